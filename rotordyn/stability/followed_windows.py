"""Unstable ranges by branches: of systems whose bearings depend on the frequency of the motion."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.optimize import minimize_scalar

from solidwhirl.rotordyn.assembly.system import AssembledSystem, at_rate
from solidwhirl.rotordyn.campbell.branches import all_below, follow
from solidwhirl.rotordyn.campbell.continued import continued
from solidwhirl.rotordyn.campbell.matching import Tracked, match_modes
from solidwhirl.rotordyn.modes.damping import NEUTRAL
from solidwhirl.rotordyn.modes.eigen import Modes, mode_columns, modes_at_speed
from solidwhirl.rotordyn.stability.eigenvalue_paths import blocks_of
from solidwhirl.rotordyn.stability.unstable_windows import Window, unstable_windows

# Speeds from which branches are followed; more are added where they change.
_SPEEDS = 33
# Steps for an end of a range, and its relative accuracy.
_STEPS, _ACCURACY = 60, 1e-11


def followed_windows(assembled: AssembledSystem, low: float, high: float) -> list[Window]:
    """Find the ranges of speeds in which a motion of the system grows.

    `low`, `high`: range of Ω, rad/s. An oscillation that grows belongs to a branch, which is
    followed through the range; what diverges does so with the bearings as they are for slow
    motions. A range between two neighbouring speeds, where a branch grows at neither, is not seen.
    """
    inner = [knot for knot in assembled.knots_rad_s if low < knot < high]
    speeds = np.unique(np.concatenate((np.linspace(low, high, _SPEEDS), inner)))
    at_speeds = follow(assembled, speeds, all_below(assembled, np.inf))
    at_speeds = [one for one in at_speeds if low <= one.modes.speed_rad_s <= high]
    windows = [
        window
        for branch in range(at_speeds[0].columns.size)
        for window in _of_branch(assembled, at_speeds, branch)
    ]
    still = at_rate(assembled, 0j)
    for block in blocks_of(still, low, high):
        found = unstable_windows(block, still.knots_rad_s, low, high)
        windows += [window for window in found if window.onset.imag == 0.0]
    return windows


def _of_branch(
    assembled: AssembledSystem, at_speeds: Sequence[Tracked], branch: int
) -> list[Window]:
    """Return the ranges in which one branch grows."""
    points = [
        mode_columns(at_speed.modes, at_speed.columns[[branch]])
        if at_speed.columns[branch] >= 0
        else None
        for at_speed in at_speeds
    ]
    windows: list[Window] = []
    inside: list[Modes] = []
    opens = False
    for before, after in pairwise([None, *points, None]):
        was, now = _grows(before), _grows(after)
        if now and not was:
            assert after is not None
            opens = before is not None
            inside = [_border(assembled, before, after)] if before is not None else []
        if now and after is not None:
            inside.append(after)
        if was and not now:
            assert before is not None
            if after is not None:
                inside.append(_border(assembled, before, after))
            windows.append(_window(assembled, inside, opens, after is not None))
    return windows


def _grows(mode: Modes | None) -> bool:
    if mode is None:
        return False
    value = complex(mode.eigenvalues[0])
    return value.real > NEUTRAL * abs(value)


def _at(assembled: AssembledSystem, low: Modes, high: Modes, speed: float) -> Modes:
    """Return a branch at a speed between two."""
    found = continued(assembled, low, high, speed)
    if found is not None:
        return found
    near = low if abs(low.speed_rad_s - speed) <= abs(high.speed_rad_s - speed) else high
    match = match_modes(assembled, near, modes_at_speed(assembled, speed))
    return mode_columns(match.second, match.partner[:1])


def _border(assembled: AssembledSystem, low: Modes, high: Modes) -> Modes:
    """Return where the growth of a branch changes its sign (Illinois method)."""
    growth = [float(mode.eigenvalues[0].real) for mode in (low, high)]
    found = high
    for _ in range(_STEPS):
        begin, end = low.speed_rad_s, high.speed_rad_s
        speed = begin - growth[0] * (end - begin) / (growth[1] - growth[0])
        found = _at(assembled, low, high, speed)
        value = complex(found.eigenvalues[0])
        if abs(value.real) <= _ACCURACY * abs(value) or abs(end - begin) <= 1e-13 * abs(end):
            break
        if value.real * growth[1] < 0:
            low, growth[0] = high, growth[1]
        else:
            growth[0] *= 0.5
        high, growth[1] = found, value.real
    return found


def _window(
    assembled: AssembledSystem, inside: Sequence[Modes], opens: bool, closes: bool
) -> Window:
    values = [complex(mode.eigenvalues[0]) for mode in inside]
    at = int(np.argmax([value.real for value in values]))
    top, speed = values[at], inside[at].speed_rad_s
    for first, last in pairwise(inside[max(0, at - 1) : at + 2]):
        found = minimize_scalar(
            lambda v, a=first, b=last: -_at(assembled, a, b, float(v)).eigenvalues[0].real,
            bounds=(first.speed_rad_s, last.speed_rad_s),
            method="bounded",
            options={"xatol": 1e-6 * abs(last.speed_rad_s - first.speed_rad_s)},
        )
        if -found.fun > top.real:
            there = _at(assembled, first, last, float(found.x))
            top, speed = complex(there.eigenvalues[0]), float(found.x)
    return Window(
        low=inside[0].speed_rad_s,
        high=inside[-1].speed_rad_s,
        opens=opens,
        closes=closes,
        onset=values[0],
        end=values[-1],
        top=top,
        top_speed=speed,
    )
