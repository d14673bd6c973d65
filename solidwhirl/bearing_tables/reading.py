"""Files of coefficients by their kind."""

from __future__ import annotations

from pathlib import Path

from solidwhirl.bearing_tables.csv_files import read_csv
from solidwhirl.bearing_tables.records import CoefficientTable, TableFileError, text_of
from solidwhirl.bearing_tables.ross_files import read_ross
from solidwhirl.core.errors import choice

_TEXTS, _ROSS, _SHEETS = (".csv", ".txt", ".tsv"), (".toml", ".json"), (".xls", ".xlsx", ".xlsm")


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
    text = text_of(path)
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
