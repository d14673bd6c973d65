"""A body as numpy arrays in one .npz file."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.atomic import replacing
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.exchange.exported import Exported
from solidwhirl.rotordyn.exchange.matrices.foreign_body import (
    EQUATION,
    ROLES,
    ForeignBody,
    checked_matrix,
    file_bytes,
    matrix_set,
    node_numbers,
    refuse_large,
    rows_of,
)
from solidwhirl.rotordyn.superelement.record import Superelement

_MOST_ARRAYS = 200
_MOST_NODES = 100_000
# Bytes of one array: 2000 coordinates at 700 points for pictures and more.
_MOST_ARRAY_BYTES = 400_000_000
# What is stored must not be a bomb: bytes in all over bytes of the file.
_MOST_RATIO = 1100
_LARGEST_WHOLE = 10**12


def write_npz(element: Superelement, path: Path, speed_rad_s: float | None = None) -> Exported:
    """Write the matrices of a superelement as numpy arrays.

    `speed_rad_s`: writes K0 + Ω²(Kgeo + Kspin) and ΩG at this speed as well. Raises
    SuperelementError: a speed beyond what the body was reduced for.
    """
    path = Path(path)
    chosen = matrix_set(element, speed_rad_s)
    rows = rows_of(element)
    arrays: dict[str, Any] = {ROLES[role].name: m for role, m in chosen.matrices.items()}
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
    """Read a body from numpy arrays, see docs/import.md for what the file must hold.

    Raises SuperelementError: no such file, damage, arrays of objects (nothing is unpickled), wrong
    shapes, numbers that are not finite, or too many coordinates. Sizes are checked before numbers
    are read.
    """
    path = Path(path)
    content = file_bytes(path)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            return _body(_Arrays(path, archive, len(content)))
    except SuperelementError:
        raise
    except (zipfile.BadZipFile, zipfile.LargeZipFile, NotImplementedError) as error:
        raise SuperelementError(f"{path}: is not an .npz file: {error}") from error
    except Exception as error:  # zlib and struct have errors of their own
        raise SuperelementError(f"{path}: is damaged: {type(error).__name__}: {error}") from error


class _Arrays:
    """Arrays of an archive by name, each read when it is asked for; sizes are checked first."""

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
        self.names = tuple(self._members)

    def __contains__(self, name: object) -> bool:
        return name in self._members

    def error(self, name: str, said: str) -> SuperelementError:
        return SuperelementError(f"{self.path}: array {name[:60]!r} {said}")

    def shape(self, name: str) -> tuple[int, ...]:
        """Shape of an array of numbers or text, by its head alone."""
        if name not in self:
            known = ", ".join(sorted(self._members)[:20])
            raise SuperelementError(f"{self.path}: has no array {name!r}; it has {known}")
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

    def shaped(self, name: str, shape: tuple[int | None, ...]) -> np.ndarray[Any, Any]:
        """An array of the given shape; None stands for any length."""
        found = self.shape(name)
        if len(found) != len(shape) or any(
            w not in (None, h) for w, h in zip(shape, found, strict=True)
        ):
            text = ", ".join("any" if w is None else str(w) for w in shape)
            raise self.error(name, f"has shape {found}, allowed is ({text})")
        with self._archive.open(self._members[name]) as file:
            read: Any = np.lib.format.read_array  # without types
            return np.asarray(read(file, allow_pickle=False))

    def numbers(self, name: str, shape: tuple[int | None, ...]) -> FloatArray:
        found = self.shaped(name, shape)
        if found.dtype.kind not in "fiu":
            raise self.error(name, f"holds {found.dtype}; numbers are needed")
        matrix = checked_matrix(f"{self.path}: array {name!r}", np.atleast_1d(found.astype(float)))
        return matrix.reshape(found.shape)

    def wholes(self, name: str, shape: tuple[int | None, ...]) -> np.ndarray[Any, Any]:
        found = self.shaped(name, shape)
        if found.dtype.kind not in "iu" or ((found < 0) | (found > _LARGEST_WHOLE)).any():
            raise self.error(name, "holds others; whole numbers from 0 are needed")
        return found.astype(np.int64)

    def text(self, name: str) -> str | None:
        return str(self.shaped(name, ())[()])[:200] if name in self else None


# Arrays that are no matrices of the coordinates.
_OTHERS = frozenset(
    [
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
    ]
)


def _body(arrays: _Arrays) -> ForeignBody:
    frame = arrays.text("frame")
    if frame not in (None, "inertial"):
        raise SuperelementError(f"{arrays.path}: frame is {frame!r}, allowed is 'inertial'")
    nodes = arrays.wholes("dof_node", (None,))
    n = nodes.size
    refuse_large(arrays.path, n)
    components = arrays.wholes("dof_component", (n,))
    if (components > 6).any():
        raise arrays.error("dof_component", f"has {components.max()}; 0 to 6")
    ids = arrays.wholes("node_id", (None,))
    if ids.size > _MOST_NODES or np.unique(ids).size < ids.size or (ids == 0).any():
        raise arrays.error(
            "node_id", f"needs at most {_MOST_NODES} different numbers, each 1 or more"
        )
    places = arrays.numbers("node_position", (ids.size, 3))
    unknown = set(nodes[components > 0].tolist()) - set(ids.tolist())
    if unknown:
        raise arrays.error("dof_node", f"has {min(unknown)}, which is no node_id")
    matrices = {}
    for name in arrays.names:
        shape = arrays.shape(name) if name not in _OTHERS else ()
        if len(shape) == 2 and shape[0] == n and shape[1] <= max(n, 6):
            matrices[name] = arrays.numbers(name, (n, None))
    shapes = {"mass": (), "center_of_gravity": (3,), "inertia": (3, 3)}
    points, modes = np.zeros((0, 3)), None
    if "recovery_position" in arrays:
        points = arrays.numbers("recovery_position", (None, 3))
        modes = arrays.numbers("recovery_modes", (len(points), 3, n))
    return ForeignBody(
        files=(arrays.path,),
        matrices=matrices,
        nodes=nodes,
        components=components,
        positions={int(k): place for k, place in zip(ids, places, strict=True)},
        names=_names(arrays, ids),
        length_unit=arrays.text("length_unit"),
        mass_unit=arrays.text("mass_unit"),
        properties={k: arrays.numbers(k, s) for k, s in shapes.items() if k in arrays},
        maximum_speed_rad_s=_maximum_speed(arrays),
        points=points,
        point_modes=modes,
    )


def _names(arrays: _Arrays, ids: np.ndarray[Any, Any]) -> dict[int, str]:
    if "node_name" not in arrays:
        return {}
    found = arrays.shaped("node_name", (ids.size,))
    if found.dtype.kind != "U":
        raise arrays.error("node_name", f"holds {found.dtype}; text is needed")
    for name in found.tolist():
        if len(name) > 200 or not (name.isprintable() or not name):
            raise arrays.error("node_name", f"has {name[:60]!r}, which is no name")
    return {number: name for number, name in zip(ids.tolist(), found.tolist(), strict=True) if name}


def _maximum_speed(arrays: _Arrays) -> float:
    if "maximum_speed_rad_s" not in arrays:
        return float("inf")
    found = arrays.shaped("maximum_speed_rad_s", ())
    value = float(found[()]) if found.dtype.kind in "fiu" else float("nan")
    if not value >= 0:
        raise arrays.error("maximum_speed_rad_s", f"is {found}; 0 or more")
    return value
