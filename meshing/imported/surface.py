"""Faces of a tetrahedral mesh: its surface, its parts, and what is wrong with them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.records import FloatArray, IntArray

# Faces of a second-order tetrahedron in gmsh's order, normals outwards: corners and their edges.
_FACES = np.array([[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 9, 7], [1, 2, 3, 5, 8, 9], [2, 0, 3, 6, 7, 8]])
# Nodes nearer than this part of the shortest edge lie at one place.
_ONE_PLACE = 1e-3
# Neighbouring faces of the surface that lie on each other, by the cosine between their normals.
_FOLDED = -1.0 + 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class Faces:
    """All faces of a mesh, each once."""

    #: (f, 6) corners and middles; of faces of the surface the normal points outwards
    nodes: IntArray
    keys: IntArray  #: (f, 3) corners in rising order, the faces in lexical order
    #: (f,) whether one tetrahedron alone has it
    outside: np.ndarray[tuple[int], np.dtype[np.bool_]]
    cells: IntArray  #: (f, 2) tetrahedra on both sides, -1: none

    def rows_of(self, corners: IntArray) -> IntArray:
        """Return the row of every face (m, 3), -1 where the mesh has none."""
        stride = np.int64(self.keys.max()) + 1
        wanted = np.sort(corners, axis=1)
        inside = ((wanted >= 0) & (wanted < stride)).all(axis=1)
        # three numbers of a large mesh overflow one key: two pairs are looked up in turn
        first = self.keys[:, 0] * stride + self.keys[:, 1]
        start = np.searchsorted(first, wanted[:, 0] * stride + wanted[:, 1], side="left")
        end = np.searchsorted(first, wanted[:, 0] * stride + wanted[:, 1], side="right")
        out = np.full(len(wanted), -1, dtype=np.int64)
        for k in np.flatnonzero(inside & (end > start)):
            third = self.keys[start[k] : end[k], 2]
            at = int(np.searchsorted(third, wanted[k, 2]))
            if at < len(third) and third[at] == wanted[k, 2]:
                out[k] = start[k] + at
        return out


def faces_of(cells: IntArray) -> Faces:
    """Find the faces of second-order tetrahedra (c, 10) in gmsh's order, of positive volume.

    Raises MeshingError: a face belongs to three tetrahedra.
    """
    nodes = cells[:, _FACES].reshape(-1, 6)
    owner = np.repeat(np.arange(len(cells)), 4)
    corners = np.sort(nodes[:, :3], axis=1)
    order = np.lexsort((corners[:, 2], corners[:, 1], corners[:, 0]))
    corners = corners[order]
    new = np.ones(len(order), dtype=bool)
    new[1:] = (corners[1:] != corners[:-1]).any(axis=1)
    start = np.flatnonzero(new)
    count = np.diff(np.append(start, len(order)))
    if count.max() > 2:
        raise MeshingError(
            f"{int(np.sum(count > 2))} faces belong to more than two elements; elements overlap"
        )
    both = np.full((len(start), 2), -1, dtype=np.int64)
    both[:, 0] = owner[order[start]]
    pair = count == 2
    both[pair, 1] = owner[order[start[pair] + 1]]
    return Faces(nodes=nodes[order[start]], keys=corners[start], outside=~pair, cells=both)


def refuse_unjoined(points: FloatArray, cells: IntArray, faces: Faces) -> None:
    """Refuse nodes at one place, parts that do not hang together, and faces that do not match.

    Raises MeshingError with numbers and places.
    """
    corners = np.unique(cells[:, :4])
    ends = cells[:, [0, 0, 0, 1, 1, 2, 1, 2, 3, 2, 3, 3]].reshape(-1, 2, 6)
    shortest = float(np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=2).min())
    if shortest <= 0.0:
        raise MeshingError("an element has two corners at one place")
    twice = scipy.spatial.cKDTree(points[corners]).query_pairs(
        _ONE_PLACE * shortest, output_type="ndarray"
    )
    if len(twice):
        raise MeshingError(
            f"{len(twice)} pairs of nodes lie at one place, the first at "
            f"{place_text(points[corners[twice[0, 0]]])} m: elements that touch there are not "
            "joined; merge the nodes in the mesher"
        )
    _refuse_overlaps(points, cells, faces)
    _refuse_cracks(points, faces)
    joined = faces.cells[~faces.outside]
    graph = scipy.sparse.coo_matrix(
        (np.ones(len(joined)), (joined[:, 0], joined[:, 1])), (len(cells),) * 2
    )
    count, part = scipy.sparse.csgraph.connected_components(graph, directed=False)
    if count > 1:
        sizes = np.bincount(part)
        places = [
            place_text(points[cells[part == k, :4]].reshape(-1, 3).mean(axis=0))
            for k in np.argsort(-sizes)[:3]
        ]
        raise MeshingError(
            f"the mesh has {count} parts that share no face, the largest of "
            f"{', '.join(str(s) for s in np.sort(sizes)[::-1][:3])} elements about "
            f"{', '.join(places)} m; a body is in one piece, each other part is a body of its own"
        )


def _refuse_overlaps(points: FloatArray, cells: IntArray, faces: Faces) -> None:
    """Refuse elements on one side of their common face."""
    inner = ~faces.outside
    face, beside = faces.nodes[inner][:, :3], faces.cells[inner]
    a, b, c = (points[face[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    tips = cells[beside, :4].sum(axis=2) - face.sum(axis=1)[:, None]
    above = [np.einsum("ij,ij->i", points[tips[:, k]] - a, normal) for k in range(2)]
    over = above[0] * above[1] >= 0.0
    if over.any():
        raise MeshingError(
            f"{int(over.sum())} elements lie over their neighbours, the first is folded over the "
            f"face at {place_text(a[over][0])} m"
        )


def _refuse_cracks(points: FloatArray, faces: Faces) -> None:
    """Refuse faces of the surface that lie on each other: neighbours that were cut differently."""
    surface = faces.nodes[faces.outside][:, :3]
    a, b, c = (points[surface[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    edges = np.sort(surface[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    third = surface[:, [2, 0, 1]].ravel()
    owner = np.repeat(np.arange(len(surface)), 3)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    same = (edges[order[1:]] == edges[order[:-1]]).all(axis=1)
    first, second = order[:-1][same], order[1:][same]
    opposite = np.einsum("ij,ij->i", normal[owner[first]], normal[owner[second]]) < _FOLDED
    if not opposite.any():
        return
    first, second = first[opposite], second[opposite]
    start = points[edges[first, 0]]
    along = points[edges[first, 1]] - start
    sides = [np.cross(along, points[third[k]] - start) for k in (first, second)]
    lying = np.einsum("ij,ij->i", *sides) > 0.0
    if lying.any():
        raise MeshingError(
            f"{int(lying.sum())} faces of neighbouring elements do not match, the first at "
            f"{place_text(points[third[first[lying][0]]])} m: hexahedra that meet tetrahedra need "
            "pyramids between them"
        )


def place_text(point: FloatArray) -> str:
    """Coordinates (3,) in brackets."""
    return "(" + ", ".join(f"{v:.6g}" for v in point) + ")"
