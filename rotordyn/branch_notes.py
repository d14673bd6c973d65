"""Remarks on a tracked set of branches: where they cross, veer, end or are in doubt."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Literal

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.branches import begins
from solidwhirl.rotordyn.damping import PEAKLESS, damping_ratio
from solidwhirl.rotordyn.eigen import Modes, scaled_stiffness
from solidwhirl.rotordyn.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.tracking import (
    GOOD_OVERLAP,
    SAME_FREQUENCY,
    Front,
    mode_columns,
    overlaps,
)

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
        their shapes and part), "ambiguous" (the likeness stayed low however small the step),
        "ended" (no partner: the branch became overdamped or rigid), "range" (a body runs faster
        than its basis was made for), "indefinite" (K + Ω²K2 has negative eigenvalues),
        "untracked" (a mode below the frequency limit has no branch from the first speed on).
    speed_rad_s
        Where, rad/s.
    branches
        Branch numbers from 0; empty if all are meant.
    text
        One sentence; it counts branches from 1, as tables and pictures do.
    """

    kind: Literal[
        "crossing", "veering", "ambiguous", "begun", "ended", "empty", "range", "indefinite"
    ]
    speed_rad_s: float
    branches: tuple[int, ...]
    text: str


def branch_notes(assembled: AssembledSystem, fronts: Sequence[Front]) -> tuple[TrackingNote, ...]:
    """Return the remarks on a set of branches, by kind and place.

    Parameters
    ----------
    assembled
        The system.
    fronts
        All speeds the branches were followed through.

    Returns
    -------
    tuple of TrackingNote
        Possibly empty.
    """
    return (
        *_range_notes(assembled, fronts),
        *_indefinite_notes(assembled, fronts),
        *_meeting_notes(assembled, fronts),
        *_end_notes(fronts),
        *_doubt_notes(fronts),
    )


def _range_notes(assembled: AssembledSystem, fronts: Sequence[Front]) -> Iterator[TrackingNote]:
    limit = assembled.speed_limit_rad_s
    fastest = max(abs(front.modes.speed_rad_s) for front in fronts)
    if fastest > limit:
        text = (
            f"above {limit:.6g} rad/s a body runs faster than its basis was made for; the diagram "
            f"goes to {fastest:.6g} rad/s"
        )
        yield TrackingNote(kind="range", speed_rad_s=limit, branches=(), text=text)


def _indefinite_notes(
    assembled: AssembledSystem, fronts: Sequence[Front]
) -> Iterator[TrackingNote]:
    known: float | None = None
    for front in fronts:
        count, speed = front.modes.negative_stiffness_count, front.modes.speed_rad_s
        if not count:
            known = speed
            continue
        if known is None:
            text = f"the stiffness has {count} negative eigenvalue(s) at {speed:.6g} rad/s"
        else:
            speed, count = _loss_of_stiffness(assembled, known, speed)
            text = f"from {speed:.6g} rad/s on the stiffness has {count} negative eigenvalue(s)"
        yield TrackingNote(kind="indefinite", speed_rad_s=speed, branches=(), text=text)
        return


def _loss_of_stiffness(
    assembled: AssembledSystem, definite: float, indefinite: float
) -> tuple[float, int]:
    """Return the speed between two at which K + Ω²K2 turns indefinite, and the count there."""

    def negative(speed: float) -> int:
        return scaled_stiffness(assembled, matrices_at_speed(assembled, speed)).negative_count

    for _ in range(_HALVINGS):
        middle = 0.5 * (definite + indefinite)
        if middle in (definite, indefinite):
            break
        definite, indefinite = (definite, middle) if negative(middle) else (middle, indefinite)
    return indefinite, negative(indefinite)


def _end_notes(fronts: Sequence[Front]) -> Iterator[TrackingNote]:
    """Say where branches begin and end, and why."""
    if not any((front.columns >= 0).any() for front in fronts):
        speed = fronts[0].modes.speed_rad_s
        text = "there is no oscillatory mode to draw at any speed of the diagram"
        yield TrackingNote(kind="empty", speed_rad_s=speed, branches=(), text=text)
    speeds = [front.modes.speed_rad_s for front in fronts]
    lifted = begins(fronts, speeds.index(0.0))[1] if 0.0 in speeds else np.zeros(0, dtype=bool)
    for before, after in pairwise(fronts):
        alive = before.columns >= 0, after.columns >= 0
        for branch in np.flatnonzero(alive[0] != alive[1]):
            place = 0.5 * (before.modes.speed_rad_s + after.modes.speed_rad_s)
            outer = abs(after.modes.speed_rad_s) > abs(before.modes.speed_rad_s)
            if lifted.size and lifted[branch] and alive[outer][branch]:
                place = 0.0
            if alive[1][branch]:
                state = _state(after, before, int(branch))
                text = f"branch {branch + 1} begins at {place:.6g} rad/s, {_FROM[state]}"
            else:
                state = _state(before, after, int(branch))
                text = f"branch {branch + 1} ends at {place:.6g} rad/s, {_TO[state]}"
            kind: Literal["begun", "ended"] = "begun" if alive[1][branch] else "ended"
            yield TrackingNote(kind=kind, speed_rad_s=place, branches=(int(branch),), text=text)


def _state(front: Front, beyond: Front, branch: int) -> str:
    """Return what the mode of a branch is where the branch is not."""
    value = complex(front.values()[branch])
    grows, still = (int((f.modes.real_eigenvalues > 0).sum()) for f in (beyond, front))
    if grows > still:
        return "diverges"
    reals = [f.modes.real_eigenvalues.size for f in (beyond, front)]
    if value.real < 0 and (reals[0] > reals[1] or damping_ratio(np.array([value]))[0] > PEAKLESS):
        return "overdamped"
    slow = abs(value) < _SLOW * np.abs(front.modes.eigenvalues).max()
    return "zero" if slow or beyond.modes.zero_count > front.modes.zero_count else "lost"


def _doubt_notes(fronts: Sequence[Front]) -> Iterator[TrackingNote]:
    for before, after in pairwise(fronts):
        speed = after.modes.speed_rad_s
        both = (before.columns >= 0) & (after.columns >= 0)
        for branch in np.flatnonzero(both & (after.overlap < GOOD_OVERLAP)):
            likeness = float(after.overlap[branch])
            text = f"branch {branch + 1} is in doubt at {speed:.6g} rad/s, likeness {likeness:.2f}"
            yield TrackingNote(
                kind="ambiguous", speed_rad_s=speed, branches=(int(branch),), text=text
            )


def _meeting_notes(assembled: AssembledSystem, fronts: Sequence[Front]) -> Iterator[TrackingNote]:
    """Find sign changes and minima of the distance between two branches."""
    values = np.array([front.values() for front in fronts])
    # where a motion does not resonate there is no crossing to see
    omega = np.where(damping_ratio(values) < PEAKLESS, values.imag, np.nan)
    speeds = np.array([front.modes.speed_rad_s for front in fronts])
    for first, second in combinations(range(omega.shape[1]), 2):
        gap = omega[:, second] - omega[:, first]
        apart = np.flatnonzero(np.abs(gap) > SAME_FREQUENCY * omega[:, first])
        for left, right in pairwise(apart):
            if gap[left] * gap[right] < 0:
                speed = _meeting_speed(speeds[left : right + 1], gap[left : right + 1])
                text = f"branches {first + 1} and {second + 1} cross near {speed:.6g} rad/s"
                yield TrackingNote(
                    kind="crossing", speed_rad_s=speed, branches=(first, second), text=text
                )
        for at in _veerings(assembled, fronts, first, second, np.abs(gap), omega[:, first]):
            speed, width = float(speeds[at]), float(abs(gap[at]) / (2.0 * np.pi))
            text = (
                f"branches {first + 1} and {second + 1} veer near {speed:.6g} rad/s, "
                f"closest distance {width:.4g} Hz"
            )
            yield TrackingNote(
                kind="veering", speed_rad_s=speed, branches=(first, second), text=text
            )


def _meeting_speed(speeds: FloatArray, gap: FloatArray) -> float:
    """Return where a distance that changes its sign is zero, from the points nearest to it."""
    if speeds.size > 2:
        return float(speeds[np.abs(gap).argmin()])
    return float(speeds[0] + gap[0] / (gap[0] - gap[1]) * (speeds[1] - speeds[0]))


def _veerings(
    assembled: AssembledSystem,
    fronts: Sequence[Front],
    first: int,
    second: int,
    gap: FloatArray,
    omega: FloatArray,
) -> Iterator[int]:
    """Yield the fronts where two branches are closest and exchange their shapes."""
    for at in range(1, gap.size - 1):
        nearest = gap[at] <= gap[at - 1] and gap[at] < gap[at + 1]
        if not nearest or not SAME_FREQUENCY * omega[at] < gap[at] < _CLOSE * omega[at]:
            continue
        left = np.flatnonzero(gap[:at] >= _APART * gap[at])
        right = np.flatnonzero(gap[at:] >= _APART * gap[at])
        if left.size == 0 or right.size == 0:
            continue
        before = _pair(fronts[int(left[-1])], first, second)
        after = _pair(fronts[at + int(right[0])], first, second)
        likeness = np.abs(overlaps(assembled, before, after)) ** 2
        if likeness[0, 1] > 0.5 and likeness[1, 0] > 0.5:
            yield at


def _pair(front: Front, first: int, second: int) -> Modes:
    """Return the modes of two branches alone."""
    return mode_columns(front.modes, front.columns[[first, second]])
