"""Energy of a run-up, and the tables and steps it is made of."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import scipy.linalg as la
from rotors import between_bearings, three_disk_element

from solidwhirl.rotordyn import End, InternalDamping, modes_at_speed
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up.integration import run_up
from solidwhirl.rotordyn.run_up.record import MotionState
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile, ramp_and_hold
from solidwhirl.rotordyn.run_up.speed_table import tabulate
from solidwhirl.rotordyn.run_up.steps import step_operators


def constant(speed, duration):
    return SpeedProfile(times_s=[0.0, duration], speeds_rad_s=[speed, speed])


def struck(system, seed=0):
    """A start in the lowest modes, so that all of it is resolved by the step."""
    modes = modes_at_speed(system, 0.0, count=6).shapes.real
    weights = np.random.default_rng(seed).standard_normal((2, modes.shape[1]))
    return MotionState(displacement=modes @ weights[0] * 1e-4, velocity=modes @ weights[1] * 0.1)


def with_centrifugal(element):
    """The element with a made-up K2 on its modes that leaves rigid motion alone."""
    modal = np.array([c.kind == "modal" for c in element.coordinates], dtype=float)
    return dataclasses.replace(element, stress_stiffening=np.diag(0.3 * modal))


def test_free_undamped_motion_keeps_its_energy():
    system = between_bearings(with_centrifugal(three_disk_element()), 7e7, 5e7)
    assert system.centrifugal_stiffness.any() and system.gyroscopic.any()
    start = struck(system)
    run = run_up(system, constant(800.0, 0.5), [], step_s=1e-4, initial=start)
    stiffness = system.stiffness + 800.0**2 * system.centrifugal_stiffness

    def energy_of(state):
        kinetic = state.velocity @ system.mass @ state.velocity
        return 0.5 * (kinetic + state.displacement @ stiffness @ state.displacement)

    energy = energy_of(start)
    assert run.energy.stored_j[0] == pytest.approx(energy, rel=1e-11)
    # exact exponential but for rounding of 1e-16 times h times the highest frequency, 5000 steps
    np.testing.assert_allclose(run.energy.stored_j, energy, rtol=1e-9)
    assert energy_of(run.final) == pytest.approx(energy, rel=1e-9)


def test_internal_damping_feeds_an_unstable_rotor():
    damping = InternalDamping(modal_ratio=0.02)
    system = between_bearings(three_disk_element(), 7e7, inside=damping)
    speed = 1500.0
    growth = modes_at_speed(system, speed, count=2).eigenvalues.real.max()
    assert growth > 0
    run = run_up(system, constant(speed, 1.0), [], step_s=1e-4, initial=struck(system))
    stored = run.energy.stored_j
    late = np.log(stored[-1] / stored[-3000]) / (2 * (run.time_s[-1] - run.time_s[-3000]))
    # the most unstable mode alone is left in the end
    assert late == pytest.approx(growth, rel=0.02)
    assert run.energy.drive_work_j[-1] > run.energy.dissipated_j[-1] > 0
    assert np.abs(run.energy.error_j).max() < 0.01 * stored[-1]


def test_energy_balance_closes_with_the_cube_of_the_step():
    inside = InternalDamping(modal_ratio=0.05)
    system = between_bearings(three_disk_element(), 7e7, 5e7, 1e4, inside=inside)
    unbalances = [Unbalance(body="rotor", interface="left", moment_kg_m=1e-2)]
    profile = ramp_and_hold(500.0, 0.5, 0.1)
    errors = []
    for step in (2e-4, 1e-4):
        run = run_up(
            system, profile, unbalances, step_s=step, gravity_m_per_s2=(0.0, -9.81, 0.0),
            phase_error_rad=3e-4,
        )  # fmt: skip
        energy = run.energy
        size = np.abs(energy.load_work_j).max()
        errors.append(np.abs(energy.error_j).max() / size)
    # inside a block of equal speed the order is 4, at its ends, where slopes are one-sided, 3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(3.0, abs=0.3)
    assert errors[1] < 1e-5
    # every part takes a share well above that
    for part in (energy.stored_j - energy.stored_j[0], energy.drive_work_j, energy.dissipated_j):
        assert np.abs(part).max() > 0.05 * size


def test_step_is_exact_for_loads_cubic_in_time():
    # σ = 0.3/h: resolved; 40/h: far beyond the step, where the response is that of statics.
    h = 0.01
    scale = np.array([30.0, 4000.0])
    damping = np.array([[3.0, 1.0], [-1.0, 200.0]])
    rows = np.hstack((-np.diag(scale), -damping))
    loads = np.array([[1.0, 0.5], [2.0, -1.0]])
    constants = np.array([[0.7], [0.2]])
    state = np.array([0.1, -0.2, 0.3, 0.5])
    cubic = np.array([[1.0, 2.0], [-3.0, 0.4], [50.0, 10.0], [200.0, -900.0]])
    propagator, load_rows, constant_rows = step_operators(scale, rows, loads, constants, h)

    def load(t):
        return cubic.T @ t ** np.arange(4), cubic[1:].T @ (np.arange(1, 4) * t ** np.arange(3))

    (start, start_rate), (end, end_rate) = load(0.0), load(h)
    given = np.concatenate((start, end, h * start_rate, h * end_rate))
    found = state @ propagator + given @ load_rows + constant_rows[0]

    # particular solution: a cubic too, by comparing powers of t
    n = 4
    matrix = np.vstack((np.hstack((np.zeros((2, 2)), np.diag(scale))), rows))
    push = [np.concatenate((np.zeros(2), loads @ row)) for row in cubic]
    push[0] = push[0] + np.concatenate((np.zeros(2), constants[:, 0]))
    powers = [np.zeros(n)] * 5
    for k in (3, 2, 1, 0):
        powers[k] = la.solve(matrix, (k + 1) * powers[k + 1] - push[k])
    particular = sum(p * h**k for k, p in enumerate(powers))
    expected = la.expm(h * matrix) @ (state - powers[0]) + particular
    np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-13)


def test_table_follows_smooth_functions_and_finds_kinks():
    calls = []

    def sample(x):
        calls.append(x)
        smooth = np.outer([1.0, 2.0], [np.sin(3 * x), np.exp(x), 1.0])
        return smooth, np.array([abs(x - 0.3), 1e-8 * x])

    table = tabulate(sample, [-1.0, 0.3, 2.0], 1e-3)
    used = len(calls)
    assert used < 120
    for x in np.linspace(-1.0, 2.0, 41):
        for found, expected in zip(table([x]), sample(float(x)), strict=True):
            assert np.abs(found[0] - expected).max() <= 1e-10 * max(1.0, np.abs(expected).max())

    # a kink that nobody named is closed in upon
    hidden = tabulate(sample, [-1.0, 2.0], 1e-3)
    for x in np.linspace(-1.0, 2.0, 41):
        for found, expected in zip(hidden([x]), sample(float(x)), strict=True):
            assert np.abs(found[0] - expected).max() <= 1e-3
    alone = tabulate(sample, [0.5], 1e-3)
    np.testing.assert_array_equal(alone([0.5])[1][0], sample(0.5)[1])


def test_stiff_joints_cost_no_digits():
    # 1e14 N/m beside 1e7: σh = 2e3; the answer is that of joints twice as stiff.
    runs = []
    for stiff in (1e14, 2e14):
        inside = InternalDamping(modal_ratio=0.05)
        system = between_bearings(three_disk_element(), stiff, inside=inside)
        unbalance = Unbalance(body="rotor", interface="left", moment_kg_m=1e-2)
        options = {"step_s": 1e-4, "gravity_m_per_s2": (0.0, -9.81, 0.0),
                   "outputs": [End(body="rotor", interface="right")]}  # fmt: skip
        runs.append(run_up(system, ramp_and_hold(200.0, 0.2), [unbalance], **options))
    one, other = (run.rotation_rad[0] for run in runs)
    np.testing.assert_allclose(one, other, atol=1e-6 * np.abs(one).max())
