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
# Iterates before the last one that the next one is mixed with; what keeps parallel ones apart.
_MIXED, _PARALLEL = 2, 1e-13
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

    def rates_of(self, matrix: FloatArray) -> ComplexArray:
        """Return λ, λ* and real λ that the diagonal of a matrix near Λ tells, (columns,)."""
        p, own = self.rates.size, matrix.diagonal()
        turning = matrix.diagonal(p)[:p] - matrix.diagonal(-p)[:p]
        pairs = 0.5 * (own[:p] + own[p : 2 * p] + 1j * turning)
        return np.concatenate((pairs, pairs.conj(), own[2 * p :]))

    def divisors(self, apart: ComplexArray, pairs: int) -> tuple[ComplexArray, ...]:
        """Return what `divided` multiplies by. `apart`: λ − λ'; `pairs`: how many λ' have them."""
        inverse = 1.0 / apart[: self.rates.size]
        one, other, real = np.split(inverse, (pairs, 2 * pairs), axis=1)
        return 0.5 * (one + other), 0.5j * (one - other), real

    def divided(self, matrix: FloatArray, divisors: tuple[ComplexArray, ...]) -> FloatArray:
        """Return the matrix whose entry of λ and λ' of the lowest is divided by λ − λ'."""
        same, crossed, real = divisors
        h, p = same.shape
        row = matrix[:h] - 1j * matrix[h:]
        first, second = row[:, :p], row[:, p : 2 * p]
        out = np.empty_like(matrix)
        for at, part in (
            (slice(p), same * first + crossed * second),
            (slice(p, 2 * p), same * second - crossed * first),
            (slice(2 * p, None), real * row[:, 2 * p :]),
        ):
            out[:h, at], out[h:, at] = part.real, -part.imag
        return out

    def sums_beside(self, matrix: FloatArray) -> FloatArray:
        """Return the sum of the absolute values beside the diagonal in rows of λ, (pairs,)."""
        h, at = self.rates.size, np.arange(self.rates.size)
        first, second = matrix[:h], matrix[h:]
        along = first[:, :h] + second[:, h:], first[:, h:] - second[:, :h]
        across = first[:, :h] - second[:, h:], first[:, h:] + second[:, :h]
        for part in along:
            part[at, at] = 0.0
        sizes = (np.sqrt(x * x + y * y).sum(axis=1) for x, y in (along, across))
        return np.asarray(0.5 * sum(sizes))


class WhirlBasis(NamedTuple):
    """Basis of states of z = p + i s, each with its own λ: `rates`, `shapes`, `moving`.

    As `RealBasis`.
    """

    rates: ComplexArray
    shapes: ComplexArray
    moving: ComplexArray

    def diagonal(self) -> ComplexArray:
        """Return Λ."""
        return np.diag(self.rates)

    def rates_of(self, matrix: ComplexArray) -> ComplexArray:
        """Return λ that the diagonal tells."""
        return matrix.diagonal()

    def divisors(self, apart: ComplexArray, _: int) -> tuple[ComplexArray, ...]:
        """Return what `divided` multiplies by."""
        return (1.0 / apart,)

    def divided(self, matrix: ComplexArray, divisors: tuple[ComplexArray, ...]) -> ComplexArray:
        """Return the matrix with its entries divided."""
        return matrix * divisors[0]

    def sums_beside(self, matrix: ComplexArray) -> FloatArray:
        """Return the sum of the absolute values beside the diagonal in each row."""
        sizes = np.sqrt(matrix.real**2 + matrix.imag**2)
        np.fill_diagonal(sizes, 0.0)
        return np.asarray(sizes.sum(axis=1))


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
    """A speed with its whole spectrum: lowest modes, the others, Λ, and E per cause.

    `by_spin`: E per rad/s, `by_square`: per (rad/s)² of the centrifugal stiffness.
    """

    speed_rad_s: float
    lowest: Basis
    others: Basis
    modal: Matrix
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
    modal = la.block_diag(lowest.diagonal(), others.diagonal())
    if not la.norm(found - modal[:size, :size]) <= _GOOD * la.norm(modal[:size, :size]):
        return None
    square = problem.centrifugal
    return Known(
        speed_rad_s=speed_rad_s,
        lowest=lowest,
        others=others,
        modal=modal,
        by_spin=-dual @ (problem.turning @ bottom + problem.circulating @ top),
        by_square=-dual @ (square @ top) if square.any() else None,
        laws=tuple(
            Law(joint, dual @ motion.conj().T, motion @ top, motion @ bottom)
            for joint, motion in joints
        ),
    )


def matrix_at(known: Known, speed_rad_s: float) -> Matrix:
    """Return A = Λ + E at a speed."""
    found = known.modal + (speed_rad_s - known.speed_rad_s) * known.by_spin
    if known.by_square is not None:
        found += (speed_rad_s**2 - known.speed_rad_s**2) * known.by_square
    for law in known.laws:
        there = law.joint.coefficients(speed_rad_s)
        here = law.joint.coefficients(known.speed_rad_s)
        r = len(law.shapes)
        k, c = (a[:r, :r] - b[:r, :r] for a, b in zip(there, here, strict=True))
        found -= law.pushed @ (k @ law.shapes + c @ law.moving)
    return np.asarray(found)


class Mixer:
    """Iterates P + f(P) that come to rest earlier by what the last steps tell (Anderson 1965)."""

    def __init__(self) -> None:
        self._last: list[Matrix] = []
        self._turns: list[Matrix] = []
        self._steps: list[Matrix] = []

    def after(self, part: Matrix, move: Matrix) -> tuple[Matrix, float]:
        """Return the next iterate, and about how far P + f is from rest, over |f|.

        The changes of P + f and f in the last steps tell that distance, and of all sums with these
        changes the iterate is where f is least.
        """
        found, last, self._last = part + move, self._last, [part + move, move]
        if not last:
            return found, 1.0
        self._turns = [move - last[1], *self._turns[: _MIXED - 1]]
        self._steps = [found - last[0], *self._steps[: _MIXED - 1]]
        gram = np.array([[np.vdot(a, b) for b in self._turns] for a in self._turns])
        sizes = np.sqrt(gram.diagonal().real)
        if not sizes.all():
            return found, 1.0
        distances = [float(nla.norm(step)) for step in self._steps] / sizes
        wanted = np.array([np.vdot(turn, move) for turn in self._turns])
        weights = nla.solve(gram + np.diag(_PARALLEL * sizes**2), wanted)
        for weight, step in zip(weights, self._steps, strict=True):
            found = found - weight * step
        return found, float(distances.max())


class Followed(NamedTuple):
    """P, the matrix Λ1 + E11 + E12 P, and a frequency below which no other mode lies."""

    part: Matrix
    low: Matrix
    bound: float


def followed(known: Known, matrix: Matrix, part: Matrix) -> Followed | None:
    """Return the subspace of the lowest modes, or None if there is none.

    `matrix`: A; `part`: about P.
    """
    lowest, others = known.lowest, known.others
    size = lowest.shapes.shape[1]
    own, across = matrix[:size, :size], matrix[:size, size:]
    back, rest = matrix[size:, :size], matrix[size:, size:]
    apart = others.rates_of(rest)[:, None] - lowest.rates_of(own)
    divisors = others.divisors(apart, lowest.rates.size)
    mixer = Mixer()
    before = np.inf
    for step in range(_STEPS):
        move = others.divided(part @ (own + across @ part) - back - rest @ part, divisors)
        moved, whole = float(nla.norm(move)), float(nla.norm(part))
        if not np.isfinite(moved) or (step > 3 and moved > _SLOW * before):
            return None
        before = moved
        part, farther = mixer.after(part, move)
        if moved * max(farther, min(1.0, farther / (1.0 - _SLOW))) <= _AT_REST * whole:
            break
    else:
        return None
    bound = _lowest_other(others, rest - part @ across)
    return Followed(part, own + across @ part, bound) if bound > 0 else None


def _lowest_other(others: Basis, rest: Matrix) -> float:
    """Return the smallest |Im λ| in Gershgorin's discs of the others."""
    centre = others.rates_of(rest)[: others.rates.size].imag
    return float((np.abs(centre) - others.sums_beside(rest)).min())
