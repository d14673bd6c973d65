"""A system with a few nonlinear joints under unbalance and weight, condensed to these joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.coordinates import seat_motion
from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.assembly.system import (
    AssembledSystem,
    at_whirl_ratio,
    gravity_load,
    matrices_at_speed,
    speed_derivative,
)
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modes.free_motions import null_motions
from solidwhirl.rotordyn.nonlinear.forces import NonlinearForce
from solidwhirl.rotordyn.response.harmonic_response import check_lateral
from solidwhirl.rotordyn.response.unbalance import Unbalance, frequency_ratio, unbalance_loads

# Unbalances turn together if their frequency ratios differ by less than this fraction.
_SAME_RATIO = 1e-12
# Part of the weight that may act on motions that nothing holds, for rounding.
_DRIVEN = 1e-6


@dataclass(frozen=True, kw_only=True)
class NonlinearJoint:
    """A nonlinear force between two interfaces, beside the bearings of the system.

    `first`, `second`: with ux and uy; None is the ground. `force`: of their relative motion.
    """

    first: End
    second: End | None = None
    force: NonlinearForce


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class ForcedSystem:
    """Hold what is balanced: M q'' + (C + Ω G) q' + K q + Σ Bᵀ f(B q, B q') = loads.

    `assembled`: the linear part, n coordinates; `forces`: j of them; `motion`: B, x and y of each
    joint per coordinate, shape (2j, n); `frequency_ratio`: ω over Ω of the first harmonic;
    `turning_kg_m`: load of the unbalance over its frequency squared, shape (n,); `steady_n`:
    weight, shape (n,). `shift_n_per_m`: a stiffness that is added at the joints and taken from
    their forces again, so that parts that the joints alone hold can be condensed.
    `free`: motions of unit modal mass that neither bearings nor joints hold, such as a torsion,
    shape (n, f); nothing drives them, and their constant part is 0.
    `period_multiple`: turns of the unbalance after which motions repeat: its load is that harmonic.
    """

    assembled: AssembledSystem
    forces: tuple[NonlinearForce, ...]
    motion: FloatArray
    frequency_ratio: float
    turning_kg_m: ComplexArray
    steady_n: FloatArray
    shift_n_per_m: float
    free: FloatArray
    period_multiple: int = 1

    def repeating_after(self, turns: int) -> ForcedSystem:
        """Return the system for motions that repeat after so many turns of the unbalance."""
        ratio = self.frequency_ratio * self.period_multiple / turns
        return replace(self, frequency_ratio=ratio, period_multiple=turns)

    @property
    def width(self) -> int:
        """Relative motions at the joints, 2j."""
        return len(self.motion)

    def shifts(self, harmonics: int) -> ComplexArray:
        """Return what is added at the joints for harmonics 0 to h, N/m, shape (h + 1,).

        A complex one damps what the joints see of a resonance; the constant part is real.
        """
        turning = np.where(np.arange(harmonics + 1) > 0, 1.0 + 1.0j, 1.0 + 0.0j)
        return np.asarray(turning * self.shift_n_per_m, dtype=complex)


class Condensed(NamedTuple):
    """Motions of m rows per force at the joints, harmonic by harmonic from 0 to h.

    `free_m`: with the shift and no other force at the joints, shape (h + 1, m); `receptance`: per
    force at the joints, (h + 1, m, 2j); `free_slope`, `receptance_slope`: by Ω.
    """

    free_m: ComplexArray
    receptance: ComplexArray
    free_slope: ComplexArray
    receptance_slope: ComplexArray


def forced_system(
    assembled: AssembledSystem,
    joints: Sequence[NonlinearJoint],
    unbalances: Sequence[Unbalance],
    speed_rad_s: float,
    gravity_m_per_s2: npt.ArrayLike = (0.0, 0.0, 0.0),
) -> ForcedSystem:
    """Return a system with nonlinear joints under unbalance and weight.

    `joints`: one or more; `unbalances`: one or more that turn at one frequency; `speed_rad_s`: a
    speed amid those looked at, above 0. Raises AnalysisError if there are none, unbalances turn at
    several frequencies, or a place has no ux and uy.
    """
    if not joints:
        raise AnalysisError("joints is empty; one or more are needed")
    if not unbalances:
        raise AnalysisError("unbalances is empty; one or more are needed")
    ratios = [frequency_ratio(assembled, u) for u in unbalances]
    if np.ptp(ratios) > _SAME_RATIO * max(ratios):
        raise AnalysisError(
            f"unbalances turn at {sorted(set(ratios))} times the speed; they must turn at one "
            "frequency, so that the motion repeats with it"
        )
    motion = np.concatenate([_relative_motion(assembled, joint) for joint in joints])
    weight = assembled.transformation.T @ gravity_load(assembled, gravity_m_per_s2)
    seen = motion @ decaying_response(assembled, motion, ratios[0], speed_rad_s)
    shift = 1.0 / float(la.norm(seen, 2))
    return ForcedSystem(
        assembled=assembled,
        forces=tuple(joint.force for joint in joints),
        motion=motion,
        frequency_ratio=ratios[0],
        turning_kg_m=unbalance_loads(assembled, unbalances),
        steady_n=weight,
        shift_n_per_m=shift,
        free=_free_motions(assembled, shift * motion.T @ motion, speed_rad_s, weight),
    )


def _free_motions(
    assembled: AssembledSystem, held: FloatArray, speed_rad_s: float, weight: FloatArray
) -> FloatArray:
    """Return motions that nothing holds, see `ForcedSystem`; weight must not drive them."""
    matrices = matrices_at_speed(at_whirl_ratio(assembled, 0.0), speed_rad_s)
    free = null_motions(assembled, matrices._replace(stiffness=matrices.stiffness + held))
    driven = np.abs(free.T @ weight).max(initial=0.0)
    if driven > _DRIVEN * np.sqrt(np.abs(weight @ la.solve(matrices.mass, weight))):
        raise AnalysisError("gravity_m_per_s2: a motion that nothing holds would fall under it")
    return free


def decaying_response(
    assembled: AssembledSystem, motion: FloatArray, ratio: float, speed_rad_s: float
) -> ComplexArray:
    """Return motions per force at the joints that grows at the rate at which it turns, (n, 2j).

    Free and undamped motions have such a response too.
    """
    mass, damping, gyroscopic, stiffness = matrices_at_speed(assembled, speed_rad_s)
    rate = ratio * speed_rad_s * np.exp(0.25j * np.pi)
    whole = rate**2 * mass + rate * (damping + gyroscopic) + stiffness
    return np.asarray(la.solve(whole, motion.T))


def _relative_motion(assembled: AssembledSystem, joint: NonlinearJoint) -> FloatArray:
    """Ux and uy of the first side relative to the second, shape (2, n)."""
    motion = np.zeros((2, assembled.size))
    for end, sign in ((joint.first, 1.0), (joint.second, -1.0)):
        if end is not None:
            check_lateral(assembled, end, f"nonlinear force at {end.label}")
            motion += sign * seat_motion(assembled, end)[:2]
    return motion


def condensed(
    forced: ForcedSystem, speed_rad_s: float, harmonics: int, rows: FloatArray
) -> Condensed:
    """Condense a system at a speed exactly, by its dynamic stiffness at each harmonic.

    `harmonics`: h; `rows`: motions that are wanted per coordinate, shape (m, n).
    """
    ratio, omega = forced.frequency_ratio, forced.frequency_ratio * speed_rad_s
    # bearings that depend on the frequency have that of each harmonic
    distinct = range(harmonics + 1) if forced.assembled.depends_on_frequency else range(1)
    systems = [at_whirl_ratio(forced.assembled, k * ratio) for k in distinct]
    here = [matrices_at_speed(system, speed_rad_s) for system in systems]
    slopes = [speed_derivative(system, speed_rad_s) for system in systems]
    mass, stiffness = np.array([m.mass for m in here]), np.array([m.stiffness for m in here])
    velocity = np.array([m.damping + m.gyroscopic for m in here])
    rate = omega * np.arange(harmonics + 1)[:, None, None]
    held = forced.shifts(harmonics)[:, None, None] * (forced.motion.T @ forced.motion)
    if forced.free.size:
        pushed = mass[0] @ forced.free
        held[0] += omega**2 * pushed @ pushed.T
    loads = np.zeros((harmonics + 1, forced.assembled.size, 2), dtype=complex)  # and by the speed
    loads[0, :, 0] = forced.steady_n
    turns = forced.period_multiple
    rise = np.array([omega**2, 2.0 * ratio * omega]) * turns**2
    loads[turns : turns + 1] += forced.turning_kg_m[:, None] * rise
    whole = stiffness - rate**2 * mass + held + 1j * rate * velocity
    pulled = np.broadcast_to(forced.motion.T, (harmonics + 1, *forced.motion.T.shape))
    right = np.concatenate((pulled, loads[..., :1]), axis=2)
    moved: ComplexArray = np.linalg.solve(whole, right)
    left: ComplexArray = np.linalg.solve(whole.transpose(0, 2, 1), rows.T[None])
    left = left.transpose(0, 2, 1)
    slope: ComplexArray = np.array([s.stiffness for s in slopes]) @ moved
    slope = slope + 1j * rate * (np.array([s.velocity for s in slopes]) @ moved)
    slope = slope + rate / speed_rad_s * (1j * velocity @ moved - 2.0 * rate * (mass @ moved))
    slope[..., -1:] -= loads[..., 1:]
    seen, change = rows @ moved, -left @ slope
    return Condensed(seen[..., -1], seen[..., :-1], change[..., -1], change[..., :-1])
