"""All eigenvalues of an operator at one speed and frequency, chosen by its structure, in one place.

Matrices that are Hermitian with K ≥ 0 and no damping give a Hermitian problem. All others go by the
inverse of the companion about a real s0. Two Rayleigh steps on the matrices as given follow, which
leave the rounding of their own terms, and tell the residual of each root and its uncertainty.
"""

from __future__ import annotations

from contextlib import suppress
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray, Matrix
from solidwhirl.rotordyn.core.dense import real_dual
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.ledger import solved
from solidwhirl.rotordyn.core.second_order import SecondOrder, Triple, times
from solidwhirl.rotordyn.core.tolerances import (
    EPS,
    INFINITE,
    PIVOT,
    ROUNDINGS,
    SKEW,
    STEP,
    SYMMETRIC,
    ZERO,
)

# Factors of s0: P(s0) is singular only at a real unstable root, which the next one avoids.
_SHIFTS = (1.0, 1.37, 0.61, 2.3)
# s0 as a part of the lowest frequency: a larger one takes digits from slow decay.
_SLOW = 0.3
# Parts of the norm of K: singular values of a scaled K below it are zeros of free motions.
_KERNEL = 64 * EPS
# A product of V with free motions below this part of its terms is rounding.
_NO_PUSH = 1e-8
# Free motions that V pushes at less than this part of the rate of the question drift.
_NO_DRIFT = 1e-11


class Spectrum(NamedTuple):
    """All m finite eigenvalues of an operator at one speed and frequency.

    `values`: s in 1/s, (m,), exactly 0 for free motions; `right`, `left`: x (n, m) and y (n, m)
    with yᴴ P'(s) x = 1, laws frozen; `residuals`: |P x| over |P| |x|, rows in units of a unit
    diagonal, (m,); `uncertainty`: what rounding leaves unknown of s, 1/s, (m,); `triple`: the
    matrices.
    """

    values: ComplexArray
    right: ComplexArray
    left: ComplexArray
    residuals: FloatArray
    uncertainty: FloatArray
    triple: Triple

    def part(self, at: IntArray) -> Spectrum:
        """Return some of the eigenvalues."""
        return self._replace(
            values=self.values[at],
            right=self.right[:, at],
            left=self.left[:, at],
            residuals=self.residuals[at],
            uncertainty=self.uncertainty[at],
        )

    def slopes(self, change: Triple) -> ComplexArray:
        """Return ds/dp = −yᴴ (∂P/∂p) x for the change of the matrices with p, (m,)."""
        moved = change.times(self.right).value(self.values)
        return np.asarray(-np.einsum("ij,ij->j", self.left.conj(), moved))

    def shares(self, other: Spectrum) -> FloatArray:
        """Return how much of one vector is in another: 1 if the same, 0 of two of one operator.

        y_aᴴ [(s_a + s_b) M + V] x_b, in both directions, so that scales drop out; (m, m).
        """
        return np.asarray(np.abs(_products(self, other) * _products(other, self).T))


def _products(one: Spectrum, other: Spectrum) -> ComplexArray:
    left, (mass, velocity, _) = one.left.conj().T, one.triple
    inertia = times(mass, other.right)
    both = left @ (inertia * other.values + times(velocity, other.right))
    return np.asarray(one.values[:, None] * (left @ inertia) + both)


def spectrum(
    operator: SecondOrder, speed: float, frequency: float = 0.0, top: float | None = None
) -> Spectrum:
    """Return all finite eigenvalues, laws frozen at a frequency.

    `speed`, `frequency`: Ω and ω, rad/s; `top`: the highest frequency of the question, about which
    the companion is inverted: roots below it keep all their digits (never a ratio of K and M, which
    loses the slow ones). None takes the lowest elastic frequency.

    Raises AnalysisError if the matrices have no regular combination, or M is singular in more than
    the states.
    """
    triple = operator.at(speed, frequency)
    solved("eigenproblems")
    found = None if operator.states else _conservative(triple)
    is_conservative = found is not None
    if found is None:
        found = _general(triple, operator.states, top or _SLOW * lowest_frequency(triple))
    values, right, left, twins = found
    # Rayleigh's quotient of both vectors: quadratic, in the terms of the matrices as given
    free, moved = values == 0, triple.times(right)
    for _ in range(2):
        slope = np.einsum("ij,ij->j", left.conj(), moved.slope(values))
        alive = np.abs(slope) > 0
        slope = np.where(alive, slope, 1.0)
        step = np.einsum("ij,ij->j", left.conj(), moved.value(values)) / slope
        sound = ~free & (np.abs(step) < STEP * np.abs(values))
        values = values - np.where(sound, step, 0.0)
    if is_conservative:
        values = 1j * values.imag
    elif np.isrealobj(triple.stiffness) and np.isrealobj(triple.mass):
        values = np.where(np.abs(values.imag) <= EPS * np.abs(values), values.real, values)
    left = left / slope.conj()
    sizes = _terms(triple, values, right)
    residuals = _backward_errors(triple, values, moved.value(values), sizes)
    # rounding of the terms, and the square of what is left of P x in the vectors
    every = np.concatenate((values, values[twins].conj()))
    apart = np.abs(values[:, None] - every)
    np.fill_diagonal(apart, np.inf)
    size = np.einsum("ij,ij->j", np.abs(left), sizes)
    miss = np.maximum(residuals, EPS) * size
    nearest = np.maximum(apart.min(axis=1, initial=np.inf), miss)
    second = miss**2 / (nearest + np.finfo(float).tiny)
    left_over = ROUNDINGS * EPS * size + second
    uncertainty = np.where(free | sound, left_over, np.maximum(left_over, np.abs(step)))
    uncertainty = np.where(alive, uncertainty, np.inf)
    # what strains by the rounding of K alone is free
    stiff = np.sqrt(np.abs(np.diag(triple.stiffness)))
    strained = len(stiff) * EPS * (stiff @ np.abs(left)) * (stiff @ np.abs(right))
    values = np.where(strained >= np.abs(values), 0.0, values)
    uncertainty = np.maximum(uncertainty, strained)
    return Spectrum(
        np.concatenate((values, values[twins].conj())),
        np.hstack((right, right[:, twins].conj())),
        np.hstack((left, left[:, twins].conj())),
        np.concatenate((residuals, residuals[twins])),
        np.concatenate((uncertainty, uncertainty[twins])),
        triple,
    )


def residuals_of(triple: Triple, values: ComplexArray, right: ComplexArray) -> FloatArray:
    """Return ‖P(s_j) x_j‖ over ‖|P| |x_j|‖, rows scaled to a unit diagonal, (m,).

    The backward error: each is a root of matrices that differ by this part.
    """
    miss = triple.times(right).value(values)
    return _backward_errors(triple, values, miss, _terms(triple, values, right))


def rounding_of(
    triple: Triple, values: ComplexArray, right: ComplexArray, left: ComplexArray
) -> FloatArray:
    """Return what the rounding of the terms of P leaves unknown of roots, 1/s, (m,)."""
    terms = _terms(triple, values, right)
    return np.asarray(ROUNDINGS * EPS * np.einsum("ij,ij->j", np.abs(left), terms))


def _backward_errors(
    triple: Triple, values: ComplexArray, miss: ComplexArray, sizes: FloatArray
) -> FloatArray:
    rate = float(np.median(np.abs(values))) or 1.0 if values.size else 1.0
    diagonal = sum(
        np.abs(np.diag(matrix)) * rate**power
        for matrix, power in zip(triple, (2, 1, 0), strict=True)
    )
    scale = (1.0 / np.sqrt(diagonal + np.finfo(float).tiny))[:, None]
    largest = (sizes * scale).max(axis=0) + np.finfo(float).tiny
    return np.asarray((np.abs(miss) * scale).max(axis=0) / largest)


def _terms(triple: Triple, values: ComplexArray, right: ComplexArray) -> FloatArray:
    """Return |s|²|M||x| + |s||V||x| + |K||x|, (n, m)."""
    size, vectors = np.abs(values), np.abs(right)
    mass, velocity, stiffness = (np.abs(matrix) @ vectors for matrix in triple)
    return np.asarray((mass * size + velocity) * size + stiffness)


def lowest_frequency(triple: Triple) -> float:
    """Return about the lowest frequency of the motions that strain the bodies, rad/s; 1 if none."""
    mass, _, stiffness = (0.5 * (matrix + matrix.conj().T) for matrix in triple)
    moving = np.diag(mass).real > 0
    block = np.ix_(moving, moving)
    try:
        rates = np.abs(la.eigh(stiffness[block], mass[block], eigvals_only=True))
    except la.LinAlgError as error:
        raise AnalysisError(
            f"the mass matrix is not positive definite ({error}); every coordinate needs inertia"
        ) from error
    strained = rates[rates > 1e-12 * rates.max(initial=0.0)]
    return float(np.sqrt(strained.min())) if strained.size else 1.0


class Roots(NamedTuple):
    """Roots (m,) and vectors (n, m); `twins`: those whose conjugates are roots as well."""

    values: ComplexArray
    right: ComplexArray
    left: ComplexArray
    twins: IntArray


def _conservative(triple: Triple) -> Roots | None:
    """Return values iω and vectors of a problem without damping, None of another one.

    With M = RᴴR and K = R ᴴU w² UᴴR the rates p = q' and the strains w Uᴴ R q obey one Hermitian
    matrix [[iG, w], [w, 0]]; a zero of K gives one exact zero where the companion has two in a
    defective pair.
    """
    mass, velocity, stiffness = triple
    size = max(float(np.abs(velocity).max()), float(np.abs(mass).max()))
    if np.abs(velocity + velocity.conj().T).max() > SKEW * size:
        return None
    for matrix in (mass, stiffness):
        if np.abs(matrix - matrix.conj().T).max() > SYMMETRIC * np.abs(matrix).max():
            return None
    try:
        factor = la.cholesky(mass)
    except la.LinAlgError:
        return None
    rates, modes = la.eigh(_within(factor, stiffness))
    floor = ZERO * max(rates[-1], 0.0)
    if rates[0] < -floor:
        return None
    held = np.flatnonzero(rates > floor)
    omega = np.sqrt(rates[held])
    n = len(mass)
    strain = np.zeros((n, held.size))
    strain[held, np.arange(held.size)] = omega
    turning = modes.conj().T @ _within(factor, velocity) @ modes
    whole = np.block([[1j * turning, strain], [strain.T, np.zeros((held.size, held.size))]])
    values, states = la.eigh(whole)
    still = np.abs(values) <= np.sqrt(floor)
    values = np.where(still, 0.0, values)
    place = np.zeros((n, values.size), dtype=complex)
    place[held] = states[n:] / omega[:, None]
    loose = rates <= floor
    place[loose] = states[:n][loose] / np.where(still, 1.0, values)
    right = la.solve_triangular(factor, modes @ place)
    right = right / np.abs(right).max(axis=0)
    # as many roots as others have: the second zeros of free motions have no vectors of their own
    right = np.pad(right, ((0, 0), (0, 2 * n - values.size)))
    values = np.pad(values, (0, 2 * n - values.size))
    return Roots(1j * values, right, right, np.empty(0, dtype=int))


def _within(factor: Matrix, matrix: Matrix) -> Matrix:
    """Return R⁻ᴴ A R⁻¹."""
    half = la.solve_triangular(factor, matrix, trans="C").conj().T
    return np.asarray(la.solve_triangular(factor, half, trans="C").conj().T)


def _general(triple: Triple, states: int, top: float) -> Roots:
    """Return all finite roots and their vectors: s = s0 + 1/μ, rows and columns of P(s0) to one."""
    mass, velocity, stiffness = triple
    n, q = len(mass), len(mass) - states
    for factor in _SHIFTS:
        shift = factor * top
        dynamic = (shift * mass + velocity) * shift + stiffness
        rows = 1.0 / np.sqrt(np.abs(dynamic).max(axis=1))
        columns = 1.0 / np.abs(rows[:, None] * dynamic).max(axis=0)
        factors = la.lu_factor(rows[:, None] * dynamic * columns)
        if np.abs(np.diag(factors[0])).min() > PIVOT:
            break
    else:
        raise AnalysisError("the matrices of the system are singular at every rate")
    heavy, first = (
        rows[:, None] * matrix * columns * size
        for matrix, size in ((mass, shift * shift), (velocity, shift))
    )
    first = first.astype(dynamic.dtype)
    first[:, :q] += heavy[:, :q]
    top_rows = -la.lu_solve(factors, np.hstack([first, heavy[:, :q]]))
    companion = np.vstack([top_rows, top_rows[:q] + np.eye(q, n + q)])
    inverse, vectors = np.linalg.eig(companion)
    if np.isrealobj(companion):
        # of the pairs of a real problem one, for which half of the vectors are enough
        duals, above = real_dual(inverse, vectors, _duals), inverse.imag >= 0
        inverse, vectors, duals = (
            inverse[above].conj(),
            vectors[:, above].conj(),
            duals[above].conj(),
        )
        twins = inverse.imag != 0
    else:
        duals, twins = _duals(vectors), np.zeros(inverse.size, dtype=bool)
    kept = np.abs(inverse) > INFINITE * np.abs(inverse).max(initial=1.0)
    both = duals[kept, :n].copy()
    both[:, :q] += duals[kept, n:]
    right = columns[:, None] * vectors[:n, kept]
    left = -rows[:, None] * la.lu_solve(factors, both.conj().T, trans=2)
    values = np.asarray(shift * (1.0 + 1.0 / inverse[kept]), dtype=complex)
    slowest = np.argsort(np.abs(values), kind="stable")
    before = np.concatenate(([0], np.cumsum(1 + twins[kept][slowest])[:-1]))
    values[slowest[before < _zero_count(triple, top)]] = 0.0
    return Roots(values, right.astype(complex), left, np.flatnonzero(twins[kept]))


def _duals(vectors: Matrix) -> Matrix:
    """Return the left vectors as rows, of unit product; of defective ones those nearest to that."""
    with suppress(np.linalg.LinAlgError):
        found = np.linalg.inv(vectors)
        if la.norm(found, 1) * la.norm(vectors, 1) < 1.0 / INFINITE:
            return np.asarray(found)
    return np.asarray(np.linalg.pinv(vectors))


def _zero_count(triple: Triple, top: float) -> int:
    """Return how many roots are zero: free motions, and their steady drift where V lets them.

    s = 0 has a vector for each motion without stiffness, and a second state for each that V does
    not push to another such motion. The companion turns a defective pair into ±1e-5 rad/s.
    """
    mass, velocity, stiffness = triple
    inertia = np.abs(np.diag(mass)) * top * top + np.abs(np.diag(velocity)) * top
    scale = 1.0 / np.sqrt(np.maximum(np.abs(np.diag(stiffness)), inertia) + np.finfo(float).tiny)
    left, size, right = la.svd(scale[:, None] * stiffness * scale)
    at: BoolArray = size <= _KERNEL * max(len(size), 10)
    if not at.any():
        return 0
    first, second = scale[:, None] * left[:, at], scale[:, None] * right[at].conj().T
    push = first.conj().T @ velocity @ second
    terms = np.abs(first).T @ np.abs(velocity) @ np.abs(second)
    inertia = float((scale**2 * np.diag(mass).real).max())
    floor = max(_NO_PUSH * float(terms.max()), _NO_DRIFT * top * inertia)
    rank = int(np.count_nonzero(la.svdvals(push) > floor)) if floor > 0 else 0
    return 2 * int(np.count_nonzero(at)) - rank
