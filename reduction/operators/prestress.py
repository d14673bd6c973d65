"""The centrifugal field of a body that spins at unit speed."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from solidwhirl.reduction.operators import compat, forms
from solidwhirl.reduction.operators.dofs import Unknowns, body_unknowns, motion_vectors
from solidwhirl.reduction.operators.held import HeldBody
from solidwhirl.reduction.operators.kinematics import Kinematics
from solidwhirl.reduction.operators.solver_choice import block_places, prepared_solver
from solidwhirl.reduction.solvers.vectors import apply, inner
from solidwhirl.rotordyn.core.arrays import FloatArray, Matrix

# Nearer to the axis than this part of the radius a mesh without symmetry shows its own unevenness.
_UNEVEN = 0.05


def centrifugal_displacement(
    space: Any,
    kin: Kinematics,
    matter: forms.Medium,
    dx: Any,
    stiffness: Any,
    component_mass: Any = None,
    *,
    solver: str = "direct",
    held: HeldBody | None = None,
) -> tuple[Any, float]:
    """Displacement of the free body under its own centrifugal load at 1 rad/s.

    The load of a body of revolution is in equilibrium; the rigid motions are held in a statically
    determinate way, so that no reaction arises. Rigid interface couplings are not applied: the
    stress they would carry is not seen by the geometric stiffness.

    `kin`: kinematics of order 0 (meridian), of index 0 (sector) or of the whole solid. `stiffness`:
    K of all of u, without interface couplings; that of a sector is destroyed. `component_mass`: M
    of one component (solid), for a mesh without symmetry: what is left of the load's resultants
    there is taken up by the inertia of a rigid motion. None: nothing is left. `held`: the factor of
    the held solid, with which nothing else is factorised where that converges. Returns u0, hoop:
    displacement (Function) [m/(rad/s)²] and the largest hoop strain u_r/r [1/(rad/s)²].
    """
    v = ufl.TestFunction(space)
    load = compat.assembled_vector(compat.compiled(forms.centrifugal_form(kin, matter, v, dx)))
    if kin.dimension == 3:
        nodes, masses = forms.at_nodes(space, kin, matter)
        out = space.tabulate_dof_coordinates()[nodes, :2]
        np.add.at(load.reshape(-1, 3)[:, :2], nodes, masses[:, None] * out)
    field = free_displacement(space, kin, stiffness, load, component_mass, solver=solver, held=held)
    return field, _hoop_strain(space, kin, field, 1e-6 if component_mass is None else _UNEVEN)


def free_displacement(
    space: Any,
    kin: Kinematics,
    stiffness: Any,
    load: FloatArray,
    component_mass: Any = None,
    *,
    solver: str = "direct",
    held: HeldBody | None = None,
) -> Any:
    """Displacement (Function) of the free body under a load (u,) in equilibrium.

    The other arguments are those of `centrifugal_displacement`.
    """
    unknowns = body_unknowns(space, kin, {}, [])
    values = motion_vectors(space, kin, 0.0)
    motions = np.column_stack([unknowns.of_motion(kin, c, v) for c, v in values.items()])
    force = load[:, None]
    if component_mass is not None:
        force = _balanced(force, motions, component_mass, space.mesh.comm)
    force = unknowns.loads(force)
    moved = None if held is None else held.released(stiffness, force)
    if moved is None:
        # of the whole solid the stiffness is the caller's own
        small = stiffness if unknowns.real is None else unknowns.folded(stiffness)
        moved = _pinned_displacement(space, kin, unknowns, small, force, motions, solver)
        if unknowns.real is not None:
            small.destroy()
    moved = moved - _rigid_part(motions, moved, space.mesh.comm)
    field = fem.Function(space)
    whole = unknowns.displacement(moved)
    compat.owned_values(field)[:] = whole.real[:, 0]
    field.x.scatter_forward()
    unknowns.destroy()
    return field


def _pinned_displacement(
    space: Any,
    kin: Kinematics,
    unknowns: Unknowns,
    stiffness: Any,
    force: Matrix,
    motions: Matrix,
    solver: str,
) -> Matrix:
    """Displacement under a load in equilibrium, by a solver of its own."""
    pins = determinate_pins(motions, space.mesh.comm)
    factor = prepared_solver(
        stiffness,
        stiffness,
        pins,
        lambda: block_places(space, kin, unknowns, {}),
        choice=solver,
        free=pins[:, :0],
        momentum=pins[:, :0],
    )
    moved = factor.solve(force, None)[: len(motions)]
    # Kσ and S cancel in rigid motion as well as the stress is in equilibrium with the load
    rest = force - apply(stiffness, moved)
    moved = moved + factor.solve(rest, None)[: len(motions)]
    factor.destroy()
    return np.asarray(moved)


def _balanced(force: FloatArray, motions: FloatArray, component_mass: Any, comm: Any) -> FloatArray:
    """Load without resultants: the inertia of the rigid motions that it would cause is added."""
    inertia = np.empty_like(motions)
    for i in range(3):
        inertia[i::3] = apply(component_mass, np.ascontiguousarray(motions[i::3]))
    caused = np.linalg.solve(inner(motions, inertia, comm), inner(motions, force, comm))
    return np.asarray(force - inertia @ caused)


def determinate_pins(motions: FloatArray, comm: Any) -> FloatArray:
    """Unit rows of as many unknowns as there are rigid motions, which hold all of them."""
    length = np.sqrt(np.diag(inner(motions, motions, comm)))
    left = motions / length
    rows = np.zeros(motions.shape)
    for j in range(motions.shape[1]):
        # the unknown that moves most in what the pins so far leave free (QR with pivoting)
        size = np.einsum("ij,ij->i", left, left)
        k = int(size.argmax()) if len(size) else 0
        largest, owner = comm.allreduce((size.max(initial=-1.0), -comm.rank), op=MPI.MAX)
        own = -owner == comm.rank
        direction = comm.bcast(left[k] / np.sqrt(largest) if own else None, root=-owner)
        left -= np.outer(left @ direction, direction)
        if own:
            rows[k, j] = 1.0
    return rows


def _rigid_part(motions: FloatArray, moved: FloatArray, comm: Any) -> FloatArray:
    """Rigid motion nearest to a displacement: the pins move the body as a whole."""
    fit = np.linalg.solve(inner(motions, motions, comm), inner(motions, moved, comm))
    return np.asarray(motions @ fit)


def _hoop_strain(space: Any, kin: Kinematics, field: Any, near: float) -> float:
    """Largest u_r / r over the nodes off the axis, by more than a part of the largest radius."""
    x = space.tabulate_dof_coordinates()
    values, comm = field.x.array.reshape(-1, 3)[: len(x)], space.mesh.comm
    if kin.dimension == 3:
        radius = np.hypot(x[:, 0], x[:, 1])
        radial = values[:, 0] * x[:, 0] + values[:, 1] * x[:, 1]
        off = radius > near * _largest(radius, comm)
        strain = radial[off] / radius[off] ** 2
    else:
        radius = x[:, 1]
        off = radius > near * _largest(radius, comm)
        strain = values[off, 0] / radius[off]
    return _largest(np.abs(strain), comm)


def _largest(values: FloatArray, comm: Any) -> float:
    """Largest of the values of all ranks, 0 without any."""
    return float(comm.allreduce(float(values.max(initial=0.0)), op=MPI.MAX))
