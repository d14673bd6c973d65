"""Branches that reach neither end of the speeds, and motions that repeat after several turns.

Motions that many starts settle to in time are corrected by harmonic balance; those on no known
branch are followed both ways. Only a branch with a stable part can be found so.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.nonlinear.continuation import Branch, follow
from solidwhirl.rotordyn.nonlinear.forced_system import ForcedSystem
from solidwhirl.rotordyn.nonlinear.harmonic_balance import (
    Point,
    as_complex,
    as_real,
    at_speed,
    with_harmonics,
)
from solidwhirl.rotordyn.nonlinear.in_time import settled
from solidwhirl.rotordyn.nonlinear.stability import SmallMotions

# Speeds at which motions are started, how far out beside the known motion, and how many each.
_SPEEDS, _SIZES, _EACH = 12, (1.0, 3.0, 10.0), 4
# Harmonics other than those of fewer turns below this part of a motion are none.
_SOME = 1e-3
# Motions that differ by less than this part are one.
_SAME = 1e-2


def sought_branches(
    small: SmallMotions, ends_rad_s: tuple[float, float], known: Sequence[Branch], harmonics: int
) -> tuple[Branch, ...]:
    """Return branches that are not among known ones, of the `period_multiple` of the system.

    `small`: shapes in which motions run; `known`: branches of one turn; `harmonics`: of the base
    frequency, that of the period.
    """
    turns, forced = small.forced.period_multiple, small.forced
    every = list(known) if turns == 1 else []
    found: list[Branch] = []
    for point in _starts(small, ends_rad_s, known, harmonics):
        if repeats_earlier(point.motion_m, turns):
            continue
        if any(_is_on(branch, point, turns) for branch in every):
            continue
        branch = through(forced, point, ends_rad_s)
        every.append(branch)
        found.append(branch)
    return tuple(found)


def through(forced: ForcedSystem, point: Point, ends_rad_s: tuple[float, float]) -> Branch:
    """Follow the branch through a motion both ways."""
    first = follow(forced, point, ends_rad_s, 1.0)
    if first.is_closed:
        return first
    second = follow(forced, point, ends_rad_s, -1.0)
    points = (*second.points[:0:-1], *first.points)
    return Branch(points, first.is_whole and second.is_whole)


def repeats_earlier(motion_m: FloatArray, turns: int) -> bool:
    """Tell whether a motion repeats after fewer turns than those of its period."""
    size = np.abs(as_complex(motion_m)).max(axis=1)
    order = np.arange(size.size)
    return any(
        size[order % divisor != 0].max() <= _SOME * size[1:].max()
        for divisor in range(2, turns + 1)
        if turns % divisor == 0
    )


def _starts(
    small: SmallMotions, ends: tuple[float, float], known: Sequence[Branch], harmonics: int
) -> Iterator[Point]:
    """Yield motions in balance that starts at several speeds settle to."""
    speeds = ends[0] + (np.arange(_SPEEDS) + 0.5) / _SPEEDS * (ends[1] - ends[0])
    points = [p.point for branch in known for p in branch.points]
    at = np.array([p.speed_rad_s for p in points])
    size = np.array([float(np.abs(p.motion_m).max()) for p in points])
    near = [float(size[np.argmin(np.abs(at - speed))]) for speed in speeds]
    sizes = np.repeat(np.outer(near, _SIZES), _EACH, axis=1)
    each = np.repeat(speeds, sizes.shape[1])
    motions = settled(small, each, sizes.ravel(), harmonics)
    for speed, motion in zip(each.tolist(), motions, strict=True):
        if np.isfinite(motion).all():
            found = at_speed(small.forced, motion, speed)
            if found is not None:
                yield found


def _is_on(branch: Branch, point: Point, turns: int) -> bool:
    """Whether a motion, or the same some turns later, is on a branch."""
    speeds = np.array([p.point.speed_rad_s for p in branch.points])
    above = speeds > point.speed_rad_s
    for k in np.flatnonzero(above[1:] != above[:-1]):
        share = (point.speed_rad_s - speeds[k]) / (speeds[k + 1] - speeds[k])
        first, last = (branch.points[j].point.motion_m for j in (k, k + 1))
        motion = with_harmonics(first + share * (last - first), len(point.motion_m) // 2)
        if any(
            la.norm(one - point.motion_m) <= _SAME * la.norm(motion)
            for one in _later(motion, turns)
        ):
            return True
    return False


def _later(motion_m: FloatArray, turns: int) -> Iterator[FloatArray]:
    """Yield a motion begun so many turns of the unbalance later."""
    amplitudes = as_complex(motion_m)
    order = np.arange(len(amplitudes))
    for turn in range(turns):
        yield as_real(amplitudes * np.exp(2j * np.pi * order * turn / turns)[:, None])


def refined(
    forced: ForcedSystem, branch: Branch, ends_rad_s: tuple[float, float], harmonics: int
) -> Branch | None:
    """Follow a branch again with more harmonics, from a motion amid it; None if that is lost."""
    for at in (len(branch.points) // 2, len(branch.points) // 4, 3 * len(branch.points) // 4):
        point = branch.points[at].point
        found = at_speed(forced, with_harmonics(point.motion_m, harmonics), point.speed_rad_s)
        if found is not None and not repeats_earlier(found.motion_m, forced.period_multiple):
            return through(forced, found, ends_rad_s)
    return None


def of_period(small: SmallMotions, turns: int) -> SmallMotions:
    """Return the same shapes for motions that repeat after so many turns."""
    return replace(small, forced=small.forced.repeating_after(turns))
