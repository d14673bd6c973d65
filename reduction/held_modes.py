"""Modes of a body with its interfaces held, at rest and at speed, by the solver that fits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc

from solidwhirl.reduction.clusters import CLUSTER, modes_of_orders, whole_clusters
from solidwhirl.reduction.constrained import ConstrainedFactor, eigenpairs, factorise
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.iterative_modes import iterative_pairs
from solidwhirl.reduction.merging import is_of_order, reference_eigenvalue
from solidwhirl.reduction.multigrid import ConstrainedIteration
from solidwhirl.reduction.operators import BodyOperators
from solidwhirl.reduction.overspeed import (
    centrifugal_product,
    negative_count,
    operator_places,
    refuse_instability,
)
from solidwhirl.reduction.slepc_modes import slepc_pairs
from solidwhirl.reduction.solvers import Solver, prepared_solver
from solidwhirl.reduction.spinning_modes import (
    MARGIN,
    Spinning,
    modes_at_speed,
    remaining_stiffness,
)
from solidwhirl.reduction.vectors import apply, project

FloatArray = NDArray[np.float64]

# All matrices of a body come from one space; the stiffness has all entries that others have.
_SAME = PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN
# Eigenvalues of held modes below this part of the reference eigenvalue are none.
_NO_STIFFNESS = 1e-3
# Modes that are computed beyond those asked for, to know where a cluster ends, and one direction
# that the iteration needs.
_BEYOND = 3
# Modes at the end of the spectrum that an iteration may not find.
_UNREACHED = 2
# Growth of the number of modes that has to bring one of the wanted orders.
_FRUITLESS = 2.0
# Modes of a solid that are looked through for the first one of the wanted orders.
_SEARCHED = 100


def held_solver(
    operators: BodyOperators, rows: FloatArray, shift: float, free: FloatArray
) -> Solver:
    """Solver of K - shift M at rest under constraint rows.

    Parameters
    ----------
    operators
        Of the body.
    rows
        (local, b) constraint rows.
    shift
        [1/s²].
    free
        (local, f) M-orthonormal rigid motions that the rows do not hold.
    """
    matrix = shifted_matrix(operators, operators.stiffness, shift)
    found = prepared_solver(
        operators.stiffness,
        matrix,
        rows,
        lambda: operator_places(operators),
        choice=operators.ingredients.effects.solver if operators.level == "solid" else "direct",
        free=free,
        momentum=apply(operators.mass, free),
        shift=shift,
    )
    if isinstance(found, ConstrainedFactor) and matrix is not operators.stiffness:
        matrix.destroy()
    return found


def shifted_factor(
    operators: BodyOperators, stiffness: Any, rows: FloatArray, shift: float
) -> ConstrainedFactor:
    """Factor of the bordered K - shift M.

    Parameters
    ----------
    operators
        Of the body.
    stiffness
        K, at rest or at speed.
    rows
        (local, b) constraint rows.
    shift
        [1/s²].
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
    operators: BodyOperators,
    factor: Solver,
    rows: FloatArray,
    shift: float,
    modes: int,
    orders: tuple[int, ...] | None,
    free: FloatArray,
    start: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray, int, float, FloatArray, FloatArray]:
    """Fixed-interface modes of the wanted circumferential orders.

    Returns eigenvalues, vectors, the number of pairs that were asked for, the next eigenvalue
    (or the last one of the list), and vectors and eigenvalues of all orders that were found.
    """
    wanted = modes if orders is None else 2 * modes
    available = operators.mass.getSize()[0] - rows.shape[1] - free.shape[1]
    if wanted + _BEYOND > available:
        families = 1 if orders is None else 2
        raise ReductionError(
            f"{modes} fixed-interface modes are asked for, the body can have "
            f"{max(available - _BEYOND, 0) // families} on this mesh; choose fewer, or a finer mesh"
        )
    reachable = available - _UNREACHED
    count = min(modes + 2 if orders is None else wanted + wanted // 2 + 4, reachable)
    found, since = 0, count
    while True:
        values, vectors = _pairs(operators, factor, shift, count, free, start)
        start = vectors
        # a space that is used up ends in vectors that break the constraint and have no stiffness
        real = np.abs(values) > _NO_STIFFNESS * reference_eigenvalue(operators)
        values, vectors = values[real], vectors[:, real]
        every, known, highest = vectors, np.sort(values), float(values.max(initial=0.0))
        if orders is not None:
            values, vectors = modes_of_orders(operators, values, vectors, orders)
        whole = whole_clusters(values, wanted, highest)
        if whole > found:
            found, since = whole, count
        # a coarse mesh mixes the orders of its highest modes, more of which bring nothing; but a
        # thin shell has many modes of other orders before the first one that is wanted
        spent = count == reachable or (found > 0 and count > _FRUITLESS * since)
        if whole >= wanted or spent:
            beyond = float(values[min(whole, len(values) - 1)]) if len(values) else 0.0
            return values[:whole], vectors[:, :whole], count, beyond, every, known
        if found == 0 and count > wanted + _SEARCHED:
            raise ReductionError(
                f"none of the {count} lowest fixed-interface modes has one of the circumferential "
                f"orders {orders}, as in a thin shell; take the harmonic level, which has one order"
            )
        count = min(int(1.6 * count) + 4, reachable)


def _pairs(
    operators: BodyOperators,
    factor: Solver,
    shift: float,
    count: int,
    free: FloatArray,
    start: FloatArray | None,
) -> tuple[FloatArray, FloatArray]:
    """Lowest eigenpairs by the method that goes with the solver."""
    if isinstance(factor, ConstrainedIteration):
        return iterative_pairs(factor, operators.mass, count=count, start=start)
    solve = eigenpairs if operators.level == "solid" else slepc_pairs
    return solve(factor, operators.mass, shift=shift, count=count, deflate=free)


def modes_from_rest(
    operators: BodyOperators,
    factor: Solver,
    at_rest: FloatArray,
    free: FloatArray,
    modes: int,
    orders: tuple[int, ...] | None,
    speed: float,
) -> tuple[FloatArray, int] | None:
    """Modes of a solid at speed without another factorisation; None where that is not safe."""
    if orders is None or free.shape[1] or isinstance(factor, ConstrainedIteration):
        return None
    centrifugal = centrifugal_product(operators)
    left = remaining_stiffness(factor, operators.stiffness, centrifugal, free, speed)
    if left < MARGIN:
        return None
    body = Spinning(
        stiffness=lambda block: apply(operators.stiffness, block),
        centrifugal=centrifugal,
        mass=operators.mass,
        speed_rad_s=speed,
        factor=factor,
        free=free,
    )

    def wanted(values: FloatArray, vectors: FloatArray) -> NDArray[np.bool_]:
        squared = np.diag(project(operators.circulation, vectors, operators.comm))
        of_order = np.flatnonzero(is_of_order(squared, orders))
        out = np.zeros(len(values), dtype=bool)
        if len(of_order):
            last = values[of_order[: 2 * modes][-1]] * (1.0 + CLUSTER)
            out[of_order[values[of_order] <= last]] = True
        return out

    found = modes_at_speed(body, at_rest, wanted)
    if found is None:
        return None
    values, vectors = modes_of_orders(operators, found[0], found[1], orders)
    whole = whole_clusters(values, 2 * modes, float(found[0].max()))
    return vectors[:, :whole], found[2]


def modes_with_own_solver(
    operators: BodyOperators,
    factor: Solver,
    rows: FloatArray,
    shift: float,
    modes: int,
    orders: tuple[int, ...] | None,
    free: FloatArray,
    speed: float,
    every: FloatArray,
) -> tuple[FloatArray, tuple[tuple[str, str], ...]]:
    """Modes at speed with a solver of the stiffness there.

    Parameters
    ----------
    operators, rows, shift, modes, orders, free
        As in `interior_modes`.
    factor
        Solver at rest, whose multigrid serves at speed too.
    speed
        Ω [rad/s].
    every
        (local, m) modes at rest of all orders, which an iteration begins with.

    Returns
    -------
    vectors (local, m), what was solved and how often

    Raises
    ------
    ReductionError
        The body has no stiffness left at that speed.
    """
    stiffness = _spinning_stiffness(operators, speed)
    if isinstance(factor, ConstrainedIteration):
        matrix = shifted_matrix(operators, stiffness, shift)
        own = replace(factor, matrix=matrix)
        _, found, used, _, _, known = interior_modes(
            operators, own, rows, shift, modes, orders, free, start=every
        )
        refuse_instability(operators, int(np.sum(known <= 0.0)), speed, free)
        for made in {id(m): m for m in (matrix, stiffness)}.values():
            made.destroy()
        return found, (("fixed-interface modes", f": {used}"),)
    did = [("factorisation", "")]
    spinning = shifted_factor(operators, stiffness, rows, shift)
    negative = spinning.indefinite_count
    if free.shape[1]:
        # the shift of a body with free motions lifts what has just lost its stiffness
        negative = negative_count(operators, stiffness, rows, free)
        did.insert(0, ("count of negative stiffness", ": 1 factorisation"))
    refuse_instability(operators, negative, speed, free)
    _, found, used, *_ = interior_modes(operators, spinning, rows, shift, modes, orders, free)
    spinning.destroy()
    stiffness.destroy()
    return found, (*did, ("fixed-interface modes", f": {used}"))


def _spinning_stiffness(operators: BodyOperators, speed: float) -> Any:
    """K + Ω² (Kσ - S)."""
    matrix = operators.stiffness.copy()
    matrix.axpy(speed**2, operators.stress_stiffening, _SAME)
    matrix.axpy(-(speed**2), operators.spin_softening, _SAME)
    return matrix
