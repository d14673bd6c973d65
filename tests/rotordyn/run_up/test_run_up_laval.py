"""Run-up of a disk on springs, where the motion is known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import fresnel

from solidwhirl.rotordyn import Disk, End, Rotor, assemble, beam_superelement
from solidwhirl.rotordyn.assembly.parts import Bearing
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up.integration import run_up
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile, ramp_and_hold

MASS = 10.0
NATURAL = 100.0
ECCENTRICITY = 1e-4
AT = End(body="rotor", interface="hub")


def unbalance(phase=0.0):
    return Unbalance(
        body="rotor", interface="hub", moment_kg_m=MASS * ECCENTRICITY, phase_rad=phase
    )


@pytest.fixture
def laval(hub, ground):
    def build(damping_ratio=0.0, ratio=1.0, stiff_y=1.0):
        stiffness = MASS * NATURAL**2
        damping, tilt = 2 * damping_ratio * MASS * NATURAL, 1e4 * np.eye(2)
        lateral = (stiffness, stiff_y * stiffness, damping)
        bearing = ground("rotor", "hub", *lateral, tilt_stiffness_n_m_per_rad=tilt)
        rotor = Rotor(element=hub(mass_kg=MASS), speed_ratio=ratio)
        return assemble({"rotor": rotor}, (bearing,))

    return build


def mass_center(time, acceleration):
    """Path of the mass centre of an undamped disk, accelerated from rest, over its eccentricity.

    With w = z + e exp(iφ) the equation z'' + ω0² z = e (ω² − iω') exp(iφ) becomes that of a force
    of constant size, w'' + ω0² w = ω0² e exp(iφ), which Lewis (1932) solved by Fresnel integrals.
    """

    def chirp(frequency):
        root, shift = np.sqrt(acceleration / np.pi), frequency / acceleration
        s, c = fresnel(root * (time - shift))
        s0, c0 = fresnel(-root * shift)
        turn = np.exp(-0.5j * frequency**2 / acceleration)
        return turn * ((c - c0) + 1j * (s - s0)) / root

    wave = np.exp(1j * NATURAL * time)
    duhamel = (wave * chirp(NATURAL) - chirp(-NATURAL) / wave) / 2j
    return np.cos(NATURAL * time) + NATURAL * duhamel


def accelerated(system, cycles, past=1.6, step=2e-4, **options):
    """Run from rest past the critical speed; `cycles` is q = f0²/(df/dt) of Lewis."""
    acceleration = NATURAL**2 / (2 * np.pi * cycles)
    duration = np.ceil(past * NATURAL / acceleration / step) * step
    profile = ramp_and_hold(acceleration * duration, duration)
    run = run_up(system, profile, [unbalance()], step_s=step, outputs=[AT], **options)
    x, y, _ = run.translation_m[0]
    return run, x + 1j * y, acceleration


def test_passage_through_the_critical_speed_follows_the_fresnel_solution(laval):
    run, path, acceleration = accelerated(laval(), 40.0)
    expected = ECCENTRICITY * (mass_center(run.time_s, acceleration) - np.exp(1j * run.angle_rad))
    # load as a Hermite cubic: (ωh)⁴/384 = 3e-9 at 160 rad/s, times the amplification of 20
    np.testing.assert_allclose(path, expected, atol=1e-7 * np.abs(expected).max())


def test_peak_of_slow_passage_is_that_of_lewis(laval):
    # Largest |w|/e → 1.1705 π √q at ω/ω0 → 1 + 1.2172/√(2q), from the largest chord of the Cornu
    # spiral seen from its eye (1.6553, at 1.2172). The next terms are of order 1/q.
    errors = []
    for cycles in (50.0, 200.0):
        run, path, _ = accelerated(laval(), cycles, past=1.3, step=5e-4)
        amplitude = np.abs(path / ECCENTRICITY + np.exp(1j * run.angle_rad))
        peak = int(amplitude.argmax())
        assert amplitude[peak] == pytest.approx(1.1705 * np.pi * np.sqrt(cycles), rel=0.02)
        shift = run.speed_rad_s[peak] / NATURAL - 1.0
        assert shift == pytest.approx(1.2172 / np.sqrt(2 * cycles), rel=0.1)
        errors.append(abs(amplitude[peak] / (1.1705 * np.pi * np.sqrt(cycles)) - 1.0))
    assert errors[1] < errors[0]


@pytest.mark.parametrize("ratio", [1.0, -1.5])
def test_phase_and_sense_of_the_unbalance(laval, ratio):
    # A light, stiffly held disk follows its load at once: z = u/k (ω² − iω') e^{i(φ + phase)}.
    profile = ramp_and_hold(4.0, 1.0, start_speed_rad_s=1.0)
    run = run_up(
        laval(damping_ratio=0.7, ratio=ratio), profile, [unbalance(0.6)], step_s=1e-3, outputs=[AT]
    )
    x, y, _ = run.translation_m[0]
    omega, change = ratio * run.speed_rad_s, ratio * 3.0
    expected = (omega**2 - 1j * change) * np.exp(1j * (ratio * run.angle_rad + 0.6))
    path = (x + 1j * y) / ECCENTRICITY * NATURAL**2
    # the next term is 2D ω'/ω0 of the load with D = 0.7, ω <= 6: 8 %
    np.testing.assert_allclose(path[200:], expected[200:], atol=0.1 * np.abs(expected).max())


def test_gravity_is_static_equilibrium(laval):
    options = {"outputs": [AT], "bearings": ["rotor.hub"], "gravity_m_per_s2": (0.0, -9.81, 0.0)}
    run = run_up(laval(stiff_y=0.5), ramp_and_hold(150.0, 0.5), [], step_s=1e-3, **options)
    x, y, _ = run.translation_m[0]
    np.testing.assert_allclose(y, -9.81 / (0.5 * NATURAL**2), rtol=1e-9)
    assert np.abs(x).max() < 1e-12 * np.abs(y).max()
    # the disk presses on the ground with its weight
    np.testing.assert_allclose(run.bearing_force_n("rotor.hub")[1], -MASS * 9.81, rtol=1e-9)


def test_end_of_the_ramp_excites_free_vibration(laval):
    # Slow motion is z = (Z0 + Z1) e^{iφ}, Z0 = e ω²/D(ω), D = ω0² − ω² + 2iδω, and to first order
    # in ω' D Z1 = −iω'e − iω'(2ωZ0' + Z0) − 2δω'Z0'. Where ω' ends, Z1 and ω'Z0' are left over.
    ratio, speed, ramp, step = 0.06, 300.0, 5.0, 2e-4
    decay, change = ratio * NATURAL, speed / ramp

    def slow(omega):
        return ECCENTRICITY * omega**2 / (NATURAL**2 - omega**2 + 2j * decay * omega)

    slope = (slow(speed + 0.1) - slow(speed - 0.1)) / 0.2
    left = -1j * change * (ECCENTRICITY + 2 * speed * slope + slow(speed))
    left = (left - 2 * decay * change * slope) / (ECCENTRICITY * speed**2 / slow(speed))
    damped = NATURAL * np.sqrt(1 - ratio**2)
    exponents = np.array([-decay + 1j * damped, -decay - 1j * damped])
    start = np.array([left, 1j * speed * left + change * slope])
    expected = np.linalg.solve(np.stack((np.ones(2), exponents)), start)

    profile = ramp_and_hold(speed, ramp, 0.5)
    run = run_up(laval(damping_ratio=ratio), profile, [unbalance()], step_s=step, outputs=[AT])
    path = run.translation_m[0, 0] + 1j * run.translation_m[0, 1]
    steady = slow(speed) * np.exp(1j * run.angle_rad)
    after = run.time_s >= ramp
    angle = float(profile.angle_rad(ramp))
    free = ((path - steady) * np.exp(-1j * angle))[after]
    waves = np.exp(np.outer(run.time_s[after] - ramp, exponents))
    found, *_ = np.linalg.lstsq(waves, free, rcond=None)
    # the next order is ω'/(ω − ω0)² = 1.5e-3; the load is a cubic to 3e-8 of e, 1e-4 of this
    np.testing.assert_allclose(found, expected, rtol=1e-2)
    assert np.abs(free - waves @ found).max() < 0.02 * np.abs(expected).max()


def test_torsion_answers_a_step_of_acceleration():
    """Two inertias on a shaft, driven at one end: ψ = ψs (1 − cos ωt), ψs = −Ω' J2/k."""
    radius, length = 0.01, 0.5
    disks = [
        Disk(name=n, position_m=z, mass_kg=5.0, polar_kg_m2=j, diametral_kg_m2=0.5 * j)
        for n, z, j in (("drive", 0.0, 0.4), ("driven", length, 0.1))
    ]
    # density next to nothing leaves two inertias and a spring
    shaft = beam_superelement(
        "shaft", [0.0, length], radius, 0.0, (2e11, 0.3, 1e-3), {"a": 0.0, "b": length}, disks,
        ("ux", "uy", "rx", "ry", "rz"),
    )  # fmt: skip
    held = tuple(
        Bearing(
            name=at,
            first=End(body="shaft", interface=at),
            stiffness_n_per_m=1e6 * np.eye(2),
            tilt_stiffness_n_m_per_rad=1e4 * np.eye(2),
        )
        for at in "ab"
    )
    system = assemble({"shaft": Rotor(element=shaft, speed_ratio=2.0)}, held)
    spring = 2e11 / 2.6 * 0.5 * np.pi * radius**4 / length
    natural = np.sqrt(spring * (1 / 0.4 + 1 / 0.1))
    acceleration = 50.0
    ends = [End(body="shaft", interface=at) for at in "ab"]
    stop = 2.5 * 2 * np.pi / natural
    step = stop / 500
    profile = SpeedProfile(times_s=[0.0, stop, 2 * stop], speeds_rad_s=[0, 50 * stop, 50 * stop])
    run = run_up(
        system, profile, [], step_s=step, outputs=ends, drives=[ends[0]], phase_error_rad=0.1
    )
    twist = run.rotation_rad[1, 2] - run.rotation_rad[0, 2]
    static = -2.0 * acceleration * 0.1 / spring
    t = run.time_s
    expected = static * (1 - np.cos(natural * t))
    # after the ramp: the same step taken away again, after 2.5 periods
    late = t > stop
    expected[late] -= static * (1 - np.cos(natural * (t[late] - stop)))
    np.testing.assert_allclose(twist, expected, atol=1e-5 * abs(static))
    assert np.abs(twist[late]).max() == pytest.approx(2 * abs(static), rel=1e-3)
    undriven = run_up(system, profile, [], step_s=step, outputs=ends, phase_error_rad=0.1)
    assert not undriven.rotation_rad.any()
