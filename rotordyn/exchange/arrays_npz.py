"""A body as numpy arrays in one .npz file."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.atomic import replacing
from solidwhirl.rotordyn.errors import SuperelementError
from solidwhirl.rotordyn.exchange.exported import Exported
from solidwhirl.rotordyn.exchange.foreign_body import (
    EQUATION,
    NAMES,
    ForeignBody,
    checked_matrix,
    file_bytes,
    matrix_set,
    node_numbers,
    refuse_large,
    rows_of,
)
from solidwhirl.rotordyn.superelement import Superelement

_MOST_ARRAYS = 200
_MOST_NODES = 100_000
# Bytes of one array: 2000 coordinates at 700 points for pictures and more.
_MOST_ARRAY_BYTES = 400_000_000
# What is stored must not be a bomb: bytes in all over bytes of the file.
_MOST_RATIO = 1100
_LONGEST_HEADER = 10_000
_LARGEST_WHOLE = 10**12


def write_npz(element: Superelement, path: Path, speed_rad_s: float | None = None) -> Exported:
    """Write the matrices of a superelement as numpy arrays.

    Parameters
    ----------
    element
        The body.
    path
        The file.
    speed_rad_s
        Writes K0 + Ω²(Kgeo + Kspin) and ΩG at this speed as well.

    Raises
    ------
    SuperelementError
        A speed beyond what the body was reduced for.
    """
    path = Path(path)
    chosen = matrix_set(element, speed_rad_s)
    rows = rows_of(element)
    arrays: dict[str, Any] = {NAMES[role][0]: m for role, m in chosen.matrices.items()}
    arrays |= {
        "dof_node": np.array([r.node if r.component else 0 for r in rows], dtype=np.int64),
        "dof_component": np.array([r.component for r in rows], dtype=np.int64),
        "dof_frequency_hz": np.array([c.frequency_hz for c in element.coordinates]),
        "node_id": np.array(list(node_numbers(element).values()), dtype=np.int64),
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
        "equation": np.array(EQUATION),
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


def read_npz(path: Path) -> ForeignBody:
    """Read a body from numpy arrays.

    Parameters
    ----------
    path
        The file; see docs/import.md for what it must hold.

    Raises
    ------
    SuperelementError
        No such file, damage, arrays of objects (nothing is unpickled), wrong shapes, numbers that
        are not finite, or too many coordinates. Sizes are checked before numbers are read.
    """
    path = Path(path)
    content = file_bytes(path)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            arrays = _Arrays(path, archive, len(content))
            return _body(path, arrays)
    except SuperelementError:
        raise
    except (zipfile.BadZipFile, zipfile.LargeZipFile, NotImplementedError) as error:
        raise SuperelementError(f"{path}: is not an .npz file: {error}") from error
    except (OSError, EOFError, ValueError, RuntimeError, LookupError, MemoryError) as error:
        raise SuperelementError(f"{path}: is damaged: {error}") from error
    except Exception as error:
        # zlib and struct have errors of their own
        raise SuperelementError(f"{path}: is damaged: {type(error).__name__}: {error}") from error


class _Arrays:
    """Arrays of an archive, each checked before it is read."""

    def __init__(self, path: Path, archive: zipfile.ZipFile, size: int) -> None:
        self.path, self._archive = path, archive
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

    def names(self) -> tuple[str, ...]:
        return tuple(self._members)

    def has(self, name: str) -> bool:
        return name in self._members

    def shape(self, name: str) -> tuple[int, ...]:
        with self._archive.open(self._members[name]) as file:
            return self._header(name, file)[0]

    def _header(self, name: str, file: Any) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
        form: Any = np.lib.format  # without types
        magic = form.read_magic(file)
        readers = {(1, 0): form.read_array_header_1_0, (2, 0): form.read_array_header_2_0}
        if magic not in readers:
            raise SuperelementError(f"{self.path}: array {name!r}: version {magic} of the format")
        shape, fortran, kind = readers[magic](file, max_header_size=_LONGEST_HEADER)
        if kind.hasobject or kind.kind not in "fiubU" or kind.subdtype is not None:
            raise SuperelementError(
                f"{self.path}: array {name[:60]!r} holds {kind}; numbers or text are allowed, "
                "objects are never read"
            )
        if kind.itemsize * int(np.prod([float(s) for s in shape])) > _MOST_ARRAY_BYTES:
            raise SuperelementError(
                f"{self.path}: array {name[:60]!r} has shape {shape}, which is too large"
            )
        return shape, fortran, kind

    def read(self, name: str, shape: tuple[int | None, ...]) -> np.ndarray[Any, Any]:
        """An array of the given shape; None stands for any length."""
        if name not in self._members:
            known = ", ".join(sorted(self._members)[:20])
            raise SuperelementError(f"{self.path}: has no array {name!r}; it has {known}")
        with self._archive.open(self._members[name]) as file:
            found, fortran, kind = self._header(name, file)
            fits = len(found) == len(shape) and all(
                w in (None, h) for w, h in zip(shape, found, strict=True)
            )
            if not fits:
                text = ", ".join("any" if w is None else str(w) for w in shape)
                raise SuperelementError(
                    f"{self.path}: array {name!r} has shape {found}, allowed is ({text})"
                )
            count = int(np.prod(found, dtype=np.int64))
            raw = file.read(count * kind.itemsize + 1)
        if len(raw) != count * kind.itemsize:
            raise SuperelementError(
                f"{self.path}: array {name!r} has {len(raw)} bytes, {count * kind.itemsize} needed"
            )
        flat = np.frombuffer(raw, dtype=kind, count=count)
        return flat.reshape(found, order="F" if fortran else "C")

    def numbers(self, name: str, shape: tuple[int | None, ...]) -> FloatArray:
        found = self.read(name, shape)
        if found.dtype.kind not in "fiu":
            raise SuperelementError(f"{self.path}: array {name!r} holds no numbers")
        matrix = checked_matrix(f"{self.path}: array {name!r}", np.atleast_1d(found.astype(float)))
        return matrix.reshape(found.shape)

    def wholes(self, name: str, shape: tuple[int | None, ...]) -> np.ndarray[Any, Any]:
        found = self.read(name, shape)
        if found.dtype.kind not in "iu" or ((found < 0) | (found > _LARGEST_WHOLE)).any():
            raise SuperelementError(f"{self.path}: array {name!r}: whole numbers from 0 are needed")
        return found.astype(np.int64)

    def text(self, name: str) -> str | None:
        if not self.has(name):
            return None
        found = self.read(name, ())
        return str(found[()])[:200]


# Arrays that are no matrices of the coordinates.
_OTHERS = frozenset(
    {
        "dof_node",
        "dof_component",
        "dof_frequency_hz",
        "node_id",
        "node_position",
        "node_name",
        "mass",
        "center_of_gravity",
        "inertia",
        "maximum_speed_rad_s",
        "recovery_position",
        "recovery_modes",
    }
)


def _body(path: Path, arrays: _Arrays) -> ForeignBody:
    frame = arrays.text("frame")
    if frame not in (None, "inertial"):
        raise SuperelementError(f"{path}: frame is {frame!r}, allowed is 'inertial'")
    nodes = arrays.wholes("dof_node", (None,))
    n = nodes.size
    refuse_large(path, n)
    components = arrays.wholes("dof_component", (n,))
    if (components > 6).any():
        raise SuperelementError(f"{path}: array 'dof_component' has {components.max()}; 0 to 6")
    ids = arrays.wholes("node_id", (None,))
    if ids.size > _MOST_NODES or np.unique(ids).size < ids.size or (ids == 0).any():
        raise SuperelementError(
            f"{path}: array 'node_id' needs at most {_MOST_NODES} different numbers from 1"
        )
    places = arrays.numbers("node_position", (ids.size, 3))
    unknown = set(nodes[components > 0].tolist()) - set(ids.tolist())
    if unknown:
        raise SuperelementError(f"{path}: array 'dof_node' has {min(unknown)}, which is no node_id")
    matrices = {}
    for name in arrays.names():
        if name in _OTHERS:
            continue
        shape = arrays.shape(name)
        if len(shape) == 2 and shape[0] == n and shape[1] <= max(n, 6):
            matrices[name] = arrays.numbers(name, (n, None))
    shapes = {"mass": (), "center_of_gravity": (3,), "inertia": (3, 3)}
    points, modes = np.zeros((0, 3)), None
    if arrays.has("recovery_position"):
        points = arrays.numbers("recovery_position", (None, 3))
        modes = arrays.numbers("recovery_modes", (len(points), 3, n))
    return ForeignBody(
        files=(path,),
        matrices=matrices,
        nodes=nodes,
        components=components,
        positions={int(k): place for k, place in zip(ids, places, strict=True)},
        names=_names(path, arrays, ids),
        length_unit=arrays.text("length_unit"),
        mass_unit=arrays.text("mass_unit"),
        properties={k: arrays.numbers(k, s) for k, s in shapes.items() if arrays.has(k)},
        maximum_speed_rad_s=_maximum_speed(path, arrays),
        points=points,
        point_modes=modes,
    )


def _names(path: Path, arrays: _Arrays, ids: np.ndarray[Any, Any]) -> dict[int, str]:
    if not arrays.has("node_name"):
        return {}
    found = arrays.read("node_name", (ids.size,))
    if found.dtype.kind != "U":
        raise SuperelementError(f"{path}: array 'node_name' holds {found.dtype}; text is needed")
    names = {int(k): str(name) for k, name in zip(ids, found, strict=True)}
    for name in names.values():
        if len(name) > 200 or not name.isprintable():
            raise SuperelementError(f"{path}: array 'node_name': {name[:60]!r} is no name")
    return {number: name for number, name in names.items() if name}


def _maximum_speed(path: Path, arrays: _Arrays) -> float:
    if not arrays.has("maximum_speed_rad_s"):
        return float("inf")
    found = arrays.read("maximum_speed_rad_s", ())
    value = float(found[()]) if found.dtype.kind in "fiu" else float("nan")
    if not value >= 0:
        raise SuperelementError(f"{path}: array 'maximum_speed_rad_s' is {found}; 0 or more")
    return value
