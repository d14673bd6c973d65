"""Material in the shadow of a step: no axial stress reaches it, so it rides on the stiff core.

A ring behind a step is too far out to bend with the cross-section it lies in. It moves with the
nearest one whose stiff part reaches its radius, as a rigid piece.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from solidwhirl.beam_level_elements import Stretch
from solidwhirl.beam_level_nodes import Layout
from solidwhirl.beam_level_profile import Column
from solidwhirl.beam_level_sections import StiffRadii, section_inertia

# Rings that the shadow at one place is divided into.
_RINGS = 4
# A shadow thinner than this fraction of the radius is rounding.
_THIN = 1e-9


class Rider(NamedTuple):
    """A ring at z, fixed to the cross-section of an element at another place."""

    mass_kg: float
    second_kg_m2: float
    z_m: float
    element: int
    carrier_m: float


def riders(
    layout: Layout, radii: tuple[StiffRadii, ...], pieces: tuple[Stretch, ...]
) -> tuple[Rider, ...]:
    """Return what lies outside the stiff part of the columns, ring by ring.

    Parameters
    ----------
    layout
        Columns and elements.
    radii
        Stiff part of every column.
    pieces
        Cross-sections of the elements, which hold the inertia of the stiff part alone.

    Returns
    -------
    tuple of Rider
    """
    found = []
    for element, piece in zip(layout.elements, pieces, strict=True):
        column, stiff = layout.skeleton.columns[element.column], radii[element.column]
        for z, weight in zip(piece.places_m, piece.weights_m, strict=True):
            low, high = stiff.at(z)
            for start, stop in ((column.inner_m(z), low), (high, column.outer_m(z))):
                if stop - start <= _THIN * column.outer_m(z):
                    continue
                edges = np.linspace(start, stop, _RINGS + 1)
                for inner, outer in pairwise(edges):
                    ring = section_inertia(column, z, inner, outer)
                    at = _carrier(layout, radii, element.column, z, 0.5 * (inner + outer))
                    found.append(
                        Rider(weight * ring.mass, weight * ring.second, z, *_located(layout, *at))
                    )
    return tuple(found)


def _carrier(
    layout: Layout, radii: tuple[StiffRadii, ...], column: int, z: float, r: float
) -> tuple[int, float]:
    """Return the nearest column and place whose stiff part reaches a radius, or comes nearest."""
    ways = [_walk(layout, radii, column, z, r, step) for step in (1, -1)]
    return min(ways, key=lambda way: (way[0], abs(way[2] - z)))[1:]


def _walk(
    layout: Layout, radii: tuple[StiffRadii, ...], column: int, z: float, r: float, step: int
) -> tuple[float, int, float]:
    """Walk through the material at a radius; return what is missing there, column and place."""
    columns = layout.skeleton.columns
    best = (np.inf, column, z)
    current: int | None = column
    while current is not None:
        stiff = radii[current]
        for k in range(stiff.z_m.size)[::step]:
            place = float(stiff.z_m[k])
            if step * (place - z) < 0.0:
                continue
            missing = max(float(stiff.inner_m[k]) - r, r - float(stiff.outer_m[k]), 0.0)
            if missing < best[0]:
                best = (missing, current, place)
            if missing == 0.0:
                return best
        current = _next(layout, columns, current, r, step)
    return best


def _next(
    layout: Layout, columns: tuple[Column, ...], current: int, r: float, step: int
) -> int | None:
    plane = columns[current].end_m if step > 0 else columns[current].start_m
    for left, right in layout.skeleton.contacts:
        here, there = (left, right) if step > 0 else (right, left)
        if here == current and columns[there].inner_m(plane) < r < columns[there].outer_m(plane):
            return there
    return None


def _located(layout: Layout, column: int, z: float) -> tuple[int, float]:
    """Return the element of a column that holds a place, and the place."""
    for index, element in enumerate(layout.elements):
        if element.column == column and element.ends_m[0] <= z <= element.ends_m[1]:
            return index, z
    own = [k for k, e in enumerate(layout.elements) if e.column == column]
    nearest = min(own, key=lambda k: min(abs(end - z) for end in layout.elements[k].ends_m))
    start, end = layout.elements[nearest].ends_m
    return nearest, min(max(z, start), end)
