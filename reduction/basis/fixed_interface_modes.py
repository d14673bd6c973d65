"""Modes of a body with its interfaces held, at rest and at speed, by the solver that fits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from petsc4py import PETSc

from solidwhirl.core.reduction_work import BODIES
from solidwhirl.reduction.basis import merging
from solidwhirl.reduction.basis.overspeed import negative_count, refuse_instability, solver_of
from solidwhirl.reduction.basis.spinning_modes import MARGIN, Spinning, modes_at_speed
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators.matrices import BodyOperators
from solidwhirl.reduction.operators.solver_choice import Solver
from solidwhirl.reduction.solvers.constrained import ConstrainedFactor, eigenpairs, factorise
from solidwhirl.reduction.solvers.iterative_modes import iterative_pairs
from solidwhirl.reduction.solvers.multigrid import ConstrainedIteration
from solidwhirl.reduction.solvers.slepc_modes import slepc_pairs
from solidwhirl.reduction.solvers.vectors import Operator, energies, inner, squares
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, Matrix

# All matrices of a body come from one space; the stiffness has all entries that the mass has.
_SAME = PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN
_DIFFERENT = PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN
# Largest part of a mode that breaks the constraint; modes that are found break it by 1e-15.
_BROKEN = 1e-8
# Modes that are computed beyond those asked for, to know where a cluster ends, and one direction
# that the iteration needs.
_BEYOND = 3
# Modes at the end of the spectrum that an iteration may not find.
_UNREACHED = 2
# Growth of the number of modes that has to bring one of the wanted orders.
_FRUITLESS = 2.0
# Modes of a solid that are looked through for the first one of the wanted orders.
_SEARCHED = 100


@dataclass(frozen=True, kw_only=True, eq=False)
class HeldProblem:
    """A body with its interfaces held, and which of its modes are wanted."""

    operators: BodyOperators
    rows: Matrix  #: (local, b) constraint rows
    free: Matrix  #: (local, f) M-orthonormal rigid motions that the rows do not hold
    shift: float  #: 0, or a small negative number [1/s²] where there are such motions
    modes: int
    #: Circumferential orders of a solid's modes that are told apart; None: all are wanted
    orders: tuple[int, ...] | None

    @property
    def wanted(self) -> int:
        """Number of modes wanted, both of a pair."""
        return self.modes if self.orders is None else 2 * self.modes


@dataclass(frozen=True, kw_only=True, eq=False)
class HeldModes:
    """Fixed-interface modes of the wanted circumferential orders."""

    #: (m,) rising [1/s²], (local, m)
    eigenvalues: FloatArray
    vectors: Matrix
    asked: int
    beyond: float  #: The next eigenvalue, or the last one of the list
    #: Vectors and eigenvalues of all orders that were found
    every: Matrix
    known: FloatArray


def held_solver(problem: HeldProblem) -> Solver:
    """Solver of K - shift M at rest under the constraint rows."""
    operators = problem.operators
    if operators.held is not None:
        return operators.held.factor
    matrix = shifted_matrix(operators, operators.stiffness, problem.shift)
    found = solver_of(operators, matrix, problem.rows, problem.free, problem.shift)
    if isinstance(found, ConstrainedFactor) and matrix is not operators.stiffness:
        matrix.destroy()
    return found


def shifted_factor(
    operators: BodyOperators, stiffness: Any, rows: FloatArray, shift: float
) -> ConstrainedFactor:
    """Factor of the bordered K - shift M.

    `stiffness`: K, at rest or at speed. `rows`: (local, b) constraint rows.
    """
    matrix = shifted_matrix(operators, stiffness, shift)
    try:
        return factorise(matrix, rows)
    finally:
        if matrix is not stiffness:
            matrix.destroy()


def shifted_matrix(operators: BodyOperators, stiffness: Any, shift: float) -> Any:
    """K - shift M; K itself without a shift."""
    if shift == 0.0:
        return stiffness
    shifted = stiffness.copy()
    shifted.axpy(-shift, operators.mass, _SAME)
    return shifted


def interior_modes(
    problem: HeldProblem, factor: Solver, start: FloatArray | None = None
) -> HeldModes:
    """Find the modes that are wanted, pairs whole.

    `factor`: of K - shift M, at rest or at speed. `start`: (local, s) fields that an iteration
    begins with. Raises ReductionError: more modes than the mesh has, or none of the wanted orders
    among many.
    """
    operators, orders, wanted = problem.operators, problem.orders, problem.wanted
    parts = 2 if np.iscomplexobj(problem.rows) else 1
    unknowns = operators.mass.getSize()[0] // parts
    available = unknowns - problem.rows.shape[1] - problem.free.shape[1]
    if wanted + _BEYOND > available:
        families = 1 if orders is None else 2
        raise ReductionError(
            f"{problem.modes} fixed-interface modes are asked for, the body can have "
            f"{max(available - _BEYOND, 0) // families} on this mesh; choose fewer, or a finer mesh"
        )
    reachable = available - _UNREACHED
    count = min(wanted + 2 if orders is None else wanted + wanted // 2 + 4, reachable)
    found, since = 0, count
    while True:
        values, vectors = _pairs(problem, factor, count, start)
        start = vectors
        # a space that is used up ends in vectors that break the constraint
        real = _broken(problem, vectors) < _BROKEN
        values, vectors = values[real], vectors[:, real]
        every, known, highest = vectors, np.sort(values), float(values.max(initial=0.0))
        if orders is not None:
            values, vectors = merging.modes_of_orders(operators, values, vectors, orders)
        whole = merging.whole_clusters(values, wanted, highest)
        if whole > found:
            found, since = whole, count
        # a coarse mesh mixes the orders of its highest modes, more of which bring nothing; but a
        # thin shell has many modes of other orders before the first one that is wanted
        spent = count == reachable or (found > 0 and count > _FRUITLESS * since)
        if whole >= wanted or spent:
            return HeldModes(
                eigenvalues=values[:whole],
                vectors=vectors[:, :whole],
                asked=count,
                beyond=float(values[min(whole, len(values) - 1)]) if len(values) else 0.0,
                every=every,
                known=known,
            )
        if found == 0 and count > wanted + _SEARCHED:
            raise ReductionError(
                f"none of the {count} lowest fixed-interface modes has one of the circumferential "
                f"orders {orders}, as in a thin shell; take the harmonic level, which has one order"
            )
        count = min(int(1.6 * count) + 4, reachable)


def _broken(problem: HeldProblem, vectors: Matrix) -> FloatArray:
    """Part of every vector (m,) that breaks the constraint rows most."""
    comm, rows = problem.operators.comm, problem.rows
    lengths = [np.sqrt(squares(block, block, comm)) for block in (rows, vectors)]
    part = np.abs(inner(rows, vectors, comm)) / np.outer(*lengths)
    return np.asarray(part.max(axis=0, initial=0.0))


def _pairs(
    problem: HeldProblem, factor: Solver, count: int, start: FloatArray | None
) -> tuple[FloatArray, FloatArray]:
    """Lowest eigenpairs by the method that goes with the solver."""
    BODIES.add("eigenproblems")
    operators = problem.operators
    if isinstance(factor, ConstrainedIteration):
        return iterative_pairs(factor, operators.mass, count=count, start=start)
    # SLEPc goes vector by vector: pairs of equal modes, as of a whole solid, or as real parts of
    # complex unknowns make them, take it two to three times as long as blocks do
    single = operators.harmonic is not None and factor.parts == 1
    solve = slepc_pairs if single else eigenpairs
    return solve(factor, operators.mass, shift=problem.shift, count=count, deflate=problem.free)


def modes_from_rest(
    problem: HeldProblem, factor: Solver, at_rest: FloatArray, speed: float
) -> tuple[FloatArray, int] | None:
    """Modes of a solid at speed without another factorisation; None where that is not safe."""
    operators, orders, free = problem.operators, problem.orders, problem.free
    if operators.level == "harmonic" or isinstance(factor, ConstrainedIteration):
        return None
    if free.shape[1] and operators.harmonic is None:
        return None
    body = Spinning(operators=operators, speed_rad_s=speed, factor=factor, free=free)
    if body.remaining_stiffness < MARGIN:
        return None

    def wanted(values: FloatArray, vectors: Matrix) -> BoolArray:
        if orders is None:
            return np.arange(len(values)) < problem.wanted
        squared = energies(operators.circulation, vectors, operators.comm)
        of_order = np.flatnonzero(merging.is_of_order(squared, orders))
        out = np.zeros(len(values), dtype=bool)
        if len(of_order):
            last = values[of_order[: problem.wanted][-1]] * (1.0 + merging.CLUSTER)
            out[of_order[values[of_order] <= last]] = True
        return out

    found = modes_at_speed(body, at_rest, wanted)
    if found is None:
        return None
    if orders is None:
        return found[1][:, : problem.wanted], found[2]
    values, vectors = merging.modes_of_orders(operators, found[0], found[1], orders)
    whole = merging.whole_clusters(values, problem.wanted, float(found[0].max()))
    return vectors[:, :whole], found[2]


def modes_with_own_solver(
    problem: HeldProblem, factor: Solver, at_rest: FloatArray, speed: float
) -> tuple[FloatArray, tuple[tuple[str, str], ...]]:
    """Modes at speed with a solver of the stiffness there.

    `factor`: solver at rest, whose multigrid serves at speed too. `at_rest`: (local, m) modes at
    rest of all orders, which an iteration begins with. Returns vectors (local, m), what was solved
    and how often. Raises ReductionError: the body has no stiffness left at that speed.
    """
    operators, free = problem.operators, problem.free
    stiffness = _spinning_stiffness(operators, speed)
    did, spinning = [("factorisation", "")], None
    if isinstance(factor, ConstrainedIteration):
        did, matrix = [], shifted_matrix(operators, stiffness, problem.shift)
        found = interior_modes(problem, replace(factor, matrix=matrix), start=at_rest)
        negative, made = int(np.sum(found.known <= 0.0)), [matrix, stiffness]
    else:
        spinning = shifted_factor(operators, stiffness, problem.rows, problem.shift)
        negative, made = spinning.indefinite_count, [spinning, stiffness]
        if free.shape[1]:
            # the shift of a body with free motions lifts what has just lost its stiffness
            negative = negative_count(operators, stiffness, problem.rows, free)
            did.insert(0, ("count of negative stiffness", ": 1 factorisation"))
    waves = bool(negative) and operators.harmonic != 0 and not operators.rotating
    if not waves:
        refuse_instability(operators, negative, speed, free)
        found = found if spinning is None else interior_modes(problem, spinning)
    for each in {id(m): m for m in made}.values():
        each.destroy()
    if waves:
        # one that stands still in space has no stiffness there, and Coriolis forces hold it
        turning = replace(problem, operators=replace(operators, rotating=True))
        return modes_with_own_solver(turning, factor, at_rest, speed)
    return found.vectors, (*did, ("fixed-interface modes", f": {found.asked}"))


def _spinning_stiffness(operators: BodyOperators, speed: float) -> Any:
    """K + Ω² (Kσ - S), in the frame of the body K + Ω² Kσ."""
    matrix = operators.stiffness.copy()
    softened = () if operators.rotating else ((-1.0, operators.spin_softening),)
    for factor, part in ((1.0, operators.stress_stiffening), *softened):
        if isinstance(part, Operator):
            whole = part.folded()
            matrix.axpy(factor * speed**2, whole, _DIFFERENT)
            whole.destroy()
        else:
            matrix.axpy(factor * speed**2, part, _SAME)
    return matrix
