"""Floquet multipliers of a periodic system: what one period makes of every motion."""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce
from math import factorial
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.asymmetric.periodic import PeriodicSystem
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, Matrix
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.magnus import GAUSS, magnus_exponent

# Steps of a period to begin with, for each radian of the fastest motion, and doublings at most.
_FEWEST, _PER_RADIAN, _DOUBLINGS = 16, 0.25, 8
# Terms of the series of an exponential, four to a row.
_SERIES = 1.0 / np.array([factorial(k) for k in range(16)], dtype=float).reshape(4, 4)
# Steps that are taken at once.
_TOGETHER = 256


class Multipliers(NamedTuple):
    """Multipliers (2n,) of a period [s], and how far they are off (relative to the largest)."""

    values: ComplexArray
    period_s: float
    error: float

    @property
    def growth_1_s(self) -> float:
        """Largest ln|μ| / T."""
        return float(np.log(np.abs(self.values).max()) / self.period_s)


def floquet_multipliers(
    system: PeriodicSystem,
    speed_rad_s: float,
    tolerance: float = 1e-10,
    basis: FloatArray | None = None,
) -> Multipliers:
    """Compute the multipliers of all motions by steps through one period.

    Magnus' method of fourth order (Iserles, Munthe-Kaas, Nørsett and Zanna 2000, Acta Numerica 9),
    with twice as many steps until the matrix of a period changes by less than `tolerance`. Nothing
    of it is shared with Hill's method. `basis`: motions (n, r) that the system is held to; None
    leaves it all. Raises AnalysisError: speed 0, or no convergence.
    """
    if not (np.isfinite(speed_rad_s) and speed_rad_s):
        raise AnalysisError(f"the speed is {speed_rad_s}; a period needs one other than 0")
    period = 2.0 * np.pi / (abs(speed_rad_s) * max(system.stride, 1))
    inside = _State(system, speed_rad_s, np.eye(system.size) if basis is None else basis)
    steps = max(_FEWEST, int(np.ceil(_PER_RADIAN * inside.fastest * period)))
    before = inside.over(period, steps)
    for _ in range(_DOUBLINGS):
        steps *= 2
        after = inside.over(period, steps)
        change = float(la.norm(after - before) / la.norm(after))
        # a sixteenth of the change is left
        if change < 16.0 * tolerance:
            return Multipliers(la.eigvals(after), period, change / 16.0)
        before = after
    raise AnalysisError(
        f"Floquet multipliers at {speed_rad_s:.6g} rad/s did not converge in {steps} steps"
    )


class _State:
    """z' = A(t) z of the scaled state (p, p' / s), q = B p."""

    def __init__(self, system: PeriodicSystem, speed: float, basis: FloatArray) -> None:
        self._speed, size = speed, basis.shape[1]
        factor = la.cho_factor(basis.T @ system.mass @ basis)
        velocity, stiffness = (
            {h: la.cho_solve(factor, basis.T @ a @ basis) for h, a in terms.items()}
            for terms in system.at(speed)
        )
        constant = stiffness.get(0, np.zeros((size, size)))
        self.fastest = float(max(np.sqrt(np.abs(la.eigvals(constant)).max()), abs(speed)))
        self._parts = state_rates(velocity, stiffness, self.fastest, size)
        self._parts[0][:size, size:] = self.fastest * np.eye(size)

    def over(self, period: float, steps: int) -> FloatArray:
        """The matrix of a period."""
        h = period / steps
        if self._parts.keys() == {0}:  # one step is as any other
            (step,) = exponentials(h * self._parts[0][None])
            return np.asarray(np.linalg.matrix_power(step, steps))
        out = np.eye(len(self._parts[0]))
        for first in range(0, steps, _TOGETHER):
            starts = np.arange(first, min(first + _TOGETHER, steps))
            early, late = (
                h * with_angle(self._parts, self._speed * h * (starts + part)) for part in GAUSS
            )
            out = reduce(
                lambda before, step: step @ before,
                exponentials(magnus_exponent(early, late)),
                out,
            )
        return out


def state_rates(
    velocity: Mapping[int, Matrix], stiffness: Mapping[int, Matrix], scale: float, n: int
) -> dict[int, Matrix]:
    """Return the harmonics of what changes the scaled velocity q' / s by q and by itself, (n,)."""
    out: dict[int, Matrix] = {}
    for h in {0, *velocity, *stiffness}:
        part = out[h] = np.zeros((2 * n, 2 * n), dtype=float if h == 0 else complex)
        if h in stiffness:
            part[n:, :n] = -stiffness[h] / scale
        if h in velocity:
            part[n:, n:] = -velocity[h]
    return out


def with_angle(parts: Mapping[int, Matrix], angles: FloatArray) -> FloatArray:
    """Return the sum of harmonics at angles (k,) of the body: those of h and −h are conjugate."""
    out = np.repeat(parts[0][None], angles.size, axis=0)
    for h, part in parts.items():
        if h > 0:
            out += 2.0 * np.tensordot(np.exp(1j * h * angles), part, axes=0).real
    return np.asarray(out)


def exponentials(matrices: FloatArray) -> FloatArray:
    """Exponentials of matrices (count, m, m) by their series, halved until they are small."""
    norm = float(np.abs(matrices).sum(axis=1).max())
    halvings = max(0, int(np.ceil(np.log2(max(norm, 1e-300)))))
    powers = np.empty((4, *matrices.shape))
    powers[0] = np.eye(matrices.shape[1])
    powers[1] = matrices / 2.0**halvings
    np.matmul(powers[1], powers[1], out=powers[2])
    np.matmul(powers[2], powers[1], out=powers[3])
    fourth = powers[2] @ powers[2]
    zeroth, lower, upper, out = np.tensordot(_SERIES, powers, axes=1)
    for part in (upper, lower, zeroth):
        out = out @ fourth
        out += part
    for _ in range(halvings):
        out = out @ out
    return np.asarray(out)
