"""A table as the keys of `[speed_laws.NAME]` of a scene."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from solidwhirl.bearing_tables.records import CoefficientTable, TableFileError
from solidwhirl.core.errors import one_line
from solidwhirl.core.toml_text import toml_key
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S

# Digits of numbers that pass through a change of units.
_DIGITS = 14


def as_table_law(table: CoefficientTable) -> dict[str, Any]:
    """Return a table as the keys of `kind = "table"`, or `"frequency_table"`.

    Coefficients are nested [speed], or [speed][frequency] with the key `frequency_hz`;
    `added_mass_kg` is there if any mass is not zero. A table over frequency alone holds at all
    speeds, so that its two speeds, rest and the speed of the highest frequency, have the same
    values.
    Raises TableFileError: a table over loads (see `at_load`), or over less than two speeds.
    """
    if table.loads_n is not None:
        raise TableFileError(table.source, "load_n: missing; a law has the values of one load")
    speeds, frequencies = table.speeds_rad_s, table.frequencies_rad_s
    repeated = 1
    if speeds is None and frequencies is not None:
        speeds, repeated = np.array([0.0, frequencies[-1]]), 2
    if speeds is None or speeds.size < 2:
        raise TableFileError(
            table.source,
            "has no two speeds; a law is over the speed, give one value in the bearing itself: "
            f"stiffness_n_per_m = {table.stiffness_n_per_m[0, 0, 0].tolist()}, "
            f"damping_n_s_per_m = {table.damping_n_s_per_m[0, 0, 0].tolist()}",
        )
    law: dict[str, Any] = {"kind": "table", "speed_rpm": _even(speeds * RPM_PER_RAD_S)}
    if frequencies is not None:
        law["frequency_hz"] = _even(frequencies / (2.0 * np.pi))

    def nested(values: FloatArray) -> Any:
        rows = np.repeat(values[0], repeated, axis=0)
        return (rows if frequencies is not None else rows[:, 0]).tolist()

    law["stiffness_n_per_m"] = nested(table.stiffness_n_per_m)
    law["damping_n_s_per_m"] = nested(table.damping_n_s_per_m)
    if table.mass_kg.any():
        law["added_mass_kg"] = nested(table.mass_kg)
    if frequencies is not None or table.mass_kg.any():
        law["kind"] = "frequency_table"
    return law


def law_toml(name: str, table: CoefficientTable) -> str:
    """Return `[speed_laws.NAME]` with a table as TOML text, its source and notes as comments.

    Raises as `as_table_law`.
    """
    law = as_table_law(table)
    lines = [f"# {one_line(text)}" for text in (table.source, *table.notes)]
    lines += [f"[speed_laws.{toml_key(name)}]", f'kind = "{law.pop("kind")}"']
    for key, value in law.items():
        lines += _lines(key, value)
    return "\n".join(lines) + "\n"


def _lines(key: str, value: list[Any]) -> Iterator[str]:
    """A list as lines of TOML, one of each speed."""
    if not isinstance(value[0], list):
        yield f"{key} = {value}"
        return
    yield f"{key} = ["
    yield from (f"    {row}," for row in value)
    yield "]"


def _even(values: FloatArray) -> list[float]:
    """Numbers without the last digits, which a change of units leaves."""
    return [float(f"{value:.{_DIGITS}g}") for value in values]
