"""Equilibrium and stiffness of rolling bearings and sets of them, at rest and at speed.

A set is one ring with several alike rows. Loads, preload and speed give where the ring lies; its
stiffness is a mean over the positions of the balls.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np
import scipy

from solidwhirl.rotordyn.bearings.balls import BallBearing
from solidwhirl.rotordyn.bearings.elements import (
    RING_MOTIONS,
    ElementForces,
    element_forces,
    row_motion,
)
from solidwhirl.rotordyn.bearings.rollers import RollerBearing
from solidwhirl.rotordyn.bearings.speed_tables import Rows, close_rows
from solidwhirl.rotordyn.bearings.validity import Exceeded
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S

RollingBearing = BallBearing | RollerBearing
Preload = Literal["spring", "rigid"]

_STEPS, _HALVINGS = 200, 40
# Forces on the ring balance to this fraction of the load.
_BALANCED = 1e-11
# A bearing whose elements are pressed together by more than this of their diameter is crushed.
_CRUSHED = 0.02
# Speed times pitch diameter from which on what is left out matters, mm/min: common practice.
_FAST = 1e6
# Positions of the balls between two at which one comes into contact, and steps to find these.
_POSITIONS, _FALSE_POSITION = 8, 8
# Positions that differ by less than this decimal are one.
_ONE_PLACE = 6
# What tables keep to, and motions that have next to no stiffness beside the largest √k.
_CLOSE, _SMALL = 1e-4, 1e-2


@dataclass(frozen=True, kw_only=True)
class BearingSet:
    """Alike rows side by side whose inner rings sit on one shaft and outer rings in one housing.

    `facing`: of each row along z, 1 if it carries a load on the inner ring towards +z, −1 towards
    −z: (1, −1) is back to back (DB, O), (−1, 1) face to face (DF, X), (1, 1) tandem (DT);
    `places_m`: of the rows along z, from the middle of the set.
    """

    row: RollingBearing
    facing: tuple[int, ...] = (1,)
    places_m: tuple[float, ...] = (0.0,)

    @property
    def rows(self) -> tuple[FloatArray, ...]:
        """What the ring does at each row."""
        pairs = zip(self.facing, self.places_m, strict=True)
        return tuple(row_motion(way, place) for way, place in pairs)

    @property
    def is_opposed(self) -> bool:
        """Whether rows carry axial loads both ways."""
        return len(set(self.facing)) > 1


@dataclass(frozen=True, kw_only=True)
class RingLoad:
    """What presses a set.

    `load_n`: on the inner rings along x, y, z; `preload_n`: axial force in the rows that face one
    way, all together, besides: kept by springs at all speeds ("spring"), or set at rest without
    other loads by the distance of the rings, which stays ("rigid").
    """

    load_n: tuple[float, float, float]
    preload_n: float = 0.0
    preload: Preload = "spring"


class RingStates(NamedTuple):
    """Equilibria of a ring, b of them, on (ux, uy, uz, rx, ry) and the shifts of the rows.

    `motion`: m and rad, (b, 7); `stiffness`: exact derivative of the load, on (ux, uy, uz, rx, ry)
    with the shifts as they are held or pushed, (b, 5, 5); `found`: of the elements.
    """

    motion: FloatArray
    stiffness: FloatArray
    found: ElementForces


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class MeanStiffness(ReadOnlyArrays):
    """Stiffness on (ux, uy, uz, rx, ry) at speeds, over the positions of the balls.

    `mean`: (s, 5, 5); `least`, `most`: of its diagonal, (s, 5).
    """

    mean: FloatArray
    least: FloatArray
    most: FloatArray


def ring_states(
    bearings: BearingSet,
    load: RingLoad,
    speeds_rad_s: FloatArray,
    positions_rad: FloatArray,
    tilt_rad: tuple[float, float] = (0.0, 0.0),
    start: FloatArray | None = None,
) -> RingStates:
    """Return the equilibria at speeds of the inner ring and angles of the first balls, (b,) each.

    `tilt_rad`: rx and ry, held; `start`: motions nearby, (b, 7). Raises AnalysisError if the set
    cannot carry the load.
    """
    speeds, force = np.asarray(speeds_rad_s, dtype=float), np.array([*load.load_n, 0.0, 0.0])
    row, sides = bearings.row, dict.fromkeys(bearings.facing)
    _refuse_load(bearings, load)
    thrown = np.array([row.centrifugal_n(speed) for speed in speeds.tolist()])
    target, motion = np.zeros(RING_MOTIONS), np.zeros((speeds.size, RING_MOTIONS))
    target[:3], motion[:, 3:5] = force[:3], tilt_rad
    free = list(row.carried)
    shift = {1: 5, -1: 6}
    pushed = {side: load.preload_n / bearings.facing.count(side) for side in sides}
    if load.preload == "rigid":
        if load.preload_n > 0:
            for side, own in pushed.items():
                motion[:, shift[side]] = row.start(np.array([0.0, 0.0, own, 0, 0]), 0.0)[2]
                target[shift[side]] = load.preload_n
            still, moved = np.zeros(1), motion[:1].copy()
            moved[:, 3:5] = 0.0
            ways = [shift[side] for side in sides]
            held = _balanced(bearings, still, still, moved, ways, target * (np.arange(7) > 4))
            motion[:, 5:], target[5:] = held.motion[0, 5:], 0.0
        if not bearings.is_opposed:
            free.remove(2)
    elif bearings.is_opposed:
        free, target[6] = [*free, 6], load.preload_n
    else:
        target[2] += bearings.facing[0] * load.preload_n
    known: dict[float, FloatArray] = {}
    for at, own in enumerate(thrown.tolist()):
        if own not in known:
            known[own] = _start(bearings, load, target, own)
        motion[at, :3] = known[own][:3]
        motion[at, 5:] += known[own][5:]
    if start is not None:
        motion[:, free] = start[:, free]
    found = _balanced(bearings, thrown, positions_rad, motion, free, target)
    _refuse_misplaced(bearings, found.found, force)
    return found


def _start(bearings: BearingSet, load: RingLoad, target: FloatArray, own: float) -> FloatArray:
    """Return a motion (7,) to begin a search from."""
    row, motion, count = bearings.row, np.zeros(RING_MOTIONS), len(bearings.facing)
    held = load.preload == "rigid" and load.preload_n > 0
    lateral = target[:2] / count
    if not bearings.is_opposed:
        way = bearings.facing[0]
        force = np.array([*lateral, 0.0 if held else way * target[2] / count, 0.0, 0.0])
        motion[:3] = row.start(force, own)[:3]
        motion[2] *= way
        return motion
    if held:
        return motion
    for way, shift in ((1, 5), (-1, 6)):
        axial = load.preload_n + (target[2] if way > 0 else 0.0)
        force = np.array([*lateral, axial / bearings.facing.count(way), 0.0, 0.0])
        motion[:2], motion[shift] = row.start(force, own)[:2], row.start(force, own)[2]
    # the rows that carry +z stay where they are, the ring moves
    motion[2], motion[6], motion[5] = motion[5], motion[6] + motion[5], 0.0
    if load.preload == "rigid":
        motion[2], motion[6] = 0.0, 0.0
    return motion


def loaded_ring(
    bearing: RollingBearing,
    load_n: tuple[float, float, float],
    tilt_rad: tuple[float, float] = (0.0, 0.0),
    speed_rad_s: float = 0.0,
) -> RingStates:
    """Return the equilibrium of one row under constant loads, its first ball at +x.

    Arguments as of `ring_states`; an axial load such as the force of springs too.
    """
    load, zero = RingLoad(load_n=load_n), np.zeros(1)
    speeds = np.array([speed_rad_s])
    return ring_states(BearingSet(row=bearing), load, speeds, zero, tilt_rad)


def mean_stiffness(
    bearings: BearingSet,
    load: RingLoad,
    speeds_rad_s: FloatArray,
    *,
    floats: bool = False,
    known: dict[float, FloatArray] | None = None,
) -> MeanStiffness:
    """Return the stiffness at speeds (s,) of the inner ring, a mean over the places of the balls.

    All rows have their first ball at one angle, which goes through the distance of two balls;
    those on either side of the load are mirror images. `floats`: the ring may slide axially, its
    axial force kept; then there is no stiffness along z. `known`: motions by speed, of calls before
    and added to, which spare much of the search. Raises AnalysisError as `ring_states`.
    """
    speeds = np.asarray(speeds_rad_s, dtype=float)
    lateral = float(np.hypot(*load.load_n[:2]))
    direction = float(np.arctan2(load.load_n[1], load.load_n[0]))
    along = RingLoad(
        load_n=(lateral, 0.0, load.load_n[2]), preload_n=load.preload_n, preload=load.preload
    )
    row = bearings.row
    half, near = np.pi / row.element_count, {} if known is None else known

    def at(speeds: FloatArray, shares: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return K and gaps at speeds and shares of half the distance of two balls, (b,) each."""
        start = None
        if near:
            rows = np.array(sorted(near))
            motions = np.array([near[speed] for speed in rows.tolist()])
            start = np.array([np.interp(speeds, rows, m) for m in motions.T]).T
        states = ring_states(bearings, along, speeds, half * shares, start=start)
        near.update(zip(speeds.tolist(), states.motion, strict=True))
        k = _released(states.stiffness, (2,)) if floats else states.stiffness
        return k, states.found.gap_m

    if lateral == 0.0:  # three balls and more are alike in all directions
        mean = _round(at(speeds, np.zeros(speeds.size))[0])
        diagonal = np.einsum("sii->si", mean)
        return MeanStiffness(mean=mean, least=diagonal.copy(), most=diagonal.copy())
    mean = np.zeros((speeds.size, 5, 5))
    least, most = np.zeros((2, speeds.size, 5))
    speed, share, weight = _places(at, speeds)
    values = at(speeds[speed], share)[0]
    np.add.at(mean, speed, weight[:, None, None] * values)
    diagonal = _diagonals(values, direction)
    for k in range(speeds.size):
        own = diagonal[speed == k]
        least[k], most[k] = own.min(axis=(0, 1)), own.max(axis=(0, 1))
    mirror = np.array([1.0, -1.0, 1.0, -1.0, 1.0])
    mean = 0.5 * (mean + mirror[:, None] * mean * mirror)
    turn = _turn(direction)
    return MeanStiffness(mean=turn @ mean @ turn.T, least=least, most=most)


class RingTable(NamedTuple):
    """Mean stiffness on (ux, uy, uz, rx, ry) over the speed, smooth between rows.

    `speeds_rad_s`: (s,); the others as of `MeanStiffness` at them.
    """

    speeds_rad_s: FloatArray
    stiffness: FloatArray
    least: FloatArray
    most: FloatArray


def ring_table(
    bearings: BearingSet, load: RingLoad, highest_rad_s: float, *, floats: bool = False
) -> RingTable:
    """Return a table from rest whose cubic spline misses k_ij by less than 1e-4 √(k_ii k_jj).

    Arguments as of `mean_stiffness`. Raises AnalysisError as there.
    """
    motions: dict[float, FloatArray] = {}
    known: dict[float, tuple[FloatArray, ...]] = {}
    radius = 0.5 * bearings.row.pitch_diameter_m
    size = np.array([1.0, 1.0, 1.0, radius, radius])

    def rows(speeds: FloatArray) -> Rows:
        found = mean_stiffness(bearings, load, speeds, floats=floats, known=motions)
        known.update(zip(speeds.tolist(), zip(found.least, found.most, strict=True), strict=True))
        root = np.sqrt(np.abs(np.einsum("sii->si", found.mean))) / size
        root = np.maximum(root, _SMALL * root.max(axis=1, keepdims=True)) * size
        own = root[:, :, None] * root[:, None]
        return Rows(*(part.reshape(speeds.size, 25) for part in (found.mean, own)))

    speeds, found = close_rows(rows, 0.0, highest_rad_s, _CLOSE)
    ranges = [known[speed] for speed in speeds.tolist()]
    least, most = (np.array(part) for part in zip(*ranges, strict=True))
    return RingTable(speeds, found.values.reshape(-1, 5, 5), least, most)


def _places(
    at: Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]], speeds: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return positions to average over, and their weights, at each of the speeds.

    `at`: stiffness and gaps at speeds and positions 0 to 1. Returns the number of the speed, the
    position and the weight, (b,) each. Where no element comes into contact on the way the mean is
    over an even periodic function, else by Gauss between such positions, denser near them.
    """
    count = speeds.size
    gaps = at(np.tile(speeds, 2), np.repeat([0.0, 1.0], count))[1]
    first, last = gaps[:count], gaps[count:]
    which, element = np.nonzero((first < 0) != (last < 0))
    low, high = np.zeros(which.size), np.ones(which.size)
    left, right = first[which, element], last[which, element]
    middle = 0.5 * (low + high)
    for _ in range(_FALSE_POSITION if which.size else 0):
        middle = low - left * (high - low) / (right - left)
        own = at(speeds[which], middle)[1][np.arange(which.size), element]
        same = (own < 0) == (left < 0)
        # Illinois: an end that stays counts half
        left, right = np.where(same, own, 0.5 * left), np.where(same, 0.5 * right, own)
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    nodes, weights = scipy.special.roots_legendre(_POSITIONS)
    t = 0.5 * (1.0 + nodes)
    dense, slope = t**3 * (10.0 - 15.0 * t + 6.0 * t * t), 30.0 * (t * (1.0 - t)) ** 2
    found: list[tuple[int, float, float]] = []
    for k in range(count):
        ends = np.unique([0.0, *middle[which == k].round(_ONE_PLACE), 1.0]).tolist()
        if len(ends) == 2:
            found += [(k, 0.0, 0.25), (k, 0.5, 0.5), (k, 1.0, 0.25)]
            continue
        for begin, end in pairwise(ends):
            found += [
                (k, begin + (end - begin) * place, 0.5 * (end - begin) * rate * weight)
                for place, rate, weight in zip(dense, slope, weights, strict=True)
            ]
    speed, share, weight = zip(*found, strict=True)
    return np.array(speed), np.array(share), np.array(weight)


def _diagonals(values: FloatArray, direction: float) -> FloatArray:
    """Return the diagonals of stiffnesses (b, 5, 5) and of their mirror images, (b, 2, 5)."""
    mirror, turn = np.array([1.0, -1.0, 1.0, -1.0, 1.0]), _turn(direction)
    both = np.stack((values, mirror[:, None] * values * mirror), axis=1)
    return np.asarray(np.einsum("ij,bpjk,ik->bpi", turn, both, turn))


def _turn(angle: float) -> FloatArray:
    """Return what turns (ux, uy, uz, rx, ry) about z by an angle."""
    turn, c, s = np.eye(5), np.cos(angle), np.sin(angle)
    turn[:2, :2] = turn[3:, 3:] = [[c, -s], [s, c]]
    return turn


def _round(stiffness: FloatArray) -> FloatArray:
    """Return stiffnesses (s, 5, 5) without the rounding that makes directions unlike."""
    out = np.zeros_like(stiffness)
    for at in (0, 3):
        mean = 0.5 * (stiffness[:, at, at] + stiffness[:, at + 1, at + 1])
        out[:, at, at] = out[:, at + 1, at + 1] = mean
    coupling = 0.5 * (stiffness[:, 0, 4] - stiffness[:, 1, 3])
    size = np.sqrt(out[:, 0, 0] * out[:, 3, 3])
    coupling = np.where(np.abs(coupling) > 1e-9 * size, coupling, 0.0)
    out[:, 0, 4] = out[:, 4, 0] = coupling
    out[:, 1, 3] = out[:, 3, 1] = -coupling
    out[:, 2, 2] = stiffness[:, 2, 2]
    return out


def _released(stiffness: FloatArray, motions: Sequence[int]) -> FloatArray:
    """Return stiffnesses (b, m, m) with motions left free, zero on these."""
    out, at = stiffness.copy(), list(motions)
    own = stiffness[:, at][:, :, at]
    trace = np.trace(own, axis1=1, axis2=2)
    own = own + ((trace == 0) + 1e-14 * trace)[:, None, None] * np.eye(len(at))
    out -= stiffness[:, :, at] @ np.linalg.solve(own, stiffness[:, at])
    out[:, at], out[:, :, at] = 0.0, 0.0
    return out


def _balanced(
    bearings: BearingSet,
    thrown: FloatArray,
    positions: FloatArray,
    motion: FloatArray,
    free: list[int],
    target: FloatArray,
) -> RingStates:
    """Find the places of rings by Newton's method; their energy is convex."""
    row, rows, motion = bearings.row, bearings.rows, motion.copy()

    def forces(motion: FloatArray, at: IntArray, near: FloatArray | None) -> ElementForces:
        return element_forces(row, rows, motion, positions[at], thrown[at], near)

    at = np.arange(len(motion))
    now = forces(motion, at, None)
    every = {name: array.copy() for name, array in now._asdict().items()}
    for _ in range(_STEPS):
        miss = (now.force - target)[:, free]
        scale = np.abs(target).max() + now.inner_load_n.max(axis=1)
        open_ = np.abs(miss).max(axis=1, initial=0.0) > _BALANCED * scale
        for name, array in now._asdict().items():
            every[name][at] = array
        if not open_.any():
            break
        at, miss, scale = at[open_], miss[open_], scale[open_]
        jacobian = now.stiffness[open_][:, free][:, :, free]
        least = 1e-12 * np.trace(jacobian, axis1=1, axis2=2) + scale / row.size_m * 1e-6
        jacobian = jacobian + least[:, None, None] * np.eye(len(free))
        step = np.linalg.solve(jacobian, -miss[..., None])[..., 0]
        step *= np.minimum(1.0, 0.1 * row.size_m / np.abs(step).max(axis=1))[:, None]
        size, trying = np.linalg.norm(miss, axis=1), np.arange(at.size)
        after = {name: array[open_].copy() for name, array in now._asdict().items()}
        start, near = motion[at], after["place"].copy()
        for _ in range(_HALVINGS):
            trial = start[trying]
            trial[:, free] += step[trying]
            found = forces(trial, at[trying], near[trying])
            motion[at[trying]] = trial
            for name, array in found._asdict().items():
                after[name][trying] = array
            good = np.linalg.norm((found.force - target)[:, free], axis=1) < size[trying]
            good &= found.inner_load_n.any(axis=1)
            trying = trying[~good]
            if not trying.size:
                break
            step[trying] *= 0.5
        now = ElementForces(**after)
    else:
        raise AnalysisError(f"no equilibrium of the rolling bearing under {target[:3].tolist()} N")
    found = ElementForces(**every)
    stiffness = found.stiffness
    if 6 in free and 5 not in free:
        stiffness = _released(stiffness, (6,))
    return RingStates(motion, stiffness[:, :5, :5], found)


def _refuse_load(bearings: BearingSet, load: RingLoad) -> None:
    """Raise AnalysisError for a load that the rows have no way of carrying."""
    row, force = bearings.row, load.load_n
    beyond = [axis for k, axis in enumerate("xyz") if force[k] and k not in row.carried]
    if beyond or (load.preload_n and 2 not in row.carried):
        raise AnalysisError(
            f"load {list(force)} N: this bearing carries none along {beyond or ['z']}"
        )
    if not any(force) and not load.preload_n:
        raise AnalysisError("load [0, 0, 0] N: without a load a rolling bearing has no stiffness")
    if load.preload == "rigid" and not bearings.is_opposed and force[2]:
        raise AnalysisError(
            f"load {list(force)} N: rows that face one way and are held by a rigid preload get "
            "their axial force from it; leave out that along z, or give the force of springs"
        )


def _refuse_misplaced(bearings: BearingSet, found: ElementForces, force: FloatArray) -> None:
    """Raise AnalysisError if elements leave their races or are crushed."""
    row = bearings.row
    problem, load = row.misplaced(found), found.outer_load_n.max()
    if isinstance(row, BallBearing):
        approach = (load / row.stiffness_n_per_m15) ** (2.0 / 3.0)
    else:
        approach = (load / row.stiffness_n_per_m109) ** 0.9
    if approach > _CRUSHED * row.size_m:
        problem = f"the elements would be pressed in by {approach / row.size_m:.2g} diameters"
    if problem:
        raise AnalysisError(f"load {force[:3].tolist()} N cannot be carried: {problem}")


def exceeded(row: RollingBearing, states: RingStates, speed_rad_s: float) -> tuple[Exceeded, ...]:
    """Return where equilibria are beyond what the theory is for: contact pressure and speed."""
    beyond, found = [], states.found
    loads = (float(found.inner_load_n.max()), float(found.outer_load_n.max()))
    pressure, limit = row.pressure_pa(*loads), row.highest_pressure_pa
    if pressure > limit:
        why = "it is above that of the static load rating, contacts are elastic no more"
        beyond.append(Exceeded("contact pressure [Pa]", pressure, limit, why))
    fast = abs(speed_rad_s) * RPM_PER_RAD_S * 1e3 * row.pitch_diameter_m
    if fast > _FAST:
        why = "gyroscopic moments, slip, oil film and growth of the rings are left out"
        beyond.append(Exceeded("speed times pitch diameter [mm/min]", fast, _FAST, why))
    return tuple(beyond)
