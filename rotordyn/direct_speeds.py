"""Critical speeds for constant bearings, directly from one eigenproblem."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.errors import AnalysisError
from solidwhirl.rotordyn.spectrum import Scaled, scale_by_stiffness
from solidwhirl.rotordyn.whirl_pencils import Pencil

# A motion without stiffness whose inertia N is below this fraction of the largest has none.
_NO_INERTIA = 1e-10


class DirectSpeeds(NamedTuple):
    """Critical speeds in rad/s, rising, shape (k,), and their shapes x, (m, k)."""

    speeds_rad_s: FloatArray
    shapes: FloatArray | ComplexArray


def direct_speeds(
    pencil: Pencil, stiffness: FloatArray, body_rate: float, limit_rad_s: float
) -> DirectSpeeds:
    """Solve K x = Ω² N x with K positive (semi)definite.

    Parameters
    ----------
    pencil
        Gives M and N.
    stiffness
        K with all bearings, shape (m, m).
    body_rate
        See `spectrum.scale_by_stiffness`.
    limit_rad_s
        Speeds above are left out; may be infinite.

    Returns
    -------
    DirectSpeeds
        An eigenvalue Ω² that is negative or infinite belongs to no speed.

    Raises
    ------
    AnalysisError
        If K has a negative eigenvalue, or a free body whirls without force at every speed.

    Notes
    -----
    Motions without stiffness (kernel of K) follow from the rest: N_kk a + N_kc c = 0.
    """
    scaled = scale_by_stiffness(stiffness, pencil.mass, body_rate)
    if scaled.negative_count:
        raise AnalysisError(
            f"the stiffness has {scaled.negative_count} negative eigenvalues; critical speeds are "
            "found directly for supports that resist every motion or let it be"
        )
    inertia = scaled.scale[:, None] * pencil.inertia * scaled.scale
    # Cholesky of the scaled K keeps more digits than its eigenvectors where it exists.
    if scaled.is_definite:
        lower = la.cholesky(scaled.stiffness, lower=True)
        basis = la.solve_triangular(lower, np.eye(scaled.scale.size), lower=True, trans="T")
    else:
        stiff = slice(scaled.zero_count, None)
        elastic = scaled.vectors[:, stiff] / np.sqrt(scaled.eigenvalues[stiff])
        kernel = _kernel(scaled)
        free = _kernel_inertia(inertia, kernel)
        if not elastic.size:
            return DirectSpeeds(np.empty(0), elastic)
        basis = elastic - kernel @ la.solve(free, kernel.T @ inertia @ elastic)
    reduced = basis.conj().T @ inertia @ basis
    values, vectors = la.eigh(0.5 * (reduced + reduced.conj().T))
    smallest = 64.0 * values.size * np.finfo(float).eps * np.abs(values).max(initial=0.0)
    kept = np.flatnonzero(values > max(smallest, 1.0 / limit_rad_s**2))[::-1]
    shapes = scaled.scale[:, None] * (basis @ vectors[:, kept])
    return DirectSpeeds(1.0 / np.sqrt(values[kept]), shapes)


def negative_count_at_rest(pencil: Pencil, body_rate: float) -> int:
    """Return how many eigenvalues of D(Ω) are negative as Ω goes to zero.

    Parameters
    ----------
    pencil
        The problem.
    body_rate
        See `spectrum.scale_by_stiffness`.

    Returns
    -------
    int
        Those of K(0), and on its kernel those of −N.

    Raises
    ------
    AnalysisError
        If a free body whirls without force at every speed.
    """
    scaled = scale_by_stiffness(pencil.stiffness_at(0.0), pencil.mass, body_rate)
    if not scaled.zero_count:
        return scaled.negative_count
    inertia = scaled.scale[:, None] * pencil.inertia * scaled.scale
    free = _kernel_inertia(inertia, _kernel(scaled))
    return scaled.negative_count + int(np.count_nonzero(la.eigvalsh(free) > 0))


def negative_count(pencil: Pencil, speed_rad_s: float, body_rate: float) -> int:
    """Return how many eigenvalues of D(Ω) are negative at a speed.

    Parameters
    ----------
    pencil
        The problem.
    speed_rad_s
        Ω > 0.
    body_rate
        See `spectrum.scale_by_stiffness`.

    Returns
    -------
    int
        Number of modes below the excitation.
    """
    scaled = scale_by_stiffness(pencil.stiffness_at(speed_rad_s), pencil.mass, body_rate)
    inertia = scaled.scale[:, None] * pencil.inertia * scaled.scale
    return int(np.count_nonzero(la.eigvalsh(scaled.stiffness - speed_rad_s**2 * inertia) < 0))


def _kernel(scaled: Scaled) -> FloatArray:
    """Return the motions without stiffness, which follow those of negative stiffness."""
    return scaled.vectors[:, scaled.negative_count : scaled.negative_count + scaled.zero_count]


def _kernel_inertia(
    inertia: FloatArray | ComplexArray, kernel: FloatArray
) -> FloatArray | ComplexArray:
    """Return N of the motions without stiffness, refusing one that is singular."""
    free = kernel.T @ inertia @ kernel
    size = np.abs(la.eigvalsh(free))
    if size.min() < _NO_INERTIA * size.max():
        raise AnalysisError(
            "a free body whirls at this excitation ratio without any force (polar over diametral "
            "inertia equals the ratio), so every speed is critical; support its tilt"
        )
    return np.asarray(free)
