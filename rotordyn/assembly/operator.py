"""An assembled system as one operator: laws read exactly, controllers as states."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.frequency_laws import FrequencyLaw
from solidwhirl.rotordyn.assembly.magnetic_laws import magnetic_bearing
from solidwhirl.rotordyn.assembly.system import AssembledSystem, LawJoint, law_slopes
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.second_order import Joint, SecondOrder, Term, Triple

# Relative step of a derivative over the speed by differences, and the least one, rad/s.
_STEP, _LEAST_STEP = 1e-6, 1e-4
# A frequency above all others, for the limit of quick motions; samples of a smooth law for each
# factor of ten.
_QUICK, _PER_DECADE = 1e9, 6
# Whether a place at a knot belongs to the interval before it or beyond.
_RIGHT: dict[int, Literal["left", "right"]] = {-1: "left", 1: "right"}
_SIDES = {-1: "below", 0: "both", 1: "above"}


@dataclass(frozen=True, eq=False)
class SpeedLaw:
    """A bearing whose coefficients depend on the speed."""

    joint: LawJoint
    frequency_knots: tuple[float, ...] = ()

    @property
    def speed_knots(self) -> tuple[float, ...]:
        """Knots of its table or pieces."""
        return self.joint.knots_rad_s

    def at(self, speed: float, frequency: float) -> Triple:
        """Return no M, and V and K at the speed."""
        stiffness, damping = self.joint.coefficients(speed)
        return Triple(np.zeros_like(stiffness), damping, stiffness)

    def by_speed(self, speed: float, frequency: float, side: int) -> Triple:
        """Return their derivatives."""
        stiffness, damping = law_slopes(self.joint, speed, _SIDES[side])  # type: ignore[arg-type]
        return Triple(np.zeros_like(stiffness), damping, stiffness)

    def by_frequency(self, speed: float, frequency: float, side: int) -> Triple:
        """Return zeros."""
        none = np.zeros((len(self.joint.motion),) * 2)
        return Triple(none, none, none)


@dataclass(frozen=True, eq=False)
class _FrequencyLaw:
    """A bearing whose coefficients depend on speed and frequency."""

    law: FrequencyLaw
    ratio: float
    #: Frequencies that stand for knots where the law is none of a table.
    sampled: tuple[float, ...] = ()

    @property
    def speed_knots(self) -> tuple[float, ...]:
        knots = self.law.knots_of_speed if self.ratio else ()
        return tuple(knot / self.ratio for knot in knots if knot > 0)

    @property
    def frequency_knots(self) -> tuple[float, ...]:
        return self.law.knots_of_frequency if self.law.is_table else self.sampled

    def at(self, speed: float, frequency: float) -> Triple:
        stiffness, damping, mass = self.law.at_frequency(abs(self.ratio * speed), frequency)
        return Triple(mass, damping, stiffness)

    def by_speed(self, speed: float, frequency: float, side: int) -> Triple:
        return _slope(lambda place: self.at(place, frequency), speed, side)

    def by_frequency(self, speed: float, frequency: float, side: int) -> Triple:
        if not self.law.is_table:
            return _slope(lambda place: self.at(speed, place), frequency, side)
        # a table is linear between its knots, and constant beyond them
        knots = np.array(self.frequency_knots)
        sides = (-1, 1) if side == 0 else (side,)
        places = [int(np.searchsorted(knots, frequency, _RIGHT[one])) for one in sides]
        ends = [(knots[k - 1], knots[k]) for k in places if 0 < k < knots.size]
        found = Triple(*(np.zeros((self.law.size,) * 2) for _ in range(3)))
        for low, high in ends:
            rise = zip(self.at(speed, low), self.at(speed, high), found, strict=True)
            found = Triple(*(c + (b - a) / (high - low) / len(sides) for a, b, c in rise))
        return found


def _slope(values: Callable[[float], Triple], place: float, side: int) -> Triple:
    """Return the derivative by differences of second order, on one side or both."""
    step = max(_STEP * abs(place), _LEAST_STEP)
    if side == 0:
        weights = {-1: -0.5, 1: 0.5}
    else:
        weights = {0: -1.5 * side, side: 2.0 * side, 2 * side: -0.5 * side}
    found = {at: values(place + at * step) for at in weights}
    parts = ([weight / step * found[at][k] for at, weight in weights.items()] for k in range(3))
    return Triple(*(np.asarray(sum(part)) for part in parts))


@lru_cache(maxsize=16)
def operator_of(assembled: AssembledSystem) -> SecondOrder:
    """Return a system as an operator on its coordinates, then the states of controllers.

    Magnetic bearings become states, exactly, integrators and all; other laws stay laws of the speed
    and of the frequency |Im s|.
    """
    terms = (
        Term(0, assembled.mass),
        Term(1, assembled.damping),
        Term(1, assembled.gyroscopic, 1),
        Term(2, assembled.stiffness),
        Term(2, assembled.circulatory_stiffness, 1),
        Term(2, assembled.centrifugal_stiffness, 2),
    )
    kept = tuple(term for place, term in enumerate(terms) if not place or term.matrix.any())
    operator = SecondOrder(kept)
    joints, magnetic = [], []
    for joint in assembled.law_joints:
        if magnetic_bearing(joint.law) is not None:
            magnetic.append(joint)
        elif joint.frequency_law is not None:
            own = joint.frequency_law
            sampled = () if own.is_table else _samples(assembled, joint)
            law = _FrequencyLaw(own, abs(joint.speed_ratio), sampled)
            joints.append(Joint(joint.motion, law))
        else:
            joints.append(Joint(joint.motion, SpeedLaw(joint)))
    operator = SecondOrder(kept, tuple(joints))
    for joint in magnetic:
        operator = _with_controller(operator, joint)
    return operator


def _samples(assembled: AssembledSystem, joint: LawJoint) -> tuple[float, ...]:
    """Return frequencies from far below all modes to far above, at which a smooth law is read."""
    law = joint.frequency_law
    assert law is not None
    ends = []
    for frequency in (0.0, _QUICK):
        stiffness = law.at_frequency(0.0, frequency).stiffness_n_per_m
        whole = assembled.stiffness + joint.motion.T @ stiffness @ joint.motion
        rates = np.abs(la.eigh(0.5 * (whole + whole.T), assembled.mass, eigvals_only=True))
        ends += [np.sqrt(rates[rates > 1e-12 * rates.max()])]
    sizes = np.concatenate(ends)
    low, high = 0.1 * float(sizes.min(initial=1.0)), 3.0 * float(sizes.max(initial=10.0))
    count = max(2, int(np.ceil(_PER_DECADE * np.log10(high / low))))
    return (0.0, *np.geomspace(low, high, count).tolist())


def _with_controller(operator: SecondOrder, joint: LawJoint) -> SecondOrder:
    """Return an operator with a magnetic bearing: force ks u − ki H y of what the sensors see."""
    bearing = magnetic_bearing(joint.law)
    assert bearing is not None
    magnets, sensors = (_with_room(rows, operator.size) for rows in _rows(joint))
    held = -bearing.negative_stiffness_n_per_m * magnets.T @ magnets
    controller, gain = bearing.controller, bearing.current_stiffness_n_per_a
    own = (controller.a, controller.b, gain * controller.c, gain * controller.d)
    with_states = operator.with_states(magnets, sensors, own, gain * controller.gain_of_rate)
    first, *others = with_states.terms
    room = len(controller.a)
    more = Term(2, np.pad(held, ((0, room), (0, room))))
    return SecondOrder((first, *others, more), with_states.joints, with_states.states)


def _rows(joint: LawJoint) -> tuple[FloatArray, FloatArray]:
    return joint.motion[:2], joint.motion[-2:]


def _with_room(rows: FloatArray, size: int) -> FloatArray:
    """Return rows on the coordinates and states before this bearing's own."""
    return np.pad(rows, ((0, 0), (0, size - rows.shape[1])))
