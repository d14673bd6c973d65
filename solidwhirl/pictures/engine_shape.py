"""A mode of an engine in space, scaled to be seen: bodies, disks, orbits along the axis."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from solidwhirl.drawing.bodies import Silhouette, silhouettes_of
from solidwhirl.drawing.modes import ShownModes
from solidwhirl.drawing.motion import (
    SECTORS,
    EngineInSpace,
    ModeInSpace,
    engine_in_space,
    mode_in_space,
    places,
    radii_at,
)
from solidwhirl.drawing.surfaces import Piece
from solidwhirl.files.surface_files import surface_grid
from solidwhirl.files.vtk_files import LINE
from solidwhirl.rotordyn import Superelement
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray

if TYPE_CHECKING:
    from solidwhirl.pipeline.run import Results

# Largest displacement as a part of the engine's length, points of an orbit.
_LARGEST, _AROUND = 0.055, 64


# Bodies around others are open over these angles.
_OPEN_RAD = (0.42 * np.pi, 1.16 * np.pi)
# Places along the axis at which bodies are compared, and strips of a cut face.
_PLACES, _STRIPS = 40, 16
# Points of the surface from which the motion of a point inside is taken.
_NEAREST = 6


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyInSpace:
    """One body: points (p, 3) [m], their motion (p, 3) [m, complex], faces and lines."""

    body: str
    points_m: FloatArray
    motion_m: ComplexArray
    quadrangles: IntArray
    triangles: IntArray
    lines: IntArray


@dataclass(frozen=True, kw_only=True, eq=False)
class OrbitInSpace:
    """The path of a point of the axis over one period: (64, 3) [m] from phase 0, and its sense."""

    points_m: FloatArray
    whirl: str


@dataclass(frozen=True, kw_only=True, eq=False)
class EngineShape:
    """A mode of an engine, scaled to be seen."""

    #: What is drawn; points move by Re(motion e^{iφ})
    bodies: tuple[BodyInSpace, ...]
    orbits: tuple[OrbitInSpace, ...]
    #: Of the mode
    frequency_hz: float
    speed_rpm: float
    whirl: str
    #: Largest displacement as drawn
    largest_m: float

    @property
    def text(self) -> str:
        """Frequency, speed and whirl."""
        return f"{self.frequency_hz:.4g} Hz at {self.speed_rpm:.0f} rpm, {self.whirl}"


def engine_shape(results: Results, shown: ShownModes, number: int) -> EngineShape:
    """Return a mode of a run in space."""
    engine = engine_in_space(results)
    mode = mode_in_space(engine, shown, number)
    first, last, radius = engine.reach_m
    largest = _LARGEST * max(last - first, 2.0 * radius)
    moved = {name: largest * q for name, q in mode.coordinates.items()}
    shells = [p for p in engine.pieces if not p.disk]
    disks = [_turned(p, moved[p.body]) for p in engine.pieces if p.disk]
    bare = [_points(name, element, moved[name]) for name, element in engine.bare.items()]
    areas = {b.name: b for b in silhouettes_of(results)}
    bodies = [
        _opened(found, areas[p.body])
        if any(_encloses(p, other) for other in shells if other is not p)
        else found
        for p, found in ((p, _turned(p, moved[p.body])) for p in shells)
    ]
    return EngineShape(
        bodies=(*bodies, *bare, *disks),
        orbits=tuple(_orbits(engine, mode, largest)),
        frequency_hz=float(shown.modes.frequency_hz[number]),
        speed_rpm=float(shown.rpm[number]),
        whirl=shown.whirl[number],
        largest_m=largest,
    )


def _turned(piece: Piece, motion: ComplexArray) -> BodyInSpace:
    """A surface with all its points around the axis."""
    faces = piece.surface.faces(SECTORS)
    return BodyInSpace(
        body=f"{piece.body}: {piece.disk}" if piece.disk else piece.body,
        points_m=faces.points_m,
        motion_m=piece.surface.displacement(motion, SECTORS),
        quadrangles=faces.quadrangles,
        triangles=faces.triangles,
        lines=np.empty((0, 2), dtype=np.int64),
    )


def _points(name: str, element: Superelement, motion: ComplexArray) -> BodyInSpace:
    """A body without a surface: its centre line, or the points that it holds for pictures."""
    cells = dict(surface_grid(element)[0].cells)
    return BodyInSpace(
        body=name,
        points_m=element.recovery_points_m,
        motion_m=element.recovery_modes @ motion,
        quadrangles=np.empty((0, 4), dtype=np.int64),
        triangles=np.empty((0, 3), dtype=np.int64),
        lines=cells.get(LINE, np.empty((0, 2), dtype=np.int64)),
    )


def _orbits(engine: EngineInSpace, mode: ModeInSpace, largest: float) -> Iterator[OrbitInSpace]:
    turn = np.exp(2j * np.pi * np.arange(_AROUND) / _AROUND)
    for station, moved, whirl in zip(engine.stations, mode.center, mode.senses, strict=True):
        if whirl:
            path = largest * np.real(moved[:, None] * turn)
            axial = np.full(_AROUND, station.axial_m)
            yield OrbitInSpace(points_m=np.column_stack((*path, axial)), whirl=whirl)


def displaced(body: BodyInSpace, phase_rad: float) -> tuple[FloatArray, FloatArray]:
    """Return points (p, 3) [m] of a body at φ of Re(motion e^{iφ}), and how far each moved (p,)."""
    moved = np.real(body.motion_m * np.exp(1j * phase_rad))
    return body.points_m + moved, np.sqrt((moved**2).sum(axis=1))


def _encloses(piece: Piece, other: Piece) -> bool:
    """Return whether the surface of another body lies inside that of a body somewhere."""
    (z, _), (z_other, _) = places(piece), places(other)
    low, high = max(z.min(), z_other.min()), min(z.max(), z_other.max())
    return any(
        reach[1] < bore[0]
        for at in np.linspace(low, high, _PLACES)
        if (bore := radii_at(piece, at)) and (reach := radii_at(other, at))
    )


def _opened(body: BodyInSpace, outline: Silhouette) -> BodyInSpace:
    """Return a body without the faces on the side of the eye, with its cross-section instead.

    Four-sided areas of its silhouette become the cut faces; they move as the points of the surface
    nearest to theirs.
    """

    def kept(faces: IntArray) -> IntArray:
        if not len(faces):
            return faces
        middle = body.points_m[faces].mean(axis=1)
        angle = np.arctan2(middle[:, 1], middle[:, 0]) % (2.0 * np.pi)
        return np.asarray(faces[(angle < _OPEN_RAD[0]) | (angle > _OPEN_RAD[1])])

    points, faces = _cut_faces(outline)
    moved = np.empty((0, 3), dtype=complex)
    if len(points):
        moved = _motion_near(body, points)
    return replace(
        body,
        points_m=np.vstack((body.points_m, points)),
        motion_m=np.vstack((body.motion_m, moved)),
        quadrangles=np.vstack((kept(body.quadrangles), faces + len(body.points_m))),
        triangles=kept(body.triangles),
    )


def _motion_near(body: BodyInSpace, points: FloatArray) -> ComplexArray:
    """Motion of points from those of the surface around, the nearer the more."""
    count = min(_NEAREST, len(body.points_m))
    distance, near = cKDTree(body.points_m).query(points, k=[*range(1, count + 1)])
    size = float(np.ptp(body.points_m, axis=0).max())
    weight = 1.0 / (distance + 1e-6 * size) ** 2
    weight /= weight.sum(axis=1, keepdims=True)
    return np.asarray(np.einsum("pk,pkc->pc", weight, body.motion_m[near]))


def _cut_faces(outline: Silhouette) -> tuple[FloatArray, IntArray]:
    """Cross-section at both ends of the opening, in strips along the axis."""
    step = 2.0 * np.pi / SECTORS
    middles = step * (np.arange(SECTORS) + 0.5)
    gone = np.flatnonzero((middles >= _OPEN_RAD[0]) & (middles <= _OPEN_RAD[1]))
    points: list[FloatArray] = []
    faces: list[tuple[int, int, int, int]] = []
    for theta in (step * gone[0], step * (gone[-1] + 1)):
        for area in outline.areas_m:
            if len(area) != 4:
                continue
            part = np.linspace(0.0, 1.0, _STRIPS + 1)[:, None]
            lower = area[0] + part * (area[1] - area[0])
            upper = area[3] + part * (area[2] - area[3])
            first = 2 * (_STRIPS + 1) * len(points)
            z, r = np.vstack((lower, upper)).T
            points.append(np.column_stack((r * np.cos(theta), r * np.sin(theta), z)))
            above = first + _STRIPS + 1
            faces += [(first + k, first + k + 1, above + k + 1, above + k) for k in range(_STRIPS)]
    if not points:
        return np.empty((0, 3)), np.empty((0, 4), dtype=np.int64)
    return np.vstack(points), np.array(faces, dtype=np.int64)
