"""The one error of the meshing stage."""

from solidwhirl.core.errors import UserError


class MeshingError(UserError):
    """A mesh that could not be made, or is not good enough to be used."""
