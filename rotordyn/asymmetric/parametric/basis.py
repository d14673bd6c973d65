"""Motions to which a periodic system is held while its unstable ranges are searched."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.asymmetric.periodic import PeriodicSystem, Term, TurnedLaw
from solidwhirl.rotordyn.core.arrays import FloatArray

#: Amplitude of what the others answer to a mode from which it is taken in.
ANSWER = 3e-3


#: The fastest motion that is followed, by the fastest change of the matrices or the slowest mode.
FAST = 2.0


def held_to(system: PeriodicSystem, basis: FloatArray) -> PeriodicSystem:
    """Return a system in the coordinates p of q = B p, B (n, r)."""

    def terms(every: Sequence[Term]) -> tuple[Term, ...]:
        return tuple(Term(h, p, basis.T @ a @ basis) for h, p, a in every)

    return PeriodicSystem(
        mass=basis.T @ system.mass @ basis,
        velocity=terms(system.velocity),
        stiffness=terms(system.stiffness),
        acceleration=terms(system.acceleration),
        laws=tuple(
            TurnedLaw(
                replace(law.joint, motion=law.joint.motion @ basis),
                {h: part @ basis for h, part in law.motion.items()},
            )
            for law in system.laws
        ),
    )


def fastest_rate(system: PeriodicSystem, speed_rad_s: float) -> float:
    """Return the rate of the fastest motion that is followed at speeds up to one, 1/s."""
    squared, _ = _at_rest(system)
    return FAST * max(system.stride * speed_rad_s, float(np.sqrt(np.abs(squared).min())))


def highest_rate(system: PeriodicSystem) -> float:
    """Return a rate that no motion at rest is faster than, 1/s."""
    squared, _ = _at_rest(system)
    return 1.01 * float(np.sqrt(np.abs(squared).max()))


def _at_rest(system: PeriodicSystem) -> tuple[FloatArray, FloatArray]:
    """ω² and modes at rest, without damping and circulatory forces."""
    squared, modes = la.eigh(system.stiffness_at_rest(), system.mass)
    return np.asarray(squared), np.asarray(modes)


def search_basis(
    system: PeriodicSystem, fastest_1_s: float, speed_rad_s: float, answer: float = ANSWER
) -> FloatArray:
    """Return motions B (n, r) with Bᵀ M B = 1.

    Modes at rest up to the rate `fastest_1_s`, and what all others answer, as springs alone, to the
    forces that the modes meet at the speed by all other terms of the matrices, with amplitudes from
    `answer` on.
    """
    lower = la.cholesky(system.mass, lower=True)
    velocity, stiffness = system.at(speed_rad_s)
    squared, modes = _at_rest(system)
    slow = np.abs(squared) <= fastest_1_s**2
    kept, others = modes[:, slow], modes[:, ~slow]
    if not others.size:
        return np.asarray(modes)
    stiffness[0] = stiffness.get(0, 0.0) - system.stiffness_at_rest()
    parts = [*stiffness.values(), *(fastest_1_s * part for part in velocity.values())]
    met = [side @ kept for part in parts for side in (part.real, part.imag)]
    answers = (others / squared[~slow]) @ (others.T @ np.hstack(met))
    directions, size, _ = la.svd(lower.T @ answers, full_matrices=False)
    added = la.solve_triangular(lower, directions[:, size > answer], lower=True, trans="T")
    return np.hstack((kept, added))
