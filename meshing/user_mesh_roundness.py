"""Whether a surface stays the same when it is turned about z."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from solidwhirl.meshing.records import FloatArray, IntArray

# Angles that nothing with a few repetitions around is the same after [rad]; the golden angle's.
_ANGLES = tuple(2.399963229728653 * k for k in range(1, 6))
# Turned nodes that are looked at, at most, and the nearest pieces for each.
_MOST, _NEAREST = 4000, 12
# Nodes nearer to the axis than this part of the largest radius say nothing of its roundness.
_NEAR_AXIS = 0.02
# Places in a second-order face: corners of the 16 pieces that it is divided into, by fourths.
_FOURTHS = 4


def surface_deviation(points: FloatArray, faces: IntArray) -> float:
    """Return how far turned corners of a surface lie from it, over their radius; the largest.

    Parameters
    ----------
    points
        (n, 3) [m].
    faces
        (f, 6) second-order triangles.
    """
    triangles = flat_pieces(points, faces)
    corner = np.unique(faces[:, :3])
    x = points[corner]
    radius = np.hypot(x[:, 0], x[:, 1])
    x = x[radius > _NEAR_AXIS * radius.max()]
    x = x[:: max(1, -(-len(x) // _MOST))]
    centre = triangles.mean(axis=1)
    tree, count = cKDTree(centre), min(_NEAREST, len(centre))
    worst = 0.0
    for angle in _ANGLES:
        cos, sin = np.cos(angle), np.sin(angle)
        turned = np.column_stack([cos * x[:, 0] - sin * x[:, 1], sin * x[:, 0] + cos * x[:, 1]])
        turned = np.column_stack([turned, x[:, 2]])
        _, near = tree.query(turned, k=count)
        near = near.reshape(len(turned), count)
        gap = np.full(len(turned), np.inf)
        for k in range(count):
            np.minimum(gap, _distance(turned, triangles[near[:, k]]), out=gap)
        worst = max(worst, float((gap / np.hypot(turned[:, 0], turned[:, 1])).max()))
    return worst


def flat_pieces(points: FloatArray, faces: IntArray) -> FloatArray:
    """Flat triangles (m, 3, 3) that follow curved faces, 16 of each.

    Parameters
    ----------
    points
        (n, 3) [m].
    faces
        (f, 6) second-order triangles.
    """
    n = _FOURTHS
    index = {(i, j): k for k, (i, j) in enumerate(_lattice(n))}
    bary = np.array([[n - i - j, i, j] for i, j in index], dtype=float) / n
    a, b, c = bary.T
    corners = [v * (2.0 * v - 1.0) for v in (a, b, c)]
    shape = np.column_stack([*corners, 4.0 * a * b, 4.0 * b * c, 4.0 * c * a])
    x = np.einsum("pn,fnd->fpd", shape, points[faces])
    cut = []
    for i, j in index:
        if i + j < n:
            cut.append([index[i, j], index[i + 1, j], index[i, j + 1]])
        if i + j < n - 1:
            cut.append([index[i + 1, j], index[i + 1, j + 1], index[i, j + 1]])
    return np.asarray(x[:, np.array(cut)].reshape(-1, 3, 3))


def _lattice(n: int) -> list[tuple[int, int]]:
    return [(i, j) for i in range(n + 1) for j in range(n + 1 - i)]


def _distance(x: FloatArray, triangles: FloatArray) -> FloatArray:
    """Distance of points (m, 3) from triangles (m, 3, 3), one each."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1)
    size[size == 0.0] = 1.0
    normal = normal / size[:, None]
    above = np.einsum("ij,ij->i", x - a, normal)
    inside = np.ones(len(x), dtype=bool)
    nearest = np.full(len(x), np.inf)
    for p, q in ((a, b), (b, c), (c, a)):
        side = np.einsum("ij,ij->i", np.cross(q - p, x - p), normal)
        inside &= side >= 0.0
        length = np.maximum(np.einsum("ij,ij->i", q - p, q - p), 1e-300)
        along = np.clip(np.einsum("ij,ij->i", x - p, q - p) / length, 0.0, 1.0)
        np.minimum(nearest, np.linalg.norm(x - p - along[:, None] * (q - p), axis=1), out=nearest)
    return np.where(inside, np.abs(above), nearest)
