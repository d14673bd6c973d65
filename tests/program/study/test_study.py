"""The study end to end on a small scene: cases in their own processes, files, resumption."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from solidwhirl.cli import app
from solidwhirl.cost.machine import uniform
from solidwhirl.identify.scene import scene_text
from solidwhirl.scene_reading.reader import parse_scene
from solidwhirl.study import run as study_run
from solidwhirl.study.cases import FULL, QUICK, study_cases
from solidwhirl.study.measure import measured, measured_apart, usage
from solidwhirl.study.report import SCHEMA, Study, study_chart, study_document, summary
from solidwhirl.study.run import StudyError, run_cases, study_command
from solidwhirl.study.table import study_table


@pytest.fixture(scope="module")
def scene_path(tmp_path_factory, small_scene):
    data = small_scene(rpm=[0.0, 15000.0]) | {"model": {"accuracy": 0.05}}
    path = tmp_path_factory.mktemp("scene") / "small.toml"
    path.write_text(scene_text(data, {}), encoding="utf-8")
    return path


@pytest.fixture(scope="module", params=["short", pytest.param("whole", marks=pytest.mark.verify)])
def quick(request, scene_path, tmp_path_factory):
    """Record, folder, document and what was said of a quick study; a short one in this process."""
    said, out = [], tmp_path_factory.mktemp("study")
    with pytest.MonkeyPatch.context() as patch:
        # no case is skipped because other programs slow this machine down
        patch.setattr(study_run, "this_machine", lambda: uniform(0.5))
        if request.param == "short":
            adaptive = {"harmonic": QUICK.adaptive["harmonic"]}
            short = replace(QUICK, graded={2: (-1, 0, 2)}, solid=(-1,), adaptive=adaptive)
            patch.setattr(study_run, "QUICK", short)
            patch.setattr(study_run, "measured_apart", lambda case, _: measured(case))
        done = study_command(scene_path, out, said.append, quick=True)
        document = written(out)
        # of a level whose ladder spans less than a factor 30 it is said
        long = not [n for n in document["notes"] if "unknowns span a factor" in n]
        assert long == (document["spans"]["harmonic"] >= 30.0) == (request.param == "whole")
        yield done, out, document, said


def written(out):
    return json.loads((out / "study.json").read_text(encoding="utf-8"))


def case(document, name):
    return next(c for c in document["cases"] if c["name"] == name)


@pytest.mark.solver
def test_every_case_ran(quick):
    done, _, document, said = quick
    cases = len(document["cases"])
    assert done.counts == (cases, 0, 0), done.notes
    assert cases == sum("to go" in line for line in said)
    assert document["schema"] == SCHEMA
    assert document["quick"]


@pytest.mark.solver
def test_errors_fall_along_the_ladder_and_estimates_bound_them(quick):
    """Second-order elements: each rung of the ladder is more accurate and has more unknowns."""
    _, _, document, _ = quick
    rungs = [case(document, f"harmonic, order 2, graded, rung {k}") for k in (-1, 0, 2)]
    errors = [r["campbell"]["true"] for r in rungs]
    unknowns = [r["unknowns"] for r in rungs]
    assert errors == sorted(errors, reverse=True)
    assert errors[0] > 3.0 * errors[2]
    assert unknowns == sorted(unknowns)
    for rung in rungs:
        # an upper bound that is not useless: the corner's error is estimated to a factor of a few
        assert 1.0 <= rung["campbell"]["effectivity"] < 10.0
        assert 1.0 <= rung["critical_speeds"]["effectivity"] < 10.0
    slope = next(s for s in document["slopes"] if s["quantity"] == "error")
    assert slope["points"] >= 3
    assert slope["slope"] < -0.5
    assert case(document, "harmonic, accuracy 0.01")["campbell"]["true"] < 1e-2


@pytest.mark.solver
def test_cost_is_that_of_the_case(quick):
    """More than the start of the program; estimates cost on top."""
    _, _, document, _ = quick
    for row in document["cases"]:
        used = row["without_estimates"] or row["with_estimates"]
        assert 0.0 < row["startup"]["cpu_s"] < used["cpu_s"]
        assert 0.0 < row["startup"]["peak_memory_gib"] <= used["peak_memory_gib"] < 2.0


@pytest.mark.solver
def test_fronts_hold_what_no_other_case_beats(quick):
    _, _, document, _ = quick
    rows = [r for r in document["cases"] if r["name"] != "reference"]
    for front, key in (("error_cpu_s", "cpu_s"), ("error_peak_memory", "peak_memory_gib")):
        names = document["pareto"][front]
        assert names
        for own in (case(document, name) for name in names):
            cheaper = [r for r in rows if cost(r, key) < cost(own, key)]
            assert not [r for r in cheaper if r["campbell"]["true"] < own["campbell"]["true"]]


def cost(row, key):
    return (row["without_estimates"] or row["with_estimates"])[key]


@pytest.mark.solver
def test_files_tell_every_case(quick):
    _, out, document, _ = quick
    assert (out / "study.png").read_bytes().startswith(b"\x89PNG")
    text = (out / "study.md").read_text(encoding="utf-8")
    for row in document["cases"]:
        assert f"| {row['name']} |" in text


@pytest.mark.solver
def test_study_again_runs_nothing(quick, scene_path, monkeypatch):
    """All results are cached; the same document but for the machine's speed of the moment."""
    done, out, document, _ = quick
    monkeypatch.setattr(study_run, "measured_apart", lambda *_: pytest.fail("was run"))
    again = study_command(scene_path, out, quick=True)
    assert again.counts == done.counts
    assert {**written(out), "machine": None} == {**document, "machine": None}
    assert not [p.name for p in out.rglob(".*")]


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
    ended = CliRunner().invoke(app, ["study", str(path), "--out", str(tmp_path / "out")])
    assert ended.exit_code == 2
    assert "needs a body with a profile" in ended.stderr
    assert not (tmp_path / "out").exists()


# -- running cases --------------------------------------------------------------------------------


@pytest.fixture
def cases(small_scene):
    return study_cases(parse_scene(small_scene()), QUICK)


@pytest.fixture
def process(monkeypatch, measurement):
    """Stand-in for the process of a case: the cases that were run, and what one says by number.

    The machine is fast enough for every case: which of them are skipped is another test.
    """
    asked, said, patience = [], {}, []

    def run(case, patience_s):
        asked.append(case)
        patience.append(patience_s)
        answer = said.get(len(asked), measurement())
        if isinstance(answer, BaseException):
            raise answer
        return answer

    monkeypatch.setattr(study_run, "measured_apart", run)

    monkeypatch.setattr(study_run, "this_machine", lambda: uniform(0.5))
    return asked, said, patience


def test_interrupted_study_continues(cases, process, tmp_path):
    asked, said, _ = process
    said[3] = KeyboardInterrupt()
    with pytest.raises(KeyboardInterrupt):
        run_cases(cases, tmp_path, QUICK, lambda text: None)
    assert not list(tmp_path.glob(".*"))
    found = run_cases(cases, tmp_path, QUICK, lambda text: None)
    assert len(asked) == 3 + len(cases) - 2
    assert [o.status for o in found] == ["done"] * len(cases)


def test_failed_case_is_recorded_and_tried_again(cases, process, tmp_path):
    asked, said, patience = process
    said[2] = "the disk fell off"
    lines = []
    found = run_cases(cases, tmp_path, QUICK, lines.append)
    assert [o.status for o in found] == ["done", "failed"] + ["done"] * (len(cases) - 2)
    assert found[1].message == "the disk fell off"
    assert f"{cases[1].name} failed: the disk fell off" in lines
    # a small case has the time that the ladders allow, on a machine with other work as well
    assert min(patience) >= 15.0 * QUICK.longest_s
    again = run_cases(cases, tmp_path, QUICK, lambda text: None)
    assert len(asked) == len(cases) + 1
    assert again[1].status == "done"


def test_without_the_reference_there_is_no_study(cases, process, tmp_path):
    process[1][1] = "no such thing"
    with pytest.raises(StudyError, match="reference can not be computed: no such thing"):
        run_cases(cases, tmp_path, QUICK, lambda text: None)


def test_a_case_has_the_time_that_is_predicted(cases, process, tmp_path, monkeypatch):
    """The reference of a whole engine is predicted to take longer than other cases may."""
    hour = SimpleNamespace(whole=SimpleNamespace(total_s=3600.0, peak_memory_gib=0.1))
    monkeypatch.setattr(study_run, "predict_cost", lambda *_, **__: hour)
    found = run_cases(cases, tmp_path, QUICK, lambda text: None)
    assert min(process[2]) > 3600.0
    # as long as the reference, and no longer: a case that is run twice, plain and with estimates
    assert {o.status for o in found} == {"done"}


@pytest.mark.verify
def test_too_large_cases_are_skipped_and_said(small_scene, process, tmp_path, monkeypatch):
    """Without memory for estimates a case runs without them, and not at all with less."""
    cases = study_cases(parse_scene(small_scene()), FULL)
    monkeypatch.setattr(study_run, "available_memory_gib", lambda: 0.5)
    lines = []
    found = run_cases(cases, tmp_path, FULL, lines.append)
    assert found[0].status == "done"
    skipped = [o for o in found if o.status == "skipped"]
    assert any(o.case.level == "solid" for o in skipped)
    for o in skipped:
        assert "GiB" in o.message or "s of processor time" in o.message
        assert any(o.case.name in line and "skipped" in line for line in lines)
    assert {"both", "off"} <= {o.case.estimates for o in found if o.status == "done"}


def test_case_scenes_are_what_their_settings_say(small_scene):
    scene = parse_scene(small_scene(body={"modes": 7}))
    cases = study_cases(scene, FULL)
    assert len({c.name for c in cases}) == len(cases)
    for c in cases:
        assert c.scene.bodies["rotor"].modes is None
        assert c.scene.speeds == scene.speeds
        assert c.scene.model.compare_coupling == "off"
        for key, value in c.settings.items():
            assert getattr(c.scene.model, key) == value


def test_a_body_with_blades_is_a_solid_in_all_cases(small_scene):
    """No meridian holds them: the truth is a solid too, and sizes follow the thinnest blade."""
    blades = {"name": "fan", "on": "disk", "count": 8, "length_m": 0.05, "chord_m": 0.02,
              "thickness_m": [0.003, 0.002]}  # fmt: skip
    cases = study_cases(parse_scene(small_scene(body={"blades": [blades]})), FULL)
    assert {c.level for c in cases} == {"solid"}
    assert cases[0].settings["accuracy"] == FULL.reference["solid"]
    rung = next(c for c in cases if c.name == "solid, order 2, graded, rung 0")
    assert rung.settings["size_m"] == pytest.approx(4.0 * 0.003)


POINT = {"program": "x", "unknowns": 9, "error": 0.1, "cpu_s": 3.0, "peak_memory_gib": 0.5}


def test_points_of_other_programs_stand_beside(cases, process, tmp_path):
    path = tmp_path / "peers.json"
    path.write_text(json.dumps([POINT]), encoding="utf-8")
    outcomes = run_cases(cases, tmp_path, QUICK, lambda text: None)
    study = Study(
        scene=cases[0].scene,
        quick=True,
        outcomes=outcomes,
        table=study_table(outcomes),
        peers=study_run.read_peers(path),
    )
    assert study_document(study)["peers"] == [POINT | {"model": ""}]
    assert "| x |  | 9 | 3.00 | 0.500 | 1.0e-01 |" in summary(study, study_document(study))
    marks = [option.marks[0] for option in study_chart(study).parts[-1].options]
    assert [m.x.tolist() for m in marks] == [[3.0], [0.5], [9.0]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (json.dumps([POINT | {"error": 0}]), r"\[0\].error: 0 found; Input should be greater"),
        (json.dumps([POINT | {"time": 1}]), r"\[0\].time: 1 found; Extra inputs"),
        ("{", "the list: .*Invalid JSON"),
    ],
)
def test_points_that_are_none_are_refused(text, message, scene_path, tmp_path):
    path = tmp_path / "peers.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(StudyError, match=message):
        study_command(scene_path, tmp_path / "out", peers=path)
    with pytest.raises(StudyError, match="can not be read: No such file"):
        study_command(scene_path, tmp_path / "out", peers=tmp_path / "none.json")
    assert not (tmp_path / "out").exists()


@pytest.mark.solver
def test_case_that_can_not_be_run_tells_why(small_scene, cases):
    """A real process: an interface beyond the end of the shaft."""
    data = small_scene()
    data["bodies"]["rotor"]["interfaces"][1]["at_m"] = 0.9
    answer = measured_apart(replace(cases[0], scene=parse_scene(data)), 100.0)
    assert "interface 'right'" in answer


def test_process_that_takes_too_long_is_ended(cases):
    assert measured_apart(cases[0], 0.05) == "ended after 0 s"


def test_peak_memory_is_read_from_the_kernel(tmp_path):
    status = tmp_path / "status"
    status.write_text("Name:\tx\nVmHWM:\t  2097152 kB\nVmRSS:\t 10 kB\n", encoding="ascii")
    assert usage(status).peak_memory_gib == 2.0
    assert 0.0 < usage(tmp_path / "none").peak_memory_gib < 100.0
