"""Contact of two smooth elastic bodies in a point, after Hertz."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from solidwhirl.rotordyn.core.errors import AnalysisError

# Ratios of the axes of a contact that are looked at, as logarithms.
_LONGEST = 12.0


@dataclass(frozen=True, kw_only=True)
class Elastic:
    """An isotropic material: Young's modulus, Poisson's ratio and density."""

    youngs_modulus_pa: float
    poissons_ratio: float
    density_kg_per_m3: float

    @property
    def compliance_per_pa(self) -> float:
        """(1 − ν²) / E of a half space, 1/Pa."""
        return (1.0 - self.poissons_ratio**2) / self.youngs_modulus_pa


BEARING_STEEL = Elastic(youngs_modulus_pa=207e9, poissons_ratio=0.3, density_kg_per_m3=7800.0)
SILICON_NITRIDE = Elastic(youngs_modulus_pa=310e9, poissons_ratio=0.26, density_kg_per_m3=3200.0)


@dataclass(frozen=True, kw_only=True)
class PointContact:
    """A contact Q = c δ^(3/2).

    `stiffness_n_per_m15`: c, N/m^1.5; `axis_ratio`: larger over smaller axis of the ellipse of
    contact, ≥ 1; `axes_per_load`: both semi-axes for a load of 1 N, m; they go with the cube root.
    """

    stiffness_n_per_m15: float
    axis_ratio: float
    axes_per_load: tuple[float, float]

    def pressure_pa(self, load_n: float) -> float:
        """Return the largest pressure in the contact, Pa."""
        a, b = self.axes_per_load
        return 1.5 * float(np.cbrt(load_n)) / (np.pi * a * b)


def point_contact(
    curvature_sum_per_m: float, curvature_difference: float, compliance_per_pa: float
) -> PointContact:
    """Return the contact of two bodies from their curvatures.

    `curvature_sum_per_m`: Σρ of the four principal curvatures, hollow ones negative;
    `curvature_difference`: F(ρ), 0 (circle) to 1 (line); `compliance_per_pa`: sum of
    (1 − ν²) / E of both bodies. Raises AnalysisError if no two bodies have such curvatures.

    Harris and Kotzalas (2006), Essential Concepts of Bearing Technology, chapter 6, with complete
    elliptic integrals; the axis ratio χ solves F = 1 − 2/(χ² − 1) (K/E − 1).
    """
    if not (curvature_sum_per_m > 0 and 0 <= curvature_difference < 1):
        raise AnalysisError(
            f"no contact in a point: the curvatures have the sum {curvature_sum_per_m:.6g} 1/m and "
            f"the difference {curvature_difference:.6g}; needed are sum > 0, 0 <= difference < 1"
        )
    ratio = _axis_ratio(curvature_difference)
    first, second = (
        float(f(1.0 - ratio**-2)) for f in (scipy.special.ellipk, scipy.special.ellipe)
    )
    size = np.cbrt(1.5 * compliance_per_pa / curvature_sum_per_m)
    long = np.cbrt(2.0 * ratio**2 * second / np.pi) * size
    # approach for 1 N, δ = δ* (3 Q κ / 2 Σρ)^(2/3) Σρ / 2 with the dimensionless δ* of Harris
    shape = 2.0 * first / np.pi * np.cbrt(np.pi / (2.0 * ratio**2 * second))
    approach = shape * size**2 * 0.5 * curvature_sum_per_m
    return PointContact(
        stiffness_n_per_m15=float(approach**-1.5),
        axis_ratio=ratio,
        axes_per_load=(float(long), float(long / ratio)),
    )


def _axis_ratio(difference: float) -> float:
    """Return χ for a curvature difference; a circle has 1."""

    def miss(log_ratio: float) -> float:
        m = -np.expm1(-2.0 * log_ratio)
        over = np.expm1(2.0 * log_ratio)
        return float(
            1.0
            - 2.0 / over * (scipy.special.ellipk(m) / scipy.special.ellipe(m) - 1.0)
            - difference
        )

    # nearly circular: F = (3/8) m, below which the quotient above is rounding
    if difference < 1e-6:
        return float(1.0 + 4.0 / 3.0 * difference)
    if miss(_LONGEST) < 0:
        raise AnalysisError(f"the curvature difference {difference:.12g} is that of a line contact")
    return float(np.exp(scipy.optimize.brentq(miss, 1e-7, _LONGEST, xtol=1e-14)))
