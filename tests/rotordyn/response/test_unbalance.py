"""Unbalance response against closed forms and critical speeds."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rotors import connect, ground, hub, one_rotor, turning, twin_rotors

from solidwhirl.rotordyn import AnalysisError, assemble, critical_speeds
from solidwhirl.rotordyn.estimates.response_errors import unbalance_peak_errors
from solidwhirl.rotordyn.response.orbits import elliptic_orbits
from solidwhirl.rotordyn.response.unbalance import (
    Unbalance,
    orbit_peaks,
    resolving_speeds,
    unbalance_response,
)
from solidwhirl.rotordyn.response.unbalance_peaks import resonance_peaks

MASS, STIFFNESS, DAMPING, MOMENT = 10.0, 4e6, 200.0, 3e-4
OMEGA0 = np.sqrt(STIFFNESS / MASS)


def laval(ky=STIFFNESS, c=DAMPING, ratio=1.0):
    """Disk of 10 kg on springs and dampers, as a body of its own or turning the other way."""
    return one_rotor(hub(mass_kg=MASS), [ground("rotor", "hub", STIFFNESS, ky, c, tilt=1e5)], ratio)


def _closed(omega, stiffness=STIFFNESS, damping=DAMPING):
    return MOMENT * omega**2 / (stiffness - MASS * omega**2 + 1j * omega * damping)


def _hub_unbalance(**options):
    return Unbalance(body="rotor", interface="hub", moment_kg_m=MOMENT, **options)


def test_laval_rotor_amplitude_and_phase():
    speeds = OMEGA0 * np.array([0.0, 0.1, 0.7, 0.98, 1.0, 1.02, 1.5, 40.0])
    (exciter,) = unbalance_response(laval(), [_hub_unbalance()], speeds).exciters
    motion = exciter.at_node("rotor", "hub")
    np.testing.assert_allclose(motion[:, 0], _closed(speeds), rtol=1e-12)
    np.testing.assert_allclose(motion[:, 1], -1j * _closed(speeds), rtol=1e-12)
    phase = np.degrees(np.angle(motion[1:, 0]))
    # In phase far below, a quarter turn behind at the undamped natural frequency, opposite above.
    assert -0.2 < phase[0] < 0
    assert phase[3] == pytest.approx(-90.0, abs=1e-9)
    assert -180.0 < phase[-1] < -179.9
    # Self-centring: the disk turns about its centre of mass, which is MOMENT / MASS off its axis;
    # what is left is 1 / 40² of it.
    assert abs(motion[-1, 0]) == pytest.approx(MOMENT / MASS, rel=1e-3)
    assert (np.diff(phase) < 0).all()
    np.testing.assert_array_equal(exciter.orbits().direction[1:, 0], "forward")
    np.testing.assert_array_equal(exciter.tilt_rad, 0.0)
    through = (STIFFNESS + 1j * speeds * DAMPING) * _closed(speeds)
    force = exciter.bearing_forces["rotor.hub"]
    np.testing.assert_allclose(force[:, 0], through, rtol=1e-12)
    np.testing.assert_allclose(force[:, 1], -1j * through, rtol=1e-12)
    assert not force[:, 2:].any()


def test_mass_at_an_angle_pushes_that_way_at_time_zero():
    # Far below resonance the motion follows the force, F / k: the mass stands at 30° at t = 0.
    for ratio in (0.5, -0.5):
        placed = [_hub_unbalance(phase_rad=np.pi / 6)]
        (exciter,) = unbalance_response(laval(c=0.0, ratio=ratio), placed, [1.0]).exciters
        motion = exciter.translation_m[0, 0]
        static = MOMENT * 0.5**2 / STIFFNESS * np.array([np.cos(np.pi / 6), 0.5])
        np.testing.assert_allclose(motion.real, static, rtol=1e-5)
        later = (motion * np.exp(1j * 0.5 * 0.1)).real
        turn = np.arctan2(later[1], later[0]) - np.pi / 6
        assert turn == pytest.approx(ratio * 0.1, rel=1e-6)


def test_anisotropic_supports_give_two_peaks_and_backward_whirl_between():
    ky = 2.5e6
    speeds = np.linspace(300.0, 900.0, 6001)
    (exciter,) = unbalance_response(laval(ky=ky, c=40.0), [_hub_unbalance()], speeds).exciters
    x, y = exciter.at_node("rotor", "hub").T
    np.testing.assert_allclose(x, _closed(speeds, damping=40.0), rtol=1e-10)
    np.testing.assert_allclose(y, -1j * _closed(speeds, ky, 40.0), rtol=1e-10)
    orbits = exciter.orbits()
    peaks = resonance_peaks(speeds, orbits.major_m[:, 0])
    # Each plane peaks at its own ω0 (1 − 2ζ²)^(−1/2) for a force ∝ Ω²; the other plane adds less
    # than 1e-4 to where.
    planes = np.array([ky, STIFFNESS])
    expected = np.sqrt(planes / MASS / (1 - 2 * 40.0**2 / (4 * planes * MASS)))
    np.testing.assert_allclose([p.position_rad_s for p in peaks], expected, rtol=1e-4)
    # Rao, Rotor Dynamics: backward between the two resonances, forward outside of both. Near them
    # the damping decides, so one half power width on either side is left out.
    away = [40.0 / MASS * side for side in (-1, 1)]
    inside = (speeds > expected[0] + away[1]) & (speeds < expected[1] + away[0])
    outside = (speeds < expected[0] + away[0]) | (speeds > expected[1] + away[1])
    assert (orbits.direction[inside, 0] == "backward").all()
    assert (orbits.direction[outside, 0] == "forward").all()


def counter_rotating(c):
    """Symmetric shafts that turn against each other at different speeds, lightly damped."""
    joint = connect("C", "inner.C", "outer.C", 1e8)
    held = [connect(at, at, None, 5e7, c) for at in ("inner.A", "inner.B", "outer.D")]
    return assemble(twin_rotors(-1.3), (*held, joint), "inner")


@pytest.mark.parametrize(("body", "whirl"), [("inner", "forward"), ("outer", "backward")])
def test_each_shaft_excites_whirl_of_its_own_sense(body, whirl):
    system = counter_rotating(5.0)
    ratio = abs(system.system.rotors[body].speed_ratio)
    undamped = critical_speeds(counter_rotating(0.0), ratio, 3000.0)
    expected = [c.speed_rad_s for c in undamped if c.whirl == whirl]
    others = [c.speed_rad_s for c in undamped if c.whirl != whirl]
    assert len(expected) >= 2 and len(others) >= 1
    near = [s * np.linspace(0.999, 1.001, 161) for s in (*expected, *others)]
    speeds = np.unique(np.concatenate([np.linspace(100.0, 3000.0, 300), *near]))
    unbalance = Unbalance(body=body, interface="C", moment_kg_m=1e-5)
    (exciter,) = unbalance_response(system, [unbalance], speeds).exciters
    peaks = resonance_peaks(speeds, np.abs(exciter.at_node(body, "C")[:, 0]), 3.0)
    # Modal damping ratios are below 3e-4 and move a peak by about their square.
    np.testing.assert_allclose([p.position_rad_s for p in peaks], expected, rtol=3e-7)
    assert set(exciter.orbits().direction.ravel()) == {whirl}


def test_exciters_are_kept_apart_by_frequency():
    system = counter_rotating(20.0)
    element = system.system.rotors["inner"].element
    rotors = {**system.system.rotors, "third": turning(element, -1.0)}
    third = connect("third", "third.A", "outer.D", 1e7, 30.0, tilt=1e4)
    system = assemble(rotors, (*system.system.bearings, third), "inner")
    parts = [
        Unbalance(body="outer", interface="D", moment_kg_m=2e-5),
        Unbalance(body="inner", interface="A", moment_kg_m=1e-5, phase_rad=1.0),
        Unbalance(body="third", interface="B", moment_kg_m=3e-5, phase_rad=-2.0),
        Unbalance(body="inner", interface="B", moment_kg_m=2e-5),
    ]
    speeds = np.array([150.0, 900.0])
    response = unbalance_response(system, parts, speeds)
    assert [e.bodies for e in response.exciters] == [("inner", "third"), ("outer",)]
    assert [e.frequency_ratio for e in response.exciters] == [1.0, 1.3]
    np.testing.assert_allclose(response.exciters[1].frequencies_rad_s, 1.3 * speeds)
    alone = [unbalance_response(system, [part], speeds).exciters[0] for part in parts]
    joined = sum(alone[i].translation_m for i in (1, 2, 3))
    found, limit = response.exciters[0].translation_m, 1e-10 * np.abs(joined).max()
    np.testing.assert_allclose(found, joined, rtol=0, atol=limit)
    for name, force in response.exciters[0].bearing_forces.items():
        summed = sum(alone[i].bearing_forces[name] for i in (1, 2, 3))
        np.testing.assert_allclose(force, summed, rtol=0, atol=1e-9 * np.abs(summed).max())


@pytest.mark.parametrize("zeta", [1e-9, 1e-5, 0.05, 0.2])
def test_refined_peaks_are_those_of_the_closed_form(zeta):
    """However few and far the samples are."""
    system = laval(c=2 * zeta * np.sqrt(STIFFNESS * MASS))
    speeds = resolving_speeds(system, [_hub_unbalance()], np.linspace(100.0, 2000.0, 12))
    (exciter,) = unbalance_response(system, [_hub_unbalance()], speeds).exciters
    node, major = exciter.nodes[0], exciter.orbits().major_m[:, 0]
    (peak,) = orbit_peaks(system, [_hub_unbalance()], node, speeds, major)
    top = MOMENT / MASS / (2 * zeta * np.sqrt(1 - zeta**2))
    square = np.sort(np.roots([1 - 8 * zeta**2 * (1 - zeta**2), 4 * zeta**2 - 2, 1.0]))
    found = unbalance_peak_errors(system, [_hub_unbalance()], node, [peak])
    assert abs(peak.amplitude / top - 1.0) <= found.height_total[0]
    if zeta < 1e-6:  # sharper than the interval it is sought in can show
        return
    assert found.height_total[0] <= 1e-8
    assert peak.amplitude == pytest.approx(top, rel=1e-9)
    if square.size == 2 and (square > 0).all() and zeta > 1e-4:
        low, high = np.sqrt(square)
        expected = 1 / np.sqrt(1 - 2 * zeta**2) / (high - low)
        assert peak.amplification == pytest.approx(expected, rel=1e-6)


def test_small_ripples_and_open_flanks():
    x = np.linspace(0.0, 10.0, 1001)
    # Saddle of the two humps at 0.9 of the lower one: no half power width towards each other.
    y = np.exp(-((x - 3.0) ** 2)) + 1.2 * np.exp(-((x - 4.8) ** 2))
    low, high = resonance_peaks(x, y)
    assert np.isnan(low.half_power_high_rad_s) and np.isfinite(low.half_power_low_rad_s)
    assert np.isnan(low.amplification) and np.isnan(high.amplification)
    assert len(resonance_peaks(x, y, minimum_prominence=1.3)) == 1
    assert resonance_peaks(x, np.zeros_like(x)) == ()
    assert resonance_peaks(x, x) == ()


@pytest.mark.parametrize(
    ("x", "y", "expected"),
    [
        (2.0, -3j, (3.0, 2.0, 90.0, "forward")),
        (2.0, 1j, (2.0, 1.0, 0.0, "backward")),
        (3.0, 4.0, (5.0, 0.0, np.degrees(np.arctan2(4, 3)), "line")),
        (3.0, -4.0, (5.0, 0.0, -np.degrees(np.arctan2(4, 3)), "line")),
        (1.0, -1j, (1.0, 1.0, np.nan, "forward")),
        (0.0, 0.0, (0.0, 0.0, np.nan, "line")),
    ],
)
def test_known_ellipses(x, y, expected):
    for phase in (1.0, np.exp(0.7j), -1.0):
        orbit = elliptic_orbits(phase * x, phase * y)
        angle = np.degrees(orbit.inclination_rad)
        # ±90° is the same axis.
        found = [orbit.major_m, orbit.minor_m, abs(angle) if expected[2] == 90.0 else angle]
        np.testing.assert_allclose(found, expected[:3], atol=1e-12)
        assert orbit.direction == expected[3]


def test_wrong_arguments_are_refused():
    system = laval()
    for options, message in [
        ({"moment_kg_m": -1e-6}, "moment_kg_m is -1e-06"),
        ({"moment_kg_m": np.inf}, "moment_kg_m is inf"),
        ({"phase_rad": np.nan}, "phase_rad is nan"),
    ]:
        with pytest.raises(AnalysisError, match=message):
            dataclasses.replace(_hub_unbalance(), **options)
    fan = Unbalance(body="fan", interface="hub", moment_kg_m=1.0)
    rim = Unbalance(body="rotor", interface="rim", moment_kg_m=1.0)
    lists = ([], [-1.0, 2.0], [np.nan], 3.0)
    for assembled, unbalances, speeds, message in [
        (system, [fan], [10.0], "no body 'fan'; there are"),
        (system, [rim], [10.0], "no interface 'rim'; it has"),
        (system, [], [10.0], "unbalances is empty"),
        (laval(ratio=0.0), [_hub_unbalance()], [10.0], "speed ratio 0 and does not turn"),
        *((system, [_hub_unbalance()], speeds, "speeds_rad_s needs a list") for speeds in lists),
    ]:
        with pytest.raises(AnalysisError, match=message):
            unbalance_response(assembled, unbalances, speeds)
    response = unbalance_response(system, [_hub_unbalance()], [10.0])
    with pytest.raises(AnalysisError, match=r"no node rotor.rim; there are \['rotor.hub'\]"):
        response.exciters[0].at_node("rotor", "rim")


@pytest.mark.parametrize(
    ("x", "y", "prominence", "message"),
    [
        ([1.0, 2.0], [1.0, 2.0], 1.1, "3 or more"),
        ([1.0, 1.0, 2.0], [1.0, 2.0, 1.0], 1.1, "rising"),
        ([1.0, 2.0, 3.0], [1.0, -2.0, 1.0], 1.1, "0 or more"),
        ([1.0, 2.0, 3.0], [1.0, 2.0, 1.0], 0.9, "minimum_prominence is 0.9"),
    ],
)
def test_wrong_curves_are_refused(x, y, prominence, message):
    with pytest.raises(AnalysisError, match=message):
        resonance_peaks(x, y, prominence)


@pytest.mark.parametrize("is_free", [True, False])
def test_response_of_a_free_body_is_sampled_beside_rest(is_free):
    """It turns about its centre of gravity: U / m from the slowest speed on, not from 0."""
    system = one_rotor(hub(mass_kg=MASS), []) if is_free else laval()
    given = np.linspace(0.0, 400.0, 5)
    speeds = resolving_speeds(system, [_hub_unbalance()], given)
    beside = speeds[(speeds > 0.0) & (speeds < 0.1 * given[1])]
    assert beside.size == is_free
    for speed in beside:
        (exciter,) = unbalance_response(system, [_hub_unbalance()], [speed]).exciters
        np.testing.assert_allclose(exciter.orbits().major_m, MOMENT / MASS, rtol=1e-12)


def test_resonance_too_sharp_for_its_height_shows_its_place():
    """Very soft beside a stiff tilt: a sample at the peak would have fewer than three digits."""
    place, damping_ratio = 0.1, 2e-7
    stiffness, damping = MASS * place**2, 2.0 * damping_ratio * MASS * place
    support = ground("rotor", "hub", stiffness, None, damping, tilt=1e5)
    system = one_rotor(hub(mass_kg=MASS), [support])
    given = np.linspace(0.0, 200.0, 11)
    speeds = resolving_speeds(system, [_hub_unbalance()], given)
    assert np.isin(given, speeds).all()
    (exciter,) = unbalance_response(system, [_hub_unbalance()], speeds).exciters
    motion = np.abs(exciter.at_node("rotor", "hub")[:, 0])
    assert abs(speeds[motion.argmax()] - place) < 1e-3 * place
    np.testing.assert_allclose(motion, np.abs(_closed(speeds, stiffness, damping)), rtol=1e-3)
    with pytest.raises(AnalysisError, match="undamped resonance"):
        unbalance_response(system, [_hub_unbalance()], np.union1d(given, [place]))
