"""Checks of critical speeds: residuals, and whether any are missing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solidwhirl.rotordyn.critical_speeds import CriticalSpeed
from solidwhirl.rotordyn.direct_speeds import negative_count, negative_count_at_rest
from solidwhirl.rotordyn.errors import AnalysisError
from solidwhirl.rotordyn.invariants import Invariant, compared, undecided
from solidwhirl.rotordyn.mode_checks import no_count
from solidwhirl.rotordyn.plain_checks import check_critical_roots
from solidwhirl.rotordyn.plain_system import PlainSystem
from solidwhirl.rotordyn.spectrum import scale_by_stiffness
from solidwhirl.rotordyn.system import AssembledSystem
from solidwhirl.rotordyn.whirl_pencils import whirl_pencils

# A critical speed this near to the end of the range (relative) may be counted on either side.
_AT_THE_END = 1e-9


_CONCERNS = "critical speeds"


def check_critical_speeds(
    assembled: AssembledSystem,
    found: Sequence[CriticalSpeed],
    excitation_ratio: float,
    speed_max_rad_s: float,
) -> tuple[Invariant, ...]:
    """Check all critical speeds of one excitation.

    Parameters
    ----------
    assembled
        The system.
    found
        What `critical_speeds` returned for this excitation and range.
    excitation_ratio, speed_max_rad_s
        As given to it; finite.

    Returns
    -------
    tuple of Invariant
        Relative error of every speed, and speeds that are missing, in the system as it is given
        (`check_critical_roots`); without damping the number of critical
        speeds by the signs of K + Ω²(K2 + iαG − α²M) near rest and at the end. With bearings that
        depend on the speed that is the number of falls less that of rises, so that the list may
        only be longer by an even number.
    """
    ratio = abs(excitation_ratio)
    where = f"critical speeds, excitation {ratio:g}"
    constant = scale_by_stiffness(
        0.5 * (assembled.stiffness + assembled.stiffness.T), assembled.mass, assembled.body_rate
    )
    reason = no_count(assembled, constant.negative_count)
    roots = [(c.speed_rad_s, _root(c, ratio)) for c in found]
    knots = assembled.knots_rad_s
    out = check_critical_roots(PlainSystem.of(assembled), roots, ratio, speed_max_rad_s, knots)
    return (*out, _count(assembled, found, ratio, speed_max_rad_s, where, reason))


def _root(critical: CriticalSpeed, ratio: float) -> complex:
    """λ = δ + iαΩ of a critical speed."""
    frequency = ratio * critical.speed_rad_s
    return complex(-critical.log_decrement * frequency / (2.0 * np.pi), frequency)


def _count(
    assembled: AssembledSystem,
    found: Sequence[CriticalSpeed],
    ratio: float,
    limit: float,
    where: str,
    reason: str,
) -> Invariant:
    name = "no critical speed is missing by signs"
    if any(abs(c.speed_rad_s - limit) <= _AT_THE_END * limit for c in found):
        reason = reason or "a critical speed lies at the end of the range"
    if reason:
        return undecided(name, where, _CONCERNS, reason)
    pencils = whirl_pencils(assembled, ratio)
    try:
        expected = sum(
            negative_count(pencil, limit, assembled.body_rate)
            - negative_count_at_rest(pencil, assembled.body_rate)
            for pencil in pencils
        )
    except AnalysisError as error:
        return undecided(name, where, _CONCERNS, str(error))
    more = len(found) - expected
    text = f"{len(found)} found, {expected} counted"
    if any(pencil.laws for pencil in pencils):
        # falls − rises of one eigenvalue each: the list has both
        missing = max(abs(expected) - len(found), more % 2)
        return compared(name, where, missing, 0.0, _CONCERNS, f"{text} as falls less rises")
    return compared(name, where, abs(more), 0.0, _CONCERNS, text)
