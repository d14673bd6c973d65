"""One operator for all linear problems: P(s) = s² M + s V(Ω, ω) + K(Ω, ω), with ω = |Im s|.

Matrices come by powers of the speed Ω; laws act on few rows each and are read at a speed and at a
frequency ω. Controllers are states, coordinates without mass.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.core.arrays import (
    ComplexArray,
    FloatArray,
    Matrix,
    real_times,
)


class Triple(NamedTuple):
    """M, V and K of an operator at one speed and frequency, or their changes, each (n, n).

    Or what they make of columns x, M x, V x and K x, (n, m) each, with a rate for each column.
    """

    mass: Matrix
    velocity: Matrix
    stiffness: Matrix

    def value(self, rate: complex | ComplexArray) -> ComplexArray:
        """Return P(s), or P(s_j) x_j."""
        return np.asarray((rate * self.mass + self.velocity) * rate + self.stiffness)

    def slope(self, rate: complex | ComplexArray) -> ComplexArray:
        """Return dP/ds, or P'(s_j) x_j, with the laws frozen."""
        return np.asarray(2.0 * rate * self.mass + self.velocity)

    def times(self, vectors: Matrix) -> Triple:
        """Return M x, V x and K x of columns x (n, m)."""
        return Triple(*(times(matrix, vectors) for matrix in self))


def times(matrix: Matrix, vectors: Matrix) -> Matrix:
    """Return the product of a matrix (n, n) with columns (n, m)."""
    if not matrix.any():
        return np.zeros_like(vectors)
    if np.isrealobj(matrix) and np.iscomplexobj(vectors):
        return real_times(matrix, vectors)
    return np.asarray(matrix @ vectors)


class Term(NamedTuple):
    """A matrix times Ω^power in M, V or K: place 0, 1 or 2 of a `Triple`."""

    place: int
    matrix: Matrix
    power: int = 0


class JointLaw(Protocol):
    """What a law on r motions is at a speed Ω and a frequency ω, and how it changes with them.

    `speed_knots`, `frequency_knots`: where it is not smooth, rad/s, rising, not negative; below the
    first and beyond the last frequency it is constant, or changes next to nothing.
    """

    @property
    def speed_knots(self) -> tuple[float, ...]:
        """Speeds at which the law is not smooth."""

    @property
    def frequency_knots(self) -> tuple[float, ...]:
        """Frequencies at which the law is not smooth; none where it does not depend on ω."""

    def at(self, speed: float, frequency: float) -> Triple:
        """Return M, V and K on the motions, (r, r) each."""

    def by_speed(self, speed: float, frequency: float, side: int) -> Triple:
        """Return the derivatives by Ω: at a knot below (−1), above (1), or the mean (0)."""

    def by_frequency(self, speed: float, frequency: float, side: int) -> Triple:
        """Return the derivatives by ω, likewise."""


class Joint(NamedTuple):
    """A law on the motions `rows` (r, n)."""

    rows: Matrix
    law: JointLaw


@dataclass(frozen=True, eq=False)
class SecondOrder:
    """Hold an operator s² M + s V(Ω, ω) + K(Ω, ω) on n coordinates, real or complex.

    `terms`: its matrices, (n, n) each; the first one is of M. `joints`: laws on few motions.
    `states`: how many coordinates, the last ones, are of first order: they have no mass.
    """

    terms: tuple[Term, ...]
    joints: tuple[Joint, ...] = ()
    states: int = 0

    @property
    def size(self) -> int:
        """Number of coordinates n, states among them."""
        return len(self.terms[0].matrix)

    @property
    def root_count(self) -> int:
        """Number of roots 2n less one for each state; some may be infinite."""
        return 2 * self.size - self.states

    @cached_property
    def is_real(self) -> bool:
        """Whether all matrices are real, so that roots come in conjugate pairs."""
        rows = [joint.rows for joint in self.joints]
        return all(np.isrealobj(matrix) for matrix in [*(t.matrix for t in self.terms), *rows])

    @cached_property
    def speed_knots(self) -> tuple[float, ...]:
        """Speeds at which a law is not smooth, rad/s, rising."""
        return tuple(sorted({knot for joint in self.joints for knot in joint.law.speed_knots}))

    @cached_property
    def frequency_knots(self) -> tuple[float, ...]:
        """Frequencies at which a law is not smooth, rad/s, rising."""
        return tuple(sorted({knot for joint in self.joints for knot in joint.law.frequency_knots}))

    def at(self, speed: float, frequency: float = 0.0) -> Triple:
        """Return M, V and K at a speed, laws as they are at a frequency, both rad/s."""
        return self._sum(lambda power: speed**power, lambda law: law.at(speed, frequency))

    def by_speed(self, speed: float, frequency: float = 0.0, side: int = 0) -> Triple:
        """Return the derivatives by the speed at a constant frequency; `side` as of `JointLaw`."""
        return self._sum(
            lambda power: power * speed ** (power - 1) if power else 0.0,
            lambda law: law.by_speed(speed, frequency, side),
        )

    def by_frequency(self, speed: float, frequency: float, side: int = 0) -> Triple:
        """Return the derivatives by the frequency at which laws are read."""
        return self._sum(lambda _: 0.0, lambda law: law.by_frequency(speed, frequency, side))

    def along(self, speed: float, whirl_ratio: float, side: int = 0) -> Triple:
        """Return the derivatives by the speed, laws being read at |whirl_ratio · Ω|."""
        ratio = abs(whirl_ratio)
        found = self.by_speed(speed, ratio * abs(speed), side)
        if not ratio or not self.frequency_knots:
            return found
        sense = -1 if speed < 0 or (speed == 0 and side < 0) else 1
        more = self.by_frequency(speed, ratio * abs(speed), side * sense)
        return Triple(*(a + sense * ratio * b for a, b in zip(found, more, strict=True)))

    def _sum(self, factor: Callable[[int], float], of: Callable[[JointLaw], Triple]) -> Triple:
        out = [np.zeros_like(self.terms[0].matrix) for _ in range(3)]
        for place, matrix, power in self.terms:
            if (times := factor(power)) != 0.0:
                out[place] = out[place] + times * matrix
        for rows, law in self.joints:
            for place, values in enumerate(of(law)):
                if values.any():
                    out[place] = out[place] + rows.conj().T @ values @ rows
        return Triple(*out)

    def with_states(
        self, out: Matrix, seen: Matrix, abcd: Sequence[FloatArray], rate: FloatArray | None = None
    ) -> SecondOrder:
        """Return the operator with the force −outᵀ u, x' = A x + B y, u = C x + D y + R y'.

        `out`, `seen`: rows of the force and of what is seen, y = seen · q, (m, n) and (p, n);
        `abcd`: A, B, C, D of the controller; `rate`: R, (m, p). Exact: no law is frozen.
        """
        a, b, c, d = (np.atleast_2d(matrix) for matrix in abcd)
        n, new = self.size, len(a)
        stiffness, velocity = np.zeros((2, n + new, n + new))
        stiffness[:n, :n], stiffness[:n, n:] = out.T @ d @ seen, out.T @ c
        stiffness[n:, :n], stiffness[n:, n:] = -b @ seen, -a
        velocity[n:, n:] = np.eye(new)
        if rate is not None:
            velocity[:n, :n] = out.T @ rate @ seen
        none = np.zeros((new, new))
        terms = (t._replace(matrix=la.block_diag(t.matrix, none)) for t in self.terms)
        joints = (j._replace(rows=np.pad(j.rows, ((0, 0), (0, new)))) for j in self.joints)
        return SecondOrder(
            (*terms, Term(1, velocity), Term(2, stiffness)), tuple(joints), self.states + new
        )
