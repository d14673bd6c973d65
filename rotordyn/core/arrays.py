"""Array types of the stage, read-only arrays, cross products, and groups of indices."""

from __future__ import annotations

from dataclasses import fields
from functools import cache
from typing import Any

import numpy as np

# As `numpy.typing.NDArray`, whose import takes longer than all of this package.
FloatArray = np.ndarray[Any, np.dtype[np.float64]]
ComplexArray = np.ndarray[Any, np.dtype[np.complex128]]
IntArray = np.ndarray[Any, np.dtype[np.int_]]
BoolArray = np.ndarray[Any, np.dtype[np.bool_]]
# Real or complex numbers of any shape.
Matrix = np.ndarray[Any, np.dtype[Any]]
StringArray = np.ndarray[Any, np.dtype[np.str_]]


def freeze_arrays(record: Any, *names: str) -> None:
    """Replace arrays of a frozen dataclass by read-only copies: those named, or all it holds."""
    for name in names or _field_names(record.__class__):
        value = getattr(record, name)
        if names or isinstance(value, np.ndarray):
            array = np.array(value)
            array.setflags(write=False)
            object.__setattr__(record, name, array)


@cache
def _field_names(kind: type) -> tuple[str, ...]:
    return tuple(field.name for field in fields(kind))


class ReadOnlyArrays:
    """Base of frozen dataclasses that replace all arrays they are given by read-only copies."""

    __slots__ = ()

    def __post_init__(self) -> None:
        freeze_arrays(self)


def real_times(matrix: FloatArray, columns: ComplexArray) -> ComplexArray:
    """Return the product of a real matrix (k, n) with complex columns (n, m), at half the work."""
    parts = np.ascontiguousarray(columns).astype(complex, copy=False).view(float)
    return np.asarray((matrix @ parts).view(complex))


def without(indices: IntArray, others: IntArray) -> IntArray:
    """Return the indices that are not among others, rising; those of −1 stand for none."""
    # the last place is that of -1
    kept = np.zeros(max(indices.max(initial=-1), others.max(initial=-1)) + 2, dtype=bool)
    kept[indices] = True
    kept[others] = False
    return np.flatnonzero(kept[:-1])


def together(near: BoolArray) -> list[IntArray]:
    """Return the groups of indices that are joined by a relation, shape (m, m)."""
    count = len(near)
    linked = near | near.T | np.eye(count, dtype=bool)
    if np.count_nonzero(linked) == count:
        return [np.array([k]) for k in range(count)]
    label, before = np.arange(count), np.full(1, -1)
    while not np.array_equal(label, before):
        # the lowest label around, and that of the index it names
        before, label = label, np.where(linked, label, count).min(axis=1, initial=count)
        label = label[label]
    return [np.flatnonzero(label == k) for k in np.unique(label)]


def cross_matrix(vectors: FloatArray) -> FloatArray:
    """Return a~ with a~ b = a × b of vectors (..., 3), shape (..., 3, 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def motion_at(places: FloatArray) -> FloatArray:
    """Return ux to rz at places (..., 3) for the six motions about the origin, (..., 6, 6)."""
    motion = np.tile(np.eye(6), (*np.shape(places)[:-1], 1, 1))
    motion[..., :3, 3:] = np.swapaxes(cross_matrix(places), -1, -2)
    return motion
