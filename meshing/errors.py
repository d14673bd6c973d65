"""The one error of the meshing stage."""

from __future__ import annotations


class MeshingError(ValueError):
    """A mesh that could not be made, or is not good enough to be used."""
