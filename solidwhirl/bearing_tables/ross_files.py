"""Bearings and seals in files that ROSS saves, TOML or JSON."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.bearing_tables.grid import ENDS, GridError, on_grid
from solidwhirl.bearing_tables.records import CoefficientTable, TableFileError
from solidwhirl.core.errors import one_line
from solidwhirl.core.toml_text import LONG_KEY, long_key
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.foreign import ForeignError, json_data

_NAMES = tuple(f"{letter}{end}" for letter in "kcm" for end in ENDS)
# Elements whose axis `frequency` is that of the motion in ROSS 2 as well.
_OVER_FREQUENCY = ("MagneticBearingElement", "SqueezeFilmDamper")
_SPEED_NOTE = (
    "ROSS 2 looks up the axis it calls frequency at the speed of the rotor; it is read as speed"
)


def read_ross(path: Path, text: str) -> dict[str, CoefficientTable]:
    """Return the tables of the bearings and seals in the text of a file of ROSS, by their tags.

    An element is a section CLASS_TAG with the keys kxx and cxx, all in SI. `speed` is the speed of
    the rotor; `frequency` beside it, or alone in files of ROSS 3, that of the motion, and alone in
    files of ROSS 2, which most elements look up at the speed, the speed too. Arrays over both are
    [speed][frequency].
    Raises TableFileError: neither TOML nor JSON, no such element, or arrays that do not fit.
    """
    data = loaded(path, text)
    version = str(data.get("ross_version", ""))
    found = {}
    for section, element in data.items():
        if not isinstance(element, dict) or None in (element.get("kxx"), element.get("cxx")):
            continue
        kind, _, rest = section.partition("_")
        tag = one_line(str(element.get("tag") or rest or section))
        found[tag] = _table(path, kind, tag, element, version)
    if not found:
        raise TableFileError(
            path,
            'has no bearing of ROSS: a section such as ["BearingElement_TAG"] with kxx and cxx',
        )
    return found


def loaded(path: Path, text: str) -> dict[str, Any]:
    """Return what the text of a file says, JSON if it is named so, else TOML.

    Raises TableFileError: it is none, or no table.
    """
    try:
        if path.suffix.lower() == ".json":
            data = json_data(text)
        elif long_key(text) is not None:
            raise ForeignError(LONG_KEY)
        else:
            data = tomllib.loads(text)
    except ForeignError as error:
        raise TableFileError(path, str(error)) from error
    except (ValueError, RecursionError) as error:
        raise TableFileError(path, f"is not valid TOML: {error}") from error
    if not isinstance(data, dict):
        raise TableFileError(path, "holds no sections of elements")
    return data


def _table(
    path: Path, kind: str, tag: str, element: Mapping[str, Any], version: str
) -> CoefficientTable:
    axes = {key: _array(path, tag, key, element[key]) for key in ("speed", "frequency")
            if element.get(key) is not None}  # fmt: skip
    notes = []
    if list(axes) == ["frequency"] and _is_speed(kind, element, version):
        axes, notes = {"speed": axes["frequency"]}, [_SPEED_NOTE]
    for key, values in axes.items():
        if values.ndim != 1 or not (np.diff(values) > 0).all():
            raise TableFileError(path, f"{tag}: {key} must be a rising list of numbers")
    sizes = tuple(values.size for values in axes.values())
    columns = {}
    for name in _NAMES:
        if element.get(name) is not None:
            values = _array(path, tag, name, element[name])
            if values.size == 1:
                values = np.full(sizes, values.item())
            if values.shape != sizes:
                of = " and ".join(f"{values.size} of {key}" for key, values in axes.items())
                raise TableFileError(
                    path, f"{tag}: {name} has shape {values.shape}, the axes {of or 'one value'}"
                )
            columns[name] = values.ravel()
    names = {"speed": "speeds_rad_s", "frequency": "frequencies_rad_s"}
    grid = np.meshgrid(*axes.values(), indexing="ij") if axes else []
    try:
        found, matrices = on_grid(
            {names[key]: g.ravel() for key, g in zip(axes, grid, strict=True)}, columns
        )
    except GridError as error:
        raise TableFileError(path, f"{tag}: {error}") from error
    if any(np.any(element.get(key) or 0.0) for key in ("kzz", "czz", "mzz")):
        notes.append("coefficients along z are left out; a law of a scene acts on ux and uy")
    return CoefficientTable(
        **found,
        stiffness_n_per_m=matrices["k"],
        damping_n_s_per_m=matrices["c"],
        mass_kg=matrices["m"],
        source=f"{path.name}: {tag}",
        notes=tuple(notes),
        assumed=(),
    )


def _is_speed(kind: str, element: Mapping[str, Any], version: str) -> bool:
    """Whether the only axis `frequency` of an element is the speed of the rotor."""
    major = version.partition(".")[0]
    newer = "speed" in element or (major.isdigit() and int(major) >= 3)
    return not newer and kind not in _OVER_FREQUENCY


def _array(path: Path, tag: str, key: str, value: Any) -> FloatArray:
    """Numbers of one key."""
    try:
        found = np.array(value, dtype=float)
    except (TypeError, ValueError, OverflowError) as error:
        raise TableFileError(path, f"{tag}: {key} is no list of numbers") from error
    if not np.isfinite(found).all() or found.size == 0:
        raise TableFileError(path, f"{tag}: {key} has entries that are no finite numbers")
    return found
