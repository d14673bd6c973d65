"""Blocks of distributed vectors: (local rows, columns) arrays and PETSc matrices acting on them."""

from __future__ import annotations

from typing import Any

import numpy as np
from petsc4py import PETSc

from solidwhirl.rotordyn.core.arrays import FloatArray


def apply(matrix: Any, block: FloatArray) -> FloatArray:
    """Matrix times every column; rows are this rank's.

    `block`: (local columns of the matrix, k).
    """
    rows, width = matrix.getLocalSize()[0], matrix.getSize()[1]
    dense = dense_matrix(block, width, matrix.comm)
    product = matrix.matMult(dense)
    out = np.array(product.getDenseArray(), order="F")
    product.destroy()
    dense.destroy()
    return out.reshape(rows, block.shape[1], order="F")


def apply_transposed(matrix: Any, block: FloatArray) -> FloatArray:
    """Transposed matrix times every column; rows are this rank's."""
    y, x = matrix.createVecs()
    out = np.empty((y.getLocalSize(), block.shape[1]))
    for k in range(block.shape[1]):
        x.array[:] = block[:, k]
        matrix.multTranspose(x, y)
        out[:, k] = y.array_r
    x.destroy()
    y.destroy()
    return out


def folded(matrix: Any, transformation: Any) -> Any:
    """Tᵀ A T."""
    product = matrix.PtAP(transformation)
    # the product holds on to A and to its work space as long as it lives
    out = product.copy()
    product.destroy()
    return out


def dense_matrix(block: FloatArray, height: int, comm: Any) -> Any:
    """PETSc dense matrix of a block; shares the memory of a block that is stored by columns.

    `block`: (local rows, k).
    """
    rows, k = block.shape
    size = ((rows, height), (PETSc.DECIDE, k))
    out = PETSc.Mat().createDense(size, array=np.asfortranarray(block), comm=comm)
    out.assemble()
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
