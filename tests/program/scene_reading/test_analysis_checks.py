"""Analyses and joints that do not fit the engine are refused with the key, before any work."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from solidwhirl.core.errors import SceneError
from solidwhirl.model.effects import make_plan
from solidwhirl.scene_checks.speeds_asked import top_speed
from solidwhirl.scene_reading.reader import parse_scene

RESPONSE = {
    "kind": "unbalance_response",
    "unbalances": [{"at": "rotor.m", "moment_kg_m": 1e-4}],
    "observe": ["rotor.m"],
    "to_rpm": 6e3,
}
RUN = {"kind": "run_up", "ramp_s": 1.0, "to_rpm": 6e3, "mount": "A"}
RUN |= {"unbalances": RESPONSE["unbalances"]}
COMPARED = {**RUN, "bands_hz": [[1, 9]]}
SHAPES = {"kind": "mode_shapes", "speeds_rpm": [0.0]}
STUDY = {
    "kind": "stiffness_study",
    "bearings": ["A"],
    "excite": "rotor.m",
    "observe": "rotor.m",
    "moment_kg_m": 1e-4,
    "stiffness_from_n_per_m": 1e6,
    "stiffness_to_n_per_m": 1e8,
    "frequency_max_hz": 200.0,
    "operating_speed_rpm": 6e3,
}
MAP = {key: STUDY[key] for key in STUDY if key.startswith(("bearings", "stiffness"))}
MAP |= {"kind": "critical_speed_map", "excited_by": "rotor", "search_to_rpm": 9e3}
WATERFALL = {"kind": "waterfall", "observe": "rotor.m", "to_rpm": 6e3, "frequency_max_hz": 9.0}
PLACES = {"kind": "place_map", "moment_kg_m": 1, "frequency_max_hz": 9}
MARGINS = {"kind": "separation_margins"}


def engine(*analyses, casing=None, **changes):
    """A rigid rotor in a casing."""
    body = {"mass_kg": 9.0, "center_of_gravity_m": [0.0, 0.0, 0.0]}
    body |= {"inertia_kg_m2": [0.5, 0.5, 0.4], "interfaces": {"a": -0.4, "m": 0.0, "b": 0.4}}
    spring = {"stiffness_n_per_m": 1e7}
    data = {
        "name": "engine",
        "rigid_bodies": {"rotor": {**body, "speed_ratio": 1.0}, "casing": body | (casing or {})},
        "bearings": [
            {"name": "A", "first": "rotor.a", "second": "casing.a", **spring},
            {"name": "B", "first": "rotor.b", "second": "casing.b", **spring},
            {"name": "M", "first": "casing.m", **spring},
        ],
        "analyses": list(analyses),
    }
    return copy.deepcopy({**data, **changes})


CASES = [
    ({**MARGINS, "operating": [{"shaft": "casing", "from_rpm": 1, "to_rpm": 2}]},
     "analyses[0].operating[0].shaft: 'casing' does not turn"),
    ({**PLACES, "places": ["rotor.m", "casing.m"]},
     "analyses[0].places[1]: 'casing' does not turn"),
    ({"kind": "rotating_campbell", "bodies": ["casing"]},
     "analyses[0].bodies[0]: 'casing' does not turn"),
    ({**STUDY, "excite": "casing.m"}, "analyses[0].excite: 'casing' does not turn"),
    ({**COMPARED, "compare_flexible": [["casing"]]},
     "analyses[0].compare_flexible[0][0]: 'casing' does not turn"),
    ({**COMPARED, "compare_flexible": [["rotor", "rotor"]]},
     "analyses[0]: compare_flexible[0] names a body twice"),
    ({**COMPARED, "compare_flexible": [[], ["rotor"], []]},
     "compare_flexible[2] is the same as compare_flexible[0]"),
    ({**COMPARED, "compare_flexible": [[]], "gravity_m_per_s2": [0, -9.81, 0]},
     "analyses[0].compare_flexible: models are compared without weight"),
    ({**RUN, "gravity_m_per_s2": [0, 0, 9.81]},
     "analyses[0].gravity_m_per_s2: 9.81 along z, but no body can move along the axis"),
    ({**RUN, "ramp_s": 1e4}, "2e+08 steps; at most 5e+07"),
    ({**RUN, "hold_s": 0.20001}, "hold_s * sampling_hz is 4000.2"),
    ({**RUN, "ramp_s": 1e-12}, "ramp_s must be a whole number of steps"),
    ({**RUN, "record_hz": 3e3}, "are 2857.14286 and 3333.33333"),
    ({**RUN, "record_hz": 200.0}, "analyses[0].record_hz: 200, but the fastest"),
    ({**RUN, "sampling_hz": 500.0, "record_hz": 500.0},
     "analyses[0].sampling_hz: 500, but the fastest unbalance turns at 100 Hz; at least 628.319"),
    ({**STUDY, "operating_speed_rpm": 11e3}, "146.667 to 220 Hz"),
    ({**STUDY, "frequency_count": 8}, "5 or more inside"),
    ({**STUDY, "stiffness_count": 2000, "frequency_count": 2000},
     "2000 x 2000 = 4000000; a map has at most 2000000"),
    ({**WATERFALL, "speed_count": 2000, "frequency_count": 2000},
     "analyses[0]: speed_count x frequency_count"),
]  # fmt: skip


def refusal(data):
    with pytest.raises(SceneError) as caught:
        parse_scene(data)
    return str(caught.value)


@pytest.mark.parametrize(("analysis", "said"), CASES)
def test_analysis_that_does_not_fit(analysis, said):
    assert said in refusal(engine(analysis))


@pytest.mark.parametrize("analysis", [RESPONSE, RUN, SHAPES, STUDY, MAP, WATERFALL])
def test_what_the_cases_start_from_is_accepted(analysis):
    assert parse_scene(engine(analysis)).analyses[0].kind == analysis["kind"]


@pytest.mark.parametrize("analysis", [STUDY, MAP])
@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"rigid": ["ux", "uy"]}, "analyses[0].bearings[0]: 'A' is rigid in ux or uy"),
        ({"speed_law": "film"}, "analyses[0].bearings[0]: 'A' has the table 'film'"),
    ],
)
def test_bearing_without_a_stiffness_to_vary(analysis, changes, said):
    film = {"kind": "table", "speed_rpm": [0, 9], "stiffness_n_per_m": [1, 2]}
    data = engine(analysis, speed_laws={"film": {**film, "damping_n_s_per_m": [0, 0]}})
    data["bearings"][0] = {"name": "A", "first": "rotor.a", "second": "casing.a", **changes}
    assert said in refusal(data)


def test_critical_speed_map_with_cross_terms():
    data = engine(MAP)
    data["bearings"][1]["stiffness_n_per_m"] = [[1e7, 1e6], [-1e6, 1e7]]
    assert "analyses[0]: bearing 'B' has unequal cross terms" in refusal(data)


def test_law_takes_the_speed_of_a_body_that_turns():
    data = engine(speed_laws={"lee": {"kind": "preset", "preset": "lee_isotropic"}})
    data["bearings"][0] |= {"first": "casing.a", "second": "rotor.a", "speed_law": "lee"}
    assert "bearings[0].first: 'casing' does not turn" in refusal(data)


def test_inertia_that_no_body_has():
    """Ixx + Iyy - Izz is twice the integral of z^2, which is not negative; likewise the others."""
    message = refusal(engine(casing={"inertia_kg_m2": [0.5, 2, 1.4]}))
    assert "rigid_bodies.casing: inertia_kg_m2 has 2" in message
    assert parse_scene(engine(casing={"inertia_kg_m2": [0.5, 1.9, 1.4]})).rigid_bodies


ORBITS = "unbalance_response_orbits"


@pytest.mark.parametrize(
    ("first", "name", "file"),
    [
        ({**RESPONSE, "orbits_at_rpm": [9.0]}, ORBITS, f"{ORBITS}.png"),
        ({**RESPONSE, "observe": ["rotor.m"] * 8}, "unbalance_response_2", "unbalance_response_2"),
        (SHAPES, "mode_shapes_0rpm", "mode_shapes_0rpm.png"),
        (RESPONSE, ORBITS, None),
        (RESPONSE, "unbalance_response_2", None),
    ],
)
def test_files_of_two_analyses(first, name, file):
    data = engine(first, {**WATERFALL, "name": name})
    if file is None:
        assert len(parse_scene(data).analyses) == 2
    else:
        assert f"analyses[1].name: {name!r} would write {file}" in refusal(data)


def test_files_of_one_analysis():
    message = refusal(engine({**SHAPES, "speeds_rpm": [9.0, 9.0]}))
    assert "analyses[0]: mode_shapes_9rpm.png would be written twice" in message
    assert parse_scene(engine({**SHAPES, "speeds_rpm": [9.1, 9.2]})).analyses


def test_study_at_one_speed_asks_for_no_more():
    """The frequency of the force is not that of the turn then."""
    rpm = np.pi / 30.0
    assert top_speed(parse_scene(engine({**STUDY, "speed_rpm": 7e3}))) == pytest.approx(7e3 * rpm)
    assert top_speed(parse_scene(engine(STUDY))) == pytest.approx(12e3 * rpm)


def test_plan_says_who_keeps_motions_that_nothing_acts_on():
    scene = parse_scene(engine(casing={"center_of_gravity_m": [0.1, 0.0, 0.0]}))
    why = {e.name: e.why for e in make_plan(scene, {}).effects}
    assert "but in casing" in why["axial"]
    assert "but in casing" in why["torsion"]
