"""Checks of stability, responses, state space and run-ups against the unsimplified system."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.checks.mode_counts import full_spectrum, is_counted_by_signs
from solidwhirl.rotordyn.checks.plain_checks import ACCURACY, ROUNDINGS, Miss, worst_of
from solidwhirl.rotordyn.checks.plain_system import PlainMatrices, PlainSystem, root_error
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.modes.damping import NEUTRAL, ROUNDING
from solidwhirl.rotordyn.response.unbalance import NEAR_REST, Unbalance
from solidwhirl.rotordyn.superelement.invariants import Invariant, compared, undecided
from solidwhirl.rotordyn.superelement.validation import MOTIONS

_EPS = float(np.finfo(float).eps)
# A response may be higher than the samples beside it by this factor.
_HIGHER = 1.5
# Responses below this part of the largest are not looked at for peaks.
_SMALL = 1e-3
# Roots slower than this part of the others are rigid motion with its rounding.
_STILL = 1e-6
# Ends of unstable intervals are right to this (relative).
_END = 1e-6
#: A resonance with less damping than this (decrement) has no height to look at.
DAMPED = 1e-6
# Frequencies, over the speed or one rad/s, at which transfer functions are compared.
_TRANSFER = (0.37, 1.7, 5.3)


class Motion(NamedTuple):
    """Amplitudes of rows of motion (k,) and what rounding may change in each."""

    amplitude: ComplexArray
    rounding: FloatArray


def motion_under(
    matrices: PlainMatrices, rate: float, load: ComplexArray, rows: FloatArray
) -> Motion | None:
    """Return the motion under a harmonic load, None at an undamped resonance.

    `load`: shape (n,); `rows`: motion of what is observed per unit coordinate, shape (k, n).
    """
    dynamic, size = matrices.dynamic(1j * rate), matrices.size(1j * rate)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(size), np.finfo(float).tiny))
    even = scale[:, None] * dynamic * scale
    factors, pivots, singular = la.lapack.zgetrf(even)
    if singular:
        return None
    solved = la.lapack.zgetrs(factors, pivots, scale * load)[0]
    seen = la.lapack.zgetrs(factors, pivots, (rows * scale).T.astype(complex), trans=1)[0]
    displacement = scale * solved
    bound = _EPS * np.abs(scale[:, None] * seen).T @ size @ np.abs(displacement)
    return Motion(np.asarray(rows @ displacement), np.asarray(bound))


def unbalance_load(
    plain: PlainSystem, loads: Sequence[Unbalance], speed_rad_s: float
) -> ComplexArray:
    """Return the force of unbalances that turn at one frequency, factor of e^{iωt}, shape (n,).

    `loads`: on bodies of one |speed ratio|; `speed_rad_s`: Ω of the reference shaft.
    """
    total = np.zeros(plain.transformation.shape[1], dtype=complex)
    for load in loads:
        spin = plain.system.rotors[load.body].speed_ratio * speed_rad_s
        seat = plain.seat(load.end)
        # m e (spin)² cos(spin t + φ) along x, sin along y; e^{iωt} has ω = |spin|
        sense = 1.0 if spin >= 0.0 else -1.0
        force = load.moment_kg_m * spin**2 * np.exp(1j * sense * load.phase_rad)
        total += force * (seat[0] - 1j * sense * seat[1])
    return total


# The right motion at a speed, None where there is none.
Moved = Callable[[float], Motion | None]


class Curve(NamedTuple):
    """A response at one place over the speed: ux and uy (s, 2)."""

    place: End
    amplitude: ComplexArray


def check_unbalance_response(
    plain: PlainSystem,
    loads: Sequence[Unbalance],
    speeds_rad_s: FloatArray,
    curves: Sequence[Curve],
    chosen: Sequence[int],
    doubtful_rad_s: Sequence[float] | FloatArray,
    where: str,
    spin_rad_s: float | None = None,
) -> Iterator[Invariant]:
    """Check a response to unbalance by direct solution, and that no peak of it is missing.

    `loads`: that turn at one frequency; `chosen`: indices of the speeds to look at.
    `doubtful_rad_s`: speeds at which the response may be far above the samples beside it: damped
    critical speeds and the knots of laws. `spin_rad_s`: speed of the reference shaft while the
    force alone turns at other speeds, with resonances of its own; None: the same.
    """
    ratio = abs(plain.system.rotors[loads[0].body].speed_ratio)
    rows = np.vstack([plain.seat(curve.place)[:2] for curve in curves])
    if spin_rad_s is not None:
        shift = ratio * float(speeds_rad_s[-1])
        doubtful_rad_s = damped_frequencies(plain.at(spin_rad_s), shift) / ratio

    def moved(speed: float) -> Motion | None:
        force, rate = unbalance_load(plain, loads, speed), ratio * speed
        turning = speed if spin_rad_s is None else spin_rad_s
        return motion_under(plain.at(turning, 1j * rate), rate, force, rows) if speed else None

    misses = _deviations(moved, speeds_rad_s, curves, chosen)
    if misses:
        text = f"direct solution at {len(misses)} of {speeds_rad_s.size} speeds"
        yield worst_of("response is that of the system", where, "the response", misses, text)
    misses = _peaks(moved, speeds_rad_s, curves, doubtful_rad_s)
    if misses:
        text = f"over the samples beside it, at {len(misses)} critical speeds and knots"
        name = "no peak of the response is missing"
        yield worst_of(name, where, "peaks of the response", misses, text)


def damped_frequencies(matrices: PlainMatrices, shift: float) -> FloatArray:
    """Return |Im λ| of all motions that have damping; `shift`: see `full_spectrum`."""
    values = full_spectrum(matrices, shift)
    damped = np.abs(values.real) > DAMPED / (2.0 * np.pi) * np.abs(values)
    return np.asarray(np.unique(np.abs(values.imag[damped])))


def _deviations(
    moved: Moved, speeds_rad_s: FloatArray, curves: Sequence[Curve], chosen: Sequence[int]
) -> list[Miss]:
    """How far a response is from the direct solution, over the largest motion at the speed."""
    misses = []
    for at in chosen:
        speed = float(speeds_rad_s[at])
        found, right = np.concatenate([curve.amplitude[at] for curve in curves]), moved(speed)
        if right is None or not np.isfinite(found).all():
            continue
        largest = float(np.abs(right.amplitude).max(initial=0.0))
        if largest > 0.0:
            error = np.abs(right.amplitude - found) / largest
            limit = ACCURACY + ROUNDINGS * right.rounding / largest
            worst = int(np.argmax(error / limit))
            misses.append(Miss(float(error[worst]), float(limit[worst]), speed))
    return misses


def _peaks(
    moved: Moved,
    speeds_rad_s: FloatArray,
    curves: Sequence[Curve],
    doubtful_rad_s: Sequence[float] | FloatArray,
) -> list[Miss]:
    """How many times a response is higher at some speeds than its samples beside them."""
    listed = np.stack([_major(curve.amplitude) for curve in curves], axis=1)
    highest = np.nanmax(listed, axis=0)
    misses = []
    for speed in doubtful_rad_s:
        if not max(speeds_rad_s[0], NEAR_REST * speeds_rad_s[-1]) < speed < speeds_rad_s[-1]:
            continue
        right = moved(speed)
        if right is None:
            continue
        major = _major(right.amplitude.reshape(-1, 2))
        # a place that the load does not reach moves by the rounding of the others
        rounding = ROUNDINGS * _EPS * major.max()
        after = int(np.searchsorted(speeds_rad_s, speed))
        beside = np.nanmax(listed[max(0, after - 2) : after + 2], axis=0)
        seen = major > np.maximum(_SMALL * highest, rounding)
        if seen.any():
            times = float((major[seen] / np.maximum(beside[seen], np.finfo(float).tiny)).max())
            misses.append(Miss(times, _HIGHER, speed))
    return misses


def _major(amplitude: ComplexArray) -> FloatArray:
    """Major half axes of orbits, of ux and uy in the last axis."""
    x, y = amplitude[..., 0], amplitude[..., 1]
    return np.asarray(0.5 * (np.abs(x + 1j * y) + np.abs(x - 1j * y)))


def check_stability(
    plain: PlainSystem,
    intervals_rad_s: Sequence[tuple[float, float, float]],
    range_rad_s: tuple[float, float],
    marks_rad_s: Sequence[float],
    where: str,
) -> tuple[Invariant, ...]:
    """Check unstable intervals by all roots beside their ends, at knots and between.

    `intervals_rad_s`: lowest and highest speed of each, rising, and that of the largest growth;
    `range_rad_s`: of the speeds that were searched; `marks_rad_s`: further speeds, such as knots of
    laws and those of a chart.
    """
    name = "unstable intervals are those of the system"
    if plain.depends_on_frequency:
        reason = "bearings depend on the frequency: no one spectrum has all roots of a speed"
        return (undecided(name, where, "stability", reason),)
    low, high = range_rad_s
    ends = [end for low_end, high_end, _ in intervals_rad_s for end in (low_end, high_end)]
    tops = {top for _, _, top in intervals_rad_s}
    inner = sorted({m for m in marks_rad_s if low < m < high})
    looked = {low, high, *inner, *(0.5 * (a + b) for a, b in pairwise([low, *inner, high]))}
    looked |= {0.5 * (a + b) for a, b in pairwise(sorted({low, *ends, high}))}
    looked |= {end * (1.0 + side) for end in ends for side in (-_END, _END)}
    faults = []
    looked |= tops
    for speed in sorted(s for s in looked if low <= s <= high):
        if speed not in tops and any(abs(speed - end) < 0.5 * _END * end for end in ends):
            continue
        inside = any(a <= speed <= b for a, b, _ in intervals_rad_s)
        # growth too slow to count belongs to an interval, but it is not all of it
        least = 0.1 * NEUTRAL if speed in tops else -ROUNDING
        grows = growth_sign(plain.at(float(speed)), float(speed), least)
        if (inside and grows < 0) or (not inside and grows > 0):
            found = "stable" if inside else "unstable"
            faults.append(f"{found} at {speed * RPM_PER_RAD_S:.9g} rpm")
    text = "; ".join(faults[:6]) or f"all roots at {len(looked)} speeds"
    return (compared(name, where, len(faults), 0.0, "stability", text),)


def growth_sign(matrices: PlainMatrices, speed_rad_s: float, least: float) -> int:
    """Return 1 if a motion grows beyond doubt, −1 if none grows, 0 in doubt.

    `least`: Re λ up to this part of |λ| is no growth.
    """
    if is_counted_by_signs(matrices):  # its energy is positive and stays
        return -1
    rates = np.abs(np.diag(matrices.stiffness)) / np.diag(matrices.mass)
    shift = max(float(np.sqrt(np.median(rates))), abs(speed_rad_s), 1.0)
    values = full_spectrum(matrices, shift)
    growing = values[(values.real > least * np.abs(values)) & (values.imag >= 0)]
    clear = growing.real > 10.0 * NEUTRAL * np.abs(growing)
    for value in growing[clear & (np.abs(growing) > _STILL * shift)]:
        found = root_error(matrices, complex(value))
        rounding = ROUNDINGS * found.rounding + 10.0 * found.distance
        if value.real > rounding + 10.0 * NEUTRAL * abs(value):
            return 1
    return 0 if growing.size else -1


class Channel(NamedTuple):
    """A force or moment, or a motion and its time derivative: 0 displacement to 2 acceleration."""

    place: End
    component: str
    derivative: int = 0


def check_transfer(
    plain: PlainSystem,
    model: Callable[[float], tuple[FloatArray, FloatArray, FloatArray, FloatArray]],
    inputs: Sequence[Channel],
    outputs: Sequence[Channel],
    speeds_rad_s: Sequence[float],
    where: str,
) -> Invariant:
    """Check a state space by transfer functions of the system.

    `model`: A, B, C, D of a speed; `inputs`, `outputs`: of the model, in its order.
    """
    into, out_of = (
        np.array([plain.seat(c.place)[MOTIONS.index(c.component)] for c in channels])
        for channels in (inputs, outputs)
    )
    orders = np.array([channel.derivative for channel in outputs])
    misses = []
    for speed in speeds_rad_s:
        a, b, c, d = model(speed)
        matrices = plain.at(speed)
        for rate in (factor * max(speed, 1.0) for factor in _TRANSFER):
            shifted = 1j * rate * np.eye(len(a)) - a
            states = la.solve(shifted, b.astype(complex))
            found, terms = c @ states + d, np.abs(c) @ np.abs(states) + np.abs(d)
            condition = float(np.linalg.cond(shifted))
            factors = (1j * rate) ** orders
            for k, load in enumerate(into):
                moved = motion_under(matrices, rate, load.astype(complex), out_of)
                if moved is None or not moved.amplitude.any():
                    continue
                size = np.abs(factors) * float(np.abs(moved.amplitude).max())
                error = np.abs(factors * moved.amplitude - found[:, k]) / size
                lost = np.abs(factors) * moved.rounding + _EPS * terms[:, k]
                limit = ACCURACY + ROUNDINGS * (_EPS * condition + lost / size)
                worst = int(np.argmax(error / limit))
                misses.append(Miss(float(error[worst]), float(limit[worst]), speed))
    text = f"{len(misses)} transfer functions"
    concerns = "the state space"
    return worst_of("state space is that of the system", where, concerns, misses, text)


def force_balance(
    plain: PlainSystem,
    speed_rad_s: float,
    acceleration_rad_s2: float,
    motion: tuple[FloatArray, FloatArray, FloatArray],
    load: FloatArray,
) -> Miss:
    """Return what is left of the forces on a system at an instant, over the largest of them.

    `speed_rad_s`, `acceleration_rad_s2`: Ω and Ω'; `motion`: q, q', q'' in its coordinates, each
    (n,); `load`: forces on the coordinates of all bodies, shape (N,).
    """
    matrices = plain.at(speed_rad_s)
    place, rate, change = motion
    force = plain.transformation.T @ load
    # ½ Ω' Σ n_i G_i: the gyroscopic part of V per unit speed
    turning = plain.gyroscopic() * 0.5 * acceleration_rad_s2
    left = matrices.mass @ change + matrices.velocity @ rate + matrices.stiffness @ place
    left = left + turning @ place - force
    mass, velocity, stiffness = matrices.sizes
    size = mass @ np.abs(change) + velocity @ np.abs(rate) + stiffness @ np.abs(place)
    size = size + np.abs(turning) @ np.abs(place) + np.abs(plain.transformation.T) @ np.abs(load)
    # in coordinates of unit inertia, so that metres and radians compare
    root = np.sqrt(np.diag(matrices.mass))
    largest = float((size / root).max())
    if largest == 0.0:
        return Miss(0.0, ACCURACY, speed_rad_s)
    return Miss(float((np.abs(left) / root).max()) / largest, ACCURACY, speed_rad_s)
