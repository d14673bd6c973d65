"""Solutions and modes under linear constraints without a factorisation.

On the fields with B u = 0 (and M-orthogonal to rigid motions that the interfaces leave free) the
stiffness is positive definite. Conjugate gradients stay there if the preconditioner does: with a
V-cycle P⁻¹ and C = [Bᵀ, M F], z = P⁻¹ r - P⁻¹ C (Cᵀ P⁻¹ C)⁻¹ Cᵀ P⁻¹ r (constraint preconditioner:
Gould, Hribar and Nocedal, SIAM J. Sci. Comput. 23 (2001) 1376-1395). P⁻¹ C is made once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import scipy.linalg

from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.solvers.vectors import apply, inner, squares, symmetric
from solidwhirl.rotordyn.core.arrays import FloatArray, Matrix

#: Columns that are solved for together.
BLOCK = 32
#: Error of a solution in the energy norm, over that of the start.
SOLUTION = 1e-11
# An error that rounding leaves may be larger; beyond this a solution has failed.
_FAILED = 1e-6
_ITERATIONS = 1000
# Iterations without a better residual after which rounding is all that is left.
_PATIENCE = 25


class Preconditioner(Protocol):
    """A Hermitian positive approximation P⁻¹ of the inverse of a stiffness."""

    @property
    def comm(self) -> Any:
        """mpi4py communicator."""

    @property
    def memory_bytes(self) -> int:
        """Memory on all ranks."""

    def cycle(self, load: Matrix) -> Matrix:
        """Approximate solution for a block of loads (local, k)."""

    def destroy(self) -> None:
        """Free what it holds."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ConstrainedIteration:
    """Solves A u + Bᵀ λ = force, B u = values by conjugate gradients.

    The counterpart of `ConstrainedFactor`, with the same `solve`.
    """

    matrix: Any  #: A, PETSc, positive definite on the constrained fields
    hierarchy: Preconditioner
    normals: Matrix  #: (local, c) C = [Bᵀ, M F] times `scale`
    answers: Matrix  #: (local, c) P⁻¹ C
    gram: tuple[Matrix, bool]  #: Cholesky factor of Cᵀ P⁻¹ C
    scale: FloatArray  #: (c,)
    border: int  #: b, the number of constraint rows
    free: Matrix  #: (local, f) rigid motions F that the rows leave free, M-orthonormal
    owns_matrix: bool  #: Whether A is nobody else's
    shift: float  #: σ of A = K - σ M; the stiffness of the free motions is -σ

    @property
    def comm(self) -> Any:
        """mpi4py communicator."""
        return self.hierarchy.comm

    @property
    def memory_bytes(self) -> int:
        """Memory of the hierarchy, on all ranks."""
        return self.hierarchy.memory_bytes

    def destroy(self) -> None:
        """Free the hierarchy, and the matrix if it is no other's."""
        if self.owns_matrix:
            self.matrix.destroy()
        self.hierarchy.destroy()

    def cleaned(self, block: Matrix) -> Matrix:
        """Fields with what breaks the constraints taken out."""
        return np.asarray(block - self._back(inner(self.normals, block, self.comm)))

    def preconditioned(self, residual: Matrix) -> Matrix:
        """Approximate solution under the constraints for a block of residuals."""
        return self.cleaned(self.hierarchy.cycle(self.without_reactions(residual)))

    def without_reactions(self, residual: Matrix) -> Matrix:
        """Residuals without the forces that the constraints take up, whose rounding would stay."""
        forces = self._forces(inner(self.answers, residual, self.comm))
        return np.asarray(residual - self.normals @ forces)

    def solve(
        self, force: Matrix | None, values: Matrix | None, tolerance: float = SOLUTION
    ) -> Matrix:
        """Solve A u + Bᵀ λ = force, B u = values.

        `force`: (local N, k) or None for zero. `values`: (b, k) or None for zero. `tolerance`:
        error of the solution in the energy norm, over that of the start. Returns (local N, k): u.
        Raises ReductionError: the iteration comes to no end.
        """
        given = force if force is not None else values
        assert given is not None
        out = np.empty((len(self.normals), given.shape[1]), dtype=given.dtype, order="F")
        for start in range(0, given.shape[1], BLOCK):
            span = slice(start, start + BLOCK)
            out[:, span] = self._solve_block(
                None if force is None else force[:, span],
                None if values is None else values[:, span],
                tolerance,
            )
        return out

    def _solve_block(self, force: Matrix | None, values: Matrix | None, tolerance: float) -> Matrix:
        given = force if force is not None else values
        assert given is not None
        out: Matrix = np.zeros((len(self.normals), given.shape[1]), dtype=given.dtype)
        load = np.zeros_like(out) if force is None else force
        if values is not None:
            wanted = np.zeros((len(self.scale), out.shape[1]), dtype=out.dtype)
            wanted[: self.border] = values * self.scale[: self.border, None]
            out = self._back(wanted)
            load = load - apply(self.matrix, out)
        out = out + self._gradients(load, tolerance)
        if force is not None and self.free.shape[1]:
            out = out + self.free @ (inner(self.free, force, self.comm) / -self.shift)
        return out

    def _gradients(self, load: Matrix, tolerance: float) -> Matrix:
        """Constrained solution for zero values, by conjugate gradients column by column."""
        out = np.zeros_like(load)
        left = self.without_reactions(load)
        z = self.preconditioned(left)
        rho = self._dots(left, z)
        begun, target = np.maximum(rho, np.finfo(float).tiny), tolerance**2 * rho
        best, since = rho.copy(), 0
        open_ = np.flatnonzero(rho > 0.0)
        step = z[:, open_]
        for _ in range(_ITERATIONS):
            if not len(open_):
                break
            product = apply(self.matrix, step)
            length = rho[open_] / self._dots(step, product)
            out[:, open_] += step * length
            left[:, open_] = self.without_reactions(left[:, open_] - product * length)
            z = self.cleaned(self.hierarchy.cycle(left[:, open_]))
            new = self._dots(left[:, open_], z)
            since = 0 if (new < 0.9 * best[open_]).any() else since + 1
            best[open_] = np.minimum(best[open_], new)
            turn = new / rho[open_]
            rho[open_] = new
            going = new > target[open_]
            if since > _PATIENCE:
                break
            step = (z + step * turn)[:, going]
            open_ = open_[going]
        worst = float(np.sqrt((best / begun).max(initial=0.0)))
        if worst > max(_FAILED, tolerance):
            raise ReductionError(
                f"the iterative solution does not converge: its error fell to {worst:.1e} of the "
                "start; take the direct solver, or elements of better shape"
            )
        return out

    def relaxed(self, load: Matrix, steps: int) -> Matrix:
        """Constrained displacement of so many steps of conjugate gradients from zero, (local, k).

        Its energy is below that of the solution.
        """
        out = np.zeros_like(load)
        left = self.without_reactions(load)
        step = z = self.preconditioned(left)
        rho = self._dots(left, z)
        for _ in range(steps):
            product = apply(self.matrix, step)
            length = _over(rho, self._dots(step, product))
            out += step * length
            left = self.without_reactions(left - product * length)
            z = self.cleaned(self.hierarchy.cycle(left))
            new = self._dots(left, z)
            step = z + step * _over(new, rho)
            rho = new
        return out

    def _forces(self, values: Matrix) -> Matrix:
        """Forces of the constraints for values of their rows; none where there are no rows."""
        return scipy.linalg.cho_solve(self.gram, values) if len(values) else values

    def _back(self, values: Matrix) -> Matrix:
        """P⁻¹ C (Cᵀ P⁻¹ C)⁻¹ times values."""
        return np.asarray(self.answers @ self._forces(values))

    def _dots(self, left: Matrix, right: Matrix) -> FloatArray:
        return squares(left, right, self.comm)


def _over(above: FloatArray, below: FloatArray) -> FloatArray:
    """Quotients; zero where there is nothing to divide by."""
    return np.divide(above, below, out=np.zeros_like(above), where=below > 0.0)


def constrained_iteration(
    grids: Preconditioner,
    matrix: Any,
    rows: Matrix,
    *,
    free: Matrix,
    momentum: Matrix,
    owns_matrix: bool = True,
    shift: float = 0.0,
) -> ConstrainedIteration:
    """Prepare solutions with a symmetric matrix under constraint rows.

    `grids`: made of K. `matrix`: A = K - σ M, or K itself, which is not freed with the rest.
    `rows`: (local, b) this rank's part of Bᵀ. `free`, `momentum`: (local, f) rigid motions that the
    rows leave free, M-orthonormal, and M times them; fields stay orthogonal to the second, and get
    what loads make of the first if there are any. Raises ReductionError: rows that depend on each
    other.
    """
    normals = np.hstack([rows, momentum])
    if normals.shape[1]:
        answers = grids.cycle(normals)
        gram = inner(normals, answers, grids.comm)
        scale = 1.0 / np.sqrt(np.diag(gram).real)
        gram = gram * np.outer(scale, scale)
    else:
        answers, gram, scale = normals, np.empty((0, 0)), np.empty(0)
    try:
        factor = scipy.linalg.cho_factor(symmetric(gram), lower=True)
    except np.linalg.LinAlgError as error:
        raise ReductionError("interfaces move as others make them; leave one out") from error
    return ConstrainedIteration(
        matrix=matrix,
        hierarchy=grids,
        normals=normals * scale,
        answers=answers * scale,
        gram=factor,
        scale=scale,
        border=rows.shape[1],
        free=free,
        owns_matrix=owns_matrix,
        shift=shift,
    )
