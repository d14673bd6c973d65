"""Curves of many cases matched with each other: by kind and order, reordered by continuity.

Cases are visited from the middle outwards, each next to those that are known. What is expected
there is extrapolated from the neighbours; what is found is paired with it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from solidwhirl.shape_prints import ComplexArray, likeness
from solidwhirl.sweep_design import BoolArray, FloatArray, IntArray

# Differences of logarithms: no difference; farther is in doubt; leaves another kind no partner.
_SAME, _FAR, _OTHER_KIND = 1e-4, 0.7, 0.25
# Continuity must be this much better than order to take its place.
_CLEARLY = 3.0
# A pair is in doubt if it is off by more than this share of the distance to the next partner.
_SHARE = 0.5
# Directions in which the neighbours spread less than this share of their largest say nothing.
_SPREAD = 0.2
# Frequencies below this share of the largest count as equal (motions that nothing holds).
_FLOOR = 1e-3
_NEVER = 1e6
# What shapes without likeness are worth beside a difference of logarithms, and the likeness (MAC)
# below which curves are never one mode.
_SHAPE, _UNLIKE = 1.0, 0.3
_OPPOSITE = {("forward", "backward"), ("backward", "forward")}

Kind = tuple[int, str]


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class MatchedCurves:
    """Which curve of each case belongs to which track.

    Attributes
    ----------
    index
        Number of the curve in the list of its case, (tracks, cases); -1 where there is none.
    doubtful
        Where another curve would fit nearly as well, or the change is larger than a factor of 2.
    reordered
        Where continuity clearly speaks against the order: curves of one kind have crossed
        between the nearest case and this one. Curves that veer look so if cases lie far apart.
    """

    index: IntArray
    doubtful: BoolArray
    reordered: BoolArray

    def __post_init__(self) -> None:
        for name in ("index", "doubtful", "reordered"):
            getattr(self, name).setflags(write=False)


@dataclass
class _Track:
    """Curve numbers by case, and where they are in doubt; grows while cases are visited."""

    index: dict[int, int] = field(default_factory=dict)
    doubtful: set[int] = field(default_factory=set)
    reordered: set[int] = field(default_factory=set)


class _Pair(NamedTuple):
    track: int
    curve: int
    doubtful: bool
    reordered: bool


@dataclass(frozen=True)
class _Expected:
    """What the tracks are expected to be in a case: logarithms (tracks, s) and kinds.

    `nearest` is what they are in the nearest case that has them, and so are the `shapes`.
    """

    curves: FloatArray
    nearest: FloatArray
    kinds: list[Kind]
    shapes: ComplexArray | None = None

    def distances(self, found: FloatArray, shapes: ComplexArray | None) -> FloatArray:
        """Distance of what is expected from what is found, by frequency and by shape."""
        distance = _distances(self.curves, found)
        if self.shapes is None or shapes is None or not distance.size:
            return distance
        mac = likeness(self.shapes, shapes)
        return np.where(mac < _UNLIKE, _NEVER, distance + _SHAPE * (1.0 - mac))


class _Found(NamedTuple):
    """What was found in every case: logarithms, kinds and, if known, shapes."""

    logs: Sequence[FloatArray]
    kinds: Sequence[Sequence[Kind]]
    shapes: Sequence[ComplexArray] | None

    def shapes_of(self, case: int) -> ComplexArray | None:
        return None if self.shapes is None else self.shapes[case]


def match_curves(
    scaled: FloatArray,
    curves: Sequence[FloatArray],
    kinds: Sequence[Sequence[Kind]],
    shapes: Sequence[ComplexArray] | None = None,
) -> MatchedCurves:
    """Match curves of neighbouring cases.

    Parameters
    ----------
    scaled
        Coordinates of the cases, (n, columns), from `SweepDesign`.
    curves
        Positive values by case, (curves, points); nan where a curve is absent.
    kinds
        Of each curve: a number and a whirl. Only curves of equal number are matched, forward
        never with backward; other whirls only where they leave each other no partner.

    Returns
    -------
    MatchedCurves
        Tracks in the order of their median value.

    Notes
    -----
    Cases are visited as Prim's algorithm spans their minimum tree. A track is expected at its
    value in the nearest visited case plus the gradient through the next ones (least squares in
    the logarithm, directions they do not span left out). Within a kind the pairs of equal order
    stand, unless pairing with the least total distance is three times closer. Pairs in doubt are
    looked at again when all cases are known, from the neighbours on all sides.
    """
    found = _Found(_logarithms(curves), kinds, shapes)
    logs = found.logs
    tracks: list[_Track] = []
    visited: list[int] = []
    for case in visiting_order(scaled):
        near = _by_distance(scaled, case, visited)
        expected = _expected(tracks, case, near, scaled, found)
        pairs = _pairs(expected, found, case)
        for pair in pairs:
            tracks[pair.track].index[case] = pair.curve
            tracks[pair.track].doubtful |= {case} if pair.doubtful else set()
            tracks[pair.track].reordered |= {case} if pair.reordered else set()
        taken = {pair.curve for pair in pairs}
        tracks += [_Track(index={case: k}) for k in range(len(logs[case])) if k not in taken]
        visited.append(case)
    _look_again(tracks, scaled, found)
    return _ordered(tracks, logs)


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


def _by_distance(scaled: FloatArray, case: int, others: Sequence[int]) -> list[int]:
    away = np.linalg.norm(scaled[list(others)] - scaled[case], axis=1)
    return [others[k] for k in np.argsort(away, kind="stable")]


def _look_again(tracks: Sequence[_Track], scaled: FloatArray, found: _Found) -> None:
    """Take back doubts that the neighbours on all sides resolve, such as those of first steps."""
    for case in sorted({c for track in tracks for c in track.doubtful}):
        near = _by_distance(scaled, case, [c for c in range(len(scaled)) if c != case])
        known = [t for t in tracks if t.index.keys() - {case}]
        expected = _expected(known, case, near, scaled, found)
        distance = expected.distances(found.logs[case], found.shapes_of(case))
        partner = {k: t.index[case] for k, t in enumerate(known) if case in t.index}
        for k, track in enumerate(known):
            if case not in track.doubtful:
                continue
            own = expected.kinds[k]
            same = [q for q, kind in enumerate(expected.kinds) if kind == own]
            rivals = [c for c, kind in enumerate(found.kinds[case]) if kind == own]
            # a change of whirl stays in doubt
            if partner[k] in rivals and not _in_doubt(
                k, partner[k], same, rivals, partner, distance, found.logs[case]
            ):
                track.doubtful.discard(case)


def _logarithms(curves: Sequence[FloatArray]) -> list[FloatArray]:
    largest = max((float(np.nanmax(c)) for c in curves if np.isfinite(c).any()), default=1.0)
    return [np.log(np.maximum(c, _FLOOR * largest)) for c in curves]


def _expected(
    tracks: Sequence[_Track],
    case: int,
    near: Sequence[int],
    scaled: FloatArray,
    found: _Found,
) -> _Expected:
    most = 2 * scaled.shape[1] + 1
    curves, nearest, expected_kinds, shapes = [], [], [], []
    for track in tracks:
        cases = list(islice((c for c in near if c in track.index), most))
        values = np.array([found.logs[c][track.index[c]] for c in cases])
        curves.append(_extrapolated(scaled[case], scaled[cases], values))
        nearest.append(values[0])
        expected_kinds.append(found.kinds[cases[0]][track.index[cases[0]]])
        if found.shapes is not None:
            shapes.append(found.shapes[cases[0]][track.index[cases[0]]])
    known = np.array(shapes) if found.shapes is not None else None
    return _Expected(np.array(curves), np.array(nearest), expected_kinds, known)


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


def _pairs(expected: _Expected, every: _Found, case: int) -> list[_Pair]:
    """Pairs of equal kind, then of what these leave."""
    found, kinds = every.logs[case], every.kinds[case]
    if not len(expected.kinds) or not len(found):
        return []
    distance = expected.distances(found, every.shapes_of(case))
    pairs: list[_Pair] = []
    for kind in dict.fromkeys(expected.kinds):
        tracks = [t for t, k in enumerate(expected.kinds) if k == kind]
        own = [c for c, k in enumerate(kinds) if k == kind]
        if own:
            pairs += _pairs_of_kind(tracks, own, expected, found, distance)
    free = [t for t in range(len(expected.kinds)) if t not in {p.track for p in pairs}]
    left = [c for c in range(len(found)) if c not in {p.curve for p in pairs}]
    cost = np.full((len(free), len(left)), _NEVER)
    for row, t in enumerate(free):
        for column, c in enumerate(left):
            (number, whirl), (other_number, other_whirl) = expected.kinds[t], kinds[c]
            opposite = (whirl, other_whirl) in _OPPOSITE
            if number == other_number and not opposite and distance[t, c] < _OTHER_KIND:
                cost[row, column] = distance[t, c]
    for row, column in zip(*linear_sum_assignment(cost), strict=True):
        if cost[row, column] < _NEVER:
            pairs.append(_Pair(free[row], left[column], doubtful=True, reordered=False))
    return pairs


def _distances(first: FloatArray, second: FloatArray) -> FloatArray:
    """Mean difference over the points that both have, (first, second)."""
    gap = np.abs(first[:, None] - second[None])
    known = np.isfinite(gap)
    count = known.sum(axis=2)
    total = np.where(known, gap, 0.0).sum(axis=2)
    return np.where(count > 0, total / np.maximum(count, 1), _NEVER)


def _pairs_of_kind(
    tracks: list[int], own: list[int], expected: _Expected, found: FloatArray, distance: FloatArray
) -> list[_Pair]:
    cost = distance[np.ix_(tracks, own)]
    nearest = sorted(zip(*(k.tolist() for k in linear_sum_assignment(cost)), strict=True))
    in_order = sorted(zip(_rank(expected.curves[tracks]), _rank(found[own]), strict=False))
    off_nearest, off_order = (sum(cost[r, c] for r, c in p) for p in (nearest, in_order))
    unclear = nearest != in_order and off_order <= _CLEARLY * off_nearest
    chosen = {tracks[r]: own[c] for r, c in (in_order if unclear else nearest)}
    other = {tracks[r]: own[c] for r, c in (nearest if unclear else in_order)}
    return [
        _Pair(
            t,
            c,
            doubtful=(unclear and other.get(t) != c)
            or _in_doubt(t, c, tracks, own, chosen, distance, found),
            # by their shapes curves that cross are no surprise
            reordered=expected.shapes is None
            and any(_crossed(expected.nearest[[t, q]], found[[c, p]]) for q, p in chosen.items()),
        )
        for t, c in chosen.items()
        if distance[t, c] < _NEVER
    ]


def _crossed(before: FloatArray, after: FloatArray) -> bool:
    """Whether two curves have changed places."""
    first, second = ([_level(c) for c in pair] for pair in (before, after))
    was, now = first[1] - first[0], second[1] - second[0]
    return abs(now) > _SAME and was * now < 0.0


def _in_doubt(
    track: int,
    curve: int,
    tracks: Sequence[int],
    curves: Sequence[int],
    partner: Mapping[int, int],
    distance: FloatArray,
    found: FloatArray,
) -> bool:
    """Whether another curve fits this track, or another track this curve, nearly as well.

    Curves that coincide may be exchanged without harm.
    """
    same = _distances(found[[curve]], found)[0] <= _SAME
    others = [distance[track, c] for c in curves if not same[c]]
    others += [
        distance[t, curve] for t in tracks
        if t != track and not (t in partner and same[partner[t]])
    ]  # fmt: skip
    off = float(distance[track, curve])
    return off > _FAR or (off > _SAME and off > _SHARE * min(others, default=np.inf))


def _level(curve: FloatArray) -> float:
    known = curve[np.isfinite(curve)]
    return float(known.mean()) if known.size else np.inf


def _rank(curves: FloatArray) -> list[int]:
    return [int(k) for k in np.argsort([_level(c) for c in curves], kind="stable")]


def _ordered(tracks: Sequence[_Track], logs: Sequence[FloatArray]) -> MatchedCurves:
    level = [np.median([_level(logs[c][k]) for c, k in t.index.items()]) for t in tracks]
    order = np.argsort(np.array(level, dtype=float), kind="stable")
    shape = len(tracks), len(logs)
    index = np.full(shape, -1, dtype=int)
    doubtful, reordered = np.zeros(shape, dtype=bool), np.zeros(shape, dtype=bool)
    for row, number in enumerate(order):
        track = tracks[number]
        index[row, list(track.index)] = list(track.index.values())
        doubtful[row, list(track.doubtful)] = True
        reordered[row, list(track.reordered)] = True
    return MatchedCurves(index=index, doubtful=doubtful, reordered=reordered)
