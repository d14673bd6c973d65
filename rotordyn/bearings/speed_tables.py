"""Coefficients of a bearing over the speed as rows, close enough for interpolation."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S

# Rows to begin with, and how narrow steps between rows may be, as a part of all speeds.
_FIRST, _NARROWEST = 9, 1e-7
# How many times as long as a step the one beside it may be.
_UNLIKE = 3.0
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


class Rows(NamedTuple):
    """Values at speeds, (s, n), and what an error of each is measured by, likewise."""

    values: FloatArray
    sizes: FloatArray


def tabulate(
    coefficients: Callable[[float], tuple[FloatArray, FloatArray]],
    lowest_rad_s: float,
    highest_rad_s: float,
    tolerance: float = 1e-4,
) -> SpeedTable:
    """Return a table whose cubic spline misses by less than a tolerance.

    `coefficients`: stiffness and damping, (2, 2) each, at a speed; `tolerance`: of the largest
    entry of each matrix at the speed. Raises AnalysisError as `close_rows`.
    """

    def rows(speeds: FloatArray) -> Rows:
        found = np.array([coefficients(speed) for speed in speeds.tolist()])
        sizes = np.broadcast_to(np.abs(found).max(axis=(2, 3), keepdims=True), found.shape)
        return Rows(found.reshape(speeds.size, 8), sizes.reshape(speeds.size, 8))

    speeds, found = close_rows(rows, lowest_rad_s, highest_rad_s, tolerance)
    matrices = found.values.reshape(-1, 2, 2, 2)
    return SpeedTable(speeds, matrices[:, 0], matrices[:, 1], "cubic")


def close_rows(
    rows: Callable[[FloatArray], Rows],
    lowest_rad_s: float,
    highest_rad_s: float,
    tolerance: float,
) -> tuple[FloatArray, Rows]:
    """Return speeds and rows there whose cubic spline misses by less than a tolerance.

    `rows`: at speeds (s,); `tolerance`: of the size of each value; half of it is kept at all
    quarters of the way between rows. Steps are halved where they miss, so that rows are dense about
    a corner, as where elements lose contact, and beside much shorter ones. Raises AnalysisError if
    the range is empty, or where values leap.
    """
    if not 0 <= lowest_rad_s < highest_rad_s < np.inf:
        raise AnalysisError(
            f"speeds from {lowest_rad_s:g} to {highest_rad_s:g} rad/s; needed is 0 <= low < high"
        )
    from scipy.interpolate import CubicSpline  # tables that are given need none

    speeds = np.linspace(lowest_rad_s, highest_rad_s, _FIRST)
    if lowest_rad_s > 0:
        speeds = np.geomspace(lowest_rad_s, highest_rad_s, _FIRST)
    known: dict[float, tuple[FloatArray, FloatArray]] = {}

    def at(speeds: FloatArray) -> Rows:
        """Return rows, each computed once."""
        new = np.array([speed for speed in np.unique(speeds).tolist() if speed not in known])
        if new.size:
            known.update(zip(new.tolist(), zip(*rows(new), strict=True), strict=True))
        found = [known[speed] for speed in speeds.ravel().tolist()]
        return Rows(
            *(np.array(part).reshape(*speeds.shape, -1) for part in zip(*found, strict=True))
        )

    quarters = np.array([[0.25], [0.5], [0.75]])
    while True:
        step = np.diff(speeds)
        exact = at(speeds[:-1] + quarters * step)
        between = CubicSpline(speeds, at(speeds).values)(speeds[:-1] + quarters * step)
        miss = np.abs(between - exact.values) > _SAFETY * tolerance * exact.sizes
        bad = miss.any(axis=(0, 2))
        if not bad.any():
            return speeds, at(speeds)
        if step[bad].min() < _NARROWEST * highest_rad_s:
            where = speeds[:-1][bad][np.argmin(step[bad])] * RPM_PER_RAD_S
            raise AnalysisError(
                f"at {where:.6g} rpm stiffness or damping leap, as where the last balls beside one "
                f"lose contact; no table follows to {tolerance:g}; end the speeds below, or load "
                "the bearing more"
            )
        # a step much longer than one beside it, or than one that is halved, makes a poor spline
        shorter = np.where(bad, 0.5 * step, step)
        beside = np.minimum(np.append(shorter[1:], np.inf), np.append(np.inf, shorter[:-1]))
        halved = bad | (step > _UNLIKE * beside)
        speeds = np.sort(np.concatenate((speeds, (0.5 * (speeds[1:] + speeds[:-1]))[halved])))
