"""One critical speed from a guess of it, by modes near it alone."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import ComplexArray
from solidwhirl.rotordyn.modes.nearby import modes_near

# Steps at most for one critical speed, and its relative accuracy.
_STEPS, _ACCURACY = 16, 1e-12


class Meeting(NamedTuple):
    """Ω, λ and φ of a mode that meets the excitation."""

    speed: float
    value: complex
    shape: ComplexArray


class Root(NamedTuple):
    """A meeting, and whether the frequency falls below that of the excitation there."""

    meeting: Meeting
    falls: bool


def refined_root(
    assembled: AssembledSystem, ratio: float, guess: Meeting, farthest: float
) -> Root | None:
    """Solve Im λ(Ω) = αΩ by the secant method, each λ from the one before.

    `ratio`: |α|; `guess`: a speed, and a mode about as it is there; `farthest`: how far (relative)
    the root may lie from it. None if it lies further away, the steps do not come to rest, or other
    modes are as near.
    """
    speed, value, shapes = guess.speed, guess.value, guess.shape[:, None].astype(complex)
    before, slope = (np.nan, np.nan), -ratio
    for _ in range(_STEPS):
        found = modes_near(assembled, speed)(value, shapes)
        if found is None:
            return None
        value, shapes = complex(found[0][0]), found[1]
        miss = value.imag - ratio * speed
        if np.isfinite(before[0]) and speed != before[0]:
            slope = (miss - before[1]) / (speed - before[0])
        if abs(miss) <= _ACCURACY * ratio * speed:
            return Root(Meeting(speed, value, shapes[:, 0]), bool(slope < 0))
        if slope == 0.0:
            return None
        before, speed = (speed, miss), speed - miss / slope
        if not abs(speed - guess.speed) < farthest * guess.speed:
            return None
    return None
