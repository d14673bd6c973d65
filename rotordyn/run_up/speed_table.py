"""Matrices tabulated over the speed by piecewise Chebyshev interpolation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.core.arrays import FloatArray

# Interpolation error over the largest entry of each matrix; far below that of freezing the speed.
_TOLERANCE = 1e-11
# Polynomial degrees tried, each on the nodes of the one before; then the range is halved.
_DEGREES = (2, 4, 8, 16)

Sample = Callable[[float], tuple[FloatArray, ...]]


class _SpeedPiece(NamedTuple):
    """Coefficients of the Chebyshev polynomials on one range, shape (degree + 1, entries)."""

    low: float
    high: float
    coefficients: FloatArray

    def at(self, speeds_rad_s: FloatArray) -> FloatArray:
        """Return the values at speeds in the range, (s, entries)."""
        width = self.high - self.low
        if width == 0:
            return np.repeat(self.coefficients[:1], speeds_rad_s.size, axis=0)
        x = np.clip((2.0 * speeds_rad_s - self.low - self.high) / width, -1.0, 1.0)
        degrees = np.arange(self.coefficients.shape[0])
        return np.asarray(np.cos(np.outer(np.arccos(x), degrees)) @ self.coefficients)


class SpeedTable(NamedTuple):
    """Matrices as functions of the speed.

    `pieces`: ranges without gaps, rising.
    """

    pieces: tuple[_SpeedPiece, ...]
    shapes: tuple[tuple[int, ...], ...]

    @property
    def entries(self) -> int:
        """Numbers in all matrices at one speed."""
        return self.pieces[0].coefficients.shape[1]

    def __call__(self, speeds_rad_s: npt.ArrayLike) -> tuple[FloatArray, ...]:
        """Return the matrices at speeds in the range, to 1e-11 of the largest entry of each.

        `speeds_rad_s`: shape (s,). Returns arrays of shape (s, ...), those at one speed contiguous.
        """
        speeds = np.asarray(speeds_rad_s, dtype=float)
        starts = [piece.low for piece in self.pieces]
        which = np.maximum(np.searchsorted(starts, speeds, side="right") - 1, 0)
        groups = [self.pieces[k].at(speeds[which == k]) for k in np.unique(which)]
        flat = groups[0] if len(groups) == 1 else np.empty((speeds.size, self.entries))
        for k, group in zip(np.unique(which), groups, strict=True):
            if group is not flat:
                flat[which == k] = group
        return _split(flat, self.shapes)


def tabulate(sample: Sample, edges: Sequence[float], smallest_width: float) -> SpeedTable:
    """Tabulate matrices over a range of speeds.

    `smallest_width`: ranges of this width are not halved any more, wherever a kink hides. `sample`:
    gives the matrices at a speed; their shapes do not change. `edges`: speeds, strictly rising,
    between which the function is smooth. A single one tabulates that speed alone. The
    interpolation of the table has been compared with the function between the nodes.

    Chebyshev interpolation in the extreme points, which converges geometrically for analytic
    functions (Trefethen 2019, Approximation Theory and Approximation Practice, chapters 4 and 8).
    """
    first = sample(edges[0])
    shapes = tuple(matrix.shape for matrix in first)
    if len(edges) == 1:
        return SpeedTable((_SpeedPiece(edges[0], edges[0], _joined(first)[None]),), shapes)
    pieces: list[_SpeedPiece] = []
    waiting = list(pairwise(edges))[::-1]
    while waiting:
        low, high = waiting.pop()
        piece, converged = _fitted(sample, low, high)
        if converged or high - low <= smallest_width:
            pieces.append(piece)
            continue
        middle = 0.5 * (low + high)
        waiting += [(middle, high), (low, middle)]
    return SpeedTable(tuple(pieces), shapes)


def _fitted(sample: Sample, low: float, high: float) -> tuple[_SpeedPiece, bool]:
    """Return the interpolant of the first degree that predicts the nodes of the next one."""
    values: dict[float, FloatArray] = {}
    sizes: list[int] = []
    coefficients = np.empty((0, 0))
    for degree in _DEGREES:
        # rounded, so that nodes of a degree are recognised among those of the next
        nodes = np.round(np.cos(np.pi * np.arange(degree + 1) / degree), 14)
        new = [float(x) for x in nodes if float(x) not in values]
        for x in new:
            matrices = sample(0.5 * (low + high) + 0.5 * (high - low) * x)
            sizes = [matrix.size for matrix in matrices]
            values[x] = _joined(matrices)
        if coefficients.size:
            known = np.array([values[x] for x in new])
            basis = np.cos(np.outer(np.arccos(new), np.arange(coefficients.shape[0])))
            if _agree(basis @ coefficients, known, sizes):
                return _SpeedPiece(low, high, _trimmed(coefficients, sizes)), True
        coefficients = _chebyshev(np.array([values[float(x)] for x in nodes]))
    trimmed = _trimmed(coefficients, sizes)
    # nothing finer to compare with: the last coefficients must have faded
    return _SpeedPiece(low, high, trimmed), trimmed.shape[0] <= _DEGREES[-1] - 2


def _chebyshev(values: FloatArray) -> FloatArray:
    """Return the coefficients of the interpolant of values at cos(jπ/N), j = 0 … N."""
    count = values.shape[0] - 1
    index = np.arange(count + 1)
    weight = np.where((index == 0) | (index == count), 0.5, 1.0)
    transform = np.cos(np.pi * np.outer(index, index) / count) * weight * weight[:, None]
    return np.asarray(2.0 / count * transform @ values)


def _agree(guess: FloatArray, known: FloatArray, sizes: Sequence[int]) -> bool:
    """Whether two rows of matrices agree, each matrix measured by its largest entry."""
    start = 0
    for size in sizes:
        part = slice(start, start + size)
        largest = np.abs(known[:, part]).max(initial=0.0)
        if np.abs(guess[:, part] - known[:, part]).max(initial=0.0) > _TOLERANCE * largest:
            return False
        start += size
    return True


def _trimmed(coefficients: FloatArray, sizes: Sequence[int]) -> FloatArray:
    """Drop the highest degrees that add less than a tenth of the tolerance to any matrix."""
    degree = coefficients.shape[0] - 1
    while degree > 0 and _agree(
        10.0 * coefficients[degree:] + coefficients[:1], coefficients[:1], sizes
    ):
        degree -= 1
    return np.ascontiguousarray(coefficients[: degree + 1])


def _joined(matrices: tuple[FloatArray, ...]) -> FloatArray:
    return np.concatenate([matrix.ravel() for matrix in matrices])


def _split(flat: FloatArray, shapes: Sequence[tuple[int, ...]]) -> tuple[FloatArray, ...]:
    """Return the matrices in each row of flat (s, entries)."""
    ends = np.cumsum([np.prod(shape, dtype=int) for shape in shapes])
    parts = np.split(flat, ends[:-1], axis=1)
    pairs = zip(parts, shapes, strict=True)
    return tuple(part.reshape(flat.shape[0], *shape) for part, shape in pairs)
