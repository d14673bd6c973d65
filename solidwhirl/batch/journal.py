"""The journal of a batch: one JSON line for each case that has ended, safe against every end."""

from __future__ import annotations

import contextlib
import dataclasses
import fcntl
import json
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from solidwhirl.core.errors import OutputError, UserError, clean
from solidwhirl.core.plain_data import plain_data
from solidwhirl.rotordyn.core.atomic import replacing
from solidwhirl.sweep.records import BatchRow

JOURNAL = "batch.jsonl"
SCHEMA = "solidwhirl-batch-1"
# What rows of earlier releases do not have.
_LATER = {"critical_motion", "campbell_motion", "method", "sweep_cases"}
_ROW = TypeAdapter(BatchRow)


class BatchTableError(UserError):
    """A journal or table of a batch that can not be read; the message names file and place."""


class Journal:
    """The open journal of a batch, for one writer.

    `path`: the file.
    """

    def __init__(self, path: Path, file: int, rows: Iterable[BatchRow]) -> None:
        self.path = path
        self._file = file
        self._rows = {row.case: row for row in rows}

    @property
    def rows(self) -> tuple[BatchRow, ...]:
        """The last row of every case."""
        return tuple(self._rows.values())

    def append(self, row: BatchRow) -> None:
        """Write a row; it is on the disk when this returns.

        `row`: it takes the place of an earlier row of the same case.
        Raises OutputError: there is no room. What was written of the line is removed, whatever
        ended it.
        """
        line = json.dumps(row_document(row), allow_nan=False).encode() + b"\n"
        end = os.fstat(self._file).st_size
        try:
            written = 0
            while written < len(line):
                written += os.pwrite(self._file, line[written:], end + written)
            os.fsync(self._file)
        except BaseException as error:  # SIGTERM too: what follows would stand in the same line
            with contextlib.suppress(OSError):
                os.ftruncate(self._file, end)
            if not isinstance(error, OSError):
                raise
            said = error.strerror or error
            raise OutputError(f"{self.path}: can not be written: {said}") from error
        self._rows[row.case] = row


@contextmanager
def open_journal(folder: str | Path) -> Iterator[Journal]:
    """Open the journal of a batch for writing; a line that was broken off is removed first.

    The system gives it free when the process ends, however it ends.
    Raises OutputError: another process writes it, or it can't be written; BatchTableError: a line
    before the last is damaged.
    """
    path = Path(folder) / JOURNAL
    try:
        file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
    except OSError as error:
        raise OutputError(f"{path}: can not be written: {error.strerror or error}") from error
    try:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OutputError(f"{path}: another batch is writing it; wait for it") from None
        read = _undamaged(path)
        os.ftruncate(file, read.length)
        yield Journal(path, file, read.rows)
    finally:
        os.close(file)


def begin_journal(folder: Path, rows: Iterable[BatchRow]) -> None:
    """Write a journal of these rows in place of the one that is there.

    Raises OutputError: it can't be written.
    """
    lines = [json.dumps(row_document(row), allow_nan=False) + "\n" for row in rows]
    try:
        with replacing(folder / JOURNAL) as temporary:
            temporary.write_text("".join(lines), encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{folder}: can not be written: {error.strerror or error}") from error


def read_journal(folder: str | Path) -> tuple[BatchRow, ...]:
    """Read the last row of every case; a last line that was broken off is passed over.

    Raises BatchTableError: there is no journal, or a line before the last is damaged.
    """
    return _last_rows(_undamaged(Path(folder) / JOURNAL))


def salvaged_journal(folder: str | Path) -> tuple[tuple[BatchRow, ...], tuple[str, ...]]:
    """Read what is left of a journal.

    Returns the last whole row of every case, and a sentence for each line that is damaged.
    Raises BatchTableError: there is no journal.
    """
    read = _parsed(Path(folder) / JOURNAL)
    return _last_rows(read), read.damaged


def _last_rows(read: _Parsed) -> tuple[BatchRow, ...]:
    return tuple({row.case: row for row in read.rows}.values())


def _undamaged(path: Path) -> _Parsed:
    read = _parsed(path)
    if read.damaged:
        raise BatchTableError(read.damaged[0])
    return read


def in_order(rows: Iterable[BatchRow]) -> tuple[BatchRow, ...]:
    """Return rows by scene and number of the case, whatever order they ended in."""
    return tuple(sorted(rows, key=lambda row: (row.scene, len(row.case), row.case)))


def row_document(row: BatchRow) -> dict[str, Any]:
    """Return a row as plain data for JSON; nan is null."""
    document = {f.name: getattr(row, f.name) for f in dataclasses.fields(row)}
    document["message"] = clean(row.message)
    return {"schema": SCHEMA, **{key: plain_data(value) for key, value in document.items()}}


def row_from_document(document: Any) -> BatchRow:
    """Return the row that plain data tells.

    Raises BatchTableError: it is no row; the message names the key.
    """
    if not isinstance(document, dict) or document.get("schema") != SCHEMA:
        raise BatchTableError(f"is no row of a batch ({SCHEMA})")
    for f in dataclasses.fields(BatchRow):
        if f.name not in document and f.name not in _LATER:
            raise BatchTableError(f"{f.name}: missing")
    try:
        return _ROW.validate_python(document)
    except ValidationError as error:
        first = error.errors()[0]
        raise BatchTableError(f"{first['loc'][0]}: {first['input']!r}: {first['msg']}") from error
    except OverflowError as error:
        raise BatchTableError(f"a number is too large: {error}") from error


@dataclasses.dataclass(frozen=True, kw_only=True)
class _Parsed:
    """Rows of a journal in the order of its lines, its whole bytes, and what is wrong with it."""

    rows: list[BatchRow]
    length: int
    damaged: tuple[str, ...]


def _parsed(path: Path) -> _Parsed:
    try:
        if path.exists() and not path.is_file():
            raise BatchTableError(f"{path}: is no regular file")
        content = path.read_bytes()
    except OSError as error:
        raise BatchTableError(f"{path}: can not be read: {error.strerror or error}") from error
    lines = content.split(b"\n")[:-1]
    rows, length, damaged = [], 0, []
    for number, line in enumerate(lines, 1):
        try:
            rows.append(row_from_document(json.loads(line)))
        except (ValueError, RecursionError) as error:
            # blocks of the last line may not have reached the disk when the machine stopped
            if number == len(lines) and not isinstance(error, BatchTableError):
                break
            said = str(error) if isinstance(error, BatchTableError) else "is damaged"
            damaged.append(f"{path}: line {number}: {clean(said, 300)}")
        length += len(line) + 1
    return _Parsed(rows=rows, length=length, damaged=tuple(damaged))
