"""The journal of a batch: one JSON line for each case that has ended, safe against every end."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from solidwhirl.core.errors import UserError, clean, writing
from solidwhirl.core.plain_data import plain_data
from solidwhirl.files.run_folder import JOURNAL
from solidwhirl.rotordyn.core.atomic import replacing
from solidwhirl.sweep.records import BatchRow

SCHEMA = "solidwhirl-batch-1"
#: What rows and tables of earlier releases do not have.
LATER = {"critical_kind", "critical_motion", "campbell_motion", "method", "sweep_cases", "warnings"}
_ROW = TypeAdapter(BatchRow)


class BatchTableError(UserError):
    """A journal or table of a batch that can not be read; the message names file and place."""


class Journal:
    """The open journal of a batch."""

    def __init__(self, path: Path, file: int, rows: Iterable[BatchRow]) -> None:
        self._path, self._file = path, file
        self._rows = {row.case: row for row in rows}

    @property
    def rows(self) -> tuple[BatchRow, ...]:
        """The last row of every case."""
        return tuple(self._rows.values())

    def append(self, row: BatchRow) -> None:
        """Write a row, in the place of an earlier one of its case; it is on the disk after this.

        Raises OutputError: there is no room. What was written of the line is removed, whatever
        ended it.
        """
        line = _line(row).encode()
        end = os.fstat(self._file).st_size
        try:
            with writing(self._path):
                written = 0
                while written < len(line):
                    written += os.pwrite(self._file, line[written:], end + written)
                os.fsync(self._file)
        except BaseException:  # SIGTERM too: what follows would stand in the same line
            with contextlib.suppress(OSError):
                os.ftruncate(self._file, end)
            raise
        self._rows[row.case] = row


@contextmanager
def open_journal(folder: str | Path, rows: Sequence[BatchRow] = ()) -> Iterator[Journal]:
    """Write a journal of these rows in place of the one that is there, for more to be appended.

    The folder is claimed by its one writer. Raises OutputError: it can't be written.
    """
    path = Path(folder) / JOURNAL
    with writing(path):
        with replacing(path) as temporary:
            temporary.write_text("".join(map(_line, rows)), encoding="utf-8")
        file = os.open(path, os.O_RDWR | os.O_CLOEXEC)
    try:
        yield Journal(path, file, rows)
    finally:
        os.close(file)


def _line(row: BatchRow) -> str:
    return json.dumps(row_document(row), allow_nan=False) + "\n"


def read_journal(folder: str | Path) -> tuple[BatchRow, ...]:
    """Read the last row of every case; a last line that was broken off is passed over.

    Raises BatchTableError: there is no journal, or a line before the last is damaged.
    """
    rows, damaged = salvaged_rows(folder)
    if damaged:
        raise BatchTableError(damaged[0])
    return rows


def salvaged_rows(folder: str | Path) -> tuple[tuple[BatchRow, ...], list[str]]:
    """Return the last whole row of every case, and a sentence for each line that is damaged.

    Raises BatchTableError: there is no journal.
    """
    path = Path(folder) / JOURNAL
    try:
        if path.exists() and not path.is_file():
            raise BatchTableError(f"{path}: is no regular file")
        lines = path.read_bytes().split(b"\n")[:-1]
    except OSError as error:
        raise BatchTableError(f"{path}: can not be read: {error.strerror or error}") from error
    rows: dict[str, BatchRow] = {}
    damaged = []
    for number, line in enumerate(lines, 1):
        try:
            row = row_from_document(json.loads(line))
            rows[row.case] = row
        except (ValueError, RecursionError) as error:
            # blocks of the last line may not have reached the disk when the machine stopped
            if number == len(lines) and not isinstance(error, BatchTableError):
                break
            said = str(error) if isinstance(error, BatchTableError) else "is damaged"
            damaged.append(f"{path}: line {number}: {clean(said, 300)}")
    return tuple(rows.values()), damaged


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
        if f.name not in document and f.name not in LATER:
            raise BatchTableError(f"{f.name}: missing")
    try:
        return _ROW.validate_python(document)
    except ValidationError as error:
        first = error.errors()[0]
        raise BatchTableError(f"{first['loc'][0]}: {first['input']!r}: {first['msg']}") from error
    except OverflowError as error:
        raise BatchTableError(f"a number is too large: {error}") from error
