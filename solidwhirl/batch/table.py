"""The table of a batch: one HDF5 file, made from the journal, for h5py and numpy alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from solidwhirl.batch import journal
from solidwhirl.batch.journal import SCHEMA, BatchTableError
from solidwhirl.core.errors import writing
from solidwhirl.core.key_units import unit_of
from solidwhirl.files.run_folder import JOURNAL
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.atomic import replacing
from solidwhirl.sweep.records import BatchRow, in_order

TABLE = "table.h5"
_TEXTS = ("case", "scene", "status", "message", "warnings", "digest", "method")
_NUMBERS = ("seconds", "peak_memory_gib")
_COUNTS = ("ranks", "sweep_cases")
_CRITICAL = ("critical_speed_rpm", "critical_frequency_hz", "critical_error_estimate")
_CAMPBELL = ("campbell_frequency_hz", "campbell_log_decrement")
_CRITICAL_WORDS = ("critical_whirl", "critical_kind")
_MOTIONS = ("critical_motion", "campbell_motion")
_COUNTED = {
    "critical_count": "critical_speed_rpm",
    "campbell_speed_count": "campbell_speed_rpm",
    "campbell_branch_count": "campbell_frequency_hz",
}
# What the file says of its datasets, and of groups for all in them: unit ("" without), meaning.
_ABOUT = {
    "case": ("", "name of the case and of its folder; one row for each, by scene and number"),
    "scene": ("", "name of the scene"),
    "status": ("", "done, failed (no results), checks_failed (results that violate an invariant)"),
    "message": ("", "why, where it is not done; bodies without an error estimate"),
    "warnings": ("", "warnings of its run, one a line"),
    "digest": ("", "SHA-256 of the case and its options"),
    "method": ("", "how the sweep takes its values; empty without a sweep"),
    "sweep_cases": ("", "cases of the sweep; 0 without"),
    "seconds": ("s", "wall time"),
    "peak_memory_gib": ("GiB", "largest resident memory of one process"),
    "ranks": ("", "processes that computed the case"),
    "values": ("", "parameters of the sweep; nan where a case has none, or a text"),
    "value_texts": ("", "texts of parameters that have any; else empty"),
    "critical_count": ("", "critical speeds of the case; nan fills the rest of its rows"),
    "critical_speed_rpm": ("rpm", "critical speeds of the reference shaft, rising (case, number)"),
    "critical_frequency_hz": ("Hz", "their frequencies (case, number)"),
    "critical_error_estimate": ("1", "relative, of speed and frequency (case, number)"),
    "critical_whirl": ("", "forward, backward, torsional, ... (case, number)"),
    "critical_kind": ("", "lateral, torsional, axial, disk, coupled (case, number)"),
    "critical_motion": ("1", "lateral motion of interfaces, unit length (case, number, 4 each)"),
    "campbell_speed_count": ("", "speeds of the case's diagram"),
    "campbell_branch_count": ("", "branches of the case's diagram"),
    "campbell_speed_rpm": ("rpm", "speeds of the reference shaft (case, speed)"),
    "campbell_frequency_hz": ("Hz", "natural frequencies (case, branch, speed)"),
    "campbell_log_decrement": ("1", "logarithmic decrements (case, branch, speed)"),
    "campbell_motion": ("1", "lateral motion of interfaces, unit length (case, branch, 4 each)"),
    "responses": ("", "results of [[analyses]], <analysis>.<quantity>; nan where absent"),
}
_UTF8 = h5py.string_dtype("utf-8")


def read_batch(folder: str | Path) -> tuple[BatchRow, ...]:
    """Read the rows of a batch, by scene and number of the case.

    `folder`: the folder of the batch; its journal is read, or its table where there is no journal.
    Raises BatchTableError: there is neither, or it is damaged.
    """
    folder = Path(folder)
    if (folder / JOURNAL).exists():
        return in_order(journal.read_journal(folder))
    if not (folder / TABLE).exists():
        raise BatchTableError(f"{folder}: has neither {JOURNAL} nor {TABLE}; it is no batch")
    return read_table(folder / TABLE)


def write_table(folder: str | Path) -> Path:
    """Make the table of a batch from its journal; readers see the old table or the new one.

    Returns the table.
    Raises BatchTableError: there is no journal, or it is damaged; OutputError: the table can't be
    written.
    """
    path = Path(folder) / TABLE
    rows = in_order(journal.read_journal(folder))
    with writing(path), replacing(path) as temporary, h5py.File(temporary, "w") as file:
        _write(file, rows)
    return path


def read_table(path: str | Path) -> tuple[BatchRow, ...]:
    """Read a table; its rows are those of the journal that it was made from.

    Raises BatchTableError: it can't be read, or is no table of a batch.
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
    # texts with what JSON can not have escaped, as in the journal
    documents = [journal.row_document(row) for row in rows]
    documents = [{**d, "warnings": "\n".join(d["warnings"])} for d in documents]
    for key in _TEXTS:
        _put_texts(file, key, [document[key] for document in documents])
    for key in _NUMBERS:
        file[key] = np.array([getattr(row, key) for row in rows], dtype=np.float64)
    for key in _COUNTS:
        file[key] = np.array([getattr(row, key) for row in rows], dtype=np.int64)
    _write_values(file, rows)
    for key, counted in _COUNTED.items():
        file[key] = np.array([len(getattr(row, counted)) for row in rows], dtype=np.int64)
    for key in (*_CRITICAL, "campbell_speed_rpm"):
        file[key] = _padded([getattr(row, key) for row in rows])
    width = max((len(row.critical_whirl) for row in rows), default=0)
    for key in _CRITICAL_WORDS:
        words = [[*own, *[""] * (width - len(own))] for own in (getattr(row, key) for row in rows)]
        _put_texts(file, key, np.array(words, dtype=object).reshape(len(rows), width))
    for key in (*_MOTIONS, *_CAMPBELL):
        _put_tables(file, key, [getattr(row, key) for row in rows])
    group = file.create_group("responses")
    for name in sorted({name for row in rows for name in row.responses}):
        group[name] = np.array([row.responses.get(name, np.nan) for row in rows])
    for name, node in file.items():
        _tell(node, *_ABOUT[name])


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


def _put_tables(file: Any, key: str, cases: Sequence[Sequence[Sequence[float]]]) -> None:
    """One table for each case, filled up with nan; case by case: together they may be large."""
    length = max((len(line) for own in cases for line in own), default=0)
    shape = (len(cases), max(map(len, cases), default=0), length)
    if 0 in shape:
        file.create_dataset(key, shape, np.float64)
        return
    dataset = file.create_dataset(
        key, shape, np.float64, fillvalue=np.nan, chunks=(1, *shape[1:]), compression="gzip"
    )
    for k, own in enumerate(cases):
        if own:
            dataset[k, : len(own)] = _padded(own, length)


def _put_texts(holder: Any, name: str, texts: Any) -> None:
    array = np.asarray(texts, dtype=object)
    holder.create_dataset(name, array.shape, _UTF8, data=array if array.size else None)


def _padded(lists: Sequence[Sequence[float]], length: int | None = None) -> FloatArray:
    """Rows of different lengths as one array, filled up with nan."""
    out = np.full((len(lists), length or max(map(len, lists), default=0)), np.nan)
    for row, values in zip(out, lists, strict=True):
        row[: len(values)] = values
    return out


def _read(file: Any) -> tuple[BatchRow, ...]:
    """Through the rows' documents, so that one place knows what a row is."""
    absent = {key for key in journal.LATER if key not in file}
    texts, counts, motions = (
        [key for key in keys if key not in absent] for keys in (_TEXTS, _COUNTS, _MOTIONS)
    )
    critical_words = [key for key in _CRITICAL_WORDS if key not in absent]
    columns = {key: file[key].asstr()[()] for key in (*texts, *critical_words)}
    names = (*counts, *motions, *_NUMBERS, *_CRITICAL, "campbell_speed_rpm", *_COUNTED)
    columns |= {key: file[key][()] for key in names}
    groups = {name: file[name].items() for name in ("values", "value_texts", "responses")}
    numbers = {name: node[()] for name, node in groups["values"]}
    words = {name: node.asstr()[()] for name, node in groups["value_texts"]}
    responses = {name: node[()] for name, node in groups["responses"]}
    rows = []
    for k in range(len(columns["case"])):
        critical, speeds, branches = (int(columns[key][k]) for key in _COUNTED)
        document: dict[str, Any] = {"schema": SCHEMA}
        document |= {key: columns[key][k] for key in texts}
        document["warnings"] = document.get("warnings", "").splitlines()
        document |= {key: columns[key][k].item() for key in (*counts, *_NUMBERS)}
        for key in (*_CRITICAL, *critical_words):
            document[key] = columns[key][k, :critical].tolist()
        if not any(document.get("critical_kind", ())):  # as of earlier releases
            document["critical_kind"] = []
        for key in motions:
            own = [m[~np.isnan(m)].tolist() for m in columns[key][k]]
            document[key] = [motion for motion in own if motion]
        document["campbell_speed_rpm"] = columns["campbell_speed_rpm"][k, :speeds].tolist()
        for key in _CAMPBELL:
            document[key] = file[key][k, :branches, :speeds].tolist()
        document["values"] = _present(numbers, k) | {n: w[k] for n, w in words.items() if w[k]}
        document["responses"] = _present(responses, k)
        rows.append(journal.row_from_document(document))
    return tuple(rows)


def _present(columns: Mapping[str, FloatArray], row: int) -> dict[str, Any]:
    """What a row has of some columns; nan is nothing."""
    return {name: float(c[row]) for name, c in columns.items() if not np.isnan(c[row])}
