"""Displacement and stress recovered in the solid, against closed forms and across the levels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reduced import requested
from shapes import body as body_of
from shapes import plane, section
from sometimes import often

from solidwhirl.geometry import Blade, Material
from solidwhirl.meshing import MeshSize, mesh_meridian, mesh_revolved
from solidwhirl.meshing.own.features.sector import mesh_sector
from solidwhirl.reduction import reduce_body
from solidwhirl.reduction.recovery.fields import body_fields
from solidwhirl.reduction.recovery.spatial_fields import in_space, values_at
from solidwhirl.reduction.recovery.stress_measures import (
    peak_von_mises,
    principal_stresses,
    von_mises,
)
from solidwhirl.reduction.recovery.stresses import StressRecovery

pytestmark = pytest.mark.solver

E, RHO, SPIN = 2.1e11, 7850.0, 1000.0
# What costs time and is of no matter where one field is looked at.
QUICK = {"modes": 1, "gyroscopic": False}
LATERAL = ("ux", "uy", "rx", "ry")


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def steel(poisson=0.3, name="steel", modulus=E):
    return Material(
        name=name, density_kg_per_m3=RHO, youngs_modulus_pa=modulus, poissons_ratio=poisson
    )


def cylinder(length, outer, inner=0.0, material=None, interfaces=(), sections=(), coupling=None):
    whole = section("all", 0.0, length, inner, outer, material or steel())
    places = interfaces or (("left", 0.0), ("right", length))
    planes = [plane(n, z, coupling or "distributing") for n, z in places]
    return body_of(whole, *sections, interfaces=planes, name="body")


def recovered(body, size, level="harmonic", make=None, **asked):
    """Superelement of a body and the recovery of its fields."""
    from mpi4py import MPI

    mesh = (make or (mesh_meridian if level == "harmonic" else mesh_revolved))(body, size)
    spin = {"maximum_speed_rad_s": SPIN, "gyroscopic": True, "centrifugal": True}
    request = requested(level, **{"components": LATERAL, "modes": 3, **spin, **asked})
    element, _ = reduce_body(body, mesh, MPI.COMM_SELF, request, {})
    return element, StressRecovery(body_fields(body, mesh, request, element))


def even(size, around=12):
    return MeshSize(size_m=size, corner_size_m=size, around=around)


def ring_stress(r, a, b):
    """Radial and hoop stress of a spinning ring or disk with Poisson's ratio 0, every thickness.

    Timoshenko and Goodier, Theory of Elasticity, 3rd ed., section 32, with ν = 0: the stress along
    the axis vanishes and the faces stay plane, so the plane solution is that of the solid.
    """
    c = RHO * SPIN**2 / 8.0
    radial = 3.0 * c * (a**2 + b**2 - a**2 * b**2 / r**2 - r**2)
    return radial, 3.0 * c * (a**2 + b**2 + a**2 * b**2 / r**2) - c * r**2


@pytest.mark.parametrize("degree", often([2, 3], 2))
def test_centrifugal_stress_of_a_ring_converges_to_the_closed_form(degree):
    a, b, errors = 0.03, 0.1, []
    for size in (0.01, 0.005, 0.0025):
        body = cylinder(0.03, b, a, steel(0.0))
        _, recovery = recovered(body, even(size), degree=degree, **QUICK)
        found = recovery.recover(np.zeros(recovery.size), SPIN)
        r = found.points.points_m[:, 1]
        radial, hoop = ring_stress(r, a, b)
        exact = np.column_stack([radial, hoop])
        errors.append(np.abs(found.steady.stress_pa[:, :2] - exact).max() / hoop.max())
        # u = r (σθ − 0 σr) / E, one order more accurate
        moved = r * hoop / E
        assert found.steady.displacement_m[:, 0] == pytest.approx(moved, rel=0.1 * errors[-1])
    # The stress has the order of the elements. Largest error over all nodes, at the bore:
    # 1.6, 0.54, 0.13 % with order 2 (rates 1.6, 2.0); 0.19, 0.036, 0.0044 % with order 3 (2.4, 3.0)
    assert np.log2(errors[1] / errors[2]) > degree - 0.2
    assert np.log2(errors[0] / errors[2]) / 2.0 > degree - 0.4
    assert errors[-1] < {2: 2e-3, 3: 1e-4}[degree]


@pytest.mark.parametrize("level", ["harmonic", "solid"])
def test_centrifugal_stress_at_the_middle_of_a_long_solid_cylinder(level):
    """Generalised plane strain far from the ends; Timoshenko and Goodier, section 119 (by ν)."""
    nu, b, length = 0.3, 0.03, 0.18
    size = even(0.006) if level == "harmonic" else even(0.02)
    _, recovery = recovered(cylinder(length, b, material=steel(nu)), size, level, **QUICK)
    space = in_space(recovery.recover(np.zeros(recovery.size), SPIN), 8)
    middle = np.abs(space.points_m[:, 2] - 0.5 * length) < 0.015
    r = np.hypot(*space.points_m[middle, :2].T)
    c = RHO * SPIN**2 / (8.0 * (1.0 - nu))
    hoop = c * ((3.0 - 2.0 * nu) * b**2 - (1.0 + 2.0 * nu) * r**2)
    radial = c * (3.0 - 2.0 * nu) * (b**2 - r**2)
    axial = 2.0 * c * nu * (b**2 - 2.0 * r**2)
    falling = np.sort(np.column_stack([radial, hoop, axial]), axis=1)[:, ::-1]
    found = principal_stresses(space.steady_stress_pa[middle])
    # the ends are three radii away; what is left is the mesh (measured 0.9 % and, very coarse, 7 %)
    error = np.abs(found - falling) / hoop.max()
    assert error.max() < (0.015 if level == "harmonic" else 0.1)
    assert np.sqrt((error**2).mean()) < (0.005 if level == "harmonic" else 0.03)


def bent_shaft(level, size, **asked):
    """A shaft on two supports pushed at two places between them: pure bending in the middle."""
    radius, length, arm, force = 0.02, 0.24, 0.06, 100.0
    places = (("a", 0.0), ("b", arm), ("c", length - arm), ("d", length))
    body = cylinder(length, radius, interfaces=places)
    element, recovery = recovered(body, size, level, components=("ux", "uy"), **asked)
    load = np.zeros(element.size)
    for name in "bc":
        load[element.interface_index(name, "ux")] = force
    held = [element.interface_index(n, c) for n in "ad" for c in ("ux", "uy")]
    free = np.setdiff1d(np.arange(element.size), held)
    q = np.zeros(element.size)
    q[free] = np.linalg.solve(element.stiffness[np.ix_(free, free)], load[free])
    moment = force * arm / (0.25 * np.pi * radius**4)
    return element, recovery, q, moment, radius, length


@pytest.mark.parametrize("stagger", [0.0, 40.0], ids=["half sector", "whole sector"])
def test_centrifugal_stress_of_blades_is_what_pulls_on_them(stagger):
    """σ A = ∫ ρ Ω² x A dx from there to the tip, of slender blades beyond their roots.

    Saint-Venant: what the root disturbs is gone a chord away from it. Forces across the radial
    line change the stress by (chord / length)² = 1 % at most; their mean is none.
    """
    tip, blades = 0.15, Blade(
        name="blades", on="all", count=8, length_m=0.1, chord_m=(0.01, 0.01),
        thickness_m=(0.006, 0.006), stagger_deg=(stagger, stagger), angle_deg=7.0,
        material=steel(),
    )  # fmt: skip
    body = replace(cylinder(0.02, 0.05, 0.03), features=(blades,))
    size = MeshSize(size_m=0.02, corner_size_m=0.01)
    element, recovery = recovered(body, size, "solid", mesh_sector, components=LATERAL, **QUICK)
    found = recovery.recover(np.zeros(element.size), SPIN)
    space = in_space(found, 8)
    x, y, _ = space.points_m.T
    pulled = []
    for theta in np.radians(7.0) + np.arange(8) * np.pi / 4:  # the whole body
        along = np.array([np.cos(theta), np.sin(theta)])
        out, aside = x * along[0] + y * along[1], y * along[0] - x * along[1]
        own = (out > 0.065) & (out < 0.135) & (np.abs(aside) < 0.0062)
        xx, yy, _, xy, _, _ = space.steady_stress_pa[own].T
        radial = xx * along[0] ** 2 + yy * along[1] ** 2 + 2 * xy * along[0] * along[1]
        pull = RHO * SPIN**2 * (tip**2 - out[own] ** 2) / 2
        assert own.sum() > 50
        np.testing.assert_allclose(radial, pull, atol=0.02 * pull.max())
        assert radial.mean() == pytest.approx(pull.mean(), rel=2e-3)
        pulled.append(radial.mean())
    assert np.ptp(pulled) < 1e-9 * pulled[0]
    # a tilt of the whole is the same in space, wherever the first blade is
    tilt = in_space(recovery.recover(element.rigid_body_modes[:, 3], 0.0), 8)
    surface, points = element.surface, element.surface.faces(8).points_m
    drawn = surface.displacement(element.rigid_body_modes[:, 3], 8)
    for moved, at in ((tilt.displacement_m, tilt.points_m), (drawn, points)):
        np.testing.assert_allclose(moved, np.cross([1.0, 0.0, 0.0], at), atol=1e-7)


@pytest.mark.parametrize("level", ["harmonic", "solid"])
def test_bending_stress_is_moment_times_distance_over_inertia(level):
    size = even(0.006) if level == "harmonic" else even(0.02)
    still = {**QUICK, "centrifugal": False}
    _, recovery, q, per_metre, radius, length = bent_shaft(level, size, **still)
    space = in_space(recovery.recover(q, 0.0), 24)
    middle = np.abs(space.points_m[:, 2] - 0.5 * length) < 0.01
    x, stress = space.points_m[middle, 0], space.stress_pa[middle]
    # pure bending is exact in three dimensions; pushed to +x, the side of +x stretches
    largest = per_metre * radius
    # measured 3e-4, and 1.1e-2 on a solid of two elements across
    tolerance = {"harmonic": 1e-3, "solid": 2e-2}[level]
    assert stress[:, 2] == pytest.approx(per_metre * x, abs=tolerance * largest)
    assert np.abs(np.delete(stress, 2, axis=1)).max() < tolerance * largest
    assert von_mises(stress).max() == pytest.approx(largest, rel=tolerance)


@pytest.mark.parametrize("level", ["harmonic", "solid"])
def test_fields_are_those_of_the_coordinates(level, rng):
    """Rigid interfaces move as they should; energies agree; rigid motion has no stress."""
    places = (("left", 0.0), ("right", 0.15))
    body = cylinder(0.15, 0.03, coupling="rigid")
    every = ("ux", "uy", "uz", "rx", "ry", "rz")
    element, recovery = recovered(
        body, even(0.03, around=8), level, orders=(1, 0), components=every, **QUICK
    )
    q = rng.normal(size=element.size) + 1j * rng.normal(size=element.size)
    found = recovery.recover(q, SPIN)
    space = in_space(found, 12)
    for name, z in places:
        at = np.abs(space.points_m[:, 2] - z) < 1e-12
        own = [element.interface_index(name, c) for c in every]
        arm = space.points_m[at] - [0.0, 0.0, z]
        exact = q[own[:3]] + np.cross(q[own[3:]], arm)
        assert np.abs(space.displacement_m[at] - exact).max() < 1e-12 * np.abs(exact).max()
    energy = 0.5 * np.real(q.conj() @ element.stiffness @ q)
    # one quadrature for both; measured 1e-14
    assert found.strain_energy_j == pytest.approx(energy, rel=1e-11)
    for motion in element.rigid_body_modes[:, element.rigid_body_present].T:
        stresses = [np.abs(t.stress_pa).max() for t in recovery.recover(motion, 0.0).terms]
        assert max(stresses) < 1e-10 * E


def test_a_mode_has_the_same_stress_on_the_meridian_and_on_half_a_solid():
    stresses = []
    for level in ("harmonic", "solid"):
        size = even(0.008) if level == "harmonic" else even(0.02)
        element, recovery = recovered(
            cylinder(0.2, 0.03, 0.015), size, level, components=("ux", "uy"), **QUICK
        )
        held = [element.interface_index(n, c) for n in ("left", "right") for c in ("ux", "uy")]
        free = np.setdiff1d(np.arange(element.size), held)
        block = np.ix_(free, free)
        values, vectors = np.linalg.eig(
            np.linalg.solve(element.mass[block], element.stiffness[block])
        )
        lowest = np.argsort(values.real)[:2]
        # The pair of planes: turned so that the middle moves along x, forward whirl
        q = np.zeros((element.size, 2))
        q[free] = vectors[:, lowest].real
        space = [in_space(recovery.recover(v, 0.0), 16) for v in q.T]
        middle = np.abs(space[0].points_m[:, 2] - 0.1) < 0.02
        mean = np.array([s.displacement_m[middle, :2].mean(axis=0) for s in space])
        q = q @ np.linalg.inv(mean)  # columns: unit mean displacement along x, along y
        whirl = q[:, 0] - 1j * q[:, 1]
        found = recovery.recover(whirl, 0.0)
        space = in_space(found, 16)
        peak = peak_von_mises(space.stress_pa)[0]
        radius = np.hypot(*space.points_m[:, :2].T)
        near = (np.abs(space.points_m[:, 2] - 0.1) < 0.005) & (radius > 0.0299)
        stresses.append(peak[near])
    # a circular whirl stresses every point of a ring alike
    assert np.ptp(stresses[0]) < 0.01 * stresses[0].mean()
    # (measured 0.5 %: the coarse solid)
    assert stresses[1].mean() == pytest.approx(stresses[0].mean(), rel=0.02)


def test_stress_jumps_between_materials_and_is_kept_apart():
    soft = steel(name="soft", modulus=0.5 * E)
    ring = section("ring", 0.0, 0.2, 0.01, 0.02, soft)
    body = cylinder(0.2, 0.01, sections=(ring,), material=steel(0.3))
    every = (*LATERAL, "uz", "rz")
    asked = {"orders": (1, 0), "components": every, **QUICK}
    element, recovery = recovered(body, even(0.006), **asked)
    q = np.zeros(element.size)
    q[element.interface_index("right", "uz")] = 1e-4
    found = recovery.recover(q, 0.0)
    points = found.points
    z, r = points.points_m.T
    border = (np.abs(r - 0.01) < 1e-9) & (np.abs(z - 0.1) < 0.03)
    axial = found.terms[0].stress_pa[:, 2]
    names = np.array(recovery.material_names)[points.point_material]
    # equal strain 5e-4, Poisson's ratios are the same, so each has its own E ε
    for name, modulus in (("steel", E), ("soft", 0.5 * E)):
        own = axial[border & (names == name)]
        assert len(own) > 4
        assert own == pytest.approx(np.full(len(own), modulus * 5e-4), rel=0.01)


def test_order_two_bulges_and_its_stress_turns_with_it(rng):
    """The field of a ring has the same size after a quarter turn, and after two."""
    body = body_of(section("ring", 0.0, 0.05, 0.09, 0.1, steel()))
    element, recovery = recovered(body, even(0.01), orders=(2,), components=(), modes=2)
    q = rng.normal(size=element.size)
    found = recovery.recover(q, 0.0)
    assert {t.order for t in found.terms} == {2}
    theta = np.array([0.3, 0.3 + 0.5 * np.pi, 0.3 + np.pi])
    moved, stress = values_at(found.terms, found.points, theta)
    size = np.linalg.norm(moved, axis=2)
    # (order 2 changes its sign after a quarter turn)
    assert size[1] == pytest.approx(size[0], rel=1e-9)
    assert size[2] == pytest.approx(size[0], rel=1e-9)
    assert von_mises(stress[1]) == pytest.approx(von_mises(stress[0]), rel=1e-9)
    energy = 0.5 * q @ element.stiffness @ q
    assert found.strain_energy_j == pytest.approx(energy, rel=1e-11)


def test_measures_of_stress(rng):
    """Against eigenvalues of the tensors, and against fine sampling of the phase."""
    stress = rng.normal(size=(200, 6))
    tensors = stress[:, np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])]
    values = np.linalg.eigvalsh(tensors)[:, ::-1]
    assert principal_stresses(stress) == pytest.approx(values, abs=1e-12)
    gaps = values - np.roll(values, 1, axis=1)
    assert von_mises(stress) == pytest.approx(np.sqrt(0.5 * (gaps**2).sum(axis=1)), rel=1e-12)
    amplitude = rng.normal(size=(200, 6)) + 1j * rng.normal(size=(200, 6))
    phases = np.linspace(0.0, 2.0 * np.pi, 2000)
    for steady in (None, stress):
        rest = 0.0 if steady is None else steady
        sampled = np.max([von_mises((amplitude * np.exp(1j * p)).real + rest) for p in phases], 0)
        peak, phase = peak_von_mises(amplitude, steady)
        # samples miss the top by up to (π/2000)² / 2 · 4 of it
        assert (peak >= sampled * (1.0 - 1e-12)).all()
        assert peak == pytest.approx(sampled, rel=1e-5)
        there = (amplitude * np.exp(1j * phase)[:, None]).real + rest
        assert von_mises(there) == pytest.approx(peak, rel=1e-12)
