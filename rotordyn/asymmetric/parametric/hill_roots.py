"""Roots of Hill's determinant: eigenvalues at a speed, and speeds at which growth begins.

D(λ, Ω) = λ² M + λ V(Ω) + K(Ω) is singular where g vanishes in [[D, b], [cᴴ, 0]] (x, g) = (0, 1)
with vectors b and c that are not far from the left and the right one of the root. g is smooth also
where two eigenvalues meet, and its derivatives need no other factors than g.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.asymmetric.parametric.block_paths import Block
from solidwhirl.rotordyn.asymmetric.parametric.hill import hill_block
from solidwhirl.rotordyn.asymmetric.periodic import PeriodicSystem
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError

# Steps of Newton's method, and the relative change at which they end.
_STEPS, _CHANGE = 30, 1e-7
# Part of the speed beyond which a root is another one.
_FAR = 0.1
# Harmonics at most.
_MOST = 15

#: What is sought: λ at a speed, the speed at which Re λ = 0, or that at which two λ are equal.
Sought = Literal["growth", "crossing", "meeting"]


class Root(NamedTuple):
    """An eigenvalue λ at a speed [rad/s], and its vectors by harmonics, each (2 order + 1, n)."""

    value: complex
    speed_rad_s: float
    right: ComplexArray
    left: ComplexArray


class Converged(NamedTuple):
    """A root, and by how much the last harmonic moved its speed [rad/s] and its growth [1/s]."""

    root: Root
    moved_rad_s: float
    moved_1_s: float


def converged_root(
    system: PeriodicSystem,
    basis: FloatArray,
    start: Root,
    sought: Sought,
    allowed: tuple[float, float],
) -> Converged | None:
    """Return a root with as many harmonics as it takes, None where Newton's method finds none.

    `basis`: motions (n, r) in which the start has its vectors: harmonics are added there, and what
    is found is the root of all coordinates. `allowed`: changes of its speed and its growth, rad/s
    and 1/s, at which no more harmonics are added. Raises AnalysisError where they are not enough.
    """
    before = _newton(hill_block(system, _order(start), basis), start, sought)
    if before is not None and not system.stride:
        return Converged(before, 0.0, 0.0)
    while before is not None and _order(before) < _MOST:
        wider = before._replace(right=_widened(before.right), left=_widened(before.left))
        after = _newton(hill_block(system, _order(wider), basis), wider, sought)
        if after is None:
            return None
        moved = abs(after.speed_rad_s - before.speed_rad_s)
        change = abs(after.value.real - before.value.real)
        if moved <= allowed[0] and change <= allowed[1]:
            whole = _in_all(system, basis, after, sought)
            return None if whole is None else Converged(whole, moved, change)
        before = after
    if before is None:
        return None
    raise AnalysisError(
        f"a motion near {start.speed_rad_s:.6g} rad/s still changes with {_MOST} harmonics; "
        "search a range of higher speeds"
    )


def _in_all(system: PeriodicSystem, basis: FloatArray, root: Root, sought: Sought) -> Root | None:
    """Return the root of the whole system near one of its motions in a basis."""
    lifted = root._replace(right=root.right @ basis.T, left=root.left @ basis.T)
    if basis.shape[0] == basis.shape[1]:
        return lifted
    return _newton(hill_block(system, _order(root)), lifted, sought)


def _order(root: Root) -> int:
    return len(root.right) // 2


def _widened(parts: ComplexArray) -> ComplexArray:
    return np.pad(parts, ((1, 1), (0, 0)))


def _newton(block: Block, start: Root, sought: Sought) -> Root | None:
    shape, value, speed = start.right.shape, complex(start.value), start.speed_rad_s
    right, left = (v.ravel() / la.norm(v) for v in (start.right, start.left))
    scale = abs(value) + abs(speed)
    for _ in range(_STEPS):
        step = _Bordered(block, value, speed, right, left).step(sought)
        if step is None:
            return None
        value, speed = value + step.value, speed + step.speed
        if sought == "crossing":
            value = 1j * value.imag
        right, left = step.right / la.norm(step.right), step.left / la.norm(step.left)
        if not (abs(speed - start.speed_rad_s) < _FAR * start.speed_rad_s and np.isfinite(value)):
            return None
        if max(abs(step.value), abs(step.speed)) <= _CHANGE * scale:
            return Root(value, speed, right.reshape(shape), left.reshape(shape))
    return None


class _Step(NamedTuple):
    value: complex
    speed: float
    right: ComplexArray
    left: ComplexArray


class _Bordered:
    """g and its derivatives at a value and a speed."""

    def __init__(
        self, block: Block, value: complex, speed: float, right: ComplexArray, left: ComplexArray
    ) -> None:
        found, change = block.at(speed), block.slopes(speed, "above")
        self._turn = change.velocity
        self._mass, size = block.mass, len(block.mass)
        self._value_slope = 2.0 * value * block.mass + found.velocity
        self._speed_slope = value * change.velocity + change.stiffness
        dynamic = value * (value * block.mass + found.velocity) + found.stiffness
        # of the size of the entries, so that the factors pivot well
        border = float(np.abs(dynamic).max())
        whole = np.zeros((size + 1, size + 1), dtype=complex)
        whole[:size, :size] = dynamic
        whole[:size, size] = border * left.conj()
        whole[size, :size] = border * right.conj()
        self._factors = la.lu_factor(whole, overwrite_a=True, check_finite=False)
        unit = np.zeros(size + 1, dtype=complex)
        unit[size] = 1.0
        solved = la.lu_solve(self._factors, unit)
        self._right, self._g = solved[:size], solved[size]
        self._left = la.lu_solve(self._factors, unit, trans=1)[:size]

    def step(self, sought: Sought) -> _Step | None:
        """Newton's step."""
        by_value, by_speed = self._by(self._value_slope), self._by(self._speed_slope)
        g = self._g
        if sought == "growth":
            value, speed = -g / by_value, 0.0
        elif sought == "crossing":
            # of i ω and Ω, both real
            turning = 1j * by_value
            across = turning.real * by_speed.imag - turning.imag * by_speed.real
            if not across:
                return None
            value = 1j * (g.imag * by_speed.real - g.real * by_speed.imag) / across
            speed = (g.real * turning.imag - g.imag * turning.real) / across
        else:
            twice, mixed = self._second()
            regular = by_value * mixed - by_speed * twice
            if not regular:
                return None
            value = (by_speed * by_value - g * mixed) / regular
            speed = ((g * twice - by_value**2) / regular).real
        return _Step(complex(value), float(speed), self._right, self._left)

    def _by(self, slope: ComplexArray) -> complex:
        return complex(-self._left @ slope @ self._right)

    def _moved(self, slope: ComplexArray) -> ComplexArray:
        """The derivative of x where that of D is a slope."""
        load = np.append(-slope @ self._right, 0.0)
        return np.asarray(la.lu_solve(self._factors, load)[:-1])

    def _second(self) -> tuple[complex, complex]:
        """The derivatives of g by λ twice, and by λ and Ω."""
        by_value, by_speed = self._moved(self._value_slope), self._moved(self._speed_slope)
        twice = 2.0 * self._left @ (self._mass @ self._right + self._value_slope @ by_value)
        mixed = self._left @ (
            self._turn @ self._right + self._value_slope @ by_speed + self._speed_slope @ by_value
        )
        return complex(-twice), complex(-mixed)
