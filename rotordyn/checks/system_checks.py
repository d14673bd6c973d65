"""Checks of an assembled system: its matrices and all that a run reports of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.operator import operator_of
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.campbell.diagram import Campbell
from solidwhirl.rotordyn.checks import plain_checks
from solidwhirl.rotordyn.checks.mode_checks import check_modes_at_rest, no_count
from solidwhirl.rotordyn.checks.plain_system import PlainSystem
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.dense import scale_by_stiffness
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.critical_speeds.search import CriticalSpeed
from solidwhirl.rotordyn.critical_speeds.whirl_pencils import (
    negative_count,
    negative_count_at_rest,
    scaled_at,
    whirl_pencils,
)
from solidwhirl.rotordyn.modes.eigen import Modes
from solidwhirl.rotordyn.superelement.body_measures import asymmetry, least_inertia
from solidwhirl.rotordyn.superelement.invariants import Invariant, compared, undecided
from solidwhirl.rotordyn.superelement.validation import SYMMETRY_LIMIT

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

    `found`: what `critical_speeds` returned for this excitation and range. Returns relative error
    of every speed, and speeds that are missing, in the system as it is given
    (`check_critical_roots`); of large systems without damping the number of critical speeds by the
    signs of K + Ω²(K2 + iαG − α²M) near rest and at the end. With bearings that depend on the speed
    that is the number of falls less that of rises, so that the list may only be longer by an even
    number.
    """
    ratio = abs(excitation_ratio)
    where = f"critical speeds, excitation {ratio:g}"
    constant = scale_by_stiffness(
        0.5 * (assembled.stiffness + assembled.stiffness.T), assembled.mass, assembled.body_rate
    )
    reason = no_count(assembled, constant.negative_count)
    roots = [(c.speed_rad_s, _root(c, ratio)) for c in found]
    out = plain_checks.check_critical_roots(
        PlainSystem.of(assembled), roots, ratio, speed_max_rad_s, operator_of(assembled)
    )
    if out[-1].passed is not None:
        return out
    # many coordinates: without damping signs tell as much
    return (*out[:-1], _count(assembled, found, ratio, speed_max_rad_s, where, reason))


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
    name = plain_checks.COUNT_SPEEDS
    if any(abs(c.speed_rad_s - limit) <= _AT_THE_END * limit for c in found):
        reason = reason or "a critical speed lies at the end of the range"
    if reason:
        return undecided(name, where, _CONCERNS, reason)
    pencils = whirl_pencils(assembled, ratio)
    try:
        expected = sum(
            negative_count(pencil, limit, assembled.body_rate)
            - negative_count_at_rest(pencil, scaled_at(pencil, 0.0, assembled.body_rate))
            for pencil in pencils
        )
    except AnalysisError as error:
        return undecided(name, where, _CONCERNS, str(error))
    more = len(found) - expected
    text = f"{len(found)} found, {expected} counted"
    laws = any(pencil.laws for pencil in pencils)
    if expected < 0 and not laws:
        reason = "signs tell of more roots below zero at rest than at the end: rounding"
        return undecided(name, where, _CONCERNS, reason)
    if laws:
        # falls − rises of one eigenvalue each: the list has both
        missing = max(abs(expected) - len(found), more % 2)
        return compared(name, where, missing, 0.0, _CONCERNS, f"{text} as falls less rises")
    return compared(name, where, abs(more), 0.0, _CONCERNS, text)


_SMALLEST_INERTIA = 1e-14
_SYSTEM = "assembled system"
_ALL = "all frequencies and responses"


def check_system(
    assembled: AssembledSystem,
    at_rest: Modes,
    diagram: Campbell,
    critical: Mapping[float, Sequence[CriticalSpeed]],
    *,
    frequency_max_hz: float | None = None,
    branch_count: int | None = None,
    speed_max_rad_s: float = 0.0,
) -> tuple[Invariant, ...]:
    """Check an assembled system and the modes and critical speeds that were found.

    `at_rest`: all its modes at rest; `critical`: all critical speeds of each excitation ratio up to
    `speed_max_rad_s`; `speed_max_rad_s`: as given to `critical_speeds`.
    """
    groups: list[tuple[str, Callable[[], tuple[Invariant, ...]]]] = [
        ("joints", lambda: plain_checks.check_joints(PlainSystem.of(assembled))),
        ("modes at rest", lambda: check_modes_at_rest(assembled, at_rest)),
        (
            "Campbell diagram",
            lambda: plain_checks.check_campbell(assembled, diagram, frequency_max_hz, branch_count),
        ),
    ]
    for ratio, found in critical.items():
        check = partial(check_critical_speeds, assembled, found, ratio, speed_max_rad_s)
        groups.append((f"critical speeds, excitation {ratio:g}", check))
    out = list(check_matrices(assembled))
    for where, made in groups:
        try:
            out += made()
        except (AnalysisError, la.LinAlgError) as error:
            # a check that can't be made is no reason to lose the run
            out.append(undecided("all checks", where, f"{where}, unchecked", str(error)))
    return tuple(out)


def check_matrices(assembled: AssembledSystem) -> tuple[Invariant, ...]:
    """Check symmetry, skewness and definiteness of the assembled matrices."""
    out = [
        _symmetric("mass", assembled.mass, 1.0),
        compared(
            "mass positive definite",
            _SYSTEM,
            -least_inertia(assembled.mass),
            -_SMALLEST_INERTIA,
            _ALL,
        ),
        _symmetric("gyroscopic", assembled.gyroscopic, -1.0),
        _symmetric("centrifugal stiffness", assembled.centrifugal_stiffness, 1.0),
    ]
    if assembled.has_symmetric_joints:
        return (*out, _symmetric("stiffness", assembled.stiffness, 1.0))
    reason = "a bearing has an unsymmetric stiffness"
    return (*out, undecided("stiffness symmetric", _SYSTEM, _ALL, reason))


def _symmetric(name: str, matrix: FloatArray, sign: float) -> Invariant:
    kind = "symmetric" if sign > 0 else "skew"
    error = asymmetry(matrix, sign)
    return compared(f"{name} {kind}", _SYSTEM, error, SYMMETRY_LIMIT, _ALL)
