"""The subspace of the lowest modes at a speed near one whose whole spectrum is known.

In the modes of the known speed, A(Ω) = Λ + E(Ω). The subspace of the lowest ones is followed: with
the others' part P of it, E21 + (Λ2 + E22) P − P (Λ1 + E11) − P E12 P = 0 (Stewart and Sun 1990,
Matrix Perturbation Theory, section V.2), and their eigenvalues are those of Λ1 + E11 + E12 P. All
others are eigenvalues of Λ2 + E22 − P E12, which lie in Gershgorin's discs: that none of them is as
low proves that none is missing.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.linalg as nla
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.system import LawJoint
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, Matrix

# Iterations at most, the relative change of P at rest, and what factor of convergence is too slow.
_STEPS, _AT_REST, _SLOW = 30, 1e-11, 0.6
# Modes of a known speed are as good as this (relative) where they serve as a basis.
_GOOD = 1e-9


class RealBasis(NamedTuple):
    """Real basis of states: of pairs Re x, then Im x; then of real eigenvalues x.

    `rates`: λ of pairs, `reals`: real λ; `shapes`, `moving`: x and λx, (n, columns).
    """

    rates: ComplexArray
    reals: FloatArray
    shapes: FloatArray
    moving: FloatArray

    def diagonal(self) -> FloatArray:
        """Return Λ: A Re x = σ Re x − ω Im x, A Im x = ω Re x + σ Im x."""
        pairs = self.rates.size
        matrix = np.diag(np.concatenate((self.rates.real, self.rates.real, self.reals)))
        at = np.arange(pairs)
        matrix[at, pairs + at], matrix[pairs + at, at] = self.rates.imag, -self.rates.imag
        return matrix

    def rates_with(self, own: FloatArray) -> ComplexArray:
        """Return λ, λ* and real λ with the diagonal of E, (columns,)."""
        p, at = self.rates.size, np.arange(self.rates.size)
        even = own[at, at] + own[p + at, p + at]
        shift = 0.5 * (even + 1j * (own[at, p + at] - own[p + at, at]))
        pairs = self.rates + shift
        return np.concatenate((pairs, pairs.conj(), self.reals + np.diag(own)[2 * p :]))

    def of_rates(self, matrix: FloatArray, p: int) -> ComplexArray:
        """Return rows of λ of a matrix with p pairs of columns: those of λ, λ*, real λ."""
        h = self.rates.size
        row = matrix[:h] - 1j * matrix[h:]
        along, across = row[:, :p], 1j * row[:, p : 2 * p]
        return np.hstack((along + across, along - across, row[:, 2 * p :]))

    def of_states(self, matrix: ComplexArray, p: int) -> FloatArray:
        """Return the real matrix that has these rows and columns of λ."""
        one, other = matrix[:, :p], matrix[:, p : 2 * p]
        row = np.hstack((0.5 * (one + other), -0.5j * (one - other), matrix[:, 2 * p :]))
        return np.vstack((row.real, -row.imag))

    def entries(self, matrix: FloatArray) -> ComplexArray:
        """Return rows of λ of a matrix whose columns are these states, too."""
        return 0.5 * self.of_rates(matrix, self.rates.size)


class WhirlBasis(NamedTuple):
    """Basis of states of z = p + i s, each with its own λ: `rates`, `shapes`, `moving`."""

    rates: ComplexArray
    shapes: ComplexArray
    moving: ComplexArray

    def diagonal(self) -> ComplexArray:
        """Return Λ."""
        return np.diag(self.rates)

    def rates_with(self, own: ComplexArray) -> ComplexArray:
        """Return λ with the diagonal of E, (columns,)."""
        return self.rates + np.diag(own)

    def of_rates(self, matrix: ComplexArray, _: int) -> ComplexArray:
        """Return the matrix: states are those of λ."""
        return matrix

    def of_states(self, matrix: ComplexArray, _: int) -> ComplexArray:
        """Return the matrix."""
        return matrix

    def entries(self, matrix: ComplexArray) -> ComplexArray:
        """Return the matrix."""
        return matrix


Basis = RealBasis | WhirlBasis


class Law(NamedTuple):
    """A bearing with a speed law: what its force pushes, (states, r), and what moves it.

    `shapes`, `moving`: its relative motion per state, (r, states).
    """

    joint: LawJoint
    pushed: Matrix
    shapes: Matrix
    moving: Matrix


class Problem(NamedTuple):
    """M, V and K at the known speed, and what V and K gain per rad/s and K per (rad/s)²."""

    mass: Matrix
    velocity: Matrix
    stiffness: Matrix
    turning: Matrix
    circulating: Matrix
    centrifugal: Matrix


class Known(NamedTuple):
    """A speed with its whole spectrum: lowest modes, the others, and E per cause.

    `by_spin`: E per rad/s, `by_square`: per (rad/s)² of the centrifugal stiffness.
    """

    speed_rad_s: float
    lowest: Basis
    others: Basis
    by_spin: Matrix
    by_square: Matrix | None
    laws: tuple[Law, ...]


def known_subspaces(
    speed_rad_s: float,
    problem: Problem,
    bases: tuple[Basis, Basis],
    joints: Sequence[tuple[LawJoint, Matrix]],
) -> Known | None:
    """Return what the lowest modes at other speeds are found from.

    `bases`: of the lowest modes and of all others; `joints`: bearings with a speed law and their
    relative motion per coordinate, (r, n). None if the modes are no basis.
    """
    lowest, others = bases
    n = len(problem.mass)
    top = np.hstack((lowest.shapes, others.shapes))
    bottom = np.hstack((lowest.moving, others.moving))
    try:
        inverse = nla.inv(np.vstack((top, bottom)))
        dual = la.cho_solve(la.cho_factor(problem.mass.conj()), inverse[:, n:].T).T
    except la.LinAlgError:
        return None
    # the basis reproduces the matrices: W A V = Λ
    size = lowest.shapes.shape[1]
    force = problem.stiffness @ top[:, :size] + problem.velocity @ bottom[:, :size]
    found = inverse[:size, :n] @ bottom[:, :size] - dual[:size] @ force
    if not la.norm(found - lowest.diagonal()) <= _GOOD * la.norm(lowest.diagonal()):
        return None
    square = problem.centrifugal
    return Known(
        speed_rad_s=speed_rad_s,
        lowest=lowest,
        others=others,
        by_spin=-dual @ (problem.turning @ bottom + problem.circulating @ top),
        by_square=-dual @ (square @ top) if square.any() else None,
        laws=tuple(
            Law(joint, dual @ motion.conj().T, motion @ top, motion @ bottom)
            for joint, motion in joints
        ),
    )


def change(known: Known, speed_rad_s: float) -> Matrix:
    """Return E at a speed."""
    found = (speed_rad_s - known.speed_rad_s) * known.by_spin
    if known.by_square is not None:
        found += (speed_rad_s**2 - known.speed_rad_s**2) * known.by_square
    for law in known.laws:
        there = law.joint.coefficients(speed_rad_s)
        here = law.joint.coefficients(known.speed_rad_s)
        r = len(law.shapes)
        k, c = (a[:r, :r] - b[:r, :r] for a, b in zip(there, here, strict=True))
        found -= law.pushed @ (k @ law.shapes + c @ law.moving)
    return found


def followed(known: Known, changed: Matrix, part: Matrix) -> tuple[Matrix, float] | None:
    """Return P, and a frequency below which no other mode lies; None if there is none.

    `changed`: E; `part`: about P.
    """
    lowest, others = known.lowest, known.others
    size, pairs = lowest.shapes.shape[1], lowest.rates.size
    own, across = changed[:size, :size], changed[:size, size:]
    back, rest = changed[size:, :size], changed[size:, size:]
    apart = others.rates_with(rest)[: others.rates.size, None] - lowest.rates_with(own)
    inverse = 1.0 / apart
    low, high = own + lowest.diagonal(), rest + others.diagonal()
    before = 1.0
    for step in range(_STEPS):
        miss = back + high @ part - part @ (low + across @ part)
        move = others.of_states(others.of_rates(miss, pairs) * inverse, pairs)
        part = part - move
        moved, whole = float(nla.norm(move)), float(nla.norm(part))
        rate = moved / before if step else 1.0
        if not np.isfinite(moved) or (step > 3 and rate > _SLOW):
            return None
        # what the next iterations would move
        if moved * min(1.0, rate / (1.0 - _SLOW)) <= _AT_REST * whole:
            break
        before = moved or 1.0
    else:
        return None
    bound = _lowest_other(others, rest - part @ across)
    return (part, bound) if bound > 0 else None


def _lowest_other(others: Basis, rest: Matrix) -> float:
    """Return the smallest |Im λ| in Gershgorin's discs of the others."""
    entries = others.entries(rest)
    at = np.arange(others.rates.size)
    sizes = np.sqrt(entries.real**2 + entries.imag**2)
    centre = (others.rates + entries[at, at]).imag
    return float((np.abs(centre) - sizes.sum(axis=1) + sizes[at, at]).min())
