"""The independent coordinates of a system: stiff and exact joints written as relative motions.

Joined coordinates are written as "that of the neighbour plus a relative motion", along the stiffest
path. A rigid joint drops the relative motion; a stiff bearing acts on it alone, so that its number
is never added to, and never swallows, the stiffness of the bodies. The teeth of a gear get their
relative motion as a coordinate in the same way.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from solidwhirl.rotordyn.assembly.coordinates import Rows, seat_motion, tooth_motion
from solidwhirl.rotordyn.assembly.parts import Gear, System
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AssemblyError
from solidwhirl.rotordyn.superelement.validation import MOTIONS

GROUND = -1
# Motions of a tied body below this fraction of the largest are the same.
_DEPENDENT = 1e-12
# Speed at which the strength of speed-dependent bearings is compared with others.
_AT_REST = 0.0


def independent_coordinates(system: System, slices: Mapping[str, slice]) -> FloatArray:
    """Return the matrix from independent coordinates to those of all bodies, shape (N, n).

    `slices`: rows of each body. Entries 0 and 1 but for gears. Exact constraints are eliminated.
    Raises AssemblyError if the joints hold every coordinate, or a gear acts on nothing that can
    move.
    """
    matrix, strength = _transformation(system, slices)
    for name, rotor in system.rotors.items():
        if rotor.element.constraint is not None:
            rows = matrix[slices[name]]
            change = _tied(rows, rotor.element.constraint, strength)
            matrix, strength = _product(matrix, change.motion), change.strength
    for gear in system.gears:
        matrix = _with_gear(Rows(system, slices, matrix), gear)
    if matrix.shape[1] == 0:
        raise AssemblyError(("the rigid joints hold every coordinate; nothing can move",))
    return matrix


def _with_gear(rows: Rows, gear: Gear) -> FloatArray:
    """Replace one independent coordinate by the relative motion of the teeth, or drop it.

    The pivot turns a seat: that of the wheel whose torsion is its own coordinate. Where the teeth
    never move against each other, as other joints close a loop with the same ratios, the gear says
    nothing new.
    """
    motion, transformation = tooth_motion(rows, gear), rows.transformation
    turning = np.zeros(motion.size)
    for end, factor in zip(gear.ends, gear.tooth_motion(), strict=True):
        turning += np.abs(factor[5] * seat_motion(rows, end)[5])
    if not turning.any():
        raise AssemblyError((f"gear {gear.name!r}: neither of its two seats can turn",))
    if np.abs(motion).max() <= _DEPENDENT * turning.max():
        return transformation
    pivot = int(np.argmax(np.where(turning > _DEPENDENT * turning.max(), np.abs(motion), 0.0)))
    if np.abs(motion[pivot]) <= _DEPENDENT * turning.max():
        raise AssemblyError((f"gear {gear.name!r}: its seats can turn together only",))
    change = np.eye(motion.size)
    change[pivot] = -motion / motion[pivot]
    change[pivot, pivot] = 1.0 / motion[pivot]
    if gear.mesh_stiffness_n_per_m is None:
        change = np.delete(change, pivot, axis=1)
    return np.asarray(transformation @ change)


class _Link(NamedTuple):
    """An edge between two coordinates (or the ground) of a given strength; inf is rigid."""

    strength: float
    first: int
    second: int


def _links(system: System, slices: Mapping[str, slice]) -> list[_Link]:
    """Return all joints between coordinates, strongest first."""
    links = []
    for bearing in system.bearings:
        stiffness, damping = bearing.matrices()
        if bearing.speed_law is not None:
            law = bearing.speed_law.coefficients(_AT_REST, stiffness[:2, :2], damping[:2, :2])
            stiffness, _ = bearing.matrices_with(law)
        for at, component in enumerate(MOTIONS):
            strength = np.inf if component in bearing.rigid else abs(stiffness[at, at])
            if strength == 0:
                continue
            ends = [
                int(slices[e.body].start)
                + system.rotors[e.body].element.interface_index(e.interface, component)
                for e in bearing.ends
            ]
            links.append(_Link(strength, ends[0], ends[1] if len(ends) == 2 else GROUND))
    return sorted(links, key=lambda link: -link.strength)


class _Change(NamedTuple):
    """Old coordinates from the new ones, and the strength of the joint behind each new one."""

    motion: FloatArray
    strength: FloatArray


def _tied(rows: FloatArray, constraint: FloatArray, strength: FloatArray) -> _Change:
    """Eliminate coordinates so that those of a body move as its constraint allows.

    What the constraint forbids must vanish: E rows x = 0. Coordinates that are the relative motion
    of a stiff joint are the last to be given up, so that its number stays with one coordinate.
    """
    left, values, _ = la.svd(constraint, full_matrices=True)
    rank = int(np.count_nonzero(values > _DEPENDENT * values.max(initial=0.0)))
    forbidden = left[:, rank:].T @ rows
    if not forbidden.size:
        return _Change(np.eye(rows.shape[1]), strength)
    weight = 1.0 / (1.0 + np.sqrt(strength))
    _, upper, order = la.qr(forbidden * weight, pivoting=True, mode="economic")
    diagonal = np.abs(np.diag(upper))
    count = int(np.count_nonzero(diagonal > _DEPENDENT * diagonal.max(initial=0.0)))
    given_up, kept = order[:count], np.sort(order[count:])
    change = np.zeros((rows.shape[1], kept.size))
    change[kept, np.arange(kept.size)] = 1.0
    if given_up.size and kept.size:
        solution, *_ = la.lstsq(forbidden[:, given_up], forbidden[:, kept])
        change[given_up] = -_cleaned(solution)
    return _Change(change, strength[kept])


def _product(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return a product with exact zeros where the terms of an entry cancel.

    What rounding leaves there would couple bodies that only meet in one that is held.
    """
    product = first @ second
    return np.where(np.abs(product) > _DEPENDENT * (np.abs(first) @ np.abs(second)), product, 0.0)


def _cleaned(matrix: FloatArray) -> FloatArray:
    """Return the matrix with rounding beside its largest entry set to zero."""
    limit = _DEPENDENT * np.abs(matrix).max(initial=0.0)
    return np.where(np.abs(matrix) > limit, matrix, 0.0)


def _transformation(system: System, slices: Mapping[str, slice]) -> tuple[FloatArray, FloatArray]:
    """Return the matrix from independent to body coordinates, and the strength of each.

    Each coordinate is that of its neighbour in a maximum spanning tree of the links plus, unless
    the link is rigid, a relative motion of its own, which is the independent coordinate.
    """
    total = max(at.stop for at in slices.values())
    tree = _spanning_tree(total, _links(system, slices))
    parents: dict[int, tuple[int, float]] = {}
    order = []
    # The ground comes first, so that a tree that reaches it starts there.
    for start in range(GROUND, total):
        if start in parents:
            continue
        parents[start] = (GROUND, 0.0)
        waiting = [start]
        while waiting:
            here = waiting.pop()
            order.append(here)
            for there, strength in tree[here]:
                if there not in parents:
                    parents[there] = (here, strength)
                    waiting.append(there)
    moving = [i for i in range(total) if np.isfinite(parents[i][1])]
    columns = {coordinate: column for column, coordinate in enumerate(moving)}
    strengths = np.array([parents[i][1] for i in moving])
    matrix = np.zeros((total + 1, len(moving)))
    # Row −1 is the ground and stays zero.
    for i in order[1:]:
        matrix[i] = matrix[parents[i][0]]
        if i in columns:
            matrix[i, columns[i]] = 1.0
    return matrix[:total], strengths


def _spanning_tree(total: int, links: list[_Link]) -> dict[int, list[tuple[int, float]]]:
    """Return the neighbours of each coordinate and of the ground in the strongest tree."""
    tree: dict[int, list[tuple[int, float]]] = {i: [] for i in range(GROUND, total)}
    group = np.arange(total + 1)  # the ground is the last
    for link in links:
        first, second = group[link.first], group[link.second]
        if first != second:
            group[group == second] = first
            tree[link.first].append((link.second, link.strength))
            tree[link.second].append((link.first, link.strength))
    return tree
