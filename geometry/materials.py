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

    Attributes
    ----------
    name : str
        Name used in scenes and messages.
    density_kg_per_m3 : float
        Mass density [kg/m^3], positive.
    youngs_modulus_pa : float
        Young's modulus [Pa], positive.
    poissons_ratio : float
        Poisson's ratio [-], in the open interval (-1, 0.5) of positive strain energy.

    Raises
    ------
    GeometryError
        If the name is empty or a constant is not finite or outside its range.
    """

    name: str
    density_kg_per_m3: float
    youngs_modulus_pa: float
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


def _table(*materials: Material) -> Mapping[str, Material]:
    return MappingProxyType({material.name: material for material in materials})


MATERIALS: Mapping[str, Material] = _table(
    # Steel of the twin rotor benchmark.
    Material(
        name="steel",
        density_kg_per_m3=7800.0,
        youngs_modulus_pa=2.0e11,
        poissons_ratio=0.3,
    ),
    # Ti-6Al-4V, room temperature.
    Material(
        name="titanium",
        density_kg_per_m3=4430.0,
        youngs_modulus_pa=1.138e11,
        poissons_ratio=0.342,
    ),
    # Inconel 718, room temperature.
    Material(
        name="nickel_alloy",
        density_kg_per_m3=8190.0,
        youngs_modulus_pa=2.0e11,
        poissons_ratio=0.29,
    ),
    Material(
        name="aluminium",
        density_kg_per_m3=2700.0,
        youngs_modulus_pa=7.0e10,
        poissons_ratio=0.33,
    ),
)
"""Common materials by name (read-only); room temperature, typical handbook values."""


def find_material(name: str) -> Material:
    """Return the material of the table `MATERIALS` with the given name.

    Parameters
    ----------
    name : str
        A key of `MATERIALS`.

    Returns
    -------
    Material

    Raises
    ------
    GeometryError
        If there is no such material; the message lists the known names.
    """
    try:
        return MATERIALS[name]
    except KeyError:
        known = ", ".join(sorted(MATERIALS))
        raise GeometryError(f"no material is called '{name}'; known: {known}") from None
