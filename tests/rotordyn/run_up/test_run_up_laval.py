"""Run-up of a disk on springs, where the motion is known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from rotors import connect, ground, hub, one_rotor, steel_shaft
from scipy.special import fresnel

from solidwhirl.rotordyn import End
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up.integration import run_up
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile, ramp_and_hold

MASS = 10.0
NATURAL = 100.0
ECCENTRICITY = 1e-4
AT = End(body="rotor", interface="hub")


UNBALANCE = Unbalance(body="rotor", interface="hub", moment_kg_m=MASS * ECCENTRICITY)


def laval(stiff_y=1.0):
    stiffness = MASS * NATURAL**2
    held = ground("rotor", "hub", stiffness, stiff_y * stiffness, tilt=1e4)
    return one_rotor(hub(mass_kg=MASS), [held])


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
    run = run_up(system, profile, [UNBALANCE], step_s=step, outputs=[AT], **options)
    x, y, _ = run.translation_m[0]
    return run, x + 1j * y, acceleration


def test_passage_through_the_critical_speed_follows_the_fresnel_solution():
    run, path, acceleration = accelerated(laval(), 40.0)
    expected = ECCENTRICITY * (mass_center(run.time_s, acceleration) - np.exp(1j * run.angle_rad))
    # load as a Hermite cubic: (ωh)⁴/384 = 3e-9 at 160 rad/s, times the amplification of 20
    np.testing.assert_allclose(path, expected, atol=1e-7 * np.abs(expected).max())


def test_gravity_is_static_equilibrium():
    options = {"outputs": [AT], "bearings": ["rotor.hub"], "gravity_m_per_s2": (0.0, -9.81, 0.0)}
    run = run_up(laval(stiff_y=0.5), ramp_and_hold(150.0, 0.5), [], step_s=1e-3, **options)
    x, y, _ = run.translation_m[0]
    np.testing.assert_allclose(y, -9.81 / (0.5 * NATURAL**2), rtol=1e-9)
    assert np.abs(x).max() < 1e-12 * np.abs(y).max()
    # the disk presses on the ground with its weight
    np.testing.assert_allclose(run.bearing_force_n("rotor.hub")[1], -MASS * 9.81, rtol=1e-9)


def test_torsion_answers_a_step_of_acceleration():
    """Two inertias on a shaft, driven at one end: ψ = ψs (1 − cos ωt), ψs = −Ω' J2/k."""
    radius, length = 0.01, 0.5
    disks = [(z, 5.0, j, 0.5 * j) for z, j in ((0.0, 0.4), (length, 0.1))]
    # density next to nothing leaves two inertias and a spring
    light = {"material": (2e11, 0.3, 1e-3), "components": ("ux", "uy", "rx", "ry", "rz")}
    seats = {"a": 0.0, "b": length}
    shaft = steel_shaft("shaft", [0.0, length], radius, seats, disks, **light)
    held = [connect(at, f"rotor.{at}", stiffness=1e6, tilt=1e4) for at in "ab"]
    system = one_rotor(shaft, held, 2.0)
    spring = 2e11 / 2.6 * 0.5 * np.pi * radius**4 / length
    natural = np.sqrt(spring * (1 / 0.4 + 1 / 0.1))
    acceleration = 50.0
    ends = [End(body="rotor", interface=at) for at in "ab"]
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
