"""The runner of batches without its solvers: order, teams, stages at once, Slurm scripts."""

from __future__ import annotations

import dataclasses
import itertools
import json
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console
from ring_scenes import STIFFNESS, ring_scene, written

from solidwhirl.batch.case import CaseSettings
from solidwhirl.batch.command import BatchProgress
from solidwhirl.batch.run import Dispatch, Place, Work, kept_cases, run_batch
from solidwhirl.batch.schedule import (
    Memory,
    Predicted,
    TimeToGo,
    largest_first,
    predicted_cost,
    team_layout,
)
from solidwhirl.batch.slurm import slurm_job, slurm_script, write_slurm_script
from solidwhirl.batch.table import read_batch, read_table
from solidwhirl.cache.files import StageStore
from solidwhirl.core.errors import OutputError, UserError
from solidwhirl.cost.machine import uniform
from solidwhirl.scene_reading.reader import read_scene
from solidwhirl.sweep.records import BatchCase, BatchRow

SCENES = Path(__file__).parents[3] / "scenes"


@settings(deadline=None)
@given(
    size=st.integers(1, 200),
    ranks=st.integers(1, 40),
    answers=st.booleans(),
)
def test_every_rank_has_one_place(size, ranks, answers):
    if ranks > size:
        with pytest.raises(ValueError, match=f"1 to {size}"):
            team_layout(size, ranks, answers_while_busy=answers)
        return
    found = team_layout(size, ranks, answers_while_busy=answers)
    teams = [found.team_of(rank) for rank in range(size)]
    counts = [teams.count(team) for team in range(found.teams)]
    assert counts == [ranks] * found.teams
    assert found.teams >= 1
    assert teams.count(None) == found.first + found.idle
    for team in range(found.teams):
        assert teams.index(team) == found.leader_of(team)
    # a rank that only coordinates costs a team at most where there are many
    assert found.teams == size // ranks or found.teams >= 8 or not answers
    # less than a team is left over, beside rank 0
    assert found.idle < ranks
    # where ranks are odd, one gives out the cases, with nothing else to do
    assert found.first == 1 or found.teams * ranks == size or not answers


def test_largest_first_and_failed_ones_last():
    seconds = dict(enumerate([3.0, 1.0, 4.0, 1.0, 5.0, 9.0]))
    assert largest_first(seconds, [0, 1, 2, 3, 4]) == [4, 2, 0, 1, 3]
    assert largest_first(seconds, range(6), last=[5, 3]) == [4, 2, 0, 1, 5, 3]


@settings(deadline=None)
@given(seconds=st.lists(st.floats(0.01, 100.0), min_size=1, max_size=7), teams=st.integers(2, 3))
def test_order_keeps_the_bound_of_longest_first(seconds, teams):
    """Longest first takes at most 4/3 - 1/(3m) of the best schedule (Graham 1969)."""
    loads = [0.0] * teams
    for case in largest_first(dict(enumerate(seconds)), range(len(seconds))):
        loads[loads.index(min(loads))] += seconds[case]
    best = min(
        max(
            sum(s for s, own in zip(seconds, places, strict=True) if own == m) for m in range(teams)
        )
        for places in itertools.product(range(teams), repeat=len(seconds))
    )
    # sums of a few floats
    assert max(loads) <= (4.0 / 3.0 - 1.0 / (3.0 * teams)) * best * (1.0 + 1e-12)


def test_time_to_go_follows_what_was_measured():
    to_go = TimeToGo(dict(enumerate([8.0, 4.0, 4.0, 2.0, 2.0])), teams=2)
    assert to_go.seconds({}) == pytest.approx(10.0)  # 20 s on two teams
    to_go.finished(0, 16.0)  # twice what was predicted
    assert to_go.factor == pytest.approx(2.0)
    assert to_go.seconds({}) == pytest.approx(12.0)
    # a case that has run for longer than predicted is about to end, and counts for nothing
    assert to_go.seconds({1: 100.0}) == pytest.approx(8.0)
    to_go.finished(1, None)  # failed: nothing was learnt
    assert to_go.factor == pytest.approx(2.0)
    for case in (2, 3):
        to_go.finished(case, 1.0)
    # one case is left, which two teams can not share
    assert to_go.seconds({}) == pytest.approx(2.0 * to_go.factor)
    # bodies that are kept from the first case on make all others cheap
    to_go = TimeToGo(dict.fromkeys(range(40), 10.0), teams=1)
    to_go.finished(0, 10.0)
    for case in range(1, 30):
        to_go.finished(case, 1.0)
    assert to_go.factor == pytest.approx(0.1)


def test_finer_scenes_are_predicted_to_cost_more():
    scene, machine = read_scene(SCENES / "laval.toml"), uniform(4.0)
    found = []
    for level, size in (("beam", None), ("harmonic", 0.02), ("harmonic", 0.005)):
        model = scene.model.model_copy(update={"size_m": size, "level": level})
        finer = scene.model_copy(update={"model": model})
        found.append(predicted_cost(finer, machine))
    seconds = [cost.seconds for cost in found]
    assert seconds == sorted(seconds) and seconds[0] < seconds[2]


def row(case, status="done", digest="d", seconds=1.0):
    return BatchRow(case=case, scene=case, status=status, digest=digest, seconds=seconds)


def test_only_whole_rows_are_kept():
    cases = [
        BatchCase(name=n, scene_path=Path("s"), values={}, data={}, digest="d") for n in "abcdef"
    ]
    rows = [row("a"), row("b", digest="e"), row("c", "failed"), row("d", "checks_failed"), row("e")]
    kept = kept_cases(cases, rows, lambda name: name != "e")
    assert {cases[n].name for n in kept} == {"a", "d"}


class Held(Executor):
    """Takes cases and computes none: a test ends them, one after another."""

    def __init__(self, choose=lambda running: 0):
        self.running, self.begun, self.together, self._choose = [], [], [], choose

    def submit(self, task, case, settings):
        future = Future()
        self.begun.append(case.name)
        self.running.append((case.name, future))
        self.together.append([name for name, _ in self.running])
        if len(self.running) == 1:
            threading.Thread(target=self._end_all).start()
        return future

    def _end_all(self):
        time.sleep(0.01)  # all that fit are begun by now
        while self.running:
            name, future = self.running.pop(self._choose(self.running) % len(self.running))
            future.set_result(row(name))


def dispatched(executor, needs_gib, workers=2, free_gib=10.0, keep=lambda row, to_go_s: None):
    """Cases "0", "1" ... of so much memory, in the order of their numbers."""
    costs = {
        n: Predicted(seconds=100.0 - n, peak_memory_gib=need) for n, need in enumerate(needs_gib)
    }
    cases = tuple(
        BatchCase(name=str(n), scene_path=Path("s"), values={}, data={}, digest="d") for n in costs
    )
    work = Work(cases=cases, todo=tuple(costs), settings=CaseSettings(out=Path("o")))
    place = Place(executor=executor, workers=workers, shares={"a": 1.0})
    Dispatch(work, costs, (place,), {"a": free_gib}, keep).run()


def test_no_case_is_begun_where_rows_can_not_be_written():
    written = []

    def keep(found, to_go_s):
        if len(written) == 2:
            raise OutputError("no space left")
        written.append(found.case)

    executor = Held()
    with pytest.raises(OutputError, match="no space left"):
        dispatched(executor, [0.0] * 8, keep=keep)
    assert written == ["0", "1"]
    # what ran when it failed is waited for
    assert executor.begun == ["0", "1", "2", "3"]
    assert executor.running == []


@pytest.mark.parametrize(
    ("needs", "together"),
    [
        # 7 + 4 and 7 + 6 are more than 10
        ([7.0, 4.0, 6.0], [["0"], ["1"], ["1", "2"]]),
        # a smaller one goes before a large one that does not fit yet
        ([7.0, 6.0, 3.0], [["0"], ["0", "2"], ["2", "1"]]),
        # one that never fits runs alone: its own run refuses it, or it was overestimated
        ([12.0, 2.0, 2.0], [["0"], ["1"], ["1", "2"]]),
    ],
)
def test_case_waits_until_it_fits_beside_those_that_run(needs, together):
    executor = Held()
    dispatched(executor, needs)
    assert executor.together == together


@given(
    needs=st.lists(st.floats(0.0, 15.0), min_size=1, max_size=12),
    workers=st.integers(1, 4),
    ends=st.lists(st.integers(0, 3), min_size=12, max_size=12),
)
@settings(deadline=None, max_examples=40)
def test_memory_is_never_promised_twice_and_all_cases_run(needs, workers, ends):
    left = list(ends)
    executor = Held(lambda running: left.pop())
    dispatched(executor, needs, workers=workers)
    assert sorted(map(int, executor.begun)) == list(range(len(needs)))
    for running in executor.together:
        taken = [needs[int(name)] for name in running if needs[int(name)] > 0.0]
        assert len(running) <= workers
        assert sum(taken) <= 10.0 + 1e-9 or len(taken) == 1


def test_all_cases_run_where_the_next_is_handed_in_late(monkeypatch):
    submit = Dispatch._submit

    def late(self):
        time.sleep(0.05)  # as of a thread that others keep from running
        submit(self)

    monkeypatch.setattr(Dispatch, "_submit", late)
    executor = Held()
    dispatched(executor, [12.0, 11.0, 13.0])  # one at a time
    assert executor.begun == ["0", "1", "2"]


def test_team_on_two_nodes_takes_of_each_its_share():
    # ranks 0 and 1 on a, 2 and 3 on b: team 0 on a, team 1 on both, team 2 on b
    on_a, on_both, on_b = shares = [{"a": 1.0}, {"a": 0.5, "b": 0.5}, {"b": 1.0}]
    needs = {0: 6.0, 1: 6.0, 2: 2.0}
    memory = Memory(free_gib={"a": 8.0, "b": 4.0}, places=shares, needs_gib=needs)
    assert not memory.allows(0, on_b, {})  # fits on a, so it does not run alone on b
    assert memory.allows(0, on_both, {})
    running = {0: on_both}  # 3 of each
    assert not memory.allows(1, on_a, running)
    assert memory.allows(2, on_a, running)
    assert memory.allows(1, on_a, {})


class AtOnce(Executor):
    """Computes a case while it is handed in; a worker may die of its second one."""

    def __init__(self, dies=False):
        self.taken, self.dies = 0, dies

    def submit(self, task, case, settings):
        self.taken += 1
        future = Future()
        if self.dies and self.taken == 2:
            future.set_exception(BrokenExecutor("a worker died"))
        else:
            future.set_result(row(case.name))
        return future


def test_rows_stay_where_an_executor_breaks():
    written = []
    keep = lambda row, left: written.append(row.case)  # noqa: E731
    with pytest.raises(BrokenExecutor, match="a worker died"):
        dispatched(AtOnce(dies=True), [0.0] * 5, workers=1, keep=keep)
    assert written == ["0"]


def test_executor_without_workers_of_its_own_takes_many_cases():
    written = []
    dispatched(AtOnce(), [0.0] * 1500, keep=lambda row, left: written.append(int(row.case)))
    assert written == list(range(1500))


@pytest.mark.verify
@pytest.mark.solver
def test_batch_runs_on_the_executor_of_a_user(tmp_path):
    """Processes of the standard library: the same rows as in this process, one after another."""
    sweep = {"method": "list", "parameters": [{**STIFFNESS, "values": [1e6, 2e6]}]}
    scene = written(tmp_path, ring_scene(sweep))
    mine = CaseSettings(out=tmp_path / "mine", pictures=False)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        found = run_batch([scene], mine, executor=pool, workers=2)
    assert [row.status for row in found] == ["done"] * 2
    assert read_batch(mine.out) == read_table(mine.out / "table.h5") == found
    alone = run_batch([scene], dataclasses.replace(mine, out=tmp_path / "one"))
    of_the_run = {"seconds": 0.0, "peak_memory_gib": 0.0}
    assert [dataclasses.replace(row, **of_the_run) for row in found] == [
        dataclasses.replace(row, **of_the_run) for row in alone
    ]
    again = run_batch([scene], mine, resume=True)
    assert again == found


@pytest.mark.solver
def test_bodies_of_cases_that_begin_together_are_refined_once(tmp_path, small_scene):
    """Two workers, one body, two stiffnesses: one refines, the other begins where that ended."""
    springs = {"name": "k", "places": ["bearings[left].stiffness_n_per_m"], "values": [1e7, 1.5e7]}
    data = small_scene(model={"estimates": "on", "level": "harmonic", "accuracy": 1e-3})
    data["sweep"] = {"method": "list", "parameters": [springs]}
    scene, mine = written(tmp_path, data), CaseSettings(out=tmp_path / "out", pictures=False)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        rows = run_batch([scene], mine, executor=pool, workers=2)
    assert [row.status for row in rows] == ["done"] * 2
    files = sorted((tmp_path / "out").glob("*/results.json"))
    found = [json.loads(file.read_text(encoding="utf-8")) for file in files]
    assert sorted(bool(one["body_problems"]) for one in found) == [False, True]
    assert max(len(one["accuracy"]["rounds"]) for one in found) > 1


# a stage as a run computes it, once a file says that all are there; own processes, since a copy of
# this one would have all that the tests before have left in it
ONCE = """
import sys
import time
from pathlib import Path

from solidwhirl.cache.files import StageStore

folder, made, start, here = map(Path, sys.argv[1:])
store = StageStore(folder)
here.touch()
while not start.exists():
    time.sleep(0.001)
with store.alone("0" * 64, print):
    if store.find("0" * 64, print) is None:
        with made.open("a") as file:
            file.write("computed\\n")
        time.sleep(0.2)
        store.keep("0" * 64, "a stage", [1.0, 2.0], print)
"""
HELD = """
import sys
import time
from pathlib import Path

from solidwhirl.cache.files import StageStore

with StageStore(Path(sys.argv[1])).alone("0" * 64, print):
    Path(sys.argv[2]).touch()
    time.sleep(60.0)
"""


def _started(code, *arguments):
    return subprocess.Popen([sys.executable, "-c", code, *map(str, arguments)])


def _wait_for(*paths):
    until = time.monotonic() + 120.0
    while not all(path.exists() for path in paths):
        assert time.monotonic() < until
        time.sleep(0.01)


def test_processes_that_come_at_once_compute_a_stage_once(tmp_path):
    made, start = tmp_path / "made", tmp_path / "start"
    here = [tmp_path / f"here-{k}" for k in range(3)]
    jobs = [_started(ONCE, tmp_path / "store", made, start, path) for path in here]
    _wait_for(*here)
    start.touch()
    for job in jobs:
        assert job.wait(60.0) == 0
    assert made.read_text() == "computed\n"
    # locks are gone, entries are whole
    assert [p.name for p in (tmp_path / "store").iterdir()] == [f"{'0' * 64}.stage"]


def test_killed_process_gives_its_stage_free(tmp_path):
    has = tmp_path / "has"
    job = _started(HELD, tmp_path / "store", has)
    _wait_for(has)
    job.kill()
    job.wait(30.0)
    began = time.monotonic()
    with StageStore(tmp_path / "store").alone("0" * 64, lambda text: None):
        assert time.monotonic() - began < 5.0


def test_stage_is_computed_where_nothing_can_be_locked(tmp_path):
    (tmp_path / "store").write_text("a file, no folder")
    with StageStore(tmp_path / "store").alone("0" * 64, lambda text: None):
        pass
    with StageStore(tmp_path / "new").alone("0" * 64, lambda text: None):
        assert (tmp_path / "new").is_dir()
    assert not (tmp_path / "new").exists()  # nothing was kept in it


# The head of a script in the words of sbatch(1), before the first command.
HEAD = re.compile(
    r"#!/bin/bash\n"
    r"#SBATCH --job-name=[\w.-]+\n"
    r"#SBATCH --ntasks=[1-9]\d*\n"
    r"#SBATCH --cpus-per-task=[1-9]\d*\n"
    r"#SBATCH --mem-per-cpu=[1-9]\d*[KMGT]?\n"
    r"#SBATCH --time=(\d+-)?\d\d?:\d\d:\d\d\n"
    r'#SBATCH --output="[^"]+ %%1[^"]*"\n'
    r"#SBATCH --open-mode=append\n"
    r"#SBATCH --requeue\n"
    r"#SBATCH --signal=B:USR1@\d{1,5}\n"
    r"(#.*\n)*\n"
)
COMMAND = ("solidwhirl", "batch", "/data/a scene.toml", "--out", "/data/it's", "--resume")


def job_of(out, seconds=(1.0,), ranks_per_scene=1, ranks=None, gib=1.0):
    costs = {n: Predicted(seconds=s, peak_memory_gib=gib) for n, s in enumerate(seconds)}
    teams = {"ranks_per_scene": ranks_per_scene, "ranks": ranks}
    return slurm_job(costs, command=COMMAND, out=out, **teams)


@pytest.mark.parametrize("ranks", [None, 12])
@pytest.mark.parametrize("seconds", [0.4, 5000.0, 3e6])
def test_slurm_script_is_one(tmp_path, seconds, ranks):
    job = job_of(tmp_path / "my sweep %1", [seconds] * 40, 4, ranks, gib=6.0)
    path = write_slurm_script(job, tmp_path / "job.sh")
    text = path.read_text(encoding="utf-8")
    assert HEAD.match(text) and text.count("\n#SBATCH") == 9
    for tool in (["bash", "-n"], *([["shellcheck"]] if shutil.which("shellcheck") else [])):
        done = subprocess.run([*tool, path], capture_output=True, text=True, check=False)
        assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert job.ranks % 4 == 0
    assert 4 <= job.ranks <= 160
    # memory of a rank: a quarter of the case's, and a reserve
    assert job.memory_mib * 4 > 6.0 * 1024
    # the limit holds what is predicted for so many teams
    teams = job.ranks // 4
    assert 60 * job.minutes > 40 * seconds / teams


@pytest.fixture
def started(tmp_path):
    """Function: a job's script on a machine with stand-ins for Slurm and MPI."""

    def start(srun, launch="srun", **variables):
        text = slurm_script(job_of(tmp_path / "o"))
        if launch == "mpirun":  # as the comment says
            text = text.replace("# launch=(mpirun", "launch=(mpirun")
        said = f'for word; do printf "%s\\n" "$word"; done > {tmp_path}/new; '
        said += f"mv {tmp_path}/new {tmp_path}/words; "
        for name, body in {
            launch: said + srun,
            "scontrol": f'echo "$@" > {tmp_path}/requeued',
        }.items():
            (tmp_path / name).write_text(f"#!/bin/bash\n{body}\n", encoding="utf-8")
            (tmp_path / name).chmod(0o755)
        (tmp_path / "job.sh").write_text(text, encoding="utf-8")
        path = {"PATH": f"{tmp_path}:/usr/bin:/bin", "SLURM_JOB_ID": "7", "SLURM_NTASKS": "3"}
        return subprocess.Popen(
            ["bash", tmp_path / "job.sh"],
            env={**path, **variables},
            stderr=subprocess.PIPE,
            text=True,
        )

    return start


def words_of(folder):
    """The words that the stand-in of srun or mpirun was started with, once it runs."""
    until = time.monotonic() + 60.0
    while not (folder / "words").exists():
        assert time.monotonic() < until
        time.sleep(0.01)
    return (folder / "words").read_text(encoding="utf-8").splitlines()


@pytest.mark.parametrize("status", [0, 3, 143])
def test_slurm_script_runs_the_command_and_ends_as_it_does(tmp_path, started, status):
    job = started(f"exit {status}")
    _, said = job.communicate(timeout=60.0)
    assert (job.returncode, said) == (status, "")
    assert tuple(words_of(tmp_path)[1:]) == COMMAND
    # nobody asked it to end: once more would come to the same
    assert not (tmp_path / "requeued").exists()


# Ends as mpirun does when it is asked to, after a while and with 1; else never.
_ASKED = "trap 'sleep 0.2; exit 1' TERM; while :; do sleep 0.05; done"


_WELL = _ASKED.replace("sleep 0.2; exit 1", "exit 0")


@pytest.mark.parametrize(
    ("body", "launch", "sent", "restarts", "code", "requeued"),
    [
        # at its time limit: Slurm sends what --signal=B:USR1 asks for
        (_ASKED, "srun", signal.SIGUSR1, 0, 1, "requeue 7\n"),
        (_ASKED, "mpirun", signal.SIGUSR1, 49, 1, "requeue 7\n"),
        (_ASKED, "srun", signal.SIGUSR1, 50, 1, None),
        # done just before the limit
        (_WELL, "srun", signal.SIGUSR1, 0, 0, None),
        # cancelled
        (_ASKED, "mpirun", signal.SIGTERM, 0, 1, None),
    ],
)
def test_job_that_is_ended_goes_on_where_it_should(
    tmp_path, started, body, launch, sent, restarts, code, requeued
):
    job = started(body, launch, SLURM_RESTART_COUNT=str(restarts))
    assert words_of(tmp_path)[0].startswith({"srun": "--kill", "mpirun": "-n"}[launch])
    time.sleep(0.2)  # the stand-in has come to its trap
    job.send_signal(sent)
    _, said = job.communicate(timeout=60.0)
    assert (job.returncode, said) == (code, "")
    asked = tmp_path / "requeued"
    assert (asked.read_text(encoding="utf-8") if asked.exists() else None) == requeued


def test_a_path_with_a_line_break_is_no_path_for_slurm(tmp_path):
    """Its second line would be a command of the script."""
    job = job_of(tmp_path / "o\ntouch evil")
    with pytest.raises(UserError, match=r"o\\ntouch evil.slurm.log: a path in a script for Slurm"):
        write_slurm_script(job, tmp_path / "job.sh")
    assert not (tmp_path / "job.sh").exists()


def test_slurm_asks_for_no_team_that_only_waits():
    # one case of an hour and a half, and many of a second: two teams are done when it is
    assert job_of(Path("o"), [1.0] * 1000 + [5400.0]).ranks == 2


def test_progress_says_a_line_for_each_case(tmp_path):
    with (tmp_path / "said").open("w") as file:
        progress = BatchProgress(Console(file=file, width=200), total=3, kept=1)
        progress.finished(row("s-[0001]", seconds=2.0), 61.0)
        failed = BatchRow(case="b", scene="b", status="failed", message="why\nmore", seconds=0.5)
        progress.finished(failed, 0.0)
        progress.close()
    assert (tmp_path / "said").read_text() == (
        "[2/3] s-[0001] done in 2.0 s; about 61 s to go\n"
        "[3/3] b FAILED in 0.5 s: why; all cases done\n"
    )
