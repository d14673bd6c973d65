"""Periodic motion by harmonic balance, forces taken in time and balanced by frequency.

Unknown are the Fourier coefficients of the relative motion at the nonlinear joints alone, real,
shape (2h + 1, 2j): constant, cos θ, sin θ, cos 2θ, and so on, θ = ω t (Cameron and Griffin 1989,
Journal of Applied Mechanics 56; Krack and Gross 2019, Harmonic Balance for Nonlinear Vibration
Problems).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.nonlinear.forced_system import Condensed, ForcedSystem, condensed
from solidwhirl.rotordyn.nonlinear.forces import ForceSamples

# Samples of a period: at least, and per harmonic.
_SAMPLES, _PER_HARMONIC = 512, 16
_MOST_STEPS, _SHORTENED = 14, 6
# A correction, relative to the motion, at which Newton's method has converged.
_CONVERGED = 1e-11
_TINY = float(np.finfo(float).tiny)


class Fourier(NamedTuple):
    """Matrices between coefficients and samples of a period.

    `values`, `slopes`: motion and its derivative by θ at t samples, shape (t, 2h + 1);
    `coefficients`: back from samples, (2h + 1, t).
    """

    values: FloatArray
    slopes: FloatArray
    coefficients: FloatArray


class Balance(NamedTuple):
    """What is out of balance at the joints, as motion, and its derivatives.

    `residual_m`: shape (u,), u = 2j (2h + 1); `by_motion`: (u, u); `by_parameter`: (u,);
    `force_n`: coefficients of the joint forces beyond the shift, complex, shape (h + 1, 2j).
    """

    residual_m: FloatArray
    by_motion: FloatArray
    by_parameter: FloatArray
    force_n: ComplexArray


#: What is out of balance in a motion (2h + 1, 2j) at a parameter.
Equations = Callable[[FloatArray, float], Balance]

#: A motion (2h + 1, 2j) and a parameter next to some in balance.
Guess = tuple[FloatArray, float]


class Point(NamedTuple):
    """A motion (2h + 1, 2j) in balance at a parameter, derivatives there, and corrections made."""

    motion_m: FloatArray
    parameter: float
    balance: Balance
    corrections: int


def series_at(angle_rad: FloatArray, harmonics: int) -> tuple[FloatArray, FloatArray]:
    """Return a motion and its derivative at angles (t,) per coefficient, shape (t, 2h + 1)."""
    order = np.arange(1, harmonics + 1)
    turn = np.outer(angle_rad, order)
    values = np.ones((angle_rad.size, 2 * harmonics + 1))
    slopes = np.zeros_like(values)
    values[:, 1::2], values[:, 2::2] = np.cos(turn), np.sin(turn)
    slopes[:, 1::2], slopes[:, 2::2] = -order * np.sin(turn), order * np.cos(turn)
    return values, slopes


@lru_cache(maxsize=8)
def fourier(harmonics: int) -> Fourier:
    """Return the matrices of a number of harmonics."""
    count = max(_SAMPLES, 1 << int(np.ceil(np.log2(_PER_HARMONIC * (harmonics + 1)))))
    return fourier_of(count, harmonics)


def fourier_of(count: int, harmonics: int) -> Fourier:
    """Return the matrices of a number of samples and of harmonics."""
    values, slopes = series_at(2.0 * np.pi * np.arange(count) / count, harmonics)
    back = 2.0 / count * values.T
    back[0] *= 0.5
    return Fourier(values, slopes, back)


def as_complex(coefficients: FloatArray) -> ComplexArray:
    """Return amplitudes of e^{ikθ} from real coefficients, (h + 1, ...) from (2h + 1, ...)."""
    upper = coefficients[1::2] - 1j * coefficients[2::2]
    return np.concatenate((coefficients[:1] + 0j, upper))


def as_real(amplitudes: ComplexArray) -> FloatArray:
    """Return real coefficients from amplitudes of e^{ikθ}, (2h + 1, ...) from (h + 1, ...)."""
    found = np.empty((2 * len(amplitudes) - 1, *amplitudes.shape[1:]))
    found[0], found[1::2], found[2::2] = (
        amplitudes[0].real,
        amplitudes[1:].real,
        -amplitudes[1:].imag,
    )
    return found


def with_harmonics(motion_m: FloatArray, harmonics: int) -> FloatArray:
    """Return the coefficients of a motion with more harmonics, which are zero, or fewer."""
    found = np.zeros((2 * harmonics + 1, motion_m.shape[1]))
    kept = min(len(found), len(motion_m))
    found[:kept] = motion_m[:kept]
    return found


def gaps(one_m: FloatArray, other_m: FloatArray, turns: int = 1) -> FloatArray:
    """Return how far two motions are apart, over the size of the first, shape (turns,).

    The first begins 0, 1, ... turns of the unbalance later; they repeat after `turns`. It has as
    many harmonics as the other or fewer.
    """
    one, other = as_complex(with_harmonics(one_m, len(other_m) // 2)), as_complex(other_m)
    phase = np.exp(2j * np.pi / turns * np.outer(np.arange(turns), np.arange(len(one))))
    return np.asarray(la.norm(phase[:, :, None] * one - other, axis=(1, 2)) / la.norm(one))


def joint_samples(
    forced: ForcedSystem, displacement_m: FloatArray, velocity_m_per_s: FloatArray
) -> list[ForceSamples]:
    """Return the force of each joint at samples (t, 2j) of the relative motion."""
    pairs = (slice(2 * k, 2 * k + 2) for k in range(len(forced.forces)))
    return [
        force.at(displacement_m[:, at], velocity_m_per_s[:, at])
        for force, at in zip(forced.forces, pairs, strict=True)
    ]


def balance(forced: ForcedSystem, motion_m: FloatArray, speed_rad_s: float) -> Balance:
    """Return what is out of balance in a motion (2h + 1, 2j); the parameter is the speed."""
    harmonics = len(motion_m) // 2
    part = condensed(forced, speed_rad_s, harmonics, forced.motion)
    return _balanced(forced, motion_m, speed_rad_s, part)


def over_load(forced: ForcedSystem, speed_rad_s: float, harmonics: int) -> Equations:
    """Return what is out of balance at a speed under sinh p times the loads; p is the parameter."""
    part = condensed(forced, speed_rad_s, harmonics, forced.motion)

    def at(motion_m: FloatArray, parameter: float) -> Balance:
        loaded = part._replace(free_m=np.sinh(parameter) * part.free_m)
        rise = -np.cosh(parameter) * as_real(part.free_m).ravel()
        return _balanced(forced, motion_m, speed_rad_s, loaded)._replace(by_parameter=rise)

    return at


def _balanced(
    forced: ForcedSystem, motion_m: FloatArray, speed_rad_s: float, part: Condensed
) -> Balance:
    count, width = motion_m.shape
    series, omega = fourier(count // 2), forced.frequency_ratio * speed_rad_s
    turned = series.slopes @ motion_m
    samples = joint_samples(forced, series.values @ motion_m, omega * turned)
    force = np.zeros((count, width))
    slope, by_speed = np.zeros((count, width, count, width)), np.zeros((count, width))
    for k, found in enumerate(samples):
        at = slice(2 * k, 2 * k + 2)
        force[:, at] = series.coefficients @ found.force_n
        slope[:, at, :, at] = _by_coefficients(series, found, omega)
        pushed = np.einsum("tij,tj->ti", found.damping_n_s_per_m, turned[:, at])
        by_speed[:, at] = forced.frequency_ratio * (series.coefficients @ pushed)
    shifts = forced.shifts(count // 2)[:, None]
    beyond = as_complex(force) - shifts * as_complex(motion_m)
    pushed = np.einsum("kij,kj->ki", part.receptance, beyond)
    by_speed_m = (
        -part.free_slope
        + np.einsum("kij,kj->ki", part.receptance_slope, beyond)
        + np.einsum("kij,kj->ki", part.receptance, as_complex(by_speed))
    )
    eye = np.broadcast_to(np.eye(width), part.receptance.shape)
    added = _real_blocks(shifts[:, :, None] * eye)
    joined = slope.reshape(count * width, -1) - added
    return Balance(
        residual_m=(motion_m + as_real(pushed - part.free_m)).ravel(),
        by_motion=np.eye(count * width) + _real_blocks(part.receptance) @ joined,
        by_parameter=as_real(by_speed_m).ravel(),
        force_n=beyond,
    )


def _by_coefficients(series: Fourier, found: ForceSamples, omega: float) -> FloatArray:
    """Derivatives of force coefficients by motion coefficients, (2h + 1, 2, 2h + 1, 2)."""
    count = len(series.coefficients)
    out = np.empty((count, 2, count, 2))
    for i in range(2):
        for j in range(2):
            moved = found.stiffness_n_per_m[:, i, j, None] * series.values
            moved = moved + omega * found.damping_n_s_per_m[:, i, j, None] * series.slopes
            out[:, i, :, j] = series.coefficients @ moved
    return out


def _real_blocks(factors: ComplexArray) -> FloatArray:
    """Return complex factors (h + 1, d, d) of amplitudes as a real matrix on coefficients."""
    harmonics, d = len(factors) - 1, factors.shape[1]
    out = np.zeros((2 * harmonics + 1, d, 2 * harmonics + 1, d))
    out[0, :, 0] = factors[0].real
    for k, factor in enumerate(factors[1:], start=1):
        c, s = 2 * k - 1, 2 * k
        out[c, :, c] = out[s, :, s] = factor.real
        out[c, :, s], out[s, :, c] = factor.imag, -factor.imag
    return out.reshape(d * (2 * harmonics + 1), -1)


def corrected(
    equations: Equations,
    guess: Guess,
    row: tuple[FloatArray, float],
    length_m: float,
) -> Point | None:
    """Correct a motion and a parameter until all is in balance; None if that fails.

    `guess`: motion (2h + 1, 2j) and parameter; `row`: of one more condition, that corrections are
    perpendicular to it: shape (u,) per m, and per unit of the parameter. `length_m`: size of
    motions. Newton's method, with steps shortened where they do not bring balance nearer.
    """
    motion, parameter = guess[0].copy(), float(guess[1])
    found = equations(motion, parameter)
    if not np.isfinite(found.residual_m).all():
        return None
    for count in range(_MOST_STEPS):
        whole = np.block([[found.by_motion, found.by_parameter[:, None]], [row[0][None], row[1]]])
        # parameters in units in which they move as much
        unit = length_m / (float(la.norm(found.by_parameter)) + _TINY)
        whole[:, -1] *= unit
        whole[-1] /= float(la.norm(whole[-1])) + _TINY
        try:
            step = np.linalg.solve(whole, np.append(-found.residual_m, 0.0))
        except np.linalg.LinAlgError:
            return None
        if not np.isfinite(step).all():
            return None
        size, part = float(la.norm(found.residual_m)), 1.0
        for _ in range(_SHORTENED):
            moved = motion + part * step[:-1].reshape(motion.shape)
            further = parameter + part * unit * step[-1]
            tried = equations(moved, further)
            if np.isfinite(tried.residual_m).all() and (
                la.norm(tried.residual_m) <= max(size, _CONVERGED * length_m)
            ):
                break
            part *= 0.5
        else:  # rounding may be all that is left
            is_near = size <= 1e3 * _CONVERGED * length_m
            return Point(motion, parameter, found, count) if is_near else None
        motion, parameter, found = moved, further, tried
        if part == 1.0 and la.norm(step[:-1]) <= 1e3 * _CONVERGED * length_m:
            return Point(motion, parameter, found, count + 1)
        if la.norm(found.residual_m) <= _CONVERGED * length_m:
            return Point(motion, parameter, found, count + 1)
    return None


def at_parameter(equations: Equations, motion_m: FloatArray, parameter: float) -> Point | None:
    """Return the motion in balance at a parameter near a guess (2h + 1, 2j); None if none."""
    length = max(float(np.abs(motion_m).max()), 1e-12)
    return corrected(equations, (motion_m, parameter), (np.zeros(motion_m.size), 1.0), length)


def at_speed(forced: ForcedSystem, motion_m: FloatArray, speed_rad_s: float) -> Point | None:
    """Return the motion in balance at a speed near a guess (2h + 1, 2j); None if none is found."""
    return at_parameter(partial(balance, forced), motion_m, speed_rad_s)
