"""Unstable ranges of systems whose bearings depend on the frequency, by many spectra."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import scipy

from solidwhirl.rotordyn.assembly.system import AssembledSystem, at_rate
from solidwhirl.rotordyn.core.arrays import ComplexArray
from solidwhirl.rotordyn.modes.damping import NEUTRAL
from solidwhirl.rotordyn.modes.eigen import Modes, modes_at_speed
from solidwhirl.rotordyn.modes.frequency_dependent import modes_near
from solidwhirl.rotordyn.stability.eigenvalue_paths import blocks_of
from solidwhirl.rotordyn.stability.unstable_windows import Window, unstable_windows

# Speeds that are looked at besides the knots of laws.
_SPEEDS = 65
# Steps for an end of a range, and its relative accuracy.
_STEPS, _ACCURACY = 60, 1e-11


class _Motion:
    """The oscillation that grows most, or decays least, at a speed."""

    def __init__(self, speed: float, value: complex, shape: ComplexArray) -> None:
        self.speed, self.value, self.shape = speed, value, shape

    @property
    def growth(self) -> float:
        """Re λ above what counts as neutral, over |λ|."""
        return float(self.value.real / abs(self.value)) - NEUTRAL

    def near(self, assembled: AssembledSystem, speed: float) -> _Motion:
        """Return the same motion at a speed nearby, or the one that grows most there."""
        found = None
        if self.shape.size:
            found = modes_near(assembled, speed)(self.value, self.shape[:, None])
        if found is None:
            return _most_growing(modes_at_speed(assembled, speed))
        return _Motion(speed, complex(found[0][0]), found[1][:, 0])


def sampled_windows(assembled: AssembledSystem, low: float, high: float) -> list[Window]:
    """Find the ranges of speeds in which a motion of the system grows.

    `low`, `high`: range of Ω, rad/s. All modes at 65 speeds and the knots of the laws tell where
    one grows; ends and the largest growth are solved for on that mode. A range that lies between
    two of these speeds is not seen. What diverges does so with the bearings as they are for slow
    motions.
    """
    inner = [knot for knot in assembled.knots_rad_s if low < knot < high]
    speeds = np.unique(np.concatenate((np.linspace(low, high, _SPEEDS), inner)))
    motions = [_most_growing(modes_at_speed(assembled, float(speed))) for speed in speeds]
    windows = _oscillating(assembled, motions)
    still = at_rate(assembled, 0j)
    for block in blocks_of(still, low, high):
        found = unstable_windows(block, still.knots_rad_s, low, high)
        windows += [window for window in found if window.onset.imag == 0.0]
    return windows


def _most_growing(modes: Modes) -> _Motion:
    values = modes.eigenvalues
    if not values.size:
        return _Motion(modes.speed_rad_s, -1.0 + 0j, np.zeros(0, dtype=complex))
    at = int(np.argmax(values.real / np.abs(values)))
    return _Motion(modes.speed_rad_s, complex(values[at]), modes.shapes[:, at])


def _oscillating(assembled: AssembledSystem, motions: Sequence[_Motion]) -> list[Window]:
    """Return the ranges in which an oscillation grows at one of the speeds."""
    windows: list[Window] = []
    inside: list[_Motion] = []
    for place, motion in enumerate(motions):
        if motion.growth <= 0.0:
            continue
        if place == 0 or motions[place - 1].growth <= 0.0:
            inside = [] if place == 0 else [_border(assembled, motion, motions[place - 1].speed)]
        inside.append(motion)
        last = place == len(motions) - 1
        if last or motions[place + 1].growth <= 0.0:
            if not last:
                inside.append(_border(assembled, motion, motions[place + 1].speed))
            windows.append(_window(assembled, inside, inside[0] is not motions[0], not last))
    return windows


def _border(assembled: AssembledSystem, growing: _Motion, calm_rad_s: float) -> _Motion:
    """Return where a motion ceases to grow on the way to a speed at which none does (Illinois)."""
    calm = growing.near(assembled, calm_rad_s)
    if calm.growth > 0.0:  # another motion was found
        calm = _most_growing(modes_at_speed(assembled, calm_rad_s))
    sides, weights = [growing, calm], [growing.growth, calm.growth]
    found = growing
    for _ in range(_STEPS):
        begin, end = (side.speed for side in sides)
        speed = begin - weights[0] * (end - begin) / (weights[1] - weights[0])
        found = min(sides, key=lambda side: abs(side.speed - speed)).near(assembled, speed)
        if abs(found.growth) <= _ACCURACY or abs(end - begin) <= 1e-13 * max(abs(begin), abs(end)):
            break
        at = 0 if found.growth > 0.0 else 1
        sides[at], weights[at] = found, found.growth
        weights[1 - at] *= 0.5
    return found


def _window(
    assembled: AssembledSystem, inside: Sequence[_Motion], opens: bool, closes: bool
) -> Window:
    at = int(np.argmax([motion.value.real for motion in inside]))
    top = inside[at]
    for first, last in pairwise(inside[max(0, at - 1) : at + 2]):
        found = scipy.optimize.minimize_scalar(
            lambda speed, near=top: -near.near(assembled, float(speed)).value.real,
            bounds=(first.speed, last.speed),
            method="bounded",
            options={"xatol": 1e-6 * abs(last.speed - first.speed)},
        )
        if -found.fun > top.value.real:
            top = top.near(assembled, float(found.x))
    return Window(
        low=inside[0].speed,
        high=inside[-1].speed,
        opens=opens,
        closes=closes,
        onset=inside[0].value,
        end=inside[-1].value,
        top=top.value,
        top_speed=top.speed,
    )
