"""Materials on the page: masses by material against closed forms, sections and their shades."""

from __future__ import annotations

import math

import numpy as np
import pytest
from everything import everything

from solidwhirl.bodies import build_bodies
from solidwhirl.page.drawing import _legend, materials_of
from solidwhirl.page.drawing_parts import Frame, body_parts, shade
from solidwhirl.page.materials import materials_table, profile_parts, sections_table
from solidwhirl.page.silhouettes import Silhouette, silhouettes_of
from solidwhirl.scene_file import parse_scene

DENSITY = {"light": 2000.0, "heavy": 8000.0}


def scene():
    """A shaft of one material in a ring of another, with a rigid disk of 3 kg."""
    moduli = {"youngs_modulus_pa": 1e11, "poissons_ratio": 0.3}
    return parse_scene(
        {
            "name": "two",
            "speeds": {"list_rpm": [0.0, 100.0]},
            "materials": {n: {"density_kg_per_m3": d, **moduli} for n, d in DENSITY.items()},
            "bodies": {
                "rotor": {
                    "material": "light",
                    "sections": [
                        {"name": "shaft", "start_m": 0.0, "end_m": 0.5, "outer_radius_m": 0.02},
                        {
                            "name": "ring",
                            "start_m": 0.2,
                            "end_m": 0.3,
                            "inner_radius_m": 0.02,
                            "outer_radius_m": [0.1, 0.1],
                            "material": "heavy",
                        },
                    ],
                    "interfaces": [{"name": "a", "kind": "section", "at_m": 0.0}],
                    "rigid_disks": [
                        {
                            "name": "d",
                            "interface": "a",
                            "mass_kg": 3.0,
                            "polar_inertia_kg_m2": 0.1,
                            "diametral_inertia_kg_m2": 0.06,
                        }
                    ],
                }
            },
            "bearings": [{"name": "A", "first": "rotor.a", "stiffness_n_per_m": 1e7}],
        }
    )


def test_masses_by_material_are_density_times_volume():
    shaft = math.pi * 0.02**2 * 0.5 * DENSITY["light"]
    ring = math.pi * (0.1**2 - 0.02**2) * 0.1 * DENSITY["heavy"]
    whole = shaft + ring + 3.0
    (table,) = materials_table(scene(), {"rotor": {"mass_kg": whole}})
    found = {row[1]: row for row in table.rows}
    assert list(found) == ["light", "heavy", "rigid disks"]
    for name, mass in (("light", shaft), ("heavy", ring), ("rigid disks", 3.0)):
        assert found[name][3] == pytest.approx(mass, rel=1e-12)
        assert float(found[name][4]) == pytest.approx(100 * mass / whole, rel=6e-3)
    assert found["heavy"][2] == 8000.0 and found["rigid disks"][2] is None


def test_masses_of_beams_make_up_the_body():
    run = everything()
    (table,) = materials_table(run.results.scene, run.document["bodies"])
    for name in ("lp", "fan"):
        own = sum(row[3] for row in table.rows if row[0] == name)
        assert own == pytest.approx(run.document["bodies"][name]["mass_kg"], rel=1e-9)
    assert "casing" not in {row[0] for row in table.rows}  # whose material nobody gave


def test_every_section_is_listed_with_its_material():
    (table,) = sections_table(scene())
    assert [(row[0], row[5]) for row in table.rows] == [
        ("rotor: shaft", "light"),
        ("rotor: ring", "heavy"),
    ]
    assert table.folded.endswith("(2)")
    beams = everything().results.scene
    (table,) = sections_table(beams)
    assert len(table.rows) == 6 + 4 and {row[5] for row in table.rows} == {"steel"}


def test_materials_are_named_and_shaded_on_the_drawing():
    (profile,) = build_bodies(scene()).values()
    parts = profile_parts(profile)

    areas = tuple(np.array([(p.start_m, 0.0), (p.end_m, 0.0), (p.end_m, 1.0)]) for p in parts)
    body = Silhouette(
        name="rotor",
        kind="cut",
        areas_m=areas,
        nodes_m={},
        seats_m={},
        disks=(),
        center_m=(0.0, 0.0),
        speed_ratio=1.0,
        labels=tuple(f"rotor: {p.name}, {p.material}" for p in parts),
        materials=tuple(p.material for p in parts),
    )
    assert materials_of([body]) == ("light", "heavy")
    frame = Frame(left=0.0, axis=0.0, first_m=0.0, scale=100.0)
    drawn = "".join(body_parts(frame, body, 0, materials_of([body])))
    assert "<title>rotor: ring, heavy</title>" in drawn and "rotor: shaft, light" in drawn
    # the second material lies darker under its hatching, the first one plain
    assert drawn.count(shade("heavy", ("light", "heavy"))) == 1
    assert 'fill-opacity="0"' in shade("light", ("light", "heavy"))
    legend = "".join(part for row in _legend([body], 500.0) for part in row)
    assert ">light<" in legend and ">heavy<" in legend


def test_one_material_is_not_in_the_legend():
    found = silhouettes_of(everything().results)
    assert materials_of(found) == ("steel",)
    assert ">steel<" not in "".join(part for row in _legend(found, 1000.0) for part in row)
    cut = [b for b in found if b.kind == "cut"]
    assert all(len(b.labels) == len(b.materials) == len(b.areas_m) for b in cut)
