"""Where between two speeds branches need a closer look."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.campbell.continued import AtHand, meeting_of
from solidwhirl.rotordyn.campbell.matching import (
    GOOD_OVERLAP,
    POOR_OVERLAP,
    SAME_FREQUENCY,
    Match,
    Tracked,
)
from solidwhirl.rotordyn.core.arrays import BoolArray, IntArray, without
from solidwhirl.rotordyn.modes.damping import CREEPING, damping_ratio
from solidwhirl.rotordyn.modes.eigen import mode_columns

# Where two modes of a match exchange their order, and whether they pass through each other there.
Meet = Callable[[Match, IntArray], tuple[float, bool]]


def meeting_in(
    assembled: AssembledSystem, match: Match, pair: IntArray, at_hand: AtHand
) -> tuple[float, bool]:
    """Return where two modes of the first speed meet; `pair`: their columns. See `meeting_of`."""
    low = mode_columns(match.first, pair)
    return meeting_of(assembled, low, mode_columns(match.second, match.partner[pair]), at_hand)


def place_to_look(here: Tracked, match: Match, wanted: IntArray, meet: Meet) -> tuple[float, bool]:
    """Return a speed between two that should be looked at, nan if none, and if closely.

    `here`: branches at the first speed; `match`: of the modes at both; `wanted`: columns of the
    second that are to be on branches; `meet`: tells of meetings, as `meeting_in` does. Halves the
    step where a branch changes much, begins or ends; where two branches exchange their order and do
    not just pass through each other, goes to where they meet. Of motions that creep more than they
    oscillate only beginnings and ends matter. What begins or ends because real eigenvalues become a
    pair, or a pair real ones, needs no look.
    """
    begin, end = match.first.speed_rad_s, match.second.speed_rad_s
    creeping = [damping_ratio(m.eigenvalues) > CREEPING for m in (match.first, match.second)]
    tracked = here.columns[here.columns >= 0]
    gone, new = _turned(match)
    tracked, wanted = without(tracked, gone), without(wanted, new)
    back = np.zeros(match.second.eigenvalues.size)
    back[match.partner[match.partner >= 0]] = match.mac[match.partner >= 0]
    mac = np.concatenate((match.mac[tracked], back[wanted]))
    creeps = np.concatenate((creeping[0][tracked], creeping[1][wanted]))
    if (mac[~creeps] < GOOD_OVERLAP).any() or (mac[creeps] <= POOR_OVERLAP).any():
        return 0.5 * (begin + end), bool((mac[~creeps] < GOOD_OVERLAP).any())
    return _veering_of(match, tracked[~creeping[0][tracked]], meet), True


def _turned(match: Match) -> tuple[IntArray, IntArray]:
    """Return which modes of the first speed turn real up to the second, and which come from there.

    Only if the numbers of real eigenvalues say so; not from rest on, where zeros may be lifted.
    """
    none = np.empty(0, dtype=int)
    first, second = match.first, match.second
    size = first.shapes.shape[0]
    counts = [
        2 * m.eigenvalues.size + m.real_eigenvalues.size + m.zero_count for m in (first, second)
    ]
    good = match.mac > POOR_OVERLAP
    gone = np.flatnonzero(~good)
    new = without(np.arange(second.eigenvalues.size), match.partner[good])
    turned = first.real_eigenvalues.size - second.real_eigenvalues.size
    told = counts == [2 * size] * 2 and first.zero_count == second.zero_count
    if not told or (gone.size and new.size) or turned != 2 * (new.size - gone.size):
        return none, none
    return (none, none) if 0.0 in (first.speed_rad_s, second.speed_rad_s) else (gone, new)


def _veering_of(match: Match, tracked: IntArray, meet: Meet) -> float:
    """Return where two branches exchange their order but may not pass through; nan if nowhere."""
    is_paired = (match.partner >= 0) & (match.mac > POOR_OVERLAP)
    paired, mine = np.flatnonzero(is_paired), tracked[is_paired[tracked]]
    if not mine.size:
        return float("nan")
    after = match.second.eigenvalues.imag[match.partner]
    before = match.first.eigenvalues.imag
    gap_before = before[paired] - before[mine, None]
    gap_after = after[paired] - after[mine, None]
    crossed = gap_before * gap_after < 0
    crossed &= np.abs(gap_before) > SAME_FREQUENCY * before[mine, None]
    crossed &= np.abs(gap_after) > SAME_FREQUENCY * after[mine, None]
    crossed &= _may_mix(match, mine, paired)
    seen = set()
    for row, column in np.argwhere(crossed):
        pair = np.array(sorted((mine[row], paired[column])))
        if tuple(pair) in seen:
            continue
        seen.add(tuple(pair))
        speed, is_passed = meet(match, pair)
        if not is_passed:
            return speed
    return float("nan")


def _may_mix(match: Match, mine: IntArray, others: IntArray) -> BoolArray:
    """Tell which modes can veer: those of one family, or any where families are not known."""
    families = [match.first.family, match.second.family]
    columns = [(mine, others), (match.partner[mine], match.partner[others])]
    mixing = np.ones((mine.size, others.size), dtype=bool)
    for family, (left, right) in zip(families, columns, strict=True):
        if family is not None:
            mixing &= family[left][:, None] == family[right]
    return mixing
