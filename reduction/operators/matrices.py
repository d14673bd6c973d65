"""Matrices of a spinning body on its mesh: one record for the harmonic and the solid level."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import ufl
from petsc4py import PETSc

from solidwhirl.meshing import Mesh
from solidwhirl.meshing.imported.records import AnyBody
from solidwhirl.reduction.operators import compat, forms, kinematics, solid_matrices
from solidwhirl.reduction.operators.coupling import Coupling, couple, reduced_motion
from solidwhirl.reduction.operators.dofs import motion_vectors
from solidwhirl.reduction.operators.kinematics import Kinematics
from solidwhirl.reduction.operators.prestress import centrifugal_displacement
from solidwhirl.reduction.operators.symmetry import (
    AXISYMMETRIC,
    LATERAL,
    sector_mesh,
    whole_node_count,
)
from solidwhirl.reduction.solvers.memory import return_free_memory
from solidwhirl.reduction.solvers.vectors import folded, project
from solidwhirl.rotordyn.core.arrays import FloatArray


@dataclass(frozen=True, kw_only=True)
class OperatorEffects:
    """Which matrices are assembled."""

    gyroscopic: bool
    #: Prestress solve, Kσ and S; the two belong together in the inertial frame, so there is no
    #: switch for one of them alone
    centrifugal: bool
    #: Rigid motions that each interface carries, some of ux, uy, uz, rx, ry, rz
    components: Mapping[str, tuple[str, ...]]
    #: Solid level: only lateral motion is asked for, so only fields with its symmetry under a half
    #: turn are sought
    lateral_only: bool
    #: Of a solid: "quartered" is of revolution, and its mesh the same after a quarter turn; "round"
    #: is of revolution on a mesh of any kind; "any" does not turn and may have any shape
    shape: str = "quartered"
    #: How systems of a solid are solved, see `solidwhirl.reduction.operators.solver_choice`
    solver: str = "auto"


@dataclass(frozen=True, kw_only=True, eq=False)
class Ingredients:
    """What the matrices of a body are assembled from."""

    kinematics: Kinematics
    matter: forms.Medium
    facet_tags: Mapping[str, Any]
    centrifugal_field: Any  #: Displacement at unit speed (Function), None without it
    effects: OperatorEffects
    component_mass: Any  #: M of one component of u on all nodes, PETSc


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyOperators:
    """Operators of one body, one circumferential order, on any communicator.

    The unknowns û are the displacement degrees of freedom, of which those on rigid interfaces are
    replaced by their master's motions.
    """

    level: str
    harmonic: int | None  #: Circumferential order, None for the solid
    families: int  #: Copies of the unknowns (2: cos and sin family with the same matrices)
    mass: Any
    stiffness: Any
    gyroscopic: Any  #: G (one family) or N of G = [[0, 2N], [-2N, 0]] (two); None if not asked
    #: Kσ and S at unit speed; None if not asked
    stress_stiffening: Any
    spin_softening: Any
    #: Solid only: ∫ ρ Jv·Ju with J the generator of a turn of the whole field; its Rayleigh
    #: quotient over M is the square of a mode's circumferential order
    circulation: Any
    turn: Any  #: Solid only: ∫ ρ v·Ju
    coupling: Coupling  #: Interface rows B and the map u = T û
    #: Rigid motions about the origin by component, local rows of û
    rigid_motions: Mapping[str, FloatArray]
    #: Component of the first family to (component, sign) of the second
    second_family: Mapping[str, tuple[str, float]]
    #: Largest hoop strain of the centrifugal field at unit speed (per (rad/s)²), 0 without it
    hoop_strain: float
    #: Solid: (6, 6) mass matrix of the mesh for the rigid motions about the origin; None on the
    #: meridian, whose straight edges hold the profile exactly
    rigid_mass: FloatArray | None
    full_dofs: int  #: Unknowns of the whole body (all families) before reduction
    space: Any
    ingredients: Ingredients
    assembled: tuple[str, ...]

    @property
    def comm(self) -> Any:
        """mpi4py communicator."""
        return self.mass.comm.tompi4py()

    def release(self) -> None:
        """Free the matrices, which Python alone would not, on all ranks; then they are gone."""
        comm = self.mass.comm
        compat.collect_garbage(comm)
        own = (getattr(self, name) for name in _MATRICES)
        for matrix in (*own, self.coupling.transformation, self.ingredients.component_mass):
            if matrix is not None:
                matrix.destroy()
        return_free_memory()


def build_operators(
    body: AnyBody,
    mesh: Mesh | None,
    comm: Any,
    *,
    order: int | None,
    degree: int,
    effects: OperatorEffects,
) -> BodyOperators:
    """Assemble the operators of a body.

    `mesh`: meridian (harmonic level) or solid mesh; needed on rank 0 only. `order`: circumferential
    order n on a meridian mesh, None on a solid mesh. Raises ReductionError: interfaces that can not
    be coupled.
    """
    dimension = 3 if order is None else 2
    copies = 2 if order is None and effects.lateral_only else 1
    materials = comm.bcast(mesh.materials if mesh is not None else None, root=0)
    part = sector_mesh(mesh, copies) if mesh is not None else None
    domain, material_tags, facet_tags = compat.distribute(part, dimension, comm)
    kin = _kinematics(domain, order, copies)
    matter = forms.medium(domain, material_tags, materials)
    space = compat.vector_space(domain, degree, 3)
    coupling = couple(space, kin, facet_tags, body.interfaces, effects.components, effects.shape)
    assemble = _assemble_solid if order is None else _assemble_meridian
    assembly = assemble(space, kin, matter, degree, effects, coupling)
    return BodyOperators(
        level="solid" if order is None else "harmonic",
        harmonic=order,
        families=kin.families,
        **{name: assembly.matrices.get(name) for name in _MATRICES},
        coupling=coupling,
        rigid_motions={
            c: reduced_motion(space, kin, coupling, body.interfaces, c) for c in kin.rigid_motions
        },
        second_family=kin.second_family,
        hoop_strain=assembly.hoop_strain,
        rigid_mass=assembly.rigid_mass,
        full_dofs=3 * whole_node_count(space, copies) * kin.families,
        space=space,
        ingredients=Ingredients(
            kinematics=kin,
            matter=matter,
            facet_tags=facet_tags,
            centrifugal_field=assembly.centrifugal_field,
            effects=effects,
            component_mass=assembly.component_mass,
        ),
        assembled=assembly.ledger,
    )


# In the order in which they are freed.
_MATRICES = ("mass", "stiffness", "gyroscopic", "stress_stiffening", "spin_softening",
             "circulation", "turn")  # fmt: skip


@dataclass(frozen=True, kw_only=True, eq=False)
class _Assembly:
    """Matrices of the unknowns û by name, and what was done for them."""

    matrices: Mapping[str, Any]
    centrifugal_field: Any
    hoop_strain: float
    rigid_mass: FloatArray | None
    component_mass: Any
    ledger: tuple[str, ...]


def _arguments(space: Any, kin: Kinematics, degree: int) -> tuple[Any, Any, Any]:
    """Trial and test function of the forms, and the measure that they are integrated over."""
    measure = forms.measure(space.mesh, kin, degree)
    return ufl.TrialFunction(space), ufl.TestFunction(space), measure


def _assemble_meridian(
    space: Any,
    kin: Kinematics,
    matter: forms.Medium,
    degree: int,
    effects: OperatorEffects,
    coupling: Coupling,
) -> _Assembly:
    """Assemble what the effects ask for, nothing else."""
    u, v, dx = _arguments(space, kin, degree)
    wanted = {"stiffness": forms.stiffness_form, "mass": forms.mass_form}
    if effects.gyroscopic:
        wanted["gyroscopic"] = forms.gyroscopic_form
    matrices = {name: assembled(form(kin, matter, u, v, dx)) for name, form in wanted.items()}
    ledger, field, hoop = list(matrices), None, 0.0
    if effects.centrifugal:
        around, static = kin, matrices["stiffness"]
        if kin.harmonic != 0:
            around = kinematics.harmonic(space.mesh, 0)
            static = assembled(forms.stiffness_form(around, matter, u, v, dx))
            ledger.append("axisymmetric_stiffness")
        field, hoop = centrifugal_displacement(space, around, matter, dx, static)
        prestress = forms.stress(around, matter, field)
        matrices["stress_stiffening"] = assembled(forms.stiffening_form(kin, prestress, u, v, dx))
        matrices["spin_softening"] = assembled(forms.softening_form(kin, matter, u, v, dx))
        ledger += ["prestress", "stress_stiffening", "spin_softening"]
    one = _one_component(matrices["mass"])
    return _Assembly(
        matrices={name: _coupled(matrix, coupling) for name, matrix in matrices.items()},
        centrifugal_field=field,
        hoop_strain=hoop,
        rigid_mass=None,
        component_mass=one,
        ledger=tuple(ledger),
    )


def _assemble_solid(
    space: Any,
    kin: Kinematics,
    matter: forms.Medium,
    degree: int,
    effects: OperatorEffects,
    coupling: Coupling,
) -> _Assembly:
    """Assemble the stiffness of vectors and all other matrices by component."""
    u, v, dx = _arguments(space, kin, degree)
    turned = coupling.transformation
    parts = solid_matrices.component_matrices(space, kin, matter, dx)
    ledger, field, hoop = ["stiffness", "mass", "spin", "spin_softening"], None, 0.0
    names = ["mass", *(["circulation", "turn"] if effects.shape != "any" else [])]
    names += ["gyroscopic"] if effects.gyroscopic else []
    matrices = {name: solid_matrices.vector_matrix(name, parts, turned) for name in names}
    stiffness = assembled(forms.stiffness_form(kin, matter, u, v, dx))
    if effects.centrifugal:
        around, weight = (kinematics.symmetric_solid(space.mesh, AXISYMMETRIC, kin.copies), None)
        if effects.shape != "quartered":
            around, weight = kin, parts.mass
        field, hoop = centrifugal_displacement(
            space, around, matter, dx, stiffness, weight, solver=effects.solver
        )
        prestress = forms.stress(around, matter, field)
        stiffening = solid_matrices.component_stiffening(space, kin, prestress, dx)
        matrices["stress_stiffening"] = solid_matrices.componentwise(stiffening, turned)
        matrices["spin_softening"] = solid_matrices.componentwise(parts.softening, turned)
        ledger += ["prestress", "stress_stiffening"]
    matrices["stiffness"] = _coupled(stiffness, coupling)
    return _Assembly(
        matrices=matrices,
        centrifugal_field=field,
        hoop_strain=hoop,
        rigid_mass=_rigid_mass(space, kin, parts.mass),
        component_mass=parts.mass,
        ledger=tuple(ledger),
    )


def _kinematics(domain: Any, order: int | None, copies: int) -> Kinematics:
    if order is not None:
        return kinematics.harmonic(domain, order)
    # the half is worked on when lateral motion alone is asked for
    return (
        kinematics.solid(domain)
        if copies == 1
        else kinematics.symmetric_solid(domain, LATERAL, copies)
    )


def _rigid_mass(space: Any, kin: Kinematics, mass: Any) -> FloatArray:
    """Rᵀ M R with the six rigid motions R of the solid, M given by component."""
    motions = motion_vectors(space, kinematics.solid(space.mesh), 0.0)
    values = np.column_stack(list(motions.values())).reshape(-1, 3, len(motions))
    comm = space.mesh.comm
    out = np.sum([project(mass, values[:, i], comm) for i in range(3)], axis=0)
    if kin.copies > 1:
        # over the whole, lateral and axial motions are orthogonal; half of it does not know
        lateral = np.array([c in kin.rigid_motions for c in motions])
        out = np.where(lateral[:, None] == lateral, out, 0.0)
    return np.asarray(out)


def _one_component(matrix: Any) -> Any:
    """Rows and columns of the first of the three components of all nodes."""
    first, end = matrix.getOwnershipRange()
    own = PETSc.IS().createStride((end - first) // 3, first=first, step=3, comm=matrix.comm)
    out = matrix.createSubMatrix(own, own)
    own.destroy()
    return out


def assembled(form: Any, coupling: Coupling | None = None) -> Any:
    """Matrix of a UFL form, with a coupling in the unknowns û."""
    matrix = compat.assemble_matrix(compat.compiled(form))
    return matrix if coupling is None else _coupled(matrix, coupling)


def _coupled(matrix: Any, coupling: Coupling) -> Any:
    """Tᵀ A T; A is destroyed."""
    if coupling.transformation is None:
        return matrix
    out = folded(matrix, coupling.transformation)
    matrix.destroy()
    return out
