"""Checks of the modes of a system: residuals, orthogonality, and whether any are missing."""

from __future__ import annotations

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.checks.mode_counts import missing_modes, modes_below
from solidwhirl.rotordyn.checks.plain_checks import COUNT, ROOTS, root_misses, worst_of
from solidwhirl.rotordyn.checks.plain_system import PlainSystem
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
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
# A pivot of the scaled stiffness below this many roundings of the size is none.
_PIVOT = 64.0
# Coordinates softer than this part of the stiffest are scaled by their mass.
_SOFT = 1e-3
# Shifts that are tried, each four times the last.
_SHIFTS = 80
# Rigid motions are counted at this part of the lowest frequency.
_BELOW = 0.1

_AT_REST = "modes at rest"
_RESIDUAL = "residual of every eigenpair"


def check_modes_at_rest(assembled: AssembledSystem, modes: Modes) -> tuple[Invariant, ...]:
    """Check the modes of a system at zero speed, all of which are given.

    Returns backward error |D(λ)φ| / |φ| over the sizes of the terms, in coordinates where K is
    about one; without damping also M- and K-orthogonality, equality of elastic and kinetic energy,
    and the number of modes by the signs of K − σ²M.
    """
    if not modes.eigenvalues.size:
        return ()
    every, speed = PlainSystem.of(assembled), modes.speed_rad_s
    concerns = "frequencies at rest and the beginning of every branch"
    lowest = modes.eigenvalues[:_LOWEST]
    misses = root_misses(every, lowest, speed)
    roots = worst_of(ROOTS, _AT_REST, concerns, misses, f"the lowest {lowest.size}")
    if every.depends_on_frequency:
        names = (_RESIDUAL, "orthogonality of the modes", "elastic energy equals kinetic", COUNT)
        why = "each mode has its own bearings, which depend on the frequency"
        return (roots, *(undecided(name, _AT_REST, concerns, why) for name in names))
    plain = every.at(speed)
    residuals, rounding = _residuals(assembled, modes)
    reason = no_count(assembled, modes.negative_stiffness_count)
    limit = _GENERAL_RESIDUAL_LIMIT if reason else _RESIDUAL_LIMIT
    limit += _ROUNDINGS * rounding
    out = [compared(_RESIDUAL, _AT_REST, float(residuals.max()), limit, concerns)]
    out.append(roots)
    if reason:
        unknown = ("orthogonality of the modes", "elastic energy equals kinetic")
        out += [undecided(name, _AT_REST, concerns, reason) for name in unknown]
        half = (modes.eigenvalues.size + 1) // 2
        lost = missing_modes(plain, modes.eigenvalues, count=half)
        text = f"full spectrum, the lowest {half} modes"
        return (*out, compared(COUNT, _AT_REST, lost.size, 0.0, concerns, text))
    out += _products(assembled, modes, rounding)
    frequencies = modes.eigenvalues.imag
    between = _highest_gap(frequencies)
    found = int(np.count_nonzero(frequencies < between))
    counted = modes_below(plain, between)
    if frequencies.size < assembled.size:
        # what is not listed is rigid motion, or missing
        counted -= modes_below(plain, _BELOW * float(frequencies.min()))
    text = f"{found} modes counted below {between / (2.0 * np.pi):.6g} Hz"
    return (*out, compared(COUNT, _AT_REST, abs(counted - found), 0.0, concerns, text))


def _residuals(assembled: AssembledSystem, modes: Modes) -> tuple[FloatArray, float]:
    """Return |D(λ)φ| over |φ| and the sizes of the terms, (m,), and what rounding in K may do.

    In coordinates y = Pᵀq, P Pᵀ = K + s²M; the rounding is the relative error of the lowest modes.
    """
    matrices, values = matrices_at_speed(assembled, modes.speed_rad_s), modes.eigenvalues
    velocity = matrices.damping + matrices.gyroscopic
    even = 0.5 * (matrices.stiffness + matrices.stiffness.T)
    floor = _SOFT * (assembled.body_rate or 1.0) * np.diag(matrices.mass)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(even), floor))
    outer = np.outer(scale, scale)
    lower = _factor(outer * even, outer * matrices.mass, float(abs(values[0])))
    scaled = (lower.T / scale) @ modes.shapes
    left = np.zeros_like(scaled)
    sizes = np.zeros(values.size)
    for power, matrix in ((0, matrices.stiffness), (1, velocity), (2, matrices.mass)):
        inner = la.solve_triangular(lower, outer * matrix, lower=True)
        own = la.solve_triangular(lower, inner.T, lower=True).T
        left += own @ (scaled * values**power)
        # a bound of the 2-norm
        sizes += np.abs(values) ** power * np.sqrt(la.norm(own, 1) * la.norm(own, np.inf))
    residuals = la.norm(left, axis=0) / (la.norm(scaled, axis=0) * sizes)
    return np.asarray(residuals), float(np.finfo(float).eps / np.diag(lower).min() ** 2)


def _factor(stiffness: FloatArray, mass: FloatArray, slowest: float) -> FloatArray:
    """Return the Cholesky factor of K + s²M with the least s² that makes it positive."""
    least = np.sqrt(_PIVOT * len(mass) * np.finfo(float).eps)
    for step in range(_SHIFTS):
        shift = slowest**2 * 4.0 ** (step - 1) if step else 0.0
        try:
            lower = la.cholesky(stiffness + shift * mass, lower=True)
        except la.LinAlgError:
            continue
        if (np.diag(lower) > least).all():
            return np.asarray(lower)
    raise AnalysisError("the mass matrix is not positive definite; every coordinate needs inertia")


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


def _highest_gap(frequencies: FloatArray) -> float:
    """Return the middle of the highest gap of a list."""
    rising = np.sort(frequencies)
    ends = np.flatnonzero(np.diff(rising) > _GAP * rising[1:])
    if not ends.size:
        return 0.5 * float(rising[0])
    return 0.5 * float(rising[ends[-1]] + rising[ends[-1] + 1])


def no_count(assembled: AssembledSystem, negative_stiffness_count: int) -> str:
    """Say why modes can not be counted by signs; empty if they can.

    `negative_stiffness_count`: negative eigenvalues of K at the speed.
    """
    if not assembled.is_conservative:
        return "the system has damping or an unsymmetric stiffness: no signs to count by"
    if negative_stiffness_count:
        return f"the stiffness has {negative_stiffness_count} negative eigenvalues"
    return ""
