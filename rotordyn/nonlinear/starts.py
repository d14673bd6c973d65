"""Motions from which branches are followed: circles, loads raised from none, motions in time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.nonlinear.continuation import Branch, Course, follow, passing
from solidwhirl.rotordyn.nonlinear.forced_system import ForcedSystem, condensed
from solidwhirl.rotordyn.nonlinear.harmonic_balance import (
    Guess,
    Point,
    as_complex,
    as_real,
    at_parameter,
    at_speed,
    gaps,
    over_load,
)
from solidwhirl.rotordyn.nonlinear.in_time import settled
from solidwhirl.rotordyn.nonlinear.stability import SmallMotions

# Speeds at which circles and large linear motions are looked for, with the ends; radii of a circle
# per speed, and how far they reach below and above the one without joints.
_GRID, _RADII, _REACH = 61, 5001, (1e-5, 1e4)
# Every so many of the circles must meet the same in all directions, to rounding.
_SOME, _ISOTROPIC = 250, 1e-9
# Speeds between the ends at which loads are raised, besides those of the largest linear motions;
# harmonics then, the longest step, and points; and up to how many times the loads, as parameter.
_BETWEEN, _HARMONICS, _LONGEST, _POINTS = 6, 3, 0.4, 300
_WHOLE, _HEAVY = float(np.arcsinh(1.0)), float(np.arcsinh(200.0))
# and so many times the motion that damping allows under the whole loads; what is none.
_BOUND, _ALIKE = 1.5, 1e-9
# Speeds at which motions are started in time, how far out beside the known motion, how many each.
_SPEEDS, _SIZES, _EACH = 12, (1.0, 3.0, 10.0), 4
# Motions that differ by less than this part are one; and those from themselves some turns later, of
# motions that repeat after fewer turns.
_SAME, _NONE = 1e-6, 1e-3


def starts_of_one_turn(
    forced: ForcedSystem, ends_rad_s: tuple[float, float]
) -> tuple[list[Guess], list[tuple[float, float]]]:
    """Return motions near some to follow, those at the ends first, and where paths to some stop.

    All circular orbits at many speeds, or else the motions on paths of raised loads at the ends, at
    the speeds of the largest linear motions, and between. A path stops at a speed in rad/s and a
    part of the loads.
    """
    grid = np.linspace(*ends_rad_s, _GRID)
    circles = [circular_orbits(forced, s) for s in (*ends_rad_s, *grid[1:-1].tolist())]
    if None not in circles:
        return [guess for orbits in circles for guess in orbits or ()], []
    size = np.array([_linear(forced, speed)[0] for speed in grid.tolist()])
    peaks = grid[1:-1][(size[1:-1] > size[:-2]) & (size[1:-1] > size[2:])]
    between = np.union1d(np.linspace(*ends_rad_s, _BETWEEN + 2)[1:-1], peaks)
    paths = {speed: raised(forced, speed) for speed in (*ends_rad_s, *between.tolist())}
    stopped = [(speed, share) for speed, (_, share) in paths.items() if share is not None]
    return [guess for guesses, _ in paths.values() for guess in guesses], stopped


def circular_orbits(forced: ForcedSystem, speed_rad_s: float) -> list[Guess] | None:
    """Return next to all circular orbits at a speed; None if motions need not be circles.

    A circle of radius r takes the load |1/H + k(r)| r, H the receptance and k(r) the stiffness of
    the joint, if all is the same in all directions and there is one joint alone: as a function of
    r it has every orbit at the load of the unbalance.
    """
    if forced.width != 2:
        return None
    part = condensed(forced, speed_rad_s, 1, forced.motion)
    free = part.free_m[1]
    sense = 1.0 if (free[1] * np.conj(free[0])).imag <= 0.0 else -1.0
    circle = np.array([1.0, -1j * sense])
    receptance = (part.receptance[1] @ circle)[0]
    load, held = free[0] / receptance, 1.0 / receptance - forced.shifts(1)[1]
    radii = abs(load / held) * np.geomspace(*_REACH, _RADII)
    equations = over_load(forced, speed_rad_s, _HARMONICS)
    for radius in radii[::_SOME]:
        motion = np.zeros((2 * _HARMONICS + 1, 2))
        motion[:3] = radius * as_real(np.array([0.0 * circle, circle]))
        left = as_complex(equations(motion, _WHOLE).residual_m.reshape(motion.shape))
        size = radius + la.norm(left, check_finite=False)
        left[1] -= left[1, 0] * circle
        if la.norm(left, check_finite=False) > _ISOTROPIC * size:
            return None
    rate = forced.frequency_ratio * speed_rad_s * sense * radii
    pushed = forced.forces[0].at(np.outer(radii, [1.0, 0.0]), np.outer(rate, [0.0, 1.0]))
    stiffness = held + pushed.force_n @ circle.conj() / radii
    beyond = np.abs(stiffness) * radii - abs(load)
    k = np.flatnonzero(beyond[1:] * beyond[:-1] <= 0.0)
    share = beyond[k] / (beyond[k] - beyond[k + 1])
    amplitude = load / (stiffness[k] + share * (stiffness[k + 1] - stiffness[k]))
    return [(as_real(np.array([0.0 * circle, a * circle])), speed_rad_s) for a in amplitude]


def raised(forced: ForcedSystem, speed_rad_s: float) -> tuple[list[Guess], float | None]:
    """Return next to the motions under the whole loads on the path that begins without loads.

    And the part of the loads at which it stops, unless a film closes or damping allows no more.
    """
    equations = over_load(forced, speed_rad_s, _HARMONICS)
    start = at_parameter(equations, np.zeros((2 * _HARMONICS + 1, forced.width)), 0.0)
    if start is None:
        return [], 0.0
    size, allowed = _linear(forced, speed_rad_s)
    course = Course(
        equations=equations,
        low=-_HEAVY,
        high=_HEAVY,
        unit=1.0,
        longest=_LONGEST,
        size_m=0.03 * size,
        bound_m=_BOUND * allowed,
        most=_POINTS,
    )
    path = follow(course, start, 1.0)
    guesses: list[Guess] = []
    for sign in (1.0, -1.0):  # under the opposite loads half a turn later
        turn = sign ** np.arange(_HARMONICS + 1)[:, None]
        motions = (as_complex(motion) for _, motion in passing(path.points, sign * _WHOLE))
        guesses += [(as_real(turn * motion), speed_rad_s) for motion in motions]
    last = path.points[-1].point.parameter
    whole = all(why in ("closed", "grows") and abs(last) > _WHOLE for _, why in path.open_ends)
    return guesses, None if whole else float(np.sinh(last))


def _linear(forced: ForcedSystem, speed_rad_s: float) -> tuple[float, float]:
    """Size of the motion at the joints without their forces, and the most that damping allows.

    The loads F on the joints can do no more work than Im 1/H takes, with forces that feed none; the
    weight is added as if the joints held none of it.
    """
    part, eye = condensed(forced, speed_rad_s, 1, forced.motion), np.eye(forced.width)
    shifts = forced.shifts(1)[:, None, None]
    held = (1.0 + _ALIKE) * eye - shifts * part.receptance  # regular where joints alone hold
    still, motion = np.linalg.solve(held, part.free_m[..., None])[..., 0]
    dynamic = la.pinv(part.receptance[1]) - shifts[1] * eye
    alike = la.orth(forced.motion, _ALIKE)  # joints at one place move alike
    damped = la.eigvalsh(alike.T @ (0.5j * (dynamic.conj().T - dynamic)) @ alike)[0]
    allowed = float(la.norm(dynamic @ motion) / damped) if damped > 0.0 else np.inf
    return float(np.abs(motion).max()), allowed + float(np.abs(still).max())


def in_time(
    small: SmallMotions, ends: tuple[float, float], known: Sequence[Branch], harmonics: int
) -> list[Guess]:
    """Return motions in balance that starts at several speeds settle to.

    `small`: shapes in which motions run; `known`: branches, they start beside the smallest motions
    of these; `harmonics`: of the base frequency.
    """
    turns = small.forced.period_multiple
    speeds = np.linspace(*ends, 2 * _SPEEDS + 1)[1::2]
    near = np.full(_SPEEDS, np.inf)  # the smallest known motion at each speed
    for branch in known:
        at = np.array([p.point.parameter for p in branch.points])
        size = np.array([np.abs(p.point.motion_m).max() for p in branch.points])
        near = np.minimum(near, size[np.abs(at - speeds[:, None]).argmin(axis=1)])
    sizes = np.repeat(np.outer(near, _SIZES), _EACH, axis=1)
    each = np.repeat(speeds, sizes.shape[1])
    motions = settled(small, each, sizes.ravel(), harmonics)
    found: list[Point] = []
    for speed, motion in zip(each.tolist(), motions, strict=True):
        point = at_speed(small.forced, motion, speed) if np.isfinite(motion).all() else None
        if point is None or (gaps(point.motion_m, point.motion_m, turns)[1:] <= _NONE).any():
            continue
        if not any(
            other.parameter == speed and gaps(point.motion_m, other.motion_m, turns).min() <= _SAME
            for other in found
        ):
            found.append(point)
    return [point[:2] for point in found]
