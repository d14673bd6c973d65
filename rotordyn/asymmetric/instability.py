"""Ranges of speed in which a periodic system is unstable, by harmonics added until they stay."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from solidwhirl.rotordyn.asymmetric.floquet import floquet_multipliers
from solidwhirl.rotordyn.asymmetric.hill import hill_block
from solidwhirl.rotordyn.asymmetric.periodic import PeriodicSystem
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.stability.eigenvalue_paths import prepared
from solidwhirl.rotordyn.stability.unstable_windows import Window, unstable_windows

# Harmonics to begin with, and at most.
_FIRST, _MOST = 2, 8
# A motion that turns slower than this part of its rate stands still.
_STILL = 1e-6
# Part of the width of a range by which its ends may still move when a harmonic is added.
_STAYS = 1e-6


@dataclass(frozen=True, kw_only=True, slots=True)
class UnstableRange:
    """Hold a range of speeds in which some motion grows.

    `low_rad_s`, `high_rad_s`: its ends; `opens`, `closes`: whether growth begins and ends there, or
    the range that was searched does. `growth_1_s`: largest growth, at `speed_rad_s`; `floquet_1_s`:
    the same by the multipliers of a period, which share nothing with Hill's method but the
    matrices. `frequency_rad_s`: of that motion in the frame of the body, up to whole strides of the
    speed: between 0 and half a stride; 0: it stands still in the body (divergence). `error_rad_s`:
    how far the last harmonic moved the ends.
    """

    low_rad_s: float
    high_rad_s: float
    opens: bool
    closes: bool
    growth_1_s: float
    speed_rad_s: float
    floquet_1_s: float
    frequency_rad_s: float
    kind: Literal["flutter", "divergence"]
    error_rad_s: float


def unstable_ranges(
    system: PeriodicSystem,
    speed_low_rad_s: float,
    speed_high_rad_s: float,
    narrowest: float = 1e-4,
) -> tuple[UnstableRange, ...]:
    """Find all ranges of speed in which some motion grows.

    `narrowest`: width of a range that is looked for, as a part of all speeds. Harmonics are added
    until no range appears, vanishes or moves. Raises AnalysisError: speeds that are not positive
    and rising, or that takes too many harmonics.
    """
    if not 0.0 < speed_low_rad_s < speed_high_rad_s < np.inf:
        raise AnalysisError(
            f"speeds are {speed_low_rad_s} to {speed_high_rad_s}; both are above 0 and rise"
        )
    width = narrowest * (speed_high_rad_s - speed_low_rad_s)
    own = system.at(0.0)[1].get(0, np.zeros_like(system.mass))
    rate = float((np.diag(own) / np.diag(system.mass)).max())

    def windows(order: int) -> list[Window]:
        block = prepared(hill_block(system, order), rate, speed_low_rad_s, speed_high_rad_s)
        found = unstable_windows(block, (), speed_low_rad_s, speed_high_rad_s, 0.5 * width)
        return [w for w in found if w.high - w.low > width]

    if not system.stride:
        return tuple(_range(system, w, 0.0) for w in windows(0))
    before = windows(_FIRST)
    for order in range(_FIRST + 1, _MOST + 1):
        after = windows(order)
        moved = _moved(before, after)
        if moved is not None:
            return tuple(_range(system, w, m) for w, m in zip(after, moved, strict=True))
        before = after
    raise AnalysisError(
        f"the unstable ranges still move with {_MOST} harmonics; search a smaller range of speeds"
    )


def _moved(before: list[Window], after: list[Window]) -> list[float] | None:
    """How far the ends of every range moved; None: one appeared, vanished or moved too far."""
    if len(before) != len(after):
        return None
    moved = [max(abs(a.low - b.low), abs(a.high - b.high))
             for a, b in zip(after, before, strict=True)]  # fmt: skip
    stays = (m <= _STAYS * (w.high - w.low) for m, w in zip(moved, after, strict=True))
    return moved if all(stays) else None


def _range(system: PeriodicSystem, window: Window, moved: float) -> UnstableRange:
    known = floquet_multipliers(system, window.top_speed)
    beat, turning = system.stride * window.top_speed, abs(window.top.imag)
    if beat:
        turning = abs((turning + 0.5 * beat) % beat - 0.5 * beat)
    still = turning <= _STILL * abs(window.top)
    return UnstableRange(
        low_rad_s=window.low,
        high_rad_s=window.high,
        opens=window.opens,
        closes=window.closes,
        growth_1_s=window.top.real,
        speed_rad_s=window.top_speed,
        floquet_1_s=known.growth_1_s,
        frequency_rad_s=0.0 if still else turning,
        kind="divergence" if still else "flutter",
        error_rad_s=moved,
    )
