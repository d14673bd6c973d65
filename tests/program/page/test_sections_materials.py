"""Materials on the page: masses by material against closed forms, sections and their shades."""

from __future__ import annotations

import math

import pytest
from everything import everything

from solidwhirl.drawing.bodies import Silhouette, profile_parts, silhouettes_of
from solidwhirl.drawing.engine import engine_drawing, materials_of
from solidwhirl.drawing.shapes import Group, Words
from solidwhirl.model.bodies import build_bodies
from solidwhirl.page.drawing.materials import materials_table, sections_table
from solidwhirl.page.drawing.svg import svg_of
from solidwhirl.scene_reading.reader import parse_scene

DENSITY = {"light": 2000.0, "heavy": 8000.0}


@pytest.fixture(scope="module")
def scene(small_scene):
    """A shaft of one material in a ring of another, with a rigid disk of 3 kg."""
    disk = {"name": "d", "interface": "left", "mass_kg": 3.0}
    disk |= {"polar_inertia_kg_m2": 0.1, "diametral_inertia_kg_m2": 0.06}
    moduli = {"youngs_modulus_pa": 1e11, "poissons_ratio": 0.3}
    materials = {n: {"density_kg_per_m3": d, **moduli} for n, d in DENSITY.items()}
    data = small_scene(body={"material": "light", "rigid_disks": [disk]}, materials=materials)
    data["bodies"]["rotor"]["sections"][1]["material"] = "heavy"
    return parse_scene(data)


def test_masses_by_material_are_density_times_volume(scene):
    shaft = math.pi * 0.02**2 * 0.4 * DENSITY["light"]
    ring = math.pi * (0.12**2 - 0.02**2) * 0.04 * DENSITY["heavy"]
    whole = shaft + ring + 3.0
    (table,) = materials_table(scene, build_bodies(scene), {"rotor": {"mass_kg": whole}})
    found = {row[1]: row for row in table.rows}
    assert list(found) == ["light", "heavy", "rigid disks"]
    for name, mass in (("light", shaft), ("heavy", ring), ("rigid disks", 3.0)):
        assert found[name][3] == pytest.approx(mass, rel=1e-12)
        assert float(found[name][4]) == pytest.approx(100 * mass / whole, rel=6e-3)
    assert found["heavy"][2] == 8000.0 and found["rigid disks"][2] is None


def test_masses_of_beams_make_up_the_body():
    run = everything()
    (table,) = materials_table(run.results.scene, run.results.geometry, run.document["bodies"])
    for name in ("lp", "fan"):
        own = sum(row[3] for row in table.rows if row[0] == name)
        assert own == pytest.approx(run.document["bodies"][name]["mass_kg"], rel=1e-9)
    assert "casing" not in {row[0] for row in table.rows}  # whose material nobody gave


def test_every_section_is_listed_with_its_material(scene):
    (table,) = sections_table(scene, build_bodies(scene))
    rows = [(row[0], row[5]) for row in table.rows]
    assert rows == [("rotor: shaft", "light"), ("rotor: disk", "heavy")]
    assert table.folded.endswith("(2)")
    beams = everything().results
    (table,) = sections_table(beams.scene, beams.geometry)
    assert len(table.rows) == 6 + 4 and {row[5] for row in table.rows} == {"steel"}


def test_materials_are_named_and_shaded_on_the_drawing(scene):
    (profile,) = build_bodies(scene).values()
    parts = profile_parts(profile)
    body = Silhouette(
        name="rotor",
        kind="cut",
        areas_m=tuple(p.corners_m for p in parts),
        nodes_m={"left": (0.0, 0.0), "right": (0.4, 0.0)},
        seats_m={"left": 0.02, "right": 0.02},
        disks=(),
        center_m=(0.0, 0.0),
        speed_ratio=1.0,
        labels=tuple(f"rotor: {p.name}, {p.material}" for p in parts),
        materials=tuple(p.material for p in parts),
    )
    drawing = engine_drawing(scene, [body], (500.0, 200.0), (), ())
    groups = {g.title: g for shape in drawing.shapes if isinstance(shape, Group)
              for g in shape.shapes if isinstance(g, Group)}  # fmt: skip
    assert set(groups) == {"rotor: disk, heavy", "rotor: shaft, light"}
    # the second material lies darker under its hatching, the first one plain
    looks = {title: [p.style.opacity for p in g.shapes if p.style.fill == "ink"]
             for title, g in groups.items()}  # fmt: skip
    assert looks == {"rotor: disk, heavy": [0.3], "rotor: shaft, light": []}
    svg = svg_of(drawing)
    assert "<title>rotor: disk, heavy</title>" in svg
    # on both sides of the axis; in the legend it has a line around it
    assert svg.count('fill="var(--ink)" fill-opacity="0.3"/>') == 2
    assert svg.count('fill="var(--ink)" stroke="var(--muted)"') == 2
    assert ">light<" in svg and ">heavy<" in svg


def test_one_material_is_not_in_the_legend():
    found = silhouettes_of(everything().results)
    assert materials_of(found) == ("steel",)
    drawing = engine_drawing(everything().results.scene, found, (1000.0, 300.0), (), ())
    assert "steel" not in {s.text for s in drawing.shapes if isinstance(s, Words)}
    cut = [b for b in found if b.kind == "cut"]
    assert all(len(b.labels) == len(b.materials) == len(b.areas_m) for b in cut)
