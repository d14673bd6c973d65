"""The study end to end on a small scene: cases in their own processes, files, resumption."""

from __future__ import annotations

import json
import re

import pytest

from solidwhirl import study as study_module
from solidwhirl.study import StudyError, study_command
from solidwhirl.study_document import SCHEMA

SCENE = """
name = "small"
title = "Small rotor"

[model]
accuracy = 0.05

[speeds]
list_rpm = [0.0, 15000.0]

[campbell]
branches = 4

[bodies.rotor]
material = "steel"
sections = [
    { name = "shaft", start_m = 0.0, end_m = 0.4, outer_radius_m = 0.02 },
    { name = "disk", start_m = 0.1, end_m = 0.14, inner_radius_m = 0.02, outer_radius_m = 0.12 },
]
interfaces = [
    { name = "left", kind = "section", at_m = 0.0 },
    { name = "right", kind = "section", at_m = 0.4 },
]

[[bearings]]
name = "left"
first = "rotor.left"
stiffness_n_per_m = 1e7

[[bearings]]
name = "right"
first = "rotor.right"
stiffness_n_per_m = 1e7
"""


@pytest.fixture(scope="module")
def scene_path(tmp_path_factory):
    path = tmp_path_factory.mktemp("scene") / "small.toml"
    path.write_text(SCENE, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def quick(scene_path, tmp_path_factory):
    """Record, document and what was said of one quick study."""
    said = []
    done = study_command(scene_path, tmp_path_factory.mktemp("study"), said.append, quick=True)
    return done, json.loads(done.document.read_text(encoding="utf-8")), said


def case(document, name):
    return next(c for c in document["cases"] if c["name"] == name)


@pytest.mark.solver
def test_every_case_ran_and_time_to_go_was_told(quick):
    done, document, said = quick
    assert (done.failed, done.skipped) == (0, 0), done.notes
    # the rows of the map are cases too
    assert done.done == len(document["cases"]) + 2
    assert sum("to go" in line for line in said) == done.done
    assert document["schema"] == SCHEMA
    assert document["quick"]


@pytest.mark.solver
def test_errors_fall_along_the_ladder_and_estimates_bound_them(quick):
    """Second-order elements: each rung of the ladder is more accurate and has more unknowns."""
    _, document, _ = quick
    rungs = [case(document, f"harmonic, order 2, graded, rung {k}") for k in (0, 1, 2)]
    errors = [r["campbell"]["relative_error"] for r in rungs]
    unknowns = [r["unknowns"] for r in rungs]
    assert errors == sorted(errors, reverse=True)
    assert errors[0] > 3.0 * errors[2]
    assert unknowns == sorted(unknowns)
    for rung in rungs:
        # an upper bound that is not useless: the corner's error is estimated to a factor of a few
        assert 1.0 <= rung["campbell"]["effectivity"] < 10.0
        assert 1.0 <= rung["critical_speeds"]["effectivity"] < 10.0
    slope = next(s for s in document["slopes"] if s["quantity"] == "error")
    assert slope["points"] == 3
    assert slope["slope"] < -0.5


@pytest.mark.solver
def test_adaptive_run_keeps_its_accuracy(quick):
    _, document, _ = quick
    assert case(document, "harmonic, accuracy 0.01")["campbell"]["relative_error"] < 1e-2


@pytest.mark.solver
def test_cost_is_that_of_the_case(quick):
    """More than the start of the program, less than the process; estimates cost on top."""
    _, document, _ = quick
    for row in document["cases"]:
        assert 0.0 < row["startup_cpu_s"] < row["cpu_s"] <= row["process_cpu_s"]
        assert 0.0 < row["startup_memory_gib"] <= row["peak_memory_gib"] < 2.0
        # stages add up to what was used after the start, to the clock's resolution
        stages = sum(row["stages_cpu_s"].values())
        assert stages == pytest.approx(row["cpu_s"] - row["startup_cpu_s"], abs=0.1)


@pytest.mark.solver
def test_fronts_hold_what_no_other_case_beats(quick):
    _, document, _ = quick
    for front, key in (("error_cpu_s", "cpu_s"), ("error_peak_memory", "peak_memory_gib")):
        names = document["pareto"][front]
        assert names
        for name in names:
            own = case(document, name)
            beaten = [
                other["name"]
                for other in document["cases"]
                if other["group"] in ("mesh", "dial", "modes", "beam")
                and other[key] < own[key]
                and other["campbell"]["relative_error"] < own["campbell"]["relative_error"]
            ]
            assert not beaten


@pytest.mark.solver
def test_pictures_are_pictures(quick):
    done, _, _ = quick
    assert {p.name for p in done.pictures} == {
        "error-time.png",
        "error-memory.png",
        "convergence.png",
        "estimates.png",
        "beam-map.png",
    }
    for path in done.pictures:
        assert path.read_bytes().startswith(b"\x89PNG")


@pytest.mark.solver
def test_page_needs_no_network(quick):
    """One library inside, nothing loaded from elsewhere; addresses are only in its source."""
    done, document, _ = quick
    page = done.page.read_text(encoding="utf-8")
    for tag in re.findall(r"<(?:script|link|img|iframe|source)\b[^>]*>", page):
        assert "src=" not in tag
        assert "href=" not in tag
    scripts = sorted(re.findall(r"<script.*?</script>", page, flags=re.DOTALL), key=len)
    assert len(scripts[-1]) > 1_000_000
    assert all(len(s) < 100_000 for s in scripts[:-1])
    assert "http" not in page.replace(scripts[-1], "")
    assert "corner_size_m = " in page
    for row in document["cases"]:
        assert row["name"] in page


@pytest.mark.solver
def test_summary_tells_every_case(quick):
    done, document, _ = quick
    text = done.report.read_text(encoding="utf-8")
    for row in document["cases"]:
        assert f"| {row['name']} |" in text


@pytest.mark.solver
def test_study_again_runs_nothing(quick, scene_path, monkeypatch):
    """All results are kept; the same document but for the machine's speed of the moment."""
    done, document, _ = quick
    monkeypatch.setattr("solidwhirl.study_runner._process", lambda *_: pytest.fail("was run"))
    again = study_command(scene_path, done.out, quick=True)
    assert again.done == done.done
    second = json.loads(again.document.read_text(encoding="utf-8"))
    assert {**second, "machine": None} == {**document, "machine": None}
    assert not [p.name for p in done.out.rglob(".*")]


def test_scene_without_a_profile_is_refused(tmp_path):
    path = tmp_path / "rigid.toml"
    path.write_text(
        'name = "rigid"\n[rigid_bodies.block]\nmass_kg = 1.0\n'
        "center_of_gravity_m = [0.0, 0.0, 0.0]\n"
        "inertia_kg_m2 = [1.0, 1.0, 1.0]\ninterfaces = { middle = 0.0 }\n",
        encoding="utf-8",
    )
    with pytest.raises(StudyError, match="needs a body with a profile"):
        study_command(path, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_missing_plotly_is_told_before_the_work(scene_path, tmp_path, monkeypatch):
    monkeypatch.setattr(study_module.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(StudyError, match="plotly"):
        study_command(scene_path, tmp_path / "out")
    assert not (tmp_path / "out").exists()
