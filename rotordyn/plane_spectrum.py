"""Whirl in supports that differ between two planes but do not couple them, without damping.

Motion in one plane couples to that in the other through the gyroscopic matrix alone, so one may be
taken real and the other imaginary: the modes are the singular vectors of a real matrix.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.complex_form import IndexArray, plane_pairs
from solidwhirl.rotordyn.spectrum import cholesky_of_mass, scale_by_stiffness
from solidwhirl.rotordyn.system import AssembledSystem, SpeedMatrices

# Parts that couple the planes may reach this fraction of the diagonal.
_ROUNDING = 1e-11


class PlaneSpectrum(NamedTuple):
    """ω of the lowest modes, rad/s, rising, and their shapes (n, m)."""

    frequencies: FloatArray
    shapes: ComplexArray


@lru_cache(maxsize=4)
def planes_apart(assembled: AssembledSystem) -> tuple[IndexArray, IndexArray] | None:
    """Return the coordinates of two planes that only the gyroscopic matrix couples.

    Parameters
    ----------
    assembled
        The system.

    Returns
    -------
    tuple of ndarray, or None
        Indices; axial motion and torsion count to the first. None if something else couples
        them, or there is damping.
    """
    pairs = plane_pairs(assembled)
    if pairs is None or not assembled.is_conservative or not pairs.first.size:
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
) -> PlaneSpectrum | None:
    """Solve an undamped system whose two planes only spin couples.

    Parameters
    ----------
    assembled
        The system.
    matrices
        Its matrices at one speed.
    count
        Number of lowest modes wanted.

    Returns
    -------
    PlaneSpectrum or None
        None if the planes are coupled otherwise, or K is not positive definite.

    Notes
    -----
    With K = LLᵀ, L⁻¹ML⁻ᵀ = NNᵀ in each plane and g the block of ΩG, x real, y = i times real:
    1/ω are the singular values of [[−g̃, Nx], [Nyᵀ, 0]]. Only digits relative to the lowest
    frequency count, as in `spectrum`.
    """
    planes = planes_apart(assembled)
    if planes is None:
        return None
    factors = []
    for at in planes:
        block = np.ix_(at, at)
        scaled = scale_by_stiffness(
            matrices.stiffness[block], matrices.mass[block], assembled.body_rate
        )
        if not scaled.is_definite:
            return None
        lower = la.cholesky(scaled.stiffness, lower=True)
        half = la.solve_triangular(lower, cholesky_of_mass(scaled.mass), lower=True)
        factors.append((scaled.scale, lower, half))
    (scale_x, lower_x, half_x), (scale_y, lower_y, half_y) = factors
    nx, ny = scale_x.size, scale_y.size
    turning = scale_x[:, None] * matrices.gyroscopic[np.ix_(*planes)] * scale_y
    turning = la.solve_triangular(lower_x, turning, lower=True)
    turning = la.solve_triangular(lower_y, turning.T, lower=True).T
    matrix = np.zeros((nx + ny, ny + nx))
    matrix[:nx, :ny], matrix[:nx, ny:], matrix[nx:, :ny] = -turning, half_x, half_y.T
    left, inverse, right = la.svd(matrix, overwrite_a=True, check_finite=False)
    kept = slice(0, min(count, nx + ny))
    shapes = np.zeros((assembled.size, inverse[kept].size), dtype=complex)
    in_x = la.solve_triangular(lower_x, left[:nx, kept], lower=True, trans="T")
    in_y = la.solve_triangular(lower_y, right[kept, :ny].T, lower=True, trans="T")
    shapes[planes[0]] = scale_x[:, None] * in_x
    shapes[planes[1]] = -1j * scale_y[:, None] * in_y
    return PlaneSpectrum(1.0 / inverse[kept], shapes)
