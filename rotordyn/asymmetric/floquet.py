"""Floquet multipliers of a periodic system: what one period makes of every motion."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.asymmetric.periodic import PeriodicSystem
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError

# Steps of a period to begin with, for each radian of the fastest motion, and doublings at most.
_FEWEST, _PER_RADIAN, _DOUBLINGS = 16, 0.25, 8
# Gauss points of a step.
_EARLY, _LATE = 0.5 - np.sqrt(3.0) / 6.0, 0.5 + np.sqrt(3.0) / 6.0


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
    system: PeriodicSystem, speed_rad_s: float, tolerance: float = 1e-10
) -> Multipliers:
    """Compute the multipliers of all motions by steps through one period.

    Magnus' method of fourth order (Iserles, Munthe-Kaas, Nørsett and Zanna 2000, Acta Numerica 9),
    with twice as many steps until the matrix of a period changes by less than `tolerance`. Nothing
    of it is shared with Hill's method. Raises AnalysisError: speed 0, or no convergence.
    """
    if not (np.isfinite(speed_rad_s) and speed_rad_s):
        raise AnalysisError(f"the speed is {speed_rad_s}; a period needs one other than 0")
    period = 2.0 * np.pi / (abs(speed_rad_s) * max(system.stride, 1))
    inside = _State(system, speed_rad_s)
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
    """z' = A(t) z of the scaled state (q, q' / s)."""

    def __init__(self, system: PeriodicSystem, speed: float) -> None:
        n, self._speed = system.size, speed
        factor = la.cho_factor(system.mass)
        velocity, stiffness = (
            {h: la.cho_solve(factor, a) for h, a in terms.items()} for terms in system.at(speed)
        )
        constant = stiffness.get(0, np.zeros((n, n)))
        self.fastest = float(max(np.sqrt(np.abs(la.eigvals(constant)).max()), abs(speed)))
        self._parts = {}
        for h in {0, *velocity, *stiffness}:
            part = np.zeros((2 * n, 2 * n), dtype=float if h == 0 else complex)
            if h in stiffness:
                part[n:, :n] = -stiffness[h] / self.fastest
            if h in velocity:
                part[n:, n:] = -velocity[h]
            self._parts[h] = part
        self._parts[0][:n, n:] = self.fastest * np.eye(n)

    def at(self, time: float) -> FloatArray:
        """A(t): the parts of h and −h are conjugate."""
        out = self._parts[0].copy()
        for h, part in self._parts.items():
            if h > 0:
                out += 2.0 * (np.exp(1j * h * self._speed * time) * part).real
        return out

    def over(self, period: float, steps: int) -> FloatArray:
        """The matrix of a period."""
        h = period / steps
        out = np.eye(len(self._parts[0]))
        for k in range(steps):
            first, second = (self.at((k + part) * h) for part in (_EARLY, _LATE))
            both = second @ first - first @ second
            step = 0.5 * h * (first + second) + np.sqrt(3.0) / 12.0 * h**2 * both
            out = la.expm(step) @ out
        return out
