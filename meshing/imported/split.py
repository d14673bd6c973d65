"""Elements of all shapes into second-order tetrahedra whose faces match.

Every element is cut from its corner with the lowest node number to the faces that do not have it,
and quadrilaterals along the diagonal from their lowest corner (Dompierre, Labbé, Vallet and
Camarero, 8th International Meshing Roundtable (1999) 195-204): neighbours cut their common face
alike, whatever their shapes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.imported.records import FileMesh
from solidwhirl.meshing.imported.surface import place_text
from solidwhirl.meshing.own.quality import EDGES
from solidwhirl.meshing.records import FloatArray, IntArray

# Corners, edges (VTK's order) and faces of the shapes.
CORNERS = {"tetra": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8}
_SHAPE_EDGES = {
    "tetra": ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
    "pyramid": ((0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)),
    "wedge": ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
    "hexahedron": (
        *((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6)),
        *((6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
    ),
}
FACES: dict[str, tuple[tuple[int, ...], ...]] = {
    "tetra": ((0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3)),
    "pyramid": ((0, 1, 2, 3), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
    "wedge": ((0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    "hexahedron": (
        *((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4)),
        *((1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    ),
}
# Corners of the shapes as they should be.
_SQUARE = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
_IDEAL = {
    "tetra": np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float),
    "pyramid": np.array([*((x, y, 0.0) for x, y in _SQUARE), (0.5, 0.5, 1.0)]),
    "wedge": np.array([(x, y, z) for z in (0.0, 1.0) for x, y in ((0, 0), (1, 0), (0, 1))]),
    "hexahedron": np.array([(x, y, z) for z in (0.0, 1.0) for x, y in _SQUARE]),
}
_DIAGONALS = ((0, 6), (1, 7), (2, 4), (3, 5))
# Nodes of every kind that is read; of complete elements the nodes in faces and middle are left out.
KINDS = {
    "tetra": ("tetra", 0),
    "tetra10": ("tetra", 6),
    "pyramid": ("pyramid", 0),
    "pyramid13": ("pyramid", 8),
    "pyramid14": ("pyramid", 8),
    "wedge": ("wedge", 0),
    "wedge15": ("wedge", 9),
    "wedge18": ("wedge", 9),
    "hexahedron": ("hexahedron", 0),
    "hexahedron20": ("hexahedron", 12),
    "hexahedron27": ("hexahedron", 12),
}
_IGNORED = ("vertex", "line", "line3", "triangle", "triangle6", "triangle7", "quad", "quad8",
            "quad9")  # fmt: skip
# Two middles of one edge are the same if they are this near, over the edge's length.
_ONE_PLACE = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False)
class Tetrahedra:
    """Second-order tetrahedra of a file."""

    #: (n, 3) in the file's unit: its corner nodes first, then the middles of edges
    points: FloatArray
    cells: IntArray  #: (c, 10) in gmsh's order
    #: (c,) element of the file that each comes from
    block: IntArray
    row: IntArray
    corner_row: IntArray  #: Point of every node of the file, -1 for those that are no corner


def as_tetrahedra(mesh: FileMesh) -> Tetrahedra:
    """Cut all volume elements into tetrahedra; middles of edges and faces stay where they are.

    Raises MeshingError: kinds of elements that are not known, no volume, or edges with two middles.
    """
    _refuse_unknown(mesh)
    pieces: list[IntArray] = []
    origin: list[IntArray] = []
    given_edges: list[IntArray] = []
    given_middles: list[FloatArray] = []
    for k, block in enumerate(mesh.blocks):
        if block.kind not in KINDS:
            continue
        shape, middles = KINDS[block.kind]
        corners = block.nodes[:, : CORNERS[shape]]
        if (np.diff(np.sort(corners, axis=1), axis=1) == 0).any():
            raise MeshingError(f"a {block.kind} element has a node twice; write it as what it is")
        cut, rows = _pulled(shape, corners)
        pieces.append(cut)
        origin.append(np.column_stack([np.full(len(rows), k), rows]))
        if middles:
            edges, places = _middles(mesh.points, shape, block.nodes)
            given_edges.append(edges)
            given_middles.append(places)
    corners, where = np.vstack(pieces), np.vstack(origin)
    corners = _right_handed(mesh.points, corners, where)
    edges, number = _edge_numbers(corners)
    middle = 0.5 * (mesh.points[edges[:, 0]] + mesh.points[edges[:, 1]])
    if given_edges:
        _put_given(edges, middle, np.vstack(given_edges), np.vstack(given_middles), mesh.points)
    used = np.unique(corners)
    corner_row = np.full(len(mesh.points), -1, dtype=np.int64)
    corner_row[used] = np.arange(len(used))
    return Tetrahedra(
        points=np.vstack([mesh.points[used], middle]),
        cells=np.hstack([corner_row[corners], len(used) + number]),
        block=where[:, 0],
        row=where[:, 1],
        corner_row=corner_row,
    )


def _refuse_unknown(mesh: FileMesh) -> None:
    kinds = {block.kind for block in mesh.blocks}
    unknown = sorted(kinds - set(KINDS) - set(_IGNORED))
    if unknown:
        raise MeshingError(
            f"elements of kind {', '.join(unknown)} are not known; allowed are {', '.join(KINDS)}"
        )
    if not kinds & set(KINDS):
        raise MeshingError(
            f"no volume elements, only {', '.join(sorted(kinds))}; a body needs tetrahedra, "
            "hexahedra, wedges or pyramids"
        )


def _pulled(shape: str, corners: IntArray) -> tuple[IntArray, IntArray]:
    """Tetrahedra from the lowest corner of every element, and the elements they come from.

    Those of one element are right-handed or left-handed together, as its own numbering is.
    """
    lowest = corners.argmin(axis=1)
    cut, rows = [], []
    for apex in range(CORNERS[shape]):
        own = np.flatnonzero(lowest == apex)
        for face in (f for f in FACES[shape] if apex not in f):
            for local in _triangles(corners[own], face):
                local = np.column_stack([local, np.full(len(own), apex)])
                at = _IDEAL[shape][local]
                turned = np.linalg.det(at[:, 1:] - at[:, :1]) < 0.0
                local[turned] = local[turned][:, [0, 2, 1, 3]]
                cut.append(np.take_along_axis(corners[own], local, axis=1))
                rows.append(own)
    return np.vstack(cut), np.concatenate(rows)


def _triangles(corners: IntArray, face: tuple[int, ...]) -> list[IntArray]:
    """Local corners (c, 3) of the triangles of a face with 3 or 4 corners."""
    local = np.tile(np.array(face), (len(corners), 1))
    if len(face) == 3:
        return [local]
    start = corners[:, face].argmin(axis=1)
    turned = np.take_along_axis(local, (start[:, None] + np.arange(4)) % 4, axis=1)
    return [turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]]


def _right_handed(points: FloatArray, corners: IntArray, where: IntArray) -> IntArray:
    """Tetrahedra of elements with a positive volume; files number them either way.

    What has a negative volume within an element of a positive one stays so: it is folded.
    """
    a, b, c, d = (points[corners[:, k]] for k in range(4))
    volume = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)
    element = where[:, 0] * (int(where[:, 1].max()) + 1) + where[:, 1]
    _, number = np.unique(element, return_inverse=True)
    whole = np.bincount(number, weights=volume)
    left = whole[number] < 0.0
    out = corners.copy()
    out[left] = out[left][:, [0, 2, 1, 3]]
    return out


def _edge_numbers(corners: IntArray) -> tuple[IntArray, IntArray]:
    """Different edges (e, 2), lower corner first, and the six of every tetrahedron (c, 6)."""
    pairs = np.array(EDGES[3])
    ends = np.sort(corners[:, pairs].reshape(-1, 2), axis=1)
    edges, number = np.unique(ends, axis=0, return_inverse=True)
    return edges, np.asarray(number).reshape(-1, len(pairs))


def _middles(points: FloatArray, shape: str, nodes: IntArray) -> tuple[IntArray, FloatArray]:
    """Edges and diagonals of second-order elements, (m, 2), and the places of their middles."""
    count, pairs = CORNERS[shape], _SHAPE_EDGES[shape]
    corner = points[nodes[:, :count]]
    middle = points[nodes[:, count : count + len(pairs)]]
    of_edge = {frozenset(pair): k for k, pair in enumerate(pairs)}
    edges = [nodes[:, list(pair)] for pair in pairs]
    places = [middle[:, k] for k in range(len(pairs))]
    for face in (f for f in FACES[shape] if len(f) == 4):
        around = [of_edge[frozenset((face[k], face[(k + 1) % 4]))] for k in range(4)]
        # the middle of the eight-node quadrilateral
        centre = 0.5 * middle[:, around].sum(axis=1) - 0.25 * corner[:, list(face)].sum(axis=1)
        for a, b in ((face[0], face[2]), (face[1], face[3])):
            edges.append(nodes[:, [a, b]])
            places.append(centre)
    if shape == "hexahedron":
        centre = 0.25 * (middle.sum(axis=1) - corner.sum(axis=1))
        for pair in _DIAGONALS:
            edges.append(nodes[:, list(pair)])
            places.append(centre)
    return np.sort(np.vstack(edges), axis=1), np.vstack(places)


def _put_given(
    edges: IntArray, middle: FloatArray, given: IntArray, places: FloatArray, points: FloatArray
) -> None:
    """Put the middles that the file has in the place of the straight ones."""
    stride = np.int64(len(points))
    keys, wanted = given[:, 0] * stride + given[:, 1], edges[:, 0] * stride + edges[:, 1]
    order = np.argsort(keys, kind="stable")
    keys, places = keys[order], places[order]
    same = np.flatnonzero(keys[1:] == keys[:-1])
    length = np.linalg.norm(points[keys // stride] - points[keys % stride], axis=1)
    apart = np.linalg.norm(places[same + 1] - places[same], axis=1)
    split = apart > _ONE_PLACE * length[same]
    if split.any():
        a, b = keys[same[split][0]] // stride, keys[same[split][0]] % stride
        first, last = place_text(points[a]), place_text(points[b])
        raise MeshingError(
            f"the edge between the nodes at {first} and {last} has two "
            "middle nodes at different places; the elements beside it are not joined"
        )
    at = np.searchsorted(keys, wanted)
    at[at == len(keys)] = 0
    found = keys[at] == wanted
    middle[found] = places[at[found]]
