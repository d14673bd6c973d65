"""Nastran OUTPUT4 files of dense real matrices, and a JSON that says what their rows are."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Literal

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.atomic import replacing
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.exchange.exported import Exported
from solidwhirl.rotordyn.exchange.matrices import body_document as documents
from solidwhirl.rotordyn.exchange.matrices import foreign_body as foreign
from solidwhirl.rotordyn.exchange.matrices.body_fields import body_of
from solidwhirl.rotordyn.superelement.record import Superelement

_SQUARE, _RECTANGULAR, _SYMMETRIC = 1, 2, 6
_SINGLE, _DOUBLE = 1, 2
_MOST_MATRICES = 100
_FORMAT = re.compile(r"1P,(\d{1,2})E(\d{1,2})\.(\d{1,2})")


def write_op4(
    element: Superelement,
    path: Path,
    speed_rad_s: float | None = None,
    form: Literal["binary", "ascii"] = "binary",
) -> Exported:
    """Write the matrices of a superelement as an OUTPUT4 file.

    The format has no rows; `<file>.rows.json` beside it says what they are. All numbers are
    doubles and come back bit for bit, in both forms.

    `speed_rad_s`: writes K0 + Ω²(Kgeo + Kspin) and ΩG at this speed as well; `form`: "binary",
    little endian, or "ascii", with 17 digits. Raises SuperelementError: a speed beyond what the
    body was reduced for, or an unknown form.
    """
    path = Path(path)
    if form not in ("binary", "ascii"):
        raise SuperelementError(f"form is {form!r}, allowed are 'binary' and 'ascii'")
    chosen = foreign.matrix_set(element, speed_rad_s)
    names = {role: foreign.ROLES[role].short for role in chosen.matrices}
    rows = rows_path(path)
    documents.write_document(rows, documents.body_document(element, names, speed_rad_s))
    pack = _binary if form == "binary" else _ascii
    with replacing(path) as temporary, temporary.open("wb") as file:
        for role, matrix in chosen.matrices.items():
            square = _SQUARE if matrix.shape[0] == matrix.shape[1] else _RECTANGULAR
            kind = _SYMMETRIC if foreign.ROLES[role].symmetry == "symmetric" else square
            for part in pack(names[role], matrix, kind):
                file.write(part)
    return Exported(
        files=(path, rows),
        carried=(*chosen.carried, "rows, nodes, units and mass properties (in the rows file)"),
        left_out=(*chosen.left_out, "Points for pictures are not written."),
    )


def rows_path(path: Path) -> Path:
    """Return the file that says what the rows of an OUTPUT4 file are."""
    return path.with_name(f"{path.name}.rows.json")


def _columns(matrix: FloatArray) -> Iterator[tuple[int, int, FloatArray]]:
    """Number, first row (both from 1) and values of the columns that are not zero."""
    for k, column in enumerate(matrix.T):
        at = np.flatnonzero(column)
        if at.size:
            yield k + 1, int(at[0]) + 1, column[at[0] : at[-1] + 1]


def _record(*parts: bytes) -> bytes:
    content = b"".join(parts)
    mark = struct.pack("<i", len(content))
    return mark + content + mark


def _binary(name: str, matrix: FloatArray, kind: int) -> Iterator[bytes]:
    rows, columns = matrix.shape
    yield _record(struct.pack("<4i8s", columns, rows, kind, _DOUBLE, f"{name:<8}".encode()))
    for number, first, values in _columns(matrix):
        head = struct.pack("<3i", number, first, 2 * values.size)
        yield _record(head, np.asarray(values, dtype="<f8").tobytes())
    yield _record(struct.pack("<3id", columns + 1, 1, 2, 1.0))


def _ascii(name: str, matrix: FloatArray, kind: int) -> Iterator[bytes]:
    rows, columns = matrix.shape
    yield f"{columns:8d}{rows:8d}{kind:8d}{_DOUBLE:8d}{name:<8}1P,3E23.16\n".encode()
    for number, first, values in _columns(matrix):
        yield f"{number:8d}{first:8d}{values.size:8d}\n".encode()
        texts = [f"{v:23.16E}" for v in values.tolist()]
        lines = ("".join(texts[k : k + 3]) for k in range(0, len(texts), 3))
        yield ("\n".join(lines) + "\n").encode()
    yield f"{columns + 1:8d}{1:8d}{1:8d}\n{1.0:23.16E}\n".encode()


def read_op4(path: Path, rows: Path | None = None) -> foreign.ForeignBody:
    """Read a body from an OUTPUT4 file and the JSON of its rows.

    `path`: the file, binary of either byte order or ASCII; `rows`: the JSON; None:
    `<file>.rows.json`. Raises SuperelementError: damage, sparse or complex matrices, sizes that do
    not fit, numbers that are not finite.
    """
    path = Path(path)
    beside = rows_path(path) if rows is None else Path(rows)
    if not beside.is_file():
        raise SuperelementError(
            f"{path}: an OUTPUT4 file does not say what its rows are; {beside} is needed, see "
            "docs/import.md"
        )
    document = documents.Document(beside)
    return body_of(document, (path, beside), read_op4_matrices(path))


def read_op4_matrices(path: Path) -> Mapping[str, FloatArray]:
    """Read the dense real matrices of an OUTPUT4 file by name."""
    path = Path(path)
    content = foreign.file_bytes(path)
    if len(content) >= 4 and content[:4] in (struct.pack("<i", 24), struct.pack(">i", 24)):
        return _read_binary(path, content, "<" if content[0] == 24 else ">")
    return _read_ascii(path, content)


class _Matrix:
    """A matrix that is being read."""

    def __init__(
        self, path: Path, known: Mapping[str, FloatArray], head: tuple[int, ...], name: str
    ) -> None:
        columns, rows, kind, number = head
        self.name = name.strip()
        self.where = f"{path}: matrix {self.name[:8]!r}"
        if not self.name.isalnum() or self.name in known or len(known) >= _MOST_MATRICES:
            raise SuperelementError(f"{self.where}: a new name of letters and digits is needed")
        if rows < 0:
            raise SuperelementError(f"{self.where}: is sparse (BIGMAT); write it dense")
        if not (rows >= 1 and columns >= 1):
            raise SuperelementError(f"{self.where}: has {rows} rows and {columns} columns")
        foreign.refuse_large(path, max(rows, columns))
        if kind not in (_SQUARE, _RECTANGULAR, _SYMMETRIC):
            raise SuperelementError(f"{self.where}: form is {kind}, allowed are 1, 2 and 6")
        if number not in (_SINGLE, _DOUBLE):
            raise SuperelementError(f"{self.where}: type is {number}, allowed are 1 and 2 (real)")
        self.number = number
        self.values = np.zeros((rows, columns))
        self._last = 0

    def place(self, column: int, first: int, count: int) -> FloatArray:
        """Return where the values of a column belong, or refuse one that can't be."""
        rows, columns = self.values.shape
        if first == 0:
            raise SuperelementError(f"{self.where}: column {column} is sparse; write it dense")
        if not (self._last < column <= columns and first >= 1 and 0 <= count <= rows - first + 1):
            raise SuperelementError(
                f"{self.where}: column {column} after {self._last}, rows {first} to "
                f"{first + count - 1} of a matrix of {rows} by {columns}"
            )
        self._last = column
        return self.values[first - 1 : first - 1 + count, column - 1]


def _read_binary(path: Path, content: bytes, order: str) -> dict[str, FloatArray]:
    records = _records(path, content, order)
    found: dict[str, FloatArray] = {}
    for at, record in records:
        if len(record) != 24:
            raise SuperelementError(f"{path}, byte {at}: a header of 24 bytes is needed")
        *head, name = struct.unpack(f"{order}4i8s", record)
        matrix = _Matrix(path, found, tuple(head), name.decode("ascii", "replace"))
        _read_columns(path, records, matrix, order)
        found[matrix.name] = foreign.checked_matrix(matrix.where, matrix.values)
    return found


def _records(path: Path, content: bytes, order: str) -> Iterator[tuple[int, bytes]]:
    at = 0
    while at < len(content):
        if at + 4 > len(content):
            raise SuperelementError(f"{path}, byte {at}: the file is cut off")
        (size,) = struct.unpack_from(f"{order}i", content, at)
        end = at + 4 + size
        if size < 0 or end + 4 > len(content):
            raise SuperelementError(f"{path}, byte {at}: a record of {size} bytes does not fit")
        if content[end : end + 4] != content[at : at + 4]:
            raise SuperelementError(f"{path}, byte {end}: the end of a record does not fit")
        yield at, content[at + 4 : end]
        at = end + 4


def _read_columns(
    path: Path, records: Iterator[tuple[int, bytes]], matrix: _Matrix, order: str
) -> None:
    width = 8 if matrix.number == _DOUBLE else 4
    for at, record in records:
        if len(record) < 12:
            raise SuperelementError(f"{path}, byte {at}: a column has 12 bytes or more")
        column, first, words = struct.unpack_from(f"{order}3i", record)
        if column == matrix.values.shape[1] + 1:
            return
        count = words * 4 // width
        if len(record) != 12 + count * width or words * 4 % width:
            raise SuperelementError(
                f"{path}, byte {at}: {words} words in a record of {len(record)} bytes"
            )
        there = matrix.place(column, first, count)
        there[:] = np.frombuffer(record, dtype=f"{order}f{width}", offset=12, count=count)
    raise SuperelementError(f"{matrix.where}: is cut off")


def _read_ascii(path: Path, content: bytes) -> dict[str, FloatArray]:
    try:
        lines = content.decode("ascii").splitlines()
    except UnicodeDecodeError as error:
        raise SuperelementError(
            f"{path}: is neither a binary nor an ASCII OUTPUT4 file (byte {error.start})"
        ) from error
    found: dict[str, FloatArray] = {}
    at = 0
    while at < len(lines):
        if not lines[at].strip():
            at += 1
            continue
        head = _wholes(path, lines, at, 4)
        match = _FORMAT.fullmatch(lines[at][40:].strip())
        if match is None:
            raise SuperelementError(f"{path}, line {at + 1}: no format as 1P,3E23.16 of numbers")
        matrix = _Matrix(path, found, head, lines[at][32:40])
        across, width = int(match[1]), int(match[2])
        if not (1 <= across <= 16 and 8 <= width <= 40):
            raise SuperelementError(f"{path}, line {at + 1}: format {match[0]}")
        at = _read_ascii_columns(path, lines, at + 1, matrix, (across, width))
        found[matrix.name] = foreign.checked_matrix(matrix.where, matrix.values)
    if not found:
        raise SuperelementError(f"{path}: has no matrix")
    return found


def _read_ascii_columns(
    path: Path, lines: list[str], at: int, matrix: _Matrix, form: tuple[int, int]
) -> int:
    """Read columns up to the end mark; the line behind it."""
    across, width = form
    while at < len(lines):
        column, first, count = _wholes(path, lines, at, 3)
        needed = -(-count // across)
        if column == matrix.values.shape[1] + 1:
            return at + 1 + max(needed, 1)
        there = matrix.place(column, first, count)
        if at + 1 + needed > len(lines):
            break
        values: list[float] = []
        for k in range(at + 1, at + 1 + needed):
            left = count - len(values)
            values += _reals(path, lines, k, min(left, across), width)
        there[:] = values
        at += 1 + needed
    raise SuperelementError(f"{matrix.where}: is cut off")


def _wholes(path: Path, lines: list[str], at: int, count: int) -> tuple[int, ...]:
    texts = [lines[at][8 * k : 8 * k + 8].strip() for k in range(count)]
    if not all(re.fullmatch(r"-?\d{1,8}", text) for text in texts):
        raise SuperelementError(
            f"{path}, line {at + 1}: {count} whole numbers of 8 columns are needed; found "
            f"{lines[at][:40]!r}"
        )
    return tuple(int(text) for text in texts)


def _reals(path: Path, lines: list[str], at: int, count: int, width: int) -> list[float]:
    try:
        texts = [lines[at][width * k : width * (k + 1)] for k in range(count)]
        return [float(text.replace("D", "E").replace("d", "e")) for text in texts]
    except ValueError as error:
        raise SuperelementError(f"{path}, line {at + 1}: {error}") from error
