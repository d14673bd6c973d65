"""Scenes of beams, rigid bodies, gears, speed laws and damping: what is planned and assembled."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from engine_of_all_kinds import ENGINE, KINDS
from engine_parts import MATERIALS, RISING, RPM, joined, rigid_rotor, rotor_on_shaft

from solidwhirl.model.bodies import build_bodies
from solidwhirl.model.effects import make_plan
from solidwhirl.model.system_parts import bearings, gears
from solidwhirl.scene_checks.speeds_asked import top_speed
from solidwhirl.scene_reading.reader import parse_scene


def planned(data):
    scene = parse_scene(data)
    return make_plan(scene, build_bodies(scene))


# -- plan -----------------------------------------------------------------------------------------


def two_solids(small_scene):
    """Two solids and a beam; rotor.left tilts, rotor.right has a gear and an axial spring."""
    data = small_scene(bearing={"tilt_stiffness_n_m_per_rad": 1e4})
    data["bodies"]["other"] = copy.deepcopy(data["bodies"]["rotor"])
    data["materials"], data["beams"] = MATERIALS, {"shaft": rotor_on_shaft()["beams"]["rotor"]}
    data["bearings"][1]["axial_stiffness_n_per_m"] = 1e6
    data["bearings"] += [{"name": "o", "first": "other.left", "second": "rotor.left"}]
    data["gears"] = [{"name": "g", "first": "rotor.right", "second": "shaft.a", "ratio": 1.0}]
    return data


LATERAL = ("ux", "uy")


def test_interfaces_carry_what_acts_on_them(small_scene):
    plan = planned(two_solids(small_scene))
    assert plan.bodies["rotor"].interface_components == {
        "left": (*LATERAL, "rx", "ry"),
        "right": (*LATERAL, "uz", "rz"),
    }
    assert plan.bodies["rotor"].orders == (1, 0)
    assert plan.bodies["other"].interface_components == {"left": LATERAL, "right": LATERAL}
    assert plan.bodies["other"].orders == (1,)
    shaft = {place: motions for place, motions in plan.carried.items() if "shaft" in place}
    # order 0 is carried whole: what turns about the axis moves along it
    assert shaft == {"shaft.a": (*LATERAL, "uz", "rz"), "shaft.m": LATERAL, "shaft.b": LATERAL}
    assert "g" in next(e.why for e in plan.effects if e.name == "torsion")


def test_both_ends_of_a_joint_carry_its_motions(small_scene):
    data = two_solids(small_scene)
    data["bearings"][2]["rigid"] = ["ry"]
    assert planned(data).carried["other.left"] == (*LATERAL, "rx", "ry")


@pytest.mark.parametrize(
    ("effect", "motions", "beside"),
    [("tilt", {"rx", "ry"}, set()), ("axial", {"uz"}, {"rz"}), ("torsion", {"rz"}, {"uz"})],
)
def test_effect_of_motions_on_everywhere_and_off_nowhere(small_scene, effect, motions, beside):
    data = two_solids(small_scene)
    data["bearings"][0]["rigid"] = ["uz", "rz"]
    for asked in ("on", "off"):
        data["effects"] = {effect: asked}
        scene, plan = parse_scene(data), planned(data)
        for place, carried in plan.carried.items():
            there = asked == "on" or beside & set(carried)  # order 0 whole
            assert motions & set(carried) == (motions if there else set()), place
        rows = {"tilt": slice(3, 5), "axial": 2, "torsion": 5}[effect]
        for bearing in bearings(scene, plan) if asked == "off" else ():
            assert not np.any([matrix[rows] for matrix in bearing.matrices()]), bearing.name
            assert not motions & set(bearing.rigid)
        assert bool(gears(scene, plan)) == (effect != "torsion" or asked == "on")
    data["effects"] = {"axial": "off", "torsion": "off"}
    assert planned(data).bodies["rotor"].orders == (1,)


def test_drive_of_a_run_up_calls_for_torsion():
    analysis = {"kind": "run_up", "ramp_s": 1.0, "to_rpm": 9e3, "mount": "A"}
    plan = planned(rigid_rotor(analyses=[{**analysis, "drives": ["rotor.m"]}]))
    assert plan.on("torsion")
    assert plan.carried["rotor.m"] == (*LATERAL, "uz", "rz")
    assert not planned(rigid_rotor(analyses=[analysis])).on("torsion")


def test_rigid_disk_tilts_its_interface_alone(small_scene):
    disk = {"name": "hub", "interface": "right", "mass_kg": 1.0}
    disk |= {"polar_inertia_kg_m2": 0.02, "diametral_inertia_kg_m2": 0.01}
    plan = planned(small_scene(body={"rigid_disks": [disk]}))
    assert plan.on("tilt") and "hub" in next(e.why for e in plan.effects if e.name == "tilt")
    assert plan.bodies["rotor"].interface_components == {
        "left": LATERAL,
        "right": (*LATERAL, "rx", "ry"),
    }


@pytest.mark.parametrize(
    ("effect", "names"), [("internal_damping", "rotor"), ("speed_dependent_bearings", "A")]
)
def test_damping_and_laws_follow_the_scene(effect, names):
    plain = rotor_on_shaft()
    called = rotor_on_shaft(speed_laws={"rising": RISING})
    called["beams"]["rotor"]["internal_damping"] = {"modal_ratio": 0.01}
    called["bearings"][0] = {"name": "A", "first": "rotor.a", "stiffness_n_per_m": 1e6}
    called["bearings"][0]["speed_law"] = "rising"
    for asked, on in (("auto", (False, True)), ("on", (True, True)), ("off", (False, False))):
        plans = [planned({**data, "effects": {effect: asked}}) for data in (plain, called)]
        assert tuple(plan.on(effect) for plan in plans) == on
        assert names in next(e.why for e in plans[1].effects if e.name == effect)
    plain["beams"]["rotor"]["internal_damping"] = {"modal_ratio": 0.0}
    assert not planned(plain).on("internal_damping")


# What is asked of an analysis, and the speed of the reference shaft up to which it looks.
FASTER = {
    **dict.fromkeys(
        ("waterfall", "stability", "bearing_laws", "state_space", "run_up"), ({"to_rpm": 9e3}, 9e3)
    ),
    "mode_shapes": ({"speeds_rpm": [0.0, 9e3]}, 9e3),
    "unbalance_response": ({"to_rpm": 9e3, "orbits_at_rpm": [9.5e3]}, 9.5e3),
    # one turn of the body per period of 200 Hz
    "place_map": ({"places": ["hp.a"], "frequency_max_hz": 200.0}, 8e3),
    # the search goes up to a speed of the shaft itself
    "critical_speed_map": ({"excited_by": "hp", "search_to_rpm": 18e3}, 12e3),
    "separation_margins": ({"search_factor": 2.0}, 12e3),
    "api617": ({"range_factor": 2.0, "maximum_continuous_rpm": 6e3}, 12e3),
}


@pytest.mark.parametrize("kind", FASTER)
def test_bases_are_made_for_the_speeds_of_all_analyses(kind):
    """The second shaft turns one and a half times as fast, and backward."""
    changes, rpm = FASTER[kind]
    asked = {"kind": kind, **KINDS[kind], **changes}
    assert top_speed(parse_scene({**ENGINE, "analyses": [asked]})) == pytest.approx(rpm * RPM)


ASSEMBLED = {
    "gyroscopic": lambda system: system.gyroscopic.any(),
    "internal_damping": lambda system: system.circulatory_stiffness.any(),
    "speed_dependent_bearings": lambda system: bool(system.law_joints),
    "bearing_damping": lambda system: (
        any(
            joint.coefficients(speed)[1].any()
            for joint in system.law_joints
            for speed in (0.0, 9e2)
        )
        or system.damping.any()
    ),
    "torsion": lambda system: any(
        c.component == "rz" for r in system.system.rotors.values() for c in r.element.coordinates
    ),
}


@pytest.mark.parametrize("effect", ASSEMBLED)
def test_nothing_switched_off_is_assembled(effect):
    data = copy.deepcopy(ENGINE) | {"analyses": []}
    if effect == "bearing_damping":
        del data["beams"]["lp"]["internal_damping"]
    if effect == "speed_dependent_bearings":
        data["bearings"][2] = {"name": "C", "first": "hp.a", "stiffness_n_per_m": 2e6}
    assert ASSEMBLED[effect](joined(data))
    assert not ASSEMBLED[effect](joined({**data, "effects": {effect: "off"}}))


def test_plan_knows_the_damping_of_gears():
    data = rigid_rotor(gears=[{"name": "g", "first": "rotor.m", "second": "disk.m", "ratio": 1.0}])
    data["gears"][0] |= {"base_radius_first_m": 0.1, "mesh_stiffness_n_per_m": 1e6}
    data["gears"][0]["mesh_damping_n_s_per_m"] = 5.0
    data["rigid_bodies"]["disk"] = {**data["rigid_bodies"]["rotor"]}
    assert joined(data).damping.any() == planned(data).on("bearing_damping")
    assert not joined({**data, "effects": {"bearing_damping": "off"}}).damping.any()
