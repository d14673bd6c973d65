"""An open superelement file whose every read is checked: kind, shape and size before content."""

from __future__ import annotations

import json
import math
import re
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.storage import format as layout

# Filters that the format uses; decoders of others are not trusted with bytes from elsewhere.
_DEFLATE, _SHUFFLE, _FLETCHER32 = 1, 2, 3
_FILTERS = {_DEFLATE: "gzip", _SHUFFLE: "shuffle", _FLETCHER32: "fletcher32"}
_CHECKSUM_BYTES = 4
_HEADER = {"format": layout.FORMAT, "unit_system": "SI"}
# Chunks: h5py makes them up to 1 MiB. What does not shrink is stored as it is, so a stored chunk
# is hardly larger than its content.
_LARGEST_CHUNK, _OVERHEAD = 1 << 24, 1 << 10
# gzip swells at most by 1032; below this a chunk may do so without a look.
_MOST_SWELLING, _HARMLESS = 1032, 1 << 24
# Memory of all numbers of a file: to begin with, and for each byte of the file.
_FIRST_BYTES, _BYTES_PER_BYTE = 1 << 26, 200
_NUMBER_BYTES = 8


class SuperelementFile:
    """Read parts of a superelement file, naming file and dataset in each error."""

    def __init__(self, path: Path, file: h5py.File) -> None:
        self.path = path
        self.file = file
        self._place = "the root"  # last one that was looked at
        self._left_bytes = _allowed_bytes(path.stat().st_size)
        self._counted: set[str] = set()
        self._datasets: dict[str, h5py.Dataset] = {}  # that were found in order

    @classmethod
    @contextmanager
    def open(cls, path: Path) -> Iterator[SuperelementFile]:
        """Open a file for reading and close it at the end of the block."""
        if not path.is_file():
            raise SuperelementError(f"{path}: no such file")
        try:
            file = h5py.File(path, "r")
        except Exception as error:  # h5py and numpy raise all kinds
            said = layout.printable(str(error))
            raise SuperelementError(f"{path}: not a complete HDF5 file: {said}") from error
        opened = cls(path, file)
        try:
            with file:
                yield opened
        except SuperelementError:
            raise
        except Exception as error:
            said = layout.printable(f"{opened._place} cannot be read: {error}")
            raise SuperelementError(f"{path}: damaged: {said}") from error

    def error(self, place: str, found: str) -> SuperelementError:
        """Return an error that names the file and the place in it."""
        return SuperelementError(
            f"{self.path}: {layout.printable(place, layout.LONGEST_NAME)} {layout.printable(found)}"
        )

    def named(self, error: SuperelementError) -> SuperelementError:
        """Return an error of the record with the name of the file, once."""
        text = str(error)
        prefix = f"{self.path}: "
        return (
            error if text.startswith(prefix) else SuperelementError(prefix + layout.printable(text))
        )

    def attribute(self, holder: h5py.Group | h5py.Dataset, place: str, name: str) -> Any:
        """Return a number, a short list of numbers, or a text; None if there is none."""
        where = f"attribute {name!r}" if place == "" else f"{place}: attribute {name!r}"
        self._place = where
        if name not in holder.attrs:
            return None
        found: Any = holder.attrs.get_id(name)
        count = int(np.prod(found.shape, dtype=np.float64)) if found.shape is not None else 0
        is_text = h5py.check_string_dtype(found.dtype) is not None
        if found.dtype.kind not in "fiu" and not is_text:
            raise self.error(where, f"has type {found.dtype}; a text or numbers are needed")
        if count * found.dtype.itemsize > layout.LONGEST_ATTRIBUTE or (
            is_text and found.shape != ()
        ):
            raise self.error(where, f"has shape {found.shape}; one text or few numbers are needed")
        value = holder.attrs[name]
        if isinstance(value, bytes):
            value = value.decode("utf-8", errors="replace")
        if isinstance(value, str) and len(value) > layout.LONGEST_ATTRIBUTE:
            raise self.error(
                where, f"has {len(value)} characters; {layout.LONGEST_ATTRIBUTE} are allowed"
            )
        return value

    def text_attribute(self, name: str) -> str:
        """Return a text attribute of the root."""
        value = self.attribute(self.file, "", name)
        if not isinstance(value, str):
            raise self.error(f"attribute {name!r}", f"is {value!r}; a text is needed")
        return value

    def integers_attribute(self, name: str) -> tuple[int, ...]:
        """Return a list of integers, none negative, from an attribute of the root."""
        value = np.asarray(self.attribute(self.file, "", name))
        if value.ndim != 1 or value.dtype.kind not in "iu" or value.size > layout.LARGEST_SIZE:
            raise self.error(f"attribute {name!r}", "is not a list of integers")
        for entry in value.tolist():
            if not 0 <= entry <= layout.LARGEST_SIZE:
                raise self.error(f"attribute {name!r}", f"has {entry}, allowed is 0 or more")
        return tuple(int(entry) for entry in value)

    def optional_integer_attribute(self, name: str) -> int | None:
        """Return an integer, not negative, from an attribute of the root; None if there is none."""
        value = self.attribute(self.file, "", name)
        return None if value is None else self.whole_number(f"attribute {name!r}", value)

    def whole_number(self, place: str, value: Any) -> int:
        """Return what an attribute holds as an integer, or refuse it."""
        number = np.asarray(value)
        if number.shape != () or number.dtype.kind not in "iu":
            raise self.error(place, f"is {value!r}; a whole number is needed")
        if not 0 <= number <= layout.LARGEST_SIZE:
            raise self.error(place, f"is {number}, allowed is 0 to {layout.LARGEST_SIZE}")
        return int(number)

    def dataset(self, place: str) -> h5py.Dataset:
        """Return a dataset that lies in this file itself, stored in a way that is trusted."""
        if place in self._datasets:
            return self._datasets[place]
        node = self._node(place)
        if not isinstance(node, h5py.Dataset):
            raise self.error(place, "is not a dataset")
        if node.shape is None:
            raise self.error(place, "is empty")
        fault = _storage_fault(node)
        if fault:
            raise self.error(place, fault)
        self._datasets[place] = node
        return node

    def group(self, place: str) -> h5py.Group:
        """Return a group that lies in this file itself."""
        node = self._node(place)
        if not isinstance(node, h5py.Group):
            raise self.error(place, "is not a group")
        return node

    def has(self, place: str) -> bool:
        """Return whether a group holds a name, be it a link that leads nowhere."""
        group, _, name = place.rpartition("/")
        self._place = place
        holder = self.group(group) if group else self.file
        return holder.get(name, getlink=True) is not None

    def _node(self, place: str) -> Any:
        """Return what lies at a place, following no links."""
        self._place = place
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

    def count(self, place: str, least: int) -> int:
        """Return the length of the first axis, within the limit."""
        n = self.length(place)
        if not least <= n <= layout.LARGEST_SIZE:
            allowed = f"{least} to {layout.LARGEST_SIZE}"
            raise self.error(place, f"has {n} entries, allowed are {allowed}")
        return n

    def numbers(self, place: str, shape: tuple[int, ...]) -> FloatArray:
        """Return a finite numeric dataset of exactly this shape; sizes are checked first."""
        values = self._values(place, shape)
        fits = np.abs(values) <= layout.LARGEST_NUMBER
        if not fits.all():
            bad = tuple(int(i) for i in np.argwhere(~fits)[0])
            raise self.error(
                place,
                f"has {values[bad]} at {list(bad)}; numbers must be finite and at most "
                f"{layout.LARGEST_NUMBER:g} in magnitude",
            )
        return values

    def wholes(self, place: str, shape: tuple[int, ...]) -> list[int]:
        """Return a dataset of whole numbers, none negative, of at most one axis."""
        values = np.atleast_1d(self.numbers(place, shape))
        bad = (values != np.floor(values)) | (values < 0) | (values > layout.LARGEST_WHOLE)
        if bad.any():
            raise self.error(place, f"has {values[bad][0]}; whole numbers from 0 are needed")
        return [int(value) for value in values]

    def optional_matrix(self, place: str, rows: int) -> FloatArray | None:
        """Return a matrix of any width up to its rows that a file may lack, None if absent."""
        if not self.has(place):
            return None
        shape = self.dataset(place).shape
        width = int(shape[1]) if len(shape) == 2 else 0
        if not 1 <= width <= rows:
            raise self.error(place, f"has shape {shape}, needed is ({rows}, 1 to {rows})")
        return self.numbers(place, (rows, width))

    def optional_numbers(self, place: str, shape: tuple[int, ...]) -> FloatArray | None:
        """Return a dataset that older files of the format lack, None where it is absent."""
        return self.numbers(place, shape) if self.has(place) else None

    def speed_limit(self, place: str) -> float:
        """Return a positive number that may be infinite."""
        return float(self._values(place, ()))

    def vector(self, place: str) -> FloatArray:
        """Return a finite numeric dataset of one axis."""
        return self.numbers(place, (self.length(place),))

    def _values(self, place: str, shape: tuple[int, ...]) -> FloatArray:
        self._place = place
        dataset = self.dataset(place)
        if dataset.shape != shape:
            raise self.error(place, f"has shape {dataset.shape}, needed is {shape}")
        if math.prod(shape) > layout.LARGEST_COUNT:
            raise self.error(place, f"has shape {shape}, more than {layout.LARGEST_COUNT} numbers")
        if dataset.dtype.kind not in "fiu":
            raise self.error(place, f"has type {dataset.dtype}; numbers are needed")
        self._spend(place, math.prod(shape) * max(_NUMBER_BYTES, int(dataset.dtype.itemsize)))
        try:
            with np.errstate(all="ignore"):  # too large for a double is infinite, and refused
                return np.asarray(dataset[()], dtype=np.float64)
        except Exception as error:  # h5py and numpy raise all kinds
            raise self.error(place, f"cannot be read: {error}") from error

    def _spend(self, place: str, size: int) -> None:
        """Refuse a file that declares far more numbers than its own size can hold."""
        if place in self._counted:
            return
        self._counted.add(place)
        self._left_bytes -= size
        if self._left_bytes < 0:
            total = _allowed_bytes(self.path.stat().st_size)
            raise self.error(
                place, f"brings the numbers declared above {total} bytes, too much for this file"
            )

    def texts(self, place: str, count: int) -> list[str]:
        """Return a list of texts of known length, each no longer than a name."""
        dataset = self.dataset(place)
        kind = h5py.check_string_dtype(dataset.dtype)
        if dataset.shape != (count,) or kind is None:
            raise self.error(
                place, f"has shape {dataset.shape} and type {dataset.dtype}; {count} texts needed"
            )
        if kind.length is not None and kind.length > 4 * layout.LONGEST_NAME:
            raise self.error(place, f"has texts of {kind.length} bytes")
        found = []
        for k in range(count):  # one by one: many may be the same long one
            text = self._text(place, dataset, k)
            if len(text) > layout.LONGEST_NAME or not text.isprintable():
                raise self.error(
                    place,
                    f"has {text[: layout.LONGEST_NAME]!r} at [{k}]; at most {layout.LONGEST_NAME} "
                    "printable characters are allowed",
                )
            found.append(text)
        return found

    def _text(self, place: str, dataset: h5py.Dataset, index: Any) -> str:
        try:
            return str(dataset.asstr()[index])
        except Exception as error:  # h5py and numpy raise all kinds
            raise self.error(place, f"cannot be read: {error}") from error

    def operator(self, name: str, n: int) -> FloatArray:
        """Return an operator after checking what it multiplies."""
        place = f"operators/{name}"
        dataset = self.dataset(place)
        known = layout.OPERATORS[name]
        for key in ("acts_on", "omega_power", "omega_dot_power"):
            value, needed = self.attribute(dataset, place, key), getattr(known, key)
            if np.ndim(value) != 0 or value != needed:
                raise self.error(place, f"has {key} {value!r}, needed is {needed!r}")
        return self.numbers(place, (n, n))

    def refuse_unsupported_operators(self, n: int) -> None:
        """Refuse terms the format defines, the program does not evaluate, and that are not zero."""
        for name in layout.UNSUPPORTED:
            place = f"operators/{name}"
            if not self.has(place):
                continue
            link = self.file["operators"].get(name, getlink=True)
            is_matrix = isinstance(link, h5py.HardLink) and isinstance(
                self._node(place), h5py.Dataset
            )
            if not is_matrix or self.numbers(place, (n, n)).any():
                raise self.error(place, "is a term this program does not evaluate")

    def provenance(self) -> dict[str, Any]:
        """Return the provenance; an empty one if the file has none."""
        if not self.has("provenance"):
            return {}
        text = self.attribute(self.group("provenance"), "provenance", "json")
        if text is None and self.has("provenance/json"):
            text = self._long_text("provenance/json")
        value = self.json("provenance", "{}" if text is None else text)
        if not isinstance(value, dict):
            raise self.error("provenance", "is not a JSON object")
        return value

    def _long_text(self, place: str) -> str:
        dataset = self.dataset(place)
        kind = h5py.check_string_dtype(dataset.dtype)
        if dataset.shape != () or kind is None or (kind.length or 0) > layout.LONGEST_TEXT:
            raise self.error(place, "is not one text")
        text = self._text(place, dataset, ())
        if len(text) > layout.LONGEST_TEXT:
            raise self.error(
                place, f"has {len(text)} characters, allowed are {layout.LONGEST_TEXT}"
            )
        return text

    def json(self, place: str, text: Any) -> Any:
        """Return what a JSON text holds."""
        try:
            return json.loads(text)
        except RecursionError as error:
            raise self.error(place, "is not JSON: nested too deeply") from error
        except (TypeError, ValueError) as error:
            raise self.error(place, f"is not JSON: {error}") from error


def check_header(file: SuperelementFile) -> None:
    """Refuse another format, a newer major version, or other units."""
    for name, allowed in _HEADER.items():
        value = file.text_attribute(name)
        if value != allowed:
            raise file.error(f"attribute {name!r}", f"is {value!r}, allowed is {allowed!r}")
    found = file.text_attribute("format_version")
    match = re.fullmatch(r"([0-9]{1,9})\.[0-9]+\.[0-9]+(?:[-+].*)?", found)
    if match is None or int(match.group(1)) != layout.MAJOR_VERSION:
        raise file.error(
            "attribute 'format_version'",
            f"is {found!r}; this program reads {layout.MAJOR_VERSION}.x.y",
        )
    text = file.text_attribute("units")
    if file.json("attribute 'units'", text) != layout.UNITS:
        raise file.error("attribute 'units'", f"is {text}, allowed is {json.dumps(layout.UNITS)}")
    for name, axis in (("spin_axis", [0.0, 0.0, 1.0]), ("spin_origin", [0.0, 0.0, 0.0])):
        if name == "spin_axis" or name in file.file.attrs:
            vector: npt.NDArray[Any] = np.asarray(file.attribute(file.file, "", name))
            if vector.shape != (3,) or vector.tolist() != axis:
                raise file.error(f"attribute {name!r}", f"is {vector.tolist()}, allowed is {axis}")


def _allowed_bytes(file_size: int) -> int:
    """Return how many bytes of numbers a file of some size may declare.

    Matrices of zeros shrink a thousand times, those of real bodies four times.
    """
    return _FIRST_BYTES + _BYTES_PER_BYTE * file_size


def _storage_fault(dataset: h5py.Dataset) -> str:
    """Return why a dataset's storage is not trusted; empty if it is."""
    if dataset.is_virtual or dataset.external:
        return "keeps its data in another file, which is not followed"
    found = _filters(dataset)
    strange = [str(code) for code in found if code not in _FILTERS]
    if strange:
        known = ", ".join(_FILTERS.values())
        return f"is packed by HDF5 filter {', '.join(strange)}; allowed are {known}"
    if len(set(found)) < len(found):
        return "is packed twice by the same HDF5 filter"
    chunk = dataset.chunks
    if chunk is None:
        return ""
    size = math.prod(chunk) * int(dataset.dtype.itemsize)
    if size > _LARGEST_CHUNK:
        return f"has chunks of {size} bytes, at most {_LARGEST_CHUNK} are allowed"
    return _swelling(dataset, size) if _DEFLATE in found else ""


def _filters(dataset: h5py.Dataset) -> list[int]:
    plist: Any = dataset.id.get_create_plist()
    return [int(plist.get_filter(k)[0]) for k in range(plist.get_nfilters())]


def _swelling(dataset: h5py.Dataset, chunk_bytes: int) -> str:
    """Why a compressed chunk is not what it should be: it holds more than it declares."""
    skipped = 1 << _filters(dataset).index(_DEFLATE)  # in the mask of a chunk stored unpacked
    harmless = max(_HARMLESS, 2 * chunk_bytes) // _MOST_SWELLING
    for chunk in _chunks(dataset, harmless):
        if chunk.size > chunk_bytes + _OVERHEAD:
            return f"has a chunk of {chunk.size} bytes for content of {chunk_bytes}"
        if chunk.filter_mask & skipped:
            continue
        _, packed = dataset.id.read_direct_chunk(chunk.chunk_offset)
        most = chunk_bytes + _CHECKSUM_BYTES
        try:
            content = zlib.decompressobj().decompress(packed, most + 1)
        except zlib.error as error:
            return f"cannot be read: {error}"
        if len(content) > most:
            return f"has a chunk that holds more than the {chunk_bytes} bytes it declares"
    return ""


def _chunks(dataset: h5py.Dataset, harmless: int) -> list[Any]:
    """Stored chunks larger than what does no harm."""
    if dataset.id.get_storage_size() <= harmless:
        return []
    found: list[Any] = []
    if hasattr(dataset.id, "chunk_iter"):
        dataset.id.chunk_iter(found.append)
    else:  # before h5py 3.8, slower for many
        found += [dataset.id.get_chunk_info(k) for k in range(dataset.id.get_num_chunks())]
    return [chunk for chunk in found if chunk.size > harmless]
