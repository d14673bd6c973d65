"""Files of unknown origin: a checksum tells damage, what has none is read in a child process first.

The seal is a SHA-256 of all bytes behind the user block that HDF5 keeps free at the start. It tells
damage of any bit before the HDF5 library sees the file, and is no proof of who wrote it. The
library can crash or run forever on damaged bytes; the child takes that upon itself.
"""

from __future__ import annotations

import faulthandler
import hashlib
import os
import re
import resource
import select
import signal
import time
import warnings
from collections.abc import Callable
from pathlib import Path

from solidwhirl.rotordyn.core.errors import SuperelementError

#: Bytes before the HDF5 content; the format allows 0, 512 and its doubles.
SEAL_BYTES = 512
_MARK = b"ROTOR-SUPERELEMENT sha256 "
_SEAL = re.compile(rb"([0-9a-f]{64})\n\x00*")
# Processor time allowed: to begin with, and for each byte (1 MB/s; a tenth of that is usual).
_FIRST_S, _S_PER_BYTE = 2, 1e-6
# Waiting beside processor time: for the disk, and for other programs.
_PATIENCE = 20.0
# Memory on top of what the program has: to begin with, and for each byte of the file.
_FIRST_BYTES, _BYTES_PER_BYTE = 1 << 29, 1000
_REFUSED, _FAILED = 1, 2
_LONGEST = 16_000


def seal_file(path: Path) -> None:
    """Write the seal into the user block (of `SEAL_BYTES`) of a complete HDF5 file."""
    seal = _MARK + _digest(path).encode() + b"\n"
    with path.open("r+b") as file:
        file.write(seal.ljust(SEAL_BYTES, b"\x00"))


def is_sealed(path: Path) -> bool:
    """Return whether a file has a seal; refuse one whose seal does not fit its bytes."""
    with path.open("rb") as file:
        head = file.read(SEAL_BYTES)
    if not head.startswith(_MARK):
        return False
    found = _SEAL.fullmatch(head[len(_MARK) :])
    if found is None or found[1].decode() != _digest(path):
        raise SuperelementError(
            f"{path}: damaged: its bytes do not fit the checksum in its first {SEAL_BYTES} bytes; "
            "a file changed on purpose needs these set to zero"
        )
    return True


def _digest(path: Path) -> str:
    """SHA-256 of what follows the user block."""
    with path.open("rb") as file:
        file.seek(SEAL_BYTES)
        return hashlib.file_digest(file, "sha256").hexdigest()


def refuse_damaged(path: Path, read: Callable[[Path], object]) -> None:
    """Refuse a file that reading could not survive; one without a seal is tried in a child first.

    Raises SuperelementError if there is no such file, its seal does not fit, or reading it does not
    end well.
    """
    try:
        if not path.is_file():
            raise SuperelementError(f"{path}: no such file")
        if not is_sealed(path):
            refuse_harmful(path, read)
    except OSError as error:
        said = error.strerror or error
        raise SuperelementError(f"{path}: can not be read: {said}") from error


def refuse_harmful(path: Path, read: Callable[[Path], object]) -> None:
    """Read a file in a child process, and refuse it if that does not end well.

    Raises SuperelementError: what `read` raised, or that the child crashed, ran on, or needed too
    much memory.

    Where processes can't be forked (Windows, or a program that has taken more address space than
    the system would grant twice) nothing is tried.
    """
    if not hasattr(os, "fork"):
        return
    size = path.stat().st_size
    seconds = _FIRST_S + int(_S_PER_BYTE * size)
    source, sink = os.pipe()
    try:
        try:
            child = _fork()
        except OSError:
            os.close(source)
            return
        if child == 0:
            _try(path, read, sink, seconds, _FIRST_BYTES + _BYTES_PER_BYTE * size)
    finally:
        os.close(sink)
    message = None
    try:
        message = _listen(source, time.monotonic() + _PATIENCE * seconds)
    finally:
        os.close(source)
        if message is None:
            os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
    code = os.waitstatus_to_exitcode(status)
    if code == _REFUSED and message:
        raise SuperelementError(message.decode("utf-8", errors="replace"))
    if code != 0:
        raise SuperelementError(f"{path}: damaged: {_reason(code, seconds)}")


def _fork() -> int:
    with warnings.catch_warnings():
        # threads of other libraries do not matter to a child that only reads and ends
        warnings.simplefilter("ignore", DeprecationWarning)
        return os.fork()


def _try(path: Path, read: Callable[[Path], object], sink: int, seconds: int, memory: int) -> None:
    """Read within limits, say what was refused, and end the process."""
    code = _FAILED
    try:
        faulthandler.disable()
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        _limit(resource.RLIMIT_CPU, seconds)
        _limit(resource.RLIMIT_AS, _address_space() + memory)
        read(path)
        code = 0
    except SuperelementError as error:
        os.write(sink, str(error).encode("utf-8", errors="replace")[:_LONGEST])
        code = _REFUSED
    finally:
        os._exit(code)  # nothing of the program's own ending is the child's business


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


def _listen(source: int, deadline: float) -> bytes | None:
    """What the child says until it ends; None if it does not end in time."""
    heard = b""
    while (left := deadline - time.monotonic()) > 0:
        ready, _, _ = select.select([source], [], [], left)
        if not ready:
            break
        piece = os.read(source, _LONGEST)
        if not piece:
            return heard
        heard += piece
    return None


def _reason(code: int, seconds: int) -> str:
    if code in (-signal.SIGXCPU, -signal.SIGKILL):
        return f"the HDF5 library does not come to an end with it in {seconds} s"
    if code < 0:
        return f"the HDF5 library breaks down on it (signal {-code})"
    return "it can not be read within the memory that its size allows"
