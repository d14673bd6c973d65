"""Coefficient tables as CSV: a header with names and units, or with a row of units below it."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from solidwhirl.bearing_tables.grid import ENDS, GridError, on_grid
from solidwhirl.bearing_tables.records import CoefficientTable, TableFileError
from solidwhirl.bearing_tables.units import UNITS, canonical, factor_of
from solidwhirl.core.errors import clean
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S

_QUANTITIES = {"k": "stiffness", "c": "damping", "m": "mass"}
#: Axis of a table by the words that head its column.
_AXES = {
    **dict.fromkeys(("speed", "rotor speed", "shaft speed", "running speed", "rotational speed",
                     "rotation speed", "spin speed", "angular speed", "angular velocity", "omega",
                     "ω", "n"), "speeds_rad_s"),
    **dict.fromkeys(("frequency", "freq", "excitation frequency", "whirl frequency", "f"),
                    "frequencies_rad_s"),
    **dict.fromkeys(("load", "static load", "bearing load"), "loads_n"),
}  # fmt: skip
_AXIS_QUANTITIES = {
    "speeds_rad_s": "speed",
    "frequencies_rad_s": "frequency",
    "loads_n": "load",
}
# What follows a name is its unit, in brackets or not.
_COEFFICIENT = re.compile(
    r"^([kcm])[ _-]?\{?(?:([xy])[ _-]?([xy])|([12])[ _-]?([12]))\}?(?!\d)[\s_,]*(.*)$",
    re.IGNORECASE,
)
_WORDS = "|".join(sorted((w for w in _AXES if len(w) > 1), key=len, reverse=True))
_AXIS = re.compile(rf"^({_WORDS.replace(' ', '[ _]')})[\s_,]*(.*)$", re.IGNORECASE)
# Symbols of an axis, where a unit of it follows.
_SYMBOL = re.compile(r"^([nfω])\s*([\[(].*)$", re.IGNORECASE)
# Words that stand for a speed here, and for a frequency elsewhere; and 1 for x, 2 for y.
_READ_AS = ("omega", "ω", "n")
_NUMBERED = {"1": "x", "2": "y"}
# Units that head a column alone.
_BARE = {"rpm": "speeds_rad_s", "hz": "frequencies_rad_s"}
_DELIMITERS = ",;\t"
# Numbers with commas between thousands, or with a decimal comma and three digits behind it; those
# that can only have the first; and blanks and apostrophes between thousands.
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+(?:\.\d*)?(?:[eE][+-]?\d+)?")
_SURE_THOUSANDS = re.compile(
    r"[+-]?[1-9]\d{0,2}(?:(?:,\d{3}){2,}(?:\.\d*)?|,\d{3}\.\d*)(?:[eE][+-]?\d+)?"
)
_GROUPS = re.compile(r"(?<=\d)[ '’\u00a0\u202f](?=\d{3}(?!\d))")
_MOST_ROWS = 200_000


@dataclass(frozen=True, kw_only=True)
class _Column:
    """A column that is read: its place, heading, name, and what one of its unit is in SI."""

    at: int
    heading: str
    name: str
    quantity: str
    unit: str
    factor: float | None


def read_csv(path: Path, text: str) -> CoefficientTable:
    """Return the table in the text of a CSV file.

    The header is the first row with a cell `kxx`, in any case, with or without a unit; rows above
    it are passed by. A unit stands in the name (`kxx_n_per_m`), in brackets behind it
    (`Kxx [lb/in]`), or in the row below. The table ends at the first empty row. Columns may be
    apart by commas, semicolons (then numbers may have a decimal comma) or tabs.
    Raises TableFileError: no header, a column without a unit that is known, a cell that is no
    number, or rows that do not fill the grid of their axes.
    """
    rows, delimiter, at = _header(path, text)
    columns, ignored = _columns(path, rows[at])
    first = at + 1
    if any(column.factor is None for column in columns):
        below = rows[first] if first < len(rows) else []
        columns, first = [_with_unit(path, column, below) for column in columns], first + 1
    _refuse_longer_rows(path, rows[at], rows[first:], delimiter)
    values, left = _numbers(path, columns, rows[first:], delimiter)
    named = dict(zip([column.name for column in columns], values.T, strict=True))
    axes = {name: named[name] for name in _AXIS_QUANTITIES if name in named}
    shown = {c.name: (c.quantity, c.unit, c.factor or 1.0) for c in columns if c.name in axes}
    try:
        found, matrices = on_grid(axes, named, shown)
    except GridError as error:
        raise TableFileError(path, str(error)) from error
    notes = [f"columns left out: {', '.join(ignored)}"] if ignored else []
    notes += [
        f"column {c.heading!r} is taken as {c.quantity if c.name in axes else c.name}"
        for c in columns
        if _is_read_as(c)
    ]
    notes += [f"{left} rows of numbers below an empty row are left out"] if left else []
    return CoefficientTable(
        **found,
        stiffness_n_per_m=matrices["k"],
        damping_n_s_per_m=matrices["c"],
        mass_kg=matrices["m"],
        source=path.name,
        notes=tuple(notes),
        assumed=tuple(_assumed(named)),
    )


def _is_read_as(column: _Column) -> bool:
    """Whether a heading has another word than the name that its column is known by."""
    word = column.heading.lower()
    if column.name in _AXIS_QUANTITIES:
        return _AXES.get(word) is None and any(word.startswith(own) for own in _READ_AS)
    return not re.search("[xy]", word[:6])


def _assumed(named: Mapping[str, FloatArray]) -> Iterator[str]:
    """What coefficients are that have no column."""
    letters = [letter for letter in _QUANTITIES if f"{letter}xx" in named]
    missing = [f"{letter}yy" for letter in letters if f"{letter}yy" not in named]
    if missing:
        taken = ", ".join(name.replace("yy", "xx") for name in missing)
        yield f"no column {', '.join(missing)}: taken as {taken}, the same in x and y"
    cross = [f"{k}{end}" for k in letters for end in ("xy", "yx") if f"{k}{end}" not in named]
    if cross:
        yield f"no column {', '.join(cross)}: taken as 0"


def csv_text(table: CoefficientTable) -> str:
    """Return a table as CSV with the units of this program, which `read_csv` reads back."""
    heads, numbers = columns_of(table)
    lines = [",".join(heads), *(",".join(repr(float(v)) for v in row) for row in numbers)]
    return "\n".join(lines) + "\n"


def columns_of(table: CoefficientTable) -> tuple[list[str], FloatArray]:
    """Return headings with units, and the numbers below them; mass if there is any."""
    axes = [
        (heading, values * scale)
        for heading, values, scale in (
            ("load_n", table.loads_n, 1.0),
            ("speed_rpm", table.speeds_rad_s, RPM_PER_RAD_S),
            ("frequency_hz", table.frequencies_rad_s, 0.5 / math.pi),
        )
        if values is not None
    ]
    parts = [("k", "n_per_m", table.stiffness_n_per_m), ("c", "n_s_per_m", table.damping_n_s_per_m)]
    if table.mass_kg.any():
        parts.append(("m", "kg", table.mass_kg))
    grid = np.meshgrid(*(values for _, values in axes), indexing="ij") if axes else []
    columns = [*(g.ravel() for g in grid), *(values.reshape(-1, 4) for _, _, values in parts)]
    heads = [h for h, _ in axes] + [f"{k}{end}_{unit}" for k, unit, _ in parts for end in ENDS]
    return heads, np.column_stack(columns)


def _header(path: Path, text: str) -> tuple[list[list[str]], str, int]:
    """Rows of a file, what stands between its columns, and the number of its header."""
    best: tuple[int, list[list[str]], str, int] | None = None
    broken: csv.Error | None = None
    for delimiter in _DELIMITERS:
        try:
            reader = csv.reader(text.splitlines(), delimiter=delimiter, strict=True)
            rows = [[cell.strip() for cell in row] for row in reader]
        except csv.Error as error:  # with another separator it may be one
            broken = broken or error
            continue
        rows = [row for row in rows if not (row and row[0].startswith("#"))]
        for at, row in enumerate(rows):
            names = [_name_of(cell)[0] for cell in row]
            if "kxx" in names:
                known = sum(map(bool, names))
                best = (known, rows, delimiter, at) if best is None or known > best[0] else best
                break
    if best is None and broken is not None:
        raise TableFileError(path, f"is no CSV file: {broken}") from broken
    if best is None:
        raise TableFileError(
            path,
            "has no header with a column kxx; allowed is a row such as "
            "speed_rpm, kxx_n_per_m, kxy_n_per_m, ..., or Speed [rpm], Kxx [lb/in], ...",
        )
    return best[1:]


def _name_of(cell: str) -> tuple[str, str, str]:
    """Name and quantity of a column, and the unit behind its name; empty for other columns."""
    if cell.lower() in _BARE:
        axis = _BARE[cell.lower()]
        return axis, _AXIS_QUANTITIES[axis], cell
    found = _COEFFICIENT.match(cell)
    if found:
        letter, *ends = (found[k].lower() for k in range(1, 6) if found[k])
        first, second = (_NUMBERED.get(end, end) for end in ends)
        return f"{letter}{first}{second}", _QUANTITIES[letter], found[6]
    found = _SYMBOL.match(cell)
    if found and factor_of("speed", found[2]) is None:
        return "", "", ""
    found = found or _AXIS.match(cell)
    if found:
        axis = _AXES[found[1].lower().replace("_", " ")]
        return axis, _AXIS_QUANTITIES[axis], found[2]
    return "", "", ""


def _columns(path: Path, header: list[str]) -> tuple[list[_Column], list[str]]:
    """Columns that are read, without a factor where the header has no unit; and all others."""
    columns: list[_Column] = []
    ignored: list[str] = []
    for at, cell in enumerate(header):
        name, quantity, unit = _name_of(cell)
        if not name:
            ignored += [clean(cell[:40])] if cell else []
            continue
        factor = factor_of(quantity, unit) if unit else None
        if unit and factor is None:
            raise _unknown_unit(path, cell, unit, quantity)
        if name in [column.name for column in columns]:
            what = _AXIS_QUANTITIES.get(name, name)
            raise TableFileError(path, f"column {cell!r}: {what} stands in two columns")
        spelt = unit.strip(" []()_")
        columns.append(
            _Column(at=at, heading=cell, name=name, quantity=quantity, unit=spelt, factor=factor)
        )
    if "cxx" not in [column.name for column in columns]:
        raise TableFileError(path, f"has no column cxx; the header has {', '.join(header)[:200]}")
    return columns, ignored


def _with_unit(path: Path, column: _Column, below: list[str]) -> _Column:
    """A column with the unit in the row below the header, unless the header has it."""
    if column.factor is not None:
        return column
    cell = below[column.at] if column.at < len(below) else ""
    if not cell or _is_number(cell):
        raise TableFileError(
            path,
            f"column {column.heading!r} has no unit; allowed is one behind its name or in the row "
            f"below: {', '.join(UNITS[column.quantity])}",
        )
    factor = factor_of(column.quantity, cell)
    if factor is None:
        raise _unknown_unit(path, column.heading, cell, column.quantity)
    return replace(column, factor=factor, unit=cell.strip(" []()"))


def _unknown_unit(path: Path, heading: str, unit: str, quantity: str) -> TableFileError:
    milli = "; m is milli and M is mega" if canonical(unit)[:2].lower() == "mn" else ""
    allowed = ", ".join(UNITS[quantity])
    return TableFileError(
        path, f"column {heading!r}: no unit {unit!r} of {quantity}; allowed are {allowed}{milli}"
    )


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True


def _refuse_longer_rows(
    path: Path, header: list[str], rows: list[list[str]], delimiter: str
) -> None:
    """Refuse rows whose commas stand between columns, and in numbers as well."""
    for number, row in enumerate(rows, start=1):
        count = max((k + 1 for k, cell in enumerate(row) if cell), default=0)
        if count == 0 and number > 1:
            return
        if count > len(header) and delimiter == "," and all(map(_is_number, row[:count])):
            raise TableFileError(
                path,
                f"row {number} of the numbers has {count} cells for {len(header)} columns: a "
                "number with a comma needs quotes, or semicolons between the columns",
            )


def _numbers(
    path: Path, columns: list[_Column], rows: list[list[str]], delimiter: str
) -> tuple[FloatArray, int]:
    """Values in SI down to the first empty row, shape (rows, columns); how many are below it."""
    cells = [[row[c.at] if c.at < len(row) else "" for c in columns] for row in rows]
    begin = next((k for k, row in enumerate(cells) if any(row)), len(cells))
    end = next((k for k in range(begin, len(cells)) if not any(cells[k])), len(cells))
    count = end - begin
    if not 0 < count <= _MOST_ROWS:
        raise TableFileError(path, f"has {count} rows of numbers; allowed is 1 to {_MOST_ROWS}")
    comma = _meaning_of_commas(path, [c for row in cells[begin:end] for c in row], delimiter)
    found = [
        [_number(path, c, cell, comma, k + 1) for c, cell in zip(columns, row, strict=True)]
        for k, row in enumerate(cells[begin:end])
    ]
    below = sum(all(map(_is_number, row)) for row in cells[end:])
    factors = [column.factor for column in columns]
    return np.array(found) * np.array(factors, dtype=float), below


def _meaning_of_commas(path: Path, cells: list[str], delimiter: str) -> str:
    """What a comma in a number of the table stands for: "." or, between thousands, nothing.

    Where commas stand between columns too, in quotes, they are no decimal ones by themselves.

    Raises TableFileError: it may be either, or is both.
    """
    with_comma = [cell for cell in cells if "," in cell]
    thousands = [c for c in with_comma if _SURE_THOUSANDS.fullmatch(c)]
    decimal = [c for c in with_comma if not _THOUSANDS.fullmatch(c)]
    if thousands and decimal:
        raise TableFileError(
            path, f"has {thousands[0]!r} and {decimal[0]!r}: write numbers without commas"
        )
    if with_comma and not thousands and not decimal:
        if delimiter == ",":
            return ""
        one = with_comma[0]
        raise TableFileError(
            path,
            f"has {one!r}, which may be {one.replace(',', '')} or {one.replace(',', '.')}: write "
            "numbers without separators of thousands",
        )
    return "" if thousands else "."


def _number(path: Path, column: _Column, cell: str, comma: str, row: int) -> float:
    text = _GROUPS.sub("", cell).replace(",", comma)
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise TableFileError(
            path,
            f"column {column.heading!r}, row {row} of the numbers: found {cell!r}, allowed is a "
            "number",
        )
    return value
