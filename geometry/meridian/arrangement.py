"""Sections cut into panels and joined to a conforming planar subdivision.

All panels are trapezoids with radial sides, so no general polygon clipping is needed: once the
sections are known not to overlap, splitting every edge at the vertices lying on it is exact.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from solidwhirl.geometry.errors import GeometryError
from solidwhirl.geometry.materials import Material
from solidwhirl.geometry.meridian.plane_graph import (
    Curve,
    DirectedCurve,
    Face,
    PlaneGraph,
    PointStore,
    compact,
)
from solidwhirl.geometry.profile import Body, Interface, Section
from solidwhirl.rotordyn.core.arrays import FloatArray


def materials_of(body: Body) -> tuple[Material, ...]:
    """Return the different materials of a body in the order of their first use."""
    return tuple(dict.fromkeys(section.material for section in body.sections))


def arrange(body: Body, tolerance_m: float) -> PlaneGraph:
    """Return the conforming subdivision of sections that do not overlap.

    `body`: body with snapped coordinates whose sections do not overlap. `tolerance_m`: distance [m]
    up to which a vertex counts as lying on an edge. Result: one face per section, or several
    where interfaces cut it. Raises GeometryError if a vertex lies in a tip so sharp that it cannot
    be told from both of the tip's edges.
    """
    planes = [(z, item) for item in body.interfaces for z in item.planes_m]
    panels = [
        (number, panel)
        for number, section in enumerate(body.sections)
        for panel in _panels(section, planes, tolerance_m)
    ]
    store = PointStore(np.empty((0, 2)), tolerance_m)
    polygons = [_polygon(panel, store) for _, panel in panels]
    for z, r in _radial_bounds([panel for _, panel in panels], planes):
        store.add(z, r)
    points = store.array()
    materials = materials_of(body)
    curves: dict[tuple[int, int], int] = {}
    faces = []
    for (number, panel), polygon in zip(panels, polygons, strict=True):
        loop = _loop(_with_vertices_on_edges(polygon, points, tolerance_m), curves)
        faces.append(Face(loop=loop, section=number, material=materials.index(panel.material)))
    graph = PlaneGraph(
        points=points,
        curves=tuple(Curve(start=start, end=end) for start, end in curves),
        faces=tuple(faces),
    )
    _refuse_folds(graph, body)
    return compact(graph)


def _panels(
    section: Section, planes: Iterable[tuple[float, Interface]], tolerance_m: float
) -> tuple[Section, ...]:
    """Cut a section at the planes of the interfaces that meet material of it."""
    cuts = sorted(
        {
            z
            for z, interface in planes
            if section.start_m < z < section.end_m
            and _meets(section.radii_at(z), interface, tolerance_m)
        }
    )
    stations = [section.start_m, *cuts, section.end_m]
    radii = [section.radii_at(z) for z in stations]
    return tuple(
        replace(
            section,
            start_m=stations[k],
            end_m=stations[k + 1],
            inner_radius_m=(radii[k][0], radii[k + 1][0]),
            outer_radius_m=(radii[k][1], radii[k + 1][1]),
        )
        for k in range(len(stations) - 1)
    )


def _meets(radii: tuple[float, float], interface: Interface, tolerance_m: float) -> bool:
    lower, upper = interface.radius_m or (0.0, np.inf)
    return min(radii[1], upper) - max(radii[0], lower) > tolerance_m


def _polygon(panel: Section, store: PointStore) -> list[int]:
    """Return the panel's corners counterclockwise, three of them for a triangle."""
    (inner_0, inner_1), (outer_0, outer_1) = panel.inner_radius_m, panel.outer_radius_m
    corners = [
        store.add(panel.start_m, inner_0),
        store.add(panel.end_m, inner_1),
        store.add(panel.end_m, outer_1),
        store.add(panel.start_m, outer_0),
    ]
    return list(dict.fromkeys(corners))


def _radial_bounds(
    panels: Iterable[Section], planes: Sequence[tuple[float, Interface]]
) -> list[tuple[float, float]]:
    """Return the places (z, r) where a radial limit of an interface cuts a panel's radial side."""
    found = []
    for panel in panels:
        for place, interface in planes:
            for side, z in enumerate((panel.start_m, panel.end_m)):
                inner, outer = panel.inner_radius_m[side], panel.outer_radius_m[side]
                if place == z:
                    found += [(z, r) for r in interface.radius_m or () if inner < r < outer]
    return found


def _with_vertices_on_edges(
    polygon: Sequence[int], points: FloatArray, tolerance_m: float
) -> list[int]:
    chain = []
    for first, last in zip(polygon, [*polygon[1:], polygon[0]], strict=True):
        chain += [first, *_vertices_on(first, last, points, tolerance_m)]
    return chain


def _vertices_on(first: int, last: int, points: FloatArray, tolerance_m: float) -> list[int]:
    """Return the points strictly inside a straight edge, from its first to its last point."""
    edge = points[last] - points[first]
    length = float(np.hypot(*edge))
    relative = points - points[first]
    along = relative @ edge / length
    across = np.abs(relative[:, 1] * edge[0] - relative[:, 0] * edge[1]) / length
    inside = (across <= tolerance_m) & (along > 0.0) & (along < length)
    inside[[first, last]] = False
    candidates = np.flatnonzero(inside)
    return [int(point) for point in candidates[np.argsort(along[candidates])]]


def _loop(chain: Sequence[int], curves: dict[tuple[int, int], int]) -> tuple[DirectedCurve, ...]:
    """Return a closed chain of points as directed curves, numbering the new ones."""
    loop = []
    for first, last in zip(chain, [*chain[1:], chain[0]], strict=True):
        if (last, first) in curves:
            loop.append((curves[last, first], -1))
        else:
            loop.append((curves.setdefault((first, last), len(curves)), 1))
    return tuple(loop)


def _refuse_folds(graph: PlaneGraph, body: Body) -> None:
    """Refuse two faces, or one twice, on the same side of a curve.

    Sections do not overlap, so it comes from a vertex in a tip so sharp that it counts as lying on
    both of the tip's edges.
    """
    owner: dict[DirectedCurve, int] = {}
    for face in graph.faces:
        for directed in face.loop:
            other = owner.setdefault(directed, face.section)
            if other != face.section or face.loop.count(directed) > 1:
                names = dict.fromkeys(body.sections[s].name for s in (other, face.section))
                listed = " and ".join(f"'{name}'" for name in names)
                z, r = graph.points[graph.ends(directed)[0]]
                raise GeometryError(
                    f"body '{body.name}': section {listed}: two "
                    f"edges fall into one at z = {z:.9g} m, r = {r:.9g} m; keep other vertices "
                    "away from the tip of a thin wedge"
                )
