"""Versions of the program and of what it runs on."""

from __future__ import annotations

import hashlib
import platform
from functools import cache
from importlib import metadata, util
from pathlib import Path

_PACKAGES = ("numpy", "scipy", "h5py", "gmsh", "meshio", "fenics-dolfinx", "petsc4py", "slepc4py")
_STAGES = ("", ".geometry", ".meshing", ".reduction", ".rotordyn")


def package_versions() -> dict[str, str]:
    """Version by package, for provenance; packages that are absent are left out."""
    out = {"python": platform.python_version()}
    for name in ("solidwhirl", *_PACKAGES):
        try:
            out[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return out


@cache
def program_digest() -> str:
    """SHA-256 of the program's own source files, as they were at the first call."""
    digest = hashlib.sha256()
    for package in (f"solidwhirl{stage}" for stage in _STAGES):
        found = util.find_spec(package)
        assert found is not None
        for folder in map(Path, found.submodule_search_locations or ()):
            for path in sorted(folder.rglob("*.py")):
                content = path.read_bytes()
                name = path.relative_to(folder).as_posix()
                digest.update(f"{package}/{name} {len(content)}\n".encode())
                digest.update(content)
    return digest.hexdigest()
