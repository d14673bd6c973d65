"""A solid of revolution from the mesh of its meridian: half of a sector, one layer of tetrahedra.

Every triangle of the meridian, revolved through the angle β = π/N, is a prism of three second-order
tetrahedra; which diagonals cut its sides follows from the numbers of the nodes, so that neighbours
agree (Dompierre et al., Proc. 8th Int. Meshing Roundtable (1999) 195-204). Fields of a low
circumferential order change so little within β that the meridian alone decides on the accuracy.

Edges are arcs on curved surfaces, and straight inside where there is room: elements with bent edges
do not hold all fields of second degree in the coordinates, as a thin disk in bending has them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from solidwhirl.geometry import Body
from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.own.meridian import compact, mesh_meridian
from solidwhirl.meshing.own.quality import scaled_jacobians
from solidwhirl.meshing.own.refinement import first_at_place
from solidwhirl.meshing.records import (
    FloatArray,
    IntArray,
    LocalSize,
    Mesh,
    MeshQuality,
    MeshSize,
    Sector,
)
from solidwhirl.rotordyn.core.arrays import BoolArray

#: Sectors of the whole: multiples of 4, so that a quarter turn takes nodes to nodes.
FEWEST_SECTORS, MOST_SECTORS = 24, 96
# Tetrahedra of a prism whose corners are 0, 1, 2 (rising numbers) and 3, 4, 5 above them.
_OF_PRISM = np.array([[0, 1, 2, 5], [0, 1, 4, 5], [0, 3, 4, 5]])
# A tetrahedron whose corners 1 and 2 have changed places.
_TURNED_OVER = [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]
# Nodes are in the plane θ = 0, surfaces in a plane of constant z, up to this part of the size.
_NEAR = 1e-9
# Part of its quality with bent edges that an element keeps with straight ones, or they stay bent.
_KEPT = 0.8
# gmsh's edges of a second-order triangle and tetrahedron, in the order of their nodes
_TRIANGLE_EDGES = ((0, 1), (1, 2), (2, 0))
_EDGES = ((0, 1), (1, 2), (2, 0), (3, 0), (3, 2), (3, 1))


def mesh_revolved(body: Body, size: MeshSize, local: LocalSize | None = None) -> Mesh:
    """Mesh half of a sector of a body of revolution with second-order tetrahedra.

    `local`: element sizes over the meridian, as in `mesh_meridian`, whose errors this raises.
    Returned: points (x, y, z) [m], 0 <= θ <= π/N.
    """
    return revolved(mesh_meridian(body, size, local))


def revolved(meridian: Mesh, sectors: int | None = None) -> Mesh:
    """Revolve a meridian mesh to half of a sector.

    `meridian`: second-order triangles. `sectors`: of the whole; None: `sectors_of` the mesh.
    Returned: cells in threes, in the order of the triangles, less those that lie on the axis;
    interfaces as facets of the sector. Raises MeshingError: elements stay folded.
    """
    count = sectors or sectors_of(meridian)
    nodes, on_axis = len(meridian.points), meridian.points[:, 1] == 0.0
    # the two sides of a joint have their diagonals in the same places
    number = first_at_place(meridian.points) if meridian.seats else np.arange(nodes)
    corners, middle = _corners_first(meridian.cells, number)
    cells, triangle = _tetrahedra(corners, middle, on_axis, nodes)
    points = _layers(meridian.points, np.pi / count)

    def facets(edges: IntArray) -> IntArray:
        return _facets(edges, number, on_axis)

    cells = _positive(points, cells)
    points = _straight_inside(points, cells, meridian, number)
    cells, points, used = compact(points, cells)
    quality = _quality(points, cells, meridian.quality)
    return replace(
        meridian,
        points=points,
        cells=cells,
        cell_section=meridian.cell_section[triangle],
        cell_material=meridian.cell_material[triangle],
        interfaces={name: used[facets(edges)] for name, edges in meridian.interfaces.items()},
        outline=used[meridian.outline],
        quality=quality,
        sector=Sector(count=count, mirrored=True),
        seats=tuple(
            np.stack([used[facets(seat[:, side])] for side in range(2)], axis=1)
            for seat in meridian.seats
        ),
        meridian=meridian if meridian.seats else None,
    )


def sectors_of(meridian: Mesh) -> int:
    """Return how many sectors go with a meridian mesh: as many as its size asks for.

    Their number costs nothing.
    """
    return int(np.clip(4 * -(-meridian.size.around // 4), FEWEST_SECTORS, MOST_SECTORS))


def _quality(points: FloatArray, cells: IntArray, flat: MeshQuality) -> MeshQuality:
    """Quality of slender elements; what is made straight is made so in the meridian, `flat`."""
    found = scaled_jacobians(points, cells)
    if found.min() <= 0.0:
        x, y, z = points[cells[int(found.argmin())]].mean(axis=0)
        raise MeshingError(
            f"solid mesh: element at z = {z:.6g}, r = {np.hypot(x, y):.6g} m is folded; choose "
            "another element size there"
        )
    return replace(
        flat,
        minimum_scaled_jacobian=float(found.min()),
        mean_scaled_jacobian=float(found.mean()),
    )


def _corners_first(cells: IntArray, number: IntArray) -> tuple[IntArray, IntArray]:
    """Corners of every triangle by rising number, and the nodes between 0-1, 1-2, 2-0 of them."""
    rank = np.argsort(number[cells[:, :3]], axis=1)
    corners = np.take_along_axis(cells[:, :3], rank, axis=1)
    between = np.empty((len(cells), 3, 3), dtype=np.int64)
    for k, (i, j) in enumerate(_TRIANGLE_EDGES):
        between[:, i, j] = between[:, j, i] = cells[:, 3 + k]
    row = np.arange(len(cells))
    middle = [between[row, rank[:, i], rank[:, j]] for i, j in _TRIANGLE_EDGES]
    return corners, np.stack(middle, axis=1)


def _tetrahedra(
    corners: IntArray, middle: IntArray, on_axis: BoolArray, nodes: int
) -> tuple[IntArray, IntArray]:
    """Second-order tetrahedra of all prisms, and the triangle that each is from.

    Node m of the meridian is m at level 0 (θ = 0), m + nodes at level 1 (β/2), m + 2 nodes at level
    2 (β); on the axis it is m at all of them.
    """
    between = np.empty((len(corners), 3, 3), dtype=np.int64)
    for i in range(3):
        between[:, i, i] = corners[:, i]
    for k, (i, j) in enumerate(_TRIANGLE_EDGES):
        between[:, i, j] = between[:, j, i] = middle[:, k]
    cells, owner = [], []
    for corner in _OF_PRISM:
        row = np.empty((len(corners), 10), dtype=np.int64)
        for k, c in enumerate(corner):
            row[:, k] = _at(corners[:, c % 3], 2 * (c // 3), on_axis, nodes)
        for k, (i, j) in enumerate(_EDGES):
            c, d = corner[i], corner[j]
            # half way on a diagonal; an edge from the axis stays in its plane
            level = np.where(on_axis[corners[:, c % 3]], 2 * (d // 3), c // 3 + d // 3)
            level = np.where(on_axis[corners[:, d % 3]], 2 * (c // 3), level)
            row[:, 4 + k] = _at(between[:, c % 3, d % 3], level, on_axis, nodes)
        # a corner on the axis stands above itself
        low, high = corner[corner < 3], corner[corner >= 3] - 3
        both = int(np.intersect1d(low, high)[0])
        cells.append(row)
        owner.append(np.where(on_axis[corners[:, both]], -1, np.arange(len(corners))))
    every, triangle = np.stack(cells, axis=1).reshape(-1, 10), np.stack(owner, axis=1).ravel()
    return every[triangle >= 0], triangle[triangle >= 0]


def _at(node: IntArray, level: IntArray | int, on_axis: BoolArray, nodes: int) -> IntArray:
    """Node at a level, that of the axis at any."""
    return np.asarray(np.where(on_axis[node], node, node + level * nodes))


def _layers(points: FloatArray, angle: float) -> FloatArray:
    """Nodes of the meridian at θ = 0, half the angle, and the angle, (3 n, 3)."""
    z, r = points.T
    out = []
    for theta in (0.0, 0.5 * angle, angle):
        out.append(np.column_stack([r * np.cos(theta), r * np.sin(theta), z]))
    return np.vstack(out)


def _positive(points: FloatArray, cells: IntArray) -> IntArray:
    """Cells with positive volume: of the others two corners change places."""
    corners = points[cells[:, :4]]
    wrong = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0.0
    out = cells.copy()
    out[wrong] = cells[wrong][:, _TURNED_OVER]
    return out


def _straight_inside(
    points: FloatArray, cells: IntArray, meridian: Mesh, number: IntArray
) -> FloatArray:
    """Points with the middles of edges between the two planes on chords, but for curved surfaces.

    Elements that would lose too much of their quality keep their arcs, as small ones do that lie
    next to a curved surface. `number`: of every node of the meridian, the same on both sides of a
    joint.
    """
    nodes = len(meridian.points)
    between = np.zeros(len(points), dtype=bool)
    between[nodes : 2 * nodes] = True
    curved = number[_on_curved_surfaces(meridian)]
    between[nodes + np.flatnonzero(np.isin(number, curved))] = False
    chosen = between[cells[:, 4:]]
    out, place = points.copy(), (nodes * np.arange(3)[:, None] + number).ravel()
    ends = cells[:, np.array(_EDGES)][chosen]
    out[cells[:, 4:][chosen]] = 0.5 * (points[ends[:, 0]] + points[ends[:, 1]])
    least = _KEPT * scaled_jacobians(points, cells)
    looked_at = np.arange(len(cells))
    while len(looked_at):
        poor = looked_at[scaled_jacobians(out, cells[looked_at]) < least[looked_at]]
        back = np.flatnonzero(np.isin(place, place[cells[poor]]))
        back = back[(out[back] != points[back]).any(axis=1)]
        out[back] = points[back]
        looked_at = np.flatnonzero(np.isin(cells, back).any(axis=1))
    return out


def _on_curved_surfaces(meridian: Mesh) -> IntArray:
    """Nodes of a meridian on its boundary, between materials and on interfaces, but for planes."""
    rows = np.array([(i, j, 3 + k) for k, (i, j) in enumerate(_TRIANGLE_EDGES)])
    edges = meridian.cells[:, rows].reshape(-1, 3)
    material = np.repeat(meridian.cell_material, 3)
    _, first, which = np.unique(edges[:, 2], return_index=True, return_inverse=True)
    low, high = (np.full(len(first), fill) for fill in (len(meridian.materials), -1))
    np.minimum.at(low, which, material)
    np.maximum.at(high, which, material)
    alone = np.bincount(which) == 1
    found = np.vstack([edges[first[alone | (low != high)]], *meridian.interfaces.values()])
    z = meridian.points[found, 0]
    curved = np.ptp(z, axis=1) > _NEAR * np.abs(meridian.points).max()
    return np.asarray(np.unique(found[curved]))


def _facets(edges: IntArray, number: IntArray, on_axis: BoolArray) -> IntArray:
    """Second-order triangles that meridian edges (two ends and the node between) revolve to."""
    flat, nodes = on_axis[edges[:, :2]].all(axis=1), len(on_axis)
    a, b, m = edges[~flat].T
    rises = number[a] < number[b]
    low, high = np.where(rises, a, b), np.where(rises, b, a)

    def at(node: IntArray, level: int) -> IntArray:
        return _at(node, level, on_axis, nodes)

    # the diagonal runs from the lower number at θ = 0 to the higher one at β; beside the axis it is
    # one of the edges
    from_axis, to_axis = on_axis[low], on_axis[high]
    diagonal = m + nodes * np.where(from_axis, 2, np.where(to_axis, 0, 1))
    lower = np.column_stack([low, high, at(high, 2), m, at(high, 1), diagonal])
    upper = np.column_stack([low, at(high, 2), at(low, 2), diagonal, m + 2 * nodes, at(low, 1)])
    return np.vstack([lower[~to_axis], upper[~from_axis]])


def unfolded(mesh: Mesh) -> Mesh:
    """Return half a sector and its mirror image, a whole sector -π/N <= θ <= π/N."""
    assert mesh.sector is not None
    x = mesh.points
    own = x[:, 1] == 0.0
    number = np.empty(len(x), dtype=np.int64)
    number[own] = np.flatnonzero(own)
    number[~own] = len(x) + np.arange(int((~own).sum()))
    return replace(
        mesh,
        points=np.vstack([x, x[~own] * [1.0, -1.0, 1.0]]),
        cells=np.vstack([mesh.cells, number[mesh.cells][:, _TURNED_OVER]]),
        cell_section=np.tile(mesh.cell_section, 2),
        cell_material=np.tile(mesh.cell_material, 2),
        interfaces={
            name: np.vstack([rows, number[rows][:, [0, 2, 1, 5, 4, 3]]])
            for name, rows in mesh.interfaces.items()
        },
        sector=replace(mesh.sector, mirrored=False),
    )
