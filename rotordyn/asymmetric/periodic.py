"""Matrices of a system in the frame that turns with one of its bodies.

M q'' + V(Ω, Ωt) q' + [K(Ω, Ωt) + Ω' E] q = f. What is the same in all directions stays constant;
the rest are harmonics e^{ihΩt}, of which bearings at rest make those of h = ±2, and of ±1 where
they join what turns with the frame to what does not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import gcd
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.assembly.system import LawJoint, Side, law_slopes
from solidwhirl.rotordyn.core.arrays import FloatArray, Matrix, ReadOnlyArrays
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


class TurnedLaw(NamedTuple):
    """A bearing with a speed law, and its motion in fixed axes by harmonic, (2, n) each."""

    joint: LawJoint
    motion: Mapping[int, Matrix]


#: Matrices (n, n) by harmonic.
Harmonics = dict[int, Matrix]
# Part of a matrix of velocities that is symmetric, below which that is rounding.
_EVEN_PART = 1e-12


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class PeriodicSystem(ReadOnlyArrays):
    """Hold M (n, n), and V, K and E as sums of terms; those of −h are conjugate to those of h.

    `laws`: bearings whose coefficients depend on the speed.
    """

    mass: FloatArray
    velocity: tuple[Term, ...]
    stiffness: tuple[Term, ...]
    acceleration: tuple[Term, ...] = ()
    laws: tuple[TurnedLaw, ...] = ()

    @property
    def size(self) -> int:
        """Number of coordinates n."""
        return int(self.mass.shape[0])

    @property
    def stride(self) -> int:
        """Greatest common divisor of all harmonics; 0 where all is constant.

        The period is that of a turn divided by it.
        """
        found = {term.harmonic for term in (*self.velocity, *self.stiffness, *self.acceleration)}
        for joint, motion in self.laws:
            # of a law that does not tell its coefficients, any
            every = np.eye(4) if joint.pieces is None else joint.pieces.polynomials
            for matrix in every.reshape(-1, 2, 2):
                found |= set(_seen(motion, matrix))
        return gcd(*found)

    @property
    def is_damped(self) -> bool:
        """Whether anything takes energy."""
        return bool(self.laws) or any(
            np.abs(a + a.T).max() > _EVEN_PART * np.abs(a).max() for _, _, a in self.velocity
        )

    def at_angle_zero(self) -> PeriodicSystem:
        """Return the system at rest and at the angle 0."""
        velocity, stiffness = (
            lean([Term(0, 0, np.sum([a.real for a in parts.values()], axis=0))] if parts else [])
            for parts in self.at(0.0)
        )
        return PeriodicSystem(mass=self.mass, velocity=velocity, stiffness=stiffness)

    def at(self, speed_rad_s: float) -> tuple[Harmonics, Harmonics]:
        """Return V and K at a speed by harmonic."""
        velocity, stiffness = (at_speed(t, speed_rad_s) for t in (self.velocity, self.stiffness))
        for joint, motion in self.laws:
            spring, drag = joint.coefficients(speed_rad_s)
            _add_joint((velocity, stiffness), motion, spring, drag, speed_rad_s)
        return velocity, stiffness

    def stiffness_at_rest(self) -> FloatArray:
        """Return the even part of K that is there at rest and at all angles, (n, n)."""
        own = self.at(0.0)[1].get(0, np.zeros_like(self.mass))
        return np.asarray(0.5 * (own + own.T).real)

    def slopes(self, speed_rad_s: float, side: Side = "both") -> tuple[Harmonics, Harmonics]:
        """Return the derivatives of V and K by the speed, their harmonics as they are.

        `side`: of a corner in the table of a bearing.
        """
        velocity, stiffness = (slope_at(t, speed_rad_s) for t in (self.velocity, self.stiffness))
        for joint, motion in self.laws:
            spring, drag = law_slopes(joint, speed_rad_s, side)
            _add_joint((velocity, stiffness), motion, spring, drag, speed_rad_s)
            own = joint.coefficients(speed_rad_s)[1]
            _add_joint(({}, stiffness), motion, 0.0 * own, own, 1.0)
        return velocity, stiffness


def at_speed(terms: Sequence[Term], speed_rad_s: float) -> Harmonics:
    """Return the sum of terms at a speed by harmonic."""
    out: Harmonics = {}
    for harmonic, power, matrix in terms:
        _add(out, harmonic, speed_rad_s**power * matrix)
    return out


def slope_at(terms: Sequence[Term], speed_rad_s: float) -> Harmonics:
    """Return the derivative of terms by the speed, their harmonics as they are."""
    lower = [Term(h, power - 1, power * a) for h, power, a in terms if power]
    return at_speed(lower, speed_rad_s)


def turning_body(
    matrices: Mapping[str, FloatArray], joints: Sequence[Joint] = ()
) -> PeriodicSystem:
    """Put a body on joints to the ground.

    `matrices`: of the body in its axes, M q'' + Ω G q' + (K + Ω² K2) q = f: `mass`, `gyroscopic` G
    = 2C with C = ∫ρ v·(e_z×u), `stiffness`, `centrifugal_stiffness` K2 = Kσ − ∫ρ (e_z×v)·(e_z×u).
    """
    velocity = [Term(0, 1, matrices["gyroscopic"])]
    stiffness = [Term(0, 0, matrices["stiffness"]), Term(0, 2, matrices["centrifugal_stiffness"])]
    for motion, spring, drag in joints:
        found = joint_terms(in_fixed_axes(motion), spring, drag)
        velocity += found[0]
        stiffness += found[1]
    return PeriodicSystem(
        mass=matrices["mass"],
        velocity=lean(velocity),
        stiffness=lean(stiffness),
        acceleration=lean([Term(0, 0, 0.5 * matrices["gyroscopic"])]),
    )


def in_fixed_axes(motion: Matrix, sense: int = 1) -> Harmonics:
    """Return ux to rz of a place in fixed axes by harmonic, from those in axes that turn (6, n).

    `sense`: 1, or −1 of axes that turn backward.
    """
    found = {sense * h: part @ motion for h, part in circles(RIGID_TURN).items()}
    return {h: part for h, part in found.items() if part.any()}


def circles(turn: FloatArray) -> Harmonics:
    """Return the projectors P_h in e^{θL} = P₀ + e^{iθ} P₁ + e^{−iθ} P₋₁ of a turn L (n, n)."""
    across = -turn @ turn
    return {
        0: np.eye(len(turn)) - across,
        1: 0.5 * (across - 1j * turn),
        -1: 0.5 * (across + 1j * turn),
    }


def joint_terms(
    motion: Mapping[int, Matrix], spring: FloatArray, drag: FloatArray
) -> tuple[list[Term], list[Term]]:
    """Return the parts of V and K of a joint at rest.

    `motion`: (m, n) in fixed axes by harmonic; `spring`, `drag`: (m, m). Its force is −k u − c u'
    with u = Σ e^{ihθ} D_h q and u' = Σ e^{ihθ} (D_h q' + ihΩ D_h q).
    """
    rated = {h: 1j * h * part for h, part in motion.items()}
    velocity = [Term(h, 0, part) for h, part in _seen(motion, drag).items()]
    stiffness = [Term(h, 0, part) for h, part in _seen(motion, spring).items()]
    stiffness += [Term(h, 1, part) for h, part in _seen(motion, drag, rated).items()]
    return velocity, stiffness


def _seen(
    motion: Mapping[int, Matrix], matrix: FloatArray, second: Mapping[int, Matrix] | None = None
) -> Harmonics:
    """Σ D_aᵀ A D_b by harmonics a + b; those that cancel are left out."""
    out: Harmonics = {}
    for a, left in motion.items():
        for b, right in (motion if second is None else second).items():
            _add(out, a + b, left.T @ matrix @ right)
    size = float(np.abs(matrix).max(initial=0.0)) * max(
        (float(np.abs(d).max()) ** 2 for d in motion.values()), default=0.0
    )
    rounding = 8.0 * np.finfo(float).eps * size
    return {h: part for h, part in out.items() if np.abs(part).max() > rounding}


def _add(out: Harmonics, harmonic: int, part: Matrix) -> None:
    out[harmonic] = out[harmonic] + part if harmonic in out else part


def _add_joint(
    into: tuple[Harmonics, Harmonics],
    motion: Mapping[int, Matrix],
    spring: FloatArray,
    drag: FloatArray,
    speed: float,
) -> None:
    """Add a joint's parts of V and K at a speed."""
    for out, terms in zip(into, joint_terms(motion, spring, drag), strict=True):
        for harmonic, part in at_speed(terms, speed).items():
            _add(out, harmonic, part.real if harmonic == 0 else part)


def lean(terms: Sequence[Term]) -> tuple[Term, ...]:
    """Return terms that are there; those that do not change with the angle are real."""
    found = []
    for harmonic, power, matrix in terms:
        kept = matrix.real if harmonic == 0 else matrix
        if kept.any():
            found.append(Term(harmonic, power, np.ascontiguousarray(kept)))
    return tuple(found)
