"""Matrices of a spinning body on its mesh: one record for the harmonic and the solid level."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import ufl

from solidwhirl.meshing import Mesh, Sector
from solidwhirl.meshing.imported.records import AnyBody
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators import compat, forms, kinematics, solid_matrices
from solidwhirl.reduction.operators.coupling import Coupling, couple
from solidwhirl.reduction.operators.cyclic import CyclicIndex
from solidwhirl.reduction.operators.dofs import Unknowns, motion_vectors
from solidwhirl.reduction.operators.held import HeldBody, held_body
from solidwhirl.reduction.operators.joined import JoinedParts, distributed
from solidwhirl.reduction.operators.joints.layers import layer_in, with_layer
from solidwhirl.reduction.operators.joints.press_fits import (
    Settled,
    added_matrices,
    fit_of,
    settle,
)
from solidwhirl.reduction.operators.kinematics import Kinematics
from solidwhirl.reduction.operators.prestress import centrifugal_displacement
from solidwhirl.reduction.solvers.memory import return_free_memory
from solidwhirl.reduction.solvers.vectors import project
from solidwhirl.rotordyn.core.arrays import FloatArray, Matrix
from solidwhirl.rotordyn.superelement.rigid_body import RIGID_TURN


@dataclass(frozen=True, kw_only=True)
class OperatorEffects:
    """Which matrices are assembled."""

    gyroscopic: bool
    #: Prestress solve, Kσ and S; the two belong together in the inertial frame, so there is no
    #: switch for one of them alone
    centrifugal: bool
    #: Rigid motions that each interface carries, some of ux, uy, uz, rx, ry, rz
    components: Mapping[str, tuple[str, ...]]
    #: Of a solid: "cyclic" is a sector; on a mesh of the whole "round" is of revolution, "any" does
    #: not turn and may have any shape, "asymmetric" does, in the frame that turns with it
    shape: str = "cyclic"
    #: Of a body of joined parts: whether the orders next to the index are taken in where they meet
    neighbours: bool = False
    #: How systems of a solid are solved, see `solidwhirl.reduction.operators.solver_choice`
    solver: str = "auto"
    #: Largest speed, to which pressed faces of joints are looked at
    maximum_speed_rad_s: float = 0.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Ingredients:
    """What the matrices of a body are assembled from."""

    kinematics: Kinematics
    matter: forms.Medium
    facet_tags: Mapping[str, Any]
    centrifugal_field: Any  #: Displacement at unit speed (Function), None without it
    effects: OperatorEffects
    component_mass: Any  #: M of one component of u on all nodes, PETSc
    joints: Settled  #: Of the body, at rest


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyOperators:
    """Operators of one body, one circumferential order, on any communicator.

    The unknowns û are the displacement degrees of freedom, of which those on rigid interfaces are
    replaced by their master's motions.
    """

    level: str
    #: Circumferential order of a meridian, cyclic index of a sector, None for the whole solid
    harmonic: int | None
    #: Whether the matrices are those of the axes that turn with the body
    rotating: bool
    #: Copies of the unknowns (2: cos and sin family, or the plane of x and that of y, with the same
    #: matrices)
    families: int
    mass: Any
    stiffness: Any
    gyroscopic: Any  #: G (one family) or N of G = [[0, 2N], [-2N, 0]] (two); None if not asked
    #: Kσ and S at unit speed; None if not asked
    stress_stiffening: Any
    spin_softening: Any
    #: Whole solid only: ∫ ρ Jv·Ju with J the generator of a turn of the whole field; its Rayleigh
    #: quotient over M is the square of a mode's circumferential order
    circulation: Any
    turn: Any  #: Whole solid only: ∫ ρ v·Ju
    coupling: Coupling  #: Interface rows B and the displacement u = T û
    #: Whole solid: what the prestress was solved with, and the basis takes over; None without it
    held: HeldBody | None
    #: Rigid motions about the origin by component, local rows of û
    rigid_motions: Mapping[str, Matrix]
    #: Component of the first family to (component, sign) of the second
    second_family: Mapping[str, tuple[str, float]]
    #: Largest hoop strain of the centrifugal field at unit speed (per (rad/s)²), 0 without it
    hoop_strain: float
    #: Solid: (6, 6) mass matrix of the mesh for the rigid motions about the origin; None on the
    #: meridian, whose straight edges hold the profile exactly
    rigid_mass: FloatArray | None
    #: Unknowns before reduction: of the whole solid, or of all families of what is meshed of it
    full_dofs: int
    space: Any
    ingredients: Ingredients
    assembled: tuple[str, ...]

    @property
    def comm(self) -> Any:
        """mpi4py communicator."""
        return self.space.mesh.comm

    def release(self) -> None:
        """Free the matrices, which Python alone would not, on all ranks; then they are gone."""
        comm = self.mass.comm
        compat.collect_garbage(comm)
        own = (getattr(self, name) for name in _MATRICES)
        factor = None if self.held is None else self.held.factor
        for made in (*own, self.ingredients.component_mass, factor):
            if made is not None:
                made.destroy()
        self.coupling.unknowns.destroy()
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
    order n on a meridian mesh, cyclic index h on that of a sector, None on a mesh of the whole
    solid. Raises ReductionError: interfaces that can not be coupled; joints, see `settle`.
    """
    about = None
    if mesh is not None:
        heavy = np.column_stack([mesh.points[mesh.mass_nodes], mesh.node_masses_kg])
        about = (mesh.dimension, mesh.sector, mesh.materials, heavy)
    dimension, sector, materials, heavy = comm.bcast(about, root=0)
    domain, material_tags, facet_tags, joined = distributed(mesh, dimension, len(materials), comm)
    if joined is not None and effects.neighbours and order == 1:
        joined = joined.every_order()
    kin = _kinematics(domain, order, sector, joined)
    matter = replace(forms.medium(domain, material_tags, materials), point_masses=heavy)
    space = compat.vector_space(domain, degree, 3)
    coupling = couple(space, kin, facet_tags, body.interfaces, effects.components, effects.shape)
    joints = Settled()
    if body.joints:
        own: tuple[Any, forms.Medium, Any] = (space, matter, facet_tags)
        meridian = own if dimension == 2 else _meridian_of(mesh, degree, comm)
        found = settle(*meridian, body.joints, materials, effects.maximum_speed_rad_s, order or 0)
        joints = _in_body(*own, kin, found)
    if order is None:
        assembly = _assemble_solid(space, kin, matter, degree, effects, coupling)
    else:
        assemble = _assemble_meridian if dimension == 2 else _assemble_sector
        assembly = assemble(space, kin, matter, degree, effects, coupling, joints)
    return BodyOperators(
        level="solid" if dimension == 3 else "harmonic",
        harmonic=order,
        rotating=effects.shape == "asymmetric",
        families=kin.families,
        **{name: assembly.matrices.get(name) for name in _MATRICES},
        coupling=coupling,
        held=assembly.held,
        rigid_motions=coupling.rigid_motions,
        second_family=kin.second_family,
        hoop_strain=assembly.hoop_strain,
        rigid_mass=assembly.rigid_mass,
        full_dofs=_full_dofs(space, kin, coupling.unknowns),
        space=space,
        ingredients=Ingredients(
            kinematics=kin,
            matter=matter,
            facet_tags=facet_tags,
            centrifugal_field=assembly.centrifugal_field,
            effects=effects,
            component_mass=assembly.component_mass,
            joints=joints,
        ),
        assembled=assembly.ledger,
    )


def _meridian_of(mesh: Mesh | None, degree: int, comm: Any) -> tuple[Any, forms.Medium, Any]:
    """Space, material and facets of the meridian that a solid with joints was revolved from."""
    if mesh is None or mesh.meridian is None:
        raise ReductionError("joints are of bodies of revolution, on one process")
    domain, tags, facets = compat.distribute(mesh.meridian, 2, comm)
    space = compat.vector_space(domain, degree, 3)
    return space, forms.medium(domain, tags, mesh.materials), facets


def _at_rest(space: Any, kin: Kinematics) -> Kinematics:
    """Kinematics of what the spin and pressed faces load a body with: of order or index 0.

    The answer is that of any factor on both the stiffness and the load.
    """
    if kin.dimension == 2:
        return kin if kin.harmonic == 0 else kinematics.harmonic(space.mesh, 0)
    assert kin.cyclic is not None
    # of half a sector the symmetric part; the amplitudes of joints are not told apart
    symmetric = kin.cyclic.sector.mirrored and kin.joined is None
    index = replace(kin.cyclic, index=0, symmetric=symmetric)
    return replace(kinematics.sector(space.mesh, index, kin.joined), weight=kin.weight)


def _in_body(
    space: Any, matter: forms.Medium, facet_tags: Mapping[str, Any], kin: Kinematics, found: Settled
) -> Settled:
    """Joints with their springs in the space of the body, and its state at rest."""
    layer, fit = layer_in(space, facet_tags, found.springs), None
    if layer is not None and found.pressing is not None:
        around = _at_rest(space, kin)
        dx = forms.measure(space.mesh, kin, compat.polynomial_degree(space))
        stiffness = _stiffness(space, around, matter, dx)
        fit = fit_of(space, around, stiffness, layer.points, found.pressing)
    return replace(found, layer=layer, fit=fit)


def _kinematics(
    domain: Any, order: int | None, sector: Sector | None, joined: JoinedParts | None
) -> Kinematics:
    """Kinematics of a meridian, of the whole solid, or of one cyclic index of a sector."""
    if domain.topology.dim == 2:
        return kinematics.harmonic(domain, order or 0)
    if order is None:
        return kinematics.solid(domain)
    assert sector is not None
    return kinematics.sector(domain, CyclicIndex(sector=sector, index=order), joined)


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
    held: HeldBody | None = None


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
    joints: Settled,
) -> _Assembly:
    """Assemble one circumferential order: what the effects ask for, nothing else."""
    field, hoop, prestress, layer = None, 0.0, None, joints.layer
    dx = forms.measure(space.mesh, kin, degree)
    if effects.centrifugal:
        around = _at_rest(space, kin)
        static = with_layer(
            _stiffness(space, around, matter, dx), layer and layer.static_stiffness(around)
        )
        field, hoop = centrifugal_displacement(space, around, matter, dx, static)
        static.destroy()
        prestress = forms.stress(around, matter, field)
        layer = layer and layer.loaded(compat.owned_values(field))
    added = added_matrices(space, kin, matter, layer, joints.fit)
    matrices = meridian_matrices(space, kin, matter, effects, prestress, coupling.unknowns, added)
    return _Assembly(
        matrices=matrices,
        centrifugal_field=field,
        hoop_strain=hoop,
        rigid_mass=None,
        component_mass=solid_matrices.component_mass(space, kin, matter, dx),
        ledger=_ledger(kin, matrices, prestressed=effects.centrifugal),
    )


def _assemble_sector(
    space: Any,
    kin: Kinematics,
    matter: forms.Medium,
    degree: int,
    effects: OperatorEffects,
    coupling: Coupling,
    joints: Settled,
) -> _Assembly:
    """Assemble one cyclic index of a sector: what the effects ask for, nothing else."""
    assert kin.cyclic is not None
    field, hoop, prestress, layer = None, 0.0, None, joints.layer
    dx = forms.measure(space.mesh, kin, degree)
    stiffness = _stiffness(space, kin, matter, dx)
    if effects.centrifugal:
        around = _at_rest(space, kin)
        static = with_layer(stiffness.copy(), layer and layer.static_stiffness(around))
        field, hoop = centrifugal_displacement(space, around, matter, dx, static)
        prestress = forms.stress(kin, matter, field)
        layer = layer and layer.loaded(compat.owned_values(field))
    one = solid_matrices.component_mass(space, kin, matter, dx)
    added = added_matrices(space, kin, matter, layer, joints.fit)
    matrices = sector_matrices(space, kin, (stiffness, one), dx, effects, prestress,
                               coupling.unknowns, added)  # fmt: skip
    # these are factorised
    matrices |= {name: matrices[name].folded() for name in ("stiffness", "mass")}
    share = kin.cyclic.mesh_copies / kin.cyclic.weight
    return _Assembly(
        matrices=matrices,
        centrifugal_field=field,
        hoop_strain=hoop,
        rigid_mass=share * turned_mean(_rigid_mass(space, one, kin.joined)),
        component_mass=one,
        ledger=_ledger(kin, matrices, prestressed=effects.centrifugal),
    )


def _stiffness(space: Any, kin: Kinematics, matter: forms.Medium, dx: Any) -> Any:
    """K of all of u."""
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    return assembled(forms.stiffness_form(kin, matter, u, v, dx))


def _ledger(kin: Kinematics, matrices: Mapping[str, Any], *, prestressed: bool) -> tuple[str, ...]:
    """What was assembled for one order, and solved for its prestress."""
    # of a sector the mass and the terms of the spin follow from the mass of one component
    made = () if kin.cyclic is None else ("mass", "gyroscopic", "spin_softening")
    static = ("prestress",) if prestressed else ()
    if prestressed and kin.cyclic is None:
        static = ("axisymmetric_stiffness", *static)
    return (*(name for name in matrices if name not in made), "component_mass", *static)


def meridian_matrices(
    space: Any,
    kin: Kinematics,
    matter: forms.Medium,
    effects: OperatorEffects,
    prestress: Any,
    unknowns: Unknowns,
    added: Mapping[str, Any],
) -> dict[str, Any]:
    """Return the matrices of one circumferential order by name.

    `prestress`: stress at unit speed (UFL), None without it. `added`: what joints add to them, by
    name, matrices of all of u, which are used up.
    """
    u, v, dx = _arguments(space, kin, compat.polynomial_degree(space))
    wanted = {
        "stiffness": forms.stiffness_form(kin, matter, u, v, dx),
        "mass": forms.mass_form(kin, matter, u, v, dx),
    }
    if effects.gyroscopic:
        wanted["gyroscopic"] = forms.gyroscopic_form(kin, matter, u, v, dx)
    if prestress is not None:
        wanted["stress_stiffening"] = forms.stiffening_form(kin, prestress, u, v, dx)
        wanted["spin_softening"] = forms.softening_form(kin, matter, u, v, dx)
    return {
        name: unknowns.folded(with_layer(assembled(form), added.get(name)))
        for name, form in wanted.items()
    }


def sector_matrices(
    space: Any,
    kin: Kinematics,
    parts: tuple[Any, Any],
    dx: Any,
    effects: OperatorEffects,
    prestress: Any,
    unknowns: Unknowns,
    added: Mapping[str, Any],
) -> dict[str, Any]:
    """Return the matrices of one cyclic index of a sector, or of a whole solid in its own axes.

    A turn of the frame multiplies the amplitudes of index 1 by a phase, so that what is constant in
    the frame that turns with the body is so in the fixed one too (multi-blade coordinates): with
    C = ∫ρ v·(e_z×u), N = M - iC and S = ∫ρ (e_z×v)·(e_z×u) + M - 2iC the matrices are those of the
    meridian, in inertial coordinates. Real fields, as of index 0 and of a whole solid, have G = 2C
    and S = ∫ρ (e_z×v)·(e_z×u).

    `parts`: K of all of u, and M of one component. `prestress`: stress at unit speed (UFL), None
    without it. `added`: as in `meridian_matrices`. Returned: operators that are products with
    blocks; `folded` makes matrices of them.
    """
    stiffness, one = with_layer(parts[0], added.get("stiffness")), parts[1]
    matrices: dict[str, Any] = {
        "stiffness": solid_matrices.SectorStiffness(unknowns=unknowns, matrix=stiffness),
        "mass": solid_matrices.sector_componentwise(unknowns, one),
    }
    for name, found in solid_matrices.sector_spin(unknowns, kin.families, one).items():
        if effects.gyroscopic if name == "gyroscopic" else effects.centrifugal:
            matrices[name] = found
    if prestress is not None:
        stiffening = solid_matrices.component_stiffening(space, kin, prestress, dx)
        found = solid_matrices.sector_componentwise(unknowns, stiffening)
        if "stress_stiffening" in added:
            found = replace(found, beside=added["stress_stiffening"])
        matrices["stress_stiffening"] = found
    return matrices


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
    unknowns = coupling.unknowns
    # derivatives along the spin are those of a body of revolution
    along = effects.shape == "round"
    parts = solid_matrices.component_matrices(space, kin, matter, dx, along_spin=along)
    ledger, field, hoop = ["stiffness", "mass"], None, 0.0
    ledger += ["spin", "spin_softening"] if along else []
    names = ["mass", *(["circulation", "turn"] if along else [])]
    spin = {} if along else solid_matrices.sector_spin(unknowns, 1, parts.mass)
    matrices: dict[str, Any] = {}
    for name, wanted in (
        ("gyroscopic", effects.gyroscopic),
        ("spin_softening", effects.centrifugal),
    ):
        if wanted and along:
            names.append(name)
        elif wanted:
            matrices[name] = spin[name]
    for name in names:
        matrices[name] = unknowns.folded(solid_matrices.vector_matrix(name, parts))
    stiffness = assembled(forms.stiffness_form(kin, matter, u, v, dx))
    matrices["stiffness"] = unknowns.folded_copy(stiffness)
    held = None
    if effects.centrifugal:
        held = held_body(matrices["stiffness"], matrices["mass"], coupling, effects.solver)
        # of a body of revolution point masses are on the axis, where they pull at nothing
        pulling = replace(matter, point_masses=matter.point_masses[:0]) if along else matter
        field, hoop = centrifugal_displacement(
            space, kin, pulling, dx, stiffness, parts.mass, solver=effects.solver, held=held
        )
        prestress = forms.stress(kin, matter, field)
        stiffening = solid_matrices.component_stiffening(space, kin, prestress, dx)
        matrices["stress_stiffening"] = solid_matrices.sector_componentwise(unknowns, stiffening)
        ledger += ["prestress", "stress_stiffening"]
    if stiffness is not matrices["stiffness"]:
        stiffness.destroy()
    return _Assembly(
        matrices=matrices,
        centrifugal_field=field,
        hoop_strain=hoop,
        rigid_mass=_rigid_mass(space, parts.mass),
        component_mass=parts.mass,
        ledger=tuple(ledger),
        held=held,
    )


def _full_dofs(space: Any, kin: Kinematics, unknowns: Unknowns) -> int:
    """Unknowns before reduction."""
    if kin.cyclic is None:
        return int(3 * space.dofmap.index_map.size_global * kin.families)
    return int(space.mesh.comm.allreduce(unknowns.count)) * kin.families


def _rigid_mass(space: Any, mass: Any, joined: JoinedParts | None = None) -> FloatArray:
    """Rᵀ M R with the six rigid motions R of the solid, M given by component; of copies none."""
    motions = motion_vectors(space, replace(kinematics.solid(space.mesh), joined=joined), 0.0)
    values = np.column_stack(list(motions.values())).reshape(-1, 3, len(motions))
    comm = space.mesh.comm
    return np.asarray(np.sum([project(mass, values[:, i], comm) for i in range(3)], axis=0))


def turned_mean(rigid_mass: FloatArray) -> FloatArray:
    """Mean of a (6, 6) rigid mass matrix over turns about the axis."""
    lateral = RIGID_TURN.any(axis=0)
    out = np.where(lateral[:, None] == lateral, rigid_mass, 0.0)
    both = np.ix_(lateral, lateral)
    out[both] = 0.5 * (rigid_mass + RIGID_TURN.T @ rigid_mass @ RIGID_TURN)[both]
    return np.asarray(out)


def assembled(form: Any) -> Any:
    """Matrix of a UFL form."""
    return compat.assemble_matrix(compat.compiled(form))
