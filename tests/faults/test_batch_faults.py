"""Batches under mpirun that are killed, ended, or fail in part: rows stay, and the next goes on."""

from __future__ import annotations

import itertools
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from jobs import SOLID, mpirun, ranks_of
from of_the_run import OF_THE_RUN
from ranks import CLEAN

from solidwhirl.batch.schedule import predicted_cost
from solidwhirl.batch.table import read_batch
from solidwhirl.cost.machine import this_machine
from solidwhirl.files.run_folder import claimed, verify_folder
from solidwhirl.scene_reading.reader import read_scene

pytestmark = [
    pytest.mark.solver,
    pytest.mark.mpi,
    pytest.mark.skipif(shutil.which("mpirun") is None, reason="no mpirun"),
]
SCRIPT = Path(__file__).with_name("batch.py")
# Time in which a job must be gone; an undisturbed one takes less.
LIMIT_S = 300.0


def start(ranks, fault, *arguments):
    """The command on so many ranks."""
    return mpirun(ranks, SCRIPT, fault, "batch", *arguments)


def finished(job, codes=(0,)):
    """What an undisturbed job says."""
    _, said = job.communicate(timeout=LIMIT_S)
    assert job.returncode in codes, said
    return said


def numbers(folder):
    document = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    return {key: value for key, value in document.items() if key not in OF_THE_RUN}


def origins(folder):
    return json.loads((folder / "results.json").read_text(encoding="utf-8"))["stages"]


def lines_of(out):
    try:
        return (out / "batch.jsonl").read_bytes().count(b"\n")
    except FileNotFoundError:
        return 0


def wait_for_rows(job, out, count):
    """Until so many rows are written; others are being computed then."""
    until = time.monotonic() + LIMIT_S
    while lines_of(out) < count:
        assert job.poll() is None, job.communicate()
        assert time.monotonic() < until
        time.sleep(0.005)


def radius(value):
    """A disk of its own."""
    return {"outer_radius_m = 0.12": f"outer_radius_m = {value}"}


@pytest.fixture
def scenes(one_body):
    """Eight scenes of harmonic level, of the same cost but for the last, the largest."""
    found = [one_body(f"s{k}", **radius(0.11 + 0.002 * k)) for k in range(7)]
    fine = {'estimates = "off"': 'estimates = "off", size_m = 0.006, corner_size_m = 0.006'}
    return [*found, one_body("largest", **fine)]


@pytest.fixture(scope="session")
def single():
    """Function: numbers of a scene that ran alone, in this process."""
    from solidwhirl.output.documents import write_results
    from solidwhirl.pipeline.run import run_scene

    def run(path, out):
        results = run_scene(read_scene(path))
        return numbers(write_results(results, out, pictures=False))

    return run


@pytest.mark.parametrize(
    "ranks",
    [pytest.param(1, marks=pytest.mark.verify), 2, pytest.param(3, marks=pytest.mark.verify)],
)
def test_rows_are_those_of_single_runs(scenes, single, one_body, tmp_path, ranks):
    # refused before it is meshed: more memory than any machine has
    huge = 'estimates = "off", size_m = 1e-6, corner_size_m = 1e-6'
    failing = one_body("refused", **{'estimates = "off"': huge})
    out = tmp_path / "out"
    chosen = [*scenes[:2], failing, scenes[-1]]
    said = finished(start(ranks, "s1:defect", *chosen, "--out", out, "--no-pictures"), codes=(1,))
    rows = {row.case: row for row in read_batch(out)}
    assert set(rows) == {path.stem for path in chosen}
    # one line for each, the largest begun first: with one rank it is the first to end as well
    ended = re.findall(r"^\[\d/4\] (\S+) ", said, flags=re.MULTILINE)
    assert sorted(ended) == sorted(rows)
    assert ranks > 1 or ended[0] == "largest"
    assert rows["refused"].status == "failed"
    assert "unknowns and need about" in rows["refused"].message
    assert rows["s1"].message.startswith("defect of the program: RuntimeError: a defect")
    assert "Traceback" in (out / "s1" / "error.txt").read_text(encoding="utf-8")
    for path in (scenes[0], scenes[-1]):
        assert rows[path.stem].status == "done"
        assert verify_folder(out / path.stem) == []
        assert numbers(out / path.stem) == single(path, tmp_path / "single" / path.stem)


@pytest.mark.verify
def test_equal_bodies_are_reduced_once_by_two_teams_at_once(one_body, tmp_path):
    # the same body on other bearings; both teams come to it within milliseconds of each other
    stiffer = [{"stiffness_n_per_m = 1e7": f"stiffness_n_per_m = {k}e7"} for k in (1, 2, 3, 4)]
    paths = [one_body(f"s{k}", **changes) for k, changes in enumerate(stiffer)]
    out = tmp_path / "out"
    finished(start(2, "none", *paths, "--out", out, "--no-pictures"))
    for stage in ("mesh rotor", "reduction rotor"):
        found = sorted(origins(out / path.stem)[stage] for path in paths)
        assert found == ["computed", "kept", "kept", "kept"]
    assert not list((out / ".stages").glob(".*"))  # no locks are left


@pytest.mark.verify
@pytest.mark.parametrize("ranks", [1, 2])
def test_second_batch_on_a_folder_is_refused(scenes, tmp_path, ranks):
    out = tmp_path / "out"
    with claimed(out):  # as a batch does while it runs
        other = start(ranks, "none", scenes[0], "--out", out, "--no-pictures", "--resume")
        said = finished(other, codes=(2,))
    assert f"{out}: another run is writing here" in said
    assert not out.exists()  # it was made for the first batch, which left nothing in it


@pytest.mark.verify
@pytest.mark.parametrize("share", [1.5, 0.5])
def test_cases_wait_for_memory(scenes, tmp_path, share):
    """With room for one and a half, or less than one, cases come one after another."""
    machine = this_machine()
    needs = [predicted_cost(read_scene(path), machine).peak_memory_gib for path in scenes[:4]]
    kind = f"room:{share * max(needs)}:{tmp_path / 'times'}"
    finished(start(2, kind, *scenes[:4], "--out", tmp_path / "out", "--no-pictures"))
    lines = (tmp_path / "times").read_text(encoding="ascii").splitlines()
    spans = sorted(tuple(map(float, line.split())) for line in lines)
    assert len(spans) == 4
    assert all(end <= begun for (_, end), (begun, _) in itertools.pairwise(spans))


@pytest.mark.verify
def test_signal_to_mpirun_itself(scenes, tmp_path):
    """mpirun passes SIGTERM on after a while of its own, and says 1 for itself or 143."""
    out = tmp_path / "out"
    command = (2, "none", *scenes, "--out", out, "--no-pictures")
    job = start(*command)
    wait_for_rows(job, out, 1)
    job.send_signal(signal.SIGTERM)
    _, said = job.communicate(timeout=LIMIT_S)
    assert job.returncode != 0
    assert "Traceback" not in said
    before = {row.case for row in read_batch(out)}
    said = finished(start(*command, "--resume"))
    assert f"{8 - len(before)} cases to compute" in said
    assert {row.status for row in read_batch(out)} == {"done"}
    assert len(read_batch(out)) == 8


@pytest.mark.verify
@pytest.mark.parametrize("kind", ["kill", pytest.param("terminate", marks=pytest.mark.verify)])
def test_goes_on_after_the_job_ended(scenes, tmp_path, kind):
    out = tmp_path / "out"
    command = (2, "none", *scenes[:4], "--out", out, "--no-pictures")
    job = start(*command)
    wait_for_rows(job, out, 1)
    # to the ranks, as srun does; mpirun passes a signal on after a while
    for process in ranks_of(job, "batch.py"):
        os.kill(process, signal.SIGKILL if kind == "kill" else signal.SIGTERM)
    _, said = job.communicate(timeout=LIMIT_S)
    assert job.returncode == 143 or (kind == "kill" and job.returncode != 0)
    assert "Traceback" not in said
    before = {row.case: row for row in read_batch(out)}
    assert 1 <= len(before) < 4
    stamps = {case: (out / case / "results.json").stat().st_mtime_ns for case in before}
    said = finished(start(*command, "--resume"))
    assert f"{4 - len(before)} cases to compute, {len(before)} kept" in said
    after = {row.case: row for row in read_batch(out)}
    assert len(after) == 4
    assert all(row.status == "done" for row in after.values())
    for case, row in before.items():
        assert after[case] == row
        assert (out / case / "results.json").stat().st_mtime_ns == stamps[case]
    assert all(verify_folder(out / case) == [] for case in after)
    assert (out / "table.h5").exists()


@pytest.mark.verify
@pytest.mark.parametrize(
    ("number", "code"),
    [(signal.SIGTERM, 143), pytest.param(signal.SIGINT, 130, marks=pytest.mark.verify)],
)
def test_one_process_ends_with_the_code_of_the_signal(scenes, tmp_path, number, code):
    out = tmp_path / "out"
    job = subprocess.Popen(
        [sys.executable, SCRIPT, "none", "batch", *scenes, "--out", out, "--no-pictures"],
        env=CLEAN,
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_for_rows(job, out, 1)
    job.send_signal(number)
    _, said = job.communicate(timeout=LIMIT_S)
    assert job.returncode == code
    assert "Traceback" not in said
    # the table holds the rows so far, and the case that was running left no half of a folder
    (out / "batch.jsonl").unlink()
    rows = read_batch(out)
    assert 1 <= len(rows) < 8
    whole = {path.parent.name for path in out.glob("*/SHA256SUMS")}
    assert whole >= {row.case for row in rows}
    assert not [path for path in out.glob("*/.*") if path.parent.name != ".stages"]


@pytest.fixture
def solids(one_body):
    """Two scenes of solid level, coarse, and one harmonic that comes after them."""
    found = [
        one_body(name, **SOLID, **{"outer_radius_m = 0.025": f"outer_radius_m = {radius_m}"})
        for name, radius_m in (("first", 0.026), ("second", 0.027))
    ]
    return [*found, one_body("third")]


@pytest.mark.verify
def test_team_goes_on_where_its_first_rank_fails(solids, tmp_path):
    # the others wait for a message of the first rank then, and get that the case is over
    out = tmp_path / "out"
    options = ("--out", out, "--no-pictures", "--ranks-per-scene", 2)
    finished(start(2, "second:first", *solids, *options), codes=(1,))
    rows = {row.case: row for row in read_batch(out)}
    assert {case: row.status for case, row in rows.items()} == {
        "first": "done",
        "second": "failed",
        "third": "done",
    }
    assert all(row.ranks == 2 for row in rows.values())


@pytest.mark.verify
def test_team_that_can_not_be_saved_ends_the_job(solids, tmp_path):
    # one rank is out of the case while the other waits for it inside a library
    out = tmp_path / "out"
    command = (*solids, "--out", out, "--no-pictures", "--ranks-per-scene", 2)
    job = start(4, "second:other", *command)
    _, said = job.communicate(timeout=LIMIT_S)
    assert job.returncode != 0
    assert "--resume goes on" in said
    assert "second: rank 1 of the team failed and the others wait for it: a defect" in said
    assert (out / "second" / "error.txt").read_text().startswith("rank 1 of the team failed")
    said = finished(start(2, "none", *command, "--resume"))
    # one team, for which what ended the job comes last
    assert re.findall(r"^\[3/3\] (\S+) ", said, flags=re.MULTILINE) == ["second"]
    assert {row.status for row in read_batch(out)} == {"done"}


@pytest.mark.verify
def test_resume_computes_what_changed(scenes, one_body, tmp_path):
    out = tmp_path / "out"
    options = ("--out", out, "--no-pictures", "--resume")
    finished(start(1, "s1:memory", *scenes[:4], *options), codes=(1,))
    first = {row.case: row for row in read_batch(out)}
    assert first["s1"].message.startswith("not enough memory")
    one_body("s2", **radius(0.2))  # another scene
    (out / "s3" / "bodies" / "rotor.json").write_text("{}", encoding="utf-8")  # a damaged folder
    said = finished(start(1, "none", *scenes[:3], scenes[3], *options))
    ended = re.findall(r"^\[\d/4\] (\S+) ", said, flags=re.MULTILINE)
    assert set(ended) == {"s1", "s2", "s3"}
    assert ended[-1] == "s1"  # it failed before
    second = {row.case: row for row in read_batch(out)}
    assert second["s0"] == first["s0"]
    assert second["s2"].digest != first["s2"].digest
    assert not (out / "s1" / "error.txt").exists()
    # a scene that is no part of the batch any more has no row
    finished(start(1, "none", *scenes[:2], *options))
    assert {row.case for row in read_batch(out)} == {"s0", "s1"}


def _has_namespaces():
    """Whether hosts can be made here: network namespaces need root, and a kernel that allows."""
    if os.geteuid() != 0 or shutil.which("ip") is None or shutil.which("unshare") is None:
        return False
    made = subprocess.run(["ip", "netns", "add", "sw-probe"], capture_output=True, check=False)
    subprocess.run(["ip", "netns", "del", "sw-probe"], capture_output=True, check=False)
    return made.returncode == 0


@pytest.mark.verify
@pytest.mark.skipif(not _has_namespaces(), reason="no network namespaces")
@pytest.mark.parametrize("ranks_per_scene", [1, 2, 4])
def test_batch_on_two_hosts(solids, single, tmp_path, ranks_per_scene):
    """Teams on two hosts, and one team across both, beside single runs in this process."""
    out = tmp_path / "out"
    options = ["--out", out, "--no-pictures", "--ranks-per-scene", ranks_per_scene]
    hosts = SCRIPT.with_name("two_hosts.sh")
    done = subprocess.run(
        [hosts, sys.executable, SCRIPT, "none", "batch", *solids, *map(str, options)],
        env=CLEAN,
        capture_output=True,
        text=True,
        timeout=2 * LIMIT_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    rows = {row.case: row for row in read_batch(out)}
    assert {row.status for row in rows.values()} == {"done"}
    for path in solids:
        assert rows[path.stem].ranks == ranks_per_scene
        assert verify_folder(out / path.stem) == []
        found, alone = numbers(out / path.stem), single(path, tmp_path / path.stem)
        if ranks_per_scene == 1 or path.stem == "third":  # solid bodies alone are divided
            assert found == alone
            continue
        speeds = [
            [s["frequency_hz"] for s in document["critical_speeds"]] for document in (found, alone)
        ]
        # sums over ranks in another order: 1e-8 is what all numbers of divided solids keep to
        assert speeds[0] == pytest.approx(speeds[1], rel=1e-8)
