"""Motions from which branches are followed: circles, loads raised from none, motions in time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.nonlinear.continuation import Branch, Course, follow
from solidwhirl.rotordyn.nonlinear.forced_system import ForcedSystem, condensed
from solidwhirl.rotordyn.nonlinear.harmonic_balance import (
    Point,
    as_complex,
    as_real,
    at_parameter,
    at_speed,
    later_turns,
    over_load,
    repeats_earlier,
)
from solidwhirl.rotordyn.nonlinear.in_time import settled
from solidwhirl.rotordyn.nonlinear.stability import SmallMotions

# Speeds at which circles are looked for, with the ends; radii of a circle per speed, and how far
# they reach below and above the one without joints.
_GRID, _RADII, _REACH = 61, 5001, (1e-5, 1e4)
# Angles at which the force on every so many of the circles must be the same to rounding.
_ANGLES, _SOME, _ISOTROPIC = (0.7, 1.6, 2.5, 3.7, 5.0), 20, 1e-9
# Speeds between the ends at which loads are raised, besides those of the largest linear motions;
# harmonics then, and the longest step.
_BETWEEN, _HARMONICS, _LONGEST = 6, 3, 0.4
# Motions under loads are followed up to so many times what damping allows, or the linear motion.
_BOUND, _MOST, _DEPENDENT = 3.0, 1e4, 1e-9
# and up to 1000 times the loads, and so many of them: in films no other bound is reached.
_HEAVY, _POINTS = float(np.arcsinh(1e3)), 200
# Speeds at which motions are started in time, how far out beside the known motion, how many each.
_SPEEDS, _SIZES, _EACH = 12, (1.0, 3.0, 10.0), 4
# Motions that differ by less than this part are one.
_SAME = 1e-6


class _Linear(NamedTuple):
    """The motion at the joints without their forces in harmonics 0 and 1, and 1/receptance there.

    `motion_m`: shape (2, 2j); `stiffness_n_per_m`: of harmonic 1, (2j, 2j).
    """

    motion_m: FloatArray
    stiffness_n_per_m: FloatArray


def all_circles(forced: ForcedSystem, ends_rad_s: tuple[float, float]) -> list[Point] | None:
    """Return all circular orbits at many speeds, from the ends inward; None if any is no circle."""
    speeds, found = np.linspace(*ends_rad_s, _GRID), []
    for speed in (*speeds[[0, -1]], *speeds[1:-1]):
        orbits = circular_orbits(forced, float(speed))
        if orbits is None:
            return None
        found += orbits
    return found


def circular_orbits(forced: ForcedSystem, speed_rad_s: float) -> list[Point] | None:
    """Return all circular orbits at a speed; None if motions need not be circles.

    A circle of radius r takes the load |1/H + k(r)| r, H the receptance and k(r) the stiffness of
    the joint, if all is the same in all directions and there is one joint alone: as a function of
    r it has every orbit at the load of the unbalance.
    """
    if forced.width != 2 or forced.period_multiple != 1:
        return None
    linear = _linear(forced, speed_rad_s)
    (still, moved), dynamic = linear.motion_m, linear.stiffness_n_per_m
    sense = 1.0 if (moved[1] * np.conj(moved[0])).imag <= 0.0 else -1.0
    circle = np.array([1.0, -1j * sense])
    turned, other = dynamic @ circle, dynamic @ circle.conj()
    uneven = (
        np.abs(moved - moved[0] * circle) + np.abs(still),
        (np.abs(turned - turned[0] * circle) + np.abs(other - other[0] * circle.conj()))
        * np.abs(moved).max() / np.abs(dynamic).max(),
    )  # fmt: skip
    if np.max(uneven) > _ISOTROPIC * np.abs(moved).max():
        return None

    def taken(radii: FloatArray, angle: float) -> ComplexArray:
        """Force outward and, imaginary, along circles at an angle."""
        out = np.array([np.cos(angle), sense * np.sin(angle)])
        along = np.array([-np.sin(angle), sense * np.cos(angle)])
        rate = forced.frequency_ratio * speed_rad_s * radii[:, None] * along
        force = forced.forces[0].at(radii[:, None] * out, rate).force_n
        return np.asarray(force @ (out + 1j * along))

    radii = abs(moved[0]) * np.geomspace(*_REACH, _RADII)
    force = taken(radii, 0.0)
    some = slice(None, None, _SOME)
    for angle in _ANGLES:
        apart = np.abs(taken(radii[some], angle) - force[some])
        if (apart > _ISOTROPIC * (np.abs(force) + np.abs(turned[0]) * radii)[some]).any():
            return None
    load = abs(turned[0] * moved[0])
    beyond = np.abs(turned[0] + force / radii) * radii - load
    found = []
    for k in np.flatnonzero(beyond[1:] * beyond[:-1] <= 0.0):
        share = beyond[k] / (beyond[k] - beyond[k + 1])
        r, pushed = (v[k] + share * (v[k + 1] - v[k]) for v in (radii, force))
        amplitude = turned[0] * moved[0] / (turned[0] + pushed / r)
        motion = as_real(np.array([0.0 * circle, amplitude * circle]))
        point = at_speed(forced, motion, speed_rad_s)
        found += [] if point is None else [point]
    return found


def under_loads(forced: ForcedSystem, ends_rad_s: tuple[float, float]) -> Iterator[Point]:
    """Yield motions under the whole loads on the path along which these are raised from none.

    At the ends, at the speeds of the largest linear motions, and between.
    """
    low, high = ends_rad_s
    grid = np.linspace(low, high, _GRID)
    size = np.array([la.norm(_linear(forced, float(s)).motion_m) for s in grid])
    peaks = 1 + np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] > size[2:]))
    speeds = {*np.linspace(low, high, _BETWEEN + 2)[1:-1].tolist(), *grid[peaks].tolist()}
    for speed in (low, high, *sorted(speeds)):
        yield from raised(forced, speed)


def raised(forced: ForcedSystem, speed_rad_s: float) -> Iterator[Point]:
    """Yield the motions under the whole loads on the path that begins without loads."""
    equations, linear = over_load(forced, speed_rad_s, _HARMONICS), _linear(forced, speed_rad_s)
    start = at_parameter(equations, np.zeros((2 * _HARMONICS + 1, forced.width)), 0.0)
    if start is None:
        return
    size = float(np.abs(linear.motion_m).max())
    dynamic = linear.stiffness_n_per_m
    moved = la.orth(forced.motion, _DEPENDENT)  # joints at one place move alike
    damped = float(la.eigvalsh(moved.T @ (0.5j * (dynamic.conj().T - dynamic)) @ moved)[0])
    load = float(la.norm(dynamic @ linear.motion_m[1]))
    allowed = _BOUND * load / damped if damped > 0.0 else np.inf
    course = Course(
        equations=equations,
        low=-_HEAVY,
        high=_HEAVY,
        unit=1.0,
        longest=_LONGEST,
        most=_POINTS,
        size_m=0.03 * size,
        bound_m=max(min(allowed, _MOST * size), 10.0 * size),
    )
    path = follow(course, start, 1.0).points
    at = np.array([p.point.parameter for p in path])
    for share in (1.0, -1.0):  # under the opposite loads half a turn later
        over = at > np.arcsinh(share)
        for k in np.flatnonzero(over[1:] != over[:-1]):
            part = (np.arcsinh(share) - at[k]) / (at[k + 1] - at[k])
            first, last = (path[j].point.motion_m for j in (k, k + 1))
            motion = as_complex(first + part * (last - first))
            turn = share ** np.arange(len(motion))
            found = at_speed(forced, as_real(turn[:, None] * motion), speed_rad_s)
            if found is not None:
                yield found


def _linear(forced: ForcedSystem, speed_rad_s: float) -> _Linear:
    part = condensed(forced, speed_rad_s, 1, forced.motion)
    shifts, eye = forced.shifts(1), np.eye(forced.width)
    motion = [
        la.solve(eye - shift * receptance, free, check_finite=False)
        for shift, receptance, free in zip(shifts, part.receptance, part.free_m, strict=True)
    ]
    return _Linear(np.array(motion), la.pinv(part.receptance[1]) - shifts[1] * eye)


def in_time(
    small: SmallMotions, ends: tuple[float, float], known: Sequence[Branch], harmonics: int
) -> Iterator[Point]:
    """Yield motions in balance that starts at several speeds settle to.

    `small`: shapes in which motions run; `known`: branches, beside whose motions they start;
    `harmonics`: of the base frequency.
    """
    speeds = ends[0] + (np.arange(_SPEEDS) + 0.5) / _SPEEDS * (ends[1] - ends[0])
    points = [p.point for branch in known for p in branch.points]
    at = np.array([p.parameter for p in points])
    size = np.array([float(np.abs(p.motion_m).max()) for p in points])
    near = [float(size[np.argmin(np.abs(at - speed))]) for speed in speeds]
    sizes = np.repeat(np.outer(near, _SIZES), _EACH, axis=1)
    each = np.repeat(speeds, sizes.shape[1])
    motions = settled(small, each, sizes.ravel(), harmonics)
    yielded: list[Point] = []
    for speed, motion in zip(each.tolist(), motions, strict=True):
        found = at_speed(small.forced, motion, speed) if np.isfinite(motion).all() else None
        if found is None or repeats_earlier(found.motion_m, small.forced.period_multiple):
            continue
        same = (
            la.norm(later - other.motion_m) <= _SAME * la.norm(later)
            for other in yielded
            if other.parameter == speed
            for later in later_turns(found.motion_m, small.forced.period_multiple)
        )
        if not any(same):
            yielded.append(found)
            yield found
