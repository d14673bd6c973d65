"""Critical speeds with damping: where branches that are followed from rest meet Im λ = αΩ."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.campbell.branches import all_below, follow
from solidwhirl.rotordyn.campbell.continued import continued, turning_point
from solidwhirl.rotordyn.campbell.matching import Tracked, match_modes
from solidwhirl.rotordyn.core.arrays import ComplexArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.critical_speeds.refined import Meeting
from solidwhirl.rotordyn.critical_speeds.undamped import undamped_places
from solidwhirl.rotordyn.modes.damping import CREEPING, damping_ratio
from solidwhirl.rotordyn.modes.eigen import Modes, mode_columns, modes_at_speed

# Steps of the search for a damped critical speed, and its relative accuracy.
_ROOT_STEPS = 80
_ROOT_ACCURACY = 1e-12
# Farther from the line, relative, nothing has met it.
_ON_LINE = 1e-6
# A motion that begins below this fraction of the largest speed may begin at rest.
_AT_REST = 1e-6


def followed_to_the_line(assembled: AssembledSystem, ratio: float, limit: float) -> list[Meeting]:
    """Return where branches that are followed from rest meet Im λ(Ω) = αΩ.

    `ratio`, `limit`: |α| and the largest Ω.
    """
    seeds = undamped_places(assembled, ratio, limit)
    inner = np.concatenate((seeds, assembled.knots_rad_s))
    marks = np.unique(np.concatenate(([0.0], inner[(inner > 0) & (inner < limit)], [limit])))
    marks = marks[np.concatenate(([True], np.diff(marks) > 1e-6 * limit))]
    speeds = np.unique(np.concatenate((marks, 0.5 * (marks[1:] + marks[:-1]), [limit])))
    at_speeds = follow(assembled, speeds, all_below(assembled, ratio * limit / (2.0 * np.pi)))
    return _meetings(assembled, at_speeds, ratio)


def _meetings(
    assembled: AssembledSystem, at_speeds: Sequence[Tracked], ratio: float
) -> list[Meeting]:
    """Return where branches meet the line."""
    found, least = [], _AT_REST * max(abs(at_speed.modes.speed_rad_s) for at_speed in at_speeds)
    for before, after in pairwise(at_speeds):
        for branch in range(before.columns.size):
            ends = _ends(assembled, before, after, branch, least)
            if ends is not None:
                miss = [_miss(modes, ratio) for modes in ends]
                if miss[0] > 0 >= miss[1] or miss[0] < 0 <= miss[1]:
                    found.append(_solve_on_branch(assembled, *ends, ratio))
    return [m for m in found if m is not None and not _creeps(np.array([m.value]))]


def _creeps(values: ComplexArray) -> bool:
    return bool((damping_ratio(values) > CREEPING).all())


def _ends(
    assembled: AssembledSystem, before: Tracked, after: Tracked, branch: int, least: float
) -> tuple[Modes, Modes] | None:
    """Return one branch at two speeds, or from where it begins or to where it ends in between.

    `least`: what begins below that speed is not told from what the spin lifts from rest. None for
    what creeps at both.
    """
    sides = [
        mode_columns(at_speed.modes, at_speed.columns[[branch]])
        if at_speed.columns[branch] >= 0
        else None
        for at_speed in (before, after)
    ]
    low, high = sides
    if all(side is None or _creeps(side.eigenvalues) for side in sides):
        return None
    if low is not None and high is not None:
        return low, high
    begin, end = before.modes.speed_rad_s, after.modes.speed_rad_s
    pairs = before.modes.real_eigenvalues.size - after.modes.real_eigenvalues.size
    if end <= least:
        return None
    if high is not None and pairs > 0:
        return turning_point(assembled, high, begin), high
    return (low, turning_point(assembled, low, end)) if low is not None and pairs < 0 else None


def _miss(mode: Modes, ratio: float) -> float:
    return float(mode.eigenvalues[0].imag - ratio * mode.speed_rad_s)


def _solve_on_branch(
    assembled: AssembledSystem, low: Modes, high: Modes, ratio: float
) -> Meeting | None:
    """Return Ω, λ and φ where a branch meets the line between two speeds (Illinois method).

    None for an overdamped motion that ceases to oscillate on the way, and for two branches that
    were taken for one: these close in on a jump across the line.
    """
    miss_low, miss_high = _miss(low, ratio), _miss(high, ratio)
    nearest = low
    for _ in range(_ROOT_STEPS):
        begin, end = low.speed_rad_s, high.speed_rad_s
        speed = begin - miss_low * (end - begin) / (miss_high - miss_low)
        found = continued(assembled, low, high, speed)
        found = found or _in_the_whole_spectrum(assembled, low, high, speed)
        if found is None:
            return None
        nearest, miss = found, _miss(found, ratio)
        if abs(miss) <= _ROOT_ACCURACY * ratio * speed or abs(end - begin) <= 1e-14 * end:
            break
        if miss * miss_high < 0:
            low, miss_low = high, miss_high
        else:
            miss_low *= 0.5
        high, miss_high = nearest, miss
    if abs(_miss(nearest, ratio)) > _ON_LINE * ratio * nearest.speed_rad_s:
        return None
    return Meeting(nearest.speed_rad_s, complex(nearest.eigenvalues[0]), nearest.shapes[:, 0])


def _in_the_whole_spectrum(
    assembled: AssembledSystem, low: Modes, high: Modes, speed: float
) -> Modes | None:
    """Return one branch at a speed between two, from the nearer one."""
    distances = [abs(modes.speed_rad_s - speed) for modes in (low, high)]
    here = low if distances[0] <= distances[1] else high
    match = match_modes(assembled, here, modes_at_speed(assembled, speed))
    if match.partner[0] < 0:
        if _creeps(here.eigenvalues):
            return None
        raise AnalysisError(
            f"the branch at {here.speed_rad_s:.6g} rad/s has no partner at {speed:.6g} rad/s"
        )
    return mode_columns(match.second, match.partner)
