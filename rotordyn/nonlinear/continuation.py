"""Branches of periodic motions over the speed, followed through their turning points.

Arc-length continuation: each motion is predicted along the tangent and corrected across it (Keller
1977; Allgower and Georg 1990, Numerical Continuation Methods). Lengths are measured with motions
over the largest so far and speeds over the range.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.nonlinear.forced_system import ForcedSystem
from solidwhirl.rotordyn.nonlinear.harmonic_balance import (
    Point,
    at_speed,
    balance,
    corrected,
)

# Steps along a branch: the first, the shortest and the longest; how they grow and shrink.
_FIRST, _SHORTEST, _LONGEST = 1e-3, 1e-7, 0.025
# How far behind a corner of a branch, where a gap closes all along an orbit, the next motion is.
_CORNER = 1e-5
_GROWN, _SHRUNK = 1.5, 0.4
# Corrections after which a step may grow, and those from which on it shrinks.
_FEW, _MANY = 4, 7
# Cosine of the angle by which a branch may turn in a step.
_TURN = 0.94
_MOST_POINTS = 3000
# Motions of a closed branch at least, and how far beside a step its beginning may lie.
_FEWEST, _BESIDE = 8, 0.3
# Part of what several turns add to a motion at first, below which it is one of a single turn.
_GONE = 1e-3
# A turning point is where the tangent's part along the speed is less than this.
_TURNED = 1e-7
# Loads are raised in steps from none where the motion under all is not found at once.
_LEAST_SHARE = 1e-3


@dataclass(frozen=True, kw_only=True, eq=False)
class BranchPoint:
    """A motion on a branch.

    `point`: in balance. `along_motion`, `along_speed`: tangent of the branch in the direction in
    which it is followed, shape (u,) in m and rad/s. `is_turning`: whether the speed turns there.
    """

    point: Point
    along_motion: FloatArray
    along_speed: float
    is_turning: bool = False


class Branch(NamedTuple):
    """Motions along a branch, and whether it was followed to its end.

    The end is that of the range of speeds, of a closed branch the beginning, and of one of several
    turns where the motion becomes one of fewer.
    """

    points: tuple[BranchPoint, ...]
    is_whole: bool
    is_closed: bool = False


class _Scale(NamedTuple):
    length_m: float
    speed_rad_s: float


def branches(
    forced: ForcedSystem, from_rad_s: float, to_rad_s: float, harmonics: int
) -> tuple[Branch, ...]:
    """Follow the motions from the lowest speed, and from the highest if that is another branch.

    `from_rad_s`, `to_rad_s`: above 0, rising. Branches that reach neither end of the range are not
    found. Raises AnalysisError if no motion is found at the lowest speed.
    """
    first = follow(forced, first_point(forced, from_rad_s, harmonics), (from_rad_s, to_rad_s), 1.0)
    last = first.points[-1].point
    if last.speed_rad_s >= to_rad_s * (1.0 - 1e-12):
        return (first,)
    try:
        other = first_point(forced, to_rad_s, harmonics)
    except AnalysisError:  # the first branch remains
        return (first,)
    return first, follow(forced, other, (from_rad_s, to_rad_s), -1.0)


def first_point(forced: ForcedSystem, speed_rad_s: float, harmonics: int) -> Point:
    """Return a motion at a speed, the loads raised from none if needed.

    Raises AnalysisError if none is found.
    """
    share, step = 0.0, 1.0
    motion = np.zeros((2 * harmonics + 1, forced.width))
    while step >= _LEAST_SHARE:
        tried = min(1.0, share + step)
        part = replace(
            forced,
            turning_kg_m=tried * forced.turning_kg_m,
            steady_n=tried * forced.steady_n,
        )
        found = at_speed(part, motion, speed_rad_s)
        if found is None:
            step *= 0.5
            continue
        share, motion, step = tried, found.motion_m, 2.0 * step
        if share == 1.0:
            return found
    raise AnalysisError(
        f"no steady motion is found at {speed_rad_s * RPM_PER_RAD_S:.6g} rpm; from "
        f"{share:.3g} of the loads on there is none nearby"
    )


def follow(
    forced: ForcedSystem, start: Point, ends_rad_s: tuple[float, float], sense: float
) -> Branch:
    """Follow a branch until its speed leaves a range, it closes, or it joins one of fewer turns.

    `sense`: 1 or −1 as the speed rises or falls at first.
    """
    low, high = ends_rad_s
    here = _tangent(start, np.zeros(start.motion_m.size), sense, _scale([start], ends_rad_s))
    points, step = [here], _FIRST
    while len(points) < _MOST_POINTS:
        scale = _scale([p.point for p in points], ends_rad_s)
        ahead = _step(forced, here, step, scale)
        if ahead is None or _cosine(here, ahead, scale) < _TURN:
            step *= _SHRUNK
            if step >= _SHORTEST:
                continue
            ahead = _round_corner(forced, here, scale)
            if ahead is None:
                return Branch(tuple(points), False)
            if here.along_speed * ahead.along_speed < 0.0:
                points[-1] = here = replace(here, is_turning=True)
            step = _FIRST
        if not low <= ahead.point.speed_rad_s <= high:
            end = high if ahead.point.speed_rad_s > high else low
            last = at_speed(forced, ahead.point.motion_m, end)
            if last is None:
                step *= _SHRUNK
                continue
            way = here.along_motion, here.along_speed
            return Branch((*points, _tangent(last, *way, scale)), True)
        if _joins(points[0], here, ahead, forced.period_multiple):
            return Branch(tuple(points), True)
        if here.along_speed * ahead.along_speed < 0.0 and not here.is_turning:
            turning = _turning_point(forced, here, ahead, step, scale)
            points += [] if turning is None else [turning]
        if len(points) > _FEWEST and _passes(points[0], here, ahead, scale):
            return Branch((*points, points[0]), True, True)
        points.append(ahead)
        here = ahead
        if ahead.point.corrections <= _FEW:
            step = min(_GROWN * step, _LONGEST)
        elif ahead.point.corrections >= _MANY:
            step *= _SHRUNK
    return Branch(tuple(points), False)


def _passes(start: BranchPoint, here: BranchPoint, ahead: BranchPoint, scale: _Scale) -> bool:
    """Whether the beginning of a branch lies between two motions that follow each other."""

    def away(first: BranchPoint, last: BranchPoint) -> FloatArray:
        motion = (last.point.motion_m - first.point.motion_m).ravel() / scale.length_m
        faster = (last.point.speed_rad_s - first.point.speed_rad_s) / scale.speed_rad_s
        return np.append(motion, faster)

    chord, to_start = away(here, ahead), away(here, start)
    share = float(chord @ to_start / (chord @ chord))
    if not 0.0 <= share <= 1.0 or _cosine(start, ahead, scale) < _TURN:
        return False
    return bool(la.norm(to_start - share * chord) <= _BESIDE * la.norm(chord))


def _joins(start: BranchPoint, here: BranchPoint, ahead: BranchPoint, turns: int) -> bool:
    """Whether a motion of several turns passes one of a single turn, or has become it."""
    if turns == 1:
        return False
    sizes = [_of_several(p.point, turns) for p in (start, here, ahead)]
    return bool(sizes[1] @ sizes[2] < 0.0 or la.norm(sizes[2]) < _GONE * la.norm(sizes[0]))


def _of_several(point: Point, turns: int) -> FloatArray:
    """Return the coefficients that a motion of one turn has not."""
    order = (np.arange(len(point.motion_m)) + 1) // 2
    return np.asarray(point.motion_m[order % turns != 0].ravel())


def _scale(points: list[Point], ends_rad_s: tuple[float, float]) -> _Scale:
    largest = max(float(np.abs(p.motion_m).max()) for p in points)
    return _Scale(max(largest, 1e-12), ends_rad_s[1] - ends_rad_s[0])


def _tangent(point: Point, along: FloatArray, along_speed: float, scale: _Scale) -> BranchPoint:
    """Return a point with its tangent of unit length, in the sense of another one."""
    row = np.append(along / scale.length_m, along_speed / scale.speed_rad_s)
    whole = np.block(
        [
            [point.balance.by_motion * scale.length_m,
             scale.speed_rad_s * point.balance.by_speed[:, None]],
        ]
    )  # fmt: skip
    # the direction that leaves all in balance, whichever way the branch turns
    way = la.svd(whole / scale.length_m)[2][-1]
    if way @ row < 0.0:
        way = -way
    return BranchPoint(
        point=point,
        along_motion=scale.length_m * way[:-1],
        along_speed=float(scale.speed_rad_s * way[-1]),
    )


def _step(
    forced: ForcedSystem, here: BranchPoint, length: float, scale: _Scale
) -> BranchPoint | None:
    """Return the motion a length ahead of one, None if it is not found."""
    along, faster = here.along_motion, here.along_speed
    size = np.hypot(la.norm(along) / scale.length_m, faster / scale.speed_rad_s)
    along, faster = along / size, faster / size
    motion = here.point.motion_m
    guess = motion + length * along.reshape(motion.shape), here.point.speed_rad_s + length * faster
    if not guess[1] > 0.0:
        return None
    row = along / scale.length_m**2, faster / scale.speed_rad_s**2
    found = corrected(forced, guess, row, scale.length_m)
    return None if found is None else _tangent(found, along, faster, scale)


def _round_corner(forced: ForcedSystem, here: BranchPoint, scale: _Scale) -> BranchPoint | None:
    """Return a motion behind a corner just ahead, None if there is none.

    Its tangent there is that of the equations beyond the corner, in whichever sense they hold.
    """
    motion = here.point.motion_m
    over = here.point.motion_m + _CORNER * here.along_motion.reshape(motion.shape)
    speed = here.point.speed_rad_s + _CORNER * here.along_speed
    beyond = Point(over, speed, balance(forced, over, speed), 0)
    if not np.isfinite(beyond.balance.residual_m).all():
        return None
    next_way = _tangent(beyond, here.along_motion, here.along_speed, scale)
    for sense in (1.0, -1.0):
        along, faster = sense * next_way.along_motion, sense * next_way.along_speed
        way = replace(here, along_motion=along, along_speed=faster)
        found = _step(forced, way, _CORNER, scale)
        if found is None or _cosine(way, found, scale) < _TURN:
            continue
        if abs(_cosine(here, found, scale)) < _TURN:
            return found
    return None


def _cosine(here: BranchPoint, ahead: BranchPoint, scale: _Scale) -> float:
    rows = [
        np.append(p.along_motion / scale.length_m, p.along_speed / scale.speed_rad_s)
        for p in (here, ahead)
    ]
    return float(rows[0] @ rows[1] / (la.norm(rows[0]) * la.norm(rows[1])))


def _turning_point(
    forced: ForcedSystem, here: BranchPoint, ahead: BranchPoint, length: float, scale: _Scale
) -> BranchPoint | None:
    """Return where the speed turns between two motions, None where it does so too sharply."""
    best: BranchPoint | None = None

    def along_speed(part: float) -> float:
        nonlocal best
        if part in (0.0, length):
            return (here if part == 0.0 else ahead).along_speed / scale.speed_rad_s
        found = _step(forced, here, part, scale)
        if found is None:
            raise ArithmeticError
        if best is None or abs(found.along_speed) < abs(best.along_speed):
            best = found
        return found.along_speed / scale.speed_rad_s

    try:
        scipy.optimize.brentq(
            along_speed, 0.0, length, xtol=1e-3 * _TURNED * length, maxiter=60, disp=False
        )
    except ArithmeticError:
        return None
    return None if best is None else replace(best, is_turning=True)
