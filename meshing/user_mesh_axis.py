"""The axis of a body in the coordinates of its file."""

from __future__ import annotations

import numpy as np

from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.records import FloatArray
from solidwhirl.meshing.user_mesh_records import MeshRequest


def on_axis(points: FloatArray, request: MeshRequest) -> FloatArray:
    """Coordinates [m] with the axis of the request as z and its origin at z = 0.

    Parameters
    ----------
    points
        (n, 3) in the file's unit.
    request
        Unit and axis.

    Raises
    ------
    MeshingError
        Directions that are none.
    """
    return np.asarray(request.unit_m * (points - np.array(request.origin)) @ axis_turn(request).T)


def axis_turn(request: MeshRequest) -> FloatArray:
    """Rotation (3, 3) that takes the direction to z.

    Parameters
    ----------
    request
        Its axis.

    Raises
    ------
    MeshingError
        Directions that are none.
    """
    direction = np.array(request.direction, dtype=float)
    length = float(np.linalg.norm(direction))
    if not length > 0.0:
        raise MeshingError("axis.direction has no length")
    z = direction / length
    if request.x_direction is not None:
        x = np.array(request.x_direction, dtype=float)
        x = x - (x @ z) * z
        if float(np.linalg.norm(x)) <= 1e-6 * float(np.linalg.norm(request.x_direction)):
            raise MeshingError("axis.x_direction lies along axis.direction")
        x = x / np.linalg.norm(x)
        return np.array([x, np.cross(z, x), z])
    if z[2] <= -1.0 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    # Rodrigues' formula for the smallest turn
    v = np.array([z[1], -z[0], 0.0])
    cross = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.asarray(np.eye(3) + cross + cross @ cross / (1.0 + z[2]))
