"""Meshes in Nastran bulk data: GRID, solids and shells by property, point masses, RBE2 and RBE3."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.imported.formats import left_out
from solidwhirl.meshing.imported.formats.left_out import LeftOut
from solidwhirl.meshing.imported.records import (
    Coupling,
    ElementBlock,
    FileCoupling,
    FileMesh,
    PointMass,
)
from solidwhirl.meshing.records import FloatArray, IntArray
from solidwhirl.rotordyn.exchange.matrices.bulk_data import Card, parsed_real, read_cards

# Numbers of nodes and kinds by card; nodes in VTK's order after `_TO_VTK`.
_CARDS = {
    "CTETRA": {4: "tetra", 10: "tetra10"},
    "CHEXA": {8: "hexahedron", 20: "hexahedron20"},
    "CPENTA": {6: "wedge", 15: "wedge15"},
    "CPYRAM": {5: "pyramid", 13: "pyramid13"},
    "CPYRA": {5: "pyramid", 13: "pyramid13"},
    "CTRIA3": {3: "triangle"},
    "CTRIAR": {3: "triangle"},
    "CQUAD4": {4: "quad"},
    "CQUADR": {4: "quad"},
    "CTRIA6": {6: "triangle6"},
    "CQUAD8": {8: "quad8"},
}
_SHELLS = ("CTRIA3", "CTRIAR", "CQUAD4", "CQUADR", "CTRIA6", "CQUAD8")
# What makes shells of stiffness of elements with its number.
_SHELL_PROPERTIES = ("PSHELL", "PCOMP", "PCOMPG", "PLPLANE", "PSHEAR", "PPLANE")
# Nastran numbers the upright edges of hexahedra and wedges before the upper ones.
_TO_VTK = {
    "hexahedron20": [*range(12), 16, 17, 18, 19, 12, 13, 14, 15],
    "wedge15": [*range(9), 12, 13, 14, 9, 10, 11],
}
_SYSTEMS = ("CORD1R", "CORD1C", "CORD1S", "CORD2R", "CORD2C", "CORD2S")
# Cards that carry stiffness or mass, by their beginning: the longest that fits counts.
_CARRYING = {
    **dict.fromkeys(("CBAR", "CBEAM", "CBEND", "CROD", "CONROD", "CTUBE", "CPIPE"), left_out.BEAMS),
    **dict.fromkeys(
        ("CELAS", "CDAMP", "CBUSH", "CGAP", "CVISC", "CJOINT", "CFAST", "CWELD", "CSEAM"),
        left_out.SPRINGS,
    ),
    **dict.fromkeys(("CMASS", "NSM", "DMIG", "GENEL", "K2GG", "M2GG", "DMI"), left_out.MASSES),
    **dict.fromkeys(
        ("MPC", "RBAR", "RBE1", "RROD", "RTRPLT", "RJOINT", "RSPLINE", "RSSCON", "CYJOIN", "BCTSET",
         "BGSET", "SESET", "SEBULK", "AXIC", "RINGAX"),
        left_out.LINKS,
    ),
    # all other elements
    "C": "mesh the part with CTETRA, CHEXA, CPENTA or CPYRAM, or take them out",
}  # fmt: skip
# Materials and sections (the scene has the former), loads, supports, sets, requests.
_HARMLESS = (
    *("MAT", "PSOLID", "PLSOLID", "PCOMPS", "PARAM", "EIG", "SPC", "SUPORT", "FORCE", "MOMENT"),
    *(
        "PLOAD",
        "LOAD",
        "TEMP",
        "GRAV",
        "RFORCE",
        "ACCEL",
        "SLOAD",
        "DEFORM",
        "SET",
        "TABLE",
        "FREQ",
    ),
    *("TSTEP", "DLOAD", "RLOAD", "TLOAD", "DAREA", "DELAY", "DPHASE", "ASET", "BSET", "CSET"),
    *("QSET", "OMIT", "USET", "LABEL", "PLOTEL", "CBARAO", "POINT", "MDLPRM", "NLPARM", "TF"),
    *("DESVAR", "DRESP", "DCONSTR", "DVPREL", "DOPTPRM", "TOPVAR", "ECHO", "BEGIN", "ENDDATA"),
    *("PBAR", "PBEAM", "PROD", "PTUBE", "PELAS", "PDAMP", "PBUSH", "PGAP", "PVISC", "PMASS"),
)


@dataclass(kw_only=True)
class _Model:
    grids: list[Card] = field(default_factory=list)
    systems: dict[str, tuple[Card, int]] = field(default_factory=dict)
    elements: dict[str, list[list[int]]] = field(default_factory=dict)
    properties: dict[str, list[str]] = field(default_factory=dict)
    shells: dict[tuple[str, str], list[Card]] = field(default_factory=dict)
    shell_properties: set[str] = field(default_factory=set)
    masses: list[Card] = field(default_factory=list)
    rigid: list[Card] = field(default_factory=list)
    densities: list[float] = field(default_factory=list)
    mass_factor: float = 1.0
    default_system: str = ""
    left: LeftOut = field(default_factory=LeftOut)


def read_nastran(path: Path) -> FileMesh:
    """Read GRIDs, solid elements, shells, point masses and couplings; groups are property numbers.

    `path`: bulk data in small, large or free fields, with or without a head before BEGIN BULK, and
    what it includes. Raises MeshingError: what carries stiffness or mass and is not taken, with
    card, count and line. Raises SuperelementError: a line that is no entry, with file and line.
    """
    files: list[Path] = []
    model = _Model()
    for card in read_cards(path, files):
        _take(model, card)
    for (name, number), cards in model.shells.items():
        if number in model.shell_properties:
            line = _line(cards[0])
            model.left.refuse(f"{name} of property {number}", line, left_out.SHELLS, len(cards))
    remarks = model.left.remarks()
    row_of, points = _grids(model)
    blocks, groups = [], dict[str, dict[int, IntArray]]()
    for k, (kind, rows) in enumerate(model.elements.items()):
        try:
            places = np.array([[row_of[n] for n in row] for row in rows], dtype=np.int64)
        except KeyError as error:
            raise MeshingError(f"an element names GRID {error}, which does not exist") from error
        blocks.append(ElementBlock(kind=kind, nodes=places))
        own = np.array(model.properties[kind])
        for number in np.unique(own):
            groups.setdefault(str(number), {})[k] = np.flatnonzero(own == number)
    coupled = [_coupling(card, row_of) for card in model.rigid]
    return FileMesh(
        points=points,
        blocks=tuple(blocks),
        element_groups=groups,
        node_groups={found.name: nodes for found, nodes in coupled},
        masses=tuple(_mass(model, card, row_of, points) for card in model.masses),
        couplings=tuple(found for found, _ in coupled),
        densities=tuple(model.densities),
        mass_factor=model.mass_factor,
        files=tuple(files),
        remarks=remarks,
    )


def _line(card: Card) -> str:
    return f"line {card.line} of {card.path.name}"


def _take(model: _Model, card: Card) -> None:
    # meshio puts a line under the names of second-order elements
    name = card.name.rstrip("_")
    if name == "GRDSET":
        model.default_system = card.text(1)
    elif name == "GRID":
        model.grids.append(card)
    elif name in _CARDS:
        kind, nodes = _element(name, card)
        number = card.text(1) or card.text(0)
        model.elements.setdefault(kind, []).append(nodes)
        model.properties.setdefault(kind, []).append(number)
        if name in _SHELLS:
            model.shells.setdefault((name, number), []).append(card)
    elif name in _SYSTEMS:
        # a card of kind 1 holds two
        starts = [0, 4] if name[4] == "1" and card.text(4) else [0]
        for start in starts:
            model.systems[card.text(start)] = (card, start)
    elif name in ("CONM1", "CONM2"):
        model.masses.append(card)
    elif name in ("RBE2", "RBE3"):
        model.rigid.append(card)
    elif name in _SHELL_PROPERTIES:
        model.shell_properties.add(card.text(0))
    elif name == "MAT1" and card.text(4):
        model.densities.append(card.real(4))
    elif name == "PARAM" and card.text(0).upper() == "WTMASS":
        model.mass_factor = card.real(1)
    elif not name.startswith(_HARMLESS):
        fits = [start for start in _CARRYING if name.startswith(start)]
        if fits:
            model.left.refuse(name, _line(card), _CARRYING[max(fits, key=len)])
        else:
            model.left.tell(name, _line(card), "is not known here and left out")


def _grids(model: _Model) -> tuple[dict[int, int], FloatArray]:
    """Rows of the nodes by their numbers, and their places (n, 3) in the basic system."""
    row_of: dict[int, int] = {}
    points = np.empty((len(model.grids), 3))
    in_system: dict[str, list[int]] = {}
    for row, card in enumerate(model.grids):
        number = card.whole(0)
        if number in row_of:
            raise MeshingError(f"GRID {number} is defined twice, again in {_line(card)}")
        row_of[number] = row
        points[row] = [_coordinate(card, k) for k in (2, 3, 4)]
        system = card.text(1) or model.default_system
        if system not in ("", "0"):
            in_system.setdefault(system, []).append(row)
    # the places of systems of kind 1 are GRIDs, mostly basic ones: round after round
    frames: dict[str, tuple[str, FloatArray, FloatArray]] = {}
    placed = np.ones(len(points), dtype=bool)
    placed[[row for rows in in_system.values() for row in rows]] = False
    while in_system:
        known = {
            system: found
            for system in in_system
            if (found := _frame(model, system, frames, row_of, points, placed, ())) is not None
        }
        if not known:
            raise MeshingError(
                f"coordinate system {next(iter(in_system))} is given by GRIDs that lie in itself"
            )
        for system, (kind, origin, axes) in known.items():
            rows = in_system.pop(system)
            points[rows] = _straight(kind, points[rows]) @ axes + origin
            placed[rows] = True
    return row_of, points


def _straight(kind: str, x: FloatArray) -> FloatArray:
    """Cartesian coordinates (n, 3) of places in a system "R", "C" or "S"; angles in degrees."""
    if kind == "R":
        return x
    r, second, third = x.T
    if kind == "C":
        angle = np.radians(second)
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), third])
    down, around = np.radians(second), np.radians(third)
    return np.column_stack(
        [
            r * np.sin(down) * np.cos(around),
            r * np.sin(down) * np.sin(around),
            r * np.cos(down),
        ]
    )


def _frame(
    model: _Model,
    system: str,
    frames: dict[str, tuple[str, FloatArray, FloatArray]],
    row_of: Mapping[int, int],
    points: FloatArray,
    placed: np.ndarray[tuple[int], np.dtype[np.bool_]],
    inside: tuple[str, ...],
) -> tuple[str, FloatArray, FloatArray] | None:
    """Kind, origin and axes (rows) of a system; None where its GRIDs have no place yet."""
    if system in ("", "0"):
        return "R", np.zeros(3), np.eye(3)
    if system in frames:
        return frames[system]
    if system in inside:
        raise MeshingError(f"coordinate system {system} is defined by itself")
    if system not in model.systems:
        raise MeshingError(f"coordinate system {system} is used, but no CORD card defines it")
    card, start = model.systems[system]
    if card.name[4] == "1":
        rows = [_row(card, row_of, start + 1 + k) for k in range(3)]
        if not placed[rows].all():
            return None
        three = points[rows]
    else:
        beside = _frame(model, card.text(1), frames, row_of, points, placed, (*inside, system))
        if beside is None:
            return None
        kind, origin, axes = beside
        three = np.array([_coordinate(card, k) for k in range(2, 11)]).reshape(3, 3)
        three = _straight(kind, three) @ axes + origin
    z, across = three[1] - three[0], three[2] - three[0]
    y = np.cross(z, across)
    if not np.linalg.norm(y) > 1e-12 * np.linalg.norm(z) * np.linalg.norm(across):
        raise card.error(f"the three points of coordinate system {system} lie in a line")
    z, y = z / np.linalg.norm(z), y / np.linalg.norm(y)
    frames[system] = (card.name[5], three[0], np.array([np.cross(y, z), y, z]))
    return frames[system]


def _row(card: Card, row_of: Mapping[int, int], at: int) -> int:
    """Row of the GRID that a field names."""
    number = card.whole(at)
    if number not in row_of:
        raise card.error(f"names GRID {number}, which does not exist")
    return row_of[number]


def _mass(model: _Model, card: Card, row_of: Mapping[int, int], points: FloatArray) -> PointMass:
    label = f"{card.name} {card.text(0)} ({_line(card)})"
    node, system = _row(card, row_of, 1), card.text(2)
    if card.name == "CONM1":
        return _full_mass(card, label, node)
    relative = system != "-1"
    offset = np.array([_coordinate(card, k) for k in (4, 5, 6)])
    i11, i21, i22, i31, i32, i33 = (_coordinate(card, k) for k in range(8, 14))
    inertia = np.array([[i11, -i21, -i31], [-i21, i22, -i32], [-i31, -i32, i33]])
    if not relative:
        offset -= points[node]
    elif system not in ("", "0"):
        everywhere = np.ones(len(points), dtype=bool)
        found = _frame(model, system, {}, row_of, points, everywhere, ())
        assert found is not None
        kind, _, axes = found
        if kind != "R":
            raise card.error("the coordinate system of a mass has to be rectangular (CORD2R)")
        offset, inertia = offset @ axes, axes.T @ inertia @ axes
    return PointMass(
        label=label, node=node, mass=_coordinate(card, 3), offset=offset, inertia=inertia
    )


def _full_mass(card: Card, label: str, node: int) -> PointMass:
    """A matrix (6, 6) that is one of a mass with a centre of gravity and an inertia."""
    m = np.zeros((6, 6))
    m[np.tril_indices(6)] = [_coordinate(card, 3 + k) for k in range(21)]
    m = m + np.tril(m, -1).T
    mass = m[0, 0]
    # of a rigid body: m 1, and m times the cross product with the arm
    arm = np.array([m[4, 2] * -1.0, m[5, 0] * -1.0, m[3, 1] * -1.0]) / (mass or 1.0)
    cross = np.array([[0.0, -arm[2], arm[1]], [arm[2], 0.0, -arm[0]], [-arm[1], arm[0], 0.0]])
    body = np.block([[mass * np.eye(3), -mass * cross], [mass * cross, m[3:, 3:]]])
    if card.text(2) not in ("", "0") or np.abs(m - body).max() > 1e-6 * np.abs(m).max():
        raise card.error(
            "is no mass of a rigid body in the basic system: one mass in all directions, at one "
            "centre of gravity; give it as CONM2"
        )
    inertia = m[3:, 3:] + mass * cross @ cross
    return PointMass(label=label, node=node, mass=mass, offset=arm, inertia=inertia)


def _coupling(card: Card, row_of: Mapping[int, int]) -> tuple[FileCoupling, IntArray]:
    """RBE2 and RBE3 as a reference node and the nodes that it moves, or that move it."""
    items = card.fields
    if card.name == "RBE2":
        kind: Coupling = "rigid"
        node, motions, members = _row(card, row_of, 1), card.text(2), items[3:]
    else:
        kind = "distributing"
        node, motions, members = _row(card, row_of, 2), "123", items[4:]
    if not {"1", "2", "3"} <= set(motions):
        raise card.error(f"couples motions {motions!r} alone; 123 are needed together")
    found: list[int] = []
    weights = set()
    k = 0
    while k < len(members):
        item = members[k].upper()
        if item in ("UM", "ALPHA"):
            break  # unknowns chosen otherwise, thermal expansion
        if item == "THRU":
            last = int(members[k + 1]) if k + 1 < len(members) and members[k + 1].isdigit() else 0
            found += [n for n in row_of if found[-1] < n <= last]
            k += 1
        elif kind == "distributing" and (k == 0 or "." in item):
            # a weight, the motions that it is for, and nodes
            weights.add(float(item) if item.isdigit() else _number(card, item))
            k += 1
            motions = members[k] if k < len(members) else ""
            if not {"1", "2", "3"} <= set(motions):
                raise card.error(f"takes motions {motions!r} of its nodes; 123 are needed")
        elif item.isdigit():
            found.append(int(item))
        elif item:
            _number(card, item)  # thermal expansion of RBE2
        k += 1
    if len(weights) > 1:
        raise card.error(
            "weighs its nodes differently; interfaces weigh by area: give all the same weight"
        )
    lost = [n for n in found if n not in row_of]
    if lost or not found:
        raise card.error(f"names GRID {lost[0]}, which does not exist" if lost else "has no nodes")
    name = f"{card.name.lower()}_{card.whole(0)}"
    label = f"{card.name} {card.text(0)} ({_line(card)})"
    coupling = FileCoupling(name=name, label=label, coupling=kind, node=node)
    return coupling, np.unique([row_of[n] for n in found])


def _number(card: Card, text: str) -> float:
    try:
        return parsed_real(text)
    except ValueError as error:
        raise card.error(str(error)) from error


def _element(name: str, card: Card) -> tuple[str, list[int]]:
    known = _CARDS[name]
    nodes = []
    for item in card.fields[2 : 2 + max(known)]:
        if not item.isdigit():
            break
        nodes.append(int(item))
    kind = known.get(len(nodes))
    if kind is None:
        counts = " or ".join(str(k) for k in known)
        raise MeshingError(f"{name} {card.text(0)} has {len(nodes)} nodes; allowed are {counts}")
    return kind, [nodes[k] for k in _TO_VTK.get(kind, range(len(nodes)))]


def _coordinate(card: Card, at: int) -> float:
    """A number; whole ones are none by Nastran's rules, but are what they look like."""
    text = card.text(at)
    return float(text) if text.lstrip("+-").isdigit() else card.real(at, 0.0)
