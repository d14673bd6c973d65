"""A whole run as a tree of datasets, in memory or from its folder."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import xarray as xr

from solidwhirl.datasets_analyses import analysis_dataset, peaks_dataset, run_up_record
from solidwhirl.datasets_batch import batch_datasets, is_batch
from solidwhirl.datasets_parts import Labelled, error_parts, filled, labelled
from solidwhirl.pipeline import Results
from solidwhirl.results import SCHEMA, results_document

Document = Mapping[str, Any]


def datasets(run: Results | str | Path) -> xr.DataTree:
    """Return all results of a run, or the table of a batch, as a tree of datasets.

    Parameters
    ----------
    run
        What `run_scene` returned, the folder of a run, or the folder of a batch.

    Returns
    -------
    DataTree
        campbell, critical_speeds, modes_at_rest, bodies, where the scene has them references, and
        analyses with one group for each by its name, and peaks with one for each that has
        resonance peaks. Variables have the names of results.json, and units and long_name as
        attributes. Of a batch the tree of `solidwhirl.datasets_batch.batch_datasets`.

    Raises
    ------
    ValueError
        The folder holds neither results of a run nor a batch.
    """
    if not isinstance(run, Results) and is_batch(Path(run)):
        return batch_datasets(run)
    document, records = _in_memory(run) if isinstance(run, Results) else _in_folder(Path(run))
    scene, accuracy = document["scene"], document["accuracy"]
    about = {"scene": scene["name"], "title": scene["title"], "scene_sha256": scene["sha256"]}
    about |= {"accuracy_asked": accuracy["asked"]}
    if accuracy["largest_error_estimate"] is not None:
        about |= {"largest_error_estimate": accuracy["largest_error_estimate"]}
    tree = {
        "/": xr.Dataset(attrs=about),
        "campbell": _campbell(document["campbell"]),
        "critical_speeds": _critical_speeds(document["critical_speeds"]),
        "modes_at_rest": _modes_at_rest(document["modes_at_rest"]),
        "bodies": _bodies(document["bodies"]),
    }
    if document.get("references"):
        tree["references"] = _table("reference", document["references"])
    for name, found in document["analyses"].items():
        tree[f"analyses/{name}"] = analysis_dataset(found)
        peaks = peaks_dataset(found)
        if peaks is not None:  # not below the analysis, whose axes it would inherit
            tree[f"peaks/{name}"] = peaks
        if name in records:
            tree[f"analyses/{name}/record"] = run_up_record(records[name], found["mount"])
    return xr.DataTree.from_dict(tree, name=scene["name"])


def _in_memory(run: Results) -> tuple[Document, Mapping[str, Document]]:
    return results_document(run), _records_in_memory(run)


def _in_folder(folder: Path) -> tuple[Document, Mapping[str, Document]]:
    document = _read(folder)
    return document, _records_in_folder(folder, document)


def _read(folder: Path) -> Document:
    path = folder / "results.json"
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"{folder}: no folder of a run: {path.name}: {error.strerror}") from error
    schema = document.get("schema") if isinstance(document, dict) else None
    if schema != SCHEMA:
        raise ValueError(f"{path}: schema is {schema!r}, {SCHEMA!r} is what can be read")
    found: Document = document
    return found


def _records_in_folder(folder: Path, document: Document) -> Mapping[str, Document]:
    """Records over time of the run-ups whose files are there."""
    runs = [name for name, found in document["analyses"].items() if found["kind"] == "run_up"]
    there = {name: folder / f"{name}.npz" for name in runs}
    return {name: _arrays(path) for name, path in there.items() if path.is_file()}


def _records_in_memory(results: Results) -> Mapping[str, Document]:
    """The same, from the functions that write them."""
    out = {}
    for name, outcome in results.analyses.items():
        write = outcome.files.get(f"{name}.npz")
        if outcome.kind == "run_up" and write is not None:
            with TemporaryDirectory() as folder:
                path = Path(folder) / "record.npz"
                write(path)
                out[name] = _arrays(path)
    return out


def _arrays(path: Path) -> Document:
    with np.load(path) as file:
        return dict(file)


def _with_errors(
    variables: dict[str, Labelled],
    coordinates: dict[str, Labelled],
    document: Document,
    over: tuple[str, ...],
) -> None:
    if "frequency_error_estimate" not in document:
        return
    estimate = filled(document["frequency_error_estimate"]).astype(float)
    variables["frequency_error_estimate"] = (over, estimate)
    if document["error_parts"]:
        variables["error_parts"], coordinates["error_part"] = error_parts(
            document["error_parts"], over
        )


def _campbell(document: Document) -> xr.Dataset:
    over = ("branch", "speed_rpm")
    variables: dict[str, Labelled] = {
        key: (over, document[key]) for key in ("frequency_hz", "log_decrement", "whirl")
    }
    count = len(document["frequency_hz"])
    coordinates: dict[str, Labelled] = {
        "branch": ("branch", np.arange(1, count + 1)),
        "speed_rpm": ("speed_rpm", document["speed_rpm"]),
    }
    _with_errors(variables, coordinates, document, over)
    notes = [note["text"] for note in document["notes"]]
    return labelled(variables, coordinates, frame=document["frame"], notes=notes)


def _critical_speeds(document: list[Document]) -> xr.Dataset:
    over = "critical_speed"
    keys = ("speed_rpm", "frequency_hz", "log_decrement")
    variables: dict[str, Labelled] = {
        key: (over, np.array([c[key] for c in document], dtype=float)) for key in keys
    }
    variables["whirl"] = (over, np.array([c["whirl"] for c in document], dtype=str))
    excited = [", ".join(c["excited_by"]) for c in document]
    variables["excited_by"] = (over, np.array(excited, dtype=str))
    coordinates: dict[str, Labelled] = {over: (over, np.arange(1, len(document) + 1))}
    if document and "frequency_error_estimate" in document[0]:
        parts = {p: [c["error_parts"][p] for c in document] for p in document[0]["error_parts"]}
        total = [c["frequency_error_estimate"] for c in document]
        errors = {"frequency_error_estimate": total, "error_parts": parts}
        _with_errors(variables, coordinates, errors, (over,))
    return labelled(variables, coordinates)


def _modes_at_rest(document: Document) -> xr.Dataset:
    variables: dict[str, Labelled] = {"frequency_hz": ("mode", document["frequency_hz"])}
    count = len(document["frequency_hz"])
    coordinates: dict[str, Labelled] = {"mode": ("mode", np.arange(1, count + 1))}
    _with_errors(variables, coordinates, document, ("mode",))
    return labelled(variables, coordinates)


def _bodies(document: Document) -> xr.Dataset:
    bodies = list(document.values())
    numbers = ("mass_kg", "polar_inertia_kg_m2", "diametral_inertia_kg_m2")
    variables: dict[str, Labelled] = {
        key: ("body", np.array([b[key] for b in bodies], dtype=float)) for key in numbers
    }
    centres = [b["center_of_gravity_m"] for b in bodies]
    variables["center_of_gravity_m"] = (("body", "axis"), np.array(centres, dtype=float))
    for key in ("level", "full_dofs", "reduced_dofs"):
        variables[key] = ("body", [b[key] for b in bodies])
    return labelled(
        variables, {"body": ("body", list(document)), "axis": ("axis", ["x", "y", "z"])}
    )


def _table(dim: str, rows: list[Document]) -> xr.Dataset:
    """Rows with the same keys; what is neither number nor text is left out."""
    plain = (str, int, float, type(None))
    keys = [key for key in rows[0] if all(isinstance(row.get(key), plain) for row in rows)]
    return labelled(
        {key: (dim, filled([row.get(key) for row in rows])) for key in keys},
        {dim: (dim, np.arange(1, len(rows) + 1))},
    )
