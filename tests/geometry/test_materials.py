"""The material table and what a material refuses."""

from __future__ import annotations

import pytest

from solidwhirl.geometry import MATERIALS, GeometryError, Material


def test_table_values():
    found = {
        name: (m.name, m.density_kg_per_m3, m.youngs_modulus_pa, m.poissons_ratio)
        for name, m in MATERIALS.items()
    }
    assert found == {
        "steel": ("steel", 7800.0, 2.0e11, 0.3),
        "titanium": ("titanium", 4430.0, 1.138e11, 0.342),
        "nickel_alloy": ("nickel_alloy", 8190.0, 2.0e11, 0.29),
        "aluminium": ("aluminium", 2700.0, 7.0e10, 0.33),
    }


def test_table_is_read_only():
    with pytest.raises(TypeError):
        MATERIALS["cheese"] = MATERIALS["steel"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"density_kg_per_m3": 0.0}, "'x': density is 0.0 kg/m"),
        ({"density_kg_per_m3": float("nan")}, "density is nan"),
        ({"youngs_modulus_pa": -1.0}, "Young's modulus is -1.0 Pa, must be finite and positive"),
        ({"youngs_modulus_pa": float("inf")}, "Young's modulus is inf"),
        ({"poissons_ratio": 0.5}, "Poisson's ratio is 0.5, must lie between -1 and 0.5"),
        ({"poissons_ratio": -1.0}, "Poisson's ratio is -1.0"),
        ({"poissons_ratio": float("nan")}, "Poisson's ratio is nan"),
        ({"name": ""}, "a material needs a name"),
    ],
)
def test_refused_constants(change, message):
    good = {"name": "x", "density_kg_per_m3": 1.0, "youngs_modulus_pa": 1.0, "poissons_ratio": 0.0}
    with pytest.raises(GeometryError, match=message):
        Material(**{**good, **change})
