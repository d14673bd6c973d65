"""Blades, holes, slots and the like of a scene: what geometry gets, on which level bodies are."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import pytest
from simplex import mesh_mass_kg

from solidwhirl.bodies.fidelity import chosen_level
from solidwhirl.bodies.reduction import first_discretisation, mesh_body
from solidwhirl.geometry import GeometryError, mass_properties, symmetry
from solidwhirl.model.bodies import build_bodies
from solidwhirl.model.effects import make_plan
from solidwhirl.scene_reading.reader import parse_scene, scene_hash, with_model

FAN = {"name": "fan", "on": "disk", "count": 9, "length_m": 0.05}
FAN |= {"chord_m": 0.01, "thickness_m": [0.004, 0.002], "stagger_deg": [0, 30]}
BOLTS = {"name": "bolts", "in": "disk", "count": 6}
BOLTS |= {"pitch_radius_m": 0.1, "diameter_m": 0.01, "angle_deg": 10}
KEYS = {"name": "keys", "in": "shaft", "count": 3, "width_m": 0.006, "depth_m": 0.004}
KEYS |= {"start_m": 0.0, "end_m": 0.05}


@pytest.fixture
def twin(scene_data):
    """Function: the twin rotor, with changes of the inner one and of the model."""

    def make(model=None, **changes):
        data = scene_data("ferraris")
        data["bodies"]["inner"] |= changes
        data["model"] |= model or {}
        return parse_scene(data)

    return make


def test_features_reach_geometry(twin):
    scene = twin(blades=[FAN, {**FAN, "name": "more", "at_m": 0.13, "material": "titanium"}])
    inner = build_bodies(twin(blades=[FAN], holes=[BOLTS], slots=[KEYS]))["inner"]
    assert [f.name for f in inner.features] == ["fan", "bolts", "keys"]
    blade, hole, slot = inner.features
    assert (blade.chord_m, blade.thickness_m) == ((0.01, 0.01), (0.004, 0.002))
    assert (blade.stagger_deg, blade.material.name) == ((0.0, 30.0), "steel")
    assert (hole.angle_deg, hole.diameter_m) == (10.0, 0.01)
    assert (slot.start_m, slot.end_m, slot.count) == (0.0, 0.05, 3)
    shaft, disk = inner.sections[0], (inner.sections[1].start_m, inner.sections[1].end_m)
    radius, ends = max(shaft.outer_radius_m), {"start_m": 0.06, "end_m": 0.07}
    cut = {"in": "disk", "width_deg": 30.0, "depth_m": 0.01, "start_m": disk[0], "end_m": disk[1]}
    added = build_bodies(
        twin(
            holes=[{**BOLTS, "count": 2, "end_m": 0.5 * sum(disk)}],
            slots=[{**KEYS, "count": 2, "per_group": 2, "pitch_deg": 40.0}],
            keyways=[{**KEYS, "name": "key", "count": 1, "angle_deg": 90.0, "end_m": 0.04}],
            flats=[{"name": "wrench", "in": "shaft", "distance_m": 0.9 * radius, **ends}],
            cuts=[{"name": "gap", **cut}],
        )
    )["inner"]
    hole, slot, keyway, flat, gap = added.features
    assert (hole.start_m, hole.end_m) == (None, 0.5 * sum(disk))
    assert (slot.per_group, slot.pitch_deg, slot.ends) == (2, 40.0, "square")
    assert (keyway.kind, keyway.count, keyway.ends) == ("keyways", 1, "round")
    assert (flat.count, flat.distance_m) == (1, 0.9 * radius)
    assert (gap.count, gap.width_deg, gap.depth_m) == (1, 30.0, 0.01)
    assert symmetry(added) == "asymmetric"
    with pytest.raises(GeometryError, match=r"^bodies\.inner: .*'fan' and blades 'more' meet"):
        build_bodies(scene)


def test_only_bodies_with_features_are_solids(twin):
    scene = twin(blades=[FAN], model={"accuracy": 0.1})
    bodies = build_bodies(scene)
    level = chosen_level(scene, bodies)
    plan = make_plan(scene, bodies, level)
    assert {name: own.level for name, own in plan.bodies.items()} == {
        "inner": "solid",
        "outer": "harmonic",
    }
    # without them beams are good enough, so that it is the features that keep them out
    plain = twin(model={"accuracy": 0.1})
    assert chosen_level(plain, build_bodies(plain)) == "beam"


def test_the_accuracy_is_coarser_with_features_where_none_is_given(scene_data):
    def accuracy(**changes):
        data = scene_data("ferraris")
        del data["model"]
        data |= {"model": changes.pop("model")} if "model" in changes else {}
        data["bodies"]["inner"] |= changes
        scene = parse_scene(data)
        again = parse_scene(json.loads(scene.model_dump_json(exclude_unset=True, by_alias=True)))
        assert again.model.accuracy == scene.model.accuracy
        return scene.model.accuracy

    assert accuracy() == accuracy(model={"level": "harmonic"}) == 1e-3
    assert accuracy(blades=[FAN]) == accuracy(holes=[BOLTS], model={"level": "solid"}) == 1e-2
    assert accuracy(blades=[FAN], model={"accuracy": 1e-3}) == 1e-3


@pytest.mark.parametrize("level", ["beam", "harmonic"])
def test_levels_without_features_are_refused_from_the_command_line_too(twin, level):
    scene = with_model(twin(holes=[BOLTS]), level=level, accuracy=None)
    with pytest.raises(GeometryError, match=rf"^model\.level: '{level}' .* holes 'bolts'"):
        build_bodies(scene)


def test_features_are_never_left_out_of_a_mesh(twin):
    scene = twin(holes=[BOLTS])
    bodies = build_bodies(scene)
    plan = make_plan(scene, bodies)
    chosen = first_discretisation(scene, plan, "inner")
    body, mesh = bodies["inner"], mesh_body(bodies["inner"], "solid", chosen)
    copies = mesh.sector.count * (2 if mesh.sector.mirrored else 1)
    without = mass_properties(replace(body, features=())).mass_kg
    exact, found = mass_properties(body).mass_kg, copies * mesh_mass_kg(mesh)
    # the holes are 0.5 % of the mass; edges of second order leave 0.1 % on the rim of a coarse mesh
    assert found == pytest.approx(exact, abs=0.5 * (without - exact))


def test_scenes_without_features_say_nothing_of_them(twin):
    plain, with_holes = twin(), twin(holes=[BOLTS])
    kinds = {"blades", "holes", "slots", "keyways", "flats", "cuts"}
    assert not kinds & set(plain.model_dump()["bodies"]["inner"])
    # keys that came later are in no hash of a scene that does not use them
    dumped = twin(holes=[BOLTS], slots=[KEYS]).model_dump(by_alias=True)["bodies"]["inner"]
    assert set(dumped["holes"][0]) == set(BOLTS)
    assert set(dumped["slots"][0]) == {*KEYS, "angle_deg"}
    assert plain.bodies["inner"].blades == ()
    assert scene_hash(plain) == scene_hash(twin(holes=[]))
    assert scene_hash(plain) != scene_hash(with_holes)
    dumped = with_holes.model_dump(mode="json", exclude_unset=True, by_alias=True)
    assert parse_scene(dumped) == with_holes


GROUP = {"name": "hp", "table": "hp_turbine", "start_m": 0.0, "spacer_thickness_m": 0.01}
BLADES = {"count": 30, "length_m": 0.04, "length_factor": 1.5, "thickness_m": [0.003, 0.001]}


def staged(small_scene, **blades):
    group = {**GROUP, "material": "nickel_alloy", "blades": {**BLADES, **blades}}
    rotor = {"stage_groups": [group], "sections": [], "interfaces": []}
    data = small_scene(body=rotor)
    data["bearings"] = []
    return build_bodies(parse_scene(data))["rotor"]


def test_blades_of_a_stage_group(small_scene):
    """Widths of Table 7: 0.0122 m and 1.4 times that; chords as wide unless they are given."""
    rows = staged(small_scene, stagger_deg=60).features
    assert [(r.name, r.on, r.count) for r in rows] == [
        ("hp_blades_1", "hp_stage_1", 30),
        ("hp_blades_2", "hp_stage_2", 30),
    ]
    assert [r.length_m for r in rows] == pytest.approx([0.04, 0.06])
    assert [r.chord_m[1] for r in rows] == pytest.approx([0.0244, 0.0244 * 1.4])
    assert [r.thickness_m[1] for r in rows] == pytest.approx([0.001, 0.001])
    assert {r.material.name for r in rows} == {"nickel_alloy"}
    rows = staged(small_scene, count=[30, 45], chord_m=0.01, chord_factor=2.0).features
    assert [r.count for r in rows] == [30, 45]
    assert [r.chord_m for r in rows] == [(0.01, 0.01), pytest.approx((0.02, 0.02))]


def test_one_count_for_each_stage(small_scene):
    with pytest.raises(GeometryError, match=r"^bodies\.rotor: .* 3 counts of blades, there are 2"):
        staged(small_scene, count=[30, 45, 60])


def test_blades_of_a_stage_weigh_what_their_plates_do(small_scene):
    """Chord and thickness by their means, to what the curved ring takes at the root."""
    bare = staged(small_scene)
    plates = sum(
        row.count * row.length_m * row.chord_m[0] * 0.5 * sum(row.thickness_m)
        for row in bare.features
    )
    ring = sum(
        math.pi * (s.outer_radius_m[0] ** 2 - s.inner_radius_m[0] ** 2) * (s.end_m - s.start_m)
        for s in bare.sections
        if "stage" in s.name
    )
    spacer = next(s for s in bare.sections if "spacer" in s.name)
    nodes = [
        spacer.radii_at(spacer.start_m + t * (spacer.end_m - spacer.start_m)) for t in (0, 0.5, 1)
    ]
    area = [math.pi * (outer**2 - inner**2) for inner, outer in nodes]
    volume = (area[0] + 4 * area[1] + area[2]) / 6 * (spacer.end_m - spacer.start_m)
    density = bare.sections[0].material.density_kg_per_m3
    blades_kg = mass_properties(bare).mass_kg - density * (ring + volume)
    assert blades_kg == pytest.approx(density * plates, rel=1e-3)
