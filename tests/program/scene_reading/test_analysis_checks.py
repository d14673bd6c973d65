"""Analyses and joints that do not fit the engine are refused with the key, before any work."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from engine_of_all_kinds import ENGINE, KINDS

from solidwhirl.core.errors import SceneError
from solidwhirl.model.effects import make_plan
from solidwhirl.scene_checks.speeds_asked import top_speed
from solidwhirl.scene_reading.reader import parse_scene


def analysis(kind, **changes):
    return {"kind": kind, **KINDS[kind], **changes}


def engine(*analyses):
    return copy.deepcopy(ENGINE | {"analyses": [*analyses]})


COMPARED = {"bands_hz": [[1, 9]]}
CASES = [
    ("separation_margins", {"operating": [{"shaft": "casing", "from_rpm": 1, "to_rpm": 2}]},
     "analyses[0].operating[0].shaft: 'casing' does not turn"),
    ("api617", {"shaft": None}, "analyses[0].shaft: missing; [[operating]] has no shaft"),
    ("api617", {"trip_rpm": 4e3}, "trip_rpm = 4000 is below maximum_continuous_rpm = 5000"),
    ("api617", {"minimum_speed_rpm": None},
     "analyses[0].minimum_speed_rpm: missing; give it here or as [[operating]]"),
    ("api617", {"probes": [{"at": "hp.a"}]},
     "analyses[0].probes[0].at: 'hp.a' does not turn with 'lp'; bodies that do are ['lp']"),
    ("api617", {"journals": ["A", "mount"]},
     "analyses[0].journals[1]: 'mount' does not hold 'lp' against anything else"),
    ("api617", {"level_2": [{"name": n, "bearings": ["B"]} for n in "ab"]},
     "analyses[0].level_2[0].bearings: 'B' stands in more than one group"),
    ("api617", {"level_2": [{"name": "a"}]}, "level_2[0]: names nothing"),
    ("api617", {"level_2": [{"name": "a", "stages": ["lp.b"]}]},
     "level_2[0].stages: no place of stages 'lp.b'"),
    ("api617", {"cases": [{"name": "hot", "laws": {"mount": "table"}}]},
     "analyses[0].cases[0].laws.mount: the bearing has no speed_law in the scene"),
    ("api617", {"cases": [{"name": "hot", "laws": {"Z": "pads"}}]},
     "analyses[0].cases[0].laws: no bearing 'Z'"),
    ("api617", {"cases": [{"name": n, "laws": {"A": "pads"}} for n in ("hot oil", "Hot_oil")]},
     "cases: 'hot_oil' would name a picture twice"),
    ("api617", {"stages": [{"at": "lp.m", "power_w": 1e5, "diameter_m": 0.4, "height_m": 0.02}]},
     "a radial stage needs density_ratio"),
    ("place_map", {"places": ["lp.m", "casing.a"]},
     "analyses[0].places[1]: 'casing' does not turn"),
    ("rotating_campbell", {"bodies": ["casing"]},
     "analyses[0].bodies[0]: 'casing' does not turn"),
    ("stiffness_study", {"excite": "casing.a"}, "analyses[0].excite: 'casing' does not turn"),
    ("run_up", {"compare_flexible": [["casing"]]},
     "analyses[0].compare_flexible[0][0]: 'casing' does not turn"),
    ("run_up", {"compare_flexible": [["lp", "lp"]]},
     "analyses[0]: compare_flexible[0] names a body twice"),
    ("run_up", {"compare_flexible": [[], ["lp"], []]},
     "compare_flexible[2] is the same as compare_flexible[0]"),
    ("run_up", {"gravity_m_per_s2": [0, -9.81, 0]},
     "analyses[0].compare_flexible: models are compared without weight"),
    ("run_up", {"gravity_m_per_s2": [0, 0, 9.81], "compare_flexible": [], "bands_hz": []},
     "analyses[0].gravity_m_per_s2: 9.81 along z, but nothing holds a body along the axis"),
    ("run_up", {"ramp_s": 1e5, "hold_s": 0}, "5e+08 steps; at most 5e+07"),
    ("run_up", {"hold_s": 0.20001}, "hold_s * sampling_hz is 1000.05"),
    ("run_up", {"ramp_s": 1e-12}, "ramp_s must be a whole number of steps"),
    ("run_up", {"record_hz": 1100.0}, "are 1000 and 1250"),
    ("run_up", {"record_hz": 200.0}, "analyses[0].record_hz: 200, but the fastest"),
    ("run_up", {"sampling_hz": 500.0, "record_hz": 500.0},
     "analyses[0].sampling_hz: 500, but the fastest unbalance turns at 100 Hz; at least 628.319"),
    ("stiffness_study", {"operating_speed_rpm": 9e3}, "120 to 180 Hz"),
    ("stiffness_study", {"frequency_count": 8}, "5 or more inside"),
    ("stiffness_study", {"stiffness_count": 2000, "frequency_count": 2000},
     "2000 x 2000 = 4000000; a map has at most 2000000"),
    ("waterfall", {"speed_count": 2000, "frequency_count": 2000},
     "analyses[0]: speed_count x frequency_count"),
    ("stiffness_study", {"bearings": ["C"]}, "analyses[0].bearings[0]: 'C' has the table 'table'"),
    ("mode_shapes", {"speeds_rpm": [9.0, 9.0]},
     "analyses[0]: mode_shapes_9rpm.png would be written twice"),
]  # fmt: skip


def refusal(data):
    with pytest.raises(SceneError) as caught:
        parse_scene(data)
    return str(caught.value)


@pytest.mark.parametrize(("kind", "changes", "said"), CASES)
def test_analysis_that_does_not_fit(kind, changes, said):
    assert parse_scene(engine(analysis(kind))).analyses[0].kind == kind
    assert said in refusal(engine(analysis(kind, **changes)))


@pytest.mark.parametrize("kind", ["stiffness_study", "critical_speed_map"])
def test_bearing_without_a_stiffness_to_vary(kind):
    data = engine(analysis(kind))
    data["bearings"][1] = {"name": "B", "first": "lp.b", "second": "casing.b", "rigid": ["ux"]}
    assert "analyses[0].bearings[0]: 'B' is rigid in ux or uy" in refusal(data)


def test_law_takes_the_speed_of_a_body_that_turns():
    data = engine()
    data["bearings"][0] |= {"first": "casing.a", "second": "lp.a"}
    assert "bearings[0].first: 'casing' does not turn" in refusal(data)


def test_inertia_that_no_body_has():
    """Ixx + Iyy - Izz is twice the integral of z^2, which is not negative; likewise the others."""
    data = engine()
    data["rigid_bodies"]["casing"]["inertia_kg_m2"] = [0.5, 2, 1.4]
    assert "rigid_bodies.casing: inertia_kg_m2 has 2" in refusal(data)
    data["rigid_bodies"]["casing"]["inertia_kg_m2"] = [0.5, 1.9, 1.4]
    assert parse_scene(data).rigid_bodies


ORBITS = "unbalance_response_orbits"


@pytest.mark.parametrize(
    ("kind", "changes", "name", "file"),
    [
        ("unbalance_response", {"orbits_at_rpm": [9.0]}, ORBITS, f"{ORBITS}.png"),
        ("unbalance_response", {"observe": ["lp.m"] * 8}, "unbalance_response_2", ""),
        ("mode_shapes", {"speeds_rpm": [0.0]}, "mode_shapes_0rpm", "mode_shapes_0rpm.png"),
        ("unbalance_response", {}, ORBITS, None),
        ("unbalance_response", {}, "unbalance_response_2", None),
    ],
)
def test_files_of_two_analyses(kind, changes, name, file):
    data = engine(analysis(kind, **changes), analysis("waterfall", name=name))
    if file is None:
        assert len(parse_scene(data).analyses) == 2
    else:
        assert f"analyses[1].name: {name!r} would write {file}" in refusal(data)


@pytest.mark.parametrize("kind", ["stiffness_study", "place_map", "unbalance_response"])
def test_force_at_one_spin_asks_for_no_more(kind):
    """The frequency of the force is not that of the turn then."""
    largest = 9e3 if kind != "unbalance_response" else 6e3
    for changes, rpm in (({"speed_rpm": 6.5e3}, 6.5e3), ({}, largest)):
        scene = parse_scene(engine(analysis(kind, **changes)))
        assert top_speed(scene) == pytest.approx(rpm * np.pi / 30.0)


def test_plan_says_who_keeps_motions_that_nothing_acts_on():
    data = engine()
    del data["gears"]
    data["beams"]["hp"]["speed_ratio"] = 1.0
    data["rigid_bodies"]["casing"]["center_of_gravity_m"] = [0.1, 0.0, 0.5]
    why = {e.name: e.why for e in make_plan(parse_scene(data), {}).effects}
    assert "but in casing" in why["axial"]
    assert "but in casing" in why["torsion"]


NODAL = {"kind": "nodal_diameters", "body": "drum", "to_rpm": 9000}
STATE = {"name": "a", "mode": 1, "speed_rpm": 0}
FIELDS = {"kind": "recovery", "bodies": ["drum"], "states": [STATE]}


@pytest.mark.parametrize(
    ("analysis", "message"),
    [
        (NODAL, r"analyses\[0\]\.body: .* counts 24, 31, 37, .* own"),
        (FIELDS, r"analyses\[0\]\.bodies\[0\]: .* counts 24, 31, 37, .* divisor"),
    ],
)
def test_fields_of_stages_without_a_common_sector(scene_data, analysis, message):
    data = scene_data("drum_stages")
    data["analyses"] = [analysis]
    with pytest.raises(SceneError, match=message):
        parse_scene(data)
    data["bodies"]["drum"]["blades"] = data["bodies"]["drum"]["blades"][:1]
    assert parse_scene(data).analyses[0].kind == analysis["kind"]
