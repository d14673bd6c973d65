"""Nastran direct matrix input (DMIG): a punch file of matrices, and bulk data of their points."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.atomic import replacing
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.exchange.exported import Exported
from solidwhirl.rotordyn.exchange.matrices import foreign_body as foreign
from solidwhirl.rotordyn.exchange.matrices.bulk_data import Card, read_cards, real_field
from solidwhirl.rotordyn.superelement.record import Superelement

# Entries that change nothing of a body that is given by its matrices.
_IGNORED = frozenset(
    {"PARAM", "ASET", "ASET1", "CSET", "CSET1", "BSET", "BSET1", "QSET", "QSET1", "EIGRL", "EIGR"}
)
_SQUARE, _RECTANGULAR, _SYMMETRIC = 1, 9, 6
_MOST_NODES = 100_000
_MOST_SCALARS = 100_000
_MOST_MATRICES = 100
_RANK = 1e-10
_MPC_SET = 1
_DIGITS = (
    "Numbers have 12 digits, so that a rigid motion may meet a stiffness of the order of 1e-12 of "
    "the largest."
)


def write_dmig(element: Superelement, path: Path, speed_rad_s: float | None = None) -> Exported:
    """Write the matrices of a superelement as Nastran DMIG entries.

    Beside the punch file there is a bulk data file of the same name that ends in `.bdf`: GRID
    points of the interfaces, scalar points of the modes, the equation and case control as
    comments, and an INCLUDE of the punch file.

    `element`: the body. If its coordinates are tied (`constraint`), the matrices are BᵀAB on scalar
    points, and MPC entries say how the interfaces follow; `path`: the punch file; it must not end
    in `.bdf`; `speed_rad_s`: writes K0 + Ω²(Kgeo + Kspin) and ΩG at this speed as well. Raises
    SuperelementError: a speed beyond what the body was reduced for, or a punch file that ends in
    `.bdf`.

    Numbers have 12 digits between 1e-10 and 1e20 and 11 elsewhere (16 columns, of which the sign
    takes one).
    """
    path = Path(path)
    if path.suffix.lower() == ".bdf":
        raise SuperelementError(
            f"{path}: the matrices go to a punch file, whose name ends in .pch; the .bdf beside it "
            "is written too"
        )
    chosen = foreign.matrix_set(element, speed_rad_s)
    tie = element.constraint
    matrices = dict(chosen.matrices)
    rows = foreign.rows_of(element)
    left = [*chosen.left_out, "Names of the interfaces are comments only."]
    left.append("Mass properties, points for pictures and the largest speed are not written.")
    left.append(_DIGITS)
    if tie is not None:
        spread = np.linalg.pinv(tie)
        matrices = {
            role: _in_other_coordinates(role, matrix, spread, tie)
            for role, matrix in matrices.items()
            if role != "constraint"
        }
        first = foreign.first_scalar(element)
        rows = tuple(foreign.Row(node=first + k, component=0) for k in range(tie.shape[1]))
        left.append(
            f"The {element.size} coordinates are tied to {tie.shape[1]} free motions: matrices are "
            "those of the free motions, on scalar points, and MPC entries move the interfaces."
        )
    bulk = path.with_suffix(".bdf")
    with replacing(bulk) as temporary:
        lines = _bulk_lines(element, path.name, matrices, rows, speed_rad_s)
        temporary.write_text("\n".join(lines) + "\n", encoding="ascii", errors="replace")
    with replacing(path) as temporary, temporary.open("w", encoding="ascii") as file:
        for line in _punch_lines(element, matrices, rows, speed_rad_s):
            file.write(line + "\n")
    return Exported(
        files=(path, bulk),
        carried=(*chosen.carried, "places of the interfaces"),
        left_out=tuple(left),
    )


def _in_other_coordinates(
    kind: str, matrix: FloatArray, to: FloatArray, back: FloatArray
) -> FloatArray:
    """Return a matrix by role in coordinates that follow from the old ones by `to`."""
    if kind == "rigid_modes":
        return np.asarray(to @ matrix)
    first = to if kind == "spin_generator" else back.T
    return np.asarray(first @ matrix @ back)


def _head(element: Superelement) -> list[str]:
    return [
        f"$ {foreign.ascii_name(element)}: superelement in SI units (m, kg, s, N, rad), inertial "
        "frame, spin about +z",
        "$ MRED q'' + OM CCOR q' + (KRED + OM**2 (KGEO + KSPN)) q = f, OM in rad/s",
    ]


def _punch_lines(
    element: Superelement,
    matrices: Mapping[str, FloatArray],
    rows: tuple[foreign.Row, ...],
    speed_rad_s: float | None,
) -> Iterator[str]:
    yield from _head(element)
    for role, matrix in matrices.items():
        name = foreign.ROLES[role].short
        at = f" {speed_rad_s:.12g}" if role.endswith("_at_speed") else ""
        yield f"$ {name}: {foreign.ROLES[role].multiplies}{at}"
        rectangular = matrix.shape[1] != matrix.shape[0]
        symmetric = foreign.ROLES[role].symmetry == "symmetric"
        form = 9 if rectangular else 6 if symmetric else 1
        count = f"{matrix.shape[1]:8d}" if rectangular else ""
        head = f"DMIG    {name:<8}{0:8d}{form:8d}{2:8d}{0:8d}{'':8}{'':8}{count}"
        yield head.rstrip()
        numbered = (foreign.Row(node=k + 1, component=0) for k in range(matrix.shape[1]))
        columns = numbered if rectangular else rows
        part = np.tril(matrix) if symmetric else matrix
        for k, column in enumerate(columns):
            at_rows = np.flatnonzero(part[:, k])
            if not at_rows.size:
                continue
            yield f"DMIG*   {name:<16}{column.node:16d}{column.component:16d}"
            for j in at_rows:
                row = rows[int(j)]
                yield f"*       {row.node:16d}{row.component:16d}{real_field(float(part[j, k]))}"


def _bulk_lines(
    element: Superelement,
    punch: str,
    matrices: Mapping[str, FloatArray],
    rows: tuple[foreign.Row, ...],
    speed_rad_s: float | None,
) -> Iterator[str]:
    yield from _head(element)
    yield from _recipe(matrices, element.constraint is not None, speed_rad_s)
    numbers = foreign.node_numbers(element)
    for node in element.interfaces:
        x, y, z = (real_field(float(v)) for v in node.position_m)
        yield f"$ {numbers[node.name]} = {node.name}"
        yield f"GRID*   {numbers[node.name]:16d}{'':16}{x}{y}"
        yield f"*       {z}"
    scalars = [row.node for row in rows if row.component == 0]
    if scalars:
        what = "free motions" if element.constraint is not None else "amplitudes of modes"
        yield f"$ {what}"
        yield f"SPOINT  {scalars[0]:8d}" + (f"    THRU{scalars[-1]:8d}" if len(scalars) > 1 else "")
    if element.constraint is not None:
        yield from _ties(element, rows)
    yield f"INCLUDE '{punch}'"


def _recipe(
    matrices: Mapping[str, FloatArray], tied: bool, speed_rad_s: float | None
) -> Iterator[str]:
    """Case control as comments."""
    yield "$ Case control, modes at rest (SOL 103):"
    yield "$   M2GG = MRED"
    yield "$   K2GG = KRED"
    if tied:
        yield f"$   MPC = {_MPC_SET}"
    if "gyroscopic" in matrices:
        terms = [
            foreign.ROLES[r].short for r in ("stress_stiffening", "spin_softening") if r in matrices
        ]
        change = "".join(f", (OM**2)*{name}" for name in terms)
        yield "$ Case control at a speed OM (complex eigenvalues, SOL 107, 110; numbers for (..)):"
        yield f"$   M2PP = MRED      K2PP = KRED{change}      B2PP = (OM)*CCOR"
        yield "$   (M2GG, K2GG, B2GG take symmetric matrices only; CCOR is skew and goes to B2PP.)"
    if speed_rad_s is not None:
        yield f"$ KSPD and CSPD hold stiffness and gyroscopic matrix at {speed_rad_s:.12g} rad/s:"
        yield "$   M2PP = MRED      K2PP = KSPD      B2PP = CSPD"


def _ties(element: Superelement, rows: tuple[foreign.Row, ...]) -> Iterator[str]:
    """MPC entries: 0 = −q + Σ B r."""
    assert element.constraint is not None
    for row, weights in zip(foreign.rows_of(element), element.constraint, strict=True):
        terms = [(row, -1.0)]
        terms += [(rows[int(k)], float(weights[k])) for k in np.flatnonzero(weights)]
        for k in range(0, len(terms), 2):
            first = f"MPC*    {_MPC_SET:16d}" if k == 0 else f"*       {'':16}"
            head, *more = [
                f"{r.node:16d}{r.component:16d}{real_field(w)}" for r, w in terms[k : k + 2]
            ]
            yield f"{first}{head}"
            yield f"*       {more[0]}" if more else "*"


def read_dmig(path: Path, nodes: Path | None = None) -> foreign.ForeignBody:
    """Read a body from bulk data with DMIG, GRID and SPOINT entries.

    `path`: bulk data; files that it includes are read too. A punch file alone takes its points from
    the `.bdf` beside it, if that does not include it itself; `nodes`: bulk data with the points,
    None: as above. Returns matrices by name; the coordinates are the rows of all square ones, grids
    first. MPC entries that move grids with scalar points become the matrix "TIE". Raises
    SuperelementError: entries that are damaged or that this reader does not know, complex matrices,
    points in other coordinate systems. The message names file and line.
    """
    path = Path(path)
    beside = path.with_suffix(".bdf")
    reader = _Reader(path)
    if nodes is not None:
        reader.read(Path(nodes))
    elif path.suffix.lower() != ".bdf" and beside.is_file():
        reader.read(beside)
    if path.resolve() not in {file.resolve() for file in reader.files}:
        reader.read(path)
    return reader.body()


class _Dmig:
    """One matrix that is being read."""

    def __init__(self, card: Card) -> None:
        self.card = card
        self.form = card.whole(2)
        # IFO 2 is another word for a rectangle
        self.form = _RECTANGULAR if self.form == 2 else self.form
        if self.form not in (_SQUARE, _SYMMETRIC, _RECTANGULAR):
            raise card.error(f"form is {self.form}; allowed are 1, 2, 6 and 9")
        kind = card.whole(3)
        if kind not in (1, 2):
            raise card.error(f"type is {kind}; allowed are 1 and 2 (real)")
        self.columns = card.whole(7, default=0)
        foreign.refuse_large(card.path, self.columns)
        self.entries: dict[tuple[foreign.Row, foreign.Row], float] = {}


class _Reader:
    """Collect what the files of a body say."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.files: list[Path] = []
        self._positions: dict[int, FloatArray] = {}
        self._scalars: set[int] = set()
        self._matrices: dict[str, _Dmig] = {}
        self._ties: dict[foreign.Row, dict[foreign.Row, float]] = {}
        self._rows: set[foreign.Row] = set()

    def read(self, path: Path) -> None:
        """Read a file and those that it includes."""
        takers = {
            "GRID": self._grid,
            "SPOINT": self._spoint,
            "DMIG": self._dmig,
            "MPC": self._mpc,
        }
        for card in read_cards(path, self.files):
            if card.name in takers:
                takers[card.name](card)
            elif card.name not in _IGNORED:
                raise card.error(
                    "this entry is not known here; a body is given by DMIG, GRID, SPOINT and MPC "
                    "entries, so reduce it to matrices first"
                )

    def _grid(self, card: Card) -> None:
        number = card.whole(0, least=1)
        if number in self._positions:
            raise card.error(f"point {number} occurs more than once")
        for at, what in ((1, "CP"), (5, "CD")):
            if card.whole(at, default=0):
                raise card.error(f"{what} is {card.text(at)}; the basic system (0) is needed")
        if len(self._positions) >= _MOST_NODES:
            raise card.error(f"more than {_MOST_NODES} points")
        self._positions[number] = np.array([card.real(k, 0.0) for k in (2, 3, 4)])

    def _spoint(self, card: Card) -> None:
        fields = [text for text in card.fields if text]
        if len(fields) == 3 and fields[1].upper() == "THRU":
            first, last = card.whole(0, least=1), card.whole(2, least=1)
            if not first <= last < first + _MOST_SCALARS:
                raise card.error(f"points {first} to {last}")
            self._scalars |= set(range(first, last + 1))
            return
        self._scalars |= {card.whole(k, least=1) for k, text in enumerate(card.fields) if text}

    def _dmig(self, card: Card) -> None:
        name = card.text(0).upper()
        if not name.isalnum() or len(name) > 8:
            raise card.error(f"name is {name[:20]!r}; 1 to 8 letters and digits are allowed")
        if card.text(1) == "0":
            if name in self._matrices:
                raise card.error(f"matrix {name} is begun more than once")
            if len(self._matrices) >= _MOST_MATRICES:
                raise card.error(f"more than {_MOST_MATRICES} matrices")
            self._matrices[name] = _Dmig(card)
            return
        if name not in self._matrices:
            raise card.error(f"column of matrix {name} before its header")
        self._column(card, self._matrices[name])

    def _column(self, card: Card, matrix: _Dmig) -> None:
        column = foreign.Row(node=card.whole(1, least=1), component=card.whole(2, default=0))
        rectangular = matrix.form == _RECTANGULAR
        if rectangular and not 1 <= column.node <= max(matrix.columns, 1):
            raise card.error(f"column {column.node} of {matrix.columns}")
        if not rectangular:
            self._known(card, column)
        # groups of four fields: point, component, value, imaginary part
        for at in range(4, len(card.fields), 4):
            if not any(card.fields[at : at + 4]):
                continue
            row = foreign.Row(node=card.whole(at, least=1), component=card.whole(at + 1, default=0))
            self._known(card, row)
            if card.text(at + 3):
                raise card.error(f"has an imaginary part at row {row.node}, {row.component}")
            twin = (column, row) if matrix.form == _SYMMETRIC else None
            if (row, column) in matrix.entries or twin in matrix.entries:
                raise card.error(f"row {row.node}, {row.component} is given twice")
            matrix.entries[row, column] = card.real(at + 2)

    def _known(self, card: Card, row: foreign.Row) -> None:
        if row.component > 6:
            raise card.error(f"component is {row.component}; 0 to 6 are allowed")
        self._rows.add(row)
        if len(self._rows) % 64 == 0:
            foreign.refuse_large(card.path, len(self._rows))

    def _mpc(self, card: Card) -> None:
        terms: list[tuple[foreign.Row, float]] = []
        groups = [card.fields[k : k + 8] for k in range(0, len(card.fields), 8)]
        for number, group in enumerate(groups):
            for at in (1, 4):
                place = 8 * number + at
                if len(group) > at and group[at]:
                    row = foreign.Row(
                        node=card.whole(place, 1), component=card.whole(place + 1, default=0)
                    )
                    terms.append((row, card.real(place + 2)))
        if not terms or terms[0][1] == 0.0 or terms[0][0] in self._ties:
            raise card.error("needs a first point of its own, with a factor that is not 0")
        (own, factor), *others = terms
        self._ties[own] = {row: -weight / factor for row, weight in others}

    def body(self) -> foreign.ForeignBody:
        """Return what was read."""
        if not self._matrices:
            raise SuperelementError(f"{self.path}: has no DMIG entry")
        rows = sorted(self._rows, key=lambda r: (r.component == 0, r.node, r.component))
        foreign.refuse_large(self.path, len(rows))
        for row in rows:
            if row.component and row.node not in self._positions:
                raise SuperelementError(
                    f"{self.path}: point {row.node} has component {row.component} in a matrix, and "
                    "no GRID entry; name the bulk data with the points"
                )
            if not row.component and row.node in self._positions:
                raise SuperelementError(
                    f"{self.path}: grid point {row.node} has component 0 in a matrix"
                )
        matrices = {name: self._dense(name, found, rows) for name, found in self._matrices.items()}
        if self._ties:
            rows, matrices = self._tied(rows, matrices)
        return foreign.ForeignBody(
            files=tuple(self.files),
            matrices=matrices,
            nodes=np.array([r.node for r in rows], dtype=np.int64),
            components=np.array([r.component for r in rows], dtype=np.int64),
            positions=self._positions,
        )

    def _dense(self, name: str, found: _Dmig, rows: list[foreign.Row]) -> FloatArray:
        index = {row: k for k, row in enumerate(rows)}
        width = found.columns if found.form == _RECTANGULAR else len(rows)
        matrix = np.zeros((len(rows), width))
        for (row, column), value in found.entries.items():
            k = index[row]
            j = column.node - 1 if found.form == _RECTANGULAR else index[column]
            matrix[k, j] = value
            if found.form == _SYMMETRIC:
                matrix[j, k] = value
        return foreign.checked_matrix(f"{found.card.path}: matrix {name}", matrix)

    def _tied(
        self, rows: list[foreign.Row], matrices: dict[str, FloatArray]
    ) -> tuple[list[foreign.Row], dict[str, FloatArray]]:
        """Coordinates of the grids that scalar points move, q = B r."""
        index = {row: k for k, row in enumerate(rows)}
        if any(row.component for row in rows):
            raise SuperelementError(
                f"{self.path}: MPC entries are known where all matrices are those of scalar points"
            )
        own = sorted(self._ties, key=lambda r: (r.node, r.component))
        tie = np.zeros((len(own), len(rows)))
        for k, row in enumerate(own):
            if row.node not in self._positions or not 1 <= row.component <= 6:
                raise SuperelementError(f"{self.path}: MPC moves {row.node}, which is no grid")
            for other, weight in self._ties[row].items():
                if other not in index:
                    raise SuperelementError(
                        f"{self.path}: MPC of point {row.node} names {other.node}, which is in no "
                        "matrix"
                    )
                tie[k, index[other]] = weight
        values = np.linalg.svd(tie, compute_uv=False)
        if len(own) < len(rows) or values[-1] < _RANK * values[0]:
            raise SuperelementError(f"{self.path}: MPC entries leave a free motion unseen")
        spread = np.linalg.pinv(tie)
        kinds = {"RIGB": "rigid_modes", "LSPN": "spin_generator"}
        out = {"TIE": tie}
        for name, matrix in matrices.items():
            kind = kinds.get(name, "rigid_modes" if matrix.shape[1] != len(rows) else "")
            out[name] = _in_other_coordinates(kind, matrix, tie, spread)
        return own, out
