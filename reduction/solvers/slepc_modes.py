"""Fixed-interface modes by SLEPc's shift-and-invert Krylov-Schur, with a factor given."""

from __future__ import annotations

from typing import Any

import numpy as np
from petsc4py import PETSc
from slepc4py import SLEPc

from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.solvers.constrained import ConstrainedFactor, bordered
from solidwhirl.rotordyn.core.arrays import FloatArray


class _Solution:
    """PETSc's preconditioner of type "python": the solve of a factor that is owned elsewhere."""

    def __init__(self, solver: Any) -> None:
        self.solver = solver

    def apply(self, _pc: Any, right: Any, out: Any) -> None:
        """Solve with the factor."""
        self.solver.solve(right, out)


def slepc_pairs(
    factor: ConstrainedFactor,
    mass: Any,
    *,
    shift: float,
    count: int,
    tolerance: float = 1e-12,
    deflate: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Eigenpairs of A u = λ M u nearest to a shift under B u = 0.

    As `constrained.eigenpairs`, vector by vector: as good a choice where unknowns are real and
    modes single, as on a meridian and on half a sector. SLEPc is given ``A - shift M``, already
    factorised, as its matrix and zero as its shift, so that nothing is factorised twice; what it
    clears at its end is a solver around the factor.

    Returns eigenvalues (m,), vectors (local N, m): rising, m >= count unless the space has fewer;
    M-orthonormal to round-off. Raises ReductionError if fewer pairs than asked converged.
    """
    local = mass.getLocalSize()[0]
    operator = factor.matrix
    weight = bordered(mass, np.zeros((local, factor.border)))
    outside = 0 if deflate is None else deflate.shape[1]
    free = operator.getSize()[0] - 2 * factor.border - outside
    count = min(count, free)
    eps = SLEPc.EPS().create(operator.comm)
    eps.setOperators(operator, weight)
    eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    eps.setType(SLEPc.EPS.Type.KRYLOVSCHUR)
    eps.setTarget(0.0)
    eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    eps.setTolerances(tol=tolerance, max_it=500)
    # purification clears the border's part of the vectors, which is not used
    eps.setPurify(False)
    eps.setDimensions(nev=count, ncv=min(max(2 * count, count + 16), free))
    _use(eps, factor)
    if deflate is not None and outside:
        eps.setDeflationSpace(_as_vectors(operator, deflate))
    eps.solve()
    found = eps.getConverged()
    if found < count:
        raise ReductionError(f"{found} of {count} fixed-interface modes converged")
    x = operator.createVecRight()
    values, vectors = np.empty(found), np.empty((local, found))
    for k in range(found):
        values[k] = eps.getEigenpair(k, x).real + shift
        vectors[:, k] = x.array_r[:local]
    eps.destroy()
    weight.destroy()
    order = np.argsort(values)
    return values[order], vectors[:, order]


def _use(eps: Any, factor: ConstrainedFactor) -> None:
    """Have the spectral transformation solve with the factor."""
    solver = PETSc.KSP().create(factor.matrix.comm)
    solver.setType(PETSc.KSP.Type.PREONLY)
    pc = solver.getPC()
    pc.setType(PETSc.PC.Type.PYTHON)
    pc.setPythonContext(_Solution(factor.solver))
    st = eps.getST()
    st.setType(SLEPc.ST.Type.SINVERT)
    st.setShift(0.0)
    st.setKSP(solver)


def _as_vectors(matrix: Any, block: FloatArray) -> list[Any]:
    """Vectors of the bordered layout, zero on the border."""
    out = []
    for k in range(block.shape[1]):
        v = matrix.createVecRight()
        v.set(0.0)
        v.array[: len(block)] = block[:, k]
        out.append(v)
    return out
