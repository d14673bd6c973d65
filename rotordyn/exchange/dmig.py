"""Nastran direct matrix input (DMIG): a punch file of matrices, and bulk data of their points."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.atomic import replacing
from solidwhirl.rotordyn.errors import SuperelementError
from solidwhirl.rotordyn.exchange.dmig_reading import DmigReader
from solidwhirl.rotordyn.exchange.exported import Exported
from solidwhirl.rotordyn.exchange.foreign_body import (
    MEANING,
    NAMES,
    SYMMETRY,
    ForeignBody,
    Row,
    first_scalar,
    matrix_set,
    node_numbers,
    rows_of,
)
from solidwhirl.rotordyn.exchange.nastran_numbers import real_field
from solidwhirl.rotordyn.superelement import Superelement

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

    Parameters
    ----------
    element
        The body. If its coordinates are tied (`constraint`), the matrices are BᵀAB on scalar
        points, and MPC entries say how the interfaces follow.
    path
        The punch file; it must not end in `.bdf`.
    speed_rad_s
        Writes K0 + Ω²(Kgeo + Kspin) and ΩG at this speed as well.

    Notes
    -----
    Numbers have 12 digits between 1e-10 and 1e20 and 11 elsewhere (16 columns, of which the sign
    takes one).

    Raises
    ------
    SuperelementError
        A speed beyond what the body was reduced for, or a punch file that ends in `.bdf`.
    """
    path = Path(path)
    if path.suffix.lower() == ".bdf":
        raise SuperelementError(
            f"{path}: the matrices go to a punch file, whose name ends in .pch; the .bdf beside it "
            "is written too"
        )
    chosen = matrix_set(element, speed_rad_s)
    tie = element.constraint
    matrices = dict(chosen.matrices)
    rows = rows_of(element)
    left = [*chosen.left_out, "Names of the interfaces are comments only."]
    left.append("Mass properties, points for pictures and the largest speed are not written.")
    left.append(_DIGITS)
    if tie is not None:
        matrices = _tied(matrices, tie)
        first = first_scalar(element)
        rows = tuple(Row(node=first + k, component=0) for k in range(tie.shape[1]))
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


def _tied(matrices: Mapping[str, FloatArray], tie: FloatArray) -> dict[str, FloatArray]:
    """Matrices of the free motions r, q = B r."""
    spread = np.linalg.pinv(tie)
    out = {}
    for role, matrix in matrices.items():
        if role == "constraint":
            continue
        if role == "rigid_modes":
            out[role] = spread @ matrix
        elif role == "spin_generator":
            out[role] = spread @ matrix @ tie
        else:
            out[role] = tie.T @ matrix @ tie
    return out


def _head(element: Superelement) -> list[str]:
    name = element.name.encode("ascii", "replace").decode()
    return [
        f"$ {name}: superelement in SI units (m, kg, s, N, rad), inertial frame, spin about +z",
        "$ MRED q'' + OM CCOR q' + (KRED + OM**2 (KGEO + KSPN)) q = f, OM in rad/s",
    ]


def _punch_lines(
    element: Superelement,
    matrices: Mapping[str, FloatArray],
    rows: tuple[Row, ...],
    speed_rad_s: float | None,
) -> Iterator[str]:
    yield from _head(element)
    for role, matrix in matrices.items():
        name = NAMES[role][1]
        at = f" {speed_rad_s:.12g}" if role.endswith("_at_speed") else ""
        yield f"$ {name}: {MEANING[role]}{at}"
        rectangular = matrix.shape[1] != matrix.shape[0]
        symmetric = SYMMETRY[role] == "symmetric"
        form = 9 if rectangular else 6 if symmetric else 1
        count = f"{matrix.shape[1]:8d}" if rectangular else ""
        head = f"DMIG    {name:<8}{0:8d}{form:8d}{2:8d}{0:8d}{'':8}{'':8}{count}"
        yield head.rstrip()
        columns = _numbered(matrix.shape[1]) if rectangular else rows
        part = np.tril(matrix) if symmetric else matrix
        for k, column in enumerate(columns):
            at_rows = np.flatnonzero(part[:, k])
            if not at_rows.size:
                continue
            yield f"DMIG*   {name:<16}{column.node:16d}{column.component:16d}"
            for j in at_rows:
                row = rows[int(j)]
                yield f"*       {row.node:16d}{row.component:16d}{real_field(float(part[j, k]))}"


def _numbered(count: int) -> tuple[Row, ...]:
    """Columns of a rectangular matrix."""
    return tuple(Row(node=k + 1, component=0) for k in range(count))


def _bulk_lines(
    element: Superelement,
    punch: str,
    matrices: Mapping[str, FloatArray],
    rows: tuple[Row, ...],
    speed_rad_s: float | None,
) -> Iterator[str]:
    yield from _head(element)
    yield from _recipe(matrices, element.constraint is not None, speed_rad_s)
    numbers = node_numbers(element)
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
        terms = [NAMES[r][1] for r in ("stress_stiffening", "spin_softening") if r in matrices]
        change = "".join(f", (OM**2)*{name}" for name in terms)
        yield "$ Case control at a speed OM (complex eigenvalues, SOL 107, 110; numbers for (..)):"
        yield f"$   M2PP = MRED      K2PP = KRED{change}      B2PP = (OM)*CCOR"
        yield "$   (M2GG, K2GG, B2GG take symmetric matrices only; CCOR is skew and goes to B2PP.)"
    if speed_rad_s is not None:
        yield f"$ KSPD and CSPD hold stiffness and gyroscopic matrix at {speed_rad_s:.12g} rad/s:"
        yield "$   M2PP = MRED      K2PP = KSPD      B2PP = CSPD"


def _ties(element: Superelement, rows: tuple[Row, ...]) -> Iterator[str]:
    """MPC entries: 0 = −q + Σ B r."""
    assert element.constraint is not None
    for row, weights in zip(rows_of(element), element.constraint, strict=True):
        terms = [(row, -1.0)]
        terms += [(rows[int(k)], float(weights[k])) for k in np.flatnonzero(weights)]
        for k in range(0, len(terms), 2):
            first = f"MPC*    {_MPC_SET:16d}" if k == 0 else f"*       {'':16}"
            head, *more = [
                f"{r.node:16d}{r.component:16d}{real_field(w)}" for r, w in terms[k : k + 2]
            ]
            yield f"{first}{head}"
            yield f"*       {more[0]}" if more else "*"


def read_dmig(path: Path, nodes: Path | None = None) -> ForeignBody:
    """Read a body from bulk data with DMIG, GRID and SPOINT entries.

    Parameters
    ----------
    path
        Bulk data; files that it includes are read too. A punch file alone takes its points from the
        `.bdf` beside it, if that does not include it itself.
    nodes
        Bulk data with the points, None: as above.

    Returns
    -------
    ForeignBody
        Matrices by name; the coordinates are the rows of all square ones, grids first. MPC entries
        that move grids with scalar points become the matrix "TIE".

    Raises
    ------
    SuperelementError
        Entries that are damaged or that this reader does not know, complex matrices, points in
        other coordinate systems. The message names file and line.
    """
    path = Path(path)
    beside = path.with_suffix(".bdf")
    reader = DmigReader(path)
    if nodes is not None:
        reader.read(Path(nodes))
    elif path.suffix.lower() != ".bdf" and beside.is_file():
        reader.read(beside)
    if path.resolve() not in {file.resolve() for file in reader.files}:
        reader.read(path)
    return reader.body()
