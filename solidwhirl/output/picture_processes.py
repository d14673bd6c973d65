"""Pictures drawn in processes of their own, several at a time.

The processes are new ones, not copies of this one, which may hold MPI and solvers. Each is given
what a picture shows, never the run.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from functools import partial
from multiprocessing.reduction import ForkingPickler
from pathlib import Path

from solidwhirl.core.machine import available_memory_gib
from solidwhirl.core.outcome import Drawing, Write
from solidwhirl.core.picture_worker import draw, follow_parent
from solidwhirl.pipeline.cached_stages import KeptPicture

#: Makes of what writes some files what does so, in whatever order they are asked for.
Begin = Callable[[Mapping[Path, Write]], AbstractContextManager[Mapping[Path, Write]]]

# A process takes about this much, and as long to start as two pictures to be drawn.
_PROCESS_GIB, _PICTURES = 0.5, 2


@contextmanager
def in_turn(pictures: Mapping[Path, Write]) -> Iterator[Mapping[Path, Write]]:
    """Let each picture be drawn in this process when it is asked for."""
    yield pictures


@contextmanager
def in_processes(pictures: Mapping[Path, Write]) -> Iterator[Mapping[Path, Write]]:
    """Begin to draw pictures in as many processes as cores and memory allow.

    Few pictures, those that are kept already, and those that another process can't be given are
    drawn in this one. Yields what waits for each picture, and raises what drawing it raised.
    """
    missing = [path for path, write in pictures.items() if not _is_kept(write, path)]
    workers = _workers(len(missing))
    if workers < 2:
        yield pictures
        return
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, mp_context=context, initializer=follow_parent)
    try:
        yield {path: _begun(pool, write, path) for path, write in pictures.items()}
    finally:
        pool.shutdown(cancel_futures=True)


def _workers(pictures: int) -> int:
    """How many processes so many pictures are worth."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return min(cores or 1, pictures // _PICTURES, int(available_memory_gib() / _PROCESS_GIB))


def _is_kept(write: Write, path: Path) -> bool:
    if not isinstance(write, KeptPicture):
        return False
    return write.find(path) is not None or _is_kept(write.draw, path)


def _begun(pool: ProcessPoolExecutor, write: Write, path: Path) -> Write:
    """What waits for a picture that a process draws, or the picture as it was."""
    if isinstance(write, KeptPicture):
        return (
            write if _is_kept(write, path) else replace(write, draw=_begun(pool, write.draw, path))
        )
    job = _job(write)
    return write if job is None else partial(_awaited, pool.submit(draw, job, path), write)


def _job(write: Write) -> bytes | None:
    """The second step of drawing for another process; None if there is none.

    What fails here fails in this process again when the picture is asked for.
    """
    try:
        step = write.ready() if isinstance(write, Drawing) else write
        return bytes(ForkingPickler.dumps(step))
    except Exception:
        return None


def _awaited(done: Future[None], write: Write, path: Path) -> None:
    try:
        done.result()
    except BrokenProcessPool:  # the system ended one, for memory most likely
        write(path)
