"""Curves of many cases matched with each other: by kind, by continuity, and by shape if known.

Cases are visited from the middle outwards, each next to those that are known. What is expected
there is extrapolated from the neighbours; what is found is paired with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from solidwhirl.rotordyn.campbell.branch_numbers import modal_assurance
from solidwhirl.rotordyn.core.arrays import (
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
    ReadOnlyArrays,
)

# Differences of logarithms: no difference; farther is in doubt; leaves another whirl no partner.
_SAME, _FAR, _OTHER_KIND = 1e-4, 0.7, 0.25
# A pair is in doubt if it is off by more than this share of the distance to the next partner.
_SHARE = 0.5
# Directions in which the neighbours spread less than this share of their largest say nothing.
_SPREAD = 0.2
# Frequencies below this share of the largest count as equal (motions that nothing holds).
_FLOOR = 1e-3
_NEVER = 1e6
# What a MAC of 0 is worth beside a difference of logarithms, and the MAC (likeness of shapes)
# below which curves are never one mode.
_SHAPE, _UNLIKE = 1.0, 0.3
_OPPOSITE = {"forward", "backward"}

Kind = tuple[int, str]


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class MatchedCurves(ReadOnlyArrays):
    """Which curve of each case belongs to which track."""

    # Number of the curve in the list of its case, (tracks, cases); -1 where there is none
    index: IntArray
    # Where another curve would fit nearly as well, the whirl changes, or the change is larger than
    # a factor of 2
    doubtful: BoolArray


class _Found(NamedTuple):
    """Where the cases are, and what was found there: logarithms, kinds and, if known, shapes."""

    scaled: FloatArray
    logs: Sequence[FloatArray]
    kinds: Sequence[Sequence[Kind]]
    shapes: Sequence[ComplexArray] | None


def match_curves(
    scaled: FloatArray,
    curves: Sequence[FloatArray],
    kinds: Sequence[Sequence[Kind]],
    shapes: Sequence[ComplexArray] | None = None,
) -> MatchedCurves:
    """Match curves of neighbouring cases.

    `scaled`: coordinates of the cases, (n, columns), from `SweepDesign`. `curves`: positive values
    by case, (curves, points); nan where a curve is absent. `kinds`: of each curve: a number and a
    whirl. Only curves of equal number are matched, forward never with backward; other whirls only
    where they are near. `shapes`: motions of the same places by case, (curves, places); None:
    frequencies alone tell.
    Tracks are in the order of their median value.

    Cases are visited as Prim's algorithm spans their minimum tree. A track is expected at its
    value in the nearest visited case plus the gradient through the next ones (least squares in
    the logarithm, directions they do not span left out), with the shape of the nearest. Pairs are
    those of least total distance. Pairs in doubt are looked at again when all cases are known,
    from the neighbours on all sides.
    """
    found = _Found(scaled, _logarithms(curves), kinds, shapes)
    tracks: list[dict[int, int]] = []
    doubts: list[set[int]] = []
    visited: list[int] = []
    for case in visiting_order(scaled):
        cost = _costs(tracks, case, visited, found)
        pairs = zip(*(k.tolist() for k in linear_sum_assignment(cost)), strict=True)
        partner = {t: c for t, c in pairs if cost[t, c] < _NEVER}
        for track, curve in partner.items():
            tracks[track][case] = curve
            if _in_doubt(track, curve, partner, cost, found.logs[case]):
                doubts[track].add(case)
        new = [k for k in range(len(curves[case])) if k not in partner.values()]
        tracks += [{case: k} for k in new]
        doubts += [set() for _ in new]
        visited.append(case)
    for case in sorted(set().union(*doubts)):
        known = [k for k, track in enumerate(tracks) if track.keys() - {case}]
        others = [c for c in visited if c != case]
        cost = _costs([tracks[k] for k in known], case, others, found)
        partner = {row: tracks[k][case] for row, k in enumerate(known) if case in tracks[k]}
        for row, k in enumerate(known):
            if case in doubts[k] and not _in_doubt(
                row, partner[row], partner, cost, found.logs[case]
            ):
                doubts[k].discard(case)
    return _ordered(tracks, doubts, found.logs)


def visiting_order(scaled: FloatArray) -> list[int]:
    """Return cases from the most central one on, each time the one nearest to those before."""
    count = len(scaled)
    if count == 0:
        return []
    first = int(np.linalg.norm(scaled - np.median(scaled, axis=0), axis=1).argmin())
    order = [first]
    distance = np.linalg.norm(scaled - scaled[first], axis=1)
    seen = np.zeros(count, dtype=bool)
    seen[first] = True
    while len(order) < count:
        following = int(np.where(seen, np.inf, distance).argmin())
        order.append(following)
        seen[following] = True
        distance = np.minimum(distance, np.linalg.norm(scaled - scaled[following], axis=1))
    return order


def _logarithms(curves: Sequence[FloatArray]) -> list[FloatArray]:
    largest = max((float(np.nanmax(c)) for c in curves if np.isfinite(c).any()), default=1.0)
    return [np.log(np.maximum(c, _FLOOR * largest)) for c in curves]


def _costs(
    tracks: Sequence[dict[int, int]], case: int, others: Sequence[int], found: _Found
) -> FloatArray:
    """How far what other cases let expect is from what was found in one, (tracks, curves)."""
    logs, kinds, shapes = found.logs[case], found.kinds[case], found.shapes
    cost = np.full((len(tracks), len(logs)), _NEVER)
    if not cost.size:
        return cost
    away = np.linalg.norm(found.scaled[list(others)] - found.scaled[case], axis=1)
    near = [others[k] for k in np.argsort(away, kind="stable")]
    most = 2 * found.scaled.shape[1] + 1
    for row, track in enumerate(tracks):
        cases = list(islice((c for c in near if c in track), most))
        values = np.array([found.logs[c][track[c]] for c in cases])
        expected = _extrapolated(found.scaled[case], found.scaled[cases], values)
        distance = _distances(expected[None], logs)[0]
        if shapes is not None:
            mac = modal_assurance(shapes[cases[0]][[track[cases[0]]]], shapes[case])[0]
            distance = np.where(mac < _UNLIKE, _NEVER, distance + _SHAPE * (1.0 - mac))
        number, whirl = found.kinds[cases[0]][track[cases[0]]]
        for column, (other_number, other) in enumerate(kinds):
            if number == other_number and whirl == other:
                cost[row, column] = distance[column]
            elif number == other_number and {whirl, other} != _OPPOSITE:
                near_enough = distance[column] < _OTHER_KIND
                cost[row, column] = _FAR + distance[column] if near_enough else _NEVER
    return cost


def _extrapolated(place: FloatArray, places: FloatArray, values: FloatArray) -> FloatArray:
    """Value of the first place plus the gradient through the others."""
    steps = places[1:] - places[0]
    length = np.linalg.norm(steps, axis=1)
    use = length > 0.0
    if not use.any() or np.linalg.norm(place - places[0]) > 3.0 * length[use].max():
        return np.asarray(values[0])
    weighted = steps[use] / length[use, None]
    rises = (values[1:] - values[0])[use] / length[use, None]
    rises = np.where(np.isfinite(rises).all(axis=0), rises, 0.0)
    gradient = np.linalg.lstsq(weighted, rises, rcond=_SPREAD)[0]
    return np.asarray(values[0] + (place - places[0]) @ gradient)


def _distances(first: FloatArray, second: FloatArray) -> FloatArray:
    """Mean difference over the points that both have, (first, second)."""
    gap = np.abs(first[:, None] - second[None])
    known = np.isfinite(gap)
    count = known.sum(axis=2)
    total = np.where(known, gap, 0.0).sum(axis=2)
    return np.where(count > 0, total / np.maximum(count, 1), _NEVER)


def _in_doubt(
    track: int, curve: int, partner: dict[int, int], cost: FloatArray, logs: FloatArray
) -> bool:
    """Whether another curve fits this track, or another track this curve, nearly as well.

    Curves that coincide may be exchanged without harm.
    """
    same = _distances(logs[[curve]], logs)[0] <= _SAME
    rivals = [t for t in range(len(cost)) if t != track and not (t in partner and same[partner[t]])]
    off = float(cost[track, curve])
    nearest = min(cost[track, ~same].min(initial=np.inf), cost[rivals, curve].min(initial=np.inf))
    return bool(off > _FAR or (off > _SAME and off > _SHARE * nearest))


def _ordered(
    tracks: Sequence[dict[int, int]], doubts: Sequence[set[int]], logs: Sequence[FloatArray]
) -> MatchedCurves:
    """Tracks by their median level."""
    means = [[np.nanmean(c) if np.isfinite(c).any() else np.inf for c in case] for case in logs]
    level = [np.median([means[c][k] for c, k in track.items()]) for track in tracks]
    index = np.full((len(tracks), len(logs)), -1, dtype=int)
    doubtful = np.zeros(index.shape, dtype=bool)
    for row, number in enumerate(np.argsort(np.array(level, dtype=float), kind="stable")):
        index[row, list(tracks[number])] = list(tracks[number].values())
        doubtful[row, list(doubts[number])] = True
    return MatchedCurves(index=index, doubtful=doubtful)
