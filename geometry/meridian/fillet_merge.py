"""Fillet faces divided among their neighbours, which removes their cusps for a mesher."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from solidwhirl.geometry.meridian.plane_graph import Curve, DirectedCurve, Face, renumbered_points
from solidwhirl.geometry.meridian.subdivision import Subdivision


def merge_fillets(subdivision: Subdivision) -> Subdivision:
    """Return the subdivision with every fillet face divided among its two neighbours.

    A fillet face has an angle of zero at both tangent points, and the triangles there are poor. So
    it is halved by the line from the corner to the middle of the arc, and each half is joined
    to the face beside it across the straight edge, if that has the same material (a half beside
    another material stays a face with one cusp). The material at every place stays what it was;
    the joined half counts to the section of the face it is joined to.

    Result: curve and point indices are new. Every fillet has two entries in `fillet_arcs`.
    """
    points = [(float(z), float(r)) for z, r in subdivision.points]
    curves, faces = list(subdivision.curves), list(subdivision.faces)
    corners = {corner.point for corner in subdivision.corners if corner.filleted}
    second_arcs = []
    for arc in subdivision.fillet_arcs:
        number = next(n for n, face in enumerate(faces) if (arc, 1) in face.loop)
        halves = _halves(faces[number], arc, corners, points, curves)
        second_arcs.append(len(curves) - 2)
        faces[number] = replace(faces[number], loop=halves[0])
        faces.append(replace(faces[number], loop=halves[1]))
        # Each half begins (second) or ends (first) its straight part at the tangent point.
        _join(faces, number, halves[0][-3])
        _join(faces, len(faces) - 1, halves[1][2])
    kept = tuple(face for face in faces if face.loop)
    return _renumbered(
        replace(
            subdivision,
            points=np.array(points),
            curves=tuple(curves),
            faces=kept,
            boundary=(*subdivision.boundary, *second_arcs),
            fillet_arcs=(*subdivision.fillet_arcs, *second_arcs),
        )
    )


def _halves(
    face: Face,
    arc: int,
    corners: Iterable[int],
    points: list[tuple[float, float]],
    curves: list[Curve],
) -> tuple[tuple[DirectedCurve, ...], tuple[DirectedCurve, ...]]:
    """Split a fillet's arc and face; return the loops from the corner and from the arc's middle.

    The loops are (corner ... first tangent point, arc, spoke) and (spoke, arc, second tangent
    point ... corner). Appends the middle point, the second half of the arc and the spoke.
    """
    at = face.loop.index((arc, 1))
    straight = [*face.loop[at + 1 :], *face.loop[:at]]
    starts = [curves[c].start if sign > 0 else curves[c].end for c, sign in straight]
    split = next(k for k, point in enumerate(starts) if point in corners)
    whole = curves[arc]
    assert whole.centre is not None  # fillet arcs have a centre
    first, last, vertex, centre = (
        np.array(points[p]) for p in (whole.start, whole.end, starts[split], whole.centre)
    )
    radius = 0.5 * (np.hypot(*(first - centre)) + np.hypot(*(last - centre)))
    outward = (vertex - centre) / np.hypot(*(vertex - centre))
    middle = len(points)
    z, r = centre + radius * outward
    points.append((float(z), float(r)))
    curves[arc] = replace(whole, end=middle)
    curves.append(replace(whole, start=middle))
    curves.append(Curve(start=starts[split], end=middle))
    spoke = len(curves) - 1
    return (
        (*straight[split:], (arc, 1), (spoke, -1)),
        ((spoke, 1), (spoke - 1, 1), *straight[:split]),
    )


def _join(faces: list[Face], half: int, across: DirectedCurve) -> None:
    """Join a half to the face on the other side of a directed curve, if the materials agree.

    The half's place in the list is left with an empty loop.
    """
    opposite = (across[0], -across[1])
    neighbour = next(n for n, face in enumerate(faces) if opposite in face.loop)
    if faces[neighbour].material != faces[half].material:
        return
    shared = {curve for curve, _ in faces[half].loop} & {c for c, _ in faces[neighbour].loop}
    kept = _without(faces[neighbour].loop, shared)
    added = _without(faces[half].loop, shared)
    faces[neighbour] = replace(faces[neighbour], loop=(*kept, *added))
    faces[half] = replace(faces[half], loop=())


def _without(loop: Sequence[DirectedCurve], chain: set[int]) -> tuple[DirectedCurve, ...]:
    """Return a loop without one contiguous chain, beginning after the chain."""
    last = next(
        k
        for k in range(len(loop))
        if loop[k][0] in chain and loop[(k + 1) % len(loop)][0] not in chain
    )
    rotated = [*loop[last + 1 :], *loop[: last + 1]]
    return tuple(item for item in rotated if item[0] not in chain)


def _renumbered(subdivision: Subdivision) -> Subdivision:
    """Return a subdivision without the curves no face uses and the points no curve uses."""
    used = sorted({curve for face in subdivision.faces for curve, _ in face.loop})
    curve_of = {old: new for new, old in enumerate(used)}
    curves, point_of = renumbered_points([subdivision.curves[number] for number in used])
    return replace(
        subdivision,
        points=subdivision.points[list(point_of)],
        curves=curves,
        faces=tuple(
            replace(face, loop=tuple((curve_of[c], sign) for c, sign in face.loop))
            for face in subdivision.faces
        ),
        boundary=_mapped(subdivision.boundary, curve_of),
        axis=_mapped(subdivision.axis, curve_of),
        fillet_arcs=_mapped(subdivision.fillet_arcs, curve_of),
        corners=tuple(
            replace(corner, point=point_of[corner.point]) for corner in subdivision.corners
        ),
        interfaces=MappingProxyType(
            {name: _mapped(curves, curve_of) for name, curves in subdivision.interfaces.items()}
        ),
        joints=tuple(
            replace(face, curves=_mapped(face.curves, curve_of), seat=_mapped(face.seat, curve_of))
            for face in subdivision.joints
        ),
    )


def _mapped(curves: Iterable[int], curve_of: Mapping[int, int]) -> tuple[int, ...]:
    return tuple(sorted(curve_of[curve] for curve in curves))
