"""Damping and frequency of the first forward and the first backward mode over the speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import FloatArray, ReadOnlyArrays, together
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modes.damping import PEAKLESS, DampingRule
from solidwhirl.rotordyn.modes.eigen import Modes, modes_at_speed
from solidwhirl.rotordyn.modes.kinds import energy_shares, is_mostly_lateral
from solidwhirl.rotordyn.modes.whirl import interface_orbits

# The sense of whirl at rest is that at this fraction of the highest speed.
_BARELY_TURNING = 1e-6
# Net whirl below this is rounding.
_NO_WHIRL = 1e-9
# Eigenvalues closer than this (relative) are equal.
_EQUAL = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class FirstMode(ReadOnlyArrays):
    """Hold damping and frequency of the first mode of one whirl over the speed.

    `log_decrement`: shape (s,); exactly 0 where it is rounding, nan where there is no such mode;
    `frequency_hz`: shape (s,), Hz.
    """

    log_decrement: FloatArray
    frequency_hz: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class WhirlDecrements(ReadOnlyArrays):
    """Hold the first forward and the first backward mode over the speed.

    `speeds_rad_s`: Ω, shape (s,); `first_forward`, `first_backward`: the mode of lowest frequency
    with that whirl, most of its energy in lateral motion, and a damping ratio below 0.71.
    """

    speeds_rad_s: FloatArray
    first_forward: FirstMode
    first_backward: FirstMode


def whirl_decrements(
    assembled: AssembledSystem, speeds_rad_s: npt.ArrayLike, rule: DampingRule | None = None
) -> WhirlDecrements:
    """Compute damping and frequency of the first forward and the first backward mode.

    `speeds_rad_s`: Ω, shape (s,), in any order; `rule`: which modes are looked at; None takes those
    with a damping ratio below 0.71, which have a resonance. Modes with half of their energy or more
    in torsion or along the axis are left out. A mode goes forward if its orbits at
    the interfaces do on the whole, by the areas of their forward and backward circles; at rest as
    it does at a very low speed. Raises AnalysisError if a speed is not finite or there is none.
    """
    speeds = checked_speeds(speeds_rad_s)
    rows = [
        first_modes(assembled, modes_at_speed(assembled, speed), rule)
        for speed in barely_turning(speeds)
    ]
    return whirl_record(speeds, rows)


def checked_speeds(speeds_rad_s: npt.ArrayLike) -> FloatArray:
    """Return speeds as an array (s,).

    `speeds_rad_s`: Ω, shape (s,). Raises AnalysisError if a speed is not finite or there is none.
    """
    speeds = np.array(speeds_rad_s, dtype=float)
    if speeds.ndim != 1 or not speeds.size or not np.isfinite(speeds).all():
        raise AnalysisError(f"speeds_rad_s needs one or more finite speeds; found {speeds.shape}")
    return speeds


def barely_turning(speeds: FloatArray) -> list[float]:
    """Return the speeds, with a very low one in place of rest, where nothing whirls.

    `speeds`: Ω, rad/s, shape (s,).
    """
    slow = _BARELY_TURNING * (float(np.abs(speeds).max()) or 1.0)
    return [float(speed) or slow for speed in speeds]


def first_modes(
    assembled: AssembledSystem, modes: Modes, rule: DampingRule | None = None
) -> tuple[float, float, float, float]:
    """Return decrement and frequency of the first forward and the first backward mode.

    `modes`: at one speed.
    """
    resonates = modes.damping_ratio < PEAKLESS if rule is None else rule.counts(modes.eigenvalues)
    resonates &= is_mostly_lateral(energy_shares(assembled, modes.shapes))
    most, least = _net_whirl(assembled, modes)
    found: list[float] = []
    for chosen in (resonates & (most > _NO_WHIRL), resonates & (least < -_NO_WHIRL)):
        # modes come by rising frequency
        at = np.flatnonzero(chosen)[:1]
        found += [*modes.log_decrement[at], *modes.frequency_hz[at]] if at.size else [np.nan] * 2
    return tuple(found)  # type: ignore[return-value]


def _net_whirl(assembled: AssembledSystem, modes: Modes) -> tuple[FloatArray, FloatArray]:
    """Return how far each mode goes forward (1) or backward (−1) on the whole, each (m,).

    Equal modes go either way, as any combination of them is a mode: most and least of it.
    """
    orbits = interface_orbits(assembled, modes.shapes)
    along, against = orbits.x + 1j * orbits.y, orbits.x - 1j * orbits.y
    values = modes.eigenvalues
    most, least = np.zeros(values.size), np.zeros(values.size)
    for group in together(np.abs(values[:, None] - values) <= _EQUAL * np.abs(values)):
        forward, backward = (a[:, group].conj().T @ a[:, group] for a in (along, against))
        size = float(np.trace(forward + backward).real)
        if size > 0:
            whole = forward + backward + _NO_WHIRL * size * np.eye(group.size)
            net = la.eigvalsh(forward - backward, whole)
            most[group], least[group] = net[-1], net[0]
    return most, least


def whirl_record(
    speeds: FloatArray, rows: list[tuple[float, float, float, float]]
) -> WhirlDecrements:
    """Return the record of the first modes.

    `speeds`: Ω, rad/s, shape (s,); `rows`: of each from `first_modes`.
    """
    columns = np.array(rows, dtype=float).T
    return WhirlDecrements(
        speeds_rad_s=speeds,
        first_forward=FirstMode(log_decrement=columns[0], frequency_hz=columns[1]),
        first_backward=FirstMode(log_decrement=columns[2], frequency_hz=columns[3]),
    )
