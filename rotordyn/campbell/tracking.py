"""Following modes from speed to speed by the MAC of their states, never by their order.

Two modes are compared in the energy product of the state (q, λq), diag(K, M): modes of one
undamped system are orthogonal in it even where their frequencies are equal.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy.linalg as la
from scipy.optimize import linear_sum_assignment

from solidwhirl.rotordyn.assembly.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from solidwhirl.rotordyn.modes.damping import damping_ratio
from solidwhirl.rotordyn.modes.eigen import Modes, modes_at_speed

# Frequencies closer than this (relative) are one cluster, and a veering narrower a crossing.
SAME_FREQUENCY = 1e-4
# Below this MAC a step is halved.
GOOD_OVERLAP = 0.8
# Below this MAC two modes are not the same branch.
POOR_OVERLAP = 0.4
# A cluster is turned into the modes of its neighbour where the MAC is below this.
_ALIGNED = 0.95
# A cluster whose states are closer to dependent than this (squared) is left as it is.
_DEPENDENT = 1e-10
# Above this damping ratio a motion creeps: which of many it is at the next speed is no matter.
CREEPING = 0.995
# Smallest step for such motions alone, as a fraction of the step asked for.
_CREEPING_STEP = 2.0**-8
# Smallest step, as a fraction of the step asked for: births and ends are placed to it.
_SMALLEST_STEP = 2.0**-20
# Relative change of λ/Ω over half a step from rest, below which a motion is lifted by the spin from
# rest on: no beginning is looked for.
_LIFTED = 1e-6
# Eigen-solutions spent on one step at most.
_BUDGET = 150


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Tracked:
    """Hold the tracked branches at one speed.

    `modes`: all modes computed there, scaled to unit energy of the state; clusters are turned to
    match the neighbour. `columns`: column of `modes` for each branch, −1 once a branch is lost;
    shape (b,). `overlap`: MAC to the previous speed, 0 to 1, shape (b,).
    """

    modes: Modes
    columns: IntArray
    overlap: FloatArray

    def values(self) -> ComplexArray:
        """Return λ of each branch, nan where it is lost."""
        values = np.full(self.columns.size, complex(np.nan, np.nan))
        alive = self.columns >= 0
        values[alive] = self.modes.eigenvalues[self.columns[alive]]
        return values

    def select(self, branches: IntArray) -> Tracked:
        """Return some of the branches."""
        return Tracked(
            modes=self.modes, columns=self.columns[branches], overlap=self.overlap[branches]
        )


class Match(NamedTuple):
    """Partner in `second` for each mode of `first` (−1: none), and the MAC."""

    first: Modes
    second: Modes
    partner: IntArray
    mac: FloatArray


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
    """Compute modes on demand and follow branches through them.

    `mode_count`: modes to compute at each speed; more than are tracked, as branches enter from
    above. `needed`: number of lowest modes of a speed that must be on branches.
    """

    def __init__(
        self, assembled: AssembledSystem, mode_count: int, needed: Callable[[Modes], int]
    ) -> None:
        self.assembled = assembled
        self.mode_count = mode_count
        self.needed = needed
        self._known: dict[float, Modes] = {}
        self._matches: dict[tuple[int, float], Match] = {}

    def modes_at(self, speed_rad_s: float) -> Modes:
        """Return the modes at a speed, computed once."""
        if speed_rad_s not in self._known:
            self._known[speed_rad_s] = modes_at_speed(self.assembled, speed_rad_s, self.mode_count)
        return self._known[speed_rad_s]

    def aligned(self, speed_rad_s: float, toward_rad_s: float) -> Modes:
        """Return the modes at a speed, equal ones turned as they part towards another speed."""
        here, there = self.modes_at(speed_rad_s), self.modes_at(toward_rad_s)
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
            wanted = np.union1d(np.arange(self.needed(match.second)), seeds.get(goal, [])).astype(
                int
            )
            solved += 1
            risen = self._lifted(match, targets[-2]) if len(targets) > 1 else wanted[:0]
            middle, is_lively = _place_to_look(here, match, np.setdiff1d(wanted, risen))
            # near its beginning a lively motion creeps, too
            fraction = _SMALLEST_STEP if is_lively else fraction
            begin = here.modes.speed_rad_s
            room = min(abs(goal - begin), abs(middle - begin), abs(goal - middle)) > fraction * step
            if np.isfinite(middle) and room and solved < _BUDGET:
                targets.append(middle)
                continue
            targets.pop()
            at_speeds.append(_step(here, match, wanted))
            matches.append(match)

    def _lifted(self, match: Match, beyond_rad_s: float) -> IntArray:
        """Return new modes near rest whose λ is in proportion to the speed as far as one beyond."""
        here, there = match.second, self.modes_at(beyond_rad_s)
        if match.first.speed_rad_s != 0.0 or not there.eigenvalues.size:
            return np.empty(0, dtype=int)
        new = np.setdiff1d(
            np.arange(here.eigenvalues.size), match.partner[match.mac > POOR_OVERLAP]
        )
        rate = here.eigenvalues[new] / here.speed_rad_s
        other = there.eigenvalues / there.speed_rad_s
        change = np.abs(other - rate[:, None]).min(axis=1)
        return np.asarray(new[change < _LIFTED * np.abs(rate)])

    def _match(self, first: Modes, speed_rad_s: float) -> Match:
        """Return the match with the modes of a speed, computed once: following is repeated."""
        key = (id(first), speed_rad_s)
        if key not in self._matches:
            self._matches[key] = match_modes(self.assembled, first, self.modes_at(speed_rad_s))
        return self._matches[key]


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


def _step(here: Tracked, match: Match, wanted: IntArray) -> Tracked:
    """Return the branches reached by a match: branches without a MAC end, others begin."""
    alive = here.columns >= 0
    mac, columns = np.zeros(alive.size), np.full(alive.size, -1)
    mac[alive] = match.mac[here.columns[alive]]
    columns[alive] = match.partner[here.columns[alive]]
    columns[mac <= POOR_OVERLAP] = -1
    new = np.setdiff1d(wanted, columns)
    return Tracked(
        modes=match.second,
        columns=np.concatenate((columns, new)),
        overlap=np.concatenate((mac, np.ones(new.size))),
    )


def _place_to_look(here: Tracked, match: Match, wanted: IntArray) -> tuple[float, bool]:
    """Return a speed between two that should be looked at, nan if none, and if closely.

    Halves the step where a branch changes much, begins or ends; where two branches exchange their
    order, goes to where they meet, so that a veering between the speeds is not taken for a
    crossing. Of motions that creep more than they oscillate only beginnings and ends matter.
    """
    begin, end = match.first.speed_rad_s, match.second.speed_rad_s
    creeping = [damping_ratio(m.eigenvalues) > CREEPING for m in (match.first, match.second)]
    tracked = here.columns[here.columns >= 0]
    back = np.zeros(match.second.eigenvalues.size)
    back[match.partner[match.partner >= 0]] = match.mac[match.partner >= 0]
    mac = np.concatenate((match.mac[tracked], back[wanted]))
    creeps = np.concatenate((creeping[0][tracked], creeping[1][wanted]))
    if (mac[~creeps] < GOOD_OVERLAP).any() or (mac[creeps] <= POOR_OVERLAP).any():
        return 0.5 * (begin + end), bool((mac[~creeps] < GOOD_OVERLAP).any())
    tracked = tracked[~creeping[0][tracked]]
    paired = np.flatnonzero((match.partner >= 0) & (match.mac > POOR_OVERLAP))
    mine = tracked[np.isin(tracked, paired)]
    if not mine.size:
        return float("nan"), False
    after = match.second.eigenvalues.imag[match.partner]
    before = match.first.eigenvalues.imag
    gap_before = before[paired] - before[mine, None]
    gap_after = after[paired] - after[mine, None]
    crossed = gap_before * gap_after < 0
    crossed &= np.abs(gap_before) > SAME_FREQUENCY * before[mine, None]
    crossed &= np.abs(gap_after) > SAME_FREQUENCY * after[mine, None]
    crossed &= _may_mix(match, mine, paired)
    if not crossed.any():
        return float("nan"), False
    row, column = np.argwhere(crossed)[0]
    sizes = abs(gap_before[row, column]), abs(gap_after[row, column])
    part = sizes[0] / (sizes[0] + sizes[1])
    return begin + float(np.clip(part, 0.02, 0.98)) * (end - begin), True


def _may_mix(match: Match, mine: IntArray, others: IntArray) -> BoolArray:
    """Tell which modes can veer: those of one family, or any where families are not known."""
    families = [match.first.family, match.second.family]
    columns = [(mine, others), (match.partner[mine], match.partner[others])]
    mixing = np.ones((mine.size, others.size), dtype=bool)
    for family, (left, right) in zip(families, columns, strict=True):
        if family is not None:
            mixing &= family[left][:, None] == family[right]
    return mixing


class _StateMetric(NamedTuple):
    """M and K of the energy product of states."""

    mass: FloatArray
    stiffness: FloatArray

    def product(self, left: Modes, right: Modes) -> ComplexArray:
        """Return the products of the states (q, λq) of two sets of modes."""
        inertia, elastic = _times(self.mass, right.shapes), _times(self.stiffness, right.shapes)
        result = np.zeros((left.eigenvalues.size, right.eigenvalues.size), dtype=complex)
        for rows, columns in _same_family(left, right):
            conjugate = left.shapes[:, rows].conj().T
            rates = np.multiply.outer(left.eigenvalues[rows].conj(), right.eigenvalues[columns])
            block = conjugate @ elastic[:, columns] + rates * (conjugate @ inertia[:, columns])
            result[np.ix_(rows, columns)] = block
        return result

    def unit(self, modes: Modes) -> Modes:
        """Return the modes scaled to states of unit size."""
        conjugate = modes.shapes.conj()
        inertia = (conjugate * _times(self.mass, modes.shapes)).sum(axis=0).real
        elastic = (conjugate * _times(self.stiffness, modes.shapes)).sum(axis=0).real
        # the rounding of stiffnesses far apart can be negative
        size = np.sqrt(np.abs(elastic) + np.abs(modes.eigenvalues) ** 2 * inertia)
        return dataclasses.replace(modes, shapes=modes.shapes / size)


def _times(matrix: FloatArray, shapes: ComplexArray) -> ComplexArray:
    """Return the product of a real matrix with complex shapes, at half the work."""
    parts = np.ascontiguousarray(shapes).astype(complex, copy=False).view(float)
    return np.asarray((matrix @ parts).view(complex))


def _same_family(left: Modes, right: Modes) -> list[tuple[IntArray, IntArray]]:
    """Return the rows and columns of each family: those of two have no product."""
    if left.family is None or right.family is None:
        return [(np.arange(left.eigenvalues.size), np.arange(right.eigenvalues.size))]
    return [
        (np.flatnonzero(left.family == f), np.flatnonzero(right.family == f)) for f in (-1, 0, 1)
    ]


def _metric_between(assembled: AssembledSystem, first: Modes, second: Modes) -> _StateMetric:
    """Return the energy product half-way between two speeds.

    Where the stiffness is not positive its eigenvalues are taken with their sizes.
    """
    mean = np.sqrt(0.5 * (first.speed_rad_s**2 + second.speed_rad_s**2))
    matrices = matrices_at_speed(assembled, float(mean))
    stiffness = 0.5 * (matrices.stiffness + matrices.stiffness.T)
    if first.negative_stiffness_count or second.negative_stiffness_count:
        values, vectors = la.eigh(stiffness, matrices.mass)
        half = matrices.mass @ vectors
        stiffness = (half * np.abs(values)) @ half.T
    return _StateMetric(matrices.mass, stiffness)


def overlaps(assembled: AssembledSystem, first: Modes, second: Modes) -> ComplexArray:
    """Return the products of unit states of two sets of modes.

    `first`, `second`: modes at two speeds. Returns shape (m1, m2); the squared absolute value is
    the modal assurance in the energy product of the mean of both stiffnesses.
    """
    metric = _metric_between(assembled, first, second)
    return metric.product(metric.unit(first), metric.unit(second))


def match_modes(assembled: AssembledSystem, first: Modes, second: Modes) -> Match:
    """Pair the modes of two speeds by the best total MAC.

    `first`, `second`: modes at two speeds. `second` has its clusters of equal frequencies
    turned within their subspace towards `first`, which is free to do, as any combination of them is
    a mode.
    """
    metric = _metric_between(assembled, first, second)
    unit_first, unit_second = metric.unit(first), metric.unit(second)
    product = metric.product(unit_first, unit_second)
    partner, mac = _assign(product)
    best = np.zeros(second.eigenvalues.size)
    best[partner[partner >= 0]] = mac[partner >= 0]
    shapes = unit_second.shapes.copy()
    for cluster in _clusters(second.eigenvalues):
        if best[cluster].min() < _ALIGNED and first.eigenvalues.size >= cluster.size:
            turn = _turn(metric, mode_columns(unit_second, cluster), product[:, cluster])
            shapes[:, cluster] = shapes[:, cluster] @ turn
            product[:, cluster] = product[:, cluster] @ turn
    partner, mac = _assign(product)
    return Match(first, dataclasses.replace(second, shapes=shapes), partner, mac)


def _turn(metric: _StateMetric, group: Modes, product: ComplexArray) -> ComplexArray:
    """Return the change of basis of a cluster that brings it closest to its partners.

    A general eigensolver returns equal modes that are independent but not orthogonal, so the
    cluster is made orthonormal first. Shape (c, c). Frequencies of a cluster differ by a little:
    each goes to the state that is mostly its own, so that branches which pass through each other
    exchange theirs where they meet, from whichever side they come.
    """
    values, vectors = la.eigh(metric.product(group, group))
    if values[0] < _DEPENDENT * values[-1]:
        return np.eye(values.size, dtype=complex)
    straight: ComplexArray = (vectors / np.sqrt(values)) @ vectors.conj().T
    turned = product @ straight
    rows = np.argsort(-(np.abs(turned) ** 2).sum(axis=1), kind="stable")[: values.size]
    left, _, right = la.svd(turned[np.sort(rows)])
    turn: ComplexArray = straight @ (left @ right).conj().T
    size = np.sqrt((np.abs(turn) ** 2).sum(axis=0))
    _, order = linear_sum_assignment(-(np.abs(turn / size) ** 2))
    return np.asarray(turn[:, order])


def mode_columns(modes: Modes, columns: IntArray) -> Modes:
    """Return some of the modes of a set."""
    return dataclasses.replace(
        modes,
        eigenvalues=modes.eigenvalues[columns],
        shapes=modes.shapes[:, columns],
        family=None if modes.family is None else modes.family[columns],
    )


def _assign(product: ComplexArray) -> tuple[IntArray, FloatArray]:
    mac = np.abs(product) ** 2
    rows, columns = linear_sum_assignment(-mac)
    partner = np.full(product.shape[0], -1)
    partner[rows] = columns
    found = np.zeros(product.shape[0])
    found[rows] = mac[rows, columns]
    return partner, found


def _clusters(eigenvalues: ComplexArray) -> list[IntArray]:
    """Return groups of two and more modes with equal frequency and damping."""
    groups, group = [], [0]
    for index in range(1, eigenvalues.size):
        distance = abs(eigenvalues[index] - eigenvalues[index - 1])
        if distance <= SAME_FREQUENCY * abs(eigenvalues[index]):
            group.append(index)
            continue
        groups.append(group)
        group = [index]
    groups.append(group)
    return [np.array(group) for group in groups if len(group) > 1]
