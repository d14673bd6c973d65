"""Planned fillets put into a subdivision as faces."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence

import numpy as np

from solidwhirl.geometry.fillets import Fillet
from solidwhirl.geometry.outline import outline_of
from solidwhirl.geometry.plane_graph import (
    Curve,
    DirectedCurve,
    Face,
    FloatArray,
    PlaneGraph,
    PointStore,
    split_curves,
)


def add_fillet_faces(
    graph: PlaneGraph,
    fillets: Sequence[Fillet],
    material_of_section: Sequence[int],
    tolerance_m: float,
) -> tuple[PlaneGraph, tuple[int, ...]]:
    """Return the subdivision with one more face per fillet, and the curve indices of the arcs.

    Parameters
    ----------
    graph : PlaneGraph
        Subdivision with a straight outline.
    fillets : sequence of Fillet
        Fillets known to fit.
    material_of_section : sequence of int
        Material index of every section.
    tolerance_m : float
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
