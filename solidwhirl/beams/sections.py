"""Cross-sections of the columns of a beam model: which part is stiff, and what it adds up to.

A step in the surface is not felt at once: the stress of bending spreads behind it at 45°. The
stiffness rule says how steep, for steps of a shaft and for disks on it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Literal, NamedTuple

import numpy as np

from solidwhirl.beams.profile import Column, Skeleton
from solidwhirl.geometry import Section
from solidwhirl.rotordyn.beams import elements
from solidwhirl.rotordyn.beams.elements import (
    SectionInertia,
    SectionStiffness,
    Segment,
    shear_coefficient,
)
from solidwhirl.rotordyn.core.arrays import FloatArray

StiffnessRule = Literal["soft", "spread", "stiff"]
ShearRule = Literal["weighted", "shifted", "doubled"]

# Points per column on which the stiff radii are followed.
_GRID = 65
# Gauss points across a ring: the integrands are r³ times a smooth function of the fibre's slope.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)  # type: ignore[no-untyped-call]
_NODES, _WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS


SPREADS: Mapping[StiffnessRule, float] = MappingProxyType(
    {"soft": 0.5, "spread": 0.8, "stiff": 1.3}
)
"""Slopes dr/dz at which stiffness spreads behind a step and into disks; 0.8 is the 45° rule."""


class StiffRadii(NamedTuple):
    """Stiff part of a column over z: grid (g,), inner and outer radius of columns and plates."""

    z_m: FloatArray
    inner_m: FloatArray
    outer_m: FloatArray

    def at(self, z_m: FloatArray) -> list[tuple[float, float]]:
        """Return inner and outer stiff radius at places, m."""
        inner = np.interp(z_m, self.z_m, self.inner_m).tolist()
        return list(zip(inner, np.interp(z_m, self.z_m, self.outer_m).tolist(), strict=True))


def stiff_radii(skeleton: Skeleton, slope: float) -> tuple[StiffRadii, ...]:
    """Return the stiff part of every column.

    Result: the outer stiff radius is the largest function below the surface that grows no faster
    than the rule's slope plus the slope of the opposite surface (so that a cone's wall is stiff),
    in both directions; the inner one likewise.
    """
    columns = skeleton.columns
    grids = [np.linspace(c.start_m, c.end_m, _GRID) for c in columns]
    found = []
    outer = _followed(skeleton, grids, slope, outwards=True)
    inner = _followed(skeleton, grids, slope, outwards=False)
    for grid, low, high in zip(grids, inner, outer, strict=True):
        found.append(StiffRadii(grid, -low, high))
    return tuple(found)


def _followed(
    skeleton: Skeleton, grids: Sequence[FloatArray], slope: float, *, outwards: bool
) -> list[FloatArray]:
    """Return the stiff surface of all columns; inner surfaces as −r, so that both grow."""
    own, whole, opposite = [], [], []
    for column, grid in zip(skeleton.columns, grids, strict=True):
        inner = np.array([column.inner_m(z) for z in grid])
        outer = np.array([column.outer_m(z) for z in grid])
        surface, other = (outer, inner) if outwards else (-inner, -outer)
        plates = column.outer_plates if outwards else column.inner_plates
        edge = max(
            (s.outer_radius_m[0] if outwards else -s.inner_radius_m[0] for s in plates),
            default=-np.inf,
        )
        own.append(surface)
        whole.append(np.maximum(surface, edge))
        opposite.append(other)
    limit = _both_ways(skeleton, grids, own, opposite, slope)
    raised = _both_ways(skeleton, grids, whole, opposite, slope)
    return [
        np.where(w > o, np.maximum(low, high), low)
        for w, o, low, high in zip(whole, own, limit, raised, strict=True)
    ]


def _both_ways(
    skeleton: Skeleton,
    grids: Sequence[FloatArray],
    surface: Sequence[FloatArray],
    opposite: Sequence[FloatArray],
    slope: float,
) -> list[FloatArray]:
    count = len(grids)
    ahead: list[list[int]] = [[] for _ in range(count)]
    behind: list[list[int]] = [[] for _ in range(count)]
    for left, right in skeleton.contacts:
        behind[right].append(left)
        ahead[left].append(right)
    rightwards: list[FloatArray] = [np.empty(0)] * count
    leftwards: list[FloatArray] = [np.empty(0)] * count
    for k in range(count):  # columns are ordered by their start
        first = max((rightwards[j][-1] for j in behind[k]), default=np.inf)
        rightwards[k] = _limited(surface[k], opposite[k], grids[k], first, slope)
    for k in reversed(range(count)):
        first = max((leftwards[j][0] for j in ahead[k]), default=np.inf)
        backwards = _limited(surface[k][::-1], opposite[k][::-1], grids[k][::-1], first, slope)
        leftwards[k] = backwards[::-1]
    return [np.minimum(a, b) for a, b in zip(rightwards, leftwards, strict=True)]


def _limited(
    surface: FloatArray, opposite: FloatArray, grid: FloatArray, first: float, slope: float
) -> FloatArray:
    """Return the surface where it grows no faster than allowed from the value before it."""
    rise = slope * np.abs(np.diff(grid)) + np.maximum(0.0, np.diff(opposite))
    allowed = np.concatenate(([0.0], np.cumsum(rise)))
    start = np.concatenate(([min(surface[0], first)], surface[1:]))
    return np.asarray(allowed + np.minimum.accumulate(start - allowed))


def hutchinson(poissons_ratio: float, radius_ratio: float) -> float:
    """Return the shear coefficient of Hutchinson (2001), J. Appl. Mech. 68, equation 44."""
    nu, b2, b4 = poissons_ratio, radius_ratio**2, radius_ratio**4
    below = 7 + 34 * b2 + 7 * b4 + nu * (12 + 48 * b2 + 12 * b4) + nu**2 * (4 + 16 * b2 + 4 * b4)
    return 6.0 * (1 + b2) ** 2 * (1 + nu) ** 2 / below


def weighted(poissons_ratio: float, radius_ratio: float) -> float:
    """Return Hutchinson's coefficient for solid sections, Cowper's for thin tubes.

    The weight is the square of the ratio of radii. Free frequencies of uniform shafts on the
    harmonic level are met best so: solid ones to 0.02 % where half a wave is ten diameters.
    """
    share = radius_ratio**2
    solid, thin = (
        hutchinson(poissons_ratio, radius_ratio),
        shear_coefficient(poissons_ratio, radius_ratio),
    )
    return (1.0 - share) * solid + share * thin


_SHEAR: Mapping[ShearRule, Callable[[float, float], float]] = MappingProxyType(
    {
        "weighted": weighted,
        "shifted": lambda nu, m: weighted(nu, m) * shear_coefficient(nu, m) / hutchinson(nu, m),
        "doubled": lambda nu, m: 2.0 * weighted(nu, m),
    }
)


def column_segment(
    column: Column, stiff: StiffRadii, ends_m: tuple[float, float], shear: ShearRule
) -> Segment:
    """Return the beam between two places of a column."""
    places = ends_m[0] + elements.GAUSS_POINTS * (ends_m[1] - ends_m[0])
    radii = stiff.at(places)
    if column.is_straight and all(pair == radii[0] for pair in radii):
        places = places[:1]
    stiffness = [
        section_stiffness(column, z, at, shear) for z, at in zip(places, radii, strict=False)
    ]
    inertia = [section_inertia(column, z, *at) for z, at in zip(places, radii, strict=False)]
    return elements.segment(
        ends_m, SectionStiffness(*np.array(stiffness).T), SectionInertia(*np.array(inertia).T)
    )


def section_stiffness(
    column: Column, z_m: float, radii_m: tuple[float, float], shear: ShearRule
) -> SectionStiffness:
    """Return the stiffness of the stiff part of a cross-section, between two radii, at a place, m.

    `shear`: shear coefficient; that of a ring with the radii of the whole stiff part.

    A fibre with the slope tan α has the axial strain cos²α of that of a straight one, and so the
    axial stress; for a thin cone this is its membrane theory for one wave along the
    circumference (Flügge, Stresses in Shells, chapter 4): EI cos⁴α, κGA cos²α, and the shear
    force V + M tan α / r.
    """
    low, high = radii_m
    bending = moment = axial = torsion = shearing = poisson = 0.0
    for layer in (*column.layers, *column.outer_plates, *column.inner_plates):
        if not layer.start_m <= z_m <= layer.end_m:
            continue
        ring = _clipped(layer, z_m, low, high)
        if ring is None:
            continue
        radius, tangent, weight = ring
        modulus, nu = layer.material.youngs_modulus_pa, layer.material.poissons_ratio
        stiffness = modulus * weight / (1.0 + tangent**2) ** 2
        sliding = modulus / (2.0 * (1.0 + nu)) * weight / (1.0 + tangent**2)
        bending += float(stiffness @ radius**3) * np.pi
        moment += float(stiffness @ (tangent * radius**2)) * np.pi
        axial += float(stiffness @ radius) * 2.0 * np.pi
        torsion += float(sliding @ radius**3) * 2.0 * np.pi
        area = float(sliding @ radius) * 2.0 * np.pi
        shearing += area
        poisson += nu * area
    coefficient = _SHEAR[shear](poisson / shearing, max(low, 0.0) / high)
    return SectionStiffness(bending, coefficient * shearing, moment / bending, axial, torsion)


def section_inertia(
    column: Column, z_m: float, low_m: float = 0.0, high_m: float = np.inf
) -> SectionInertia:
    """Return the inertia of the rings of a column at a place between two radii, m."""
    mass = second = 0.0
    for layer in column.layers:
        inner, outer = layer.radii_at(z_m)
        inner, outer = max(inner, low_m), min(outer, high_m)
        if outer <= inner:
            continue
        ring = np.pi * layer.material.density_kg_per_m3 * (outer - inner) * (outer + inner)
        mass += ring
        second += 0.25 * ring * (outer**2 + inner**2)
    return SectionInertia(mass, second)


def _clipped(
    layer: Section, z_m: float, low: float, high: float
) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Return radii, slopes and weights of the fibres of a layer between two radii."""
    inner, outer = layer.radii_at(z_m)
    start, stop = max(inner, low), min(outer, high)
    if stop <= start:
        return None
    length = layer.end_m - layer.start_m
    slopes = [(r[1] - r[0]) / length for r in (layer.inner_radius_m, layer.outer_radius_m)]
    radius = start + _NODES * (stop - start)
    share = (radius - inner) / (outer - inner)
    return radius, slopes[0] + share * (slopes[1] - slopes[0]), _WEIGHTS * (stop - start)
