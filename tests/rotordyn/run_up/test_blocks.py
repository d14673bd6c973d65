"""Parts and strides of a run-up against plain steps of the whole, one by one."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import scipy.linalg as la
from rotors import connect, polynomial_law, rigid_body, turning

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.assembly.coordinates import interface_row
from solidwhirl.rotordyn.modes.uncoupled import uncoupled_groups
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up.integration import run_up
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile

LAW = polynomial_law((1.0, -2e-3, 1e-5), (0.5, 1e-3), (1.0, -1e-3), top=300.0)
H = 1e-4


def two_shafts(between=None):
    """Rotors on their own bearings, with a bearing between them if it has a stiffness."""
    first = rigid_body("a", 12.0, 0.18, [0.5, 0.5, 0.7], {"l": 0.0, "m": 0.2, "r": 0.5})
    second = rigid_body("b", 6.0, 0.3, [0.2, 0.2, 0.25], {"m": 0.2, "r": 0.45})
    bearings = [
        connect("left", "a.l", None, (5e5, 3e5), 400.0, speed_law=LAW),
        connect("right", "a.r", None, 6e5, 400.0),
        connect("front", "b.m", None, 8e5, 400.0),
        connect("outer", "b.r", None, (4e5, 5e5), 400.0),
    ]
    bearings += [connect("inter", "b.m", "a.m", between)] if between else []
    return rd.assemble({"a": turning(first), "b": turning(second, -1.4)}, tuple(bearings))


def test_parts_are_what_no_joint_couples():
    def motions(system):
        """Bodies and components of each part."""
        found = []
        for at in uncoupled_groups(system):
            rows = np.flatnonzero(np.abs(system.transformation[:, at]).max(axis=1))
            bodies = {
                n for n, s in system.body_slices.items() for r in rows if s.start <= r < s.stop
            }
            found.append(("".join(sorted(bodies)), at.size))
        return sorted(found)

    apart, joined = motions(two_shafts()), motions(two_shafts(7e5))
    assert [size for body, size in apart if body == "a"][-1] == 4
    assert {body for body, _ in apart} == {"a", "b"}
    assert ("ab", 8) in joined and sum(size for _, size in joined) == sum(s for _, s in apart)


@pytest.mark.parametrize("between", [None, 7e5])
def test_strides_of_parts_are_plain_steps_of_the_whole(between):
    system = two_shafts(between)
    unbalances = (
        Unbalance(body="a", interface="m", moment_kg_m=2e-4, phase_rad=0.4),
        Unbalance(body="b", interface="r", moment_kg_m=1e-4, phase_rad=2.0),
    )
    profile = SpeedProfile(times_s=[0.0, 0.03, 0.05], speeds_rad_s=[160.0, 250.0, 250.0])
    ends = [rd.End(body="a", interface="l"), rd.End(body="b", interface="r")]
    run = run_up(
        system, profile, unbalances, step_s=H, record_every=10, outputs=ends, phase_error_rad=3e-3
    )
    # blocks of one stride from record to record
    assert run.longest_block == 10
    plain = stepped(system, profile, unbalances, run.longest_block)
    for k, end in enumerate(ends):
        for found, half in ((run.translation_m, plain[0]), (run.velocity_m_per_s, plain[1])):
            expected = half @ interface_row(system, end.body, end.interface, "ux")
            limit = 1e-9 * np.abs(expected).max()
            np.testing.assert_allclose(found[k, 0], expected[::10], atol=limit)


def stepped(system, profile, unbalances, block):
    """q and q' at all steps, (s, n) each, in physical coordinates, no mode in sight.

    An exponential of the whole for every block, and of the load the Hermite cubic by the solution
    of its Taylor terms, in one augmented matrix.
    """
    n, inverse = system.size, la.inv(system.mass)
    steps = round(profile.duration_s / H)
    state, states = np.zeros(2 * n), [np.zeros(2 * n)]
    for begin, end in pairwise(np.rint(profile.times_s / H).astype(int)):
        slope = (profile.speed_rad_s(H * end) - profile.speed_rad_s(H * begin)) / (
            H * (end - begin)
        )
        size = block if slope else steps
        for first in range(begin, end, size):
            last = min(first + size, end)
            middle = float(profile.speed_rad_s(0.5 * H * (first + last)))
            matrices = rd.matrices_at_speed(system, middle)
            stiffness = matrices.stiffness + 0.5 * slope * system.gyroscopic
            velocity = matrices.damping + matrices.gyroscopic
            motion = np.block(
                [[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ velocity]]
            )
            for step in range(first, last):
                powers = cubic(*load(system, profile, unbalances, slope, begin, step))
                whole = np.zeros((2 * n + 4, 2 * n + 4))
                whole[: 2 * n, : 2 * n] = motion
                whole[n : 2 * n, 2 * n :] = inverse @ powers.T
                # t, t² / 2 and t³ / 6 of a chain of integrators
                whole[[2 * n, 2 * n + 1, 2 * n + 2], [2 * n + 1, 2 * n + 2, 2 * n + 3]] = 1.0
                start = np.concatenate((state, [0.0, 0.0, 0.0, 1.0]))
                state = (la.expm(H * whole) @ start)[: 2 * n]
                states.append(state)
    found = np.array(states)
    return found[:, :n], found[:, n:]


def load(system, profile, unbalances, slope, begin, step):
    """Forces at both ends of a step and their rates, (n,) each."""
    ends = []
    for k in (step, step + 1):
        since = H * (k - begin)
        speed = float(profile.speed_rad_s(H * begin)) + slope * since
        angle = float(profile.angle_rad(H * begin)) + 0.5 * since * (
            speed + float(profile.speed_rad_s(H * begin))
        )
        force, rate = np.zeros((2, system.size))
        for u in unbalances:
            ratio = system.system.rotors[u.body].speed_ratio
            omega, change = ratio * speed, ratio * slope
            turn = u.moment_kg_m * np.exp(1j * (ratio * angle + u.phase_rad))
            pull = (omega**2 - 1j * change) * turn
            grows = (2.0 * omega * change + 1j * omega * (omega**2 - 1j * change)) * turn
            for component, part in (("ux", np.real), ("uy", np.imag)):
                row = interface_row(system, u.body, u.interface, component)
                force, rate = force + part(pull) * row, rate + part(grows) * row
        ends.append((force, rate))
    (first, rising), (second, falling) = ends
    return first, second, rising, falling


def cubic(first, second, rising, falling):
    """Derivatives at its start of the cubic with these ends, highest first, (4, n)."""
    change = second - first
    square = (3.0 * change / H - 2.0 * rising - falling) / H
    cube = (rising + falling - 2.0 * change / H) / H**2
    return np.array([6.0 * cube, 2.0 * square, rising, first])
