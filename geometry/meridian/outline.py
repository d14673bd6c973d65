"""The outline of a subdivision: closed loops, corners and straight runs of curves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from solidwhirl.geometry.meridian.plane_graph import DirectedCurve, PlaneGraph, outline_curves
from solidwhirl.rotordyn.core.arrays import FloatArray

# Largest excess [rad] over a straight angle that is still no corner.
STRAIGHT_ANGLE_RAD = 1e-6


@dataclass(frozen=True, kw_only=True, slots=True)
class Corner:
    """Mark a re-entrant corner of the outline."""

    point: int  #: Point index. A filleted corner's point lies inside the body.
    #: Angle of the material between the two straight edges [rad], above pi
    interior_angle_rad: float
    #: Whether a fillet covers the corner; if not, the stress there is singular
    filleted: bool = False


@dataclass(frozen=True, kw_only=True, slots=True)
class Outline:
    """Hold the successor and predecessor of every curve of an outline that is not pinched."""

    #: Point index to the directed curve, material on its left, that starts or ends there
    leaving: Mapping[int, DirectedCurve]
    arriving: Mapping[int, DirectedCurve]


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class StraightRun:
    """Hold consecutive outline curves that lie on one line, walking away from a corner."""

    curves: tuple[int, ...]
    stations: tuple[int, ...]  #: Point indices, one more than curves; the first is the corner
    direction: FloatArray  #: (2,) Unit vector (z, r) from the corner to the far end
    length_m: float


def outline_of(graph: PlaneGraph) -> Outline:
    """Return the outline (axis included) of a subdivision without pinched vertices."""
    directed = outline_curves(graph)
    return Outline(
        leaving={graph.ends(item)[0]: item for item in directed},
        arriving={graph.ends(item)[1]: item for item in directed},
    )


def reentrant_corners(
    graph: PlaneGraph, outline: Outline, tolerance_m: float
) -> tuple[Corner, ...]:
    """Return the corners whose interior angle exceeds pi, by point index.

    `graph`: subdivision with a straight outline. `tolerance_m`: vertices closer than twice this to
    the line through their neighbours are no corners; they come from snapping. Result: none of
    them filleted.
    """
    found = []
    for point, leaving in sorted(outline.leaving.items()):
        before, after = graph.step(outline.arriving[point]), graph.step(leaving)
        cross = float(before[0] * after[1] - before[1] * after[0])
        angle = math.pi - math.atan2(cross, float(before @ after))
        off_line = abs(cross) / float(np.hypot(*(before + after)) or np.inf)
        bent = angle > math.pi + STRAIGHT_ANGLE_RAD
        if bent and (off_line > 2.0 * tolerance_m or before @ after <= 0.0):
            found.append(Corner(point=point, interior_angle_rad=angle))
    return tuple(found)


def straight_run(
    graph: PlaneGraph, step: Mapping[int, DirectedCurve], corner: int, tolerance_m: float
) -> StraightRun:
    """Return the outline curves from a corner on that lie on one straight line.

    `graph`: subdivision with a straight outline. `step`: `Outline.leaving` to walk along the
    outline, `Outline.arriving` to walk against it. `corner`: point index to start from.
    `tolerance_m`: distance [m] of passed points from the line that still counts as straight,
    twofold.
    """
    curves: list[int] = []
    stations = [corner]
    while True:
        directed = step[stations[-1]]
        first, last = graph.ends(directed)
        following = last if first == stations[-1] else first
        if not _straight(graph.points[[*stations, following]], 2.0 * tolerance_m):
            break
        curves.append(directed[0])
        stations.append(following)
    far = graph.points[stations[-1]] - graph.points[corner]
    length = float(np.hypot(*far))
    return StraightRun(
        curves=tuple(curves), stations=tuple(stations), direction=far / length, length_m=length
    )


def _straight(points: FloatArray, tolerance_m: float) -> bool:
    """Tell whether points go straight from the first to the last one, in order."""
    relative = points - points[0]
    length = float(np.hypot(*relative[-1]))
    if length <= tolerance_m:
        return False
    direction = relative[-1] / length
    across = np.abs(relative[:, 1] * direction[0] - relative[:, 0] * direction[1])
    return bool(across.max() <= tolerance_m and np.all(np.diff(relative @ direction) > 0.0))
