"""The motion of one body split by how it turns: parts of circumferential order 0, ±1, ±2, ..."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray, ReadOnlyArrays
from solidwhirl.rotordyn.superelement.record import Superelement
from solidwhirl.rotordyn.superelement.surface import around_axis


def products_around(left: int, right: int, products: FloatArray) -> FloatArray:
    """Return ∫ φ_aj φ_bk dm in Cartesian directions from products of amplitudes.

    The amplitudes (a, b, c) of order n stand for u_r = a cos nθ, u_θ = b sin nθ, u_z = c cos nθ
    (cos family) and u_r = a sin nθ, u_θ = -b cos nθ, u_z = c sin nθ (sin family); those of order 0
    are u_r, u_θ, u_z themselves.

    `left`, `right`: circumferential orders; `products`: ∫ of amplitude times amplitude over the
    mass per unit angle, shape (3, 3, j, k). Returns shape (3, 3, families · j, families · k): cos
    family, then sin family; order 0 has one.
    """
    # sums over equal steps are exact for trigonometric polynomials of a lower degree
    count = left + right + 3
    theta = 2.0 * np.pi * np.arange(count) / count
    weights = np.einsum("tafi,tbgl->abfgil", _cartesian(left, theta), _cartesian(right, theta))
    quarters = np.round(8.0 * weights / count)  # of π, whole numbers but for rounding
    out = np.einsum("abfgil,iljk->abfjgk", 0.25 * np.pi * quarters, products, optimize=True)
    rows, columns = (out.shape[i] * out.shape[i + 1] for i in (2, 4))
    return np.asarray(out.reshape(3, 3, rows, columns))


def _cartesian(order: int, theta: FloatArray) -> FloatArray:
    """Displacement x, y, z per amplitude a, b, c of each family, (angles, 3, families, 3)."""
    families = (0, 1) if order else (0,)
    unit = np.eye(3)
    moved = [around_axis(unit, order, f, theta).transpose(0, 2, 1) for f in families]
    return np.stack(moved, axis=2)


# Orders are whole numbers, and L is skew in the product with M, to this accuracy.
_EXACT = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Turns(ReadOnlyArrays):
    """Hold the coordinates of a body in which a turn about the axis is a change of phase.

    A part of order μ obeys L q = iμ q with the generator L of a turn. In q e^{iωt}, ω > 0, it
    is a pattern of |μ| waves round the axis that turns about +z for μ > 0 and about −z for
    μ < 0; μ = ±1 is lateral motion, forward and backward for a positive Ω.

    `orders`: μ of each part, shape (r,), rising; r = n but for bodies with a constraint.
    `amplitudes`: takes coordinates to the parts, shape (r, n); |part|² adds up to qᴴ M q.
    `vectors`: takes the parts to coordinates, shape (n, r).
    """

    orders: IntArray
    amplitudes: ComplexArray
    vectors: ComplexArray

    def lateral(self) -> FloatArray:
        """Return the projector on the lateral motion, |μ| = 1, shape (n, n), real."""
        kept = np.abs(self.orders) == 1
        return np.asarray((self.vectors[:, kept] @ self.amplitudes[kept]).real)


def body_turns(element: Superelement) -> Turns | None:
    """Return the parts of a body's motion by circumferential order.

    Returns None if the body does not know its generator, or if the generator does not keep M, as in
    a body that is not one of revolution.

    With M = RRᵀ and y = Rᵀq the generator becomes RᵀLR⁻ᵀ, skew because a turn keeps the kinetic
    energy; i times it is Hermitian with whole eigenvalues.
    """
    if element.spin_generator is None:
        return None
    free = np.eye(element.size) if element.constraint is None else element.constraint
    spread = np.linalg.pinv(free)
    turned = element.spin_generator @ free
    inner = spread @ turned
    # A place off the axis does not turn within its own coordinates.
    if np.abs(free @ inner - turned).max(initial=0.0) > _EXACT * np.abs(free).max(initial=1.0):
        return None
    try:
        factor = la.cholesky(free.T @ element.mass @ free, lower=True)
    except la.LinAlgError:
        return None
    turn = la.solve_triangular(factor, (factor.T @ inner).T, lower=True).T
    size = max(float(np.abs(turn).max(initial=0.0)), 1.0)
    if np.abs(turn + turn.T).max(initial=0.0) > _EXACT * size:
        return None
    values, vectors = la.eigh(-0.5j * (turn - turn.T))
    orders = np.round(values)
    if np.abs(values - orders).max(initial=0.0) > _EXACT * size:
        return None
    return Turns(
        orders=orders.astype(int),
        amplitudes=vectors.conj().T @ factor.T @ spread,
        vectors=free @ la.solve_triangular(factor, vectors, lower=True, trans="T"),
    )
