"""Critical speeds: where a mode is met by an excitation that turns α times per turn of Ω."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.campbell.branches import all_below, follow
from solidwhirl.rotordyn.campbell.continued import continued, turning_point
from solidwhirl.rotordyn.campbell.matching import Tracked, match_modes, mode_columns
from solidwhirl.rotordyn.campbell.places import CREEPING
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.dense import scale_by_stiffness
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.critical_speeds.speed_roots import SpeedRoots, speed_roots
from solidwhirl.rotordyn.critical_speeds.whirl_pencils import (
    DirectSpeeds,
    Pencil,
    direct_speeds,
    negative_count,
    negative_count_at_rest,
    whirl_pencils,
)
from solidwhirl.rotordyn.modes.damping import (
    DampingRule,
    amplification_factor,
    damping_ratio,
    log_decrement,
)
from solidwhirl.rotordyn.modes.eigen import Modes, modes_at_speed, scaled_stiffness
from solidwhirl.rotordyn.modes.whirl import separated_whirl, whirl_direction

# Steps of the search for a damped critical speed, and its relative accuracy.
_ROOT_STEPS = 80
_ROOT_ACCURACY = 1e-12
# A motion that begins below this fraction of the largest speed may begin at rest.
_AT_REST = 1e-6


class _Meeting(NamedTuple):
    """Ω, λ and φ of a mode that meets the excitation."""

    speed: float
    value: complex
    shape: ComplexArray


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class CriticalSpeed(ReadOnlyArrays):
    """Hold one critical speed.

    Attributes
    ----------
    speed_rad_s
        Ω at which a damped natural frequency Im λ equals |α| Ω.
    frequency_hz
        That frequency, |α| Ω / 2π.
    whirl
        "forward", "backward", "mixed" or "planar".
    shape
        Mode in the independent coordinates of the system, shape (n,), complex, largest entry 1.
    log_decrement
        −2π Re λ / Im λ of the mode there; 0 without damping.
    """

    speed_rad_s: float
    frequency_hz: float
    whirl: str
    shape: ComplexArray
    log_decrement: float

    def __repr__(self) -> str:
        rpm = self.speed_rad_s * RPM_PER_RAD_S
        return (
            f"CriticalSpeed: {rpm:.2f} rpm, {self.frequency_hz:.2f} Hz, {self.whirl}, "
            f"log decrement {self.log_decrement:.3g}"
        )

    @property
    def eigenvalue(self) -> complex:
        """λ of the mode there, 1/s."""
        return 2.0 * np.pi * self.frequency_hz * complex(-self.log_decrement / (2.0 * np.pi), 1.0)

    @property
    def amplification_factor(self) -> float:
        """1 / 2ζ of the mode; inf without damping, negative if it grows."""
        return amplification_factor(self.log_decrement)

    def counts(self, rule: DampingRule) -> bool:
        """Tell whether this is a resonance; if not it is critically damped."""
        return bool(rule.counts(np.array([self.eigenvalue]))[0])


@dataclass(frozen=True, kw_only=True)
class CriticalSpeedCount:
    """Hold the number of critical speeds of an undamped system up to a limit.

    `speed_max_rad_s`: the limit, rad/s. `below_at_rest`, `below_at_limit`: number of negative
    eigenvalues of K(Ω) + Ω² (K2 + iαG − α²M) near rest and at the limit. `falls`, `rises`: number
    of critical speeds at which an eigenvalue turns negative, or positive; a constant stiffness has
    the first kind only. `unresolved_rad_s`: intervals in which an eigenvalue touches zero to
    rounding: no critical speed, or two.
    """

    speed_max_rad_s: float
    below_at_rest: int
    below_at_limit: int
    falls: int
    rises: int
    unresolved_rad_s: tuple[tuple[float, float], ...]

    @property
    def count(self) -> int:
        """Number of critical speeds."""
        return self.falls + self.rises


def critical_speeds(
    assembled: AssembledSystem,
    excitation_ratio: float = 1.0,
    speed_max_rad_s: float | None = None,
) -> tuple[CriticalSpeed, ...]:
    """Compute the critical speeds of a system.

    `excitation_ratio`: α: frequency of the excitation over Ω, such as the speed ratio of the shaft
    that carries the unbalance, or the order of a harmonic. Its sign does not matter, as modes of
    either whirl are returned. `speed_max_rad_s`: leave out what lies above; None is the range the
    bodies were made for (no limit for beams). A system with damping, an unsymmetric stiffness or
    bearings that depend on the speed needs a finite limit. They come by rising speed. Raises
    AnalysisError if the ratio is zero or not finite, or a limit is needed and missing.

    Without damping, ω = αΩ turns the problem into [K + Ω² (K2 + iαG − α²M)] φ = 0, Hermitian and,
    for constant bearings, linear in Ω²; no speed is swept (Genta 2005, Dynamics of Rotating
    Systems, section 4.6). An eigenvalue Ω² that is negative or infinite belongs to no speed: the
    mode stiffens faster with the spin than the excitation rises (a thin disk, Ip > Id, whirling
    forward). With bearings K(Ω) the speeds at which an eigenvalue of that matrix changes its sign
    are found by counting negative eigenvalues, all of them (see `speed_roots`); one mode may have
    several critical speeds. An isotropic system is solved for forward and backward whirl apart.

    With damping, the branches are followed from rest and Im λ(Ω) = αΩ is solved on each; steps
    begin and end at the critical speeds without damping and the knots of speed laws. Motions that
    creep, of a damping ratio above 0.995, are left out.
    """
    ratio, limit = checked_excitation(assembled, excitation_ratio, speed_max_rad_s)
    if _is_undamped_problem(assembled):
        speeds, shapes = _undamped(assembled, ratio, limit)
        decrements = np.zeros(speeds.size)
    elif np.isfinite(limit):
        speeds, shapes, decrements = _damped(assembled, ratio, limit)
    else:
        raise AnalysisError(
            "speed_max_rad_s is needed: this system has damping, an unsymmetric or a negative "
            "stiffness, and its branches are followed up to a finite speed"
        )
    directions = whirl_direction(assembled, shapes)
    return tuple(
        CriticalSpeed(
            speed_rad_s=float(speed),
            frequency_hz=float(ratio * speed / (2.0 * np.pi)),
            whirl=str(whirl),
            shape=shape / shape[np.abs(shape).argmax()],
            log_decrement=float(decrement),
        )
        for speed, shape, decrement, whirl in zip(
            speeds, shapes.T, decrements, directions, strict=True
        )
    )


def count_critical_speeds(
    assembled: AssembledSystem,
    excitation_ratio: float = 1.0,
    speed_max_rad_s: float | None = None,
) -> CriticalSpeedCount:
    """Count the critical speeds of a system without damping by the signs of its eigenvalues.

    `assembled`: the system; damping is left out; `excitation_ratio`, `speed_max_rad_s`: as for
    `critical_speeds`; the limit must be finite. For constant bearings from the matrices at rest and
    at the limit only, so that it certifies the list of `critical_speeds` independently. Raises
    AnalysisError if the ratio is zero or not finite, the limit is not finite, or the constant part
    of the stiffness is negative.
    """
    ratio, limit = checked_excitation(assembled, excitation_ratio, speed_max_rad_s)
    if not np.isfinite(limit):
        raise AnalysisError("speed_max_rad_s is needed: critical speeds are counted up to it")
    at_rest = at_limit = falls = rises = 0
    unresolved: list[tuple[float, float]] = []
    for pencil in whirl_pencils(assembled, ratio):
        if pencil.laws:
            roots = speed_roots(pencil, assembled.body_rate, limit)
            counts = roots.counts
            falls += int(np.count_nonzero(roots.falls))
            rises += int(np.count_nonzero(~roots.falls))
            unresolved += roots.unresolved
        else:
            counts = (
                negative_count_at_rest(pencil, assembled.body_rate),
                negative_count(pencil, limit, assembled.body_rate),
            )
            # K/Ω² − N of a constant K falls with Ω, so no eigenvalue comes back.
            falls += counts[1] - counts[0]
        at_rest += counts[0]
        at_limit += counts[1]
    return CriticalSpeedCount(
        speed_max_rad_s=limit,
        below_at_rest=at_rest,
        below_at_limit=at_limit,
        falls=falls,
        rises=rises,
        unresolved_rad_s=tuple(unresolved),
    )


def checked_excitation(
    assembled: AssembledSystem, excitation_ratio: float, speed_max_rad_s: float | None
) -> tuple[float, float]:
    """Return |α| and the limit."""
    ratio = abs(float(excitation_ratio))
    if not np.isfinite(ratio) or ratio == 0:
        raise AnalysisError(f"excitation_ratio is {excitation_ratio}; finite and not 0 is allowed")
    limit = assembled.speed_limit_rad_s if speed_max_rad_s is None else float(speed_max_rad_s)
    if not limit > 0:
        raise AnalysisError(f"speed_max_rad_s is {speed_max_rad_s}; it must be positive")
    return ratio, limit


def _is_undamped_problem(assembled: AssembledSystem) -> bool:
    """Whether there is no damping, and no negative stiffness but that of a speed law."""
    constant = scale_by_stiffness(assembled.stiffness, assembled.mass, assembled.body_rate)
    return assembled.is_conservative and constant.negative_count == 0


def _undamped(
    assembled: AssembledSystem, ratio: float, limit: float
) -> tuple[FloatArray, ComplexArray]:
    """Return the critical speeds and shapes without damping, by rising speed."""
    speeds, shapes = [], []
    for pencil in whirl_pencils(assembled, ratio):
        found = _speeds_of(pencil, assembled.body_rate, limit)
        speeds.append(found.speeds_rad_s)
        shapes.append(pencil.expand(found.shapes))
    together, columns = np.concatenate(speeds), np.hstack(shapes)
    order = np.argsort(together, kind="stable")
    return together[order], separated_whirl(assembled, together[order], columns[:, order])


def _speeds_of(pencil: Pencil, body_rate: float, limit: float) -> DirectSpeeds | SpeedRoots:
    if not pencil.laws:
        return direct_speeds(pencil, pencil.stiffness, body_rate, limit)
    if not np.isfinite(limit):
        raise AnalysisError(
            "speed_max_rad_s is needed: bearings depend on the speed, and critical speeds are "
            "searched for up to a finite one"
        )
    return speed_roots(pencil, body_rate, limit)


def undamped_places(assembled: AssembledSystem, ratio: float, limit: float) -> FloatArray:
    """Return the critical speeds without damping and skew stiffness, and where modes touch.

    Where a mode touches the excitation without them it may cross it twice.

    `ratio`, `limit`: |α| and the largest Ω, finite. Returns Ω, rising. None if K is negative, or
    the pieces of a law are not known.
    """
    if any(joint.pieces is None for joint in assembled.law_joints):
        return np.empty(0)
    start = matrices_at_speed(assembled, 0.0)
    for matrices in (start, start._replace(stiffness=assembled.stiffness)):
        if scaled_stiffness(assembled, matrices).negative_count:
            return np.empty(0)
    seeds = []
    for pencil in whirl_pencils(assembled, ratio):
        found = _speeds_of(pencil, assembled.body_rate, limit)
        seeds.append(found.speeds_rad_s)
        if isinstance(found, SpeedRoots):
            seeds.append(np.array([0.5 * (low + high) for low, high in found.unresolved]))
    return np.sort(np.concatenate(seeds))


def _damped(
    assembled: AssembledSystem, ratio: float, limit: float
) -> tuple[FloatArray, ComplexArray, FloatArray]:
    """Follow the branches from rest and solve Im λ(Ω) = αΩ where one meets the line."""
    seeds = undamped_places(assembled, ratio, limit)
    inner = np.concatenate((seeds, assembled.knots_rad_s))
    marks = np.unique(np.concatenate(([0.0], inner[(inner > 0) & (inner < limit)], [limit])))
    marks = marks[np.concatenate(([True], np.diff(marks) > 1e-6 * limit))]
    speeds = np.unique(np.concatenate((marks, 0.5 * (marks[1:] + marks[:-1]), [limit])))
    at_speeds = follow(assembled, speeds, all_below(assembled, ratio * limit / (2.0 * np.pi)))
    found = _meetings(assembled, at_speeds, ratio)
    found.sort(key=lambda item: item.speed)
    # Im λ = αΩ here but for rounding, which is no small part of it where Re λ is far larger
    values = np.array([complex(m.value.real, ratio * m.speed) for m in found], dtype=complex)
    shapes = np.array([item.shape for item in found], dtype=complex).reshape(-1, assembled.size)
    return np.array([item.speed for item in found]), shapes.T, log_decrement(values)


def _meetings(
    assembled: AssembledSystem, at_speeds: Sequence[Tracked], ratio: float
) -> list[_Meeting]:
    """Return where branches meet the line."""
    found, least = [], _AT_REST * max(abs(at_speed.modes.speed_rad_s) for at_speed in at_speeds)
    for before, after in pairwise(at_speeds):
        for branch in range(before.columns.size):
            ends = _ends(assembled, before, after, branch, least)
            if ends is not None:
                miss = [_miss(modes, ratio) for modes in ends]
                if miss[0] > 0 >= miss[1] or miss[0] < 0 <= miss[1]:
                    found.append(_solve_on_branch(assembled, *ends, ratio))
    return [m for m in found if m is not None and not _creeps(np.array([m.value]))]


def _creeps(values: ComplexArray) -> bool:
    return bool((damping_ratio(values) > CREEPING).all())


def _ends(
    assembled: AssembledSystem, before: Tracked, after: Tracked, branch: int, least: float
) -> tuple[Modes, Modes] | None:
    """Return one branch at two speeds, or from where it begins or to where it ends in between.

    `least`: what begins below that speed is not told from what the spin lifts from rest. None for
    what creeps at both.
    """
    sides = [
        mode_columns(at_speed.modes, at_speed.columns[[branch]])
        if at_speed.columns[branch] >= 0
        else None
        for at_speed in (before, after)
    ]
    low, high = sides
    if all(side is None or _creeps(side.eigenvalues) for side in sides):
        return None
    if low is not None and high is not None:
        return low, high
    begin, end = before.modes.speed_rad_s, after.modes.speed_rad_s
    pairs = before.modes.real_eigenvalues.size - after.modes.real_eigenvalues.size
    if end <= least:
        return None
    if high is not None and pairs > 0:
        return turning_point(assembled, high, begin), high
    return (low, turning_point(assembled, low, end)) if low is not None and pairs < 0 else None


def _miss(mode: Modes, ratio: float) -> float:
    return float(mode.eigenvalues[0].imag - ratio * mode.speed_rad_s)


def _solve_on_branch(
    assembled: AssembledSystem, low: Modes, high: Modes, ratio: float
) -> _Meeting | None:
    """Return Ω, λ and φ where a branch meets the line between two speeds (Illinois method).

    None for an overdamped motion that ceases to oscillate on the way.
    """
    miss_low, miss_high = _miss(low, ratio), _miss(high, ratio)
    nearest = low
    for _ in range(_ROOT_STEPS):
        begin, end = low.speed_rad_s, high.speed_rad_s
        speed = begin - miss_low * (end - begin) / (miss_high - miss_low)
        found = continued(assembled, low, high, speed)
        found = found or _in_the_whole_spectrum(assembled, low, high, speed)
        if found is None:
            return None
        nearest, miss = found, _miss(found, ratio)
        if abs(miss) <= _ROOT_ACCURACY * ratio * speed or abs(end - begin) <= 1e-14 * end:
            break
        if miss * miss_high < 0:
            low, miss_low = high, miss_high
        else:
            miss_low *= 0.5
        high, miss_high = nearest, miss
    return _Meeting(nearest.speed_rad_s, complex(nearest.eigenvalues[0]), nearest.shapes[:, 0])


def _in_the_whole_spectrum(
    assembled: AssembledSystem, low: Modes, high: Modes, speed: float
) -> Modes | None:
    """Return one branch at a speed between two, from the nearer one."""
    distances = [abs(modes.speed_rad_s - speed) for modes in (low, high)]
    here = low if distances[0] <= distances[1] else high
    match = match_modes(assembled, here, modes_at_speed(assembled, speed))
    if match.partner[0] < 0:
        if _creeps(here.eigenvalues):
            return None
        raise AnalysisError(
            f"the branch at {here.speed_rad_s:.6g} rad/s has no partner at {speed:.6g} rad/s"
        )
    return mode_columns(match.second, match.partner)
