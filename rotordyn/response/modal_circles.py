"""Responses at many frequencies of one speed: modes of the bodies once, bearings as a coupling.

Bodies on the even part of their bearings, undamped, are a Hermitian problem of each speed: with its
modes D(ω)⁻¹ costs no factorisation. What bearings have beside that, damping and unevenness, acts on
few motions U q and comes in as a change of low rank (Woodbury; Hager 1989, SIAM Review 31). Exact
but for rounding, which the residual of every point tells.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import BoolArray, ComplexArray, FloatArray, Matrix
from solidwhirl.rotordyn.core.ledger import solved
from solidwhirl.rotordyn.response.coupled_circles import (
    SplitSystem,
    circle_loads,
    couplings,
    is_poor,
)
from solidwhirl.rotordyn.response.points import MatrixTriple, ScaledMatrices, Solved, measured


class _Modes(NamedTuple):
    """Modes of K + ωG − ω²M: 1/ω_k of both signs, (2m,), and shapes of unit energy, (m, 2m).

    D(ω)⁻¹ = X diag(1 / (1 − ω/ω_k)) Xᴴ, with xᴴ (K + ω_k² M) x = 1.
    """

    inverse: FloatArray
    shapes: Matrix
    matrices: MatrixTriple


def solve_by_modes(
    split: SplitSystem, speeds: FloatArray, frequencies: FloatArray, force: ComplexArray
) -> tuple[Solved, BoolArray]:
    """Solve for the lateral response at each point, and say which were left unsolved (p,).

    `split`: of `split_bodies`, whose isotropic part is undamped. Arguments and returns are else
    those of `solve_split`. A speed at which the isotropic part has no positive definite stiffness
    is left unsolved.
    """
    form, loads = split.form, circle_loads(split.form, force).transpose(1, 2, 0, 3)
    circles = np.zeros(loads.shape, dtype=complex)
    residual, unsolved = np.zeros(speeds.size), np.zeros(speeds.size, dtype=bool)
    loaded = loads.any(axis=(0, 1, 3))
    scaled = ScaledMatrices(form.at_speed, float(speeds[0]), float(np.abs(frequencies).max()))
    scale = scaled.scale[:, None, None]
    unit = 0.5 * (split.turned * scaled.scale).conj().T
    for speed in np.unique(speeds[loaded]):
        points = np.flatnonzero(loaded & (speeds == speed))
        modes = _modes_of(scaled.at(float(speed)))
        if modes is None:
            unsolved[points] = True
            continue
        omega, own = frequencies[points], loads[:, :, points] * scale
        coupling = couplings(split, speeds[points], omega)
        found, pulled = _solved(modes, omega, own, coupling, unit)
        residual[points], growth = _measured(modes.matrices, omega, own, found, pulled)
        unsolved[points] = is_poor(residual[points], growth)
        circles[:, :, points] = found * scale
    displacement = form.whirl_shapes(circles[0], circles[1].conj()).swapaxes(0, 1)
    return Solved(np.ascontiguousarray(displacement), residual), unsolved


def _modes_of(matrices: MatrixTriple) -> _Modes | None:
    """Return the modes of M, V = −iG and K; None if K is not positive definite.

    With K = LLᴴ and M = NNᴴ: [[−L⁻¹GL⁻ᴴ, L⁻¹N], [NᴴL⁻ᴴ, 0]] (Lᴴx, y) = 1/ω (Lᴴx, y).
    """
    mass, velocity, stiffness = matrices
    try:
        lower = la.cholesky(stiffness, lower=True, check_finite=False)
        half = la.solve_triangular(lower, la.cholesky(mass, lower=True), lower=True)
    except la.LinAlgError:
        return None
    turning = np.asarray(1j * velocity)
    right = turning.real if np.isrealobj(half) else turning
    inner = la.solve_triangular(lower, right, lower=True)
    inner = la.solve_triangular(lower, inner.conj().T, lower=True)
    m = lower.shape[0]
    matrix = np.zeros((2 * m, 2 * m), dtype=half.dtype)
    matrix[:m, :m] = -0.5 * (inner + inner.conj().T)
    matrix[:m, m:], matrix[m:, :m] = half, half.conj().T
    solved("eigenproblems")
    inverse, vectors = la.eigh(matrix, overwrite_a=True, check_finite=False, driver="evd")
    shapes = la.solve_triangular(lower, vectors[:m], lower=True, trans="C")
    return _Modes(inverse, shapes, matrices)


def _solved(
    modes: _Modes,
    omega: FloatArray,
    loads: ComplexArray,
    coupling: ComplexArray,
    unit: ComplexArray,
) -> tuple[ComplexArray, ComplexArray]:
    """Return both circles, and what the coupling pulls on them, (2, m, p, r) each.

    `loads`: (2, m, p, r); `coupling`: k + iωc, (p, rows, rows); `unit`: load of the forward circle
    of a unit force on U q, (m, rows); that of the mirrored one is its conjugate.
    """
    shape, rows, states = loads.shape, unit.shape[1], modes.inverse.size
    flat, columns = (2, -1, shape[2] * shape[3]), (rows, shape[2], shape[3])
    shapes, units = ((x, x.conj()) for x in (modes.shapes, unit))
    sides = np.stack([_product(x.conj().T, u) for x, u in zip(shapes, units, strict=True)])
    modal = [_product(x.conj().T, f) for x, f in zip(shapes, loads.reshape(flat), strict=True)]
    weights = 1.0 / (1.0 - np.stack([np.outer(modes.inverse, s * omega) for s in (1.0, -1.0)]))
    bent = weights[..., None] * np.reshape(modal, (2, states, *shape[2:]))
    # motions U q of unit forces: U X is twice the conjugate of Xᴴ unit
    pairs = 2.0 * (sides[0].conj()[:, :, None] * sides[0][:, None]).reshape(states, rows * rows)
    along, against = (_product(w.T, pairs).reshape(omega.size, rows, rows) for w in weights)
    moved = 2.0 * (sides.conj().swapaxes(1, 2) @ bent.reshape(flat)).sum(axis=0)
    small = np.eye(rows) + coupling @ (along + against.conj())
    pull = np.linalg.solve(small, coupling @ moved.reshape(columns).swapaxes(0, 1))
    held = (sides @ pull.swapaxes(0, 1).reshape(rows, flat[2])).reshape(bent.shape)
    amplitudes = (bent - weights[..., None] * held).reshape(flat)
    circles = np.stack([_product(x, a) for x, a in zip(shapes, amplitudes, strict=True)])
    reached = 2.0 * sum(u.conj().T @ z for u, z in zip(units, circles, strict=True))
    force = (coupling @ reached.reshape(columns).swapaxes(0, 1)).swapaxes(0, 1)
    pulled = np.stack([u @ force.reshape(rows, flat[2]) for u in units])
    return circles.reshape(shape), pulled.reshape(shape)


def _measured(
    matrices: MatrixTriple,
    omega: FloatArray,
    loads: ComplexArray,
    circles: ComplexArray,
    pulled: ComplexArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the largest |f − D q| / |f| and |D| |q| / |f| of each point, (p,) each."""
    mass, velocity, stiffness = matrices
    turning = 1j * velocity
    error = loads - pulled
    for side, sign in enumerate((1.0, -1.0)):
        for matrix, factor in (
            (stiffness, np.ones_like(omega)),
            (turning, sign * omega),
            (mass, -(omega**2)),
        ):
            own = matrix if side == 0 else matrix.conj()
            product = _product(own, circles[side].reshape(len(own), -1))
            error[side] -= factor[:, None] * product.reshape(error[side].shape)
    sizes = [float(la.norm(matrix)) ** 2 for matrix in (stiffness, turning, mass)]
    mixed = float(np.vdot(stiffness, mass).real)
    size = sizes[0] + omega**2 * (sizes[1] - 2.0 * mixed) + omega**4 * sizes[2]
    by_point = (a.transpose(2, 0, 1, 3) for a in (loads, circles, error))
    return measured(np.sqrt(2.0 * np.maximum(size, 0.0)), *by_point)


def _product(matrix: Matrix, columns: ComplexArray) -> ComplexArray:
    """Return a matrix times columns (m, k), at half the work if it is real."""
    if np.iscomplexobj(matrix) and matrix.imag.any():
        return np.asarray(matrix @ columns)
    parts = np.ascontiguousarray(columns).view(float)
    return np.asarray((np.ascontiguousarray(matrix.real) @ parts).view(complex))
