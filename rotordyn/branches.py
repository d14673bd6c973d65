"""Which branches are followed: the lowest ones, or all that come below a frequency."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.system import AssembledSystem
from solidwhirl.rotordyn.tracking import Front, Tracker


def follow_lowest(
    assembled: AssembledSystem, speeds_rad_s: FloatArray, branch_count: int
) -> list[Front]:
    """Follow the lowest branches of the first speed, computing more modes where one gets lost.

    Parameters
    ----------
    assembled
        The system.
    speeds_rad_s
        Monotonic, shape (s,).
    branch_count
        Number of branches.

    Returns
    -------
    list of Front
        At the speeds given and at those added.
    """
    mode_count = min(assembled.size, 2 * branch_count + 12)
    while True:
        fronts = Tracker(assembled, mode_count).follow(speeds_rad_s, branch_count)
        if (fronts[-1].columns >= 0).all() or mode_count == assembled.size:
            return fronts
        mode_count = min(assembled.size, 2 * mode_count)


def follow_below(
    assembled: AssembledSystem, speeds_rad_s: FloatArray, frequency_max_hz: float
) -> list[Front]:
    """Follow all branches that come below a frequency, those that enter from above as well.

    Parameters
    ----------
    assembled
        The system.
    speeds_rad_s
        Monotonic, shape (s,).
    frequency_max_hz
        The limit, Hz.

    Returns
    -------
    list of Front
        At the speeds given and at those added; branches that never come below are left out.
    """
    everything = Tracker(assembled, assembled.size)
    below = [
        int(np.count_nonzero(everything.modes_at(float(v)).frequency_hz <= frequency_max_hz))
        for v in speeds_rad_s
    ]
    available = everything.modes_at(float(speeds_rad_s[0])).eigenvalues.size
    fronts = everything.follow(speeds_rad_s, min(max(1, *below), available))
    if untracked_below(fronts, frequency_max_hz):
        # Branches from higher up come down: follow twice as many.
        fronts = everything.follow(speeds_rad_s, min(2 * max(1, *below) + 8, available))
    omega = np.array([front.values().imag for front in fronts])
    kept = np.flatnonzero((omega <= 2.0 * np.pi * frequency_max_hz).any(axis=0))
    return [front.select(kept) for front in fronts]


def untracked_below(fronts: Sequence[Front], frequency_max_hz: float) -> list[float]:
    """Return the speeds at which a mode below a frequency belongs to no branch.

    Parameters
    ----------
    fronts
        The branches.
    frequency_max_hz
        The limit, Hz.

    Returns
    -------
    list of float
        In rad/s; empty as a rule. A mode that is rigid or overdamped at the first speed has no
        branch.
    """
    speeds = []
    for front in fronts:
        low = np.flatnonzero(front.modes.frequency_hz <= frequency_max_hz)
        if np.setdiff1d(low, front.columns).size:
            speeds.append(front.modes.speed_rad_s)
    return speeds
