"""Meshes in the input files of Abaqus and CalculiX: parts in their places, sets, point masses."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import numpy as np
import scipy

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
from solidwhirl.rotordyn.core.foreign import Allowance, ForeignError, included, regular_bytes

T = TypeVar("T")
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
# Lines that meshers write along edges; they count as rods where they have a section.
_LINES = {"T3D2": ("line", 2), "T2D2": ("line", 2), "T3D3": ("line3", 3), "T2D3": ("line3", 3)}
_MASSES = ("MASS", "ROTARYI")
# What carries stiffness or mass and is no part of a mesh of solids, by the beginning of its type.
_REFUSED_TYPES = {
    **dict.fromkeys(("B2", "B3", "PIPE", "ELBOW", "FRAME"), left_out.BEAMS),
    **dict.fromkeys(
        ("SPRING", "DASHPOT", "JOINT", "CONN", "GAP", "ITS", "ITT", "DRAG"), left_out.SPRINGS
    ),
    **dict.fromkeys(("DCOUP", "COH", "GK", "RB2", "RB3"), left_out.LINKS),
}
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
    "triangle": ((0, 1, 2),),
    "quad": ((0, 1, 2, 3),),
}
# Keywords that change what coordinates and nodes mean.
_REFUSED = {
    "SYSTEM": "write the nodes in global coordinates",
    "NMAP": "write the nodes in global coordinates",
    "TRANSLATE": "write the nodes in global coordinates",
    "PARAMETER": "write the numbers themselves",
    "NGEN": "write all nodes",
    "NFILL": "write all nodes",
    "NCOPY": "write all nodes",
    "ELGEN": "write all elements",
    "ELCOPY": "write all elements",
    "IMPORT": "write the mesh into one file",
    "SUBMODEL": "write the whole model",
}
# Keywords that join, hold or weigh and are refused.
_CARRYING = {
    **dict.fromkeys(("SPRING", "DASHPOT", "CONNECTORSECTION", "GAP", "JOINT"), left_out.SPRINGS),
    **dict.fromkeys(
        (
            *("MPC", "EQUATION", "TIE", "EMBEDDEDELEMENT", "SHELLTOSOLIDCOUPLING", "FASTENER"),
            *("DISTRIBUTINGCOUPLING", "PRE-TENSIONSECTION", "COHESIVESECTION", "GASKETSECTION"),
        ),
        left_out.LINKS,
    ),
    **dict.fromkeys(
        (
            "NONSTRUCTURALMASS",
            "MATRIXINPUT",
            "MATRIXASSEMBLE",
            "SUBSTRUCTUREPROPERTY",
            "USERELEMENT",
        ),
        left_out.MASSES,
    ),
}
# Sections that make rods, beams and shells of elements; that of solids does so of lines and planes.
_SECTIONS = {
    **dict.fromkeys(("BEAMSECTION", "BEAMGENERALSECTION", "FRAMESECTION"), left_out.BEAMS),
    **dict.fromkeys(
        ("SHELLSECTION", "SHELLGENERALSECTION", "MEMBRANESECTION", "SURFACESECTION"),
        left_out.SHELLS,
    ),
    "SOLIDSECTION": "mesh the part with solid elements, or take them out",
}
# Titles, materials (the scene has them), output, loads, supports and steps: nothing of a body.
_HARMLESS = frozenset(
    (
        *("HEADING", "PREPRINT", "PART", "ENDPART", "ASSEMBLY", "ENDASSEMBLY", "ENDINSTANCE"),
        *("MATERIAL", "DENSITY", "ELASTIC", "PLASTIC", "EXPANSION", "CONDUCTIVITY", "DAMPING"),
        *("SPECIFICHEAT", "CREEP", "HYPERELASTIC", "USERMATERIAL", "DEPVAR", "ORIENTATION"),
        *("LATENTHEAT", "MAGNETICPERMEABILITY", "ELECTRICALCONDUCTIVITY", "CYCLICHARDENING"),
        *("AMPLITUDE", "TRANSFORM", "PHYSICALCONSTANTS", "INITIALCONDITIONS", "BOUNDARY"),
        *("CLOAD", "DLOAD", "DSLOAD", "TEMPERATURE", "RESTART", "TIMEPOINTS", "DISTRIBUTION"),
        *("DISTRIBUTIONTABLE", "SECTIONCONTROLS", "HOURGLASSSTIFFNESS", "FILEFORMAT", "NORMAL"),
        *("FILTER", "OUTPUT", "NODEOUTPUT", "ELEMENTOUTPUT", "CONTACTOUTPUT", "ENERGYOUTPUT"),
        *("INTEGRATEDOUTPUTSECTION", "NODEPRINT", "ELPRINT", "NODEFILE", "ELFILE", "CONTACTPRINT"),
        *("CONTACTFILE", "SECTIONPRINT", "MONITOR", "PRINT", "STEP", "ENDSTEP", "END"),
        # read elsewhere
        *("NODE", "ELEMENT", "NSET", "ELSET", "SURFACE", "MASS", "ROTARYINERTIA", "COUPLING"),
        *("KINEMATIC", "DISTRIBUTING", "RIGIDBODY", "KINEMATICCOUPLING", "INSTANCE", *_SECTIONS),
    )
)
# Words that stand alone in keyword lines: what continues such a line, and is no data.
_FLAGS = frozenset(("GENERATE", "INTERNAL", "UNSORTED", "COMBINE"))
# Entries of sets that a file may make by naming sets and counting numbers off.
_MOST_ENTRIES = 50_000_000


@dataclass(frozen=True, kw_only=True, slots=True)
class _Entry:
    """A keyword, its options in capitals, and its data lines with their items."""

    keyword: str  #: In capitals, without blanks
    options: dict[str, str]
    rows: list[list[str]]
    line: str  #: "line 7"

    def error(self, said: str) -> MeshingError:
        return MeshingError(f"{self.line}: *{self.keyword}: {said}")

    def whole(self, text: str) -> int:
        if not text.lstrip("+-").isdigit() or len(text) > 12:
            raise self.error(f"found {text[:40]!r}, a whole number is needed")
        return int(text)

    def real(self, text: str) -> float:
        try:
            return float(text.upper().replace("D", "E")) if text else 0.0
        except ValueError as error:
            raise self.error(f"found {text[:40]!r}, a number is needed") from error

    def reals(self, count: int) -> list[float]:
        """So many numbers of the first line, zero where it has fewer."""
        found = [self.real(item) for item in (self.rows[0] if self.rows else [])[:count]]
        return found + [0.0] * (count - len(found))


@dataclass(kw_only=True)
class _Scope:
    """Numbers and names of one instance, or of the assembly (a flat file is nothing else)."""

    name: str = ""
    nodes: dict[int, int] = field(default_factory=dict)  #: Number to row
    elements: dict[int, int] = field(default_factory=dict)  #: Number to row
    #: Names in capitals to the name as written and rows
    node_sets: dict[str, tuple[str, IntArray]] = field(default_factory=dict)
    element_sets: dict[str, tuple[str, IntArray]] = field(default_factory=dict)
    surfaces: dict[str, tuple[str, tuple[IntArray, ...]]] = field(default_factory=dict)
    node_surfaces: dict[str, tuple[str, IntArray]] = field(default_factory=dict)


@dataclass(kw_only=True)
class _Model:
    """What has been read so far, nodes and elements of all instances in one row."""

    points: list[list[float]] = field(default_factory=list)
    kinds: list[str] = field(default_factory=list)  #: Of every element
    nodes: list[list[int]] = field(default_factory=list)  #: Rows of every element
    names: list[str] = field(default_factory=list)  #: Of every element: type, number and line
    assembly: _Scope = field(default_factory=_Scope)
    instances: dict[str, _Scope] = field(default_factory=dict)
    masses: list[PointMass] = field(default_factory=list)
    weighed: set[int] = field(default_factory=set)  #: Rows of mass elements that have a mass
    couplings: list[FileCoupling] = field(default_factory=list)
    densities: list[float] = field(default_factory=list)
    left: LeftOut = field(default_factory=LeftOut)
    entries: Allowance = field(default_factory=lambda: Allowance(_MOST_ENTRIES, "entries of sets"))

    def scope(self, name: str) -> _Scope:
        found = self.instances.get(name.upper())
        if found is None:
            known = ", ".join(s.name for s in self.instances.values()) or "none"
            raise MeshingError(f"no instance {name!r}; the file has {known}")
        return found


def read_inp(path: Path) -> FileMesh:
    """Read nodes, elements, sets, surfaces, point masses and couplings to reference nodes.

    `path`: the file; parts are put where their instances say. Raises MeshingError: what carries
    stiffness or mass and is not taken, with keyword, count and line; generated nodes.
    """
    files: list[Path] = []
    model = _Model()
    parts: dict[str, list[_Entry]] = {}
    placed: list[tuple[_Entry, list[_Entry]]] = []
    own: list[_Entry] = []
    here, in_step = own, False
    try:
        for entry in _entries(path, files):
            if entry.keyword == "STEP":
                in_step = True
            elif entry.keyword == "ENDSTEP":
                in_step = False
            elif in_step:
                continue  # loads, supports and output
            elif entry.keyword == "PART":
                here = parts.setdefault(entry.options.get("NAME", "").upper(), [])
            elif entry.keyword == "INSTANCE":
                here = []
                placed.append((entry, here))
            elif entry.keyword in ("ENDPART", "ENDINSTANCE"):
                here = own
            else:
                here.append(entry)
        _fill_instances(model, parts, placed)
        _fill(model, model.assembly, own, np.eye(3), np.zeros(3))
        return _as_mesh(model, tuple(files))
    except ForeignError as error:
        raise MeshingError(str(error)) from error


def _entries(path: Path, files: list[Path]) -> Iterator[_Entry]:
    """Keyword, options and data lines, one after the other; those of included files too."""
    content = regular_bytes(path).decode("utf-8", errors="replace")
    files.append(path)
    of_file = "" if len(files) == 1 else f"{path.name}, "
    entry: _Entry | None = None
    open_line = False
    for number, raw in enumerate(content.splitlines(), 1):
        line = raw.strip()
        if not line or line.startswith("**"):
            continue
        if not line.startswith("*"):
            items = [item.strip() for item in line.split(",")]
            if entry is None:
                continue
            if open_line and ("=" in line or all(i.upper() in _FLAGS or not i for i in items)):
                _put_options(entry.options, items)
                open_line = line.endswith(",")
            else:
                entry.rows.append(items)
                open_line = False
            continue
        if entry is not None:
            yield from _included(entry, path, files)
        first, *rest = line[1:].split(",")
        keyword, options = "".join(first.upper().split()), dict[str, str]()
        _put_options(options, rest)
        entry = _Entry(keyword=keyword, options=options, rows=[], line=f"{of_file}line {number}")
        open_line = line.endswith(",")
    if entry is not None:
        yield from _included(entry, path, files)


def _put_options(options: dict[str, str], items: Iterable[str]) -> None:
    for item in items:
        key, _, value = item.partition("=")
        if key.strip():
            options["".join(key.upper().split())] = value.strip().strip('"')


def _included(entry: _Entry, path: Path, files: list[Path]) -> Iterator[_Entry]:
    if entry.keyword != "INCLUDE":
        yield entry
        return
    try:
        other = included(path, entry.options.get("INPUT", ""), files)
    except ForeignError as error:
        raise entry.error(str(error)) from error
    yield from _entries(other, files)


def _fill_instances(
    model: _Model, parts: dict[str, list[_Entry]], placed: list[tuple[_Entry, list[_Entry]]]
) -> None:
    """Put parts where their instances say; a part alone without an instance where it is."""
    if not placed:
        for name, entries in parts.items():
            model.instances[name] = _Scope(name=name)
            _fill(model, model.instances[name], entries, np.eye(3), np.zeros(3))
        return
    used = set()
    for entry, own in placed:
        name, part = entry.options.get("NAME", ""), entry.options.get("PART", "").upper()
        if part not in parts:
            raise entry.error(f"names part {entry.options.get('PART', '')!r}, which is not there")
        if name.upper() in model.instances:
            raise entry.error(f"instance {name!r} is there twice")
        used.add(part)
        scope = model.instances[name.upper()] = _Scope(name=name)
        _fill(model, scope, [*parts[part], *own], *_place(entry))
    for name in parts.keys() - used:
        first = parts[name][0].line if parts[name] else "no line"
        model.left.tell(f"*PART {name}", first, "is in no *INSTANCE and left out")


def _place(entry: _Entry) -> tuple[FloatArray, FloatArray]:
    """Turn (3, 3) and shift (3,) of an instance: first moved, then turned about an axis."""
    rows = [[entry.real(item) for item in row if item] for row in entry.rows]
    shift = np.array(rows[0][:3] if rows else [0.0] * 3)
    turn = np.eye(3)
    if len(shift) != 3 or (len(rows) > 1 and len(rows[1]) != 7):
        raise entry.error("a shift is 3 numbers, a turn 7: two points of its axis and degrees")
    if len(rows) > 1:
        a, b, angle = np.array(rows[1][:3]), np.array(rows[1][3:6]), np.radians(rows[1][6])
        axis = (b - a) / (np.linalg.norm(b - a) or 1.0)
        turn = scipy.spatial.transform.Rotation.from_rotvec(angle * axis).as_matrix()
        shift = turn @ (shift - a) + a
    return turn, shift


def _fill(
    model: _Model, scope: _Scope, entries: Sequence[_Entry], turn: FloatArray, shift: FloatArray
) -> None:
    """Take nodes, then elements, then sets, then what refers to them."""
    for entry in entries:
        key = entry.keyword
        if key in _REFUSED:
            raise entry.error(f"is not read; {_REFUSED[key]}")
        if key in _CARRYING:
            model.left.refuse(f"*{key}", entry.line, _CARRYING[key])
        elif key == "NODE":
            rows = _nodes(model, scope, entry, turn, shift)
            _add(scope.node_sets, entry.options.get("NSET"), rows)
        elif key == "DENSITY" and entry.rows:
            model.densities.append(entry.real(entry.rows[0][0]))
        elif key not in _HARMLESS:
            model.left.tell(f"*{key}", entry.line, "is not known here and left out")
    for entry in entries:
        if entry.keyword == "ELEMENT":
            rows = _elements(model, scope, entry)
            _add(scope.element_sets, entry.options.get("ELSET"), rows)
    for entry in entries:
        if entry.keyword in ("NSET", "ELSET"):
            _set(model, scope, entry)
    for entry in entries:
        if entry.keyword == "SURFACE":
            _surface(model, scope, entry)
    for k, entry in enumerate(entries):
        if entry.keyword == "MASS":
            _mass(model, scope, entry)
        elif entry.keyword == "ROTARYINERTIA":
            _rotary(model, scope, entry)
        elif entry.keyword in _SECTIONS:
            _section(model, scope, entry)
        elif entry.keyword in ("COUPLING", "RIGIDBODY", "KINEMATICCOUPLING"):
            _coupling(model, scope, entry, entries[k + 1] if k + 1 < len(entries) else entry)


def _add(sets: dict[str, tuple[str, IntArray]], name: str | None, rows: IntArray) -> None:
    if name is not None:
        _, before = sets.get(name.upper(), (name, rows[:0]))
        sets[name.upper()] = (name, np.unique(np.append(before, rows)))


def _nodes(
    model: _Model, scope: _Scope, entry: _Entry, turn: FloatArray, shift: FloatArray
) -> IntArray:
    system = entry.options.get("SYSTEM", "R").upper()
    if system not in ("R", "C"):
        raise entry.error(f"SYSTEM={system} is not read; write the nodes in global coordinates")
    first = len(model.points)
    made: list[list[float]] = []
    for row in entry.rows:
        number = entry.whole(row[0])
        if number in scope.nodes:
            raise entry.error(f"node {number} is defined twice")
        x = [entry.real(item) for item in row[1:4]]
        x += [0.0] * (3 - len(x))
        if system == "C":
            angle = np.radians(x[1])
            x[:2] = [x[0] * np.cos(angle), x[0] * np.sin(angle)]
        scope.nodes[number] = first + len(made)
        made.append(x)
    if made:
        placed = (
            np.array(made) @ turn.T + shift if shift.any() or (turn != np.eye(3)).any() else None
        )
        model.points += made if placed is None else placed.tolist()
    return np.arange(first, len(model.points))


def _elements(model: _Model, scope: _Scope, entry: _Entry) -> IntArray:
    name = entry.options.get("TYPE", "").upper()
    found = _kind(name)
    if found is None:
        what_to_do = next(
            (said for start, said in _REFUSED_TYPES.items() if name.startswith(start)), None
        )
        if what_to_do is None:
            raise entry.error(
                f"TYPE={name or '(none)'} is not known; allowed are {', '.join(_VOLUMES)} and "
                "their variants, MASS, ROTARYI, shells for the names of surfaces"
            )
        model.left.refuse(f"*ELEMENT, TYPE={name}", entry.line, what_to_do, len(entry.rows))
        return np.empty(0, dtype=np.int64)
    kind, width = found
    items = [entry.whole(item) for row in entry.rows for item in row if item]
    if len(items) % (width + 1):
        raise entry.error(f"TYPE={name}: every element needs {width} nodes")
    first = len(model.kinds)
    for start in range(0, len(items), width + 1):
        number, *nodes = items[start : start + width + 1]
        if number in scope.elements:
            raise entry.error(f"element {number} is defined twice")
        scope.elements[number] = len(model.kinds)
        model.kinds.append(kind)
        model.nodes.append([_node(scope, entry, n) for n in nodes])
        model.names.append(f"{name} {number} ({entry.line})" if kind in _MASSES else "")
    return np.arange(first, len(model.kinds))


def _node(scope: _Scope, entry: _Entry, number: int) -> int:
    row = scope.nodes.get(number)
    if row is None:
        raise entry.error(f"names node {number}, which does not exist")
    return row


def _kind(name: str) -> tuple[str, int] | None:
    """Kind and nodes of an element; None for one that is not taken."""
    if name in _MASSES:
        return name, 1
    if name in _LINES:
        return _LINES[name]
    for start, known in _VOLUMES.items():
        if name.startswith(start) and not name[len(start) :][:1].isdigit():
            return known
    for start in _SURFACES:
        rest = name[len(start) :]
        if name.startswith(start) and rest[:1].isdigit() and int(rest[0]) in _SURFACE_KINDS:
            return _SURFACE_KINDS[int(rest[0])], int(rest[0])
    return None


def _set(model: _Model, scope: _Scope, entry: _Entry) -> None:
    """A set of numbers, of other sets, or counted off; of the assembly also of an instance's."""
    of_nodes = entry.keyword == "NSET"
    name = entry.options.get(entry.keyword)
    if name is None:
        raise entry.error(f"has no {entry.keyword}=")
    source = model.scope(entry.options["INSTANCE"]) if "INSTANCE" in entry.options else scope
    found = []
    if of_nodes and "ELSET" in entry.options:
        rows = _named(model, source, entry, entry.options["ELSET"], of_nodes=False)
        found.append(np.array([n for k in rows for n in model.nodes[k]], dtype=np.int64))
    numbers = source.nodes if of_nodes else source.elements
    if "GENERATE" in entry.options:
        # the numbers that there are, so that what is counted off needs no memory
        known = np.fromiter(numbers, dtype=np.int64, count=len(numbers))
        rows_of = np.fromiter(numbers.values(), dtype=np.int64, count=len(numbers))
        for row in entry.rows:
            first, last, step = (entry.whole(v) for v in ([i for i in row if i] + ["1"] * 3)[:3])
            if step < 1:
                raise entry.error(f"counts off in steps of {step}; 1 or more is needed")
            model.entries.take(len(known))
            found.append(
                rows_of[(known >= first) & (known <= last) & ((known - first) % step == 0)]
            )
    else:
        single = []
        for row in entry.rows:
            for item in row:
                if item.lstrip("+-").isdigit():
                    k = numbers.get(entry.whole(item))
                    if k is not None:
                        single.append(k)
                elif item:
                    found.append(_named(model, source, entry, item, of_nodes=of_nodes))
        found.append(np.array(single, dtype=np.int64))
    for rows in found:
        model.entries.take(len(rows))
    sets = scope.node_sets if of_nodes else scope.element_sets
    _add(sets, name, np.concatenate(found) if found else np.empty(0, dtype=np.int64))


def _named(model: _Model, scope: _Scope, entry: _Entry, name: str, *, of_nodes: bool) -> IntArray:
    """Rows of a number, a set, or what of an instance is meant by "instance.name"."""
    name = name.strip('"')
    table = scope.node_sets if of_nodes else scope.element_sets
    if name.upper() in table:
        return table[name.upper()][1]
    if name.lstrip("+-").isdigit():
        k = (scope.nodes if of_nodes else scope.elements).get(entry.whole(name))
        return np.array([] if k is None else [k], dtype=np.int64)
    instance, dot, rest = name.partition(".")
    if dot and instance.upper() in model.instances:
        return _named(model, model.instances[instance.upper()], entry, rest, of_nodes=of_nodes)
    # what is named in another scope, once
    others = [s for s in (model.assembly, *model.instances.values()) if s is not scope]
    tables = [s.node_sets if of_nodes else s.element_sets for s in others]
    found = [t[name.upper()][1] for t in tables if name.upper() in t]
    if len(found) == 1:
        return found[0]
    kind = "no node set" if of_nodes else "no element set"
    said = f"which is in {len(found)} parts; write instance.name" if found else f"which is {kind}"
    raise entry.error(f"names {name[:80]!r}, {said}")


def _surface(model: _Model, scope: _Scope, entry: _Entry) -> None:
    name, kind = entry.options.get("NAME", ""), entry.options.get("TYPE", "ELEMENT").upper()
    rows = [row for row in entry.rows if row and row[0]]
    if kind == "NODE":
        found = [_named(model, scope, entry, row[0], of_nodes=True) for row in rows]
        scope.node_surfaces[name.upper()] = (name, np.unique(np.concatenate(found)))
    elif kind == "ELEMENT":
        faces: dict[int, list[list[int]]] = {}
        for row in rows:
            elements = _named(model, scope, entry, row[0], of_nodes=False)
            model.entries.take(len(elements))
            side = row[1].upper() if len(row) > 1 else ""
            for corners in _sides(model, entry, elements, name, side):
                faces.setdefault(len(corners), []).append(corners)
        made = tuple(np.array(own, dtype=np.int64) for own in faces.values())
        _, before = scope.surfaces.get(name.upper(), (name, ()))
        scope.surfaces[name.upper()] = (name, (*before, *made))
    else:
        model.left.tell(f"*SURFACE, TYPE={kind}", entry.line, "is left out")


def _sides(
    model: _Model, entry: _Entry, elements: IntArray, name: str, side: str
) -> Iterator[list[int]]:
    """Corners of the faces "S1", ... of elements; of all that are on the outside without one."""
    outer: dict[tuple[int, ...], list[list[int]]] = {}
    for k in elements.tolist():
        faces = _FACES.get(model.kinds[k].rstrip("0123456789"), ())
        nodes = model.nodes[k]
        if side in ("", "SPOS", "SNEG"):
            for face in faces:
                corners = [nodes[c] for c in face]
                outer.setdefault(tuple(sorted(corners)), []).append(corners)
            continue
        at = int(side[1:]) - 1 if side[:1] == "S" and side[1:].isdigit() else -1
        if not 0 <= at < len(faces):
            raise entry.error(f"surface {name!r}: an element has no side {side[:20]!r}")
        yield [nodes[c] for c in faces[at]]
    yield from (found[0] for found in outer.values() if len(found) == 1)


def _of_set(model: _Model, scope: _Scope, entry: _Entry, kinds: Iterable[str]) -> list[int]:
    """Elements of some kinds in the set that an entry is about."""
    if "ELSET" not in entry.options:
        raise entry.error("has no ELSET=")
    rows = _named(model, scope, entry, entry.options["ELSET"], of_nodes=False)
    return [k for k in rows.tolist() if model.kinds[k] in kinds]


def _mass(model: _Model, scope: _Scope, entry: _Entry) -> None:
    if entry.options.get("TYPE", "ISOTROPIC").upper() != "ISOTROPIC" or not entry.rows:
        raise entry.error("one mass for all directions is needed")
    mass = entry.reals(1)[0]
    for k in _of_set(model, scope, entry, ("MASS",)):
        model.weighed.add(k)
        if mass:
            model.masses.append(PointMass(label=model.names[k], node=model.nodes[k][0], mass=mass))


def _rotary(model: _Model, scope: _Scope, entry: _Entry) -> None:
    if "ORIENTATION" in entry.options:
        raise entry.error("ORIENTATION is not read; give the inertia in global directions")
    xx, yy, zz, xy, xz, yz = entry.reals(6)
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    for k in _of_set(model, scope, entry, ("ROTARYI",)):
        model.weighed.add(k)
        model.masses.append(
            PointMass(label=model.names[k], node=model.nodes[k][0], mass=0.0, inertia=inertia)
        )


def _section(model: _Model, scope: _Scope, entry: _Entry) -> None:
    """What a section makes a rod, a beam or a shell of."""
    surfaces = (*_SURFACE_KINDS.values(), "line", "line3")
    found = _of_set(model, scope, entry, surfaces)
    if found:
        model.left.refuse(
            f"*{entry.keyword} of {', '.join(sorted({model.kinds[k] for k in found}))} elements",
            entry.line,
            _SECTIONS[entry.keyword],
            len(found),
        )


def _coupling(model: _Model, scope: _Scope, entry: _Entry, after: _Entry) -> None:
    """A reference node tied to a surface or to nodes, which becomes a group of that name."""
    kind: Coupling = "rigid"
    options = entry.options
    reference = options.get("REFNODE")
    nodes: IntArray | None = None
    if entry.keyword == "COUPLING":
        if "INFLUENCERADIUS" in options or after.keyword not in ("KINEMATIC", "DISTRIBUTING"):
            raise entry.error("*KINEMATIC or *DISTRIBUTING is needed, and no INFLUENCE RADIUS")
        kind = "rigid" if after.keyword == "KINEMATIC" else "distributing"
        _refuse_free_directions(after, after.rows if kind == "rigid" else [])
        surface, name = options.get("SURFACE", ""), options.get("CONSTRAINTNAME", "")
    elif entry.keyword == "KINEMATICCOUPLING":
        _refuse_free_directions(entry, [row[1:] for row in entry.rows])
        found = [_named(model, scope, entry, row[0], of_nodes=True) for row in entry.rows]
        nodes, surface, name = np.concatenate(found), "", ""
    else:
        held = [options[key] for key in ("NSET", "TIENSET", "PINNSET") if key in options]
        found = [_named(model, scope, entry, one, of_nodes=True) for one in held]
        if "ELSET" in options:
            rows = _named(model, scope, entry, options["ELSET"], of_nodes=False)
            found.append(np.array([n for k in rows for n in model.nodes[k]], dtype=np.int64))
        if not found:
            raise entry.error("has neither NSET= nor ELSET=")
        nodes, surface, name = np.unique(np.concatenate(found)), (held or [""])[0], ""
    if reference is None:
        raise entry.error("has no REF NODE=")
    rows = _named(model, scope, entry, reference, of_nodes=True)
    if len(rows) != 1:
        raise entry.error(f"REF NODE={reference} is {len(rows)} nodes; one is needed")
    name = name or f"{entry.keyword.lower()}_{len(model.couplings) + 1}"
    if nodes is None:
        _named_surface(model, scope, entry, surface, name)
    else:
        _add(model.assembly.node_sets, name, nodes)
    model.couplings.append(
        FileCoupling(
            name=name,
            label=f"*{entry.keyword} {name} ({entry.line})",
            coupling=kind,
            node=int(rows[0]),
            group=surface,
        )
    )


def _refuse_free_directions(entry: _Entry, rows: Sequence[Sequence[str]]) -> None:
    """A rigid coupling has to take all translations; nodes of solids have no rotations."""
    ranges = [[entry.whole(item) for item in row if item] for row in rows]
    held = {k for r in ranges if r for k in range(r[0], min(r[-1], 6) + 1)}
    if held and not {1, 2, 3} <= held:
        raise entry.error(f"couples motions {sorted(held)} alone; 1 to 3 are needed together")


def _named_surface(model: _Model, scope: _Scope, entry: _Entry, surface: str, name: str) -> None:
    """Give a surface a second name, that of its coupling."""
    instance, dot, rest = surface.partition(".")
    scopes = [scope, model.assembly, *model.instances.values()]
    if dot and instance.upper() in model.instances:
        scopes, surface = [model.instances[instance.upper()]], rest
    for found in scopes:
        if surface.upper() in found.surfaces:
            faces = found.surfaces[surface.upper()][1]
            model.assembly.surfaces[name.upper()] = (name, faces)
            return
        if surface.upper() in found.node_surfaces:
            _add(model.assembly.node_sets, name, found.node_surfaces[surface.upper()][1])
            return
    raise entry.error(f"names {surface[:80]!r}, which is no surface of elements or nodes")


def _as_mesh(model: _Model, files: tuple[Path, ...]) -> FileMesh:
    unweighed = [k for k, kind in enumerate(model.kinds) if kind in _MASSES]
    unweighed = [k for k in unweighed if k not in model.weighed]
    if unweighed:
        raise MeshingError(
            f"{model.names[unweighed[0]]}: no *MASS or *ROTARY INERTIA says how much it is"
            + (f", nor of {len(unweighed) - 1} others" if len(unweighed) > 1 else "")
        )
    kinds: dict[str, list[int]] = {}
    for k, kind in enumerate(model.kinds):
        if kind not in _MASSES:
            kinds.setdefault(kind, []).append(k)
    block, row = np.full((2, len(model.kinds)), -1, dtype=np.int64)
    blocks = []
    for k, (kind, own) in enumerate(kinds.items()):
        nodes = np.array([model.nodes[e] for e in own], dtype=np.int64)
        blocks.append(ElementBlock(kind=kind, nodes=nodes))
        block[own], row[own] = k, np.arange(len(own))

    def by_block(elements: IntArray) -> dict[int, IntArray]:
        return {
            int(k): row[elements[block[elements] == k]]
            for k in np.unique(block[elements])
            if k >= 0
        }

    scopes = (model.assembly, *model.instances.values())
    element_sets = _named_once([(s, s.element_sets) for s in scopes])
    node_sets = _named_once([(s, {**s.node_surfaces, **s.node_sets}) for s in scopes])
    return FileMesh(
        points=np.array(model.points, dtype=float).reshape(-1, 3),
        blocks=tuple(blocks),
        element_groups={name: by_block(rows) for name, rows in element_sets.items()},
        node_groups=node_sets,
        face_groups=_named_once([(s, s.surfaces) for s in scopes]),
        masses=tuple(model.masses),
        couplings=tuple(model.couplings),
        densities=tuple(model.densities),
        files=files,
        remarks=model.left.remarks(),
    )


def _named_once(tables: Sequence[tuple[_Scope, dict[str, tuple[str, T]]]]) -> dict[str, T]:
    """Groups by name, those of an instance with that before it where there are several."""
    out: dict[str, T] = {}
    for scope, table in tables:
        for key, (name, found) in table.items():
            alone = sum(key in other for _, other in tables) == 1
            if alone or not scope.name:
                out[name] = found
            if scope.name:
                out[f"{scope.name}.{name}"] = found
    return out
