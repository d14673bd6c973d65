"""Linear systems and eigenproblems under linear constraints B u = q.

The constraint rows border the matrix, ``[[A, Bᵀ], [B, 0]]``; MUMPS factorises the symmetric
indefinite result once, and SLEPc's shift-and-invert uses that factor.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc
from slepc4py import SLEPc

from solidwhirl.reduction.errors import ReductionError

FloatArray = NDArray[np.float64]


def bordered(matrix: Any, rows: FloatArray) -> Any:
    """Border a distributed matrix with dense rows and their transposes.

    Parameters
    ----------
    matrix
        (N, N) PETSc AIJ matrix.
    rows
        (local N, b) this rank's part of Bᵀ.

    Returns
    -------
    (N + b, N + b) PETSc AIJ matrix; the b new unknowns are the last of the last rank.
    """
    comm = matrix.comm.tompi4py()
    last = comm.rank == comm.size - 1
    size, b = matrix.getSize()[0], rows.shape[1]
    local = matrix.getLocalSize()[0]
    indptr, indices, data = _with_border_columns(matrix, rows, size)
    counts = comm.gather(rows, root=comm.size - 1)
    if last:
        dense = np.vstack(counts)
        for j in range(b):
            columns = np.flatnonzero(dense[:, j])
            indices = np.concatenate([indices, columns, [size + j]])
            data = np.concatenate([data, dense[columns, j], [0.0]])
            indptr = np.append(indptr, indptr[-1] + len(columns) + 1)
        local += b
    out = PETSc.Mat().createAIJ(
        size=((local, size + b), (local, size + b)),
        csr=(indptr.astype(PETSc.IntType), indices.astype(PETSc.IntType), data),
        comm=comm,
    )
    out.assemble()
    out.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    return out


def _with_border_columns(
    matrix: Any, rows: FloatArray, size: int
) -> tuple[NDArray[Any], NDArray[Any], FloatArray]:
    """CSR of this rank's rows, without stored zeros, with the border's columns appended."""
    indptr, indices, data = matrix.getValuesCSR()
    start = matrix.getOwnershipRange()[0]
    counts = np.diff(indptr)
    # the diagonal stays, even if zero: MUMPS and shifts want it
    keep = (data != 0.0) | (indices == np.repeat(np.arange(start, start + len(counts)), counts))
    kept = np.concatenate([[0], np.cumsum(keep)])[indptr]
    indices, data = indices[keep].astype(np.int64), data[keep]
    i, j = np.nonzero(rows)  # row by row; the border's columns are the largest of their rows
    indices = np.insert(indices, kept[i + 1], size + j)
    data = np.insert(data, kept[i + 1], rows[i, j])
    added = np.concatenate([[0], np.cumsum(np.bincount(i, minlength=len(counts)))])
    return kept + added, indices, data


@dataclass(frozen=True, kw_only=True, eq=False)
class ConstrainedFactor:
    """Factorised ``[[A, Bᵀ], [B, 0]]``.

    Attributes
    ----------
    matrix, solver
        The bordered PETSc matrix and its factorised KSP.
    border
        b, the number of constraint rows.
    negative_pivots
        Negative eigenvalues of the bordered matrix; b of them belong to the border if A is
        positive definite under the constraint (Sylvester), every further one is an eigenvalue
        of A below zero.
    """

    matrix: Any
    solver: Any
    border: int
    negative_pivots: int

    @property
    def indefinite_count(self) -> int:
        """Negative eigenvalues of A on the space B u = 0."""
        return self.negative_pivots - self.border

    def solve(self, force: FloatArray | None, values: FloatArray | None) -> FloatArray:
        """Solve A u + Bᵀ λ = force, B u = values.

        Parameters
        ----------
        force
            (local N, k) or None for zero.
        values
            (b, k) or None for zero.

        Returns
        -------
        (local N + own border rows, k): u, then on the last rank the reactions λ.
        """
        comm = self.matrix.comm.tompi4py()
        given = force if force is not None else values
        assert given is not None
        x, y = self.matrix.createVecs()
        own = y.getLocalSize() - (self.border if comm.rank == comm.size - 1 else 0)
        out = np.empty((y.getLocalSize(), given.shape[1]))
        for k in range(given.shape[1]):
            y.set(0.0)
            if force is not None:
                y.array[:own] = force[:, k]
            if values is not None and comm.rank == comm.size - 1:
                y.array[own:] = values[:, k]
            self.solver.solve(y, x)
            out[:, k] = x.array_r
        return out


def _mumps(context: Any) -> None:
    """Direct solution by MUMPS, symmetric."""
    context.setType(PETSc.KSP.Type.PREONLY)
    pc = context.getPC()
    pc.setType(PETSc.PC.Type.CHOLESKY)
    pc.setFactorSolverType("mumps")
    pc.setFactorSetUpSolverType()
    factor = pc.getFactorMatrix()
    factor.setMumpsIcntl(13, 1)  # root on one process: the inertia is then counted whole
    factor.setMumpsIcntl(14, 40)  # work space for delayed pivots of the border


def factorise(matrix: Any, rows: FloatArray) -> ConstrainedFactor:
    """Factorise a symmetric matrix bordered with constraint rows.

    Parameters
    ----------
    matrix
        (N, N) PETSc matrix.
    rows
        (local N, b) this rank's part of Bᵀ (b may be 0).
    """
    whole = bordered(matrix, rows)
    solver = PETSc.KSP().create(whole.comm)
    solver.setOperators(whole)
    _mumps(solver)
    solver.setUp()
    # INFOG(12); getInertia would want null pivot detection, which costs a quarter of the time
    negative = int(solver.getPC().getFactorMatrix().getMumpsInfog(12))
    return ConstrainedFactor(
        matrix=whole, solver=solver, border=rows.shape[1], negative_pivots=negative
    )


def eigenpairs(
    factor: ConstrainedFactor,
    mass: Any,
    *,
    shift: float,
    count: int,
    tolerance: float = 1e-12,
    deflate: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Eigenpairs of A u = λ M u nearest to a shift under B u = 0, with the factor at hand.

    SLEPc's shift-and-invert is given ``A - shift M``, already factorised, as its matrix and zero
    as its shift, so that nothing is factorised twice.

    Parameters
    ----------
    factor
        Factor of the bordered ``A - shift M``.
    mass
        Bordered M (zero border).
    shift
        The shift that the factor was made for.
    count
        Eigenpairs wanted.
    deflate
        (local, k) vectors to keep out (rigid-body modes), bordered layout.

    The factor is used up: SLEPc clears it when it is done. Solve what else it is needed for
    before.

    Returns
    -------
    eigenvalues (m,), vectors (local N + own border rows, m)
        With m >= count unless the space has fewer; M-orthonormal to round-off.

    Raises
    ------
    ReductionError
        If fewer pairs than asked converged.
    """
    operator = factor.matrix
    free = operator.getSize()[0] - 2 * factor.border
    count = min(count, free)
    eps = SLEPc.EPS().create(operator.comm)
    eps.setOperators(operator, mass)
    eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    eps.setType(SLEPc.EPS.Type.KRYLOVSCHUR)
    eps.setTarget(0.0)
    eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    eps.setTolerances(tol=tolerance, max_it=500)
    # purification clears the border's part of the vectors, which is not used
    eps.setPurify(False)
    eps.setDimensions(nev=count, ncv=min(max(2 * count, count + 16), free))
    st = eps.getST()
    st.setType(SLEPc.ST.Type.SINVERT)
    st.setShift(0.0)
    st.setKSP(factor.solver)
    if deflate is not None and deflate.shape[1]:
        eps.setDeflationSpace(_as_vectors(operator, deflate))
    eps.solve()
    found = eps.getConverged()
    if found < count:
        raise ReductionError(f"{found} of {count} fixed-interface modes converged")
    x = operator.createVecRight()
    values, vectors = np.empty(found), np.empty((x.getLocalSize(), found))
    for k in range(found):
        values[k] = eps.getEigenpair(k, x).real + shift
        vectors[:, k] = x.array_r
    eps.destroy()
    order = np.argsort(values)
    return values[order], vectors[:, order]


def _as_vectors(matrix: Any, block: FloatArray) -> list[Any]:
    out = []
    for k in range(block.shape[1]):
        v = matrix.createVecRight()
        v.array[:] = block[:, k]
        out.append(v)
    return out
