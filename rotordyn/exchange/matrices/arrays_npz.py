"""A body as numpy arrays in one .npz file."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.rotordyn.core.atomic import replacing
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.exchange.exported import Exported
from solidwhirl.rotordyn.exchange.matrices import foreign_body as foreign
from solidwhirl.rotordyn.exchange.matrices.body_fields import BodyFields, body_of
from solidwhirl.rotordyn.superelement.record import Superelement

_MOST_ARRAYS = 200
# Bytes of one array: 2000 coordinates at 700 points for pictures and more.
_MOST_ARRAY_BYTES = 400_000_000
# What is stored must not be a bomb: bytes in all over bytes of the file.
_MOST_RATIO = 1100


def write_npz(element: Superelement, path: Path, speed_rad_s: float | None = None) -> Exported:
    """Write the matrices of a superelement as numpy arrays.

    With `speed_rad_s`, K0 + Ω²(Kgeo + Kspin) and ΩG at this speed are written as well. Raises
    SuperelementError: a speed beyond what the body was reduced for.
    """
    path = Path(path)
    chosen = foreign.matrix_set(element, speed_rad_s)
    rows = foreign.rows_of(element)
    numbers = foreign.node_numbers(element)
    arrays: dict[str, Any] = {foreign.ROLES[role].name: m for role, m in chosen.matrices.items()}
    arrays |= {
        "dof_node": np.array([r.node if r.component else 0 for r in rows], dtype=np.int64),
        "dof_component": np.array([r.component for r in rows], dtype=np.int64),
        "dof_frequency_hz": np.array([c.frequency_hz for c in element.coordinates]),
        "node_id": np.array(list(numbers.values()), dtype=np.int64),
        "node_position": np.array([n.position_m for n in element.interfaces]).reshape(-1, 3),
        "node_name": np.array([n.name for n in element.interfaces], dtype=np.str_),
        "mass": np.float64(element.mass_kg),
        "center_of_gravity": element.center_of_gravity_m,
        "inertia": element.inertia_kg_m2,
        "maximum_speed_rad_s": np.float64(element.maximum_speed_rad_s),
        "recovery_position": element.recovery_points_m,
        "recovery_modes": element.recovery_modes,
        "name": np.array(element.name),
        "length_unit": np.array("m"),
        "mass_unit": np.array("kg"),
        "frame": np.array("inertial"),
        "equation": np.array(foreign.EQUATION),
    }
    if speed_rad_s is not None:
        arrays["speed_rad_s"] = np.float64(speed_rad_s)
    with replacing(path) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, **arrays)
    return Exported(
        files=(path,),
        carried=(*chosen.carried, "rows, nodes, units, mass properties, points for pictures"),
        left_out=chosen.left_out,
    )


def read_npz(path: Path) -> foreign.ForeignBody:
    """Read a body from numpy arrays, see docs/import.md for what the file must hold.

    Raises SuperelementError: no such file, damage, arrays of objects (nothing is unpickled), wrong
    shapes, numbers that are not finite, or too many coordinates. Sizes are checked before numbers
    are read.
    """
    path = Path(path)
    content = foreign.file_bytes(path)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            arrays = _Arrays(path, archive, len(content))
            return body_of(arrays, (path,), arrays.matrices())
    except SuperelementError:
        raise
    except (zipfile.BadZipFile, zipfile.LargeZipFile, NotImplementedError) as error:
        raise SuperelementError(f"{path}: is not an .npz file: {error}") from error
    except Exception as error:  # zlib and struct have errors of their own
        raise SuperelementError(f"{path}: is damaged: {type(error).__name__}: {error}") from error


class _Arrays(BodyFields):
    """Arrays of an archive by name, each read when it is asked for; sizes are checked first."""

    def __init__(self, path: Path, archive: zipfile.ZipFile, size: int) -> None:
        super().__init__(path)
        self._archive = archive
        members = archive.infolist()
        if len(members) > _MOST_ARRAYS:
            raise SuperelementError(
                f"{path}: holds {len(members)} arrays, at most {_MOST_ARRAYS} are allowed"
            )
        self._members: dict[str, zipfile.ZipInfo] = {}
        for member in members:
            name = member.filename.removesuffix(".npy")
            if name in self._members:
                raise SuperelementError(f"{path}: array {name[:60]!r} occurs twice")
            self._members[name] = member
        total = sum(member.file_size for member in members)
        if total > _MOST_RATIO * size:
            raise SuperelementError(
                f"{path}: declares {total} bytes in a file of {size}; refused as a bomb"
            )

    def label(self, name: str) -> str:
        """Return the name of an array, cut off where it is long."""
        return f"array {name[:60]!r}"

    def raw(self, name: str) -> Any:
        """Return an array, None if there is none."""
        if name not in self._members:
            return None
        self._shape(name)
        with self._archive.open(self._members[name]) as file:
            read: Any = np.lib.format.read_array  # without types
            return np.asarray(read(file, allow_pickle=False))

    def matrices(self) -> dict[str, np.ndarray[Any, Any]]:
        """Return all arrays that may be matrices of the coordinates."""
        n = int((*self._shape("dof_node"), 0)[0]) if "dof_node" in self._members else 0
        foreign.refuse_large(self.path, n)
        found = {}
        for name in self._members:
            shape = self._shape(name) if name not in _OTHERS else ()
            if len(shape) == 2 and shape[0] == n and shape[1] <= max(n, 6):
                found[name] = self.numbers(name, shape)
        return found

    def _shape(self, name: str) -> tuple[int, ...]:
        """Shape of an array of numbers or text, by its head alone."""
        form: Any = np.lib.format  # without types
        read = {(1, 0): form.read_array_header_1_0, (2, 0): form.read_array_header_2_0}
        with self._archive.open(self._members[name]) as file:
            version = form.read_magic(file)
            if version not in read:
                raise self.error(name, f"has version {version} of the format")
            shape, _, kind = read[version](file)
        if kind.hasobject or kind.kind not in "fiubU" or kind.subdtype is not None:
            raise self.error(
                name, f"holds {kind}; numbers or text are allowed, objects are never read"
            )
        if kind.itemsize * np.prod(np.array(shape, dtype=float)) > _MOST_ARRAY_BYTES:
            raise self.error(name, f"has shape {shape}, which is too large")
        return tuple(shape)


# Arrays that are no matrices of the coordinates.
_ROWS = ("dof_node", "dof_component", "dof_frequency_hz")
_NODES = ("node_id", "node_position", "node_name")
_BODY = ("mass", "center_of_gravity", "inertia", "maximum_speed_rad_s")
_OTHERS = {*_ROWS, *_NODES, *_BODY, "recovery_position", "recovery_modes"}
