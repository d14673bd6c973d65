"""Critical speeds: where a mode is met by an excitation that turns α times per turn of Ω."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.arrays import ComplexArray, FloatArray, freeze_arrays
from solidwhirl.rotordyn.branches import follow_below, untracked_below
from solidwhirl.rotordyn.eigen import log_decrement, modes_at_speed, scaled_stiffness
from solidwhirl.rotordyn.errors import AnalysisError
from solidwhirl.rotordyn.spectrum import Scaled
from solidwhirl.rotordyn.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.tracking import Front, match_modes
from solidwhirl.rotordyn.whirl import interface_orbits, whirl_direction

# Critical speeds closer than this (relative) share a subspace.
_SAME_SPEED = 1e-8
# Where branches begin if there are rigid motions at rest, as a fraction of the limit.
_JUST_ABOVE_REST = 1e-3
# Steps of the search for a damped critical speed, and its relative accuracy.
_ROOT_STEPS = 80
_ROOT_ACCURACY = 1e-12
# Two searches that end closer than this (relative) found the same critical speed.
_SAME_ROOT = 1e-7


class _Meeting(NamedTuple):
    """Ω, λ and φ of a mode that meets the excitation."""

    speed: float
    value: complex
    shape: ComplexArray


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class CriticalSpeed:
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

    def __post_init__(self) -> None:
        freeze_arrays(self, "shape")


def critical_speeds(
    assembled: AssembledSystem,
    excitation_ratio: float = 1.0,
    speed_max_rad_s: float | None = None,
) -> tuple[CriticalSpeed, ...]:
    """Compute the critical speeds of a system with constant bearings.

    Parameters
    ----------
    assembled
        The system.
    excitation_ratio
        α: frequency of the excitation over Ω, such as the speed ratio of the shaft that carries
        the unbalance, or the order of a harmonic. Its sign does not matter, as modes of either
        whirl are returned.
    speed_max_rad_s
        Leave out what lies above; None is the range the bodies were made for (no limit for
        beams). A system with damping or an unsymmetric stiffness needs a finite limit.

    Returns
    -------
    tuple of CriticalSpeed
        By rising speed.

    Raises
    ------
    AnalysisError
        If the ratio is zero or not finite, or a limit is needed and missing.

    Notes
    -----
    Without damping, ω = αΩ turns the problem into [K + Ω² (K2 + iαG − α²M)] φ = 0, Hermitian and
    linear in Ω²; no speed is swept (Genta 2005, Dynamics of Rotating Systems, section 4.6). An
    eigenvalue Ω² that is negative or infinite belongs to no speed: the mode stiffens faster with
    the spin than the excitation rises (a thin disk, Ip > Id, whirling forward). With damping, the
    branches are followed from rest and Im λ(Ω) = αΩ is solved on each.
    """
    ratio = abs(float(excitation_ratio))
    if not np.isfinite(ratio) or ratio == 0:
        raise AnalysisError(f"excitation_ratio is {excitation_ratio}; finite and not 0 is allowed")
    limit = assembled.speed_limit_rad_s if speed_max_rad_s is None else float(speed_max_rad_s)
    if not limit > 0:
        raise AnalysisError(f"speed_max_rad_s is {speed_max_rad_s}; it must be positive")
    scaled = scaled_stiffness(assembled, matrices_at_speed(assembled, 0.0))
    if assembled.is_conservative and scaled.negative_count == 0:
        speeds, shapes = _undamped(assembled, scaled, ratio, limit)
        decrements = np.zeros(speeds.size)
    elif np.isfinite(limit):
        speeds, shapes, decrements = _damped(assembled, scaled, ratio, limit)
    else:
        raise AnalysisError(
            "speed_max_rad_s is needed: this system has damping, an unsymmetric or a negative "
            "stiffness, and its branches are followed up to a finite speed"
        )
    directions = whirl_direction(assembled, shapes)
    return tuple(
        CriticalSpeed(
            speed_rad_s=float(speeds[k]),
            frequency_hz=float(ratio * speeds[k] / (2.0 * np.pi)),
            whirl=str(directions[k]),
            shape=shapes[:, k] / shapes[np.abs(shapes[:, k]).argmax(), k],
            log_decrement=float(decrements[k]),
        )
        for k in range(speeds.size)
    )


def _undamped(
    assembled: AssembledSystem, scaled: Scaled, ratio: float, limit: float
) -> tuple[FloatArray, ComplexArray]:
    """Solve K φ = Ω² N φ, N = α²M − iαG − K2, with K positive (semi)definite.

    Motions without stiffness (kernel of K) follow from the rest: N_kk a + N_kc c = 0.
    """
    moving: ComplexArray = ratio**2 * assembled.mass - 1j * ratio * assembled.gyroscopic
    moving = moving - assembled.centrifugal_stiffness
    inertia: ComplexArray = scaled.scale[:, None] * moving * scaled.scale
    stiff = slice(scaled.zero_count, None)
    # Cholesky of the scaled K keeps more digits than its eigenvectors where it exists.
    if scaled.is_definite:
        lower = la.cholesky(scaled.stiffness, lower=True)
        basis = la.solve_triangular(lower, np.eye(scaled.scale.size), lower=True, trans="T")
    else:
        kernel = scaled.vectors[:, : scaled.zero_count]
        elastic = scaled.vectors[:, stiff] / np.sqrt(scaled.eigenvalues[stiff])
        basis = elastic - kernel @ _kernel_motion(inertia, kernel, elastic)
    reduced = basis.conj().T @ inertia @ basis
    values, vectors = la.eigh(0.5 * (reduced + reduced.conj().T))
    smallest = 64.0 * values.size * np.finfo(float).eps * np.abs(values).max(initial=0.0)
    kept = np.flatnonzero(values > max(smallest, 1.0 / limit**2))[::-1]
    speeds = 1.0 / np.sqrt(values[kept])
    shapes = scaled.scale[:, None] * (basis @ vectors[:, kept])
    return speeds, _separated_whirl(assembled, speeds, shapes)


def _kernel_motion(inertia: ComplexArray, kernel: FloatArray, basis: FloatArray) -> ComplexArray:
    """Return N_kk⁻¹ N_kc, the motion without stiffness that goes with each other one."""
    free = kernel.T @ inertia @ kernel
    size = np.abs(la.eigvalsh(free))
    if size.min() < 1e-10 * size.max():
        raise AnalysisError(
            "a free body whirls at this excitation ratio without any force (polar over diametral "
            "inertia equals the ratio), so every speed is critical; support its tilt"
        )
    return np.asarray(la.solve(free, kernel.T @ inertia @ basis))


def _separated_whirl(
    assembled: AssembledSystem, speeds: FloatArray, shapes: ComplexArray
) -> ComplexArray:
    """Turn the modes of equal critical speeds into the most backward and most forward ones."""
    result = shapes.astype(complex)
    start = 0
    for stop in range(1, speeds.size + 1):
        if stop < speeds.size and speeds[stop] - speeds[stop - 1] <= _SAME_SPEED * speeds[stop]:
            continue
        if stop - start > 1:
            group = result[:, start:stop]
            orbits = interface_orbits(assembled, group)
            forward, backward = orbits.x + 1j * orbits.y, orbits.x - 1j * orbits.y
            turning: ComplexArray = forward.conj().T @ forward - backward.conj().T @ backward
            result[:, start:stop] = group @ la.eigh(turning)[1]
        start = stop
    return result


def _damped(
    assembled: AssembledSystem, scaled: Scaled, ratio: float, limit: float
) -> tuple[FloatArray, ComplexArray, FloatArray]:
    """Follow the branches from rest and solve Im λ(Ω) = αΩ where one meets the line."""
    seeds = np.empty(0)
    if scaled.negative_count == 0:
        seeds, _ = _undamped(assembled, scaled, ratio, limit)
    # A motion that is rigid at rest may be a mode at any speed (nutation), so begin just above.
    start = _JUST_ABOVE_REST * limit if scaled.zero_count else 0.0
    marks = np.unique(np.concatenate(([start], seeds[seeds > start], [limit])))
    marks = marks[np.concatenate(([True], np.diff(marks) > 1e-6 * limit))]
    speeds = np.unique(np.concatenate((marks, 0.5 * (marks[1:] + marks[:-1]), [limit])))
    highest = ratio * limit / (2.0 * np.pi)
    fronts = follow_below(assembled, speeds, highest)
    found = _meetings(assembled, fronts, ratio)
    if untracked_below(fronts, highest):
        # Modes that are overdamped at rest have a branch from the other end.
        down = follow_below(assembled, speeds[::-1], highest)[::-1]
        known = [item.speed for item in found]
        found += [
            item
            for item in _meetings(assembled, down, ratio)
            if not np.isclose(item.speed, known, rtol=_SAME_ROOT, atol=0.0).any()
        ]
    found.sort(key=lambda item: item.speed)
    values = np.array([item.value for item in found], dtype=complex)
    shapes = np.array([item.shape for item in found], dtype=complex).reshape(-1, assembled.size)
    return np.array([item.speed for item in found]), shapes.T, log_decrement(values)


def _meetings(assembled: AssembledSystem, fronts: Sequence[Front], ratio: float) -> list[_Meeting]:
    """Return where branches meet the line, by rising speed of the fronts."""
    found = []
    for before, after in pairwise(fronts):
        for branch in range(before.columns.size):
            if before.columns[branch] >= 0 and after.columns[branch] >= 0:
                miss = [_miss(front, branch, ratio) for front in (before, after)]
                if miss[0] > 0 >= miss[1] or miss[0] < 0 <= miss[1]:
                    found.append(_solve_on_branch(assembled, before, after, branch, ratio))
    return found


def _miss(front: Front, branch: int, ratio: float) -> float:
    return float(front.values()[branch].imag - ratio * front.modes.speed_rad_s)


def _solve_on_branch(
    assembled: AssembledSystem, before: Front, after: Front, branch: int, ratio: float
) -> _Meeting:
    """Return Ω, λ and φ where a branch meets the line between two fronts (Illinois method)."""
    low, high = before.select(np.array([branch])), after.select(np.array([branch]))
    miss_low, miss_high = _miss(low, 0, ratio), _miss(high, 0, ratio)
    nearest = low
    for _ in range(_ROOT_STEPS):
        begin, end = low.modes.speed_rad_s, high.modes.speed_rad_s
        speed = begin - miss_low * (end - begin) / (miss_high - miss_low)
        nearest = _front_at(assembled, low, high, speed)
        miss = _miss(nearest, 0, ratio)
        if abs(miss) <= _ROOT_ACCURACY * ratio * speed or abs(end - begin) <= 1e-14 * end:
            break
        if miss * miss_high < 0:
            low, miss_low = high, miss_high
        else:
            miss_low *= 0.5
        high, miss_high = nearest, miss
    column = int(nearest.columns[0])
    value = complex(nearest.modes.eigenvalues[column])
    return _Meeting(nearest.modes.speed_rad_s, value, nearest.modes.shapes[:, column])


def _front_at(assembled: AssembledSystem, low: Front, high: Front, speed: float) -> Front:
    """Return the one branch of two fronts at a speed between them, from the nearer one."""
    distances = [abs(front.modes.speed_rad_s - speed) for front in (low, high)]
    here = low if distances[0] <= distances[1] else high
    match = match_modes(assembled, here.modes, modes_at_speed(assembled, speed))
    column = match.partner[here.columns]
    if (column < 0).any():
        raise AnalysisError(
            f"the branch at {here.modes.speed_rad_s:.6g} rad/s has no partner at {speed:.6g} rad/s"
        )
    return Front(modes=match.second, columns=column, overlap=match.likeness[here.columns])
