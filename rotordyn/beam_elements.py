"""Timoshenko beam matrices of a shaft in one plane: mass, stiffness and gyroscopic weight.

Each node has a deflection w and a slope angle θ; in the plane of x they are (ux, ry), in the plane
of y (uy, −rx). A shaft of revolution has the same matrices in both planes, and G couples them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray

# Gauss-Legendre, four points: degree 7, and the products of cubic shape functions have degree 6.
_NEAR, _FAR = np.sqrt(3 / 7 - 2 / 7 * np.sqrt(1.2)), np.sqrt(3 / 7 + 2 / 7 * np.sqrt(1.2))
_POINTS = np.array([-_FAR, -_NEAR, _NEAR, _FAR])
_WEIGHTS = (18 + np.sqrt(30) * np.array([-1.0, 1.0, 1.0, -1.0])) / 36


class PlaneMatrices(NamedTuple):
    """Matrices in (w1, θ1, w2, θ2, ...); `gyroscopic` is the symmetric weight of ρ Ip θ θ."""

    mass: FloatArray
    stiffness: FloatArray
    gyroscopic: FloatArray


def shear_coefficient(poissons_ratio: float, radius_ratio: float) -> float:
    """Return the shear coefficient of a solid or hollow circular section.

    Parameters
    ----------
    poissons_ratio
        Poisson's ratio.
    radius_ratio
        Inner over outer radius, 0 for a solid section.

    Returns
    -------
    float
        κ, the shear stiffness being κ G A.

    Notes
    -----
    Cowper (1966), The shear coefficient in Timoshenko's beam theory, J. Appl. Mech. 33, table 1.
    """
    nu, m2 = poissons_ratio, radius_ratio**2
    hollow = (1.0 + m2) ** 2
    return 6.0 * (1.0 + nu) * hollow / ((7.0 + 6.0 * nu) * hollow + (20.0 + 12.0 * nu) * m2)


def beam_element(
    length_m: float,
    outer_radius_m: float,
    inner_radius_m: float,
    youngs_modulus_pa: float,
    poissons_ratio: float,
    density_kg_m3: float,
) -> PlaneMatrices:
    """Return the matrices of one uniform Timoshenko element.

    Parameters
    ----------
    length_m, outer_radius_m, inner_radius_m
        Geometry, m.
    youngs_modulus_pa, poissons_ratio, density_kg_m3
        Material.

    Returns
    -------
    PlaneMatrices
        Each of shape (4, 4), order w1, θ1, w2, θ2.

    Notes
    -----
    Shape functions are the exact static solution of the uniform beam (Przemieniecki 1968, section
    5.6; Friswell et al. 2010, section 5.4), so static deflections at nodes are exact. The mass is
    consistent and includes rotary inertia.
    """
    area, second = _section(outer_radius_m, inner_radius_m)
    shear_modulus = youngs_modulus_pa / (2.0 * (1.0 + poissons_ratio))
    kappa = shear_coefficient(poissons_ratio, inner_radius_m / outer_radius_m)
    bending, shear = youngs_modulus_pa * second, kappa * shear_modulus * area
    phi = 12.0 * bending / (shear * length_m**2)

    deflection, slope, curvature = shapes_at(0.5 * (_POINTS + 1.0), length_m, phi)
    weights = 0.5 * length_m * _WEIGHTS
    # The shear angle w' − θ of each shape function is constant along the element.
    angle = phi / (2.0 * (1.0 + phi)) * np.array([-2.0 / length_m, -1.0, 2.0 / length_m, -1.0])
    bend = np.einsum("g,gi,gj->ij", weights, curvature, curvature)
    spin = np.einsum("g,gi,gj->ij", weights, slope, slope)
    move = np.einsum("g,gi,gj->ij", weights, deflection, deflection)
    return PlaneMatrices(
        mass=density_kg_m3 * (area * move + second * spin),
        stiffness=bending * bend + shear * length_m * np.outer(angle, angle),
        gyroscopic=2.0 * density_kg_m3 * second * spin,
    )


def rod_coupling(
    length_m: float,
    outer_radius_m: float,
    inner_radius_m: float,
    poissons_ratio: float,
    density_kg_m3: float,
) -> tuple[FloatArray, FloatArray]:
    """Return the mass that a linear two-node rod and a beam have in common in one element.

    Parameters
    ----------
    length_m, outer_radius_m, inner_radius_m
        Geometry, m.
    poissons_ratio, density_kg_m3
        Material.

    Returns
    -------
    moving, tilting : ndarray
        ∫ ρA N w and ∫ ρI N θ of the linear N with the deflection w and the slope θ of
        `beam_element`; each (2, 4).
    """
    area, second = _section(outer_radius_m, inner_radius_m)
    kappa = shear_coefficient(poissons_ratio, inner_radius_m / outer_radius_m)
    phi = 24.0 * (1.0 + poissons_ratio) * second / (kappa * area * length_m**2)
    xi = 0.5 * (_POINTS + 1.0)
    deflection, slope, _ = shapes_at(xi, length_m, phi)
    weighted = 0.5 * length_m * density_kg_m3 * _WEIGHTS * np.stack((1.0 - xi, xi))
    return area * weighted @ deflection, second * weighted @ slope


def _section(outer_radius_m: float, inner_radius_m: float) -> tuple[float, float]:
    """Area and second moment of area of a circular section."""
    area = np.pi * (outer_radius_m**2 - inner_radius_m**2)
    return area, 0.25 * np.pi * (outer_radius_m**4 - inner_radius_m**4)


def shapes_at(xi: FloatArray, length: float, phi: float) -> tuple[FloatArray, ...]:
    """Return w, θ and θ' of the four shape functions at ξ = z/L.

    Parameters
    ----------
    xi
        ξ, shape (points,).
    length
        L, m.
    phi
        Shear parameter 12 EI / (κ G A L²).

    Returns
    -------
    tuple of ndarray
        Each (points, 4); those of a uniform Timoshenko beam (Przemieniecki 1968, section 5.6).
    """
    a = 1.0 / (1.0 + phi)
    x2, x3 = xi**2, xi**3
    w = (
        a * (1 - 3 * x2 + 2 * x3 + phi * (1 - xi)),
        a * length * (xi - 2 * x2 + x3 + 0.5 * phi * (xi - x2)),
        a * (3 * x2 - 2 * x3 + phi * xi),
        a * length * (-x2 + x3 - 0.5 * phi * (xi - x2)),
    )
    theta = (
        6 * a / length * (x2 - xi),
        a * (1 - 4 * xi + 3 * x2 + phi * (1 - xi)),
        6 * a / length * (xi - x2),
        a * (3 * x2 - 2 * xi + phi * xi),
    )
    curvature = (
        6 * a / length**2 * (2 * xi - 1),
        a / length * (6 * xi - 4 - phi),
        6 * a / length**2 * (1 - 2 * xi),
        a / length * (6 * xi - 2 + phi),
    )
    return tuple(np.stack(columns, axis=1) for columns in (w, theta, curvature))


def shaft_matrices(
    nodes_m: FloatArray,
    outer_radius_m: FloatArray,
    inner_radius_m: FloatArray,
    youngs_modulus_pa: float,
    poissons_ratio: float,
    density_kg_m3: float,
) -> PlaneMatrices:
    """Return the assembled matrices of a stepped shaft in one plane.

    Parameters
    ----------
    nodes_m
        Node positions along the axis, shape (N,), increasing, m.
    outer_radius_m, inner_radius_m
        Radii between the nodes, shape (N − 1,), m.
    youngs_modulus_pa, poissons_ratio, density_kg_m3
        Material.

    Returns
    -------
    PlaneMatrices
        Each of shape (2N, 2N), order w1, θ1, w2, θ2, ...
    """
    n = 2 * nodes_m.size
    whole = PlaneMatrices(np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n)))
    for index, length in enumerate(np.diff(nodes_m)):
        part = beam_element(
            float(length),
            float(outer_radius_m[index]),
            float(inner_radius_m[index]),
            youngs_modulus_pa,
            poissons_ratio,
            density_kg_m3,
        )
        at = slice(2 * index, 2 * index + 4)
        for total, local in zip(whole, part, strict=True):
            total[at, at] += local
    return whole
