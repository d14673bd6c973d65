"""A meridian mesh parted along the faces of joints: nodes there are doubled."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from solidwhirl.meshing.records import IntArray

# Corners and middle of the edges of a triangle with six nodes.
_EDGES = ((0, 1, 3), (1, 2, 4), (2, 0, 5))


@dataclass(frozen=True, kw_only=True, eq=False)
class Parted:
    """Nodes of a mesh after parting."""

    cells: IntArray  #: (c, 6)
    node_of: IntArray  #: (n,) which of the old nodes each is; the first are the old ones themselves
    #: Old edge, by its sorted corners, to the cells beside it
    beside: dict[tuple[int, int], list[int]]
    old_cells: IntArray

    def facets(self, old: IntArray, section: IntArray | None = None, wanted: int = 0) -> IntArray:
        """Facets (f, 3) by their new nodes: of the first cell beside, or of that of a section."""
        out = np.empty_like(old)
        for row, facet in enumerate(old):
            cells = self.beside[_key(facet[0], facet[1])]
            own = next(c for c in cells if section is None or section[c] == wanted)
            place = {int(n): k for k, n in enumerate(self.old_cells[own])}
            out[row] = [self.cells[own, place[int(n)]] for n in facet]
        return out

    def copies(self, old: IntArray) -> IntArray:
        """Old nodes and all their doubles."""
        return np.flatnonzero(np.isin(self.node_of, old))


def parted(cells: IntArray, faces: IntArray, count: int) -> Parted:
    """Part a mesh of triangles with six nodes along edges.

    `faces`: (f, 3) edges, corners first. `count`: nodes of the mesh. A node is doubled where its
    cells hang together by no other edge; where they do, as at the end of a slit, it stays one.
    """
    beside: dict[tuple[int, int], list[int]] = defaultdict(list)
    for c, nodes in enumerate(cells):
        for i, j, _ in _EDGES:
            beside[_key(nodes[i], nodes[j])].append(c)
    cut = {_key(a, b) for a, b, _ in faces}
    new, node_of = cells.copy(), list(range(count))
    around: dict[int, list[int]] = {int(n): [] for n in np.unique(faces)}
    for c in np.flatnonzero(np.isin(cells, list(around)).any(axis=1)):
        for n in cells[c]:
            if int(n) in around:
                around[int(n)].append(int(c))
    for node, own in around.items():
        for group in _groups(node, own, cells, beside, cut)[1:]:
            for c in group:
                new[c, cells[c] == node] = len(node_of)
            node_of.append(node)
    return Parted(cells=new, node_of=np.array(node_of), beside=dict(beside), old_cells=cells)


def _groups(
    node: int,
    own: list[int],
    cells: IntArray,
    beside: dict[tuple[int, int], list[int]],
    cut: set[tuple[int, int]],
) -> list[list[int]]:
    """Cells around a node that hang together by edges that are not cut."""
    left, out = set(own), []
    while left:
        first = min(left)
        left.discard(first)
        group, grow = [first], [first]
        while grow:
            nodes = cells[grow.pop()]
            for i, j, middle in _EDGES:
                key = _key(nodes[i], nodes[j])
                if key in cut or node not in (nodes[i], nodes[j], nodes[middle]):
                    continue
                found = [c for c in beside[key] if c in left]
                left.difference_update(found)
                group += found
                grow += found
        out.append(group)
    return out


def _key(a: int, b: int) -> tuple[int, int]:
    return (int(a), int(b)) if a < b else (int(b), int(a))
