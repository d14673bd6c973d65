"""A meridian drawn in gmsh: entities, size field, and the session they live in."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import gmsh
import numpy as np

from solidwhirl.geometry import Body, Subdivision
from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.own.grading import face_bounds, graded_places
from solidwhirl.meshing.records import LocalSize, MeshSize

# Bodies are drawn in the power of 1000 of a metre in which they are this long or longer. gmsh's
# kernel takes points nearer than 1e-7 for one; the smallest detail of a body is 1e-6 of it.
_SHORTEST = 0.3
# Decimals and digits that are drawn: units that differ give the same numbers, and the same mesh.
_DECIMALS, _DIGITS = 12, 12
# How far sizes go on beyond facets, as a part of their edges: an arc of a quarter of the circle
# bulges by 0.15 of its chord.
_SKIN = 0.15


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


def local_size_field(local: LocalSize, size: MeshSize, unit_m: float) -> None:
    """Set gmsh's size field of a meridian: sizes given at points, and no larger than the largest.

    `unit_m`: length [m] that is drawn as 1.
    """
    set_smallest(local_sizes(local, size, unit_m))


def local_sizes(local: LocalSize, size: MeshSize, unit_m: float) -> list[int]:
    """Size fields of a meridian, in the plane y = 0, or of a sector; the smallest value counts."""
    if local.points.shape[1] == 3:
        local = with_skin(local)
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


def with_skin(local: LocalSize) -> LocalSize:
    """Sizes of a solid continued beyond its flat facets, constant along the normals.

    Curved surfaces bulge from the facets of the last mesh. gmsh would take the size of the nearest
    vertex there, which may be that of a fine edge across a whole facet.
    """
    sides = np.array([np.roll(np.arange(4), k) for k in range(4)])  # facet, and the vertex across
    facets = local.cells[:, sides].reshape(-1, 4)
    _, first, count = np.unique(
        np.sort(facets[:, :3], axis=1), axis=0, return_index=True, return_counts=True
    )
    outer = facets[first[count == 1]]
    a, b, c, across = (local.points[outer[:, k]] for k in range(4))
    normals = np.cross(b - a, c - a)
    normals *= -np.sign(np.einsum("fi,fi->f", normals, across - a))[:, None]
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    longest = np.max([np.linalg.norm(u - v, axis=1) for u, v in ((a, b), (b, c), (c, a))], axis=0)
    out, reach = np.zeros_like(local.points), np.zeros(len(local.points))
    for k in range(3):
        np.add.at(out, outer[:, k], normals)
        np.maximum.at(reach, outer[:, k], _SKIN * longest)
    on_skin = np.unique(outer[:, :3])
    length = np.maximum(np.linalg.norm(out[on_skin], axis=1), 1e-300)
    copies = local.points[on_skin] + (reach[on_skin] / length)[:, None] * out[on_skin]
    # prisms in three tetrahedra, neighbours with the same diagonals
    below = np.sort(outer[:, :3], axis=1)
    above = len(local.points) + np.searchsorted(on_skin, below)
    prisms = [np.hstack([below[:, k:], above[:, : k + 1]]) for k in range(3)]
    return replace(
        local,
        points=np.vstack([local.points, copies]),
        cells=np.vstack([local.cells, *prisms]),
        size_m=np.concatenate([local.size_m, local.size_m[on_skin]]),
    )


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
