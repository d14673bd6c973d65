"""Measurements of a subdivision made without the code under test."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest

from solidwhirl.geometry import Subdivision


def chords_of(found: Subdivision, loop, per_arc: int = 1) -> np.ndarray:
    """Return the vertices of a loop, arcs replaced by `per_arc` chords."""
    places = []
    for number, sign in loop:
        curve = found.curves[number]
        first, last = (curve.start, curve.end)[::sign]
        places.append(found.points[first])
        if curve.centre is not None:
            centre = found.points[curve.centre]
            one, two = found.points[first] - centre, found.points[last] - centre
            sweep = math.atan2(one[0] * two[1] - one[1] * two[0], one @ two)
            for k in range(1, per_arc):
                c, s = math.cos(sweep * k / per_arc), math.sin(sweep * k / per_arc)
                places.append(centre + np.array([[c, -s], [s, c]]) @ one)
    return np.array(places)


def shoelace(places: np.ndarray) -> float:
    z, r = (places - places[0]).T
    return 0.5 * float(np.sum(z * np.roll(r, -1) - r * np.roll(z, -1)))


def area_of(found: Subdivision, loop) -> float:
    """Return the signed area of a loop: its chords plus the circular segments on its arcs."""
    area = shoelace(chords_of(found, loop))
    for number, sign in loop:
        curve = found.curves[number]
        if curve.centre is not None:
            centre = found.points[curve.centre]
            one, two = (found.points[p] - centre for p in (curve.start, curve.end)[::sign])
            sweep = math.atan2(one[0] * two[1] - one[1] * two[0], one @ two)
            area += 0.5 * float(one @ one) * (sweep - math.sin(sweep))
    return area


def loops_of(found: Subdivision) -> list[list[tuple[int, int]]]:
    """Return the closed loops of boundary and axis, with the material on the left."""
    outline = {*found.boundary, *found.axis}
    leaving = {}
    for face in found.faces:
        for number, sign in face.loop:
            if number in outline:
                start = (found.curves[number].start, found.curves[number].end)[::sign][0]
                assert start not in leaving, "outline is pinched"
                leaving[start] = (number, sign)
    loops = []
    while leaving:
        point = next(iter(leaving))
        loop = []
        while point in leaving:
            loop.append(leaving.pop(point))
            number, sign = loop[-1]
            point = (found.curves[number].start, found.curves[number].end)[::sign][1]
        loops.append(loop)
    return loops


def conforming(found: Subdivision) -> None:
    """Assert every structural promise of a subdivision."""
    uses = Counter(directed for face in found.faces for directed in face.loop)
    assert set(uses.values()) == {1}
    sides = Counter(number for number, _ in uses)
    assert set(sides) == set(range(len(found.curves)))
    once = {number for number, count in sides.items() if count == 1}
    assert max(sides.values()) <= 2
    assert once == {*found.boundary, *found.axis}
    assert not set(found.boundary) & set(found.axis)
    for number in found.axis:
        curve = found.curves[number]
        assert found.points[[curve.start, curve.end], 1].tolist() == [0.0, 0.0]
    for face in found.faces:
        ends = [(found.curves[n].start, found.curves[n].end)[::s] for n, s in face.loop]
        assert all(a[1] == b[0] for a, b in zip(ends, [*ends[1:], ends[0]], strict=True))
        assert area_of(found, face.loop) > 0.0
    loops = loops_of(found)
    areas = sorted(area_of(found, loop) for loop in loops)
    assert areas[-1] > 0.0
    assert all(area < 0.0 for area in areas[:-1])  # the others go around holes
    # Euler, with the outside and the holes as faces: V - E + F = 2 for a connected plane graph.
    vertices = {p for curve in found.curves for p in (curve.start, curve.end)}
    assert len(vertices) - len(found.curves) + len(found.faces) + len(loops) == 2
    # Round-off of a sum of products of coordinates below 1 m^2.
    total = math.fsum(area_of(found, face.loop) for face in found.faces)
    assert math.fsum(areas) == pytest.approx(total, rel=1e-12)
    assert set(found.fillet_arcs) == {n for n, c in enumerate(found.curves) if c.centre is not None}
    assert set(found.fillet_arcs) <= set(found.boundary)
