"""Linear elastic isotropic materials and a small table of common ones."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from solidwhirl.geometry.errors import GeometryError


@dataclass(frozen=True, kw_only=True, slots=True)
class Material:
    """Hold the constants of a linear elastic isotropic material.

    Raises GeometryError if the name is empty or a constant is not finite or outside its range.
    """

    name: str
    density_kg_per_m3: float  #: Mass density [kg/m^3], positive
    youngs_modulus_pa: float
    #: Poisson's ratio [-], in the open interval (-1, 0.5) of positive strain energy
    poissons_ratio: float

    def __post_init__(self) -> None:
        if not self.name:
            raise GeometryError("a material needs a name, found an empty one")
        for label, value, unit in (
            ("density", self.density_kg_per_m3, "kg/m^3"),
            ("Young's modulus", self.youngs_modulus_pa, "Pa"),
        ):
            if not (math.isfinite(value) and value > 0.0):
                raise GeometryError(
                    f"material '{self.name}': {label} is {value} {unit}, "
                    "must be finite and positive"
                )
        if not -1.0 < self.poissons_ratio < 0.5:
            raise GeometryError(
                f"material '{self.name}': Poisson's ratio is {self.poissons_ratio}, "
                "must lie between -1 and 0.5 (both excluded)"
            )


# kg/m³, Pa and Poisson's ratio.
_HANDBOOK = {
    "steel": (7800.0, 2.0e11, 0.3),  # of the twin rotor benchmark
    "titanium": (4430.0, 1.138e11, 0.342),  # Ti-6Al-4V
    "nickel_alloy": (8190.0, 2.0e11, 0.29),  # Inconel 718
    "aluminium": (2700.0, 7.0e10, 0.33),
}
MATERIALS: Mapping[str, Material] = MappingProxyType(
    {
        name: Material(
            name=name, density_kg_per_m3=rho, youngs_modulus_pa=modulus, poissons_ratio=nu
        )
        for name, (rho, modulus, nu) in _HANDBOOK.items()
    }
)
"""Common materials by name (read-only); room temperature, typical handbook values."""
