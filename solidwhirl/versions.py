"""Versions of the program and of what it runs on."""

from __future__ import annotations

import platform
from importlib import metadata

_PACKAGES = ("numpy", "scipy", "h5py", "gmsh", "meshio", "fenics-dolfinx", "petsc4py", "slepc4py")


def package_versions() -> dict[str, str]:
    """Version by package, for provenance; packages that are absent are left out."""
    out = {"python": platform.python_version()}
    for name in ("solidwhirl", *_PACKAGES):
        try:
            out[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return out
