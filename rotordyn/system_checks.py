"""Checks of an assembled system: its matrices and all that a run reports of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import scipy.linalg as la

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.body_measures import asymmetry, least_inertia
from solidwhirl.rotordyn.campbell import Campbell
from solidwhirl.rotordyn.critical_speed_checks import check_critical_speeds
from solidwhirl.rotordyn.critical_speeds import CriticalSpeed
from solidwhirl.rotordyn.eigen import Modes
from solidwhirl.rotordyn.errors import AnalysisError
from solidwhirl.rotordyn.invariants import Invariant, compared, undecided
from solidwhirl.rotordyn.mode_checks import check_campbell, check_modes_at_rest
from solidwhirl.rotordyn.plain_checks import check_joints
from solidwhirl.rotordyn.plain_system import PlainSystem
from solidwhirl.rotordyn.superelement_checks import SYMMETRY_LIMIT
from solidwhirl.rotordyn.system import AssembledSystem

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

    Parameters
    ----------
    assembled
        The system.
    at_rest
        All its modes at rest.
    diagram
        Its Campbell diagram.
    critical
        All critical speeds of each excitation ratio up to `speed_max_rad_s`.
    frequency_max_hz, branch_count
        As given to `campbell`.
    speed_max_rad_s
        As given to `critical_speeds`.
    """
    groups: list[tuple[str, Callable[[], tuple[Invariant, ...]]]] = [
        ("joints", lambda: check_joints(PlainSystem.of(assembled))),
        ("modes at rest", lambda: check_modes_at_rest(assembled, at_rest)),
        (
            "Campbell diagram",
            lambda: check_campbell(assembled, diagram, frequency_max_hz, branch_count),
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
    """Check symmetry, skewness and definiteness of the assembled matrices.

    Parameters
    ----------
    assembled
        The system.
    """
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
