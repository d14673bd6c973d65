"""Blocks of distributed vectors: (local rows, columns) arrays and PETSc matrices acting on them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def apply(matrix: Any, block: FloatArray) -> FloatArray:
    """Matrix times every column; rows are this rank's.

    Parameters
    ----------
    matrix
        PETSc matrix.
    block
        (local columns of the matrix, k).
    """
    x, y = matrix.createVecs()
    return _by_column(matrix.mult, x, y, block)


def apply_transposed(matrix: Any, block: FloatArray) -> FloatArray:
    """Transposed matrix times every column; rows are this rank's."""
    y, x = matrix.createVecs()
    return _by_column(matrix.multTranspose, x, y, block)


def _by_column(
    multiply: Callable[[Any, Any], None], x: Any, y: Any, block: FloatArray
) -> FloatArray:
    """Multiply every column of a block with work vectors x and y, which are destroyed."""
    out = np.empty((y.getLocalSize(), block.shape[1]))
    for k in range(block.shape[1]):
        x.array[:] = block[:, k]
        multiply(x, y)
        out[:, k] = y.array_r
    x.destroy()
    y.destroy()
    return out


def inner(left: FloatArray, right: FloatArray, comm: Any) -> FloatArray:
    """leftᵀ right, summed over the ranks; the same array on every rank."""
    return np.asarray(comm.allreduce(left.T @ right))


def project(matrix: Any, block: FloatArray, comm: Any) -> FloatArray:
    """blockᵀ A block."""
    return inner(block, apply(matrix, block), comm)


def symmetric(square: FloatArray) -> FloatArray:
    """Symmetric part (removes round-off)."""
    return np.asarray(0.5 * (square + square.T))


def skew(square: FloatArray) -> FloatArray:
    """Skew part (removes round-off)."""
    return np.asarray(0.5 * (square - square.T))
