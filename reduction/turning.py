"""How the coordinates of a reduced solid change in a small turn of its field about the axis."""

from __future__ import annotations

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from solidwhirl.reduction.craig_bampton import Basis
from solidwhirl.reduction.operators import BodyOperators
from solidwhirl.reduction.vectors import project

FloatArray = NDArray[np.float64]
# The projected generator has singular values 1 (lateral motion) and 0 (axial motion and torsion).
_TURNS = 0.5
# Its entries are -1, 0 and 1 but for rounding in modes of equal frequency.
_WHOLE = 1e-5


def turn_generator(
    operators: BodyOperators, basis: Basis, mass: FloatArray
) -> tuple[FloatArray | None, FloatArray]:
    """Return the spin generator of a solid in its reduced coordinates.

    Parameters
    ----------
    operators, basis
        Of the solid.
    mass
        (n, n) reduced mass matrix.

    Returns
    -------
    generator : ndarray or None
        (n, n) L of the superelement, in coordinates whose sign is changed by `signs`; None if the
        modes do not come in pairs that turn into each other, as the highest of a coarse mesh.
    signs : ndarray
        (n,) 1 or -1, so that the second mode of each pair is the first one turned by 90°.

    Notes
    -----
    The mesh is the same after a quarter turn, so the projected form M⁻¹ ∫ ρ v·(e_z×u - D u) is
    exactly i times a positive matrix on fields of order 1; its polar factor in the metric of M
    is the quarter turn itself, free of the error of the mesh.
    """
    change = project(operators.turn, basis.vectors, operators.comm)
    lower = scipy.linalg.cholesky(mass, lower=True)
    scaled = scipy.linalg.solve_triangular(lower, change, lower=True)
    scaled = scipy.linalg.solve_triangular(lower, scaled.T, lower=True).T
    left, values, right = scipy.linalg.svd(0.5 * (scaled - scaled.T))
    turning = values > _TURNS
    quarter = left[:, turning] @ right[turning]
    generator = scipy.linalg.solve_triangular(lower, quarter @ lower.T, lower=True, trans="T")
    whole = np.round(generator)
    if np.abs(generator - whole).max(initial=0.0) > _WHOLE:
        return None, np.ones(len(whole))
    signs = np.ones(len(whole))
    for k in range(basis.interface_count, len(whole) - 1):
        # an interior pair in which the second mode turns into the first one
        if whole[k, k + 1] == 1.0 and whole[k + 1, k] == -1.0:
            signs[k + 1] = -1.0
    return whole * np.outer(signs, signs), signs


def evenly_turned_motions(rigid: FloatArray, generator: FloatArray | None) -> FloatArray:
    """Return the rigid motions of a body of revolution without the rounding that tells x from y.

    Parameters
    ----------
    rigid
        (n, 6) ux, uy, uz, rx, ry, rz in reduced coordinates.
    generator
        (n, n) L with entries -1, 0, 1; None leaves the motions as they are.

    Notes
    -----
    A turn takes ux to uy and rx to ry: L R = R T, hence R = -L R T, and the mean of both is taken.
    """
    if generator is None:
        return rigid
    turned = np.zeros((6, 6))
    turned[1, 0] = turned[4, 3] = 1.0
    turned[0, 1] = turned[3, 4] = -1.0
    lateral = np.abs(generator).any(axis=0)
    out = rigid.copy()
    even = 0.5 * (rigid - generator @ rigid @ turned)
    columns = turned.any(axis=0)
    out[np.ix_(lateral, columns)] = even[np.ix_(lateral, columns)]
    out[np.ix_(~lateral, columns)] = 0.0
    return out


def evenly_turned(matrix: FloatArray, generator: FloatArray | None) -> FloatArray:
    """Return a matrix of a body of revolution without the rounding that tells x from y.

    Parameters
    ----------
    matrix
        (n, n) in reduced coordinates.
    generator
        (n, n) L with entries -1, 0, 1; None leaves the matrix as it is.
    """
    if generator is None:
        return matrix
    lateral = np.abs(generator).any(axis=0)
    even = 0.5 * (matrix + generator.T @ matrix @ generator)
    out = np.zeros_like(matrix)
    out[np.ix_(lateral, lateral)] = even[np.ix_(lateral, lateral)]
    out[np.ix_(~lateral, ~lateral)] = matrix[np.ix_(~lateral, ~lateral)]
    return out
