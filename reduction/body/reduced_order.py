"""One circumferential order of a reduction: its basis, and what that makes of the operators."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.linalg import eigh

from solidwhirl.reduction.basis.craig_bampton import Basis, reduction_basis
from solidwhirl.reduction.basis.merging import merged
from solidwhirl.reduction.basis.pairing import paired
from solidwhirl.reduction.basis.reduced_block import ReducedBlock
from solidwhirl.reduction.body.request import ReductionRequest
from solidwhirl.reduction.body.superelements import reduce_block
from solidwhirl.reduction.operators.matrices import BodyOperators
from solidwhirl.reduction.residuals.residual_energy import balanced, residual_terms
from solidwhirl.reduction.solvers.vectors import apply, inner, project, symmetric
from solidwhirl.rotordyn.core.arrays import FloatArray


def reduce_order(
    operators: BodyOperators, request: ReductionRequest, points: FloatArray
) -> tuple[Basis, ReducedBlock]:
    """Return the basis of one order, and what it makes of the operators.

    `points`: recovery points, (m, 3) [m]. Raises ReductionError: see `reduction_basis`.
    """
    basis = reduction_basis(
        operators,
        modes=request.modes if request.orders else 2 * request.modes,
        maximum_speed_rad_s=request.maximum_speed_rad_s,
        orders=request.orders,
        speeds_between_rad_s=request.speeds_between_rad_s,
    )
    if operators.harmonic is not None or operators.rotating:
        basis = with_spin_answers(
            operators,
            basis,
            speed_rad_s=request.maximum_speed_rad_s,
            tolerance=request.spin_tolerance,
        )
    if operators.ingredients.effects.shape == "round":
        basis = paired(operators, basis, request.orders)
    return basis, reduce_block(operators, basis, points)


# Modes that the spin loads: up to this multiple of the top speed, where gyroscopic effects let
# their critical speeds come into the range.
_REACH = 1.5


def with_spin_answers(
    operators: BodyOperators, basis: Basis, *, speed_rad_s: float, tolerance: float
) -> Basis:
    """Take static answers to the loads of the spin into a basis.

    `operators`, `basis`: of one body and circumferential order; the factor of the basis is used
    again. `tolerance`: relative error of a frequency below which a combination of answers is left
    out; 0: the basis is returned as it is.
    """
    if not tolerance or not speed_rad_s:
        return basis
    loads = _loads(operators, basis, speed_rad_s)
    if not loads.shape[1]:
        return basis
    comm, interior = operators.comm, basis.vectors[:, basis.interface_count :]
    answers = basis.factor.solve(loads, None)[: len(loads)]
    f = basis.free.shape[1]
    elastic = interior[:, f:]  # Rayleigh-Ritz: K-orthogonal, the free motions first
    inside = inner(elastic, apply(operators.stiffness, answers), comm)
    outside = answers - elastic @ (inside / basis.eigenvalues[f:, None])
    squared, turn = np.linalg.eigh(symmetric(project(operators.stiffness, outside, comm)))
    # what eliminating a direction takes from s²; half of it from the frequency
    kept = 0.5 * squared > tolerance
    if not kept.any():
        return basis
    new = outside @ (turn[:, kept] / np.sqrt(squared[kept]))
    wider, eigenvalues = merged(operators, basis.free, [elastic, new], None, exact=2)
    return replace(
        basis,
        vectors=np.hstack([basis.vectors[:, : basis.interface_count], wider]),
        eigenvalues=eigenvalues,
        solved=(
            *basis.solved,
            f"static answers to the spin: {int(kept.sum())} of {loads.shape[1]} solutions",
        ),
    )


def _loads(operators: BodyOperators, basis: Basis, speed: float) -> FloatArray:
    """Loads of the spin on modes of the free and of the held body, per unit of elastic frequency.

    Their answers' energy is then the relative change of the squared frequency.
    """
    comm, v = operators.comm, basis.vectors
    stiffness, mass = (
        symmetric(project(m, v, comm)) for m in (operators.stiffness, operators.mass)
    )
    squared, shapes = eigh(stiffness, mass)
    rate = np.concatenate([np.sqrt(np.maximum(squared, 0.0)), np.sqrt(basis.fixed_eigenvalues)])
    motions = np.hstack([v @ shapes, basis.fixed_vectors])[:, rate <= _REACH * speed]
    elastic = float(np.sqrt(basis.fixed_eigenvalues.min(initial=np.inf)))
    rate = np.maximum(rate[rate <= _REACH * speed], min(elastic, speed))
    _, _, gyroscopic, centrifugal = residual_terms(operators, motions)
    loads = np.stack([speed * gyroscopic, speed**2 * centrifugal / rate])
    loads = np.hstack(list(balanced(loads, operators, basis.free)))
    return np.asarray(loads[:, np.abs(loads).max(axis=0, initial=0.0) > 0.0])
