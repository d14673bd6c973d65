"""A solid at rest with its interfaces held: one factor for the prestress and for the basis.

The displacement of the free body follows from it in two steps. Interfaces that only hold means of
their surface are let go by their constraint modes. Surfaces that are rigid stay so at first: what
their own strain and the rest of the body do to each other dies out in the neighbourhood
(Saint-Venant), so that alternating solutions of the whole and of the neighbourhood converge in a
few steps (Schwarz's method).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse
from mpi4py import MPI
from petsc4py import PETSc

from solidwhirl.reduction.errors import FactorMemoryError
from solidwhirl.reduction.operators.coupling import Coupling
from solidwhirl.reduction.operators.dofs import Unknowns
from solidwhirl.reduction.operators.solver_choice import expected_factor
from solidwhirl.reduction.solvers.constrained import ConstrainedFactor, factorise
from solidwhirl.reduction.solvers.vectors import (
    apply,
    inner,
    project,
    squares,
    symmetric,
    uncancelled,
)
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray, Matrix

# Layers of elements about the rigid surfaces that are solved for again: so many at least, and more
# up to a part of the body that costs little; and the largest part of it that they may be.
_LAYERS = 4
_CHEAP_PART, _LARGEST_PART = 0.1, 0.5
# Change of the displacement, relative, after which it is not worked out again. Its error is that
# times the rate of convergence, 1e-3 or less of solids.
_CHANGE = 1e-9
_STEPS = 8


@dataclass(frozen=True, kw_only=True, eq=False)
class HeldBody:
    """A body at rest whose interfaces hold all rigid motions."""

    factor: ConstrainedFactor  #: Of K under the rows of the interfaces and anchors
    stiffness: Any  #: K in the unknowns û, PETSc
    unknowns: Unknowns
    #: (local û, b + a) displacement for a unit value of every row, the others held at zero
    constraint: FloatArray
    rigid_count: int  #: Rigid motions of the body

    def released(self, stiffness: Any, force: FloatArray) -> FloatArray | None:
        """Displacement of the free body without interfaces, up to rigid motions.

        `stiffness`: K of all of u, PETSc. `force`: (local u, 1) load in equilibrium. Returns (local
        u, 1); None where the rigid surfaces are too large a part of the body, or it is too thin.
        """
        around = self._around_rigid_surfaces(stiffness)
        if around is None:
            return None
        local = _part_of(stiffness, around) if len(around) else None
        comm, flexible = self.stiffness.comm.tompi4py(), self._flexible_motions()
        moved, settled = np.zeros_like(force), False
        for _ in range(_STEPS):
            load = self.unknowns.loads(force - apply(stiffness, moved))
            step = self.factor.solve(load, None)[: len(load)]
            step = self.unknowns.displacement(step + flexible @ inner(flexible, load, comm))
            moved = moved + step
            settled = _largest(step, comm) <= _CHANGE * _largest(moved, comm)
            if settled:
                break
            if local is not None:
                left = force - apply(stiffness, moved)
                moved[around] += local.solve(left[around], None)
        if local is not None:
            local.destroy()
        return np.asarray(moved) if settled else None

    def _flexible_motions(self) -> FloatArray:
        """Motions of the interfaces that strain the body, orthonormal in its energy, (local û, f).

        They answer loads in equilibrium: F Fᵀ f.
        """
        comm = self.stiffness.comm.tompi4py()
        length = np.sqrt(uncancelled(self.stiffness, self.constraint, comm))
        work = symmetric(project(self.stiffness, self.constraint / length, comm))
        s, q = np.linalg.eigh(work)
        strained = slice(self.rigid_count, None)
        combined = q[:, strained] / np.sqrt(s[strained]) / length[:, None]
        return np.asarray(self.constraint @ combined)

    def _around_rigid_surfaces(self, stiffness: Any) -> IntArray | None:
        """Displacements in the layers of elements about rigid surfaces; None: too many."""
        kept = self.unknowns.kept
        comm, (local, size) = stiffness.comm, stiffness.getSizes()[0]
        near = np.ones(local, dtype=bool)
        near[kept] = False
        if self.unknowns.real is None:
            return np.flatnonzero(near)
        if comm.size > 1:  # layers are found on one process
            return None
        indptr, columns, values = stiffness.getValuesCSR()
        links = scipy.sparse.csr_matrix((values, columns, indptr))
        outermost, layers = np.flatnonzero(near), 0
        while len(outermost) and (layers < _LAYERS or near.sum() < _CHEAP_PART * size):
            reached = np.unique(links[outermost].indices)
            outermost, layers = reached[~near[reached]], layers + 1
            near[outermost] = True
            if near.sum() > _LARGEST_PART * size:
                return None
        return np.flatnonzero(near)


def held_body(stiffness: Any, mass: Any, coupling: Coupling, choice: str) -> HeldBody | None:
    """Factorise a solid at rest with its interfaces held.

    `stiffness`, `mass`: K and M in the unknowns û, PETSc. `choice`: how systems are solved, see
    `solver_choice`. None: interfaces do not hold all rigid motions, or no factorisation is wanted
    or fits.
    """
    rows, comm = coupling.held, stiffness.comm.tompi4py()
    if unrestrained(mass, coupling).shape[1] or choice == "iterative":
        return None
    if choice == "auto" and not expected_factor(stiffness.getSize()[0], comm).fits:
        return None
    try:
        factor = factorise(stiffness, rows)
    except FactorMemoryError:
        if choice == "direct":
            raise
        return None
    return HeldBody(
        factor=factor,
        stiffness=stiffness,
        unknowns=coupling.unknowns,
        constraint=factor.solve(None, np.eye(rows.shape[1]))[: len(rows)],
        rigid_count=len(coupling.rigid_motions),
    )


def unrestrained(mass: Any, coupling: Coupling) -> Matrix:
    """Rigid motions (local û, f) that the interfaces do not hold, M-orthonormal."""
    rows = coupling.held
    if not coupling.rigid_motions:
        return np.empty((len(rows), 0), dtype=rows.dtype)
    motions: Matrix = np.column_stack(list(coupling.rigid_motions.values()))
    comm = mass.comm.tompi4py()
    gram = project(mass, motions, comm)
    motions = motions @ np.linalg.inv(np.linalg.cholesky(gram)).conj().T
    if not rows.shape[1]:
        return motions
    length = np.sqrt(squares(rows, rows, comm))
    held = inner(rows / length, motions, comm)
    _, s, vt = np.linalg.svd(held)
    rank = int(np.sum(s > 1e-9 * s.max()))
    return np.asarray(motions @ vt[rank:].conj().T)


def _part_of(matrix: Any, places: IntArray) -> ConstrainedFactor:
    """Factor of the rows and columns of some unknowns, all others held; one process."""
    chosen = PETSc.IS().createGeneral(places.astype(PETSc.IntType), comm=matrix.comm)
    part = matrix.createSubMatrix(chosen, chosen)
    factor = factorise(part, np.empty((len(places), 0)))
    for made in (part, chosen):
        made.destroy()
    return factor


def _largest(block: FloatArray, comm: Any) -> float:
    return float(comm.allreduce(float(np.abs(block).max(initial=0.0)), op=MPI.MAX))
