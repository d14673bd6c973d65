"""Places of a mesh where the stress is singular: re-entrant edges, ends of rigid interfaces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from solidwhirl.meshing.imported.records import AnyInterface
from solidwhirl.meshing.own.grading import chain_ends
from solidwhirl.reduction.operators import compat
from solidwhirl.reduction.operators.cyclic import CyclicIndex
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, IntArray

# Interior angle beyond which an edge of the surface is a corner and no part of an arc [rad].
_REENTRANT = np.radians(215.0)
# Angles around an edge inside the material add up to a full turn.
_WHOLE = 2.0 * np.pi - 1e-3
# Two facets whose directions add up to less than this are one straight line.
_STRAIGHT = 1e-3
# Triangles of a rigid surface that meet at a larger angle than this have an edge between them.
_EDGE = np.radians(35.0)
# Nodes are on a cut face up to this part of the size of the mesh.
_NEAR = 1e-9


def singular_nodes(
    domain: Any,
    facet_tags: Mapping[str, Any],
    interfaces: Sequence[AnyInterface],
    cyclic: CyclicIndex | None,
) -> BoolArray:
    """Return which vertices lie on a re-entrant edge or at the end of a rigid interface.

    `domain`: of a meridian (edges are its corners), of a sector, whose cyclic index is given, or of
    a whole solid.
    """
    points, cells = compat.straight_cells(domain)
    rigid = [
        _facet_nodes(domain, cells, facet_tags[i.name]) for i in interfaces if i.coupling == "rigid"
    ]
    if cells.shape[1] == 3:
        singular = _reentrant_corners(points, cells)
        for facets in rigid:
            singular[chain_ends(points, facets, _STRAIGHT)] = True
    else:
        singular = _reentrant_edges(points, cells)
        cut = np.zeros(len(points), dtype=bool) if cyclic is None else _on_cut(points, cyclic)
        for facets in rigid:
            singular |= _ends(points, facets, cut)
    return np.asarray(singular)


def _reentrant_corners(points: FloatArray, cells: IntArray) -> BoolArray:
    """Nodes of a meridian around which the material fills more than a corner."""
    sides = points[np.roll(cells, -1, axis=1)] - points[cells]
    sides /= np.linalg.norm(sides, axis=2, keepdims=True)
    angles = np.arccos(np.clip(-(sides * np.roll(sides, 1, axis=1)).sum(axis=2), -1.0, 1.0))
    around = np.zeros(len(points))
    np.add.at(around, cells, angles)
    return np.asarray((around > _REENTRANT) & (around < _WHOLE))


def _reentrant_edges(points: FloatArray, cells: IntArray) -> BoolArray:
    """Nodes at the ends of edges around which the material fills more than a corner."""
    edges, angles = [], []
    for pair in combinations(range(4), 2):
        a, b = pair
        c, d = set(range(4)) - set(pair)
        x = points[cells]
        along = x[:, b] - x[:, a]
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        beside = []
        for other in (c, d):
            v = x[:, other] - x[:, a]
            v = v - along * np.sum(v * along, axis=1, keepdims=True)
            beside.append(v / np.linalg.norm(v, axis=1, keepdims=True))
        angles.append(np.arccos(np.clip(np.sum(beside[0] * beside[1], axis=1), -1.0, 1.0)))
        edges.append(np.sort(cells[:, [a, b]], axis=1))
    own, place = np.unique(np.concatenate(edges), axis=0, return_inverse=True)
    around = np.bincount(place.ravel(), np.concatenate(angles), len(own))
    out = np.zeros(len(points), dtype=bool)
    out[own[(around > _REENTRANT) & (around < _WHOLE)]] = True
    return out


def _ends(points: FloatArray, facets: IntArray, on_cut: BoolArray) -> BoolArray:
    """Nodes where triangles of a surface end, cut faces left out, or meet at an angle."""
    normal = np.cross(points[facets[:, 1]] - points[facets[:, 0]],
                      points[facets[:, 2]] - points[facets[:, 0]])  # fmt: skip
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    edges = np.sort(np.concatenate([facets[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))]))
    own, place, count = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    owner = np.tile(np.arange(len(facets)), 3)[np.argsort(place.ravel(), kind="stable")]
    first = np.concatenate([[0], np.cumsum(count)])[:-1]
    single = (count == 1) & ~on_cut[own].all(axis=1)
    shared = np.flatnonzero(count == 2)
    left, right = normal[owner[first[shared]]], normal[owner[first[shared] + 1]]
    bent = np.abs(np.sum(left * right, axis=1)) < np.cos(_EDGE)
    out = np.zeros(len(points), dtype=bool)
    out[own[single]] = True
    out[own[shared[bent]]] = True
    return out


def _on_cut(points: FloatArray, cyclic: CyclicIndex) -> BoolArray:
    """Nodes on the cut faces of a sector, and on the axis."""
    from scipy.spatial import cKDTree

    near = _NEAR * float(np.abs(points).max())
    alpha = 2.0 * np.pi / cyclic.sector.count
    axis = np.hypot(points[:, 0], points[:, 1]) <= near
    if cyclic.sector.mirrored:
        half = 0.5 * alpha
        beyond = points[:, 1] * np.cos(half) - points[:, 0] * np.sin(half)
        return np.asarray((np.abs(points[:, 1]) <= near) | (np.abs(beyond) <= near) | axis)
    c, s = np.cos(alpha), np.sin(alpha)
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    tree = cKDTree(points)
    ahead, back = tree.query(points @ turn)[0], tree.query(points @ turn.T)[0]
    return np.asarray((ahead <= near) | (back <= near) | axis)


def _facet_nodes(domain: Any, cells: IntArray, tags: Any) -> IntArray:
    """Nodes of the mesh at the corners of the facets of an interface."""
    topology, d = domain.topology, domain.topology.dim
    topology.create_connectivity(d - 1, 0)
    corners = topology.connectivity(d, 0).array.reshape(-1, d + 1)[: len(cells)]
    node = np.zeros(int(corners.max()) + 1, dtype=np.int64)
    node[corners] = cells
    ends = topology.connectivity(d - 1, 0).array.reshape(-1, d)
    return np.asarray(node[ends[tags.indices]])
