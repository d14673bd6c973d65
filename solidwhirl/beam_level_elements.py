"""Beam and rod elements whose cross-section varies along them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solidwhirl.beam_level_profile import Column
from solidwhirl.beam_level_sections import (
    SectionInertia,
    SectionStiffness,
    ShearRule,
    StiffRadii,
    section_inertia,
    section_stiffness,
)
from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.beam_elements import shapes_at

# Products of two cubic shapes with an inertia of degree four: degree 10, six points are exact.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(6)  # type: ignore[no-untyped-call]
_POINTS, _WEIGHTS = 0.5 * (_POINTS + 1.0), 0.5 * _WEIGHTS


class Stretch(NamedTuple):
    """A piece of a column between two nodes: cross-sections and weights at the Gauss points."""

    length_m: float
    stiffness: tuple[SectionStiffness, ...]
    inertia: tuple[SectionInertia, ...]
    places_m: FloatArray
    weights_m: FloatArray


class ElementMatrices(NamedTuple):
    """Mass, stiffness and gyroscopic weight of one element in the coordinates of its two nodes."""

    mass: FloatArray
    stiffness: FloatArray
    gyroscopic: FloatArray


def stretch(
    column: Column, stiff: StiffRadii, ends_m: tuple[float, float], shear: ShearRule
) -> Stretch:
    """Return the cross-sections of a column at the Gauss points between two places."""
    start, end = ends_m
    places = start + _POINTS * (end - start)
    radii = [stiff.at(z) for z in places]
    looked_at = places
    if column.is_straight and all(pair == radii[0] for pair in radii):
        looked_at = places[:1]
    repeat = places.size // looked_at.size
    return Stretch(
        end - start,
        tuple(section_stiffness(column, stiff, z, shear) for z in looked_at) * repeat,
        tuple(section_inertia(column, z, *pair) for z, pair in zip(looked_at, radii, strict=False))
        * repeat,
        places,
        _WEIGHTS * (end - start),
    )


def beam_matrices(piece: Stretch) -> ElementMatrices:
    """Return a Timoshenko element, order w1, θ1, w2, θ2.

    Parameters
    ----------
    piece
        Cross-sections along the element.

    Returns
    -------
    ElementMatrices
        Each of shape (4, 4).

    Notes
    -----
    The stiffness is the inverse of the flexibility under shear force and end moment, so that
    static deflections of a varying beam are exact at the nodes up to the quadrature. Inertia is
    consistent with the shapes of the uniform beam of the same mean flexibility.
    """
    length = piece.length_m
    z = length * _POINTS
    bending = np.array([s.bending for s in piece.stiffness])
    shear = np.array([s.shear for s in piece.stiffness])
    taper = np.array([s.taper for s in piece.stiffness])
    # moment M1 − V z and shear force V + taper M, per unit of V and of M1
    moment = np.column_stack((-z, np.ones_like(z)))
    force = np.column_stack((np.ones_like(z), np.zeros_like(z))) + taper[:, None] * moment
    weight = length * _WEIGHTS
    flexibility = moment.T @ ((weight / bending)[:, None] * moment)
    flexibility += force.T @ ((weight / shear)[:, None] * force)
    balance = np.array([[-1.0, 0.0, 1.0, -length], [0.0, -1.0, 0.0, 1.0]])
    stiffness = balance.T @ np.linalg.solve(flexibility, balance)

    deflection, slope = beam_shapes(piece, _POINTS)
    mass = np.array([s.mass for s in piece.inertia]) * weight
    second = np.array([s.second for s in piece.inertia]) * weight
    spin = slope.T @ (second[:, None] * slope)
    return ElementMatrices(
        deflection.T @ (mass[:, None] * deflection) + spin,
        0.5 * (stiffness + stiffness.T),
        2.0 * spin,
    )


def beam_shapes(piece: Stretch, xi: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return w and θ at ξ for the four coordinates of an element, shape (points, 4) each.

    They are those of a uniform beam with the means of both compliances.
    """
    length = piece.length_m
    bending = np.array([s.bending for s in piece.stiffness])
    shear = np.array([s.shear for s in piece.stiffness])
    phi = 12.0 * float(_WEIGHTS @ (1.0 / shear)) / float(_WEIGHTS @ (1.0 / bending)) / length**2
    deflection, slope, _ = shapes_at(xi, length, phi)
    return deflection, slope


def rod_matrices(piece: Stretch, *, twisted: bool) -> ElementMatrices:
    """Return a rod element for torsion or axial motion, order of the two nodes.

    Parameters
    ----------
    piece
        Cross-sections along the element.
    twisted
        Torsion (True) or axial motion.

    Returns
    -------
    ElementMatrices
        Each of shape (2, 2); nothing gyroscopic.
    """
    rigidity = np.array([s.torsion if twisted else s.axial for s in piece.stiffness])
    per_length = np.array([2.0 * s.second if twisted else s.mass for s in piece.inertia])
    shapes = np.column_stack((1.0 - _POINTS, _POINTS))
    spring = 1.0 / (piece.length_m * float(_WEIGHTS @ (1.0 / rigidity)))
    mass = shapes.T @ ((piece.length_m * _WEIGHTS * per_length)[:, None] * shapes)
    stiffness = spring * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return ElementMatrices(mass, stiffness, np.zeros((2, 2)))
