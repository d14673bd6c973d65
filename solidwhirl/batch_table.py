"""The table of a batch: one HDF5 file, made from the journal, for h5py and numpy alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from solidwhirl.batch_journal import (
    JOURNAL,
    SCHEMA,
    BatchTableError,
    in_order,
    read_journal,
    row_document,
    row_from_document,
)
from solidwhirl.errors import OutputError
from solidwhirl.rotordyn.atomic import replacing
from solidwhirl.sweep_labels import unit_of
from solidwhirl.sweep_records import BatchRow

TABLE = "table.h5"
_TEXTS = ("case", "scene", "status", "message", "digest")
_NUMBERS = ("seconds", "peak_memory_gib")
_CRITICAL = ("critical_speed_rpm", "critical_frequency_hz", "critical_error_estimate")
_CAMPBELL = ("campbell_frequency_hz", "campbell_log_decrement")
# What the file says of its datasets, and of groups for all in them: unit ("" without), meaning.
_ABOUT = {
    "case": ("", "name of the case and of its folder; one row for each, by scene and number"),
    "scene": ("", "name of the scene"),
    "status": ("", "done, failed (no results), checks_failed (results that violate an invariant)"),
    "message": ("", "why, where it is not done"),
    "digest": ("", "SHA-256 of the case and its options"),
    "seconds": ("s", "wall time"),
    "peak_memory_gib": ("GiB", "largest resident memory of one process"),
    "ranks": ("", "processes that computed the case"),
    "values": ("", "parameters of the sweep; nan where a case has none, or a text"),
    "value_texts": ("", "texts of parameters that have any; else empty"),
    "critical_count": ("", "critical speeds of the case; nan fills the rest of its rows"),
    "critical_speed_rpm": ("rpm", "critical speeds of the reference shaft, rising (case, number)"),
    "critical_frequency_hz": ("Hz", "their frequencies (case, number)"),
    "critical_error_estimate": ("1", "relative, of speed and frequency (case, number)"),
    "critical_whirl": ("", "forward, backward, ... (case, number)"),
    "critical_motion": ("1", "lateral motion of interfaces, unit length (case, number, 4 each)"),
    "campbell_speed_count": ("", "speeds of the case's diagram"),
    "campbell_branch_count": ("", "branches of the case's diagram"),
    "campbell_speed_rpm": ("rpm", "speeds of the reference shaft (case, speed)"),
    "campbell_frequency_hz": ("Hz", "natural frequencies (case, branch, speed)"),
    "campbell_log_decrement": ("1", "logarithmic decrements (case, branch, speed)"),
    "responses": ("", "results of [[analyses]], <analysis>.<quantity>; nan where absent"),
}
_UTF8 = h5py.string_dtype("utf-8")
Floats = npt.NDArray[np.float64]


def read_batch(folder: str | Path) -> tuple[BatchRow, ...]:
    """Read the rows of a batch, by scene and number of the case.

    Parameters
    ----------
    folder
        The folder of the batch; its journal is read, or its table where there is no journal.

    Raises
    ------
    BatchTableError
        There is neither, or it is damaged.
    """
    folder = Path(folder)
    if (folder / JOURNAL).exists():
        return in_order(read_journal(folder))
    if not (folder / TABLE).exists():
        raise BatchTableError(f"{folder}: has neither {JOURNAL} nor {TABLE}; it is no batch")
    return read_table(folder / TABLE)


def write_table(folder: str | Path) -> Path:
    """Make the table of a batch from its journal; readers see the old table or the new one.

    Parameters
    ----------
    folder
        The folder of the batch.

    Returns
    -------
    The table.

    Raises
    ------
    BatchTableError
        There is no journal, or it is damaged.
    OutputError
        The table can't be written.
    """
    path = Path(folder) / TABLE
    rows = in_order(read_journal(folder))
    try:
        with replacing(path) as temporary, h5py.File(temporary, "w") as file:
            _write(file, rows)
    except OSError as error:
        said = error.strerror or str(error).splitlines()[0]
        raise OutputError(f"{path}: can not be written: {said}") from error
    return path


def read_table(path: str | Path) -> tuple[BatchRow, ...]:
    """Read a table; its rows are those of the journal that it was made from.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    BatchTableError
        It can't be read, or is no table of a batch.
    """
    try:
        with h5py.File(path, "r") as file:
            schema = file.attrs.get("schema")
            if schema != SCHEMA:
                raise BatchTableError(f"{path}: its schema is {schema!r}; {SCHEMA!r} is known")
            return _read(file)
    except BatchTableError as error:
        raise BatchTableError(f"{path}: {str(error).removeprefix(f'{path}: ')}") from error
    except (OSError, KeyError, TypeError, ValueError, IndexError) as error:
        raise BatchTableError(f"{path}: is no table of a batch: {error}") from error


def _write(file: Any, rows: Sequence[BatchRow]) -> None:
    file.attrs["schema"] = SCHEMA
    for key in _TEXTS:
        _put_texts(file, key, [getattr(row, key) for row in rows])
    # with what JSON can not have escaped, as in the journal
    _replace_texts(file, "message", [row_document(row)["message"] for row in rows])
    for key in _NUMBERS:
        file[key] = np.array([getattr(row, key) for row in rows], dtype=np.float64)
    file["ranks"] = np.array([row.ranks for row in rows], dtype=np.int64)
    _write_values(file, rows)
    file["critical_count"] = np.array([len(r.critical_speed_rpm) for r in rows], dtype=np.int64)
    for key in _CRITICAL:
        file[key] = _padded([getattr(row, key) for row in rows])
    width = max((len(row.critical_whirl) for row in rows), default=0)
    _write_motions(file, rows, width)
    whirls = [[*row.critical_whirl, *[""] * (width - len(row.critical_whirl))] for row in rows]
    _put_texts(file, "critical_whirl", np.array(whirls, dtype=object).reshape(len(rows), width))
    _write_diagrams(file, rows)
    group = file.create_group("responses")
    for name in sorted({name for row in rows for name in row.responses}):
        group[name] = np.array([row.responses.get(name, np.nan) for row in rows])
    for name, node in file.items():
        _tell(node, *_ABOUT[name])


def _write_motions(file: Any, rows: Sequence[BatchRow], width: int) -> None:
    """Of fewer interfaces or critical speeds nan fills the rest."""
    length = max((len(m) for row in rows for m in row.critical_motion), default=0)
    motions = np.full((len(rows), width, length), np.nan)
    for k, row in enumerate(rows):
        for number, motion in enumerate(row.critical_motion):
            motions[k, number, : len(motion)] = motion
    file["critical_motion"] = motions


def _tell(node: Any, unit: str, holds: str) -> None:
    """Attributes of a dataset, or of all in a group: there the unit is that in the name."""
    node.attrs["holds"] = holds
    for name, one in node.items() if isinstance(node, h5py.Group) else ():
        _tell(one, unit_of(name), holds)
    if isinstance(node, h5py.Dataset):
        node.attrs["unit"] = unit


def _write_values(file: Any, rows: Sequence[BatchRow]) -> None:
    """Each parameter is a column of numbers, and one of texts if a case has a text for it."""
    numbers, texts = file.create_group("values"), file.create_group("value_texts")
    for name in dict.fromkeys(name for row in rows for name in row.values):
        found = [row.values.get(name, np.nan) for row in rows]
        numbers[name] = np.array([np.nan if isinstance(v, str) else v for v in found], np.float64)
        if any(isinstance(v, str) for v in found):
            _put_texts(texts, name, [v if isinstance(v, str) else "" for v in found])


def _write_diagrams(file: Any, rows: Sequence[BatchRow]) -> None:
    """Row by row: together they may be far larger than each is."""
    speeds = [len(row.campbell_speed_rpm) for row in rows]
    branches = [len(row.campbell_frequency_hz) for row in rows]
    file["campbell_speed_count"] = np.array(speeds, dtype=np.int64)
    file["campbell_branch_count"] = np.array(branches, dtype=np.int64)
    file["campbell_speed_rpm"] = _padded([row.campbell_speed_rpm for row in rows])
    shape = (len(rows), max(branches, default=0), max(speeds, default=0))
    for key in _CAMPBELL:
        if 0 in shape:
            file.create_dataset(key, shape, np.float64)
            continue
        dataset = file.create_dataset(
            key, shape, np.float64, fillvalue=np.nan, chunks=(1, *shape[1:]), compression="gzip"
        )
        for k, row in enumerate(rows):
            if speeds[k] and branches[k]:
                dataset[k, : branches[k], : speeds[k]] = np.array(getattr(row, key))


def _put_texts(holder: Any, name: str, texts: Any) -> None:
    array = np.asarray(texts, dtype=object)
    holder.create_dataset(name, array.shape, _UTF8, data=array if array.size else None)


def _replace_texts(holder: Any, name: str, texts: list[str]) -> None:
    del holder[name]
    _put_texts(holder, name, texts)


def _padded(lists: Sequence[Sequence[float]]) -> Floats:
    """Rows of different lengths as one array, filled up with nan."""
    out = np.full((len(lists), max(map(len, lists), default=0)), np.nan)
    for row, values in zip(out, lists, strict=True):
        row[: len(values)] = values
    return out


def _read(file: Any) -> tuple[BatchRow, ...]:
    """Through the rows' documents, so that one place knows what a row is."""
    columns = {key: file[key].asstr()[()] for key in (*_TEXTS, "critical_whirl")}
    counts = ("critical_count", "campbell_speed_count", "campbell_branch_count")
    names = (*_NUMBERS, "ranks", *_CRITICAL, "campbell_speed_rpm", *counts)
    columns |= {key: file[key][()] for key in names}
    numbers = {name: node[()] for name, node in file["values"].items()}
    texts = {name: node.asstr()[()] for name, node in file["value_texts"].items()}
    responses = {name: node[()] for name, node in file["responses"].items()}
    motions = file["critical_motion"][()] if "critical_motion" in file else None
    rows = []
    for k in range(len(columns["case"])):
        critical, speeds, branches = (int(columns[key][k]) for key in counts)
        document: dict[str, Any] = {"schema": SCHEMA}
        document |= {key: columns[key][k] for key in (*_TEXTS, *_NUMBERS, "ranks")}
        keys = (*_CRITICAL, "critical_whirl")
        document |= {key: list(columns[key][k, :critical]) for key in keys}
        if motions is not None:
            document["critical_motion"] = [m[~np.isnan(m)].tolist() for m in motions[k, :critical]]
            if not any(document["critical_motion"]):
                document["critical_motion"] = []
        document["campbell_speed_rpm"] = list(columns["campbell_speed_rpm"][k, :speeds])
        for key in _CAMPBELL:
            document[key] = file[key][k, :branches, :speeds].tolist()
        document["values"] = _present(numbers, k) | {n: t[k] for n, t in texts.items() if t[k]}
        document["responses"] = _present(responses, k)
        rows.append(row_from_document(document))
    return tuple(rows)


def _present(columns: Mapping[str, Floats], row: int) -> dict[str, Any]:
    """What a row has of some columns; nan is nothing."""
    return {name: c[row] for name, c in columns.items() if not np.isnan(c[row])}
