"""Results as xarray datasets: named dimensions, coordinates with units, errors as variables.

`datasets` opens a whole run, in memory or from its folder; the other functions take one record of
`solidwhirl.rotordyn`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from solidwhirl import rotordyn as rd
from solidwhirl.analyses.base import record_of
from solidwhirl.analyses.kinds.critical_speed_map import CriticalSpeedMapSpec
from solidwhirl.analyses.registry import KINDS
from solidwhirl.core.plain_data import Labelled
from solidwhirl.datasets.batch import batch_datasets, is_batch
from solidwhirl.datasets.files import read_netcdf, write_netcdf
from solidwhirl.datasets.parts import filled, labelled, tabled, with_errors
from solidwhirl.output.documents import SCHEMA, results_document
from solidwhirl.pipeline.engine_stages import ExcitedCriticalSpeed
from solidwhirl.pipeline.run import Results
from solidwhirl.rotordyn.core.foreign import ForeignError, json_data, regular_bytes
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.critical_speeds.map import CriticalSpeedMap
from solidwhirl.rotordyn.response.maps import GroundMotionMap
from solidwhirl.rotordyn.response.unbalance import UnbalanceResponse
from solidwhirl.rotordyn.run_up.record import RunUp

__all__ = [
    "campbell_dataset",
    "critical_speed_dataset",
    "critical_speed_map_dataset",
    "datasets",
    "ground_motion_dataset",
    "modes_dataset",
    "read_netcdf",
    "run_up_dataset",
    "unbalance_dataset",
    "write_netcdf",
]

_AXES = ["x", "y", "z"]
# Dimensions of the arrays of the diagram, and of modes at one speed.
_CAMPBELL = dict.fromkeys(
    ("frequency_hz", "log_decrement", "whirl", "eigenvalue_per_s"), ("branch", "speed_rpm")
)
_MODES = {
    **dict.fromkeys(
        ("frequency_hz", "log_decrement", "damping_ratio", "eigenvalue_per_s"), ("mode",)
    ),
    "shape": ("coordinate", "mode"),
}
Document = Mapping[str, Any]
_PEAK_NUMBERS = ("speed_rpm", "frequency_hz", "amplitude_m", "amplification")
_PEAK_ERRORS = ("frequency_error_estimate", "amplitude_error_estimate")
_Errors = rd.CampbellErrors | rd.CriticalSpeedErrors | rd.FrequencyErrors | None


def datasets(run: Results | str | Path) -> xr.DataTree:
    """Return all results of a run, or the table of a batch, as a tree of datasets.

    `run`: what `run_scene` returned, the folder of a run, or the folder of a batch. Returns
    campbell, critical_speeds, modes_at_rest, bodies, where the scene has them references, and
    analyses with one group for each by its name, and peaks with one for each that has resonance
    peaks. Variables have the names of results.json, and units and long_name as attributes. Of a
    batch the tree of `solidwhirl.datasets.batch.batch_datasets`. Raises ValueError: the folder
    holds neither results of a run nor a batch.
    """
    if not isinstance(run, Results) and is_batch(Path(run)):
        return batch_datasets(run)
    document: Document
    records: Mapping[str, Document]
    if isinstance(run, Results):
        document = results_document(run)
        records = {name: record_of(run.analyses[name], name) for name in _recorded(document)}
    else:
        document = _read(Path(run))
        records = _records_in_folder(Path(run), document)
    scene, accuracy = document["scene"], document["accuracy"]
    about = {"scene": scene["name"], "title": scene["title"], "scene_sha256": scene["sha256"]}
    about |= {"accuracy_asked": accuracy["asked"]}
    if accuracy["largest_error_estimate"] is not None:
        about |= {"largest_error_estimate": accuracy["largest_error_estimate"]}
    tree = {
        "/": xr.Dataset(attrs=about),
        "campbell": _campbell(document["campbell"]),
        "critical_speeds": _critical_speeds(document["critical_speeds"]),
        "modes_at_rest": _modes(document["modes_at_rest"]),
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
            tree[f"analyses/{name}/record"] = record_dataset(records[name], found)
    return xr.DataTree.from_dict(tree, name=scene["name"])


def _read(folder: Path) -> Document:
    path = folder / "results.json"
    try:
        document = json_data(regular_bytes(path))
    except ForeignError as error:
        raise ValueError(f"{folder}: no folder of a run: {path.name}: {error}") from error
    schema = document.get("schema") if isinstance(document, dict) else None
    if schema != SCHEMA:
        raise ValueError(f"{path}: schema is {schema!r}, {SCHEMA!r} is what can be read")
    found: Document = document
    return found


def _records_in_folder(folder: Path, document: Document) -> Mapping[str, Document]:
    """Records over time of the analyses whose files are there."""
    there = {name: folder / f"{name}.npz" for name in _recorded(document)}
    found = {}
    for name, path in there.items():
        if path.is_file():
            with np.load(path) as file:
                found[name] = dict(file)
    return found


def _recorded(document: Document) -> list[str]:
    """Analyses that have a record over time."""
    return [name for name, a in document["analyses"].items() if KINDS[a["kind"]].has_record]


def campbell_dataset(campbell: rd.Campbell, errors: rd.CampbellErrors | None = None) -> xr.Dataset:
    """Return a Campbell diagram as a dataset.

    `campbell`: the diagram, b branches at s speeds. `errors`: their estimates; None leaves them
    out. Returns frequency_hz, log_decrement, eigenvalue_per_s, whirl ("" where a branch has ended)
    over (branch, speed_rpm), with errors frequency_error_estimate and error_parts.
    """
    document = {
        "frequency_hz": campbell.frequency_hz,
        "log_decrement": campbell.log_decrement,
        "whirl": campbell.whirl,
        "eigenvalue_per_s": campbell.eigenvalues,
        "speed_rpm": campbell.speeds_rad_s * RPM_PER_RAD_S,
        "frame": "inertial",
        "notes": [{"text": note.text} for note in campbell.notes],
    }
    return _campbell(document | _errors_document(errors))


def modes_dataset(modes: rd.Modes, errors: rd.FrequencyErrors | None = None) -> xr.Dataset:
    """Return the modes of a system at one speed as a dataset.

    `modes`: m of them. `errors`: their estimates; None leaves them out. Returns frequency_hz,
    log_decrement, damping_ratio, eigenvalue_per_s over mode, and shape over (coordinate, mode);
    speed_rpm is a coordinate without dimension.
    """
    document = {
        "frequency_hz": modes.frequency_hz,
        "log_decrement": modes.log_decrement,
        "damping_ratio": modes.damping_ratio,
        "eigenvalue_per_s": modes.eigenvalues,
        "shape": modes.shapes,
    }
    found = _modes(document | _errors_document(errors))
    speed = labelled({}, {"speed_rpm": ((), modes.speed_rad_s * RPM_PER_RAD_S)})
    return found.assign_coords(speed.coords)


def critical_speed_dataset(
    found: Sequence[rd.CriticalSpeed | ExcitedCriticalSpeed],
    errors: rd.CriticalSpeedErrors | None = None,
) -> xr.Dataset:
    """Return critical speeds as a dataset.

    `found`: as `critical_speeds` or a run returns them. `errors`: their estimates, in that order;
    None leaves them out. Returns speed_rpm, frequency_hz, whirl, log_decrement over critical_speed,
    which counts from 1; of a run also excited_by.
    """
    rows = []
    for c in found:
        excited = {"excited_by": c.excited_by} if isinstance(c, ExcitedCriticalSpeed) else {}
        bare = c.critical if isinstance(c, ExcitedCriticalSpeed) else c
        rows.append(
            {
                "speed_rpm": bare.speed_rad_s * RPM_PER_RAD_S,
                "frequency_hz": bare.frequency_hz,
                "whirl": bare.whirl,
                "log_decrement": bare.log_decrement,
                **excited,
            }
        )
    return _critical_speeds(rows, _errors_document(errors))


def critical_speed_map_dataset(found: CriticalSpeedMap) -> xr.Dataset:
    """Return a critical speed map as a dataset.

    `found`: the map, b branches at s stiffnesses. Returns critical_speed_rpm and whirl over
    (branch, stiffness_n_per_m).
    """
    document = {
        "critical_speed_rpm": found.speed_rad_s * RPM_PER_RAD_S,
        "whirl": found.whirl,
        "likeness": found.likeness,
        "stiffness_n_per_m": found.stiffness_n_per_m,
    }
    return tabled(document, CriticalSpeedMapSpec.axes).assign_attrs(
        bearings=list(found.bearings), excitation_ratio=found.excitation_ratio
    )


def unbalance_dataset(response: UnbalanceResponse) -> xr.Dataset:
    """Return a response to unbalance as a dataset.

    `response`: e exciters of different frequency, s speeds. Returns translation_m and tilt_rad over
    (exciter, speed_rpm, node, direction), major_m and minor_m over (exciter, speed_rpm, node),
    force_n and moment_n_m over (exciter, speed_rpm, bearing, axis), frequency_hz over (exciter,
    speed_rpm). Amplitudes are complex, time factor e^{iωt}; those of different exciters have no
    common phase. tilt is about x and y.
    """
    exciters = response.exciters
    orbits = [exciter.orbits() for exciter in exciters]
    forces = np.stack(
        [np.stack(list(e.bearing_forces.values()), axis=1) for e in exciters]
        if exciters[0].bearing_forces
        else [np.empty((len(response.speeds_rad_s), 0, 6), dtype=complex) for _ in exciters]
    )
    at_node = ("exciter", "speed_rpm", "node")
    through = ("exciter", "speed_rpm", "bearing", "axis")
    hertz = np.stack([e.frequencies_rad_s for e in exciters]) / (2.0 * np.pi)
    return labelled(
        {
            "translation_m": (
                (*at_node, "direction"),
                np.stack([e.translation_m for e in exciters]),
            ),
            "tilt_rad": ((*at_node, "direction"), np.stack([e.tilt_rad for e in exciters])),
            "major_m": (at_node, np.stack([o.major_m for o in orbits])),
            "minor_m": (at_node, np.stack([o.minor_m for o in orbits])),
            "force_n": (through, forces[..., :3]),
            "moment_n_m": (through, forces[..., 3:]),
        },
        {
            "exciter": ("exciter", [", ".join(e.bodies) for e in exciters]),
            "speed_rpm": ("speed_rpm", response.speeds_rad_s * RPM_PER_RAD_S),
            "node": ("node", [node.label for node in exciters[0].nodes]),
            "direction": ("direction", _AXES[:2]),
            "bearing": ("bearing", np.array(list(exciters[0].bearing_forces), dtype=str)),
            "axis": ("axis", _AXES),
            "frequency_hz": (("exciter", "speed_rpm"), hertz),
            "frequency_ratio": ("exciter", [e.frequency_ratio for e in exciters]),
        },
    )


def ground_motion_dataset(found: GroundMotionMap) -> xr.Dataset:
    """Return a response to ground motion (a waterfall) as a dataset.

    `found`: the map, s speeds and f frequencies. Returns translation_m, complex, over (speed_rpm,
    frequency_hz, direction), and amplitude_m, the major semi-axis of the orbit, over (speed_rpm,
    frequency_hz).
    """
    over = ("speed_rpm", "frequency_hz")
    return labelled(
        {
            "translation_m": ((*over, "direction"), found.translation_m),
            "amplitude_m": (over, found.major_m()),
        },
        {
            "speed_rpm": ("speed_rpm", found.speeds_rad_s * RPM_PER_RAD_S),
            "frequency_hz": ("frequency_hz", found.frequencies_rad_s / (2.0 * np.pi)),
            "direction": ("direction", _AXES[:2]),
        },
        node=found.node.label,
        ground_amplitude_m=found.amplitude_m,
        ground_direction=found.direction,
    )


def run_up_dataset(run: RunUp) -> xr.Dataset:
    """Return the record of a run-up as a dataset.

    `run`: s times, o interfaces, b bearings. Returns translation_m, rotation_rad and their rates
    over (node, axis, time_s), force_n and moment_n_m over (bearing, axis, time_s), energies over
    time_s. speed_rpm and angle_rad are coordinates along time_s.
    """
    moved, held = ("node", "axis", "time_s"), ("bearing", "axis", "time_s")
    energy = run.energy
    return labelled(
        {
            "translation_m": (moved, run.translation_m),
            "rotation_rad": (moved, run.rotation_rad),
            "velocity_m_per_s": (moved, run.velocity_m_per_s),
            "angular_velocity_rad_per_s": (moved, run.angular_velocity_rad_per_s),
            "force_n": (held, run.force_n),
            "moment_n_m": (held, run.moment_n_m),
            "stored_energy_j": ("time_s", energy.stored_j),
            "load_work_j": ("time_s", energy.load_work_j),
            "drive_work_j": ("time_s", energy.drive_work_j),
            "dissipated_j": ("time_s", energy.dissipated_j),
        },
        {
            "time_s": ("time_s", run.time_s),
            "speed_rpm": ("time_s", run.speed_rad_s * RPM_PER_RAD_S),
            "angle_rad": ("time_s", run.angle_rad),
            "node": ("node", np.array([end.label for end in run.outputs], dtype=str)),
            "bearing": ("bearing", np.array(run.bearings, dtype=str)),
            "axis": ("axis", _AXES),
        },
        step_s=run.step_s,
        notes=list(run.notes),
    )


def _errors_document(errors: _Errors) -> dict[str, Any]:
    if errors is None:
        return {}
    return {"frequency_error_estimate": errors.total, "error_parts": errors.parts}


def _campbell(document: Document) -> xr.Dataset:
    notes = [note["text"] for note in document["notes"]]
    found = tabled(document, _CAMPBELL).assign_attrs(frame=document["frame"], notes=notes)
    return with_errors(found, document, ("branch", "speed_rpm"))


def _modes(document: Document) -> xr.Dataset:
    return with_errors(tabled(document, _MODES), document, ("mode",))


def _critical_speeds(rows: Sequence[Document], errors: Document | None = None) -> xr.Dataset:
    """Rows with their numbers; errors are among them, or of all."""
    over = "critical_speed"
    variables: dict[str, Labelled] = {
        key: (over, np.array([row[key] for row in rows], dtype=float))
        for key in ("speed_rpm", "frequency_hz", "log_decrement")
    }
    variables["whirl"] = (over, np.array([row["whirl"] for row in rows], dtype=str))
    if all("excited_by" in row for row in rows):
        excited = [", ".join(row["excited_by"]) for row in rows]
        variables["excited_by"] = (over, np.array(excited, dtype=str))
    if errors is None and rows and "frequency_error_estimate" in rows[0]:
        parts = {p: [row["error_parts"][p] for row in rows] for p in rows[0]["error_parts"]}
        total = [row["frequency_error_estimate"] for row in rows]
        errors = {"frequency_error_estimate": total, "error_parts": parts}
    return with_errors(labelled(variables), errors or {}, (over,))


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
    return labelled(variables, {"body": ("body", list(document)), "axis": ("axis", _AXES)})


def _table(dim: str, rows: list[Document]) -> xr.Dataset:
    """Rows with the same keys; what is neither number nor text is left out."""
    plain = (str, int, float, type(None))
    keys = [key for key in rows[0] if all(isinstance(row.get(key), plain) for row in rows)]
    return labelled({key: (dim, filled([row.get(key) for row in rows])) for key in keys})


def analysis_dataset(document: Document) -> xr.Dataset:
    """Return one analysis of a run as a dataset.

    Names are those of results.json; single numbers and texts are attributes. Kinds without arrays
    have attributes alone.
    """
    found = KINDS[document["kind"]].labels(document)
    return labelled(*found[:2], **_single(document) | dict(found.attributes))


def peaks_dataset(document: Document) -> xr.Dataset | None:
    """Return the resonance peaks of one analysis as a dataset; None where it has none.

    place, exciter, speed_rpm, frequency_hz, amplitude_m, amplification over peak, which counts
    from 1, and error estimates where there are such.
    """
    peaks = KINDS[document["kind"]].peaks(document)
    if peaks is None:
        return None
    rows = list(peaks)
    errors = [key for key in _PEAK_ERRORS if rows and all(key in row for row in rows)]
    variables: dict[str, Labelled] = {
        key: ("peak", np.array([row[key] for row in rows], dtype=str))
        for key in ("place", "exciter")
    }
    for key in (*_PEAK_NUMBERS, *errors):
        variables[key] = ("peak", np.array([row[key] for row in rows], dtype=float))
    return labelled(variables)


def record_dataset(record: Mapping[str, Any], document: Document) -> xr.Dataset:
    """Return the record over time that an analysis writes beside results.json."""
    found = KINDS[document["kind"]].record_labels(record, document)
    return labelled(*found[:2], **found.attributes)


def _single(document: Document) -> dict[str, Any]:
    """Numbers, texts, and lists of texts."""
    out: dict[str, Any] = {}
    for key, value in document.items():
        texts = isinstance(value, list) and all(isinstance(v, str) for v in value)
        if isinstance(value, str | int | float) or (texts and value):
            out[key] = value
    return out
