"""Following modes from speed to speed by the MAC of their states, never by their order."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.campbell.matching import POOR_OVERLAP, Match, Tracked, match_modes
from solidwhirl.rotordyn.campbell.places import meeting_in, place_to_look
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray, without
from solidwhirl.rotordyn.modes.eigen import Modes
from solidwhirl.rotordyn.perturbation.lowest_modes import LowestModes

# Smallest step for creeping motions alone, as a fraction of the step asked for.
_CREEPING_STEP = 2.0**-8
# Smallest step, as a fraction of the step asked for: births and ends are placed to it.
_SMALLEST_STEP = 2.0**-20
# Relative change of λ/Ω over half a step from rest, below which a motion is lifted by the spin from
# rest on: no beginning is looked for.
_LIFTED = 1e-6
# Eigen-solutions spent on one step at most.
_BUDGET = 150


class Chain(NamedTuple):
    """Branches from one speed on, as many at each speed, and what is still untracked.

    `at_speeds`: branches that begin later are −1 before; `starts`: columns at the first speed from
    which modes come that were met later only; `seeds`: speed and column where modes begin that were
    met later only.
    """

    at_speeds: list[Tracked]
    starts: frozenset[int]
    seeds: frozenset[tuple[float, int]]


class Tracker:
    """Follow branches through modes that are computed on demand.

    `mode_count`: modes to compute at each speed; more than are tracked, as branches enter from
    above. `needed`: number of lowest modes of a speed that must be on branches.
    """

    def __init__(
        self, assembled: AssembledSystem, mode_count: int, needed: Callable[[Modes], int]
    ) -> None:
        self.assembled = assembled
        self.needed = needed
        self.modes = LowestModes(assembled, mode_count, needed)
        self._matches: dict[tuple[Modes, float], Match] = {}
        self._meetings: dict[tuple[Modes, Modes, tuple[int, ...]], tuple[float, bool]] = {}

    def aligned(self, speed_rad_s: float, toward_rad_s: float) -> Modes:
        """Return the modes at a speed, equal ones turned as they part towards another speed."""
        here, there = self.modes.at(speed_rad_s), self.modes.at(toward_rad_s)
        return match_modes(self.assembled, there, here).second

    def follow(
        self,
        first: Modes,
        speeds_rad_s: FloatArray,
        starts: frozenset[int],
        seeds: frozenset[tuple[float, int]],
    ) -> Chain:
        """Follow branches from one speed through others, and all needed modes met on the way.

        `speeds_rad_s`: speeds to go to, monotonic away from there, shape (s,); `starts`: columns of
        `first` to follow; `seeds`: speeds and columns to follow from there on. The result is at the
        speeds given and at those added where modes change quickly, meet, begin or end.
        """
        self.modes.coming_rad_s = speeds_rad_s
        columns = np.array(sorted(starts), dtype=int)
        at_speeds = [Tracked(modes=first, columns=columns, overlap=np.ones(columns.size))]
        matches: list[Match] = []
        known: dict[float, list[int]] = {}
        for speed, column in seeds:
            known.setdefault(speed, []).append(column)
        for speed in speeds_rad_s:
            self._advance(at_speeds, matches, float(speed), known)
        return _traced_back(at_speeds, matches)

    def _advance(
        self,
        at_speeds: list[Tracked],
        matches: list[Match],
        stop_rad_s: float,
        seeds: dict[float, list[int]],
    ) -> None:
        """Append the branches up to a speed, halving where needed."""
        step = abs(stop_rad_s - at_speeds[-1].modes.speed_rad_s)
        fraction = _CREEPING_STEP
        targets, solved = [stop_rad_s], 0
        while targets:
            here, goal = at_speeds[-1], targets[-1]
            match = self._match(here.modes, goal)
            wanted = np.arange(self.needed(match.second))
            if goal in seeds:
                wanted = np.union1d(wanted, seeds[goal])
            solved += 1
            risen = self._lifted(match, targets[-2]) if len(targets) > 1 else wanted[:0]
            middle, is_lively = place_to_look(here, match, without(wanted, risen), self._meeting)
            # near its beginning a lively motion creeps, too
            fraction = _SMALLEST_STEP if is_lively else fraction
            begin = here.modes.speed_rad_s
            is_part = self.modes.is_part(begin) or self.modes.is_part(goal)
            if np.isfinite(middle) and is_part and _is_lost(here, match, wanted):
                # what begins or ends is judged by whole spectra
                self._replace_last(at_speeds, matches)
                self.modes.whole_at(goal)
                solved -= 1
                continue
            room = min(abs(goal - begin), abs(middle - begin), abs(goal - middle)) > fraction * step
            if np.isfinite(middle) and room and solved < _BUDGET:
                targets.append(middle)
                continue
            targets.pop()
            at_speeds.append(_step(here, match, wanted))
            matches.append(match)

    def _replace_last(self, at_speeds: list[Tracked], matches: list[Match]) -> None:
        """Put all modes of the last speed in the place of its lowest ones."""
        here = at_speeds[-1]
        speed = here.modes.speed_rad_s
        if not self.modes.is_part(speed):
            return
        match = match_modes(self.assembled, here.modes, self.modes.whole_at(speed))
        columns, last = here.columns.copy(), matches[-1]
        columns[columns >= 0] = match.partner[columns[columns >= 0]]
        partner = np.where(last.partner >= 0, match.partner[last.partner], -1)
        at_speeds[-1] = Tracked(modes=match.second, columns=columns, overlap=here.overlap)
        matches[-1] = last._replace(second=match.second, partner=partner)
        self._matches[last.first, speed] = matches[-1]

    def _lifted(self, match: Match, beyond_rad_s: float) -> IntArray:
        """Return new modes near rest whose λ is in proportion to the speed as far as one beyond."""
        here, there = match.second, self.modes.at(beyond_rad_s)
        if match.first.speed_rad_s != 0.0 or not there.eigenvalues.size:
            return np.empty(0, dtype=int)
        new = without(np.arange(here.eigenvalues.size), match.partner[match.mac > POOR_OVERLAP])
        rate = here.eigenvalues[new] / here.speed_rad_s
        other = there.eigenvalues / there.speed_rad_s
        change = np.abs(other - rate[:, None]).min(axis=1)
        return np.asarray(new[change < _LIFTED * np.abs(rate)])

    def _match(self, first: Modes, speed_rad_s: float) -> Match:
        """Return the match with the modes of a speed, computed once: following is repeated."""
        key, second = (first, speed_rad_s), self.modes.at(speed_rad_s)
        known = self._matches.get(key)
        if known is None or known.second.eigenvalues.size != second.eigenvalues.size:
            self._matches[key] = match_modes(self.assembled, first, second)
        return self._matches[key]

    def _meeting(self, match: Match, pair: IntArray) -> tuple[float, bool]:
        """Return where two modes of a match meet, computed once."""
        key = (match.first, match.second, tuple(pair.tolist()))
        if key not in self._meetings:
            self._meetings[key] = meeting_in(self.assembled, match, pair, self.modes.at_hand)
        return self._meetings[key]


def _traced_back(at_speeds: list[Tracked], matches: list[Match]) -> Chain:
    """Return as many branches at each speed, with where modes that were met late come from."""
    count = at_speeds[-1].columns.size
    columns = np.full((len(at_speeds), count), -1)
    overlap = np.ones((len(at_speeds), count))
    for place, at_speed in enumerate(at_speeds):
        columns[place, : at_speed.columns.size] = at_speed.columns
        overlap[place, : at_speed.overlap.size] = at_speed.overlap
    starts, seeds = set(), set()
    for branch in range(at_speeds[0].columns.size, count):
        place = met = int(np.flatnonzero(columns[:, branch] >= 0)[0])
        while place > 0:
            match = matches[place - 1]
            source = np.flatnonzero(match.partner == columns[place, branch])
            if not source.size or match.mac[source[0]] <= POOR_OVERLAP:
                break
            place -= 1
            columns[place, branch] = source[0]
            overlap[place + 1, branch] = match.mac[source[0]]
        if place == 0:
            starts.add(int(columns[0, branch]))
        elif place < met:
            seeds.add((at_speeds[place].modes.speed_rad_s, int(columns[place, branch])))
    full = [
        Tracked(modes=at_speed.modes, columns=own, overlap=mac)
        for at_speed, own, mac in zip(at_speeds, columns, overlap, strict=True)
    ]
    return Chain(full, frozenset(starts), frozenset(seeds))


def _is_lost(here: Tracked, match: Match, wanted: IntArray) -> bool:
    """Tell whether a branch has no partner, or a mode that is to be on one."""
    tracked = here.columns[here.columns >= 0]
    found = match.partner[match.mac > POOR_OVERLAP]
    ended = (match.mac[tracked] <= POOR_OVERLAP).any()
    return bool(ended or without(wanted, found).size)


def _step(here: Tracked, match: Match, wanted: IntArray) -> Tracked:
    """Return the branches reached by a match: branches without a MAC end, others begin."""
    alive = here.columns >= 0
    mac, columns = np.zeros(alive.size), np.full(alive.size, -1)
    mac[alive] = match.mac[here.columns[alive]]
    columns[alive] = match.partner[here.columns[alive]]
    columns[mac <= POOR_OVERLAP] = -1
    new = without(wanted, columns)
    return Tracked(
        modes=match.second,
        columns=np.concatenate((columns, new)),
        overlap=np.concatenate((mac, np.ones(new.size))),
    )
