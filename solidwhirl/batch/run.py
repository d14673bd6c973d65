"""Cases of a batch on executors: the largest first, as many at once as memory allows."""

from __future__ import annotations

import _thread
import platform
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from solidwhirl.batch.case import ERROR_FILE, CaseSettings, run_alone
from solidwhirl.batch.journal import (
    BatchTableError,
    Journal,
    open_journal,
    salvaged_rows,
)
from solidwhirl.batch.schedule import Memory, Predicted, TimeToGo, largest_first, predicted_cost
from solidwhirl.batch.table import TABLE, read_batch, write_table
from solidwhirl.core.errors import OutputError
from solidwhirl.core.machine import available_memory_gib
from solidwhirl.cost.machine import Machine, this_machine
from solidwhirl.files.run_folder import JOURNAL, MANIFEST, claimed, holder_of, verify_folder
from solidwhirl.pipeline.cached_stages import open_store
from solidwhirl.sweep.cases import batch_cases, case_scene
from solidwhirl.sweep.records import BatchCase, BatchRow

# Rows of cases that end together with the batch are waited for so long: mpirun kills after 1 s [s].
_LAST_ROWS_S = 0.4
# The thread that waits for the others looks so often whether it was asked to end [s].
_LOOK_S = 0.05
_REFUSED = Predicted(seconds=0.0, peak_memory_gib=0.0)
Task = Callable[[BatchCase, CaseSettings], BatchRow]
Keep = Callable[[BatchRow, float], None]


@dataclass(frozen=True, kw_only=True)
class Place:
    """Workers of one executor on the same nodes."""

    # Takes the cases; None: the thread that runs the batch computes them itself
    executor: Executor | None
    workers: int  # cases that it computes at once
    shares: Mapping[str, float]  # part of the memory of a case by node; the parts add up to 1
    task: Task = run_alone  # what a worker does with a case


@dataclass(frozen=True, kw_only=True)
class Work:
    """What a batch computes."""

    cases: tuple[BatchCase, ...]
    todo: tuple[int, ...]  # indices of those that have no good row
    last: tuple[int, ...] = ()  # of these, those that failed before
    rows: tuple[BatchRow, ...] = ()  # rows that stay in the journal
    settings: CaseSettings  # what the cases have in common


def run_batch(
    scenes: Sequence[str | Path],
    settings: CaseSettings,
    *,
    executor: Executor | None = None,
    workers: int = 1,
    memory_gib: float | None = None,
    resume: bool = False,
) -> tuple[BatchRow, ...]:
    """Run all cases of scenes on an executor, and write their folders, the journal and the table.

    Parameters
    ----------
    scenes
        Scene files, with `[sweep]` or without.
    settings
        Folder of the batch and what all cases have in common.
    executor
        Any of `concurrent.futures`: a process pool (start method "spawn": MPI survives no fork),
        Dask's, Parsl's, mpi4py's. Its workers see the same files. None: this process.
    workers
        Cases that the executor computes at once.
    memory_gib
        What the workers share; cases wait that do not fit beside those that run. None: what this
        machine has free; infinite where every worker has enough.
    resume
        Keep the rows whose case is the same and whose folder is whole.

    Returns
    -------
    All rows, by scene and number of the case.

    Raises
    ------
    SceneError
        Scene files that make no batch.
    OutputError
        The folder can't be written, or another batch is writing it.
    """
    cases = batch_cases(scenes, level=settings.level, accuracy=settings.accuracy)
    with claimed(settings.out):
        work = work_of(cases, settings, resume=resume)
        free = available_memory_gib() if memory_gib is None else memory_gib
        place = Place(executor=executor, workers=workers, shares={platform.node(): 1.0})
        with journal_of(work) as journal:
            costs = predicted_costs(work, work.todo, this_machine())
            nodes = {platform.node(): free}
            Dispatch(work, costs, (place,), nodes, lambda row, to_go_s: journal.append(row)).run()
        return read_batch(settings.out)


def work_of(cases: tuple[BatchCase, ...], settings: CaseSettings, *, resume: bool) -> Work:
    """Return what is to be done in the folder of a batch.

    Raises OutputError: the folder has files of somebody else's, or a run is writing the folder of a
    case.
    """
    out = settings.out
    _refuse_others(cases, out)
    with suppress(OSError):  # without the store nothing is kept
        settings.stages.mkdir(parents=True, exist_ok=True)
    open_store(settings.stages).clear_leftovers()
    rows: tuple[BatchRow, ...] = ()
    if resume and (out / JOURNAL).exists():
        try:
            rows, damaged = salvaged_rows(out)
        except BatchTableError as error:
            raise OutputError(f"{error}; remove it to begin again") from error
        for line in damaged:
            sys.stderr.write(f"warning: {line}; the case of this line is computed again\n")
    kept = kept_cases(cases, rows, lambda name: not verify_folder(out / name))
    digests = {case.name: case.digest for case in cases}
    failed = {
        row.case for row in rows if row.status == "failed" and digests.get(row.case) == row.digest
    }
    todo = tuple(n for n in range(len(cases)) if n not in kept)
    ended = {case.name for case in cases if resume and (out / case.name / ERROR_FILE).exists()}
    stay = {cases[n].name for n in kept} | failed
    return Work(
        cases=cases,
        todo=todo,
        last=tuple(n for n in todo if cases[n].name in failed | ended),
        rows=tuple(row for row in rows if row.case in stay),
        settings=settings,
    )


def _refuse_others(cases: Sequence[BatchCase], out: Path) -> None:
    if (out / MANIFEST).exists():
        raise OutputError(f"{out}: is the folder of a run; choose another one for a batch")
    for path in (out / JOURNAL, out / TABLE):
        if (path.exists() or path.is_symlink()) and not _is_of_a_batch(out):
            said = "is there already and no batch wrote it; move it away or choose another folder"
            raise OutputError(f"{path}: {said}")
    for case in cases:
        holder = holder_of(out / case.name)
        if holder:
            raise OutputError(f"{out / case.name}: another run is writing here ({holder})")


def _is_of_a_batch(out: Path) -> bool:
    """Whether a journal is there that has a row, or nothing as yet but perhaps half of one."""
    try:
        rows, _ = salvaged_rows(out)
    except BatchTableError:
        return False
    return bool(rows) or (out / JOURNAL).read_bytes()[:1] in (b"", b"{")


def kept_cases(
    cases: Sequence[BatchCase], rows: Sequence[BatchRow], complete: Callable[[str], bool]
) -> frozenset[int]:
    """Return the indices of cases whose row is that of what is asked, in a complete folder."""
    found = {row.case: row for row in rows if row.status != "failed"}
    return frozenset(
        n
        for n, case in enumerate(cases)
        if case.name in found and found[case.name].digest == case.digest and complete(case.name)
    )


@contextmanager
def journal_of(work: Work) -> Iterator[Journal]:
    """Open the journal with the rows that stay; the table is made from it, however this ends."""
    out = work.settings.out
    with open_journal(out, work.rows) as journal:
        try:
            yield journal
        except BaseException:
            with suppress(Exception):  # what ended the block is what is told
                write_table(out)
            raise
        write_table(out)


def predicted_costs(work: Work, numbers: Sequence[int], machine: Machine) -> dict[int, Predicted]:
    """Predict the cost of some cases, by their index; no time for those that a run refuses."""
    settings, found = work.settings, {}
    for n in numbers:
        try:
            scene = case_scene(work.cases[n], level=settings.level, accuracy=settings.accuracy)
            found[n] = predicted_cost(scene, machine)
        except Exception:  # whatever it is, the case tells it when its turn comes
            found[n] = _REFUSED
    return found


class Dispatch:
    """Cases that are left and those that run; called by several threads.

    `costs`: what cases are predicted to cost. `places`: where they are computed. `free_gib`: free
    memory by node; a case waits until it fits beside those that run. `keep`: writes a row down,
    with the time to go [s]; called by one thread at a time.
    """

    def __init__(
        self,
        work: Work,
        costs: Mapping[int, Predicted],
        places: Sequence[Place],
        free_gib: Mapping[str, float],
        keep: Keep,
    ) -> None:
        self._work, self._places, self._keep = work, tuple(places), keep
        available = available_memory_gib()
        # what is refused for its size takes no time
        seconds = {n: c.seconds * (c.least_memory_gib <= available) for n, c in costs.items()}
        self._left = deque(largest_first(seconds, work.todo, work.last))
        self._to_go = TimeToGo(seconds, sum(place.workers for place in places))
        needs = {n: cost.peak_memory_gib for n, cost in costs.items()}
        shares = [place.shares for place in places]
        self._memory = Memory(free_gib=free_gib, places=shares, needs_gib=needs)
        self._running: dict[int, tuple[Place, float]] = {}
        self._changed = threading.Condition()
        self._submitting = False
        self._error: BaseException | None = None

    def run(self) -> None:
        """Compute all cases: the most expensive first, those that failed before last.

        The calling thread computes those of the place without an executor. Raises what `keep`
        raised, or an executor that broke; the cases running then are finished first.
        """
        try:
            self._run()
        except KeyboardInterrupt as error:
            self._end(error)
            raise

    def _run(self) -> None:
        self._submit()
        for own in (place for place in self._places if place.executor is None):
            while (number := self._next(own)) is not None:
                self._put(number, own.task(self._work.cases[number], self._work.settings))
                self._submit()
        with self._changed:
            while self._running:
                self._changed.wait(_LOOK_S)
        if self._error is not None:
            raise self._error

    def _end(self, error: BaseException) -> None:
        """Begin nothing more, and take the rows that come within a moment."""
        with self._changed:
            self._left.clear()
        until = time.monotonic() + _LAST_ROWS_S
        while self._running and time.monotonic() < until:
            time.sleep(0.005)
        with self._changed:
            self._error = error

    def _take(self, place: Place) -> int | None:
        """The next case that a place may begin, None if there is none now."""
        busy = sum(other is place for other, _ in self._running.values())
        if self._error is not None or busy >= place.workers:
            return None
        running = {n: at.shares for n, (at, _) in self._running.items()}
        for number in self._left:
            if self._memory.allows(number, place.shares, running):
                self._left.remove(number)
                self._running[number] = (place, time.monotonic())
                return number
        return None

    def _next(self, place: Place) -> int | None:
        """Wait for a case of the calling thread; None if none is left."""
        with self._changed:
            while self._left and self._error is None:
                number = self._take(place)
                if number is not None:
                    return number
                self._changed.wait(_LOOK_S)
        return None

    def _submit(self) -> None:
        """Give the executors what they may begin; a row that is there at once comes here again."""
        with self._changed:
            if self._submitting:
                return
            self._submitting = True
            try:
                for place in self._places:
                    if place.executor is not None:
                        self._fill(place, place.executor)
            finally:
                self._submitting = False

    def _fill(self, place: Place, executor: Executor) -> None:
        while (number := self._take(place)) is not None:
            case = self._work.cases[number]
            try:
                future = executor.submit(place.task, case, self._work.settings)
            except Exception as error:
                self._fail(number, error)
                return
            future.add_done_callback(partial(self._ended, number))

    def _ended(self, number: int, future: Future[BatchRow]) -> None:
        """In a thread of the executor.

        One step for whoever waits: between a case that has ended and the next there is no moment
        without any, which would be taken for the end.
        """
        with self._changed:
            try:
                self._put(number, future.result())
            except KeyboardInterrupt:  # a worker was asked to end: all are, if they are not already
                self._fail(number, None)
                _thread.interrupt_main(signal.SIGTERM)
            except BaseException as error:
                self._fail(number, error)
            self._submit()

    def _fail(self, number: int, error: BaseException | None) -> None:
        """Begin nothing more, as an executor broke or rows can't be written."""
        with self._changed:
            self._running.pop(number, None)
            self._error = self._error or error
            self._changed.notify_all()

    def _put(self, number: int, row: BatchRow) -> None:
        """Write a row down; where that fails, nothing more is begun."""
        with self._changed:
            self._running.pop(number, None)
            self._to_go.finished(number, None if row.status == "failed" else row.seconds)
            now = time.monotonic()
            begun = {n: now - start for n, (_, start) in self._running.items()}
            left_s = self._to_go.seconds(begun)
            if self._error is None:
                try:
                    self._keep(row, left_s)
                except KeyboardInterrupt:
                    self._keep(row, left_s)  # a row that was interrupted is not written yet
                    raise
                except Exception as error:
                    self._error = error
            self._changed.notify_all()
