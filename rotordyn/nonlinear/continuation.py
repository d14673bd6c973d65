"""Branches of periodic motions over a parameter, followed through their turning points and corners.

Arc-length continuation: each motion is predicted along the tangent and corrected across it (Keller
1977; Allgower and Georg 1990, Numerical Continuation Methods). Lengths are measured with motions
over their size and parameters over a unit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
import scipy
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.nonlinear.harmonic_balance import Equations, Point, at_parameter, corrected

# Steps along a branch: the first and the shortest; how they shrink where one fails, and the next
# after so many corrections.
_FIRST, _SHORTEST, _SHRUNK = 1e-3, 1e-7, 0.4
_NEXT = (4.0, 4.0, 2.5, 1.5, 1.5, 1.0, 1.0, 0.4)
# Cosine of the angle by which a branch may turn in a step.
_TURN = 0.94
# How far behind a corner of a branch, where a gap closes all along an orbit, the next motion is;
# how far before it the way there is taken from, and the angle by which it must leave that way.
_REACHES, _BEFORE, _BACK = (1e-5, 1e-4, 1e-3), 1e-4, 0.02
# Part of the largest motion of a branch so far that lengths are measured with at least.
_SMALL = 0.3
# Motions of a closed branch at least, and how far beside a step its beginning may lie.
_FEWEST, _BESIDE = 8, 0.3
# Part of what several turns add to a motion at first, below which it is one of a single turn.
_GONE = 1e-3
# A turning point is where the tangent's part along the parameter is less than this.
_TURNED = 1e-7

#: Why a branch is not known beyond an end: no motion was found there, a film closes, it grew beyond
#: the bound, or had too many points.
OpenEnd = Literal["lost", "closed", "grows", "long"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Course:
    """What is followed, and how far.

    `equations`: of the motions; `low`, `high`: range of the parameter; `unit`: of the parameter;
    `longest`: step; `size_m`: of motions, least; `bound_m`: up to which motions are followed;
    `turns`: of the unbalance after which they repeat; `most`: points.
    """

    equations: Equations
    low: float
    high: float
    unit: float
    longest: float
    size_m: float = 1e-12
    bound_m: float = np.inf
    turns: int = 1
    most: int = 3000


@dataclass(frozen=True, kw_only=True, eq=False)
class BranchPoint:
    """A motion on a branch.

    `point`: in balance. `along`: tangent of the branch in the direction in which it is followed,
    motion (u,) in m and parameter, shape (u + 1,). `is_turning`: whether the parameter turns there.
    """

    point: Point
    along: FloatArray
    is_turning: bool = False

    def place(self) -> FloatArray:
        """Return motion and parameter in a row, shape (u + 1,)."""
        return np.append(self.point.motion_m.ravel(), self.point.parameter)


class Branch(NamedTuple):
    """Motions along a branch.

    It ends at those of the range, where it closes, and one of several turns where the motion
    becomes one of fewer. `open_ends`: indices (0 or −1) of ends that are none of these, and why.
    """

    points: tuple[BranchPoint, ...]
    is_closed: bool = False
    open_ends: tuple[tuple[int, OpenEnd], ...] = ()


def through(course: Course, start: Point) -> Branch:
    """Follow the branch through a motion both ways."""
    first = follow(course, start, 1.0)
    if first.is_closed:
        return first
    second = follow(course, start, -1.0)
    behind = tuple(replace(p, along=-p.along) for p in second.points[:0:-1])
    open_ends = [(0, why) for _, why in second.open_ends] + list(first.open_ends)
    return Branch((*behind, *first.points), False, tuple(open_ends))


def follow(course: Course, start: Point, sense: float) -> Branch:
    """Follow a branch until its parameter leaves the range, it closes, or joins one of fewer turns.

    `sense`: 1 or −1 as the parameter rises or falls at first.
    """
    largest = max(float(np.abs(start.motion_m).max()), course.size_m)
    here = _tangent(start, np.append(np.zeros(start.motion_m.size), sense), _metric(start, course))
    points, step = [here], _FIRST
    if not course.low < start.parameter + sense * _TURNED * course.unit < course.high:
        return Branch((here,))
    while len(points) < course.most:
        size = float(np.abs(here.point.motion_m).max())
        largest = max(largest, size)
        if size > course.bound_m:
            return Branch(tuple(points), False, ((-1, "grows"),))
        metric = _metric(here.point, course, _SMALL * largest)
        ahead = _step(course, here, step, metric)
        if ahead is None or _cosine(here.along, ahead.along, metric) < _TURN:
            step *= _SHRUNK
            if step >= _SHORTEST:
                continue
            ahead = _beyond_corner(course, points, metric)
            if ahead is None:
                over = here.place() + _REACHES[-1] * here.along
                near = course.equations(over[:-1].reshape(here.point.motion_m.shape), over[-1])
                why: OpenEnd = "lost" if np.isfinite(near.residual_m).all() else "closed"
                return Branch(tuple(points), False, ((-1, why),))
            turns = here.along[-1] * ahead.along[-1] < 0.0
            points[-1] = here = replace(here, is_turning=bool(turns))
            step = _FIRST
        if not course.low <= ahead.point.parameter <= course.high:
            end = course.high if ahead.point.parameter > course.high else course.low
            _, between = next(passing((here, ahead), end))
            last = at_parameter(course.equations, between, end)
            if last is None:
                step *= _SHRUNK
                continue
            return Branch((*points, _tangent(last, here.along, metric)))
        if _joins(points[0], here, ahead, course.turns):
            return Branch(tuple(points))
        if here.along[-1] * ahead.along[-1] < 0.0 and not here.is_turning:
            turning = _turning_point(course, here, ahead, step, metric)
            points += [] if turning is None else [turning]
        if len(points) > _FEWEST and _passes(points[0], here, ahead, metric):
            return Branch((*points, points[0]), True)
        points.append(ahead)
        here = ahead
        step *= _NEXT[min(ahead.point.corrections, len(_NEXT) - 1)]
        step = min(step, course.longest)
    return Branch(tuple(points), False, ((-1, "long"),))


def passing(points: Sequence[BranchPoint], parameter: float) -> Iterator[tuple[int, FloatArray]]:
    """Yield where a branch passes a parameter, the place before, and the motion between two."""
    at = np.array([p.point.parameter for p in points])
    low, high = np.minimum(at[1:], at[:-1]), np.maximum(at[1:], at[:-1])
    near = 1e-9 * abs(parameter)  # ends of branches are those of the range, to rounding
    for k in np.flatnonzero((low <= parameter + near) & (high >= parameter - near)).tolist():
        first, last = (points[j].point.motion_m for j in (k, k + 1))
        share = (parameter - at[k]) / (at[k + 1] - at[k]) if high[k] > low[k] else 0.0
        yield k, first + share * (last - first)


def _metric(point: Point, course: Course, least_m: float = 0.0) -> FloatArray:
    """Units of motion and parameter at a point, shape (u + 1,)."""
    size = max(float(np.abs(point.motion_m).max()), least_m, course.size_m)
    return np.append(np.full(point.motion_m.size, size), course.unit)


def _cosine(one: FloatArray, other: FloatArray, metric: FloatArray) -> float:
    one, other = one / metric, other / metric
    return float(one @ other / (la.norm(one) * la.norm(other)))


def _tangent(point: Point, along: FloatArray, metric: FloatArray) -> BranchPoint:
    """Return a point with its tangent of unit length, in the sense of another one."""
    whole = np.column_stack((point.balance.by_motion, point.balance.by_parameter)) * metric
    # the direction that leaves all in balance, whichever way the branch turns
    way = la.svd(whole / metric[0])[2][-1]
    return BranchPoint(point=point, along=metric * (way if way @ (along / metric) >= 0.0 else -way))


def _step(
    course: Course, here: BranchPoint, length: float, metric: FloatArray
) -> BranchPoint | None:
    """Return the motion a length ahead of one; None if none is found near there."""
    motion = here.point.motion_m
    along = here.along / float(la.norm(here.along / metric))
    guess = here.place() + length * along
    row = along / metric**2
    found = corrected(
        course.equations,
        (guess[:-1].reshape(motion.shape), float(guess[-1])),
        (row[:-1], float(row[-1])),
        float(metric[0]),
    )
    if found is None:
        return None
    ahead = _tangent(found, along, metric)
    way = la.norm((ahead.place() - here.place()) / metric)
    return ahead if length >= _TURN * way else None


def _beyond_corner(
    course: Course, points: list[BranchPoint], metric: FloatArray
) -> BranchPoint | None:
    """Return a motion behind a corner just ahead, None if there is none.

    Its tangent is that of the equations beyond the corner, in the sense that does not lead back.
    """
    here = points[-1]
    before = (here.place() - p.place() for p in reversed(points))
    came = next((b for b in before if la.norm(b / metric) > _BEFORE), here.along)
    came = came / float(la.norm(came / metric))
    shape = here.point.motion_m.shape
    for reach in _REACHES:
        over = here.place() + reach * came
        there = course.equations(over[:-1].reshape(shape), float(over[-1]))
        if not np.isfinite(there.residual_m).all():
            continue
        beyond = _tangent(Point(over[:-1].reshape(shape), float(over[-1]), there, 0), came, metric)
        for way in (beyond.along, -beyond.along):
            found = _step(course, replace(here, along=way), reach, metric)
            if found is None or _cosine(way, found.along, metric) < _TURN:
                continue
            if _cosine(came, found.place() - here.place(), metric) > -np.cos(_BACK):
                return found
    return None


def _passes(start: BranchPoint, here: BranchPoint, ahead: BranchPoint, metric: FloatArray) -> bool:
    """Whether the beginning of a branch lies between two motions that follow each other."""
    chord, to_start = ((p.place() - here.place()) / metric for p in (ahead, start))
    share = float(chord @ to_start / (chord @ chord))
    if not 0.0 <= share <= 1.0 or _cosine(start.along, ahead.along, metric) < _TURN:
        return False
    return bool(la.norm(to_start - share * chord) <= _BESIDE * la.norm(chord))


def _joins(start: BranchPoint, here: BranchPoint, ahead: BranchPoint, turns: int) -> bool:
    """Whether a motion of several turns passes one of a single turn, or has become it."""
    if turns == 1:
        return False
    order = (np.arange(len(start.point.motion_m)) + 1) // 2
    first, last, next_one = (
        p.point.motion_m[order % turns != 0].ravel() for p in (start, here, ahead)
    )
    return bool(last @ next_one < 0.0 or la.norm(next_one) < _GONE * la.norm(first))


def _turning_point(
    course: Course, here: BranchPoint, ahead: BranchPoint, length: float, metric: FloatArray
) -> BranchPoint | None:
    """Return where the parameter turns between two motions, None where it does so too sharply."""

    def at(part: float) -> BranchPoint:
        found = here if part == 0.0 else _step(course, here, part, metric)
        if found is None:
            raise ArithmeticError
        return found

    try:
        part = scipy.optimize.brentq(
            lambda part: at(part).along[-1], 0.0, length, xtol=1e-3 * _TURNED * length
        )
        return replace(at(part), is_turning=True)
    except ArithmeticError:
        return None
