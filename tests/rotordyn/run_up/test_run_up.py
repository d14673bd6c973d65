"""Run-up of whole systems against independent integrators, steady response and other models."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import scipy.linalg as la
from rotors import connect, polynomial_law, rigid_body, table_law, turning
from scipy.integrate import solve_ivp

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.assembly.coordinates import interface_row
from solidwhirl.rotordyn.response.harmonic_response import harmonic_response, independent_loads
from solidwhirl.rotordyn.response.unbalance import Unbalance, turning_load, unbalance_response
from solidwhirl.rotordyn.run_up.integration import run_up
from solidwhirl.rotordyn.run_up.record import MotionState
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile

TABLE = table_law(
    [0.0, 90.0, 250.0],
    [[[4e5, 5e4], [-6e4, 3e5]], [[6e5, 9e4], [-9e4, 5e5]], [[7e5, 2e4], [-1e4, 4e5]]],
    [[[300, 20], [20, 200]], [[500, 0], [0, 300]], [[200, 0], [0, 400]]],
    "linear",
)
POLYNOMIAL = polynomial_law((1.0, -2e-3, 1e-5), (0.5, 1e-3), (1.0, -1e-3), top=300.0)


def spools(law=TABLE, damping=400.0):
    """Two counter-rotating rigid rotors, one within the other, on unlike bearings."""
    first = rigid_body("a", 12.0, 0.18, [0.5, 0.5, 0.7], {"l": 0.0, "m": 0.2, "r": 0.5})
    second = rigid_body("b", 6.0, 0.3, [0.2, 0.2, 0.25], {"m": 0.2, "r": 0.45})
    own = () if law is TABLE else ((5e5, 3e5), damping)
    bearings = (
        connect("left", "a.l", None, *own, speed_law=law),
        connect("right", "a.r", None, 6e5, damping),
        connect("inter", "b.m", "a.m", 8e5, damping),
        connect("outer", "b.r", None, (4e5, 5e5), damping),
    )
    return rd.assemble({"a": turning(first), "b": turning(second, -1.4)}, bearings)


UNBALANCES = (
    Unbalance(body="a", interface="m", moment_kg_m=2e-4, phase_rad=0.4),
    Unbalance(body="a", interface="r", moment_kg_m=1e-4, phase_rad=-1.0),
    Unbalance(body="b", interface="r", moment_kg_m=1e-4, phase_rad=2.0),
)
OUTPUTS = (rd.End(body="a", interface="l"), rd.End(body="b", interface="r"))
PROFILE = SpeedProfile(times_s=[0.0, 0.1, 0.14], speeds_rad_s=[0.0, 200.0, 200.0])


def integrated(system, profile, knots, times, start):
    """Motion by an adaptive Runge-Kutta method of order 8, smooth between `knots`, (s, 2n)."""
    n = system.size
    inverse = la.inv(system.mass)
    loads = []
    for u in UNBALANCES:
        ratio = system.system.rotors[u.body].speed_ratio
        rows = [interface_row(system, u.body, u.interface, c) for c in ("ux", "uy")]
        loads.append((ratio, u.phase_rad, u.moment_kg_m * np.array(rows)))

    def rate(time, state, piece):
        since, slope = time - profile.times_s[piece], profile.accelerations_rad_s2[piece]
        speed = profile.speeds_rad_s[piece] + slope * since
        angle = float(profile.angle_rad(profile.times_s[piece]))
        angle += 0.5 * (speed + profile.speeds_rad_s[piece]) * since
        matrices = rd.matrices_at_speed(system, float(speed))
        force = -(matrices.damping + matrices.gyroscopic) @ state[n:]
        force -= (matrices.stiffness + 0.5 * slope * system.gyroscopic) @ state[:n]
        for ratio, phase, rows in loads:
            c, s = np.cos(ratio * angle + phase), np.sin(ratio * angle + phase)
            square, change = (ratio * speed) ** 2, ratio * slope
            force += (square * c + change * s) * rows[0] + (square * s - change * c) * rows[1]
        return np.concatenate((state[n:], inverse @ force))

    states, state = [start], start
    for begin, stop in pairwise(np.unique([*profile.times_s, *knots])):
        inside = times[(times > begin + 1e-9) & (times <= stop + 1e-9)].clip(begin, stop)
        piece = int(np.searchsorted(profile.times_s, 0.5 * (begin + stop))) - 1
        options = {"dense_output": True, "args": (piece,), "rtol": 1e-8, "atol": 1e-12}
        done = solve_ivp(rate, (begin, stop), state, "DOP853", **options)
        states.extend(done.sol(inside).T)
        state = done.y[:, -1]
    return np.array(states)


REVERSAL = SpeedProfile(times_s=[0.0, 0.06, 0.1], speeds_rad_s=[150.0, 20.0, -110.0])
# where it passes 90, 0 and −90 rad/s, rows of the table
KNOTS = (0.06 * 60 / 130, 0.06 + 0.04 * 20 / 130, 0.06 + 0.04 * 110 / 130)


@pytest.mark.parametrize(
    ("law", "profile", "knots"), [(POLYNOMIAL, PROFILE, ()), (TABLE, REVERSAL, KNOTS)]
)
def test_agrees_with_an_adaptive_integrator(law, profile, knots):
    system = spools(law)
    run = run_up(
        system, profile, UNBALANCES, step_s=5e-5, outputs=OUTPUTS, phase_error_rad=1e-5,
        record_every=20,
    )  # fmt: skip
    start = np.zeros(2 * system.size)
    states = integrated(system, profile, knots, run.time_s, start)
    place = states[-1, : system.size]
    # phase 1e-5 in the blocks; the load of 280 rad/s is a cubic to (ωh)⁴/384 = 6e-8
    np.testing.assert_allclose(run.final.displacement, place, atol=2e-5 * np.abs(place).max())
    for at, end in enumerate(OUTPUTS):
        for k, component in enumerate(("ux", "uy")):
            row = interface_row(system, end.body, end.interface, component)
            halves = (states[:, : system.size], states[:, system.size :])
            for found, half in zip((run.translation_m, run.velocity_m_per_s), halves, strict=True):
                expected, limit = half @ row, 2e-5 * np.abs(half @ row).max()
                np.testing.assert_allclose(found[at, k], expected, atol=limit)


def test_error_falls_with_the_square_of_the_block():
    system = spools(POLYNOMIAL)
    options = {"step_s": 5e-5, "outputs": OUTPUTS, "record_every": 20}
    exact = run_up(system, PROFILE, UNBALANCES, phase_error_rad=1.5e-6, **options).translation_m
    errors, sizes = [], []
    for allowed in (1.6e-3, 4e-4, 1e-4):
        run = run_up(system, PROFILE, UNBALANCES, phase_error_rad=allowed, **options)
        errors.append(np.abs(run.translation_m - exact).max())
        sizes.append(run.longest_block)
    rates = np.log(np.array(errors[:-1]) / errors[1:]) / np.log(np.array(sizes[:-1]) / sizes[1:])
    # blocks of whole steps end unevenly: the rate is 2 but for some tenths
    assert (rates > 1.7).all()
    assert errors[0] < 1.6e-3 * np.abs(exact).max()


def steady_start(system, speed, unbalances):
    """Displacement and velocity at time 0 of the steady response at constant speed."""
    place, rate = np.zeros(system.size), np.zeros(system.size)
    for u in unbalances:
        omega = abs(system.system.rotors[u.body].speed_ratio) * speed
        load = omega**2 * independent_loads(system, {u.body: turning_load(system, u)})
        found = harmonic_response(system, [speed], [omega], load[None, :, None])
        amplitude = found.displacement[0, :, 0]
        place += amplitude.real
        rate += (1j * omega * amplitude).real
    return MotionState(displacement=place, velocity=rate)


def test_steady_response_at_constant_speed_stays():
    system, speed = spools(TABLE), 120.0
    start = steady_start(system, speed, UNBALANCES)
    # whole turns of both rotors: 5 of one are 7 of the other
    period = 5 * 2 * np.pi / speed
    errors = []
    for steps in (200, 400):
        profile = SpeedProfile(times_s=[0.0, period], speeds_rad_s=[speed, speed])
        options = {"outputs": OUTPUTS, "bearings": ["left", "inter"], "initial": start}
        run = run_up(system, profile, UNBALANCES, step_s=period / steps, **options)
        response = unbalance_response(system, UNBALANCES, [speed])
        error = 0.0
        for at, end in enumerate(OUTPUTS):
            expected = sum(
                (e.at_node(end.body, end.interface)[0][:, None]
                 * np.exp(1j * e.frequencies_rad_s[0] * run.time_s)).real
                for e in response.exciters
            )  # fmt: skip
            error = max(error, np.abs(run.translation_m[at, :2] - expected).max())
        errors.append(error / np.abs(run.translation_m).max())
    # only the Hermite cubic of the load is left, of fourth order
    assert np.log2(errors[0] / errors[1]) > 3.7
    assert errors[1] < 1e-6
    for name in ("left", "inter"):
        expected = sum(
            (e.bearing_forces[name][0][:, None]
             * np.exp(1j * e.frequencies_rad_s[0] * run.time_s)).real
            for e in response.exciters
        )  # fmt: skip
        force = run.bearing_force_n(name)
        np.testing.assert_allclose(force, expected[:3], atol=1e-5 * np.abs(expected).max())
