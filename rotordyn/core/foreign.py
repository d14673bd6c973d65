"""Limits under which files of others are read: which, how many bytes, a child's time and memory.

A reader calls `regular_bytes` for its files, spends an `Allowance` on what a few bytes can make
many of, and leaves what a library does with damaged bytes to `in_child`. All three raise
`ForeignError` without the file's name, which the reader puts before it in an error of its own.
"""

from __future__ import annotations

import ctypes
import faulthandler
import json
import math
import os
import resource
import select
import signal
import stat
import sys
import time
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn

#: Bytes that a file may have unless its reader says otherwise.
MOST_BYTES = 2_000_000_000
# Waiting beside processor time: for the disk, and for other programs.
_PATIENCE = 20.0
_REFUSED, _FAILED = 1, 2
_PIECE = 1 << 16
_MOST_FILES = 50
_NO_FILE = "no such file"
_PR_SET_PDEATHSIG = 1


class ForeignError(ValueError):
    """What is wrong with a file of others: a part of a sentence that follows its name."""


def refuse_irregular(path: Path) -> int:
    """Return the bytes of a regular file; refuse pipes, devices, folders, links in a circle.

    Raises ForeignError.
    """
    try:
        found = path.stat()
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        raise ForeignError(_said(error)) from error
    if not stat.S_ISREG(found.st_mode):
        raise ForeignError("is no regular file")
    return found.st_size


def regular_bytes(path: Path, most: int = MOST_BYTES) -> bytes:
    """Read a regular file of at most `most` bytes.

    Raises ForeignError: it is none, has more, grows meanwhile, or can't be read.
    """
    refuse_irregular(path)
    try:
        # what became a pipe since is not waited for
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK), "rb") as file:  # noqa: PTH123
            size = os.fstat(file.fileno()).st_size
            if size > most:
                raise ForeignError(f"has {size} bytes, at most {most} are allowed")
            # `size`, not `most`: as many bytes are allocated as are asked for
            content = file.read(size + 1)
    except OSError as error:
        raise ForeignError(_said(error)) from error
    if len(content) > size:
        raise ForeignError("grows while it is read")
    return content


def _said(error: OSError | ValueError) -> str:
    if isinstance(error, FileNotFoundError):
        return _NO_FILE
    return f"can not be read: {getattr(error, 'strerror', None) or error}"


def included(path: Path, name: str, files: Sequence[Path]) -> Path:
    """Return the file that one of a user's files includes; what it names is not trusted.

    `path`: the file that includes it; `files`: those read so far, the user's own first. Raises
    ForeignError: it lies outside the folder of the first, is one of them, or one too many.
    """
    found = path.parent / name
    if "\0" in name or not found.resolve().is_relative_to(files[0].parent.resolve()):
        raise ForeignError(
            f"INCLUDE names {name[:80]!r}, which lies outside the folder of the file; files beside "
            "it and below are allowed"
        )
    if any(found.resolve() == file.resolve() for file in files):
        raise ForeignError(f"INCLUDE names {name[:80]!r} a second time; files are included once")
    if len(files) >= _MOST_FILES:
        raise ForeignError(f"INCLUDE: more than {_MOST_FILES} files")
    try:
        refuse_irregular(found)
    except ForeignError as error:
        raise ForeignError(f"INCLUDE names {name[:80]!r}, which {_which(str(error))}") from error
    return found


def _which(said: str) -> str:
    return "does not exist" if said == _NO_FILE else said


def json_data(content: bytes | str) -> Any:
    """Return what a JSON text says.

    Raises ForeignError: it is none, is nested too deeply, or has a whole number that no double can
    hold.
    """
    try:
        return json.loads(content, parse_int=_whole)
    except RecursionError as error:
        raise ForeignError("is not valid JSON: nested too deeply") from error
    except ForeignError:
        raise
    except ValueError as error:
        raise ForeignError(f"is not valid JSON: {error}") from error


def _whole(text: str) -> int:
    if not math.isfinite(float(text)):
        raise ForeignError(f"holds a number of {len(text)} digits, which is too large")
    return int(text)


class Allowance:
    """How many things a file may make in all, whatever it repeats or counts off."""

    def __init__(self, most: int, things: str) -> None:
        self.most, self.things, self.left = most, things, most

    def take(self, count: int) -> None:
        """Spend some.

        Raises ForeignError: there are not so many left.
        """
        self.left -= count
        if self.left < 0:
            raise ForeignError(f"makes more than {self.most} {self.things}; so many are allowed")


def in_child(
    work: Callable[[], bytes],
    *,
    seconds: int | None,
    memory_bytes: int,
    refused: type[Exception],
) -> bytes:
    """Return what `work` returns, done in a child process, which may crash or run on.

    Parameters
    ----------
    work
        What it changes in memory stays in the child.
    seconds
        Processor time allowed, and 20 times that by the clock; None: it may take long, and ends
        when this process is asked to.
    memory_bytes
        Address space on top of what the program has.
    refused
        An exception of `work` that is raised here, with its message.

    Raises
    ------
    ForeignError
        The child broke down, came to no end, needed more memory, or could not be started.

    On Windows, where processes can't be forked, the work is done here.
    """
    if not hasattr(os, "fork"):
        return work()
    source, sink = os.pipe()
    try:
        try:
            child = _fork()
        except OSError as error:
            os.close(source)
            raise ForeignError(f"needs a process of its own: {error.strerror}") from error
        if child == 0:
            os.close(source)
            _do(work, sink, seconds, memory_bytes, refused)
    finally:
        os.close(sink)
    heard = None
    try:
        heard = _listen(source, None if seconds is None else _PATIENCE * seconds)
    finally:
        os.close(source)
        if heard is None:
            os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
    code = os.waitstatus_to_exitcode(status)
    if code == 0 and heard is not None:
        return heard
    if code == _REFUSED and heard:
        raise refused(heard.decode("utf-8", errors="replace"))
    raise ForeignError(_reason(code, seconds))


def _fork() -> int:
    with warnings.catch_warnings():
        # threads of other libraries do not matter to a child that only reads and ends
        warnings.simplefilter("ignore", DeprecationWarning)
        try:
            return os.fork()
        except OSError:
            if sys.platform != "linux":
                raise
            # MPI has malloc keep address space that was given back, which a fork would need twice
            ctypes.CDLL(None).malloc_trim(0)
            return os.fork()


def _do(
    work: Callable[[], bytes],
    sink: int,
    seconds: int | None,
    memory: int,
    refused: type[Exception],
) -> NoReturn:
    """Work within limits, send the result or what was refused, and end the process."""
    code = _FAILED
    try:
        _die_of_signals()
        if sys.platform == "linux":  # nobody waits for the result of a child whose parent is gone
            ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if seconds is not None:
            _limit(resource.RLIMIT_CPU, seconds)
        _limit(resource.RLIMIT_AS, _address_space() + memory)
        try:
            said, ends = work(), 0
        except refused as error:
            said, ends = str(error).encode("utf-8", errors="replace"), _REFUSED
        with open(sink, "wb", closefd=False) as file:
            file.write(said)
        code = ends
    finally:
        os._exit(code)  # nothing of the program's own ending is the child's business


def _die_of_signals() -> None:
    """Let go of what other libraries do on signals: PETSc's way ends the parent, by MPI_Abort."""
    faulthandler.disable()
    for kind in signal.valid_signals() - {signal.SIGKILL, signal.SIGSTOP}:
        if signal.getsignal(kind) is not signal.SIG_IGN:
            signal.signal(kind, signal.SIG_DFL)


def _limit(kind: int, value: int) -> None:
    """Lower a limit, never raise it."""
    _, hard = resource.getrlimit(kind)
    value = value if hard == resource.RLIM_INFINITY else min(value, hard)
    resource.setrlimit(kind, (value, hard))


def _address_space() -> int:
    """Bytes of address space in use; without /proc as if there were many."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    except (OSError, ValueError, IndexError):
        return 1 << 40
    return pages * resource.getpagesize()


def _listen(source: int, patience_s: float | None) -> bytes | None:
    """What the child says until it ends; None if it does not end in time."""
    heard: list[bytes] = []
    deadline = None if patience_s is None else time.monotonic() + patience_s
    while deadline is None or time.monotonic() < deadline:
        left = None if deadline is None else max(deadline - time.monotonic(), 0.0)
        if not select.select([source], [], [], left)[0]:
            break
        piece = os.read(source, _PIECE)
        if not piece:
            return b"".join(heard)
        heard.append(piece)
    return None


def _reason(code: int, seconds: int | None) -> str:
    if code in (-signal.SIGXCPU, -signal.SIGKILL):
        return "does not come to an end with it" + ("" if seconds is None else f" in {seconds} s")
    if code < 0:
        return f"breaks down on it (signal {-code})"
    return "can not do with the memory that is allowed for it"
