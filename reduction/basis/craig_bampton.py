"""Craig-Bampton basis of a spinning body, one basis for a range of speeds.

Constraint modes (one per interface coordinate), fixed-interface modes at rest and, where the
centrifugal field matters, at the top speed; merged by an M-orthonormal rank-revealing step
(Craig and Bampton, AIAA J. 6 (1968) 1313-1319). To these comes, for every constraint mode Ψ, the
static answer K⁻¹ M Ψ of the held body to its inertia (as in the enhanced Craig-Bampton method of
Kim and Lee, Int. J. Numer. Methods Eng. 103 (2015) 79-93): what the truncated modes would have
done, to first order in ω².
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from solidwhirl.reduction.basis import fixed_interface_modes as fixed_modes
from solidwhirl.reduction.basis.merging import merged, reference_eigenvalue, rounding_of_energies
from solidwhirl.reduction.basis.overspeed import (
    MAXIMUM_HOOP_STRAIN,
    centrifugal_load,
    refuse_overspeed,
)
from solidwhirl.reduction.operators.held import unrestrained
from solidwhirl.reduction.operators.matrices import BodyOperators
from solidwhirl.reduction.operators.solver_choice import Solver
from solidwhirl.reduction.solvers.constrained import ConstrainedFactor
from solidwhirl.reduction.solvers.vectors import apply, energies, inner, project, symmetric
from solidwhirl.rotordyn.core.arrays import FloatArray, Matrix

__all__ = ["MAXIMUM_HOOP_STRAIN", "Basis", "orthogonality_error", "reduction_basis"]

# Relative change of a modal stiffness by Ω² (Kσ - S) from which the top speed gets modes too.
_PRESTRESS_MATTERS = 1e-4
# Stiffness of free rigid motions by the shift, in roundings of their energy.
_ABOVE_ROUNDING = 1e4
# Least part of constraint modes that rounding leaves of combinations of them.
_DEPENDENT = 1e-14


@dataclass(frozen=True, kw_only=True, eq=False)
class Basis:
    """Reduction basis of one family, columns [constraint modes, interior modes]."""

    vectors: Matrix  #: (local û, b + m)
    interface_count: int
    #: (m,) squared angular frequencies of the interior vectors (Rayleigh-Ritz, at rest) [1/s²]
    eigenvalues: FloatArray
    fixed_eigenvalues: FloatArray  #: (k,) those of the fixed-interface modes at rest, k <= m
    fixed_vectors: Matrix  #: (local û, k) these modes, M-orthonormal
    #: Lowest eigenvalue of a fixed-interface mode at rest that is not in the basis, or the highest
    #: that is, whichever is known [1/s²]
    omitted_eigenvalue: float
    factor: Solver  #: Solver of K - shift M at rest with the interfaces held
    shift: float  #: 0, or a small negative number [1/s²] where rigid motions are not held
    #: (local û, f) rigid motions that the interfaces do not hold; they lie in the basis
    free: Matrix
    solved: tuple[str, ...]
    #: Of all fixed-interface modes at rest that were computed, those of other circumferential
    #: orders too, rising
    found_eigenvalues: FloatArray = field(default_factory=lambda: np.empty(0))
    #: (b + m, b + m) turn of a solid's coordinates where it is known by construction
    generator: FloatArray | None = None
    #: Deviation of the interior modes from M-orthonormality before they were put into pairs, whose
    #: rigid motions are orthonormal in the mean over turns; None: they are as they were found
    orthogonality: float | None = None


def reduction_basis(
    operators: BodyOperators,
    *,
    modes: int,
    maximum_speed_rad_s: float,
    orders: tuple[int, ...] = (1,),
    speeds_between_rad_s: tuple[float, ...] = (),
) -> Basis:
    """Compute the basis.

    `modes`: interior modes asked for per family (solid: of the circumferential orders wanted; pairs
    are kept whole). `orders`: circumferential orders of a solid's modes that are kept; others than
    0 and 1 load no interface of a body of revolution. Empty: modes are not told apart, and `modes`
    counts each of them. `speeds_between_rad_s`: whose modes are taken in as those of the top speed
    are. Raises ReductionError: the centrifugal field is outside linear theory, or the body loses
    its stiffness below the top speed, or modes did not converge.
    """
    refuse_overspeed(operators, maximum_speed_rad_s)
    rows, all_rows = operators.coupling.rows, operators.coupling.held
    free = unrestrained(operators.mass, operators.coupling)
    shift = _shift(operators, free)
    kept = (orders or None) if operators.harmonic is None else None
    problem = fixed_modes.HeldProblem(
        operators=operators, rows=all_rows, free=free, shift=shift, modes=modes, orders=kept
    )
    factor = fixed_modes.held_solver(problem)
    direct = isinstance(factor, ConstrainedFactor)
    solved = ["factorisation at rest" if direct else "multigrid at rest"]
    constraint = _constraint_modes(operators, factor)
    candidates = []
    if rows.shape[1]:
        # what the inertia of the constraint modes bends between the interfaces, statically
        inertia = apply(operators.mass, _apart(operators, constraint))
        candidates.append(factor.solve(inertia, None)[: len(rows)])
        solved.append(f"inertia corrections of constraint modes: {rows.shape[1]}")
    fixed = fixed_modes.interior_modes(problem, factor)
    solved.append(f"fixed-interface modes at rest: {fixed.asked}")
    if (count := len(fixed.eigenvalues)) < problem.wanted:
        solved.append(f"of the {problem.wanted} modes asked for the mesh has {count}")
    candidates.append(fixed.vectors)
    # a solid mesh mixes circumferential orders
    exact = len(candidates) if kept is None and direct else 0
    if _prestress_matters(operators, fixed.vectors, maximum_speed_rad_s):
        for speed in (*speeds_between_rad_s, maximum_speed_rad_s):
            named = "top speed" if speed == maximum_speed_rad_s else f"{speed:.6g} rad/s"
            candidates.append(_modes_at(problem, factor, fixed, speed, named, solved))
    interior, eigenvalues = merged(operators, free, candidates, kept, exact=exact)
    return Basis(
        vectors=np.hstack([constraint, interior]),
        interface_count=rows.shape[1],
        eigenvalues=eigenvalues,
        fixed_eigenvalues=fixed.eigenvalues,
        fixed_vectors=fixed.vectors,
        omitted_eigenvalue=fixed.beyond,
        factor=factor,
        shift=shift,
        free=free,
        solved=tuple(solved),
        found_eigenvalues=fixed.known,
    )


def _shift(operators: BodyOperators, free: Matrix) -> float:
    """Shift that holds rigid motions that are free, far below the modes of slender bodies as well.

    Constraint modes are those at the shift, not at rest.
    """
    if not free.shape[1]:
        return 0.0
    rounding = float(rounding_of_energies(operators, free).max())
    return -min(reference_eigenvalue(operators), _ABOVE_ROUNDING * rounding)


def _modes_at(
    problem: fixed_modes.HeldProblem,
    factor: Solver,
    fixed: fixed_modes.HeldModes,
    speed: float,
    named: str,
    solved: list[str],
) -> FloatArray:
    """Modes at a speed; adds what was solved for them to a list."""
    found = fixed_modes.modes_from_rest(problem, factor, fixed.every, speed)
    if found is not None:
        solved.append(f"modes at {named} with the factor at rest, solutions: {found[1]}")
        return found[0]
    at_speed, did = fixed_modes.modes_with_own_solver(problem, factor, fixed.every, speed)
    solved += [f"{what} at {named}{count}" for what, count in did]
    return at_speed


def _constraint_modes(operators: BodyOperators, factor: Solver) -> Matrix:
    """Displacement for a unit value of every interface coordinate, the others held."""
    rows, border = operators.coupling.rows, operators.coupling.held.shape[1]
    count = rows.shape[1]
    if operators.held is not None:  # what the prestress was solved with
        return operators.held.constraint[:, :count]
    if not count:
        return rows
    values = np.zeros((border, count), dtype=rows.dtype)
    values[:count, :count] = np.eye(count)
    return factor.solve(None, values)[: len(rows)]


def _apart(operators: BodyOperators, constraint: FloatArray) -> FloatArray:
    """Combinations of the constraint modes that are M-orthogonal.

    Those of interfaces near each other are large and nearly opposite; their sum would be lost.
    """
    gram = project(operators.mass, constraint, operators.comm)
    length = np.sqrt(np.diag(gram).real)
    s, q = np.linalg.eigh(symmetric(gram / np.outer(length, length)))
    return np.asarray(constraint @ (q / np.sqrt(np.maximum(s, _DEPENDENT)) / length[:, None]))


def _prestress_matters(operators: BodyOperators, modes: FloatArray, speed: float) -> bool:
    """Whether Ω² (Kσ - S) changes or mixes the modes noticeably at the top speed."""
    if operators.stress_stiffening is None or speed == 0.0 or not modes.shape[1]:
        return False
    comm = operators.comm
    change = inner(modes, centrifugal_load(operators, modes), comm)
    stiffness = np.sqrt(energies(operators.stiffness, modes, comm))
    relative = speed**2 * np.abs(change) / np.outer(stiffness, stiffness)
    return bool(relative.max() > _PRESTRESS_MATTERS)


def orthogonality_error(operators: BodyOperators, basis: Basis) -> float:
    """Largest deviation of the interior modes from M-orthonormality."""
    if basis.orthogonality is not None:
        return basis.orthogonality
    interior = basis.vectors[:, basis.interface_count :]
    gram = project(operators.mass, interior, operators.comm)
    return float(np.abs(gram - np.eye(len(gram))).max()) if len(gram) else 0.0
