"""Kinds of motion by shares of the kinetic energy, and what excites each."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as la
from rotors import (
    connect,
    ground,
    in_coordinates,
    one_rotor,
    steel_shaft,
    three_disk_element,
    turning,
    with_axial_and_torsion,
)

import solidwhirl.rotordyn as rd
from solidwhirl.rotordyn.assembly.coordinates import interface_row
from solidwhirl.rotordyn.modes.kinds import energy_shares, kind_words, kinds, motion_words
from solidwhirl.rotordyn.modes.whirl import excitation_by
from solidwhirl.rotordyn.stability.whirl_decrements import whirl_decrements
from solidwhirl.rotordyn.superelement.families import free_frequencies_by_family

# masses, polar inertias and base radii of two wheels on isotropic springs, with a mesh along x
M, J, R, DAMPING = (6.0, 3.0), (0.4, 0.05), (0.2, 0.1), 300.0
MESH, SHAFT = 4e8, 9e4


def _pair(support, ratio=-2.0, angle=0.0):
    """Two wheels in mesh; a torsion spring holds the first, which gives torsion a stiffness."""
    bodies = {
        name: turning(rd.rigid_superelement(name, m, (0.0, 0.0, 0.0), (j, j, j), {"w": 0.0}), r)
        for name, m, j, r in zip("ab", M, J, (1.0, ratio), strict=True)
    }
    held = [
        ground("a", "w", *np.ravel(support), cx=DAMPING, torsion_stiffness_n_m_per_rad=SHAFT,
               tilt=1e10, axial_stiffness_n_per_m=1e7),
        ground("b", "w", *np.ravel(support), cx=DAMPING, tilt=1e10,
               axial_stiffness_n_per_m=2e7),
    ]  # fmt: skip
    gear = rd.Gear(
        name="gear", first=rd.End(body="a", interface="w"), second=rd.End(body="b", interface="w"),
        ratio=ratio, mesh_stiffness_n_per_m=MESH, base_radius_first_m=R[0],
        line_of_action_rad=angle,
    )  # fmt: skip
    return rd.assemble(bodies, held, gears=[gear])


def _plain(support):
    """ω² and shares of lateral motion of x1, x2, θ1, θ2 by hand: δ = x1 − x2 + r1 θ1 + r2 θ2."""
    teeth = np.array([1.0, -1.0, R[0], R[1]])
    mass = np.diag([*M, *J])
    stiffness = np.diag([support, support, SHAFT, 0.0]) + MESH * np.outer(teeth, teeth)
    squared, shapes = la.eigh(stiffness, mass)
    return squared, (np.diag(mass)[:2, None] * shapes[:2] ** 2).sum(axis=0)


@pytest.mark.parametrize("support", [2e5, 2e6, 1e7, 1e9])
def test_shares_of_a_geared_pair_are_those_of_its_four_coordinates(support):
    """From torsion on soft lateral springs by way of coupled motion to wheels that stay put."""
    system = _pair(support)
    modes = rd.modes_at_speed(system, 0.0)
    shares = energy_shares(system, modes.shapes)
    np.testing.assert_allclose(shares.sum(axis=1), 1.0, rtol=1e-12)
    squared, lateral = _plain(support)
    for omega2, share in zip(squared, lateral, strict=True):
        own = int(np.abs(modes.frequency_hz - np.sqrt(omega2) / (2 * np.pi)).argmin())
        # damping of 300 N s/m moves shapes by its ratio squared at most
        np.testing.assert_allclose(shares[own, :2], [share, 1.0 - share], atol=2e-3)
        expected = "lateral" if share >= 0.9 else "torsional" if share <= 0.1 else "coupled"
        assert kinds(shares[own]) == expected


def test_torsion_of_a_train_is_no_forward_mode_and_unbalance_does_not_excite_it():
    # unlike in x and y, and the teeth at an angle to both: orbits of torsion are ellipses
    system = _pair([1e9, 4e8], angle=0.7)
    modes = rd.modes_at_speed(system, 100.0)
    x, y, turn = (interface_row(system, "a", "w", c) @ modes.shapes for c in ("ux", "uy", "rz"))
    lowest = int(np.flatnonzero(J[0] * np.abs(turn) ** 2 > 0.1)[0])
    first, net = modes.frequency_hz[lowest], (x[lowest].conj() * y[lowest]).imag
    assert abs(net) > 1e-6 * np.abs(x[lowest]) ** 2
    found = whirl_decrements(system, [100.0])
    same = found.first_backward if net > 0 else found.first_forward
    assert same.frequency_hz[0] > 2.0 * first
    speeds = rd.critical_speeds(system, 1.0, 7.0 * first * 2 * np.pi)
    (torsional,) = (c for c in speeds if c.kind == "torsional" and c.frequency_hz < 1.1 * first)
    assert torsional.whirl == "torsional"
    excitation = excitation_by(system, torsional.shape, ["a"])
    assert excitation.exciters == ("torque",) and excitation.bodies == ()
    assert excitation.why == "torsional: unbalance excites lateral motion"


def test_coupled_modes_respond_to_both():
    system = _pair(1e7)
    modes = rd.modes_at_speed(system, 10.0)
    shares = energy_shares(system, modes.shapes)
    coupled = int(np.flatnonzero(kinds(shares) == "coupled")[0])
    found = excitation_by(system, modes.shapes[:, coupled], ["a"])
    assert found.exciters == ("unbalance", "torque") and found.bodies == ("a",)
    words = kind_words(shares[coupled])
    assert words.startswith("coupled (") and "% lateral" in words and "% torsional" in words
    assert motion_words("forward", shares[coupled]) == f"forward, {words}"
    assert motion_words("forward", np.array([0.95, 0.05, 0.0, 0.0])) == "forward"


def test_axial_modes_are_excited_by_neither():
    system = _pair(1e9)
    modes = rd.modes_at_speed(system, 10.0)
    axial = np.flatnonzero(kinds(energy_shares(system, modes.shapes)) == "axial")
    np.testing.assert_allclose(
        np.sort(modes.frequency_hz[axial]),
        np.sort(np.sqrt([1e7 / M[0], 2e7 / M[1]])) / (2 * np.pi), rtol=1e-9,
    )  # fmt: skip
    assert excitation_by(system, modes.shapes[:, axial[0]], ["a", "b"]).exciters == ()


def test_only_the_shaft_that_moves_is_named():
    """Two shafts of one speed that nothing joins: each mode is excited by its own."""
    shaft = three_disk_element()
    system = rd.assemble(
        {name: turning(shaft) for name in "ab"},
        [ground(body, end, k) for body, k in (("a", 5e7), ("b", 7e7)) for end in ("left", "right")],
    )
    for critical in rd.critical_speeds(system, 1.0, 3000.0):
        found = excitation_by(system, critical.shape, ["a", "b"])
        assert len(found.bodies) == (critical.whirl == "forward")


def test_shares_do_not_depend_on_the_coordinates_of_a_body():
    """Inner coordinates of any kind, as of imported matrices, tell the same."""
    ends = {"a": 0.0, "m": 0.4, "b": 1.0}
    element = with_axial_and_torsion(
        steel_shaft("s", np.linspace(0, 1, 9), 0.03, ends), 1.0, 0.03, "a", "b"
    )
    modal = np.array([c.kind == "modal" for c in element.coordinates])
    basis = np.eye(element.size)
    rng = np.random.default_rng(7)
    size = np.sqrt(np.diag(element.mass))
    block = rng.standard_normal((modal.sum(), element.size)) / size[modal, None] * size
    block[:, modal] += 3.0 * np.eye(modal.sum())
    basis[modal] = block
    held = [ground("rotor", end, 1e8, axial_stiffness_n_per_m=1e7) for end in ("a", "b")]
    other = in_coordinates(element, basis)
    shares = []
    for own in (element, other):
        system = one_rotor(own, held)
        modes = rd.modes_at_speed(system, 500.0, 12)
        shares.append(energy_shares(system, modes.shapes))
    # Rounding of the change of coordinates.
    np.testing.assert_allclose(shares[1], shares[0], atol=1e-6)
    first, second = (free_frequencies_by_family(own) for own in (element, other))
    for family in ("lateral", "torsional", "axial"):
        np.testing.assert_allclose(second[family][:4], first[family][:4], rtol=1e-6)


def test_free_frequencies_of_a_rod_have_their_names():
    """One rod element of consistent mass: ω² = 12 c² / L² with c² = E/ρ axially, G/ρ in torsion."""
    ends = {"a": 0.0, "b": 1.0}
    shaft = steel_shaft("s", np.linspace(0, 1, 9), 0.03, ends)
    found = free_frequencies_by_family(with_axial_and_torsion(shaft, 1.0, 0.03, "a", "b"))
    hertz = np.sqrt(12 * np.array([2e11 / 2.6, 2e11]) / 7800) / (2 * np.pi)
    np.testing.assert_allclose(found["torsional"], hertz[:1], rtol=1e-9)
    np.testing.assert_allclose(found["axial"], hertz[1:], rtol=1e-9)
    np.testing.assert_allclose(
        found["lateral"], free_frequencies_by_family(shaft)["lateral"], rtol=1e-9
    )
    assert not found["disk"].size and found["lateral"].size > 10


def test_joined_bodies_share_their_energy():
    """Bodies on one another with an eccentric one between: shares of coupled inertia are halved."""
    arm = 0.01
    body = rd.rigid_superelement("e", 5.0, (arm, 0.0, 0.0), (0.02, 0.02, 0.03), {"w": 0.0})
    system = rd.assemble({"e": turning(body, 0.0)}, [connect("e.w", "e.w", stiffness=(1e6, 1e6))])
    mass = body.mass
    y, turn = (body.interface_index("w", c) for c in ("uy", "rz"))
    shape = np.zeros(body.size)
    shape[y], shape[turn] = 1.0, 2.0
    whole = np.linalg.pinv(system.transformation) @ shape
    across = mass[y, turn] * 2.0
    parts = np.array([mass[y, y] + across, 4.0 * mass[turn, turn] + across])
    np.testing.assert_allclose(
        energy_shares(system, whole[:, None])[0, :2], parts / parts.sum(), rtol=1e-9
    )
