"""Ranges of speed in which a periodic system is unstable.

Two roads that share nothing but the matrices: the exponents of a period, in few coordinates, tell
where to look; Hill's method, in all of them, has the last word on every end and growth.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from solidwhirl.rotordyn.asymmetric.parametric.basis import fastest_rate, highest_rate, search_basis
from solidwhirl.rotordyn.asymmetric.parametric.constant import ConstantMotions
from solidwhirl.rotordyn.asymmetric.parametric.exponents import PeriodicMotions
from solidwhirl.rotordyn.asymmetric.parametric.floquet import floquet_multipliers
from solidwhirl.rotordyn.asymmetric.parametric.growing_pieces import Piece, Search
from solidwhirl.rotordyn.asymmetric.parametric.hill_roots import (
    Converged,
    Root,
    Sought,
    converged_root,
)
from solidwhirl.rotordyn.asymmetric.parametric.meetings import (
    Meeting,
    beyond_strides,
    of_modes,
    with_itself,
)
from solidwhirl.rotordyn.asymmetric.periodic import PeriodicSystem, Term
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.modes.damping import NEUTRAL

# Harmonics of Hill's method to begin with.
_FIRST = 3
# Harmonics to begin with where that led both ends of a range to one, and how near these are then,
# over the width of the range.
_AGAIN, _ONE_END = 8, 1e-3
# Coordinates that are few.
_FEW = 16
# A motion that turns slower than this part of its rate stands still.
_STILL = 1e-6
# Part of the width of a range by which its ends, and of its growth by which that, may still move
# when a harmonic is added.
_STAYS = 1e-7
# Accuracy of the multipliers beside it.
_CLOSE = 1e-9
# Growth by the speed that is rounding of Hill's method.
_ROUNDING = 1e-12
# Distance from the end of a range at which modes that meet are told apart, and in its middle what
# they make: part of the width, and of the speed at most.
_BESIDE, _NEAR = 0.2, 0.01
# Pieces of the search may be narrower than the range, by this factor.
_MAYBE = 0.3
# Part of the speed by which an end may lie elsewhere than in the coordinates of the search.
_SHIFT = 1e-3


@dataclass(frozen=True, kw_only=True, slots=True)
class UnstableRange:
    """Hold a range of speeds in which some motion grows.

    `low_rad_s`, `high_rad_s`: its ends; `opens`, `closes`: whether growth begins and ends there, or
    the range that was searched does. `growth_1_s`: largest growth, at `speed_rad_s`; `floquet_1_s`:
    the same by the multipliers of a period, which share nothing with Hill's method but the
    matrices, in the coordinates of the search. `frequency_rad_s`: of that motion in the frame of
    the body, up to whole strides of the speed: between 0 and half a stride; 0: it stands still in
    the body (divergence). `meeting`: the modes that drive each other; None if it neither opens nor
    closes. `error_rad_s`: how far the last harmonic moved the ends.
    """

    low_rad_s: float
    high_rad_s: float
    opens: bool
    closes: bool
    growth_1_s: float
    speed_rad_s: float
    floquet_1_s: float
    frequency_rad_s: float
    kind: Literal["flutter", "divergence"]
    meeting: Meeting | None
    error_rad_s: float


def unstable_ranges(
    system: PeriodicSystem,
    speed_low_rad_s: float,
    speed_high_rad_s: float,
    narrowest: float = 1e-4,
) -> tuple[UnstableRange, ...]:
    """Find all ranges of speed in which some motion grows.

    `narrowest`: width of a range that is looked for, as a part of all speeds. Raises AnalysisError:
    speeds that are not positive and rising, or a motion that takes too many harmonics.
    """
    if not 0.0 < speed_low_rad_s < speed_high_rad_s < np.inf:
        raise AnalysisError(
            f"speeds are {speed_low_rad_s} to {speed_high_rad_s}; both are above 0 and rise"
        )
    low, high = speed_low_rad_s, speed_high_rad_s
    found = _searched(system, low, high, narrowest * (high - low)).ranges()
    return tuple(r for r in found if r.high_rad_s - r.low_rad_s > narrowest * (high - low))


def closed_by_damping(
    system: PeriodicSystem,
    speed_low_rad_s: float,
    speed_high_rad_s: float,
    left: Sequence[UnstableRange],
    narrowest: float = 1e-4,
) -> tuple[UnstableRange, ...]:
    """Find the ranges in which a system would be unstable without damping, and is not with it.

    `left`: those with damping, as `unstable_ranges` finds them; other arguments and errors as
    there. A range counts as closed if none that is left has a speed in common with it. One that
    neither opens nor closes is left out, cross-coupled bearings need their damping at every speed;
    and so is one whose ends Hill's method does not find.
    """
    width = narrowest * (speed_high_rad_s - speed_low_rad_s)
    search = _searched(_undamped(system), speed_low_rad_s, speed_high_rad_s, width)
    return tuple(
        r
        for r in search.ranges(unless_lost=True)
        if r.high_rad_s - r.low_rad_s > width
        and (r.opens or r.closes)
        and all(r.high_rad_s < o.low_rad_s or o.high_rad_s < r.low_rad_s for o in left)
    )


def _undamped(system: PeriodicSystem) -> PeriodicSystem:
    """The system without forces of damping: the even part of V, and what it adds to K with Ω."""
    velocity = [Term(h, p, 0.5 * (a - a.T)) for h, p, a in system.velocity]
    return replace(
        system,
        velocity=tuple(term for term in velocity if term.matrix.any()),
        stiffness=tuple(term for term in system.stiffness if term.power % 2 == 0),
    )


def _searched(system: PeriodicSystem, low: float, high: float, width: float) -> _Found:
    """Search among the motions that may meet by the first and second harmonic of the matrices.

    With the stride g, ω_j + ω_k = m gΩ of m = 1 has no motion above gΩ, of m = 2 none above 2gΩ.
    Among few coordinates all are taken in.
    """
    return _Found(system, _motions(system, low, high), (low, high), width)


def _motions(system: PeriodicSystem, low: float, high: float) -> ConstantMotions | PeriodicMotions:
    """Motions of a system between two speeds."""
    if not system.stride:
        return ConstantMotions(system, low, high)
    fastest = fastest_rate(system, high)
    if system.size <= _FEW:
        fastest = max(fastest, highest_rate(system))
    return PeriodicMotions(system, search_basis(system, fastest, high), fastest)


def growth_over_speed(
    system: PeriodicSystem, speeds_rad_s: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Return the largest Re λ of all motions at speeds from 0 on, 1/s, and how many grow; (s,).

    An oscillation counts once.
    """
    high = float(np.max(speeds_rad_s)) or 1.0
    turning, growth, count = _motions(system, 0.5 * high, high), [], []
    for speed in np.asarray(speeds_rad_s, dtype=float).tolist():
        still = speed == 0.0 and system.stride
        own = ConstantMotions(system.at_angle_zero(), 0.5 * high, high) if still else turning
        found = own.solve(speed)
        growing = found.values[found.excess > 0.0]
        # one that meets its own conjugate, up to whole strides, has no other
        alone = [
            abs(beyond_strides(2.0 * v, found.stride * speed)) <= _STILL * max(abs(v), speed)
            for v in growing.imag.tolist()
        ]
        growth.append(float(found.own.real.max(initial=-np.inf)))
        count.append(round(float(np.where(alone, 1.0, 0.5).sum())))
    return np.array(growth), np.array(count, dtype=int)


class _Found:
    """Pieces of the range of speeds that grow, and what Hill's method makes of them."""

    def __init__(
        self,
        system: PeriodicSystem,
        motions: ConstantMotions | PeriodicMotions,
        speeds: tuple[float, float],
        width: float,
    ) -> None:
        self._system, self._motions, self._width = system, motions, width
        self._search: Search[Any] = Search(motions, (), *speeds, width)
        self._pieces = self._search.pieces()

    def ranges(self, *, unless_lost: bool = False) -> list[UnstableRange]:
        """Return the ranges of all pieces that may be wide enough.

        `unless_lost`: leave those out whose ends are not found, which is an error otherwise.
        """
        found = []
        for piece in self._pieces:
            if piece.high - piece.low > _MAYBE * self._width:
                with suppress(AnalysisError) if unless_lost else nullcontext():
                    found.append(self._range(piece))
        return [one for one in found if one is not None]

    def _range(self, piece: Piece) -> UnstableRange | None:
        """Return the range of a piece; None where Hill's method finds no growth."""
        opens, closes = self._search.ends_inside(piece)
        first, last = self._ends(piece, opens, closes)
        low = first.root.speed_rad_s if first else piece.low
        high = last.root.speed_rad_s if last else piece.high
        if high <= low:
            return None
        speed = self._search.highest(piece)
        speed = speed if low <= speed <= high else 0.5 * (low + high)
        top = self._top(speed)
        if top is None:
            return None
        beat = self._system.stride * speed
        rest = abs(beyond_strides(top.imag, beat))
        still = rest <= _STILL * max(speed, beat)
        known = floquet_multipliers(self._system, speed, _CLOSE, self._motions.basis)
        return UnstableRange(
            low_rad_s=low,
            high_rad_s=high,
            opens=opens,
            closes=closes,
            growth_1_s=top.real,
            speed_rad_s=speed,
            floquet_1_s=known.growth_1_s,
            frequency_rad_s=0.0 if still else rest,
            kind="divergence" if still else "flutter",
            meeting=self._meeting(first or last, piece),
            error_rad_s=self._error((opens, first, low), (closes, last, high)),
        )

    def _error(self, *ends: tuple[bool, Converged | None, float]) -> float:
        """How far ends may lie elsewhere: those that were not found are those of the search."""
        return max(
            (
                0.0 if not inside else end.moved_rad_s if end else _SHIFT * speed
                for inside, end, speed in ends
            ),
            default=0.0,
        )

    def _top(self, speed: float) -> complex | None:
        """Return the eigenvalue that grows most at a speed; None if by Hill's method none does."""
        found = self._search.at(speed)
        start = self._motions.root(found, int(found.excess.argmax()), _FIRST)
        allowed = max(_STAYS * abs(start.value.real), _ROUNDING * speed)
        top = self._hill(start, "growth", (np.inf, allowed))
        if top is None:
            return None
        value = top.root.value
        # what the search counts as neutral is neutral in all coordinates too
        least = NEUTRAL * max(abs(value), self._system.stride * speed)
        return value if value.real > least else None

    def _hill(self, start: Root, sought: Sought, allowed: tuple[float, float]) -> Converged | None:
        return converged_root(self._system, self._motions.basis, start, sought, allowed)

    def _ends(
        self, piece: Piece, opens: bool, closes: bool
    ) -> tuple[Converged | None, Converged | None]:
        """Return where growth begins and where it ends.

        From few harmonics both ends of a narrow range may be led to the same one.
        """
        for order in (_FIRST, _AGAIN):
            first = self._end(piece.low, piece.high, order) if opens else None
            last = self._end(piece.high, piece.low, order) if closes else None
            width = piece.high - piece.low
            if not (first and last):
                break
            if last.root.speed_rad_s - first.root.speed_rad_s > _ONE_END * width:
                break
        return first, last

    def _end(self, speed: float, other: float, order: int) -> Converged | None:
        """Return where growth begins or ends at a speed; it grows towards the other.

        Without damping two motions meet there, else one of them crosses the axis. None: not found,
        as where a third motion is near.
        """
        search = self._search
        value = search.at_end(speed, other)
        found = search.at(speed)
        start = self._motions.root(found, found.nearest(value)[0], order)
        start = start._replace(value=1j * start.value.imag)
        step = 2.0 * search.accuracy(speed, other) * (1 if speed > other else -1)
        beyond = search.at(min(max(speed + step, search.low), search.high))
        index, after = beyond.nearest(value)
        damped = after.real < -beyond.tolerance[index]
        ways: tuple[Sought, Sought] = ("crossing", "meeting") if damped else ("meeting", "crossing")
        width = abs(other - speed)
        for sought in ways:
            end = self._hill(start, sought, (_STAYS * width, np.inf))
            if end and abs(end.root.speed_rad_s - speed) < 0.5 * width + _SHIFT * speed:
                return end
        return None

    def _meeting(self, end: Converged | None, piece: Piece) -> Meeting | None:
        """Return the modes that what grows is made of, as they are beside the end of a range."""
        if end is None:
            return None
        speed, turning = end.root.speed_rad_s, end.root.value.imag
        beat = self._system.stride * speed
        if abs(beyond_strides(2.0 * turning, beat)) <= _STILL * max(speed, beat):
            return with_itself(end.root, beat)
        width = piece.high - piece.low
        outward = 1.0 if 2.0 * speed > piece.low + piece.high else -1.0
        low, high = self._search.low, self._search.high
        beside, growing = (
            self._search.at(min(max(speed + side * min(part * width, _NEAR * speed), low), high))
            for side, part in ((outward, _BESIDE), (-outward, 0.5))
        )
        parts = self._motions.alike(beside, growing)[0][:, growing.excess.argmax()]
        return of_modes(turning, beside.values.imag, parts, beat)
