"""Linear systems and eigenproblems under linear constraints B u = q.

The constraint rows border the matrix, ``[[A, Bᵀ], [B, 0]]``; MUMPS factorises the symmetric
indefinite result once, and all solutions and modes use that factor.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc

from solidwhirl.core.reduction_work import BODIES
from solidwhirl.reduction.errors import FactorMemoryError, ReductionError
from solidwhirl.reduction.solvers.block_krylov import krylov_pairs
from solidwhirl.reduction.solvers.memory import available_memory_bytes
from solidwhirl.reduction.solvers.vectors import apply, dense_matrix, paired, unpaired
from solidwhirl.rotordyn.core.arrays import FloatArray, Matrix

#: Right-hand sides that MUMPS takes through the factor together (ICNTL(27)).
SOLUTION_BLOCK = 32
_MEGABYTE = 1_000_000
#: Memory of a factor of 1e5 unknowns of a solid [bytes] (bench/multigrid.py), and its power.
FACTOR_BYTES, FACTOR_POWER = 5.5e8, 4.0 / 3.0
_UNKNOWNS = 1e5
# Memory a factor may take at first: of the smallest [bytes], and of what is expected; others than
# solids are below.
_FIRST_BYTES, _OF_EXPECTED = 500_000_000, 3.0
# What MUMPS says where memory is short, INFOG(1).
_OF_MEMORY = (-9, -13, -19)


def bordered(matrix: Any, rows: FloatArray) -> Any:
    """Border a distributed symmetric matrix with dense rows and their transposes.

    `matrix`: (N, N) PETSc AIJ; `rows`: (local N, b) this rank's part of Bᵀ. Returns a PETSc SBAIJ
    matrix (N + b, N + b), of which the upper half is stored; the b new unknowns are the last of the
    last rank.
    """
    comm = matrix.comm.tompi4py()
    last = comm.rank == comm.size - 1
    size, b = matrix.getSize()[0], rows.shape[1]
    local = matrix.getLocalSize()[0]
    indptr, indices, data = _upper_half(matrix)
    i, j = np.nonzero(rows)  # row by row; the border's columns are the largest of their rows
    place = indptr[i + 1]
    indices = np.insert(indices, place, size + j)
    data = np.insert(data, place, rows[i, j])
    indptr = indptr + np.concatenate([[0], np.cumsum(np.bincount(i, minlength=local))])
    if last:
        # the diagonal is stored, though zero: MUMPS wants it
        indices = np.concatenate([indices, size + np.arange(b)])
        data = np.concatenate([data, np.zeros(b)])
        indptr = np.concatenate([indptr, indptr[-1] + 1 + np.arange(b)])
        local += b
    out = PETSc.Mat().createSBAIJ(
        size=((local, size + b), (local, size + b)),
        bsize=1,
        csr=(indptr.astype(PETSc.IntType), indices.astype(PETSc.IntType), data),
        comm=comm,
    )
    out.assemble()
    return out


def real_rows(rows: Matrix) -> FloatArray:
    """Constraint rows as real ones, (local real unknowns, real rows): two for a complex one."""
    if not np.iscomplexobj(rows):
        return rows
    both = np.stack([rows, 1j * rows], axis=2)
    return paired(both.reshape(len(rows), 2 * rows.shape[1]))


def _upper_half(matrix: Any) -> tuple[NDArray[Any], NDArray[Any], FloatArray]:
    """Rows of this rank from the diagonal on (CSR)."""
    indptr, indices, data = matrix.getValuesCSR()
    own = np.arange(*matrix.getOwnershipRange(), dtype=indices.dtype)
    kept = indices >= np.repeat(own, np.diff(indptr))
    before = np.concatenate([[0], np.cumsum(kept, dtype=np.int64)])
    return before[indptr], indices[kept], data[kept]


@dataclass(frozen=True, kw_only=True, eq=False)
class ConstrainedFactor:
    """Factorised ``[[A, Bᵀ], [B, 0]]``."""

    #: The bordered PETSc matrix and its factorised KSP
    matrix: Any
    solver: Any
    border: int  #: b, the number of constraint rows, as real ones
    parts: int  #: Real unknowns of one unknown: 2 where unknowns are complex
    #: Negative eigenvalues of the bordered matrix; b of them belong to the border if A is positive
    #: definite under the constraint (Sylvester), every further one is an eigenvalue of A below zero
    negative_pivots: int
    memory_bytes: int  #: Memory of the factor, on all ranks

    @property
    def indefinite_count(self) -> int:
        """Negative eigenvalues of A on the space B u = 0."""
        return (self.negative_pivots - self.border) // self.parts

    def destroy(self) -> None:
        """Free the factor and its matrix."""
        self.solver.destroy()
        self.matrix.destroy()

    def __del__(self) -> None:
        """Free them with the last reference; several ranks let go together, see `factorise`."""
        if not PETSc.Sys.isFinalized() and self.matrix.handle and self.matrix.comm.size == 1:
            self.destroy()

    def solve(self, force: Matrix | None, values: Matrix | None) -> Matrix:
        """Solve A u + B λ = force, Bᴴ u = values.

        `force`: (local N, k) or None for zero. `values`: (b, k) or None for zero. Returns (local N
        + own border rows, k): u, then on the last rank the reactions λ.
        """
        comm = self.matrix.comm.tompi4py()
        given = force if force is not None else values
        assert given is not None
        last = comm.rank == comm.size - 1
        rows = self.matrix.getLocalSize()[0]
        own = rows - (self.border if last else 0)
        right = np.zeros((rows, given.shape[1]), order="F")
        if force is not None:
            right[:own] = paired(force)
        if values is not None and last:
            right[own:] = paired(values)
        found = self.solve_whole(right)
        return unpaired(found) if self.parts == 2 else found

    def solve_whole(self, right: FloatArray) -> FloatArray:
        """Solve the bordered system for every column of a block (local N + own border rows, k).

        All columns go through the factor together, several times faster than one by one.
        """
        if not right.shape[1]:
            return np.empty(right.shape)
        comm, height = self.matrix.comm, self.matrix.getSize()[0]
        b = dense_matrix(right, height, comm)
        x = dense_matrix(np.zeros(right.shape, order="F"), height, comm)
        result = self.solver.getPC().getFactorMatrix()
        result.matSolve(b, x)
        result.destroy()  # this reference to it
        out = np.array(x.getDenseArray(), order="F")
        b.destroy()
        x.destroy()
        return out


def predicted_factor_bytes(unknowns: int) -> float:
    """Memory of MUMPS for a solid on all ranks, from measurements of other solids."""
    return float(FACTOR_BYTES * (unknowns / _UNKNOWNS) ** FACTOR_POWER)


def factorise(matrix: Any, rows: Matrix) -> ConstrainedFactor:
    """Factorise a symmetric matrix bordered with constraint rows.

    `matrix`: (N, N) PETSc matrix. `rows`: (local N, b) this rank's part of B (b may be 0); complex
    ones say that the matrix is that of complex unknowns, see `vectors`. Raises
    FactorMemoryError: the factor needs more memory than the machine has available, which is known
    before any of it is computed. Raises ReductionError: the factorisation failed.
    """
    border = real_rows(rows)
    whole = bordered(matrix, border)
    # of several ranks: what none of them refers to any more ends here
    PETSc.garbage_cleanup(whole.comm)
    available = available_memory_bytes(whole.comm.tompi4py())
    BODIES.add("factorisations")
    limits = _limits(whole.getSize()[0], available)
    for limit in limits:
        solver = PETSc.KSP().create(whole.comm)
        solver.setOperators(whole)
        _mumps(solver, limit)
        solver.setUp()
        result = solver.getPC().getFactorMatrix()
        if int(result.getMumpsInfog(1)) not in _OF_MEMORY or limit is limits[-1]:
            break
        for part in (result, solver):
            part.destroy()
    try:
        _refuse_failure(result, whole.getSize()[0], available)
    except ReductionError:
        for part in (result, solver, whole):
            part.destroy()
        raise
    # INFOG(12); getInertia would want null pivot detection, which costs a quarter of the time
    negative = int(result.getMumpsInfog(12))
    memory = _MEGABYTE * int(result.getMumpsInfog(22))
    result.destroy()  # this reference to it
    return ConstrainedFactor(
        matrix=whole,
        solver=solver,
        border=border.shape[1],
        parts=2 if np.iscomplexobj(rows) else 1,
        negative_pivots=negative,
        memory_bytes=memory,
    )


def _limits(unknowns: int, available: int | None) -> list[int | None]:
    """Memory that MUMPS may take [bytes]: first what is expected, then all there is.

    It takes the address space at once, of which only what is needed becomes memory; but a process
    of more than the machine's memory can't be forked.
    """
    if available is None:
        return [None]
    first = _FIRST_BYTES + int(_OF_EXPECTED * predicted_factor_bytes(unknowns))
    return [first, available] if first < available else [available]


def _mumps(context: Any, limit: int | None) -> None:
    """Direct solution by MUMPS, symmetric, in at most `limit` bytes."""
    context.setType(PETSc.KSP.Type.PREONLY)
    pc = context.getPC()
    pc.setType(PETSc.PC.Type.CHOLESKY)
    pc.setFactorSolverType("mumps")
    pc.setFactorSetUpSolverType()
    factor = pc.getFactorMatrix()
    factor.setMumpsIcntl(13, 1)  # root on one process: the inertia is then counted whole
    factor.setMumpsIcntl(14, 40)  # work space for delayed pivots of the border
    factor.setMumpsIcntl(27, SOLUTION_BLOCK)
    if limit is not None:
        factor.setMumpsIcntl(23, max(1, limit // _MEGABYTE))
    factor.destroy()  # this reference to it


def _refuse_failure(factor: Any, size: int, available: int | None) -> None:
    """Turn what MUMPS says into an error; PETSc would go on without a factor."""
    state = int(factor.getMumpsInfog(1))
    if state >= 0:
        return
    needed = int(factor.getMumpsInfog(16)) / 1e3
    if state in _OF_MEMORY and available is not None:
        raise FactorMemoryError(
            f"the factor of {size} unknowns needs {needed:.3g} GB of memory in one process and "
            f"{available / 1e9:.3g} GB are available; take a coarser mesh, the harmonic level, "
            "more processes on other machines, or, for the mesh of a whole, the iterative solver"
        )
    raise ReductionError(f"the factorisation of {size} unknowns failed: MUMPS INFOG(1) = {state}")


def eigenpairs(
    factor: ConstrainedFactor,
    mass: Any,
    *,
    shift: float,
    count: int,
    tolerance: float = 1e-11,
    deflate: Matrix | None = None,
) -> tuple[FloatArray, Matrix]:
    """Eigenpairs of A u = λ M u nearest to a shift under B u = 0, with the factor at hand.

    Parameters
    ----------
    factor
        Factor of the bordered ``A - shift M``; stays as it is and can go on solving.
    shift
        The shift that the factor was made for.
    tolerance
        Relative residual of the inverse problem, in the norm of M.
    deflate
        (local, k) M-orthonormal vectors to keep out (rigid-body modes).

    Returns
    -------
    eigenvalues (m,), vectors (local N, m)
        With m >= count unless the space has fewer; M-orthonormal to round-off.

    Raises
    ------
    ReductionError
        If fewer pairs than asked converged.
    """
    local, size = (n // factor.parts for n in (mass.getLocalSize()[0], mass.getSize()[0]))
    kind = complex if factor.parts == 2 else float
    outside = np.empty((local, 0), dtype=kind) if deflate is None else deflate
    count = min(count, size - factor.border // factor.parts - outside.shape[1])
    theta, vectors, _ = krylov_pairs(
        lambda block: factor.solve(apply(mass, block), None)[:local],
        mass,
        first=lambda theta: np.argsort(-np.abs(theta)),
        count=count,
        tolerance=tolerance,
        outside=outside,
    )
    if len(theta) < count:
        raise ReductionError(f"{len(theta)} of {count} fixed-interface modes converged")
    values = shift + 1.0 / theta
    order = np.argsort(values)
    return values[order], vectors[:, order]
