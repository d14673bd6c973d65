"""Damping of the first forward mode over cross-coupled stiffness, up to the loss of stability."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.assembly.coordinates import interface_row
from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modes.damping import PEAKLESS, log_decrement
from solidwhirl.rotordyn.modes.eigen import modes_at_speed
from solidwhirl.rotordyn.modes.kinds import energy_shares, is_mostly_lateral
from solidwhirl.rotordyn.modes.nearby import modes_near
from solidwhirl.rotordyn.modes.whirl import interface_orbits

# Steps over the range that is asked for, doublings of it in search of the loss of stability, and
# halvings of a step over which a mode is not told from others.
_STEPS, _DOUBLINGS, _HALVINGS = 30, 10, 6
# Accuracy of that place, as a part of the step it lies in.
_PLACED = 1e-9
# Shapes of the same mode at neighbouring steps agree to this (MAC).
_SAME = 0.8
# Eigenvalues closer than this (relative) are equal; net whirl below this is none.
_EQUAL, _NO_WHIRL = 1e-6, 1e-9


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class CrossCouplingSweep(ReadOnlyArrays):
    """Hold the first forward mode over cross-coupled stiffness.

    `stiffness_n_per_m`: Q, rising from 0, shape (s,); `log_decrement`, `frequency_hz`: shape (s,).
    `lost_at_n_per_m`: Q_0, where the decrement is 0; 0 if it is not above 0 without Q, inf if it
    does not fall to 0 in 1024 times the range asked for.
    """

    stiffness_n_per_m: FloatArray
    log_decrement: FloatArray
    frequency_hz: FloatArray
    lost_at_n_per_m: float


class ForwardMode(NamedTuple):
    """λ in 1/s, and φ scaled to φᴴMφ = 1, shape (n,)."""

    value: complex
    shape: ComplexArray

    @property
    def log_decrement(self) -> float:
        """Its logarithmic decrement."""
        return float(log_decrement(np.array([self.value]))[0])

    @property
    def frequency_hz(self) -> float:
        """Its damped natural frequency."""
        return self.value.imag / (2.0 * np.pi)


def with_cross_coupling(
    assembled: AssembledSystem, stiffness_n_per_m: Mapping[End, float]
) -> AssembledSystem:
    """Return a system with cross-coupled stiffness k_xy = Q, k_yx = −Q to the ground.

    `stiffness_n_per_m`: Q by interface; positive drives whirl in the sense in which its body turns.
    """
    stiffness = assembled.stiffness.copy()
    for end, value in stiffness_n_per_m.items():
        x, y = (interface_row(assembled, end.body, end.interface, c) for c in ("ux", "uy"))
        sense = -1.0 if assembled.system.rotors[end.body].speed_ratio < 0.0 else 1.0
        stiffness += sense * value * (np.outer(x, y) - np.outer(y, x))
    return dataclasses.replace(assembled, stiffness=stiffness)


def first_forward_mode(
    assembled: AssembledSystem, speed_rad_s: float, sense: float = 1.0
) -> ForwardMode:
    """Return the lateral mode of lowest frequency that whirls with a shaft.

    `speed_rad_s`: Ω; `sense`: 1 of a shaft that turns with the reference shaft, −1 of one that
    turns against it. Its damping ratio is below 0.71. Raises AnalysisError if there is none.
    """
    modes = modes_at_speed(assembled, speed_rad_s)
    orbits = interface_orbits(assembled, modes.shapes)
    along, against = (
        (np.abs(orbits.x + 1j * s * orbits.y) ** 2).sum(axis=0) for s in (sense, -sense)
    )
    net = (along - against) / np.maximum(along + against, np.finfo(float).tiny)
    lateral = is_mostly_lateral(energy_shares(assembled, modes.shapes))
    goes = np.flatnonzero((net > _NO_WHIRL) & (modes.damping_ratio < PEAKLESS) & lateral)
    if not goes.size:
        raise AnalysisError(f"no mode whirls forward at {speed_rad_s:.6g} rad/s")
    values = modes.eigenvalues
    same = goes[np.abs(values[goes] - values[goes[0]]) <= _EQUAL * np.abs(values[goes[0]])]
    first = same[net[same].argmax()]
    return ForwardMode(complex(values[first]), _unit(assembled, modes.shapes[:, first]))


def cross_coupling_sweep(
    assembled: AssembledSystem,
    speed_rad_s: float,
    shares: Mapping[End, float],
    largest_n_per_m: float,
    exact_n_per_m: float,
    sense: float = 1.0,
) -> CrossCouplingSweep:
    """Follow the first forward mode over cross-coupled stiffness at one speed.

    `shares`: parts of Q by interface; `largest_n_per_m`: Q goes up to this, or to where stability
    is lost if that comes first; `exact_n_per_m`: a Q that is looked at in any case. The loss is
    sought beyond that too. Raises AnalysisError if no mode whirls forward, or it is lost sight of.
    """

    def system_at(value: float) -> AssembledSystem:
        return with_cross_coupling(assembled, {end: value * s for end, s in shares.items()})

    start = first_forward_mode(assembled, speed_rad_s, sense)
    known: dict[float, ForwardMode] = {0.0: start}

    def at(value: float) -> ForwardMode:
        if value not in known:
            known[value] = _followed(system_at, speed_rad_s, known, value)
        return known[value]

    lost = _lost_at(at, largest_n_per_m) if start.log_decrement > 0.0 else 0.0
    end = min(largest_n_per_m, lost) or largest_n_per_m
    steps = np.union1d(np.linspace(0.0, end, _STEPS + 1), [exact_n_per_m])
    found = [at(float(value)) for value in steps]
    return CrossCouplingSweep(
        stiffness_n_per_m=steps,
        log_decrement=np.array([mode.log_decrement for mode in found]),
        frequency_hz=np.array([mode.frequency_hz for mode in found]),
        lost_at_n_per_m=lost,
    )


def _lost_at(at: Callable[[float], ForwardMode], largest: float) -> float:
    """Return where the decrement falls to 0, inf if it does not."""
    from scipy.optimize import brentq

    steps = [
        *np.linspace(0.0, largest, _STEPS + 1),
        *(largest * 2.0 ** np.arange(1, _DOUBLINGS + 1)),
    ]
    for low, high in pairwise(steps):
        if at(float(high)).value.real >= 0.0:
            return float(brentq(lambda q: at(q).value.real, low, high, xtol=_PLACED * (high - low)))
    return float("inf")


def _followed(
    system_at: Callable[[float], AssembledSystem],
    speed_rad_s: float,
    known: dict[float, ForwardMode],
    value: float,
    halvings: int = _HALVINGS,
) -> ForwardMode:
    """Return the mode at a Q from the nearest Q at which it is known, by way of the middle."""
    origin = min(known, key=lambda q: abs(q - value))
    system = system_at(value)
    mode, likeness = _alike(system, speed_rad_s, known[origin])
    if likeness >= _SAME:
        return mode
    if halvings == 0:
        raise AnalysisError(
            f"the first forward mode is lost sight of at a cross-coupling of {value:.4g} N/m"
        )
    middle = 0.5 * (origin + value)
    known[middle] = _followed(system_at, speed_rad_s, known, middle, halvings - 1)
    return _followed(system_at, speed_rad_s, known, value, halvings - 1)


def _alike(
    system: AssembledSystem, speed_rad_s: float, before: ForwardMode
) -> tuple[ForwardMode, float]:
    """Return the mode of a system that is most like one, and their MAC."""
    near = modes_near(system, speed_rad_s)(before.value, before.shape[:, None])
    if near is not None and near[0][0].imag > 0.0:
        mode = ForwardMode(complex(near[0][0]), _unit(system, near[1][:, 0]))
        likeness = _mac(system, before, mode.shape)
        if likeness >= _SAME:
            return mode, likeness
    modes = modes_at_speed(system, speed_rad_s)
    found = [_mac(system, before, _unit(system, shape)) for shape in modes.shapes.T]
    best = int(np.argmax(found))
    shape = _unit(system, modes.shapes[:, best])
    return ForwardMode(complex(modes.eigenvalues[best]), shape), found[best]


def _unit(system: AssembledSystem, shape: ComplexArray) -> ComplexArray:
    return np.asarray(shape / np.sqrt((shape.conj() @ system.mass @ shape).real))


def _mac(system: AssembledSystem, before: ForwardMode, shape: ComplexArray) -> float:
    return float(abs(before.shape.conj() @ system.mass @ shape) ** 2)
