"""Element sizes of what is meshed: those of its meridian, and those that its features ask for."""

from __future__ import annotations

import gmsh
import numpy as np
import scipy

from solidwhirl.geometry import (
    Blade,
    Body,
    Hole,
    Recess,
    RingCut,
    Section,
    Slot,
    Subdivision,
    places_rad,
)
from solidwhirl.geometry.feature_shapes import bottom_distance, hole_range, largest_radius
from solidwhirl.meshing.own import drawing as drawn
from solidwhirl.meshing.own.features.cut import Cut, section_named
from solidwhirl.meshing.own.features.solids import Solids
from solidwhirl.meshing.own.grading import AROUND, edge_at_hole, face_bounds, graded_places
from solidwhirl.meshing.records import FloatArray, LocalSize, MeshSize
from solidwhirl.rotordyn.core.arrays import BoolArray

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
    """Set gmsh's size field of what is drawn.

    `local`: sizes over an earlier mesh of it, in place of all others. Without: blades have
    `size.through_thickness` elements across them; re-entrant edges of blades and recesses are
    graded like the corners of the meridian. Either way `AROUND` is kept. `unit_m`: length [m] that
    is drawn as 1.
    """
    # gmsh takes the smallest of this and of the size field
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", AROUND)
    if local is not None:
        drawn.set_smallest(drawn.local_sizes(local, size, unit_m))
        return
    places = graded_places(body, subdivision, size)
    plane = drawn.graded_fields(places, size.growth, size, 2, unit_m)
    bounds = face_bounds(body, subdivision, size, 3)
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
    """Curves with the element edge [m] asked for there: roots, bottoms of recesses, holes."""
    tags = np.array([tag for _, tag in gmsh.model.getEntities(1)])
    middles = unit_m * np.array([_middle(tag) for tag in tags])
    angle = np.arctan2(middles[:, 1], middles[:, 0])
    near = _ON * float(np.abs(middles).max())
    off = np.hypot(middles[:, 0], middles[:, 1])
    inner = np.minimum(np.abs(angle), np.abs(angle - cut.swept_rad)) * off > near
    reentrant, out = inner & np.isin(tags, _root_curves(solids)), []
    for feature in body.features:
        if isinstance(feature, Blade):
            continue
        own = _own_frame(feature, middles, cut)
        section = section_named(body, feature.within)
        if isinstance(feature, Hole):
            wall = _on_wall(feature, section, own, near)
            out.append((tags[wall], edge_at_hole(feature, size)))
            reentrant |= inner & wall & _at_blind_end(feature, section, own, near)
        else:
            reentrant |= inner & _inside_edges(feature, section, own, near)
    out.append((tags[reentrant], size.corner_size_m))
    return [([int(t) for t in on], edge) for on, edge in out if len(on)]


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


def _own_frame(feature: Hole | Recess, points: FloatArray, cut: Cut) -> FloatArray:
    """Points turned to the frame of the nearest of the equal features, whose middle is at θ = 0."""
    middles = places_rad(feature, cut.angle_rad)
    angle = np.arctan2(points[:, 1], points[:, 0])
    near = scipy.spatial.cKDTree(_unit_vectors(middles)).query(_unit_vectors(angle))[1]
    angle = angle - middles[near]
    r = np.hypot(points[:, 0], points[:, 1])
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), points[:, 2]])


def _unit_vectors(angle: FloatArray) -> FloatArray:
    return np.column_stack([np.cos(angle), np.sin(angle)])


def _inside_edges(recess: Recess, section: Section, points: FloatArray, near: float) -> BoolArray:
    """Whether points lie on an edge of a recess where two of its walls meet."""
    x, y, z = points.T
    r, bottom = np.hypot(x, y), bottom_distance(recess, section)
    # how far they are outside each wall; an end of the recess is one only within the section
    outside = [bottom - (r if isinstance(recess, RingCut) else x)]
    ends = [recess.start_m - z, z - recess.end_m]
    if isinstance(recess, RingCut):
        outside.append(r * (np.abs(np.arctan2(y, x)) - 0.5 * np.radians(recess.width_deg)))
    elif isinstance(recess, Slot) and recess.ends == "round":
        half = 0.5 * recess.width_m
        beyond = np.maximum(np.maximum(ends[0], ends[1]) + half, 0.0)
        outside.append(np.hypot(y, beyond) - half)
        ends = []
    elif isinstance(recess, Slot):
        outside.append(np.abs(y) - 0.5 * recess.width_m)
    inside = (recess.start_m > section.start_m, recess.end_m < section.end_m)
    closed = [e for e, own in zip(ends, inside, strict=False) if own]
    walls = np.array([*outside, *closed])
    within = np.all(np.array([*outside, *ends]) < near, axis=0)
    surface = r > largest_radius(section) - near
    return np.asarray(within & ~surface & ((np.abs(walls) < near).sum(axis=0) >= 2))


def _on_wall(hole: Hole, section: Section, points: FloatArray, near: float) -> BoolArray:
    """Whether points lie on the wall of a hole."""
    x, y, z = points.T
    off = np.abs(np.hypot(x - hole.pitch_radius_m, y) - 0.5 * hole.diameter_m)
    start, end = hole_range(hole, section)
    return np.asarray((off < near) & (z > start - near) & (z < end + near))


def _at_blind_end(hole: Hole, section: Section, points: FloatArray, near: float) -> BoolArray:
    """Whether points are at the height of the bottom of a blind hole."""
    ends = zip(hole_range(hole, section), (section.start_m, section.end_m), strict=True)
    blind = [own for own, end in ends if abs(own - end) > near]
    off = [np.abs(points[:, 2] - e) for e in blind]
    return np.asarray(np.min([np.full(len(points), np.inf), *off], axis=0) < near)


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
