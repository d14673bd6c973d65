"""Asymmetric bodies: closed forms, two-bladed hubs, multipliers of a period."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from flat_rotors import on_shaft, two_blades
from sometimes import often
from turning_frame import floquet_multipliers as by_steps

from solidwhirl.rotordyn.asymmetric import (
    Joint,
    PeriodicSystem,
    closed_by_damping,
    floquet_exponents,
    floquet_multipliers,
    hill_block,
    turning_body,
    unstable_ranges,
)
from solidwhirl.rotordyn.asymmetric.periodic import Term
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.stability.eigenvalue_paths import prepared, solve

RPM = np.pi / 30.0


@cache
def unlike_planes(damping=(0.0, 0.0), cross=0.0):
    """Two blades on a mast with unlike planes: the system, its parts, and its unstable ranges."""
    system, direct = two_blades((40.0, 90.0), damping, cross)
    return system, direct, unstable_ranges(system, 0.5, 12.0)


def test_flat_shaft_is_unstable_between_its_critical_speeds():
    (found,) = unstable_ranges(on_shaft(5.0, (1e6, 2e6)), 100.0, 900.0)
    assert (found.low_rad_s, found.high_rad_s) == pytest.approx(
        (np.sqrt(1e6 / 5.0), np.sqrt(2e6 / 5.0)), rel=1e-12
    )
    found_rpm = found.low_rad_s / RPM, found.high_rad_s / RPM
    assert found_rpm == pytest.approx((4270.6, 6039.5), abs=0.05)
    assert (found.kind, found.frequency_rad_s) == ("divergence", 0.0)
    assert found.growth_1_s == pytest.approx(found.floquet_1_s, rel=1e-9)


def test_damping_from_outside_narrows_and_closes_the_range():
    """The quartic of (s² + 2ζω0 s + ω1² − Ω²)(...) + (2Ωs + 2ζω0Ω)² at s = 0."""
    middle = np.sqrt(0.5 * (1.0 + 1.21))
    (found,) = unstable_ranges(on_shaft(1.0, (1.0, 1.21), 2.0 * 0.02 * middle), 0.1, 3.0)
    assert (found.low_rad_s, found.high_rad_s) == pytest.approx((1.004425, 1.095154), abs=1e-6)
    assert unstable_ranges(on_shaft(1.0, (1.0, 1.21), 2.0 * 0.05 * middle), 0.1, 3.0) == ()


def test_two_blades_on_a_mast_that_is_the_same_in_all_directions():
    system, _ = two_blades((40.0, 40.0))
    found = unstable_ranges(system, 0.1, 12.0)
    assert [(r.low_rad_s, r.high_rad_s) for r in found] == [
        pytest.approx(known, abs=1e-5) for known in ((1.85943, 2.10819), (7.40948, 10.45729))
    ]
    assert [r.kind for r in found] == ["divergence", "flutter"]
    block = prepared(hill_block(system, 0), 90.0, 0.1, 12.0)
    assert solve(block, 2.0).values.real.max() == pytest.approx(0.117036, abs=1e-6)


@pytest.mark.parametrize(
    ("damping", "cross"),
    often([((0.0, 0.0), 0.0), ((0.3, 0.2), 0.0), ((0.5, 0.5), 0.4)], ((0.3, 0.2), 0.0)),
)
def test_two_blades_on_a_mast_with_unlike_planes(damping, cross):
    """Ends against multipliers on either side of them, growth against those inside."""
    system, direct, found = unlike_planes(damping, cross)
    assert len(found) > 3
    for one in found:
        assert one.growth_1_s == pytest.approx(one.floquet_1_s, rel=1e-7)
        assert one.error_rad_s < 1e-6
        ends = ((one.low_rad_s, one.opens), (one.high_rad_s, one.closes))
        for end in [speed for speed, is_one in ends if is_one]:
            step = 1e-4 * (one.speed_rad_s - end)
            out, into = (floquet_multipliers(system, end + d, 1e-12) for d in (-step, step))
            assert out.growth_1_s < 1e-9 < 1e-7 < into.growth_1_s
    # what lies between is stable: a sweep that shares nothing with the search
    turning, hold = direct
    for speed in np.linspace(0.6, 11.9, 24):
        grows = any(r.low_rad_s < speed < r.high_rad_s for r in found)
        known = by_steps(turning, np.eye(6, 4), speed, hold)
        rate = np.log(np.abs(known).max()) * speed / (2.0 * np.pi)
        assert (rate > 1e-6) == grows


def test_multipliers_are_those_of_an_integration_in_time():
    system, (turning, hold) = two_blades((40.0, 90.0), (0.3, 0.2), 0.4)
    found = floquet_multipliers(system, 2.5)
    known = by_steps(turning, np.eye(6, 4), 2.5, hold)
    # a turn of the body has two periods of its support
    assert np.sort(np.abs(found.values) ** 2) == pytest.approx(np.sort(np.abs(known)), abs=1e-9)


def test_matrices_without_a_constant_and_without_velocity():
    """A stiffness that changes along circles: growth by both methods."""
    zero = np.zeros((2, 2))
    still = {"mass": np.eye(2), "gyroscopic": zero, "stiffness": zero,
             "centrifugal_stiffness": zero}  # fmt: skip
    spring = np.diag([1.0, 1.21, 0.0, 0.0, 0.0, 0.0])
    system = turning_body(still, [Joint(np.eye(6, 2), spring, 0.0 * spring)])
    assert system.stride == 2
    assert system.velocity == ()
    known = floquet_multipliers(system, 1.05)
    found = solve(prepared(hill_block(system, 4), 1.0, 0.5, 2.0), 1.05)
    assert found.own.real.max() == pytest.approx(known.growth_1_s, abs=1e-9)
    # seen along with the springs it is a flat shaft between its critical speeds
    (one,) = unstable_ranges(system, 0.5, 2.0)
    assert (one.low_rad_s, one.high_rad_s) == pytest.approx((1.0, 1.1), rel=1e-9)


@pytest.mark.parametrize("speeds", [(0.0, 1.0), (2.0, 1.0), (1.0, np.inf)])
def test_speeds_that_have_no_meaning(speeds):
    with pytest.raises(AnalysisError, match="above 0 and rise"):
        unstable_ranges(on_shaft(1.0, (1.0, 2.0)), *speeds)


def test_modes_that_meet_are_told_by_their_frequencies():
    """Twice one frequency, or the sum of two, is a whole number of strides of the speed."""
    system, _, found = unlike_planes()
    told = [(r.meeting.relation, r.meeting.order) for r in found]
    assert told == [("main", 0), ("difference", 0), ("main", 2), ("difference", 0), ("sum", 1)]
    for one in found:
        first, second, stride = one.meeting.first_rad_s, one.meeting.second_rad_s, 2.0
        both = first - second if one.meeting.relation == "difference" else first + second
        assert both == pytest.approx(one.meeting.order * stride * one.low_rad_s, abs=1e-9)
        # the motions of the open range are those of the two modes, by whole strides
        (near,) = floquet_exponents(system, [one.low_rad_s - 1e-5])
        beat = stride * one.low_rad_s
        rests = np.abs((near.imag[:, None] - [first, second] + 0.5 * beat) % beat - 0.5 * beat)
        assert rests.min(axis=0) == pytest.approx(0.0, abs=0.02)


def closed(system, low, high):
    return closed_by_damping(system, low, high, unstable_ranges(system, low, high))


def test_ranges_that_damping_closes():
    middle = np.sqrt(0.5 * (1.0 + 1.21))
    damped = on_shaft(1.0, (1.0, 1.21), 2.0 * 0.05 * middle)
    (one,) = closed(damped, 0.1, 3.0)
    assert (one.low_rad_s, one.high_rad_s) == pytest.approx((1.0, 1.1), rel=1e-12)
    assert closed(on_shaft(1.0, (1.0, 1.21), 2.0 * 0.02 * middle), 0.1, 3.0) == ()
    # what is left of a two-bladed hub is named by the undamped one, less what closes
    system, _, left = unlike_planes((0.3, 0.2))
    undamped = {r.low_rad_s for r in unlike_planes()[2]}
    assert {r.low_rad_s for r in closed_by_damping(system, 0.5, 12.0, left)} < undamped


@pytest.mark.verify
def test_ends_of_a_rotor_searched_in_few_coordinates():
    """A hub with stiff inner masses on springs: ends against multipliers of the whole system."""
    system, _ = two_blades((40.0, 90.0), (0.3, 0.2))
    whole = with_stiff_masses(system, 4e4)
    found = unstable_ranges(whole, 1.9, 4.0)
    assert [r.kind for r in found] == ["divergence", "flutter", "divergence"]
    for one in found:
        assert one.growth_1_s == pytest.approx(one.floquet_1_s, rel=1e-4)
        for end in (one.low_rad_s, one.high_rad_s):
            step = 1e-4 * (one.speed_rad_s - end)
            out, into = (floquet_multipliers(whole, end + d, 1e-12) for d in (-step, step))
            assert out.growth_1_s < 1e-8 < into.growth_1_s


def with_stiff_masses(system, spring):
    """Every coordinate carries a mass of 0.1 on a stiff spring: twice the coordinates."""

    def doubled(terms):
        both = np.array([[1.0, 0.0], [0.0, 0.0]])
        return [Term(h, p, np.kron(both, a)) for h, p, a in terms]

    tie = np.kron([[1.0, -1.0], [-1.0, 1.0]], np.diag(spring * np.arange(1.0, system.size + 1.0)))
    return PeriodicSystem(
        mass=np.kron(np.array([[1.0, 0.0], [0.0, 0.0]]), system.mass)
        + np.kron(np.diag([0.0, 0.1]), np.eye(system.size)),
        velocity=tuple(doubled(system.velocity)),
        stiffness=(*doubled(system.stiffness), Term(0, 0, tie)),
    )


def test_constant_system_has_eigenvalues_not_exponents():
    with pytest.raises(AnalysisError, match="changes with the angle"):
        floquet_exponents(on_shaft(1.0, (1.0, 2.0)), [1.0])


def test_speeds_far_below_the_first_mode():
    """The slowest mode turns at 1.8: what could grow below 0.3 is of a high order and damped."""
    system, _ = two_blades((40.0, 90.0), (0.3, 0.2))
    assert unstable_ranges(system, 0.1, 0.3) == ()
    for speed in (0.12, 0.2, 0.29):
        assert floquet_multipliers(system, speed).growth_1_s < 1e-9
