"""Files of unknown origin: a checksum tells damage, what has none is read in a child process first.

The seal is a SHA-256 of all bytes behind the user block that HDF5 keeps free at the start. It tells
damage of any bit before the HDF5 library sees the file, and is no proof of who wrote it. The
library can crash or run forever on damaged bytes; the child takes that upon itself.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable
from pathlib import Path

from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.core.foreign import ForeignError, in_child, refuse_irregular

#: Bytes before the HDF5 content; the format allows 0, 512 and its doubles.
SEAL_BYTES = 512
_MARK = b"ROTOR-SUPERELEMENT sha256 "
_SEAL = re.compile(rb"([0-9a-f]{64})\n\x00*")
# Processor time allowed: to begin with, and for each byte (1 MB/s; a tenth of that is usual).
_FIRST_S, _S_PER_BYTE = 2, 1e-6
# Memory on top of what the program has: to begin with, and for each byte of the file.
_FIRST_BYTES, _BYTES_PER_BYTE = 1 << 29, 1000


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
        refuse_irregular(path)
        if not is_sealed(path):
            refuse_harmful(path, read)
    except ForeignError as error:
        raise SuperelementError(f"{path}: {error}") from error
    except OSError as error:
        said = error.strerror or error
        raise SuperelementError(f"{path}: can not be read: {said}") from error


def refuse_harmful(path: Path, read: Callable[[Path], object]) -> None:
    """Read a file in a child process, and refuse it if that does not end well.

    Raises SuperelementError: what `read` raised, or that the child crashed, ran on, or needed too
    much memory.
    """
    size = path.stat().st_size
    try:
        in_child(
            lambda: _tried(path, read),
            seconds=_FIRST_S + int(_S_PER_BYTE * size),
            memory_bytes=_FIRST_BYTES + _BYTES_PER_BYTE * size,
            refused=SuperelementError,
        )
    except ForeignError as error:
        raise SuperelementError(f"{path}: damaged: the HDF5 library {error}") from error


def _tried(path: Path, read: Callable[[Path], object]) -> bytes:
    read(path)
    return b""
