"""Array types of the stage, the one way arrays are made read-only, and groups of indices."""

from __future__ import annotations

from dataclasses import fields
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
    """Replace the named arrays of a frozen dataclass by read-only copies."""
    for name in names:
        array = np.array(getattr(record, name))
        array.setflags(write=False)
        object.__setattr__(record, name, array)


class ReadOnlyArrays:
    """Base of frozen dataclasses that replace all arrays they are given by read-only copies."""

    __slots__ = ()

    def __post_init__(self) -> None:
        names = (field.name for field in fields(self))  # type: ignore[arg-type]
        freeze_arrays(self, *(n for n in names if isinstance(getattr(self, n), np.ndarray)))


def together(near: BoolArray) -> list[IntArray]:
    """Return the groups of indices that are joined by a relation, shape (m, m)."""
    if not near.size:
        return []
    count, label = connected_components(near, directed=False)
    return [np.flatnonzero(label == k) for k in range(count)]
