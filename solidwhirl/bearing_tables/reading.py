"""Files of coefficients by their kind."""

from __future__ import annotations

from pathlib import Path

from solidwhirl.bearing_tables.csv_files import read_csv
from solidwhirl.bearing_tables.records import CoefficientTable, TableFileError
from solidwhirl.bearing_tables.ross_files import read_ross
from solidwhirl.core.errors import choice

_TEXTS, _ROSS, _SHEETS = (".csv", ".txt", ".tsv"), (".toml", ".json"), (".xls", ".xlsx", ".xlsm")
_MOST_BYTES = 50_000_000


def read_tables(path: Path) -> dict[str, CoefficientTable]:
    """Return all tables of a file by their tags; a CSV file has one, without a tag.

    CSV files are those ending in .csv, .txt or .tsv, see `csv_files.read_csv`; .toml and .json are
    files of ROSS, see `ross_files.read_ross`.
    Raises TableFileError: another ending, a file that can't be read, or what the readers refuse.
    """
    suffix = path.suffix.lower()
    if suffix in _SHEETS:
        raise TableFileError(path, "is a spreadsheet; save the sheet of coefficients as CSV")
    if suffix not in (*_TEXTS, *_ROSS):
        known = ", ".join((*_TEXTS, *_ROSS))
        raise TableFileError(path, f"ends in {suffix[:20]!r}; known are {known}")
    text = _text(path)
    return {"": read_csv(path, text)} if suffix in _TEXTS else read_ross(path, text)


def read_table(path: Path, tag: str | None = None) -> CoefficientTable:
    """Return one table of a file; `tag` says which, where it has several.

    Raises TableFileError: as `read_tables`, and if there is no such tag or it is needed.
    """
    found = read_tables(path)
    if tag is None:
        if len(found) > 1:
            raise TableFileError(path, f"tag: missing; the file has {', '.join(found)}")
        return next(iter(found.values()))
    if tag not in found or not tag:
        raise TableFileError(path, f"tag: no {tag!r}; {choice(tag, [t for t in found if t])}")
    return found[tag]


def _text(path: Path) -> str:
    try:
        with path.open("rb") as file:
            content = file.read(_MOST_BYTES + 1)
    except OSError as error:
        raise TableFileError(path, f"can not be read: {error.strerror or error}") from error
    if len(content) > _MOST_BYTES:
        raise TableFileError(path, f"larger than {_MOST_BYTES} bytes; such a file is small")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:  # as spreadsheets write it where that is the system's own
        return content.decode("cp1252", errors="replace")
