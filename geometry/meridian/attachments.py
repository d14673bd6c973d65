"""The curves of a subdivision that belong to each interface of the body."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping

from solidwhirl.geometry.errors import GeometryError
from solidwhirl.geometry.meridian.plane_graph import (
    DirectedCurve,
    PlaneGraph,
    PointStore,
    outline_curves,
    split_curves,
)
from solidwhirl.geometry.meridian.snapping import axial_range, radial_range
from solidwhirl.geometry.profile import Body, Interface
from solidwhirl.rotordyn.core.arrays import FloatArray


def split_at_interfaces(graph: PlaneGraph, body: Body, tolerance_m: float) -> PlaneGraph:
    """Split the outline where interfaces of kind "outer", "inner" and "face" begin and end.

    `graph`: subdivision with a straight outline. `tolerance_m`: distance [m] below which a bound
    falls on an existing vertex.
    """
    for interface in body.interfaces:
        if interface.planes_m:
            continue  # the sections themselves were cut
        store = PointStore(graph.points, tolerance_m)
        cuts: defaultdict[int, list[int]] = defaultdict(list)
        for directed in outline_curves(graph):
            if _looks_right(graph, directed, interface):
                for z, r in _bounds_on(graph, directed, interface, tolerance_m):
                    cuts[directed[0]].append(store.add(z, r))
        graph = split_curves(graph, store.array(), cuts)
    return graph


def interface_curves(
    graph: PlaneGraph, body: Body, tolerance_m: float
) -> Mapping[str, tuple[int, ...]]:
    """Return the curve indices of every interface, ascending.

    `tolerance_m`: distance [m] a curve may lie outside the bounds. Raises GeometryError if an
    interface finds no curve, or its axial range is not covered.
    """
    found = {}
    for interface in body.interfaces:
        candidates: Iterable[DirectedCurve]
        if interface.planes_m:
            candidates = [(number, 1) for number in range(len(graph.curves))]
        else:
            candidates = outline_curves(graph)
        curves = sorted(
            directed[0]
            for directed in candidates
            if _looks_right(graph, directed, interface)
            and all(_inside(graph.points[p], interface, tolerance_m) for p in graph.ends(directed))
        )
        if not curves:
            raise GeometryError(_outside_message(body, interface))
        if interface.kind in ("outer", "inner", "slab"):
            _refuse_uncovered(graph, curves, interface, tolerance_m)
        found[interface.name] = tuple(curves)
    return found


def _looks_right(graph: PlaneGraph, directed: DirectedCurve, interface: Interface) -> bool:
    """Tell whether a straight curve has the orientation that the interface's kind asks for."""
    if interface.kind == "slab":
        return not graph.on_axis(directed[0])
    dz = float(graph.step(directed)[0])
    if interface.kind in ("section", "face"):
        return dz == 0.0 and bool(graph.points[graph.ends(directed)[0], 0] == interface.start_m)
    # With the material on the left the outward normal is (dr, -dz).
    if interface.kind == "outer":
        return dz < 0.0
    return dz > 0.0 and not graph.on_axis(directed[0])


def _bounds_on(
    graph: PlaneGraph, directed: DirectedCurve, interface: Interface, tolerance_m: float
) -> list[tuple[float, float]]:
    """Return the places (z, r) [m] inside a straight curve where the interface is bounded."""
    start, step = graph.points[graph.ends(directed)[0]], graph.step(directed)
    shares = []
    limits = ((interface.start_m, interface.end_m), interface.radius_m or ())
    for direction, values in enumerate(limits):
        if step[direction] != 0.0:
            shares += [(value - start[direction], step[direction]) for value in values]
    places = []
    for numerator, denominator in shares:
        share = float(numerator / denominator)
        z, r = (float(x) for x in start + share * step)
        if 0.0 < share < 1.0 and _inside((z, r), interface, tolerance_m):
            places.append((z, r))
    return places


def _inside(
    place: tuple[float, float] | FloatArray, interface: Interface, tolerance_m: float
) -> bool:
    z, r = place
    if not interface.start_m - tolerance_m <= z <= interface.end_m + tolerance_m:
        return False
    if interface.radius_m is None:
        return True
    lower, upper = interface.radius_m
    return bool(lower - tolerance_m <= r <= upper + tolerance_m)


def _span(interface: Interface) -> str:
    span = f"z = {interface.start_m:.9g} m"
    if interface.end_m != interface.start_m:
        span += f" to {interface.end_m:.9g} m"
    if interface.radius_m is not None:
        span += f", r = {interface.radius_m[0]:.9g} m to {interface.radius_m[1]:.9g} m"
    return span


def _outside_message(body: Body, interface: Interface) -> str:
    (z_0, z_1), (r_0, r_1) = axial_range(body), radial_range(body)
    return (
        f"interface '{interface.name}' of kind '{interface.kind}' at {_span(interface)} lies "
        f"outside the body '{body.name}': no curve found there; the body reaches from "
        f"z = {z_0:.9g} m to {z_1:.9g} m and from r = {r_0:.9g} m to {r_1:.9g} m"
    )


def _refuse_uncovered(
    graph: PlaneGraph, curves: Iterable[int], interface: Interface, tolerance_m: float
) -> None:
    """Refuse an interface whose axial range is not fully covered by its curves."""
    spans = sorted(
        tuple(sorted((float(graph.points[c.start, 0]), float(graph.points[c.end, 0]))))
        for c in (graph.curves[number] for number in curves)
    )
    covered = [list(spans[0])]
    for low, high in spans[1:]:
        if low <= covered[-1][1] + tolerance_m:
            covered[-1][1] = max(covered[-1][1], high)
        else:
            covered.append([low, high])
    complete = (
        len(covered) == 1
        and covered[0][0] <= interface.start_m + tolerance_m
        and covered[0][1] >= interface.end_m - tolerance_m
    )
    if not complete:
        parts = " and ".join(f"z = {low:.9g} m to {high:.9g} m" for low, high in covered)
        raise GeometryError(
            f"interface '{interface.name}' of kind '{interface.kind}' at {_span(interface)} is "
            f"partially outside the body: only {parts} is covered"
        )
