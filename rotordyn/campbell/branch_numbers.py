"""Which branch of a Campbell diagram a mode is: one number in every analysis."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.optimize import linear_sum_assignment

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.campbell.body_frames import branch_columns
from solidwhirl.rotordyn.campbell.diagram import Campbell
from solidwhirl.rotordyn.campbell.tracking import Tracker, mode_columns, overlaps
from solidwhirl.rotordyn.core.arrays import ComplexArray, IntArray
from solidwhirl.rotordyn.modes.eigen import Modes

# Eigenvalues of branches closer than this (relative) do not tell them apart.
_SAME = 1e-7
# A mode is a branch if their eigenvalues differ by less than this (relative).
_FOUND = 1e-6
# Weight of the order beside the likeness.
_IN_ORDER = 1e-2


def branch_numbers(assembled: AssembledSystem, diagram: Campbell, modes: Modes) -> IntArray:
    """Return the number of the branch that each mode of a system is on.

    `modes`: of the system at any one speed. Returns numbers from 1, 0 for a mode that no branch
    holds, shape (m,).

    Branches are followed from the nearest speed of the diagram, on either side, at which their
    eigenvalues are apart, and told by eigenvalue and shape.
    """
    numbers = np.zeros(modes.eigenvalues.size, dtype=int)
    if not len(diagram.eigenvalues) or not numbers.size:
        return numbers
    for place in _anchors(diagram, modes.speed_rad_s):
        branches, found = _at_speed(assembled, diagram, place, modes.speed_rad_s)
        new = ~np.isin(branches, numbers - 1)
        if not new.any():
            continue
        free = np.flatnonzero(numbers == 0)
        partner = _partners(
            assembled, mode_columns(modes, free), mode_columns(found, np.flatnonzero(new))
        )
        has = partner >= 0
        numbers[free[has]] = branches[new][partner[has]] + 1
    return numbers


def _anchors(diagram: Campbell, speed_rad_s: float) -> Iterator[int]:
    """Yield the speeds of the diagram to start from: the nearest on either side."""
    speeds = diagram.speeds_rad_s
    equal = np.array([_equal_pairs(column) for column in diagram.eigenvalues.T])
    distance = np.abs(speeds - speed_rad_s)
    for side in (speeds <= speed_rad_s, speeds > speed_rad_s):
        if side.any():
            at = np.flatnonzero(side)
            yield int(at[np.lexsort((distance[at], equal[at]))[0]])


def _equal_pairs(values: ComplexArray) -> int:
    known = values[np.isfinite(values)]
    near = np.abs(known[:, None] - known) <= _SAME * np.abs(known)
    pairs: int = np.count_nonzero(near) - known.size
    return pairs


def _at_speed(
    assembled: AssembledSystem, diagram: Campbell, place: int, speed_rad_s: float
) -> tuple[IntArray, Modes]:
    """Return the branches that reach a speed, and their modes there."""
    begin = float(diagram.speeds_rad_s[place])
    tracker = Tracker(assembled, assembled.size, lambda _: 0)
    values = diagram.eigenvalues[:, place]
    alive = np.flatnonzero(np.isfinite(values))
    first = tracker.modes_at(begin)
    columns = branch_columns(values[alive], first.eigenvalues, begin)
    if begin == speed_rad_s:
        return alive, mode_columns(first, columns)
    first = tracker.aligned(begin, speed_rad_s)
    chain = tracker.follow(
        first, np.array([speed_rad_s]), frozenset(int(c) for c in columns), frozenset()
    )
    last = chain.at_speeds[-1]
    reached = last.columns >= 0
    return alive[np.argsort(columns)][reached], mode_columns(last.modes, last.columns[reached])


def _partners(assembled: AssembledSystem, modes: Modes, found: Modes) -> IntArray:
    """Return for each mode the one of equal eigenvalue, of several the most alike; −1 for none."""
    partner = np.full(modes.eigenvalues.size, -1)
    apart = np.abs(modes.eigenvalues[:, None] - found.eigenvalues)
    apart /= np.abs(modes.eigenvalues)[:, None]
    # at rest any combination of equal modes is one: they keep their order
    still = modes.speed_rad_s == 0
    likeness = 0.0 if still else np.abs(overlaps(assembled, modes, found)) ** 2
    place = np.arange(max(apart.shape)) / max(apart.shape)
    order = np.abs(place[: apart.shape[0], None] - place[: apart.shape[1]])
    cost = np.minimum(apart / _FOUND, 2.0) - likeness + _IN_ORDER * order
    rows, columns = linear_sum_assignment(cost)
    near = apart[rows, columns] <= _FOUND
    partner[rows[near]] = columns[near]
    return partner
