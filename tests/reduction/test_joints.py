"""Layers of springs between sections, against closed forms, bonded bodies and the other level."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as sla
from mpi4py import MPI

from solidwhirl.geometry import Body, Joint, Material, Section
from solidwhirl.meshing import MeshSize, mesh_meridian, mesh_revolved
from solidwhirl.meshing.imported.body import body_of_mesh, mesh_of
from solidwhirl.meshing.imported.formats.step import mesh_step, step_geometry
from solidwhirl.meshing.imported.records import StepSize
from solidwhirl.reduction import ReductionError, ReductionRequest
from solidwhirl.reduction.body.reduced_order import reduce_order
from solidwhirl.reduction.operators import compat
from solidwhirl.reduction.operators.joints.layers import layer_in, with_layer
from solidwhirl.reduction.operators.matrices import OperatorEffects, build_operators
from solidwhirl.reduction.residuals.residual_energy import lift_energy
from solidwhirl.reduction.solvers.vectors import Operator, apply, project

sys.path.append(str(Path(__file__).parents[1] / "meshing"))

from mesh_makers import drawn, request

E, RHO = 2.0e11, 7800.0
STEEL = Material(name="own", density_kg_per_m3=RHO, youngs_modulus_pa=E, poissons_ratio=0.3)
#: The same by another name: nodes between materials stay on arcs, as those on a joint do.
ALIKE = replace(STEEL, name="alike")
#: Without contraction a finite cylinder that spins is in Lamé's plane stress exactly.
CORK = Material(name="cork", density_kg_per_m3=RHO, youngs_modulus_pa=E, poissons_ratio=0.0)
BORE, SEAT, RIM, LENGTH = 0.02, 0.05, 0.12, 0.06
FIT = Joint(between=("shaft", "hub"), interference_m=5e-5)


def ring(name: str, start: float, end: float, inner: float, outer: float, matter=STEEL) -> Section:
    return Section(
        name=name,
        start_m=start,
        end_m=end,
        inner_radius_m=(inner, inner),
        outer_radius_m=(outer, outer),
        material=matter,
    )


def fitted(joint: Joint | None, matter: Material = STEEL, beyond: float = 0.0) -> Body:
    """A hub on a hollow shaft that is longer at both ends."""
    parts = (
        ("shaft", -beyond, LENGTH + beyond, BORE, SEAT),
        ("hub", 0.0, LENGTH, SEAT, RIM),
    )
    return Body(
        name="fit",
        sections=tuple(ring(*part, matter) for part in parts),
        joints=() if joint is None else (joint,),
    )


def operators(
    body: Body,
    order: int,
    *,
    size: float = 0.01,
    degree: int = 3,
    top: float = 500.0,
    mesher=mesh_meridian,
):
    effects = OperatorEffects(
        gyroscopic=True, centrifugal=True, components={}, maximum_speed_rad_s=top
    )
    mesh = mesher(body, MeshSize(size_m=size, corner_size_m=size))
    return build_operators(body, mesh, MPI.COMM_SELF, order=order, degree=degree, effects=effects)


def state_of(body: Body, **asked: float):
    return operators(body, 0, **asked).ingredients.joints.states[0]


def sparse(matrix) -> sp.csr_matrix:
    matrix = matrix.folded() if isinstance(matrix, Operator) else matrix
    indptr, columns, values = matrix.getValuesCSR()
    return sp.csr_matrix((values, columns, indptr), matrix.getSize())


def solid(body: Body, order: int, *, size: float = 0.02, degree: int = 2, top: float = 500.0):
    return operators(body, order, size=size, degree=degree, top=top, mesher=mesh_revolved)


def elastic_hz(found, speed: float = 0.0) -> np.ndarray:
    k, m = sparse(found.stiffness), sparse(found.mass)
    k = k + speed**2 * (sparse(found.stress_stiffening) - sparse(found.spin_softening))
    values = sla.eigsh(k + 1e6 * m, 8, m, sigma=0.0, return_eigenvectors=False) - 1e6
    return np.sqrt(np.sort(values)[2:]) / (2.0 * np.pi)


def lame_pressure(overlap: float) -> float:
    """Of two cylinders of one material (Timoshenko, Strength of Materials II, art. 41)."""
    a, b, c = BORE**2, SEAT**2, RIM**2
    return E * overlap / SEAT * (c - b) * (b - a) / (2.0 * b * (c - a))


@pytest.mark.parametrize("order", [0, 1, 2])
def test_a_stiff_layer_is_bonded(order: int) -> None:
    bonded = operators(fitted(None, beyond=0.05), order, size=0.02)
    stiff = Joint(between=("shaft", "hub"), stiffness_n_per_m3=(1e19, 1e19))
    found = operators(fitted(stiff, beyond=0.05), order, size=0.02)
    for speed in (0.0, 500.0):
        assert elastic_hz(found, speed) == pytest.approx(elastic_hz(bonded, speed), rel=1e-6)
    loosely = fitted(replace(FIT, interference_m=1e-8), beyond=0.05)
    pressed = operators(loosely, order, size=0.02, top=0.0)
    assert elastic_hz(pressed) == pytest.approx(elastic_hz(bonded), rel=1e-6)


def test_a_stiff_layer_in_a_solid_is_bonded() -> None:
    def made(joint: Joint | None) -> Body:
        shaft, hub = fitted(joint, beyond=0.05).sections
        sections = (shaft, replace(hub, material=ALIKE))
        return Body(name="fit", sections=sections, joints=() if joint is None else (joint,))

    bonded = solid(made(None), 1)
    stiff = solid(made(Joint(between=("shaft", "hub"), stiffness_n_per_m3=(1e19, 1e19))), 1)
    for speed in (0.0, 500.0):
        assert elastic_hz(stiff, speed) == pytest.approx(elastic_hz(bonded, speed), rel=1e-6)


def test_a_soft_layer_in_a_solid_is_that_of_the_meridian() -> None:
    """With finer elements the solid comes down to the frequencies that the meridian has."""
    body = fitted(Joint(between=("shaft", "hub"), stiffness_n_per_m3=(1e13, 5e12)), beyond=0.05)
    exact = elastic_hz(operators(body, 1, size=0.02, degree=5), 500.0)[:3]
    coarse, fine = (
        elastic_hz(solid(body, 1, size=h), 500.0)[:3] / exact - 1 for h in (0.03, 0.015)
    )
    assert (fine > 0.0).all()
    assert (fine < 5e-3).all()
    assert (np.log2(coarse / fine) > 1.5).all()


def test_a_soft_layer_softens() -> None:
    stiff, soft = (
        elastic_hz(
            operators(
                fitted(Joint(between=("shaft", "hub"), stiffness_n_per_m3=(k, k)), beyond=0.05), 1
            )
        )
        for k in (1e15, 1e13)
    )
    assert (soft < 0.99 * stiff)[:2].all()


@pytest.mark.parametrize("made", [operators, solid])
def test_patch_of_a_pulled_stack(made) -> None:
    """Uniform stress with a jump t/k on a plane face is a solution, to rounding."""
    tension, springs = 1e6, (3e12, 1e12)
    found = made(flanged(Joint(between=("shaft", "hub"), stiffness_n_per_m3=springs)), 0)
    x = found.space.tabulate_dof_coordinates()
    flat = found.level == "harmonic"
    z, across = (x[:, 0], x[:, [1]] * [1.0, 0.0]) if flat else (x[:, 2], x[:, :2])
    cells = compat.cell_unknowns(found.space).reshape(
        len(compat.curved_cells(found.space.mesh)[1]), -1
    )
    above = np.zeros(len(x), dtype=bool)
    above[cells[z[cells].mean(axis=1) > 0.1]] = True
    strain = tension / E
    u = np.column_stack(
        [-0.3 * strain * across, strain * z + above * tension / springs[0]]
    ).reshape(-1, 1)
    unknowns = found.coupling.unknowns
    force = apply(found.stiffness, unknowns.of_displacement(u))
    inside = unknowns.of_displacement(np.repeat((z > 1e-9) & (z < 0.25 - 1e-9), 3)[:, None] * 1.0)
    assert np.abs(force[inside[:, 0] != 0.0]).max() < 1e-10 * np.abs(force).max()
    pulled = unknowns.of_displacement(np.outer(z > 0.249, [0.0, 0.0, 1.0]).reshape(-1, 1))
    # arcs are parabolas in the solid
    area = found.ingredients.joints.layer.points.area_m2.sum() * (
        2.0 * np.pi if flat else found.ingredients.kinematics.cyclic.weight
    )
    assert area == pytest.approx(np.pi * (SEAT**2 - BORE**2), rel=1e-6)
    assert np.vdot(pulled, force).real == pytest.approx(tension * area, rel=1e-10)


def coned(joint: Joint) -> Body:
    """A hub on a conical seat."""
    shaft = replace(ring("shaft", 0.0, LENGTH, BORE, SEAT), outer_radius_m=(0.04, 0.055))
    hub = replace(ring("hub", 0.0, LENGTH, SEAT, RIM), inner_radius_m=(0.04, 0.055))
    return Body(name="cone", sections=(shaft, hub), joints=(joint,))


def flanged(joint: Joint) -> Body:
    """Two rings on one plane."""
    parts = (("shaft", 0.0, 0.1, BORE, SEAT), ("hub", 0.1, 0.25, BORE, SEAT))
    return Body(name="flange", sections=tuple(ring(*part) for part in parts), joints=(joint,))


@pytest.mark.parametrize("level", [operators, solid])
@pytest.mark.parametrize("made", [fitted, coned])
def test_a_tilt_costs_no_force_at_speed(made, level) -> None:
    """The traction of the layer turns with its face, else the two centrifugal effects differ."""
    found = level(made(Joint(between=("shaft", "hub"), stiffness_n_per_m3=(1e13, 3e12))), 1)
    tilt = found.rigid_motions["ry"][:, None]
    softening = apply(found.spin_softening, tilt)
    left = apply(found.stress_stiffening, tilt) - softening
    assert np.abs(left).max() < 1e-11 * np.abs(softening).max()


def turns_of_each(found, motion: str) -> np.ndarray:
    """(local û, 2) a rigid turn of the shaft alone, and of the hub alone."""
    x = found.space.tabulate_dof_coordinates()
    flat = found.level == "harmonic"
    z, r = (x[:, 0], x[:, 1]) if flat else (x[:, 2], np.hypot(x[:, 0], x[:, 1]))
    cells = compat.cell_unknowns(found.space).reshape(
        len(compat.curved_cells(found.space.mesh)[1]), -1
    )
    # the seat of `fitted`, or of `coned`: nothing of the shaft is outside of it
    layer = found.ingredients.joints.layer.points.places_m
    seat = np.polyfit(*layer.T, 1)
    hub = np.zeros(len(x), dtype=bool)
    hub[cells[(r - np.polyval(seat, z))[cells].mean(axis=1) > 0.0]] = True
    unknowns = found.coupling.unknowns
    whole = unknowns.displacement(found.rigid_motions[motion][:, None])
    parts = [np.repeat(part, 3)[:, None] * whole for part in (~hub, hub)]
    return np.hstack([unknowns.of_displacement(part) for part in parts])


@pytest.mark.parametrize("level", [operators, solid])
@pytest.mark.parametrize("motion", ["rz", "ry"])
@pytest.mark.parametrize("made", [fitted, coned])
def test_turning_one_side_against_the_other_costs_the_springs_alone(made, motion, level) -> None:
    """A traction between two bodies has no moment on either that turns with half of their turn."""
    body = made(Joint(between=("shaft", "hub"), stiffness_n_per_m3=(1e13, 3e12)))
    found = level(body, 0 if motion == "rz" else 1)
    turns = turns_of_each(found, motion)
    softening = project(found.spin_softening, turns, MPI.COMM_SELF)
    left = project(found.stress_stiffening, turns, MPI.COMM_SELF) - softening
    # what either body has of its stress alone is as large as what it has of the spin
    assert np.abs(left).max() < 1e-10 * np.abs(softening).max()


@pytest.mark.parametrize("level", [operators, solid])
@pytest.mark.parametrize("motion", ["rz", "ry"])
def test_a_pressure_has_no_moment_on_a_hub_that_turns_on_its_shaft(motion, level) -> None:
    """The same of the stress at rest."""
    found = level(fitted(FIT), 0 if motion == "rz" else 1, top=0.0)
    own = found.ingredients
    assert own.joints.fit is not None
    pressed = own.joints.fit.stiffening(
        found.space, own.kinematics, own.matter, own.joints.layer.points
    )
    stiffening = found.coupling.unknowns.folded_copy(pressed)
    left = project(stiffening, turns_of_each(found, motion), MPI.COMM_SELF)
    # of one body alone it is the pressure times the face and its lever
    moment = lame_pressure(5e-5) * SEAT * 2.0 * np.pi * SEAT * LENGTH
    assert np.abs(left).max() < 1e-9 * moment


@pytest.mark.parametrize("level", [operators, solid])
def test_a_hub_turns_on_its_tangential_springs_at_one_frequency(level) -> None:
    """Two rigid bodies on k r² A, at every speed; of elastic ones it is lower by 1e-4."""
    along = 1e9
    found = level(fitted(Joint(between=("shaft", "hub"), stiffness_n_per_m3=(1e13, along))), 0)
    shaft, hub = (
        0.5 * np.pi * RHO * LENGTH * (b**4 - a**4) for a, b in ((BORE, SEAT), (SEAT, RIM))
    )
    spring = along * 2.0 * np.pi * SEAT**3 * LENGTH
    exact = np.sqrt(spring * (1.0 / shaft + 1.0 / hub)) / (2.0 * np.pi)
    # the first that is elastic moves along the axis
    at_rest, spun = (elastic_hz(found, speed)[1] for speed in (0.0, 900.0))
    assert at_rest == pytest.approx(exact, rel=3e-4)
    assert spun == pytest.approx(at_rest, rel=1e-5)


def test_the_stress_of_a_fit_stiffens_and_costs_a_tilt_no_force() -> None:
    """Its own geometric stiffness: in proportion to the fit, and none for a rigid tilt."""
    stiffness = []
    for overlap in (1e-5, 2e-5, 3e-5):
        made = fitted(replace(FIT, interference_m=overlap), beyond=0.05)
        found = operators(made, 1, size=0.02, top=0.0)
        k = sparse(found.stiffness)
        assert np.abs(k @ found.rigid_motions["ry"]).max() < 1e-14 * np.abs(k).max()
        stiffness.append(elastic_hz(found) ** 2)
    first, second = np.diff(stiffness, axis=0)
    assert second == pytest.approx(first, rel=1e-2)
    assert (np.abs(first) > 1e-6 * stiffness[0]).any()


def test_a_fit_in_a_solid_is_that_of_the_meridian() -> None:
    """Its stress stiffens as much, costs a tilt no force, and moves the rim as Lamé has it."""
    changes = []
    for made in (operators, solid):
        found = [
            made(fitted(replace(FIT, interference_m=overlap), beyond=0.05), 1, size=0.02, top=0.0)
            for overlap in (1e-5, 1e-4)
        ]
        tilt = apply(found[1].stiffness, found[1].rigid_motions["ry"][:, None])
        assert np.abs(tilt).max() < 1e-14 * np.abs(sparse(found[1].stiffness)).max()
        changes.append(np.diff([elastic_hz(f)[0] ** 2 for f in found]))
    assert changes[1] == pytest.approx(changes[0], rel=0.02)
    found = solid(fitted(FIT, CORK), 0, degree=3)
    field = compat.owned_values(found.ingredients.joints.fit.field).reshape(-1, 3)
    x = found.space.tabulate_dof_coordinates()
    radius = np.hypot(x[:, 0], x[:, 1])
    moved = np.einsum("ni,ni->n", field[:, :2], x[:, :2] / radius[:, None])[radius > RIM - 1e-9]
    pressure = lame_pressure(FIT.interference_m)
    lame = 2.0 * pressure * SEAT**2 * RIM / (E * (RIM**2 - SEAT**2))
    assert moved == pytest.approx(np.full(len(moved), lame), rel=1e-4)


def test_what_lifts_softens_as_estimated() -> None:
    """The estimate of lifted faces against the modes with the springs of the largest speed."""
    top = 4500.0 * np.pi / 30.0
    wheel = Body(
        name="wheel",
        sections=(
            ring("shaft", 0.0, 0.6, 0.0, 0.03),
            ring("hub", 0.25, 0.33, 0.03, 0.06),
            ring("disk", 0.28, 0.30, 0.06, 0.2),
        ),
        joints=(replace(FIT, interference_m=4e-6),),
    )
    request = ReductionRequest(
        level="harmonic", orders=(1,), components=(), degree=2, modes=8,
        maximum_speed_rad_s=top, gyroscopic=True, centrifugal=True,
    )  # fmt: skip
    found, in_solid = (made(wheel, 1, size=0.01, degree=2, top=top) for made in (operators, solid))
    estimate, other = (_lift_estimate(f, request) for f in (found, in_solid))
    # the same places of the face are closed on both levels
    assert other == pytest.approx(estimate, rel=0.02)
    before, springs = elastic_hz(found), found.ingredients.joints.springs
    tags = found.ingredients.facet_tags
    at_rest, at_top = (
        layer_in(found.space, tags, s) for s in (springs, [own.at_top for own in springs])
    )
    with_layer(
        found.stiffness, at_rest.without(at_top).stiffness(found.ingredients.kinematics), -1.0
    )
    change = elastic_hz(found) / before - 1.0
    assert (change[:2] < -1e-3).all()
    assert estimate == pytest.approx(change[:2], rel=0.15)


def _lift_estimate(found, request: ReductionRequest) -> np.ndarray:
    """Relative change of the lowest two frequencies at the largest speed."""
    basis, _ = reduce_order(found, request, np.zeros((0, 3)))
    lifted = lift_energy(found, basis, request.maximum_speed_rad_s)
    n = basis.vectors.shape[1]
    energy = request.maximum_speed_rad_s**4 * lifted.gram.reshape(4, n, 4, n)[3, :, 3]
    k, m = (project(a, basis.vectors, found.comm) for a in (found.stiffness, found.mass))
    values, vectors = scipy.linalg.eigh(k, m)
    return -0.5 * np.diag(vectors.T @ energy @ vectors)[2:4] / values[2:4]


def test_lame_pressure_torque_and_loosening_speed() -> None:
    found = state_of(fitted(FIT, CORK), size=0.006, degree=4)
    pressure = lame_pressure(FIT.interference_m)
    assert found.pressure_pa[0] == pytest.approx(pressure, rel=1e-6)
    assert found.torque_n_m[0] == pytest.approx(
        0.12 * pressure * 2.0 * np.pi * SEAT**2 * LENGTH, rel=1e-6
    )
    # bores of rotating disks: u = ρ Ω² b ((3 + ν) c² + (1 - ν) b²) / 4E and its like of the shaft
    loose = np.sqrt(4.0 * E * 5e-5 / (RHO * SEAT * 3.0 * (RIM**2 - BORE**2)))
    assert found.loose_at_rad_s == pytest.approx(loose, rel=1e-6)
    assert found.mean_pressure_pa[-1] == pytest.approx(
        pressure * (1.0 - (500.0 / loose) ** 2), rel=1e-6
    )
    hoop = pressure * (RIM**2 + SEAT**2) / (RIM**2 - SEAT**2)
    mises = np.sqrt(hoop**2 + pressure**2 + hoop * pressure)
    assert found.stress_pa[0, 1] == pytest.approx(mises, rel=1e-4)


def test_lame_pressure_of_a_fit_as_it_is_drawn(tmp_path: Path) -> None:
    """A steel shaft of 10 mm and a light hub of 30 mm in a STEP file, both without contraction."""
    drawn(tmp_path / "fit.step", 10.0 - 0.02, beyond_mm=0)
    light = replace(CORK, name="light", youngs_modulus_pa=7e10, density_kg_per_m3=2700.0)
    asked = request(
        tmp_path / "fit.step",
        unit_m=1e-3,
        shape="cyclic",
        material=CORK,
        materials=(("hub", light),),
        joints=(Joint(between=("shaft", "hub")),),
        step=StepSize(size_m=0.004, smallest_m=0.001, around=16),
    )
    asked = replace(asked, joints=step_geometry(asked).joints)
    mesh = mesh_of(mesh_step(asked), asked, "fit")
    effects = OperatorEffects(gyroscopic=True, centrifugal=True, components={})
    found = build_operators(
        body_of_mesh("fit", asked, mesh), mesh, MPI.COMM_SELF, order=0, degree=3, effects=effects
    )
    (state,) = found.ingredients.joints.states
    # δ / b = p ((c² + b²) / (c² - b²) / E_hub + 1 / E_shaft)
    flexibility = (0.03**2 + 0.01**2) / (0.03**2 - 0.01**2) / 7e10 + 1.0 / E
    assert state.interference_m == pytest.approx(2e-5, rel=1e-6)
    assert state.mean_pressure_pa[0] == pytest.approx(2e-5 / 0.01 / flexibility, rel=1e-5)
    assert state.pressure_pa[0] == pytest.approx(state.mean_pressure_pa[0], rel=1e-3)


def test_temperature_takes_interference_away() -> None:
    warm = replace(FIT, temperature_difference_k=40.0, expansion_per_k=12e-6)
    found = state_of(fitted(warm), degree=4)
    left = 5e-5 - 40.0 * 12e-6 * SEAT
    assert found.interference_m == pytest.approx(left, rel=1e-12)
    assert found.mean_pressure_pa[0] == pytest.approx(lame_pressure(left), rel=1e-5)


def test_a_mean_pressure_is_met() -> None:
    asked = Joint(between=("shaft", "hub"), pressure_pa=3e7, over_m=(0.01, 0.04))
    found = state_of(fitted(asked, beyond=0.05))
    assert found.mean_pressure_pa[0] == pytest.approx(3e7, rel=1e-9)
    assert found.area_m2 == pytest.approx(2.0 * np.pi * SEAT * 0.03, rel=1e-12)


def test_the_ends_of_a_long_hub_lift_first() -> None:
    found = state_of(fitted(FIT), top=1490.0)
    assert found.lifts_at_rad_s < 1490.0 < found.loose_at_rad_s
    assert 0.0 < found.lifted_part[-1] < 1.0
    assert (found.pressure_pa >= 0.0).all()
    # between the speeds of first lift and of the loose hub the pressure is no line over Ω²
    assert found.lifted_part[:-1].max() == 0.0


def test_a_clamped_flange_keeps_the_force_of_its_bolts() -> None:
    """Contraction of unlike rings redistributes the pressure; its resultant is the bolts'."""
    parts = (("drum", 0.0, 0.05, 0.10, 0.14), ("disk", 0.05, 0.08, 0.03, 0.14))
    body = Body(
        name="flange",
        sections=tuple(ring(*part) for part in parts),
        joints=(Joint(between=("drum", "disk"), pressure_pa=2e8),),
    )
    found = state_of(body, top=800.0)
    assert found.interference_m is None
    assert found.pressure_pa[0] == pytest.approx(2e8, rel=1e-6)
    assert found.mean_pressure_pa == pytest.approx(2e8, rel=1e-6)
    assert np.ptp(found.pressure_pa[-1]) > 1e5


@pytest.mark.parametrize(
    ("joint", "top", "message"),
    [
        (replace(FIT, yield_pa=1.2e8), 100.0, r"section 'hub' yields .* von Mises stress 1\.5"),
        (FIT, 1600.0, r"at 15278.9 rpm joint between 'shaft' and 'hub' is loose, from 1429"),
        (replace(FIT, temperature_difference_k=200.0, expansion_per_k=12e-6), 0.0, "loose at rest"),
    ],
)
def test_refused_fits(joint: Joint, top: float, message: str) -> None:
    with pytest.raises(ReductionError, match=message):
        operators(fitted(joint), 0, top=top)


@pytest.mark.parametrize(
    ("made", "order", "moves"),
    [
        (fitted, 0, "slides along the axis"),
        (coned, 0, "turns about the axis"),
        (fitted, 1, None),
        (coned, 1, None),
        (flanged, 0, "turns about the axis"),
        (flanged, 1, "slides across the axis"),
    ],
)
def test_what_no_spring_along_the_face_holds_is_refused(made, order, moves) -> None:
    """A cone can not slide along the axis; planes slide across it, cylinders and cones do not."""
    body = made(Joint(between=("shaft", "hub"), stiffness_n_per_m3=(1e13, 0.0)))
    if moves is None:
        elastic = elastic_hz(operators(body, order, size=0.02), 100.0)
        assert (elastic > 100.0).all()
        return
    with pytest.raises(ReductionError, match=f"is 0, so that one section {moves} freely against"):
        operators(body, order, size=0.02)


def test_pressed_faces_are_cylinders_or_planes() -> None:
    with pytest.raises(ReductionError, match="neither a cylinder nor a plane"):
        operators(coned(FIT), 0)
    stack = Body(
        name="stack",
        sections=(ring("shaft", 0.0, 0.1, BORE, SEAT), ring("hub", 0.1, 0.2, BORE, SEAT)),
        joints=(FIT,),
    )
    with pytest.raises(ReductionError, match=r"its face is a plane: give the pressure_pa"):
        operators(stack, 0)
