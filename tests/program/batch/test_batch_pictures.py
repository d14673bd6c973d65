"""Pictures of a batch: at its end, again without computing, and where drawing fails."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import pytest
from ring_scenes import STIFFNESS, ring_scene, written
from typer.testing import CliRunner

from solidwhirl.batch.journal import open_journal
from solidwhirl.batch.pictures import redraw
from solidwhirl.batch.table import write_table
from solidwhirl.cli import app
from solidwhirl.sweep.records import BatchRow

# A point mass of 20 kg on springs of k each side, in both directions: 60 / (2 pi) sqrt(2 k / m).
MASS = 20.0
RING = ring_scene({"method": "grid", "parameters": [{**STIFFNESS, "values": [0.5e6, 1e6, 2e6]}]})


def critical_rpm(stiffness):
    return 30.0 / math.pi * math.sqrt(2.0 * stiffness / MASS)


def row(number, stiffness, status="done"):
    rpm = critical_rpm(stiffness)
    found = (rpm,) if status == "done" else ()
    return BatchRow(
        case=f"ring-{number:04d}",
        scene="ring",
        status=status,
        message="" if status == "done" else "no room",
        warnings=(f"k: {stiffness:g} N/m; is it?",),
        values={"stiffness_n_per_m": stiffness},
        critical_speed_rpm=found,
        critical_frequency_hz=tuple(v / 60.0 for v in found),
        critical_whirl=("forward",) * len(found),
        critical_error_estimate=(1e-4,) * len(found),
        campbell_speed_rpm=(0.0, 6000.0) if found else (),
        campbell_frequency_hz=((rpm / 60.0, rpm / 60.0),) if found else (),
        campbell_log_decrement=((0.0, 0.0),) if found else (),
    )


def batch_of(folder, rows):
    folder.mkdir(exist_ok=True)
    with open_journal(folder, rows):
        pass
    write_table(folder)
    return folder


@pytest.fixture
def batch(tmp_path):
    """Three cases of one parameter, and one that failed."""
    rows = [row(n, k) for n, k in enumerate((0.5e6, 1e6, 2e6), 1)]
    return batch_of(tmp_path / "out", [*rows, row(4, 4e6, "failed")])


@pytest.fixture
def ring(tmp_path):
    return written(tmp_path, RING)


def invoke(*words):
    return CliRunner().invoke(app, [str(w) for w in words])


def test_pictures_are_drawn_again_without_computing(batch):
    done = invoke("batch-pictures", batch, "--operating-rpm", 4000, 5000)
    assert done.exit_code == 0, done.output
    files = sorted(p.name for p in (batch / "pictures").iterdir())
    # neither map (one parameter) nor bands (a grid)
    assert files == [
        "ring-critical-speeds.png", "ring-parallel.html", "ring-tornado.png", "sweep.json",
    ]  # fmt: skip
    assert sorted(line.rsplit("/")[-1] for line in done.stdout.split()) == files
    document = json.loads((batch / "pictures" / "sweep.json").read_text(encoding="utf-8"))
    assert document["operating_rpm"] == [4000.0, 5000.0]
    # the failed case is counted, and said
    assert document["cases"] == {"done": 3, "failed": 1}
    assert document["scenes"][0]["left_out"][0]["message"] == "no room"
    assert "1 of 4 cases left out: failed" in document["scenes"][0]["notes"]
    page = (batch / "pictures" / "ring-parallel.html").read_text(encoding="utf-8")
    assert "3 cases, 1 left out" in page
    # once for all cases, those left out too, and said on the page
    (warned,) = document["scenes"][0]["warnings"]
    assert warned.startswith("k: ") and warned.endswith("is it? [4 cases, first ring-0001]")
    assert f"<li>warning: {warned}</li>" in page


def test_pictures_of_part_of_a_batch_say_so(tmp_path):
    """Rows 2, 3 and 5 of a batch of six cases that runs."""
    rows = [replace(row(n, k), sweep_cases=6) for n, k in ((2, 1e6), (3, 2e6), (5, 4e6))]
    redraw(batch_of(tmp_path / "out", rows))
    folder = tmp_path / "out" / "pictures"
    (scene,) = json.loads((folder / "sweep.json").read_text(encoding="utf-8"))["scenes"]
    assert any(n.startswith("3 cases left out: no row yet") for n in scene["notes"])
    page = (folder / "ring-parallel.html").read_text(encoding="utf-8")
    assert "3 cases, 3 missing" in page


def test_pictures_that_no_longer_apply_go_and_others_stay(batch):
    folder = batch / "pictures"
    folder.mkdir()
    for name in ("old-margins.png", "ring-parallel.png", "mine.png"):
        (folder / name).write_text("before", encoding="utf-8")
    redraw(batch)
    assert (folder / "mine.png").read_text(encoding="utf-8") == "before"
    assert not (folder / "old-margins.png").exists() and (folder / "sweep.json").exists()
    batch_of(batch, [row(1, 1e6)])
    assert redraw(batch) == ()
    assert [p.name for p in folder.iterdir()] == ["mine.png"]
    done = invoke("batch-pictures", batch)
    assert done.exit_code == 0 and "no scene has a sweep of two cases" in done.stdout


def test_what_can_not_be_drawn_is_refused_in_one_message(batch, tmp_path):
    for words, said in (
        ((batch, "--operating-rpm", 5000, 4000), "--operating-rpm: operating_rpm is 5000.0 to"),
        ((batch, "--operating-rpm", 0, 4000), "--operating-rpm"),
        ((tmp_path / "none",), "it is no batch"),
    ):
        done = invoke("batch-pictures", *words)
        assert done.exit_code == 2 and said in done.stderr, done.output
        assert "Traceback" not in done.stderr
    assert not (batch / "pictures").exists()
    (batch / "pictures").write_text("a file", encoding="utf-8")
    done = invoke("batch-pictures", batch)
    assert done.exit_code == 2 and "can not be written" in done.stderr


@pytest.mark.solver
def test_batch_says_each_warning_once_even_if_quiet(tmp_path):
    """Springs of 1e13 N/m and more are doubted in each case, in the words of `run`."""
    sweep = {"method": "list", "parameters": [{**STIFFNESS, "values": [1e13, 2e13]}]}
    path, out = written(tmp_path, ring_scene(sweep)), tmp_path / "batch"
    done = invoke("batch", path, "--out", out, "--quiet", "--no-pictures")
    assert done.exit_code == 0, done.output
    left, right = done.stderr.splitlines()
    said = "warning: bearings[0].stiffness_n_per_m: 1e+13 N/m; usual is"
    assert left.startswith(said) and left.endswith("[2 cases, first ring-0001]")
    assert right.startswith(said.replace("[0]", "[1]"))
    rows = [json.loads(line) for line in (out / "batch.jsonl").read_text("utf-8").splitlines()]
    (case,) = [row for row in rows if row["case"] == "ring-0001"]
    assert f"warning: {case['warnings'][0]} [2 cases, first ring-0001]" == left


@pytest.mark.verify
def test_batch_draws_at_its_end(ring, tmp_path, monkeypatch):
    """Exit code and table are the same whether pictures are drawn, left out, or fail."""
    out = tmp_path / "batch"
    done = invoke("batch", ring, "--out", out, "--operating-rpm", 4000, 5000)
    assert done.exit_code == 0, done.output
    document = json.loads((out / "pictures" / "sweep.json").read_text(encoding="utf-8"))
    (scene,) = document["scenes"]
    found = [s["speed_rpm"][1] for s in scene["critical_speeds"]]
    # one of them at least is the mass on its springs; the other tilts
    assert any(rpm == pytest.approx(critical_rpm(1e6), rel=1e-9) for rpm in found)
    power = scene["sensitivities"][0]["one_at_a_time"][0]["elasticity"]
    assert power == pytest.approx(0.5, abs=1e-9)
    table = (out / "batch.jsonl").read_bytes()

    def fail(*_):
        raise MemoryError

    monkeypatch.setattr("solidwhirl.rotordyn.plots.frame.new_figure", fail)
    done = invoke("batch", ring, "--out", out, "--resume")
    assert done.exit_code == 0 and "no pictures: MemoryError" in done.stderr, done.output
    assert (out / "batch.jsonl").read_bytes() == table

    other = tmp_path / "numbers"
    done = invoke("batch", ring, "--out", other, "--no-pictures", "--quiet")
    assert done.exit_code == 0 and not done.output
    assert not (other / "pictures").exists() and (other / "table.h5").exists()


def test_wrong_speeds_are_refused_before_the_cases_and_right_ones_are_in_the_script(ring, tmp_path):
    out, script = tmp_path / "batch", tmp_path / "job.sh"
    words = ("batch", ring, "--out", out)
    done = invoke(*words, "--operating-rpm", 5000, 4000)
    assert done.exit_code == 2 and "--operating-rpm" in done.stderr
    assert not out.exists()
    done = invoke(*words, "--slurm", script, "--operating-rpm", 4000, 5000.5)
    assert done.exit_code == 0, done.output
    assert "--operating-rpm 4000.0 5000.5" in script.read_text(encoding="utf-8")


def test_run_and_plan_say_that_a_sweep_is_left_out(ring, tmp_path):
    said = "nominal case: values as in the scene file"
    for words in (("plan", ring), ("run", ring, "--out", tmp_path / "run", "--no-pictures")):
        done = invoke(*words)
        assert done.exit_code == 0, done.output
        text = " ".join(done.stderr.split())
        assert said in text and "computes the 3 cases of [sweep]" in text
    results = json.loads((tmp_path / "run" / "results.json").read_text(encoding="utf-8"))
    speeds = [c["speed_rpm"] for c in results["critical_speeds"]]
    assert any(rpm == pytest.approx(critical_rpm(1e6), rel=1e-9) for rpm in speeds)
    done = invoke("run", ring, "--out", tmp_path / "run", "--no-pictures", "--quiet")
    assert done.exit_code == 0 and not done.output
