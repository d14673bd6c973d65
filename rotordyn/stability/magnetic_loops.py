"""Rotors in magnetic bearings: closed-loop eigenvalues and the sensitivity of every axis."""

from __future__ import annotations

from collections.abc import Sequence
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
    """Return closed-loop eigenvalues and the peaks of |Gs|, all other loops closed.

    `assembled`: the rotor without its magnetic bearings; `highest_rad_s`: end of the range of
    frequencies, by default the larger of 2 kHz and three times the speed; `zone_limits`: largest
    |Gs| of zones A, B and C; the value on a limit belongs to the better zone. Raises AnalysisError
    without loops, AssemblyError for a place that does not exist.

    Gs = 1/(1 + Go) by definition is the signal after the summing point at a sensor for a unit
    signal put in there; it is computed from the whole closed system.
    """
    if not loops:
        raise AnalysisError("magnetic sensitivity: no magnetic bearing is given")
    plant = _Plant(assembled, loops, speed_rad_s)
    eigenvalues = plant.eigenvalues()
    if (eigenvalues.real >= 0).any():
        return Sensitivity(eigenvalues=eigenvalues, axes=())
    highest = highest_rad_s or max(_RANGE_RAD_S, _RANGE_SPEEDS * abs(speed_rad_s))
    samples = _samples(eigenvalues, highest)
    sampled = np.array([np.abs(plant.sensitivities(w)) for w in samples])
    axes = []
    for k in range(2 * len(loops)):
        peak, at = _peak(plant, k, samples, sampled[:, k])
        zone = "ABCD"[int(np.searchsorted(zone_limits, peak))]
        found = {"loop": loops[k // 2].name, "axis": "xy"[k % 2], "zone": zone}
        axes.append(AxisPeak(**found, peak=peak, frequency_rad_s=at))
    return Sensitivity(eigenvalues=eigenvalues, axes=tuple(axes))


class _Plant:
    """Matrices of rotor and magnets at a speed, M q'' + C q' + K q = −Σ Tᵀ ki H (S q + e)."""

    def __init__(
        self, assembled: AssembledSystem, loops: Sequence[MagneticLoop], speed_rad_s: float
    ) -> None:
        found: SpeedMatrices = matrices_at_speed(assembled, speed_rad_s)
        self.loops = loops
        self.mass = found.mass
        self.damping = found.damping + found.gyroscopic
        self.stiffness = found.stiffness.copy()
        self.magnets = [seat_motion(assembled, loop.actuator)[:2] for loop in loops]
        self.sensors = [seat_motion(assembled, loop.sensor)[:2] for loop in loops]
        for loop, rows in zip(loops, self.magnets, strict=True):
            self.stiffness -= loop.bearing.negative_stiffness_n_per_m * rows.T @ rows

    def eigenvalues(self) -> ComplexArray:
        """Return the eigenvalues of rotor and controller states, exactly linear."""
        stiffness, damping, force, states, outputs = self.stiffness, self.damping, [], [], []
        for loop, rows, seen in zip(self.loops, self.magnets, self.sensors, strict=True):
            own, gain = loop.bearing.controller, loop.bearing.current_stiffness_n_per_a
            stiffness = stiffness + gain * rows.T @ own.d @ seen
            damping = damping + gain * rows.T @ own.gain_of_rate @ seen
            force.append(gain * rows.T @ own.c)
            states.append(own.a)
            outputs.append(own.b @ seen)
        n, a = len(self.mass), la.block_diag(*states)
        inverse = la.cho_factor(self.mass)
        pushed = [la.cho_solve(inverse, m) for m in (stiffness, damping, np.hstack(force))]
        whole = np.block(
            [
                [np.zeros((n, n)), np.eye(n), np.zeros((n, len(a)))],
                [-pushed[0], -pushed[1], -pushed[2]],
                [np.vstack(outputs), np.zeros((len(a), n)), a],
            ]
        )
        values = la.eigvals(whole)
        return np.asarray(values[np.argsort(np.abs(values.imag), kind="stable")])

    def sensitivities(self, frequency_rad_s: float) -> ComplexArray:
        """Return Gs of all axes at a frequency, each with all other loops closed."""
        s = 1j * frequency_rad_s
        stiffness = self.stiffness + s * self.damping + s**2 * self.mass
        pulls = []
        for loop, rows, seen in zip(self.loops, self.magnets, self.sensors, strict=True):
            pull = rows.T @ loop.bearing.sensor_stiffness(s)
            stiffness = stiffness + pull @ seen
            pulls.append(pull)
        moved = np.linalg.solve(stiffness, -np.hstack(pulls))
        return np.asarray(1.0 + np.diag(np.vstack(self.sensors) @ moved))


def _samples(eigenvalues: ComplexArray, highest: float) -> FloatArray:
    """Return frequencies at which no peak can hide: a grid, and places about the eigenvalues."""
    sizes = np.abs(eigenvalues)
    lowest = min(1e-2 * sizes.min(), 1e-3 * highest)
    about = [eigenvalues.imag + k * eigenvalues.real for k in _ABOUT]
    found = np.concatenate((np.geomspace(lowest, highest, _GRID), *about))
    found = found[(found > 0) & (found <= highest)]
    return np.asarray(np.unique(np.concatenate((found, [highest]))))


def _peak(
    plant: _Plant, axis: int, samples: FloatArray, sampled: FloatArray
) -> tuple[float, float]:
    """Return the largest |Gs| and where, every high sampled peak refined between its neighbours."""
    best, at = float(sampled.max()), float(samples[np.argmax(sampled)])
    ends = np.concatenate(([-np.inf], sampled, [-np.inf]))
    tops = np.flatnonzero((sampled >= ends[:-2]) & (sampled >= ends[2:]) & (sampled > 0.5 * best))
    for k in tops:
        low, high = samples[max(k - 1, 0)], samples[min(k + 1, len(samples) - 1)]
        found = scipy.optimize.minimize_scalar(
            lambda w: -abs(plant.sensitivities(w)[axis]),
            bounds=(low, high),
            method="bounded",
            options={"xatol": 1e-10 * high},
        )
        if -found.fun > best:
            best, at = float(-found.fun), float(found.x)
    return best, at
