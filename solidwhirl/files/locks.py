"""Files that one process at a time has locked; the system frees them when it ends, however."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
from collections.abc import Callable
from pathlib import Path

# A lock whose file was removed between opening and locking is tried for again so often.
_ATTEMPTS = 1000


def lock_file(path: Path, busy: Callable[[int], None]) -> int:
    """Lock a file, made with its folder where it is not there, and return it open.

    `busy`: called with the open file where another process has it; it raises, or returns to wait.
    Raises OSError: the file system has no locks, or the file can't be made.
    """
    for _ in range(_ATTEMPTS):
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o644)
        except FileNotFoundError:
            continue  # another process removed the folder meanwhile
        try:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                busy(file)
                fcntl.flock(file, fcntl.LOCK_EX)
            if os.fstat(file).st_ino == path.stat().st_ino:
                return file
        except FileNotFoundError:
            pass  # the holder before removed it between opening and locking
        except BaseException:
            os.close(file)
            raise
        os.close(file)
    raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))


def release(path: Path, file: int) -> None:
    """Remove a locked file while it is held, and free it; who opened it sees that it is gone."""
    with contextlib.suppress(OSError):
        path.unlink()
    os.close(file)
