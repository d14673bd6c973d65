"""Outer eigenpairs by a block Krylov space: lowest modes, softest direction.

Solving for a block of right-hand sides takes a fraction of the time of solving one by one, which is
what SLEPc's shift-and-invert would do. The space is kept whole (no restart) and M-orthonormal to
round-off (Grimes, Lewis and Simon, SIAM J. Matrix Anal. Appl. 15 (1994) 228-272).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from solidwhirl.reduction.solvers.vectors import apply, inner, symmetric
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray, Matrix

#: Columns that go through the factor together.
BLOCK = 4
# A direction left by orthogonalisation that is shorter than this is round-off.
_LOST = 1e-10
# The projection is diagonalised whenever the space has grown by one part in this many.
_SELDOM = 16
# Vectors kept beyond the wanted ones before a run counts as failed.
_PATIENCE = 12


def krylov_pairs(
    operator: Callable[[Matrix], Matrix],
    product: Any,
    *,
    first: Callable[[FloatArray], IntArray],
    count: int,
    tolerance: float,
    least: float = 0.0,
    outside: Matrix,
) -> tuple[FloatArray, Matrix, FloatArray]:
    """Outer eigenpairs S x = θ x of an operator S that is symmetric in the product of P.

    `operator`: applies S to a block (local, k). `product`: P, PETSc matrix, symmetric and positive
    definite on the vectors that S makes. `first`: order of given θ in which pairs are wanted
    (indices); an end of the spectrum. `tolerance`: largest |S x - θ x| / |θ| in the norm of P.
    `least`: |θ| below which differences do not matter. `outside`: (local, f) P-orthonormal vectors
    of an invariant space that is left out. Returned: θ (m,), vectors (local, m), residuals (m,) of
    all leading pairs that have converged: m >= count, unless the space has fewer or the iteration
    came to its end; P-orthonormal.
    """
    comm = product.comm.tompi4py()
    random = np.random.default_rng(comm.rank).standard_normal((len(outside), BLOCK))
    start, mass = operator(random.astype(outside.dtype)), product
    space = GrowingSpace(outside, mass, comm)
    image = np.zeros((0, 0), dtype=outside.dtype)
    new = space.extend(start, apply(mass, start))
    limit = _PATIENCE * (count + 2 * BLOCK)
    leading, theta, left, shapes = 0, np.empty(0), np.empty(0), np.empty((0, 0))
    due = count
    while new:
        answer = operator(space.columns(-new))
        weight = apply(mass, answer)
        ahead = space.take_out(answer, weight)[outside.shape[1] :]
        image = bordered_image(image, ahead)
        if len(image) >= due:
            rest = symmetric(inner(answer, weight, comm))  # of what is left of the answer
            theta, shapes, left = _projected_pairs(image, rest, first)
            good = left <= tolerance * np.maximum(np.abs(theta), least)
            leading = len(good) if good.all() else int(np.argmin(good))
            if leading >= count or len(theta) > limit:
                break
            # what this costs grows with the cube of the space; it need not follow every block
            due = len(image) + len(image) // _SELDOM
        new = space.extend(answer, None)
        if not new:  # the space is invariant: all pairs are exact
            theta, shapes, left = _projected_pairs(image, np.empty((0, 0)), first)
            leading = len(theta)
    vectors = space.columns(outside.shape[1]) @ shapes[:, :leading]
    return theta[:leading], vectors, left[:leading]


def _projected_pairs(
    image: Matrix, rest: Matrix, first: Callable[[FloatArray], IntArray]
) -> tuple[FloatArray, Matrix, FloatArray]:
    """Eigenpairs of the projection in the wanted order, and their residuals.

    `rest` holds the products of what the newest columns' images have beyond the space.
    """
    theta, shapes = np.linalg.eigh(image)
    order = first(theta)
    theta, shapes = theta[order], shapes[:, order]
    tail = shapes[len(shapes) - len(rest) :]
    left = np.sqrt(np.maximum(np.einsum("ik,ij,jk->k", tail.conj(), rest, tail).real, 0.0))
    return theta, shapes, left


def bordered_image(image: Matrix, ahead: Matrix) -> Matrix:
    """The projection of S, grown by the columns of the newest block."""
    old, new = len(image), ahead.shape[1]
    out = np.zeros((old + new, old + new), dtype=ahead.dtype)
    out[:old, :old] = image
    out[:, old:] = ahead
    out[old:, :] = ahead.conj().T
    out[old:, old:] = symmetric(ahead[old:])
    return out


class GrowingSpace:
    """M-orthonormal columns that grow in place."""

    def __init__(self, first: Matrix, mass: Any, comm: Any) -> None:
        self._mass, self._comm = mass, comm
        self._store = np.array(first, order="F")
        self._used = first.shape[1]

    def columns(self, start: int) -> Matrix:
        """Columns from `start` on; negative: as many of the last ones."""
        return self._store[:, start if start >= 0 else self._used + start : self._used]

    def take_out(self, block: Matrix, weight: Matrix) -> Matrix:
        """Take the part in the space out of a block, in place, given M times the block."""
        basis = self.columns(0)
        part = inner(basis, weight, self._comm)
        block -= basis @ part
        return part

    def extend(self, block: Matrix, weight: Matrix | None) -> int:
        """Add what a block has beyond the space; returns the number of new columns.

        `weight` is M times the block; without it the block is taken as free of the space up to
        round-off.
        """
        if weight is not None:
            self.take_out(block, weight)
        for _ in range(2):
            # the second pass takes out the round-off that the first one magnified
            weight = apply(self._mass, block)
            gram = inner(block, weight, self._comm)
            part = self.take_out(block, weight)
            gram = symmetric(gram - part.conj().T @ part)
            size = np.sqrt(np.maximum(np.diag(gram).real, np.finfo(float).tiny))
            s, q = np.linalg.eigh(gram / np.outer(size, size))
            keep = s > _LOST**2
            block = block @ ((q[:, keep] / np.sqrt(s[keep])) / size[:, None])
        self._append(block)
        return block.shape[1]

    def _append(self, block: Matrix) -> None:
        """Store new columns; the store doubles when it is full."""
        rows, wanted = len(block), self._used + block.shape[1]
        if wanted > self._store.shape[1]:
            count = max(2 * self._store.shape[1], wanted, 96)
            grown = np.empty((rows, count), order="F", dtype=self._store.dtype)
            grown[:, : self._used] = self.columns(0)
            self._store = grown
        self._store[:, self._used : wanted] = block
        self._used = wanted
