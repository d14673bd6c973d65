"""Strict reader of .SID_FEM files, written from the grammar alone; refuses what is off it."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

NUMBER = r"[ -]\d\.\d{11}D[+-]\d\d"
# a reader in C looks for these anywhere in a line and takes the line for a block
KEYWORDS = (
    "J",
    "Me",
    "Ke",
    "De",
    "Ct",
    "Cr",
    "Gr",
    "Ge",
    "Oe",
    "mdCM",
    "frame",
    "refmod",
    "ksigma",
)
EQUALS = 48
LONGEST_NUMBER = 18
BLOCKS = ("mdCM", "J", "Ct", "Cr", "Me", "Gr", "Ge", "Oe", "ksigma", "Ke", "De")
NODE_BLOCKS = ("origin", "phi", "psi", "AP")
J_ROWS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
OE_COLUMNS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


class SidError(ValueError):
    """A file off the grammar."""


@dataclass(frozen=True)
class Taylor:
    """A matrix M0 (rows, columns) and its change with the modes M1 (rows, modes, columns)."""

    m0: np.ndarray
    m1: np.ndarray | None
    structure: int


@dataclass(frozen=True)
class SidFile:
    """All that a file says."""

    comment: str
    name: str
    mass: float
    frequencies_hz: np.ndarray
    labels: tuple[int, ...]
    nodes: tuple[dict[str, Taylor], ...]
    blocks: dict[str, Taylor]


class _Lines:
    def __init__(self, text):
        if not text.isascii():
            raise SidError("not ASCII")
        if not text.endswith("\n") or "\r" in text or "\t" in text:
            raise SidError("lines must end in a line feed and hold no tabs")
        self.lines = [line.rstrip(" ") for line in text[:-1].split("\n")]
        self.at = 0

    def fail(self, wanted):
        found = self.lines[self.at] if self.at < len(self.lines) else "the end"
        raise SidError(f"line {self.at + 1}: {wanted!r} expected, {found!r} found")

    def match(self, pattern):
        found = self.at < len(self.lines) and re.fullmatch(pattern, self.lines[self.at])
        if not found:
            self.fail(pattern)
        self.at += 1
        return found

    def peek(self, pattern):
        return self.at < len(self.lines) and re.fullmatch(pattern, self.lines[self.at])

    def word(self, indent, text):
        self.match(" " * indent + re.escape(text))

    def value(self, indent, key, pattern):
        """Text behind the "=", which stands in one column in the whole file."""
        head = (" " * indent + key).ljust(EQUALS)
        assert len(head) == EQUALS
        return self.match(re.escape(head) + "=" + pattern).group(1)

    def integer(self, indent, key):
        return int(self.value(indent, key, r"( *\d+)"))


def _float(text):
    assert len(text) <= LONGEST_NUMBER
    return float(text.replace("D", "E"))


def _taylor(lines, indent, name, shape, nq, order):
    lines.word(indent, name)
    found_order = lines.integer(26, "order")
    nrow, ncol = lines.integer(26, "nrow"), lines.integer(26, "ncol")
    found_nq, nqn = lines.integer(26, "nq"), lines.integer(26, "nqn")
    structure = lines.integer(26, "structure")
    if (nrow, ncol, found_nq, nqn) != (*shape, nq, 0) or found_order not in order:
        raise SidError(f"{name}: head {found_order, nrow, ncol, found_nq, nqn}, {shape, nq} wanted")
    if structure not in (0, 1, 2, 3, 4):
        raise SidError(f"{name}: structure {structure}")
    m0, m1 = np.zeros(shape), np.zeros((shape[0], nq, shape[1])) if found_order else None
    last = (-1,)
    while not lines.peek(" " * indent + f"end {name}"):
        first = lines.match(rf" {{26}}m([01])\(([\d, ]+)\) *=({NUMBER})")
        fields = first.group(2).split(",")
        if not all(
            re.fullmatch(r" ?\d|\d\d|\d{3,}| \d\d", field) and len(field) > 1 for field in fields
        ):
            raise SidError(f"line {lines.at}: index fields {fields}, I2 wanted")
        # FEMBS itself writes a blank before columns of two digits, and the rest of the line moves
        moved = sum(bool(re.fullmatch(r" \d\d", field)) for field in fields)
        if lines.lines[lines.at - 1].index("=") != EQUALS + moved:
            raise SidError(f"line {lines.at}: '=' must be in column {EQUALS + 1}")
        index = tuple(int(field) - 1 for field in fields)
        constant = first.group(1) == "0"
        if len(index) != (2 if constant else 3) or (not constant and m1 is None):
            raise SidError(f"line {lines.at}: {len(index)} indices in m{first.group(1)}")
        into = m0 if constant else m1
        if min(index) < 0 or any(i >= n for i, n in zip(index, into.shape, strict=True)):
            raise SidError(f"line {lines.at}: index {index} outside {into.shape}")
        # M0 row by row, then M1 column by column, in it row by row
        here = (0, *index) if constant else (1, index[2], index[0], index[1])
        if here <= last:
            raise SidError(f"line {lines.at}: entries out of order")
        last = here
        value = _float(first.group(3))
        if value == 0.0:
            raise SidError(f"line {lines.at}: zeros are not listed")
        into[index] = value
    lines.word(indent, f"end {name}")
    if structure == 0 and last != (-1,):
        raise SidError(f"{name}: structure 0 with entries")
    # both triangles are listed, each rounded for itself
    if structure in (1, 2) and np.abs(m0 - m0.T).max() > 1e-11 * np.abs(m0).max():
        raise SidError(f"{name}: structure {structure} without symmetry")
    if structure == 4:
        if last != (-1,) and not np.array_equal(m0, np.eye(*shape)):
            raise SidError(f"{name}: structure 4 is the unit matrix")
        m0 = np.eye(*shape)
    return Taylor(m0, m1, structure)


def _plain(text, where):
    bad = [word for word in KEYWORDS if word in text]
    if bad:
        raise SidError(f"{where} {text!r} holds {bad}")
    return text


def parse_sid(text):
    """Return the contents of a file; SidError if anything is off the grammar."""
    lines = _Lines(text)
    head = lines.match(r"([ \d]{4}\d)([ \d]{3}\d)    :No\. nodes, No\. modes:(.*)")
    count, nq = int(head.group(1)), int(head.group(2))
    comment = head.group(3)
    lines.word(1, "part")
    name = lines.value(6, "new modal", " (.+)")
    lines.word(11, "refmod")
    mass = _float(lines.value(16, "mass", f"({NUMBER})"))
    if lines.integer(16, "nelastq") != nq:
        raise SidError("nelastq is not the number of modes")
    frequencies = []
    for j in range(1, nq + 1):
        found = lines.value(16, f"ielastq ({j:4d})", r" (Eigen Mode [ \d]{3}\d : [ \d.]{12} Hz)")
        frequencies.append(float(found[19:31]))
    lines.word(11, "end refmod")
    lines.word(11, "frame")
    nodes, labels = [], []
    for _ in range(count):
        labels.append(int(lines.value(16, "new node", r"( {0,8}\d{1,9})")))
        if labels[-1] > 99999:
            raise SidError(f"node {labels[-1]} overflows the buffers of readers")
        lines.value(21, "rframe", " (body ref)")
        shapes = {"origin": (3, 1), "phi": (3, nq), "psi": (3, nq), "AP": (3, 3)}
        orders = {"origin": (1,), "phi": (0, 1), "psi": (0, 1), "AP": (0, 1)}
        nodes.append(
            {key: _taylor(lines, 21, key, shapes[key], nq, orders[key]) for key in NODE_BLOCKS}
        )
        lines.word(16, "end node")
    lines.word(11, "end frame")
    if len(set(labels)) != len(labels):
        raise SidError("a node comes twice")
    shapes = {
        **{"mdCM": (3, 1), "J": (6, 1), "Ct": (nq, 3), "Cr": (nq, 3), "Me": (nq, nq)},
        **{"Gr": (3, 3 * nq), "Ge": (nq, 3 * nq), "Oe": (nq, 6), "ksigma": (nq, 1)},
        **{"Ke": (nq, nq), "De": (nq, nq)},
    }
    orders = dict.fromkeys(shapes, (0,)) | dict.fromkeys(("mdCM", "J", "Cr", "Oe"), (1,))
    orders["Ct"] = (0, 1)
    blocks = {key: _taylor(lines, 11, key, shapes[key], nq, orders[key]) for key in BLOCKS}
    lines.word(6, "end modal")
    lines.word(1, "end part")
    if lines.at != len(lines.lines):
        lines.fail("the end")
    return SidFile(comment, name, mass, np.array(frequencies), tuple(labels), tuple(nodes), blocks)


def check_for_open_readers(sid):
    """Refuse what the grammar allows, but readers in use take for something else."""
    _plain(sid.name, "name")
    _plain(sid.comment, "comment")
    for block in (*sid.blocks.values(), *(b for node in sid.nodes for b in node.values())):
        if block.structure == 4:
            raise SidError("a unit matrix without entries, which readers take for zero")
    if not np.array_equal(sid.blocks["Me"].m0, np.eye(sid.frequencies_hz.size)):
        raise SidError("Me is not the unit matrix, for which readers take it")


def gyroscopic_layout(sid):
    """Return "fembs" or "mode": the order of columns in which Ge is twice Cr.M1."""
    nq = sid.frequencies_hz.size
    twice = 2.0 * sid.blocks["Cr"].m1
    limit = 1e-9 * np.abs(twice).max()
    orders = {"fembs": twice.swapaxes(1, 2), "mode": twice}
    found = [
        layout
        for layout, terms in orders.items()
        if np.abs(sid.blocks["Ge"].m0 - terms.reshape(nq, -1)).max() <= limit
    ]
    if not found:
        raise SidError("Ge is not 2 Cr.M1 in either order of its columns")
    return found[0]


def columns(sid, name, layout):
    """Return Ge or Gr as (rows, mode, component)."""
    nq = sid.frequencies_hz.size
    block = sid.blocks[name].m0
    if layout == "fembs":
        return block.reshape(-1, 3, nq).swapaxes(1, 2)
    return block.reshape(-1, nq, 3)


def tensor(rows, order):
    """Return symmetric matrices from their components (6, ...) in the given order."""
    full = np.zeros((3, 3, *rows.shape[1:]))
    for row, (a, b) in zip(rows, order, strict=True):
        full[a, b] = full[b, a] = row
    return full


def fields(sid, names):
    """Return what the file says in the fields of `floating_frame.floating_body`.

    `names` are those of the first nodes. Oe holds the symmetric part of I9 and in it the stress
    stiffening, as users of the format take it.
    """
    layout, blocks = gyroscopic_layout(sid), sid.blocks
    nq = sid.frequencies_hz.size
    halved = np.array([1.0, 1.0, 1.0, 0.5, 0.5, 0.5])[:, None, None]
    return {
        "mass_kg": sid.mass,
        "center_of_gravity_m": blocks["mdCM"].m0[:, 0] / sid.mass,
        "inertia_kg_m2": tensor(blocks["J"].m0[:, 0], J_ROWS),
        "mass": blocks["Me"].m0,
        "stiffness": blocks["Ke"].m0,
        "stress_stiffening": np.zeros((nq, nq)),
        "I3": blocks["Ct"].m0.T,
        "I4": blocks["Cr"].m0.T,
        "I5": blocks["Cr"].m1.transpose(2, 1, 0),
        "I8": 0.5 * columns(sid, "Gr", layout).transpose(0, 2, 1),
        "I9": tensor(halved * np.moveaxis(blocks["Oe"].m1, 2, 0), OE_COLUMNS),
        "nodes": [
            {
                "name": name,
                "position_m": node["origin"].m0[:, 0],
                "translations": node["phi"].m0,
                "rotations": node["psi"].m0,
            }
            for name, node in zip(names, sid.nodes[: len(names)], strict=True)
        ],
    }
