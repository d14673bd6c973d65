"""Ranges of speed in which a periodic system is unstable.

Two roads that share nothing but the matrices: the exponents of a period, in few coordinates, tell
where to look; Hill's method, in all of them, has the last word on every end and growth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np

from solidwhirl.rotordyn.asymmetric.basis import search_basis
from solidwhirl.rotordyn.asymmetric.constant import ConstantMotions
from solidwhirl.rotordyn.asymmetric.exponents import PeriodicMotions
from solidwhirl.rotordyn.asymmetric.floquet import floquet_multipliers
from solidwhirl.rotordyn.asymmetric.hill_roots import Converged, converged_root
from solidwhirl.rotordyn.asymmetric.periodic import PeriodicSystem, Term
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.stability.eigenvalue_paths import Spectral
from solidwhirl.rotordyn.stability.unstable_windows import Piece, Search

# Harmonics to begin with, and at most.
_FIRST, _MOST = 3, 15
# The fastest motion of the search by the fastest change of the matrices.
_FAST = 2.0
# A motion that turns slower than this part of its rate stands still.
_STILL = 1e-6
# Part of the width of a range by which its ends, and of its growth by which that, may still move
# when a harmonic is added.
_STAYS = 1e-7
# Distance from a range, as a part of its width, at which the modes that meet are told apart,
_BESIDE = 0.2
# and the part of what grows from which a mode is one of them.
_PART = 0.1
# Part of the speed by which an end may lie elsewhere than in the coordinates of the search.
_SHIFT = 1e-3


Relation = Literal["main", "sum", "difference", "alone"]


class Meeting(NamedTuple):
    """The modes that meet where a range opens, or closes if it does not open.

    `first_rad_s`, `second_rad_s`: their frequencies there in the frame of the body, first ≥ second
    ≥ 0. With `order` m strides of the speed: "main": twice the one frequency is m strides (m = 0:
    it stands still); "sum", "difference": of both; "alone": a mode that no other drives.
    """

    relation: Relation
    order: int
    first_rad_s: float
    second_rad_s: float


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
    width = narrowest * (speed_high_rad_s - speed_low_rad_s)
    search, pieces = _searched(system, speed_low_rad_s, speed_high_rad_s, width)
    found = (_range(system, search, piece) for piece in pieces)
    return tuple(r for r in found if r is not None and r.high_rad_s - r.low_rad_s > width)


def closed_by_damping(
    system: PeriodicSystem,
    speed_low_rad_s: float,
    speed_high_rad_s: float,
    narrowest: float = 1e-4,
) -> tuple[UnstableRange, ...]:
    """Find the ranges in which a system would be unstable without damping, and is not with it.

    Arguments and errors as of `unstable_ranges`. A range counts as closed if none that is left has
    a speed in common with it.
    """
    asked = (speed_low_rad_s, speed_high_rad_s, narrowest)
    left = unstable_ranges(system, *asked)
    return tuple(
        r
        for r in unstable_ranges(_undamped(system), *asked)
        if all(r.high_rad_s < o.low_rad_s or o.high_rad_s < r.low_rad_s for o in left)
    )


def _undamped(system: PeriodicSystem) -> PeriodicSystem:
    """The system without forces of damping: the even part of V, and what it adds to K with Ω."""
    velocity = [Term(h, p, 0.5 * (a - a.T)) for h, p, a in system.velocity]
    return replace(
        system,
        velocity=tuple(term for term in velocity if term.matrix.any()),
        stiffness=tuple(term for term in system.stiffness if term.power % 2 == 0),
    )


def _searched(
    system: PeriodicSystem, low: float, high: float, width: float
) -> tuple[Search[Any], list[Piece]]:
    """Search in ever more coordinates until the same ranges are found."""
    if not system.stride:
        search = Search(ConstantMotions(system, low, high), (), low, high, width)
        return search, search.pieces()
    fastest, before = _FAST * system.stride * high, None
    while True:
        basis = search_basis(system, fastest, high)
        search = Search(PeriodicMotions(system, basis, fastest), (), low, high, width)
        pieces = search.pieces()
        whole = basis.shape[1] == system.size
        if whole or (before is not None and _same(before, pieces, width)):
            return search, pieces
        before, fastest = pieces, 2.0 * fastest


def _same(before: Sequence[Piece], after: Sequence[Piece], width: float) -> bool:
    """Whether all pieces that are wide enough are found again."""
    for some, others in ((before, after), (after, before)):
        for piece in some:
            again = any(o.low < piece.high and piece.low < o.high for o in others)
            if piece.high - piece.low > width and not again:
                return False
    return True


def _range(system: PeriodicSystem, search: Search[Any], piece: Piece) -> UnstableRange | None:
    """Return the range of a piece; None where Hill's method finds no growth."""
    opens, closes = search.ends_inside(piece)
    low = _end(system, search, piece.low, piece.high) if opens else None
    high = _end(system, search, piece.high, piece.low) if closes else None
    ends = (
        low.root.speed_rad_s if low else piece.low,
        high.root.speed_rad_s if high else piece.high,
    )
    speed = search.highest(piece)
    if not ends[0] <= speed <= ends[1]:
        speed = 0.5 * (ends[0] + ends[1])
    spectral = search.at(speed)
    start = search.motions.root(spectral, int(spectral.excess.argmax()), _FIRST)
    growth = abs(start.value.real)
    top = converged_root(system, start, "growth", (np.inf, _STAYS * growth), _MOST)
    if top is None or not top.root.value.real > 0:
        return None
    value, beat = top.root.value, system.stride * speed
    turning = abs(value.imag - beat * round(value.imag / beat)) if beat else abs(value.imag)
    still = _repeats(value.imag, beat, speed)
    known = floquet_multipliers(system, speed, basis=search.motions.basis)
    return UnstableRange(
        low_rad_s=ends[0],
        high_rad_s=ends[1],
        opens=opens,
        closes=closes,
        growth_1_s=value.real,
        speed_rad_s=speed,
        floquet_1_s=known.growth_1_s,
        frequency_rad_s=0.0 if still else turning,
        kind="divergence" if still else "flutter",
        meeting=_meeting(search, piece, low or high, spectral),
        error_rad_s=max((e.moved_rad_s for e in (low, high) if e), default=0.0),
    )


def _end(system: PeriodicSystem, search: Search[Any], speed: float, other: float) -> Converged:
    """Return where growth begins or ends at a speed; it grows towards the other.

    Without damping two motions meet there, else one of them crosses the axis.
    """
    value = search.at_end(speed, other)
    found = search.at(speed)
    start = search.motions.root(found, found.nearest(value)[0], _FIRST)
    start = start._replace(value=1j * start.value.imag)
    step = 2.0 * search.accuracy(speed, other) * (1 if speed > other else -1)
    beyond = search.at(min(max(speed + step, search.low), search.high))
    damped = beyond.nearest(value)[1].real < -float(beyond.tolerance[beyond.counted].max())
    width = abs(other - speed)
    for sought in ("crossing", "meeting") if damped else ("meeting", "crossing"):
        end = converged_root(system, start, sought, (_STAYS * width, np.inf), _MOST)
        if end is not None and abs(end.root.speed_rad_s - speed) < 0.5 * width + _SHIFT * speed:
            return end
    raise AnalysisError(f"the end of an unstable range near {speed:.6g} rad/s was not found")


def _meeting(
    search: Search[Any], piece: Piece, end: Converged | None, growing: Spectral
) -> Meeting | None:
    """Return the modes that what grows is made of, as they are beside the end of a range."""
    if end is None:
        return None
    root, beat = end.root, growing.stride * end.root.speed_rad_s
    turning = root.value.imag
    if _repeats(2.0 * turning, beat, root.speed_rad_s):
        # both are conjugate: as fast as all harmonics of it are on the whole
        rates = turning + beat * np.arange(-(len(root.right) // 2), len(root.right) // 2 + 1)
        energy = (np.abs(root.right) ** 2).sum(axis=1)
        mean = float(np.sqrt(energy @ rates**2 / energy.sum()))
        odd = round(2.0 * turning / beat) % 2 if beat else 0
        order = 2 * round((2.0 * mean / beat - odd) / 2.0) + odd if beat else 0
        return Meeting("main", order, 0.5 * order * beat, 0.5 * order * beat)
    out = _BESIDE * (piece.high - piece.low)
    out = -out if root.speed_rad_s < growing.speed_rad_s else out
    beside = search.at(min(max(root.speed_rad_s + out, search.low), search.high))
    like = search.motions.alike(beside, growing)[0][:, growing.excess.argmax()]
    pair = np.argsort(-like)[:2]
    lifts = np.round((beside.values[pair].imag - turning) / beat) if beat else np.zeros(2)
    rates = turning + beat * lifts
    fast, slow = sorted(np.abs(rates), reverse=True)
    if like[pair[1]] < _PART:
        return Meeting("alone", 0, abs(rates[0]), abs(rates[0]))
    relation: Relation = "sum" if rates[0] * rates[1] < 0 else "difference"
    both = fast + slow if relation == "sum" else fast - slow
    return Meeting(relation, round(both / beat) if beat else 0, fast, slow)


def _repeats(rate: float, beat: float, size: float) -> bool:
    """Whether a rate is a whole number of beats, or 0."""
    rest = rate - beat * round(rate / beat) if beat else rate
    return abs(rest) <= _STILL * max(size, beat)
