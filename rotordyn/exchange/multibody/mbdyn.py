"""Flexible bodies for MBDyn's modal joint: the .fem file, and an input that uses it."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Literal, NamedTuple, get_args

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.atomic import replace_text
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.exchange.exported import Exported
from solidwhirl.rotordyn.exchange.multibody import body_fixed
from solidwhirl.rotordyn.exchange.multibody.body_fixed import BodyFixedForm
from solidwhirl.rotordyn.exchange.multibody.mass_points import equivalent_mass_points
from solidwhirl.rotordyn.superelement.record import Superelement

MbdynLevel = Literal[13, 18, 19]

_VALUES_IN_LINE = 6
_SPIN_ABOUT_Z = 3


class _Nodes(NamedTuple):
    """All nodes of the file: labels, places (k, 3), shapes (k, 6, m), masses (k,)."""

    labels: tuple[str, ...]
    places: FloatArray
    shapes: FloatArray
    masses: FloatArray


def write_mbdyn(
    element: Superelement,
    path: Path,
    *,
    modes: int | None = None,
    level: MbdynLevel = 19,
    modal_damping: float = 0.0,
) -> Exported:
    """Write a body for MBDyn's modal joint, and beside it an input that holds it on springs.

    `path`: the .fem file; the input takes its name with "_example.mbd" instead of the suffix;
    `modes`: number of elastic modes of the free body, by frequency; None for all; `level`: highest
    record group: 19 with stiffening by spin, which MBDyn takes into account under automatic
    differentiation; 18 without it; 13 for versions that know the inertia of modes from masses at
    nodes only, with points of mass that have the same inertia; `modal_damping`: damping ratio of
    every mode, which fills record group 13; 0 writes none. Raises SuperelementError if the body has
    no mass moments or is tied by a constraint, if an argument is out of its range, or if the file's
    name cannot stand in an MBDyn input.

    The format is that of the manual's chapter "Modal Element Data" (P. Masarati et al., MBDyn
    input manual).
    """
    if re.search(r'["\\\x00-\x1f\x7f]', path.name) or path.suffix == ".mbd":
        raise SuperelementError(
            f"the file cannot be called {path.name!r}: allowed are names without quotes, "
            "backslashes and control characters that do not end in .mbd"
        )
    form = body_fixed.body_fixed_form(element, modes=modes)
    text = fem_text(form, level=level, modal_damping=modal_damping)
    example = path.with_name(f"{path.stem}_example.mbd")
    labels = node_labels([node.name for node in form.nodes])
    start = _example_input(form, path.name, labels, level=level, modal_damping=modal_damping)
    replace_text(example, start)
    replace_text(path, text)
    return Exported(
        files=(path, example),
        carried=_carried(form, labels, level),
        left_out=_left_out(element, form, labels, level),
    )


def fem_text(form: BodyFixedForm, *, level: MbdynLevel = 19, modal_damping: float = 0.0) -> str:
    """Return the text of the .fem file.

    Returns ASCII, lines ended by a line feed, numbers with 17 digits, at most 6 in a line. Raises
    SuperelementError if an argument is out of its range, or no points of mass have the body's
    inertia.
    """
    if level not in get_args(MbdynLevel):
        raise SuperelementError(
            f"the last record group is {level!r}, allowed are {get_args(MbdynLevel)}"
        )
    nodes = _nodes(form, level)
    lines = [
        "** MBDyn MODAL DATA FILE",
        "** body in its own frame, kg m s rad, z is the axis of spin",
    ]
    for group, title, values in _records(form, nodes, level, modal_damping):
        lines += ["**", f"** RECORD GROUP {group}, {title}", *values]
    return "".join(f"{line}\n" for line in [*lines, "**", "** END OF FILE"])


def node_labels(names: Sequence[str]) -> tuple[str, ...]:
    """Return labels that are all different: letters, digits, `_-.`, at most 60 characters."""
    labels: list[str] = []
    for name in names:
        plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
        label = wanted = re.sub(r"[^A-Za-z0-9_.-]+", "_", plain)[:50] or "interface"
        # recovery points are p1, p2, ..., points of mass m1, m2, ...
        again = 2
        if re.fullmatch(r"[pm]\d+", label):
            label = wanted = f"{label}_"
        while label in labels:
            label, again = f"{wanted}_{again}", again + 1
        labels.append(label)
    return tuple(labels)


def _nodes(form: BodyFixedForm, level: MbdynLevel) -> _Nodes:
    """Return interfaces, recovery points, and for level 13 points of mass."""
    m = form.frequencies_hz.size
    count = form.points_m.shape[0]
    labels = [*node_labels([node.name for node in form.nodes])]
    labels += [f"p{k}" for k in range(1, count + 1)]
    places = [*(node.position_m for node in form.nodes), *form.points_m]
    shapes = [np.vstack([node.translations, node.rotations]) for node in form.nodes]
    shapes += [np.vstack([shape, np.zeros((3, m))]) for shape in form.point_modes]
    masses = np.zeros(len(places))
    if level == 13:
        points = equivalent_mass_points(form)
        labels += [f"m{k}" for k in range(1, points.masses_kg.size + 1)]
        places += [*points.positions_m]
        shapes += [np.vstack([shape, np.zeros((3, m))]) for shape in points.shapes]
        masses = np.concatenate([masses, points.masses_kg])
    return _Nodes(
        labels=tuple(labels),
        places=np.array(places).reshape(-1, 3),
        shapes=np.array(shapes).reshape(-1, 6, m),
        masses=masses,
    )


def _records(
    form: BodyFixedForm, nodes: _Nodes, level: MbdynLevel, modal_damping: float
) -> Iterator[tuple[int, str, Iterable[str]]]:
    """Give number, title and lines of each record group."""
    m = form.frequencies_hz.size
    count = len(nodes.labels)
    header = "**   REVISION,  NODE,  NORMAL, ATTACHMENT, CONSTRAINT, REJECTED MODES."
    yield 1, "HEADER", [header, f"      REV0  {count}  {m}  0  0  0"]
    yield 2, "FINITE ELEMENT NODE LIST", nodes.labels
    yield 3, "INITIAL MODAL DISPLACEMENTS", _values(np.zeros(m))
    yield 4, "INITIAL MODAL VELOCITIES", _values(np.zeros(m))
    for axis, letter in enumerate("XYZ"):
        yield 5 + axis, f"NODAL {letter} COORDINATES", _values(nodes.places[:, axis, None])
    yield 8, "MODE SHAPES", _shape_lines(nodes.shapes)
    yield 9, "MODAL MASS MATRIX", _values(form.mass)
    yield 10, "MODAL STIFFNESS MATRIX", _values(form.stiffness)
    if level == 13:
        spread = np.zeros((count, 6))
        spread[:, :3] = nodes.masses[:, None]
        yield 11, "DIAGONAL OF LUMPED MASS MATRIX", _values(spread)
    else:
        yield 12, "GLOBAL INERTIA PROPERTIES", _rigid_inertia(form)
    yield 13, "MODAL DAMPING MATRIX", _values(body_fixed.modal_damping_matrix(form, modal_damping))
    if level >= 18:
        yield 14, "INVARIANT 3", _values(form.I3)
        yield 15, "INVARIANT 4", _values(form.I4)
        yield 16, "INVARIANT 8", _values(form.I8.transpose(0, 2, 1))
        yield 17, "INVARIANT 5", _values(form.I5)
        yield 18, "INVARIANT 9", _values(form.I9.transpose(0, 2, 3, 1))
    if level >= 19:
        stiffening = _values(form.stress_stiffening)
        yield 19, "MODAL STRESS STIFFENING MATRIX", ["1", str(_SPIN_ABOUT_Z), *stiffening]


def _rigid_inertia(form: BodyFixedForm) -> Iterator[str]:
    """Give mass, centre of gravity, and inertia about it."""
    centre = form.center_of_gravity_m
    steiner = form.mass_kg * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    yield from _values(np.array([form.mass_kg]))
    yield from _values(centre)
    yield from _values(form.inertia_kg_m2 - steiner)


def _shape_lines(shapes: FloatArray) -> Iterator[str]:
    """Give the motion of all nodes, mode by mode, each under a line that names it."""
    for mode in range(shapes.shape[2]):
        yield f"**    NORMAL MODE SHAPE # {mode + 1:2d}"
        yield from _values(shapes[:, :, mode])


def _values(array: FloatArray) -> Iterator[str]:
    """Give the rows of an array, with at most 6 values in a line."""
    for row in array.reshape(array.shape[0], -1) if array.ndim > 1 else array[None, :]:
        for start in range(0, row.size, _VALUES_IN_LINE):
            yield " ".join(f"{value:.16e}" for value in row[start : start + _VALUES_IN_LINE])


def _carried(form: BodyFixedForm, labels: tuple[str, ...], level: MbdynLevel) -> tuple[str, ...]:
    """Say what the files hold."""
    m = form.frequencies_hz.size
    points = form.points_m.shape[0]
    shown = f"; recovery points p1 to p{points}" if points else ""
    phrases = [
        f"{m} elastic {'mode' if m == 1 else 'modes'} of the free body",
        f"interface nodes {', '.join(labels)}{shown}",
        "mass, centre of gravity, inertia and their change with the modes",
        "Coriolis and centrifugal terms about all three axes",
    ]
    if level == 13:
        phrases.append("the inertia as points of mass m1, m2, ... that have the same moments")
    if level == 19:
        phrases.append("stiffening by the stress of a spin about z")
    phrases.append("an input that holds the body on springs at its interfaces")
    return tuple(phrases)


def _left_out(
    element: Superelement, form: BodyFixedForm, labels: tuple[str, ...], level: MbdynLevel
) -> tuple[str, ...]:
    """Say what the files do not hold, or not as it is."""
    sentences = list(body_fixed.body_fixed_limits(element, form))
    if level < 19 and np.any(form.stress_stiffening):
        sentences.append(
            f"Stiffening by spin is not written at level {level}: at speed all frequencies are "
            "too low, and the body is not fit for high speeds."
        )
    if level == 19:
        sentences.append(
            "MBDyn ignores stiffening by spin unless its input says "
            '"use automatic differentiation;".'
        )
    if form.points_m.shape[0]:
        sentences.append("Rotations of the recovery points are not known and are written as zero.")
    for node, label in zip(form.nodes, labels, strict=True):
        if label != node.name:
            sentences.append(f"The interface {node.name!r} is written as {label!r}.")
    return tuple(sentences)


_HEAD = """\
# Body "{name}" from {file}, spinning freely about z on springs to the ground.
# Units kg, m, s, rad. Set the spin, the springs and the times to yours.

set: real SPIN = 100.; # rad/s
set: real RADIAL = {radial:.3e}; # N/m, of each spring in x and y
set: real AXIAL = {radial:.3e}; # N/m, in z
set: real STEP = {step:.3e}; # s
set: real END = {end:.3e}; # s

set: integer BODY = 1;
set: integer GROUND = 2;
set: integer INTERFACE = 100;
set: integer SPRING = 200;

begin: data;
    problem: initial value;
end: data;

begin: initial value;
    initial time: 0.;
    final time: END;
    time step: STEP;
    method: ms, 0.6;
    tolerance: 1.e-6;
    max iterations: 20;
    derivatives coefficient: 1.e-9;
    derivatives tolerance: 1.e-3;
    derivatives max iterations: 20;
end: initial value;

begin: control data;
{differentiation}    structural nodes:
        + 1 # frame of the body
        + 1 # ground
        + {count} # interfaces
    ;
    joints:
        + 1 # body
        + 1 # ground
        + {count} # springs
    ;
end: control data;

begin: nodes;
    structural: BODY, modal,
        null,
        eye,
        null,
        0., 0., SPIN;
    structural: GROUND, static,
        null,
        eye,
        null,
        null;
"""

_NODE = """\
    structural: INTERFACE + {k}, static,
        {place},
        eye,
        {velocity},
        0., 0., SPIN;
"""

_ELEMENTS = """\
end: nodes;

begin: elements;
    joint: BODY, modal, BODY,
        {modes},
        from file,
        {damping},
        "{file}",
        origin position, null,
        {count}{interfaces}{ninth};
    joint: GROUND, clamp, GROUND,
        position, node,
        orientation, node;
"""

_SPRING = """\
    joint: SPRING + {k}, deformable displacement joint,
        GROUND,
            position, {place},
        INTERFACE + {k},
            position, null,
        linear elastic generic, diag, RADIAL, RADIAL, AXIAL;
"""


def _example_input(
    form: BodyFixedForm,
    file: str,
    labels: Sequence[str],
    *,
    level: int,
    modal_damping: float,
) -> str:
    """Return an input with the body on springs, at every interface as stiff as its first mode."""
    frequency = float(form.frequencies_hz[0])
    radial = form.mass_kg * (2.0 * np.pi * frequency) ** 2 / max(len(labels), 1)
    values = {
        "name": form.name,
        "file": file,
        "radial": radial,
        "step": 0.01 / frequency,
        "end": 10.0 / frequency,
        "differentiation": "    use automatic differentiation;\n" if level >= 19 else "",
        "count": len(labels),
        "modes": form.frequencies_hz.size,
        "damping": "damping from file" if modal_damping else "no damping",
        # the manual has it before the origin; the program reads it behind the interfaces
        "ninth": ",\n        use invariant 9" if level == 13 else "",
        "interfaces": "".join(
            f',\n        "{label}", INTERFACE + {k}, null' for k, label in enumerate(labels, 1)
        ),
    }
    places = [
        (k, ", ".join(f"{value:.16e}" for value in node.position_m), node.position_m)
        for k, node in enumerate(form.nodes, 1)
    ]
    return "".join(
        [
            _HEAD.format(**values),
            *(_NODE.format(k=k, place=text, velocity=_velocity(at)) for k, text, at in places),
            _ELEMENTS.format(**values),
            *(_SPRING.format(k=k, place=text) for k, text, _ in places),
            "end: elements;\n",
        ]
    )


def _velocity(position_m: FloatArray) -> str:
    """Return the velocity of a place on the spinning body as an expression."""
    x, y = float(position_m[0]), float(position_m[1])
    if x == y == 0.0:
        return "null"
    return f"-SPIN*({y:.16e}), SPIN*({x:.16e}), 0."
