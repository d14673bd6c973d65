"""Blades, and what holes and recesses take away, as solids of the open gmsh model."""

from __future__ import annotations

from dataclasses import dataclass

import gmsh
import numpy as np

from solidwhirl.geometry import Blade, Body, Feature, Flat, Hole, Recess, RingCut, Section, Slot
from solidwhirl.geometry.feature_shapes import (
    blade_section,
    bottom_distance,
    hole_range,
    largest_radius,
)
from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.own.drawing import drawn_length
from solidwhirl.meshing.own.features.cut import blade_corners, root_outline, section_named
from solidwhirl.meshing.records import FloatArray

DimTags = list[tuple[int, int]]


@dataclass(frozen=True, kw_only=True)
class Solids:
    """Volumes of a drawn sector by tag: what each is."""

    face: dict[int, int]  #: Volumes of sections to faces of the subdivision
    blade: dict[int, int]  #: Volumes of blades to features of the body


# Corners of a blade nearer to the end of its section than this part of the chord are at it.
_SAME = 1e-9
# Twist between two of the cross-sections that a smooth blade is drawn through.
_TWIST_DEG = 6.0
# Depth of what is drawn below the surface, and height above it, as a part of the radius; all of it
# is cut off.
_BEYOND = 0.02


def feature_solid(feature: Feature, body: Body, angle_rad: float, unit_m: float) -> DimTags:
    """Draw one of the equal features, with its middle at an angle.

    `unit_m`: length [m] that is drawn as 1. Returned: the part of a blade above the surface of its
    section; what a hole or a slot takes away. Raises MeshingError: it can't be drawn.
    """
    if isinstance(feature, Blade):
        solid = _blade(feature, section_named(body, feature.on), unit_m)
    elif isinstance(feature, Hole):
        solid = _hole(feature, section_named(body, feature.within), unit_m)
    else:
        solid = _recess(feature, section_named(body, feature.within), unit_m)
    gmsh.model.occ.rotate(solid, 0, 0, 0, 0, 0, 1, angle_rad)
    return solid


def _hole(hole: Hole, section: Section, unit_m: float) -> DimTags:
    z0, z1 = (drawn_length(z, unit_m) for z in hole_range(hole, section))
    radius = drawn_length(0.5 * hole.diameter_m, unit_m)
    x = drawn_length(hole.pitch_radius_m, unit_m)
    return [(3, gmsh.model.occ.addCylinder(x, 0.0, z0, 0.0, 0.0, z1 - z0, radius))]


def _recess(recess: Recess, section: Section, unit_m: float) -> DimTags:
    """A box, an extruded outline or a piece of a ring, from the bottom to beyond the surface."""
    occ, outer = gmsh.model.occ, largest_radius(section)
    bottom, top = (
        drawn_length(r, unit_m) for r in (bottom_distance(recess, section), (1.0 + _BEYOND) * outer)
    )
    z0, z1 = (drawn_length(z, unit_m) for z in (recess.start_m, recess.end_m))
    if isinstance(recess, RingCut):
        return _ring_piece(np.radians(recess.width_deg), (bottom, top), (z0, z1))
    if isinstance(recess, Slot) and recess.ends == "round":
        outline = _stadium(bottom, drawn_length(0.5 * recess.width_m, unit_m), (z0, z1))
        return [p for p in occ.extrude([(2, outline)], top - bottom, 0.0, 0.0) if p[0] == 3]
    width = 2.0 * top if isinstance(recess, Flat) else drawn_length(recess.width_m, unit_m)
    return [(3, occ.addBox(bottom, -0.5 * width, z0, top - bottom, width, z1 - z0))]


def _ring_piece(
    width_rad: float, radii: tuple[float, float], axial: tuple[float, float]
) -> DimTags:
    """A ring between two radial walls, about θ = 0."""
    occ = gmsh.model.occ
    (r0, r1), (z0, z1) = radii, axial
    corners = [occ.addPoint(r, 0.0, z) for r, z in ((r0, z0), (r1, z0), (r1, z1), (r0, z1))]
    face = occ.addPlaneSurface([_loop(corners)])
    occ.rotate([(2, face)], 0, 0, 0, 0, 0, 1, -0.5 * width_rad)
    return [p for p in occ.revolve([(2, face)], 0, 0, 0, 0, 0, 1, width_rad) if p[0] == 3]


def _stadium(x: float, half: float, axial: tuple[float, float]) -> int:
    """Face in the plane x between two half circles of a radius and the lines that join them."""
    occ = gmsh.model.occ
    z0, z1 = axial[0] + half, axial[1] - half
    tips = [occ.addPoint(x, 0.0, z) for z in axial]
    centres = [occ.addPoint(x, 0.0, z) for z in (z0, z1)]
    left = [occ.addPoint(x, -half, z) for z in (z0, z1)]
    right = [occ.addPoint(x, half, z) for z in (z0, z1)]
    curves = [
        occ.addLine(*left),
        occ.addCircleArc(left[1], centres[1], tips[1]),
        occ.addCircleArc(tips[1], centres[1], right[1]),
        occ.addLine(right[1], right[0]),
        occ.addCircleArc(right[0], centres[0], tips[0]),
        occ.addCircleArc(tips[0], centres[0], left[0]),
    ]
    return int(occ.addPlaneSurface([occ.addCurveLoop(curves)]))


def _blade(blade: Blade, section: Section, unit_m: float) -> DimTags:
    """A plate from below the surface to its flat tip, less what is below the surface."""
    occ = gmsh.model.occ
    outline = root_outline(blade, section)
    low = float(outline[:, 0].min()) - _BEYOND * largest_radius(section)
    high = largest_radius(section) + blade.length_m
    twist = abs(blade.stagger_deg[1] - blade.stagger_deg[0])
    x = np.linspace(low, high, 2 + int(np.ceil(twist / _TWIST_DEG)))
    corners = blade_corners(blade, section, x)
    if blade.stagger_deg == (0.0, 0.0):
        corners[0] = _within(blade, section, corners[0])
    chord, thickness, _ = blade_section(blade, section, x)
    if min(chord.min(), thickness.min()) <= 0.0:
        raise MeshingError(f"blades {blade.name!r}: chord or thickness vanish below the root")
    points = [
        [occ.addPoint(*(drawn_length(float(v), unit_m) for v in (r, *yz))) for yz in of]
        for r, of in zip(x, corners, strict=True)
    ]
    if twist == 0.0:
        solid = [(3, _hexahedron(points))]
    else:
        loops = [_loop(of) for of in points]
        solid = occ.addThruSections(loops, makeSolid=True)
    over = max(section.start_m - outline[:, 2].min(), outline[:, 2].max() - section.end_m, 0.0)
    above = occ.cut(solid, _core(section, over + _BEYOND * blade.chord_m[0], unit_m))[0]
    if not above:
        raise MeshingError(f"blades {blade.name!r}: nothing of them is above the surface")
    # what reaches through a thin section into its bore is not the blade
    return [max(above, key=lambda pair: occ.getCenterOfMass(*pair)[0])]


def _within(blade: Blade, section: Section, corners: FloatArray) -> FloatArray:
    """Corners at the lower end of what is drawn.

    A blade as wide as its section that narrows to the tip would be a little wider than it below the
    root; a corner that is within the axial range at the root stays within.
    """
    root = blade_corners(blade, section, largest_radius(section))[:, 1]
    near = _SAME * blade.chord_m[0]
    inside = (root > section.start_m - near) & (root < section.end_m + near)
    z = np.clip(corners[:, 1], section.start_m, section.end_m)
    return np.column_stack([corners[:, 0], np.where(inside, z, corners[:, 1])])


def _loop(points: list[int]) -> int:
    lines = [
        gmsh.model.occ.addLine(a, b) for a, b in zip(points, points[1:] + points[:1], strict=True)
    ]
    return int(gmsh.model.occ.addCurveLoop(lines))


def _hexahedron(corners: list[list[int]]) -> int:
    """Solid between two quadrilaterals with plane sides."""
    occ = gmsh.model.occ
    low, high = corners
    rings = [[occ.addLine(of[k], of[(k + 1) % 4]) for k in range(4)] for of in corners]
    up = [occ.addLine(a, b) for a, b in zip(low, high, strict=True)]
    loops = rings + [[rings[0][k], up[(k + 1) % 4], rings[1][k], up[k]] for k in range(4)]
    faces = [occ.addPlaneSurface([occ.addCurveLoop(loop)]) for loop in loops]
    return int(occ.addVolume([occ.addSurfaceLoop(faces)]))


def _core(section: Section, beyond: float, unit_m: float) -> DimTags:
    """Everything below the outer surface of a section, which goes on straight at its ends."""
    (r0, r1), width = section.outer_radius_m, section.end_m - section.start_m
    more = (r1 - r0) / width * beyond
    z, dz, r0, r1 = (
        drawn_length(v, unit_m)
        for v in (section.start_m - beyond, width + 2.0 * beyond, r0 - more, r1 + more)
    )
    occ = gmsh.model.occ
    if r0 == r1:
        return [(3, occ.addCylinder(0, 0, z, 0, 0, dz, r0))]
    return [(3, occ.addCone(0, 0, z, 0, 0, dz, max(r0, 0.0), max(r1, 0.0)))]
