"""Systems in fewer coordinates: what stays exact, what converges, what a cut costs."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as la
from rotors import (
    between_bearings,
    ground,
    hub,
    one_rotor,
    polynomial_law,
    state_eigenvalues,
    three_disk_element,
    twin,
    with_axial_and_torsion,
)

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.assembly.coordinates import interface_row
from solidwhirl.rotordyn.modes.modal_truncation import project_system, rest_modes, truncated_system


@pytest.fixture(scope="module")
def isotropic():
    return between_bearings(three_disk_element(), 7e7)


@pytest.fixture(scope="module")
def with_laws():
    law = polynomial_law((1.0, 1e-3), (0.5, 2e-3), (1.0, -1e-4), top=2000.0)
    inside = rd.InternalDamping(stiffness_coefficient_s=1e-6)
    own = (7e7, 5e7, 700.0)
    return between_bearings(three_disk_element(), *own, inside=inside, speed_law=law)


@pytest.mark.parametrize("speed", [0.0, 1500.0])
def test_a_complete_basis_changes_nothing(with_laws, speed):
    """A change of coordinates keeps all eigenvalues, with bearings that depend on the speed."""
    generator = np.random.default_rng(1)
    turn = la.qr(generator.standard_normal((with_laws.size, with_laws.size)))[0]
    basis = turn / np.sqrt(np.diag(with_laws.mass))[:, None]
    reduced = project_system(with_laws, basis)
    before, after = (rd.modes_at_speed(s, speed, 12) for s in (with_laws, reduced))
    # In these coordinates every entry mixes the stiffest motions, so digits are lost: the highest
    # ω² is 1e9 times the lowest.
    np.testing.assert_allclose(after.eigenvalues, before.eigenvalues, rtol=1e-6)
    truncated = truncated_system(with_laws, with_laws.size)
    after = rd.modes_at_speed(truncated, speed, 12)
    np.testing.assert_allclose(after.eigenvalues, before.eigenvalues, rtol=1e-9)


def test_projection_is_galerkins(with_laws):
    basis = np.random.default_rng(2).standard_normal((with_laws.size, 5))
    reduced = project_system(with_laws, basis)
    for speed in (0.0, 800.0):
        whole, small = (rd.matrices_at_speed(s, speed) for s in (with_laws, reduced))
        for name in whole._fields:
            exact = basis.T @ getattr(whole, name) @ basis
            limit = 1e-12 * np.abs(exact).max() + 1e-12
            np.testing.assert_allclose(getattr(small, name), exact, rtol=0, atol=limit)
    row = interface_row(with_laws, "rotor", "left", "ux")
    np.testing.assert_allclose(interface_row(reduced, "rotor", "left", "ux"), row @ basis)


def test_modes_at_rest_are_kept_exactly():
    system = twin()
    reduced = truncated_system(system, 10)
    exact = rd.modes_at_speed(system, 0.0, 10).frequency_hz
    # Both come from the same standing problem; supports of 1e10 N/m in it.
    np.testing.assert_allclose(rd.modes_at_speed(reduced, 0.0).frequency_hz, exact, rtol=1e-10)
    np.testing.assert_array_equal(reduced.mass, np.eye(10))
    assert not (reduced.stiffness - np.diag(np.diag(reduced.stiffness))).any()
    assert reduced.is_conservative


def test_frequencies_at_speed_converge_from_above():
    """Cost of few modes, as in Müller and Hennings, section 4.2: one per plane is 8 % off."""
    system, speed = twin(), 20000 * np.pi / 30
    exact = rd.modes_at_speed(system, speed, 2).frequency_hz
    errors = []
    for count in (2, 4, 8, 22):
        found = rd.modes_at_speed(truncated_system(system, count), speed, 2).frequency_hz
        errors.append(found / exact - 1)
    errors = np.array(errors)
    assert (errors > -1e-12).all()
    assert 0.05 < errors[0].max() < 0.1
    assert (errors[1:] < 0.3 * errors[:-1]).all()
    assert errors[-1].max() < 1e-6


def test_analyses_work_on_it(with_laws):
    system = twin()
    reduced = truncated_system(system, 22)
    exact = rd.critical_speeds(system, 1.0, 2100.0)
    found = rd.critical_speeds(reduced, 1.0, 2100.0)
    assert [c.whirl for c in found] == [c.whirl for c in exact]
    speeds = [[c.speed_rad_s for c in part] for part in (found, exact)]
    np.testing.assert_allclose(*speeds, rtol=1e-5)
    grid = np.linspace(0, 2000, 5)
    diagrams = [rd.campbell(s, grid, branch_count=4) for s in (reduced, system)]
    np.testing.assert_allclose(diagrams[0].frequency_hz, diagrams[1].frequency_hz, rtol=1e-6)
    np.testing.assert_array_equal(diagrams[0].whirl, diagrams[1].whirl)
    whole = rd.campbell(with_laws, grid / 2, branch_count=4)
    errors = []
    for count in (24, 40):
        damped = rd.campbell(truncated_system(with_laws, count), grid / 2, branch_count=4)
        errors.append(np.abs(damped.eigenvalues / whole.eigenvalues - 1).max())
    # The bearings are twice as stiff at the end as at rest, where the modes come from.
    assert errors[0] < 2e-3 and errors[1] < 0.2 * errors[0]


def test_isotropic_system_keeps_its_complex_form(isotropic):
    reduced = truncated_system(isotropic, 8)
    form, whole = rd.complex_form(reduced), rd.complex_form(isotropic)
    assert whole is not None and form is not None
    assert form.size == 4
    # Signed whirl speeds of the real and of the complex problem.
    speed = 1000.0
    omega = np.sort(np.abs(state_eigenvalues(*form.at_speed(speed)).imag))
    np.testing.assert_allclose(omega, rd.modes_at_speed(reduced, speed).eigenvalues.imag, rtol=1e-9)


def test_free_rotor_keeps_its_rigid_motions():
    system = one_rotor(three_disk_element(), [])
    reduced = truncated_system(system, 8)
    assert not reduced.stiffness[:4].any()
    modes = rd.modes_at_speed(reduced, 100.0)
    whole = rd.modes_at_speed(system, 100.0)
    # Two translations cost nothing, and of each tilt pair one precession is at rest.
    assert (modes.zero_count, whole.zero_count) == (6, 6)
    # Rigid nutation at Ω Ip/Id is in the basis but for the bending it goes with.
    np.testing.assert_allclose(modes.frequency_hz[0], whole.frequency_hz[0], rtol=1e-4)
    assert rd.complex_form(reduced) is not None


def test_axial_and_torsion_modes_stay_apart():
    element = with_axial_and_torsion(three_disk_element(), 1.3, 0.05, "left", "right")
    held = {"axial_stiffness_n_per_m": 1e6, "torsion_stiffness_n_m_per_rad": 1e4}
    system = between_bearings(element, 7e7, **held)
    reduced = truncated_system(system, 8)
    exact = rd.modes_at_speed(system, 0.0, 8).frequency_hz
    np.testing.assert_allclose(rd.modes_at_speed(reduced, 0.0).frequency_hz, exact, rtol=1e-9)
    form = rd.complex_form(reduced)
    assert form is not None and form.rest.size >= 1 and 2 * form.size + form.rest.size == 8


def test_negative_support_is_kept():
    """A support that pushes away: one negative ω² in each plane, before all others."""
    spring = np.diag([1e6, 1e6, 2e4, 2e4])
    system = one_rotor(hub(stiffness=spring), [ground("rotor", "hub", -1.5e6)])
    squared, _ = rest_modes(system)
    np.testing.assert_allclose(squared, [-5e4, -5e4, 4e5, 4e5], rtol=1e-12)
    reduced = truncated_system(system, 2)
    np.testing.assert_allclose(np.diag(reduced.stiffness), [-5e4, -5e4], rtol=1e-12)


@pytest.mark.parametrize(
    ("count", "message"),
    [
        (0, "mode_count is 0; 1 to 56 are possible"),
        (57, "mode_count is 57; 1 to 56 are possible"),
        (3, r"parts modes of equal frequency .* Hz; take 2 or 4"),
    ],
)
def test_impossible_counts_and_halves_of_pairs_are_refused(isotropic, count, message):
    with pytest.raises(rd.AnalysisError, match=message):
        truncated_system(isotropic, count)


@pytest.mark.parametrize(
    ("basis", "message"),
    [
        (np.ones((3, 2)), r"shape \(3, 2\); allowed is \(56, m\)"),
        (np.ones((56, 2)), "2 columns of rank 1"),
        (np.full((56, 1), np.nan), "not finite"),
        (np.zeros((56, 0)), r"shape \(56, 0\)"),
    ],
)
def test_useless_bases_are_refused(isotropic, basis, message):
    with pytest.raises(rd.AnalysisError, match=message):
        project_system(isotropic, basis)


def test_turn_that_leaves_the_basis_is_forgotten(isotropic):
    assert project_system(isotropic, np.eye(56)[:, :3]).spin_generator is None
    assert project_system(isotropic, np.eye(56)[:, :2]).spin_generator is not None
