"""How many unknowns a solid mesh will have, before it is made."""

from __future__ import annotations

import numpy as np

from solidwhirl.geometry import Body, Subdivision, subdivide
from solidwhirl.meshing.drawing import face_bounds, face_edges, graded_places
from solidwhirl.meshing.records import MeshSize

# A tetrahedron of edge h fills √2/12 h³; gmsh's meshes have 1.4 times as many after optimising,
# and 1.4 second-order nodes of three unknowns for each.
_TETRAHEDRON = np.sqrt(2.0) / 12.0
_UNKNOWNS = 1.4 * 1.4 * 3.0


def predict_unknowns(body: Body, size: MeshSize) -> int:
    """Predict the unknowns of a solid mesh, within a factor of two.

    The bulk of every section is counted with its own element size; around a graded corner on a
    circle of radius R, elements of size h + g ρ over three quarters of a turn in the meridian
    add 3π/2 · 2πR / (2 g² h · 0.118).

    Parameters
    ----------
    body
        The body.
    size
        What will be asked of the mesh.
    """
    subdivision = subdivide(body)
    bulk = sum(
        2.0 * np.pi * radius * area / bound**3
        for (area, radius), bound in zip(
            _faces(subdivision), face_bounds(body, subdivision, size, 3), strict=True
        )
    )
    corners = sum(
        3.0 * np.pi**2 * r / (2.0 * size.growth**2 * h)
        for _, r, h in graded_places(body, subdivision, size)
    )
    return int((bulk + corners) / _TETRAHEDRON * _UNKNOWNS)


def _faces(subdivision: Subdivision) -> list[tuple[float, float]]:
    """Area and centroid radius of every face."""
    out = []
    for face in subdivision.faces:
        p, q = face_edges(subdivision, face)
        cross = p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1]
        area = 0.5 * cross.sum()
        out.append((abs(area), float(((p + q)[:, 1] * cross).sum() / (6.0 * area))))
    return out
