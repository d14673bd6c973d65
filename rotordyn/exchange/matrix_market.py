"""A folder of Matrix Market files, and a JSON that says what their rows are."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.atomic import replacing
from solidwhirl.rotordyn.errors import SuperelementError
from solidwhirl.rotordyn.exchange.body_document import Document, body_document, write_document
from solidwhirl.rotordyn.exchange.exported import Exported
from solidwhirl.rotordyn.exchange.foreign_body import (
    MEANING,
    NAMES,
    SYMMETRY,
    ForeignBody,
    checked_matrix,
    file_text,
    matrix_set,
    refuse_large,
)
from solidwhirl.rotordyn.superelement import Superelement

DOCUMENT = "body.json"
_BANNER = "%%MatrixMarket"
_LONGEST_HEADER = 10_000


def write_matrix_market(
    element: Superelement, path: Path, speed_rad_s: float | None = None
) -> Exported:
    """Write the matrices of a superelement as a folder of Matrix Market files.

    All numbers have 17 digits and come back bit for bit; zeros are left out (coordinate format),
    of symmetric and skew matrices the lower triangle is written.

    Parameters
    ----------
    element
        The body.
    path
        The folder; made if it is not there. `body.json` in it appears last.
    speed_rad_s
        Writes K0 + Ω²(Kgeo + Kspin) and ΩG at this speed as well.

    Raises
    ------
    SuperelementError
        A speed beyond what the body was reduced for, or a place that is no folder.
    """
    path = Path(path)
    chosen = matrix_set(element, speed_rad_s)
    if path.exists() and not path.is_dir():
        raise SuperelementError(f"{path}: is a file; a folder is needed")
    path.mkdir(exist_ok=True)
    names = {role: f"{NAMES[role][0]}.mtx" for role in chosen.matrices}
    for role, matrix in chosen.matrices.items():
        with replacing(path / names[role]) as temporary:
            temporary.write_text(_text(element, role, matrix, speed_rad_s), encoding="ascii")
    write_document(path / DOCUMENT, body_document(element, names, speed_rad_s))
    return Exported(
        files=(path / DOCUMENT, *(path / name for name in names.values())),
        carried=(*chosen.carried, "rows, nodes, units and mass properties"),
        left_out=(*chosen.left_out, "Points for pictures are not written."),
    )


def _text(element: Superelement, role: str, matrix: FloatArray, speed: float | None) -> str:
    symmetry = SYMMETRY[role]
    part = matrix
    if symmetry != "general":
        part = np.tril(matrix, -1 if symmetry == "skew-symmetric" else 0)
    # by columns, as the format's own tools write it
    columns, rows = np.nonzero(part.T)
    name = element.name.encode("ascii", "replace").decode()
    at = f", speed_rad_s = {speed!r}" if role.endswith("_at_speed") else ""
    head = [
        f"{_BANNER} matrix coordinate real {symmetry}",
        f"% {name}: {NAMES[role][0]} multiplies {MEANING[role]}{at}",
        f"% rows, nodes and units are in {DOCUMENT}; inertial frame, SI",
        f"{matrix.shape[0]} {matrix.shape[1]} {len(rows)}",
    ]
    values = part[rows, columns].tolist()
    body = (f"{r + 1} {c + 1} {v!r}" for r, c, v in zip(rows, columns, values, strict=True))
    return "\n".join([*head, *body]) + "\n"


def read_matrix_market(path: Path) -> ForeignBody:
    """Read a body from Matrix Market files and the JSON that names them.

    Parameters
    ----------
    path
        The JSON, or the folder that holds `body.json`.

    Raises
    ------
    SuperelementError
        Damage, a matrix of another size than the rows, numbers that are not finite, or too many
        coordinates. Sizes are checked before numbers are read.
    """
    path = Path(path)
    path = path / DOCUMENT if path.is_dir() else path
    document = Document(path)
    count = len(document.rows(document.nodes()[0])[0])
    matrices: dict[str, FloatArray] = {}
    files = [path]
    for role, name in document.matrix_names().items():
        if Path(name).name != name:
            raise document.error(
                f"matrices.{role[:60]}", f"is {name!r}; a file of the same folder is needed"
            )
        file = path.parent / name
        matrix = read_matrix(file)
        if matrix.shape[0] != count:
            raise SuperelementError(
                f"{file}: has {matrix.shape[0]} rows, {path.name} has {count} coordinates"
            )
        matrices[NAMES[role][0] if role in NAMES else role] = matrix
        files.append(file)
    return document.body(tuple(files), matrices)


def read_matrix(path: Path) -> FloatArray:
    """Read one real matrix in Matrix Market's coordinate or array format.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    ndarray
        Dense, both triangles of symmetric and skew matrices filled.

    Raises
    ------
    SuperelementError
        Anything that is not so; the message names file and line.
    """
    lines = file_text(path).splitlines()
    form, symmetry = _banner(path, lines)
    at = 1
    while at < len(lines) and (lines[at].startswith("%") or not lines[at].strip()):
        at += 1
        if at > _LONGEST_HEADER:
            raise SuperelementError(f"{path}: more than {_LONGEST_HEADER} lines of comments")
    shape = _sizes(path, lines, at, form)
    if symmetry != "general" and shape[0] != shape[1]:
        raise SuperelementError(
            f"{path}, line {at + 1}: {shape[0]} by {shape[1]} is not square, but {symmetry}"
        )
    words = [line.split() for line in lines[at + 1 :] if line.strip()]
    wanted = shape[2] if form == "coordinate" else _array_count(shape, symmetry)
    if len(words) != wanted:
        raise SuperelementError(f"{path}: has {len(words)} lines of numbers, {wanted} are needed")
    width = 3 if form == "coordinate" else 1
    for k, line in enumerate(words):
        if len(line) != width:
            raise SuperelementError(
                f"{path}, entry {k + 1}: has {len(line)} numbers, {width} are needed"
            )
    table = _numbers(path, words)
    matrix = (
        _from_entries(path, table, shape, symmetry)
        if form == "coordinate"
        else _from_columns(table[:, 0], shape, symmetry)
    )
    return checked_matrix(str(path), matrix)


def _banner(path: Path, lines: list[str]) -> tuple[str, str]:
    words = lines[0].lower().split() if lines else []
    if len(words) != 5 or words[:2] != [_BANNER.lower(), "matrix"]:
        raise SuperelementError(
            f"{path}, line 1: no Matrix Market matrix; found {lines[0][:60] if lines else ''!r}"
        )
    form, field, symmetry = words[2:]
    allowed = {
        "format": (form, ("coordinate", "array")),
        "field": (field, ("real", "integer", "double")),
        "symmetry": (symmetry, ("general", "symmetric", "skew-symmetric")),
    }
    for what, (found, known) in allowed.items():
        if found not in known:
            raise SuperelementError(
                f"{path}, line 1: {what} is {found[:60]!r}, allowed are {', '.join(known)}"
            )
    return form, symmetry


def _sizes(path: Path, lines: list[str], at: int, form: str) -> tuple[int, int, int]:
    words = lines[at].split() if at < len(lines) else []
    count = 3 if form == "coordinate" else 2
    if len(words) != count or not all(w.isascii() and w.isdigit() and len(w) < 13 for w in words):
        raise SuperelementError(f"{path}, line {at + 1}: {count} sizes are needed")
    sizes = [int(word) for word in words]
    refuse_large(path, max(sizes[:2]))
    if min(sizes[:2]) < 1:
        raise SuperelementError(f"{path}, line {at + 1}: a size is 0")
    entries = sizes[2] if count == 3 else 0
    if entries > sizes[0] * sizes[1]:
        raise SuperelementError(
            f"{path}, line {at + 1}: {entries} entries in {sizes[0]} by {sizes[1]}"
        )
    return sizes[0], sizes[1], entries


def _array_count(shape: tuple[int, int, int], symmetry: str) -> int:
    n = shape[0]
    counts = {"general": n * shape[1], "symmetric": n * (n + 1) // 2}
    return counts.get(symmetry, n * (n - 1) // 2)


def _numbers(path: Path, words: list[list[str]]) -> FloatArray:
    try:
        return np.array(words, dtype=np.float64) if words else np.zeros((0, 3))
    except ValueError as error:
        raise SuperelementError(f"{path}: {error}") from error


def _from_entries(
    path: Path, table: FloatArray, shape: tuple[int, int, int], symmetry: str
) -> FloatArray:
    places = table[:, :2]
    inside = (places == np.round(places)) & (places >= 1) & (places <= np.array(shape[:2]))
    if not inside.all():
        k = int(np.flatnonzero(~inside.all(axis=1))[0])
        raise SuperelementError(
            f"{path}, entry {k + 1}: place {places[k].tolist()} is outside of {shape[:2]}"
        )
    rows, columns = places.astype(np.int64).T - 1
    seen = rows * shape[1] + columns
    if len(np.unique(seen)) < len(seen):
        raise SuperelementError(f"{path}: an entry is given twice")
    if symmetry != "general" and (columns > rows).any():
        k = int(np.flatnonzero(columns > rows)[0])
        raise SuperelementError(
            f"{path}, entry {k + 1}: lies above the diagonal of a {symmetry} matrix"
        )
    matrix = np.zeros(shape[:2])
    matrix[rows, columns] = table[:, 2]
    return _filled(path, matrix, symmetry)


def _from_columns(values: FloatArray, shape: tuple[int, int, int], symmetry: str) -> FloatArray:
    if symmetry == "general":
        return values.reshape(shape[1], shape[0]).T
    matrix = np.zeros(shape[:2])
    offset = 1 if symmetry == "skew-symmetric" else 0
    columns, rows = np.triu_indices(shape[0], offset)
    matrix[rows, columns] = values
    return _filled(Path(), matrix, symmetry)


def _filled(path: Path, lower: FloatArray, symmetry: str) -> FloatArray:
    """Both triangles of a matrix whose lower one was read."""
    if symmetry == "general":
        return lower
    if symmetry == "skew-symmetric":
        if np.diag(lower).any():
            raise SuperelementError(f"{path}: a skew-symmetric matrix has a diagonal entry")
        return lower - lower.T
    return np.asarray(lower + np.tril(lower, -1).T)
