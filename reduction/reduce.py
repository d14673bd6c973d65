"""The reduction of one body, from mesh to superelement."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solidwhirl.geometry import Body, MassProperties
from solidwhirl.meshing import Mesh
from solidwhirl.meshing.user_mesh_records import AnyBody, MeshedBody
from solidwhirl.reduction.craig_bampton import Basis, orthogonality_error
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.indicators import ElementIndicators
from solidwhirl.reduction.kinematics import COMPONENTS
from solidwhirl.reduction.mass_moments import BlockMoments, block_moments
from solidwhirl.reduction.mesh_bodies import (
    MeshMassProperties,
    check_evenness,
    check_mesh_mass,
    count_found_modes,
    mesh_properties,
    shape_of,
    shown_points,
)
from solidwhirl.reduction.omitted import FinerSpace, Omitted, mesh_energy, truncation_energy
from solidwhirl.reduction.operators import BodyOperators, build_operators
from solidwhirl.reduction.pairing import evenness
from solidwhirl.reduction.reduced_order import ReductionRequest, order_effects, reduce_order
from solidwhirl.reduction.solvers import road_of
from solidwhirl.reduction.superelements import (
    ReducedBlock,
    build_superelement,
    joined_order,
    lateral_free_frequencies,
    mesh_mass_properties,
)
from solidwhirl.reduction.surfaces import joined_surface, surface_amplitudes, surface_mesh
from solidwhirl.reduction.verification import (
    check_mass,
    count_held_modes,
    meshed_part_properties,
    verify_order,
)
from solidwhirl.reduction.verification_meridian import count_solid_modes
from solidwhirl.rotordyn.invariants import Invariant
from solidwhirl.rotordyn.superelement import Superelement, attach_rigid_disk

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class ReductionWork:
    """What one reduction did.

    Attributes
    ----------
    assembled, solved
        Matrices and solutions by circumferential order ("solid" for the solid level).
    orthogonality_error
        Largest deviation of the interior modes from M-orthonormality.
    hoop_strain
        Largest hoop strain of the centrifugal field at the top speed (0 if it was not computed).
        The prestress neglects the change of shape, which is of that relative order.
    solver
        "direct" or "iterative": how the systems of the basis were solved.
    seconds
        Wall time of operators, of basis and projection, of the error estimate and of the checks.
    indicators
        Where on the mesh the estimated error arises; empty unless "mesh" was asked for.
    checks
        What must hold for the basis, and whether it does.
    """

    assembled: Mapping[str, tuple[str, ...]]
    solved: Mapping[str, tuple[str, ...]]
    orthogonality_error: float
    hoop_strain: float
    solver: str
    seconds: Mapping[str, float]
    indicators: tuple[ElementIndicators, ...] = ()
    checks: tuple[Invariant, ...] = ()


def reduce_body(
    body: AnyBody,
    mesh: Mesh | None,
    comm: Any,
    request: ReductionRequest,
    provenance: Mapping[str, Any],
) -> tuple[Superelement, ReductionWork]:
    """Reduce a meshed body to its superelement.

    Parameters
    ----------
    body
        The body.
    mesh
        Meridian mesh (harmonic) or solid mesh, needed on rank 0 of `comm` only.
    comm
        Communicator; all its ranks get the same superelement.
    request
        What to compute.
    provenance
        Stored with the superelement.

    Returns
    -------
    Superelement, ReductionWork

    Raises
    ------
    ReductionError
        See `reduction_basis` and `couple`; or the interfaces' motions depend on each other.
    """
    points = comm.bcast(_recovery_points(body, mesh) if comm.rank == 0 else None, root=0)
    outline = comm.bcast(surface_mesh(mesh) if mesh is not None else None, root=0)
    blocks, moved, omitted, finer, checks, dofs = [], [], [], [], [], 0
    assembled, solved, errors = {}, {}, [0.0]
    moments: list[BlockMoments] = []
    seconds = {"operators": 0.0, "basis": 0.0, "error_estimate": 0.0, "checks": 0.0}
    for order in (None,) if request.level == "solid" else request.orders:
        start = time.perf_counter()
        operators = build_operators(
            body,
            mesh,
            comm,
            order=order,
            degree=request.degree,
            effects=order_effects(body, request, order),
        )
        middle = time.perf_counter()
        basis, block = reduce_order(operators, request, points)
        label = "solid" if order is None else f"n={order}"
        assembled[label], solved[label] = operators.assembled, basis.solved
        errors.append(orthogonality_error(operators, basis))
        blocks.append(block)
        moved.append(surface_amplitudes(operators, basis, outline))
        dofs += operators.full_dofs
        reduced = time.perf_counter()
        parts, fine, did = _omitted(operators, basis, body, request)
        omitted.append(parts)
        finer.append(fine)
        solved[label] += did
        estimated = time.perf_counter()
        checks += _checks(operators, basis, errors[-1], body, mesh, request)
        seconds["operators"] += middle - start
        seconds["basis"] += reduced - middle
        seconds["error_estimate"] += estimated - reduced
        seconds["checks"] += time.perf_counter() - estimated
        solver = road_of(basis.factor)
        basis.factor.destroy()
        moments.append(_moments(operators, basis, block, moments))
        operators.release()
    properties = _properties(body, operators)
    if operators.rigid_mass is not None:
        checks.append(_check_mass(body, properties))
    element = build_superelement(
        body,
        tuple(blocks),
        level=request.level,
        harmonics=() if request.level == "solid" else request.orders,
        full_dofs=dofs,
        maximum_speed_rad_s=request.maximum_speed_rad_s,
        properties=properties,
        points_m=points,
        provenance=provenance,
        omitted=tuple(omitted),
        moments=tuple(moments),
    )
    surface = joined_surface(body, outline, element.harmonics, tuple(blocks), tuple(moved))
    element = replace(element, surface=surface)
    _refuse_dependent_interfaces(element, request)
    element = _with_rigid_disks(element, body, request)
    work = ReductionWork(
        assembled=assembled,
        solved=solved,
        orthogonality_error=max(errors),
        hoop_strain=operators.hoop_strain * request.maximum_speed_rad_s**2,
        solver=solver,
        seconds=seconds,
        indicators=_indicators(body, tuple(blocks), tuple(finer)),
        checks=tuple(checks),
    )
    return element, work


def _check_mass(body: AnyBody, properties: MassProperties | MeshMassProperties) -> Invariant:
    """Mass of a solid mesh against what is known of the body."""
    if isinstance(body, MeshedBody) and isinstance(properties, MeshMassProperties):
        return check_mesh_mass(body, properties)
    assert isinstance(body, Body)
    assert isinstance(properties, MassProperties)
    return check_mass(body, properties)


def _moments(
    operators: BodyOperators, basis: Basis, block: ReducedBlock, earlier: list[BlockMoments]
) -> BlockMoments:
    """Mass moments of one order in the coordinates of its block."""
    return block_moments(operators, basis, block.signs, block.order, block.generator, earlier)


def _checks(
    operators: BodyOperators,
    basis: Basis,
    orthogonality: float,
    body: AnyBody,
    mesh: Mesh | None,
    request: ReductionRequest,
) -> list[Invariant]:
    """What must hold for the basis of one order, while its factor is at hand."""
    where = body.name if operators.harmonic is None else f"{body.name}, n={operators.harmonic}"
    out = list(verify_order(operators, basis, orthogonality, where))
    if operators.harmonic is not None:
        return [*out, count_held_modes(operators, basis, where)]
    if isinstance(body, MeshedBody):
        if basis.generator is not None:
            out.append(check_evenness(where, evenness(operators, basis)))
        return [*out, count_found_modes(operators, basis, where)]
    counted = count_solid_modes(
        body,
        mesh,
        operators.comm,
        basis,
        request.orders,
        lambda order: replace(
            order_effects(body, request, order), gyroscopic=False, centrifugal=False
        ),
    )
    return [*out, counted]


def _omitted(
    operators: BodyOperators, basis: Basis, body: AnyBody, request: ReductionRequest
) -> tuple[tuple[Omitted, ...], FinerSpace | None, tuple[str, ...]]:
    """What one order leaves out, the finer space it was measured in, and what was solved."""
    if not request.estimates:
        return (), None, ()
    truncation, answers = truncation_energy(operators, basis)
    columns = basis.vectors.shape[1]
    did: tuple[str, ...] = (f"error estimate of the reduction: {3 * columns} solutions",)
    if "mesh" not in request.estimates:
        return (truncation,), None, did
    mesh, finer = mesh_energy(operators, basis, answers, body.interfaces)
    did += (f"error estimate of the mesh: factorisation one order higher, {3 * columns} solutions",)
    return (truncation, mesh), finer, did


def _indicators(
    body: AnyBody, blocks: tuple[ReducedBlock, ...], finer: tuple[FinerSpace | None, ...]
) -> tuple[ElementIndicators, ...]:
    """Where on the mesh the estimated error arises, one record per circumferential order."""
    flat = [c for b in blocks for c in b.coordinates]
    order = joined_order(body, flat)
    starts = np.cumsum([0, *(len(b.coordinates) for b in blocks)])
    place = np.argsort(order)
    return tuple(
        ElementIndicators(
            finer=fine,
            rows=place[start : start + len(block.coordinates)],
            signs=block.signs,
            order=block.order,
        )
        for block, fine, start in zip(blocks, finer, starts[:-1], strict=True)
        if fine is not None
    )


def _properties(body: AnyBody, operators: BodyOperators) -> MassProperties | MeshMassProperties:
    """Mass properties of the meshed part: the mesh's own where it only approximates the body."""
    if isinstance(body, MeshedBody):
        assert operators.rigid_mass is not None
        return mesh_properties(operators.rigid_mass, shape_of(body))
    if operators.rigid_mass is not None:
        return mesh_mass_properties(operators.rigid_mass)
    return meshed_part_properties(body)


def _refuse_dependent_interfaces(element: Superelement, request: ReductionRequest) -> None:
    """Interfaces whose motions depend on each other leave the body no rigid motion."""
    lateral = [COMPONENTS.index(c) for c in ("ux", "uy", "rx", "ry")]
    lateral = lateral if request.orders else list(range(6))
    if (1 in request.orders or not request.orders) and not element.rigid_body_present[
        lateral
    ].all():
        raise ReductionError(
            f"body {element.name!r} can not move as a rigid one in its superelement: an interface "
            "moves as others make it, such as one that is the union of two others; leave it out"
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
    return replace(element, free_frequencies_hz=lateral_free_frequencies(element)[:10])


def _recovery_points(body: AnyBody, mesh: Mesh | None) -> FloatArray:
    """Vertices of the outline at θ = 0 and at θ = 90°, or of a given mesh, (m, 3)."""
    assert mesh is not None
    shown = shown_points(body, mesh)
    if shown is not None:
        return shown
    vertices = np.intersect1d(mesh.outline, mesh.cells[:, : mesh.dimension + 1])
    x = mesh.points[vertices]
    if mesh.dimension == 2:
        z, r = x[:, 0], x[:, 1]
    else:
        z, r = x[:, 2], x[:, 0]
    order = np.lexsort((r, z))
    z, r, zero = z[order], r[order], np.zeros(len(z))
    return np.vstack([np.column_stack([r, zero, z]), np.column_stack([zero, r, z])])
