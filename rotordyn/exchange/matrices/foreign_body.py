"""A body as matrices, rows and nodes: what all formats of plain matrices hold, and their names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.core.foreign import MOST_BYTES, ForeignError, regular_bytes
from solidwhirl.rotordyn.exchange.exported import refuse_rotating
from solidwhirl.rotordyn.superelement.record import Superelement
from solidwhirl.rotordyn.superelement.validation import MOTIONS

#: Coordinates that a reader takes, at most.
MOST_COORDINATES = 2000
#: Numbers beyond this are taken for damage.
LARGEST_NUMBER = 1e60
EQUATION = "M q'' + W G q' + (K0 + W^2 (Kgeo + Kspin) + W' (1/2) G) q = f, W in rad/s about +z"


class Role(NamedTuple):
    """What is known of a matrix by its role.

    `name`, `short`: in formats with long names, and in those with eight letters.
    `symmetry`: "symmetric", "skew-symmetric" or "general".
    `multiplies`: what, in words.
    """

    name: str
    short: str
    symmetry: str
    multiplies: str


_EVEN, _SKEW, _ANY = "symmetric", "skew-symmetric", "general"
ROLES: Mapping[str, Role] = MappingProxyType(
    {
        "mass": Role("M", "MRED", _EVEN, "q''"),
        "stiffness": Role("K0", "KRED", _EVEN, "q"),
        "gyroscopic": Role("G", "CCOR", _SKEW, "W q'"),
        "stress_stiffening": Role("Kgeo", "KGEO", _EVEN, "W^2 q"),
        "spin_softening": Role("Kspin", "KSPN", _EVEN, "W^2 q, with its sign (negative)"),
        "rigid_modes": Role(
            "rigid_modes",
            "RIGB",
            _ANY,
            "columns ux uy uz rx ry rz about the origin, in the coordinates",
        ),
        "constraint": Role(
            "constraint", "TIE", _ANY, "q = constraint r, the equation is that of r"
        ),
        "spin_generator": Role(
            "L", "LSPN", _ANY, "q changes by a L q in a turn of the whole field by a small angle a"
        ),
        "stiffness_at_speed": Role(
            "K_speed", "KSPD", _EVEN, "q, K0 + W^2 (Kgeo + Kspin) at speed_rad_s"
        ),
        "gyroscopic_at_speed": Role("G_speed", "CSPD", _SKEW, "q', W G at speed_rad_s"),
    }
)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class ForeignBody:
    """Hold what a file of matrices says of a body, in the units and axes of the file.

    `files`: files it was read from, the one that was named first.
    `matrices`: by their names in the file; (n, n), or (n, columns) for rigid motions and
    constraints.
    `nodes`, `components`: row of each coordinate, shape (n,): number of its node and component 1 to
    6 (ux to rz), or 0 for the amplitude of a mode.
    `positions`: places of the nodes by number, shape (3,).
    `names`: names of the nodes that have one, by number.
    `length_unit`, `mass_unit`: as the file says them; None where it does not.
    `properties`: mass properties as the file says them, in its units: "mass", "center_of_gravity"
    (3,), "inertia" (3, 3); empty where it does not.
    `maximum_speed_rad_s`: largest speed the body was reduced for; inf where the file does not say
    it.
    `points`, `point_modes`: points for pictures, shape (p, 3), and their displacement (p, 3, n); p
    may be 0.
    """

    files: tuple[Path, ...]
    matrices: Mapping[str, FloatArray]
    nodes: np.ndarray[Any, np.dtype[np.int64]]
    components: np.ndarray[Any, np.dtype[np.int64]]
    positions: Mapping[int, FloatArray]
    names: Mapping[int, str] = field(default_factory=dict)
    length_unit: str | None = None
    mass_unit: str | None = None
    properties: Mapping[str, FloatArray] = field(default_factory=dict)
    maximum_speed_rad_s: float = np.inf
    points: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    point_modes: FloatArray | None = None

    @property
    def size(self) -> int:
        """Number of coordinates n."""
        return int(self.nodes.size)


class MatrixSet(NamedTuple):
    """Matrices of a body by role, zero and unknown ones left out; texts as in `Exported`."""

    matrices: Mapping[str, FloatArray]
    carried: tuple[str, ...]
    left_out: tuple[str, ...]


def matrix_set(element: Superelement, speed_rad_s: float | None) -> MatrixSet:
    """Return the matrices of a body by role; those at a speed if it is given, and in its range.

    Raises SuperelementError: a speed out of it, or a body in the rotating frame.
    """
    refuse_rotating(element)
    found: dict[str, FloatArray] = {"mass": element.mass, "stiffness": element.stiffness}
    carried, left = ["mass", "elastic stiffness"], list[str]()
    for role, matrix, said in (
        ("gyroscopic", element.gyroscopic, "gyroscopic matrix"),
        ("stress_stiffening", element.stress_stiffening, "stress stiffening"),
        ("spin_softening", -element.spin_softening, "spin softening"),
    ):
        if matrix.any():
            found[role] = matrix
            carried.append(said)
        else:
            left.append(f"The {said} of this body is zero and is not written.")
    if element.rigid_body_present.any():
        found["rigid_modes"] = element.rigid_body_modes
        carried.append("rigid motions")
    if element.constraint is not None:
        found["constraint"] = element.constraint
        carried.append("constraint of the coordinates")
    if element.spin_generator is not None:
        found["spin_generator"] = element.spin_generator
        carried.append("turn of the coordinates about the axis")
    if speed_rad_s is not None:
        _check_speed(element, speed_rad_s)
        change = element.stress_stiffening - element.spin_softening
        found["stiffness_at_speed"] = element.stiffness + speed_rad_s**2 * change
        found["gyroscopic_at_speed"] = speed_rad_s * element.gyroscopic
        carried.append(f"stiffness and gyroscopic matrix at {speed_rad_s:g} rad/s")
    if element.error_forms:
        left.append("What is known of the errors of the reduction (error forms) is not written.")
    return MatrixSet(matrices=found, carried=tuple(carried), left_out=tuple(left))


def _check_speed(element: Superelement, speed_rad_s: float) -> None:
    where = f"superelement {element.name!r}"
    if not np.isfinite(speed_rad_s):
        raise SuperelementError(f"{where}: speed_rad_s is {speed_rad_s}; it must be finite")
    if abs(speed_rad_s) > element.maximum_speed_rad_s:
        raise SuperelementError(
            f"{where}: speed_rad_s is {speed_rad_s:g}, the body was reduced for at most "
            f"{element.maximum_speed_rad_s:g} rad/s"
        )


class Row(NamedTuple):
    """Name one coordinate: a node and a component 1 to 6, or a scalar of its own (component 0)."""

    node: int
    component: int


def ascii_name(element: Superelement) -> str:
    """Return the name of a body for comments."""
    return element.name.encode("ascii", "replace").decode()


def node_numbers(element: Superelement) -> dict[str, int]:
    """Return the number of each interface, from 1 in their order."""
    return {node.name: k + 1 for k, node in enumerate(element.interfaces)}


def first_scalar(element: Superelement) -> int:
    """Return the number of the first modal coordinate: 1001, or more where there are more nodes."""
    start = 1000
    while start < len(element.interfaces):
        start *= 10
    return start + 1


def rows_of(element: Superelement) -> tuple[Row, ...]:
    """Return the row of each coordinate; modal ones are scalars with numbers of their own."""
    numbers, scalar = node_numbers(element), first_scalar(element)
    out = []
    for coordinate in element.coordinates:
        if coordinate.kind == "modal":
            out.append(Row(node=scalar, component=0))
            scalar += 1
        else:
            component = MOTIONS.index(coordinate.component) + 1
            out.append(Row(node=numbers[coordinate.interface], component=component))
    return tuple(out)


def checked_matrix(where: str, matrix: FloatArray) -> FloatArray:
    """Return a matrix of a file, refusing numbers that are not finite or absurdly large."""
    bad = ~(np.abs(matrix) <= LARGEST_NUMBER)
    if bad.any():
        at = tuple(int(k) for k in np.argwhere(bad)[0])
        raise SuperelementError(
            f"{where}: row {at[0] + 1}, column {at[-1] + 1} is {matrix[at]}; finite numbers up to "
            f"{LARGEST_NUMBER:g} are allowed"
        )
    return np.ascontiguousarray(matrix, dtype=np.float64)


def refuse_large(path: Path, count: int) -> None:
    """Refuse more coordinates than a body may have."""
    if count > MOST_COORDINATES:
        raise SuperelementError(
            f"{path}: has {count} coordinates or more, at most {MOST_COORDINATES} are allowed; "
            "reduce the body to its interfaces and a few modes (Craig-Bampton) in the program it "
            "comes from"
        )


def file_bytes(path: Path, most: int = MOST_BYTES) -> bytes:
    """Read a file; refuse one that can't be read or has more than `most` bytes."""
    try:
        return regular_bytes(path, most)
    except ForeignError as error:
        raise SuperelementError(f"{path}: {error}") from error
