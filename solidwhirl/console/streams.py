"""Standard streams that never end a command: whoever reads them may be gone, or their disk full.

The standard library alone: `doctor` runs where nothing else does.
"""

from __future__ import annotations

import contextlib
import errno
import io
import os
import select
import sys
from dataclasses import dataclass
from typing import Any, TextIO

# The reader has what it wanted: no failure.
_READER_GONE = (errno.EPIPE, errno.ECONNRESET)


class _Descriptor(io.RawIOBase):
    """Writes to a file descriptor until that fails once, and nowhere from then on."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self._number = number
        self.problem: OSError | None = None

    def writable(self) -> bool:
        return True

    def fileno(self) -> int:
        return self._number

    def isatty(self) -> bool:
        return os.isatty(self._number)

    def write(self, content: Any) -> int:
        while self.problem is None:
            try:
                return os.write(self._number, content)
            except BlockingIOError:  # a pipe that does not wait, as some parents leave it
                select.select([], [self._number], [])
            except OSError as error:
                self.problem = error
        return len(content)


@dataclass(frozen=True, kw_only=True)
class Streams:
    """The standard streams of a command."""

    output: _Descriptor

    def exit_code(self, code: int) -> int:
        """Return the exit code, 2 instead of 0 if the output could not be written; says so."""
        sys.stdout.flush()
        problem = self.output.problem
        if problem is None or problem.errno in _READER_GONE:
            return code
        sys.stderr.write(f"error: the standard output can not be written: {problem.strerror}\n")
        sys.stderr.flush()
        return code or 2


def lasting_streams() -> Streams:
    """Put streams in place of `sys.stdout` and `sys.stderr` whose failures end nothing.

    Letters that the encoding lacks are escaped; a closed stream becomes the null device, so that
    no file that is opened later gets its descriptor. What compiled libraries and other programs
    print goes to the error stream: the output holds what the command says and nothing else.
    """
    sys.stderr, _ = _lasting(sys.stderr, 2)
    sys.stdout, output = _lasting(sys.stdout, 1)
    return Streams(output=output)


def _lasting(stream: TextIO | None, number: int) -> tuple[TextIO, _Descriptor]:
    encoding, by_line = "utf-8", False
    if stream is None:  # it was closed when the program began
        _fill(number)
    else:
        encoding = stream.encoding
        by_line = getattr(stream, "line_buffering", False)
        with contextlib.suppress(OSError, ValueError):
            stream.flush()
        with contextlib.suppress(OSError, ValueError):
            number = stream.fileno()
    if number == 1:
        number = os.dup(1)
        os.dup2(2, 1)
    raw = _Descriptor(number)
    text = io.TextIOWrapper(
        io.BufferedWriter(raw),
        encoding=encoding,
        errors="backslashreplace",
        line_buffering=by_line or number == 2,
    )
    return text, raw


def _fill(number: int) -> None:
    """Open the null device under a number that is free, and those below it."""
    while True:
        opened = os.open(os.devnull, os.O_RDWR)
        if opened > number:
            os.close(opened)
            return
