"""Element sizes that a body asks for, on its meridian and at its holes; loads no mesher."""

from __future__ import annotations

import numpy as np

from solidwhirl.geometry import Body, Face, Hole, Subdivision
from solidwhirl.geometry.parts import faces_beside
from solidwhirl.meshing.records import FloatArray, IntArray, MeshSize

#: Fewest elements around any curved surface. An element with two faces on one is folded unless its
#: edges are made straight: at 16 that takes 1 per mille of a shaft's mass, at 24 6 millionths.
AROUND = 24
# Elements across the quarter circle of a fillet.
_ACROSS_FILLET = 4
# A slice between two neighbours is part of them: it needs no elements smaller than this part of
# theirs, though it is thinner; in 3D they fill the circumference as well.
_SLICE = {2: 0.05, 3: 0.25}
# Two curves whose directions add up to less than this are one straight line.
_STRAIGHT = 1e-9


def face_bounds(
    body: Body, subdivision: Subdivision, size: MeshSize, dimension: int
) -> list[float]:
    """Largest element edge [m] on every face, from its thickness and, in 3D, its circumference."""
    thickness = sliced_thickness(subdivision, _SLICE[dimension])
    bounds = []
    for face, thick in zip(subdivision.faces, thickness, strict=True):
        bound = min(size.size_m, 1.5 * float(thick) / size.through_thickness)
        if dimension == 3:
            outer = max(body.sections[face.section].outer_radius_m)
            bound = min(bound, 2.0 * np.pi * outer / size.around)
        bounds.append(bound)
    return bounds


def sliced_thickness(subdivision: Subdivision, part: float) -> FloatArray:
    """Thickness [m] of every face that decides on its elements.

    It is the smaller dimension, but for a slice that is bonded to a thicker face along a whole side
    (what two cross-sections near each other cut out of a shaft, or the step of a shoulder): there
    it is at least a part of the neighbour's.
    """
    own, sides = face_thickness(subdivision), faces_beside(subdivision)
    out = own.copy()
    # from the thickest on, so that a pile of slices follows what it lies on
    for k in np.argsort(-own):
        for c in (c for c, _ in subdivision.faces[k].loop):
            curve = subdivision.curves[c]
            length = np.linalg.norm(subdivision.points[curve.end] - subdivision.points[curve.start])
            for other in sides[c]:
                if length > 2.0 * own[other]:
                    out[other] = max(out[other], part * out[k])
    return out


def face_thickness(subdivision: Subdivision) -> FloatArray:
    """Smaller dimension of every face [m]: twice its area over its perimeter, at most.

    For a long strip this is its thickness; for a square it is half the side, which the factor
    in `face_bounds` makes up for.
    """
    out = np.empty(len(subdivision.faces))
    for k, face in enumerate(subdivision.faces):
        p, q = face_edges(subdivision, face)
        area = 0.5 * abs(np.sum(p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1]))
        out[k] = 2.0 * area / np.linalg.norm(q - p, axis=1).sum()
    return out


def face_edges(subdivision: Subdivision, face: Face) -> tuple[FloatArray, FloatArray]:
    """Start and end points (n, 2) of the edges of a face, arcs as chords, counterclockwise."""
    starts = []
    for c, sign in face.loop:
        curve = subdivision.curves[c]
        starts.append(curve.start if sign > 0 else curve.end)
    p = subdivision.points[np.array(starts)]
    return p, np.roll(p, -1, axis=0)


def graded_places(
    body: Body, subdivision: Subdivision, size: MeshSize
) -> list[tuple[float, float, float]]:
    """Places (z, r) with the element size asked for there."""
    places = []
    for corner in subdivision.corners:
        if not corner.filleted:
            z, r = subdivision.points[corner.point]
            places.append((float(z), float(r), size.corner_size_m))
    for interface in body.interfaces:
        if interface.coupling == "rigid":  # the stress is singular where the rigid part ends
            own = [subdivision.curves[c] for c in subdivision.interfaces[interface.name]]
            chain = np.array([(curve.start, curve.end) for curve in own])
            for z, r in subdivision.points[chain_ends(subdivision.points, chain, _STRAIGHT)]:
                places.append((float(z), float(r), size.corner_size_m))
    arc_size = body.fillet_radius_m * (np.pi / 2.0) / _ACROSS_FILLET
    for c in subdivision.fillet_arcs:
        curve = subdivision.curves[c]
        z, r = subdivision.points[[curve.start, curve.end]].mean(axis=0)
        places.append((float(z), float(r), min(arc_size, size.size_m)))
    return places


def chain_ends(points: FloatArray, segments: IntArray, straight: float) -> list[int]:
    """Return the points (z, r) off the axis where a chain of segments (s, 2) ends or turns.

    `straight`: two unit directions that add up to less are one line.
    """
    directions: dict[int, list[FloatArray]] = {}
    for a, b in segments:
        step = (points[b] - points[a]) / np.linalg.norm(points[b] - points[a])
        directions.setdefault(int(a), []).append(step)
        directions.setdefault(int(b), []).append(-step)
    near = 1e-9 * float(np.abs(points).max())
    return [
        point
        for point, steps in directions.items()
        if points[point, 1] > near
        and not (len(steps) == 2 and np.linalg.norm(steps[0] + steps[1]) < straight)
    ]


def edge_at_hole(hole: Hole, size: MeshSize) -> float:
    """Element edge at the wall of a hole [m]."""
    return min(size.size_m, np.pi * hole.diameter_m / AROUND)
