"""Mass of a beam model that bends with no cross-section of its own: it rides on another.

No axial stress reaches a ring behind a step: it moves with the nearest cross-section whose stiff
part reaches its radius, as a rigid piece. Fillets have mass and no stiffness.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from solidwhirl.beams.nodes import Layout
from solidwhirl.beams.profile import Column, Skeleton
from solidwhirl.beams.sections import StiffRadii, section_inertia
from solidwhirl.geometry import Body
from solidwhirl.geometry.mass_properties import fillet_mass_properties
from solidwhirl.geometry.meridian.fillets import Fillet
from solidwhirl.geometry.meridian.subdivision import planned_fillets
from solidwhirl.rotordyn.beams.elements import Segment
from solidwhirl.rotordyn.beams.families import Attached
from solidwhirl.rotordyn.core.arrays import FloatArray

# Rings that the shadow at one place is divided into.
_RINGS = 4
# A shadow thinner than this fraction of the radius is rounding.
_THIN = 1e-9


class CarriedRing(NamedTuple):
    """A ring at z, fixed to the cross-section of an element at another place."""

    mass_kg: float
    second_kg_m2: float
    z_m: float
    element: int
    carrier_m: float

    @property
    def arm_m(self) -> float:
        """From the cross-section that carries it to the ring, m."""
        return self.z_m - self.carrier_m

    def xi(self, piece: Segment) -> FloatArray:
        """Return the place of that cross-section in its element, 0 to 1, shape (1,)."""
        return np.array([(self.carrier_m - piece.start_m) / piece.length_m])


def carried_rings(
    layout: Layout, radii: tuple[StiffRadii, ...], pieces: tuple[Segment, ...]
) -> tuple[CarriedRing, ...]:
    """Return what lies outside the stiff part of the columns, ring by ring.

    `pieces`: cross-sections of the elements, which hold the inertia of the stiff part alone.
    """
    found = []
    for element, piece in zip(layout.elements, pieces, strict=True):
        column, stiff = layout.skeleton.columns[element.column], radii[element.column]
        at_places = zip(piece.places_m, piece.weights_m, stiff.at(piece.places_m), strict=True)
        for z, weight, (low, high) in at_places:
            for start, stop in ((column.inner_m(z), low), (high, column.outer_m(z))):
                if stop - start <= _THIN * column.outer_m(z):
                    continue
                edges = np.linspace(start, stop, _RINGS + 1)
                for inner, outer in pairwise(edges):
                    ring = section_inertia(column, z, inner, outer)
                    at = _carrier(layout, radii, element.column, z, 0.5 * (inner + outer))
                    inertia = weight * ring.mass, weight * ring.second
                    found.append(CarriedRing(*inertia, z, *_located(layout, *at)))
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


def fillet_rings(body: Body, layout: Layout) -> tuple[Attached, ...]:
    """Return the fillets of a body, each fixed to the nearest node of its column.

    A fillet that touches no column goes to the one that carries its plate. Together they have the
    mass properties of all fillets.
    """
    found = []
    for fillet in planned_fillets(body) if body.fillet_radius_m else ():
        material = body.sections[fillet.section].material
        own = fillet_mass_properties(fillet, material.density_kg_per_m3)
        z = float(own.center_of_gravity_m[2])
        column = _column(layout.skeleton, fillet)
        nodes = sorted({n for e in layout.elements if e.column == column for n in e.nodes})
        node = min(nodes, key=lambda n: abs(float(layout.nodes_m[n]) - z))
        found.append(
            Attached(node, z, own.mass_kg, own.polar_inertia_kg_m2, own.diametral_inertia_kg_m2)
        )
    return tuple(found)


def _column(skeleton: Skeleton, fillet: Fillet) -> int:
    z, r = (float(value) for value in fillet.vertex_m)
    slack = 1e3 * skeleton.tolerance_m
    for k, column in enumerate(skeleton.columns):
        if column.start_m - slack <= z <= column.end_m + slack:
            inside = min(max(z, column.start_m), column.end_m)
            if column.inner_m(inside) - slack <= r <= column.outer_m(inside) + slack:
                return k
    for plate in skeleton.plates:
        for cell in plate.cells:
            beside = cell.start_m - slack <= z <= cell.end_m + slack
            place = plate.inner or plate.outer
            if beside and cell.inner_m - slack <= r <= cell.outer_m + slack and place:
                return place.column
    raise AssertionError(f"fillet at {fillet.place} lies on no part of the body")
