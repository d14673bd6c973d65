"""Static loads of scenes: numbers against balances by hand, and what is refused before a run."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from symmetric_rotor import run

from solidwhirl.build import beam
from solidwhirl.core.errors import SceneError
from solidwhirl.model.effects import make_plan
from solidwhirl.rotordyn import AnalysisError
from solidwhirl.scene_reading.reader import parse_scene

G = 9.80665
SHAFT = beam([0.0, 0.2, 0.4, 0.6], 0.02, {"a": 0.0, "m": 0.3, "b": 0.6})
WEIGHT = 7800.0 * np.pi * 0.02**2 * 0.6 * G
DISK = {"name": "d", "at_m": 0.2, "mass_kg": 12.0, "polar_inertia_kg_m2": 0.1,
        "diametral_inertia_kg_m2": 0.06}  # fmt: skip
FILM = [[2e7, 1e7], [-1e7, 2e7]]
GEAR = {"name": "mesh", "first": "s.m", "second": "t.m", "ratio": -2.0}
TEETH = {"base_radius_first_m": 0.1, "line_of_action_deg": 70.0}


def held(body, name, **first):
    """Two bearings of a shaft."""
    pair = [{"name": n, "first": f"{body}.{end}", "stiffness_n_per_m": 1e7}
            for n, end in zip(name, "ab", strict=True)]  # fmt: skip
    return [pair[0] | first, pair[1]]


def scene(bearings=None, **changes):
    data = {"name": "shafts", "speeds": {"list_rpm": [0.0]}, "beams": {"s": SHAFT}}
    data |= {"bearings": held("s", "AB") if bearings is None else bearings}
    return copy.deepcopy(data | changes)


def two_shafts(teeth=TEETH, **first):
    shafts = {"s": SHAFT, "t": SHAFT | {"speed_ratio": -2.0}}
    bearings = held("s", "AB", **first) + held("t", "CD")
    return scene(bearings, beams=shafts, gears=[GEAR | teeth])


def static(data, **asked):
    (entry,) = run(data, {"kind": "static", **asked}).analyses.values()
    return entry


def test_loads_sag_and_attitude():
    """A disk at a third: 2/3 and 1/3; a film moves its journal aside by the cross terms."""
    data = scene(held("s", "AB", stiffness_n_per_m=FILM))
    data["beams"]["s"] = SHAFT | {"disks": [DISK]}
    entry = static(data)
    (found,) = entry.document["speeds"]
    for name, share in (("A", 2.0 / 3.0), ("B", 1.0 / 3.0)):
        bearing = found["bearings"][name]
        assert bearing["load_n"] == pytest.approx(0.5 * WEIGHT + share * 12.0 * G, rel=1e-9)
        assert bearing["load_kg"] == pytest.approx(bearing["load_n"] / G)
        assert bearing["direction_deg"] == pytest.approx(-90.0)
        assert bearing["force_n"][0] == pytest.approx(0.0, abs=1e-9)
    film, spring = (found["bearings"][name] for name in "AB")
    # load down: x = kxy W / det, y = -kxx W / det, so that the motion leads the load
    moved = np.linalg.solve(FILM, [0.0, -film["load_n"]])
    np.testing.assert_allclose(film["motion_m"], moved, rtol=1e-9)
    assert film["attitude_deg"] == pytest.approx(np.degrees(np.arctan2(1e7, 2e7)), rel=1e-9)
    assert spring["attitude_deg"] == pytest.approx(0.0, abs=1e-9)
    body = found["bodies"]["s"]
    size = np.hypot(*np.array(body["deflection_m"]).T)
    assert body["sag_m"] == size.max()
    assert body["sag_at_m"] == body["axial_m"][size.argmax()]
    assert found["balance"]["relative_residual"] < 1e-9
    # sag between stations, which shorter elements have: a few parts in a hundred of the work
    assert found["bodies_without_estimate"] == [] and 0.0 < found["error_estimate"] < 0.1
    assert "A 1" in entry.headline and "µm (s)" in entry.headline
    head, *_ = entry.blocks()[-3:]
    assert head.title == "Loads of the bearings" and len(head.rows) == 2


def test_gear_torque_and_given_forces_at_two_speeds(tmp_path):
    """Teeth share T / r among two bearings each; the film of a table is that of the speed."""
    law = {"kind": "table", "speed_rpm": [0.0, 3000.0], "stiffness_n_per_m": [1e7, FILM]}
    law["damping_n_s_per_m"] = [0.0, 0.0]
    data = two_shafts(stiffness_n_per_m=0.0, speed_law="t", axial_stiffness_n_per_m=1e7)
    data["speed_laws"] = {"t": law}
    force = {"at": "s.b", "force_n": [0.0, -80.0, 30.0]}
    asked = {"forces": [force], "gears": [{"gear": "mesh", "torque_n_m": 40.0}]}
    entry = static(data, speeds_rpm=[0.0, 3000.0], **asked)
    angle = np.radians(70.0)
    teeth = 400.0 * np.array([np.cos(angle), np.sin(angle)])
    for state in entry.document["speeds"]:
        own = {name: np.array(b["force_n"]) for name, b in state["bearings"].items()}
        down = np.array([0.0, -0.5 * WEIGHT])
        np.testing.assert_allclose(own["A"], [*(down - 0.5 * teeth), 30.0], rtol=1e-8)
        np.testing.assert_allclose(own["B"][:2], down - 0.5 * teeth + [0.0, -80.0], rtol=1e-8)
        for name in "CD":
            np.testing.assert_allclose(own[name][:2], down + 0.5 * teeth, rtol=1e-8)
        assert state["gear_forces_n"]["mesh"] == pytest.approx(400.0)
        assert [load["at"] for load in state["loads"]] == ["s.b", "s.m", "t.m"]
        assert state["balance"]["relative_residual"] < 1e-8
    attitudes = [s["bearings"]["A"]["attitude_deg"] for s in entry.document["speeds"]]
    np.testing.assert_allclose(attitudes, [0.0, np.degrees(np.arctan(0.5))], atol=1e-6)
    assert list(entry.files) == ["static_0rpm.png", "static_3000rpm.png"]
    for name, write in entry.files.items():
        write(tmp_path / name)


REFUSED = {
    "no thrust bearing": (
        {}, {"gravity_m_per_s2": [0, 0, -G]},
        "gravity_m_per_s2: -9.80665 along z, but nothing holds a body along the axis"),
    "one bearing": (
        {"bearings": held("s", "AB")[:1]}, {}, "no bearing carries the weight of 's' along y"),
    "nothing": ({}, {"gravity_m_per_s2": [0, 0, 0]}, "there are no forces and no gears"),
    "free turn": (
        {}, {"forces": [{"at": "s.m", "moment_n_m": [0, 0, 5]}]}, "nothing holds 's' in rz"),
    "free axially": (
        {}, {"forces": [{"at": "s.m", "force_n": [0, 0, 5]}]}, "nothing holds 's' in uz"),
    "left out": (
        {"effects": {"axial": "off"}}, {"forces": [{"at": "s.m", "force_n": [0, 0, 5]}]},
        "forces[0]: it acts on motions of the effect axial, which is off"),
    "no gear": ({}, {"gears": [{"gear": "g", "torque_n_m": 1}]}, "gears[0].gear: no gear 'g'"),
    "empty force": ({}, {"forces": [{"at": "s.m"}]}, "neither force_n nor moment_n_m"),
    "twice": ({}, {"speeds_rpm": [1, 1]}, "speeds_rpm has a value twice"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_nothing_carries_is_refused_before_computing(case):
    changes, asked, said = REFUSED[case]
    with pytest.raises(SceneError) as caught:
        parse_scene(scene(**changes, analyses=[{"kind": "static", **asked}]))
    assert said in str(caught.value)


def test_weight_along_the_axis_is_carried_for_every_body_or_refused():
    """One thrust bearing does not hold the other shaft, in a run-up neither."""
    run_up = {"kind": "run_up", "ramp_s": 0.1, "to_rpm": 600.0, "mount": "A"}
    for asked in ({"kind": "static"}, run_up):
        asked = asked | {"gravity_m_per_s2": [0.0, 0.0, -G]}
        data = two_shafts(axial_stiffness_n_per_m=1e7, stiffness_n_per_m=1e7)
        with pytest.raises(SceneError, match="no axial bearing carries the weight of 't' along z"):
            parse_scene(data | {"analyses": [asked]})
        data["bearings"][2]["axial_stiffness_n_per_m"] = 1e7
        parse_scene(data | {"analyses": [asked]})
    found = static(data, gravity_m_per_s2=[0.0, 0.0, -G]).document["speeds"][0]
    loads = [found["bearings"][name]["force_n"][2] for name in "AC"]
    np.testing.assert_allclose(loads, -WEIGHT, rtol=1e-9)


def test_angles_are_of_asymmetric_bodies():
    parsed = parse_scene(scene(analyses=[{"kind": "static", "angles_deg": [30.0]}]))
    with pytest.raises(AnalysisError, match="angles_deg: is of asymmetric bodies"):
        make_plan(parsed, {})


def test_gears_without_a_line_of_action_are_refused():
    asked = {"kind": "static", "gears": [{"gear": "mesh", "torque_n_m": 1.0}]}
    with pytest.raises(SceneError, match="has no line_of_action_deg"):
        parse_scene(two_shafts({}) | {"analyses": [asked]})


def test_interfaces_carry_what_loads_act_on():
    """A tilting moment alone makes a beam no larger, and a solid carry tilt there."""
    asked = {"kind": "static", "forces": [{"at": "s.m", "moment_n_m": [5.0, 0.0, 0.0]}]}
    parsed = parse_scene(scene(analyses=[asked]))
    assert "rx" in make_plan(parsed, {}).carried["s.m"]
