"""The error that every refusal of the geometry stage raises."""

from solidwhirl.core.errors import UserError


class GeometryError(UserError):
    """Report a body that cannot be built, naming the place, what was found and what is allowed."""
