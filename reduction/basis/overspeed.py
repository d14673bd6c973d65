"""Speeds that a body can not be reduced for: beyond linear prestress, or without stiffness."""

from __future__ import annotations

from typing import Any

import numpy as np

from solidwhirl.core.reduction_work import BODIES
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators.matrices import BodyOperators
from solidwhirl.reduction.operators.solver_choice import Solver, block_places, prepared_solver
from solidwhirl.reduction.solvers.block_krylov import krylov_pairs
from solidwhirl.reduction.solvers.constrained import factorise
from solidwhirl.reduction.solvers.hierarchy import BlockPlaces
from solidwhirl.reduction.solvers.vectors import apply, inner
from solidwhirl.rotordyn.core.arrays import FloatArray, Matrix

#: Hoop strain beyond which a centrifugal field computed on the undeformed shape is refused.
MAXIMUM_HOOP_STRAIN = 0.05
_RPM = 30.0 / np.pi
# Residual of the softest direction; the square of it is the error of the speed squared.
_RESIDUAL = 1e-6


def refuse_overspeed(operators: BodyOperators, speed_rad_s: float) -> None:
    """Linear prestress neglects the change of shape; refuse where that is not small.

    Raises ReductionError with the hoop strain and the speed up to which the prestress is good.
    """
    strain = operators.hoop_strain * speed_rad_s**2
    if strain > MAXIMUM_HOOP_STRAIN:
        allowed = np.sqrt(MAXIMUM_HOOP_STRAIN / operators.hoop_strain) * _RPM
        raise ReductionError(
            f"at {speed_rad_s * _RPM:.6g} rpm the hoop strain is {strain:.3g}; the prestress is "
            f"linear and good to {MAXIMUM_HOOP_STRAIN:g}, that is to {allowed:.6g} rpm"
        )


def refuse_instability(
    operators: BodyOperators, negative: int, speed_rad_s: float, free: FloatArray
) -> None:
    """Refuse a body whose stiffness at speed is not positive with its interfaces held.

    `negative`: negative eigenvalues of its stiffness at speed. Raises ReductionError with the speed
    and the number of negative eigenvalues there, and the speed at which the first of them was zero.
    """
    if negative <= 0:
        return
    lost, change = (
        speed_without_stiffness(operators, free),
        "Kσ" if operators.rotating else "(Kσ - S)",
    )
    raise ReductionError(
        f"at {speed_rad_s * _RPM:.6g} rpm the body has lost its stiffness: K + Ω²{change} has "
        f"{negative} negative eigenvalues with its interfaces held, the first of "
        f"them from {lost * _RPM:.7g} rpm on"
    )


def negative_count(
    operators: BodyOperators, stiffness: Any, rows: FloatArray, free: FloatArray
) -> int:
    """Negative eigenvalues of a stiffness with interfaces and rigid motions held.

    `stiffness`: K + Ω²(Kσ - S), PETSc. `rows`: (local, b) rows that the interfaces hold.
    """
    factor = factorise(stiffness, np.hstack([rows, apply(operators.mass, free)]))
    count = factor.indefinite_count
    factor.destroy()
    return count


def speed_without_stiffness(operators: BodyOperators, free: FloatArray) -> float:
    """Lowest speed at which a direction of the held body has no stiffness left [rad/s].

    `operators`: of the body, with its centrifugal matrices. `free`: (local, f) M-orthonormal rigid
    motions that the interfaces leave free; they have no stiffness at any speed and are left out.
    Result: root of -1/θ of the lowest θ of (Kσ - S) x = θ K x; inf if rotation stiffens all
    motions.
    """
    held = np.hstack([operators.coupling.held, apply(operators.mass, free)])
    factor = solver_of(operators, operators.stiffness, held, free[:, :0])
    theta, _ = softest_direction(operators, factor, free[:, :0], _RESIDUAL)
    factor.destroy()
    return float(np.sqrt(-1.0 / theta)) if theta < 0.0 else float(np.inf)


def softest_direction(
    operators: BodyOperators, factor: Solver, free: Matrix, tolerance: float, least: float = 0.0
) -> tuple[float, float]:
    """Lowest θ of (Kσ - S) x = θ K x of the held body, and its possible error.

    `factor`: solver of K at rest. `free`: (local, f) what is left out. `tolerance`: of θ, or of
    `least` where |θ| is smaller. Returns inf where rotation leaves the stiffness as it is.
    """
    momentum = apply(operators.mass, free)

    def softened(block: Matrix) -> Matrix:
        # rounding moves a free body as a whole
        moved = factor.solve(centrifugal_load(operators, block), None)[: len(block)]
        return np.asarray(moved - free @ inner(momentum, moved, operators.comm))

    BODIES.add("eigenproblems")
    theta, _, left = krylov_pairs(
        softened,
        operators.stiffness,
        first=np.argsort,
        count=1,
        tolerance=tolerance,
        least=least,
        outside=free[:, :0],
    )
    return (float(theta[0]), float(left[0])) if len(theta) else (float(np.inf), 0.0)


def solver_of(
    operators: BodyOperators, matrix: Any, rows: FloatArray, free: FloatArray, shift: float = 0.0
) -> Solver:
    """Solver of K - shift M at rest under constraint rows, by the way chosen for the body."""
    return prepared_solver(
        operators.stiffness,
        matrix,
        rows,
        lambda: operator_places(operators),
        choice=operators.ingredients.effects.solver if operators.harmonic is None else "direct",
        free=free,
        momentum=apply(operators.mass, free),
        shift=shift,
    )


def operator_places(operators: BodyOperators) -> BlockPlaces:
    """Places of the unknowns û of a whole solid in blocks of three."""
    unknowns = operators.coupling.unknowns
    free = len(unknowns.norms)
    masters = {c: motion[free:] for c, motion in operators.rigid_motions.items()}
    return block_places(operators.space, operators.ingredients.kinematics, unknowns, masters)


def centrifugal_load(operators: BodyOperators, block: FloatArray) -> FloatArray:
    """Centrifugal part of the stiffness whose modes the basis has, times a block of vectors.

    Kσ - S in the inertial frame. In the frame of the body Kσ alone: above a critical speed of the
    held body K + Ω²(Kσ - S) is not positive, and Coriolis forces hold it. Fields of order 1 and
    more are held so in the inertial frame too, where a wave on the body stands still in it (see
    `fixed_interface_modes.modes_with_own_solver`).
    """
    stiffening = apply(operators.stress_stiffening, block)
    if operators.rotating:
        return np.asarray(stiffening)
    return np.asarray(stiffening - apply(operators.spin_softening, block))
