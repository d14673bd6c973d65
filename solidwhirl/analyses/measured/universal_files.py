"""Universal files: functions (dataset 58), modes (55), nodes (15, 2411) and units (164).

Read and written by pyuff; what it lets pass is checked here.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.analyses.measured.records import MOST_BYTES, Freedom, MeasuredFileError
from solidwhirl.analyses.measured.units import Units, file_units, function_factor
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.core.foreign import ForeignError, regular_bytes

# Response of a function by its specific data type.
_QUANTITIES = {8: "receptance", 11: "mobility", 12: "accelerance"}
_TYPES = {quantity: code for code, quantity in _QUANTITIES.items()}
_FORCE, _FREQUENCY, _FRF, _GENERAL, _MODES = 13, 18, 4, 0, 55
_LABELS = {"receptance": "m", "mobility": "m/s", "accelerance": "m/s^2"}
_READ = (15, 55, 58, 164, 2411)
# Begin and end of a block as pyuff finds them; binary numbers do not end a line before one.
_MARK = re.compile(rb"    -1(?=[\r\n]| {74}|\Z)")


class FileFunction(NamedTuple):
    """A frequency response function between two freedoms, in SI units."""

    response: Freedom
    reference: Freedom
    quantity: str
    frequency_hz: FloatArray
    values: ComplexArray


class FileMode(NamedTuple):
    """A mode; motions along x, y, z of the file by node, (3,), in any scale."""

    frequency_hz: float
    damping_ratio: float | None
    motion: Mapping[int, ComplexArray]


class UniversalFile(NamedTuple):
    """What a universal file holds; `nodes_m`: places by node, (3,), empty without any."""

    functions: tuple[FileFunction, ...]
    modes: tuple[FileMode, ...]
    nodes_m: Mapping[int, FloatArray]
    notes: tuple[str, ...]


def read_universal(path: Path, asked: str | None, quantity: str | None = None) -> UniversalFile:
    """Read the functions, modes and nodes of a universal file.

    `asked`: units that the scene names; `quantity`: what functions of type "general" are, and of
    ordinates of no type; None: such functions are left out or refused.
    Raises MeasuredFileError: it can not be read, a block is broken, or its units are missing or
    contradict each other.
    """
    blocks, not_read = _blocks(path)
    units = file_units(path, [b for _, b in blocks if b["type"] == 164], asked)
    notes = [] if units is None else [f"units by {units.said_by}"]
    of_functions = [(where, b) for where, b in blocks if b["type"] == 58]
    taken = (_FRF,) if quantity is None else (_FRF, _GENERAL)
    functions = [
        _function(path, where, block, units, quantity)
        for where, block in of_functions
        if block["func_type"] in taken
    ]
    left = len(of_functions) - len(functions)
    general = sum(block["func_type"] == _GENERAL for _, block in of_functions)
    if not_read:
        kinds = ", ".join(map(str, not_read))
        notes.append(f"datasets that are not read are passed over: {kinds}")
    if left:
        notes.append(f"{left} functions that are no frequency response are left out")
    if general and quantity is None:
        notes.append(f'{general} of them are of type "general": quantity says what they are')
    modes = [_mode(path, where, b) for where, b in blocks if b["type"] == 55]
    return UniversalFile(
        tuple(functions),
        tuple(mode for mode in modes if mode is not None),
        _nodes(path, [b for _, b in blocks if b["type"] in (15, 2411)], units),
        tuple(notes),
    )


def _blocks(path: Path) -> tuple[list[tuple[str, Mapping[str, Any]]], list[int]]:
    """Return the blocks that are read, each with what messages call it, and the kinds of others."""
    import pyuff

    try:
        content = regular_bytes(path, MOST_BYTES)
    except ForeignError as error:
        raise MeasuredFileError(path, str(error)) from error
    marks = [mark.span() for mark in _MARK.finditer(content)]
    file = pyuff.UFF(str(path))
    types = [int(t) for t in file.get_set_types()]
    if not types:
        raise MeasuredFileError(
            path, "no block between two lines with -1 in columns 5 and 6; it is no universal file"
        )
    if len(marks) % 2:
        raise MeasuredFileError(
            path, f"{len(marks)} marks -1, so that a block has no beginning or no end; it is broken"
        )
    found: list[tuple[str, Mapping[str, Any]]] = []
    for k, kind in enumerate(types):
        where = f"block {k + 1} (dataset {kind})"
        if kind in _READ:
            try:
                if kind == _MODES:
                    text = content[marks[2 * k][1] : marks[2 * k + 1][0]].decode("latin-1")
                    found.append((where, _data_at_nodes(text)))
                else:
                    found.append((where, file.read_sets(k)))
            except Exception as error:  # pyuff raises nothing narrower
                raise MeasuredFileError(path, f"{where} is broken: it can not be read") from error
    return found, sorted(set(types) - {*_READ})


def _data_at_nodes(text: str) -> dict[str, Any]:
    """Return dataset 55 by the names of pyuff, which takes no blanks at the ends of lines.

    `text`: of the block, with the line of its number. Raises ValueError, IndexError: it is broken.
    """
    lines = text.splitlines()  # first the end of the mark, the number, and five of text
    _, analysis, _, _, kind, per_node = (int(n) for n in _fields(lines[7], 10)[:6])
    found: dict[str, Any] = {"type": _MODES, "analysis_type": analysis}
    values = [_number(n) for n in _fields(lines[9], 13)]
    if analysis == 2:
        found |= {"freq": values[0], "modal_damp_vis": values[2] if len(values) > 2 else 0.0}
    elif analysis in (3, 7):
        found["eig"] = complex(values[0], values[1])
    body = [line for line in lines[10:] if line.strip()]
    count = per_node * (2 if kind in (5, 6) else 1)
    nodes, data, at = [], [], 0
    while at < len(body):
        nodes.append(int(body[at].split()[0]))
        row: list[float] = []
        at += 1
        while len(row) < count:
            row += [_number(n) for n in _fields(body[at], 13)]
            at += 1
        data.append(row[:count])
    table = np.array(data, dtype=float).reshape(len(nodes), per_node, -1)
    motion = table[..., 0] + 1j * table[..., 1] if kind in (5, 6) else table[..., 0]
    return found | {"node_nums": nodes, **{f"r{k + 1}": motion[:, k] for k in range(3)}}


def _fields(line: str, width: int) -> list[str]:
    """Numbers of a line in columns of a width, or apart by blanks where they are not in columns."""
    line = line.rstrip()
    columns = [line[k : k + width].strip() for k in range(0, len(line), width)]
    whole = all(columns) and all(len(column.split()) == 1 for column in columns)
    return columns if whole else line.split()


def _number(text: str) -> float:
    """A number as Fortran writes it, such as 1.0D+02 or 1.0+102."""
    return float(re.sub(r"(?<=[\d.])([+-]\d+)$", r"E\1", re.sub("[dD]", "E", text)))


def _function(
    path: Path,
    where: str,
    block: Mapping[str, Any],
    units: Units | None,
    quantity: str | None,
) -> FileFunction:
    x, y = np.asarray(block["x"], dtype=float), np.asarray(block["data"])
    if len(y) != block["num_pts"] or len(x) != len(y):
        raise MeasuredFileError(
            path, f"{where} is broken: {block['num_pts']} values are announced, {len(y)} are there"
        )
    if not (np.isfinite(x).all() and np.isfinite(y).all() and (np.diff(x) > 0).all()):
        raise MeasuredFileError(
            path, f"{where} is broken: numbers are missing, or frequencies do not rise"
        )
    if not np.iscomplexobj(y):
        raise MeasuredFileError(path, f"{where}: real values; a response function needs a phase")
    kind, per, over = (
        block.get(f"{of}_spec_data_type") for of in ("ordinate", "orddenom", "abscissa")
    )
    if quantity is not None and kind in (0, None):
        kind, per = _TYPES[quantity], per or _FORCE
    if kind not in _QUANTITIES or per != _FORCE or over not in (_FREQUENCY, 0):
        raise MeasuredFileError(
            path,
            f"{where}: ordinate of type {kind} per type {per} over type {over}; allowed are "
            "displacement (8), velocity (11) or acceleration (12) per force (13) over frequency "
            "(18); of an ordinate of no type (0), quantity says what it is",
        )
    labels = tuple(str(block.get(f"{of}_axis_units_lab", "")) for of in ("ordinate", "orddenom"))
    factor = function_factor(path, where, units, (labels[0], labels[1]))
    above = x > 0.0
    return FileFunction(
        Freedom(int(block["rsp_node"]), int(block["rsp_dir"])),
        Freedom(int(block["ref_node"]), int(block["ref_dir"])),
        _QUANTITIES[int(kind)],
        x[above],
        np.asarray(factor * y[above], dtype=complex),
    )


def _mode(path: Path, where: str, block: Mapping[str, Any]) -> FileMode | None:
    """Return a mode; None of a block of other data."""
    kind = block["analysis_type"]
    if kind == 2:
        hertz, damping = float(block["freq"]), float(block["modal_damp_vis"])
    elif kind in (3, 7):
        rate = complex(block["eig"])
        hertz, damping = abs(rate) / (2.0 * np.pi), -rate.real / abs(rate) if rate else np.nan
    else:
        return None
    motions = np.array([block["r1"], block["r2"], block["r3"]], dtype=complex).T
    nodes = [int(node) for node in block["node_nums"]]
    if len(nodes) != len(motions) or not np.isfinite(motions).all() or not np.isfinite(hertz):
        raise MeasuredFileError(path, f"{where} is broken: numbers are missing")
    if not hertz > 0.0:
        return None  # a rigid motion
    return FileMode(hertz, damping or None, dict(zip(nodes, motions, strict=True)))


def _nodes(
    path: Path, blocks: Sequence[Mapping[str, Any]], units: Units | None
) -> dict[int, FloatArray]:
    """Return places of nodes; none where nothing says their unit."""
    if units is None:
        return {}
    found: dict[int, FloatArray] = {}
    for block in blocks:
        places = np.array([block["x"], block["y"], block["z"]], dtype=float).T * units.length_m
        if not np.isfinite(places).all():
            raise MeasuredFileError(path, "a node has no place; its dataset is broken")
        found |= dict(zip((int(n) for n in block["node_nums"]), places, strict=True))
    return found


def write_universal(
    path: Path,
    functions: Sequence[FileFunction],
    modes: Sequence[FileMode],
    nodes_m: Mapping[int, FloatArray],
) -> None:
    """Write functions, modes and nodes in SI units; frequencies of functions in equal steps."""
    import pyuff

    places = np.array(list(nodes_m.values()), dtype=float).reshape(-1, 3)
    sets: list[dict[str, Any]] = [
        {"type": 164, "units_code": 1, "units_description": "SI", "temp_mode": 1,
         "length": 1.0, "force": 1.0, "temp": 1.0, "temp_offset": 273.15},
        {"type": 15, "node_nums": list(nodes_m), "x": places[:, 0], "y": places[:, 1],
         "z": places[:, 2]},
    ]  # fmt: skip
    sets += [_function_set(function) for function in functions]
    sets += [_mode_set(k + 1, mode) for k, mode in enumerate(modes)]
    pyuff.UFF(str(path)).write_sets(sets, "overwrite")


def _function_set(function: FileFunction) -> dict[str, Any]:
    x = function.frequency_hz
    dataset: dict[str, Any] = {
        "type": 58, "binary": 0, "func_type": _FRF, "func_id": 0, "ver_num": 0, "load_case_id": 0,
        "rsp_ent_name": "NONE", "rsp_node": function.response.node,
        "rsp_dir": function.response.direction, "ref_ent_name": "NONE",
        "ref_node": function.reference.node, "ref_dir": function.reference.direction,
        "ord_data_type": 6, "num_pts": len(x), "abscissa_spacing": 1, "abscissa_min": float(x[0]),
        "abscissa_inc": float(x[1] - x[0]), "z_axis_value": 0.0, "x": x, "data": function.values,
        "id1": function.quantity, "id2": "NONE", "id3": "NONE", "id4": "NONE", "id5": "NONE",
    }  # fmt: skip
    axes = {
        "abscissa": (_FREQUENCY, "frequency", "Hz"),
        "ordinate": (_TYPES[function.quantity], "response", _LABELS[function.quantity]),
        "orddenom": (_FORCE, "force", "N"),
        "z_axis": (0, "NONE", "NONE"),
    }
    for axis, (kind, label, unit) in axes.items():
        exponents = {f"{axis}_{of}_unit_exp": 0 for of in ("len", "force", "temp")}
        lab = "z_axis_axis" if axis == "z_axis" else f"{axis}_axis"
        dataset |= {f"{axis}_spec_data_type": kind, **exponents}
        dataset |= {f"{lab}_lab": label, f"{lab}_units_lab": unit}
    return dataset


def _mode_set(number: int, mode: FileMode) -> dict[str, Any]:
    motion = np.array(list(mode.motion.values()))
    real = not motion.imag.any()
    columns = (motion.real if real else motion).T
    rate = 2.0 * np.pi * mode.frequency_hz
    damping = mode.damping_ratio or 0.0
    own: dict[str, Any] = (
        {"analysis_type": 2, "freq": mode.frequency_hz, "modal_m": 1.0, "modal_damp_vis": damping}
        if real
        else {"analysis_type": 3, "eig": rate * complex(-damping, np.sqrt(1.0 - damping**2))}
    )
    return {
        "type": 55, "model_type": 1, "data_ch": 2, "spec_data_type": 8, "load_case": 0,
        "mode_n": number, "node_nums": list(mode.motion), "r1": columns[0], "r2": columns[1],
        "r3": columns[2], **own,
    }  # fmt: skip
