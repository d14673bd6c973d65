"""Checks of the modes of a system: residuals, orthogonality, and whether any are missing."""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.campbell.diagram import Campbell
from solidwhirl.rotordyn.checks.dynamic_stiffness import dynamic_stiffness, split_stiffness
from solidwhirl.rotordyn.checks.mode_counts import missing_modes
from solidwhirl.rotordyn.checks.plain_checks import (
    COUNT,
    ROOTS,
    check_branches,
    root_miss,
    worst_of,
)
from solidwhirl.rotordyn.checks.plain_system import PlainSystem
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.modes.eigen import Modes
from solidwhirl.rotordyn.superelement.invariants import Invariant, compared, undecided

# [measured]: largest over all scenes and the tests, levels beam, harmonic and solid.
_RESIDUAL_LIMIT = 1e-13  # [2.6e-15] without damping, by Hermitian problems
_GENERAL_RESIDUAL_LIMIT = 1e-10  # [2.7e-12] with damping, by a companion matrix
_ORTHOGONALITY_LIMIT = 1e-9  # [2.3e-11]
_ENERGY_LIMIT = 2e-10  # [4.1e-12]
# Frequencies farther apart than this (relative) leave room to count between them.
_GAP = 1e-3
# Bound of the rounding in K over what it does: [1/60] with supports of 1e2 N/m beside shafts of
# 1e9 N/m, where it is the largest.
_ROUNDINGS = 16.0
# Roots at rest that are looked at one by one.
_LOWEST = 24

_AT_REST = "modes at rest"
_RESIDUAL = "residual of every eigenpair"


def check_modes_at_rest(assembled: AssembledSystem, modes: Modes) -> tuple[Invariant, ...]:
    """Check the modes of a system at zero speed.

    `modes`: all of its modes at rest. Returns backward error |D(λ)φ| / |φ| over the sizes of the
    terms, in coordinates where K is about one; without damping also M- and K-orthogonality,
    equality of elastic and kinetic energy, and the number of modes (`SplitStiffness.modes_below`).
    """
    if not modes.eigenvalues.size:
        return ()
    stiffness = dynamic_stiffness(assembled, modes.speed_rad_s, float(abs(modes.eigenvalues[0])))
    concerns = "frequencies at rest and the beginning of every branch"
    residual = float(stiffness.residuals(modes.eigenvalues, modes.shapes).max())
    reason = no_count(assembled, modes.negative_stiffness_count)
    limit = residual_limit(reason, stiffness.rounding)
    out = [compared(_RESIDUAL, _AT_REST, residual, limit, concerns)]
    out.append(_roots_at_rest(assembled, modes, concerns))
    if reason:
        unknown = ("orthogonality of the modes", "elastic energy equals kinetic")
        out += [undecided(name, _AT_REST, concerns, reason) for name in unknown]
        half = (modes.eigenvalues.size + 1) // 2
        matrices = PlainSystem.of(assembled).at(modes.speed_rad_s)
        lost = missing_modes(matrices, modes.eigenvalues, count=half)
        text = f"full spectrum, the lowest {half} modes"
        return (*out, compared(COUNT, _AT_REST, lost.size, 0.0, concerns, text))
    out += _products(assembled, modes, stiffness.rounding)
    frequencies = modes.eigenvalues.imag
    between = _places(frequencies)[0]
    found = int(np.count_nonzero(frequencies < between))
    counted = split_stiffness(assembled, modes.speed_rad_s, float(frequencies[0]))
    missing = abs(counted.modes_below(between) - found)
    text = f"{found} modes counted below {between / (2.0 * np.pi):.6g} Hz"
    return (*out, compared(COUNT, _AT_REST, missing, 0.0, concerns, text))


def _roots_at_rest(assembled: AssembledSystem, modes: Modes, concerns: str) -> Invariant:
    """Relative error of the lowest roots in the system as it is given."""
    matrices = PlainSystem.of(assembled).at(modes.speed_rad_s)
    values = modes.eigenvalues[:_LOWEST]
    misses = [root_miss(matrices, complex(value), modes.speed_rad_s) for value in values]
    return worst_of(ROOTS, _AT_REST, concerns, misses, f"the lowest {values.size}")


def _products(assembled: AssembledSystem, modes: Modes, rounding: float) -> list[Invariant]:
    """Orthogonality in M and K, and the balance of energy."""
    matrices = matrices_at_speed(assembled, modes.speed_rad_s)
    omega, shapes = modes.eigenvalues.imag, modes.shapes
    kinetic = shapes.conj().T @ matrices.mass @ shapes
    elastic = shapes.conj().T @ matrices.stiffness @ shapes / np.outer(omega, omega)
    unit = np.eye(omega.size)
    orthogonal = max(float(np.abs(part - part * unit).max()) for part in (kinetic, elastic))
    balance = float(np.abs(np.diag(elastic).real / np.diag(kinetic).real - 1.0).max())
    return [
        compared(
            "orthogonality of the modes",
            _AT_REST,
            orthogonal,
            _ORTHOGONALITY_LIMIT + _ROUNDINGS * rounding,
            "shapes at rest, and what is expanded in them (run-up, state space)",
        ),
        compared(
            "elastic energy equals kinetic",
            _AT_REST,
            balance,
            _ENERGY_LIMIT + _ROUNDINGS * rounding,
            "frequencies at rest",
        ),
    ]


def check_campbell(
    assembled: AssembledSystem,
    diagram: Campbell,
    frequency_max_hz: float | None = None,
    branch_count: int | None = None,
) -> tuple[Invariant, ...]:
    """Check a Campbell diagram against the system as it is given.

    `frequency_max_hz`: as given to `campbell`: below it the branches are all modes, at every speed.
    `branch_count`: as given to `campbell`: at every speed they hold that many lowest modes. None
    with no limit either takes the smallest number of branches at a speed. The result is as
    `check_branches`.
    """
    alive = np.isfinite(diagram.eigenvalues).sum(axis=0)
    return check_branches(
        PlainSystem.of(assembled),
        diagram.speeds_rad_s,
        diagram.eigenvalues,
        branch_count=int(alive.min()) if branch_count is None else branch_count,
        frequency_max_hz=frequency_max_hz,
    )


def _places(frequencies: FloatArray) -> tuple[float, list[tuple[float, float]]]:
    """Return the middle of the highest gap of a list, and both sides of near equal ones below."""
    rising = np.sort(frequencies)
    ends = np.flatnonzero(np.diff(rising) > _GAP * rising[1:])
    if not ends.size:
        return 0.5 * float(rising[0]), []
    highest = 0.5 * float(rising[ends[-1]] + rising[ends[-1] + 1])
    near = [
        (float(rising[first] * (1.0 - 0.5 * _GAP)), float(rising[last] * (1.0 + 0.5 * _GAP)))
        for first, last in zip((0, *ends[:-1] + 1), ends, strict=True)
        if last > first
    ]
    return highest, near


def residual_limit(no_signs: str, rounding: float) -> float:
    """Return the limit of residuals, by the solver that the system called for."""
    return (_GENERAL_RESIDUAL_LIMIT if no_signs else _RESIDUAL_LIMIT) + _ROUNDINGS * rounding


def no_count(assembled: AssembledSystem, negative_stiffness_count: int) -> str:
    """Say why modes can not be counted by signs; empty if they can.

    `negative_stiffness_count`: negative eigenvalues of K at the speed.
    """
    if not assembled.is_conservative:
        return "the system has damping or an unsymmetric stiffness: no signs to count by"
    if negative_stiffness_count:
        return f"the stiffness has {negative_stiffness_count} negative eigenvalues"
    return ""
