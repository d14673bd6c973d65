"""Beam and rod elements whose cross-section may vary along them.

In bending each node has a deflection w and a slope angle θ; in the plane of x they are (ux, ry), in
the plane of y (uy, −rx). A shaft of revolution has the same matrices in both planes, and G couples
them. Axial motion and torsion have one coordinate per node.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.core.arrays import FloatArray

Family = Literal["lateral", "axial", "torsion"]

# Products of two cubic shapes with an inertia of degree four: degree 10, six points are exact.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(6)  # type: ignore[no-untyped-call]
#: Gauss points of an element on [0, 1].
GAUSS_POINTS: FloatArray = 0.5 * (_POINTS + 1.0)
_WEIGHTS = 0.5 * _WEIGHTS


class SectionStiffness(NamedTuple):
    """Stiffness of cross-sections, a number or one each at the Gauss points.

    `bending`: EI, N m².
    `shear`: κGA, N.
    `taper`: share of the moment that inclined fibres turn into a shear force, 1/m.
    `axial`: EA, N.
    `torsion`: GJ, N m².
    """

    bending: npt.ArrayLike
    shear: npt.ArrayLike
    taper: npt.ArrayLike
    axial: npt.ArrayLike
    torsion: npt.ArrayLike


class SectionInertia(NamedTuple):
    """Mass per length (kg/m) and second moment of mass per length (kg m) of cross-sections."""

    mass: npt.ArrayLike
    second: npt.ArrayLike


class Segment(NamedTuple):
    """A beam between two nodes: cross-sections and weights at the Gauss points, shape (6,) each.

    `bending` to `torsion` are those of `SectionStiffness`, `mass` and `second` of `SectionInertia`.
    """

    length_m: float
    bending: FloatArray
    shear: FloatArray
    taper: FloatArray
    axial: FloatArray
    torsion: FloatArray
    mass: FloatArray
    second: FloatArray
    places_m: FloatArray
    weights_m: FloatArray

    @property
    def start_m(self) -> float:
        """Place of the first node, m."""
        return float(self.places_m[0]) - self.length_m * float(GAUSS_POINTS[0])


class ElementMatrices(NamedTuple):
    """Matrices in the coordinates of two nodes; `gyroscopic` is the weight of ρ Ip θ θ."""

    mass: FloatArray
    stiffness: FloatArray
    gyroscopic: FloatArray


def shear_coefficient(poissons_ratio: float, radius_ratio: float) -> float:
    """Return κ of a solid or hollow circular section, the shear stiffness being κ G A.

    `radius_ratio`: inner over outer radius, 0 for a solid section.

    Cowper (1966), The shear coefficient in Timoshenko's beam theory, J. Appl. Mech. 33, table 1.
    """
    nu, m2 = poissons_ratio, radius_ratio**2
    hollow = (1.0 + m2) ** 2
    return 6.0 * (1.0 + nu) * hollow / ((7.0 + 6.0 * nu) * hollow + (20.0 + 12.0 * nu) * m2)


def segment(
    ends_m: tuple[float, float], stiffness: SectionStiffness, inertia: SectionInertia
) -> Segment:
    """Return the beam between two places with cross-sections all along or at the Gauss points."""
    start, end = ends_m
    weights = _WEIGHTS * (end - start)
    parts = [np.broadcast_to(part, weights.shape) for part in (*stiffness, *inertia)]
    return Segment._make([end - start, *parts, start + GAUSS_POINTS * (end - start), weights])


def element_matrices(piece: Segment, family: Family) -> ElementMatrices:
    """Return a Timoshenko element, order w1, θ1, w2, θ2, or a rod in the order of the two nodes.

    The stiffness is the inverse of the flexibility under shear force and end moment, so that
    static deflections of a varying beam are exact at the nodes up to the quadrature. Inertia is
    consistent with the shapes of the uniform beam of the same mean flexibility (Przemieniecki
    1968, section 5.6; Friswell et al. 2010, section 5.4) and includes rotary inertia.
    """
    length, weight = piece.length_m, piece.weights_m
    if family != "lateral":
        rigidity = piece.torsion if family == "torsion" else piece.axial
        per_length = 2.0 * piece.second if family == "torsion" else piece.mass
        spring = 1.0 / float(weight @ (1.0 / rigidity))
        shapes = np.column_stack((1.0 - GAUSS_POINTS, GAUSS_POINTS))
        mass = shapes.T @ ((weight * per_length)[:, None] * shapes)
        spring_matrix = spring * np.array([[1.0, -1.0], [-1.0, 1.0]])
        return ElementMatrices(mass, spring_matrix, np.zeros((2, 2)))
    z = length * GAUSS_POINTS
    # moment M1 − V z and shear force V + taper M, per unit of V and of M1
    moment = np.column_stack((-z, np.ones_like(z)))
    force = np.column_stack((np.ones_like(z), np.zeros_like(z))) + piece.taper[:, None] * moment
    flexibility = moment.T @ ((weight / piece.bending)[:, None] * moment)
    flexibility += force.T @ ((weight / piece.shear)[:, None] * force)
    balance = np.array([[-1.0, 0.0, 1.0, -length], [0.0, -1.0, 0.0, 1.0]])
    stiffness = np.asarray(balance.T @ np.linalg.solve(flexibility, balance))
    deflection, slope = section_motion(piece, GAUSS_POINTS, family)
    spin = slope.T @ ((piece.second * weight)[:, None] * slope)
    moved = deflection.T @ ((piece.mass * weight)[:, None] * deflection)
    mass = np.asarray(moved + spin)
    return ElementMatrices(mass, 0.5 * (stiffness + stiffness.T), 2.0 * spin)


def section_motion(
    piece: Segment, xi: FloatArray, family: Family, arms_m: FloatArray | float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Return how the nodes of an element move and tilt its cross-sections at ξ = z/L.

    `arms_m`: along the axis, from the cross-section to what is rigidly fixed to it, shape
    (points,). Returns shape (points, 4), or (points, 2) for rods, which do not tilt.

    Shapes of the uniform beam with the means of both compliances.
    """
    if family != "lateral":
        moved = np.column_stack((1.0 - xi, xi))
        return moved, np.zeros_like(moved)
    length = piece.length_m
    shear, bending = (float(_WEIGHTS @ (1.0 / part)) for part in (piece.shear, piece.bending))
    phi = 12.0 * shear / bending / length**2
    a = 1.0 / (1.0 + phi)
    x2, x3 = xi**2, xi**3
    deflection = np.column_stack(
        (
            a * (1 - 3 * x2 + 2 * x3 + phi * (1 - xi)),
            a * length * (xi - 2 * x2 + x3 + 0.5 * phi * (xi - x2)),
            a * (3 * x2 - 2 * x3 + phi * xi),
            a * length * (-x2 + x3 - 0.5 * phi * (xi - x2)),
        )
    )
    slope = np.column_stack(
        (
            6 * a / length * (x2 - xi),
            a * (1 - 4 * xi + 3 * x2 + phi * (1 - xi)),
            6 * a / length * (xi - x2),
            a * (3 * x2 - 2 * xi + phi * xi),
        )
    )
    return deflection + np.reshape(arms_m, (-1, 1)) * slope, slope
