"""Identification: known values come back, what is undetermined is said, problems are refused."""

from __future__ import annotations

import copy
import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from cylinder import CYLINDER, LENGTH, MASS, POLAR, RADIUS

from solidwhirl.core.errors import OutputError, SceneError
from solidwhirl.geometry import mass_properties
from solidwhirl.identify.model import InfeasibleError, Model
from solidwhirl.identify.record import (
    document,
    missed_lines,
    relative_sensitivities,
    sensitivities_per_range,
    text,
    uncertainties,
    value_lines,
)
from solidwhirl.identify.run import (
    RECORD,
    REPORT,
    identified_scene,
    identify,
    identify_command,
    read_problem,
)
from solidwhirl.identify.scene import scene_text
from solidwhirl.identify.search import start_points
from solidwhirl.model.bodies import build_bodies
from solidwhirl.scene_reading.reader import parse_scene, read_scene

SCENES = Path(__file__).resolve().parents[3] / "scenes"
STEEL = 7800.0

# -- closed forms ---------------------------------------------------------------------------------


def test_cylinder_is_found(problem):
    """r = sqrt(2 I / m), L = m / (rho pi r^2), from a third of the mass and two other starts."""
    found = identify(read_problem(problem(settings={"starts": 3, "prior": 0.0})))
    radius = np.sqrt(2.0 * 0.09 / 30.0)
    assert found.met and len(found.starts) == 3
    for descent in found.starts:
        assert descent.largest < 0.2  # tolerances
        np.testing.assert_allclose(descent.point, found.point, atol=1e-3)
    # the search stops within 0.2 tolerances of 1e-3 of the targets; the radius goes with sqrt(I/m)
    assert found.values["radius"] == pytest.approx(radius, rel=2e-4)
    assert found.values["length"] == pytest.approx(30.0 / (STEEL * np.pi * radius**2), rel=6e-4)
    written = parse_scene(tomllib.loads(identified_scene(found)))
    properties = mass_properties(build_bodies(written)["rotor"])
    assert properties.mass_kg == pytest.approx(found.reached[0], rel=1e-12)
    assert properties.polar_inertia_kg_m2 == pytest.approx(found.reached[1], rel=1e-12)


def test_the_scene_keeps_what_it_was_identified_from(problem):
    """And its own references of other quantities."""
    own = {"quantity": "bodies.rotor.center_of_gravity_m[2]", "value": 0.25, "source": "drawing"}
    mass = {"quantity": "bodies.rotor.mass_kg", "value": 1.0, "source": "older"}
    sourced = {**MASS, "source": "scales", "tolerance": 2e-3}
    found = identify(
        read_problem(
            problem(targets=(sourced, POLAR), scene={**CYLINDER, "references": [mass, own]})
        )
    )
    references = {
        r.quantity: (r.value, r.source, r.tolerance)
        for r in parse_scene(tomllib.loads(identified_scene(found))).references
    }
    assert references == {
        "bodies.rotor.mass_kg": (30.0, "scales; identified from it", 2e-3),
        "bodies.rotor.polar_inertia_kg_m2": (0.09, "identified from it", 1e-3),
        "bodies.rotor.center_of_gravity_m[2]": (0.25, "drawing", None),
    }


def test_sensitivities_of_the_cylinder(problem):
    """m ~ r^2 L and I ~ r^4 L; the finite step of 1e-3 of the range is worth 1 %."""
    found = identify(read_problem(problem()))
    expected = [[2.0, 1.0], [4.0, 1.0]]
    np.testing.assert_allclose(relative_sensitivities(found), expected, rtol=1e-2)
    ranges = np.array([0.18, 1.9]) / [found.values["radius"], found.values["length"]]
    np.testing.assert_allclose(sensitivities_per_range(found), expected * ranges, rtol=1e-2)


def test_free_parameter_without_effect_is_undetermined(problem):
    """The start of the shaft moves with its end: no target depends on where it lies."""
    place = {"name": "place", "start": 0.0, "lower": -1.0, "upper": 1.0}
    place["places"] = ["bodies.rotor.sections[shaft].start_m"]
    length = {**LENGTH, "places": []}
    end = {
        "places": ["bodies.rotor.sections[shaft].end_m"],
        "terms": {"place": 1.0, "length": 1.0},
    }
    found = identify(read_problem(problem((RADIUS, length, place), derived=[end])))
    assert found.met
    record = document(found)["identifiability"]
    assert record["undetermined_directions"] == 1
    last = record["directions"][-1]
    assert last["singular_value"] == pytest.approx(0.0, abs=1e-6)
    assert abs(last["shares"]["place"]) == pytest.approx(1.0, abs=1e-6)
    # nothing known but the bounds: standard deviation of an even spread over a range of 2
    spread = uncertainties(found)
    assert spread[2] == pytest.approx(2.0 / np.sqrt(12.0), rel=1e-6)
    # known to 1e-3 each: var(ln r) = var(ln I - ln m) / 4, by hand
    assert spread[0] == pytest.approx(found.values["radius"] * 1e-3 * np.sqrt(0.5), rel=2e-2)
    # the prior keeps it where it started
    assert found.values["place"] == pytest.approx(0.0, abs=1e-3)


def test_unreachable_target_is_reported_not_hidden(problem):
    """A radius of 0.2 m or less has no polar inertia of 1 kg m^2 at 30 kg (r would be 0.26 m)."""
    length = {**LENGTH, "lower": 0.001, "why": "a | <b>"}
    polar = {**POLAR, "value": 1.0, "source": "*scales*"}
    markup = {"title": "<i>T</i> *x*", "notes": ["# no heading"]}
    found = identify(read_problem(problem((RADIUS, length), (MASS, polar), **markup)))
    assert not found.met
    record = document(found)
    assert not record["met"]
    assert [t["met"] for t in record["targets"]] != [True, True]
    assert record["parameters"][0]["at_bound"] == "upper"
    written = text(found)
    assert "**Not all targets are met.**" in written
    assert written.startswith(r"# Identification of &lt;i&gt;T&lt;/i&gt; \*x\*")
    assert r"\*scales\* |" in written and r"| a \| &lt;b&gt; |" in written
    assert "\n\\# no heading\n" in written


def test_starts_repeat_by_their_seed(problem):
    first, again, other = (
        start_points(Model(read_problem(problem(settings={"starts": 4, "seed": s}))))
        for s in (7, 7, 8)
    )
    np.testing.assert_array_equal(first, again)
    assert first.shape == (4, 2)
    np.testing.assert_allclose(first[0], [(0.05 - 0.02) / 0.18, 0.4 / 1.9])
    assert np.abs(first[1:] - other[1:]).min() > 1e-6


# -- the whole model ------------------------------------------------------------------------------

TRUTH = {"shaft_radius": 0.021, "disk_start": 0.12, "rim": 0.115}
STARTS = {"shaft_radius": 0.025, "disk_start": 0.08, "rim": 0.10}


def rotor_problem(small_scene, values):
    """Three free numbers of the small scene; targets are what the model says for the truth."""
    disk = "bodies.rotor.sections[disk]"
    places = {
        "shaft_radius": ["bodies.rotor.sections[shaft].outer_radius_m", f"{disk}.inner_radius_m"],
        "disk_start": [f"{disk}.start_m"],
        "rim": [f"{disk}.outer_radius_m"],
    }
    bounds = {"shaft_radius": (0.015, 0.03), "disk_start": (0.05, 0.18), "rim": (0.08, 0.14)}
    spec = {
        "name": "rotor",
        "scene": "base.toml",
        "settings": {"accuracy": 0.02, "coarse_accuracy": 0.05, "prior": 0.0},
        "parameters": [
            {
                "name": n,
                "start": STARTS[n],
                "lower": bounds[n][0],
                "upper": bounds[n][1],
                "places": places[n],
            }
            for n in TRUTH
        ],
        "derived": [{"places": [f"{disk}.end_m"], "constant": 0.04, "terms": {"disk_start": 1.0}}],
        "targets": [
            {"name": "mass", "quantity": "mass_kg", "body": "rotor", "value": values[0]},
            {"name": "f1", "quantity": "frequency_hz", "mode": 1, "value": values[1]},
            {"name": "f2", "quantity": "frequency_hz", "mode": 3, "value": values[2]},
            {
                "name": "forward",
                "quantity": "frequency_hz",
                "mode": 4,
                "speed_rpm": 12000,
                "value": values[3],
            },
        ],
    }
    return spec, small_scene(rpm=None)


@pytest.fixture
def rotor(tmp_path, small_scene):
    """Path of the problem of three free numbers, whose answer is known."""

    def write(values):
        spec, scene = rotor_problem(small_scene, values)
        (tmp_path / "base.toml").write_text(scene_text(scene, {}), encoding="utf-8")
        path = tmp_path / "rotor.toml"
        path.write_text(scene_text(spec, {}), encoding="utf-8")
        return path

    model = Model(read_problem(write([1.0, 1.0, 1.0, 1.0])))
    return write(model.whole(model.point(TRUTH), 0.02).tolist())


@pytest.fixture
def computed_points(monkeypatch):
    """List of the points at which a whole model was computed, not remembered."""
    seen = []
    compute = Model._computed

    def counted(self, values, accuracy, kind):
        seen.append((*values.values(), accuracy, kind))
        return compute(self, values, accuracy, kind)

    monkeypatch.setattr(Model, "_computed", counted)
    return seen


@pytest.mark.solver
def test_known_rotor_is_recovered_and_a_broken_search_goes_on(rotor, tmp_path, computed_points):
    """Targets of the model itself, another start: the truth comes back.

    The search ends within 0.2 tolerances of 1e-3. The least determined parameter is the place of
    the disk, on which the frequencies depend with exponents of about 0.3: 1e-3 for the others and
    3e-3 for it. A different mesh at every point adds scatter of 1e-4 to the frequencies.
    """
    out = tmp_path / "found.toml"

    class StoppedError(Exception):
        pass

    def stop(line):
        if len(computed_points) >= 5:
            raise StoppedError

    with pytest.raises(StoppedError):
        identify_command(rotor, out, stop)
    known = set(computed_points)
    assert len(list((tmp_path / "found.stages").glob("*.stage"))) == len(known) >= 5
    assert not out.exists()
    computed_points.clear()
    said = []
    done = identify_command(rotor, out, said.append)
    assert done.met, [*missed_lines(done)]
    assert said[0] == "start 1 of 1"
    assert said[1].startswith("evaluation 1 at accuracy 0.05: ")
    assert said[-1].startswith(f"evaluation {len([s for s in said if s.startswith('eval')])} at")
    # none twice, and all that were asked for: one more is of the whole scene
    assert not known & set(computed_points)
    record = json.loads(out.with_suffix(RECORD).read_text(encoding="utf-8"))
    asked = len(known) + len(computed_points)
    assert asked == len(set(computed_points) | known) == record["search"]["evaluations"] + 1
    found = {p["name"]: p["value"] for p in record["parameters"]}
    assert found["shaft_radius"] == pytest.approx(TRUTH["shaft_radius"], rel=1e-3)
    assert found["rim"] == pytest.approx(TRUTH["rim"], rel=1e-3)
    assert found["disk_start"] == pytest.approx(TRUTH["disk_start"], rel=3e-3)
    assert out.is_file() and out.with_suffix(REPORT).is_file()
    assert not (tmp_path / "found.stages").exists()


@pytest.mark.solver
def test_budget_ends_the_search_with_the_best_so_far(rotor):
    spec = tomllib.loads(rotor.read_text())
    spec["settings"]["maximum_evaluations"] = 3
    rotor.write_text(scene_text(spec, {}), encoding="utf-8")
    found = identify(read_problem(rotor))
    assert found.ended == "budget"
    assert found.values["shaft_radius"] > 0.0
    assert np.isfinite(found.reached).all()


@pytest.mark.solver
def test_interfaces_that_nothing_uses_change_little(small_scene, tmp_path):
    """Distributing interfaces add no stiffness; the mesh is another one (0.02 asked)."""
    data = small_scene(rpm=None)
    data["bodies"]["rotor"]["interfaces"].append(
        {"name": "middle", "kind": "section", "at_m": 0.27}
    )
    spec, _ = rotor_problem(small_scene, [1.0, 1.0, 1.0, 1.0])
    (tmp_path / "base.toml").write_text(scene_text(data, {}), encoding="utf-8")
    (tmp_path / "p.toml").write_text(scene_text(spec, {}), encoding="utf-8")
    model = Model(read_problem(tmp_path / "p.toml"))
    point = model.point(TRUTH)
    lean, complete = model.whole(point, 0.02), model.complete(point, 0.02)
    assert (lean[1:] != complete[1:]).all()
    np.testing.assert_allclose(lean, complete, rtol=2e-3)


# -- points without a model -----------------------------------------------------------------------


def test_points_without_a_body_are_rejected_and_counted(problem):
    """A bore that may exceed the radius: the search passes such points and ends beside them."""
    scene = copy.deepcopy(CYLINDER)
    scene["bodies"]["rotor"]["sections"][0]["inner_radius_m"] = 0.01
    bore = {"name": "bore", "start": 0.019, "lower": 0.0, "upper": 0.15}
    bore["places"] = ["bodies.rotor.sections[shaft].inner_radius_m"]
    radius = {**RADIUS, "start": 0.021}
    targets = (MASS, {**POLAR, "value": 0.2})
    found = identify(read_problem(problem((radius, LENGTH, bore), targets, scene)))
    assert found.met
    # I / m = (r^2 + b^2) / 2 whatever the length
    squares = found.values["radius"] ** 2 + found.values["bore"] ** 2
    assert squares == pytest.approx(2.0 * 0.2 / 30.0, rel=2e-3)
    assert all(
        "crossing radii" in message or "no thickness" in message for message in found.infeasible
    )
    model = Model(read_problem(problem((radius, LENGTH, bore), targets, scene)))
    with pytest.raises(InfeasibleError, match="crossing radii"):
        model.masses(np.array([0.0, 0.5, 1.0]))
    assert len(model.infeasible) == 1


def test_start_without_a_body_is_refused(problem):
    scene = copy.deepcopy(CYLINDER)
    scene["bodies"]["rotor"]["sections"][0]["start_m"] = 0.6
    with pytest.raises(SceneError, match=r"problem\.toml: no start .* negative width"):
        identify(read_problem(problem(scene=scene)))


# -- files ----------------------------------------------------------------------------------------


def test_input_files_are_not_overwritten(problem):
    path = problem()
    for target in (path, path.with_name("base.toml")):
        with pytest.raises(OutputError, match="is read by this problem"):
            identify_command(path, target)
    with pytest.raises(OutputError, match="is a folder"):
        identify_command(path, path.parent)


def test_files_of_an_identification(problem, tmp_path):
    path = problem(comments={"bodies.rotor.sections[shaft].start_m": "by definition"})
    out = tmp_path / "deep" / "found.toml"
    done = identify_command(path, out)
    assert done.met
    assert [*missed_lines(done)] == []
    first, *_ = value_lines(done)
    assert first.startswith("radius = ") and " ± " in first
    written = out.read_text(encoding="utf-8")
    assert "# outer_radius_m: identified (radius)" in written
    assert "# start_m: by definition" in written
    read_scene(out)
    names = sorted(p.name for p in out.parent.iterdir())
    assert names == ["found.identification.json", "found.identification.md", "found.toml"]
    report = out.with_suffix(REPORT).read_text(encoding="utf-8")
    assert "All targets are met." in report
    assert "| mass | 30 | " in report


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda p: p.stem)
def test_written_scenes_read_back(path):
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    assert tomllib.loads(scene_text(data, {}, ("a title",))) == data


def test_texts_with_special_characters_read_back():
    data = {
        "name": "x",
        "title": 'quote " back \\ tab \t bell \x07 delete \x7f umlaut ü',
        "notes": [],
    }
    assert tomllib.loads(scene_text(data, {})) == data
