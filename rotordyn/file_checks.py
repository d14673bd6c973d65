"""An open superelement file whose every read is checked: kind, shape and size before content."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.errors import SuperelementError
from solidwhirl.rotordyn.file_format import (
    FORMAT,
    LARGEST_COUNT,
    LARGEST_SIZE,
    MAJOR_VERSION,
    OPERATORS,
    UNITS,
    UNSUPPORTED,
)

# What h5py raises for damaged content.
_READ_ERRORS = (OSError, RuntimeError, KeyError, TypeError, ValueError)


class SuperelementFile:
    """Read parts of a superelement file, naming file and dataset in each error.

    Parameters
    ----------
    path
        For messages.
    file
        The open HDF5 file.
    """

    def __init__(self, path: Path, file: h5py.File) -> None:
        self.path = path
        self.file = file

    @classmethod
    @contextmanager
    def open(cls, path: Path) -> Iterator[SuperelementFile]:
        """Open a file for reading and close it at the end of the block."""
        if not path.is_file():
            raise SuperelementError(f"{path}: no such file")
        try:
            file = h5py.File(path, "r")
        except OSError as error:
            raise SuperelementError(f"{path}: not a complete HDF5 file: {error}") from error
        try:
            with file:
                yield cls(path, file)
        except SuperelementError:
            raise
        except _READ_ERRORS as error:
            raise SuperelementError(f"{path}: damaged: {error}") from error

    def error(self, place: str, found: str) -> SuperelementError:
        """Return an error that names the file and the place in it."""
        return SuperelementError(f"{self.path}: {place} {found}")

    def named(self, error: SuperelementError) -> SuperelementError:
        """Return an error of the record with the name of the file, once."""
        text = str(error)
        prefix = f"{self.path}: "
        return error if text.startswith(prefix) else SuperelementError(prefix + text)

    def text_attribute(self, name: str) -> str:
        """Return a text attribute of the root."""
        value = self.file.attrs.get(name)
        if isinstance(value, bytes):
            value = value.decode("utf-8", errors="replace")
        if not isinstance(value, str):
            raise self.error(f"attribute {name!r}", f"is {value!r}; a text is needed")
        return value

    def integers_attribute(self, name: str) -> tuple[int, ...]:
        """Return a list of integers from an attribute of the root."""
        value = np.asarray(self.file.attrs.get(name, "missing"))
        if value.ndim != 1 or value.dtype.kind not in "iu" or value.size > LARGEST_SIZE:
            raise self.error(f"attribute {name!r}", "is not a list of integers")
        return tuple(int(entry) for entry in value)

    def dataset(self, place: str) -> h5py.Dataset:
        """Return a dataset that lies in this file itself."""
        node = self._node(place)
        if not isinstance(node, h5py.Dataset):
            raise self.error(place, "is not a dataset")
        if node.is_virtual or node.external:
            raise self.error(place, "keeps its data in another file, which is not followed")
        return node

    def group(self, place: str) -> h5py.Group:
        """Return a group that lies in this file itself."""
        node = self._node(place)
        if not isinstance(node, h5py.Group):
            raise self.error(place, "is not a group")
        return node

    def _node(self, place: str) -> Any:
        """Return what lies at a place, following no links."""
        parts = place.split("/")
        node: Any = self.file
        for depth, part in enumerate(parts):
            link = node.get(part, getlink=True) if isinstance(node, h5py.Group) else None
            if link is None:
                raise self.error(place, "is missing")
            if not isinstance(link, h5py.HardLink):
                raise self.error("/".join(parts[: depth + 1]), "is a link; links are not followed")
            node = node[part]
        return node

    def length(self, place: str) -> int:
        """Return the length of the first axis, not reading the data."""
        shape = self.dataset(place).shape
        if not shape:
            raise self.error(place, f"has shape {shape}; an array is needed")
        return int(shape[0])

    def coordinate_count(self) -> int:
        """Return the number of coordinates n, within the limit."""
        n = self.length("dof/component")
        if not 1 <= n <= LARGEST_SIZE:
            raise self.error("dof/component", f"has {n} entries, allowed are 1 to {LARGEST_SIZE}")
        return n

    def interface_count(self) -> int:
        """Return the number of interfaces, within the limit."""
        count = self.length("interface/name")
        if count > LARGEST_SIZE:
            raise self.error(
                "interface/name", f"has {count} entries, at most {LARGEST_SIZE} allowed"
            )
        return count

    def numbers(self, place: str, shape: tuple[int, ...]) -> FloatArray:
        """Return a finite numeric dataset of exactly this shape; sizes are checked first."""
        values = self._values(place, shape)
        if not np.isfinite(values).all():
            bad = tuple(int(i) for i in np.argwhere(~np.isfinite(values))[0])
            raise self.error(place, f"has {values[bad]} at {list(bad)}; numbers must be finite")
        return values

    def optional_matrix(self, place: str, rows: int) -> FloatArray | None:
        """Return a matrix of any width that a file may lack, None where it is absent."""
        group, _, name = place.rpartition("/")
        holder = self.file.get(group)
        if isinstance(holder, h5py.Group) and name not in holder:
            return None
        shape = self.dataset(place).shape
        width = int(shape[1]) if len(shape) == 2 else 0
        return self.numbers(place, (rows, width))

    def optional_numbers(self, place: str, shape: tuple[int, ...]) -> FloatArray | None:
        """Return a dataset that older files of the format lack, None where it is absent."""
        group, _, name = place.rpartition("/")
        holder = self.file.get(group)
        if isinstance(holder, h5py.Group) and name not in holder:
            return None
        return self.numbers(place, shape)

    def speed_limit(self, place: str) -> float:
        """Return a positive number that may be infinite."""
        return float(self._values(place, ()))

    def vector(self, place: str) -> FloatArray:
        """Return a finite numeric dataset of one axis."""
        return self.numbers(place, (self.length(place),))

    def _values(self, place: str, shape: tuple[int, ...]) -> FloatArray:
        dataset = self.dataset(place)
        if dataset.shape != shape:
            raise self.error(place, f"has shape {dataset.shape}, needed is {shape}")
        if int(np.prod(shape, dtype=np.int64)) > LARGEST_COUNT:
            raise self.error(place, f"has shape {shape}, more than {LARGEST_COUNT} numbers")
        if dataset.dtype.kind not in "fiu":
            raise self.error(place, f"has type {dataset.dtype}; numbers are needed")
        try:
            return np.asarray(dataset[()], dtype=np.float64)
        except _READ_ERRORS as error:
            raise self.error(place, f"cannot be read: {error}") from error

    def texts(self, place: str, count: int) -> list[str]:
        """Return a list of texts of known length."""
        dataset = self.dataset(place)
        if dataset.shape != (count,) or h5py.check_string_dtype(dataset.dtype) is None:
            raise self.error(
                place, f"has shape {dataset.shape} and type {dataset.dtype}; {count} texts needed"
            )
        try:
            return [str(text) for text in dataset.asstr()[()]]
        except _READ_ERRORS as error:
            raise self.error(place, f"cannot be read: {error}") from error

    def operator(self, name: str, n: int) -> FloatArray:
        """Return an operator after checking what it multiplies."""
        place = f"operators/{name}"
        attributes = self.dataset(place).attrs
        known = OPERATORS[name]
        for key in ("acts_on", "omega_power", "omega_dot_power"):
            value, needed = attributes.get(key), getattr(known, key)
            value = value.decode() if isinstance(value, bytes) else value
            if value != needed:
                raise self.error(place, f"has {key} {value!r}, needed is {needed!r}")
        return self.numbers(place, (n, n))

    def refuse_unsupported_operators(self, n: int) -> None:
        """Refuse terms the format defines, the program does not evaluate, and that are not zero."""
        operators = self.file["operators"]
        for name in UNSUPPORTED:
            if name not in operators:
                continue
            place = f"operators/{name}"
            link = operators.get(name, getlink=True)
            is_matrix = isinstance(link, h5py.HardLink) and isinstance(
                operators[name], h5py.Dataset
            )
            if not is_matrix or self.numbers(place, (n, n)).any():
                raise self.error(place, "is a term this program does not evaluate")

    def provenance(self) -> dict[str, Any]:
        """Return the provenance; an empty one if the file has none."""
        if "provenance" not in self.file:
            return {}
        text: Any = self.file["provenance"].attrs.get("json")
        if text is None and "provenance/json" in self.file:
            text = self.dataset("provenance/json").asstr()[()]
        try:
            value = json.loads(text if text is not None else "{}")
        except ValueError as error:
            raise self.error("provenance", f"is not JSON: {error}") from error
        if not isinstance(value, dict):
            raise self.error("provenance", "is not a JSON object")
        return value


def check_header(file: SuperelementFile) -> None:
    """Refuse another format, a newer major version, other units or another frame.

    Parameters
    ----------
    file
        The open file.

    Raises
    ------
    SuperelementError
        Naming the attribute, what was found and what is allowed.
    """
    _expect(file, "format", (FORMAT,))
    found = file.text_attribute("format_version")
    match = re.fullmatch(r"(\d+)\.(\d+)\.(\d+)(?:[-+].*)?", found)
    if match is None or int(match.group(1)) != MAJOR_VERSION:
        raise file.error(
            "attribute 'format_version'", f"is {found!r}; this program reads {MAJOR_VERSION}.x.y"
        )
    _expect(file, "unit_system", ("SI",))
    _expect(file, "frame", ("inertial",))
    try:
        units = json.loads(file.text_attribute("units"))
    except ValueError as error:
        raise file.error("attribute 'units'", f"is not JSON: {error}") from error
    if units != UNITS:
        raise file.error("attribute 'units'", f"is {units}, allowed is {UNITS}")
    axis: npt.NDArray[Any] = np.asarray(file.file.attrs.get("spin_axis", ()))
    if axis.shape != (3,) or not np.array_equal(axis, [0.0, 0.0, 1.0]):
        raise file.error("attribute 'spin_axis'", f"is {axis.tolist()}, allowed is [0, 0, 1]")


def _expect(file: SuperelementFile, name: str, allowed: tuple[str, ...]) -> None:
    value = file.text_attribute(name)
    if value not in allowed:
        raise file.error(f"attribute {name!r}", f"is {value!r}, allowed is {allowed[0]!r}")
