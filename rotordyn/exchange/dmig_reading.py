"""Entries of bulk data to matrices, rows and nodes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.errors import SuperelementError
from solidwhirl.rotordyn.exchange.bulk_data import Card, read_cards
from solidwhirl.rotordyn.exchange.foreign_body import (
    ForeignBody,
    Row,
    checked_matrix,
    refuse_large,
)

# Entries that change nothing of a body that is given by its matrices.
_IGNORED = frozenset(
    {"PARAM", "ASET", "ASET1", "CSET", "CSET1", "BSET", "BSET1", "QSET", "QSET1", "EIGRL", "EIGR"}
)
_SQUARE, _RECTANGULAR, _SYMMETRIC = 1, 9, 6
_MOST_NODES = 100_000
_MOST_SCALARS = 100_000
_MOST_MATRICES = 100
_RANK = 1e-10

Entries = dict[tuple[Row, Row], float]


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
        refuse_large(card.path, self.columns)
        self.entries: Entries = {}


class DmigReader:
    """Collect what the files of a body say.

    Parameters
    ----------
    path
        The file that was named, for messages.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.files: list[Path] = []
        self._positions: dict[int, FloatArray] = {}
        self._scalars: set[int] = set()
        self._matrices: dict[str, _Dmig] = {}
        self._ties: dict[Row, dict[Row, float]] = {}
        self._rows: set[Row] = set()

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
        column = Row(node=card.whole(1, least=1), component=card.whole(2, default=0))
        rectangular = matrix.form == _RECTANGULAR
        if rectangular and not 1 <= column.node <= max(matrix.columns, 1):
            raise card.error(f"column {column.node} of {matrix.columns}")
        if not rectangular:
            self._known(card, column)
        # groups of four fields: point, component, value, imaginary part
        for at in range(4, len(card.fields), 4):
            if not any(card.fields[at : at + 4]):
                continue
            row = Row(node=card.whole(at, least=1), component=card.whole(at + 1, default=0))
            self._known(card, row)
            if card.text(at + 3):
                raise card.error(f"has an imaginary part at row {row.node}, {row.component}")
            twin = (column, row) if matrix.form == _SYMMETRIC else None
            if (row, column) in matrix.entries or twin in matrix.entries:
                raise card.error(f"row {row.node}, {row.component} is given twice")
            matrix.entries[row, column] = card.real(at + 2)

    def _known(self, card: Card, row: Row) -> None:
        if row.component > 6:
            raise card.error(f"component is {row.component}; 0 to 6 are allowed")
        self._rows.add(row)
        if len(self._rows) % 64 == 0:
            refuse_large(card.path, len(self._rows))

    def _mpc(self, card: Card) -> None:
        terms: list[tuple[Row, float]] = []
        groups = [card.fields[k : k + 8] for k in range(0, len(card.fields), 8)]
        for number, group in enumerate(groups):
            for at in (1, 4):
                place = 8 * number + at
                if len(group) > at and group[at]:
                    row = Row(node=card.whole(place, 1), component=card.whole(place + 1, default=0))
                    terms.append((row, card.real(place + 2)))
        if not terms or terms[0][1] == 0.0 or terms[0][0] in self._ties:
            raise card.error("needs a first point of its own, with a factor that is not 0")
        (own, factor), *others = terms
        self._ties[own] = {row: -weight / factor for row, weight in others}

    def body(self) -> ForeignBody:
        """Return what was read."""
        if not self._matrices:
            raise SuperelementError(f"{self.path}: has no DMIG entry")
        rows = sorted(self._rows, key=lambda r: (r.component == 0, r.node, r.component))
        refuse_large(self.path, len(rows))
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
        return ForeignBody(
            files=tuple(self.files),
            matrices=matrices,
            nodes=np.array([r.node for r in rows], dtype=np.int64),
            components=np.array([r.component for r in rows], dtype=np.int64),
            positions=self._positions,
        )

    def _dense(self, name: str, found: _Dmig, rows: list[Row]) -> FloatArray:
        index = {row: k for k, row in enumerate(rows)}
        width = found.columns if found.form == _RECTANGULAR else len(rows)
        matrix = np.zeros((len(rows), width))
        for (row, column), value in found.entries.items():
            k = index[row]
            j = column.node - 1 if found.form == _RECTANGULAR else index[column]
            matrix[k, j] = value
            if found.form == _SYMMETRIC:
                matrix[j, k] = value
        return checked_matrix(f"{found.card.path}: matrix {name}", matrix)

    def _tied(
        self, rows: list[Row], matrices: dict[str, FloatArray]
    ) -> tuple[list[Row], dict[str, FloatArray]]:
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
        out = {"TIE": tie}
        for name, matrix in matrices.items():
            if name == "RIGB" or matrix.shape[1] != len(rows):
                out[name] = tie @ matrix
            elif name == "LSPN":
                out[name] = tie @ matrix @ spread
            else:
                out[name] = spread.T @ matrix @ spread
        return own, out
