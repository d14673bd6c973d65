"""The curves of a subdivision along which joints part the body."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

from solidwhirl.geometry.errors import GeometryError
from solidwhirl.geometry.joints import Joint
from solidwhirl.geometry.meridian.fillets import Fillet
from solidwhirl.geometry.meridian.plane_graph import (
    PlaneGraph,
    PointStore,
    faces_of_curves,
    split_curves,
)
from solidwhirl.geometry.profile import Body


@dataclass(frozen=True, kw_only=True, slots=True)
class JointFace:
    """The common face of two sections."""

    sections: tuple[int, int]  #: Indices of the body's sections, in the order of the joint
    curves: tuple[int, ...]  #: All curves of the face, ascending
    seat: tuple[int, ...]  #: Those that carry


def split_at_seats(graph: PlaneGraph, body: Body, tolerance_m: float) -> PlaneGraph:
    """Split the common faces of joints where what carries begins and ends.

    Raises GeometryError: the sections of a joint do not touch, or are none of the body's.
    """
    for joint in body.joints:
        if joint.over_m is None:
            continue
        store = PointStore(graph.points, tolerance_m)
        cuts: defaultdict[int, list[int]] = defaultdict(list)
        for number in _common(graph, body, joint):
            start, step = graph.points[graph.ends((number, 1))[0]], graph.step((number, 1))
            way = _along(graph, number)
            for bound in joint.over_m:
                share = float((bound - start[way]) / step[way])
                if 0.0 < share < 1.0:
                    z, r = (float(x) for x in start + share * step)
                    cuts[number].append(store.add(z, r))
        graph = split_curves(graph, store.array(), cuts)
    return graph


def joint_faces(graph: PlaneGraph, body: Body, tolerance_m: float) -> tuple[JointFace, ...]:
    """Return the common face of every joint.

    Raises GeometryError: the sections do not touch, nothing of the face carries, or two joints are
    of one face.
    """
    names = [section.name for section in body.sections]
    out = []
    for joint in body.joints:
        curves = _common(graph, body, joint)
        seat = tuple(n for n in curves if _carries(graph, n, joint, tolerance_m))
        if not seat:
            places = [graph.points[p, _along(graph, n)] for n in curves for p in graph.ends((n, 1))]
            raise GeometryError(
                f"body '{body.name}': {joint.where}: over_m is {list(joint.over_m or ())}, but the "
                f"common face reaches from {min(places):.9g} to {max(places):.9g} m"
            )
        ends = (names.index(joint.between[0]), names.index(joint.between[1]))
        out.append(JointFace(sections=ends, curves=curves, seat=seat))
    for first, second in combinations(range(len(out)), 2):
        if set(out[first].curves) & set(out[second].curves):
            raise GeometryError(
                f"body '{body.name}': {body.joints[first].where}: two joints are of this face; "
                "keep one"
            )
    return tuple(out)


def refuse_filleted_ends(
    body: Body, graph: PlaneGraph, faces: Sequence[JointFace], fillets: Sequence[Fillet]
) -> None:
    """Refuse a fillet where two parts meet: there is no material in the corner."""
    corners = {fillet.corner for fillet in fillets}
    for joint, face in zip(body.joints, faces, strict=True):
        for point in {p for n in face.curves for p in graph.ends((n, 1))} & corners:
            z, r = graph.points[point]
            raise GeometryError(
                f"body '{body.name}': {joint.where}: fillet_radius_m = {body.fillet_radius_m:g} "
                f"would fill the corner between the two parts at z = {z:.9g} m, r = {r:.9g} m; "
                "bodies with joints have sharp corners: leave it out"
            )


def _common(graph: PlaneGraph, body: Body, joint: Joint) -> tuple[int, ...]:
    names = [section.name for section in body.sections]
    for name in joint.between:
        if name not in names:
            raise GeometryError(
                f"body '{body.name}': {joint.where}: there is no section '{name}'; known: "
                f"{', '.join(names)}"
            )
    wanted = {names.index(name) for name in joint.between}
    found = tuple(
        number
        for number, owners in enumerate(faces_of_curves(graph))
        if {graph.faces[k].section for k in owners} == wanted
    )
    if not found:
        raise GeometryError(
            f"body '{body.name}': {joint.where}: the two sections do not touch; allowed are "
            "sections with a common face"
        )
    return found


def _along(graph: PlaneGraph, number: int) -> int:
    """Which coordinate, z or r, tells a place on a curve."""
    return 1 if graph.step((number, 1))[0] == 0.0 else 0


def _carries(graph: PlaneGraph, number: int, joint: Joint, tolerance_m: float) -> bool:
    if joint.over_m is None:
        return True
    low, high = joint.over_m
    places = [graph.points[p, _along(graph, number)] for p in graph.ends((number, 1))]
    return bool(min(places) >= low - tolerance_m and max(places) <= high + tolerance_m)
