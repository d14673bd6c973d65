"""Motions that a system settles to in time, many side by side, as starts for harmonic balance.

Average acceleration (Newmark 1959, Journal of the Engineering Mechanics Division 85), implicit in
the joints alone: it is stable for any step, and steps need only be short beside the harmonics
wanted. What a motion settles to is corrected by harmonic balance, which has the accuracy.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.system import matrices_at_speed
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.nonlinear.forced_system import decaying_response
from solidwhirl.rotordyn.nonlinear.harmonic_balance import fourier_of, joint_samples
from solidwhirl.rotordyn.nonlinear.stability import SmallMotions

# Steps of a turn of the unbalance, and turns after which motions are taken as settled.
_STEPS, _TURNS = 64, 80
_CORRECTIONS, _SETTLED = 8, 1e-6


class _Step(NamedTuple):
    """Matrices of a step of b motions: on (q, q'), (b, m, 2m), and others; its length."""

    held: FloatArray
    compliance: FloatArray
    pushed: FloatArray
    seen: FloatArray
    length_s: FloatArray


def settled(
    small: SmallMotions, speeds_rad_s: FloatArray, size_m: FloatArray, harmonics: int
) -> FloatArray:
    """Return what motions from several starts at several speeds settle to.

    `small`: shapes in which they move; its system's `period_multiple` is after how many turns they
    are taken to repeat; `speeds_rad_s`: Ω of each motion, shape (b,); `size_m`: how far the joints
    are from rest at first, in a direction and at a speed of their own each, shape (b,). Returns
    coefficients of the motion at the joints, shape (b, 2h + 1, 2j), nan where it runs away.
    """
    forced, turns = small.forced, small.forced.period_multiple
    omega = forced.period_multiple * forced.frequency_ratio * speeds_rad_s
    step, start = _step(small, speeds_rad_s, omega), _start(small, speeds_rad_s, size_m, omega)
    turning, steady = small.shapes.T @ forced.turning_kg_m, small.shapes.T @ forced.steady_n
    count, first = _STEPS * turns, _STEPS * turns * max(1, _TURNS // turns)
    recorded = np.empty((count, speeds_rad_s.size, forced.width))
    state = (*start, np.zeros_like(start[0]))
    with np.errstate(all="ignore"):  # what runs away is nan
        for k in range(1, first + count):
            angle = np.exp(2j * np.pi * k / _STEPS)
            load = steady + (omega**2 * angle)[:, None] * turning
            state = _stepped(small, step, state, load.real)
            if k >= first:
                recorded[k - first] = state[0] @ small.motion.T
    back = fourier_of(count, harmonics).coefficients
    return np.asarray(np.einsum("ht,tbj->bhj", back, recorded))


def _step(small: SmallMotions, speeds: FloatArray, omega: FloatArray) -> _Step:
    length = 2.0 * np.pi / (_STEPS * omega)
    held, compliance = [], []
    for speed, h in zip(speeds.tolist(), length.tolist(), strict=True):
        mass, damping, gyroscopic, stiffness = matrices_at_speed(small.system, speed)
        velocity = damping + gyroscopic
        held.append(np.hstack((stiffness, velocity)))
        compliance.append(la.inv(mass + 0.5 * h * velocity + 0.25 * h**2 * stiffness))
    inverse = np.array(compliance)
    pushed = inverse @ small.motion.T
    return _Step(np.array(held), inverse, pushed, small.motion @ pushed, length[:, None])


def _start(
    small: SmallMotions, speeds: FloatArray, size_m: FloatArray, omega: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Place and velocity of each motion, (b, m), its joints away from rest by a size."""
    random = np.random.default_rng(0)
    place, velocity = np.zeros((2, speeds.size, small.system.size))
    for k, (speed, size) in enumerate(zip(speeds.tolist(), size_m.tolist(), strict=True)):
        pulled = decaying_response(
            small.system, small.motion, small.forced.frequency_ratio, speed
        ).real
        away = pulled @ random.standard_normal(small.forced.width)
        reach = float(np.abs(small.motion @ away).max())
        phase = 2.0 * np.pi * random.random()
        away = away * (size / reach if reach else 0.0)
        place[k] = np.cos(phase) * away
        velocity[k] = np.sin(phase) * omega[k] / small.forced.period_multiple * away
    return place, velocity


def _stepped(
    small: SmallMotions,
    step: _Step,
    state: tuple[FloatArray, FloatArray, FloatArray],
    load_n: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return place, velocity and acceleration (b, m) a step later."""
    h, motion = step.length_s, small.motion
    place = state[0] + h * state[1] + 0.25 * h**2 * state[2]
    velocity = state[1] + 0.5 * h * state[2]
    held = step.held @ np.concatenate((place, velocity), axis=1)[..., None]
    free = (step.compliance @ (load_n[..., None] - held))[..., 0]
    from_place, from_velocity, from_free = (part @ motion.T for part in (place, velocity, free))
    pull, scale = state[2] @ motion.T, float(np.nanmax(np.abs(from_free), initial=0.0))
    eye = np.eye(motion.shape[0])
    for _ in range(_CORRECTIONS):
        found = joint_samples(
            small.forced, from_place + 0.25 * h**2 * pull, from_velocity + 0.5 * h * pull
        )
        force = np.concatenate([one.force_n for one in found], axis=1)
        miss = pull - from_free + (step.seen @ force[..., None])[..., 0]
        if not np.nanmax(np.abs(miss), initial=0.0) > _SETTLED * scale:
            break
        slope = np.zeros((len(pull), *eye.shape))
        for k, one in enumerate(found):
            at = slice(2 * k, 2 * k + 2)
            slope[:, at, at] = 0.25 * h[..., None] ** 2 * one.stiffness_n_per_m
            slope[:, at, at] += 0.5 * h[..., None] * one.damping_n_s_per_m
        pull = pull - _solved(eye + step.seen @ slope, miss)
    rate = free - (step.pushed @ force[..., None])[..., 0]
    return place + 0.25 * h**2 * rate, velocity + 0.5 * h * rate, rate


def _solved(matrices: FloatArray, right: FloatArray) -> FloatArray:
    """Solve (b, k, k) x = (b, k); nan where a motion has run away."""
    lost = ~(np.isfinite(matrices).all(axis=(1, 2)) & np.isfinite(right).all(axis=1))
    matrices[lost] = np.eye(matrices.shape[1])
    found = np.linalg.solve(matrices, right[..., None])[..., 0]
    found[lost] = np.nan
    return np.asarray(found)
