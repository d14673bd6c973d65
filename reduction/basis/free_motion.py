"""Rigid motions in reduced coordinates: exact, and without elastic force."""

from __future__ import annotations

import numpy as np

from solidwhirl.reduction.basis.craig_bampton import Basis
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators.kinematics import COMPONENTS
from solidwhirl.reduction.operators.matrices import BodyOperators
from solidwhirl.reduction.solvers.vectors import (
    apply,
    diagonal,
    energies,
    inner,
    squares,
    symmetric,
)
from solidwhirl.rotordyn.core.arrays import BoolArray, Matrix

# Largest part of a rigid motion, in kinetic energy, that the basis may miss.
_MISSED = 1e-12
# Elastic force of a rigid motion beside that of the diagonal of K alone: rounding of the assembly.
_ROUNDING = 1e-10


def rigid_coefficients(operators: BodyOperators, basis: Basis) -> tuple[Matrix, BoolArray]:
    """Return the reduced coordinates of the rigid motions about the origin.

    Returns rigid: (n, 6) coordinates of the motions ux ... rz of the first family; zero where
    absent; present: (6,) which of them lie in the basis.

    The interface coordinates are those of the interfaces themselves; a fit of all coordinates would
    lose digits where interfaces are near each other and their constraint modes nearly parallel.
    """
    comm, b = operators.comm, basis.interface_count
    n = basis.vectors.shape[1]
    rigid, present = np.zeros((n, 6), dtype=basis.vectors.dtype), np.zeros(6, dtype=bool)
    constraint, interior = basis.vectors[:, :b], basis.vectors[:, b:]
    weighted = apply(operators.mass, interior)
    gram = symmetric(inner(interior, weighted, comm))
    for component, motion in operators.rigid_motions.items():
        k = COMPONENTS.index(component)
        at = inner(operators.coupling.rows, motion[:, None], comm)[:, 0]
        left = motion - constraint @ at
        fit = np.linalg.solve(gram, inner(weighted, left[:, None], comm)[:, 0])
        pair = np.column_stack([left - interior @ fit, motion])
        size = energies(operators.mass, pair, comm)
        if size[0] < _MISSED * size[1]:
            rigid[:, k], present[k] = np.concatenate([at, fit]), True
    return rigid, present


def without_rigid_force(
    operators: BodyOperators, stiffness: Matrix, mass: Matrix, rigid: Matrix
) -> Matrix:
    """Return the reduced stiffness, projected on motions that are M-orthogonal to the rigid ones.

    K R = 0 holds on the mesh but for the rounding of its stiffest entries, which a soft body shows
    as a small stiffness of either sign.

    `stiffness`, `mass`: (n, n) reduced matrices. `rigid`: (n, 6) rigid motions; columns of zeros
    are absent. Raises ReductionError: the force K R on the mesh is more than rounding.
    """
    motions = rigid[:, rigid.any(axis=0)]
    if not motions.shape[1]:
        return stiffness
    force = rigid_force(operators)
    if force > _ROUNDING:
        raise ReductionError(
            f"the stiffness resists a rigid motion: relative force {force:.2e}, rounding gives "
            f"less than {_ROUNDING:g}"
        )
    keep = straining_part(mass, rigid)
    return symmetric(keep.conj().T @ stiffness @ keep)


def straining_part(mass: Matrix, rigid: Matrix) -> Matrix:
    """Return the projection of motions on those that are M-orthogonal to the rigid ones.

    `mass`: (n, n) reduced matrix. `rigid`: (n, 6) rigid motions; columns of zeros are absent.
    Result: (n, n) I - R (Rᴴ M R)⁻¹ Rᴴ M.
    """
    motions = rigid[:, rigid.any(axis=0)]
    if not motions.shape[1]:
        return np.eye(len(mass))
    momentum = mass @ motions
    held = np.linalg.solve(motions.conj().T @ momentum, momentum.conj().T)
    return np.asarray(np.eye(len(mass)) - motions @ held)


def rigid_force(operators: BodyOperators) -> float:
    """Return the largest |K r| of rigid motions r over |diag(K) r|, which knows no cancellation."""
    if not operators.rigid_motions:
        return 0.0
    comm = operators.comm
    motions = np.column_stack(list(operators.rigid_motions.values()))
    force = apply(operators.stiffness, motions)
    own = diagonal(operators.stiffness, motions)[:, None] * motions
    sizes = [squares(a, a, comm) for a in (force, own)]
    return float(np.sqrt((sizes[0] / sizes[1]).max()))
