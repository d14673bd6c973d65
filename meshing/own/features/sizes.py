"""Element sizes of a sector: those of its meridian, and those that its features ask for."""

from __future__ import annotations

import gmsh
import numpy as np

from solidwhirl.geometry import Blade, Body, Hole, Section, Slot, Subdivision
from solidwhirl.meshing.own import drawing as drawn
from solidwhirl.meshing.own.features.cut import Cut, section_named
from solidwhirl.meshing.own.features.solids import Solids, slot_ranges
from solidwhirl.meshing.records import FloatArray, LocalSize, MeshSize
from solidwhirl.rotordyn.core.arrays import BoolArray

#: Fewest elements around any curved surface. An element with two faces on one is folded unless its
#: edges are made straight: at 16 that takes 1 per mille of a shaft's mass, at 24 6 millionths.
AROUND = 24
# Points along a graded curve, from which distances are measured: at most so many.
_MOST_SAMPLES = 400
# What lies nearer to a plane than this part of the body's size lies in it.
_ON = 1e-6


def set_sizes(
    body: Body,
    subdivision: Subdivision,
    size: MeshSize,
    local: LocalSize | None,
    solids: Solids,
    cut: Cut,
    unit_m: float,
) -> None:
    """Set gmsh's size field of a drawn sector.

    `local`: sizes over an earlier mesh of the sector, in place of all others. Without: features
    have `size.through_thickness` elements across blades; the re-entrant edges of blades and slots
    are graded like the corners of the meridian. Either way `AROUND` is kept. `unit_m`: length [m]
    that is drawn as 1.
    """
    # gmsh takes the smallest of this and of the size field
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", AROUND)
    if local is not None:
        drawn.set_smallest(drawn.local_sizes(local, size, unit_m))
        return
    places = drawn.graded_places(body, subdivision, size)
    plane = drawn.graded_fields(places, size.growth, size, 2, unit_m)
    bounds = drawn.face_bounds(body, subdivision, size, 3)
    fields = drawn.bounded(
        [(bounds[face], [tag]) for tag, face in solids.face.items()], "VolumesList", unit_m
    )
    if plane:
        fields.append(_revolved(drawn.smallest(plane)))
    fields += drawn.bounded(_blade_bounds(body, size, solids), "VolumesList", unit_m)
    for curves, edge in _graded_curves(body, size, solids, cut, unit_m):
        fields.append(_from_curves(curves, edge / unit_m, size.size_m / unit_m, size.growth))
    drawn.set_smallest(fields)


def _revolved(plane: int) -> int:
    """Size field of the meridian, which is drawn at y = 0, for all angles."""
    field = gmsh.model.mesh.field
    tag = field.add("Param")
    field.setNumber(tag, "InField", plane)
    for name, value in (("FX", "Sqrt(x^2+y^2)"), ("FY", "0"), ("FZ", "z")):
        field.setString(tag, name, value)
    return int(tag)


def _blade_bounds(body: Body, size: MeshSize, solids: Solids) -> list[tuple[float, list[int]]]:
    """Largest element edge [m] in blades, by the same rule as in sections."""
    out = []
    for tag, index in solids.blade.items():
        blade = body.features[index]
        assert isinstance(blade, Blade)
        thin = min(0.5 * sum(blade.thickness_m), 0.5 * sum(blade.chord_m), blade.length_m)
        out.append((min(size.size_m, 1.5 * thin / size.through_thickness), [tag]))
    return out


def _graded_curves(
    body: Body, size: MeshSize, solids: Solids, cut: Cut, unit_m: float
) -> list[tuple[list[int], float]]:
    """Curves with the element edge [m] asked for there: roots, bottoms of slots, holes."""
    tags = np.array([tag for _, tag in gmsh.model.getEntities(1)])
    middles = unit_m * np.array([_middle(tag) for tag in tags])
    angle = np.arctan2(middles[:, 1], middles[:, 0])
    near = _ON * float(np.abs(middles).max())
    off = np.hypot(middles[:, 0], middles[:, 1])
    inner = np.minimum(np.abs(angle), np.abs(angle - cut.width_rad)) * off > near
    reentrant, out = inner & np.isin(tags, _root_curves(solids)), []
    for feature in body.features:
        if isinstance(feature, Blade):
            continue
        own = _own_frame(feature, middles, cut)
        section = section_named(body, feature.within)
        if isinstance(feature, Slot):
            reentrant |= inner & _inside_edges(feature, section, own, near)
        else:
            out.append((tags[_on_wall(feature, section, own, near)], edge_at_hole(feature, size)))
    out.append((tags[reentrant], size.corner_size_m))
    return [([int(t) for t in on], edge) for on, edge in out if len(on)]


def edge_at_hole(hole: Hole, size: MeshSize) -> float:
    """Element edge at the wall of a hole [m]."""
    return min(size.size_m, np.pi * hole.diameter_m / AROUND)


def _root_curves(solids: Solids) -> list[int]:
    """Curves around the faces that blades and sections share."""
    out: set[int] = set()
    for _, face in gmsh.model.getEntities(2):
        volumes, curves = gmsh.model.getAdjacencies(2, face)
        if any(v in solids.blade for v in volumes) and any(v in solids.face for v in volumes):
            out.update(int(c) for c in curves)
    return sorted(out)


def _middle(curve: int) -> FloatArray:
    low, high = gmsh.model.getParametrizationBounds(1, curve)
    return np.array(gmsh.model.getValue(1, curve, [0.5 * (low[0] + high[0])]))


def _own_frame(feature: Hole | Slot, points: FloatArray, cut: Cut) -> FloatArray:
    """Points turned to the frame of the nearest of the equal features, whose middle is at θ = 0."""
    pitch = 2.0 * np.pi / feature.count
    angle = np.arctan2(points[:, 1], points[:, 0])
    angle -= np.radians(feature.angle_deg) - cut.angle_rad
    angle -= pitch * np.round(angle / pitch)
    r = np.hypot(points[:, 0], points[:, 1])
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), points[:, 2]])


def _inside_edges(slot: Slot, section: Section, points: FloatArray, near: float) -> BoolArray:
    """Whether points lie on an edge of a slot where two of its walls meet."""
    bottom, outer = slot_ranges(slot, section)
    x, y, z = points.T
    walls = np.array([np.abs(x - bottom) < near, np.abs(np.abs(y) - 0.5 * slot.width_m) < near])
    # an end of the slot is a wall only within the section
    ends = [e for e in (slot.start_m, slot.end_m) if section.start_m < e < section.end_m]
    walls = np.vstack([walls, *(np.abs(z - e)[None] < near for e in ends)])
    within = (np.abs(y) < 0.5 * slot.width_m + near) & (x > bottom - near)
    within &= (z > slot.start_m - near) & (z < slot.end_m + near)
    surface = np.hypot(x, y) > outer - near
    return np.asarray(within & ~surface & (walls.sum(axis=0) >= 2))


def _on_wall(hole: Hole, section: Section, points: FloatArray, near: float) -> BoolArray:
    """Whether points lie on the wall of a hole."""
    x, y, z = points.T
    off = np.abs(np.hypot(x - hole.pitch_radius_m, y) - 0.5 * hole.diameter_m)
    return np.asarray((off < near) & (z > section.start_m - near) & (z < section.end_m + near))


def _from_curves(curves: list[int], edge: float, largest: float, growth: float) -> int:
    """Size field that grows with the distance from curves; lengths as drawn."""
    field = gmsh.model.mesh.field
    longest = max(gmsh.model.occ.getMass(1, c) for c in curves)
    distance = field.add("Distance")
    field.setNumbers(distance, "CurvesList", curves)
    field.setNumber(distance, "Sampling", int(np.clip(2.0 * longest / edge, 20, _MOST_SAMPLES)))
    tag = field.add("Threshold")
    settings = {"InField": distance, "SizeMin": edge, "SizeMax": max(largest, 1.001 * edge)}
    settings |= {"DistMin": 0.0, "DistMax": (settings["SizeMax"] - edge) / growth}
    for name, value in settings.items():
        field.setNumber(tag, name, value)
    return int(tag)
