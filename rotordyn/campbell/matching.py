"""Modes of two speeds paired by the MAC of their states.

Two modes are compared in the energy product of the state (q, λq), diag(K, M): modes of one
undamped system are orthogonal in it even where their frequencies are equal.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.system import AssembledSystem, matrices_at_speed
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray, real_times
from solidwhirl.rotordyn.modes.eigen import Modes, mode_columns

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


class _StateMetric(NamedTuple):
    """M and K of the energy product of states."""

    mass: FloatArray
    stiffness: FloatArray

    def unit(self, modes: Modes) -> _UnitStates:
        """Return the modes scaled to states of unit size."""
        conjugate = modes.shapes.conj()
        inertia = real_times(self.mass, modes.shapes)
        elastic = real_times(self.stiffness, modes.shapes)
        kinetic = (conjugate * inertia).sum(axis=0).real
        potential = (conjugate * elastic).sum(axis=0).real
        # the rounding of stiffnesses far apart can be negative
        size = np.sqrt(np.abs(potential) + np.abs(modes.eigenvalues) ** 2 * kinetic)
        scaled = dataclasses.replace(modes, shapes=modes.shapes / size)
        return _UnitStates(scaled, inertia / size, elastic / size)


class _UnitStates(NamedTuple):
    """Modes whose states have unit size, and M and K times their shapes."""

    modes: Modes
    inertia: ComplexArray
    elastic: ComplexArray

    def product(self, left: Modes) -> ComplexArray:
        """Return the products of the states (q, λq) of other modes with these."""
        right = self.modes
        result = np.zeros((left.eigenvalues.size, right.eigenvalues.size), dtype=complex)
        for rows, columns in _same_family(left, right):
            conjugate = left.shapes[:, rows].conj().T
            rates = np.multiply.outer(left.eigenvalues[rows].conj(), right.eigenvalues[columns])
            inertia = conjugate @ self.inertia[:, columns]
            block = conjugate @ self.elastic[:, columns] + rates * inertia
            result[np.ix_(rows, columns)] = block
        return result

    def columns(self, at: IntArray) -> _UnitStates:
        """Return some of the states."""
        return _UnitStates(mode_columns(self.modes, at), self.inertia[:, at], self.elastic[:, at])


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
    return metric.unit(second).product(metric.unit(first).modes)


def match_modes(assembled: AssembledSystem, first: Modes, second: Modes) -> Match:
    """Pair the modes of two speeds by the best total MAC.

    `first`, `second`: modes at two speeds. `second` has its clusters of equal frequencies
    turned within their subspace towards `first`, which is free to do, as any combination of them is
    a mode.
    """
    metric = _metric_between(assembled, first, second)
    states = metric.unit(second)
    product = states.product(metric.unit(first).modes)
    partner, mac = _assign(product)
    best = np.zeros(second.eigenvalues.size)
    best[partner[partner >= 0]] = mac[partner >= 0]
    shapes, is_turned = states.modes.shapes.copy(), False
    for cluster in _clusters(second.eigenvalues):
        if best[cluster].min() < _ALIGNED and first.eigenvalues.size >= cluster.size:
            turn = _turn(states.columns(cluster), product[:, cluster])
            shapes[:, cluster] = shapes[:, cluster] @ turn
            product[:, cluster] = product[:, cluster] @ turn
            is_turned = True
    if is_turned:
        partner, mac = _assign(product)
    return Match(first, dataclasses.replace(second, shapes=shapes), partner, mac)


def _turn(group: _UnitStates, product: ComplexArray) -> ComplexArray:
    """Return the change of basis of a cluster that brings it closest to its partners.

    A general eigensolver returns equal modes that are independent but not orthogonal, so the
    cluster is made orthonormal first. Shape (c, c). Frequencies of a cluster differ by a little:
    each goes to the state that is mostly its own, so that branches which pass through each other
    exchange theirs where they meet, from whichever side they come.
    """
    values, vectors = la.eigh(group.product(group.modes))
    if values[0] < _DEPENDENT * values[-1]:
        return np.eye(values.size, dtype=complex)
    straight: ComplexArray = (vectors / np.sqrt(values)) @ vectors.conj().T
    turned = product @ straight
    rows = np.argsort(-(np.abs(turned) ** 2).sum(axis=1), kind="stable")[: values.size]
    left, _, right = la.svd(turned[np.sort(rows)])
    turn: ComplexArray = straight @ (left @ right).conj().T
    size = np.sqrt((np.abs(turn) ** 2).sum(axis=0))
    _, order = scipy.optimize.linear_sum_assignment(-(np.abs(turn / size) ** 2))
    return np.asarray(turn[:, order])


def _assign(product: ComplexArray) -> tuple[IntArray, FloatArray]:
    mac = np.abs(product) ** 2
    rows, columns = scipy.optimize.linear_sum_assignment(-mac)
    partner = np.full(product.shape[0], -1)
    partner[rows] = columns
    found = np.zeros(product.shape[0])
    found[rows] = mac[rows, columns]
    return partner, found


def _clusters(eigenvalues: ComplexArray) -> list[IntArray]:
    """Return groups of two and more modes with equal frequency and damping."""
    apart = np.abs(np.diff(eigenvalues)) > SAME_FREQUENCY * np.abs(eigenvalues[1:])
    if apart.all():
        return []
    groups = np.split(np.arange(eigenvalues.size), np.flatnonzero(apart) + 1)
    return [group for group in groups if group.size > 1]
