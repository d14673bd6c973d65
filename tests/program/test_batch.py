"""The runner of batches without its solvers: order, teams, stages at once, Slurm scripts."""

from __future__ import annotations

import itertools
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console

from solidwhirl.batch import kept_cases
from solidwhirl.batch_coordinator import LATER, NONE_LEFT, Coordinator
from solidwhirl.batch_memory import MemoryRoom
from solidwhirl.batch_progress import BatchProgress
from solidwhirl.batch_schedule import (
    Predicted,
    TimeToGo,
    largest_first,
    predicted_cost,
    team_layout,
)
from solidwhirl.batch_slurm import slurm_job, slurm_script, write_slurm_script
from solidwhirl.errors import OutputError
from solidwhirl.machine import MachineSpeed
from solidwhirl.scene_file import read_scene
from solidwhirl.store_stages import open_store
from solidwhirl.sweep_records import BatchCase, BatchRow
from solidwhirl.terminal import duration_text

SCENES = Path(__file__).parents[2] / "scenes"


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


def test_no_core_idles_on_two_ranks():
    assert team_layout(2, 1, answers_while_busy=True).teams == 2
    assert team_layout(4, 2, answers_while_busy=True).teams == 2
    # the odd rank gives out the cases, with nothing else to do
    assert team_layout(5, 2, answers_while_busy=True).first == 1


def test_largest_first_and_failed_ones_last():
    seconds = [3.0, 1.0, 4.0, 1.0, 5.0, 9.0]
    assert largest_first(seconds, [0, 1, 2, 3, 4]) == [4, 2, 0, 1, 3]
    assert largest_first(seconds, range(6), last=[5, 3]) == [4, 2, 0, 1, 5, 3]


@settings(deadline=None)
@given(seconds=st.lists(st.floats(0.01, 100.0), min_size=1, max_size=7), teams=st.integers(2, 3))
def test_order_keeps_the_bound_of_longest_first(seconds, teams):
    """Longest first takes at most 4/3 - 1/(3m) of the best schedule (Graham 1969)."""
    loads = [0.0] * teams
    for case in largest_first(seconds, range(len(seconds))):
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


def test_time_to_go_forgets_the_first_cases():
    # bodies that are kept from the first case on make all others cheap
    to_go = TimeToGo(dict.fromkeys(range(40), 10.0), teams=1)
    to_go.finished(0, 10.0)
    for case in range(1, 30):
        to_go.finished(case, 1.0)
    assert to_go.factor == pytest.approx(0.1)


def test_finer_scenes_are_predicted_to_cost_more():
    scene = read_scene(SCENES / "ferraris.toml")
    machine = MachineSpeed(gflops=10.0, gbytes_per_s=10.0)
    found = [
        predicted_cost(
            scene.model_copy(
                update={"model": scene.model.model_copy(update={"size_m": size, "level": level})}
            ),
            machine,
        ).seconds
        for level, size in (("beam", None), ("harmonic", 0.02), ("harmonic", 0.005))
    ]
    assert found == sorted(found)
    assert found[0] < found[2]


def test_pictures_of_a_case_are_part_of_its_time():
    scene, machine = read_scene(SCENES / "laval.toml"), MachineSpeed(gflops=10.0, gbytes_per_s=10.0)
    with_, without = (predicted_cost(scene, machine, pictures=drawn) for drawn in (True, False))
    assert with_.seconds > without.seconds + 1.0  # they take two seconds
    assert with_.peak_memory_gib == without.peak_memory_gib


def row(case, status="done", digest="d", seconds=1.0):
    return BatchRow(case=case, scene=case, status=status, digest=digest, seconds=seconds)


def test_only_whole_rows_are_kept():
    cases = [
        BatchCase(name=n, scene_path=Path("s"), values={}, data={}, digest="d") for n in "abcdef"
    ]
    rows = [row("a"), row("b", digest="e"), row("c", "failed"), row("d", "checks_failed"), row("e")]
    kept = kept_cases(cases, rows, lambda name: name != "e")
    assert {cases[n].name for n in kept} == {"a", "d"}


def test_coordinator_gives_each_case_once_and_stops_where_rows_can_not_be_written():
    written = []

    def keep(found, to_go_s):
        if len(written) == 2:
            raise OutputError("no space left")
        written.append(found.case)

    order = [3, 1, 2, 0, 4, 5, 6, 7]
    coordinator = Coordinator(order, to_go_of(order), 2, keep)
    # in hand: one of those that come last; none where few are left
    assert coordinator.take_small(1) == 7
    assert coordinator.take_small(1) == 6
    assert coordinator.take_small(1) == NONE_LEFT
    assert [coordinator.take(team) for team in (0, 1, 0)] == [3, 1, 2]
    for case in (3, 1, 2):
        coordinator.put(case, row(f"c{case}"))
    assert written == ["c3", "c1"]
    assert isinstance(coordinator.error, OutputError)
    assert coordinator.take(0) == coordinator.take_small(1) == NONE_LEFT


def to_go_of(order):
    return TimeToGo(dict.fromkeys(order, 1.0), 2)


def two_teams(needs, free_gib=10.0):
    """A coordinator of two teams on one machine, of cases in the order of their numbers."""
    room = MemoryRoom({"a": free_gib}, [{"a": 1.0}] * 2, dict(enumerate(needs)))
    order = range(len(needs))
    return Coordinator(order, to_go_of(order), 2, lambda row, to_go_s: None, room)


def test_case_waits_until_it_fits_beside_the_one_that_runs():
    coordinator = two_teams([7.0, 4.0, 6.0])
    assert coordinator.take(0) == 0
    assert coordinator.take(1) == LATER  # 7 + 4 and 7 + 6 are more than 10
    coordinator.put(0, row("c0"))
    assert coordinator.take(1) == 1
    assert coordinator.take(0) == 2
    assert coordinator.take(0) == NONE_LEFT


def test_smaller_case_goes_before_a_large_one_that_does_not_fit_yet():
    coordinator = two_teams([7.0, 6.0, 3.0])
    assert coordinator.take(0) == 0
    assert coordinator.take(1) == 2
    coordinator.put(2, row("c2"))
    assert coordinator.take(1) == LATER
    coordinator.put(0, row("c0"))
    assert coordinator.take(1) == 1


def test_case_that_never_fits_runs_alone():
    coordinator = two_teams([12.0, 2.0, 2.0])
    # alone from the start, as nothing runs yet: its own run refuses it, or it was overestimated
    assert coordinator.take(0) == 0
    assert coordinator.take(1) == LATER
    coordinator.put(0, row("c0", "failed"))
    assert [coordinator.take(team) for team in (0, 1)] == [1, 2]


def test_small_case_in_hand_counts_and_team_counts_its_largest_only():
    coordinator = two_teams([6.0, 6.0, 5.0, 5.0, 5.0, 5.0, 5.0, 4.0])
    assert coordinator.take_small(1) == 7
    assert coordinator.take(0) == 0  # 6 + 4
    assert coordinator.take(1) == LATER  # 6 + the larger of 4 and 5 is too much
    coordinator.put(0, row("c0"))
    assert coordinator.take(1) == 1  # the team computes one of its two at a time: 6, not 10
    assert coordinator.take_small(0) == NONE_LEFT


@given(
    needs=st.lists(st.floats(0.0, 15.0), min_size=1, max_size=12),
    teams=st.integers(1, 4),
    ends=st.lists(st.integers(0, 3), min_size=60, max_size=60),
)
@settings(deadline=None)
def test_memory_is_never_promised_twice_and_all_cases_run(needs, teams, ends):
    free = 10.0
    room = MemoryRoom({"a": free}, [{"a": 1.0}] * teams, dict(enumerate(needs)))
    order = range(len(needs))
    coordinator = Coordinator(order, to_go_of(order), teams, lambda row, to_go_s: None, room)
    running, done = {}, []
    for end in ends:
        for team in range(teams):
            if team not in running:
                case = coordinator.take(team)
                if case >= 0:
                    running[team] = case
        if not running:
            break
        taken = [needs[case] for case in running.values() if needs[case] > 0.0]
        assert sum(taken) <= free + 1e-9 or len(taken) == 1
        team = sorted(running)[end % len(running)]
        case = running.pop(team)
        done.append(case)
        coordinator.put(case, row(f"c{case}"))
    assert sorted(done) == list(order)


def test_team_on_two_nodes_takes_of_each_its_share():
    # ranks 0 and 1 on a, 2 and 3 on b: team 0 on a, team 1 on both, team 2 on b
    shares = [{"a": 1.0}, {"a": 0.5, "b": 0.5}, {"b": 1.0}]
    room = MemoryRoom({"a": 8.0, "b": 4.0}, shares, {0: 6.0, 1: 6.0, 2: 2.0})
    assert not room.may_begin(2, 0)  # fits on a, so it does not run alone on b
    assert room.may_begin(1, 0)
    room.begin(1, 0)  # 3 of each
    assert not room.may_begin(0, 1)
    assert room.may_begin(0, 2)
    room.end(0)
    assert room.may_begin(0, 1)


# a stage as a run computes it, once a file says that all are there; own processes, since a copy of
# this one would have all that the tests before have left in it
ONCE = """
import sys
import time
from pathlib import Path

from solidwhirl.store_stages import open_store

folder, made, start, here = map(Path, sys.argv[1:])
store = open_store(folder)
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

from solidwhirl.store_stages import open_store

with open_store(Path(sys.argv[1])).alone("0" * 64, print):
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
    here = [tmp_path / f"here-{k}" for k in range(6)]
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
    with open_store(tmp_path / "store").alone("0" * 64, lambda text: None):
        assert time.monotonic() - began < 5.0


def test_stage_is_computed_where_nothing_can_be_locked(tmp_path):
    (tmp_path / "store").write_text("a file, no folder")
    with open_store(tmp_path / "store").alone("0" * 64, lambda text: None):
        pass
    with open_store(tmp_path / "new").alone("0" * 64, lambda text: None):
        assert (tmp_path / "new").is_dir()
    assert not (tmp_path / "new").exists()  # nothing was kept in it


# Long options of sbatch(1) and the form of their values.
MEMORY = r"[1-9]\d*[KMGT]?"
OPTIONS = {
    "job-name": r"[\w.-]+",
    "ntasks": r"[1-9]\d*",
    "cpus-per-task": r"[1-9]\d*",
    "mem-per-cpu": MEMORY,
    "time": r"(\d+-)?\d\d?:\d\d:\d\d",
    "output": r'[^\s"]+|"[^"]+"',
    "open-mode": r"append|truncate",
    "requeue": None,
    "signal": r"([RB]+:)?(\d+|[A-Z][A-Z0-9]+)(@\d{1,5})?",
}


def header_problems(text):
    """What sbatch would refuse or pass over in the head of a script."""
    lines = text.splitlines()
    found = [] if lines[0].startswith("#!") else ["no interpreter in the first line"]
    seen = set()
    begun = False
    for line in lines[1:]:
        if not line.startswith("#SBATCH"):
            begun = begun or bool(line.strip() and not line.startswith("#"))
            continue
        if begun:
            found.append(f"behind the first command: {line}")
        match = re.fullmatch(r"#SBATCH --([a-z-]+)(?:=(.+))?", line)
        if match is None or match[1] not in OPTIONS:
            found.append(f"unknown: {line}")
            continue
        form = OPTIONS[match[1]]
        if (form is None) != (match[2] is None) or (form and not re.fullmatch(form, match[2])):
            found.append(f"value: {line}")
        if match[1] in seen:
            found.append(f"twice: {line}")
        seen.add(match[1])
    return found + [f"missing: {name}" for name in ("ntasks", "time") if name not in seen]


COMMAND = ("solidwhirl", "batch", "/data/a scene.toml", "--out", "/data/it's", "--resume")


@pytest.mark.parametrize("ranks", [None, 12])
@pytest.mark.parametrize("seconds", [0.4, 5000.0, 3e6])
def test_slurm_script_is_one(tmp_path, seconds, ranks):
    costs = {n: Predicted(seconds=seconds, peak_memory_gib=6.0) for n in range(40)}
    job = slurm_job(
        costs, command=COMMAND, out=tmp_path / "my sweep %1", ranks_per_scene=4, ranks=ranks
    )
    path = write_slurm_script(job, tmp_path / "job.sh")
    text = path.read_text(encoding="utf-8")
    assert header_problems(text) == []
    done = subprocess.run(["bash", "-n", path], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert "%%1" in text
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
        costs = {0: Predicted(seconds=1.0, peak_memory_gib=1.0)}
        text = slurm_script(
            slurm_job(costs, command=COMMAND, out=tmp_path / "o", ranks_per_scene=1, ranks=None)
        )
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


@pytest.mark.parametrize("status", [0, 1, 3, 143])
def test_slurm_script_runs_the_command_and_ends_as_it_does(tmp_path, started, status):
    job = started(f"exit {status}")
    _, said = job.communicate(timeout=60.0)
    assert (job.returncode, said) == (status, "")
    assert tuple(words_of(tmp_path)[1:]) == COMMAND
    # nobody asked it to end: once more would come to the same
    assert not (tmp_path / "requeued").exists()


# Ends as mpirun does when it is asked to, after a while and with 1; else never.
_ASKED = "trap 'sleep 0.2; exit 1' TERM; while :; do sleep 0.05; done"


@pytest.mark.parametrize(("launch", "first"), [("srun", "--kill"), ("mpirun", "-n")])
def test_job_at_its_time_limit_ends_in_order_and_goes_on(tmp_path, started, launch, first):
    job = started(_ASKED, launch)
    assert words_of(tmp_path)[0].startswith(first)
    time.sleep(0.2)  # the stand-in has come to its trap
    job.send_signal(signal.SIGUSR1)  # Slurm, as --signal=B:USR1 asks it to
    _, said = job.communicate(timeout=60.0)
    assert (job.returncode, said) == (1, "")
    assert (tmp_path / "requeued").read_text(encoding="utf-8") == "requeue 7\n"


def test_job_that_ends_well_before_its_limit_is_not_started_again(tmp_path, started):
    job = started("trap 'exit 0' TERM; while :; do sleep 0.05; done")
    words_of(tmp_path)
    time.sleep(0.2)
    job.send_signal(signal.SIGUSR1)
    job.communicate(timeout=60.0)
    assert job.returncode == 0
    assert not (tmp_path / "requeued").exists()


def test_job_is_started_again_so_often_and_no_more(tmp_path, started):
    job = started(_ASKED, SLURM_RESTART_COUNT="50")
    words_of(tmp_path)
    time.sleep(0.2)
    job.send_signal(signal.SIGUSR1)
    job.communicate(timeout=60.0)
    assert job.returncode == 1
    assert not (tmp_path / "requeued").exists()


def test_cancelled_job_ends_in_order_and_stays_cancelled(tmp_path, started):
    job = started(_ASKED, "mpirun")
    words_of(tmp_path)
    time.sleep(0.2)
    job.send_signal(signal.SIGTERM)
    job.communicate(timeout=60.0)
    assert job.returncode == 1
    assert not (tmp_path / "requeued").exists()


@pytest.mark.skipif(shutil.which("shellcheck") is None, reason="no shellcheck")
def test_shellcheck_finds_nothing_in_the_slurm_script(tmp_path):
    costs = {0: Predicted(seconds=1.0, peak_memory_gib=1.0)}
    job = slurm_job(costs, command=COMMAND, out=tmp_path / "o", ranks_per_scene=1, ranks=None)
    script = write_slurm_script(job, tmp_path / "job.sh")
    done = subprocess.run(["shellcheck", script], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "")


def test_slurm_asks_for_no_team_that_only_waits():
    # one case of an hour and a half, and many of a second: two teams are done when it is
    costs = {n: Predicted(seconds=1.0, peak_memory_gib=1.0) for n in range(1000)}
    costs[1000] = Predicted(seconds=5400.0, peak_memory_gib=1.0)
    job = slurm_job(costs, command=COMMAND, out=Path("o"), ranks_per_scene=1, ranks=None)
    assert job.ranks == 2


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


@pytest.mark.parametrize(
    ("seconds", "said"), [(0.04, "0.0 s"), (9.96, "10 s"), (99.6, "2 min"), (7200.0, "2.0 h")]
)
def test_durations(seconds, said):
    assert duration_text(seconds) == said
