"""Rows of a table in any order, put on a full grid of its axes."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from solidwhirl.bearing_tables.records import AXES
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray

#: Columns of the coefficients on (ux, uy) in the order of a raveled matrix.
ENDS = ("xx", "xy", "yx", "yy")


class GridError(Exception):
    """Rows that are no table; the message says which."""


#: An axis in messages: what it is called, its unit, and what one of that is in SI.
Shown = Mapping[str, tuple[str, str, float]]
_SI: Shown = {
    "loads_n": ("load", "N", 1.0),
    "speeds_rad_s": ("speed", "rad/s", 1.0),
    "frequencies_rad_s": ("frequency", "rad/s", 1.0),
}


def on_grid(
    axes: Mapping[str, FloatArray], columns: Mapping[str, FloatArray], shown: Shown = _SI
) -> tuple[dict[str, FloatArray | None], dict[str, FloatArray]]:
    """Return the axes with their values rising, and matrices of k, c and m on their grid.

    `axes`: values by the names of `AXES`, one per row; `columns`: coefficients by names such as
    "kxx", one per row, with kxx and cxx. Missing yy is xx, other missing ones are 0; `shown`: the
    axes as messages have them.
    Raises GridError: a value of an axis that is negative, a point twice, or one that is missing.
    """
    count = columns["kxx"].size
    values: dict[str, FloatArray | None] = dict.fromkeys(AXES)
    where = []
    for name in AXES:
        if name not in axes:
            where.append(np.zeros(count, dtype=int))
            continue
        if axes[name].min() < 0:
            point = _point(shown, name, axes[name].min())
            raise GridError(f"{point}; allowed is 0 and more")
        values[name], place = np.unique(axes[name], return_inverse=True)
        where.append(place)
    sizes = [1 if values[name] is None else len(values[name]) for name in AXES]  # type: ignore[arg-type]
    size = math.prod(sizes)
    if size > count:
        words = " × ".join(f"{n} of {_SI[a][0]}" for n, a in zip(sizes, AXES, strict=True) if n > 1)
        raise GridError(
            f"{count} rows for {words}; a table over two axes needs a row for every combination "
            "of their values"
        )
    flat = np.ravel_multi_index(tuple(where), tuple(sizes))
    _refuse_twice(axes, flat, shown)
    order = np.argsort(flat)
    return values, {
        letter: _matrices(columns, letter)[order].reshape(*sizes, 2, 2) for letter in "kcm"
    }


def _refuse_twice(axes: Mapping[str, FloatArray], flat: IntArray, shown: Shown) -> None:
    """Refuse rows of one point; as many rows as points without any fill the grid."""
    if not axes and flat.size > 1:
        raise GridError(
            f"{flat.size} rows, but no column of speed, frequency or load tells them apart"
        )
    times = np.bincount(flat)
    if times.max() > 1:
        rows = np.flatnonzero(flat == int(times.argmax()))
        point = " and ".join(_point(shown, name, axes[name][rows[0]]) for name in axes)
        some = ", ".join(str(row + 1) for row in rows[:5]) + (", ..." if len(rows) > 5 else "")
        raise GridError(f"{len(rows)} rows at {point} (rows {some} of the numbers); allowed is one")


def _matrices(columns: Mapping[str, FloatArray], letter: str) -> FloatArray:
    """Matrices of one kind, shape (rows, 2, 2)."""
    zero = np.zeros_like(columns["kxx"])
    xx = columns.get(f"{letter}xx", zero)
    missing = {"xx": zero, "xy": zero, "yx": zero, "yy": xx}
    found = [columns.get(f"{letter}{end}", missing[end]) for end in ENDS]
    return np.stack(found, axis=-1).reshape(-1, 2, 2)


def _point(shown: Shown, axis: str, value: float) -> str:
    word, unit, size = shown[axis]
    return f"{word} {value / size:.6g} {unit}"
