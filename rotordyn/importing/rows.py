"""Rows, units and axes of imported matrices: from those of a file to those of a scene."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray, motion_at
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.exchange.matrices.foreign_body import ROLES, ForeignBody
from solidwhirl.rotordyn.superelement.validation import MOTIONS

LENGTHS: Mapping[str, float] = {"m": 1.0, "mm": 1e-3}
MASSES: Mapping[str, float] = {"kg": 1.0, "t": 1e3}
AXES = ("xyz", "yzx", "zxy")


class Report(NamedTuple):
    """What an import says: of which body, and notes that it collects."""

    where: str
    notes: list[str]

    def error(self, said: str) -> SuperelementError:
        """Return an error that names the body."""
        return SuperelementError(f"{self.where}: {said}")


@dataclass(frozen=True, kw_only=True)
class ImportOptions:
    """Say what a file of matrices can't.

    `interfaces`: node of each interface, by the interface's name.
    `names`: names of matrices in the file, by role ("mass", "stiffness", ...); the others have the
    names that `exchange.foreign_body.ROLES` gives.
    `length_unit`, `mass_unit`: "m" or "mm", "kg" or "t"; None: as the file says.
    `axes`: axes of the file that are x, y and z here: "xyz", "yzx" or "zxy".
    `origin_m`: place of the file's origin on the axis, m.
    `turns`: whether the body turns.
    """

    interfaces: Mapping[str, int]
    names: Mapping[str, str] = field(default_factory=dict)
    length_unit: str | None = None
    mass_unit: str | None = None
    axes: str = "xyz"
    origin_m: float = 0.0
    turns: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class Placed:
    """Rows of a body in the order of its coordinates, in the axes and the unit of the scene.

    `order`: rows of the file, interfaces first.
    `components`: 1 to 6, or 0, shape (n,).
    `places`: of the nodes of the rows, shape (n, 3), m; nan for amplitudes of modes.
    `owners`: interface of each row, or an empty text.
    `positions`: of the interfaces, by name.
    `labels`: for messages.
    `turn`: axes of the file from those of the scene, shape (3, 3).
    `shift_m`: (3,), of the file's origin.
    """

    order: Any
    components: Any
    places: FloatArray
    owners: tuple[str, ...]
    positions: Mapping[str, FloatArray]
    labels: tuple[str, ...]
    turn: FloatArray
    shift_m: FloatArray


def import_units(report: Report, body: ForeignBody, options: ImportOptions) -> tuple[float, float]:
    """Return the length unit in m and the mass unit in kg; refuse unknown or contradicting ones."""
    out = []
    for key, asked, stated, known in (
        ("length_unit", options.length_unit, body.length_unit, LENGTHS),
        ("mass_unit", options.mass_unit, body.mass_unit, MASSES),
    ):
        allowed = " or ".join(repr(unit) for unit in known)
        if asked is None and stated is None:
            raise report.error(f"the file does not say its units; {key} is needed, {allowed}")
        if asked is not None and stated is not None and asked != stated:
            raise report.error(f"{key} is {asked!r}, the file says {stated!r}")
        unit = str(asked if stated is None else stated)
        if unit not in known:
            raise report.error(f"{key} is {unit[:20]!r}, allowed is {allowed}")
        out.append(known[unit])
    return out[0], out[1]


def import_matrices(
    report: Report, body: ForeignBody, names: Mapping[str, str]
) -> dict[str, FloatArray]:
    """Return the matrices of a file by role, refusing what is missing or of another shape."""
    found: dict[str, FloatArray] = {}
    for role, known in ROLES.items():
        if role.endswith("_at_speed"):
            continue
        asked = names.get(role)
        if asked is not None and asked not in body.matrices:
            raise report.error(f"{role} = {asked!r} is not in the file; it has {_known(body)}")
        at = asked or next((n for n in known[:2] if n in body.matrices), None)
        if at is not None:
            found[role] = body.matrices[at]
    for role in ("mass", "stiffness"):
        if role not in found:
            raise report.error(
                f"has no matrix {' or '.join(ROLES[role][:2])}; name it with {role}, the "
                f"file has {_known(body)}"
            )
    if ("stress_stiffening" in found) != ("spin_softening" in found):
        raise report.error(
            "stress_stiffening and spin_softening belong together: one alone gives a "
            "false stiffness to a rigid tilt; give both or none"
        )
    n = body.size
    for role, matrix in found.items():
        columns = {"rigid_modes": 6, "constraint": matrix.shape[1]}.get(role, n)
        if matrix.shape != (n, columns) or matrix.shape[1] > max(n, 6):
            raise report.error(f"{role} has shape {matrix.shape}, allowed is {(n, columns)}")
    return found


def _known(body: ForeignBody) -> str:
    return ", ".join(sorted(body.matrices)[:20]) or "none"


def placed_rows(report: Report, body: ForeignBody, options: ImportOptions, length: float) -> Placed:
    """Return the rows of a body in order, interfaces first; `length` is the file's unit, m."""
    if options.axes not in AXES:
        raise report.error(f"axes is {options.axes!r}, allowed are {', '.join(AXES)}")
    source = ["xyz".index(letter) for letter in options.axes]
    turn = np.eye(3)[source]  # here = turn @ file
    shift = np.array([0.0, 0.0, options.origin_m])
    here = {k: length * (turn @ place) + shift for k, place in body.positions.items()}
    moved = {0: 0} | {source[k % 3] + 1 + 3 * (k // 3): k + 1 for k in range(6)}
    components = np.array([moved[int(k)] for k in body.components])
    owner = _owners(report, body, options)
    names = list(options.interfaces)

    def rank(row: int) -> tuple[int, int]:
        name = owner.get(int(body.nodes[row])) if components[row] else None
        return (len(names), 0) if name is None else (names.index(name), int(components[row]))

    order = np.array(sorted(range(body.size), key=rank))
    rows = [(int(body.nodes[k]), int(components[k])) for k in order]
    twice = [row for row, count in Counter(rows).items() if row[1] and count > 1]
    if twice:
        node, component = min(twice)
        raise report.error(f"node {node} has {MOTIONS[component - 1]} more than once")
    owners = tuple(owner.get(node, "") if component else "" for node, component in rows)
    nowhere = np.full(3, np.nan)
    return Placed(
        order=order,
        components=components[order],
        places=np.array([here[node] if component else nowhere for node, component in rows]),
        owners=owners,
        positions={name: here[node] for node, name in owner.items()},
        labels=tuple(
            _label(name, node, component, int(row))
            for name, (node, component), row in zip(owners, rows, order, strict=True)
        ),
        turn=turn,
        shift_m=shift,
    )


def _label(name: str, node: int, component: int, row: int) -> str:
    """Name of a coordinate for messages."""
    if not component:
        return f"the mode of row {row + 1}"
    return f"{name or f'node {node}'}.{MOTIONS[component - 1]}"


def _owners(report: Report, body: ForeignBody, options: ImportOptions) -> dict[int, str]:
    """Interface of each node that is one."""
    owner: dict[int, str] = {}
    with_rows = set(body.nodes[body.components > 0].tolist())
    for name, node in options.interfaces.items():
        if node not in body.positions:
            known = ", ".join(str(k) for k in list(body.positions)[:20])
            raise report.error(
                f"interface {name!r} is node {node}, which the file does not have; it has {known}"
            )
        if node not in with_rows:
            raise report.error(
                f"interface {name!r} is node {node}, which has no coordinate in the matrices"
            )
        if node in owner:
            raise report.error(f"interfaces {owner[node]!r} and {name!r} are both node {node}")
        owner[node] = name
    if not owner:
        raise report.error("has no interface; one or more are needed")
    return owner


def scaled_matrices(
    chosen: Mapping[str, FloatArray], placed: Placed, length: float, mass: float
) -> dict[str, FloatArray]:
    """Return the matrices in SI units and in the order of the coordinates.

    Translations of the file are those in metres over its unit (length, m), rotations are the same,
    amplitudes of modes stay as they are; energies carry mass unit (kg) times length unit squared.
    """
    order = placed.order
    size = np.where(np.isin(placed.components, (1, 2, 3)), 1.0 / length, 1.0)
    out = {}
    for role, matrix in chosen.items():
        rows = matrix[order]
        if role == "rigid_modes":
            out[role] = _moved_motions(rows / size[:, None], placed, length)
        elif role == "constraint":
            out[role] = rows / size[:, None]
        elif role == "spin_generator":
            out[role] = rows[:, order] / size[:, None] * size
        else:
            out[role] = rows[:, order] * (mass * length**2) * np.outer(size, size)
    return out


def _moved_motions(motions: FloatArray, placed: Placed, length: float) -> FloatArray:
    """Rigid motions about the scene's origin from those about the file's."""
    shift, turn = motions[:, :3] / length @ placed.turn.T, motions[:, 3:] @ placed.turn.T
    # a rotation about the scene's origin moves the file's by θ × shift
    return np.hstack([shift, turn + shift @ motion_at(placed.shift_m)[:3, 3:]])


def stated_properties(
    body: ForeignBody, options: ImportOptions, length: float, mass: float
) -> dict[str, FloatArray]:
    """Return mass properties that the file states, in SI units and the scene's axes, or none."""
    if len(body.properties) < 3:
        return {}
    turn = np.eye(3)[["xyz".index(letter) for letter in options.axes]]
    center = length * (turn @ body.properties["center_of_gravity"])
    return {
        "mass": mass * body.properties["mass"],
        "center_of_gravity": center + np.array([0.0, 0.0, options.origin_m]),
        "inertia": mass * length**2 * (turn @ body.properties["inertia"] @ turn.T),
    }
