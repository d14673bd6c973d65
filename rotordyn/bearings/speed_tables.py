"""Coefficients of a bearing over the speed as rows, close enough for interpolation."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError

# Rows to begin with, and rounds of putting new ones between them.
_FIRST, _ROUNDS = 9, 12
# What is found at quarters of the way is kept to this fraction of what is promised.
_SAFETY = 0.5


class SpeedTable(NamedTuple):
    """Coefficients at speeds.

    `speeds_rad_s`: rising, shape (s,); `stiffness_n_per_m`, `damping_n_s_per_m`: on (ux, uy), shape
    (s, 2, 2); `interpolation`: what is meant between the rows, see `TableLaw`.
    """

    speeds_rad_s: FloatArray
    stiffness_n_per_m: FloatArray
    damping_n_s_per_m: FloatArray
    interpolation: str = "monotone"


def tabulate(
    coefficients: Callable[[float], tuple[FloatArray, FloatArray]],
    lowest_rad_s: float,
    highest_rad_s: float,
    tolerance: float = 1e-4,
) -> SpeedTable:
    """Return a table whose monotone interpolation misses by less than a tolerance.

    `coefficients`: stiffness and damping, (2, 2) each, at a speed; `tolerance`: of the largest
    entry of each matrix at the speed; half of it is kept at all quarters of the way between rows.
    Raises AnalysisError if the range is empty or no table of some thousand rows is close enough.
    """
    if not 0 <= lowest_rad_s < highest_rad_s < np.inf:
        raise AnalysisError(
            f"speeds from {lowest_rad_s:g} to {highest_rad_s:g} rad/s; needed is 0 <= low < high"
        )
    from scipy.interpolate import PchipInterpolator  # tables that are given need none

    speeds = np.linspace(lowest_rad_s, highest_rad_s, _FIRST)
    if lowest_rad_s > 0:
        speeds = np.geomspace(lowest_rad_s, highest_rad_s, _FIRST)
    known: dict[float, FloatArray] = {}

    def at(speeds: FloatArray) -> FloatArray:
        """Return coefficients, shape (s, 2, 2, 2), each computed once."""
        for speed in speeds.tolist():
            if speed not in known:
                known[speed] = np.array(coefficients(speed))
        return np.array([known[speed] for speed in speeds.tolist()])

    for _ in range(_ROUNDS):
        rows, good = at(speeds), np.ones(speeds.size - 1, dtype=bool)
        for share in (0.25, 0.5, 0.75):
            between = speeds[:-1] + share * np.diff(speeds)
            exact = at(between)
            miss = np.abs(PchipInterpolator(speeds, rows)(between) - exact).max(axis=(2, 3))
            size = np.abs(exact).max(axis=(2, 3))
            good &= (miss <= _SAFETY * tolerance * size).all(axis=1)
        if good.all():
            return SpeedTable(speeds, rows[:, 0], rows[:, 1])
        middles = 0.5 * (speeds[1:] + speeds[:-1])[~good]
        speeds = np.sort(np.concatenate((speeds, middles)))
    raise AnalysisError(f"no table of {speeds.size} rows is as close as {tolerance:g}")
