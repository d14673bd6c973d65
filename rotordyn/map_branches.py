"""Branches of critical speeds over a stiffness, paired by the likeness of their shapes."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la
from scipy.optimize import linear_sum_assignment

from solidwhirl.rotordyn.arrays import ComplexArray, FloatArray

# Below this likeness a step of stiffness is halved, and two shapes are not the same branch.
_GOOD, _POOR = 0.8, 0.4
# Halvings of one step, and of one on which branches begin or end, which no step is too small for.
_HALVINGS, _HALVINGS_AT_ENDS = 5, 1
# Speeds closer than this (relative) are one cluster, whose shapes are free to turn.
_SAME_SPEED = 1e-7

IntArray = npt.NDArray[np.int_]


class MapPoint(NamedTuple):
    """Critical speeds at one stiffness, rising, shape (r,), and their shapes, (m, r)."""

    stiffness: float
    speeds: FloatArray
    shapes: FloatArray | ComplexArray


class MapBranches(NamedTuple):
    """Column of each branch at each stiffness, −1 where there is none, and its likeness.

    Both have shape (b, s); the likeness to the previous stiffness is 1 where a branch begins.
    """

    columns: IntArray
    likeness: FloatArray


class _Pairs(NamedTuple):
    """Partner of each column of the first point in the second (−1: none), and the likeness."""

    second: MapPoint
    partner: IntArray
    likeness: FloatArray


def follow_branches(
    points: list[MapPoint],
    solve: Callable[[float], MapPoint],
    metric: Callable[[float], FloatArray],
    wanted: int,
) -> tuple[list[MapPoint], MapBranches]:
    """Pair the critical speeds of successive stiffness values.

    Parameters
    ----------
    points
        At rising stiffness.
    solve
        Gives a point between two others, for steps on which shapes change much.
    metric
        Stiffness matrix (m, m) in whose energy product shapes are compared, at a stiffness.
    wanted
        Steps are halved for the sake of this many of the lowest speeds.

    Returns
    -------
    points : list of MapPoint
        Those given, with shapes of equal speeds turned to match their neighbours.
    branches : MapBranches
        All branches, also those that begin or end on the way.
    """
    turned = [points[0]]
    columns = [[int(c)] for c in range(points[0].speeds.size)]
    likeness = [[1.0] for _ in columns]
    for place, point in enumerate(points[1:], start=1):
        pairs = _advance(turned[-1], point, solve, metric, wanted, _HALVINGS)
        turned.append(pairs.second)
        taken = set()
        for branch, score in zip(columns, likeness, strict=True):
            here = branch[-1]
            there = int(pairs.partner[here]) if here >= 0 else -1
            branch.append(there)
            score.append(float(pairs.likeness[here]) if there >= 0 else 0.0)
            taken.add(there)
        for new in sorted(set(range(point.speeds.size)) - taken):
            columns.append([-1] * place + [new])
            likeness.append([0.0] * place + [1.0])
    shape = (len(columns), len(points))
    return turned, MapBranches(
        np.array(columns, dtype=int).reshape(shape), np.array(likeness).reshape(shape)
    )


def _advance(
    first: MapPoint,
    second: MapPoint,
    solve: Callable[[float], MapPoint],
    metric: Callable[[float], FloatArray],
    wanted: int,
    halvings: int,
) -> _Pairs:
    """Pair two points, by way of the middle where shapes change much."""
    middle = float(np.sqrt(first.stiffness * second.stiffness))
    pairs = _paired(first, second, metric(middle))
    if first.speeds.size != second.speeds.size:
        halvings = min(halvings, _HALVINGS_AT_ENDS)
    if halvings == 0 or not _doubtful(pairs, wanted):
        return pairs
    before = _advance(first, solve(middle), solve, metric, wanted, halvings - 1)
    after = _advance(before.second, second, solve, metric, wanted, halvings - 1)
    partner, likeness = np.full(first.speeds.size, -1), np.zeros(first.speeds.size)
    for here, between in enumerate(before.partner):
        if between >= 0 and after.partner[between] >= 0:
            partner[here] = after.partner[between]
            likeness[here] = min(before.likeness[here], after.likeness[between])
    return _Pairs(after.second, partner, likeness)


def _doubtful(pairs: _Pairs, wanted: int) -> bool:
    """Whether one of the lowest speeds of either point has no good partner."""
    unmatched = np.setdiff1d(np.arange(pairs.second.speeds.size), pairs.partner)
    return bool((pairs.likeness[:wanted] < _GOOD).any() or (unmatched < wanted).any())


def _paired(first: MapPoint, second: MapPoint, metric: FloatArray) -> _Pairs:
    """Pair by the best total likeness; among equal shapes the nearer speed is preferred."""
    one, two = _unit(first.shapes, metric), _unit(second.shapes, metric)
    product = one.conj().T @ metric @ two
    for cluster in _clusters(second.speeds):
        if first.speeds.size < cluster.size:
            continue
        rows = np.argsort(-(np.abs(product[:, cluster]) ** 2).sum(axis=1), kind="stable")
        left, _, right = la.svd(product[np.sort(rows[: cluster.size])][:, cluster])
        turn = (left @ right).conj().T
        two[:, cluster] = two[:, cluster] @ turn
        product[:, cluster] = product[:, cluster] @ turn
    likeness = np.minimum(np.abs(product) ** 2, 1.0)
    distance = np.abs(np.log(np.divide.outer(first.speeds, second.speeds)))
    rows, columns = linear_sum_assignment(-likeness * np.exp(-distance))
    partner, found = np.full(first.speeds.size, -1), np.zeros(first.speeds.size)
    for row, column in zip(rows, columns, strict=True):
        if likeness[row, column] > _POOR:
            partner[row], found[row] = column, likeness[row, column]
    return _Pairs(second._replace(shapes=two), partner, found)


def _unit(shapes: FloatArray | ComplexArray, metric: FloatArray) -> FloatArray | ComplexArray:
    """Return shapes of unit energy."""
    energy = np.einsum("im,im->m", shapes.conj(), metric @ shapes).real
    return np.asarray(shapes / np.sqrt(energy))


def _clusters(speeds: FloatArray) -> list[IntArray]:
    """Return groups of two and more columns of equal speed."""
    ends = np.flatnonzero(np.diff(speeds) > _SAME_SPEED * speeds[1:]) + 1
    groups = np.split(np.arange(speeds.size), ends)
    return [group for group in groups if group.size > 1]
