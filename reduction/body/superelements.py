"""From operators and bases to the superelement that the assembler reads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.linalg

from solidwhirl.core.joint_states import JointState
from solidwhirl.meshing.imported.records import AnyBody, is_asymmetric
from solidwhirl.reduction.basis import pairing
from solidwhirl.reduction.basis.craig_bampton import Basis
from solidwhirl.reduction.basis.free_motion import rigid_coefficients, without_rigid_force
from solidwhirl.reduction.basis.reduced_block import ReducedBlock, joined_order, planes
from solidwhirl.reduction.body.mass_moments import BlockMoments, joined_moments
from solidwhirl.reduction.body.request import ReductionRequest, solved_orders
from solidwhirl.reduction.body.surfaces import recovery_modes
from solidwhirl.reduction.operators.kinematics import COMPONENTS
from solidwhirl.reduction.operators.matrices import BodyOperators, turned_mean
from solidwhirl.reduction.residuals.residual_energy import FinerSpace, Omitted, joined_forms
from solidwhirl.reduction.solvers.vectors import project, skew, symmetric
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, IntArray, Matrix
from solidwhirl.rotordyn.superelement.families import free_frequencies_by_family
from solidwhirl.rotordyn.superelement.invariants import Invariant
from solidwhirl.rotordyn.superelement.record import Coordinate, InterfaceNode, Superelement
from solidwhirl.rotordyn.superelement.rigid_body import MassProperties
from solidwhirl.rotordyn.superelement.validation import Frame

_MOST_FREE = 10
_MATRICES = ("mass", "stiffness", "stress_stiffening", "spin_softening")


def reduce_block(operators: BodyOperators, basis: Basis, points_m: FloatArray) -> ReducedBlock:
    """Project the operators of one order on its basis.

    `points_m`: (m, 3) recovery points at θ = 0 and 90°, vertices of the mesh.
    """
    comm = operators.comm
    n = basis.vectors.shape[1]
    family = {name: _projection(getattr(operators, name), basis, comm) for name in _MATRICES}
    matrices: dict[str, Any] = {name: symmetric(matrix) for name, matrix in family.items()}
    raw = _projection(operators.gyroscopic, basis, comm)
    rigid, present = rigid_coefficients(operators, basis)
    recovery = recovery_modes(operators, basis, points_m)
    signs = np.ones(n * operators.families)
    generator: FloatArray | None = np.zeros((n, n))
    if operators.families == 1:
        matrices["gyroscopic"] = skew(raw)
    if operators.harmonic is None:
        generator = basis.generator
        matrices = {
            name: pairing.evenly_turned(matrix, generator) for name, matrix in matrices.items()
        }
        rigid = pairing.evenly_turned_motions(rigid, generator)
    if basis.generator is not None and operators.gyroscopic is not None:
        matrices["gyroscopic"] = pairing.even_gyroscopic(operators, basis, matrices["mass"])
    matrices["stiffness"] = without_rigid_force(
        operators, matrices["stiffness"], matrices["mass"], rigid
    )
    coordinates = _family_coordinates(operators, basis, matrices["stiffness"])
    if operators.families == 1:
        fixed = np.sqrt(np.maximum(basis.fixed_eigenvalues, 0.0)) / (2.0 * np.pi)
        order = np.arange(n)
    else:
        fixed = np.repeat(np.sqrt(np.maximum(basis.fixed_eigenvalues, 0.0)) / (2.0 * np.pi), 2)
        matrices = {name: planes(matrix) for name, matrix in matrices.items()}
        matrices["gyroscopic"] = skew(planes(2j * symmetric(raw)))
        coordinates, rigid, present, signs = _both_families(operators, coordinates, rigid, present)
        matrices = {name: matrix * np.outer(signs, signs) for name, matrix in matrices.items()}
        recovery = recovery * signs
        # cos n(θ − α) = cos nθ + n α sin nθ, and the sin family goes back
        turn = (operators.harmonic or 0) * np.array([[0.0, -1.0], [1.0, 0.0]])
        generator = np.kron(turn, np.eye(n)) * np.outer(signs, signs)
        order = _interleaved(coordinates)
    return ReducedBlock(
        coordinates=tuple(coordinates[k] for k in order),
        matrices={name: matrix[np.ix_(order, order)] for name, matrix in matrices.items()},
        rigid=rigid[order],
        present=present,
        recovery=recovery[:, :, order],
        fixed_frequencies_hz=fixed,
        generator=None if generator is None else generator[np.ix_(order, order)],
        signs=signs,
        order=np.asarray(order, dtype=np.int64),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class SolvedOrder:
    """One circumferential order of a body, reduced, estimated, checked; its matrices are gone."""

    label: str  #: "n=1", or "solid"
    block: ReducedBlock
    surface: FloatArray  #: (p, 3, n) amplitudes of the surface's points per column of the basis
    #: What the block leaves out, the same parts for all orders; empty without estimates
    omitted: tuple[Omitted, ...]
    #: The space that errors of the mesh were measured in, None without them
    finer: FinerSpace | None
    moments: BlockMoments
    checks: tuple[Invariant, ...]
    full_dofs: int
    rigid_mass: FloatArray | None
    hoop_strain: float
    joints: tuple[JointState, ...]
    orthogonality_error: float
    assembled: tuple[str, ...]
    solved: tuple[str, ...]
    solver: str
    seconds: Mapping[str, float]


def build_superelement(
    body: AnyBody,
    orders: Sequence[SolvedOrder],
    request: ReductionRequest,
    properties: MassProperties,
    points_m: FloatArray,
    provenance: Mapping[str, Any],
) -> Superelement:
    """Join the orders of one body (direct sum) to its superelement.

    Different orders do not couple in a body of revolution; of any other there is one block.

    `properties`: mass properties of the meshed part (without rigid disks). `points_m`: (m, 3)
    recovery points.
    """
    blocks = [found.block for found in orders]
    flat = [c for b in blocks for c in b.coordinates]
    order = joined_order(body, blocks)
    frame: Frame = "rotating" if is_asymmetric(body) else "inertial"

    def joined(name: str) -> FloatArray:
        whole = scipy.linalg.block_diag(*[b.matrices[name] for b in blocks])
        return np.asarray(whole[np.ix_(order, order)])

    matrices: dict[str, Any] = {name: joined(name) for name in (*_MATRICES, "gyroscopic")}
    recovery = np.concatenate([b.recovery for b in blocks], axis=2)[:, :, order]
    element = Superelement(
        name=body.name,
        level=request.level,  # type: ignore[arg-type]
        harmonics=tuple(n for n in solved_orders(body, request) if n is not None),
        coordinates=tuple(flat[k] for k in order),
        interfaces=tuple(
            InterfaceNode(
                name=i.name, position_m=np.array(i.position_m, dtype=float), coupling=i.coupling
            )
            for i in body.interfaces
        ),
        **matrices,
        rigid_body_modes=np.vstack([b.rigid for b in blocks])[order],
        rigid_body_present=np.any([b.present for b in blocks], axis=0),
        **properties._asdict(),
        full_dofs=sum(found.full_dofs for found in orders),
        maximum_speed_rad_s=request.maximum_speed_rad_s,
        recovery_points_m=points_m,
        recovery_modes=recovery,
        free_frequencies_hz=np.empty(0),
        fixed_interface_frequencies_hz=np.sort(
            np.concatenate([b.fixed_frequencies_hz for b in blocks])
        ),
        frequency_error_estimate=np.empty(0),
        provenance=provenance,
        spin_generator=_joined_generator(blocks, order),
        error_forms=joined_forms(blocks, [found.omitted for found in orders], order, frame),
        moments=joined_moments([found.moments for found in orders], order),
        frame=frame,
    )
    return with_free_frequencies(element)


def with_free_frequencies(element: Superelement) -> Superelement:
    """Return a body with the lowest frequencies of its free lateral motion."""
    lateral = free_frequencies_by_family(element)["lateral"]
    return replace(element, free_frequencies_hz=lateral[:_MOST_FREE])


def _joined_generator(blocks: Sequence[ReducedBlock], order: IntArray) -> FloatArray | None:
    known = [b.generator for b in blocks if b.generator is not None]
    if len(known) < len(blocks):
        return None
    return np.asarray(scipy.linalg.block_diag(*known)[np.ix_(order, order)])


def mesh_properties(rigid_mass: FloatArray, shape: str) -> MassProperties:
    """Mass properties from the rigid mass matrix of a mesh.

    `rigid_mass`: (6, 6) for ux, uy, uz, rx, ry, rz about the origin. `shape`: "round": the mean
    over quarter turns is taken, as of all matrices.
    """
    even = turned_mean(rigid_mass) if shape == "round" else rigid_mass
    mass = float(even[0, 0])
    centre = np.array([even[1, 5], -even[0, 5], even[0, 4]]) / mass
    about = mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    inertia = even[3:, 3:] - about
    return MassProperties(mass, centre, 0.5 * (inertia + inertia.T))


def mesh_mass_properties(rigid_mass: FloatArray) -> MassProperties:
    """Mass properties of a mesh of a body of revolution from its rigid mass matrix.

    `rigid_mass`: (6, 6) for ux, uy, uz, rx, ry, rz about the origin.
    """
    mass = float(rigid_mass[0, 0])
    z = rigid_mass[0, 4] / mass
    diametral, polar = rigid_mass[4, 4] - mass * z**2, rigid_mass[5, 5]
    return MassProperties(mass, np.array([0.0, 0.0, z]), np.diag([diametral, diametral, polar]))


def _projection(matrix: Any, basis: Basis, comm: Any) -> Matrix:
    """Vᵀ A V, zero where A was not assembled."""
    if matrix is None:
        return np.zeros((basis.vectors.shape[1],) * 2, dtype=basis.vectors.dtype)
    return project(matrix, basis.vectors, comm)


def _family_coordinates(
    operators: BodyOperators, basis: Basis, stiffness: Matrix
) -> list[Coordinate]:
    """Interface coordinates, and M-orthonormal modes with their frequencies."""
    out = [
        Coordinate(kind="interface", interface=name, component=c, frequency_hz=0.0)  # type: ignore[arg-type]
        for name, c in operators.coupling.coordinates
    ]
    for value in np.diag(stiffness).real[basis.interface_count :]:
        f = float(np.sqrt(max(float(value), 0.0)) / (2.0 * np.pi))
        out.append(Coordinate(kind="modal", interface="", component="q", frequency_hz=f))
    return out


def _both_families(
    operators: BodyOperators, coordinates: list[Coordinate], rigid: Matrix, present: BoolArray
) -> tuple[list[Coordinate], FloatArray, BoolArray, FloatArray]:
    """Coordinates of cos and sin family with true rotations, and the signs that make them so."""
    n = len(coordinates)
    second, signs = [], np.ones(2 * n)
    for k, c in enumerate(coordinates):
        component, sign = operators.second_family.get(c.component, (c.component, 1.0))
        signs[n + k] = sign
        second.append(replace(c, component=component))  # type: ignore[arg-type]
    both, there = np.zeros((2 * n, 6)), np.zeros(6, dtype=bool)
    for k in np.flatnonzero(present):
        component, sign = operators.second_family[COMPONENTS[k]]
        partner = COMPONENTS.index(component)
        # c = q1 - i q2 of the motion, and -i times it of what it turns into
        both[:n, k], both[n:, k] = rigid[:, k].real, -rigid[:, k].imag * signs[n:]
        both[:n, partner] = sign * rigid[:, k].imag
        both[n:, partner] = sign * rigid[:, k].real * signs[n:]
        there[k] = there[partner] = True
    return coordinates + second, both, there, signs


def _interleaved(coordinates: list[Coordinate]) -> IntArray:
    """Order of two stacked families: interfaces by name and component, modes in pairs."""
    n = len(coordinates) // 2
    names = list(dict.fromkeys(c.interface for c in coordinates[:n]))

    def key(k: int) -> tuple[int, int, int]:
        c = coordinates[k]
        if c.kind == "modal":
            return (1, k % n, k // n)
        return (0, names.index(c.interface), COMPONENTS.index(c.component))

    return np.array(sorted(range(2 * n), key=key), dtype=np.int64)
