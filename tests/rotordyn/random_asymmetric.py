"""Random asymmetric bodies on random joints, and their growth at many speeds.

`growth_at` shares nothing with the search but the matrices: classical Runge-Kutta steps through one
turn at every speed.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.asymmetric import Joint, turning_body
from solidwhirl.rotordyn.asymmetric.periodic import at_speed

SPIN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])  # e_z ×
# Part of a radian of the fastest motion that a step may be: growth is right to 1e-6 of the speed.
FINE = 0.03


def random_system(seed):
    """2 to 4 interface motions and 0 to 3 modes; every third is undamped, some are cross-coupled.

    Frequencies are of the order of 1 to 4.
    """
    pick = np.random.default_rng(seed)
    motions, modes = int(pick.choice([2, 4])), int(pick.integers(0, 4))
    places, masses = pick.uniform(-1.0, 1.0, (12, 3)), pick.uniform(0.5, 1.5, 12) / 12.0
    rigid = np.zeros((6, motions + modes))
    rigid[:, :motions] = np.eye(6)[:, [0, 1, 3, 4][:motions]]
    shapes = [
        np.hstack((np.eye(3), -np.cross(np.eye(3), place).T)) @ rigid
        + np.hstack((np.zeros((3, motions)), pick.normal(0.0, 0.5, (3, modes))))
        for place in places
    ]
    mass, coriolis, softening = (
        sum(m * j.T @ s @ j for m, j in zip(masses, shapes, strict=True))
        for s in (np.eye(3), SPIN, -SPIN @ SPIN)
    )
    turn = la.qr(pick.normal(size=(modes, modes)))[0] if modes else np.zeros((0, 0))
    own = la.block_diag(
        np.diag(pick.uniform(0.0, 2.0, motions) * (motions == 2)),
        turn @ np.diag(pick.uniform(0.5, 8.0, modes)) @ turn.T,
    )
    # what tilts or bends is stretched as well
    stress = 1.5 * softening * np.outer(*[np.arange(len(mass)) > 1] * 2)
    matrices = {
        "mass": mass + 0.05 * np.eye(len(mass)),
        "gyroscopic": 2.0 * coriolis,
        "stiffness": own,
        "centrifugal_stiffness": stress - softening,
    }
    joints = [_random_joint(pick, rigid, motions, damped=seed % 3 != 0) for _ in range(2)]
    return turning_body(matrices, joints)


def _random_joint(pick, rigid, motions, damped):
    spring, drag = np.zeros((2, 6, 6))
    for at, size in ((0, 1.0), (3, 0.4))[: motions // 2]:
        angle = pick.uniform(0.0, np.pi)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        plane = slice(at, at + 2)
        spring[plane, plane] = size * turn @ np.diag(pick.uniform(0.5, 3.0, 2)) @ turn.T
        if damped:
            drag[plane, plane] = size * turn @ np.diag(pick.uniform(0.0, 0.15, 2)) @ turn.T
            spring[plane, plane] += size * pick.uniform(-0.15, 0.15) * SPIN[:2, :2]
    arm = np.eye(6)
    arm[0, 4], arm[1, 3] = pick.normal(0.0, 0.5) * np.array([1.0, -1.0])
    return Joint(arm @ rigid, spring, drag)


def growth_at(system, speeds):
    """Largest ln|μ| / T at speeds (k,)."""
    speeds = np.asarray(speeds, dtype=float)
    inverse, size = la.inv(system.mass), system.size
    found = [[at_speed(t, v) for v in speeds] for t in (system.velocity, system.stiffness)]
    velocity, stiffness = (
        {h: np.array([inverse @ part[h] for part in parts]) for h in parts[0]} for parts in found
    )
    bound = max(np.abs(stiffness[0]).sum(axis=2).max() ** 0.5, 1.0)
    steps = int(np.ceil(2.0 * np.pi / max(system.stride, 1) * bound / speeds.min() / FINE))
    step = 2.0 * np.pi / max(system.stride, 1) / steps

    def rates(angle):
        out = np.zeros((speeds.size, 2 * size, 2 * size))
        out[:, :size, size:] = np.eye(size)
        for at, parts in ((0, stiffness), (size, velocity)):
            for h, part in parts.items():
                out[:, size:, at : at + size] -= (np.exp(1j * h * angle) * part).real
        return out / speeds[:, None, None]

    state = np.tile(np.eye(2 * size), (speeds.size, 1, 1))
    start = rates(0.0)
    for k in range(steps):
        middle, end = rates((k + 0.5) * step), rates((k + 1) * step)
        a = start @ state
        b = middle @ (state + 0.5 * step * a)
        c = middle @ (state + 0.5 * step * b)
        d = end @ (state + step * c)
        state = state + step / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        start = end
    largest = np.abs(np.linalg.eigvals(state)).max(axis=1)
    return np.log(largest) * speeds * max(system.stride, 1) / (2.0 * np.pi)
