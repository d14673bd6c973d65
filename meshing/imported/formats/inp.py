"""Meshes in the input files of Abaqus and CalculiX: nodes, elements, sets and surfaces."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.imported.records import ElementBlock, FileMesh
from solidwhirl.meshing.records import IntArray

# Beginnings of element names, and their nodes; longer beginnings first.
_VOLUMES = {
    "C3D20": ("hexahedron20", 20),
    "C3D15": ("wedge15", 15),
    "C3D10": ("tetra10", 10),
    "C3D8": ("hexahedron", 8),
    "C3D6": ("wedge", 6),
    "C3D5": ("pyramid", 5),
    "C3D4": ("tetra", 4),
}
# Shells, membranes and plane elements whose first digit is their number of nodes.
_SURFACES = ("STRI", "SFM3D", "M3D", "CPS", "CPE", "CAX", "S", "R3D", "DS")
_SURFACE_KINDS = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8"}
_LINES = ("T3D", "T2D", "B3", "B2", "SPRING", "DASHPOT", "MASS", "ROTARYI", "CONN3D", "GAP", "D")
# Faces by their corners, in Abaqus' numbering S1, S2, ...
_FACES: dict[str, tuple[tuple[int, ...], ...]] = {
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "hexahedron": (
        (0, 1, 2, 3),
        (4, 7, 6, 5),
        (0, 4, 5, 1),
        (1, 5, 6, 2),
        (2, 6, 7, 3),
        (3, 7, 4, 0),
    ),
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    "pyramid": ((0, 1, 2, 3), (0, 4, 1), (1, 4, 2), (2, 4, 3), (3, 4, 0)),
}
# Keywords that change what coordinates and nodes mean.
_REFUSED = {
    "INCLUDE": "write the mesh into one file",
    "SYSTEM": "write the nodes in global coordinates",
    "TRANSLATE": "write the nodes in global coordinates",
    "NGEN": "write all nodes",
    "NFILL": "write all nodes",
    "NCOPY": "write all nodes",
    "ELGEN": "write all elements",
    "ELCOPY": "write all elements",
    "IMPORT": "write the mesh into one file",
}


@dataclass(kw_only=True)
class _Content:
    """What has been read so far, by the numbers of the file."""

    nodes: dict[int, list[float]] = field(default_factory=dict)
    elements: dict[int, tuple[str, list[int]]] = field(default_factory=dict)
    node_sets: dict[str, list[int]] = field(default_factory=dict)
    element_sets: dict[str, list[int]] = field(default_factory=dict)
    surfaces: dict[str, list[tuple[str, str]]] = field(default_factory=dict)
    instances: int = 0


def read_inp(path: Path) -> FileMesh:
    """Read nodes, elements, NSET, ELSET and element SURFACE; all other keywords are passed over.

    `path`: the file. One part, with its instance in place. Raises MeshingError: elements that are
    not known, generated nodes, included files, several instances.
    """
    content = _Content()
    with path.open("r", encoding="utf-8", errors="replace") as file:
        for keyword, options, data in _keywords(file):
            _take(content, keyword, options, data)
    return _as_mesh(content)


def _keywords(lines: Iterator[str]) -> Iterator[tuple[str, dict[str, str], list[list[str]]]]:
    """Keyword, its options and its data lines, one after the other."""
    keyword, options, data = "", dict[str, str](), list[list[str]]()
    for raw in lines:
        line = raw.strip()
        if not line or line.startswith("**"):
            continue
        if not line.startswith("*"):
            data.append([item.strip() for item in line.split(",")])
            continue
        if keyword:
            yield keyword, options, data
        first, *rest = [part.strip() for part in line[1:].split(",")]
        keyword, data = " ".join(first.upper().split()), []
        options = {}
        for part in rest:
            key, _, value = part.partition("=")
            options[key.strip().upper()] = value.strip().strip('"')
    if keyword:
        yield keyword, options, data


def _take(content: _Content, keyword: str, options: dict[str, str], data: list[list[str]]) -> None:
    if keyword in _REFUSED:
        raise MeshingError(f"*{keyword} is not read; {_REFUSED[keyword]}")
    if keyword == "INSTANCE":
        content.instances += 1
        if content.instances > 1 or data:
            raise MeshingError("several or moved instances are not read; write one flat mesh")
    elif keyword == "NODE" and "SYSTEM" not in options:
        numbers = _nodes(content, data)
        if "NSET" in options:
            content.node_sets.setdefault(options["NSET"], []).extend(numbers)
    elif keyword == "NODE":
        raise MeshingError("*NODE, SYSTEM is not read; write the nodes in global coordinates")
    elif keyword == "ELEMENT":
        numbers = _elements(content, options.get("TYPE", ""), data)
        if "ELSET" in options:
            content.element_sets.setdefault(options["ELSET"], []).extend(numbers)
    elif keyword == "NSET" and "NSET" in options:
        _set(content.node_sets, options["NSET"], options, data)
    elif keyword == "ELSET" and "ELSET" in options:
        _set(content.element_sets, options["ELSET"], options, data)
    elif keyword == "SURFACE" and options.get("TYPE", "ELEMENT").upper() == "ELEMENT":
        pairs = [(row[0], row[1].upper()) for row in data if len(row) > 1]
        content.surfaces.setdefault(options.get("NAME", ""), []).extend(pairs)


def _nodes(content: _Content, data: list[list[str]]) -> list[int]:
    numbers = []
    for row in data:
        values = [float(v) if v else 0.0 for v in row[1:4]]
        number = int(row[0])
        if number in content.nodes:
            raise MeshingError(f"node {number} is defined twice")
        content.nodes[number] = values + [0.0] * (3 - len(values))
        numbers.append(number)
    return numbers


def _elements(content: _Content, kind: str, data: list[list[str]]) -> list[int]:
    found, width = _kind(kind.upper())
    if not found:
        return []
    items = [int(item) for row in data for item in row if item]
    if len(items) % (width + 1):
        raise MeshingError(f"*ELEMENT, TYPE={kind}: every element needs {width} nodes")
    numbers = []
    for start in range(0, len(items), width + 1):
        number, *nodes = items[start : start + width + 1]
        if number in content.elements:
            raise MeshingError(f"element {number} is defined twice")
        content.elements[number] = (found, nodes)
        numbers.append(number)
    return numbers


def _kind(name: str) -> tuple[str, int]:
    """Kind and nodes of an element; empty for those that carry no volume or surface."""
    for start, known in _VOLUMES.items():
        if name.startswith(start) and not name[len(start) :][:1].isdigit():
            return known
    for start in _SURFACES:
        rest = name[len(start) :]
        if name.startswith(start) and rest[:1].isdigit() and int(rest[0]) in _SURFACE_KINDS:
            return _SURFACE_KINDS[int(rest[0])], int(rest[0])
    if name.startswith(_LINES):
        return "", 0
    raise MeshingError(
        f"*ELEMENT, TYPE={name or '(none)'} is not known; allowed are {', '.join(_VOLUMES)} and "
        "their variants, shells for the names of surfaces"
    )


def _set(
    sets: dict[str, list[int]], name: str, options: dict[str, str], data: list[list[str]]
) -> None:
    own = sets.setdefault(name, [])
    for row in data:
        items = [item for item in row if item]
        if "GENERATE" in options:
            first, last, step = (int(v) for v in (*items, "1")[:3])
            own.extend(range(first, last + 1, step))
            continue
        for item in items:
            if item.lstrip("+-").isdigit():
                own.append(int(item))
            elif item in sets:
                own.extend(sets[item])
            else:
                raise MeshingError(f"set {name!r} names {item!r}, which is no number and no set")


def _as_mesh(content: _Content) -> FileMesh:
    row_of = {number: k for k, number in enumerate(content.nodes)}
    kinds: dict[str, list[int]] = {}
    for number, (kind, _) in content.elements.items():
        kinds.setdefault(kind, []).append(number)
    place: dict[int, tuple[int, int]] = {}
    blocks = []
    for k, (kind, numbers) in enumerate(kinds.items()):
        try:
            rows = [[row_of[n] for n in content.elements[e][1]] for e in numbers]
        except KeyError as error:
            raise MeshingError(f"an element names node {error}, which does not exist") from error
        blocks.append(ElementBlock(kind=kind, nodes=np.array(rows, dtype=np.int64)))
        place |= {number: (k, row) for row, number in enumerate(numbers)}
    return FileMesh(
        points=np.array(list(content.nodes.values()), dtype=float).reshape(-1, 3),
        blocks=tuple(blocks),
        element_groups={n: _by_block(own, place) for n, own in content.element_sets.items()},
        node_groups={
            name: np.array([row_of[n] for n in own if n in row_of], dtype=np.int64)
            for name, own in content.node_sets.items()
        },
        face_groups={n: _faces(n, own, content, row_of) for n, own in content.surfaces.items()},
    )


def _by_block(numbers: list[int], place: Mapping[int, tuple[int, int]]) -> dict[int, IntArray]:
    out: dict[int, list[int]] = {}
    for number in dict.fromkeys(numbers):
        if number in place:
            block, row = place[number]
            out.setdefault(block, []).append(row)
    return {block: np.array(rows, dtype=np.int64) for block, rows in out.items()}


def _faces(
    name: str, pairs: list[tuple[str, str]], content: _Content, row_of: Mapping[int, int]
) -> tuple[IntArray, ...]:
    """Corners of the faces of a surface."""
    found: dict[int, list[list[int]]] = {}
    for which, side in pairs:
        numbers = [int(which)] if which.isdigit() else content.element_sets.get(which)
        if numbers is None:
            raise MeshingError(f"surface {name!r} names {which!r}, which is no element set")
        for number in numbers:
            if number not in content.elements:
                continue
            kind, nodes = content.elements[number]
            faces = _FACES.get(kind.rstrip("0123456789"), ())
            at = int(side[1:]) - 1 if side[:1] == "S" and side[1:].isdigit() else -1
            if not 0 <= at < len(faces):
                raise MeshingError(f"surface {name!r}: element {number} has no side {side!r}")
            corners = [row_of[nodes[c]] for c in faces[at]]
            found.setdefault(len(corners), []).append(corners)
    return tuple(np.array(own, dtype=np.int64) for own in found.values())
