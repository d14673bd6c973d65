"""Which modes of a system a diagram lacks, by signs or by the full spectrum of its matrices.

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
_EPS = float(np.finfo(float).eps)
# The least eigenvalue of a stiffness that is positive, in roundings of it.
_ROUNDINGS = 64.0


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


def all_listed(
    matrices: PlainMatrices,
    roots: ComplexArray,
    count: int,
    frequency_max_hz: float | None = None,
) -> bool:
    """Whether signs show that roots of a system are all of its lowest modes.

    `roots`: known to be roots, shape (m,). `count`, `frequency_max_hz`: as of `missing_modes`.
    False too where signs do not tell, see `is_counted_by_signs`.
    """
    rising = np.sort(roots.imag)
    if frequency_max_hz is None:
        rising = rising[:count]
        top = float(rising.max(initial=0.0)) * (1.0 + _FOUND)
    else:
        top = 2.0 * np.pi * frequency_max_hz * (1.0 - _FOUND)
        rising, count = rising[rising <= top], int(np.count_nonzero(rising <= top))
    if not count or rising.size < count or not is_counted_by_signs(matrices):
        return False
    if modes_below(matrices, top) != count:
        return False
    # a root that is listed twice may hide another one
    groups = np.split(rising, np.flatnonzero(np.diff(rising) > 2.0 * _FOUND * rising[1:]) + 1)
    return all(_are_in_group(matrices, group) for group in groups if group.size > 1)


def _are_in_group(matrices: PlainMatrices, group: FloatArray) -> bool:
    """Whether as many modes as are listed lie around some equal frequencies [rad/s]."""
    low, high = group[0] * (1.0 - _FOUND), group[-1] * (1.0 + _FOUND)
    return modes_below(matrices, high) - modes_below(matrices, low) == group.size


def is_counted_by_signs(matrices: PlainMatrices) -> bool:
    """Whether `modes_below` counts: a system without damping whose stiffness is positive.

    What is less than rounding is taken for nothing, the stiffness for positive if its least
    eigenvalue in units of its terms is more than that.
    """
    rounding = _EPS * len(matrices.mass)
    size = np.diag(matrices.sizes[2])
    if not (size > 0.0).all():
        return False
    scale = 1.0 / np.sqrt(size)
    stiffness = scale[:, None] * matrices.stiffness * scale
    damping = np.abs(matrices.velocity + matrices.velocity.T)
    if (damping > rounding * matrices.sizes[1]).any():
        return False
    if (np.abs(stiffness - stiffness.T) > rounding).any():
        return False
    factor, failed = la.lapack.dpotrf(stiffness, lower=1)
    if failed:
        return False
    norm = float(np.abs(stiffness).sum(axis=0).max())
    reciprocal, _ = la.lapack.dpocon(factor, norm, uplo="L")
    return bool(reciprocal * norm > _ROUNDINGS * rounding)


def modes_below(matrices: PlainMatrices, frequency_rad_s: float) -> int:
    """Count the modes 0 < ω < σ of a system without damping, rigid motions among them.

    They are as many as K + iσV − σ²M has negative eigenvalues, where K has none: each of these
    falls through zero at a mode and never rises there, as φᴴ(iV − 2ωM)φ = −φᴴ(K/ω + ωM)φ < 0. Their
    signs are read from LDLᴴ with blocks of one and two rows (Sylvester's law of inertia; Bunch and
    Kaufman 1977); a block of two has one of either sign.
    """
    mass, velocity, stiffness = matrices[:3]
    square = frequency_rad_s**2
    scale = 1.0 / np.sqrt(np.abs(np.diag(stiffness)) + square * np.diag(mass))
    factorised, shifted = la.lapack.dsytrf, stiffness - square * mass
    if velocity.any():
        factorised, shifted = la.lapack.zhetrf, shifted + 1j * frequency_rad_s * velocity
    factors, pivots, _ = factorised(scale[:, None] * shifted * scale, lower=1)
    single = pivots > 0
    negative = np.count_nonzero(np.diag(factors).real[single] < 0)
    return int(negative + np.count_nonzero(~single) // 2)


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
