"""Error estimates of critical speeds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solidwhirl.rotordyn.assembly.system import (
    AssembledSystem,
    at_rate,
    at_whirl_ratio,
    speed_derivative,
)
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.critical_speeds.search import CriticalSpeed
from solidwhirl.rotordyn.estimates.campbell_errors import CampbellErrors
from solidwhirl.rotordyn.estimates.eigenvalue_errors import (
    FrequencyErrors,
    bodies_without_forms,
    eigenvalue_shifts,
)
from solidwhirl.rotordyn.modes.eigen import Modes, mode_columns, modes_at_speed

# A critical speed is a mode of the system at that speed to this (relative) accuracy; what is
# between both is told as an error of the solver.
_FOUND = 1e-3
# A branch belongs to a critical speed if it passes it as near as this (relative).
_ON_BRANCH = 0.05
# A branch of another whirl is taken only if it passes nearer by this (relative).
_OTHER_WHIRL = 0.02
# Modes above that of the critical speed that may be as close to it as it is wrong.
_ABOVE = 4


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class CriticalSpeedErrors(FrequencyErrors):
    """Hold |δΩ| / Ω of critical speeds by part, (k,) each; that of the frequency is the same."""


def critical_speed_errors(
    assembled: AssembledSystem,
    critical_speeds: Sequence[CriticalSpeed],
    campbell_errors: CampbellErrors | None = None,
) -> CriticalSpeedErrors:
    """Estimate the relative errors of critical speeds with any excitation ratios, in their order.

    `campbell_errors`: of the same system: gives the share of "speed_interpolation" in the error of
    the reduction where a branch passes. Without it, and beyond its speeds, all is
    "mode_truncation". Raises AnalysisError if one is no mode of the system at its speed.

    With δs of the mode at the critical speed and its slope ds/dΩ = −yᵀ(dD/dΩ)x / (yᵀD'x), the
    branch meets the line αΩ at δΩ = Im δs / (α − Im ds/dΩ). Without damping that is
    yᵀ(E − Ω²ΔK2)x / (yᵀ[dD/dΩ + iα D']x).
    """
    count = len(critical_speeds)
    parts = {"eigen_solver": np.zeros(count)}
    for place, critical in enumerate(critical_speeds):
        for part, value in _errors_of(assembled, critical).items():
            parts.setdefault(part, np.zeros(count))[place] = value
    if campbell_errors is not None and "speed_interpolation" in campbell_errors.parts:
        share = np.array([_interpolated_share(campbell_errors, c) for c in critical_speeds])
        whole = parts.get("mode_truncation", np.zeros(count))
        parts["speed_interpolation"] = share * whole
        parts["mode_truncation"] = whole - parts["speed_interpolation"]
    return CriticalSpeedErrors(parts=parts, bodies_without_estimate=bodies_without_forms(assembled))


def _errors_of(assembled: AssembledSystem, critical: CriticalSpeed) -> dict[str, float]:
    """Return |δΩ| / Ω of one critical speed by part."""
    speed = critical.speed_rad_s
    modes = modes_at_speed(assembled, speed)
    column = _mode_of(assembled, critical, modes)
    kept = np.arange(min(column + 1 + _ABOVE, modes.eigenvalues.size))
    # along αΩ bearings that depend on the frequency are ones that depend on the speed
    shifts = eigenvalue_shifts(at_rate(assembled, critical.eigenvalue), mode_columns(modes, kept))
    ratio = 2.0 * np.pi * critical.frequency_hz / speed
    rate, right, left = (a[..., column] for a in shifts.pairs)
    slope = speed_derivative(at_whirl_ratio(assembled, ratio), speed)
    moved = -left @ (slope.at_rate(complex(rate)) @ right)
    gap = abs(ratio - float(np.imag(moved))) * speed
    errors = {part: abs(float(v[column].imag)) / gap for part, v in shifts.parts.items()}
    missed = abs(modes.eigenvalues[column] - critical.eigenvalue)
    errors["eigen_solver"] = float(shifts.solver[column] + missed) / gap
    return errors


def _mode_of(assembled: AssembledSystem, critical: CriticalSpeed, modes: Modes) -> int:
    """Return the mode at a critical speed, that of the likest shape among equal ones."""
    value = critical.eigenvalue
    near = np.flatnonzero(np.abs(modes.eigenvalues - value) <= _FOUND * abs(value))
    if not near.size or critical.shape.size != assembled.size:
        raise AnalysisError(
            f"the critical speed {critical.speed_rad_s:.6g} rad/s is no mode of this system; give "
            "the system it was computed from"
        )
    mac = critical.shape.conj() @ assembled.mass @ modes.shapes[:, near]
    return int(near[np.abs(mac).argmax()])


def _interpolated_share(errors: CampbellErrors, critical: CriticalSpeed) -> float:
    """Return the share of speed interpolation on the branch that passes, 0 if none does."""
    campbell, speed = errors.campbell, critical.speed_rad_s
    order = np.argsort(campbell.speeds_rad_s)
    speeds = campbell.speeds_rad_s[order]
    if not speeds[0] <= speed <= speeds[-1]:
        return 0.0

    def at_speed(values: FloatArray) -> FloatArray:
        return np.array([np.interp(speed, speeds, row) for row in values[:, order]])

    frequency = at_speed(campbell.frequency_hz)
    whirl = campbell.whirl[:, order[int(np.abs(speeds - speed).argmin())]]
    miss = np.abs(frequency - critical.frequency_hz) / critical.frequency_hz
    cost = np.where(np.isfinite(miss), miss, np.inf) + _OTHER_WHIRL * (whirl != critical.whirl)
    branch = int(cost.argmin())
    if not cost[branch] <= _ON_BRANCH:
        return 0.0
    over = at_speed(errors.parts["speed_interpolation"])[branch]
    rest = at_speed(errors.parts["mode_truncation"])[branch]
    return float(over / (over + rest)) if over + rest > 0 else 0.0
