"""Cyclic indices of one body: small matrices of its nodal-diameter modes, and their shapes.

Of a body of revolution an index is a circumferential order on the meridian, of a sector one of its
cyclic indices. Interfaces are held or free as the request says; what is not held carries nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from solidwhirl.meshing import Mesh
from solidwhirl.meshing.imported.records import AnyBody
from solidwhirl.reduction.basis.craig_bampton import Basis, reduction_basis
from solidwhirl.reduction.body.blade_roots import blade_roots, meshed_blades
from solidwhirl.reduction.body.reduced_order import with_spin_answers
from solidwhirl.reduction.body.request import ReductionRequest, order_operators
from solidwhirl.reduction.body.surfaces import SurfaceMesh, nodal_amplitudes, surface_mesh
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators.kinematics import COMPONENTS
from solidwhirl.reduction.operators.matrices import BodyOperators
from solidwhirl.reduction.residuals import residual_energy as residuals
from solidwhirl.reduction.solvers.vectors import Combination, project
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray, Matrix
from solidwhirl.rotordyn.nodal_diameters import (
    BladeRoot,
    CyclicBody,
    CyclicMatrices,
    OmittedEnergy,
    rotating_matrices,
)

# Relative error of a frequency from which on answers to the loads of the spin are in the basis.
_SPIN = 1e-6
# Mirror image in the plane y = 0.
_MIRROR = np.array([1.0, -1.0, 1.0])


@dataclass(frozen=True, kw_only=True)
class CyclicRequest:
    """What is asked of the cyclic indices of a body."""

    level: str
    indices: tuple[int, ...]
    #: Interfaces whose surfaces do not move; all others are free
    held: tuple[str, ...]
    degree: int
    #: Modes of every index in the basis
    modes: int
    maximum_speed_rad_s: float
    #: Errors to estimate, as of `ReductionRequest`
    estimates: tuple[str, ...] = ()
    solver: str = "auto"


@dataclass(frozen=True, kw_only=True, eq=False)
class CyclicShapes:
    """Fields of all indices on the outer surface of what was meshed."""

    #: (p, 2) z, r of a meridian or (p, 3) x, y, z of a whole sector
    points_m: FloatArray
    #: (c, 2) edges or (c, 3) triangles
    cells: IntArray
    #: By index (p, 3, n): Φ of every coordinate along r, θ, z (to be times e^{ihθ}) or x, y, z (of
    #: the copy k, turned by kα, to be times e^{ihkα})
    amplitudes: tuple[Matrix, ...]
    #: By index, those of the blades of a sector that a scene describes
    roots: tuple[tuple[BladeRoot, ...], ...]


def reduce_indices(
    body: AnyBody,
    mesh: Mesh,
    comm: Any,
    request: CyclicRequest,
    begins: Callable[[int], None] = lambda index: None,
) -> tuple[CyclicBody, CyclicShapes]:
    """Reduce the cyclic indices of a body one by one.

    `mesh`: meridian or sector. `comm`: all its ranks must call. `begins`: told every index. Raises
    ReductionError: nothing holds an index that can move as a rigid body; see `reduction_basis`.
    """
    clamped = _clamped(body, request.held)
    outline, blades = surface_mesh(mesh), meshed_blades(body, mesh)
    indices: list[CyclicMatrices] = []
    amplitudes: list[Matrix] = []
    roots: list[tuple[BladeRoot, ...]] = []
    for index in request.indices:
        begins(index)
        operators = order_operators(clamped, mesh, comm, _order_request(request, index), index)
        try:
            if not request.held and operators.rigid_motions:
                raise ReductionError(
                    f"nodal diameter {index} moves the body as a whole; hold an interface, or "
                    "leave 0 and 1 to the modes of the engine"
                )
            basis = _basis(operators, request)
            left_out = residuals.truncation_energy(operators, basis) if request.estimates else None
            basis.factor.destroy()  # before the finer space, which takes as much
            omitted = _omitted(operators, basis, left_out, clamped, request)
            indices.append(_matrices(operators, basis, index, omitted))
            amplitudes.append(_fields(operators, basis, outline.points_m))
            at_nodes = partial(_interior_fields, operators, basis)
            roots.append(blade_roots(blades, mesh, operators, _interior(basis), at_nodes))
        finally:
            operators.release()
    sectors = None if mesh.dimension == 2 else _sectors(mesh)
    return (
        CyclicBody(name=body.name, sectors=sectors, indices=tuple(indices)),
        _shapes(mesh, outline, amplitudes, roots),
    )


def _shapes(
    mesh: Mesh,
    outline: SurfaceMesh,
    amplitudes: Sequence[Matrix],
    roots: Sequence[tuple[BladeRoot, ...]],
) -> CyclicShapes:
    points, cells = outline.points_m, outline.cells
    if mesh.sector is not None and mesh.sector.mirrored:
        cells = np.concatenate([cells, cells[:, ::-1] + len(points)])
        points = np.concatenate([points, points * _MIRROR])
    return CyclicShapes(
        points_m=points, cells=cells, amplitudes=tuple(amplitudes), roots=tuple(roots)
    )


def _sectors(mesh: Mesh) -> int:
    if mesh.sector is None:
        raise ReductionError("nodal diameters need the mesh of a sector, or a meridian")
    return mesh.sector.count


def _clamped(body: AnyBody, held: Sequence[str]) -> AnyBody:
    """The body with the held interfaces alone, whose nodes do not move against each other.

    A rigid disk on one of them does not move, and one on another has nothing to move with.
    """
    kept: Any = tuple(replace(i, coupling="rigid") for i in body.interfaces if i.name in held)
    return replace(body, interfaces=kept, rigid_disks=())


def _order_request(request: CyclicRequest, index: int) -> ReductionRequest:
    return ReductionRequest(
        level=request.level,
        orders=(index,),
        components=COMPONENTS,
        degree=request.degree,
        modes=request.modes,
        maximum_speed_rad_s=request.maximum_speed_rad_s,
        gyroscopic=True,
        centrifugal=True,
        estimates=request.estimates,
        solver=request.solver,
    )


def _basis(operators: BodyOperators, request: CyclicRequest) -> Basis:
    """Return the basis that the matrices in the turning frame ask for.

    Those of the fixed frame have no stiffness left where a wave stands still in it, which is no
    instability but an engine order that meets its mode.
    """
    speed, turned = request.maximum_speed_rad_s, operators
    turn = _turn(operators)
    if turn is not None:
        spin, softening, mass = operators.gyroscopic, operators.spin_softening, operators.mass
        turned = replace(
            operators,
            gyroscopic=Combination(terms=((1.0, spin), (-turn, mass))),
            spin_softening=Combination(
                terms=((1.0, softening), (turn**2, mass), (-2.0 * turn, spin))
            ),
        )
    basis = reduction_basis(turned, modes=request.modes, maximum_speed_rad_s=speed)
    return with_spin_answers(turned, basis, speed_rad_s=speed, tolerance=_SPIN)


def _interior(basis: Basis) -> Matrix:
    return basis.vectors[:, basis.interface_count :]


def _matrices(
    operators: BodyOperators, basis: Basis, index: int, omitted: tuple[OmittedEnergy, ...]
) -> CyclicMatrices:
    vectors, comm = _interior(basis), operators.comm
    mass, stiffness, spin, stiffening, softening = (
        project(getattr(operators, name), vectors, comm)
        for name in ("mass", "stiffness", "gyroscopic", "stress_stiffening", "spin_softening")
    )
    inertial = (mass, stiffness, spin, stiffening - softening)
    return rotating_matrices(index, _turn(operators), inertial, omitted)


def _turn(operators: BodyOperators) -> int | None:
    """How often the amplitudes turn with the frame; None of real fields."""
    if operators.families == 1:
        return None
    return operators.harmonic if operators.level == "harmonic" else 1


def _omitted(
    operators: BodyOperators,
    basis: Basis,
    left_out: tuple[residuals.Omitted, Matrix] | None,
    body: AnyBody,
    request: CyclicRequest,
) -> tuple[OmittedEnergy, ...]:
    """What the basis leaves out (`left_out`, with answers), and what its elements can't follow."""
    if left_out is None:
        return ()
    truncation, answers = left_out
    found = [truncation]
    if "mesh" in request.estimates:
        found.append(residuals.mesh_energy(operators, basis, answers, body.interfaces)[0])
    size, first = basis.vectors.shape[1], basis.interface_count
    kept = np.arange(4 * size).reshape(4, size)[:, first:].ravel()
    return tuple(
        OmittedEnergy(
            part=o.part,
            gram=o.gram[np.ix_(kept, kept)],
            safety=o.safety,
            cutoff_rad_s=o.cutoff_rad_s,
        )
        for o in found
    )


def _interior_fields(operators: BodyOperators, basis: Basis, places: FloatArray) -> Matrix:
    return nodal_amplitudes(operators, basis, places)[:, :, basis.interface_count :]


def _fields(operators: BodyOperators, basis: Basis, places: FloatArray) -> Matrix:
    """Φ at places; on the meridian of Φ = (a, -ib, c) e^{inθ}, and (a, b, c) for n = 0.

    Of half a sector those of the mirror images follow.
    """
    found = _interior_fields(operators, basis, places)
    if operators.level == "harmonic":
        turn = np.array([1.0, -1.0j, 1.0]) if operators.families == 2 else np.ones(3)
        return np.asarray(found * turn[:, None])
    cyclic = operators.ingredients.kinematics.cyclic
    if cyclic is None or not (cyclic.sector.mirrored or cyclic.is_real):
        return found
    if not cyclic.sector.mirrored:
        return np.asarray(found.real)
    image = np.conj(found) * _MIRROR[:, None]
    whole = np.concatenate([found, image])
    return np.asarray(whole.real + whole.imag if cyclic.is_real else whole)
