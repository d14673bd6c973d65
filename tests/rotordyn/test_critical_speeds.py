"""Critical speeds: direct solution against branches, closed forms, damping, free motion."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import scipy.linalg as la
from scipy.optimize import brentq

from solidwhirl.rotordyn import (
    AnalysisError,
    Bearing,
    End,
    Rotor,
    assemble,
    critical_speeds,
    matrices_at_speed,
    modes_at_speed,
)


@pytest.mark.parametrize("ratio", [1.0, 0.5, 3.0])
def test_direct_solution_meets_the_modes_at_that_speed(twin, ratio):
    system = twin()
    found = critical_speeds(system, ratio, 2500.0)
    assert len(found) >= 2
    for critical in found:
        omega = modes_at_speed(system, critical.speed_rad_s).eigenvalues.imag
        assert np.abs(omega - ratio * critical.speed_rad_s).min() < 1e-8 * omega[0]
        assert critical.frequency_hz == pytest.approx(
            ratio * critical.speed_rad_s / (2 * np.pi), rel=1e-14
        )


@pytest.mark.parametrize("ratio", [1.0, 2.0])
def test_direct_solution_finds_every_meeting_of_a_sweep(twin, ratio):
    system, top = twin(), 2500.0
    speeds = np.linspace(0, top, 26)
    # Number of modes below the line grows by one at each meeting of a falling distance, and the
    # difference of counts between two speeds is what the direct solution must give.
    below = [
        np.count_nonzero(modes_at_speed(system, s).eigenvalues.imag < ratio * s) for s in speeds
    ]
    found = np.array([c.speed_rad_s for c in critical_speeds(system, ratio, top)])
    counted = [np.count_nonzero(found < s) for s in speeds]
    assert counted == below


def test_residual_and_sign_of_the_ratio(twin):
    system = twin()
    found = critical_speeds(system, 1.3, 2500.0)
    for critical in found:
        m, _, g, k = matrices_at_speed(system, critical.speed_rad_s)
        omega = 1.3 * critical.speed_rad_s
        terms = [
            k @ critical.shape,
            1j * omega * g @ critical.shape,
            -(omega**2) * m @ critical.shape,
        ]
        size = sum(la.norm(term) for term in terms)
        assert la.norm(sum(terms)) < 1e-10 * size
    turned = critical_speeds(system, -1.3, 2500.0)
    assert [c.speed_rad_s for c in turned] == [c.speed_rad_s for c in found]


def test_speeds_above_the_limit_are_left_out(twin):
    every = [c.speed_rad_s for c in critical_speeds(twin(), 1.0, 3000.0)]
    some = [c.speed_rad_s for c in critical_speeds(twin(), 1.0, 0.5 * (every[1] + every[2]))]
    assert some == every[:2]


def test_there_may_be_no_critical_speed(twin, three_disk):
    assert critical_speeds(twin(), 1.0, 100.0) == ()
    assert critical_speeds(three_disk(), 1.0, 100.0) == ()


def test_range_of_the_basis_is_the_default_limit(twin_bodies, twin_bearings):
    inner, outer = twin_bodies()
    rotors = {
        "inner": Rotor(
            element=dataclasses.replace(inner, maximum_speed_rad_s=1100.0), speed_ratio=1.0
        ),
        "outer": Rotor(element=outer, speed_ratio=-1.0),
    }
    found = critical_speeds(assemble(rotors, twin_bearings()))
    assert [round(c.frequency_hz) for c in found] == [159]


def test_stiff_supports_cost_no_digits(twin):
    limit = np.array([c.speed_rad_s for c in critical_speeds(twin(support=None), 1.0, 2500.0)])
    error = {}
    for k in (1e11, 1e13, 1e16):
        found = [c.speed_rad_s for c in critical_speeds(twin(support=k, joint=k), 1.0, 2500.0)]
        error[k] = found / limit - 1
    np.testing.assert_allclose(error[1e13], error[1e11] / 100, rtol=2e-3)
    assert np.abs(error[1e16]).max() < 1e-8


def test_point_mass_has_one_forward_and_one_backward_speed(one_rotor, hub, ground):
    k, m = 3e5, 12.0
    disk = hub(mass_kg=m, polar_kg_m2=1e-3, diametral_kg_m2=1e-3)
    support = ground("rotor", "hub", k, tilt_stiffness_n_m_per_rad=1e6 * np.eye(2))
    found = critical_speeds(one_rotor(disk, [support]), 1.0, 1000.0)
    np.testing.assert_allclose([c.speed_rad_s for c in found], np.sqrt(k / m), rtol=1e-12)
    assert [c.whirl for c in found] == ["backward", "forward"]


@pytest.mark.parametrize(("polar", "count"), [(0.08, 1), (0.03, 2)])
def test_thin_disk_on_a_free_tilt_has_no_forward_speed(one_rotor, hub, polar, count):
    """Only tilt: k = Ω² (Id ∓ Ip), forward needs Id > Ip."""
    k, diametral = 300.0, 0.05
    disk = hub(mass_kg=10.0, polar_kg_m2=polar, diametral_kg_m2=diametral)
    tilt = Bearing(
        name="tilt",
        first=End(body="rotor", interface="hub"),
        tilt_stiffness_n_m_per_rad=k * np.eye(2),
    )
    # Translations are free: they have no critical speed and must not disturb.
    found = critical_speeds(one_rotor(disk, [tilt]))
    exact = {
        "backward": np.sqrt(k / (diametral + polar)),
        "forward": np.sqrt(k / max(diametral - polar, 1e-300)),
    }
    assert [c.whirl for c in found] == ["backward", "forward"][:count]
    for critical in found:
        assert critical.speed_rad_s == pytest.approx(exact[critical.whirl], rel=1e-12)


def test_free_shaft_has_the_critical_speeds_of_its_elastic_modes(three_disk_element, one_rotor):
    system = one_rotor(three_disk_element(), [])
    found = critical_speeds(system, 1.0, 4000.0)
    assert found
    for critical in found:
        omega = modes_at_speed(system, critical.speed_rad_s).eigenvalues.imag
        assert np.abs(omega / critical.speed_rad_s - 1).min() < 1e-10


def test_free_body_that_whirls_without_force_is_refused(one_rotor, hub):
    with pytest.raises(AnalysisError, match="every speed is critical"):
        critical_speeds(one_rotor(hub(polar_kg_m2=0.05, diametral_kg_m2=0.05), []))


def test_little_damping_gives_the_undamped_speeds(three_disk):
    undamped = critical_speeds(three_disk(0.0, 0.0), 1.0, 2900.0)
    damped = critical_speeds(three_disk(1.0, 1.0), 1.0, 2900.0)
    # Damping c enters the frequency with c².
    np.testing.assert_allclose(
        [c.speed_rad_s for c in damped], [c.speed_rad_s for c in undamped], rtol=1e-8
    )
    assert all(c.log_decrement == 0 for c in undamped)
    assert all(0 < c.log_decrement < 1e-3 for c in damped)
    assert [c.whirl for c in damped] == [c.whirl for c in undamped]


def test_little_damping_keeps_speeds_of_motions_that_are_rigid_at_rest(one_rotor, hub):
    """Thin disk on an elastic arm, free to tilt about a pin: the nutation has a critical speed."""
    arm, disk = hub(0.5, 1e-3, 1e-3, name="pin"), hub(10.0, 0.08, 0.05)
    link = np.diag([1e6, 1e6, 300.0, 300.0])

    def system(damping):
        body = {
            "pin": Rotor(element=arm, speed_ratio=1.0),
            "disk": Rotor(element=disk, speed_ratio=1.0),
        }
        joint = Bearing(
            name="joint",
            first=End(body="pin", interface="hub"),
            second=End(body="disk", interface="hub"),
            stiffness_n_per_m=link[:2, :2],
            tilt_stiffness_n_m_per_rad=link[2:, 2:],
        )
        ends = End(body="pin", interface="hub")
        pin = Bearing(
            name="ground",
            first=ends,
            stiffness_n_per_m=1e6 * np.eye(2),
            tilt_damping_n_m_s_per_rad=damping * np.eye(2),
        )
        return assemble(body, (joint, pin))

    undamped = critical_speeds(system(0.0), 1.0, 3000.0)
    damped = critical_speeds(system(1e-6), 1.0, 3000.0)
    assert len(undamped) >= 2
    np.testing.assert_allclose(
        [c.speed_rad_s for c in damped], [c.speed_rad_s for c in undamped], rtol=1e-6
    )


def test_damped_speeds_solve_their_definition(three_disk):
    system = three_disk(2e5, 1e5)
    found = critical_speeds(system, 1.0, 2900.0)
    assert max(c.log_decrement for c in found) > 0.5
    for critical in found:
        modes = modes_at_speed(system, critical.speed_rad_s)
        at = np.abs(modes.eigenvalues.imag - critical.speed_rad_s).argmin()
        assert modes.eigenvalues[at].imag == pytest.approx(critical.speed_rad_s, rel=1e-10)
        assert modes.log_decrement[at] == pytest.approx(critical.log_decrement, rel=1e-6)


def test_damped_disk_on_tilt_spring_in_closed_form(one_rotor, hub):
    """Id λ² + (c ∓ i Ip Ω) λ + k = 0 for forward and backward whirl; Im λ(Ω) = Ω by bracketing."""
    k, diametral, polar, c = 300.0, 0.05, 0.03, 2.0
    disk = hub(mass_kg=10.0, polar_kg_m2=polar, diametral_kg_m2=diametral)
    tilt = Bearing(
        name="tilt",
        first=End(body="rotor", interface="hub"),
        stiffness_n_per_m=1e9 * np.eye(2),
        tilt_stiffness_n_m_per_rad=k * np.eye(2),
        tilt_damping_n_m_s_per_rad=c * np.eye(2),
    )
    found = critical_speeds(one_rotor(disk, [tilt]), 1.0, 400.0)

    def miss(speed, sign):
        roots = np.roots([diametral, c - sign * 1j * polar * speed, k])
        return roots.imag.max() - speed

    exact = {
        "forward": brentq(miss, 10, 300, args=(1,)),
        "backward": brentq(miss, 10, 300, args=(-1,)),
    }
    assert {c.whirl for c in found} == set(exact)
    for critical in found:
        assert critical.speed_rad_s == pytest.approx(exact[critical.whirl], rel=1e-9)


@pytest.mark.parametrize(
    ("ratio", "limit", "message"),
    [
        (0.0, None, "excitation_ratio is 0.0"),
        (np.nan, None, "excitation_ratio is nan"),
        (1.0, -5.0, "speed_max_rad_s is -5.0"),
        (1.0, None, "speed_max_rad_s is needed"),
    ],
)
def test_arguments_without_meaning_are_refused(three_disk, ratio, limit, message):
    with pytest.raises(AnalysisError, match=message):
        critical_speeds(three_disk(), ratio, limit)
