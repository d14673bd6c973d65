"""The reduction of one body, from mesh to superelement."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solidwhirl.geometry import Body, MassProperties
from solidwhirl.meshing import Mesh
from solidwhirl.reduction.craig_bampton import Basis, orthogonality_error, reduction_basis
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.indicators import ElementIndicators
from solidwhirl.reduction.kinematics import COMPONENTS
from solidwhirl.reduction.omitted import FinerSpace, Omitted, mesh_energy, truncation_energy
from solidwhirl.reduction.operators import BodyOperators, OperatorEffects, build_operators
from solidwhirl.reduction.superelements import (
    ReducedBlock,
    build_superelement,
    joined_order,
    lateral_free_frequencies,
    mesh_mass_properties,
    reduce_block,
)
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
_AXIAL = ("uz", "rz")


@dataclass(frozen=True, kw_only=True)
class ReductionRequest:
    """What a body's superelement has to hold.

    Attributes
    ----------
    level
        "harmonic" or "solid".
    orders
        Circumferential orders: 1 lateral, 0 axial and torsional (solid: which modes are kept;
        harmonic: which problems are solved; others than 0 and 1 load no interface).
    components
        Interface coordinates, of ux, uy, uz, rx, ry, rz.
    interface_components
        Interfaces that carry fewer of them, by name; each costs a constraint mode.
    degree
        Polynomial degree of the displacement.
    modes
        Fixed-interface modes per order, pairs counted once.
    maximum_speed_rad_s
        Largest speed of this body.
    gyroscopic, centrifugal
        Effects that are assembled.
    speeds_between_rad_s
        Speeds between rest and the top whose modes the basis takes in as well.
    estimates
        Errors to estimate: "mode_truncation", and on the harmonic level "mesh", which compares
        with elements one order higher.
    """

    level: str
    orders: tuple[int, ...]
    components: tuple[str, ...]
    degree: int
    modes: int
    maximum_speed_rad_s: float
    gyroscopic: bool
    centrifugal: bool
    interface_components: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    speeds_between_rad_s: tuple[float, ...] = ()
    estimates: tuple[str, ...] = ()


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
    seconds: Mapping[str, float]
    indicators: tuple[ElementIndicators, ...] = ()
    checks: tuple[Invariant, ...] = ()


def reduce_body(
    body: Body,
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
    points = comm.bcast(_recovery_points(mesh) if comm.rank == 0 else None, root=0)
    blocks, omitted, finer, checks, dofs = [], [], [], [], 0
    assembled, solved, errors = {}, {}, [0.0]
    seconds = {"operators": 0.0, "basis": 0.0, "error_estimate": 0.0, "checks": 0.0}
    for order in (None,) if request.level == "solid" else request.orders:
        start = time.perf_counter()
        operators = build_operators(
            body,
            mesh,
            comm,
            order=order,
            degree=request.degree,
            effects=_effects(body, request, order),
        )
        middle = time.perf_counter()
        basis, block = _reduce_order(operators, request, points)
        label = "solid" if order is None else f"n={order}"
        assembled[label], solved[label] = operators.assembled, basis.solved
        errors.append(orthogonality_error(operators, basis))
        blocks.append(block)
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
        basis.factor.destroy()
        operators.release()
    properties = _properties(body, operators)
    if operators.rigid_mass is not None:
        checks.append(check_mass(body, properties))
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
    )
    _refuse_dependent_interfaces(element, request)
    element = _with_rigid_disks(element, body, request)
    work = ReductionWork(
        assembled=assembled,
        solved=solved,
        orthogonality_error=max(errors),
        hoop_strain=operators.hoop_strain * request.maximum_speed_rad_s**2,
        seconds=seconds,
        indicators=_indicators(body, tuple(blocks), tuple(finer)),
        checks=tuple(checks),
    )
    return element, work


def _checks(
    operators: BodyOperators,
    basis: Basis,
    orthogonality: float,
    body: Body,
    mesh: Mesh | None,
    request: ReductionRequest,
) -> list[Invariant]:
    """What must hold for the basis of one order, while its factor is at hand."""
    where = body.name if operators.harmonic is None else f"{body.name}, n={operators.harmonic}"
    out = list(verify_order(operators, basis, orthogonality, where))
    if operators.harmonic is not None:
        return [*out, count_held_modes(operators, basis, where)]
    counted = count_solid_modes(
        body,
        mesh,
        operators.comm,
        basis,
        request.orders,
        lambda order: replace(_effects(body, request, order), gyroscopic=False, centrifugal=False),
    )
    return [*out, counted]


def _omitted(
    operators: BodyOperators, basis: Basis, body: Body, request: ReductionRequest
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
    body: Body, blocks: tuple[ReducedBlock, ...], finer: tuple[FinerSpace | None, ...]
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


def _properties(body: Body, operators: BodyOperators) -> MassProperties:
    """Mass properties of the meshed part: the mesh's own where it only approximates the body."""
    if operators.rigid_mass is not None:
        return mesh_mass_properties(operators.rigid_mass)
    return meshed_part_properties(body)


def _refuse_dependent_interfaces(element: Superelement, request: ReductionRequest) -> None:
    """Interfaces whose motions depend on each other leave the body no rigid motion."""
    lateral = [COMPONENTS.index(c) for c in ("ux", "uy", "rx", "ry")]
    if 1 in request.orders and not element.rigid_body_present[lateral].all():
        raise ReductionError(
            f"body {element.name!r} can not move as a rigid one in its superelement: an interface "
            "moves as others make it, such as one that is the union of two others; leave it out"
        )


def _with_rigid_disks(element: Superelement, body: Body, request: ReductionRequest) -> Superelement:
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


def _effects(body: Body, request: ReductionRequest, order: int | None) -> OperatorEffects:
    """Effects of one circumferential order: axial motion and torsion live in order 0."""
    components = {}
    for interface in body.interfaces:
        carried = request.interface_components.get(interface.name, request.components)
        components[interface.name] = tuple(
            c
            for c in carried
            if c in request.components and (order is None or (c in _AXIAL) == (order == 0))
        )
    return OperatorEffects(
        gyroscopic=request.gyroscopic,
        centrifugal=request.centrifugal,
        components=components,
        lateral_only=request.orders == (1,),
    )


def _reduce_order(
    operators: BodyOperators, request: ReductionRequest, points: FloatArray
) -> tuple[Basis, ReducedBlock]:
    basis = reduction_basis(
        operators,
        modes=request.modes,
        maximum_speed_rad_s=request.maximum_speed_rad_s,
        orders=request.orders,
        speeds_between_rad_s=request.speeds_between_rad_s,
    )
    return basis, reduce_block(operators, basis, points)


def _recovery_points(mesh: Mesh | None) -> FloatArray:
    """Vertices of the outline at θ = 0 and at θ = 90°, (m, 3)."""
    assert mesh is not None
    vertices = np.intersect1d(mesh.outline, mesh.cells[:, : mesh.dimension + 1])
    x = mesh.points[vertices]
    if mesh.dimension == 2:
        z, r = x[:, 0], x[:, 1]
    else:
        z, r = x[:, 2], x[:, 0]
    order = np.lexsort((r, z))
    z, r, zero = z[order], r[order], np.zeros(len(z))
    return np.vstack([np.column_stack([r, zero, z]), np.column_stack([zero, r, z])])
