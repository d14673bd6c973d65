"""The command `batch`: many scenes, or the cases of a sweep, on all ranks of a job."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn

from solidwhirl.batch.case import CaseSettings
from solidwhirl.batch.pictures import draw_at_end, picture_settings
from solidwhirl.batch.ranks import costs_on_ranks, layout_of, run_on_ranks
from solidwhirl.batch.run import Work, journal_of, work_of
from solidwhirl.batch.schedule import Layout, Predicted
from solidwhirl.batch.slurm import slurm_job, write_slurm_script
from solidwhirl.batch.table import TABLE
from solidwhirl.console.terminal import duration_text, say
from solidwhirl.core.machine import available_memory_gib
from solidwhirl.files.run_folder import claimed
from solidwhirl.sweep.cases import batch_cases
from solidwhirl.sweep.records import BatchRow, distinct_warnings

#: Exit codes: a case failed; all came out, but an invariant of one is violated.
FAILED, CHECKS_FAILED = 1, 3
_WORDS = {"done": "done", "failed": "FAILED", "checks_failed": "CHECKS FAILED"}


def batch_command(
    scenes: Sequence[Path],
    settings: CaseSettings,
    *,
    ranks_per_scene: int = 1,
    resume: bool = False,
    slurm: Path | None = None,
    quiet: bool = False,
    operating_rpm: tuple[float, float] | None = None,
) -> int:
    """Run all cases of scenes on the ranks of the job; every rank calls this.

    `ranks_per_scene`: size of a team. `slurm`: write a Slurm script to this file and run nothing.
    `quiet`: say nothing but errors and warnings. `operating_rpm`: operating speeds of the reference
    shaft, in pictures.
    Returns rank 0's exit code: 0 all cases are done, 1 one failed, 3 one violates an invariant.
    Raises SceneError, OutputError: as `run_batch`, and for options that make no batch.
    """
    from mpi4py import MPI

    world = MPI.COMM_WORLD
    if world.rank == 0:
        picture_settings(operating_rpm)  # refused now, not after the cases
    if slurm is not None:
        words = _options(settings, ranks_per_scene, quiet, operating_rpm)
        return _write_script(scenes, settings, ranks_per_scene, words, slurm, world)
    layout = layout_of(world, ranks_per_scene)
    work: Any = None
    with contextlib.ExitStack() as held:
        if world.rank == 0:  # what is refused here ends the other ranks, which wait for it
            cases = batch_cases(scenes, level=settings.level, accuracy=settings.accuracy)
            held.enter_context(claimed(settings.out))
            work = work_of(cases, settings, resume=resume)
        work = world.bcast(work)
        costs = costs_on_ranks(work, world)
        if world.rank != 0:
            run_on_ranks(work, costs, layout, world, lambda row, to_go_s: None)
            return 0
        console = Console(stderr=True, quiet=quiet)
        found = _coordinated(work, costs, layout, world, console)
        if settings.pictures:
            draw_at_end(settings.out, operating_rpm, console)
    return FAILED if found["failed"] else CHECKS_FAILED if found["checks_failed"] else 0


def _coordinated(
    work: Work, costs: Mapping[int, Predicted], layout: Layout, world: Any, console: Console
) -> dict[str, int]:
    """Rank 0: journal, table and what is said; returns how many rows are not done, by status."""
    with (
        journal_of(work) as journal,
        contextlib.closing(
            BatchProgress(console, len(work.cases), len(work.cases) - len(work.todo))
        ) as progress,
    ):
        say(console, _first_line(work, costs, layout))

        def keep(row: BatchRow, to_go_s: float) -> None:
            journal.append(row)
            progress.finished(row, to_go_s)

        run_on_ranks(work, costs, layout, world, keep)
        found = journal.rows
    if console.quiet:  # what failed is said even so
        for row in found:
            if row.status != "done":
                typer.echo(failure_line(row), err=True)
    for text in distinct_warnings(found):
        typer.secho(f"warning: {text}", fg="yellow", err=True)
    by_status = {s: sum(row.status == s for row in found) for s in ("failed", "checks_failed")}
    failed, bad = by_status.values()
    table = work.settings.out / TABLE
    if not console.quiet:
        typer.echo(f"{len(found)} rows, {failed} failed, {bad} with failed checks: {table}")
    return by_status


def failure_line(row: BatchRow) -> str:
    """How a case ended, in one line."""
    first = f": {row.message.splitlines()[0]}" if row.message else ""
    return f"{row.case} {_WORDS[row.status]} in {duration_text(row.seconds)}{first}"


class BatchProgress:
    """Lines and bar of a batch, on the rank that coordinates."""

    def __init__(self, console: Console, total: int, kept: int) -> None:
        self._console, self._total, self._done = console, total, kept
        self._bar: Progress | None = None
        self._task = TaskID(0)
        if console.is_terminal and not console.quiet:
            self._bar = Progress(
                TextColumn("{task.description}"),
                BarColumn(),
                MofNCompleteColumn(),
                TextColumn("{task.fields[left]}"),
                console=console,
                transient=True,
            )
            self._task = self._bar.add_task("cases", total=total, completed=kept, left="")
            self._bar.start()

    def finished(self, row: BatchRow, to_go_s: float) -> None:
        """Tell that a case is over."""
        self._done += 1
        left = self._total - self._done
        to_go = f"about {duration_text(to_go_s)} to go" if left else "all cases done"
        line = failure_line(row)
        if self._bar is None:
            say(self._console, f"[{self._done}/{self._total}] {line}; {to_go}")
            return
        if row.status != "done":
            say(self._console, line)
        self._bar.update(self._task, completed=self._done, left=to_go)

    def close(self) -> None:
        """Remove the bar."""
        if self._bar is not None:
            self._bar.stop()


def _first_line(work: Work, costs: Mapping[int, Predicted], layout: Layout) -> str:
    kept = len(work.cases) - len(work.todo)
    available = available_memory_gib()
    total = sum(c.seconds for c in costs.values() if c.least_memory_gib <= available)
    ranks = "rank" if layout.ranks_per_team == 1 else "ranks"
    teams = "team" if layout.teams == 1 else "teams"
    parts = [
        f"{len(work.todo)} cases to compute",
        f"{kept} kept" if kept else "",
        f"{layout.teams} {teams} of {layout.ranks_per_team} {ranks}",
        "rank 0 only gives them out" if layout.first else "",
        f"{layout.idle} ranks idle" if layout.idle else "",
        f"about {duration_text(total / layout.teams)}",
    ]
    return ", ".join(part for part in parts if part)


def _options(
    settings: CaseSettings,
    ranks_per_scene: int,
    quiet: bool,
    operating_rpm: tuple[float, float] | None,
) -> list[str]:
    """The options of a job: it goes on where an earlier one stopped."""
    words = ["--ranks-per-scene", str(ranks_per_scene), "--resume"]
    named = {
        "--store": settings.store and settings.store.absolute(),
        "--level": settings.level,
        "--accuracy": settings.accuracy,
    }
    for name, value in named.items():
        words += [] if value is None else [name, str(value)]
    words += ["--no-pictures"] * (not settings.pictures) + ["--quiet"] * quiet
    if operating_rpm is not None:
        words += ["--operating-rpm", *(repr(float(speed)) for speed in operating_rpm)]
    return words


def _write_script(
    scenes: Sequence[Path],
    settings: CaseSettings,
    ranks_per_scene: int,
    words: list[str],
    path: Path,
    world: Any,
) -> int:
    """Write the Slurm script of a batch; the same command there goes on where one stopped."""
    cases: Any = None
    if world.rank == 0:
        cases = batch_cases(scenes, level=settings.level, accuracy=settings.accuracy)
    cases = world.bcast(cases)
    work = Work(cases=cases, todo=tuple(range(len(cases))), settings=settings)
    costs = costs_on_ranks(work, world)
    if world.rank != 0:
        return 0
    files = [str(scene.absolute()) for scene in scenes]
    job = slurm_job(
        costs,
        command=["solidwhirl", "batch", *files, "--out", str(settings.out.absolute()), *words],
        out=settings.out,
        ranks_per_scene=ranks_per_scene,
        ranks=world.size if world.size > 1 else None,
    )
    write_slurm_script(job, path)
    if "--quiet" not in words:
        typer.echo(
            f"script: {path}: {len(cases)} cases, {job.ranks} ranks of {job.memory_mib} MiB, "
            f"{job.minutes} min; start it with sbatch {path}"
        )
    return 0
