"""Which modes of a system a diagram lacks, by the full spectrum of the matrices as they are.

Nothing of how the diagram was made is used: neither the forms of isotropic and conservative
systems, nor the scaling, nor the following of branches.
"""

from __future__ import annotations

import numpy as np
import scipy
import scipy.linalg as la

from solidwhirl.rotordyn.checks.plain_system import PlainMatrices
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, together

# A mode is found if an entry of the diagram is this near (relative).
_FOUND = 1e-5
# |Im λ| below this fraction of |λ| may be a real eigenvalue: such a mode is not missed.
_HARDLY_TURNING = 1e-5
# Eigenvalues below this fraction of the shift may be zeros.
_ZERO = 1e-5
# A shift nearer to an eigenvalue than this (1/ν) drowns the others; take another one.
_HIT = 1e6


def missing_modes(
    matrices: PlainMatrices,
    found: ComplexArray,
    *,
    count: int | None = None,
    frequency_max_hz: float | None = None,
) -> ComplexArray:
    """Return the modes of a system at one speed that a list lacks.

    `found`: λ of the list in 1/s, shape (m,). `count`: the list should hold this many of the lowest
    modes; it may hold others. `frequency_max_hz`: the list should hold the modes below this
    frequency; None for `count`. Returns λ of what is missing, shape (k,). Modes within 1e-5 of real
    or zero eigenvalues are not missed, as rounding moves them from one kind to the other.
    """
    listed = np.sort_complex(np.asarray(found)[np.isfinite(found)])
    shift = _shift(matrices, listed, frequency_max_hz)
    highest = max(2.0 * np.pi * (frequency_max_hz or 0.0), np.abs(listed).max(initial=shift))
    values = _conservative_spectrum(matrices, highest)
    if values is None:
        values = full_spectrum(matrices, shift)
    values = values[(values.imag > 0) & (np.abs(values) > _ZERO * shift)]
    values = values[np.argsort(values.imag)]
    sure = values.imag > _HARDLY_TURNING * np.abs(values)
    if frequency_max_hz is not None:
        wanted = sure & (values.imag <= 2.0 * np.pi * frequency_max_hz * (1.0 - _FOUND))
    else:
        doubtful = (listed.imag <= _HARDLY_TURNING * np.abs(listed)) | (
            np.abs(listed) <= _ZERO * shift
        )
        known = values[sure]
        wanted = sure & np.isin(values, known[: max(0, (count or 0) - int(doubtful.sum()))])
    return _without_partner(values[wanted], listed)


def _without_partner(wanted: ComplexArray, listed: ComplexArray) -> ComplexArray:
    """Return what has no entry of its own in a list."""
    apart = np.abs(wanted[:, None] - listed) > _FOUND * np.abs(wanted)[:, None]
    rows, columns = scipy.optimize.linear_sum_assignment(apart)
    served = np.zeros(wanted.size, dtype=bool)
    served[rows] = ~apart[rows, columns]
    return np.asarray(wanted[~served])


def _shift(matrices: PlainMatrices, listed: ComplexArray, frequency_max_hz: float | None) -> float:
    """Return a real shift of the size of the modes that are looked for, 1/s."""
    if listed.size:
        return float(np.median(np.abs(listed)))
    if frequency_max_hz is not None:
        return 2.0 * np.pi * frequency_max_hz
    rates = np.abs(matrices.stiffness).max() / np.diag(matrices.mass).min()
    return float(np.sqrt(rates)) if rates > 0 else 1.0


def _conservative_spectrum(matrices: PlainMatrices, highest: float) -> ComplexArray | None:
    """Return λ = iω, ω > 0, without damping and with K positive definite; else None.

    The state matrix of 1/λ is skew: its square is symmetric, with every −1/ω² twice. The rounding
    of the largest drowns the others where a motion is all but rigid: None if it does up to the
    `highest` |λ| that matters, 1/s.
    """
    stiffness, velocity = matrices.stiffness, matrices.velocity
    diagonal = np.diag(stiffness)
    eps = 4.0 * np.finfo(float).eps
    damped = np.abs(velocity + velocity.T) > eps * matrices.sizes[1]
    skew = np.abs(stiffness - stiffness.T) > eps * matrices.sizes[2]
    if damped.any() or skew.any() or not (diagonal > 0).all():
        return None
    outer = 1.0 / np.sqrt(np.outer(diagonal, diagonal))
    try:
        lower = la.cholesky(outer * stiffness, lower=True)
    except la.LinAlgError:
        return None
    half = la.solve_triangular(lower, la.cholesky(outer * matrices.mass, lower=True), lower=True)
    turning = la.solve_triangular(lower, outer * velocity, lower=True)
    turning = la.solve_triangular(lower, turning.T, lower=True).T
    state = np.block([[-turning, -half], [half.T, np.zeros_like(half)]])
    squares = la.eigvalsh(state.T @ state)[::-2]
    if len(state) * eps * squares[0] * highest**2 > _FOUND:
        return None
    return np.asarray(1j / np.sqrt(squares[squares > 0]))


def full_spectrum(matrices: PlainMatrices, shift: float) -> ComplexArray:
    """Return all 2n eigenvalues of a system at one speed, but those at zero, 1/s.

    `shift`: s > 0 of the size of the roots that matter, 1/s; they are the most accurate ones.

    λ = s (1 + 1/ν), Q(s) ν² + s Q'(s) ν + s²M = 0. Coordinates that no entry joins have roots of
    their own.
    """
    matrices_of = (matrices.mass, matrices.velocity, matrices.stiffness)
    joined = np.logical_or.reduce([matrix != 0 for matrix in matrices_of])
    parts = []
    for at in together(joined):
        block = np.ix_(at, at)
        mass, velocity, stiffness = (matrix[block] for matrix in matrices_of)
        parts.append(_joined_spectrum(mass, velocity, stiffness, shift))
    return np.concatenate(parts)


def _joined_spectrum(
    mass: FloatArray, velocity: FloatArray, stiffness: FloatArray, shift: float
) -> ComplexArray:
    """Return all eigenvalues of λ²M + λV + K, but those at zero."""
    n = len(mass)
    for factor in (1.0, 1.37, 0.61):
        s = factor * shift
        scale = 1.0 / np.sqrt(np.abs(np.diag(stiffness)) + s**2 * np.diag(mass))
        outer = np.outer(scale, scale)
        square = outer * (s**2 * mass + s * velocity + stiffness)
        slope, inertia = outer * (s * velocity + 2.0 * s**2 * mass), outer * (s**2 * mass)
        companion = np.zeros((2 * n, 2 * n))
        companion[:n] = -la.solve(square, np.hstack((slope, inertia)))
        companion[n:, :n] = np.eye(n)
        inverse = la.eigvals(companion)
        if np.abs(inverse).max() < _HIT:
            break
    inverse = inverse[inverse != 0]
    return np.asarray(s * (1.0 + 1.0 / inverse))
