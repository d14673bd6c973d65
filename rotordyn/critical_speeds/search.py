"""Critical speeds: where a mode is met by an excitation that turns α times per turn of Ω."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem, at_whirl_ratio
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, ReadOnlyArrays
from solidwhirl.rotordyn.core.dense import scale_by_stiffness
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.critical_speeds.met import met_by_excitation
from solidwhirl.rotordyn.critical_speeds.speed_roots import speed_roots
from solidwhirl.rotordyn.critical_speeds.undamped import undamped_critical_speeds
from solidwhirl.rotordyn.critical_speeds.whirl_pencils import (
    negative_count,
    negative_count_at_rest,
    scaled_at,
    separate_pencils,
)
from solidwhirl.rotordyn.modes.damping import DampingRule, amplification_factor, log_decrement
from solidwhirl.rotordyn.modes.kinds import kinds
from solidwhirl.rotordyn.modes.whirl import motion_of, separated_whirl

# Systems and ratios whose critical speeds are kept: analyses ask for the same ones. Limits that are
# closer than this (relative) are one.
_KEPT, _ROUNDING = 8, 1e-12


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
        "forward", "backward", "mixed" or "straight" of lateral motion, else the kind.
    shares
        Of the kinetic energy by family: lateral, torsional, axial, disk, shape (4,).
    shape
        Mode in the independent coordinates of the system, shape (n,), complex, largest entry 1.
    log_decrement
        −2π Re λ / Im λ of the mode there; 0 without damping.
    """

    speed_rad_s: float
    frequency_hz: float
    whirl: str
    shares: FloatArray
    shape: ComplexArray
    log_decrement: float

    def __repr__(self) -> str:
        rpm = self.speed_rad_s * RPM_PER_RAD_S
        return (
            f"CriticalSpeed: {rpm:.2f} rpm, {self.frequency_hz:.2f} Hz, {self.whirl}, "
            f"log decrement {self.log_decrement:.3g}"
        )

    @property
    def kind(self) -> str:
        """Lateral, torsional, axial, disk or coupled."""
        return str(kinds(self.shares))

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

    With damping all roots are followed over the speed and Im λ(Ω) = αΩ is solved on their paths;
    the roots above the excitation at the ends of each step tell how many meet it in between.
    Bearings that depend on the frequency are read at αΩ, which is that of the mode, so that no root
    is made up; controllers are states. Motions that creep, of a damping ratio above 0.995, are left
    out. Raises AnalysisError if roots meet the excitation that can't be told apart.
    """
    ratio, limit = checked_excitation(assembled, excitation_ratio, speed_max_rad_s)
    known = _searched(assembled, ratio)
    for reached, found in known:
        if is_searched(limit, reached):
            return tuple(c for c in found if c.speed_rad_s <= limit * (1.0 + _ROUNDING))
    found = _found(assembled, ratio, limit)
    known.append((limit, found))
    return found


def is_searched(limit_rad_s: float, reached_rad_s: float) -> bool:
    """Whether a search for the same excitation up to a speed has all that is below a limit."""
    return limit_rad_s <= reached_rad_s * (1.0 + _ROUNDING)


@lru_cache(maxsize=_KEPT)
def _searched(
    assembled: AssembledSystem, ratio: float
) -> list[tuple[float, tuple[CriticalSpeed, ...]]]:
    """Return what was found before, and up to which speeds."""
    return []


def _found(assembled: AssembledSystem, ratio: float, limit: float) -> tuple[CriticalSpeed, ...]:
    given, assembled = assembled, at_whirl_ratio(assembled, ratio)
    if _is_undamped_problem(assembled):
        speeds, shapes = undamped_critical_speeds(assembled, ratio, limit)
        decrements = np.zeros(speeds.size)
    elif np.isfinite(limit):
        speeds, shapes, decrements = _damped(given, ratio, limit)
    else:
        raise AnalysisError(
            "speed_max_rad_s is needed: this system has damping, an unsymmetric or a negative "
            "stiffness, and its roots are followed up to a finite speed"
        )
    motion = motion_of(assembled, shapes)
    return tuple(
        CriticalSpeed(
            speed_rad_s=float(speed),
            frequency_hz=float(ratio * speed / (2.0 * np.pi)),
            whirl=str(whirl),
            shares=shares,
            shape=shape / shape[np.abs(shape).argmax()],
            log_decrement=float(decrement),
        )
        for speed, shape, decrement, whirl, shares in zip(
            speeds, shapes.T, decrements, motion.whirl, motion.shares, strict=True
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
    assembled = at_whirl_ratio(assembled, ratio)
    at_rest = at_limit = falls = rises = 0
    unresolved: list[tuple[float, float]] = []
    for pencil in separate_pencils(assembled, ratio):
        if pencil.laws:
            roots = speed_roots(pencil, assembled.body_rate, limit)
            counts = roots.counts
            falls += int(np.count_nonzero(roots.falls))
            rises += int(np.count_nonzero(~roots.falls))
            unresolved += roots.unresolved
        else:
            counts = (
                negative_count_at_rest(pencil, scaled_at(pencil, 0.0, assembled.body_rate)),
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


def _damped(
    assembled: AssembledSystem, ratio: float, limit: float
) -> tuple[FloatArray, ComplexArray, FloatArray]:
    """Return critical speeds, shapes and decrements with damping, by rising speed."""
    found = sorted(met_by_excitation(assembled, ratio, limit), key=lambda item: item.speed)
    speeds = np.array([item.speed for item in found])
    # Im λ = αΩ here but for rounding, which is no small part of it where Re λ is far larger
    values = np.array([complex(m.value.real, ratio * m.speed) for m in found], dtype=complex)
    shapes = np.array([item.right for item in found], dtype=complex).reshape(-1, assembled.size).T
    return speeds, separated_whirl(assembled, values, shapes), log_decrement(values)
