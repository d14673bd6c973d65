"""Which branches are followed: every mode that is among the lowest, or below a frequency.

All diagrams of a system begin at rest, wherever their own speeds begin: its branches, and their
order, are those of the system and not of the range that is asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.arrays import BoolArray, FloatArray
from solidwhirl.rotordyn.eigen import Modes, whole_group_count
from solidwhirl.rotordyn.system import AssembledSystem
from solidwhirl.rotordyn.tracking import Chain, Front, IntArray, Tracker

# Frequencies closer than this (relative) at rest are equal.
_EQUAL = 1e-8
# A frequency in proportion to the speed is so within this factor.
_PROPORTION = 1.5
# Speeds looked at between rest and the first one asked for, at most.
_MOST_BEFORE = 16
# Times that branches met late are followed again from where they begin.
_ROUNDS = 30


class Selection(NamedTuple):
    """What a diagram is to hold.

    Attributes
    ----------
    needed
        Number of lowest modes of a speed that must be on branches.
    first_count
        Modes to compute at each speed in the first attempt.
    is_from_rest
        Whether branches that are needed between rest and the range are held as well.
    """

    needed: Callable[[Modes], int]
    first_count: int
    is_from_rest: bool


def lowest(branch_count: int) -> Selection:
    """Select the lowest modes of every speed, none of equal frequency cut off.

    Parameters
    ----------
    branch_count
        How many.
    """
    return Selection(
        needed=lambda modes: whole_group_count(modes.eigenvalues, branch_count),
        first_count=2 * branch_count + 12,
        is_from_rest=True,
    )


def all_below(assembled: AssembledSystem, frequency_max_hz: float) -> Selection:
    """Select all modes below a frequency.

    Parameters
    ----------
    assembled
        The system.
    frequency_max_hz
        The limit, Hz.
    """
    return Selection(
        needed=lambda modes: int(np.count_nonzero(modes.frequency_hz <= frequency_max_hz)),
        first_count=assembled.size,
        is_from_rest=False,
    )


def follow(
    assembled: AssembledSystem, speeds_rad_s: FloatArray, selection: Selection
) -> list[Front]:
    """Follow every branch that is needed at one of the speeds, from rest on.

    Parameters
    ----------
    assembled
        The system.
    speeds_rad_s
        Ω, shape (s,).
    selection
        What is needed.

    Returns
    -------
    list of Front
        By rising speed: at the speeds given, at rest, at the knots of speed laws in the range, and
        where branches change quickly, meet, begin or end. Branches by rising frequency at rest:
        those that the spin lifts from zero first, equal ones by that at the next speed; then those
        that begin at a speed, by that speed.
    """
    for count in sorted({min(assembled.size, selection.first_count), assembled.size}):
        tracker = Tracker(assembled, count, selection.needed)
        ways = _way(assembled, speeds_rad_s, 1.0), _way(assembled, speeds_rad_s, -1.0)
        toward = (*ways[0], *ways[1], 0.0)[0]
        fronts = _both_ways(tracker, ways, toward)
        # a branch may have left through the top of what was computed
        if all((front.columns >= 0).all() for front in fronts):
            break
    return _selected(fronts, speeds_rad_s, selection, toward)


def _both_ways(
    tracker: Tracker, ways: tuple[tuple[float, ...], tuple[float, ...]], toward: float
) -> list[Front]:
    """Follow branches from rest to both ends of the range."""
    rest = tracker.aligned(0.0, toward) if toward else tracker.modes_at(0.0)
    starts = frozenset(range(tracker.needed(rest)))
    seeds: frozenset[tuple[float, int]] = frozenset()
    for _ in range(_ROUNDS):
        chains = [tracker.follow(rest, np.array(way), starts, seeds) for way in ways]
        more = frozenset().union(*(c.starts for c in chains))
        begun = frozenset().union(*(c.seeds for c in chains))
        if more <= starts and begun <= seeds:
            break
        starts, seeds = starts | more, seeds | begun
    return _joined(chains, len(starts))


def _way(assembled: AssembledSystem, speeds_rad_s: FloatArray, sign: float) -> tuple[float, ...]:
    """Return the speeds to go through from rest to one side: knots, and some before the first."""
    asked = {float(v) for v in sign * speeds_rad_s if v > 0}
    if not asked:
        return ()
    first, last = min(asked), max(asked)
    knots = {knot for knot in assembled.knots_rad_s if 0 < knot < last}
    before: set[float] = set()
    if not (speeds_rad_s == 0).any():
        step = (last - first) / max(1, len(asked) - 1) or first
        count = min(_MOST_BEFORE, int(np.ceil(first / step)))
        before = {float(v) for v in np.linspace(0.0, first, count + 1)[1:-1]}
    return tuple(sign * v for v in sorted(asked | knots | before))


def _joined(chains: list[Chain], shared: int) -> list[Front]:
    """Return both ways from rest as one list; branches that begin on one side are its own."""
    up, down = (chain.fronts for chain in chains)
    own_up, own_down = (fronts[0].columns.size - shared for fronts in (up, down))

    def spread(front: Front, before: int, after: int) -> Front:
        columns, overlap = front.columns, front.overlap
        gap, end = np.full(before, -1), np.full(after, -1)
        return Front(
            modes=front.modes,
            columns=np.concatenate((columns[:shared], gap, columns[shared:], end)),
            overlap=np.concatenate(
                (overlap[:shared], np.ones(before), overlap[shared:], np.ones(after))
            ),
        )

    return [
        *(spread(front, own_up, 0) for front in reversed(down[1:])),
        *(spread(front, 0, own_down) for front in up),
    ]


def _selected(
    fronts: list[Front], speeds_rad_s: FloatArray, selection: Selection, toward: float
) -> list[Front]:
    """Keep the branches that are needed at one of the speeds, in their order."""
    places = {front.modes.speed_rad_s: k for k, front in enumerate(fronts)}
    order = _order(fronts, places[0.0], places[toward])
    alive, needed = np.zeros((2, order.size), dtype=bool)
    for speed in map(float, speeds_rad_s):
        front = fronts[places[speed]]
        alive |= front.columns >= 0
        needed |= (front.columns >= 0) & (front.columns < selection.needed(front.modes))
    kept = alive if selection.is_from_rest else needed
    chosen = order[kept[order]]
    return [front.select(chosen) for front in fronts]


def begins(fronts: Sequence[Front], rest: int) -> tuple[IntArray, BoolArray]:
    """Return where branches begin, seen from rest, and which of them the spin lifts from rest.

    Parameters
    ----------
    fronts
        By speed.
    rest
        Which of them is at rest.

    Returns
    -------
    begin, lifted : ndarray
        Front of each branch, and whether it comes from rest though it is not there: its frequency
        is in proportion to the speed, so that only rounding says from where on it turns.
    """
    alive = np.array([front.columns >= 0 for front in fronts])
    places = np.arange(len(fronts))[:, None]
    begin = np.where(alive, np.abs(places - rest), len(fronts)).argmin(axis=0)
    speeds = np.array([abs(front.modes.speed_rad_s) for front in fronts])
    omega = np.array([front.values().imag for front in fronts])
    lifted = np.abs(begin - rest) == 1
    for branch in np.flatnonzero(np.abs(begin - rest) > 1):
        at = begin[branch]
        side = places[:, 0] > rest if at > rest else places[:, 0] < rest
        beyond = side & alive[:, branch] & (speeds > _PROPORTION * speeds[at])
        if beyond.any():
            far = np.flatnonzero(beyond)[np.argmin(speeds[beyond])]
            ratio = omega[at, branch] / speeds[at] / (omega[far, branch] / speeds[far])
            lifted[branch] = 1.0 / _PROPORTION < ratio < _PROPORTION
    return begin, lifted


def _order(fronts: list[Front], rest: int, after: int) -> IntArray:
    """Return the order of branches: those that the spin lifts from zero begin beside rest."""
    begin, lifted = begins(fronts, rest)
    at_rest = np.where(lifted, 0.0, fronts[rest].values().imag)
    rising = np.argsort(at_rest, kind="stable")
    steps = np.diff(at_rest[rising]) > _EQUAL * at_rest[rising][1:]
    group = np.empty(at_rest.size, dtype=int)
    group[rising] = np.concatenate((np.zeros(min(1, at_rest.size), int), np.cumsum(steps)))
    speeds = np.array([front.modes.speed_rad_s for front in fronts])[begin]
    late = np.isnan(at_rest)
    group[late], first = 0, np.abs(np.where(late, speeds, 0.0))
    later = np.nan_to_num(fronts[after].values().imag)
    return np.asarray(np.lexsort((later, group, first, late)))
