"""The command `batch`: many scenes, or the cases of a sweep, on all ranks of a job."""

from __future__ import annotations

import contextlib
import json
import os
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import typer
from rich.console import Console

from solidwhirl.batch import Work, kept_cases, layout_of, predicted_costs, run_batch
from solidwhirl.batch_case import CaseSettings
from solidwhirl.batch_journal import (
    JOURNAL,
    BatchTableError,
    open_journal,
    row_document,
    salvaged_journal,
)
from solidwhirl.batch_pictures import draw_at_end, operating_words, picture_settings
from solidwhirl.batch_progress import BatchProgress, failure_line
from solidwhirl.batch_schedule import Layout, Predicted
from solidwhirl.batch_slurm import slurm_job, write_slurm_script
from solidwhirl.batch_table import TABLE, write_table
from solidwhirl.errors import OutputError
from solidwhirl.machine import available_memory_gib
from solidwhirl.rotordyn.atomic import replacing
from solidwhirl.run_folder import STAGES, claimed, holder_of, verify_folder
from solidwhirl.store_stages import open_store
from solidwhirl.sweep import batch_cases
from solidwhirl.sweep_records import BatchCase, BatchRow
from solidwhirl.terminal import duration_text

#: Exit codes: a case failed; all came out, but an invariant of one is violated.
FAILED, CHECKS_FAILED = 1, 3


def batch_command(
    scenes: Sequence[Path],
    out: Path,
    *,
    ranks_per_scene: int = 1,
    resume: bool = False,
    store: Path | None = None,
    level: str | None = None,
    accuracy: float | None = None,
    slurm: Path | None = None,
    quiet: bool = False,
    pictures: bool = True,
    operating_rpm: tuple[float, float] | None = None,
) -> int:
    """Run all cases of scenes on the ranks of the job; every rank calls this.

    Parameters
    ----------
    scenes
        Scene files, with `[sweep]` or without.
    out
        Folder of the batch: a folder for each case, the journal and the table.
    ranks_per_scene
        Ranks that compute a case together.
    resume
        Keep the rows whose case is the same and whose folder is whole.
    store
        Folder of the stages of all cases; None: `.stages` in `out`.
    level, accuracy
        Instead of those of the scenes.
    slurm
        Write a Slurm script to this file and run nothing.
    quiet
        Say nothing but errors.
    pictures
        Whether to draw.
    operating_rpm
        Operating speeds of the reference shaft, for the pictures of sweeps.

    Returns
    -------
    Exit code, on rank 0; 0 on the others: 0 if all cases are done, 1 if one failed, 3 if one
    violates an invariant.

    Raises
    ------
    SceneError
        Scene files or options that make no batch.
    OutputError
        The folder can't be written, or another batch is writing it.
    """
    from mpi4py import MPI

    world = MPI.COMM_WORLD
    settings = CaseSettings(
        out=out, store=store or out / STAGES, level=level, accuracy=accuracy, pictures=pictures
    )
    if world.rank == 0:
        picture_settings(operating_rpm)  # refused now, not after the cases
    if slurm is not None:
        words = operating_words(operating_rpm)
        return _script(scenes, settings, ranks_per_scene, store, slurm, world, quiet, words)
    layout = layout_of(world, ranks_per_scene)
    console = Console(stderr=True, quiet=quiet)
    with contextlib.ExitStack() as held:
        if world.rank == 0:  # what is refused here ends the other ranks, which wait for it
            cases = batch_cases(scenes, level=level, accuracy=accuracy)
            held.enter_context(claimed(out))
            work, rows = _work(cases, settings, resume)
            world.bcast(work)
        else:
            work, rows = world.bcast(None), ()
        costs = predicted_costs(work, world)
        if world.rank != 0:
            run_batch(work, costs, layout, world, lambda row, to_go_s: None)
            return 0
        code = _coordinated(work, costs, layout, world, rows, console)
        if pictures:
            draw_at_end(out, operating_rpm, console)
        return code


def _work(
    cases: tuple[BatchCase, ...], settings: CaseSettings, resume: bool
) -> tuple[Work, tuple[BatchRow, ...]]:
    """What is to be done, and the rows that stay in the journal."""
    out = settings.out
    _refuse_others(cases, out)
    _refuse_store(settings.store)
    rows: tuple[BatchRow, ...] = ()
    if resume and (out / JOURNAL).exists():
        try:
            rows, damaged = salvaged_journal(out)
        except BatchTableError as error:
            raise OutputError(f"{error}; remove it to begin again") from error
        for line in damaged:
            typer.echo(f"warning: {line}; the case of this line is computed again", err=True)
    kept = kept_cases(cases, rows, lambda name: not verify_folder(out / name))
    digests = {case.name: case.digest for case in cases}
    failed = {
        row.case for row in rows if row.status == "failed" and digests.get(row.case) == row.digest
    }
    todo = tuple(n for n in range(len(cases)) if n not in kept)
    last = tuple(n for n in todo if cases[n].name in failed)
    stay = {cases[n].name for n in kept} | failed
    return (
        Work(cases=cases, todo=todo, last=last, settings=settings),
        tuple(row for row in rows if row.case in stay),
    )


def _refuse_others(cases: Sequence[BatchCase], out: Path) -> None:
    """Refuse a folder with files of somebody else's, or where a run is writing that of a case."""
    for name in (JOURNAL, TABLE):
        path = out / name
        if os.path.lexists(path) and not _is_of_a_batch(out):
            raise OutputError(
                f"{path}: is there already and no batch wrote it; move it away or choose another "
                "folder"
            )
    for case in cases:
        holder = holder_of(out / case.name)
        if holder:
            raise OutputError(f"{out / case.name}: another run is writing here ({holder})")


def _is_of_a_batch(out: Path) -> bool:
    """Whether a journal is there that has a row, or nothing as yet but perhaps half of one."""
    try:
        rows, _ = salvaged_journal(out)
    except BatchTableError:
        return False
    return bool(rows) or (out / JOURNAL).read_bytes()[:1] in (b"", b"{")


def _refuse_store(store: Path) -> None:
    """Make the folder of the stages, once for all ranks; without it nothing is kept."""
    with contextlib.suppress(OSError):
        store.mkdir(parents=True, exist_ok=True)
    open_store(store).clear_leftovers()


def _coordinated(
    work: Work,
    costs: dict[int, Predicted],
    layout: Layout,
    world: Any,
    rows: tuple[BatchRow, ...],
    console: Console,
) -> int:
    """Rank 0: journal, table and what is said."""
    out = work.settings.out
    _begin_journal(out, rows)
    progress = BatchProgress(console, len(work.cases), len(work.cases) - len(work.todo))
    with open_journal(out) as journal, _closing(progress), _table_after(out):
        progress.say(_first_line(work, costs, layout))

        def keep(row: BatchRow, to_go_s: float) -> None:
            journal.append(row)
            progress.finished(row, to_go_s)

        run_batch(work, costs, layout, world, keep)
        found = journal.rows
    if console.quiet:  # what failed is said even so
        for row in found:
            if row.status != "done":
                typer.echo(failure_line(row), err=True)
    by_status = {s: sum(row.status == s for row in found) for s in ("failed", "checks_failed")}
    console.print(
        f"{len(found)} rows, {by_status['failed']} failed, {by_status['checks_failed']} with "
        f"failed checks: {out / TABLE}",
        highlight=False,
        soft_wrap=True,
    )
    return FAILED if by_status["failed"] else CHECKS_FAILED if by_status["checks_failed"] else 0


def _begin_journal(out: Path, rows: tuple[BatchRow, ...]) -> None:
    """A journal of the rows that are kept, in place of the one that is there."""
    lines = [json.dumps(row_document(row), allow_nan=False) + "\n" for row in rows]
    try:
        with replacing(out / JOURNAL) as temporary:
            temporary.write_text("".join(lines), encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{out}: can not be written: {error.strerror or error}") from error


@contextlib.contextmanager
def _closing(progress: BatchProgress) -> Iterator[None]:
    try:
        yield
    finally:
        progress.close()


@contextlib.contextmanager
def _table_after(out: Path) -> Iterator[None]:
    """Make the table from the rows that are there, however the block ends."""
    try:
        yield
    except BaseException:
        with contextlib.suppress(Exception):  # what ended the block is what is told
            write_table(out)
        raise
    write_table(out)


def _first_line(work: Work, costs: dict[int, Predicted], layout: Layout) -> str:
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


def _script(
    scenes: Sequence[Path],
    settings: CaseSettings,
    ranks_per_scene: int,
    store: Path | None,
    path: Path,
    world: Any,
    quiet: bool,
    words: list[str],
) -> int:
    """Write the Slurm script of a batch."""
    cases: Any = None
    if world.rank == 0:
        cases = batch_cases(scenes, level=settings.level, accuracy=settings.accuracy)
    cases = world.bcast(cases)
    work = Work(cases=cases, todo=tuple(range(len(cases))), last=(), settings=settings)
    costs = predicted_costs(work, world)
    if world.rank != 0:
        return 0
    command = [*_command(scenes, settings, ranks_per_scene, store, quiet), *words]
    ranks = world.size if world.size > 1 else None
    job = slurm_job(
        costs,
        command=command,
        out=settings.out,
        ranks_per_scene=ranks_per_scene,
        ranks=ranks,
    )
    try:
        write_slurm_script(job, path)
    except OSError as error:
        raise OutputError(f"{path}: can not be written: {error.strerror or error}") from error
    if not quiet:
        sys.stderr.write(
            f"script: {path}: {len(cases)} cases, {job.ranks} ranks of {job.memory_mib} MiB, "
            f"{job.minutes} min; start it with sbatch {path}\n"
        )
    return 0


def _command(
    scenes: Sequence[Path],
    settings: CaseSettings,
    ranks_per_scene: int,
    store: Path | None,
    quiet: bool,
) -> list[str]:
    """The same command for a job: it goes on where an earlier one stopped."""
    words = ["solidwhirl", "batch", *(str(scene.absolute()) for scene in scenes)]
    words += ["--out", str(settings.out.absolute()), "--ranks-per-scene", str(ranks_per_scene)]
    words += ["--resume"]
    words += ["--store", str(store.absolute())] if store is not None else []
    words += ["--level", settings.level] if settings.level is not None else []
    words += ["--accuracy", repr(settings.accuracy)] if settings.accuracy is not None else []
    words += [] if settings.pictures else ["--no-pictures"]
    return words + (["--quiet"] if quiet else [])
