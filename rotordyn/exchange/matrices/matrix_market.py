"""A folder of Matrix Market files, and a JSON that says what their rows are."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import scipy

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.atomic import replacing
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.exchange.exported import Exported
from solidwhirl.rotordyn.exchange.matrices import body_document as documents
from solidwhirl.rotordyn.exchange.matrices import foreign_body as foreign
from solidwhirl.rotordyn.exchange.matrices.body_fields import body_of
from solidwhirl.rotordyn.superelement.record import Superelement

DOCUMENT = "body.json"
# Digits after the point: doubles come back bit for bit.
_DIGITS = 17
_ALLOWED = {
    "format": ("coordinate", "array"),
    "field": ("real", "integer", "double"),
    "symmetry": ("general", "symmetric", "skew-symmetric"),
}


def write_matrix_market(
    element: Superelement, path: Path, speed_rad_s: float | None = None
) -> Exported:
    """Write the matrices of a superelement as a folder of Matrix Market files.

    Numbers come back bit for bit; zeros are left out (coordinate format), of symmetric and skew
    matrices the lower triangle is written.

    `path`: the folder; made if it is not there. `body.json` in it appears last; `speed_rad_s`:
    writes K0 + Ω²(Kgeo + Kspin) and ΩG at this speed as well. Raises SuperelementError: a speed
    beyond what the body was reduced for, or a place that is no folder.
    """
    path = Path(path)
    chosen = foreign.matrix_set(element, speed_rad_s)
    if path.exists() and not path.is_dir():
        raise SuperelementError(f"{path}: is a file; a folder is needed")
    path.mkdir(exist_ok=True)
    names = {role: f"{foreign.ROLES[role].name}.mtx" for role in chosen.matrices}
    for role, matrix in chosen.matrices.items():
        known = foreign.ROLES[role]
        at = f", speed_rad_s = {speed_rad_s!r}" if role.endswith("_at_speed") else ""
        comment = (
            f" {foreign.ascii_name(element)}: {known.name} multiplies {known.multiplies}{at}\n"
            f" rows, nodes and units are in {DOCUMENT}; inertial frame, SI"
        )
        with replacing(path / names[role]) as temporary, temporary.open("wb") as file:
            scipy.io.mmwrite(
                file,
                scipy.sparse.coo_matrix(matrix),
                comment=comment,
                field="real",
                precision=_DIGITS,
                symmetry=known.symmetry,
            )
    documents.write_document(path / DOCUMENT, documents.body_document(element, names, speed_rad_s))
    return Exported(
        files=(path / DOCUMENT, *(path / name for name in names.values())),
        carried=(*chosen.carried, "rows, nodes, units and mass properties"),
        left_out=(*chosen.left_out, "Points for pictures are not written."),
    )


def read_matrix_market(path: Path) -> foreign.ForeignBody:
    """Read a body from Matrix Market files and the JSON that names them.

    `path`: the JSON, or the folder that holds `body.json`. Raises SuperelementError: damage, a
    matrix of another size than the rows, numbers that are not finite, or too many coordinates.
    Sizes are checked before numbers are read.
    """
    path = Path(path)
    path = path / DOCUMENT if path.is_dir() else path
    document = documents.Document(path)
    matrices: dict[str, FloatArray] = {}
    files = [path]
    for role, name in document.matrix_names().items():
        if Path(name).name != name:
            raise document.error(
                f"matrices.{role[:60]}", f"is {name!r}; a file of the same folder is needed"
            )
        file = path.parent / name
        matrices[foreign.ROLES[role].name if role in foreign.ROLES else role] = read_matrix(file)
        files.append(file)
    return body_of(document, tuple(files), matrices)


def read_matrix(path: Path) -> FloatArray:
    """Read one real matrix in Matrix Market's coordinate or array format.

    It is dense, both triangles of symmetric and skew matrices filled. Raises SuperelementError:
    anything that is not so, too many coordinates, an entry that is given twice.
    """
    content = foreign.file_bytes(path)
    # scipy before 1.12 looks for the line of sizes for ever
    if not any(line.strip() and not line.startswith(b"%") for line in io.BytesIO(content)):
        raise SuperelementError(f"{path}: is no Matrix Market matrix: it has no line of sizes")
    try:
        rows, columns, entries, *kinds = scipy.io.mminfo(io.BytesIO(content))
        for (what, allowed), found in zip(_ALLOWED.items(), kinds, strict=True):
            if found not in allowed:
                raise SuperelementError(
                    f"{path}: {what} is {found[:60]!r}, allowed are {', '.join(allowed)}"
                )
        foreign.refuse_large(path, max(rows, columns))
        if min(rows, columns) < 1 or not 0 <= entries <= rows * columns:
            raise SuperelementError(f"{path}: has {entries} entries in {rows} by {columns}")
        if kinds[2] != "general" and rows != columns:
            raise SuperelementError(f"{path}: {rows} by {columns} is not square, but {kinds[2]}")
        read = scipy.sparse.coo_matrix(scipy.io.mmread(io.BytesIO(content)))
    except SuperelementError:
        raise
    except (ValueError, LookupError, ArithmeticError, TypeError, MemoryError) as error:
        raise SuperelementError(f"{path}: is no Matrix Market matrix: {error}") from error
    if len(np.unique(read.row.astype(np.int64) * columns + read.col)) < read.nnz:
        raise SuperelementError(f"{path}: an entry is given twice")
    matrix = foreign.checked_matrix(str(path), read.toarray().astype(float))
    if kinds[2] == "skew-symmetric" and np.diag(matrix).any():
        raise SuperelementError(f"{path}: a skew-symmetric matrix has a diagonal entry")
    return matrix
