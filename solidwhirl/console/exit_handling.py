"""How a command ends that can not go on: signals, memory, and ranks that would wait for ever."""

from __future__ import annotations

import contextlib
import errno
import mmap
import os
import signal
import sys
import traceback
from collections.abc import Iterator
from typing import Any, NoReturn

import typer

from solidwhirl.core.errors import clean

# PETSc's codes for memory that it did not get, and for errors of libraries such as MUMPS.
_NO_MEMORY, _LIBRARY = 55, 76
# Address space below which nothing is begun, and a product large enough to want the buffer.
_LEAST_MEMORY, _BLOCK = 256 << 20, 256
_NEXT_TO_NONE = 64 << 20
# Further lines of a message, below what stands behind "error: ".
_BELOW = " " * len("error: ")
# What libraries say when they get no memory.
_SAYINGS = (
    "bad_alloc",
    "cannot allocate memory",
    "cannot allocate required memory",
    "unable to allocate",
    "out of memory",
    "failed to map segment",
    "insufficient memory",
    "memory allocation failed",
    "can't start new thread",
)
# MUMPS's INFOG(1): memory that it did not get, or that its estimate was too small.
_MUMPS = ("infog(1)=-13", "infog(1)=-9", "infog(1)=-19", "infog(1)=-5,", "infog(1)=-7")


class Terminated(KeyboardInterrupt):
    """The system asked the program to end (SIGTERM)."""


def keep_petsc_from_signals() -> None:
    """Tell PETSc to leave SIGTERM alone, which it would take for a crash."""
    options = os.environ.get("PETSC_OPTIONS", "")
    if "-no_signal_handler" not in options:
        os.environ["PETSC_OPTIONS"] = f"{options} -no_signal_handler".strip()


@contextlib.contextmanager
def interruptible() -> Iterator[None]:
    """While this lasts, SIGTERM raises `Terminated`; a second one ends the program at once.

    Before and after, SIGTERM ends it silently: there nothing would catch the exception.
    """
    before = sys.unraisablehook
    sys.unraisablehook = _end_where_nothing_can_be_raised
    signal.signal(signal.SIGTERM, _terminate)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        sys.unraisablehook = before


def _terminate(number: int, frame: object) -> NoReturn:
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    raise Terminated


def _end_where_nothing_can_be_raised(unraisable: Any) -> None:
    """The signal came in a finalizer or a callback, whose exceptions Python drops."""
    if isinstance(unraisable.exc_value, Terminated):
        os.kill(os.getpid(), signal.SIGTERM)  # by now with its default action
    sys.__unraisablehook__(unraisable)


def end_interrupted(error: KeyboardInterrupt, remark: str = "") -> NoReturn:
    """Say in one line that the command was interrupted, and leave with 130 or 143."""
    if isinstance(error, Terminated):
        stop(f"ended by the system (SIGTERM){remark}", 128 + signal.SIGTERM)
    stop(f"interrupted{remark}", 128 + signal.SIGINT)


def stop(message: str, code: int = 2) -> NoReturn:
    """Print a message and leave with a code, on all ranks."""
    with contextlib.suppress(OSError):  # whoever read it may be gone
        typer.echo("error: " + clean(message).replace("\n", "\n" + _BELOW), err=True)
    _abort_others(code)
    raise typer.Exit(code)


def end_of_defect(error: Exception) -> NoReturn:
    """Let an exception that nobody expected end all ranks, with its traceback.

    Where memory is so short that ending itself fails, the message is out already, or can't be.
    """
    if is_out_of_memory(error):
        with contextlib.suppress(Exception):
            if not _is_after_stop(error):
                typer.echo(f"error: {memory_text(error)}", err=True)
            _abort_others(2)
        raise SystemExit(2)
    if _ranks() > 1:
        traceback.print_exception(error)
    _abort_others(1)
    raise error


def _is_after_stop(error: BaseException) -> bool:
    """Whether an exception came up while the program was ending with a message."""
    current: BaseException | None = error
    for _ in range(20):
        if current is None or isinstance(current, typer.Exit | SystemExit):
            return current is not None
        current = current.__context__
    return False


def _ranks() -> int:
    mpi: Any = sys.modules.get("mpi4py.MPI")
    return 1 if mpi is None else int(mpi.COMM_WORLD.size)


def _abort_others(code: int) -> None:
    """End all ranks: those that wait for this one would wait for ever."""
    if _ranks() > 1:
        sys.stderr.flush()
        sys.modules["mpi4py.MPI"].COMM_WORLD.Abort(code)


def take_first_memory() -> None:
    """Take what the linear algebra needs of memory at its first call, or refuse.

    OpenBLAS waits for its buffer for ever where there is no room for it.

    Raises MemoryError: less address space than that is left.
    """
    if not _has_memory(_LEAST_MEMORY):
        raise MemoryError(f"less than {_LEAST_MEMORY >> 20} MiB are left")
    import numpy as np

    block = np.ones((_BLOCK, _BLOCK))
    block @ block  # the buffer stays


def _has_memory(size_bytes: int) -> bool:
    """Whether there is as much address space, by asking for it."""
    try:
        mmap.mmap(-1, size_bytes).close()
    except (OSError, ValueError):
        return False
    return True


def is_out_of_memory(error: BaseException) -> bool:
    """Whether an exception, or one behind it, comes from too little memory.

    `error`: the exception, while it holds what it was working on: libraries that do not say why
    they failed are taken to have had no memory where there is next to none left.
    """
    if isinstance(error, RuntimeError) and not _has_memory(_NEXT_TO_NONE):
        return True
    seen: set[int] = set()
    current: BaseException | None = error
    while current is not None and id(current) not in seen:
        if _says_no_memory(current):
            return True
        seen.add(id(current))
        current = current.__cause__ or current.__context__
    return False


def _says_no_memory(error: BaseException) -> bool:
    if isinstance(error, MemoryError) or getattr(error, "errno", None) == errno.ENOMEM:
        return True
    code = getattr(error, "ierr", None)
    if code == _NO_MEMORY:
        return True
    text = str(error).lower()
    if code == _LIBRARY and any(m in text.replace(" ", "") for m in _MUMPS):
        return True
    return any(saying in text for saying in _SAYINGS)


def memory_text(error: BaseException) -> str:
    """One line on what got no memory."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    said = f" ({lines[-1][:200]})" if lines else ""
    return (
        f"not enough memory{said}; free some or allow more, or choose a coarser accuracy, fewer "
        "modes or the level harmonic. Completed stages are kept: the same command goes on from them"
    )
