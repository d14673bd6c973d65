"""Refusals of sections that do not fit together: overlaps, pinched outlines, loose pieces."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import combinations, pairwise

import numpy as np

from solidwhirl.geometry.errors import GeometryError
from solidwhirl.geometry.meridian.plane_graph import PlaneGraph, faces_of_curves, outline_curves
from solidwhirl.geometry.profile import Body, Section
from solidwhirl.rotordyn.core.arrays import FloatArray, together


def refuse_overlaps(body: Body, tolerance_m: float) -> None:
    """Refuse two sections that share material.

    `tolerance_m`: radial depth [m] up to which sections count as touching. Raises GeometryError
    naming the two sections, the shared meridian area and the place where it is deepest.
    """
    for first, second in combinations(body.sections, 2):
        if first.start_m >= second.end_m or second.start_m >= first.end_m:
            continue
        stations, depths = _common_thickness(first, second)
        if not stations or max(depths) <= tolerance_m:
            continue
        area = sum(
            0.5 * (z1 - z0) * (d0 + d1)
            for z0, z1, d0, d1 in zip(
                stations[:-1], stations[1:], depths[:-1], depths[1:], strict=True
            )
        )
        deepest = int(np.argmax(depths))
        z = stations[deepest]
        r = max(first.radii_at(z)[0], second.radii_at(z)[0]) + 0.5 * depths[deepest]
        raise GeometryError(
            f"body '{body.name}': sections '{first.name}' and '{second.name}' overlap by "
            f"{area:.3g} m^2 of the meridian, deepest at z = {z:.9g} m, r = {r:.9g} m; sections "
            "may touch but not share material"
        )


def _common_thickness(first: Section, second: Section) -> tuple[list[float], list[float]]:
    """Return stations [m] over the common axial range and max(0, common thickness) [m] there.

    min(outer) - max(inner) is linear between the crossings of the outer and of the inner radii;
    the zeros in between are stations too, so its positive part is linear between all stations.
    """
    start, end = max(first.start_m, second.start_m), min(first.end_m, second.end_m)
    if end <= start:
        return [], []
    radii = [np.array([s.radii_at(start), s.radii_at(end)]) for s in (first, second)]
    (outer_0, outer_1), (inner_0, inner_1) = (radii[0] - radii[1]).T[::-1]
    shares = {0.0, 1.0, *_zero(outer_0, outer_1), *_zero(inner_0, inner_1)}

    def thickness(share: float) -> float:
        (in_a, out_a), (in_b, out_b) = ((1.0 - share) * r[0] + share * r[1] for r in radii)
        return float(min(out_a, out_b) - max(in_a, in_b))

    knots = sorted(shares)
    for low, high in pairwise(knots):
        shares |= {low + t * (high - low) for t in _zero(thickness(low), thickness(high))}
    knots = sorted(shares)
    return (
        [min(end, start + share * (end - start)) for share in knots],
        [max(0.0, thickness(share)) for share in knots],
    )


def _zero(at_0: float, at_1: float) -> tuple[float, ...]:
    """Return where a linear function on [0, 1] changes its sign, if it does."""
    return (float(at_0 / (at_0 - at_1)),) if at_0 * at_1 < 0.0 else ()


def refuse_pinches(body: Body, graph: PlaneGraph) -> None:
    """Refuse an outline that touches itself, or the axis, in a single point.

    Raises GeometryError naming the sections that meet there and the point.
    """
    outline = [curve for curve, _ in outline_curves(graph)]
    axis: Counter[int] = Counter()
    total: Counter[int] = Counter()
    for curve in outline:
        ends = (graph.curves[curve].start, graph.curves[curve].end)
        total.update(ends)
        if graph.on_axis(curve):
            axis.update(ends)
    for point, count in sorted(total.items()):
        z, r = graph.points[point]
        if count <= 2 and (r != 0.0 or axis[point]):
            continue
        names = _quoted(_sections_at(point, body, graph))
        place = f"z = {z:.9g} m, r = {r:.9g} m"
        if count > 2:
            raise GeometryError(
                f"body '{body.name}': sections {names} touch only in a point at {place}; the "
                "outline is pinched there, give them an edge of positive length in common"
            )
        raise GeometryError(
            f"body '{body.name}': sections {names} touch the axis only in a point at {place}; "
            "the outline is pinched there"
        )


def _sections_at(point: int, body: Body, graph: PlaneGraph) -> list[str]:
    found = {
        face.section
        for face in graph.faces
        for directed in face.loop
        if point in graph.ends(directed)
    }
    return [body.sections[number].name for number in sorted(found)]


def _quoted(names: Iterable[str]) -> str:
    return ", ".join(f"'{name}'" for name in names)


def refuse_pieces(body: Body, graph: PlaneGraph) -> None:
    """Refuse a body whose sections are not all bonded through edges of positive length.

    Raises GeometryError naming the groups of sections, and the narrowest gap between two of them.
    """
    groups = _bonded_groups(len(body.sections), graph)
    if len(groups) == 1:
        return
    listed = " and ".join(
        f"({_quoted(body.sections[number].name for number in group)})" for group in groups
    )
    width, place, first, second = min(
        (
            (*_separation(body.sections[a], body.sections[b]), a, b)
            for one, other in combinations(groups, 2)
            for a in one
            for b in other
        ),
        key=lambda found: found[0],
    )
    raise GeometryError(
        f"body '{body.name}' is in {len(groups)} pieces: {listed}; gap between "
        f"'{body.sections[first].name}' and '{body.sections[second].name}' at "
        f"z = {place[0]:.9g} m, r = {place[1]:.9g} m ({width:.3g} m wide)"
    )


def _bonded_groups(count: int, graph: PlaneGraph) -> list[list[int]]:
    """Return groups of section indices connected through shared curves, in order."""
    shared = np.eye(count, dtype=bool)
    for faces in faces_of_curves(graph):
        sections = [graph.faces[number].section for number in faces]
        shared[np.ix_(sections, sections)] = True
    return [group.tolist() for group in together(shared)]


def _separation(first: Section, second: Section) -> tuple[float, tuple[float, float]]:
    """Return the distance [m] of two separate sections and the place (z, r) [m] on the first."""
    best = (np.inf, (0.0, 0.0))
    for points, corners, on_first in (
        (_corners(first), _corners(second), True),
        (_corners(second), _corners(first), False),
    ):
        for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            near = _nearest_on_segment(points, start, end)
            distance = np.hypot(*(points - near).T)
            k = int(np.argmin(distance))
            if distance[k] < best[0]:
                z, r = points[k] if on_first else near[k]
                best = (float(distance[k]), (float(z), float(r)))
    return best


def _corners(section: Section) -> FloatArray:
    (inner_0, inner_1), (outer_0, outer_1) = section.inner_radius_m, section.outer_radius_m
    start, end = section.start_m, section.end_m
    return np.array([(start, inner_0), (end, inner_1), (end, outer_1), (start, outer_0)])


def _nearest_on_segment(points: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Return, for every point (p, 2), the nearest point of a segment (may have no length)."""
    edge = end - start
    square = float(edge @ edge)
    share = np.zeros(len(points)) if square == 0.0 else (points - start) @ edge / square
    nearest: FloatArray = start + np.clip(share, 0.0, 1.0)[:, None] * edge
    return nearest


def refuse_tiny_details(body: Body, graph: PlaneGraph, detail_m: float) -> None:
    """Refuse vertices nearly on a curve or on each other: slips that no mesh can resolve.

    `graph`: subdivision; arcs count with their end points only. `detail_m`: shortest distance [m]
    allowed between a vertex and a curve it does not belong to. Raises GeometryError naming the
    sections, the place and the distance.
    """
    used = np.unique([(curve.start, curve.end) for curve in graph.curves])
    used = used[np.argsort(graph.points[used, 0])]
    places = graph.points[used, 0]
    for number, curve in enumerate(graph.curves):
        if curve.centre is not None:
            continue
        start, end = graph.points[curve.start], graph.points[curve.end]
        low, high = np.searchsorted(
            places, (min(start[0], end[0]) - detail_m, max(start[0], end[0]) + detail_m)
        )
        others = used[low:high]
        others = others[(others != curve.start) & (others != curve.end)]
        near = _nearest_on_segment(graph.points[others], start, end)
        distance = np.hypot(*(graph.points[others] - near).T)
        length = float(np.hypot(*(end - start)))
        if min(length, distance.min(initial=np.inf)) >= detail_m:
            continue
        point = curve.start if length < detail_m else int(others[np.argmin(distance)])
        raise GeometryError(
            _detail_message(
                body, graph, number, point, min(length, float(distance.min(initial=np.inf)))
            )
            + f"; the smallest length allowed is {detail_m:.3g} m"
        )


def _detail_message(
    body: Body, graph: PlaneGraph, curve: int, point: int, distance_m: float
) -> str:
    z, r = graph.points[point]
    owners: Sequence[int] = [
        face.section for face in graph.faces if any(curve == c for c, _ in face.loop)
    ]
    names = dict.fromkeys(
        [*(body.sections[number].name for number in owners), *_sections_at(point, body, graph)]
    )
    return (
        f"body '{body.name}': a gap or edge of only {distance_m:.3g} m at z = {z:.9g} m, "
        f"r = {r:.9g} m (sections {_quoted(names)})"
    )
