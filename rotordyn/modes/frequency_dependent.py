"""Modes of systems with bearings whose force depends on the frequency of the motion.

[K + sV + s²M + Σ Bᵀ Z(Ω, s) B] φ = 0 is no polynomial in s. With the bearings as they are at a
frequency ω it is one, and its roots with Im s = ω are roots of both. How many of its roots lie
below ω, at two frequencies, tells how many are between.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import NamedTuple, TypeAlias

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.frequency_laws import FrequencyTableLaw
from solidwhirl.rotordyn.assembly.system import (
    AssembledSystem,
    SpeedMatrices,
    at_rate,
    matrices_at_speed,
)
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, Matrix, together
from solidwhirl.rotordyn.core.dense import (
    Spectrum,
    apart_from_zeros,
    reciprocal,
    scale_by_stiffness,
    solve_general,
)
from solidwhirl.rotordyn.core.ledger import solved
from solidwhirl.rotordyn.modes.controlled import (
    controlled,
    controlled_motions,
    has_controllers_alone,
)
from solidwhirl.rotordyn.modes.damping import CREEPING, damping_ratio
from solidwhirl.rotordyn.modes.nearby import nearby_modes

# Steps for one root, and the relative change at which it is at rest.
_STEPS, _AT_REST = 15, 1e-12
# Roots of a frozen problem closer than this (relative) are refined as one group.
_EQUAL = 1e-6
# Two roots this close (relative) are one if their shapes are this much alike.
_ONE, _ALIKE = 1e-8, 0.9
# A range of frequencies in which not all roots are found is halved down to this part.
_NARROW = 1e-13
# and to this one for motions that creep, which are no modes.
_CREEPING_WIDTH = 1e-2
# A frequency above all others, for the limit of quick motions.
_QUICK = 1e9
# Frequencies at which a law without knots is looked at: so many for each factor of ten.
_PER_DECADE = 6
# An end of a range belongs to it within this fraction.
_ROUNDING = 1e-9
# A stiffness of this condition has free motions; they are found beside this part of the stiffest.
_SINGULAR, _SLOW = 1e13, 1e-3
# Relative step of the derivative over the rate.
_STEP = 1e-6


# From a rate and what modes look like to their values and shapes; None where others are as near.
Near: TypeAlias = Callable[[complex, ComplexArray], tuple[ComplexArray, ComplexArray] | None]


class Frozen(NamedTuple):
    """All roots of a system with the bearings as they are at a frequency."""

    frequency: float
    spectrum: Spectrum
    zero_count: int
    negative_count: int

    def below(self, size: int) -> int:
        """Return how many of the 2n roots have |Im s| below the frequency."""
        above = np.count_nonzero(self.spectrum.eigenvalues.imag >= self.frequency)
        return 2 * size - 2 * int(above)


def dependent_modes(assembled: AssembledSystem, speed_rad_s: float) -> Frozen:
    """Return all modes of a system with bearings that depend on the frequency.

    `speed_rad_s`: Ω. Real roots are those of the bearings for slow motions, and two of about their
    rate of decay stand for a motion that creeps, of a damping ratio above 0.995. Tables have as
    many roots as counts say. Of other laws those are found that the frozen problems of several
    frequencies lead to. Where all of them are magnetic, the states of their controllers are
    unknowns too, and all roots are found as one linear problem has them.
    """
    if has_controllers_alone(assembled):
        return _with_controllers(assembled, speed_rad_s)
    edges = _edges(assembled, speed_rad_s)
    frozen = [_frozen(assembled, speed_rad_s, frequency) for frequency in edges]
    parts = _roots_of(assembled, speed_rad_s, frozen)
    values = np.concatenate([part.eigenvalues for part in parts])
    shapes = np.concatenate([part.shapes for part in parts], axis=1)
    found = Spectrum(values, shapes, frozen[0].spectrum.real_eigenvalues)
    return frozen[0]._replace(spectrum=_without_creeping(found))


def _without_creeping(found: Spectrum) -> Spectrum:
    """Return roots by rising frequency, motions that creep as two real ones."""
    values = found.eigenvalues
    rising = np.lexsort((values.real, values.imag))
    creeps = damping_ratio(values[rising]) > CREEPING
    lively = rising[~creeps]
    real = np.concatenate((found.real_eigenvalues, np.repeat(values[rising[creeps]].real, 2)))
    return Spectrum(values[lively], found.shapes[:, lively], np.sort(real))


def _with_controllers(assembled: AssembledSystem, speed: float) -> Frozen:
    """Return all roots of a system whose magnetic bearings alone depend on the frequency."""
    parts = controlled(assembled)
    found = controlled_motions(parts, speed)
    slow = _matrices(assembled, speed, 0.0)
    even = 0.5 * (slow.stiffness + slow.stiffness.T)
    negative = scale_by_stiffness(even, slow.mass, assembled.body_rate).negative_count
    states = sum(len(loop.bearing.controller.a) for loop in parts.loops)
    known = 2 * found.eigenvalues.size + found.real_eigenvalues.size
    zeros = 2 * assembled.size + states - known
    return Frozen(0.0, _without_creeping(found), zeros, negative)


def _roots_of(assembled: AssembledSystem, speed: float, frozen: Sequence[Frozen]) -> list[Spectrum]:
    """Return all roots that oscillate, from those of the frozen problems at rising frequencies."""
    first, last = frozen[0], frozen[-1]
    omega = first.spectrum.eigenvalues.imag
    parts = [_chosen(first.spectrum, omega < first.frequency)]
    if not all(isinstance(law, FrequencyTableLaw) for law in assembled.frequency_laws):
        parts = [_chosen(first.spectrum, np.zeros(omega.size, dtype=bool))]
        for each in frozen:
            parts = _united(parts, _refined(assembled, speed, each.spectrum, 0.0, np.inf))
        return parts
    # a root of a table at its own frequency is one of the frozen problem, mass and all
    for low, high in pairwise(frozen):
        parts += _between(assembled, speed, low, high)
    parts.append(_chosen(last.spectrum, last.spectrum.eigenvalues.imag >= last.frequency))
    return parts


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
    for _ in range(_STEPS + 1):
        matrices = matrices_at_speed(at_rate(assembled, rate), speed_rad_s)
        found = nearby_modes(matrices, rate, shapes)
        if found is None:
            return None
        shapes = found[1]
        change = complex(found[0].mean()) - rate
        if abs(change) <= _AT_REST * abs(rate):
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


def _edges(assembled: AssembledSystem, speed: float) -> FloatArray:
    """Return frequencies between which the bearings are smooth, and not too far apart."""
    laws = assembled.frequency_laws
    knots = {knot for law in laws for knot in law.knots_of_frequency}
    if any(not isinstance(law, FrequencyTableLaw) for law in laws):
        ends = [_frozen(assembled, speed, omega).spectrum for omega in (0.0, _QUICK)]
        size = np.abs(
            np.concatenate([v for e in ends for v in (e.eigenvalues, e.real_eigenvalues)])
        )
        low, high = 0.1 * float(size.min(initial=1.0)), 2.0 * float(size.max(initial=10.0))
        count = max(2, int(np.ceil(_PER_DECADE * np.log10(high / low))))
        knots |= set(np.geomspace(low, high, count).tolist())
    return np.array(sorted(knots)) if knots else np.zeros(1)


def _frozen(assembled: AssembledSystem, speed: float, frequency: float) -> Frozen:
    """Return all roots with the bearings as they are at a frequency."""
    matrices = _matrices(assembled, speed, frequency)
    symmetric = 0.5 * (matrices.stiffness + matrices.stiffness.T)
    mass = 0.5 * (matrices.mass + matrices.mass.T)
    scaled = scale_by_stiffness(symmetric, mass, assembled.body_rate)
    velocity = matrices.damping + matrices.gyroscopic
    if np.array_equal(matrices.mass, matrices.mass.T):
        spectrum = solve_general(scaled, matrices.stiffness, velocity, assembled.size)
    else:
        spectrum = _with_skew_mass(matrices, scaled.scale)
    found = 2 * spectrum.eigenvalues.size + spectrum.real_eigenvalues.size
    zeros = 0 if scaled.is_definite else 2 * assembled.size - found
    return Frozen(frequency, spectrum, zeros, scaled.negative_count)


def _with_skew_mass(matrices: SpeedMatrices, scale: FloatArray) -> Spectrum:
    """Solve a problem whose mass is not symmetric, as a seal's may be: 1/λ of its companion form.

    Beside a shift where the stiffness is singular. Slow motions keep their digits.
    """
    outer = np.multiply.outer(scale, scale)
    mass, stiffness = outer * matrices.mass, outer * matrices.stiffness
    velocity = outer * (matrices.damping + matrices.gyroscopic)
    shift = 0.0
    if np.linalg.cond(stiffness) > _SINGULAR:
        shift = _SLOW / float(np.sqrt(np.diag(mass).max()))
    n = scale.size
    companion = np.zeros((2 * n, 2 * n))
    dynamic = stiffness + shift * velocity + shift**2 * mass
    both = np.hstack((velocity + 2.0 * shift * mass, mass))
    companion[:n] = -la.solve(dynamic, both)
    companion[n:, :n] = np.eye(n)
    solved("eigenproblems")
    inverse, vectors = la.eig(companion, overwrite_a=True, check_finite=False)
    values = shift + reciprocal(inverse)
    return apart_from_zeros(values, scale[:, None] * vectors[:n])


def _matrices(assembled: AssembledSystem, speed: float, frequency: float) -> SpeedMatrices:
    """Return the matrices at a frequency, added mass in the mass."""
    others = tuple(j for j in assembled.law_joints if j.frequency_law is None)
    found = matrices_at_speed(replace(assembled, law_joints=others), speed)
    mass, damping, stiffness = found.mass, found.damping, found.stiffness
    for joint in assembled.law_joints:
        law, motion = joint.frequency_law, joint.motion
        if law is not None:
            k, c, m = law.at_frequency(abs(joint.speed_ratio * speed), frequency)
            mass = mass + motion.T @ m @ motion
            damping = damping + motion.T @ c @ motion
            stiffness = stiffness + motion.T @ k @ motion
    return SpeedMatrices(mass, damping, found.gyroscopic, stiffness)


def _chosen(spectrum: Spectrum, chosen: Matrix) -> Spectrum:
    return Spectrum(spectrum.eigenvalues[chosen], spectrum.shapes[:, chosen], np.empty(0))


def _between(assembled: AssembledSystem, speed: float, low: Frozen, high: Frozen) -> list[Spectrum]:
    """Return the roots with low ≤ Im s < high, as many as the counts at both ends say.

    Where the frequency of a root depends much on that of the bearings, as beside overdamped motion,
    no iteration may lead to it; halving does.
    """
    count = (high.below(assembled.size) - low.below(assembled.size)) // 2
    begin, end = low.frequency, high.frequency
    width = end - begin
    found: list[Spectrum] = []
    # a root has passed ω between the two: above it at one end, below it at the other
    for side, least, most in ((low, begin, end + width), (high, begin - width, end)):
        omega = side.spectrum.eigenvalues.imag
        lively = damping_ratio(side.spectrum.eigenvalues) <= CREEPING
        near = _chosen(side.spectrum, (omega >= least) & (omega < most) & lively)
        found = _united(found, _refined(assembled, speed, near, begin, end))
    known = sum(part.eigenvalues.size for part in found)
    # a frequency may be passed upward and downward; such roots come by twos
    if known == count or (known > count and (known - count) % 2 == 0):
        return found
    away = np.abs(high.spectrum.eigenvalues.imag - end)
    nearest = _chosen(high.spectrum, np.argsort(away)[: max(count, 0)])
    creeps = bool((damping_ratio(nearest.eigenvalues) > CREEPING).all())
    if width <= (_CREEPING_WIDTH if creeps else _NARROW) * end:
        return [nearest]
    middle = _frozen(assembled, speed, 0.5 * (begin + end))
    parts: list[Spectrum] = []
    for first, last in ((low, middle), (middle, high)):
        if first.below(assembled.size) != last.below(assembled.size):
            parts += _between(assembled, speed, first, last)
    return parts


def _refined(
    assembled: AssembledSystem, speed: float, near: Spectrum, low: float, high: float
) -> list[Spectrum]:
    """Return roots found from those of a frozen problem, if their frequency is in a range."""
    found: list[Spectrum] = []
    rates, find = near.eigenvalues, modes_near(assembled, speed)
    for group in together(np.abs(rates[:, None] - rates) <= _EQUAL * np.abs(rates)):
        one = find(complex(rates[group].mean()), near.shapes[:, group])
        if one is None:
            continue
        inside = (one[0].imag >= low * (1.0 - _ROUNDING)) & (one[0].imag < high * (1 - _ROUNDING))
        kept = Spectrum(one[0][inside], one[1][:, inside], np.empty(0))
        found = _united(found, [kept])
    return found


def _united(known: Sequence[Spectrum], more: Sequence[Spectrum]) -> list[Spectrum]:
    """Return roots and those of others that are not among them."""
    out = list(known)
    for part in more:
        new = [
            place
            for place, value in enumerate(part.eigenvalues)
            if not any(_is_known(have, value, part.shapes[:, place]) for have in known)
        ]
        if new:
            out.append(_chosen(part, np.array(new)))
    return out


def _is_known(have: Spectrum, value: complex, shape: ComplexArray) -> bool:
    same = np.flatnonzero(np.abs(have.eigenvalues - value) <= _ONE * abs(value))
    if not same.size:
        return False
    # equal roots have a subspace: what lies in it is known
    basis = np.linalg.qr(have.shapes[:, same])[0]
    inside = np.linalg.norm(basis.conj().T @ shape) ** 2
    return bool(inside > _ALIKE * np.linalg.norm(shape) ** 2)
