"""Meshes in Nastran bulk data: GRID, solid and shell elements by property."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.records import IntArray
from solidwhirl.meshing.user_mesh_records import ElementBlock, FileMesh

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
# Nastran numbers the upright edges of hexahedra and wedges before the upper ones.
_TO_VTK = {
    "hexahedron20": [*range(12), 16, 17, 18, 19, 12, 13, 14, 15],
    "wedge15": [*range(9), 12, 13, 14, 9, 10, 11],
}
# Cards that shape nothing here though they name nodes.
_SKIPPED = ("CBAR", "CBEAM", "CROD", "CONROD", "CBUSH", "CELAS", "CDAMP", "CONM", "CMASS", "CGAP",
            "CTUBE", "CVISC", "CWELD", "CFAST", "CORD")  # fmt: skip
_LONGEST_REAL = 30


def read_nastran(path: Path) -> FileMesh:
    """Read GRID in the basic system, solid elements and shells; groups are property numbers.

    Parameters
    ----------
    path
        Bulk data in small, large or free fields, with or without a head before BEGIN BULK.

    Raises
    ------
    MeshingError
        Nodes in another coordinate system, elements that are not known, included files.
    """
    with path.open("r", encoding="utf-8", errors="replace") as file:
        cards = list(_cards(file))
    row_of: dict[int, int] = {}
    points: list[list[float]] = []
    elements: dict[str, list[list[int]]] = {}
    properties: dict[str, list[str]] = {}
    default_system = ""
    for name, fields in cards:
        if name == "GRDSET":
            default_system = _field(fields, 1)
    for name, fields in cards:
        if name == "GRID":
            system = _field(fields, 1) or default_system
            if system not in ("", "0"):
                raise MeshingError(
                    f"GRID {fields[0]} is in coordinate system {system}; write all nodes in the "
                    "basic system"
                )
            row_of[int(fields[0])] = len(points)
            points.append([_real(_field(fields, k)) for k in (2, 3, 4)])
        elif name in _CARDS:
            kind, nodes = _element(name, fields)
            elements.setdefault(kind, []).append(nodes)
            properties.setdefault(kind, []).append(_field(fields, 1) or fields[0])
        elif name == "INCLUDE":
            raise MeshingError("INCLUDE is not read; write the mesh into one file")
        elif name.startswith("C") and not name.startswith(_SKIPPED) and name in _UNKNOWN_SOLIDS:
            raise MeshingError(f"{name} is not known; allowed are {', '.join(_CARDS)}")
    blocks, groups = [], dict[str, dict[int, IntArray]]()
    for k, (kind, rows) in enumerate(elements.items()):
        try:
            places = np.array([[row_of[n] for n in row] for row in rows], dtype=np.int64)
        except KeyError as error:
            raise MeshingError(f"an element names GRID {error}, which does not exist") from error
        blocks.append(ElementBlock(kind=kind, nodes=places))
        own = np.array(properties[kind])
        for number in np.unique(own):
            groups.setdefault(str(number), {})[k] = np.flatnonzero(own == number)
    return FileMesh(
        points=np.array(points, dtype=float).reshape(-1, 3),
        blocks=tuple(blocks),
        element_groups=groups,
        node_groups={},
        face_groups={},
    )


# Solids and axisymmetric elements that would leave a hole if they were passed over.
_UNKNOWN_SOLIDS = ("CTRIAX", "CTRIAX6", "CQUADX", "CQUADX4", "CQUADX8", "CTRAX3", "CTRAX6",
                   "CIHEX", "CIHEX1", "CIHEX2", "CHEXA8", "CHEXA20", "CSLCD")  # fmt: skip


def _cards(lines: Iterator[str]) -> Iterator[tuple[str, list[str]]]:
    """Name and fields of every card, continuations joined."""
    name, fields = "", list[str]()
    started = True
    for raw in lines:
        line = raw.split("$", 1)[0].rstrip("\n\r")
        if not line.strip():
            continue
        first = line.strip().upper()
        if first.startswith(("SOL ", "CEND", "ID ")):
            started = False  # a head: what follows is no bulk data yet
        if first.startswith("BEGIN"):
            started, name, fields = True, "", []
            continue
        if first.startswith("ENDDATA"):
            break
        if not started:
            continue
        card, own = _split(line)
        if card in ("", "+", "*") or card[0] in "+*":
            fields += own
            continue
        if name:
            yield name, fields
        # meshio puts a line under the names of second-order elements
        name, fields = card.rstrip("*_").upper(), own
    if name:
        yield name, fields


def _split(line: str) -> tuple[str, list[str]]:
    """First field, and the data fields that follow (8 in small fields, 4 in large ones)."""
    if "," in line:
        first, *rest = [part.strip() for part in line.split(",")]
        wide = 4 if first.endswith("*") or first == "*" else 8
        return first, (rest + [""] * wide)[:wide]
    line = line.expandtabs(8)
    first = line[:8].strip()
    if first.endswith("*") or first.startswith("*"):
        return first, [line[8 + 16 * k : 24 + 16 * k].strip() for k in range(4)]
    return first, [line[8 + 8 * k : 16 + 8 * k].strip() for k in range(8)]


def _element(name: str, fields: list[str]) -> tuple[str, list[int]]:
    known = _CARDS[name]
    most = max(known)
    nodes = []
    for item in fields[2 : 2 + most]:
        if not item or not item.isdigit():
            break
        nodes.append(int(item))
    kind = known.get(len(nodes))
    if kind is None:
        counts = " or ".join(str(k) for k in known)
        raise MeshingError(f"{name} {fields[0]} has {len(nodes)} nodes; allowed are {counts}")
    if kind in _TO_VTK:
        nodes = [nodes[k] for k in _TO_VTK[kind]]
    return kind, nodes


def _field(fields: list[str], index: int) -> str:
    return fields[index] if index < len(fields) else ""


def _real(text: str) -> float:
    """A real number as Nastran writes it: 1.5-3 is 1.5e-3, 1.5D-3 too."""
    if not text:
        return 0.0
    if len(text) > _LONGEST_REAL:
        raise MeshingError(f"{text[:_LONGEST_REAL]!r}... is no number")
    plain = text.upper().replace("D", "E")
    if "E" not in plain:
        for k in range(1, len(plain)):
            if plain[k] in "+-":
                plain = f"{plain[:k]}E{plain[k:]}"
                break
    return float(plain)
