"""Elements of all shapes into second-order tetrahedra whose faces match.

Every element is cut from its first corner to the faces that do not have it, and quadrilaterals
along the diagonal from their first corner (Dompierre, Labbé, Vallet and Camarero, 8th International
Meshing Roundtable (1999) 195-204): neighbours cut their common face alike, whatever their shapes.
Which of two corners is first, radius, height and the sense of the turn about z say and no number:
what is the same after a turn is cut alike, and bends alike in all directions. Where none is first,
as around the axis, an element or a face is cut from its middle.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.imported.records import FileMesh
from solidwhirl.meshing.imported.surface import place_text
from solidwhirl.meshing.imported.turning import NEAR, size_m
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
    #: (m, 5) corners of faces that are cut from their middle, and the node there, in their rows
    of_faces: IntArray


def as_tetrahedra(mesh: FileMesh) -> Tetrahedra:
    """Cut all volume elements into tetrahedra; middles of edges and faces stay where they are.

    Raises MeshingError: kinds of elements that are not known, no volume, or edges with two middles.
    """
    _refuse_unknown(mesh)
    pieces: list[IntArray] = []
    origin: list[IntArray] = []
    given_edges: list[IntArray] = []
    given_middles: list[FloatArray] = []
    added = _Added(points=mesh.points, tolerance=NEAR * size_m(mesh.points[_corners_of(mesh)]))
    for k, block in enumerate(mesh.blocks):
        if block.kind not in KINDS:
            continue
        shape, middles = KINDS[block.kind]
        corners = block.nodes[:, : CORNERS[shape]]
        if (np.diff(np.sort(corners, axis=1), axis=1) == 0).any():
            raise MeshingError(f"a {block.kind} element has a node twice; write it as what it is")
        cut, rows = _pulled(shape, block.nodes, added)
        pieces.append(cut)
        origin.append(np.column_stack([np.full(len(rows), k), rows]))
        if middles:
            edges, places = _middles(mesh.points, shape, block.nodes)
            given_edges.append(edges)
            given_middles.append(places)
    points = np.vstack([mesh.points, *added.places])
    corners, where = np.vstack(pieces), np.vstack(origin)
    corners = _right_handed(points, corners, where)
    edges, number = _edge_numbers(corners)
    middle = 0.5 * (points[edges[:, 0]] + points[edges[:, 1]])
    if given_edges:
        _put_given(edges, middle, np.vstack(given_edges), np.vstack(given_middles), points)
    used = np.unique(corners)
    corner_row = np.full(len(points), -1, dtype=np.int64)
    corner_row[used] = np.arange(len(used))
    return Tetrahedra(
        points=np.vstack([points[used], middle]),
        cells=np.hstack([corner_row[corners], len(used) + number]),
        block=where[:, 0],
        row=where[:, 1],
        corner_row=corner_row,
        of_faces=_rows_of(added.of_faces),
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


def _corners_of(mesh: FileMesh) -> IntArray:
    """Nodes at the corners of volume elements."""
    volume = (b for b in mesh.blocks if b.kind in KINDS)
    corners = [b.nodes[:, : CORNERS[KINDS[b.kind][0]]].ravel() for b in volume]
    return np.asarray(np.unique(np.concatenate(corners)))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Added:
    """Nodes in the middles of elements and faces, and what decides where they are needed."""

    points: FloatArray  #: Of the file, about z
    tolerance: float  #: Radii and heights that differ by less are the same
    places: list[FloatArray] = field(default_factory=list)
    #: Node in the middle of a face, by its sorted corners
    of_faces: dict[tuple[int, ...], int] = field(default_factory=dict)

    def node(self, place: FloatArray) -> int:
        """A node at a place."""
        self.places.append(place[None])
        return len(self.points) + len(self.places) - 1

    def first_of(self, corners: IntArray) -> IntArray:
        """The corner of each row (m, k) that is before all others, (m,); -1: none is."""
        x, y, z = np.moveaxis(self.points[corners], 2, 0)
        r = np.hypot(x, y)
        a, b = (slice(None), slice(None), None), (slice(None), None, slice(None))
        turn = x[a] * y[b] - y[a] * x[b]
        beside = np.abs(turn) > self.tolerance * np.minimum(r[a], r[b])
        before = np.select(
            [np.abs(r[a] - r[b]) > self.tolerance, np.abs(z[a] - z[b]) > self.tolerance, beside],
            [r[a] < r[b], z[a] < z[b], turn > 0.0],
            corners[a] < corners[b],
        )
        before |= np.eye(corners.shape[1], dtype=bool)
        first = before.all(axis=2)
        return np.where(first.any(axis=1), first.argmax(axis=1), -1)


def _pulled(shape: str, nodes: IntArray, added: _Added) -> tuple[IntArray, IntArray]:
    """Tetrahedra from the first corner of every element, and the elements they come from.

    Those of one element are right-handed or left-handed together, as its own numbering is.
    """
    count, faces = CORNERS[shape], FACES[shape]
    corners = nodes[:, :count]
    ideal = _IDEAL[shape]
    places = np.vstack(
        [ideal, *(ideal[list(face)].mean(axis=0) for face in faces), ideal.mean(axis=0)]
    )
    # corners, middles of faces, middle; -1 where there is none
    every = np.full((len(nodes), len(places)), -1, dtype=np.int64)
    every[:, :count] = corners
    first = added.first_of(corners)
    for row in np.flatnonzero(first < 0):
        every[row, -1] = added.node(added.points[nodes[row]].mean(axis=0))
    cut, rows = [], []
    for f, face in enumerate(faces):
        start = added.first_of(corners[:, face]) if len(face) == 4 else np.zeros(len(nodes), int)
        uncut = np.flatnonzero(start < 0)
        if uncut.size:
            middle = _face_middle(added.points, shape, nodes[uncut], face)
            for row, place in zip(uncut, middle, strict=True):
                key = tuple(sorted(corners[row, face].tolist()))
                if key not in added.of_faces:
                    added.of_faces[key] = added.node(place)
                every[row, count + f] = added.of_faces[key]
        for s in np.unique(start):
            round_ = np.roll(face, -int(s)) if s >= 0 else np.array(face)
            triangles = [(round_[k], round_[k + 1], round_[0]) for k in range(1, len(face) - 1)]
            if s < 0:
                triangles = [(face[k], face[(k + 1) % 4], count + f) for k in range(4)]
            for apex in np.unique(first):
                own = np.flatnonzero((start == s) & (first == apex))
                if apex in face or not own.size:
                    continue
                for triangle in triangles:
                    local = np.array([*triangle, apex if apex >= 0 else len(places) - 1])
                    at = places[local]
                    if np.linalg.det(at[1:] - at[0]) < 0.0:
                        local = local[[0, 2, 1, 3]]
                    cut.append(every[np.ix_(own, local)])
                    rows.append(own)
    return np.vstack(cut), np.concatenate(rows)


def _face_middle(
    points: FloatArray, shape: str, nodes: IntArray, face: tuple[int, ...]
) -> FloatArray:
    """The middles of a face with four corners of elements, with or without middles of edges."""
    corner = points[nodes[:, list(face)]]
    if nodes.shape[1] == CORNERS[shape]:
        return np.asarray(corner.mean(axis=1))
    of_edge = {frozenset(pair): CORNERS[shape] + k for k, pair in enumerate(_SHAPE_EDGES[shape])}
    around = [of_edge[frozenset((face[k], face[(k + 1) % 4]))] for k in range(4)]
    # of the eight-node quadrilateral
    return np.asarray(0.5 * points[nodes[:, around]].sum(axis=1) - 0.25 * corner.sum(axis=1))


def _rows_of(faces: dict[tuple[int, ...], int]) -> IntArray:
    """Sorted corners of faces and the nodes in their middles, (m, 5)."""
    return np.array([(*key, node) for key, node in faces.items()], dtype=np.int64).reshape(-1, 5)


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
    edges = [nodes[:, list(pair)] for pair in pairs]
    places = [middle[:, k] for k in range(len(pairs))]
    for face in (f for f in FACES[shape] if len(f) == 4):
        centre = _face_middle(points, shape, nodes, face)
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
