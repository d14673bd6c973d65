"""Surfaces of the bodies and of their rigid disks, with their motion per coordinate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from solidwhirl.drawing.bodies import RigidDisk, Silhouette
from solidwhirl.files.surface_files import shown_surface
from solidwhirl.rotordyn import Superelement
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray
from solidwhirl.rotordyn.superelement.centreline import centreline_motion
from solidwhirl.rotordyn.superelement.surface import (
    Surface,
    beam_surface,
    outline_chains,
    plane_sections,
)
from solidwhirl.rotordyn.superelement.validation import MOTIONS

# Turn [rad] at a corner of an outline; pieces along one that is turned about the axis.
_CORNER, _STEPS = 0.12, 60
# Points of the surface of a whole solid.
MOST_POINTS = 2500
# Factor from one size of boxes to the next.
_LARGER = 1.12
# Components of a direction that tell two sides of a surface apart.
_COUNTS = 0.35
# Half the thickness of a rigid disk over its radius, as no scene tells it.
_FLAT = 0.06


class Piece(NamedTuple):
    """A surface of a body, or of one of its rigid disks with the disk's name."""

    body: str
    surface: Surface
    disk: str = ""


def pieces_of(
    elements: Mapping[str, Superelement], bodies: Sequence[Silhouette]
) -> tuple[Piece, ...]:
    """Return the surfaces of the bodies and of their rigid disks.

    Of a body that knows no surface the profile is turned about the axis, its sections square to the
    centre line; one without a profile has none.
    """
    found: list[Piece] = []
    for body in bodies:
        element = elements[body.name]
        surface = shown_surface(element)
        if surface is None and body.lines_m:
            surface = _turned(element, body.lines_m)
        if surface is not None:
            found.append(Piece(body.name, surface))
        for disk in body.disks:
            turned = _disk_at_interface if disk.interface else _disk_on_beam
            found += [Piece(body.name, s, disk.name) for s in turned(element, disk)]
    return tuple(found)


def _turned(element: Superelement, lines: Sequence[FloatArray]) -> Surface | None:
    """An outline in (z, r) whose sections stay square to the centre line."""
    axis = centreline_motion(element)
    places, first = np.unique(axis.axial_m, return_index=True)
    if places.size < 2:
        return None
    step = float(np.ptp(np.vstack(lines)[:, 0])) / _STEPS
    points: list[FloatArray] = []
    edges: list[IntArray] = []
    for start, end in (pair for line in lines for pair in pairwise(line)):
        count = max(1, int(np.ceil(abs(end[0] - start[0]) / step)))
        number = sum(map(len, points)) + np.arange(count)
        edges.append(np.column_stack([number, number + 1]))
        points.append(start + np.linspace(0.0, 1.0, count + 1)[:, None] * (end - start))
    meridian, moved = np.vstack(points), axis.modes[first]
    from scipy.interpolate import interp1d  # takes a tenth of a second

    at = [interp1d(places, f, axis=0, bounds_error=False, fill_value=(f[0], f[-1]))(meridian[:, 0])
          for f in (moved, np.gradient(moved, places, axis=0))]  # fmt: skip
    planes = [(at[0][:, c], at[1][:, c]) for c in (0, 1)]
    return plane_sections(meridian, np.concatenate(edges), planes)


def thinned(surface: Surface, spacing_m: float) -> Surface:
    """Return a surface with fewer points: corners of a meridian, clusters of a solid.

    Points along the outline of a meridian are at most so far apart.
    """
    if surface.kind != "meridian":
        return _clustered(surface)
    points, cells = kept_of_outline(surface.points_m, surface.cells, spacing_m)
    return replace(
        surface,
        points_m=surface.points_m[points],
        cells=cells,
        amplitudes=surface.amplitudes[points],
    )


def kept_of_outline(
    points_m: FloatArray, cells: IntArray, spacing_m: float
) -> tuple[IntArray, IntArray]:
    """Return which points of a meridian's outline are kept, and the edges between those."""
    kept: list[IntArray] = [
        chain[_kept_of_chain(points_m[chain], spacing_m)] for chain in outline_chains(cells)
    ]
    points = np.unique(np.concatenate(kept)) if kept else np.empty(0, dtype=np.int64)
    new = np.full(len(points_m), -1)
    new[points] = np.arange(points.size)
    edges = [np.column_stack([new[k[:-1]], new[k[1:]]]) for k in kept if k.size > 1]
    return points, np.concatenate(edges) if edges else np.empty((0, 2), dtype=np.int64)


def kept_of_sector(points_m: FloatArray, cells: IntArray, most: int) -> tuple[IntArray, IntArray]:
    """Return which points of a sector's surface are kept, and the triangles between those.

    There is one point for each small box that has some and each direction that the surface there
    looks to, as both sides of a thin blade are in one box: the point at the sharpest edge. On the
    cut faces boxes are of r and z, so that both faces keep the same points and copies of the sector
    have no gaps between them. `most`: points at most.
    """
    low, size = points_m.min(axis=0), float(np.ptp(points_m, axis=0).max())
    # rounded, as both faces are equal up to that
    flat = np.column_stack([np.hypot(points_m[:, 0], points_m[:, 1]), points_m[:, 2]])
    flat = np.round(flat / size, 8)
    side, sharpness = _cut_side(points_m, cells), _sharpness(points_m, cells, flat)
    order = np.lexsort((*flat.T, -np.round(sharpness, 3)))
    looks = _looks(points_m, cells)
    looks[side != 0] = 0.0
    box = 1.0 / 400.0
    while True:
        place = np.floor((points_m - low) / (size * box))
        place[side != 0] = 0.0
        place[side != 0, :2] = np.floor(flat[side != 0] / box)
        boxes = np.column_stack([side, place, looks]).astype(np.int64)[order]
        _, first, group = np.unique(boxes, axis=0, return_index=True, return_inverse=True)
        if first.size <= most or box > 0.2:
            break
        box *= 1.12
    new = np.empty(len(points_m), dtype=np.int64)
    new[order] = group.reshape(-1)
    triangles = new[cells]
    lost = (triangles == np.roll(triangles, 1, axis=1)).any(axis=1)
    return order[first], triangles[~lost]


def _normals(points_m: FloatArray, cells: IntArray) -> FloatArray:
    """Unit normals of triangles."""
    corners = points_m[cells]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300))


def _looks(points_m: FloatArray, cells: IntArray) -> FloatArray:
    """Where the surface looks at its points: signs of the components that count, (p, 3)."""
    total = np.zeros_like(points_m)
    np.add.at(total, cells.ravel(), np.repeat(_normals(points_m, cells), 3, axis=0))
    total /= np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-300)
    return np.where(np.abs(total) > _COUNTS, np.sign(total), 0.0)


def _edges(cells: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Edges of triangles, (3 c, 2): number of each among the different ones, these, their count."""
    edges = np.sort(np.concatenate([cells[:, [0, 1]], cells[:, [1, 2]], cells[:, [2, 0]]]), axis=1)
    found, number, count = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    return number.reshape(-1), found, count


def _sharpness(points_m: FloatArray, cells: IntArray, flat: FloatArray) -> FloatArray:
    """How much a surface turns at its points, 0 where it is plane.

    On the edges of the surface, which both cut faces have, the turn of these in r and z, `flat`.
    """
    normal = _normals(points_m, cells)
    number, edges, count = _edges(cells)
    total = np.zeros((len(edges), 3))
    np.add.at(total, number, np.tile(normal, (3, 1)))
    turn = np.where(count == 2, 2.0 - np.linalg.norm(total, axis=1), 0.0)
    sharp = np.bincount(edges.ravel(), np.repeat(turn, 2), len(points_m))
    outer = edges[count == 1]
    along = flat[outer[:, 1]] - flat[outer[:, 0]]
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
    ends = np.zeros_like(flat)
    np.add.at(ends, outer[:, 0], along)
    np.add.at(ends, outer[:, 1], -along)
    own = np.unique(outer)
    sharp[own] = np.linalg.norm(ends[own], axis=1)
    return np.asarray(sharp)


def _cut_side(points_m: FloatArray, cells: IntArray) -> IntArray:
    """-1 and 1 of points on the edges of a sector's surface, by the cut face, else 0."""
    _, edges, count = _edges(cells)
    own = np.unique(edges[count == 1])
    middle = points_m[:, :2].sum(axis=0)
    across = points_m[:, 1] * middle[0] - points_m[:, 0] * middle[1]
    side = np.zeros(len(points_m), dtype=np.int64)
    side[own] = np.where(across[own] < 0.0, -1, 1)
    return side


def _kept_of_chain(points: FloatArray, spacing: float) -> IntArray:
    """Places along a chain that are its ends, corners, or far from the last one kept."""
    last = len(points) - 1
    step = np.diff(points, axis=0)
    angle = np.arctan2(step[:, 1], step[:, 0])
    kept, before, direction = [0], points[0], angle[0]
    for k in range(1, last):
        turn = abs((angle[k] - direction + np.pi) % (2.0 * np.pi) - np.pi)
        if turn > _CORNER or np.hypot(*(points[k + 1] - before)) > spacing:
            kept.append(k)
            before, direction = points[k], angle[k]
    return np.array([*kept, last])


def _clustered(surface: Surface) -> Surface:
    """The surface of a whole solid with one point for each small box that has some."""
    faces = surface.faces(0)
    points = faces.points_m
    if surface.kind == "solid" and len(points) <= MOST_POINTS:
        return surface
    low, size = points.min(axis=0), float(np.ptp(points, axis=0).max())
    _, first, group = _few_boxes(points - low, size / 400.0)
    cells = group[faces.triangles]
    flat = (cells == np.roll(cells, 1, axis=1)).any(axis=1)
    if surface.kind == "sector":
        return surface.as_solid(first, cells[~flat])
    return replace(
        surface,
        points_m=points[first],
        cells=cells[~flat],
        amplitudes=surface.amplitudes[first],
    )


def _few_boxes(points: FloatArray, size: float) -> tuple[IntArray, IntArray, IntArray]:
    """Boxes of a size that is raised until few have points: numbers, first points, box of each."""
    while True:
        found = np.unique(_boxes(points, size), return_index=True, return_inverse=True)
        count = found[0].size
        if count <= MOST_POINTS:
            return found
        # they fall as the square of the size, of boxes with a point or two more slowly
        steps = int(0.5 * np.log(count / MOST_POINTS) / np.log(_LARGER))
        size *= _LARGER ** max(1, steps)


def _boxes(points: FloatArray, size: float) -> IntArray:
    """Numbers of the boxes of a size that points (p, 3) from 0 on are in."""
    place = np.floor(points / size).astype(np.int64)
    return np.asarray(np.ravel_multi_index(tuple(place.T), tuple(place.max(axis=0) + 1)))


def _disk_at_interface(element: Superelement, disk: RigidDisk) -> list[Surface]:
    node = element.interface_node(disk.interface)
    rows: dict[str, FloatArray] = {c: np.zeros(element.size) for c in MOTIONS}
    for component in element.components_at(node.name):
        rows[component][element.interface_index(node.name, component)] = 1.0
    return [_disk_surface(disk, float(node.position_m[2]), rows)]


def _disk_on_beam(element: Superelement, disk: RigidDisk) -> list[Surface]:
    """At the nearest point of the beam; none if its points do not rise along the axis."""
    places = element.recovery_points_m[:, 2]
    if places.size < 2 or not (np.diff(places) > 0.0).all():
        return []
    moved = element.recovery_modes
    slopes = np.gradient(moved, places, axis=0)
    at = int(np.abs(places - disk.at_m).argmin())
    rows: dict[str, FloatArray] = dict(zip(MOTIONS[:3], moved[at], strict=True))
    rows |= {"rx": -slopes[at, 1], "ry": slopes[at, 0], "rz": np.zeros(element.size)}
    return [_disk_surface(disk, float(places[at]), rows)]


def _disk_surface(disk: RigidDisk, carrier_m: float, rows: Mapping[str, FloatArray]) -> Surface:
    """A disk that moves with a point of the axis, whose motions are "ux" to "rz", (n,) each."""
    half = _FLAT * disk.radius_m * np.array([-1.0, 1.0])
    planes = []
    for moved, slope in ((rows["ux"], rows["ry"]), (rows["uy"], -rows["rx"])):
        plane = np.zeros((4, moved.size))
        plane[0::2] = moved + np.outer(disk.at_m - carrier_m + half, slope)
        plane[1::2] = slope
        planes.append(plane)
    return beam_surface(
        disk.at_m + half,
        np.array([disk.radius_m]),
        np.array([0.0]),
        (planes[0], planes[1]),
        np.tile(rows["uz"], (2, 1)),
        np.tile(rows["rz"], (2, 1)),
    )


def outer_faces(tetrahedra: IntArray) -> IntArray:
    """Return the faces (f, 3) that one of the tetrahedra (c, 4) alone has, seen from outside."""
    faces = tetrahedra[:, [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]].reshape(-1, 3)
    _, first, counts = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
    )
    return np.asarray(faces[first[counts == 1]])
