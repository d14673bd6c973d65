"""A body on a support at rest, integrated in the frame that turns with the body.

M q'' + (2Ω C + c) q' + (K + Ω² K2 + Ω' C + k) q = f with the support's k and c turned back by the
angle of the body, so that they change with the time where a direction of the support differs.
`turning` is (M, C, K, K2) at unit speed, `port` (6, n) the motion ux uy uz rx ry rz of the place on
the support, and `hold` its stiffness and damping (2, 2) of translation, then of tilt.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg as la
from scipy.integrate import solve_ivp

TIGHT = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-12}
CROSS = np.array([[0.0, -1.0], [1.0, 0.0]])


def floquet_multipliers(turning, port, speed, hold):
    """Eigenvalues of the change of the state over one turn of the body."""
    inverse, n = la.inv(turning[0]), len(turning[0])

    def rate(time, state):
        k, c = _at(turning, port, hold, speed * time, speed)
        q, velocity = state.reshape(2, n, 2 * n)
        return np.concatenate((velocity, -inverse @ (c @ velocity + k @ q))).ravel()

    end = 2.0 * np.pi / abs(speed)
    found = solve_ivp(rate, (0.0, end), np.eye(2 * n).ravel(), **TIGHT)
    return la.eigvals(found.y[:, -1].reshape(2 * n, 2 * n))


def unbalance_run_up(turning, port, hold, moment, profile, times, *, euler=True):
    """Motion x + iy at rest of the place on the support, with an unbalance along x of the body.

    `moment` [kg m]; `profile`: speed at time 0 and its rate. `euler`: False leaves Ω' C out.
    """
    inverse, n = la.inv(turning[0]), len(turning[0])
    start, rise = profile

    def rate(time, state):
        speed, angle = start + rise * time, start * time + 0.5 * rise * time**2
        k, c = _at(turning, port, hold, angle, speed)
        k += rise * turning[1] if euler else 0.0
        force = moment * (speed**2 * port[0] - rise * port[1])
        q, velocity = state.reshape(2, n)
        return np.concatenate((velocity, inverse @ (force - c @ velocity - k @ q)))

    found = solve_ivp(rate, (0.0, times[-1]), np.zeros(2 * n), t_eval=times, **TIGHT).y[:n]
    angle = start * times + 0.5 * rise * times**2
    return (port[0] + 1j * port[1]) @ found * np.exp(1j * angle)


def _at(turning, port, hold, angle, speed):
    """Stiffness and damping at one angle and speed of the body."""
    _, coriolis, stiffness, change = turning
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    k, c = stiffness + speed**2 * change, 2.0 * speed * coriolis
    for at, (spring, drag) in zip((0, 3), (hold[:2], hold[2:]), strict=True):
        part = port[at : at + 2]
        own = turn.T @ drag @ turn
        c = c + part.T @ own @ part
        k = k + part.T @ (turn.T @ spring @ turn + speed * own @ CROSS) @ part
    return k, c
