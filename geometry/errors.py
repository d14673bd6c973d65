"""The error that every refusal of the geometry stage raises, and the refusals of single values."""

import math

from solidwhirl.core.errors import UserError


class GeometryError(UserError):
    """Report a body that cannot be built, naming the place, what was found and what is allowed."""


def require_name(what: str, name: str) -> None:
    """Refuse an empty name of a thing, which `what` says in one word or two."""
    if not name:
        raise GeometryError(f"a {what} needs a name, found an empty one")


def require_finite(where: str, *values: float) -> None:
    """Refuse a value that is not finite; `where` begins the message."""
    for value in values:
        if not math.isfinite(value):
            raise GeometryError(f"{where}: found {value}, every value must be finite")
