"""A planar subdivision as points, curves and faces, and the changes made to it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray

DirectedCurve = tuple[int, int]  # curve index, +1 along the curve or -1 against it


@dataclass(frozen=True, kw_only=True, slots=True)
class Curve:
    """Join two points by a straight line or a circular arc."""

    start: int
    end: int
    #: Point index of the arc's centre; the arc is the one below 180 degrees. None if straight.
    centre: int | None = None


@dataclass(frozen=True, kw_only=True, slots=True)
class Face:
    """Bound a piece of one section."""

    #: (curve index, +1 along or -1 against it), counterclockwise with z to the right and r up
    loop: tuple[DirectedCurve, ...]
    section: int  #: Index into the body's sections
    material: int  #: Index into the subdivision's materials


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class PlaneGraph:
    """Hold points, curves and faces that share whole curves."""

    points: FloatArray  #: (p, 2) Coordinates (z, r) [m], read-only
    curves: tuple[Curve, ...]
    faces: tuple[Face, ...]

    def __post_init__(self) -> None:
        self.points.setflags(write=False)

    def ends(self, directed: DirectedCurve) -> tuple[int, int]:
        """Return first and last point index of a directed curve."""
        curve = self.curves[directed[0]]
        return (curve.start, curve.end) if directed[1] > 0 else (curve.end, curve.start)

    def step(self, directed: DirectedCurve) -> FloatArray:
        """Return the vector (z, r) [m] from the first to the last point of a directed curve."""
        first, last = self.ends(directed)
        step: FloatArray = self.points[last] - self.points[first]
        return step

    def on_axis(self, curve: int) -> bool:
        """Tell whether both ends of a curve lie on the axis of rotation."""
        found = self.curves[curve]
        return bool(self.points[found.start, 1] == 0.0 and self.points[found.end, 1] == 0.0)


class PointStore:
    """Number points (z, r), giving one number to points closer than a tolerance."""

    def __init__(self, points: FloatArray, tolerance_m: float) -> None:
        self._points: list[tuple[float, float]] = []
        self._tolerance_m = tolerance_m
        # numbers of the points in the slices of the axis of twice the tolerance, by their places
        self._slices: dict[int, list[int]] = {}
        for z, r in points:
            self._append(float(z), float(r))

    def add(self, z_m: float, r_m: float) -> int:
        """Return the number of the point at (z, r) [m], a new one if there is none."""
        here = self._slice(z_m)
        near = sorted(n for k in (here - 1, here, here + 1) for n in self._slices.get(k, ()))
        for number in near:
            z, r = self._points[number]
            if abs(z - z_m) <= self._tolerance_m and abs(r - r_m) <= self._tolerance_m:
                return number
        self._append(float(z_m), float(r_m))
        return len(self._points) - 1

    def _append(self, z_m: float, r_m: float) -> None:
        self._slices.setdefault(self._slice(z_m), []).append(len(self._points))
        self._points.append((z_m, r_m))

    def _slice(self, z_m: float) -> int:
        return math.floor(z_m / (2.0 * self._tolerance_m))

    def array(self) -> FloatArray:
        """Return the coordinates (p, 2) [m]."""
        return np.array(self._points, dtype=np.float64).reshape(-1, 2)


def faces_of_curves(graph: PlaneGraph) -> tuple[tuple[int, ...], ...]:
    """Return, for every curve, the indices of the faces that have it in their loop."""
    found: list[list[int]] = [[] for _ in graph.curves]
    for number, face in enumerate(graph.faces):
        for curve, _ in face.loop:
            found[curve].append(number)
    return tuple(tuple(faces) for faces in found)


def outline_curves(graph: PlaneGraph) -> tuple[DirectedCurve, ...]:
    """Return the curves with one adjacent face (axis included), with the material on the left."""
    owners = faces_of_curves(graph)
    return tuple(
        directed for face in graph.faces for directed in face.loop if len(owners[directed[0]]) == 1
    )


def split_curves(
    graph: PlaneGraph, points: FloatArray, cuts: Mapping[int, Sequence[int]]
) -> PlaneGraph:
    """Split straight curves at given points.

    `points`: (p, 2) Its points followed by new ones, (z, r) [m]. `cuts`: curve index to the points
    on it. The order does not matter; the ends are left out. The piece at the start keeps the
    curve's index, the others get new ones.
    """
    curves = list(graph.curves)
    pieces: dict[int, list[int]] = {}
    for number, on_curve in cuts.items():
        curve = graph.curves[number]
        inner = set(on_curve) - {curve.start, curve.end}
        origin = points[curve.start]
        chain = sorted(inner, key=lambda p: float(np.hypot(*(points[p] - origin))))
        stations = [curve.start, *chain, curve.end]
        curves[number] = Curve(start=stations[0], end=stations[1])
        pieces[number] = [number]
        for first, last in pairwise(stations[1:]):
            pieces[number].append(len(curves))
            curves.append(Curve(start=first, end=last))
    faces = tuple(
        replace(face, loop=tuple(part for item in face.loop for part in _parts(item, pieces)))
        for face in graph.faces
    )
    return PlaneGraph(points=points, curves=tuple(curves), faces=faces)


def _parts(directed: DirectedCurve, pieces: Mapping[int, Sequence[int]]) -> list[DirectedCurve]:
    number, sign = directed
    parts = pieces.get(number, [number])
    return [(part, sign) for part in (parts if sign > 0 else reversed(parts))]


def compact(graph: PlaneGraph) -> PlaneGraph:
    """Drop the points that no curve uses."""
    curves, used = renumbered_points(graph.curves)
    return PlaneGraph(points=graph.points[list(used)], curves=curves, faces=graph.faces)


def renumbered_points(curves: Sequence[Curve]) -> tuple[tuple[Curve, ...], dict[int, int]]:
    """Return curves whose points are numbered without gaps, and the new number of each old one."""
    used = sorted({p for c in curves for p in (c.start, c.end, c.centre) if p is not None})
    new = {old: number for number, old in enumerate(used)}
    return tuple(
        Curve(
            start=new[c.start], end=new[c.end], centre=None if c.centre is None else new[c.centre]
        )
        for c in curves
    ), new
