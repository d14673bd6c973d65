"""Left eigenvectors of a system at a speed, for the first-order change of its eigenvalues."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.system import SpeedMatrices
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, together
from solidwhirl.rotordyn.modes.eigen import Modes
from solidwhirl.rotordyn.modes.nearby import balance_of, moved_apart

# Eigenvalues closer than this (relative) share a subspace, any basis of which is one of modes.
_SAME = 1e-6
# |Re s| below this fraction of |s| is rounding where nothing is damped.
_UNDAMPED = 1e-9
# The matrix that is inverted is taken beside the eigenvalue by this fraction, not to be singular.
_BESIDE = 1e-11
_STEPS = 2
# Entries below this fraction of what the diagonals of K and M make of them are rounding.
_ROUNDING = 1e-11


class ModePairs(NamedTuple):
    """Eigenvalues s (m,), right vectors x and left vectors y, each (n, m).

    yᵀ D(s) = 0, scaled to y_iᵀ [(s_i + s_j) M + C + ΩG] x_j = 1 for i = j, and 0 for other modes.
    """

    rates: ComplexArray
    right: ComplexArray
    left: ComplexArray


def mode_pairs(matrices: SpeedMatrices, modes: Modes) -> ModePairs:
    """Return the modes of a system with their left vectors.

    `matrices`: of the system at the speed of the modes. `modes`: modes; those of equal frequency
    are best all there. Without damping and with K symmetric the left vector is the conjugate of the
    right one; where a mirror turns D(s) into its transpose, its image (`mirror_signs`); else it
    comes from two steps of inverse iteration with D(s)ᵀ, equal eigenvalues together.
    """
    rates, right = modes.eigenvalues, modes.shapes.astype(complex)
    groups = together(np.abs(rates[:, None] - rates) <= _SAME * np.abs(rates))
    symmetric = not matrices.damping.any() and np.array_equal(
        matrices.stiffness, matrices.stiffness.T
    )
    if symmetric and (np.abs(rates.real) <= _UNDAMPED * np.abs(rates)).all():
        left = right.conj()
    elif (signs := mirror_signs(matrices)) is not None:
        left = signs[:, None] * right
    else:
        left = np.zeros_like(right)
        for at, columns in moved_apart(matrices, right):
            part = matrices.part(at)
            for group in groups:
                own = np.intersect1d(group, columns)
                if own.size:
                    place = np.ix_(at, own)
                    left[place] = _left_of_group(part, rates[own], right[place])
    products = state_products(matrices, rates, left, right)
    alone = np.array([group[0] for group in groups if group.size == 1], dtype=int)
    scaled = left.copy()
    scaled[:, alone] /= np.diag(products)[alone]
    for group in groups:
        if group.size > 1:
            product = products[np.ix_(group, group)]
            scaled[:, group] = np.linalg.solve(product, left[:, group].T).T
    return ModePairs(rates, right, scaled)


def state_products(
    matrices: SpeedMatrices, rates: ComplexArray, left: ComplexArray, right: ComplexArray
) -> ComplexArray:
    """Return y_iᵀ [(s_i + s_j) M + C + ΩG] x_j, shape (m, m): the product of the states."""
    inertia = left.T @ matrices.mass @ right
    velocity = left.T @ (matrices.damping + matrices.gyroscopic) @ right
    return np.asarray((rates[:, None] + rates) * inertia + velocity)


def mirror_signs(matrices: SpeedMatrices) -> FloatArray | None:
    """Return signs t of the coordinates with D(s)ᵀ = T D(s) T, T = diag(t), for every s; or None.

    Symmetric entries join coordinates of one sign, skew ones those of opposite signs. Bearings that
    push each plane by itself do so, and the spin and isotropic cross terms couple two planes, so
    that t is 1 in one of them and -1 in the other. Then yᵀ D(s) = 0 for y = T x.
    """
    stiffness, inertia = (np.sqrt(np.abs(np.diag(m))) for m in (matrices.stiffness, matrices.mass))
    joins = np.zeros((2, *matrices.mass.shape), dtype=bool)
    for matrix, size in (
        (matrices.mass, inertia),
        (matrices.damping + matrices.gyroscopic, np.sqrt(inertia * stiffness)),
        (matrices.stiffness, stiffness),
    ):
        allowed = 2.0 * _ROUNDING * np.multiply.outer(size, size)
        joins |= np.abs((matrix + matrix.T, matrix - matrix.T)) > allowed
    even, odd = joins
    # every coordinate twice, once of each sign: none may be joined to itself of the other
    n = len(even)
    label = np.empty(2 * n, dtype=int)
    for number, group in enumerate(together(np.block([[even, odd], [odd, even]]))):
        label[group] = number
    if (label[:n] == label[n:]).any():
        return None
    return np.where(label[:n] < label[n:], 1.0, -1.0)


def dynamic_stiffness(matrices: SpeedMatrices, rate: complex) -> ComplexArray:
    """Return D(s) = K + s (C + ΩG) + s² M, shape (n, n)."""
    velocity = matrices.damping + matrices.gyroscopic
    return np.asarray(matrices.stiffness + rate * velocity + rate**2 * matrices.mass)


def _left_of_group(
    matrices: SpeedMatrices, rates: ComplexArray, right: ComplexArray
) -> ComplexArray:
    """Return a basis of the left vectors of one eigenvalue, beginning with the conjugates."""
    rate = complex(rates.mean()) * (1.0 + _BESIDE)
    balance = balance_of(matrices, rate)[:, None]
    factors = la.lu_factor(balance * dynamic_stiffness(matrices, rate).T * balance.T)
    vectors = right.conj() / balance
    for _ in range(_STEPS):
        vectors, _ = np.linalg.qr(la.lu_solve(factors, vectors))
    return np.asarray(balance * vectors)
