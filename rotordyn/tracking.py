"""Following modes from speed to speed by the likeness of their states, never by their order.

Two modes are compared in the energy product of the state (q, λq), diag(K, M): modes of one
undamped system are orthogonal in it even where their frequencies are equal.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg as la
from scipy.optimize import linear_sum_assignment

from solidwhirl.rotordyn.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.eigen import Modes, modes_at_speed, whole_group_count
from solidwhirl.rotordyn.system import AssembledSystem, matrices_at_speed

IntArray = npt.NDArray[np.int_]

# Frequencies closer than this (relative) are one cluster, and a veering narrower a crossing.
SAME_FREQUENCY = 1e-4
# Below this likeness a step is halved.
GOOD_OVERLAP = 0.8
# Below this likeness two modes are not the same branch.
POOR_OVERLAP = 0.4
# A cluster is turned into the modes of its neighbour where the likeness is below this.
_ALIGNED = 0.95
# A cluster whose states are closer to dependent than this (squared) is left as it is.
_DEPENDENT = 1e-10
# Smallest step, as a fraction of the step asked for.
_SMALLEST_STEP = 2.0**-16
# Eigen-solutions spent on one step at most.
_BUDGET = 150


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Front:
    """Hold the tracked branches at one speed.

    Attributes
    ----------
    modes
        All modes computed there, scaled to unit energy of the state; clusters are turned to
        match the neighbour.
    columns
        Column of `modes` for each branch, −1 once a branch is lost; shape (b,).
    overlap
        Likeness to the previous front, 0 to 1, shape (b,).
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

    def select(self, branches: IntArray) -> Front:
        """Return the front with some of its branches."""
        return Front(
            modes=self.modes, columns=self.columns[branches], overlap=self.overlap[branches]
        )


class Match(NamedTuple):
    """Partner in `second` for each mode of `first` (−1: none), and the likeness."""

    first: Modes
    second: Modes
    partner: IntArray
    likeness: FloatArray


class Tracker:
    """Compute modes on demand and follow branches through them.

    Parameters
    ----------
    assembled
        The system.
    mode_count
        Modes to compute at each speed; more than are tracked, as branches enter from above.
    """

    def __init__(self, assembled: AssembledSystem, mode_count: int) -> None:
        self.assembled = assembled
        self.mode_count = mode_count
        self._known: dict[float, Modes] = {}

    def modes_at(self, speed_rad_s: float) -> Modes:
        """Return the modes at a speed, computed once."""
        if speed_rad_s not in self._known:
            self._known[speed_rad_s] = modes_at_speed(self.assembled, speed_rad_s, self.mode_count)
        return self._known[speed_rad_s]

    def follow(self, speeds_rad_s: FloatArray, branch_count: int) -> list[Front]:
        """Follow the lowest branches of the first speed through all speeds.

        Parameters
        ----------
        speeds_rad_s
            Monotonic, shape (s,).
        branch_count
            Number of branches, more where one of equal frequencies would be left out.

        Returns
        -------
        list of Front
            At the speeds given and at those added where modes change quickly or meet.
        """
        first = self.modes_at(float(speeds_rad_s[0]))
        columns = np.arange(whole_group_count(first.eigenvalues, branch_count))
        fronts = [Front(modes=first, columns=columns, overlap=np.ones(columns.size))]
        for index, speed in enumerate(speeds_rad_s[1:]):
            if index == 0:
                second = self.modes_at(float(speed))
                turned = match_modes(self.assembled, second, first).second
                fronts[0] = dataclasses.replace(fronts[0], modes=turned)
            fronts += self._advance(fronts[-1], float(speed))
        return fronts

    def _advance(self, start: Front, stop_rad_s: float) -> list[Front]:
        """Return the fronts from one speed (excluded) to the next, halving where needed."""
        smallest = _SMALLEST_STEP * abs(stop_rad_s - start.modes.speed_rad_s)
        targets, fronts, solved = [stop_rad_s], [start], 0
        while targets:
            here, goal = fronts[-1], targets[-1]
            match = match_modes(self.assembled, here.modes, self.modes_at(goal))
            solved += 1
            middle = _place_to_look(here, match)
            begin = here.modes.speed_rad_s
            room = min(abs(goal - begin), abs(middle - begin), abs(goal - middle)) > smallest
            if np.isfinite(middle) and room and solved < _BUDGET:
                targets.append(middle)
                continue
            targets.pop()
            fronts.append(_step(here, match))
        return fronts[1:]


def _step(here: Front, match: Match) -> Front:
    """Return the front reached by a match; a branch without a likeness is lost."""
    alive = here.columns >= 0
    likeness, columns = np.zeros(alive.size), np.full(alive.size, -1)
    likeness[alive] = match.likeness[here.columns[alive]]
    columns[alive] = match.partner[here.columns[alive]]
    columns[likeness <= POOR_OVERLAP] = -1
    return Front(modes=match.second, columns=columns, overlap=likeness)


def _place_to_look(here: Front, match: Match) -> float:
    """Return a speed between two that should be looked at, nan if none.

    Halves the step where a branch changes much; where two branches exchange their order, goes to
    where they meet, so that a veering between the speeds is not taken for a crossing.
    """
    begin, end = match.first.speed_rad_s, match.second.speed_rad_s
    tracked = here.columns[here.columns >= 0]
    if (match.likeness[tracked] < GOOD_OVERLAP).any():
        return 0.5 * (begin + end)
    paired = np.flatnonzero((match.partner >= 0) & (match.likeness > POOR_OVERLAP))
    after = match.second.eigenvalues.imag[match.partner]
    before = match.first.eigenvalues.imag
    mine = tracked[np.isin(tracked, paired)]
    gap_before = before[paired] - before[mine, None]
    gap_after = after[paired] - after[mine, None]
    crossed = gap_before * gap_after < 0
    crossed &= np.abs(gap_before) > SAME_FREQUENCY * before[mine, None]
    crossed &= np.abs(gap_after) > SAME_FREQUENCY * after[mine, None]
    crossed &= _may_mix(match, mine, paired)
    if not crossed.any():
        return float("nan")
    row, column = np.argwhere(crossed)[0]
    sizes = abs(gap_before[row, column]), abs(gap_after[row, column])
    part = sizes[0] / (sizes[0] + sizes[1])
    return begin + float(np.clip(part, 0.02, 0.98)) * (end - begin)


def _may_mix(match: Match, mine: IntArray, others: IntArray) -> npt.NDArray[np.bool_]:
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
        inertia = left.shapes.conj().T @ self.mass @ right.shapes
        elastic = left.shapes.conj().T @ self.stiffness @ right.shapes
        rates = np.multiply.outer(left.eigenvalues.conj(), right.eigenvalues)
        return np.asarray(elastic + rates * inertia)

    def unit(self, modes: Modes) -> Modes:
        """Return the modes scaled to states of unit size."""
        conjugate = modes.shapes.conj()
        inertia = (conjugate * (self.mass @ modes.shapes)).sum(axis=0).real
        elastic = (conjugate * (self.stiffness @ modes.shapes)).sum(axis=0).real
        # the rounding of stiffnesses far apart can be negative
        size = np.sqrt(np.abs(elastic) + np.abs(modes.eigenvalues) ** 2 * inertia)
        return dataclasses.replace(modes, shapes=modes.shapes / size)


def _metric_between(assembled: AssembledSystem, first: Modes, second: Modes) -> _StateMetric:
    """Return the energy product half-way between two speeds.

    Where the stiffness is not positive the velocities alone are compared.
    """
    mean = np.sqrt(0.5 * (first.speed_rad_s**2 + second.speed_rad_s**2))
    matrices = matrices_at_speed(assembled, float(mean))
    stiffness = 0.5 * (matrices.stiffness + matrices.stiffness.T)
    if first.negative_stiffness_count or second.negative_stiffness_count:
        stiffness = np.zeros_like(stiffness)
    return _StateMetric(matrices.mass, stiffness)


def overlaps(assembled: AssembledSystem, first: Modes, second: Modes) -> ComplexArray:
    """Return the products of unit states of two sets of modes.

    Parameters
    ----------
    assembled
        The system.
    first, second
        Modes at two speeds.

    Returns
    -------
    ndarray
        Shape (m1, m2); the squared absolute value is the modal assurance in the energy product
        of the mean of both stiffnesses.
    """
    metric = _metric_between(assembled, first, second)
    return metric.product(metric.unit(first), metric.unit(second))


def match_modes(assembled: AssembledSystem, first: Modes, second: Modes) -> Match:
    """Pair the modes of two speeds by the best total likeness.

    Parameters
    ----------
    assembled
        The system.
    first, second
        Modes at two speeds.

    Returns
    -------
    Match
        `second` has its clusters of equal frequencies turned within their subspace towards
        `first`, which is free to do, as any combination of them is a mode.
    """
    metric = _metric_between(assembled, first, second)
    unit_first, unit_second = metric.unit(first), metric.unit(second)
    product = metric.product(unit_first, unit_second)
    partner, likeness = _assign(product)
    best = np.zeros(second.eigenvalues.size)
    best[partner[partner >= 0]] = likeness[partner >= 0]
    shapes = unit_second.shapes.copy()
    for cluster in _clusters(second.eigenvalues):
        if best[cluster].min() < _ALIGNED and first.eigenvalues.size >= cluster.size:
            turn = _turn(metric, mode_columns(unit_second, cluster), product[:, cluster])
            shapes[:, cluster] = shapes[:, cluster] @ turn
            product[:, cluster] = product[:, cluster] @ turn
    partner, likeness = _assign(product)
    return Match(first, dataclasses.replace(second, shapes=shapes), partner, likeness)


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
    likeness = np.abs(product) ** 2
    rows, columns = linear_sum_assignment(-likeness)
    partner = np.full(product.shape[0], -1)
    partner[rows] = columns
    found = np.zeros(product.shape[0])
    found[rows] = likeness[rows, columns]
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
