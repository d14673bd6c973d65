"""The rows of a batch as a tree of datasets: one dimension of cases, parameters beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from solidwhirl.batch.table import TABLE, read_batch
from solidwhirl.core.plain_data import Labelled
from solidwhirl.datasets.parts import labelled
from solidwhirl.files.run_folder import JOURNAL
from solidwhirl.sweep.records import BatchRow

_TEXTS = ("scene", "status", "message")
_CRITICAL = ("speed_rpm", "frequency_hz", "error_estimate")
_CAMPBELL = ("frequency_hz", "log_decrement")
_DIMENSIONS = ("case", "critical_speed", "branch", "speed_rpm", "speed")


def is_batch(folder: Path) -> bool:
    """Whether a folder has the journal or the table of a batch."""
    return (folder / JOURNAL).is_file() or (folder / TABLE).is_file()


def batch_datasets(folder: str | Path) -> xr.DataTree:
    """Return the table of a batch as a tree of datasets.

    Returns at the root scene, status, message, warnings (one a line), seconds, peak_memory_gib and
    ranks over case, with the parameters of the sweep as coordinates along case; critical_speeds,
    campbell and responses below it, with the same coordinates. Names and units are those of the
    table. A case that lacks something has nan, "" among texts. Raises BatchTableError: the folder
    holds no batch, or a damaged one.
    """
    rows = read_batch(folder)
    root = labelled(
        {
            **{key: ("case", np.array([getattr(r, key) for r in rows], str)) for key in _TEXTS},
            "warnings": ("case", np.array(["\n".join(row.warnings) for row in rows], str)),
            "seconds": ("case", [row.seconds for row in rows]),
            "peak_memory_gib": ("case", [row.peak_memory_gib for row in rows]),
            "ranks": ("case", [row.ranks for row in rows]),
        }
    )
    tree = {
        "critical_speeds": _critical_speeds(rows),
        "campbell": _campbell(rows),
        "responses": labelled(
            {
                name: ("case", [row.responses.get(name, float("nan")) for row in rows])
                for name in sorted({name for row in rows for name in row.responses})
            }
        ),
    }
    parameters = _parameters(rows)
    beside = {name: _beside(found, rows, parameters) for name, found in {"/": root, **tree}.items()}
    return xr.DataTree.from_dict(beside, name=Path(folder).resolve().name)


def _parameters(rows: Sequence[BatchRow]) -> dict[str, Labelled]:
    """A value for each case by parameter; those with a text among them are texts."""
    out: dict[str, Labelled] = {}
    for name in dict.fromkeys(name for row in rows for name in row.values):
        values: list[Any] = [row.values.get(name) for row in rows]
        if any(isinstance(value, str) for value in values):
            texts = ["" if value is None else str(value) for value in values]
            out[name] = ("case", np.array(texts, dtype=str))
        else:
            out[name] = ("case", np.array(values, dtype=float))
    return out


def _beside(
    found: xr.Dataset, rows: Sequence[BatchRow], parameters: Mapping[str, Labelled]
) -> xr.Dataset:
    """The dataset with cases and parameters as coordinates; a name that is taken gets a longer."""
    taken = {*map(str, found.variables), *_DIMENSIONS}
    named = {f"parameter_{n}" if n in taken else n: values for n, values in parameters.items()}
    case = ("case", np.array([row.case for row in rows], dtype=str))
    return found.assign_coords(labelled({}, {"case": case, **named}).coords)


def _padded(rows: Sequence[Sequence[float]], count: int) -> list[list[float]]:
    return [[*row, *[float("nan")] * (count - len(row))] for row in rows]


def _critical_speeds(rows: Sequence[BatchRow]) -> xr.Dataset:
    """Filled up to the case that has most."""
    count = max((len(row.critical_speed_rpm) for row in rows), default=0)
    over = ("case", "critical_speed")
    variables: dict[str, Labelled] = {}
    for key in _CRITICAL:
        values = _padded([getattr(row, f"critical_{key}") for row in rows], count)
        variables[key] = (over, np.array(values, dtype=float).reshape(len(rows), count))
    for key in ("whirl", "kind"):
        owns = [getattr(row, f"critical_{key}") for row in rows]
        words = [[*own, *[""] * (count - len(own))] for own in owns]
        variables[key] = (over, np.array(words, dtype=str).reshape(len(rows), count))
    return labelled(variables)


def _campbell(rows: Sequence[BatchRow]) -> xr.Dataset:
    """Along speed_rpm where all cases that have a diagram have its speeds, else along speed."""
    speeds = {row.campbell_speed_rpm for row in rows if row.campbell_speed_rpm}
    branches = max((len(row.campbell_frequency_hz) for row in rows), default=0)
    most = max((len(s) for s in speeds), default=0)
    shared = len(speeds) == 1
    last = "speed_rpm" if shared else "speed"
    variables: dict[str, Labelled] = {}
    for key in _CAMPBELL:
        values = np.full((len(rows), branches, most), np.nan)
        for k, row in enumerate(rows):
            for b, branch in enumerate(getattr(row, f"campbell_{key}")):
                values[k, b, : len(branch)] = branch
        variables[key] = (("case", "branch", last), values)
    if shared:
        return labelled(
            variables, {"speed_rpm": ("speed_rpm", np.array(next(iter(speeds)), dtype=float))}
        )
    own = np.array(_padded([row.campbell_speed_rpm for row in rows], most), dtype=float)
    return labelled(variables, {"speed_rpm": (("case", "speed"), own.reshape(len(rows), most))})
