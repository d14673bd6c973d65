"""The reduction of one body, from mesh to superelement."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from solidwhirl.core.reduction_work import ReductionWork
from solidwhirl.meshing import Mesh
from solidwhirl.meshing.imported.records import AnyBody, MeshedBody, is_asymmetric
from solidwhirl.reduction.basis.craig_bampton import Basis, orthogonality_error
from solidwhirl.reduction.basis.pairing import averaging_change
from solidwhirl.reduction.basis.reduced_block import ReducedBlock, joined_rows
from solidwhirl.reduction.body import superelements, surfaces, verification
from solidwhirl.reduction.body.mass_moments import block_moments
from solidwhirl.reduction.body.reduced_order import reduce_order
from solidwhirl.reduction.body.request import (
    ReductionRequest,
    order_operators,
    shape_of,
    solved_orders,
)
from solidwhirl.reduction.body.superelements import SolvedOrder
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators.kinematics import COMPONENTS
from solidwhirl.reduction.operators.matrices import BodyOperators
from solidwhirl.reduction.operators.solver_choice import solver_name
from solidwhirl.reduction.residuals import residual_energy as residuals
from solidwhirl.reduction.residuals.indicators import ElementIndicators
from solidwhirl.reduction.solvers.memory import return_free_memory
from solidwhirl.rotordyn.core.arrays import FloatArray, Matrix
from solidwhirl.rotordyn.superelement.invariants import Invariant
from solidwhirl.rotordyn.superelement.record import Superelement
from solidwhirl.rotordyn.superelement.rigid_body import MassProperties, attach_rigid_disk


def reduce_body(
    body: AnyBody,
    mesh: Mesh | None,
    comm: Any,
    request: ReductionRequest,
    provenance: Mapping[str, Any],
) -> tuple[Superelement, ReductionWork]:
    """Reduce a meshed body to its superelement.

    `mesh`: meridian mesh (harmonic) or solid mesh, needed on rank 0 of `comm` only. `comm`:
    communicator; all its ranks get the same superelement. Raises ReductionError: see
    `reduction_basis` and `couple`; or the interfaces' motions depend on each other.
    """
    points = comm.bcast(_recovery_points(body, mesh) if comm.rank == 0 else None, root=0)
    outlines = comm.bcast(surfaces.surface_meshes(mesh) if mesh is not None else None, root=0)
    shown = (points, np.concatenate([outline.points_m for outline in outlines]))
    orders: list[SolvedOrder] = []
    for order in solved_orders(body, request):
        start = time.perf_counter()
        operators = order_operators(body, mesh, comm, request, order)
        assembling = time.perf_counter() - start
        try:
            found = _solved(operators, body, request, shown, orders)
        finally:
            operators.release()
        orders.append(replace(found, seconds={"operators": assembling, **found.seconds}))
    properties = _properties(body, orders[-1].rigid_mass)
    blocks = [order.block for order in orders]
    element = superelements.build_superelement(
        body, orders, request, properties, points, provenance
    )
    amplitudes = [order.surface for order in orders]
    surface = surfaces.joined_surface(body, outlines, element.harmonics, blocks, amplitudes)
    copies = surface.copies
    count = None if copies is None else copies.count
    element = replace(element, surface=surface, cyclic_sectors=count)
    _refuse_dependent_interfaces(element, request)
    element = _with_rigid_disks(element, body, request)
    checks = [check for order in orders for check in order.checks]
    if orders[-1].rigid_mass is not None:
        if isinstance(body, MeshedBody):
            checks.append(verification.check_mesh_mass(body, properties))
        else:
            checks.append(verification.check_mass(body, properties))
    indicators = _indicators(body, blocks, [order.finer for order in orders])
    work = ReductionWork(
        assembled={order.label: order.assembled for order in orders},
        solved={order.label: order.solved for order in orders},
        orthogonality_error=max(order.orthogonality_error for order in orders),
        hoop_strain=orders[-1].hoop_strain * request.maximum_speed_rad_s**2,
        solver=orders[-1].solver,
        seconds={
            name: sum(order.seconds[name] for order in orders)
            for name in ("operators", "basis", "error_estimate", "checks")
        },
        indicators=(lambda: indicators) if indicators else None,
        checks=tuple(checks),
        joints=orders[-1].joints,
    )
    return element, work


def _solved(
    operators: BodyOperators,
    body: AnyBody,
    request: ReductionRequest,
    shown: tuple[FloatArray, FloatArray],
    earlier: Sequence[SolvedOrder],
) -> SolvedOrder:
    """Reduce one order; `shown` are the recovery points and those of the surface."""
    points, on_surface = shown
    start = time.perf_counter()
    basis, block = reduce_order(operators, request, points)
    error = orthogonality_error(operators, basis)
    surface = surfaces.nodal_amplitudes(operators, basis, on_surface)
    reduced = time.perf_counter()
    left_out = residuals.truncation_energy(operators, basis) if request.estimates else None
    truncated = time.perf_counter()
    checks = order_checks(operators, basis, error, body, request)
    checked = time.perf_counter()
    solver = solver_name(basis.factor)
    basis.factor.destroy()  # before the finer space, which takes as much
    return_free_memory()
    omitted, finer, did = _omitted(operators, basis, left_out, body, request)
    estimated = time.perf_counter()
    before = [order.moments for order in earlier]
    return SolvedOrder(
        label="solid" if operators.harmonic is None else f"n={operators.harmonic}",
        block=block,
        surface=surface,
        omitted=omitted,
        finer=finer,
        moments=block_moments(operators, basis, block, before),
        checks=tuple(checks),
        full_dofs=operators.full_dofs,
        rigid_mass=operators.rigid_mass,
        hoop_strain=operators.hoop_strain,
        joints=operators.ingredients.joints.states,
        orthogonality_error=error,
        assembled=operators.assembled,
        solved=(*basis.solved, *did),
        solver=solver,
        seconds={
            "basis": reduced - start,
            "error_estimate": estimated - checked + truncated - reduced,
            "checks": checked - truncated,
        },
    )


def order_checks(
    operators: BodyOperators,
    basis: Basis,
    orthogonality: float,
    body: AnyBody,
    request: ReductionRequest,
) -> list[Invariant]:
    """What must hold for the basis of one order, while its factor is at hand."""
    where = body.name if operators.harmonic is None else f"{body.name}, n={operators.harmonic}"
    out = list(verification.verify_order(operators, basis, orthogonality, where))
    if operators.harmonic is not None:
        return [*out, verification.count_fixed_modes(operators, basis, where)]
    if basis.generator is not None:
        change = averaging_change(operators, basis, request.maximum_speed_rad_s)
        out.append(verification.check_evenness(where, change, request.accuracy))
    return [*out, verification.count_found_modes(operators, basis, where)]


def _omitted(
    operators: BodyOperators,
    basis: Basis,
    left_out: tuple[residuals.Omitted, Matrix] | None,
    body: AnyBody,
    request: ReductionRequest,
) -> tuple[tuple[residuals.Omitted, ...], residuals.FinerSpace | None, tuple[str, ...]]:
    """What one order leaves out, the finer space it was measured in, and what was solved.

    `left_out`: modes and answers of `truncation_energy`; None without estimates.
    """
    if left_out is None:
        return (), None, ()
    truncation, answers = left_out
    columns = basis.vectors.shape[1]
    did: tuple[str, ...] = (f"error estimate of the reduction: {3 * columns} solutions",)
    parts, finer = [truncation], None
    # which cells meet at an edge is looked for on one process
    if "mesh" in request.estimates and operators.comm.size == 1:
        mesh, finer = residuals.mesh_energy(operators, basis, answers, body.interfaces)
        parts.append(mesh)
        did += (
            f"error estimate of the mesh: factorisation one order higher, {3 * columns} solutions",
        )
    lifted = residuals.lift_energy(operators, basis, request.maximum_speed_rad_s)
    if lifted is not None:
        parts.append(lifted)
        did += (f"error estimate of lifting faces: factorisation, {columns} solutions",)
    joined = operators.ingredients.kinematics.joined
    if joined is not None and not request.neighbours:
        parts.append(residuals.joint_energy(operators, basis, answers, body.interfaces))
        did += (f"error estimate of the joints: {3 * columns} solutions with the next orders",)
    return tuple(parts), finer, did


def _indicators(
    body: AnyBody, blocks: Sequence[ReducedBlock], finer: Sequence[residuals.FinerSpace | None]
) -> tuple[ElementIndicators, ...]:
    """Where on the mesh the estimated error arises, one record per circumferential order."""
    return tuple(
        ElementIndicators(finer=fine, rows=rows, signs=block.signs, order=block.order)
        for block, fine, rows in zip(blocks, finer, joined_rows(body, blocks), strict=True)
        if fine is not None
    )


def _properties(body: AnyBody, rigid_mass: FloatArray | None) -> MassProperties:
    """Mass properties of the meshed part: the mesh's own where it only approximates the body."""
    if isinstance(body, MeshedBody) or is_asymmetric(body):
        assert rigid_mass is not None
        return superelements.mesh_properties(rigid_mass, shape_of(body))
    if rigid_mass is not None:
        return superelements.mesh_mass_properties(rigid_mass)
    return verification.meshed_part_properties(body)


def _refuse_dependent_interfaces(element: Superelement, request: ReductionRequest) -> None:
    """Interfaces whose motions depend on each other leave the body no rigid motion."""
    lateral = [COMPONENTS.index(c) for c in ("ux", "uy", "rx", "ry")]
    lateral = lateral if request.orders else list(range(6))
    if (1 in request.orders or not request.orders) and not element.rigid_body_present[
        lateral
    ].all():
        raise ReductionError(
            f"body {element.name!r} can not move as a rigid one in its superelement: an interface "
            "moves as others make it, such as one that is the union of two others (leave it out), "
            "or Poisson's ratio is so near to 0.5 that rounding is left of its stiffness"
        )


def _with_rigid_disks(
    element: Superelement, body: AnyBody, request: ReductionRequest
) -> Superelement:
    """Add the lumped disks; the free frequencies are those of the body with them."""
    if not body.rigid_disks:
        return element
    for disk in body.rigid_disks:
        element = attach_rigid_disk(
            element,
            disk.interface,
            name=disk.name,
            mass_kg=disk.mass_kg,
            polar_kg_m2=disk.polar_inertia_kg_m2,
            diametral_kg_m2=disk.diametral_inertia_kg_m2,
            offset_m=disk.offset_m,
        )
    if not request.gyroscopic:  # the disks brought theirs along
        element = replace(element, gyroscopic=np.zeros_like(element.gyroscopic))
    return superelements.with_free_frequencies(element)


def _recovery_points(body: AnyBody, mesh: Mesh | None) -> FloatArray:
    """Vertices of the outline at θ = 0 and in the sector a quarter turn away, (m, 3)."""
    assert mesh is not None
    if mesh.dimension == 3 and mesh.sector is None:
        return np.array(mesh.points[mesh.outline])
    vertices = np.intersect1d(mesh.outline, mesh.cells[:, : mesh.dimension + 1])
    x = mesh.points[vertices]
    if mesh.dimension == 2:
        z, r = x[:, 0], x[:, 1]
    else:
        z, r = x[:, 2], x[:, 0]
    order = np.lexsort((r, z))
    if mesh.sector is not None:
        angle = 2.0 * np.pi * surfaces.quarter_copy(mesh.sector) / mesh.sector.count
        c, s = np.cos(angle), np.sin(angle)
        turned = x @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        return np.vstack([x[order], turned[order]])
    z, r, zero = z[order], r[order], np.zeros(len(z))
    return np.vstack([np.column_stack([r, zero, z]), np.column_stack([zero, r, z])])
