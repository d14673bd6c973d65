"""The error that every refusal of the geometry stage raises."""

from __future__ import annotations


class GeometryError(ValueError):
    """Report a body that cannot be built, naming the place, what was found and what is allowed."""
