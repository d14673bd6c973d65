"""Steps of a periodic system in time by Gauss' method of two stages, which is of fourth order.

It is stable for any step, and keeps the energy where nothing takes or gives any, so that no growth
is its own. Hairer, Lubich and Wanner 2006, Geometric Numerical Integration, chapter II.1.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
import scipy.linalg as la
from scipy.linalg.lapack import dgesv

from solidwhirl.rotordyn.assembly.system import Side, law_slopes
from solidwhirl.rotordyn.asymmetric.periodic import PeriodicSystem, joint_terms
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray, Matrix
from solidwhirl.rotordyn.core.errors import AnalysisError

# Places of the stages within a step, and the weights of their accelerations: in the velocities at
# the stages, in the displacements there, and in the displacement after the step.
_ROOT = np.sqrt(3.0) / 6.0
_PLACES = np.array([0.5 - _ROOT, 0.5 + _ROOT])
_FIRST = np.array([[0.25, 0.25 - _ROOT], [0.25 + _ROOT, 0.25]])
_SECOND = _FIRST @ _FIRST
_LAST = 0.5 * _FIRST.sum(axis=0)
# Numbers in the matrices of the steps that are made together.
_TOGETHER = 2**16


class Instants(NamedTuple):
    """Angle and speed p of the frame, shape (s,), and p', which is one for all of them."""

    angles_rad: FloatArray
    speeds_rad_s: FloatArray
    rate_rad_s2: float


class _Factors:
    """Powers of the speed, its rate, and coefficients of the laws: what terms are multiplied by."""

    def __init__(self, system: PeriodicSystem) -> None:
        terms = (*system.velocity, *system.stiffness, *system.acceleration)
        self._top = max((term.power for term in terms), default=0)
        self._laws = [law.joint for law in system.laws]

    @property
    def rate(self) -> int:
        """Place of the rate; powers have that of their exponent."""
        return self._top + 1

    def of_law(self, number: int) -> int:
        """Place of the four stiffnesses of a law; dampings, and these by the speed, follow."""
        return self._top + 2 + 12 * number

    def at(self, instants: Instants) -> tuple[FloatArray, FloatArray]:
        """Return all factors and their rates, (s, f) each."""
        speeds, rise = instants.speeds_rad_s, instants.rate_rad_s2
        powers = speeds[:, None] ** np.arange(self._top + 1)
        slopes = np.zeros_like(powers)
        slopes[:, 1:] = rise * np.arange(1, self._top + 1) * powers[:, :-1]
        same = np.full((len(speeds), 1), rise)
        values, rates = [powers, same], [slopes, 0.0 * same]
        side: Side = "above" if speeds.sum() >= 0 else "below"  # at rest, where |p| has a corner
        for joint in self._laws:
            found = np.array([joint.coefficients(float(p)) for p in speeds]).reshape(-1, 8)
            change = np.array([law_slopes(joint, float(p), side) for p in speeds])
            change = rise * change.reshape(-1, 8)
            drag, drag_change = found[:, 4:], change[:, 4:]
            values += [found, speeds[:, None] * drag]
            rates += [change, rise * drag + speeds[:, None] * drag_change]
        return np.hstack(values), np.hstack(rates)


class _Part(NamedTuple):
    """Factor, harmonic and matrix of a term."""

    factor: int
    harmonic: int
    matrix: Matrix


class TermSum:
    """Σ a(p, p') e^{ihθ} A: real matrices with real weights."""

    def __init__(self, parts: list[_Part], size: int) -> None:
        every: dict[tuple[int, int], Matrix] = {}
        for factor, harmonic, matrix in parts:
            if harmonic >= 0:  # the others are conjugate to these
                key = (factor, harmonic)
                every[key] = every.get(key, 0.0) + matrix
        kept: list[tuple[int, int, complex, FloatArray]] = []
        for (factor, harmonic), matrix in every.items():
            if harmonic == 0:
                kept.append((factor, 0, 1.0, matrix.real))
            else:
                kept.append((factor, harmonic, 2.0, matrix.real))
                kept.append((factor, harmonic, 2.0j, matrix.imag))
        kept = [one for one in kept if one[3].any()]
        self._factors: IntArray = np.array([one[0] for one in kept], dtype=int)
        self._harmonics: IntArray = np.array([one[1] for one in kept], dtype=int)
        self._turned: ComplexArray = np.array([one[2] for one in kept], dtype=complex)
        #: (t, n, n)
        self.matrices = np.array([one[3] for one in kept]).reshape(-1, size, size)
        self._rows = np.ascontiguousarray(self.matrices.transpose(0, 2, 1)).reshape(len(kept), -1)

    def weights(self, factors: FloatArray, angles_rad: FloatArray) -> FloatArray:
        """Return the weight of every matrix, (s, t)."""
        return np.asarray(factors[:, self._factors] * self._turn(angles_rad).real)

    def transposed(self, weights: FloatArray) -> FloatArray:
        """Return the transposes of the sums with some weights (..., t), shape (..., n, n)."""
        shape = (*weights.shape[:-1], *self.matrices.shape[1:])
        return np.asarray((weights @ self._rows).reshape(shape))

    def weight_rates(
        self, factors: FloatArray, rates: FloatArray, instants: Instants
    ) -> FloatArray:
        """Return how fast the weights change, (s, t)."""
        turn = self._turn(instants.angles_rad)
        turning = 1j * instants.speeds_rad_s[:, None] * self._harmonics * turn
        return np.asarray(
            rates[:, self._factors] * turn.real + factors[:, self._factors] * turning.real
        )

    def _turn(self, angles_rad: FloatArray) -> ComplexArray:
        return np.asarray(
            self._turned * np.exp(1j * np.multiply.outer(angles_rad, self._harmonics))
        )


class SteppedSystem:
    """A periodic system in coordinates w of unit mass, q = `shapes` w, ready to be stepped."""

    def __init__(self, system: PeriodicSystem) -> None:
        try:
            root = la.cholesky(system.mass, lower=True)
        except la.LinAlgError as error:
            raise AnalysisError("the mass matrix is not positive definite") from error
        n = self.size = system.size
        self.root: FloatArray = root.T
        self.shapes: FloatArray = la.solve_triangular(root, np.eye(n), lower=True).T
        self.factors = _Factors(system)
        velocity = [_Part(t.power, t.harmonic, t.matrix) for t in system.velocity]
        stiffness = [_Part(t.power, t.harmonic, t.matrix) for t in system.stiffness]
        rate = self.factors.rate
        stiffness += [_Part(rate, t.harmonic, t.matrix) for t in system.acceleration]
        for number, law in enumerate(system.laws):
            found = _law_parts(law.motion, self.factors.of_law(number))
            velocity += found[0]
            stiffness += found[1]
        self.velocity, self.stiffness = (
            TermSum([p._replace(matrix=self.shapes.T @ p.matrix @ self.shapes) for p in parts], n)
            for parts in (velocity, stiffness)
        )

    def weights(self, instants: Instants) -> tuple[FloatArray, FloatArray]:
        """Return the weights of the matrices of V and of K + p' E, (s, t) each."""
        factors, _ = self.factors.at(instants)
        parts = (self.velocity, self.stiffness)
        velocity, stiffness = (part.weights(factors, instants.angles_rad) for part in parts)
        return velocity, stiffness


def _law_parts(motion: Mapping[int, Matrix], at: int) -> tuple[list[_Part], list[_Part]]:
    """Terms of V and K of a bearing with a speed law, one for each of its coefficients."""
    velocity: list[_Part] = []
    stiffness: list[_Part] = []
    none = np.zeros((2, 2))
    for k in range(4):
        unit = none.copy()
        unit.flat[k] = 1.0
        spring = joint_terms(motion, unit, none)[1]
        stiffness += [_Part(at + k, t.harmonic, t.matrix) for t in spring]
        drag = joint_terms(motion, none, unit)
        velocity += [_Part(at + 4 + k, t.harmonic, t.matrix) for t in drag[0]]
        stiffness += [_Part(at + 8 + k, t.harmonic, t.matrix) for t in drag[1]]
    return velocity, stiffness


def gauss_steps(
    system: SteppedSystem,
    loads: Callable[[Instants], FloatArray],
    begin: tuple[float, float, float],
    step_s: float,
    states: FloatArray,
) -> None:
    """Fill in the states (w, w') after each of some steps, shape (k + 1, 2n); the first is given.

    `loads`: forces on w at some instants, (s, n); `begin`: angle, p and p' at the first state.
    """
    n, count = system.size, len(states) - 1
    times = step_s * (np.arange(count)[:, None] + _PLACES)
    instants = instants_after(begin, times.ravel())
    drag, spring = (part.reshape(count, 2, -1) for part in system.weights(instants))
    forces = loads(instants).reshape(count, 2, n)
    size = max(1, _TOGETHER // (4 * n**2))
    for start in range(0, count, size):
        some = slice(start, start + size)
        velocity, stiffness, left = _stage_matrices(system, drag[some], spring[some], step_s)
        for k in range(len(left)):
            before, after = states[start + k], states[start + k + 1]
            place, rate = before[:n], before[n:]
            moved = (place + np.multiply.outer(step_s * _PLACES, rate))[:, None]
            sought = forces[start + k] - (moved @ stiffness[k])[:, 0] - rate @ velocity[k]
            _, _, found, failed = dgesv(
                left[k].T, sought.ravel(), overwrite_a=True, overwrite_b=True
            )
            if failed:
                raise AnalysisError(f"a step of {step_s:.6g} s can not be solved; take a smaller")
            first, second = found[:n], found[n:]
            after[n:] = rate + (0.5 * step_s) * (first + second)
            after[:n] = place + step_s * rate
            after[:n] += step_s**2 * (_LAST[0] * first + _LAST[1] * second)


def instants_after(begin: tuple[float, float, float], times_s: FloatArray) -> Instants:
    """Return the instants some times (s,) after an angle, p and p'."""
    angle, speed, rise = begin
    return Instants(angle + times_s * (speed + 0.5 * rise * times_s), speed + rise * times_s, rise)


def _stage_matrices(
    system: SteppedSystem, drag: FloatArray, spring: FloatArray, step_s: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return V and K at the stages, and what the accelerations of both stages meet, transposed.

    `drag`, `spring`: weights of V and K, (k, 2, t). Returns (k, 2, n, n) twice and (k, 2n, 2n).
    """
    count, n = len(drag), system.size
    # by step, stage, and stage whose acceleration it is
    left = system.velocity.transposed((step_s * _FIRST)[:, :, None] * drag[:, :, None])
    left += system.stiffness.transposed((step_s**2 * _SECOND)[:, :, None] * spring[:, :, None])
    whole = left.transpose(0, 2, 3, 1, 4).reshape(count, 2 * n, 2 * n)
    whole[:, np.arange(2 * n), np.arange(2 * n)] += 1.0
    return system.velocity.transposed(drag), system.stiffness.transposed(spring), whole
