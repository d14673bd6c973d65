"""Craig-Bampton basis of a spinning body, one basis for a range of speeds.

Constraint modes (one per interface coordinate), fixed-interface modes at rest and, where the
centrifugal field matters, at the top speed; merged by an M-orthonormal rank-revealing step
(Craig and Bampton, AIAA J. 6 (1968) 1313-1319). To these comes, for every constraint mode Ψ, the
static answer K⁻¹ M Ψ of the held body to its inertia (as in the enhanced Craig-Bampton method of
Kim and Lee, Int. J. Numer. Methods Eng. 103 (2015) 79-93): what the truncated modes would have
done, to first order in ω².
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from petsc4py import PETSc

from solidwhirl.reduction.constrained import (
    ConstrainedFactor,
    bordered,
    eigenpairs,
    factorise,
)
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators import BodyOperators
from solidwhirl.reduction.vectors import apply, inner, project, symmetric

FloatArray = NDArray[np.float64]

#: Hoop strain beyond which a centrifugal field computed on the undeformed shape is refused.
MAXIMUM_HOOP_STRAIN = 0.05
# All matrices of a body come from one space and have one pattern.
_SAME = PETSc.Mat.Structure.SAME_NONZERO_PATTERN
# Relative change of a modal stiffness by Ω² (Kσ - S) from which the top speed gets modes too.
_PRESTRESS_MATTERS = 1e-4
# Singular values of the merged modes below this are the same vector twice.
_SAME_VECTOR = 1e-7
# A Rayleigh quotient this near to n counts as order n; a mesh mixes orders a little.
_ORDER_TOLERANCE = 0.25
# Modes this near in λ are one cluster: their directions are not determined.
_CLUSTER = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False)
class Basis:
    """Reduction basis of one family, columns [constraint modes, interior modes].

    Attributes
    ----------
    vectors
        (local û, b + m).
    interface_count
        b.
    eigenvalues
        (m,) squared angular frequencies of the interior vectors (Rayleigh-Ritz, at rest) [1/s²].
    fixed_eigenvalues
        (k,) those of the fixed-interface modes at rest, k <= m.
    solved
        What was factorised and solved, in order.
    """

    vectors: FloatArray
    interface_count: int
    eigenvalues: FloatArray
    fixed_eigenvalues: FloatArray
    solved: tuple[str, ...]


def reduction_basis(
    operators: BodyOperators,
    *,
    modes: int,
    maximum_speed_rad_s: float,
    orders: tuple[int, ...] = (1,),
) -> Basis:
    """Compute the basis.

    Parameters
    ----------
    operators
        Of one body.
    modes
        Interior modes asked for per family (solid: of the circumferential orders wanted;
        pairs are kept whole).
    maximum_speed_rad_s
        Top of the speed range.
    orders
        Solid only: circumferential orders of the modes that are kept. Orders other than 0 and 1
        load no interface of a body of revolution.

    Raises
    ------
    ReductionError
        The centrifugal field is outside linear theory, or the body loses its stiffness below
        the top speed, or modes did not converge.
    """
    _refuse_overspeed(operators, maximum_speed_rad_s)
    rows = operators.coupling.rows
    all_rows = np.hstack([rows, operators.coupling.anchors])
    free = _unrestrained(operators, all_rows)
    shift = -_reference_eigenvalue(operators) if free.shape[1] else 0.0
    solved = []
    factor = _factor(operators, operators.stiffness, all_rows, shift)
    solved.append("factorisation at rest")
    constraint = _constraint_modes(factor, rows.shape[1], all_rows.shape[1], len(rows))
    candidates = [free - constraint @ inner(rows, free, operators.comm)]
    if rows.shape[1]:
        # what the inertia of the constraint modes bends between the interfaces, statically
        inertia = apply(operators.mass, constraint)
        candidates.append(factor.solve(inertia, None)[: len(rows)])
        solved.append(f"inertia corrections of constraint modes: {rows.shape[1]}")
    kept = orders if operators.level == "solid" else None
    fixed, at_rest, used = _interior_modes(operators, factor, all_rows, shift, modes, kept, free)
    solved.append(f"fixed-interface modes at rest: {used}")
    candidates.append(at_rest)
    if _prestress_matters(operators, at_rest, maximum_speed_rad_s):
        stiffness = _spinning_stiffness(operators, maximum_speed_rad_s)
        spinning = _factor(operators, stiffness, all_rows, shift)
        solved.append("factorisation at top speed")
        _refuse_instability(spinning, maximum_speed_rad_s)
        _, at_speed, used = _interior_modes(operators, spinning, all_rows, shift, modes, kept, free)
        solved.append(f"fixed-interface modes at top speed: {used}")
        candidates.append(at_speed)
    interior, eigenvalues = _merge(operators, np.hstack(candidates), kept)
    return Basis(
        vectors=np.hstack([constraint, interior]),
        interface_count=rows.shape[1],
        eigenvalues=eigenvalues,
        fixed_eigenvalues=fixed,
        solved=tuple(solved),
    )


def _refuse_overspeed(operators: BodyOperators, speed: float) -> None:
    """Linear prestress neglects the change of shape; refuse where that is not small."""
    strain = operators.hoop_strain * speed**2
    if strain > MAXIMUM_HOOP_STRAIN:
        allowed = np.sqrt(MAXIMUM_HOOP_STRAIN / operators.hoop_strain) * 30.0 / np.pi
        raise ReductionError(
            f"at {speed * 30.0 / np.pi:.6g} rpm the hoop strain is {strain:.3g}; the prestress is "
            f"linear and good to {MAXIMUM_HOOP_STRAIN:g}, that is to {allowed:.6g} rpm"
        )


def _refuse_instability(factor: ConstrainedFactor, speed: float) -> None:
    if factor.indefinite_count > 0:
        raise ReductionError(
            f"at {speed * 30.0 / np.pi:.6g} rpm the body has lost its stiffness: K + Ω²(Kσ - S) "
            f"has {factor.indefinite_count} negative eigenvalues with its interfaces held"
        )


def _unrestrained(operators: BodyOperators, rows: FloatArray) -> FloatArray:
    """Rigid motions (local û, f) that the rows do not hold."""
    motions = np.column_stack(list(operators.rigid_motions.values()) or [rows[:, :0]])
    motions = motions if operators.rigid_motions else np.empty((len(rows), 0))
    if not motions.shape[1]:
        return motions
    comm = operators.comm
    gram = project(operators.mass, motions, comm)
    motions = motions @ np.linalg.inv(np.linalg.cholesky(gram)).T
    if not rows.shape[1]:
        return motions
    length = np.sqrt(np.diag(inner(rows, rows, comm)))
    held = inner(rows / length, motions, comm)
    _, s, vt = np.linalg.svd(held)
    rank = int(np.sum(s > 1e-9 * s.max()))
    return motions @ vt[rank:].T


def _reference_eigenvalue(operators: BodyOperators) -> float:
    """A small squared frequency: 1e-6 of the ratio of traces, far below the elastic modes."""
    ratio = operators.stiffness.getDiagonal().sum() / operators.mass.getDiagonal().sum()
    return float(1e-9 * ratio)


def _factor(
    operators: BodyOperators, stiffness: Any, rows: FloatArray, shift: float
) -> ConstrainedFactor:
    """Factor of the bordered K - shift M."""
    if shift == 0.0:
        return factorise(stiffness, rows)
    shifted = stiffness.copy()
    shifted.axpy(-shift, operators.mass, _SAME)
    return factorise(shifted, rows)


def _constraint_modes(factor: ConstrainedFactor, count: int, border: int, local: int) -> FloatArray:
    """Displacement for a unit value of every interface coordinate, the others held."""
    if not count:
        return np.empty((local, 0))
    values = np.zeros((border, count))
    values[:count, :count] = np.eye(count)
    return factor.solve(None, values)[:local]


def _interior_modes(
    operators: BodyOperators,
    factor: ConstrainedFactor,
    rows: FloatArray,
    shift: float,
    modes: int,
    orders: tuple[int, ...] | None,
    free: FloatArray,
) -> tuple[FloatArray, FloatArray, int]:
    """Fixed-interface modes of the wanted circumferential orders.

    Returns eigenvalues, vectors and the number of pairs that SLEPc was asked for.
    """
    local = len(rows)
    mass = bordered(operators.mass, np.zeros_like(rows))
    deflate = np.zeros((factor.matrix.getLocalSize()[0], free.shape[1]))
    deflate[:local] = free
    wanted = modes if orders is None else 2 * modes
    available = operators.mass.getSize()[0] - rows.shape[1] - free.shape[1]
    count = min(modes + 2 if orders is None else wanted + wanted // 2 + 4, available)
    found = -1
    while True:
        values, vectors = eigenpairs(factor, mass, shift=shift, count=count, deflate=deflate)
        vectors = vectors[:local]
        if orders is not None:
            values, vectors = _of_orders(operators, values, vectors, orders)
        whole = _whole_clusters(values, wanted)
        # a coarse mesh mixes the orders of its highest modes: asking for more then brings nothing
        if whole >= min(wanted, available) or count == available or whole <= found:
            return values[:whole], vectors[:, :whole], count
        found = whole
        count = min(int(1.6 * count) + 4, available)


def _whole_clusters(values: FloatArray, wanted: int) -> int:
    """Number of leading modes near the wanted one that cuts no repeated mode in half.

    The last cluster found may lack a member, so it only counts if it is not needed.
    """
    ends = [
        k for k in range(1, len(values)) if values[k] - values[k - 1] > _CLUSTER * abs(values[k])
    ]
    enough = [k for k in ends if k >= wanted]
    return enough[0] if enough else (ends[-1] if ends else 0)


def _of_orders(
    operators: BodyOperators, values: FloatArray, vectors: FloatArray, orders: tuple[int, ...]
) -> tuple[FloatArray, FloatArray]:
    """Modes of the wanted circumferential orders, by the Rayleigh quotient of J²."""
    squared = project(operators.circulation, vectors, operators.comm)
    gram = project(operators.mass, vectors, operators.comm)
    start = 0
    rotated = vectors.copy()
    squares = np.empty(len(values))
    for stop in range(1, len(values) + 1):
        if stop < len(values) and values[stop] - values[stop - 1] <= _CLUSTER * abs(values[stop]):
            continue
        span = slice(start, stop)
        n2, turn = scipy.linalg.eigh(squared[span, span], gram[span, span])
        rotated[:, span] = vectors[:, span] @ turn
        squares[span] = n2
        start = stop
    keep = _is_of_order(squares, orders)
    return values[keep], rotated[:, keep]


def _is_of_order(squared: FloatArray, orders: tuple[int, ...]) -> NDArray[np.bool_]:
    """Whether Rayleigh quotients of J² belong to one of the circumferential orders."""
    order = np.sqrt(np.maximum(squared, 0.0))
    return np.any([np.abs(order - n) < _ORDER_TOLERANCE for n in orders], axis=0)  # type: ignore[no-any-return]


def _spinning_stiffness(operators: BodyOperators, speed: float) -> Any:
    """K + Ω² (Kσ - S)."""
    matrix = operators.stiffness.copy()
    matrix.axpy(speed**2, operators.stress_stiffening, _SAME)
    matrix.axpy(-(speed**2), operators.spin_softening, _SAME)
    return matrix


def _prestress_matters(operators: BodyOperators, modes: FloatArray, speed: float) -> bool:
    """Whether Ω² (Kσ - S) changes or mixes the modes noticeably at the top speed."""
    if operators.stress_stiffening is None or speed == 0.0 or not modes.shape[1]:
        return False
    comm = operators.comm
    change = project(operators.stress_stiffening, modes, comm)
    change -= project(operators.spin_softening, modes, comm)
    stiffness = np.sqrt(np.diag(project(operators.stiffness, modes, comm)))
    relative = speed**2 * np.abs(change) / np.outer(stiffness, stiffness)
    return bool(relative.max() > _PRESTRESS_MATTERS)


def _merge(
    operators: BodyOperators, candidates: FloatArray, orders: tuple[int, ...] | None
) -> tuple[FloatArray, FloatArray]:
    """M-orthonormal interior vectors without duplicates, and their Rayleigh-Ritz eigenvalues.

    On a solid mesh, directions that are not of the wanted circumferential orders are dropped: a
    trace of other orders, which the mesh mixes in, would come out as modes of no accuracy.
    """
    comm = operators.comm
    if not candidates.shape[1]:
        return candidates, np.empty(0)
    length = np.sqrt(np.diag(project(operators.mass, candidates, comm)))
    scaled = candidates[:, length > 0.0] / length[length > 0.0]
    gram = symmetric(project(operators.mass, scaled, comm))
    s, q = np.linalg.eigh(gram)
    keep = s > _SAME_VECTOR**2 * s.max()
    basis = scaled @ (q[:, keep] / np.sqrt(s[keep]))
    # a second pass takes out the round-off that the small singular values brought in
    gram = symmetric(project(operators.mass, basis, comm))
    basis = basis @ np.linalg.inv(np.linalg.cholesky(gram)).T
    if orders is not None:
        squared, turn = np.linalg.eigh(symmetric(project(operators.circulation, basis, comm)))
        basis = basis @ turn[:, _is_of_order(squared, orders)]
    values, turn = np.linalg.eigh(symmetric(project(operators.stiffness, basis, comm)))
    return _turned_columns(basis, turn), values


def _turned_columns(basis: FloatArray, turn: FloatArray) -> FloatArray:
    """Rotate columns and fix their sign (largest entry of the turn positive)."""
    signs = np.sign(turn[np.abs(turn).argmax(axis=0), np.arange(turn.shape[1])])
    return np.asarray(basis @ (turn * signs))


def orthogonality_error(operators: BodyOperators, basis: Basis) -> float:
    """Largest deviation of the interior modes from M-orthonormality."""
    interior = basis.vectors[:, basis.interface_count :]
    gram = project(operators.mass, interior, operators.comm)
    return float(np.abs(gram - np.eye(len(gram))).max()) if len(gram) else 0.0
