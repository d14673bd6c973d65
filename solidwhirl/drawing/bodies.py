"""Bodies in the plane of a drawing: sections, outlines, places of nodes, rigid disks."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from solidwhirl import geometry
from solidwhirl.files.surface_files import shown_surface
from solidwhirl.geometry import Body, Curve, Interface, Subdivision
from solidwhirl.model.bodies import scene_materials
from solidwhirl.pipeline.run import Results
from solidwhirl.rotordyn import Superelement
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.superelement.surface import Surface, outline_chains
from solidwhirl.scene.records import Scene

# Points of an arc, and places along the axis at which the reach of a solid is looked for.
_ARC_POINTS, _PLACES = 12, 240


class Part(NamedTuple):
    """A section of a body: places along z and radii at both ends, m, its material and mass, kg."""

    name: str
    start_m: float
    end_m: float
    inner_m: tuple[float, float]
    outer_m: tuple[float, float]
    material: str
    mass_kg: float

    @property
    def corners_m(self) -> FloatArray:
        """(z, r) along the inner radius and back along the outer one, shape (4, 2)."""
        z = (self.start_m, self.end_m, self.end_m, self.start_m)
        return np.column_stack([z, [*self.inner_m, *self.outer_m[::-1]]])


@dataclass(frozen=True, kw_only=True, eq=False)
class FeatureSet:
    """Blades, holes, ... of a body: how many, what is seen of one from the side, mass, kg.

    `area_m`: (z, r) of its outline, shape (k, 2). What is cut out has a negative mass. `side`: of
    what stands in one place, whether it is above the axis (1) or below it (-1); 0: on both sides.
    """

    name: str
    kind: str
    count: int
    section: str
    material: str
    mass_kg: float
    area_m: FloatArray
    side: int = 0

    @property
    def text(self) -> str:
        """Name, number and kind."""
        return f"{self.name}, {self.count} {self.kind}, {self.material}"


class RigidDisk(NamedTuple):
    """A rigid disk, seen as the uniform thin one with its polar inertia, m r²/2.

    Its place along z, the radius, and the interface that carries it, "" for one of a beam.
    """

    name: str
    at_m: float
    radius_m: float
    interface: str = ""


@dataclass(frozen=True, kw_only=True, eq=False)
class Silhouette:
    """A body in the plane of the drawing, z to the right, x or r upwards."""

    name: str
    #: "cut": areas above the axis, cut by a plane through it; "view": the whole body seen from the
    #: side; "none": nothing but its nodes is known
    kind: str
    #: Polygons (k, 2) of (z, height)
    areas_m: tuple[FloatArray, ...]
    #: (z, height) of the master nodes by interface
    nodes_m: Mapping[str, tuple[float, float]]
    #: Radius at which what is fixed to an interface is drawn
    seats_m: Mapping[str, float]
    disks: tuple[RigidDisk, ...]
    #: (z, height) of the centre of gravity
    center_m: tuple[float, float]
    #: Speed of the body over that of the reference shaft
    speed_ratio: float
    #: Outline (k, 2) in (z, r) of a profile with its fillets
    lines_m: tuple[FloatArray, ...] = ()
    features: tuple[FeatureSet, ...] = ()
    #: Of each area, what it is and the name of its material; empty where neither is known
    labels: tuple[str, ...] = ()
    materials: tuple[str, ...] = ()

    def radii_at(self, axial_m: float) -> tuple[float, float] | None:
        """Smallest and largest height of the areas at a place, None beside the body."""
        found: list[float] = []
        for area in self.areas_m:
            closed = np.vstack((area, area[:1]))
            for (z0, r0), (z1, r1) in pairwise(closed):
                if not min(z0, z1) - 1e-9 <= axial_m <= max(z0, z1) + 1e-9:
                    continue
                part = 0.5 if z1 == z0 else (axial_m - z0) / (z1 - z0)
                found += [r0, r1] if z1 == z0 else [r0 + part * (r1 - r0)]
        return (float(min(found)), float(max(found))) if found else None

    @property
    def reach_m(self) -> float:
        """Largest height, that of the rigid disks left aside."""
        return max((float(np.abs(area[:, 1]).max()) for area in self.areas_m), default=0.0)


def silhouettes_of(results: Results) -> tuple[Silhouette, ...]:
    """Return what is seen of every body of a run, in the order of the scene."""
    return silhouettes(results.scene, results.elements, results.geometry)


def silhouettes(
    scene: Scene, elements: Mapping[str, Superelement], profiles: Mapping[str, Body]
) -> tuple[Silhouette, ...]:
    """Return what is seen of every body; `profiles`: geometry of those that are drawn by one."""
    return tuple(
        _silhouette(scene, name, elements[name], profiles.get(name))
        for name in scene.speed_ratios()
    )


def _silhouette(scene: Scene, name: str, element: Superelement, profile: Body | None) -> Silhouette:
    nodes = {n.name: (float(n.position_m[2]), float(n.position_m[0])) for n in element.interfaces}
    parts = profile_parts(profile) if profile is not None else beam_parts(scene, name)
    areas = [p.corners_m for p in parts]
    labels = [f"{name}: {p.name}, {p.material}" for p in parts]
    materials = [p.material for p in parts]
    lines: tuple[FloatArray, ...] = ()
    kind = "cut"
    if profile is not None:
        drawn = geometry.subdivide(profile)
        lines = tuple(_line(drawn, drawn.curves[k]) for k in drawn.boundary)
        for face in drawn.faces[len(drawn.faces) - len(drawn.fillet_arcs) :]:
            pieces = [_line(drawn, drawn.curves[c])[::sense][:-1] for c, sense in face.loop]
            areas.append(np.vstack(pieces))
            materials.append(drawn.materials[face.material].name)
            labels.append(f"{name}: fillet, {materials[-1]}")
    elif not parts:
        kind, areas = areas_of_surface(element)
    center = np.asarray(element.center_of_gravity_m, dtype=float)
    found = Silhouette(
        name=name,
        kind=kind,
        areas_m=tuple(areas),
        lines_m=lines,
        features=() if profile is None else profile_features(profile),
        nodes_m=nodes,
        seats_m={},
        disks=disks_of(scene, name, element),
        center_m=(float(center[2]), float(center[0])),
        speed_ratio=scene.speed_ratio(name),
        labels=tuple(labels),
        materials=tuple(materials),
    )
    if profile is not None:
        seats = {i.name: _seat(profile, i) for i in profile.interfaces}
    else:
        seats = {n: (found.radii_at(z) or (0.0, 0.0))[1] for n, (z, _) in nodes.items()}
    return replace(found, seats_m=seats)


def profile_parts(body: Body) -> tuple[Part, ...]:
    """Return the sections of a profile, without its fillets."""
    return tuple(
        Part(s.name, s.start_m, s.end_m, s.inner_radius_m, s.outer_radius_m, s.material.name,
             geometry.section_mass_properties(s).mass_kg)
        for s in body.sections
    )  # fmt: skip


def profile_features(body: Body) -> tuple[FeatureSet, ...]:
    """Return the blades, holes, slots and other features of a profile."""
    sections = {s.name: s for s in body.sections}
    return tuple(
        FeatureSet(
            name=f.name,
            kind=f.kind,
            count=len(geometry.places_rad(f)),
            section=f.section,
            material=geometry.feature_material(f, sections[f.section]).name,
            mass_kg=geometry.feature_mass_properties(f, sections[f.section]).mass_kg,
            area_m=geometry.side_view(f, sections[f.section]),
            side=0 if f.count > 1 else (1 if np.cos(np.radians(f.angle_deg)) >= 0.0 else -1),
        )
        for f in body.features
    )


def beam_parts(scene: Scene, name: str) -> tuple[Part, ...]:
    """Return the sections of a beam of a scene, numbered from 1; none of another body."""
    beam = scene.beams.get(name)
    if beam is None:
        return ()
    density = scene_materials(scene)[beam.material].density_kg_per_m3
    places = zip(pairwise(beam.stations_m), *beam.section_radii_m, strict=True)
    return tuple(
        Part(f"section {k}", a, b, (low, low), (high, high), beam.material,
             math.pi * (high - low) * (high + low) * (b - a) * density)
        for k, ((a, b), high, low) in enumerate(places, start=1)
    )  # fmt: skip


def disks_of(scene: Scene, name: str, element: Superelement) -> tuple[RigidDisk, ...]:
    """Return the rigid disks of a body that have mass and polar inertia.

    Those of a body that came as a superelement are told by its provenance.
    """
    at = {n.name: float(n.position_m[2]) for n in element.interfaces}
    body = scene.finite_element_bodies().get(name)
    if name in scene.beams:
        rows = [
            (d.name, float(d.at_m), d.mass_kg, d.polar_inertia_kg_m2, "")
            for d in scene.beams[name].disks
        ]
    elif body is not None:
        rows = [
            (d.name, at[d.interface] + d.offset_m, d.mass_kg, d.polar_inertia_kg_m2, d.interface)
            for d in body.rigid_disks
        ]
    else:
        rows = [
            (str(d.get("name", d["interface"])), at[d["interface"]] + float(d["offset_m"]),
             float(d["mass_kg"]), float(d["polar_kg_m2"]), d["interface"])
            for d in element.provenance.get("rigid_disks", ())
        ]  # fmt: skip
    return tuple(
        RigidDisk(label, place, math.sqrt(2.0 * polar / mass), interface)
        for label, place, mass, polar, interface in rows
        if mass > 0.0 and polar > 0.0
    )


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


def _seat(body: Body, interface: Interface) -> float:
    """Radius of what an interface covers: the outer one, but of an inner surface its own."""
    low, high = interface.start_m, interface.end_m
    found = [
        s.radii_at(z)
        for s in body.sections
        if s.start_m <= high and s.end_m >= low
        for z in (max(low, s.start_m), min(high, s.end_m))
    ]
    if not found:
        return 0.0
    radii = np.array(found)
    least, most = interface.radius_m or (0.0, np.inf)
    if interface.kind == "inner":
        return float(np.clip(radii[:, 0].max(), least, most))
    within = radii[radii[:, 0] <= most]
    return float(np.clip((within if len(within) else radii)[:, 1].max(), least, most))


def areas_of_surface(element: Superelement) -> tuple[str, list[FloatArray]]:
    """Return kind and areas of a body that came as matrices or as a mesh; none of a rigid one."""
    surface = shown_surface(element)
    if surface is not None and surface.kind == "meridian":
        return "cut", [_between_loops(surface)]
    if surface is not None:
        return "view", [_seen_from_the_side(surface)]
    points = element.recovery_points_m
    radius = np.hypot(points[:, 0], points[:, 1])
    if not len(points) or np.ptp(points[:, 2]) == 0.0 or not radius.any():
        return "none", []
    # nothing tells what lies between points: from the smallest to the largest radius
    count = min(_PLACES, max(2, len(points) // 6))
    edges = np.linspace(points[:, 2].min(), points[:, 2].max(), count + 1)
    own = np.clip(np.digitize(points[:, 2], edges) - 1, 0, count - 1)
    filled = np.unique(own)
    middle = 0.5 * (edges[filled] + edges[filled + 1])
    middle[[0, -1]] = edges[[0, -1]]
    low, high = (np.array([f(radius[own == k]) for k in filled]) for f in (np.min, np.max))
    lower, upper = np.column_stack([middle, low]), np.column_stack([middle, high])
    return "cut", [np.vstack([lower, upper[::-1]])]


def _between_loops(surface: Surface) -> FloatArray:
    """Cross-section of a meridian: its outline, cavities joined to it by a cut."""
    loops: Sequence[FloatArray] = [surface.points_m[k] for k in outline_chains(surface.cells)]
    outer, *inner = sorted(loops, key=lambda loop: -float(np.ptp(loop, axis=0).prod()))
    return np.vstack([outer, *(np.vstack([loop, outer[-1:]]) for loop in inner)])


def _seen_from_the_side(surface: Surface) -> FloatArray:
    """Outline of a solid seen along y: least and largest x by slices of z."""
    faces = surface.faces(0)
    corners = faces.points_m[faces.triangles]
    x, z = corners[:, :, 0], corners[:, :, 2]
    places = np.linspace(z.min(), z.max(), _PLACES)
    first = np.searchsorted(places, z.min(axis=1), side="right") - 1
    last = np.searchsorted(places, z.max(axis=1), side="left")
    least, most = np.full(_PLACES, np.inf), np.full(_PLACES, -np.inf)
    for a, b, lower, upper in zip(first, last, x.min(axis=1), x.max(axis=1), strict=True):
        span = slice(max(int(a), 0), min(int(b), _PLACES - 1) + 1)
        least[span] = np.minimum(least[span], lower)
        most[span] = np.maximum(most[span], upper)
    known = most >= least
    upper = np.column_stack([places[known], most[known]])
    lower = np.column_stack([places[known], least[known]])
    return np.vstack([upper, lower[::-1]])
