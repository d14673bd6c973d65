"""A system with fewer coordinates: projected on a basis, or on its lowest modes at rest."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import FloatArray, Matrix
from solidwhirl.rotordyn.core.dense import (
    Scaled,
    hermitian_part,
    scale_by_stiffness,
    solve_standing,
)
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modes.complex_form import complex_form
from solidwhirl.rotordyn.modes.eigen import scaled_stiffness

# Frequencies closer than this (relative) are one mode with two or more shapes.
_SAME_FREQUENCY = 1e-6
# A turn stays in the basis if it leaves it by less than this.
_SAME_TURN = 1e-9


def project_system(assembled: AssembledSystem, basis: npt.ArrayLike) -> AssembledSystem:
    """Restrict a system to the motions of a basis, q = basis · a.

    `basis`: independent columns, shape (n, m), m ≤ n. The result is in the m amplitudes (Galerkin);
    its `transformation` still gives the motion of all bodies, so every analysis works on it.
    Bearings with a speed law are projected as well. `spin_generator` is None if a turn leaves the
    basis. Raises AnalysisError if the basis has another number of rows, no columns, entries that
    are not finite, or dependent columns.
    """
    columns = _checked_basis(assembled, basis)
    return dataclasses.replace(
        assembled,
        mass=_projected(assembled.mass, columns),
        stiffness=_projected(assembled.stiffness, columns),
        gyroscopic=_projected(assembled.gyroscopic, columns),
        centrifugal_stiffness=_projected(assembled.centrifugal_stiffness, columns),
        damping=_projected(assembled.damping, columns),
        circulatory_stiffness=_projected(assembled.circulatory_stiffness, columns),
        law_joints=tuple(
            dataclasses.replace(joint, motion=joint.motion @ columns)
            for joint in assembled.law_joints
        ),
        spin_generator=_projected_turn(assembled.spin_generator, columns),
        transformation=assembled.transformation @ columns,
    )


def truncated_system(assembled: AssembledSystem, mode_count: int) -> AssembledSystem:
    """Restrict a system to its lowest modes at rest.

    `mode_count`: number of modes of M and the symmetric part of K at rest, without damping; rigid
    motions come first. In the amplitudes of the modes, M the unit matrix, the symmetric part of K
    at rest diagonal. Gyroscopic, centrifugal and damping matrices couple them. Raises AnalysisError
    if there are not as many modes, or the last one taken has a partner of the same frequency that
    is left out: half of a pair has no gyroscopic coupling.

    A model that is exact at rest and wrong at speed: Müller and Hennings, section 4.2, need 22
    modes of a shaft where the analytical model has one bending mode per plane.
    """
    if not 1 <= mode_count <= assembled.size:
        raise AnalysisError(f"mode_count is {mode_count}; 1 to {assembled.size} are possible")
    squared, shapes = _turning_modes(assembled)
    same = _partners(squared, mode_count)
    if same is not None:
        raise AnalysisError(
            f"mode_count {mode_count} parts modes of equal frequency "
            f"{np.sqrt(abs(squared[mode_count - 1])) / (2.0 * np.pi):.6g} Hz; take {same[0]} or "
            f"{same[1]}"
        )
    kept, square = shapes[:, :mode_count], np.diag(squared[:mode_count])
    reduced = project_system(assembled, kept)
    # What the projection leaves beside the diagonal is rounding of the stiffest coordinate.
    at_rest = matrices_at_speed(assembled, 0.0).stiffness
    constant = _symmetric(assembled.stiffness) - _symmetric(at_rest)
    skew = _projected(assembled.stiffness - _symmetric(assembled.stiffness), kept)
    stiffness = square + _projected(constant, kept) + skew
    return dataclasses.replace(reduced, mass=np.eye(mode_count), stiffness=stiffness)


def rest_modes(assembled: AssembledSystem) -> tuple[FloatArray, FloatArray]:
    """Return the modes at rest of M and the symmetric part of K.

    Returns `squared_frequency`: ω², rising, (rad/s)², shape (n,); exactly 0 for rigid motions,
    negative for a support with negative stiffness. Returns `shapes`: columns φ with φᵀMφ = 1, shape
    (n, n).
    """
    return _standing(scaled_stiffness(assembled, matrices_at_speed(assembled, 0.0)))


def _standing(scaled: Scaled) -> tuple[FloatArray, Matrix]:
    """Return ω², rising, and shapes of unit modal mass, real if K and M are."""
    if scaled.negative_count:
        squared, shapes = la.eigh(scaled.stiffness, scaled.mass)
        return squared, scaled.scale[:, None] * shapes
    omega, elastic = solve_standing(scaled)
    kernel = scaled.vectors[:, : scaled.zero_count]
    if not kernel.size:
        return omega**2, elastic
    size = la.cholesky(kernel.conj().T @ scaled.mass @ kernel, lower=True)
    rigid = la.solve_triangular(size, kernel.conj().T, lower=True).conj().T
    inner = elastic / scaled.scale[:, None]
    inner = inner - rigid @ (rigid.conj().T @ scaled.mass @ inner)
    squared = np.concatenate((np.zeros(scaled.zero_count), omega**2))
    return squared, scaled.scale[:, None] * np.hstack((rigid, inner))


def _turning_modes(assembled: AssembledSystem) -> tuple[FloatArray, FloatArray]:
    """Return the modes at rest, those of a system with a complex form as pairs z and i z.

    Then the reduced system has complex coordinates like the whole one.
    """
    form = complex_form(assembled)
    if form is None:
        return rest_modes(assembled)
    stiffness, _ = form.hermitian_parts(0.0)
    squared, z = _standing(scale_by_stiffness(stiffness, form.mass, assembled.body_rate))
    lateral = np.zeros((assembled.size, z.shape[1], 2))
    for column, moved in enumerate((z, 1j * z)):
        lateral[form.first, :, column] = moved.real
        lateral[form.second, :, column] = form.second_sign[:, None] * moved.imag
    squares, shapes = [np.repeat(squared, 2)], [lateral.reshape(assembled.size, -1)]
    if form.rest.size:
        at = np.ix_(form.rest, form.rest)
        even = hermitian_part(matrices_at_speed(assembled, 0.0).stiffness[at])
        own, along = _standing(scale_by_stiffness(even, assembled.mass[at], assembled.body_rate))
        squares.append(own)
        shapes.append(np.eye(assembled.size)[:, form.rest] @ along)
    together = np.concatenate(squares)
    order = np.argsort(together, kind="stable")
    return together[order], np.hstack(shapes)[:, order]


def _checked_basis(assembled: AssembledSystem, basis: npt.ArrayLike) -> FloatArray:
    columns = np.array(basis, dtype=float)
    if columns.ndim != 2 or columns.shape[0] != assembled.size or not columns.shape[1]:
        raise AnalysisError(
            f"the basis has shape {columns.shape}; allowed is ({assembled.size}, m) with m ≥ 1"
        )
    if not np.isfinite(columns).all():
        raise AnalysisError("the basis has entries that are not finite")
    length = la.norm(columns, axis=0)
    rank = np.linalg.matrix_rank(columns / np.where(length > 0, length, 1.0))
    if rank < columns.shape[1]:
        raise AnalysisError(
            f"the basis has {columns.shape[1]} columns of rank {rank}; they must be independent"
        )
    return columns


def _symmetric(matrix: FloatArray) -> FloatArray:
    return np.asarray(0.5 * (matrix + matrix.T))


def _projected(matrix: FloatArray, basis: FloatArray) -> FloatArray:
    """Return the projection with symmetric and skew parts exactly so."""
    even = basis.T @ _symmetric(matrix) @ basis
    odd = basis.T @ (matrix - _symmetric(matrix)) @ basis
    return np.asarray(0.5 * (even + even.T) + 0.5 * (odd - odd.T))


def _projected_turn(generator: FloatArray | None, basis: FloatArray) -> FloatArray | None:
    """Return L a of L (basis a) = basis (L a), None if a turn leaves the basis."""
    if generator is None:
        return None
    turned = generator @ basis
    inner, *_ = la.lstsq(basis, turned)
    size = max(float(np.abs(basis).max()), float(np.abs(turned).max()))
    if np.abs(basis @ inner - turned).max() > _SAME_TURN * size:
        return None
    whole = np.round(inner)
    return np.asarray(whole if np.abs(inner - whole).max() < _SAME_TURN else inner)


def _partners(squared: FloatArray, count: int) -> tuple[int, int] | None:
    """Return the counts around a group of equal frequencies that a cut would part."""
    near = _SAME_FREQUENCY * np.abs(squared[count - 1])
    group = np.flatnonzero(np.abs(squared - squared[count - 1]) <= near)
    first, last = int(group[0]), int(group[-1]) + 1
    return None if last == count else (first, last)
