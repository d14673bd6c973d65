"""Matrices of a body in the frame that turns with it, on what does not turn.

M q'' + V(Ω, Ωt) q' + K(Ω, Ωt) q = f. What is the same in all directions stays constant; the rest
are harmonics e^{ihΩt}, of which bearings make those of h = ±2, and of ±1 where they couple motions
across the axis to those along it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import gcd
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, Matrix, ReadOnlyArrays
from solidwhirl.rotordyn.superelement.rigid_body import RIGID_TURN


class Term(NamedTuple):
    """Part Ω^power e^{i harmonic Ωt} of a matrix."""

    harmonic: int
    power: int
    matrix: Matrix


class Joint(NamedTuple):
    """Stiffness and damping at rest against the motion of a place of the body.

    `motion`: (6, n) ux to rz in the axes of the body; `stiffness`, `damping`: (6, 6) in fixed axes.
    """

    motion: FloatArray
    stiffness: FloatArray
    damping: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class PeriodicSystem(ReadOnlyArrays):
    """Hold M (n, n), and V and K as sums of terms; those of −h are the conjugates of those of h."""

    mass: FloatArray
    velocity: tuple[Term, ...]
    stiffness: tuple[Term, ...]

    @property
    def size(self) -> int:
        """Number of coordinates n."""
        return int(self.mass.shape[0])

    @property
    def stride(self) -> int:
        """Greatest common divisor of all harmonics; 0 where all is constant.

        The period is that of a turn divided by it.
        """
        return gcd(*(term.harmonic for term in (*self.velocity, *self.stiffness)))


def at_speed(terms: Sequence[Term], speed_rad_s: float) -> dict[int, Matrix]:
    """Return the sum of terms at a speed by harmonic."""
    out: dict[int, Matrix] = {}
    for harmonic, power, matrix in terms:
        part = speed_rad_s**power * matrix
        out[harmonic] = out[harmonic] + part if harmonic in out else part
    return out


def slope_at(terms: Sequence[Term], speed_rad_s: float) -> dict[int, Matrix]:
    """Return the derivative of terms by the speed, their harmonics as they are."""
    lower = [Term(h, power - 1, power * a) for h, power, a in terms if power]
    return at_speed(lower, speed_rad_s)


def turning_body(
    matrices: Mapping[str, FloatArray], joints: Sequence[Joint] = ()
) -> PeriodicSystem:
    """Put a body on joints to the ground.

    `matrices`: of the body in its axes, M q'' + Ω G q' + (K + Ω² K2) q = f: `mass`, `gyroscopic` G
    = 2C with C = ∫ρ v·(e_z×u), `stiffness`, `centrifugal_stiffness` K2 = Kσ − ∫ρ (e_z×v)·(e_z×u).
    A joint's force in the axes of the body is −e^{−θL} [k e^{θL} u + c (e^{θL} u)'] with u =
    `motion` q and L = `RIGID_TURN`, whose e^{θL} leads from the body's axes to fixed ones.
    """
    velocity = [Term(0, 1, matrices["gyroscopic"])]
    stiffness = [Term(0, 0, matrices["stiffness"]), Term(0, 2, matrices["centrifugal_stiffness"])]
    for motion, spring, drag in joints:
        for harmonic, part in turned(spring).items():
            stiffness.append(Term(harmonic, 0, motion.T @ part @ motion))
        for harmonic, part in turned(drag).items():
            velocity.append(Term(harmonic, 0, motion.T @ part @ motion))
            stiffness.append(Term(harmonic, 1, motion.T @ part @ RIGID_TURN @ motion))
    return PeriodicSystem(
        mass=matrices["mass"], velocity=_lean(velocity), stiffness=_lean(stiffness)
    )


def turned(matrix: FloatArray) -> dict[int, ComplexArray]:
    """Return e^{−θL} A e^{θL} by harmonics of θ, for A on ux uy uz rx ry rz.

    e^{θL} = P₀ + e^{iθ} P₊ + e^{−iθ} P₋ with the projectors on the eigenvectors of L, so that the
    part of e^{ihθ} is the sum of all P_aᴴ A P_b with b − a = h.
    """
    across = -RIGID_TURN @ RIGID_TURN
    parts = {
        0: np.eye(6) - across,
        1: 0.5 * (across - 1j * RIGID_TURN),
        -1: 0.5 * (across + 1j * RIGID_TURN),
    }
    out: dict[int, ComplexArray] = {}
    for a, left in parts.items():
        for b, right in parts.items():
            found = left.conj().T @ matrix @ right
            out[b - a] = out.get(b - a, np.zeros((6, 6), dtype=complex)) + found
    return out


def _lean(terms: Sequence[Term]) -> tuple[Term, ...]:
    """Terms that are there; those that do not change with the angle are real."""
    found = []
    for harmonic, power, matrix in terms:
        kept = matrix.real if harmonic == 0 else matrix
        if kept.any():
            found.append(Term(harmonic, power, np.ascontiguousarray(kept)))
    return tuple(found)
