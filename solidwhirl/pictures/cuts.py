"""Bodies in space that are open on the side of the eye, so that what is inside shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from solidwhirl.pictures.outlines import Outline

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
IntArray = NDArray[np.int64]
# Points around a body.
SECTORS = 72
# Bodies around others are open over these angles.
_OPEN_RAD = (0.42 * np.pi, 1.16 * np.pi)
# Places along the axis at which bodies are compared, and strips of a cut face.
_PLACES, _STRIPS = 40, 16
# Points of the surface from which the motion of a point inside is taken.
_AROUND = 6


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyInSpace:
    """One body: points (p, 3) [m], their motion (p, 3) [m, complex], faces and lines."""

    body: str
    points_m: FloatArray
    motion_m: ComplexArray
    quadrangles: IntArray
    triangles: IntArray
    lines: IntArray


def encloses(outline: Outline, everything: Sequence[Outline]) -> bool:
    """Return whether another body lies inside a body somewhere along the axis.

    Parameters
    ----------
    outline
        Of the body.
    everything
        Outlines of all bodies.
    """
    for other in everything:
        ends = [area[:, 0] for area in other.areas]
        if other is outline or not ends:
            continue
        low, high = min(e.min() for e in ends), max(e.max() for e in ends)
        for z in np.linspace(low, high, _PLACES):
            own, inside = outline.radii_at(float(z)), other.radii_at(float(z))
            if own is not None and inside is not None and own[0] > 0.0 and inside[1] < own[1]:
                return True
    return False


def opened(body: BodyInSpace, outline: Outline) -> BodyInSpace:
    """Return a body without the faces on the side of the eye, with its cross-section instead.

    Parameters
    ----------
    body
        In space.
    outline
        Its meridian, whose four-sided areas become the cut faces; they move as the points of the
        surface nearest to theirs.
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
    count = min(_AROUND, len(body.points_m))
    distance, near = cKDTree(body.points_m).query(points, k=[*range(1, count + 1)])
    size = float(np.ptp(body.points_m, axis=0).max())
    weight = 1.0 / (distance + 1e-6 * size) ** 2
    weight /= weight.sum(axis=1, keepdims=True)
    return np.asarray(np.einsum("pk,pkc->pc", weight, body.motion_m[near]))


def _cut_faces(outline: Outline) -> tuple[FloatArray, IntArray]:
    """Cross-section at both ends of the opening, in strips along the axis."""
    step = 2.0 * np.pi / SECTORS
    middles = step * (np.arange(SECTORS) + 0.5)
    gone = np.flatnonzero((middles >= _OPEN_RAD[0]) & (middles <= _OPEN_RAD[1]))
    points: list[FloatArray] = []
    faces: list[tuple[int, int, int, int]] = []
    for theta in (step * gone[0], step * (gone[-1] + 1)):
        for area in outline.areas:
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
