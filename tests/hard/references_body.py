"""Closed forms and exact roots of beams, plates and cylinders, independent of all meshes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.optimize import brentq
from scipy.special import iv, ivp, jv, jvp

from solidwhirl.geometry import Material

FloatArray = NDArray[np.float64]


def roots(function: Callable[[float], float], start: float, end: float, count: int) -> FloatArray:
    """First roots of a function of one variable, looked for on 4000 pieces."""
    x = np.linspace(start, end, 4001)
    y = np.array([function(v) for v in x])
    at = np.flatnonzero(y[:-1] * y[1:] < 0.0)[:count]
    return np.array([brentq(function, x[k], x[k + 1], xtol=1e-14, rtol=1e-14) for k in at])


def timoshenko_free_hz(length_m: float, radius_m: float, material: Material) -> float:
    """First bending frequency of a free solid shaft; Timoshenko's beam, Cowper's coefficient.

    The solution is a sum of four exponentials of z with moment and shear force zero at both ends
    (Huang, J. Appl. Mech. 28 (1961) 579-584).
    """
    e, nu, rho = material.youngs_modulus_pa, material.poissons_ratio, material.density_kg_per_m3
    area, inertia = np.pi * radius_m**2, np.pi * radius_m**4 / 4.0
    shear = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu) * e / (2.0 * (1.0 + nu)) * area

    def determinant(omega: float) -> float:
        # w = exp(s z), θ = c exp(s z): EI θ'' + kGA (w' - θ) + ρI ω² θ = 0 and the shear balance
        p = omega**2 * rho * (inertia / (e * inertia) + area / shear)
        q = omega**2 * rho * area / (e * inertia) * (omega**2 * rho * inertia / shear - 1.0)
        squares = np.roots([1.0, p, q]).astype(complex)
        s = np.concatenate([np.sqrt(squares), -np.sqrt(squares)])
        c = s + omega**2 * rho * area / (shear * s)
        rows = []
        for z in (0.0, length_m):
            grown = np.exp(s * z - np.abs(s.real) * length_m / 2.0)
            rows += [c * s * grown, (s - c) * grown * length_m]
        value = np.linalg.det(np.array(rows))
        return float(value.real if abs(value.real) > abs(value.imag) else value.imag)

    euler = (4.730040744862704 / length_m) ** 2 * np.sqrt(e * inertia / (rho * area))
    return float(roots(determinant, 0.7 * euler, 1.01 * euler, 1)[0] / (2.0 * np.pi))


def free_plate_hz(order: int, radius_m: float, thickness_m: float, material: Material) -> float:
    """Lowest mode with a nodal circle of a free circular plate (Kirchhoff), n nodal diameters.

    w = A J_n(k r) + B I_n(k r) with M_r = 0 and V_r = 0 at the edge (Leissa, NASA SP-160, 1969).
    """
    nu, n = material.poissons_ratio, order

    def determinant(k: float) -> float:
        columns = []
        for f, d, sign in ((jv, jvp, -1.0), (iv, ivp, 1.0)):
            w, slope, bend = f(n, k), k * d(n, k, 1), k**2 * d(n, k, 2)
            moment = bend + nu * (slope - n**2 * w)
            # the Laplacian of w is ± k² w
            force = sign * k**2 * slope - (1.0 - nu) * n**2 * (slope - w)
            columns.append((moment, force))
        (a, c), (b, d2) = columns
        return float(a * d2 - b * c) / float(iv(n, k)) / k**4

    k = roots(determinant, 2.5, 8.0, 1)[0] / radius_m
    e, rho = material.youngs_modulus_pa, material.density_kg_per_m3
    bending = e * thickness_m**2 / (12.0 * (1.0 - nu**2) * rho)
    return float(k**2 * np.sqrt(bending) / (2.0 * np.pi))


def spinning_plate_hz(
    radius_m: float, thickness_m: float, material: Material, speed_rad_s: float
) -> float:
    """First axisymmetric mode of a free circular plate that spins; Ritz in powers of r².

    Bending of Kirchhoff's plate and the centrifugal stress of a solid disk in plane stress.
    """
    e, nu, rho = material.youngs_modulus_pa, material.poissons_ratio, material.density_kg_per_m3
    bending = e * thickness_m**3 / (12.0 * (1.0 - nu**2))
    x, weight = np.polynomial.legendre.leggauss(40)
    r, weight = 0.5 * (x + 1.0), 0.5 * weight
    powers = 2.0 * np.arange(1, 9)[:, None]
    w = np.vstack([np.ones_like(r), r**powers])
    slope = np.vstack([np.zeros_like(r), powers * r ** (powers - 1.0)])
    curve = np.vstack([np.zeros_like(r), powers * (powers - 1.0) * r ** (powers - 2.0)])
    around = slope / r
    area = 2.0 * np.pi * weight * r

    def product(a: FloatArray, b: FloatArray, factor: FloatArray) -> FloatArray:
        return np.asarray((a * factor * area) @ b.T)

    one = np.ones_like(r)
    k = product(curve, curve, one) + product(around, around, one)
    k = (k + nu * (product(curve, around, one) + product(around, curve, one))) * bending
    tension = rho * speed_rad_s**2 * (3.0 + nu) / 8.0 * (1.0 - r**2) * thickness_m * radius_m**4
    k = (k + product(slope, slope, tension)) / radius_m**2
    m = rho * thickness_m * radius_m**2 * product(w, w, one)
    return float(np.sqrt(eigh(k, m, eigvals_only=True)[1]) / (2.0 * np.pi))


def torsion_hz(length_m: float, radius_m: float, material: Material, top_hz: float) -> FloatArray:
    """All torsional frequencies of a free solid cylinder below a limit, exact.

    u_θ = cos(kπz/L) r, or J1(βr) with J2(β R) = 0: ω² = c² ((kπ/L)² + β²).
    """
    shear = material.youngs_modulus_pa / (2.0 * (1.0 + material.poissons_ratio))
    speed = np.sqrt(shear / material.density_kg_per_m3)
    beta = np.concatenate([[0.0], roots(lambda x: float(jv(2, x)), 1.0, 40.0, 8) / radius_m])
    axial = np.pi / length_m * np.arange(200)
    hz = speed * np.sqrt(axial[:, None] ** 2 + beta**2).ravel() / (2.0 * np.pi)
    return np.sort(hz[(hz > 0.0) & (hz < top_hz)])
