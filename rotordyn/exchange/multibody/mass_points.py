"""Points of mass that move as a body does, as far as its inertia is concerned."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.exchange.multibody.body_fixed import BodyFixedForm

# Directions of less than this share of the largest moment are rounding errors, as is less than
# minus this share.
_ROUNDING = 1e-13
_NOT_A_BODY = 1e-9


class MassPoints(NamedTuple):
    """Points of mass (k,), their places (k, 3), and displacement per elastic mode (k, 3, m)."""

    masses_kg: FloatArray
    positions_m: FloatArray
    shapes: FloatArray


def equivalent_mass_points(form: BodyFixedForm) -> MassPoints:
    """Find points of mass that have all moments of a body in a floating frame.

    `form`: the body with m modes. Returns at most 3 m + 4 points of one mass. Mass, centre of
    gravity, inertia, modal mass and the integrals I3, I4, I5, I8, I9 summed over them are those of
    the body. Raises SuperelementError if no masses have these moments: the body's moments
    contradict each other.

    The functions 1, x, y, z and the components of all modes have a Gram matrix Q over the mass.
    With Q = Fᵀ F each row of F, divided by its first entry, is a point of the square of that
    entry as mass. A reflection makes all first entries equal, so that none is zero.
    """
    gram, scale = _scaled_gram(form)
    values, vectors = la.eigh(gram)
    if values[0] < -_NOT_A_BODY * values[-1]:
        raise SuperelementError(
            f"body {form.name!r}: its mass moments contradict each other (a sum of squares is "
            f"{values[0] / values[-1]:.3g} of the largest), so that no points of mass have them; "
            "allowed are the levels that need none"
        )
    kept = values > _ROUNDING * values[-1]
    factor = np.sqrt(values[kept])[:, None] * vectors[:, kept].T * scale
    size = factor.shape[0]
    first = np.linalg.norm(factor[:, 0])
    factor = _reflected(factor, np.full(size, first / np.sqrt(size)))
    functions = factor / factor[:, :1]
    m = form.frequencies_hz.size
    return MassPoints(
        masses_kg=np.full(size, first**2 / size),
        positions_m=functions[:, 1:4],
        shapes=functions[:, 4:].reshape(size, 3, m),
    )


def _scaled_gram(form: BodyFixedForm) -> tuple[FloatArray, FloatArray]:
    """Return the Gram matrix of 1, x, y, z, φ_xj, φ_yj, φ_zj with unit diagonal, and its scale."""
    m = form.frequencies_hz.size
    gram = np.zeros((4 + 3 * m, 4 + 3 * m))
    gram[0, 0] = form.mass_kg
    gram[0, 1:4] = gram[1:4, 0] = form.mass_kg * form.center_of_gravity_m
    gram[1:4, 1:4] = 0.5 * np.trace(form.inertia_kg_m2) * np.eye(3) - form.inertia_kg_m2
    gram[0, 4:] = gram[4:, 0] = form.I3.ravel()
    first = _dyads(-form.I8)
    gram[4:, 1:4] = first.transpose(0, 2, 1).reshape(-1, 3)
    gram[1:4, 4:] = gram[4:, 1:4].T
    # I9_jk holds the dyad φ_k φ_jᵀ
    gram[4:, 4:] = _dyads(form.I9).transpose(0, 3, 1, 2).reshape(3 * m, 3 * m)
    gram = 0.5 * (gram + gram.T)
    own = np.diag(gram)
    # components that modes lack but for rounding must not be scaled up
    still = 4 + np.flatnonzero(own[4:] <= _ROUNDING * own[4:].max(initial=0.0))
    gram[still], gram[:, still] = 0.0, 0.0
    scale = np.sqrt(np.maximum(np.diag(gram), 0.0))
    scale[scale == 0.0] = 1.0
    return gram / np.outer(scale, scale), scale


def _dyads(products: FloatArray) -> FloatArray:
    """Return ∫ b aᵀ from ∫ ã b̃, shape (3, 3, ...)."""
    trace = 0.5 * np.einsum("aa...->...", products)
    return np.asarray(products - np.multiply.outer(np.eye(3), trace))


def _reflected(factor: FloatArray, first: FloatArray) -> FloatArray:
    """Return the rows turned so that the first column is the given one, of the same length."""
    normal = factor[:, 0] - first
    length = normal @ normal
    if length <= np.finfo(float).eps ** 2 * (first @ first):
        return factor
    return np.asarray(factor - np.outer(normal, (2.0 / length) * (normal @ factor)))
