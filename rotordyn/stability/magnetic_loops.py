"""Rotors in magnetic bearings: closed-loop eigenvalues and the sensitivity of every axis."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.coordinates import seat_motion
from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.assembly.system import AssembledSystem, SpeedMatrices, matrices_at_speed
from solidwhirl.rotordyn.bearings.magnetic import MagneticBearing
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modes.controlled import (
    Controlled,
    Loop,
    controlled,
    state_matrix,
)
from solidwhirl.rotordyn.modes.modal_truncation import project_system
from solidwhirl.rotordyn.modes.uncoupled import uncoupled_groups
from solidwhirl.rotordyn.perturbation.left_vectors import dynamic_stiffness

# ISO 14839-3: largest |Gs| of the zones A, B and C; beyond is D.
ZONE_LIMITS = (3.0, 4.0, 5.0)
# Upper end of the range that the standard looks at, rad/s, and in multiples of the speed.
_RANGE_RAD_S, _RANGE_SPEEDS = 2000.0 * 2.0 * np.pi, 3.0
_GRID = 240
# Places about an eigenvalue that are looked at, in its own decay rates.
_ABOUT = (-4.0, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 4.0)


@dataclass(frozen=True, kw_only=True)
class MagneticLoop:
    """A magnetic bearing in a rotor: where its magnets pull and where its sensors look."""

    name: str
    bearing: MagneticBearing
    actuator: End
    sensor: End


@dataclass(frozen=True, kw_only=True)
class AxisPeak:
    """Largest |Gs| of one axis: `peak` at `frequency_rad_s`, and its zone, "A" to "D"."""

    loop: str
    axis: str
    peak: float
    frequency_rad_s: float
    zone: str


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Sensitivity(ReadOnlyArrays):
    """What ISO 14839-3 asks of a rotor in magnetic bearings.

    `eigenvalues`: of rotor and controllers with all loops closed, rad/s, rising in frequency;
    `axes`: peaks of the sensitivity, empty if an eigenvalue grows: the figure means nothing then.
    """

    eigenvalues: ComplexArray
    axes: tuple[AxisPeak, ...]

    @property
    def is_stable(self) -> bool:
        """Whether every eigenvalue decays."""
        return bool(np.all(self.eigenvalues.real < 0))

    @property
    def message(self) -> str:
        """One line: instability first, else the worst axis."""
        if not self.is_stable:
            worst = self.eigenvalues[np.argmax(self.eigenvalues.real)]
            return (
                f"unstable: a motion of {abs(worst.imag) / (2.0 * np.pi):.6g} Hz grows with "
                f"{worst.real:.6g} 1/s; no sensitivity is given"
            )
        peak = max(self.axes, key=lambda axis: axis.peak)
        return (
            f"zone {peak.zone}: |Gs| of {peak.loop} {peak.axis} is {peak.peak:.4g} at "
            f"{peak.frequency_rad_s / (2.0 * np.pi):.6g} Hz"
        )


def magnetic_sensitivity(
    assembled: AssembledSystem,
    loops: Sequence[MagneticLoop],
    speed_rad_s: float,
    highest_rad_s: float | None = None,
    zone_limits: tuple[float, float, float] = ZONE_LIMITS,
) -> Sensitivity:
    """Return the sensitivity of a rotor with magnetic bearings beside those of the system.

    `assembled`: the rotor; `loops`: bearings that come to those it has. All else, and what it
    raises, as of `system_sensitivity`; AssemblyError for a place that does not exist.
    """
    own = controlled(assembled)
    more = tuple(
        Loop(
            loop.name,
            loop.bearing,
            *(seat_motion(assembled, end)[:2] for end in (loop.actuator, loop.sensor)),
        )
        for loop in loops
    )
    return _sensitivity(
        own._replace(loops=own.loops + more), speed_rad_s, highest_rad_s, zone_limits
    )


def system_sensitivity(
    assembled: AssembledSystem,
    speed_rad_s: float,
    highest_rad_s: float | None = None,
    zone_limits: tuple[float, float, float] = ZONE_LIMITS,
) -> Sensitivity:
    """Return closed-loop eigenvalues and the peaks of |Gs|, all other loops closed.

    `assembled`: a system with magnetic bearings; `highest_rad_s`: end of the range of frequencies,
    by default the larger of 2 kHz and three times the speed; `zone_limits`: largest |Gs| of zones
    A, B and C; the value on a limit belongs to the better zone. Raises AnalysisError if it has no
    magnetic bearing.

    Gs = 1/(1 + Go) by definition is the signal after the summing point at a sensor for a unit
    signal put in there; it is computed from the whole closed system. Other bearings that depend on
    the frequency are taken at that of the spin.
    """
    return _sensitivity(
        controlled(_that_loops_move(assembled)), speed_rad_s, highest_rad_s, zone_limits
    )


def _that_loops_move(assembled: AssembledSystem) -> AssembledSystem:
    """Leave out coordinates that no loop reaches, such as a torsion that nothing holds."""
    loops = controlled(assembled).loops
    reached = np.zeros(assembled.size, dtype=bool)
    for loop in loops:
        reached |= (loop.magnets != 0.0).any(axis=0) | (loop.sensors != 0.0).any(axis=0)
    groups = [group for group in uncoupled_groups(assembled) if reached[group].any()]
    if not groups or sum(group.size for group in groups) == assembled.size:
        return assembled
    return project_system(assembled, np.eye(assembled.size)[:, np.sort(np.concatenate(groups))])


def highest_of(speed_rad_s: float) -> float:
    """Return the end of the range of frequencies of a speed: 2 kHz or three times it, rad/s."""
    return max(_RANGE_RAD_S, _RANGE_SPEEDS * abs(speed_rad_s))


def sensitivities(
    assembled: AssembledSystem, speed_rad_s: float, frequencies_rad_s: FloatArray
) -> ComplexArray:
    """Return Gs of all axes of a system at frequencies (f,), each with all other loops closed.

    Returns shape (f, 2 loops), x and y of each magnetic bearing, in the order of the bearings.
    """
    parts = controlled(assembled)
    matrices = matrices_at_speed(parts.system, speed_rad_s)
    return np.array([_sensitivities(parts.loops, matrices, float(w)) for w in frequencies_rad_s])


def _sensitivity(
    parts: Controlled,
    speed: float,
    highest_rad_s: float | None,
    zone_limits: tuple[float, float, float],
) -> Sensitivity:
    if not parts.loops:
        raise AnalysisError("magnetic sensitivity: no magnetic bearing is given")
    values = la.eigvals(state_matrix(parts, speed))
    eigenvalues = np.asarray(values[np.argsort(np.abs(values.imag), kind="stable")])
    if (eigenvalues.real >= 0).any():
        return Sensitivity(eigenvalues=eigenvalues, axes=())
    highest = highest_rad_s or highest_of(speed)
    samples = _samples(eigenvalues, highest)
    matrices = matrices_at_speed(parts.system, speed)
    sampled = np.array([np.abs(_sensitivities(parts.loops, matrices, w)) for w in samples])
    axes = []
    for k in range(2 * len(parts.loops)):

        def gain(frequency: float, axis: int = k) -> float:
            return float(abs(_sensitivities(parts.loops, matrices, frequency)[axis]))

        peak, at = _peak(gain, samples, sampled[:, k])
        zone = "ABCD"[int(np.searchsorted(zone_limits, peak))]
        found = {"loop": parts.loops[k // 2].name, "axis": "xy"[k % 2], "zone": zone}
        axes.append(AxisPeak(**found, peak=peak, frequency_rad_s=at))
    return Sensitivity(eigenvalues=eigenvalues, axes=tuple(axes))


def _sensitivities(
    loops: Sequence[Loop], matrices: SpeedMatrices, frequency_rad_s: float
) -> ComplexArray:
    """Return Gs of all axes at a frequency, each with all other loops closed.

    `matrices`: of the system without these loops.
    """
    rate = 1j * frequency_rad_s
    whole, pulls = dynamic_stiffness(matrices, rate), []
    for _, bearing, magnets, sensors in loops:
        pull = magnets.T @ bearing.sensor_stiffness(rate)
        held = bearing.negative_stiffness_n_per_m * magnets.T @ magnets
        whole = whole + pull @ sensors - held
        pulls.append(pull)
    moved = np.linalg.solve(whole, -np.hstack(pulls))
    return np.asarray(1.0 + np.diag(np.vstack([loop.sensors for loop in loops]) @ moved))


def _samples(eigenvalues: ComplexArray, highest: float) -> FloatArray:
    """Return frequencies at which no peak can hide: a grid, and places about the eigenvalues."""
    sizes = np.abs(eigenvalues)
    lowest = min(1e-2 * sizes.min(), 1e-3 * highest)
    about = [eigenvalues.imag + k * eigenvalues.real for k in _ABOUT]
    found = np.concatenate((np.geomspace(lowest, highest, _GRID), *about))
    found = found[(found > 0) & (found <= highest)]
    return np.asarray(np.unique(np.concatenate((found, [highest]))))


def _peak(
    gain: Callable[[float], float], samples: FloatArray, sampled: FloatArray
) -> tuple[float, float]:
    """Return the largest |Gs| and where, every high sampled peak refined between its neighbours."""
    best, at = float(sampled.max()), float(samples[np.argmax(sampled)])
    ends = np.concatenate(([-np.inf], sampled, [-np.inf]))
    tops = np.flatnonzero((sampled >= ends[:-2]) & (sampled >= ends[2:]) & (sampled > 0.5 * best))
    for k in tops:
        low, high = samples[max(k - 1, 0)], samples[min(k + 1, len(samples) - 1)]
        found = scipy.optimize.minimize_scalar(
            lambda w: -gain(float(w)),
            bounds=(low, high),
            method="bounded",
            options={"xatol": 1e-10 * high},
        )
        if -found.fun > best:
            best, at = float(-found.fun), float(found.x)
    return best, at
