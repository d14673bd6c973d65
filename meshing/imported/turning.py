"""Meshes turned about z: nodes and faces that lie on each other, and points inside.

All coordinates are in metres, z along the axis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from solidwhirl.meshing.imported.surface import Faces
from solidwhirl.meshing.records import FloatArray, IntArray

BoolArray = np.ndarray[tuple[int], np.dtype[np.bool_]]
#: Nodes of the two cuts that are this near when turned, over the size of the mesh, are partners:
#: eight characters of a Nastran field, one for a sign and one for a point, keep six digits.
NEAR = 1e-5
# But no farther than this part of the shortest edge.
_OF_EDGE = 0.05


@dataclass(frozen=True, kw_only=True, eq=False)
class Cut:
    """Where a sector and its copies, turned by multiples of 2π/N, join."""

    first: IntArray  #: (m,) rows of faces that, turned by 2π/N, lie on
    second: IntArray  #: (m,) these, with the sector on the other side
    onto: IntArray  #: (n,) node that a node of the first cut is turned onto, -1 for all others


def turned(points: FloatArray, angle: float) -> FloatArray:
    """Points (n, 3) turned about z by an angle [rad]."""
    cos, sin = np.cos(angle), np.sin(angle)
    turn = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(points @ turn)


def tolerance_m(points: FloatArray, cells: IntArray) -> float:
    """How far turned nodes of tetrahedra (c, 4 or more) may be from their partners [m]."""
    corner = points[cells[:, :4]]
    edges = corner[:, [0, 0, 0, 1, 1, 2]] - corner[:, [1, 2, 3, 2, 3, 3]]
    shortest = float(np.sqrt((edges**2).sum(axis=2).min()))
    return min(NEAR * size_m(points[np.unique(cells)]), _OF_EDGE * shortest)


def size_m(points: FloatArray) -> float:
    """Length or largest radius, whichever is larger [m]."""
    return float(max(np.ptp(points[:, 2]), np.hypot(points[:, 0], points[:, 1]).max()))


def partners(points: FloatArray, nodes: IntArray, angle: float, tolerance: float) -> IntArray:
    """Return the one of `nodes` that each of them is turned onto, (n,) for all points; -1: none.

    `angle`: in rad; `tolerance`: largest distance [m].
    """
    out = np.full(len(points), -1, dtype=np.int64)
    tree = scipy.spatial.cKDTree(points[nodes])
    _, near = tree.query(turned(points[nodes], angle), distance_upper_bound=tolerance)
    found = near < len(nodes)
    out[nodes[found]] = nodes[near[found]]
    on_axis = nodes[np.hypot(*points[nodes, :2].T) <= tolerance]
    out[on_axis] = on_axis
    return out


def matched_cut(points: FloatArray, faces: Faces, count: int, tolerance: float) -> Cut:
    """Find faces of the surface that, turned by 2π/N, lie on others with opposite normals.

    Faces of a surface that goes on from sector to sector lie on each other with the same normal.
    Where the same nodes are joined to other triangles (other diagonals of quadrilaterals), patches
    of faces with the same nodes and the same edges around lie on each other.
    """
    cut = _matched_faces(points, faces, count, tolerance)
    return _with_patches(points, faces, count, tolerance, cut)


def _matched_faces(points: FloatArray, faces: Faces, count: int, tolerance: float) -> Cut:
    """Faces that lie on others, corner by corner."""
    rows = np.flatnonzero(faces.outside)
    partner = partners(points, np.unique(faces.nodes[rows][:, :3]), 2.0 * np.pi / count, tolerance)
    images = partner[faces.nodes[rows][:, :3]]
    rows, images = rows[(images >= 0).all(axis=1)], images[(images >= 0).all(axis=1)]
    other = faces.rows_of(images)
    start = (faces.nodes[other][:, :3] == images[:, :1]).argmax(axis=1)
    after = faces.nodes[other, (start + 1) % 3]
    opposite = (other >= 0) & faces.outside[other] & (after == images[:, 2])
    rows, images, other, start = (v[opposite] for v in (rows, images, other, start))
    # corners of the second run the other way round, and so do the edges after them
    corner = (start[:, None] - np.arange(3)) % 3
    edge = 3 + (start[:, None] - np.arange(3) - 1) % 3
    onto = np.full(len(points), -1, dtype=np.int64)
    onto[faces.nodes[rows]] = np.take_along_axis(
        faces.nodes[other], np.hstack([corner, edge]), axis=1
    )
    return Cut(first=rows, second=other, onto=onto)


def _with_patches(points: FloatArray, faces: Faces, count: int, tolerance: float, cut: Cut) -> Cut:
    """The cut with patches of faces that share their nodes with others, but not their edges."""
    left = faces.outside.copy()
    left[cut.first] = left[cut.second] = False
    rows = np.flatnonzero(left)
    nodes = np.unique(faces.nodes[faces.outside])
    there = partners(points, nodes, 2.0 * np.pi / count, tolerance)
    back = np.full(len(points), -1, dtype=np.int64)
    back[there[there >= 0]] = np.flatnonzero(there >= 0)
    on_axis = there == np.arange(len(points))
    away = ~on_axis[faces.nodes[rows]].all(axis=1)
    first = rows[away & (there[faces.nodes[rows]] >= 0).all(axis=1)]
    second = rows[away & (back[faces.nodes[rows]] >= 0).all(axis=1)]
    if not len(first) or not len(second):
        return cut
    known = {_around(faces.nodes[own]): own for own in _patches(faces, second)}
    onto, firsts, seconds = cut.onto.copy(), [cut.first], [cut.second]
    for own in _patches(faces, first):
        other = known.get(_around(there[faces.nodes[own]]))
        if other is None:
            continue
        members = np.unique(faces.nodes[own])
        area = turned(_area_vector(points, faces.nodes[own])[None], 2.0 * np.pi / count)[0]
        if area @ _area_vector(points, faces.nodes[other]) >= 0.0:
            continue  # a surface that goes on from sector to sector
        if np.array_equal(np.unique(there[members]), np.unique(faces.nodes[other])):
            onto[members] = there[members]
            firsts.append(own)
            seconds.append(other)
    return Cut(first=np.concatenate(firsts), second=np.concatenate(seconds), onto=onto)


def _patches(faces: Faces, rows: IntArray) -> list[IntArray]:
    """Rows of faces that hang together by edges."""
    middles = faces.nodes[rows][:, 3:]
    number = np.unique(middles, return_inverse=True)[1].reshape(middles.shape)
    owner = np.repeat(np.arange(len(rows)), 3)
    graph = scipy.sparse.coo_matrix(
        (np.ones(len(owner)), (owner, number.ravel())), (len(rows), int(number.max()) + 1)
    ).tocsr()
    _, part = scipy.sparse.csgraph.connected_components(graph @ graph.T, directed=False)
    return [rows[part == k] for k in range(int(part.max()) + 1)]


def _area_vector(points: FloatArray, nodes: IntArray) -> FloatArray:
    """Sum of the normals of faces, each as long as its area (3,)."""
    a, b, c = (points[nodes[:, k]] for k in range(3))
    return np.asarray(0.5 * np.cross(b - a, c - a).sum(axis=0))


def _around(nodes: IntArray) -> frozenset[int]:
    """Middles of the edges around a patch of faces (f, 6): those that one face alone has."""
    middles, times = np.unique(nodes[:, 3:], return_counts=True)
    return frozenset(middles[times == 1].tolist())


def chains(onto: IntArray) -> tuple[IntArray, IntArray]:
    """First node of the chain of partners that every node is in, and how many turns from it."""
    root, turns = np.arange(len(onto)), np.zeros(len(onto), dtype=np.int64)
    onto = np.where(onto == root, -1, onto)
    begins = onto >= 0
    begins[onto[onto >= 0]] = False
    here = np.flatnonzero(begins)
    while len(here):
        there = onto[here]
        root[there], turns[there] = root[here], turns[here] + 1
        here = there[onto[there] >= 0]
    return root, turns


def angles_taken(places: FloatArray) -> float:
    """Angle about the axis that places (m, 3) take: all but the largest gap [rad]."""
    angle = np.sort(np.arctan2(places[:, 1], places[:, 0]))
    gaps = np.diff(np.append(angle, angle[0] + 2.0 * np.pi))
    return float(2.0 * np.pi - gaps.max())


def inside(points: FloatArray, cells: IntArray, places: FloatArray) -> BoolArray:
    """Whether places (m, 3) lie inside one of the tetrahedra, taken straight, (m,)."""
    out = np.zeros(len(places), dtype=bool)
    corner = points[cells[:, :4]]
    centre = corner.mean(axis=1)
    reach = np.linalg.norm(corner - centre[:, None], axis=2).max(axis=1)
    octave = np.floor(np.log2(reach)).astype(np.int64)
    for k in np.unique(octave):
        own = np.flatnonzero(octave == k)
        near = scipy.spatial.cKDTree(centre[own]).query_ball_point(places, float(reach[own].max()))
        of = np.repeat(np.arange(len(places)), [len(found) for found in near])
        cell = own[np.array([c for found in near for c in found], dtype=np.int64)]
        a, b, c = (corner[cell, k] - corner[cell, 0] for k in (1, 2, 3))
        away = places[of] - corner[cell, 0]
        volume = np.einsum("ij,ij->i", a, np.cross(b, c))
        share = (
            np.column_stack(
                [np.einsum("ij,ij->i", away, np.cross(*s)) for s in ((b, c), (c, a), (a, b))]
            )
            * np.sign(volume)[:, None]
        )
        within = (share > 0.0).all(axis=1) & (share.sum(axis=1) < np.abs(volume))
        out[of[within]] = True
    return out


def cylinder_text(point: FloatArray) -> str:
    """A place (3,) as z, r and θ."""
    angle = np.degrees(np.arctan2(point[1], point[0]))
    return f"z = {point[2]:.6g} m, r = {np.hypot(point[0], point[1]):.6g} m, θ = {angle:.4g}°"
