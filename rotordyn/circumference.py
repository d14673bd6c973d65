"""Products of displacement fields of circumferential orders, integrated around the axis."""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray


def products_around(left: int, right: int, products: FloatArray) -> FloatArray:
    """Return ∫ φ_aj φ_bk dm in Cartesian directions from products of amplitudes.

    The amplitudes (a, b, c) of order n stand for u_r = a cos nθ, u_θ = b sin nθ, u_z = c cos nθ
    (cos family) and u_r = a sin nθ, u_θ = -b cos nθ, u_z = c sin nθ (sin family); those of order 0
    are u_r, u_θ, u_z themselves.

    Parameters
    ----------
    left, right
        Circumferential orders.
    products
        ∫ of amplitude times amplitude over the mass per unit angle, shape (3, 3, j, k).

    Returns
    -------
    ndarray
        Shape (3, 3, families · j, families · k): cos family, then sin family; order 0 has one.
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
    cos, sin = np.cos(order * theta), np.sin(order * theta)
    families = [(cos, sin), (sin, -cos)] if order else [(cos, cos)]
    out = np.zeros((len(theta), 3, len(families), 3))
    for f, (radial, tangential) in enumerate(families):
        out[:, 0, f, 0], out[:, 0, f, 1] = radial * np.cos(theta), -tangential * np.sin(theta)
        out[:, 1, f, 0], out[:, 1, f, 1] = radial * np.sin(theta), tangential * np.cos(theta)
        out[:, 2, f, 2] = radial
    return out
