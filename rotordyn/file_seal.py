"""The seal of a file: a SHA-256 of its bytes in the user block that HDF5 keeps free at the start.

It tells damage of any bit, before the HDF5 library sees the file, and is no proof of who wrote it.
"""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

from solidwhirl.rotordyn.errors import SuperelementError

#: Bytes before the HDF5 content; the format allows 0, 512 and its doubles.
SEAL_BYTES = 512
_MARK = b"ROTOR-SUPERELEMENT sha256 "
_SEAL = re.compile(rb"([0-9a-f]{64})\n\x00*")


def seal_file(path: Path) -> None:
    """Write the seal into the user block of a complete file.

    Parameters
    ----------
    path
        An HDF5 file with a user block of `SEAL_BYTES`.
    """
    seal = _MARK + _digest(path).encode() + b"\n"
    with path.open("r+b") as file:
        file.write(seal.ljust(SEAL_BYTES, b"\x00"))


def is_sealed(path: Path) -> bool:
    """Return whether a file has a seal, which then fits its bytes.

    Parameters
    ----------
    path
        Any file.

    Raises
    ------
    SuperelementError
        If it has a seal that does not fit: the file is not what was written.
    """
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
