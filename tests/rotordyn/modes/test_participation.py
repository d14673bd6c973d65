"""Shares of bodies and joints in modes: closed forms, sensitivities and balances."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rotors import (
    between_bearings,
    connect,
    general,
    ground,
    hub,
    one_rotor,
    polynomial_law,
    three_disk,
    three_disk_element,
    turning,
    twin,
    with_axial_and_torsion,
)

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.modes.participation import participation

FILM = polynomial_law((1.0, 1e-3), (0.5, 2e-3), (1.0, -1e-4), top=2000.0)


def _sums(result):
    kinetic = result.kinetic_bodies.sum(axis=0)
    stored = result.strain_bodies + result.centrifugal_bodies
    potential = stored.sum(axis=0) + result.strain_joints.sum(axis=0)
    decrement = result.decrement_bodies.sum(axis=0) + result.decrement_joints.sum(axis=0)
    return kinetic, potential, decrement


@pytest.fixture(scope="module")
def chain():
    """Disk on a bearing in a casing on a mount: two masses and two springs in each plane."""
    rotors = {"disk": turning(hub(mass_kg=10.0)), "casing": turning(hub(mass_kg=30.0), 0.0)}
    between = connect("bearing", "disk.hub", "casing.hub", 2e6, tilt=1e6)
    mount = ground("casing", "hub", 5e6, tilt=1e6)
    return rd.assemble(rotors, (between, mount))


def test_two_masses_in_closed_form(chain):
    """Only the two translation modes; the tilt of the disks is far above."""
    result = participation(chain, rd.modes_at_speed(chain, 0.0, 4))
    mass = np.array([10.0, 30.0])
    values, vectors = np.linalg.eig(np.diag(1 / mass) @ np.array([[2e6, -2e6], [-2e6, 7e6]]))
    assert result.bodies == ("disk", "casing")
    assert result.joints == ("bearing", "casing.hub")
    for mode, at in zip((0, 2), np.argsort(values), strict=True):
        u = vectors[:, at]
        kinetic = mass * u**2 / (mass @ u**2)
        strain = np.array([2e6 * (u[0] - u[1]) ** 2, 5e6 * u[1] ** 2])
        for plane in (0, 1):
            found = result.kinetic_bodies[:, mode + plane]
            np.testing.assert_allclose(found, kinetic, rtol=1e-10)
            found = result.strain_joints[:, mode + plane]
            np.testing.assert_allclose(found, strain / strain.sum(), rtol=1e-10)
    # Rigid bodies store nothing.
    assert not result.strain_bodies.any() and not result.centrifugal_bodies.any()


def test_strain_share_is_the_sensitivity_to_the_stiffness():
    """∂ ln ω² / ∂ ln k of an undamped mode at rest is the share of that spring."""

    def build(factor):
        bearings = [ground("rotor", "left", 7e7 * factor, 5e7), ground("rotor", "right", 7e7, 5e7)]
        return one_rotor(three_disk_element(), bearings)

    step = 1e-4
    low, high = (rd.modes_at_speed(build(f), 0.0, 6).frequency_hz for f in (1 - step, 1 + step))
    slope = 2 * np.log(high / low) / np.log((1 + step) / (1 - step))
    system = build(1.0)
    modes = rd.modes_at_speed(system, 0.0, 6)
    result = participation(system, modes)
    # The spring along x takes part in modes of the plane of x alone.
    in_x = slope > 1e-6
    assert in_x.sum() == 3
    # Central differences: error of second order in the step, 1e-8 times small factors.
    np.testing.assert_allclose(result.strain_joints[0, in_x], slope[in_x], rtol=1e-6)


@pytest.mark.parametrize("speed", [0.0, 1200.0])
def test_twin_rotor_adds_up(speed):
    system = twin()
    result = participation(system, rd.modes_at_speed(system, speed, 8))
    kinetic, potential, decrement = _sums(result)
    np.testing.assert_allclose(kinetic, 1.0, rtol=1e-12)
    # Supports of 1e10 N/m are coordinates of their own, so they cost no digits.
    np.testing.assert_allclose(potential, 1.0, rtol=1e-12)
    assert np.abs(decrement).max() < 1e-15


@pytest.mark.parametrize("law", [None, FILM])
def test_parts_of_the_decrement_add_up_to_it(law):
    """Damped bearings, internal damping, circulation and cross-coupling in one system."""
    coupled = ([[1e6, 4e5], [-4e5, 1e6]], [[300.0, 50.0], [-50.0, 300.0]])
    seal = connect("seal", "rotor.left", None, *coupled)
    inside = rd.InternalDamping(stiffness_coefficient_s=2e-6, modal_ratio=1e-3)
    own = (7e7, 5e7, 700.0, 500.0)
    more = {"more": [seal], "speed_law": law}
    system = between_bearings(three_disk_element(), *own, inside=inside, **more)
    modes = rd.modes_at_speed(system, 1500.0, 12)
    result = participation(system, modes)
    decrement = _sums(result)[2]
    np.testing.assert_allclose(decrement, modes.log_decrement, rtol=1e-8, atol=1e-10)
    if law:
        return
    # Each kind matters, and drives forward whirl against the bearings at this speed.
    assert (np.abs(result.decrement_bodies).max(axis=1) > 1e-3).all()
    forward = result.decrement_joints[result.joints.index("seal"), 1]
    assert result.decrement_bodies[0, 1] < 0 < result.decrement_joints[0, 1]
    assert forward < 0


def test_geared_shafts_add_up():
    shaft = with_axial_and_torsion(three_disk_element(), 1.3, 0.05, "left", "right")
    rotors = {"first": turning(shaft), "second": turning(shaft, -2.0)}
    held = {"torsion_stiffness_n_m_per_rad": 1e4, "axial_stiffness_n_per_m": 1e6}
    bearings = [ground(name, end, 7e7, **held) for name in rotors for end in ("left", "right")]
    first, second = (rd.End(body=name, interface="left") for name in rotors)
    gear = rd.Gear(
        name="gear", first=first, second=second, ratio=-2.0, mesh_stiffness_n_per_m=1e8,
        mesh_damping_n_s_per_m=1e3, base_radius_first_m=0.1, line_of_action_rad=0.4,
    )  # fmt: skip
    system = rd.assemble(rotors, tuple(bearings), gears=(gear,))
    modes = rd.modes_at_speed(system, 200.0, 12)
    result = participation(system, modes)
    assert result.joints[-1] == "gear"
    assert result.strain_joints[-1].max() > 0.01
    kinetic, potential, decrement = _sums(result)
    np.testing.assert_allclose(kinetic, 1.0, rtol=1e-10)
    np.testing.assert_allclose(potential, 1.0, rtol=1e-10)
    # The gear alone damps.
    np.testing.assert_allclose(decrement, modes.log_decrement, rtol=1e-7, atol=1e-11)
    assert not result.decrement_bodies.any()


def test_centrifugal_part():
    """K = 2e4, K2 = −0.25 kg at Ω = 200: 2e4 elastic less 1e4 centrifugal."""
    body = general(np.eye(5), 2e4 * np.eye(5), np.zeros((5, 5)))
    body = dataclasses.replace(body, spin_softening=0.25 * np.eye(5))
    system = one_rotor(body, [])
    result = participation(system, rd.modes_at_speed(system, 200.0))
    np.testing.assert_allclose(result.strain_bodies, 2.0, rtol=1e-12)
    np.testing.assert_allclose(result.centrifugal_bodies, -1.0, rtol=1e-12)


def test_free_nutation_stores_nothing():
    system = one_rotor(hub(), [])
    result = participation(system, rd.modes_at_speed(system, 100.0))
    assert result.kinetic_bodies.tolist() == [[1.0]]
    assert np.isnan(result.strain_bodies).all()


def test_modes_of_another_system_are_refused():
    with pytest.raises(rd.AnalysisError, match="the modes have 56 coordinates, the system has 74"):
        participation(twin(), rd.modes_at_speed(three_disk(), 0.0, 2))
