"""Plain step-by-step integration of a run-up, to compare the fast one with."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.coordinates import interface_row
from solidwhirl.rotordyn.assembly.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.response.unbalance import Unbalance
from solidwhirl.rotordyn.run_up.record import MotionState
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile


class PlainRun(NamedTuple):
    """Motion in the independent coordinates at all steps.

    Attributes
    ----------
    time_s
        Shape (s,).
    displacement, velocity, acceleration
        q, q', q'', shape (s, n).
    """

    time_s: FloatArray
    displacement: FloatArray
    velocity: FloatArray
    acceleration: FloatArray


def run_up_newmark(
    assembled: AssembledSystem,
    profile: SpeedProfile,
    unbalances: Sequence[Unbalance],
    step_s: float,
    initial: MotionState,
    steady_load: FloatArray | None = None,
) -> PlainRun:
    """Integrate a run-up by Newmark's average acceleration with new matrices at each step.

    `profile`: Ω(t); `unbalances`: may be empty; `step_s`: the last step ends with or before the
    profile; `steady_load`: constant load in the independent coordinates, shape (n,). The result is
    of second order in the step; natural frequencies are lowered by (ωh)²/12.

    Newmark 1959, J. Eng. Mech. Div. ASCE 85, with β = 1/4, γ = 1/2. One LU factorisation for each
    step: slow, and without anything in common with `run_up` but the matrices.
    """
    count = int(np.floor(profile.duration_s / step_s * (1.0 + 1e-12)))
    times = np.minimum(step_s * np.arange(count + 1), profile.duration_s)
    still = np.zeros(assembled.size) if steady_load is None else steady_load
    forces = still + unbalance_forces(assembled, profile, unbalances, times)
    q, v, a = (np.empty((count + 1, assembled.size)) for _ in range(3))
    q[0], v[0] = initial.displacement, initial.velocity
    velocity, stiffness = _matrices(assembled, profile, times[0])
    a[0] = la.solve(assembled.mass, forces[0] - velocity @ v[0] - stiffness @ q[0])
    for k in range(count):
        velocity, stiffness = _matrices(assembled, profile, times[k + 1])
        place = q[k] + step_s * v[k] + 0.25 * step_s**2 * a[k]
        speed = v[k] + 0.5 * step_s * a[k]
        matrix = assembled.mass + 0.5 * step_s * velocity + 0.25 * step_s**2 * stiffness
        a[k + 1] = la.solve(matrix, forces[k + 1] - velocity @ speed - stiffness @ place)
        q[k + 1] = place + 0.25 * step_s**2 * a[k + 1]
        v[k + 1] = speed + 0.5 * step_s * a[k + 1]
    return PlainRun(times, q, v, a)


def unbalance_forces(
    assembled: AssembledSystem,
    profile: SpeedProfile,
    unbalances: Sequence[Unbalance],
    times_s: FloatArray,
) -> FloatArray:
    """Return u [ω² (cos φ, sin φ) + ω' (sin φ, −cos φ)] of all unbalances over time.

    `unbalances`: may be empty; `times_s`: shape (s,). `profile`: Ω(t); the acceleration at a
    breakpoint is that after it. The result is in the independent coordinates, shape (s, n).
    """
    total = np.zeros((times_s.size, assembled.size))
    for unbalance in unbalances:
        ratio = assembled.system.rotors[unbalance.body].speed_ratio
        angle = ratio * profile.angle_rad(times_s) + unbalance.phase_rad
        square = (ratio * profile.speed_rad_s(times_s)) ** 2
        change = ratio * profile.acceleration_rad_s2(times_s)
        in_x = square * np.cos(angle) + change * np.sin(angle)
        in_y = square * np.sin(angle) - change * np.cos(angle)
        for component, force in (("ux", in_x), ("uy", in_y)):
            row = interface_row(assembled, unbalance.body, unbalance.interface, component)
            total += unbalance.moment_kg_m * np.outer(force, row)
    return total


def _matrices(
    assembled: AssembledSystem, profile: SpeedProfile, time_s: float
) -> tuple[FloatArray, FloatArray]:
    """Return the factors of q' and q at a time."""
    matrices = matrices_at_speed(assembled, float(profile.speed_rad_s(time_s)))
    change = 0.5 * float(profile.acceleration_rad_s2(time_s)) * assembled.gyroscopic
    return matrices.damping + matrices.gyroscopic, matrices.stiffness + change
