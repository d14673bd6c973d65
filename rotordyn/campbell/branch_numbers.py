"""Which branch of a Campbell diagram a mode is: one number in every analysis.

And shapes of modes in a few numbers, by which the same mode is found again in another case.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy

from solidwhirl.rotordyn.assembly.coordinates import body_rows
from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.campbell.body_frames import branch_columns
from solidwhirl.rotordyn.campbell.diagram import Campbell
from solidwhirl.rotordyn.campbell.matching import overlaps
from solidwhirl.rotordyn.campbell.tracking import Tracker
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray
from solidwhirl.rotordyn.modes.eigen import Modes, mode_columns, modes_at_speed
from solidwhirl.rotordyn.superelement.centreline import interface_rows

# Eigenvalues of branches closer than this (relative) do not tell them apart.
_SAME = 1e-7
# A mode is a branch if their eigenvalues differ by less than this (relative).
_FOUND = 1e-6
# Weight of the order beside the MAC.
_IN_ORDER = 1e-2
# Interfaces whose motion is kept in a print; of more, so many evenly spread ones.
_MOST = 16
_DIGITS = 4


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
        there = np.flatnonzero(np.isfinite(diagram.eigenvalues[:, place]))
        if np.isin(there, numbers - 1).all():
            continue  # following them would find nothing new
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
    first = tracker.modes.at(begin)
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
    mac = 0.0 if still else np.abs(overlaps(assembled, modes, found)) ** 2
    place = np.arange(max(apart.shape)) / max(apart.shape)
    order = np.abs(place[: apart.shape[0], None] - place[: apart.shape[1]])
    cost = np.minimum(apart / _FOUND, 2.0) - mac + _IN_ORDER * order
    rows, columns = scipy.optimize.linear_sum_assignment(cost)
    near = apart[rows, columns] <= _FOUND
    partner[rows[near]] = columns[near]
    return partner


def shape_print(system: AssembledSystem, shape: ComplexArray) -> list[float]:
    """Return the lateral motion of interfaces in a mode, of unit length.

    `shape`: the mode in its independent coordinates, complex (n,). Returns real and imaginary part
    of ux and uy of each interface in turn, four numbers each; zeros for a mode without lateral
    motion there (axial, torsion, disks alone).
    """
    motions = [
        np.tensordot(interface_rows(rotor.element).modes, body_rows(system, name) @ shape, axes=1)
        for name, rotor in system.system.rotors.items()
    ]
    places = np.concatenate(motions)
    kept = np.unique(np.linspace(0, len(places) - 1, min(_MOST, len(places))).round().astype(int))
    motion = places[kept].ravel() if len(places) else np.zeros(0, dtype=complex)
    length = float(np.linalg.norm(motion))
    # a motion that is rounding beside that of the whole mode has no shape
    if length <= 1e-9 * float(np.linalg.norm(shape)):
        motion = np.zeros_like(motion)
    else:
        motion = motion / length
    return [round(float(v), _DIGITS) for v in motion.view(float)]


def branch_prints(system: AssembledSystem, diagram: Campbell) -> list[list[float]]:
    """Return the print of each branch of a diagram, at the last speed at which it exists.

    The result is from `shape_print`; zeros for a branch whose mode is not found there. At rest
    equal modes have no shapes of their own: empty for a diagram without a speed above 0.
    """
    alive = np.isfinite(diagram.frequency_hz)
    last = alive.shape[1] - 1 - alive[:, ::-1].argmax(axis=1)
    if not diagram.speeds_rad_s[last].all():
        return []
    found: dict[int, list[float]] = {}
    for at in np.unique(last):
        modes = modes_at_speed(system, float(diagram.speeds_rad_s[at]))
        numbers = branch_numbers(system, diagram, modes)
        for branch in np.flatnonzero((last == at) & np.isin(np.arange(1, last.size + 1), numbers)):
            own = int(np.flatnonzero(numbers == branch + 1)[0])
            found[int(branch)] = shape_print(system, modes.shapes[:, own])
    length = max(map(len, found.values()), default=0)
    return [found.get(branch, [0.0] * length) for branch in range(last.size)]


def modal_assurance(first: ComplexArray, second: ComplexArray) -> FloatArray:
    """Return the modal assurance criterion of all pairs of shapes, (first, second).

    `first`, `second`: shapes in rows. Those that are zero are like each other and unlike all
    others. Returns |a^H b|² / (a^H a · b^H b): 1 for the same shape whatever its scale and phase, 0
    for orthogonal ones such as forward and backward whirl.
    """
    product = np.abs(first.conj() @ second.T) ** 2
    norms = (np.linalg.norm(first, axis=1) ** 2)[:, None] * np.linalg.norm(second, axis=1) ** 2
    still = ~first.any(axis=1)[:, None] & ~second.any(axis=1)
    return np.where(norms > 0.0, product / np.where(norms > 0.0, norms, 1.0), still.astype(float))
