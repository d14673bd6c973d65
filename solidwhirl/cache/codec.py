"""Frozen records as bytes and back, bit for bit, and fingerprints of them; no pickle.

A record becomes JSON beside a list of raw blocks: arrays with their memory layout (BLAS adds up in
another order where it is another), long lists of floats, bytes. Only frozen dataclasses and named
tuples of the packages that the reader names are made again, by their constructors.
"""

from __future__ import annotations

import dataclasses
import hashlib
import importlib
import json
import re
from collections.abc import Mapping, Sequence, Set
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

_PLAIN = frozenset({type(None), bool, int, float, str})
# Lists of floats from this length on become a block.
_LONG = 8
# A record of a module: no private names, nothing nested, no `__main__`.
_NAME = re.compile(r"([a-z][a-z0-9_]*(?:\.[a-z][a-z0-9_]*)*)\.([A-Za-z][A-Za-z0-9]*)")
_DTYPE = re.compile(r"[<>|][biufcUS][1-9][0-9]{0,6}")
_ALIGNMENT = 8
_LENGTH = 8

Block = bytes | memoryview
PACKAGES = frozenset({"solidwhirl"})


class CodecError(ValueError):
    """A value that can not be packed, or bytes that hold none."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Seen:
    """What fingerprints see of records, which are named with their modules.

    `left_out`: fields that do not count, by record. `large`: records that are never equal but to
    themselves and whose digests are kept as long as they live.
    """

    left_out: Mapping[str, frozenset[str]] = dataclasses.field(default_factory=dict)
    large: frozenset[str] = frozenset()
    digests: WeakKeyDictionary[Any, str] = dataclasses.field(default_factory=WeakKeyDictionary)


class _Packer:
    """JSON nodes of values; blocks in the order in which the nodes mention them."""

    def __init__(self, packages: Set[str] | None, seen: Seen) -> None:
        self.blocks: list[Block] = []
        self._packages, self._seen = packages, seen

    def node(self, value: Any) -> Any:
        kind = type(value)
        if kind in _PLAIN:
            return value
        if kind is list:
            return self._list(value)
        if kind is tuple:
            return {"t": self._list(list(value))}
        if isinstance(value, np.ndarray):
            return {"a": self._array(value)}
        if isinstance(value, np.generic):
            return {"s": self._array(np.asarray(value))}
        if kind is complex:
            return {"c": [value.real, value.imag]}
        if kind is bytes:
            return {"b": self._block(value)}
        if isinstance(value, Mapping):
            return self._mapping(value)
        return self._record(value)

    def _list(self, values: list[Any]) -> Any:
        kinds = set(map(type, values))
        if len(values) >= _LONG and kinds == {float}:
            return {"f": self._block(np.array(values).tobytes())}
        return values if kinds <= _PLAIN else [self.node(v) for v in values]

    def _mapping(self, value: Mapping[Any, Any]) -> dict[str, Any]:
        if all(type(k) is str for k in value):
            return {"m": {k: self.node(v) for k, v in value.items()}}
        return {"d": [[self.node(k), self.node(v)] for k, v in value.items()]}

    def _record(self, value: Any) -> dict[str, Any]:
        kind = type(value)
        label = f"{kind.__module__}.{kind.__qualname__}"
        if self._packages is not None and _kind_of(label, self._packages) is not kind:
            raise CodecError(f"a {kind.__qualname__} can not be kept")
        names = _names(kind)
        if hasattr(kind, "model_fields"):  # pydantic
            names = list(kind.model_fields)
        if names is None:
            raise CodecError(f"a {kind.__qualname__} can not be kept")
        skipped = self._seen.left_out.get(label, frozenset())
        fields = {n: getattr(value, n) for n in names if n not in skipped}
        if label not in self._seen.large:
            return {"r": [label, {n: self.node(v) for n, v in fields.items()}]}
        if value not in self._seen.digests:
            self._seen.digests[value] = fingerprint(fields, self._seen)
        return {"h": [label, self._seen.digests[value]]}

    def _array(self, value: np.ndarray[Any, Any]) -> list[Any]:
        """Block, type, shape, and axes by falling stride."""
        if value.dtype.kind not in "biufcUS":
            raise CodecError(f"an array of {value.dtype} can not be kept")
        if value.dtype.itemsize == 0:
            value = value.astype(f"{value.dtype.kind}1")
        axes = list(range(value.ndim))
        if not value.flags.c_contiguous:
            value = value.copy(order="K")
            axes = [int(a) for a in np.argsort([-s for s in value.strides], kind="stable")]
            value = value.transpose(axes)
        flat = np.ascontiguousarray(value)
        data = flat.reshape(-1).view(np.uint8).data if flat.size else b""
        return [self._block(data), value.dtype.str, list(value.shape), axes]

    def _block(self, data: Block) -> int:
        self.blocks.append(data)
        return len(self.blocks) - 1


def _names(kind: Any) -> list[str] | None:
    """Fields of a dataclass or of a named tuple; None: it is neither."""
    if dataclasses.is_dataclass(kind):
        return [f.name for f in dataclasses.fields(kind) if f.init]
    return list(kind._fields) if hasattr(kind, "_fields") else None


def _kind_of(label: str, packages: Set[str]) -> Any:
    """The frozen dataclass or named tuple of a name; None where the packages have none."""
    match = _NAME.fullmatch(label)
    if match is None or label.split(".")[0] not in packages:
        return None
    try:
        kind = getattr(importlib.import_module(match[1]), match[2], None)
    except ImportError:
        return None
    params = getattr(kind, "__dataclass_params__", None)
    is_frozen = hasattr(kind, "_fields") if params is None else params.frozen
    if not isinstance(kind, type) or not is_frozen:
        return None
    return kind if f"{kind.__module__}.{kind.__qualname__}" == label else None


def pack(value: Any, packages: Set[str] = PACKAGES) -> list[Block]:
    """Return a value as pieces of bytes that belong one after the other.

    `value`: frozen dataclasses and named tuples of the packages, tuples, lists, mappings, arrays,
    numbers, texts, bytes, None, nested as they like.
    Raises CodecError: something else occurs in it.
    """
    head, blocks = _pieces(value, _Packer(packages, Seen()))
    out: list[Block] = [len(head).to_bytes(_LENGTH, "little"), head]
    for block in blocks:
        out += [block, bytes(-len(block) % _ALIGNMENT)]
    return out


def fingerprint(value: Any, seen: Seen | None = None) -> str:
    """SHA-256 of a value's content, the same for values whose every bit is the same.

    `value`: as in `pack`, any frozen dataclass and pydantic record. `seen`: what counts of it.
    """
    head, blocks = _pieces(value, _Packer(None, seen or Seen()))
    digest = hashlib.sha256(head)
    for block in blocks:
        digest.update(len(block).to_bytes(_LENGTH, "little"))
        digest.update(block)
    return digest.hexdigest()


def _pieces(value: Any, packer: _Packer) -> tuple[bytes, list[Block]]:
    try:
        node = packer.node(value)
        head = json.dumps([node, [len(b) for b in packer.blocks]], separators=(",", ":"))
    except (RecursionError, ValueError) as error:
        raise error if isinstance(error, CodecError) else CodecError(str(error)) from error
    return head.encode("ascii"), packer.blocks


def unpack(data: Block, packages: Set[str] = PACKAGES) -> Any:
    """Return the value that `pack` was given.

    Raises CodecError: the bytes are no such value, or hold a record that is not allowed.
    """
    view = memoryview(data)
    end = _LENGTH + int.from_bytes(view[:_LENGTH], "little")
    if end > len(view):
        raise CodecError("it is too short")
    try:
        node, lengths = json.loads(str(view[_LENGTH:end], "ascii"))
        return _Reader(_blocks(view[end:], lengths), packages).value(node)
    except CodecError:
        raise
    except (ValueError, TypeError, KeyError, IndexError, AttributeError, RecursionError) as error:
        raise CodecError(f"it holds no record ({error})") from error


def _blocks(view: memoryview, lengths: Sequence[int]) -> list[memoryview]:
    out, place = [], 0
    for length in lengths:
        out.append(view[place : place + length])
        place += length + -length % _ALIGNMENT
    if place != len(view) or min(lengths, default=0) < 0:
        raise CodecError("its blocks are not whole")
    return out


class _Reader:
    """Values of JSON nodes."""

    def __init__(self, blocks: list[memoryview], packages: Set[str]) -> None:
        self._blocks, self._packages = blocks, packages

    def value(self, node: Any) -> Any:
        if type(node) in _PLAIN:
            return node
        if type(node) is list:
            return node if set(map(type, node)) <= _PLAIN else [self.value(n) for n in node]
        ((tag, content),) = node.items()
        match tag:
            case "t":
                return tuple(self.value(content))
            case "m":
                return {k: self.value(v) for k, v in content.items()}
            case "d":
                return {self.value(k): self.value(v) for k, v in content}
            case "c":
                return complex(*content)
            case "b":
                return bytes(self._blocks[content])
            case "f":
                return np.frombuffer(self._blocks[content], dtype=np.float64).tolist()
            case "a":
                return self._array(*content)
            case "s":
                return self._array(*content)[()]
            case "r":
                return self._record(*content)
        raise CodecError(f"it has an unknown part {tag!r}")

    def _array(self, number: int, kind: str, shape: list[int], axes: list[int]) -> Any:
        if not _DTYPE.fullmatch(kind):
            raise CodecError("an array of it has no layout")
        block, dtype = self._blocks[number], np.dtype(kind)
        flat = np.frombuffer(block, dtype) if len(block) else np.empty(0, dtype)
        out = flat.reshape(shape).copy()
        if list(out.shape) != shape:
            raise CodecError("an array of it has another size")
        out.setflags(write=False)
        return out.transpose([axes.index(a) for a in range(len(shape))])

    def _record(self, name: str, fields: Mapping[str, Any]) -> Any:
        kind = _kind_of(name, self._packages)
        if kind is None:
            raise CodecError(f"it holds a record {name!r}, which is none of this program")
        if set(fields) != set(_names(kind) or ()):
            raise CodecError(f"a record {name!r} of it has other fields")
        return kind(**{k: self.value(v) for k, v in fields.items()})
