"""Frequencies in the frame of a body: closed forms, a rotating-frame formulation, round trips."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rotors import (
    general,
    ground,
    hub,
    one_rotor,
    plane_spring,
    rigid_body,
    state_eigenvalues,
    twin,
)

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.campbell.body_frames import campbell_seen_by_body
from solidwhirl.rotordyn.superelement.circumferential_orders import body_turns
from solidwhirl.rotordyn.superelement.rigid_body import rigid_superelement

MASS, TRANSLATION, COUPLING, TILT, DIAMETRAL, POLAR = 10.0, 5e5, -1.2e5, 4e4, 0.05, 0.08
# Speeds of the overhung disk: from below to above its forward mode, so that it is mirrored.
SPEEDS = np.array([20.0, 100.0, 300.0, 900.0])

# L on ux, uy, rx, ry.
TURN = np.zeros((4, 4))
TURN[1, 0] = TURN[3, 2] = 1.0
TURN[0, 1] = TURN[2, 3] = -1.0


def overhung(ratio=1.0, turn=TURN, **options):
    """Rigid disk on a massless shaft, with or without the knowledge of how it turns."""
    values = {"mass_kg": MASS, "diametral_kg_m2": DIAMETRAL, "polar_kg_m2": POLAR}
    spring = plane_spring(TRANSLATION, COUPLING, TILT)
    disk = hub(**{**values, "stiffness": spring, **options})
    disk = dataclasses.replace(disk, spin_generator=turn)
    return one_rotor(disk, (), ratio)


def _in_rotating_coordinates(speed):
    """Signed frequencies σ of ζ, ψ ~ e^{iσt}, z = ζ e^{iΩt}, φ = ψ e^{iΩt}, rad/s.

    m (ζ'' + 2iΩζ' − Ω²ζ) + k ζ − ic ψ = 0,
    Id (ψ'' + 2iΩψ' − Ω²ψ) − iΩIp (ψ' + iΩψ) + kr ψ + ic ζ = 0: Coriolis and centrifugal terms
    instead of a gyroscopic term alone.
    """
    velocity = np.diag([2j * speed * MASS, 1j * speed * (2 * DIAMETRAL - POLAR)])
    softer = speed**2 * np.diag([MASS, DIAMETRAL - POLAR])
    stiffness = np.array([[TRANSLATION, -1j * COUPLING], [1j * COUPLING, TILT]]) - softer
    return np.sort(state_eigenvalues(np.diag([MASS, DIAMETRAL]), velocity, stiffness).imag)


@pytest.mark.parametrize("ratio", [1.0, -1.3])
def test_rotating_frame_formulation(ratio):
    system = overhung(ratio)
    seen = campbell_seen_by_body(system, rd.campbell(system, SPEEDS, branch_count=4), "rotor")
    signed = np.take_along_axis(seen.signed_hz, seen.share.argmax(axis=0)[None], axis=0)[0]
    for place, speed in enumerate(SPEEDS):
        exact = _in_rotating_coordinates(ratio * speed) / (2 * np.pi)
        # Both are eigenvalues of 4 × 4 matrices; the smallest |σ| is a difference of
        # numbers up to 1e3 times it.
        np.testing.assert_allclose(np.sort(signed[:, place]), exact, rtol=0, atol=1e-9)


def test_forward_mode_is_mirrored_above_its_critical_speed():
    """And back in the inertial frame by Müller and Hennings, appendix B, equations 15 to 17."""
    diagram = rd.campbell(overhung(), SPEEDS, branch_count=4)
    seen = campbell_seen_by_body(overhung(), diagram, "rotor")
    forward = int(np.flatnonzero(diagram.whirl[:, 0] == "forward")[0])
    slower = diagram.frequency_hz[forward] < SPEEDS / (2 * np.pi)
    assert slower.tolist() == [False, False, True, True]
    np.testing.assert_array_equal(seen.is_mirrored[0, forward], slower)
    f, turn = seen.frequency_hz, SPEEDS / (2 * np.pi)
    ahead = np.where(seen.is_mirrored[0], turn - f[0], f[0] + turn)
    for inertial in (ahead, np.abs(f[1] - turn)):
        np.testing.assert_allclose(inertial, diagram.frequency_hz, rtol=0, atol=1e-12)


@pytest.mark.parametrize("polar", [0.09, 0.02])
def test_free_rigid_rotor(polar):
    """Nutation at Ω Ip/Id; in the body Euler's free precession, Ω (Ip/Id − 1)."""
    system = overhung(stiffness=None, polar_kg_m2=polar)
    speeds = np.array([100.0, 500.0, 1000.0])
    diagram = rd.campbell(system, speeds, branch_count=1)
    seen = campbell_seen_by_body(system, diagram, "rotor")
    np.testing.assert_allclose(seen.share[0], 1.0, rtol=1e-12)
    precession = speeds * (polar / DIAMETRAL - 1) / (2 * np.pi)
    np.testing.assert_allclose(seen.signed_hz[0, 0], precession, rtol=1e-10)
    assert seen.is_mirrored[0].all() == (polar < DIAMETRAL)


def test_round_trip_of_a_diagram():
    system = twin()
    diagram = rd.campbell(system, np.linspace(0, 2000, 9), branch_count=6)
    for body, ratio in (("inner", 1.0), ("outer", -1.0)):
        seen = campbell_seen_by_body(system, diagram, body)
        assert seen.speed_ratio == ratio
        sign = np.where(seen.orders == 0, 1, np.sign(seen.orders))[:, None, None]
        turn = np.abs(seen.orders)[:, None, None] * seen.spin_rad_s / (2 * np.pi)
        back = sign * (seen.signed_hz + turn)
        wanted = np.broadcast_to(diagram.frequency_hz, back.shape)
        np.testing.assert_allclose(back, wanted, rtol=0, atol=1e-12)
        np.testing.assert_array_equal(seen.growth_rate_1_s, diagram.eigenvalues.real)


def test_shares_of_an_elliptic_mode():
    """The forward part of q is (1 − iL) q / 2; its kinetic energy against the whole."""
    system = twin()
    diagram = rd.campbell(system, [0.0, 700.0, 1500.0], branch_count=4)
    for body in ("inner", "outer"):
        seen = campbell_seen_by_body(system, diagram, body)
        assert seen.share_source == "kinetic energy"
        np.testing.assert_allclose(seen.share.sum(axis=0), 1.0, rtol=1e-12)
    element = system.system.rotors["inner"].element
    shapes = rd.modes_at_speed(system, 700.0, 4).shapes
    own = system.transformation[system.body_slices["inner"]] @ shapes
    forward = 0.5 * (own - 1j * element.spin_generator @ own)
    energy = [np.einsum("im,ij,jm->m", q.conj(), element.mass, q).real for q in (forward, own)]
    share = energy[0] / energy[1]
    # Neither pure circles nor lines, so the test means something.
    assert 0.1 < share[0] < 0.49
    found = campbell_seen_by_body(system, diagram, "inner").share[0, :, 1]
    np.testing.assert_allclose(found, share, rtol=1e-7)


def test_straight_orbit_has_two_equal_circles():
    """x = cos ωt is half a forward and half a backward circle: f ± Ω/2π, seen at equal size."""
    system = one_rotor(hub(polar_kg_m2=0.0), [ground("rotor", "hub", 1e6, 2e6)])
    diagram = rd.campbell(system, [0.0, 50.0, 400.0], branch_count=2)
    assert (diagram.whirl == "straight").all()
    seen = campbell_seen_by_body(system, diagram, "rotor")
    # This body does not know its generator, so the path of its axis is taken.
    assert seen.share_source == "orbits"
    np.testing.assert_allclose(seen.share, 0.5, rtol=1e-12)
    omega = np.sqrt(np.array([1e6, 2e6]) / 10.0)[:, None]
    signed = np.array([omega - diagram.speeds_rad_s, -omega - diagram.speeds_rad_s])
    np.testing.assert_allclose(seen.signed_hz * 2 * np.pi, signed, rtol=1e-12)


def test_modes_of_equal_frequency_are_parted_by_their_labels():
    """Without gyroscopic effect forward and backward whirl have one frequency at all speeds."""
    system = overhung(polar_kg_m2=0.0)
    diagram = rd.campbell(system, [0.0, 100.0, 200.0], branch_count=4)
    whirl = np.array([["forward"], ["backward"]] * 2)
    named = dataclasses.replace(diagram, whirl=np.repeat(whirl, 3, axis=1))
    share = campbell_seen_by_body(system, named, "rotor").share[0]
    np.testing.assert_allclose(share, np.repeat([[1.0], [0.0]] * 2, 3, axis=1), atol=1e-9)
    same = dataclasses.replace(diagram, whirl=np.full((4, 3), "straight"))
    np.testing.assert_allclose(campbell_seen_by_body(system, same, "rotor").share, 0.5, rtol=1e-9)


def test_disk_modes_are_shifted_by_their_diameters():
    """A pattern of two diameters that turns at ω/2 is seen at ω − 2Ω by its body."""
    turn = np.zeros((6, 6))
    turn[:4, :4], turn[4:, 4:] = TURN, 2.0 * TURN[:2, :2]
    gyroscopic = np.zeros((6, 6))
    gyroscopic[4, 5], gyroscopic[5, 4] = 1.0, -1.0
    body = general(np.eye(6), np.diag([1e4] * 4 + [9e4] * 2), gyroscopic)
    body = dataclasses.replace(body, spin_generator=turn)
    assert body_turns(body).orders.tolist() == [-2, -1, -1, 1, 1, 2]
    system = one_rotor(body)
    speeds = np.array([40.0, 200.0])
    diagram = rd.campbell(system, speeds, branch_count=6)
    seen = campbell_seen_by_body(system, diagram, "rotor")
    assert seen.orders.tolist() == [1, -1, 2, -2]
    # q'' − iΩ q' + 9e4 q = 0 for the pattern q e^{iωt}.
    omega = np.sqrt(9e4 + 0.25 * speeds**2)
    for branch, order, whirl in ((4, 3, -1), (5, 2, 1)):
        np.testing.assert_allclose(seen.share[order, branch], 1.0, rtol=1e-10)
        signed = whirl * (omega + whirl * 0.5 * speeds) - 2 * speeds
        found = seen.signed_hz[order, branch] * 2 * np.pi
        np.testing.assert_allclose(found, signed, rtol=1e-10)


def test_rigid_body_with_two_seats():
    """Its six coordinates are tied to one rigid motion: M is singular, its parts are not."""
    body = rigid_body("fan", 10.0, 0.25, [0.6, 0.6, 1.0], {"a": 0.0, "b": 0.6})
    parts = body_turns(body)
    assert parts.orders.tolist() == [-1, -1, 1, 1]
    motion = body.constraint @ np.array([1.0, 2.0, 0.3, 0.1])
    size = np.sum(np.abs(parts.amplitudes @ motion) ** 2)
    assert size == pytest.approx(motion @ body.mass @ motion, rel=1e-12)
    np.testing.assert_allclose(parts.lateral() @ motion, motion, rtol=1e-12)
    system = one_rotor(body, [ground("rotor", end, 1e6) for end in ("a", "b")])
    diagram = rd.campbell(system, [100.0, 400.0], branch_count=4)
    seen = campbell_seen_by_body(system, diagram, "rotor")
    np.testing.assert_allclose(seen.body_share, 1.0, rtol=1e-12)
    forward = (diagram.whirl == "forward").astype(float)
    np.testing.assert_allclose(seen.share[0], forward, atol=1e-9)
    # A seat off the axis is turned to another place, which has no coordinates.
    seats = {"a": 0.0, "p": [0.0, 0.5, 0.0]}
    aside = rigid_superelement("casing", 1.0, [0, 0, 0], [1, 1, 1], seats)
    assert body_turns(aside) is None


def test_negative_speed_is_the_mirror_image():
    up, down = (rd.campbell(overhung(), s * SPEEDS, branch_count=4) for s in (1, -1))
    seen = [campbell_seen_by_body(overhung(), diagram, "rotor") for diagram in (up, down)]
    # +z and −z change their places.
    np.testing.assert_allclose(seen[1].signed_hz[0], -seen[0].signed_hz[1], rtol=1e-9)
    np.testing.assert_allclose(seen[1].share[0], seen[0].share[1], atol=1e-9)


def test_wrong_arguments_are_refused():
    diagram = rd.campbell(overhung(), SPEEDS, branch_count=4)
    with pytest.raises(rd.AnalysisError, match="no mode of this system"):
        campbell_seen_by_body(overhung(polar_kg_m2=0.07), diagram, "rotor")
    with pytest.raises(rd.AssemblyError, match="there is no body 'fan'"):
        campbell_seen_by_body(twin(), diagram, "fan")
