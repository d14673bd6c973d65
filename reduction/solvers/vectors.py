"""Blocks of distributed vectors: (local rows, columns) arrays and PETSc matrices acting on them.

PETSc's numbers are real. A block may be complex: its matrices are then Hermitian and hold, for
every complex unknown, the real and the imaginary part next to each other, so that a product is the
complex one (`paired`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from petsc4py import PETSc

from solidwhirl.rotordyn.core.arrays import FloatArray, Matrix


def paired(block: Matrix) -> FloatArray:
    """Real and imaginary parts in turn, (2 rows, k); a real block as it is."""
    if not np.iscomplexobj(block):
        return block
    return np.asarray(np.ascontiguousarray(block.T).view(float).T)


def unpaired(block: FloatArray) -> Matrix:
    """Complex block of pairs of rows."""
    return np.asarray(np.ascontiguousarray(block.T).view(complex).T)


def as_complex(real: FloatArray, imaginary: FloatArray) -> Matrix:
    """Complex block of two real ones, stored by columns."""
    out = np.empty(real.shape, dtype=complex, order="F")
    out.real, out.imag = real, imaginary
    return out


@runtime_checkable
class Operator(Protocol):
    """A matrix that is known by what it makes of a block."""

    def times(self, block: Matrix) -> Matrix:
        """Matrix times every column."""

    def folded(self) -> Any:
        """As a PETSc matrix."""

    def destroy(self) -> None:
        """Free what it holds."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Combination:
    """Sum of matrices times factors; the matrices stay those of others."""

    terms: tuple[tuple[float, Any], ...]

    def times(self, block: Matrix) -> Matrix:
        """Sum times every column."""
        return np.asarray(sum(factor * apply(matrix, block) for factor, matrix in self.terms))

    def folded(self) -> Any:
        """As a PETSc matrix."""
        wholes = [
            (factor, matrix.folded() if isinstance(matrix, Operator) else matrix.copy())
            for factor, matrix in self.terms
        ]
        first, out = wholes[0]
        out.scale(first)
        for factor, whole in wholes[1:]:
            out.axpy(factor, whole, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
            whole.destroy()
        return out

    def destroy(self) -> None:
        """Nothing is its own."""


def apply(matrix: Any, block: Matrix) -> Matrix:
    """Matrix times every column; rows are this rank's.

    `block`: (local columns of the matrix, k), or half of them and complex.
    """
    if isinstance(matrix, Operator):
        return matrix.times(block)
    if np.iscomplexobj(block):
        return unpaired(apply(matrix, paired(block)))
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
    # one after the other takes half the time of PtAP
    product = matrix.matMult(transformation)
    whole = transformation.transposeMatMult(product)
    # a product holds on to its factors and to its work space as long as it lives
    out = whole.copy()
    for made in (whole, product):
        made.destroy()
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


def inner(left: Matrix, right: Matrix, comm: Any) -> Matrix:
    """leftᴴ right, summed over the ranks; the same array on every rank."""
    return np.asarray(comm.allreduce(left.conj().T @ right))


def squares(left: Matrix, right: Matrix, comm: Any) -> FloatArray:
    """Real diagonal of leftᴴ right."""
    return np.asarray(comm.allreduce(np.einsum("ij,ij->j", left.conj(), right).real))


def energies(matrix: Any, block: Matrix, comm: Any) -> FloatArray:
    """Real diagonal of blockᴴ A block."""
    return squares(block, apply(matrix, block), comm)


def project(matrix: Any, block: Matrix, comm: Any) -> Matrix:
    """blockᴴ A block."""
    return inner(block, apply(matrix, block), comm)


def diagonal(matrix: Any, like: Matrix) -> FloatArray:
    """Diagonal of a matrix in the rows of a block that it acts on."""
    found = matrix.getDiagonal()
    values = found.array_r[:: 2 if np.iscomplexobj(like) else 1].copy()
    found.destroy()
    return np.asarray(values)


def uncancelled(matrix: Any, block: Matrix, comm: Any) -> FloatArray:
    """Real diagonal of blockᴴ diag(A) block: energies without what cancels in rigid motions."""
    return squares(block, diagonal(matrix, block)[:, None] * block, comm)


def symmetric(square: Matrix) -> Matrix:
    """Hermitian (symmetric) part (removes round-off)."""
    return np.asarray(0.5 * (square + square.conj().T))


def skew(square: FloatArray) -> FloatArray:
    """Skew part (removes round-off)."""
    return np.asarray(0.5 * (square - square.T))
