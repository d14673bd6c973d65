"""Eigenvalues of a system that is the same in all directions: half of it, in complex coordinates.

Lateral motion is solved in z = p + i s, where whirl with +z and against it come apart by the sign
of the frequency; axial motion and torsion, which a turn does not move, are solved beside it.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.system import AssembledSystem, SpeedMatrices
from solidwhirl.rotordyn.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray, Matrix
from solidwhirl.rotordyn.core.dense import (
    Scaled,
    Spectrum,
    are_real,
    cholesky_of_mass,
    general_eigenvalues,
    is_definite,
    scale_by_stiffness,
    scaled_matrices,
    solve_general,
    solve_gyroscopic,
    solve_standing,
)
from solidwhirl.rotordyn.core.ledger import solved
from solidwhirl.rotordyn.modes.complex_form import (
    ComplexForm,
    complex_form,
    plane_pairs,
)

# Parts that couple the planes may reach this fraction of the diagonal.
_ROUNDING = 1e-11


@lru_cache(maxsize=4)
def planes_apart(assembled: AssembledSystem) -> tuple[IntArray, IntArray] | None:
    """Return the coordinates of two planes that only the gyroscopic matrix couples.

    Returns indices; axial motion and torsion count to the first. None if something else couples
    them. Damping is not looked at.
    """
    pairs = plane_pairs(assembled)
    if pairs is None or not pairs.first.size:
        return None
    # by the bearings' own numbers: beside a stiff shaft a cross term may be rounding in the sum
    own = (bearing.matrices()[0] for bearing in assembled.system.bearings)
    if any(k[0, 1] or k[1, 0] or k[3, 4] or k[4, 3] for k in own):
        return None
    first = np.sort(np.concatenate((pairs.first, pairs.rest)))
    second = np.sort(pairs.second)
    across = np.ix_(first, second)
    for matrix in (assembled.mass, assembled.stiffness, assembled.centrifugal_stiffness):
        size = np.sqrt(np.abs(np.diag(matrix)))
        allowed = _ROUNDING * np.outer(size[first], size[second])
        if (np.abs(matrix[across]) > allowed).any():
            return None
    turning = assembled.gyroscopic
    within = max(np.abs(turning[np.ix_(s, s)]).max(initial=0.0) for s in (first, second))
    if within > _ROUNDING * np.abs(turning).max(initial=0.0):
        return None
    for joint in assembled.law_joints:
        planes = [np.abs(joint.motion[:, side]).max(axis=1) > 0 for side in (first, second)]
        crossed = joint.pieces is None or joint.pieces.has_cross_terms
        if (planes[0] & planes[1]).any() or crossed:
            return None
    return first, second


def plane_spectrum(
    assembled: AssembledSystem, matrices: SpeedMatrices, count: int
) -> SplitSpectrum | None:
    """Solve an undamped system whose two planes only spin couples.

    `count`: number of lowest modes wanted. Returns None if the planes are coupled otherwise, or K
    is not positive definite.

    With K = LLᵀ, L⁻¹ML⁻ᵀ = NNᵀ in each plane and g the block of ΩG, x real, y = i times real:
    1/ω are the singular values of [[−g̃, Nx], [Nyᵀ, 0]]. Only digits relative to the lowest
    frequency count, as in `spectrum`.
    """
    planes = planes_apart(assembled) if assembled.is_conservative else None
    if planes is None:
        return None
    factors = []
    for at in planes:
        block = np.ix_(at, at)
        scale, stiffness, mass = scaled_matrices(
            matrices.stiffness[block], matrices.mass[block], assembled.body_rate
        )
        if not is_definite(stiffness):
            return None
        lower = la.cholesky(stiffness, lower=True)
        half = la.solve_triangular(lower, cholesky_of_mass(mass), lower=True)
        factors.append((scale, lower, half))
    (scale_x, lower_x, half_x), (scale_y, lower_y, half_y) = factors
    nx, ny = scale_x.size, scale_y.size
    turning = scale_x[:, None] * matrices.gyroscopic[np.ix_(*planes)] * scale_y
    turning = la.solve_triangular(lower_x, turning, lower=True)
    turning = la.solve_triangular(lower_y, turning.T, lower=True).T
    matrix = np.zeros((nx + ny, ny + nx))
    matrix[:nx, :ny], matrix[:nx, ny:], matrix[nx:, :ny] = -turning, half_x, half_y.T
    solved("eigenproblems")
    left, inverse, right = la.svd(matrix, overwrite_a=True, check_finite=False)
    kept = slice(0, min(count, nx + ny))
    shapes = np.zeros((assembled.size, inverse[kept].size), dtype=complex)
    in_x = la.solve_triangular(lower_x, left[:nx, kept], lower=True, trans="T")
    in_y = la.solve_triangular(lower_y, right[kept, :ny].T, lower=True, trans="T")
    shapes[planes[0]] = scale_x[:, None] * in_x
    shapes[planes[1]] = -1j * scale_y[:, None] * in_y
    return SplitSpectrum(Spectrum(1j * (1.0 / inverse[kept]), shapes, np.empty(0)), 0, None)


class SplitSpectrum(NamedTuple):
    """A spectrum, the number of zero eigenvalues among the 2n, and the families if there are."""

    spectrum: Spectrum
    zero_count: int
    family: IntArray | None


class SpectrumPart(NamedTuple):
    """Eigenvalues with Im λ > 0, shapes (n, m), real eigenvalues, zeros, sense of whirl."""

    values: ComplexArray
    shapes: ComplexArray
    real: FloatArray
    zeros: int
    family: IntArray


def split_spectrum(
    assembled: AssembledSystem, matrices: SpeedMatrices, speed_rad_s: float, count: int
) -> SplitSpectrum | None:
    """Solve an isotropic system at one speed.

    `count`: number of lowest oscillatory modes wanted. Returns None if the system has no complex
    form, its lateral stiffness is negative, or it is free without damping.

    With k = LLᴴ, L⁻¹AL⁻ᴴ = NNᴴ and z = z0 e^{iνt}, ν = 1/μ, conservative whirl is the Hermitian
    problem [[−Ω g̃, N], [Nᴴ, 0]] (x, y) = μ (x, y), real where the complex form is: all ν of both
    signs at once, the lowest as the largest μ. See `spectrum` for the reason of 1/ν and the
    scaling.
    """
    form = complex_form(assembled)
    if form is None:
        return None
    stiffness, damping = form.hermitian_parts(speed_rad_s)
    scaled = scale_by_stiffness(stiffness, form.mass, assembled.body_rate)
    velocity = damping - 1j * speed_rad_s * form.gyroscopic
    circulating = stiffness - 1j * speed_rad_s * form.circulatory
    is_damped = bool(damping.any() or form.circulatory.any())
    if scaled.negative_count or not (scaled.is_definite or is_damped):
        return None
    if is_damped:
        lateral = _damped(form, scaled, circulating, velocity)
    else:
        lateral = _conservative(form, scaled, speed_rad_s, count)
    rest = unturned_modes(assembled, matrices, form)
    return _joined(lateral, rest, count)


def _congruent(lower: Matrix, matrix: Matrix) -> Matrix:
    """Return L⁻¹ A L⁻ᴴ of a Hermitian matrix."""
    inner = la.solve_triangular(lower, matrix, lower=True)
    result = la.solve_triangular(lower, inner.conj().T, lower=True)
    return np.asarray(0.5 * (result + result.conj().T))


def _conservative(
    form: ComplexForm, scaled: Scaled, speed_rad_s: float, count: int
) -> SpectrumPart:
    outer = np.multiply.outer(scaled.scale, scaled.scale)
    lower = la.cholesky(scaled.stiffness, lower=True)
    half = la.solve_triangular(lower, cholesky_of_mass(scaled.mass), lower=True)
    turning = _congruent(lower, speed_rad_s * outer * form.gyroscopic)
    scale = scaled.scale
    m = scale.size
    matrix = np.zeros((2 * m, 2 * m), dtype=np.result_type(turning, half))
    matrix[:m, :m] = -turning
    matrix[:m, m:], matrix[m:, :m] = half, half.conj().T
    # divide and conquer is twice as fast as the default where all vectors are wanted
    solved("eigenproblems")
    inverse, vectors = la.eigh(matrix, overwrite_a=True, check_finite=False, driver="evd")
    order = np.argsort(-np.abs(inverse), kind="stable")[: min(count, 2 * m)]
    frequencies = 1.0 / inverse[order]
    shapes = scale[:, None] * la.solve_triangular(lower, vectors[:m, order], lower=True, trans="C")
    return SpectrumPart(
        1j * np.abs(frequencies),
        _in_the_round(form, shapes, frequencies > 0),
        np.empty(0),
        0,
        np.sign(frequencies).astype(int),
    )


def _damped(
    form: ComplexForm, scaled: Scaled, stiffness: ComplexArray, velocity: ComplexArray
) -> SpectrumPart:
    """Solve the general problem of half the size, also of a free body."""
    outer = np.multiply.outer(scaled.scale, scaled.scale)
    found = general_eigenvalues(scaled, outer * stiffness, outer * velocity)
    nonzero = found.values != 0
    values = found.values[nonzero]
    shapes = scaled.scale[:, None] * found.shapes[:, nonzero]
    is_real = are_real(values)
    # every λ of z stands for itself and its conjugate in the real coordinates
    return whirl_in_the_round(form, values[~is_real], shapes[:, ~is_real])._replace(
        real=np.repeat(values.real[is_real], 2), zeros=2 * int(np.count_nonzero(~nonzero))
    )


def whirl_in_the_round(
    form: ComplexForm, values: ComplexArray, shapes: ComplexArray
) -> SpectrumPart:
    """Return modes of the independent coordinates from those of z.

    `values`: λ of z, none of them real; `shapes`: shape (m, k).
    """
    forward = values.imag > 0
    upper = np.where(forward, values, values.conj())
    inside = _in_the_round(form, shapes, forward)
    return SpectrumPart(upper, inside, np.empty(0), 0, np.where(forward, 1, -1))


def _in_the_round(form: ComplexForm, shapes: ComplexArray, forward: BoolArray) -> ComplexArray:
    """Return amplitudes of the independent coordinates for λ with Im λ > 0."""
    none = np.zeros_like(shapes)
    along = np.where(forward, shapes, none)
    against = np.where(forward, none, shapes)
    return form.whirl_shapes(along, against)


def unturned_modes(
    assembled: AssembledSystem, matrices: SpeedMatrices, form: ComplexForm
) -> SpectrumPart:
    """Solve axial motion and torsion."""
    n, at = assembled.size, form.rest
    if not at.size:
        none = np.empty(0, dtype=int)
        return SpectrumPart(np.empty(0, complex), np.empty((n, 0), complex), np.empty(0), 0, none)
    block = np.ix_(at, at)
    stiffness, damping = matrices.stiffness[block], matrices.damping[block]
    # the spin couples radial motion of order 0 to torsion
    turning = matrices.gyroscopic[block]
    even = 0.5 * (stiffness + stiffness.T)
    scaled = scale_by_stiffness(even, matrices.mass[block], assembled.body_rate)
    if damping.any() or scaled.negative_count:
        found = solve_general(scaled, stiffness, damping + turning, at.size)
    elif turning.any():
        found = solve_gyroscopic(scaled, turning, at.size)
    else:
        omega, vectors = solve_standing(scaled)
        found = Spectrum(1j * omega, vectors.astype(complex), np.empty(0))
    shapes = np.zeros((n, found.eigenvalues.size), dtype=complex)
    shapes[at] = found.shapes
    zeros = 2 * at.size - 2 * found.eigenvalues.size - found.real_eigenvalues.size
    family = np.zeros(found.eigenvalues.size, dtype=int)
    return SpectrumPart(found.eigenvalues, shapes, found.real_eigenvalues, zeros, family)


def _joined(lateral: SpectrumPart, rest: SpectrumPart, count: int) -> SplitSpectrum:
    values = np.concatenate((lateral.values, rest.values))
    order = np.argsort(values.imag, kind="stable")[:count]
    shapes = np.hstack((lateral.shapes, rest.shapes))[:, order]
    real = np.sort(np.concatenate((lateral.real, rest.real)))
    family = np.concatenate((lateral.family, rest.family))[order]
    return SplitSpectrum(Spectrum(values[order], shapes, real), lateral.zeros + rest.zeros, family)
