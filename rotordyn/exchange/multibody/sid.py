"""Standard input data of a flexible body (Wallrapp 1994), text files ending in .SID_FEM."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from pathlib import Path
from typing import Literal, NamedTuple, get_args

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray, cross_matrix
from solidwhirl.rotordyn.core.atomic import replace_text
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.exchange.exported import Exported
from solidwhirl.rotordyn.exchange.multibody import body_fixed
from solidwhirl.rotordyn.exchange.multibody.body_fixed import BodyFixedForm
from solidwhirl.rotordyn.superelement.record import Superelement

SidLayout = Literal["fembs", "mode"]

_ZERO, _SYMMETRIC, _FULL = 0, 2, 3
# Column of "=" in every line that has one, after the indents of the program that made the format.
_EQUALS = 48
_LARGEST_NODE = 99_999
_LONGEST_NAME = 40
# Readers look for these words anywhere in a line, so that a name must not hold them. Names are in
# lower case, which takes care of the words that are not.
_WORDS = (
    *("refmod", "frame", "mdcm", "ksigma", "origin", "order", "nrow", "ncol", "nqn", "nq"),
    *("structure", "mass", "nelastq", "ielastq", "modal", "node", "part", "phi", "psi"),
    *("sigma", "end", "new", "m0", "m1", "mn"),
)
# Rows of a symmetric tensor as the format lists them; the columns of Oe are in another order.
_J_ROWS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
_OE_COLUMNS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
_OE_SPIN = 2


class _Block(NamedTuple):
    """One matrix, constant (rows, columns) and per mode (rows, modes, columns) or None."""

    name: str
    constant: FloatArray
    per_mode: FloatArray | None = None
    structure: int = _FULL


def write_sid(
    element: Superelement,
    path: Path,
    *,
    modes: int | None = None,
    layout: SidLayout = "fembs",
    modal_damping: float = 0.0,
) -> Exported:
    """Write a body as standard input data of a flexible body in a floating frame.

    `path`: file to write, by habit ending in .SID_FEM; `modes`: number of elastic modes of the free
    body, by frequency; None for all; `layout`: columns of Ge and Gr: "fembs" by component, then
    mode, as FEMBS writes them and Simpack reads them; "mode" by mode, then component, as open
    readers take them; `modal_damping`: damping ratio of every mode, which fills De; 0 writes none.
    Raises SuperelementError if the body has no mass moments or is tied by a constraint, if an
    argument is out of its range, or if a number does not fit the format.

    Equation, indices and blocks follow O. Wallrapp, "Standardization of flexible body modeling in
    multibody system codes", Mech. Struct. & Mach. 22 (1994) 283-304.
    """
    form = body_fixed.body_fixed_form(element, modes=modes)
    text = sid_text(form, layout=layout, modal_damping=modal_damping)
    replace_text(path, text)
    return Exported(
        files=(path,), carried=_carried(form, layout), left_out=_left_out(element, form)
    )


def sid_text(
    form: BodyFixedForm, *, layout: SidLayout = "fembs", modal_damping: float = 0.0
) -> str:
    """Return the text, ASCII; refuse arguments out of range and numbers that do not fit."""
    if layout not in get_args(SidLayout):
        raise SuperelementError(
            f"layout is {layout!r}, allowed are {', '.join(map(repr, get_args(SidLayout)))}"
        )
    nodes = len(form.nodes) + form.points_m.shape[0]
    if nodes > _LARGEST_NODE:
        raise SuperelementError(
            f"body {form.name!r} has {nodes} nodes and recovery points; the format can number "
            f"{_LARGEST_NODE}"
        )
    return "".join(f"{line}\n" for line in _lines(form, layout, modal_damping))


def sid_name(name: str) -> str:
    """Return a name that no reader mistakes for a word of the format.

    Returns lower case letters, digits, "_", "-", at most 40; the words that readers search for are
    broken by "_".
    """
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode().lower()
    plain = re.sub(r"[^a-z0-9_-]+", "_", plain).strip("_")[:_LONGEST_NAME] or "body"
    while found := [word for word in _WORDS if word in plain]:
        for word in found:
            plain = plain.replace(word, f"{word[:-1]}_{word[-1]}")
    return plain[:_LONGEST_NAME].rstrip("_")


def _lines(form: BodyFixedForm, layout: SidLayout, modal_damping: float) -> Iterator[str]:
    """Give the lines of the file, top to bottom."""
    m = form.frequencies_hz.size
    columns = "by component" if layout == "fembs" else "by mode"
    yield (
        f"{len(form.nodes) + form.points_m.shape[0]:5d}{m:4d}    :No. nodes, No. modes:"
        f"written by solidwhirl, units kg m s rad, axis of spin z, gyroscopic columns {columns}"
    )
    yield " part"
    yield f"{'      new modal':{_EQUALS}}= {sid_name(form.name)}"
    yield "           refmod"
    yield _value(16, "mass", number(form.mass_kg, f"body {form.name!r}, mass"))
    yield _value(16, "nelastq", f"{m:6d}")
    for j, frequency in enumerate(form.frequencies_hz, start=1):
        yield _value(16, f"ielastq ({j:4d})", f" Eigen Mode {j:4d} : {frequency:12.3f} Hz")
    yield "           end refmod"
    yield "           frame"
    for label, blocks in enumerate(_nodes(form), start=1):
        yield _value(16, "new node", f"{label:9d}")
        yield _value(21, "rframe", " body ref")
        for block in blocks:
            yield from _block_lines(21, block, m, f"body {form.name!r}, node {label}")
        yield "                end node"
    yield "           end frame"
    for block in _blocks(form, layout, modal_damping):
        yield from _block_lines(11, block, m, f"body {form.name!r}")
    yield "      end modal"
    yield " end part"


def _nodes(form: BodyFixedForm) -> Iterator[tuple[_Block, ...]]:
    """Give the blocks of each node: interfaces, then recovery points, which do not turn."""
    m = form.frequencies_hz.size
    for node in form.nodes:
        yield _node(node.position_m, node.translations, node.rotations)
    for position, shapes in zip(form.points_m, form.point_modes, strict=True):
        yield _node(position, shapes, np.zeros((3, m)))


def _node(
    position_m: FloatArray, translations: FloatArray, rotations: FloatArray
) -> tuple[_Block, ...]:
    """Return place, displacement, rotation and axes of one node."""
    turned = cross_matrix(rotations.T).swapaxes(0, 1)
    return (
        _Block(name="origin", constant=position_m[:, None], per_mode=translations[:, :, None]),
        _Block(name="phi", constant=translations),
        _Block(name="psi", constant=rotations),
        _Block(name="AP", constant=np.eye(3), per_mode=turned),
    )


def _blocks(form: BodyFixedForm, layout: SidLayout, modal_damping: float) -> tuple[_Block, ...]:
    """Return the matrices of the body in the order of the file."""
    m = form.frequencies_hz.size
    inertia_change = form.I8 + form.I8.swapaxes(0, 1)
    coriolis = np.moveaxis(form.I5, 0, 2).swapaxes(0, 1)
    first = _rows(form.inertia_kg_m2, _J_ROWS)[:, None]
    return (
        _Block(
            name="mdCM",
            constant=(form.mass_kg * form.center_of_gravity_m)[:, None],
            per_mode=form.I3[:, :, None],
        ),
        _Block(name="J", constant=first, per_mode=_rows(inertia_change, _J_ROWS)[:, :, None]),
        _Block(name="Ct", constant=form.I3.T),
        _Block(name="Cr", constant=form.I4.T, per_mode=coriolis),
        _Block(name="Me", constant=form.mass, structure=_SYMMETRIC),
        _Block(name="Gr", constant=_side_by_side(2.0 * form.I8.swapaxes(1, 2), layout)),
        _Block(name="Ge", constant=_side_by_side(2.0 * coriolis, layout)),
        _centrifugal(form, inertia_change),
        _Block(name="ksigma", constant=np.zeros((m, 1))),
        _Block(name="Ke", constant=form.stiffness, structure=_SYMMETRIC),
        _Block(
            name="De",
            constant=body_fixed.modal_damping_matrix(form, modal_damping),
            structure=_SYMMETRIC,
        ),
    )


def _centrifugal(form: BodyFixedForm, inertia_change: FloatArray) -> _Block:
    """Return Oe: centrifugal forces, their change with the modes, stiffening by spin about z."""
    pairs = 0.5 * (form.I9 + form.I9.swapaxes(2, 3))
    force, change = [], []
    for a, b in _OE_COLUMNS:
        force.append(-(0.5 if a == b else 1.0) * inertia_change[a, b])
        change.append(pairs[a, b] if a == b else pairs[a, b] + pairs[b, a])
    change[_OE_SPIN] = change[_OE_SPIN] + form.stress_stiffening
    return _Block(name="Oe", constant=np.stack(force, axis=1), per_mode=np.stack(change, axis=2))


def _rows(tensor: FloatArray, order: tuple[tuple[int, int], ...]) -> FloatArray:
    """Return the named components of a tensor of shape (3, 3, ...) as rows."""
    return np.stack([tensor[a, b] for a, b in order])


def _side_by_side(terms: FloatArray, layout: SidLayout) -> FloatArray:
    """Return terms (rows, mode, component) as (rows, 3 modes)."""
    ordered = terms.swapaxes(1, 2) if layout == "fembs" else terms
    return ordered.reshape(terms.shape[0], -1)


def _block_lines(indent: int, block: _Block, m: int, where: str) -> Iterator[str]:
    """Give the lines of one matrix; entries that are zero are not listed."""
    yield f"{'':{indent}}{block.name}"
    rows, columns = block.constant.shape
    where = f"{where}, {block.name}"
    entries = [*_constant_entries(block.constant, where), *_mode_entries(block.per_mode, where)]
    head = {
        "order": 0 if block.per_mode is None else 1,
        "nrow": rows,
        "ncol": columns,
        "nq": m,
        "nqn": 0,
        "structure": block.structure if entries else _ZERO,
    }
    for key, value in head.items():
        yield _value(26, key, f"{value:5d}")
    yield from entries
    yield f"{'':{indent}}end {block.name}"


def _constant_entries(constant: FloatArray, where: str) -> Iterator[str]:
    """Give one line for each entry of M0, row by row."""
    for row, column in np.argwhere(constant):
        text = number(constant[row, column], where)
        if text != _NOTHING:
            yield _value(26, f"m0({row + 1:2d},{column + 1:2d})", text)


def _mode_entries(per_mode: FloatArray | None, where: str) -> Iterator[str]:
    """Give one line for each entry of M1, index order row, mode, column, column by column."""
    if per_mode is None:
        return
    for column, row, mode in np.argwhere(per_mode.transpose(2, 0, 1)):
        text = number(per_mode[row, mode, column], where)
        if text != _NOTHING:
            yield _value(26, f"m1({row + 1:2d},{mode + 1:2d},{column + 1:2d})", text)


_NOTHING = " 0.00000000000D+00"


def number(value: float, where: str) -> str:
    """Write a number as Fortran's D18.11 does: from 1e100 on it is refused, below 1e-99 it is 0."""
    text = f"{value: .11e}".replace("e", "D")
    if len(text) == len(_NOTHING):
        return text
    if abs(value) < 1.0:
        return _NOTHING
    raise SuperelementError(
        f"{where}: the number {value:g} is too large for the format, which ends below 1e100"
    )


def _value(indent: int, key: str, text: str) -> str:
    """Return a line with a value."""
    return f"{'':{indent}}{key}".ljust(_EQUALS) + f"={text}"


def _carried(form: BodyFixedForm, layout: SidLayout) -> tuple[str, ...]:
    """Say what the file holds."""
    names = ", ".join(f"{k} {node.name}" for k, node in enumerate(form.nodes, start=1))
    points = form.points_m.shape[0]
    first = len(form.nodes) + 1
    shown = f"; nodes {first} to {first + points - 1} recovery points" if points else ""
    m = form.frequencies_hz.size
    return (
        f"{m} elastic {'mode' if m == 1 else 'modes'} of the free body",
        f"nodes {names}{shown}",
        "mass, centre of gravity, inertia and their change with the modes",
        "Coriolis and centrifugal terms about all three axes, "
        f"columns of Ge and Gr in the layout {layout!r}",
        "stiffening by the stress of a spin about z",
    )


def _left_out(element: Superelement, form: BodyFixedForm) -> tuple[str, ...]:
    """Say what the file does not hold, or not as it is."""
    sentences = list(body_fixed.body_fixed_limits(element, form))
    if form.points_m.shape[0]:
        sentences.append("Rotations of the recovery points are not known and are written as zero.")
    written = sid_name(form.name)
    if written != form.name:
        sentences.append(
            f"The name {form.name!r} is written as {written!r}: readers of this format mistake "
            "capital letters and some words for keywords."
        )
    sentences.append("Numbers have 12 digits.")
    return tuple(sentences)
