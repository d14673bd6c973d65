"""Measured functions and modes as CSV, one row for each number of a sensor."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from solidwhirl.analyses.measured.records import (
    MOST_BYTES,
    UNITS,
    MeasuredFileError,
    MeasuredFunction,
    MeasuredMode,
)
from solidwhirl.core.errors import choice
from solidwhirl.rotordyn.core.foreign import ForeignError, regular_bytes

_OF_MODE = ("frequency_hz", "damping_ratio", "uncertainty_hz")
_MODE_COLUMNS = ("mode", *_OF_MODE, "sensor", "real", "imaginary")
_MOST_ROWS = 2_000_000


def read_functions(
    path: Path, hammers: Sequence[str], sensors: Sequence[str]
) -> tuple[MeasuredFunction, ...]:
    """Read functions: columns hammer, sensor, frequency_hz, real_UNIT and imaginary_UNIT.

    UNIT is m_per_n of receptances, m_per_s_n of mobilities, m_per_s2_n of accelerances. `hammers`,
    `sensors`: names of the scene. Raises MeasuredFileError: a column, name or number is missing or
    wrong; the message names its line.
    """
    head, rows = _table(path)
    quantity = next((q for q, unit in UNITS.items() if f"real_{unit}" in head), None)
    if quantity is None:
        allowed = ", ".join(f"real_{unit}" for unit in UNITS.values())
        raise MeasuredFileError(
            path, f"no column of real parts; allowed is one of {allowed}; the headings are {head}"
        )
    numbers = ("frequency_hz", f"real_{UNITS[quantity]}", f"imaginary_{UNITS[quantity]}")
    _require(path, head, ("hammer", "sensor", *numbers))
    found: dict[tuple[str, str], list[list[float]]] = {}
    for line, row in rows:
        ends = (
            _named(path, line, "hammer", row, hammers),
            _named(path, line, "sensor", row, sensors),
        )
        found.setdefault(ends, []).append([_number(path, line, key, row) for key in numbers])
    functions = []
    for (hammer, sensor), values in found.items():
        x, real, imaginary = np.array(values).T
        if (np.diff(x) <= 0.0).any() or x[0] < 0.0:
            raise MeasuredFileError(
                path, f"frequencies from {hammer!r} to {sensor!r} do not rise from 0 Hz or above"
            )
        above = x > 0.0
        functions.append(
            MeasuredFunction(
                hammer=hammer,
                sensor=sensor,
                quantity=quantity,
                frequency_hz=x[above],
                values=(real + 1j * imaginary)[above],
            )
        )
    return tuple(functions)


def read_modes(path: Path, sensors: Sequence[str]) -> tuple[MeasuredMode, ...]:
    """Read modes: columns mode and frequency_hz, others may be left out.

    damping_ratio and uncertainty_hz (standard deviation) belong to the mode; sensor, real and
    imaginary are the motion of a sensor, one row each. `sensors`: names of the scene. Raises
    MeasuredFileError: a column, name or number is missing or wrong; the message names its line.
    """
    head, rows = _table(path)
    _require(path, head, ("mode", "frequency_hz"))
    unknown = [key for key in head if key not in _MODE_COLUMNS]
    if unknown:
        raise MeasuredFileError(
            path, f"unknown column {unknown[0]!r}; {choice(unknown[0], list(_MODE_COLUMNS))}"
        )
    own: dict[str, tuple[float | None, ...]] = {}
    shapes: dict[str, dict[str, complex]] = {}
    for line, row in rows:
        name = row["mode"]
        given = tuple(_number(path, line, k, row) if row.get(k) else None for k in _OF_MODE)
        if given[0] is None or given[0] <= 0.0:
            raise MeasuredFileError(path, f"line {line}: frequency_hz must be above 0")
        if own.setdefault(name, given) != given:
            raise MeasuredFileError(
                path, f"line {line}: mode {name!r} has other numbers than above"
            )
        if row.get("sensor"):
            sensor = _named(path, line, "sensor", row, sensors)
            real = _number(path, line, "real", row)
            imaginary = _number(path, line, "imaginary", row) if row.get("imaginary") else 0.0
            shapes.setdefault(name, {})[sensor] = complex(real, imaginary)
    modes = [
        MeasuredMode(
            frequency_hz=f or 0.0, damping_ratio=d, uncertainty_hz=u, shape=shapes.get(name)
        )
        for name, (f, d, u) in own.items()
    ]
    return tuple(sorted(modes, key=lambda mode: mode.frequency_hz))


def _table(path: Path) -> tuple[list[str], Iterator[tuple[int, Mapping[str, str]]]]:
    """Return headings, and rows with their line by heading."""
    try:
        text = regular_bytes(path, MOST_BYTES).decode("utf-8-sig")
    except ForeignError as error:
        raise MeasuredFileError(path, str(error)) from error
    except UnicodeDecodeError as error:
        raise MeasuredFileError(path, f"is not UTF-8 text (byte {error.start})") from error
    lines = list(csv.reader(text.splitlines()))
    if len(lines) > _MOST_ROWS:
        raise MeasuredFileError(path, f"more than {_MOST_ROWS} lines")
    if len(lines) < 2:
        raise MeasuredFileError(path, "no row below the headings")
    head = [cell.strip() for cell in lines[0]]

    def rows() -> Iterator[tuple[int, Mapping[str, str]]]:
        for line, cells in enumerate(lines[1:], start=2):
            if not any(cell.strip() for cell in cells):
                continue
            if len(cells) != len(head):
                raise MeasuredFileError(
                    path, f"line {line}: {len(cells)} cells below {len(head)} headings"
                )
            yield line, {k: cell.strip() for k, cell in zip(head, cells, strict=True)}

    return head, rows()


def _require(path: Path, head: Sequence[str], keys: Sequence[str]) -> None:
    missing = [key for key in keys if key not in head]
    if missing:
        raise MeasuredFileError(path, f"no column {missing[0]!r}; the headings are {head}")


def _named(path: Path, line: int, key: str, row: Mapping[str, str], known: Sequence[str]) -> str:
    if row[key] not in known:
        raise MeasuredFileError(
            path, f"line {line}: no {key} {row[key]!r} in the scene; there are {list(known)}"
        )
    return row[key]


def _number(path: Path, line: int, key: str, row: Mapping[str, str]) -> float:
    try:
        value = float(row[key])
    except (KeyError, ValueError):
        value = math.nan
    if not math.isfinite(value):
        raise MeasuredFileError(path, f"line {line}: {key} is {row.get(key)!r}; no finite number")
    return value
