"""Modes near a known one, without the whole spectrum: inverse iteration of a block of states."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.linalg as nla
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.system import (
    AssembledSystem,
    SpeedMatrices,
    at_rate,
    matrices_at_speed,
)
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray, together
from solidwhirl.rotordyn.core.dense import diagonal, uncoupled
from solidwhirl.rotordyn.core.ledger import solved

# Iterations at most, the relative change of the eigenvalues at which they are at rest, and what
# part of a block may leave its subspace.
_STEPS, _AT_REST, _CLOSED = 20, 1e-12, 1e-11
# The shift lies beside the number given by the first of these fractions at which D is regular: no
# pivot is rounding of the largest.
_BESIDE, _PIVOT = (1e-7, 1e-5, 1e-3, 1e-2), 64 * np.finfo(float).eps
# Iterations for left vectors, and the largest relative step of a value that they sharpen.
_LEFT_STEPS, _SMALL = 3, 1e-6

# Steps for one root with bearings at its own frequency, and the relative change at which it rests.
_SECANTS, _RESTS = 15, 1e-12
# Relative step of the derivative over the rate.
_STEP = 1e-6

LuFactors = tuple[ComplexArray, IntArray]
# From a rate and what modes look like to their values and shapes; None where others are as near.
Near: TypeAlias = Callable[[complex, ComplexArray], tuple[ComplexArray, ComplexArray] | None]


def nearby_modes(
    matrices: SpeedMatrices, rate: complex, shapes: ComplexArray
) -> tuple[ComplexArray, ComplexArray] | None:
    """Find the eigenvalues that are nearest to a number.

    `matrices`: of the system at a speed; `rate`: λ0 in 1/s, not zero, next to the wanted ones;
    `shapes`: about what they look like, shape (n, m), independent. Returns m values λ, by rising
    distance from λ0, and their shapes (n, m); None if they do not come to rest in some steps, as
    others are about as near.

    One factorisation of D(λ0) serves (A − λ0)⁻¹ of the states (q, λq), whose largest eigenvalues
    1/(λ − λ0) a block of m states finds (Saad 2011, Numerical Methods for Large Eigenvalue
    Problems, section 5.1). Shapes that only move coordinates that nothing joins to others are
    found in these, and each in its own.
    """
    groups = moved_apart(matrices, shapes)
    if len(groups) == 1 and groups[0].coordinates.size == len(shapes):
        return _nearest_modes(matrices, rate, shapes)
    values, whole = np.zeros(shapes.shape[1], dtype=complex), np.zeros(shapes.shape, dtype=complex)
    for at, columns in groups:
        own = np.ix_(at, columns)
        found = _nearest_modes(matrices.part(at), rate, shapes[own])
        if found is None:
            return None
        values[columns], whole[own] = found
    order = np.argsort(np.abs(values - rate), kind="stable")
    return values[order], whole[:, order]


class Moved(NamedTuple):
    """Coordinates that nothing joins to others, and the columns of the shapes that move them."""

    coordinates: IntArray
    columns: IntArray


def moved_apart(matrices: SpeedMatrices, shapes: ComplexArray) -> list[Moved]:
    """Return the groups of shapes that move no coordinates in common."""
    groups = uncoupled(*matrices)
    moves = np.array([shapes[at].any(axis=0) for at in groups])
    out = []
    for columns in together((moves[:, :, None] & moves[:, None, :]).any(axis=0)):
        own = np.flatnonzero(moves[:, columns].any(axis=1))
        out.append(Moved(np.sort(np.concatenate([groups[k] for k in own])), columns))
    return out


def _nearest_modes(
    matrices: SpeedMatrices, rate: complex, shapes: ComplexArray
) -> tuple[ComplexArray, ComplexArray] | None:
    """Find the eigenvalues that are nearest to a number, in all coordinates."""
    size = abs(rate)
    balance = balance_of(matrices, rate)
    around = np.multiply.outer(balance, balance)
    mass = size**2 * (around * matrices.mass)
    velocity = size * (around * (matrices.damping + matrices.gyroscopic))
    stiffness = around * matrices.stiffness
    regular = _factored(rate / size, (mass, velocity, stiffness))
    if regular is None:
        return None
    at, slope, factors = regular
    here = shapes / balance[:, None]
    states = np.vstack((here, at * here))
    before = np.full(shapes.shape[1], np.inf, dtype=complex)
    for _ in range(_STEPS):
        basis = nla.qr(states)[0]
        half, rest = np.split(basis, 2)
        found = la.lu_solve(factors, -(slope @ half + mass @ rest), check_finite=False)
        states = np.vstack((found, half + at * found))
        small = basis.conj().T @ states
        inverse, turn = nla.eig(small)
        order = np.argsort(-np.abs(inverse), kind="stable")
        values = at + 1.0 / inverse[order]
        # eigenvalues that meet are never at rest; the subspace of both is
        is_closed = nla.norm(states - basis @ small) <= _CLOSED * nla.norm(states)
        if is_closed or (np.abs(values - before) <= _AT_REST).all():
            right = found @ turn[:, order]
            values = _sharpened(values, right, (mass, velocity, stiffness), factors)
            return size * values, balance[:, None] * right
        before = values
    return None


def _factored(
    rate: complex, problem: tuple[FloatArray, ...]
) -> tuple[complex, ComplexArray, LuFactors] | None:
    """Return a shift beside a rate, V + s M and the factors of D there; None if it is singular.

    A root far below others is a small difference of large terms: as near as usual all of it may be
    their rounding.
    """
    mass, velocity, stiffness = problem
    for beside in _BESIDE:
        at = rate * (1.0 + beside)
        slope = velocity + at * mass
        solved("factorisations")
        upper, swaps, _ = la.lapack.zgetrf(stiffness + at * slope)
        pivots = np.abs(np.diag(upper))
        if pivots.min() > _PIVOT * pivots.max():
            return at, slope, (upper, swaps)
    return None


def balance_of(matrices: SpeedMatrices, rate: complex) -> FloatArray:
    """Return scales that bring the diagonal of D near 1, so that stiff springs do no harm."""
    size = np.abs(np.diag(matrices.stiffness)) + abs(rate) ** 2 * np.diag(matrices.mass)
    return np.asarray(1.0 / np.sqrt(np.where(size > 0, size, 1.0)))


def _sharpened(
    values: ComplexArray, right: ComplexArray, problem: tuple[FloatArray, ...], factors: LuFactors
) -> ComplexArray:
    """Return eigenvalues after a step of Newton's method, which leaves the rounding of its terms.

    `problem`: M, V and K. Left vectors by residual inverse iteration; their error counts times that
    of the right ones.
    """
    mass, velocity, stiffness = problem
    left = right.conj()
    for _ in range(_LEFT_STEPS):
        miss = stiffness.T @ left + values * (velocity.T @ left) + values**2 * (mass.T @ left)
        left = left - la.lu_solve(factors, miss, trans=1, check_finite=False)
    push, inertia = velocity @ right, mass @ right
    miss = diagonal(left.T, stiffness @ right + values * push + values**2 * inertia)
    slope = diagonal(left.T, push + 2.0 * values * inertia)
    step = miss / np.where(slope == 0, np.inf, slope)
    # what is no small step is of roots that meet, or of left vectors that are none
    return np.where(np.abs(step) <= _SMALL * np.abs(values), values - step, values)


def modes_near(assembled: AssembledSystem, speed_rad_s: float) -> Near:
    """Return what finds modes of a system at a speed near a rate, as `nearby_modes` does.

    Where bearings depend on the frequency all of them are taken as they are at the mean of the
    roots that are found, so that more than one shape is for equal roots.
    """
    if assembled.depends_on_frequency:
        return partial(_with_own_frequency, assembled, speed_rad_s)
    return partial(nearby_modes, matrices_at_speed(assembled, speed_rad_s))


def _with_own_frequency(
    assembled: AssembledSystem, speed_rad_s: float, rate: complex, shapes: ComplexArray
) -> tuple[ComplexArray, ComplexArray] | None:
    before, miss = complex(np.nan, 0.0), complex(np.nan, 0.0)
    for _ in range(_SECANTS + 1):
        matrices = matrices_at_speed(at_rate(assembled, rate), speed_rad_s)
        found = nearby_modes(matrices, rate, shapes)
        if found is None:
            return None
        shapes = found[1]
        change = complex(found[0].mean()) - rate
        if abs(change) <= _RESTS * abs(rate):
            return found
        is_first = np.isnan(before.real)
        slope = -1.0 + 0j if is_first else (change - miss) / (rate - before)
        # the secant method; a slope that is none leaves the plain iteration
        step = -change / slope if abs(slope) > 0.1 else change
        before, miss = rate, change
        rate = complex(rate + step)
    return None


def with_own_bearings(
    assembled: AssembledSystem,
    speed_rad_s: float,
    rate: complex,
    vectors: tuple[ComplexArray, ComplexArray],
    change: complex,
) -> complex:
    """Return the change of a root whose bearings change with it, from that of the frozen problem.

    `rate`: s of the root; `vectors`: its left and right ones, yᵀ(2sM + V)x = 1 with the bearings
    frozen at s; `change`: δs with those bearings, to first order. Z may change otherwise with the
    frequency than with the growth: δs + yᵀBᵀ(∂Z/∂s − C)B x δs is solved for both parts.
    """
    growth, frequency = (
        _beside_damping(assembled, speed_rad_s, rate, vectors, direction)
        for direction in (1.0 + 0j, 1j)
    )
    columns = np.array([1.0 + growth, 1j + frequency])
    real = np.array([columns.real, columns.imag])
    found = np.linalg.solve(real, [change.real, change.imag])
    return complex(found[0], found[1])


def _beside_damping(
    assembled: AssembledSystem,
    speed_rad_s: float,
    rate: complex,
    vectors: tuple[ComplexArray, ComplexArray],
    direction: complex,
) -> complex:
    """Return yᵀBᵀ(dZ − C ds)B x per unit step of s in a direction, all bearings together."""
    left, right = vectors
    step = _STEP * abs(rate) * direction
    total = 0j
    for joint in assembled.law_joints:
        law = joint.frequency_law
        if law is None:
            continue
        spin = abs(joint.speed_ratio * speed_rad_s)
        ends = [law.dynamic_stiffness(spin, rate + sign * step) for sign in (-1.0, 1.0)]
        change = (ends[1] - ends[0]) / (2.0 * abs(step))
        damping = joint.with_law(law.at_rate(rate)).coefficients(speed_rad_s)[1]
        rest = change - direction * damping
        total += (joint.motion @ left) @ (rest @ (joint.motion @ right))
    return complex(total)
