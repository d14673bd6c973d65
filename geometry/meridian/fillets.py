"""Circular fillets at the re-entrant corners of an outline: where they go, whether they fit."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from solidwhirl.geometry.errors import GeometryError
from solidwhirl.geometry.meridian.outline import (
    Corner,
    Outline,
    StraightRun,
    outline_of,
    straight_run,
)
from solidwhirl.geometry.meridian.plane_graph import (
    Curve,
    DirectedCurve,
    Face,
    PlaneGraph,
    PointStore,
    faces_of_curves,
    split_curves,
)
from solidwhirl.geometry.meridian.snapping import Scale
from solidwhirl.geometry.profile import Body, Interface
from solidwhirl.rotordyn.core.arrays import FloatArray


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Fillet:
    """Hold one planned fillet: an arc tangent to the two straight runs at a re-entrant corner."""

    corner: int  #: Point index of the corner
    vertex_m: FloatArray  #: (2,) The corner (z, r) [m]
    #: Section whose material fills the fillet: the one listed first of the two at the corner
    section: int
    radius_m: float
    tangent_length_m: float  #: Distance [m] from the corner to both tangent points
    centre_m: FloatArray  #: (2,) Centre of the arc (z, r) [m]
    #: Outline from the corner against, and along, the outline's direction
    before: StraightRun
    after: StraightRun

    @property
    def tangent_points_m(self) -> FloatArray:
        """Tangent points (2, 2) [m]: first on `before`, then on `after`; rows (z, r)."""
        directions = np.array([self.before.direction, self.after.direction])
        points: FloatArray = self.vertex_m + self.tangent_length_m * directions
        return points

    @property
    def place(self) -> str:
        """Where the corner is, for messages."""
        return f"z = {self.vertex_m[0]:.9g} m, r = {self.vertex_m[1]:.9g} m"


def plan_fillets(
    graph: PlaneGraph, outline: Outline, corners: Iterable[Corner], body: Body, scale: Scale
) -> tuple[Fillet, ...]:
    """Return the fillets of a body, each known to fit on its edges and beside the others.

    Corners so flat that the tangent length falls below `Scale.detail_m` get none.

    `graph`: subdivision with a straight outline. `body`: body with snapped coordinates; its
    `fillet_radius_m` may be 0. Raises GeometryError if the radius is too small to resolve, a
    tangent length does not fit on its edge, or a fillet runs into another part of the body.
    """
    if body.fillet_radius_m == 0.0:
        return ()
    if body.fillet_radius_m < scale.detail_m:
        raise GeometryError(
            f"body '{body.name}': fillet radius {body.fillet_radius_m:.3g} m is below the smallest "
            f"length allowed, {scale.detail_m:.3g} m; use 0 for sharp corners"
        )
    planned = [
        _fillet(graph, outline, corner, body.fillet_radius_m, scale.tolerance_m)
        for corner in corners
    ]
    fillets = tuple(item for item in planned if item.tangent_length_m > scale.detail_m)
    _refuse_unfitting(fillets, scale.tolerance_m)
    _refuse_collisions(graph, outline, fillets, body, scale)
    return fillets


def _fillet(
    graph: PlaneGraph, outline: Outline, corner: Corner, radius_m: float, tolerance_m: float
) -> Fillet:
    before = straight_run(graph, outline.arriving, corner.point, tolerance_m)
    after = straight_run(graph, outline.leaving, corner.point, tolerance_m)
    vertex = graph.points[corner.point]
    # The empty wedge has the opening angle 2 pi - interior angle, below pi.
    (z_1, r_1), (z_2, r_2) = before.direction, after.direction
    half = 0.5 * math.atan2(abs(z_1 * r_2 - r_1 * z_2), z_1 * z_2 + r_1 * r_2)
    middle = before.direction + after.direction
    owners = faces_of_curves(graph)
    sections = [graph.faces[owners[run.curves[0]][0]].section for run in (before, after)]
    return Fillet(
        corner=corner.point,
        vertex_m=vertex,
        section=min(sections),
        radius_m=radius_m,
        tangent_length_m=radius_m / math.tan(half),
        centre_m=vertex + radius_m / math.sin(half) * middle / float(np.hypot(*middle)),
        before=before,
        after=after,
    )


def _refuse_unfitting(fillets: Sequence[Fillet], tolerance_m: float) -> None:
    """Refuse a fillet longer than its straight edge, less a neighbour's share of the same edge."""
    by_corner = {fillet.corner: fillet for fillet in fillets}
    for fillet in fillets:
        for run in (fillet.before, fillet.after):
            neighbour = by_corner.get(run.stations[-1])
            taken = 0.0 if neighbour is None else neighbour.tangent_length_m
            if fillet.tangent_length_m + taken <= run.length_m + tolerance_m:
                continue
            shared = f" less {taken:.6g} m of the neighbouring fillet" if taken > 0.0 else ""
            raise GeometryError(
                f"fillet of radius {fillet.radius_m:.6g} m at {fillet.place} does not fit: it "
                f"needs {fillet.tangent_length_m:.6g} m of the adjacent straight edge, available "
                f"are {run.length_m:.6g} m{shared}"
            )


def _refuse_collisions(
    graph: PlaneGraph, outline: Outline, fillets: Sequence[Fillet], body: Body, scale: Scale
) -> None:
    """Refuse fillets that would cover another edge of the outline.

    Two fillets cannot overlap then: what they share would be bounded by their arcs alone and lie
    outside both circles, and two circles leave no such bounded region.
    """
    owners = faces_of_curves(graph)
    for fillet in fillets:
        own = {*fillet.before.curves, *fillet.after.curves}
        for number, _ in outline.leaving.values():
            if number not in own and _reaches_into(graph, number, fillet, scale):
                name = body.sections[graph.faces[owners[number][0]].section].name
                raise GeometryError(
                    f"fillet of radius {fillet.radius_m:.6g} m at {fillet.place} does not fit: it "
                    f"runs into section '{name}'"
                )


def _reaches_into(graph: PlaneGraph, number: int, fillet: Fillet, scale: Scale) -> bool:
    """Tell whether a straight curve enters a fillet: its triangle, outside the arc's circle."""
    ends = graph.points[[graph.curves[number].start, graph.curves[number].end]]
    apart = np.abs(ends[0] + ends[1] - 2.0 * fillet.vertex_m) - np.abs(ends[1] - ends[0])
    if np.any(apart > 2.0 * fillet.tangent_length_m):  # bounding boxes do not touch
        return False
    triangle = np.array([fillet.vertex_m, *fillet.tangent_points_m])
    inside = _clipped(ends, triangle)
    if inside is None:
        return False
    distance = np.hypot(*(inside - fillet.centre_m).T)
    # A curve that goes on from a tangent point touches the arc there and nowhere else.
    touching = np.hypot(*(inside[:, None, :] - fillet.tangent_points_m).T).min(axis=0)
    allowed = np.where(
        touching <= 2.0 * scale.tolerance_m,
        fillet.radius_m + 2.0 * scale.tolerance_m,
        fillet.radius_m - scale.detail_m,
    )
    return bool(np.any(distance > allowed))


def _clipped(ends: FloatArray, triangle: FloatArray) -> FloatArray | None:
    """Return the end points (2, 2) of a segment's part inside a triangle, None if outside."""
    low, high = 0.0, 1.0
    middle = triangle.mean(axis=0)
    step = ends[1] - ends[0]
    for first, last in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
        normal = np.array([first[1] - last[1], last[0] - first[0]])
        normal *= np.sign(float(normal @ (middle - first)))
        height, slope = float(normal @ (ends[0] - first)), float(normal @ step)
        if slope == 0.0:
            if height < 0.0:
                return None
        elif slope > 0.0:
            low = max(low, -height / slope)
        else:
            high = min(high, -height / slope)
    return None if low > high else np.array([ends[0] + low * step, ends[0] + high * step])


def refuse_swallowed_interfaces(
    graph: PlaneGraph,
    fillets: Iterable[Fillet],
    interfaces: Iterable[Interface],
    curves: Mapping[str, Sequence[int]],
    tolerance_m: float,
) -> None:
    """Refuse fillets that cover a curve of an interface or widen its cross-section.

    `tolerance_m`: length [m] of overlap that does not count. Raises GeometryError naming the
    interface and the fillet's place.
    """
    for fillet in fillets:
        covered = _covered_curves(graph, fillet, tolerance_m)
        for interface in interfaces:
            if covered.intersection(curves[interface.name]):
                raise GeometryError(
                    f"fillet of radius {fillet.radius_m:.6g} m at {fillet.place} covers a part of "
                    f"the interface '{interface.name}'; move the interface at least "
                    f"{fillet.tangent_length_m:.6g} m away from the corner"
                )
            for z in interface.planes_m:
                if _widens(fillet, z, interface.radius_m, tolerance_m):
                    raise GeometryError(
                        f"fillet of radius {fillet.radius_m:.6g} m at {fillet.place} widens the "
                        f"cross-section of the interface '{interface.name}' at "
                        f"z = {z:.9g} m; limit its radius_m or move it"
                    )


def _covered_curves(graph: PlaneGraph, fillet: Fillet, tolerance_m: float) -> set[int]:
    """Return the outline curves that a fillet covers, wholly or in part."""
    covered = set()
    for run in (fillet.before, fillet.after):
        for curve, near in zip(run.curves, run.stations[:-1], strict=True):
            distance = float(np.hypot(*(graph.points[near] - fillet.vertex_m)))
            if distance < fillet.tangent_length_m - tolerance_m:
                covered.add(curve)
    return covered


def _widens(
    fillet: Fillet, z: float, radius_m: tuple[float, float] | None, tolerance_m: float
) -> bool:
    """Tell whether the plane z of an interface passes through a fillet's triangle."""
    triangle = np.array([fillet.vertex_m, *fillet.tangent_points_m])
    if not triangle[:, 0].min() + tolerance_m < z < triangle[:, 0].max() - tolerance_m:
        return False
    line = np.array([[z, triangle[:, 1].min()], [z, triangle[:, 1].max()]])
    inside = _clipped(line, triangle)
    if inside is None:
        return False
    lower, upper = radius_m or (0.0, np.inf)
    return bool(min(inside[:, 1].max(), upper) - max(inside[:, 1].min(), lower) > tolerance_m)


def add_fillet_faces(
    graph: PlaneGraph,
    fillets: Sequence[Fillet],
    material_of_section: Sequence[int],
    tolerance_m: float,
) -> tuple[PlaneGraph, tuple[int, ...]]:
    """Return the subdivision with one more face per fillet, and the curve indices of the arcs.

    Parameters
    ----------
    graph
        Subdivision with a straight outline.
    material_of_section
        Material index of every section.
    tolerance_m
        Distance [m] below which a tangent point falls on an existing vertex.

    Returns
    -------
    PlaneGraph
        The faces and curves of `graph` keep their indices (a split curve: its first piece).
    tuple of int
        Index of every fillet's arc, in the order of `fillets`.
    """
    if not fillets:
        return graph, ()
    graph, tangents = _with_tangent_points(graph, fillets, tolerance_m)
    outline = outline_of(graph)
    centres = np.array([fillet.centre_m for fillet in fillets])
    curves, faces = list(graph.curves), list(graph.faces)
    arcs = []
    for number, (fillet, (first, last)) in enumerate(zip(fillets, tangents, strict=True)):
        # The fillet lies on the right of the outline, so its loop runs against it.
        back = [
            *reversed(_walk(graph, outline.leaving, fillet.corner, last)),
            *_walk(graph, outline.arriving, fillet.corner, first),
        ]
        arcs.append(len(curves))
        curves.append(Curve(start=first, end=last, centre=len(graph.points) + number))
        faces.append(
            Face(
                loop=(*((curve, -sign) for curve, sign in back), (arcs[-1], 1)),
                section=fillet.section,
                material=material_of_section[fillet.section],
            )
        )
    points = np.vstack([graph.points, centres])
    return PlaneGraph(points=points, curves=tuple(curves), faces=tuple(faces)), tuple(arcs)


def _with_tangent_points(
    graph: PlaneGraph, fillets: Sequence[Fillet], tolerance_m: float
) -> tuple[PlaneGraph, list[tuple[int, int]]]:
    """Return the graph split at the tangent points, and their numbers, two per fillet."""
    store = PointStore(graph.points, tolerance_m)
    cuts: defaultdict[int, list[int]] = defaultdict(list)
    tangents = []
    for fillet in fillets:
        pair = []
        for run, (z, r) in zip((fillet.before, fillet.after), fillet.tangent_points_m, strict=True):
            pair.append(store.add(z, r))
            ahead = _distances(graph.points, run.stations)
            # The curve whose far end is the first at or beyond the tangent point.
            reached = np.flatnonzero(ahead[1:] >= fillet.tangent_length_m - tolerance_m)
            cuts[run.curves[reached[0] if len(reached) else -1]].append(pair[-1])
        tangents.append((pair[0], pair[1]))
    return split_curves(graph, store.array(), cuts), tangents


def _distances(points: FloatArray, stations: Sequence[int]) -> FloatArray:
    relative = points[list(stations)] - points[stations[0]]
    distances: FloatArray = np.hypot(relative[:, 0], relative[:, 1])
    return distances


def _walk(
    graph: PlaneGraph, step: Mapping[int, DirectedCurve], start: int, stop: int
) -> list[DirectedCurve]:
    """Return the directed outline curves between two vertices, in the order of walking."""
    walked = []
    point = start
    while point != stop:
        directed = step[point]
        walked.append(directed)
        first, last = graph.ends(directed)
        point = last if first == point else first
    return walked
