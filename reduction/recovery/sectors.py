"""Fields of one cyclic index at all points of a sector, from its mesh or from half of it.

The field of index h is A at the sector and R(kα)(A cos hkα + B sin hkα) at its copy k, α = 2π/N
(see `operators.cyclic`): with u = Re[(q1 - i q2)(Φ1 + iΦ2)], A = Φ1 q1 + Φ2 q2 and
B = Φ1 q2 - Φ2 q1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from solidwhirl.meshing import Sector
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, IntArray
from solidwhirl.rotordyn.superelement.surface import turns

# Components of a symmetric tensor: three on the diagonal, then 12, 23, 13, as VTK has them.
ROW, COLUMN = np.array([0, 1, 2, 0, 1, 0]), np.array([0, 1, 2, 1, 2, 2])
_PLACE = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
# Signs of the mirror image in the plane y = 0 of a vector and of a tensor.
_MIRROR = np.array([1.0, -1.0, 1.0])
_MIRRORED = {3: _MIRROR, 6: _MIRROR[ROW] * _MIRROR[COLUMN]}
# Points nearer than this part of the size are the same.
_NEAR = 1e-9

#: A and B of a field, each (p, components)
Pair = tuple[NDArray[Any], NDArray[Any]]


def turned(values: NDArray[Any], angle: FloatArray | float) -> NDArray[Any]:
    """Return vectors (p, 3) or tensors (p, 6) turned about z by some angles (k,), (k, p, ...)."""
    turn = turns(np.atleast_1d(angle))
    if values.shape[-1] == 3:
        return np.asarray(np.einsum("kij,pj->kpi", turn, values))
    tensor = values[:, _PLACE]
    return np.asarray(np.einsum("kia,pab,kjb->kpij", turn, tensor, turn, optimize=True))[
        :, :, ROW, COLUMN
    ]


def mirrored(values: NDArray[Any]) -> NDArray[Any]:
    """Return points, vectors (p, 3), or tensors (p, 6) and their mirror images, (2 p, ...)."""
    return np.concatenate([values, values * _MIRRORED[values.shape[-1]]])


def pair_of(parts: Sequence[Pair], sector: Sector, index: int) -> Pair:
    """Return A and B at all points of a sector.

    `parts`: Φ1 q and Φ2 q of the families, at the points of the mesh. `index`: h.
    """
    if sector.mirrored:
        sign = np.array([[1.0], [-1.0]]).repeat(len(parts[0][0]), axis=0)
        parts = [(mirrored(first), sign * mirrored(second)) for first, second in parts]
    first, second = parts[0]
    if 2 * index % sector.count == 0:  # the field is real
        return first + second, np.zeros_like(first)
    other, more = parts[1]
    return first + more, other - second


class _Link(NamedTuple):
    """Points that coincide with some of a copy: which, with which, and their part of the mean."""

    copy: int
    point: IntArray
    partner: IntArray
    part: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class SharedPoints:
    """Means over all elements around a point, those of the copies of the sector among them."""

    links: tuple[_Link, ...]
    count: int

    def mean(self, pair: Pair, index: int) -> Pair:
        """Return a field of A and B with the mean of its own and the neighbours' values."""
        out = tuple(np.zeros_like(part) for part in pair)
        for copy, point, partner, part in self.links:
            angle = 2.0 * np.pi * copy / self.count
            cos, sin = np.cos(index * angle), np.sin(index * angle)
            a, b = (values[partner] for values in pair)
            for total, values in zip(out, (cos * a + sin * b, cos * b - sin * a), strict=True):
                np.add.at(total, point, part[:, None] * turned(values, angle)[0])
        return out[0], out[1]


def shared_points(
    points_m: FloatArray, material: IntArray, weight: FloatArray, count: int, apart: BoolArray
) -> SharedPoints:
    """Find the points of a sector that copies of it have as well.

    `points_m`: (p, 3) points of the whole sector; `material`: (p,) numbers of materials, which are
    kept apart; `weight`: (p,) size of the elements at a point; `count`: N; `apart`: (p,) whether
    another point is at the same place, across a joint: what is beyond it is not told from it, and
    they have no means.
    """
    size = float(np.abs(points_m).max())
    axis = np.flatnonzero(np.hypot(points_m[:, 0], points_m[:, 1]) <= _NEAR * size)
    every = np.arange(len(points_m))
    found = []
    for copy in range(count):
        # only the neighbours share more than the axis
        own = every if copy in (0, 1, count - 1) else axis
        there = turned(points_m[own], 2.0 * np.pi * copy / count)[0]
        first, second = (
            cKDTree(np.column_stack([x, size * material[own]])) for x in (points_m[own], there)
        )
        near = first.sparse_distance_matrix(second, _NEAR * size, output_type="ndarray")
        mine, theirs = own[near["i"]], own[near["j"]]
        kept = ~apart[mine] | ((mine == theirs) & (copy == 0))
        found.append((copy, mine[kept], theirs[kept]))
    total = np.sum([np.bincount(i, weight[j], len(points_m)) for _, i, j in found], axis=0)
    links = (_Link(copy, i, j, weight[j] / total[i]) for copy, i, j in found)
    return SharedPoints(links=tuple(links), count=count)
