"""Meshes in Nastran bulk data: GRID, solid and shell elements by property."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.imported.records import ElementBlock, FileMesh
from solidwhirl.meshing.records import FloatArray, IntArray
from solidwhirl.rotordyn.exchange.matrices.bulk_data import Card, read_cards

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
# Solids and axisymmetric elements that would leave a hole if they were passed over.
_UNKNOWN = re.compile("CTRIAX6?|CQUADX[48]?|CTRAX[36]|CIHEX[12]?|CHEXA(8|20)|CSLCD")


def read_nastran(path: Path) -> FileMesh:
    """Read GRID in the basic system, solid elements and shells; groups are property numbers.

    `path`: bulk data in small, large or free fields, with or without a head before BEGIN BULK.
    Raises MeshingError: nodes in another coordinate system, elements that are not known, included
    files (a mesh is known by the content of one file). Raises SuperelementError: a line that is no
    entry, with file and line.
    """
    grids, elements = [], dict[str, list[list[int]]]()
    properties: dict[str, list[str]] = {}
    default_system = ""
    files: list[Path] = []
    for card in read_cards(path, files):
        # meshio puts a line under the names of second-order elements
        name = card.name.rstrip("_")
        if name == "GRDSET":
            default_system = card.text(1)
        elif name == "GRID":
            grids.append(card)
        elif name in _CARDS:
            kind, nodes = _element(name, card)
            elements.setdefault(kind, []).append(nodes)
            properties.setdefault(kind, []).append(card.text(1) or card.text(0))
        elif _UNKNOWN.fullmatch(name):
            raise MeshingError(f"{name} is not known; allowed are {', '.join(_CARDS)}")
    if len(files) > 1:
        raise MeshingError("INCLUDE is not read; write the mesh into one file")
    row_of, points = _grids(grids, default_system)
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
    return FileMesh(points=points, blocks=tuple(blocks), element_groups=groups)


def _grids(grids: list[Card], default_system: str) -> tuple[dict[int, int], FloatArray]:
    """Rows of the nodes by their numbers, and their places (n, 3)."""
    row_of = {}
    for row, card in enumerate(grids):
        system = card.text(1) or default_system
        if system not in ("", "0"):
            raise MeshingError(
                f"GRID {card.text(0)} is in coordinate system {system}; write all nodes in the "
                "basic system"
            )
        row_of[card.whole(0)] = row
    points = [[_coordinate(card, k) for k in (2, 3, 4)] for card in grids]
    return row_of, np.array(points, dtype=float).reshape(-1, 3)


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
    """A coordinate; whole numbers are none by Nastran's rules, but are what they look like."""
    text = card.text(at)
    return float(text) if text.lstrip("+-").isdigit() else card.real(at, 0.0)
