"""A meridian drawn in gmsh: entities, size field, and the session they live in."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import gmsh
import numpy as np

from solidwhirl.geometry import Body, Face, Subdivision
from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.records import FloatArray, IntArray, LocalSize, MeshSize

# Elements across the quarter circle of a fillet.
_ACROSS_FILLET = 4
# A slice between two neighbours is part of them: it needs no elements smaller than this part of
# theirs, though it is thinner; in 3D they fill the circumference as well.
_SLICE = {2: 0.05, 3: 0.25}
# Bodies are drawn in the power of 1000 of a metre in which they are this long or longer. gmsh's
# kernel takes points nearer than 1e-7 for one; the smallest detail of a body is 1e-6 of it.
_SHORTEST = 0.3
# Decimals and digits that are drawn: units that differ give the same numbers, and the same mesh.
_DECIMALS, _DIGITS = 12, 12
# Two curves whose directions add up to less than this are one straight line.
_STRAIGHT = 1e-9


@contextmanager
def gmsh_session() -> Iterator[None]:
    """Run gmsh quietly, with one thread (repeatable meshes), and always close it.

    Raises MeshingError: what gmsh itself could not do, in its own words.
    """
    with _without_chatter():
        yield from _session()


@contextmanager
def _without_chatter() -> Iterator[None]:
    """Send what the CAD kernel prints on the standard output nowhere; its errors are raised."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)
    try:
        yield
    finally:
        ctypes.CDLL(None).fflush(None)
        os.dup2(kept, 1)
        os.close(kept)


def _session() -> Iterator[None]:
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        gmsh.option.setNumber("Geometry.OCCBoundsUseStl", 0)
        for name in ("FromPoints", "FromCurvature", "ExtendFromBoundary"):
            gmsh.option.setNumber(f"Mesh.MeshSize{name}", 0)
        gmsh.model.add("body")
        yield
    except MeshingError:
        raise
    except Exception as error:  # gmsh raises bare Exception
        if type(error) is not Exception:
            raise
        raise MeshingError(f"gmsh could not make the mesh: {error}") from error
    finally:
        gmsh.finalize()


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """gmsh tags of a drawn meridian, by index in the subdivision."""

    curves: tuple[int, ...]
    faces: tuple[int, ...]


def drawing_unit_m(subdivision: Subdivision) -> float:
    """Length [m] that is 1 in the drawing, a power of 1000: bodies of any size are drawn alike."""
    extent = max(float(np.ptp(subdivision.points[:, 0])), float(subdivision.points[:, 1].max()))
    return float(1000.0 ** np.floor(np.log10(extent / _SHORTEST) / 3.0))


def drawn_length(length_m: float, unit_m: float) -> float:
    """Length in units of the drawing, without the rounding that the unit brings."""
    return float(f"{length_m / unit_m:.{_DIGITS}g}")


def draw(subdivision: Subdivision, unit_m: float) -> Drawing:
    """Draw the faces of a meridian in the plane y = 0, with x = r.

    `unit_m`: length [m] that is drawn as 1. Result: tags of curves and faces in the open gmsh
    model.
    """
    occ = gmsh.model.occ
    drawn = [[round(float(x) / unit_m, _DECIMALS) for x in p] for p in subdivision.points]
    points = [occ.addPoint(r, 0.0, z) for z, r in drawn]
    curves = []
    for curve in subdivision.curves:
        if curve.centre is None:
            curves.append(occ.addLine(points[curve.start], points[curve.end]))
        else:
            arc = (points[curve.start], points[curve.centre], points[curve.end])
            curves.append(occ.addCircleArc(*arc))
    faces = []
    for face in subdivision.faces:
        loop = occ.addCurveLoop([sign * curves[c] for c, sign in face.loop])
        faces.append(occ.addPlaneSurface([loop]))
    occ.synchronize()
    return Drawing(curves=tuple(curves), faces=tuple(faces))


def face_thickness(subdivision: Subdivision) -> FloatArray:
    """Smaller dimension of every face [m]: twice its area over its perimeter, at most.

    For a long strip this is its thickness; for a square it is half the side, which the factor
    in `size_fields` makes up for.
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


def local_size_field(local: LocalSize, size: MeshSize, unit_m: float) -> None:
    """Set gmsh's size field of a meridian: sizes given at points, and no larger than the largest.

    `unit_m`: length [m] that is drawn as 1.
    """
    set_smallest(local_sizes(local, size, unit_m))


def local_sizes(local: LocalSize, size: MeshSize, unit_m: float) -> list[int]:
    """Size fields of a meridian, in the plane y = 0, or of a sector; the smallest value counts."""
    corners = local.points[local.cells] / unit_m
    values = local.size_m[local.cells] / unit_m
    size_drawn = drawn_length(size.size_m, unit_m)
    if local.points.shape[1] == 2:
        z, r = corners[:, :, 0], corners[:, :, 1]
        kind, places = "ST", [r, np.zeros_like(r), z]
    else:
        kind, places = "SS", [corners[:, :, k] for k in range(3)]
    data = np.concatenate([*places, values], axis=1)
    view = gmsh.view.add("sizes")
    gmsh.view.addListData(view, kind, len(data), data.ravel())
    field = gmsh.model.mesh.field
    given = field.add("PostView")
    field.setNumber(given, "ViewTag", view)
    field.setNumber(given, "UseClosest", 1)
    largest = field.add("Constant")
    field.setNumber(largest, "VIn", size_drawn)
    field.setNumber(largest, "VOut", size_drawn)
    return [given, largest, *graded_fields(local.places, local.growth, size, 2, unit_m)]


def set_smallest(fields: list[int]) -> None:
    """Let the smallest of size fields decide."""
    gmsh.model.mesh.field.setAsBackgroundMesh(smallest(fields))


def smallest(fields: list[int]) -> int:
    """Size field that is the smallest of others."""
    minimum = gmsh.model.mesh.field.add("Min")
    gmsh.model.mesh.field.setNumbers(minimum, "FieldsList", fields)
    return int(minimum)


def bounded(bounds: Iterable[tuple[float, list[int]]], key: str, unit_m: float) -> list[int]:
    """Size fields that are constant [m] on entities each, which `key` is gmsh's option for."""
    field = gmsh.model.mesh.field
    tags = []
    for bound, entities in bounds:
        tags.append(field.add("Constant"))
        field.setNumber(tags[-1], "VIn", drawn_length(bound, unit_m))
        field.setNumber(tags[-1], "VOut", 1e22)
        field.setNumbers(tags[-1], key, entities)
    return tags


def _drawn_places(
    places: Iterable[tuple[float, float, float]], unit_m: float
) -> list[tuple[float, float, float]]:
    """Places and their element sizes in units of the drawing."""
    return [
        (round(z / unit_m, _DECIMALS), round(r / unit_m, _DECIMALS), drawn_length(h, unit_m))
        for z, r, h in places
    ]


def graded_fields(
    places: Iterable[tuple[float, float, float]],
    growth: float,
    size: MeshSize,
    dimension: int,
    unit_m: float,
) -> list[int]:
    """Size fields that grow with the distance from places (z, r, h) [m], of circles in 3D.

    In the plane a ball does it, which gmsh evaluates ten times faster than an expression.
    """
    largest = drawn_length(size.size_m, unit_m)
    field = gmsh.model.mesh.field
    tags = []
    for z, r, h in _drawn_places(places, unit_m):
        if dimension == 2:
            tags.append(field.add("Ball"))
            settings = {"XCenter": r, "YCenter": 0.0, "ZCenter": z, "Radius": 1e-9 * largest}
            settings |= {"VIn": h, "VOut": largest, "Thickness": (largest - h) / growth}
            for name, value in settings.items():
                field.setNumber(tags[-1], name, value)
        else:
            tags.append(field.add("MathEval"))
            distance = f"Sqrt((z-({z!r}))^2+(Sqrt(x^2+y^2)-({r!r}))^2)"
            field.setString(tags[-1], "F", f"{h!r}+{growth!r}*{distance}")
    return tags


def size_fields(
    body: Body, subdivision: Subdivision, size: MeshSize, entities: list[int], unit_m: float
) -> None:
    """Set gmsh's size field: graded to re-entrant corners, bounded by the sections' thickness.

    `entities`: tags of the drawn faces (2D) or of the volumes swept by them (3D), in the order of
    the subdivision's faces. `unit_m`: length [m] that is drawn as 1.
    """
    dimension = 3 if gmsh.model.getEntities(3) else 2
    key = "VolumesList" if dimension == 3 else "SurfacesList"
    bounds = face_bounds(body, subdivision, size, dimension)
    tags = bounded(zip(bounds, ([e] for e in entities), strict=True), key, unit_m)
    places = graded_places(body, subdivision, size)
    set_smallest([*tags, *graded_fields(places, size.growth, size, dimension, unit_m)])


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
    own = face_thickness(subdivision)
    sides: dict[int, list[int]] = {}
    for k, face in enumerate(subdivision.faces):
        for c, _ in face.loop:
            sides.setdefault(c, []).append(k)
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
