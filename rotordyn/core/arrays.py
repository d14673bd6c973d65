"""Array types of the stage, the one way arrays are made read-only, and groups of indices."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.sparse.csgraph import connected_components

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]
IntArray = npt.NDArray[np.int_]
BoolArray = npt.NDArray[np.bool_]
# Real or complex numbers of any shape.
Matrix = npt.NDArray[Any]
StringArray = npt.NDArray[np.str_]


def freeze_arrays(record: Any, *names: str) -> None:
    """Replace arrays of a frozen dataclass by read-only copies: those named, or all it declares."""
    for name in names or _declared(record):
        array = np.array(getattr(record, name))
        array.setflags(write=False)
        object.__setattr__(record, name, array)


def _declared(record: Any) -> list[str]:
    """Fields whose annotation is an array, or an array or None, and that are not None."""
    kinds = {f.name: str(f.type).removesuffix(" | None") for f in dataclasses.fields(record)}
    arrays = (name for name, kind in kinds.items() if kind.endswith("Array"))
    return [name for name in arrays if getattr(record, name, None) is not None]


class ArrayRecord:
    """Base of frozen dataclasses: arrays given to one are kept as read-only copies."""

    __slots__ = ()

    def __post_init__(self) -> None:
        freeze_arrays(self)


def together(near: BoolArray) -> list[IntArray]:
    """Return the groups of indices that are joined by a relation, shape (m, m)."""
    if not near.size:
        return []
    count, label = connected_components(near, directed=False)
    return [np.flatnonzero(label == k) for k in range(count)]
