"""Stability of periodic motions: Floquet multipliers of small motions beside them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.core.magnus import GAUSS, magnus_exponent
from solidwhirl.rotordyn.modes.modal_truncation import project_system, rest_modes
from solidwhirl.rotordyn.nonlinear.forced_system import ForcedSystem, decaying_response
from solidwhirl.rotordyn.nonlinear.harmonic_balance import joint_samples, series_at

# Modes at rest that small motions are made of: at least, at most, and up to so many times ω.
_FEWEST, _MOST, _TIMES = 8, 16, 6.0
# Columns shorter than this beside the others are dropped.
_DEPENDENT = 1e-7
# Steps of a turn, a power of 2, and parts of one in which forces are sampled. The error falls with
# the fourth power of the steps; where a gap opens or closes, with that of the parts. A step's
# exponential is that of its 2^s-th part, squared s times, so that what dies out within it is gone.
_STEPS, _PARTS, _SQUARED = 128, 4, 3
# A motion grows if a multiplier is above 1 by more than this; less is rounding.
GROWS = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class SmallMotions:
    """Hold what small motions beside a periodic one are made of.

    `system`: projected on m shapes; `motion`: relative motion at the joints per shape, (2j, m);
    `forced`: whole system; `shapes`: of its n coordinates, (n, m).
    """

    system: AssembledSystem
    motion: FloatArray
    forced: ForcedSystem
    shapes: FloatArray


def small_motions(forced: ForcedSystem, top_rad_s: float) -> SmallMotions:
    """Choose shapes of small motions: low modes at rest, and what forces at the joints do.

    `top_rad_s`: highest speed looked at. A small system is taken whole.
    """
    system = forced.assembled
    if system.size <= _MOST:
        whole = np.eye(system.size)
        return SmallMotions(system=system, motion=forced.motion, forced=forced, shapes=whole)
    squared, shapes = rest_modes(system)
    omega = forced.frequency_ratio * top_rad_s
    low = int(np.count_nonzero(squared <= (_TIMES * omega) ** 2))
    kept = shapes[:, : min(max(low, _FEWEST), _MOST)]
    added = decaying_response(system, forced.motion, forced.frequency_ratio, top_rad_s)
    columns = np.hstack((added.real, added.imag))
    for _ in range(2):  # the second time what rounding has left
        columns = columns - kept @ (kept.T @ (system.mass @ columns))
        columns = columns / np.sqrt(np.einsum("ij,ij->j", columns, system.mass @ columns))
    size, turn = la.eigh(columns.T @ system.mass @ columns)
    found = size > _DEPENDENT * size[-1]
    basis = np.hstack((kept, columns @ (turn[:, found] / np.sqrt(size[found]))))
    return SmallMotions(
        system=project_system(system, basis),
        motion=forced.motion @ basis,
        forced=forced,
        shapes=basis,
    )


def multipliers(
    small: SmallMotions, motion_m: FloatArray, speed_rad_s: float, steps: int | None = None
) -> ComplexArray:
    """Return the Floquet multipliers of a periodic motion, the largest first, shape (2m,).

    `motion_m`: coefficients at the joints, shape (2h + 1, 2j); `steps`: of the period, a power of
    2; by default 128 per turn of the unbalance or some more, 64 of one harmonic. Each step of
    the period is a Magnus integrator of fourth order with a Padé approximant of its exponential,
    which keeps undamped motions at 1 (Iserles et al. 2000, Acta Numerica 9).
    """
    omega = small.forced.frequency_ratio * speed_rad_s
    least = _STEPS if len(motion_m) > 3 else _STEPS // 2
    steps = steps or least << (small.forced.period_multiple - 1).bit_length()
    states = _state_matrices(small, motion_m, speed_rad_s, steps)
    length = 2.0 * np.pi / (steps * omega)
    whole = magnus_exponent(length * states[0::2], length * states[1::2]) / 2.0**_SQUARED
    even = np.eye(whole.shape[1]) + whole @ whole / 12.0
    each = np.linalg.solve(even - 0.5 * whole, even + 0.5 * whole)
    for _ in range(_SQUARED):
        each = each @ each
    while len(each) > 1:
        each = each[1::2] @ each[0::2]
    found = np.linalg.eigvals(each[0])
    return np.asarray(found[np.argsort(-np.abs(found))], dtype=complex)


def _state_matrices(
    small: SmallMotions, motion_m: FloatArray, speed_rad_s: float, steps: int
) -> FloatArray:
    """State matrices of small motions (σ a, a') at two Gauss points of each step, (2s, 2m, 2m)."""
    omega = small.forced.frequency_ratio * speed_rad_s
    mass, damping, gyroscopic, stiffness = matrices_at_speed(small.system, speed_rad_s)
    inside = np.add.outer(np.arange(_PARTS), GAUSS).ravel() / _PARTS
    at = np.add.outer(np.arange(steps), inside).ravel()
    values, slopes = series_at(2.0 * np.pi * at / steps, len(motion_m) // 2)
    found = joint_samples(small.forced, values @ motion_m, omega * (slopes @ motion_m))
    pushed = la.solve(mass, small.motion.T, assume_a="pos")
    m = small.system.size
    # two samples of a step with its mean and first moment: a kink within it counts in full
    share = 1.0 + np.outer([-1.0, 1.0], 12.0 / np.sqrt(12.0) * (inside - 0.5))
    share /= inside.size
    states = np.zeros((2 * steps, 2 * m, 2 * m))
    states[:, :m, m:] = omega * np.eye(m)
    states[:, m:, :m] = -la.solve(mass, stiffness, assume_a="pos") / omega
    states[:, m:, m:] = -la.solve(mass, damping + gyroscopic, assume_a="pos")
    for k, joint in enumerate(found):
        rows = slice(2 * k, 2 * k + 2)
        seen = small.motion[rows]
        held, damped = (
            np.einsum("gi,sijk->sgjk", share, part.reshape(steps, -1, 2, 2)).reshape(-1, 2, 2)
            for part in (joint.stiffness_n_per_m, joint.damping_n_s_per_m)
        )
        states[:, m:, :m] -= pushed[:, rows] @ held @ seen / omega
        states[:, m:, m:] -= pushed[:, rows] @ damped @ seen
    return states
