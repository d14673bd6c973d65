"""Sets of bearings and means over ball positions, against textbook equations and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import fsolve

from solidwhirl.rotordyn.assembly.bearing_laws import RingLaw
from solidwhirl.rotordyn.bearings.balls import BallBearing
from solidwhirl.rotordyn.bearings.rollers import RollerBearing
from solidwhirl.rotordyn.bearings.rolling import (
    BearingSet,
    RingLoad,
    loaded_ring,
    mean_stiffness,
    ring_states,
    ring_table,
)

RPM = np.pi / 30.0
ALPHA = np.radians(15.0)
ROW = BallBearing(
    ball_count=9, ball_diameter_m=8e-3, pitch_diameter_m=50e-3, contact_angle_rad=ALPHA
)
STEP = 14e-3
DB = BearingSet(row=ROW, facing=(1, -1), places_m=(-STEP / 2, STEP / 2))
DF = BearingSet(row=ROW, facing=(-1, 1), places_m=(-STEP / 2, STEP / 2))
RIGID = RingLoad(load_n=(0.0, 0.0, 0.0), preload_n=250.0, preload="rigid")
REST = np.zeros(1)


def mean(bearings, load, rpm=0.0, **more):
    return mean_stiffness(bearings, load, np.array([rpm * RPM]), **more).mean[0]


def ball_force(row, r, a, own):
    """Force (radial, axial) on the inner groove centre at (r, a): two forces at each race.

    Harris and Kotzalas (2006), Advanced Concepts, equations 3.17 to 3.29, for one ball.
    """
    li, lo = (
        (row.inner_groove - 0.5) * row.ball_diameter_m,
        (row.outer_groove - 0.5) * (row.ball_diameter_m),
    )
    ki, ko = row.inner.stiffness_n_per_m15, row.outer.stiffness_n_per_m15

    def loads(x):
        v = x * 1e-3
        long = np.hypot(a - v[1], r - v[0]), np.hypot(*v)
        return (
            v,
            long,
            [
                k * max(d - free, 0.0) ** 1.5
                for k, d, free in zip((ki, ko), long, (li, lo), strict=True)
            ],
        )

    def miss(x):
        v, (di, do), (qi, qo) = loads(x)
        return [
            qo * v[0] / do - qi * (r - v[0]) / di - own,
            qo * v[1] / do - qi * (a - v[1]) / di,
        ]

    start = np.array([r, a]) * (lo + 0.5 * max(np.hypot(r, a) - li - lo, 0.0)) / np.hypot(r, a)
    x = fsolve(miss, start * 1e3, xtol=1e-13)
    v, (di, _), (qi, _) = loads(x)
    return np.array([qi * (r - v[0]) / di, qi * (a - v[1]) / di])


def set_force(bearings, q, shifts, own):
    """Force and moment on the ring of a set at a motion (5,), its first balls at +x."""
    row, total = bearings.row, np.zeros(5)
    arm = 0.5 * row.pitch_diameter_m + (row.inner_groove - 0.5) * row.ball_diameter_m * np.cos(
        ALPHA
    )
    distance = (row.inner_groove + row.outer_groove - 1.0) * row.ball_diameter_m
    for way, z, shift in zip(bearings.facing, bearings.places_m, shifts, strict=True):
        for angle in 2 * np.pi * np.arange(row.ball_count) / row.ball_count:
            c, s = np.cos(angle), np.sin(angle)
            radial = c * (q[0] + z * q[4]) + s * (q[1] - z * q[3])
            axial = q[2] + arm * (q[3] * s - q[4] * c)
            f, g = ball_force(
                row, distance * np.cos(ALPHA) + radial,
                distance * np.sin(ALPHA) + way * axial + shift, own,
            )  # fmt: skip
            g *= way
            point = np.array([arm * c, arm * s, 0.0])
            turned = np.cross(point, [0.0, 0.0, g]) + np.cross([0, 0, z], [f * c, f * s, 0.0])
            total += [f * c, f * s, g, *turned[:2]]
    return total


@pytest.mark.parametrize(
    ("bearings", "load", "rpm"),
    [
        (DB, RingLoad(load_n=(80.0, 30.0, 20.0), preload_n=250.0, preload="rigid"), 15000.0),
        (DF, RingLoad(load_n=(40.0, 0.0, -30.0), preload_n=150.0, preload="rigid"), 24000.0),
        (BearingSet(row=ROW, facing=(-1,)), RingLoad(load_n=(30.0, 0, 0), preload_n=200.0), 2e4),
    ],
)
def test_equilibrium_and_stiffness_by_the_equations_of_each_ball(bearings, load, rpm):
    found = ring_states(bearings, load, np.array([rpm * RPM]), REST)
    own, q = ROW.centrifugal_n(rpm * RPM), found.motion[0]
    shifts = [q[5 if way > 0 else 6] for way in bearings.facing]
    force = set_force(bearings, q[:5], shifts, own)
    wanted = np.array(load.load_n)
    if not bearings.is_opposed:
        wanted[2] += bearings.facing[0] * load.preload_n
    np.testing.assert_allclose(force[:3], wanted, atol=1e-6 * 250.0)
    step = np.array([1e-8, 1e-8, 1e-8, 4e-7, 4e-7])  # of the central difference, relative 1e-6
    numeric = np.array(
        [
            (
                set_force(bearings, q[:5] + h * e, shifts, own)
                - set_force(bearings, q[:5] - h * e, shifts, own)
            )
            / (2 * h)
            for h, e in zip(step, np.eye(5), strict=True)
        ]
    ).T
    root = np.sqrt(np.diag(found.stiffness[0]))
    assert (np.abs(numeric - found.stiffness[0]) / np.outer(root, root)).max() < 1e-5


def test_pair_at_rest_by_hand_from_one_bearing():
    """Rows side by side: springs add, at their places; face to face the other way round."""
    states = loaded_ring(ROW, (0.0, 0.0, 250.0))
    one, angle = states.stiffness[0], states.found.inner_angle_rad[0, 0]
    k, axial, tilt, cross = one[0, 0], one[2, 2], one[4, 4], one[0, 4]
    for pair, sign in ((DB, -1.0), (DF, 1.0)):
        found = mean(pair, RIGID)
        # u of a row at z: u + z ry; its own coupling turns with the way that it faces
        wanted = 2.0 * tilt + 0.5 * STEP**2 * k + sign * 2.0 * STEP * cross
        np.testing.assert_allclose(
            np.diag(found), [2 * k, 2 * k, 2 * axial, wanted, wanted], rtol=1e-8
        )
        assert found[0, 4] == found[1, 3] == 0.0
    # lines of contact meet the axis at these places, where a row is a spring across
    reach = 0.5 * ROW.pitch_diameter_m * np.tan(angle)
    rough = 2.0 * k * (0.5 * STEP + reach) ** 2
    assert mean(DB, RIGID)[4, 4] == pytest.approx(rough, rel=0.12)
    assert mean(DB, RIGID)[4, 4] > 5.0 * mean(DF, RIGID)[4, 4]


def test_springs_keep_the_force_and_rigid_rings_gain_it():
    springs = RingLoad(load_n=(0.0, 0.0, 0.0), preload_n=250.0)
    one = loaded_ring(ROW, (0.0, 0.0, 250.0)).stiffness[0]
    assert mean(DB, springs)[2, 2] == pytest.approx(one[2, 2], rel=1e-8)  # one row is located
    assert mean(DB, springs, floats=True)[2, 2] == 0.0
    fast = [mean(DB, load, 20000.0) for load in (springs, RIGID)]
    assert fast[0][0, 0] < 0.7 * mean(DB, springs)[0, 0] < fast[1][0, 0]
    states = ring_states(DB, RIGID, np.array([20000.0 * RPM]), REST)
    carried = states.found.inner_load_n * np.sin(states.found.inner_angle_rad)
    assert carried[0, : ROW.ball_count].sum() > 1.1 * 250.0


def test_tandem_shares_the_load():
    pair = BearingSet(row=ROW, facing=(1, 1), places_m=(-STEP / 2, STEP / 2))
    load = RingLoad(load_n=(0.0, 0.0, 0.0), preload_n=500.0)
    one = loaded_ring(ROW, (0.0, 0.0, 250.0)).stiffness[0]
    np.testing.assert_allclose(mean(pair, load)[:3, :3], 2.0 * one[:3, :3], rtol=1e-8, atol=1.0)


def test_a_printed_bearing():
    """218 under a thrust of 17 800 N: Harris and Kotzalas (2006), Essential Concepts, chapter 7.

    The contact angle is 41.6 degrees, with a constant of the contact read off a figure.
    """
    row = BallBearing(
        ball_count=16,
        ball_diameter_m=22.23e-3,
        pitch_diameter_m=125.3e-3,
        inner_groove=0.5232,
        outer_groove=0.5232,
        contact_angle_rad=np.radians(40.0),
    )
    found = loaded_ring(row, (0.0, 0.0, 17800.0))
    assert np.degrees(found.found.inner_angle_rad[0, 0]) == pytest.approx(41.6, abs=0.15)


GROOVE = BallBearing(
    ball_count=8, ball_diameter_m=12e-3, pitch_diameter_m=46e-3, radial_clearance_m=15e-6
)
# What couples axial motion with others.
ALONG = np.array([[(i == 2) != (j == 2) for j in range(5)] for i in range(5)])
ROLLERS = RollerBearing(
    roller_count=14, roller_diameter_m=10e-3, effective_length_m=10e-3, pitch_diameter_m=65e-3,
    radial_clearance_m=20e-6,
)  # fmt: skip


@pytest.mark.parametrize(
    ("row", "load", "rpm"),
    [
        (GROOVE, (0.0, -500.0, 0.0), 30000.0),
        (GROOVE, (300.0, 400.0, 0.0), 0.0),
        (ROLLERS, (0.0, -3000.0, 0.0), 15000.0),
        (ROW, (400.0, 0.0, 300.0), 18000.0),
    ],
)
def test_mean_and_range_over_many_positions(row, load, rpm):
    """By 600 positions, whose mean misses by their distance to the power 3/2 (10/9 of rollers)."""
    bearings, speed, count = BearingSet(row=row), rpm * RPM, 600
    found = mean_stiffness(bearings, RingLoad(load_n=load), np.array([speed]))
    places = 2 * np.pi / row.element_count * (np.arange(count) + 0.5) / count
    every = ring_states(bearings, RingLoad(load_n=load), np.full(count, speed), places).stiffness
    own, wanted = np.diagonal(every, axis1=1, axis2=2), every.mean(axis=0)
    size = np.sqrt(np.outer(np.diag(wanted), np.diag(wanted)))
    assert (np.abs(found.mean[0] - wanted) <= 1e-3 * size + 1e-9).all()
    np.testing.assert_allclose(found.least[0], own.min(axis=0), rtol=0.02, atol=1e-6)
    np.testing.assert_allclose(found.most[0], own.max(axis=0), rtol=0.02, atol=1e-6)


def test_table_follows_balls_that_lose_contact():
    load, highest = RingLoad(load_n=(0.0, -500.0, 0.0)), 30000.0 * RPM
    table = ring_table(BearingSet(row=GROOVE), load, highest)
    assert table.speeds_rad_s.size < 100
    law, zero = RingLaw(name="l", speeds_rad_s=table[0], stiffness=table[1]), np.zeros((2, 2))
    speeds = np.random.default_rng(2).uniform(0.0, highest, 3)
    exact = mean_stiffness(BearingSet(row=GROOVE), load, speeds).mean
    for speed, wanted in zip(speeds.tolist(), exact, strict=True):
        found = law.coefficients(speed, zero, zero).stiffness_n_per_m
        root = np.sqrt(np.diag(wanted))
        wanted = np.where(ALONG, 0.0, wanted)  # left out of the law
        assert (np.abs(found - wanted) / np.outer(root, root)).max() < 1e-4
