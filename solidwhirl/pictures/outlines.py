"""Meridians of all bodies of a scene as polygons and lines in (z, r), for drawings."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from solidwhirl.bodies import build_bodies
from solidwhirl.body_outlines import beam_areas, disks_of, profile_areas
from solidwhirl.geometry import Body, Curve, Subdivision, subdivide
from solidwhirl.pipeline import Results
from solidwhirl.rotordyn import Superelement
from solidwhirl.scene import Scene
from solidwhirl.surface_files import shown_surface

FloatArray = NDArray[np.float64]
# Points of an arc, and places along the axis at which the reach of a solid is looked for.
_ARC_POINTS, _PLACES = 12, 120


@dataclass(frozen=True, kw_only=True, eq=False)
class DiskOutline:
    """A rigid disk: where it is, and the radius of the uniform thin disk with its inertia."""

    name: str
    axial_m: float
    radius_m: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Outline:
    """The meridian of one body.

    Attributes
    ----------
    body
        Its name.
    speed_ratio
        Its speed over that of the reference shaft.
    areas
        Closed polygons (k, 2) in (z, r), m, that together are its cross-section; empty for a
        body without a shape.
    lines
        Lines (k, 2) in (z, r), m: its outline.
    interfaces
        Place along the axis of each interface, m.
    disks
        Its rigid disks.
    """

    body: str
    speed_ratio: float
    areas: tuple[FloatArray, ...]
    lines: tuple[FloatArray, ...]
    interfaces: dict[str, float]
    disks: tuple[DiskOutline, ...]

    def radii_at(self, axial_m: float) -> tuple[float, float] | None:
        """Smallest and largest radius of the cross-section at a place, None beside the body."""
        found: list[float] = []
        for area in self.areas:
            closed = np.vstack((area, area[:1]))
            for (z0, r0), (z1, r1) in pairwise(closed):
                low, high = min(z0, z1), max(z0, z1)
                if not low - 1e-9 <= axial_m <= high + 1e-9:
                    continue
                part = 0.5 if z1 == z0 else (axial_m - z0) / (z1 - z0)
                found += [r0, r1] if z1 == z0 else [r0 + part * (r1 - r0)]
        return (float(min(found)), float(max(found))) if found else None

    @property
    def reach_m(self) -> float:
        """Largest radius, that of the rigid disks left aside."""
        return max((float(area[:, 1].max()) for area in self.areas), default=0.0)


def outlines_of(results: Results) -> tuple[Outline, ...]:
    """Return the meridians of all bodies of a run, in the order of its engine.

    Parameters
    ----------
    results
        The run.
    """
    scene = results.scene
    profiles = build_bodies(scene)
    ratios = scene.speed_ratios()
    found = []
    for name, element in results.elements.items():
        if name in profiles:
            areas, lines = _of_profile(profiles[name])
        elif name in scene.beams:
            areas = beam_areas(scene.beams[name])
            lines = tuple(np.vstack((a, a[:1])) for a in areas)
        else:
            areas, lines = _of_surface(element)
        places = {node.name: float(node.position_m[2]) for node in element.interfaces}
        found.append(
            Outline(
                body=name,
                speed_ratio=ratios[name],
                areas=areas,
                lines=lines,
                interfaces=places,
                disks=_disks(scene, name, places),
            )
        )
    return tuple(found)


def _of_profile(body: Body) -> tuple[tuple[FloatArray, ...], tuple[FloatArray, ...]]:
    """Sections as areas, and the outline with its fillets."""
    drawn = subdivide(body)
    lines = tuple(_line(drawn, drawn.curves[k]) for k in drawn.boundary)
    return (*profile_areas(body), *_fillets(drawn)), lines


def _fillets(drawn: Subdivision) -> list[FloatArray]:
    """Areas of the faces that fillets add, which come after those of the sections."""
    out = []
    for face in drawn.faces[len(drawn.faces) - len(drawn.fillet_arcs) :]:
        pieces = []
        for curve, sense in face.loop:
            line = _line(drawn, drawn.curves[curve])
            pieces.append((line if sense > 0 else line[::-1])[:-1])
        out.append(np.vstack(pieces))
    return out


def _line(drawn: Subdivision, curve: Curve) -> FloatArray:
    """Points of a straight line or an arc."""
    start, end = drawn.points[curve.start], drawn.points[curve.end]
    if curve.centre is None:
        return np.array([start, end])
    centre = drawn.points[curve.centre]
    first, last = (np.arctan2(*(point - centre)[::-1]) for point in (start, end))
    turn = (last - first + np.pi) % (2.0 * np.pi) - np.pi
    angle = first + turn * np.linspace(0.0, 1.0, _ARC_POINTS)
    radius = float(np.hypot(*(start - centre)))
    return np.asarray(centre + radius * np.column_stack((np.cos(angle), np.sin(angle))))


def _of_surface(
    element: Superelement,
) -> tuple[tuple[FloatArray, ...], tuple[FloatArray, ...]]:
    """Outline of a body that came as matrices or as a mesh; none of a rigid body."""
    surface = shown_surface(element)
    if surface is not None and surface.kind == "meridian":
        lines = tuple(surface.points_m[edge] for edge in surface.cells)
        return (_reach(surface.points_m),), lines
    points = element.recovery_points_m if surface is None else surface.points_m
    radius = np.hypot(points[:, 0], points[:, 1])
    if not len(points) or np.ptp(points[:, 2]) == 0.0 or not radius.any():
        return (), ()
    area = _reach(np.column_stack((points[:, 2], radius)))
    return (area,), (np.vstack((area, area[:1])),)


def _reach(points: FloatArray) -> FloatArray:
    """Polygon between the smallest and the largest radius of points (z, r) along the axis."""
    z, r = points.T
    edges = np.linspace(z.min(), z.max(), min(_PLACES, max(2, len(z) // 6)) + 1)
    own = np.clip(np.digitize(z, edges) - 1, 0, len(edges) - 2)
    filled = np.unique(own)
    middle = 0.5 * (edges[filled] + edges[filled + 1])
    middle[0], middle[-1] = z.min(), z.max()
    low = np.array([r[own == k].min() for k in filled])
    high = np.array([r[own == k].max() for k in filled])
    return np.vstack((np.column_stack((middle, low)), np.column_stack((middle, high))[::-1]))


def _disks(scene: Scene, name: str, places: dict[str, float]) -> tuple[DiskOutline, ...]:
    """Rigid disks of a body; of a uniform thin disk the polar inertia is m r²/2."""
    return tuple(
        DiskOutline(
            name=disk.name,
            axial_m=disk.at_m,
            radius_m=float(np.sqrt(2.0 * disk.polar_inertia_kg_m2 / disk.mass_kg)),
        )
        for disk in disks_of(scene, name, places)
        if disk.polar_inertia_kg_m2 > 0.0
    )
