"""Bodies that nothing holds laterally are doubted; free axial motion and torsion are not."""

from __future__ import annotations

import pytest
from results_read import results_in
from typer.testing import CliRunner

from solidwhirl.build import beam, body, cylinder
from solidwhirl.cli import app
from solidwhirl.core.errors import SceneError
from solidwhirl.model.system_parts import engine_of, simple_elements
from solidwhirl.pipeline.run import make_plan
from solidwhirl.plausibility.supports import support_doubts
from solidwhirl.rotordyn import AnalysisError
from solidwhirl.rotordyn.modes.free_motions import free_lateral_motions, unsupported_bodies
from solidwhirl.scene_reading.reader import parse_scene
from solidwhirl.scene_reading.weight import refuse_unsupported

SHAFT = beam([0.0, 0.2, 0.4], 0.02, {"a": 0.0, "m": 0.2, "b": 0.4})
CASING = {
    "mass_kg": 30.0,
    "center_of_gravity_m": [0.0, 0.01, 0.2],
    "inertia_kg_m2": [1.0, 1.0, 1.2],
    "interfaces": {"a": 0.0, "m": 0.2, "b": 0.4},
}


def bearing(name, first, second="ground", k=1e7, **more):
    return {"name": name, "first": first, "second": second, "stiffness_n_per_m": k, **more}


def assembled(bearings, gears=(), casing=None, effects=None, **beams):
    """The system of some shafts, and a casing."""
    data = {
        "name": "shafts",
        "beams": {name: SHAFT | changes for name, changes in beams.items()},
        "bearings": bearings,
        "gears": list(gears),
        "effects": effects or {},
    }
    if casing is not None:
        data["rigid_bodies"] = {"casing": casing}
    scene = parse_scene(data)
    plan = make_plan(scene, {})
    return engine_of(scene, plan, simple_elements(scene, plan))


# A free rigid body has four lateral motions; a place held in x and y takes two, in x alone one.
ONE = {
    "two bearings": ([bearing("A", "s.a"), bearing("B", "s.b")], 0, ()),
    "one": ([bearing("A", "s.a")], 2, ("A",)),
    "one, very soft": ([bearing("A", "s.a", k=10.0)], 2, ("A",)),
    "one, rigid": ([{"name": "A", "first": "s.a", "rigid": ["ux", "uy"]}], 2, ("A",)),
    "one that holds the tilt": ([bearing("A", "s.a", tilt_stiffness_n_m_per_rad=1e4)], 0, ()),
    "two in x, one in y": (
        [bearing("A", "s.a"), bearing("B", "s.b", k=[[1e7, 0.0], [0.0, 0.0]])],
        1,
        ("A", "B"),
    ),
    "two at one place": ([bearing("A", "s.m"), bearing("B", "s.m")], 2, ("A", "B")),
    "none": ([], 4, ()),
    "damping alone": ([{"name": "A", "first": "s.a", "damping_n_s_per_m": 1e3}], 4, ()),
}


@pytest.mark.parametrize("case", ONE)
def test_one_shaft(case):
    bearings, count, holders = ONE[case]
    found = free_lateral_motions(assembled(bearings, s={}))
    assert [(f.bodies, f.held_by, f.count) for f in found] == (
        [(("s",), holders, count)] if count else []
    )


def test_axial_motion_and_torsion_are_free_by_nature():
    held = [bearing("A", "s.a"), bearing("B", "s.b")]
    system = assembled(held, s={}, effects={"axial": "on", "torsion": "on"})
    assert free_lateral_motions(system) == ()
    geared = [*held, bearing("C", "t.a"), bearing("D", "t.b")]
    gear = {"name": "g", "first": "s.m", "second": "t.m", "ratio": 1.0}
    assert free_lateral_motions(assembled(geared, [gear], s={}, t={})) == ()
    casing = [*(b | {"second": f"casing.{b['first'][-1]}"} for b in held)]
    casing += [bearing("E", "casing.a"), bearing("F", "casing.b")]
    # nothing keeps the casing, whose centre of gravity is off the axis, from turning
    assert free_lateral_motions(assembled(casing, casing=CASING, s={})) == ()


def test_only_what_moves_is_named():
    """A held casing with a shaft that has one bearing in it, beside a shaft that has two."""
    system = assembled(
        [
            *(bearing("E", "casing.a"), bearing("F", "casing.b"), bearing("A", "s.m", "casing.m")),
            *(bearing("C", "t.a", "casing.a"), bearing("D", "t.b", "casing.b")),
        ],
        casing=CASING,
        s={},
        t={},
    )
    (found,) = free_lateral_motions(system)
    assert (found.bodies, found.held_by, found.count) == (("s",), ("A",), 2)
    (doubt,) = support_doubts(system)
    assert "'s' is held by one bearing only ('A') and can tilt freely: 2 lateral" in doubt.message


def test_a_train_with_a_hinge():
    """Two shafts joined by a hinge, one bearing each: 8 motions less 3 times 2."""
    hinge = {"name": "hinge", "first": "s.b", "second": "t.a", "rigid": ["ux", "uy"]}
    ends = [bearing("A", "s.a"), bearing("B", "t.b")]
    (found,) = free_lateral_motions(assembled([*ends, hinge], s={}, t={}))
    assert (found.bodies, found.held_by, found.count) == (("s", "t"), ("A", "B"), 2)
    stiff = hinge | {"rigid": ["ux", "uy", "rx", "ry"]}
    assert free_lateral_motions(assembled([*ends, stiff], s={}, t={})) == ()


def test_geared_shafts():
    """One bearing each, so both tilt; teeth with a line of action make them one train."""
    ends = [bearing("A", "s.a"), bearing("B", "t.a")]
    gear = {"name": "g", "first": "s.m", "second": "t.m", "ratio": 1.0}
    apart = free_lateral_motions(assembled(ends, [gear], s={}, t={}))
    assert [(f.bodies, f.count) for f in apart] == [(("s",), 2), (("t",), 2)]
    teeth = gear | {"base_radius_first_m": 0.05, "line_of_action_deg": 20.0}
    for mesh in ({}, {"mesh_stiffness_n_per_m": 1e8}):
        (found,) = free_lateral_motions(assembled(ends, [teeth | mesh], s={}, t={}))
        # torsion gives way to the teeth: none of the four tilts is lost
        assert (found.bodies, found.held_by, found.count) == (("s", "t"), ("A", "B"), 4)


def test_free_on_purpose_is_said_neutrally():
    """An engine on a casing that nothing mounts."""
    joints = [bearing("A", "s.a", "casing.a"), bearing("B", "s.b", "casing.b")]
    (doubt,) = support_doubts(assembled(joints, casing=CASING, s={}))
    assert "nothing holds 's' and 'casing' laterally: 4 lateral motions" in doubt.message
    assert "Free on purpose? Then this is as it should be" in doubt.message


def run(path, out, *options):
    words = ["run", str(path), "--out", str(out), "--level", "beam", *options]
    return CliRunner().invoke(app, words)


@pytest.mark.verify
@pytest.mark.solver
def test_a_missing_bearing_is_named_everywhere(tmp_path, small_scene, root):
    """Terminal, results, report and page; zeros at rest are the motions that are counted."""
    path = tmp_path / "one.toml"
    text = (root / "scenes" / "laval.toml").read_text("utf-8")
    path.write_text(text.rpartition("[[bearings]]")[0], encoding="utf-8")
    done = run(path, tmp_path / "out", "--no-pictures")
    assert done.exit_code == 0, done.output
    said = "'rotor' is held by one bearing only ('left') and can tilt freely: 2 lateral motions"
    assert said in " ".join(done.stdout.split())
    (doubt,) = results_in(tmp_path / "out")["doubts"]
    assert doubt["key"] == "bearings" and said in doubt["message"]
    report = (tmp_path / "out" / "report.md").read_text("utf-8")
    assert "**warning:** bearings" in report and said in report
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    assert "is held by one bearing only" in page


@pytest.mark.solver
@pytest.mark.parametrize("name", ["ferraris", "laval"])
def test_no_scene_of_the_project_is_questioned(computed, name):
    found = computed(name)
    assert support_doubts(found.system) == ()
    assert found.at_rest.zero_count == 0


# A rigid body on a bearing at one place falls unless its centre of gravity is there.
WEIGHT = {
    "two bearings": (["a", "b"], ()),
    "a pivot at one end": (["a"], ("s",)),
    "a pivot at the centre of gravity": (["m"], ()),
    "none": ([], ("s",)),
}


@pytest.mark.parametrize("case", WEIGHT)
def test_weight_falls_where_no_bearing_carries_it(case):
    places, wanted = WEIGHT[case]
    system = assembled([bearing(place, f"s.{place}") for place in places], s={})
    assert unsupported_bodies(system, [0.0, -9.81, 0.0]) == wanted
    assert unsupported_bodies(system, [-1e-3, 0.0, 0.0]) == wanted


def test_bodies_that_hang_on_each_other_fall_together():
    hung = [bearing("A", "s.a", "t.a"), bearing("B", "s.b", "t.b"), bearing("C", "t.a")]
    assert unsupported_bodies(assembled(hung, s={}, t={}), [0.0, -9.81, 0.0]) == ("s", "t")
    held = [*hung, bearing("D", "t.b")]
    assert unsupported_bodies(assembled(held, s={}, t={}), [0.0, -9.81, 0.0]) == ()


def under_gravity(**more):
    """A scene on one bearing with a run-up under its weight."""
    run_up = {"kind": "run_up", "ramp_s": 0.1, "to_rpm": 600.0, "mount": "A"}
    run_up |= {"observe": ["s.a"], "gravity_m_per_s2": [0.0, -9.81, 0.0]}
    return {"name": "s", "bearings": [bearing("A", "s.a")], "analyses": [run_up], **more}


def test_a_shaft_on_one_bearing_is_refused_under_its_weight():
    """Bodies of sections and beams before they are made, others before they are computed with."""
    aside, balanced = (body(cylinder("c", 0.0, 0.4, 0.02), interfaces={"a": z}) for z in (0.1, 0.2))
    with pytest.raises(SceneError, match="no bearing carries the weight of 's' along y"):
        parse_scene(under_gravity(bodies={"s": aside}))
    parse_scene(under_gravity(bodies={"s": balanced}))
    with pytest.raises(SceneError, match="no bearing carries the weight of 's' along y"):
        parse_scene(under_gravity(beams={"s": SHAFT}))
    held = parse_scene(under_gravity(beams={"s": SHAFT | {"interfaces": {"a": 0.2}}}))
    falling = assembled([bearing("A", "s.a")], s={})
    with pytest.raises(AnalysisError, match=r"analyses\[0\].gravity.*: no bearing .* 's' along y"):
        refuse_unsupported(held, falling)
