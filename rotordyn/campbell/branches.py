"""Which branches are followed: every mode that is among the lowest, or below a frequency.

All diagrams of a system begin at rest, wherever their own speeds begin: its branches, and their
order, are those of the system and not of the range that is asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Literal, NamedTuple

import numpy as np
import scipy

from solidwhirl.rotordyn.assembly.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.campbell.continued import alone_at, turning_point
from solidwhirl.rotordyn.campbell.matching import (
    GOOD_OVERLAP,
    SAME_FREQUENCY,
    Tracked,
    overlaps,
)
from solidwhirl.rotordyn.campbell.tracking import Chain, Tracker
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, IntArray
from solidwhirl.rotordyn.modes.damping import PEAKLESS, damping_ratio
from solidwhirl.rotordyn.modes.eigen import Modes, mode_columns, scaled_stiffness, whole_group_count

# Frequencies closer than this (relative) at rest are equal.
_EQUAL = 1e-8
# A frequency in proportion to the speed is so within this factor; one that may have been born of
# real eigenvalues elsewhere within that.
_PROPORTION, _IN_PROPORTION = 1.5, 1.001
# Speeds looked at between rest and the first one asked for, at most.
_MOST_BEFORE = 16
# Times that branches met late are followed again from where they begin.
_ROUNDS = 30


class Selection(NamedTuple):
    """What a diagram is to hold.

    `needed`: number of lowest modes of a speed that must be on branches; `first_count`: modes to
    compute at each speed in the first attempt; `is_from_rest`: whether branches that are needed
    between rest and the range are held as well.
    """

    needed: Callable[[Modes], int]
    first_count: int
    is_from_rest: bool


def lowest(branch_count: int) -> Selection:
    """Select the lowest modes of every speed, none of equal frequency cut off."""
    return Selection(
        needed=lambda modes: whole_group_count(modes.eigenvalues, branch_count),
        first_count=2 * branch_count + 12,
        is_from_rest=True,
    )


def all_below(assembled: AssembledSystem, frequency_max_hz: float) -> Selection:
    """Select all modes below a frequency."""
    return Selection(
        needed=lambda modes: int(np.count_nonzero(modes.frequency_hz <= frequency_max_hz)),
        first_count=assembled.size,
        is_from_rest=False,
    )


def follow(
    assembled: AssembledSystem, speeds_rad_s: FloatArray, selection: Selection
) -> list[Tracked]:
    """Follow every branch that is needed at one of the speeds, from rest on.

    `speeds_rad_s`: Ω, shape (s,); `selection`: what is needed. The result is by rising speed: at
    the speeds given, at rest, at the knots of speed laws in the range, and where branches change
    quickly, meet, begin or end. Branches by rising frequency at rest: those that the spin lifts
    from zero first, equal ones by that at the next speed; then those that begin at a speed, by that
    speed.
    """
    # where the whole spectrum is computed anyway, some of it would save nothing
    least = selection.first_count if assembled.is_conservative else assembled.size
    for count in sorted({min(assembled.size, least), assembled.size}):
        tracker = Tracker(assembled, count, selection.needed)
        ways = _way(assembled, speeds_rad_s, 1.0), _way(assembled, speeds_rad_s, -1.0)
        toward = (*ways[0], *ways[1], 0.0)[0]
        at_speeds = _both_ways(tracker, ways, toward)
        if not _has_gaps(at_speeds):
            break
    return _selected(at_speeds, speeds_rad_s, selection, toward)


def _has_gaps(at_speeds: Sequence[Tracked]) -> bool:
    """Whether a branch may have left through the top of what was computed.

    Those that the spin lifts from rest are not there at rest, and come in from below.
    """
    rest = int(np.argmin([abs(at_speed.modes.speed_rad_s) for at_speed in at_speeds]))
    absent = np.array([at_speed.columns < 0 for at_speed in at_speeds])
    begin, lifted = begins(at_speeds, rest)
    places = np.arange(len(at_speeds))[:, None]
    before = np.abs(places - rest) < np.abs(begin - rest)
    return bool((absent & ~(lifted & before)).any())


def _both_ways(
    tracker: Tracker, ways: tuple[tuple[float, ...], tuple[float, ...]], toward: float
) -> list[Tracked]:
    """Follow branches from rest to both ends of the range."""
    rest = tracker.aligned(0.0, toward) if toward else tracker.modes.at(0.0)
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


def _joined(chains: list[Chain], shared: int) -> list[Tracked]:
    """Return both ways from rest as one list; branches that begin on one side are its own."""
    up, down = (chain.at_speeds for chain in chains)
    own_up, own_down = (at_speeds[0].columns.size - shared for at_speeds in (up, down))

    def spread(at_speed: Tracked, before: int, after: int) -> Tracked:
        columns, overlap = at_speed.columns, at_speed.overlap
        gap, end = np.full(before, -1), np.full(after, -1)
        return Tracked(
            modes=at_speed.modes,
            columns=np.concatenate((columns[:shared], gap, columns[shared:], end)),
            overlap=np.concatenate(
                (overlap[:shared], np.ones(before), overlap[shared:], np.ones(after))
            ),
        )

    return [
        *(spread(at_speed, own_up, 0) for at_speed in reversed(down[1:])),
        *(spread(at_speed, 0, own_down) for at_speed in up),
    ]


def _selected(
    at_speeds: list[Tracked], speeds_rad_s: FloatArray, selection: Selection, toward: float
) -> list[Tracked]:
    """Keep the branches that are needed at one of the speeds, in their order."""
    places = {at_speed.modes.speed_rad_s: k for k, at_speed in enumerate(at_speeds)}
    order = _order(at_speeds, places[0.0], places[toward])
    alive, needed = np.zeros((2, order.size), dtype=bool)
    for speed in map(float, speeds_rad_s):
        at_speed = at_speeds[places[speed]]
        alive |= at_speed.columns >= 0
        needed |= (at_speed.columns >= 0) & (at_speed.columns < selection.needed(at_speed.modes))
    kept = alive if selection.is_from_rest else needed
    chosen = order[kept[order]]
    return [at_speed.select(chosen) for at_speed in at_speeds]


def begins(at_speeds: Sequence[Tracked], rest: int) -> tuple[IntArray, BoolArray]:
    """Return where branches begin, seen from rest, and which of them the spin lifts from rest.

    Index of the first speed of each branch, and whether it comes from rest though it is not there:
    its frequency is in proportion to the speed, so that only rounding says from where on it turns.
    """
    alive = np.array([at_speed.columns >= 0 for at_speed in at_speeds])
    places = np.arange(len(at_speeds))[:, None]
    begin = np.where(alive, np.abs(places - rest), len(at_speeds)).argmin(axis=0)
    speeds = np.array([abs(at_speed.modes.speed_rad_s) for at_speed in at_speeds])
    omega = np.array([at_speed.values().imag for at_speed in at_speeds])
    reals = np.array([at_speed.modes.real_eigenvalues.size for at_speed in at_speeds])
    lifted = np.abs(begin - rest) == 1
    for branch in np.flatnonzero(np.abs(begin - rest) > 1):
        at = begin[branch]
        side = places[:, 0] > rest if at > rest else places[:, 0] < rest
        beyond = side & alive[:, branch] & (speeds > _PROPORTION * speeds[at])
        if beyond.any():
            far = np.flatnonzero(beyond)[np.argmin(speeds[beyond])]
            ratio = omega[at, branch] / speeds[at] / (omega[far, branch] / speeds[far])
            was_real = reals[at - np.sign(at - rest)] > reals[at]
            bound = _IN_PROPORTION if was_real else _PROPORTION
            lifted[branch] = 1.0 / bound < ratio < bound
    return begin, lifted


def _order(at_speeds: list[Tracked], rest: int, after: int) -> IntArray:
    """Return the order of branches: those that the spin lifts from zero begin beside rest."""
    begin, lifted = begins(at_speeds, rest)
    at_rest = np.where(lifted, 0.0, at_speeds[rest].values().imag)
    rising = np.argsort(at_rest, kind="stable")
    steps = np.diff(at_rest[rising]) > _EQUAL * at_rest[rising][1:]
    group = np.empty(at_rest.size, dtype=int)
    group[rising] = np.concatenate((np.zeros(min(1, at_rest.size), int), np.cumsum(steps)))
    speeds = np.array([at_speed.modes.speed_rad_s for at_speed in at_speeds])[begin]
    late = np.isnan(at_rest)
    group[late], first = 0, np.abs(np.where(late, speeds, 0.0))
    later = np.nan_to_num(at_speeds[after].values().imag)
    return np.asarray(np.lexsort((later, group, first, late)))


# A crossing is placed when it moves by less than this part of its step, by a polynomial through so
# many places at most; at first through as many as this on either side.
_PLACED, _MOST_PLACES, _AROUND = 1e-4, 10, 2
# A veering is sought where two branches come closer than this fraction of their frequency,
_CLOSE = 0.3
# between places where they are this many times farther apart than at the closest point.
_APART = 3.0
# A mode that begins or ends at zero frequency is slower there than this fraction of the fastest.
_SLOW = 1e-2
# What a mode is before its branch begins and after it ends.
_FROM = {
    "overdamped": "from overdamped motion",
    "diverges": "from divergence",
    "zero": "from zero frequency",
    "lost": "and is not found before",
}
_TO = {
    "overdamped": "and becomes overdamped",
    "diverges": "and diverges",
    "zero": "at zero frequency",
    "lost": "and is not found beyond",
}
# Halvings that locate the loss of stiffness.
_HALVINGS = 60


@dataclass(frozen=True, kw_only=True)
class TrackingNote:
    """Say what a reader of a Campbell diagram should know about one place.

    Attributes
    ----------
    kind
        "crossing" (two branches pass through each other), "veering" (they come close, exchange
        their shapes and part), "ambiguous" (the MAC stayed low however small the step),
        "ended" (no partner: the branch became overdamped or rigid), "range" (a body runs faster
        than its basis was made for), "indefinite" (K + Ω²K2 has negative eigenvalues),
        "steep law" (a bearing makes the mode by rising over the frequency more steeply than a
        passive support can, see `Modes.index`).
    speed_rad_s
        Where, rad/s.
    branches
        Branch numbers from 0; empty if all are meant.
    text
        One sentence; it counts branches from 1, as tables and pictures do.
    """

    kind: Literal[
        "crossing",
        "veering",
        "ambiguous",
        "begun",
        "ended",
        "empty",
        "range",
        "indefinite",
        "steep law",
    ]
    speed_rad_s: float
    branches: tuple[int, ...]
    text: str


def branch_notes(
    assembled: AssembledSystem, at_speeds: Sequence[Tracked]
) -> tuple[TrackingNote, ...]:
    """Return the remarks on a set of branches, by kind and place.

    `speeds`: all speeds the branches were followed through. Possibly empty.
    """
    return (
        *_range_notes(assembled, at_speeds),
        *_indefinite_notes(assembled, at_speeds),
        *_meeting_notes(assembled, at_speeds),
        *_end_notes(assembled, at_speeds),
        *_ambiguity_notes(at_speeds),
        *_steep_law_notes(at_speeds),
    )


def _range_notes(
    assembled: AssembledSystem, at_speeds: Sequence[Tracked]
) -> Iterator[TrackingNote]:
    limit = assembled.speed_limit_rad_s
    fastest = max(abs(at_speed.modes.speed_rad_s) for at_speed in at_speeds)
    if fastest > limit:
        text = (
            f"above {limit:.6g} rad/s a body runs faster than its basis was made for; the diagram "
            f"goes to {fastest:.6g} rad/s"
        )
        yield TrackingNote(kind="range", speed_rad_s=limit, branches=(), text=text)


def _indefinite_notes(
    assembled: AssembledSystem, at_speeds: Sequence[Tracked]
) -> Iterator[TrackingNote]:
    """Say where the stiffness has a negative eigenvalue more than before."""
    known: tuple[float, int] | None = None
    for at_speed in at_speeds:
        count, speed = at_speed.modes.negative_stiffness_count, at_speed.modes.speed_rad_s
        if known is None and count:
            text = f"the stiffness has {count} negative eigenvalue(s) at {speed:.6g} rad/s"
            yield TrackingNote(kind="indefinite", speed_rad_s=speed, branches=(), text=text)
        elif known is not None and count > known[1]:
            place, found = _loss_of_stiffness(assembled, known, speed)
            text = f"from {place:.6g} rad/s on the stiffness has {found} negative eigenvalue(s)"
            yield TrackingNote(kind="indefinite", speed_rad_s=place, branches=(), text=text)
        known = speed, count


def _loss_of_stiffness(
    assembled: AssembledSystem, known: tuple[float, int], beyond: float
) -> tuple[float, int]:
    """Return the speed beyond which K + Ω²K2 has more negative eigenvalues, and how many.

    `known`: a speed and the count there. `beyond`: a speed where there are more.
    """

    def negative(speed: float) -> int:
        return scaled_stiffness(assembled, matrices_at_speed(assembled, speed)).negative_count

    low, count = known
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + beyond)
        if middle in (low, beyond):
            break
        low, beyond = (low, middle) if negative(middle) > count else (middle, beyond)
    return beyond, negative(beyond)


def _end_notes(assembled: AssembledSystem, at_speeds: Sequence[Tracked]) -> Iterator[TrackingNote]:
    """Say where branches begin and end, and why."""
    if not any((at_speed.columns >= 0).any() for at_speed in at_speeds):
        speed = at_speeds[0].modes.speed_rad_s
        text = "there is no oscillatory mode to draw at any speed of the diagram"
        yield TrackingNote(kind="empty", speed_rad_s=speed, branches=(), text=text)
    speeds = [at_speed.modes.speed_rad_s for at_speed in at_speeds]
    lifted = begins(at_speeds, speeds.index(0.0))[1] if 0.0 in speeds else np.zeros(0, dtype=bool)
    for before, after in pairwise(at_speeds):
        alive = before.columns >= 0, after.columns >= 0
        for branch in np.flatnonzero(alive[0] != alive[1]):
            moving, still = (after, before) if alive[1][branch] else (before, after)
            state = _state(moving, still, int(branch))
            place = 0.5 * (before.modes.speed_rad_s + after.modes.speed_rad_s)
            outer = abs(after.modes.speed_rad_s) > abs(before.modes.speed_rad_s)
            if lifted.size and lifted[branch] and alive[outer][branch]:
                place = 0.0
            elif state in ("overdamped", "diverges"):
                mode = mode_columns(moving.modes, moving.columns[[branch]])
                place = turning_point(assembled, mode, still.modes.speed_rad_s).speed_rad_s
            if alive[1][branch]:
                text = f"branch {branch + 1} begins at {place:.6g} rad/s, {_FROM[state]}"
            else:
                text = f"branch {branch + 1} ends at {place:.6g} rad/s, {_TO[state]}"
            kind: Literal["begun", "ended"] = "begun" if alive[1][branch] else "ended"
            yield TrackingNote(kind=kind, speed_rad_s=place, branches=(int(branch),), text=text)


def _state(at_speed: Tracked, beyond: Tracked, branch: int) -> str:
    """Return what the mode of a branch is where the branch is not."""
    value = complex(at_speed.values()[branch])
    grows, still = (int((f.modes.real_eigenvalues > 0).sum()) for f in (beyond, at_speed))
    if grows > still:
        return "diverges"
    reals = [f.modes.real_eigenvalues.size for f in (beyond, at_speed)]
    if value.real < 0 and (reals[0] > reals[1] or damping_ratio(np.array([value]))[0] > PEAKLESS):
        return "overdamped"
    slow = abs(value) < _SLOW * np.abs(at_speed.modes.eigenvalues).max()
    return "zero" if slow or beyond.modes.zero_count > at_speed.modes.zero_count else "lost"


def _ambiguity_notes(at_speeds: Sequence[Tracked]) -> Iterator[TrackingNote]:
    for before, after in pairwise(at_speeds):
        speed = after.modes.speed_rad_s
        both = (before.columns >= 0) & (after.columns >= 0)
        for branch in np.flatnonzero(both & (after.overlap < GOOD_OVERLAP)):
            mac = float(after.overlap[branch])
            text = f"branch {branch + 1} is ambiguous at {speed:.6g} rad/s, MAC {mac:.2f}"
            yield TrackingNote(
                kind="ambiguous", speed_rad_s=speed, branches=(int(branch),), text=text
            )


def _steep_law_notes(at_speeds: Sequence[Tracked]) -> Iterator[TrackingNote]:
    """Say which branches have roots of index −1, and where."""
    steep: dict[int, list[float]] = {}
    for at_speed in at_speeds:
        index = at_speed.modes.index
        if index is None:
            continue
        alive = np.flatnonzero(at_speed.columns >= 0)
        for branch in alive[index[at_speed.columns[alive]] < 0].tolist():
            steep.setdefault(branch, []).append(at_speed.modes.speed_rad_s)
    for branch, speeds in sorted(steep.items()):
        text = (
            f"branch {branch + 1} from {min(speeds):.6g} to {max(speeds):.6g} rad/s is made by a "
            "bearing whose coefficients rise with the frequency more steeply than those of a "
            "passive support can; no verdict rests on it"
        )
        yield TrackingNote(kind="steep law", speed_rad_s=min(speeds), branches=(branch,), text=text)


def _meeting_notes(
    assembled: AssembledSystem, at_speeds: Sequence[Tracked]
) -> Iterator[TrackingNote]:
    """Find sign changes and minima of the distance between two branches."""
    values = np.array([at_speed.values() for at_speed in at_speeds])
    # where a motion does not resonate there is no crossing to see
    omega = np.where(damping_ratio(values) < PEAKLESS, values.imag, np.nan)
    speeds = np.array([at_speed.modes.speed_rad_s for at_speed in at_speeds])
    for first, second in combinations(range(omega.shape[1]), 2):
        gap = omega[:, second] - omega[:, first]
        apart = np.flatnonzero(np.abs(gap) > SAME_FREQUENCY * omega[:, first])
        for left, right in pairwise(apart):
            if gap[left] * gap[right] < 0:
                ends = [_pair(at_speeds[k], first, second) for k in (left, right)]
                around = slice(max(0, left - _AROUND), right + 1 + _AROUND)
                speed = _meeting_speed(assembled, speeds[around], gap[around], ends)
                text = f"branches {first + 1} and {second + 1} cross near {speed:.6g} rad/s"
                yield TrackingNote(
                    kind="crossing", speed_rad_s=speed, branches=(first, second), text=text
                )
        for at in _veerings(assembled, at_speeds, first, second, gap, omega[:, first]):
            speed, width = float(speeds[at]), float(abs(gap[at]) / (2.0 * np.pi))
            text = (
                f"branches {first + 1} and {second + 1} veer near {speed:.6g} rad/s, "
                f"closest distance {width:.4g} Hz"
            )
            yield TrackingNote(
                kind="veering", speed_rad_s=speed, branches=(first, second), text=text
            )


def _meeting_speed(
    assembled: AssembledSystem, speeds: FloatArray, gap: FloatArray, ends: Sequence[Modes]
) -> float:
    """Return where the distance of two branches is zero between two places.

    `speeds`, `gap`: places around and distances there; `ends`: the branches at the two. By a
    polynomial through the places, which one through the inner ones alone confirms, or what the
    distance is where that is zero.
    """
    low, high = ends
    places, distances = (list(v[np.isfinite(gap)]) for v in (speeds, gap))

    def zero(inner: slice) -> float:
        through = scipy.interpolate.BarycentricInterpolator(places[inner], distances[inner])
        return float(
            scipy.optimize.brentq(lambda at: float(through(at)), low.speed_rad_s, high.speed_rad_s)
        )

    limits = sorted((low.speed_rad_s, high.speed_rad_s))
    inner = sorted(places[1:-1])
    is_around = inner[:1] <= limits[:1] and inner[-1:] >= limits[1:]
    speed = zero(slice(1, -1)) if len(inner) > 3 and is_around else np.inf
    while True:
        before, speed = speed, zero(slice(None))
        step = min(abs(speed - before), np.abs(np.array(places) - speed).min())
        here = None
        if step > _PLACED * abs(high.speed_rad_s - low.speed_rad_s) and len(places) < _MOST_PLACES:
            here = alone_at(assembled, low, high, speed)
        if here is None:
            return float(speed)
        places.append(speed)
        distances.append(float(np.diff(here.imag)[0]))


def _veerings(
    assembled: AssembledSystem,
    at_speeds: Sequence[Tracked],
    first: int,
    second: int,
    gap: FloatArray,
    omega: FloatArray,
) -> Iterator[int]:
    """Yield the speeds where two branches are closest, without crossing, and exchange shapes."""
    signs, gap = np.sign(gap), np.abs(gap)
    closest = (gap[1:-1] <= gap[:-2]) & (gap[1:-1] < gap[2:])
    closest &= (signs[1:-1] == signs[:-2]) & (signs[1:-1] == signs[2:])
    closest &= (gap > SAME_FREQUENCY * omega)[1:-1] & (gap < _CLOSE * omega)[1:-1]
    for at in (1 + np.flatnonzero(closest)).tolist():
        left = np.flatnonzero(gap[:at] >= _APART * gap[at])
        right = np.flatnonzero(gap[at:] >= _APART * gap[at])
        if left.size == 0 or right.size == 0:
            continue
        before = _pair(at_speeds[int(left[-1])], first, second)
        after = _pair(at_speeds[at + int(right[0])], first, second)
        mac = np.abs(overlaps(assembled, before, after)) ** 2
        if mac[0, 1] > 0.5 and mac[1, 0] > 0.5:
            yield at


def _pair(at_speed: Tracked, first: int, second: int) -> Modes:
    """Return the modes of two branches alone."""
    return mode_columns(at_speed.modes, at_speed.columns[[first, second]])
