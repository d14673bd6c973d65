"""Matrices of a spinning body on its mesh: one record for the harmonic and the solid level."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import ufl
from numpy.typing import NDArray

from solidwhirl.geometry import Body
from solidwhirl.meshing import Mesh
from solidwhirl.reduction import compat, forms, kinematics
from solidwhirl.reduction.coupling import Coupling, couple, reduced_motion
from solidwhirl.reduction.kinematics import Kinematics
from solidwhirl.reduction.prestress import centrifugal_displacement
from solidwhirl.reduction.unknowns import motion_vectors
from solidwhirl.reduction.vectors import project

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class OperatorEffects:
    """Which matrices are assembled.

    Attributes
    ----------
    gyroscopic
        G.
    centrifugal
        Prestress solve, Kσ and S; the two belong together in the inertial frame, so there is no
        switch for one of them alone.
    components
        Rigid motions that each interface carries, some of ux, uy, uz, rx, ry, rz.
    lateral_only
        Solid level: only lateral motion is asked for, so only fields with its symmetry under a
        half turn are sought.
    """

    gyroscopic: bool
    centrifugal: bool
    components: Mapping[str, tuple[str, ...]]
    lateral_only: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyOperators:
    """Operators of one body, one circumferential order, on any communicator.

    The unknowns û are the displacement degrees of freedom, of which those on rigid interfaces are
    replaced by their master's motions.

    Attributes
    ----------
    level
        "harmonic" or "solid".
    harmonic
        Circumferential order, None for the solid.
    families
        Copies of the unknowns (2: cos and sin family with the same matrices).
    mass, stiffness
        M, K.
    gyroscopic
        G (one family) or N of G = [[0, 2N], [-2N, 0]] (two); None if not asked.
    stress_stiffening, spin_softening
        Kσ and S at unit speed; None if not asked.
    circulation
        Solid only: ∫ ρ Jv·Ju with J the generator of a turn of the whole field; its Rayleigh
        quotient over M is the square of a mode's circumferential order.
    turn
        Solid only: ∫ ρ v·Ju.
    coupling
        Interface rows B and the map u = T û.
    rigid_motions
        Rigid motions about the origin by component, local rows of û.
    second_family
        Component of the first family to (component, sign) of the second.
    hoop_strain
        Largest hoop strain of the centrifugal field at unit speed (per (rad/s)²), 0 without it.
    rigid_mass
        Solid: (6, 6) mass matrix of the mesh for the rigid motions about the origin; None on the
        meridian, whose straight edges hold the profile exactly.
    full_dofs
        Unknowns of the whole body (all families) before reduction.
    space
        Displacement space.
    assembled
        What was assembled and solved, in order.
    """

    level: str
    harmonic: int | None
    families: int
    mass: Any
    stiffness: Any
    gyroscopic: Any
    stress_stiffening: Any
    spin_softening: Any
    circulation: Any
    turn: Any
    coupling: Coupling
    rigid_motions: Mapping[str, FloatArray]
    second_family: Mapping[str, tuple[str, float]]
    hoop_strain: float
    rigid_mass: FloatArray | None
    full_dofs: int
    space: Any
    assembled: tuple[str, ...]

    @property
    def comm(self) -> Any:
        """mpi4py communicator."""
        return self.mass.comm.tompi4py()


def build_operators(
    body: Body,
    mesh: Mesh | None,
    comm: Any,
    *,
    order: int | None,
    degree: int,
    effects: OperatorEffects,
) -> BodyOperators:
    """Assemble the operators of a body.

    Parameters
    ----------
    body
        For its interfaces and materials.
    mesh
        Meridian (harmonic level) or solid mesh; needed on rank 0 only.
    comm
        Communicator.
    order
        Circumferential order n on a meridian mesh, None on a solid mesh.
    degree
        Polynomial degree of the displacement.
    effects
        What to assemble.

    Raises
    ------
    ReductionError
        Interfaces that can not be coupled.
    """
    dimension = 3 if order is None else 2
    domain, material_tags, facet_tags = compat.distribute(mesh, dimension, comm)
    kin = _kinematics(domain, order, effects)
    materials = comm.bcast(mesh.materials if mesh is not None else None, root=0)
    matter = forms.medium(domain, material_tags, materials)
    space = compat.vector_space(domain, degree, 3)
    coupling = couple(space, kin, facet_tags, body.interfaces, effects.components)
    assembly = _assemble(space, kin, matter, degree, effects)
    whole = assembly.matrices
    index_map = space.dofmap.index_map
    return BodyOperators(
        level="solid" if order is None else "harmonic",
        harmonic=order,
        families=kin.families,
        mass=_coupled(whole.get("mass"), coupling),
        stiffness=_coupled(whole.get("stiffness"), coupling),
        gyroscopic=_coupled(whole.get("gyroscopic"), coupling),
        stress_stiffening=_coupled(whole.get("stress_stiffening"), coupling),
        spin_softening=_coupled(whole.get("spin_softening"), coupling),
        circulation=_coupled(whole.get("circulation"), coupling),
        turn=_coupled(whole.get("turn"), coupling),
        coupling=coupling,
        rigid_motions={
            c: reduced_motion(space, kin, coupling, body.interfaces, c) for c in kin.rigid_motions
        },
        second_family=kin.second_family,
        hoop_strain=assembly.hoop_strain,
        rigid_mass=_rigid_mass(space, whole["mass"]) if order is None else None,
        full_dofs=index_map.size_global * space.dofmap.index_map_bs * kin.families,
        space=space,
        assembled=assembly.ledger,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Assembly:
    """Matrices of all unknowns by name, and what was done for them."""

    matrices: Mapping[str, Any]
    hoop_strain: float
    ledger: tuple[str, ...]


def _assemble(
    space: Any, kin: Kinematics, matter: forms.Medium, degree: int, effects: OperatorEffects
) -> _Assembly:
    """Assemble what the effects ask for, nothing else."""
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    metadata = {"quadrature_degree": forms.quadrature_degree(kin, degree)}
    dx = ufl.Measure("dx", domain=space.mesh, metadata=metadata)
    wanted = {"stiffness": forms.stiffness_form, "mass": forms.mass_form}
    if effects.gyroscopic:
        wanted["gyroscopic"] = forms.gyroscopic_form
    if kin.harmonic is None:
        wanted["circulation"] = forms.circulation_form
        wanted["turn"] = forms.turn_form
    matrices = {
        name: compat.assemble_matrix(compat.compiled(form(kin, matter, u, v, dx)))
        for name, form in wanted.items()
    }
    ledger = list(matrices)
    if not effects.centrifugal:
        return _Assembly(matrices=matrices, hoop_strain=0.0, ledger=tuple(ledger))
    around, static = _axisymmetric(space.mesh, kin), matrices["stiffness"]
    if kin.harmonic is not None and around is not kin:
        form = forms.stiffness_form(around, matter, u, v, dx)
        static = compat.assemble_matrix(compat.compiled(form))
        ledger.append("axisymmetric_stiffness")
    field, hoop = centrifugal_displacement(space, around, matter, dx, static)
    prestress = forms.stress(around, matter, field)
    for name, form in (
        ("stress_stiffening", forms.stiffening_form(kin, prestress, u, v, dx)),
        ("spin_softening", forms.softening_form(kin, matter, u, v, dx)),
    ):
        matrices[name] = compat.assemble_matrix(compat.compiled(form))
    ledger += ["prestress", "stress_stiffening", "spin_softening"]
    return _Assembly(matrices=matrices, hoop_strain=hoop, ledger=tuple(ledger))


def _axisymmetric(domain: Any, kin: Kinematics) -> Kinematics:
    """Kinematics of the centrifugal field on the same mesh."""
    if kin.harmonic is None:
        return kinematics.solid_axisymmetric(domain)
    return kin if kin.harmonic == 0 else kinematics.harmonic(domain, 0)


def _kinematics(domain: Any, order: int | None, effects: OperatorEffects) -> Kinematics:
    if order is not None:
        return kinematics.harmonic(domain, order)
    describe = kinematics.solid_lateral if effects.lateral_only else kinematics.solid
    return describe(domain)


def _rigid_mass(space: Any, mass: Any) -> FloatArray:
    """Rᵀ M R with the six rigid motions of the solid."""
    motions = motion_vectors(space, kinematics.solid(space.mesh), 0.0)
    return project(mass, np.column_stack(list(motions.values())), space.mesh.comm)


def _coupled(matrix: Any, coupling: Coupling) -> Any:
    """Tᵀ A T."""
    if matrix is None or coupling.transformation is None:
        return matrix
    return matrix.PtAP(coupling.transformation)
