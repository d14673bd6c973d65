"""What is seen of the bodies in the plane of the drawing: areas, radii at a place, disks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solidwhirl.bodies import build_bodies
from solidwhirl.body_outlines import beam_areas, disks_of, profile_areas
from solidwhirl.geometry import Body, Interface
from solidwhirl.page.materials import Part, beam_parts, profile_parts
from solidwhirl.pipeline import Results
from solidwhirl.rotordyn import Superelement
from solidwhirl.scene import Scene
from solidwhirl.scene_joints import BeamSpec

FloatArray = NDArray[np.float64]
# Places along z at which the outline of a body of any shape is sought.
_SLICES = 240


@dataclass(frozen=True, kw_only=True)
class Disk:
    """A rigid disk, drawn as the thin ring that has its polar inertia.

    Attributes
    ----------
    name
        Of the disk.
    at_m
        Place of its centre of gravity along z.
    gyration_m
        Root of polar inertia over mass.
    """

    name: str
    at_m: float
    gyration_m: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Silhouette:
    """A body in the plane of the drawing, z to the right, x or r upwards.

    Attributes
    ----------
    name
        Of the body.
    kind
        "cut": areas are those cut by a plane through the axis; "view": the body seen from the
        side; "none": nothing but its nodes is known.
    areas_m
        Polygons (k, 2) of (z, height).
    nodes_m
        (z, height) of the master nodes by interface.
    seats_m
        Radius at which what is fixed to an interface is drawn.
    labels, materials
        Of each area, what it is and the name of its material; empty where neither is known.
    disks
        Rigid disks.
    center_m
        (z, height) of the centre of gravity.
    speed_ratio
        Speed of the body over that of the reference shaft.
    """

    name: str
    kind: str
    areas_m: tuple[FloatArray, ...]
    nodes_m: Mapping[str, tuple[float, float]]
    seats_m: Mapping[str, float]
    disks: tuple[Disk, ...]
    center_m: tuple[float, float]
    speed_ratio: float
    labels: tuple[str, ...] = ()
    materials: tuple[str, ...] = ()


def silhouettes_of(results: Results) -> tuple[Silhouette, ...]:
    """Return what is seen of every body, in the order of the scene.

    Parameters
    ----------
    results
        The run.
    """
    scene = results.scene
    profiles = build_bodies(scene)
    return tuple(
        _silhouette(scene, name, results.elements[name], profiles.get(name))
        for name in scene.speed_ratios()
    )


def _silhouette(scene: Scene, name: str, element: Superelement, profile: Body | None) -> Silhouette:
    nodes = {n.name: (float(n.position_m[2]), float(n.position_m[0])) for n in element.interfaces}
    kind = "none"
    areas: tuple[FloatArray, ...] = ()
    parts: tuple[Part, ...] = ()
    if profile is not None:
        kind, areas, parts = "cut", profile_areas(profile), profile_parts(profile)
        seats = {i.name: _seat(profile, i) for i in profile.interfaces}
    elif name in scene.beams:
        kind, areas = "cut", beam_areas(scene.beams[name])
        parts = beam_parts(scene, name)
        seats = {n: _beam_radius(scene.beams[name], z) for n, (z, _) in nodes.items()}
    else:
        outline = _view(element)
        if outline is not None:
            kind, areas = "view", (outline,)
        seats = {n: _view_radius(outline, z) for n, (z, _) in nodes.items()}
    labels: list[str] = []
    if kind == "cut":
        pieces = [list(_mirrored([area])) for area in areas]
        labels = [f"{name}: {p.name}, {p.material}" for p in parts]
        labels = [text for text, own in zip(labels, pieces, strict=True) for _ in own]
        parts = tuple(p for p, own in zip(parts, pieces, strict=True) for _ in own)
        areas = tuple(area for own in pieces for area in own)
    center = np.asarray(element.center_of_gravity_m, dtype=float)
    return Silhouette(
        name=name,
        kind=kind,
        areas_m=areas,
        nodes_m=nodes,
        seats_m=seats,
        disks=tuple(_disks(scene, name, {n: z for n, (z, _) in nodes.items()})),
        center_m=(float(center[2]), float(center[0])),
        speed_ratio=scene.speed_ratio(name),
        labels=tuple(labels),
        materials=tuple(p.material for p in parts),
    )


def _mirrored(upper: Iterable[FloatArray]) -> Iterator[FloatArray]:
    """Areas above the axis and below it; those that reach it, in one piece."""
    for area in upper:
        lower = area * (1.0, -1.0)
        if area[0, 1] == area[1, 1] == 0.0:
            yield np.vstack([lower[[3, 2]], area[[2, 3]]])
        else:
            yield area
            yield lower


def _seat(body: Body, interface: Interface) -> float:
    """Radius of what an interface covers: the outer one, but of an inner surface its own."""
    low, high = interface.start_m, interface.end_m
    found = []
    for s in body.sections:
        if s.start_m > high or s.end_m < low:
            continue
        for z in (max(low, s.start_m), min(high, s.end_m)):
            found.append(s.radii_at(z))
    if not found:
        return 0.0
    radii = np.array(found)
    least, most = interface.radius_m or (0.0, np.inf)
    if interface.kind == "inner":
        return float(np.clip(radii[:, 0].max(), least, most))
    within = radii[radii[:, 0] <= most]
    return float(np.clip((within if len(within) else radii)[:, 1].max(), least, most))


def _beam_radius(beam: BeamSpec, z: float) -> float:
    count = len(beam.stations_m) - 1
    outer = np.broadcast_to(beam.outer_radius_m, count)
    k = int(np.clip(np.searchsorted(beam.stations_m, z, side="right") - 1, 0, count - 1))
    return float(outer[k])


def _disks(scene: Scene, name: str, places: dict[str, float]) -> Iterator[Disk]:
    for disk in disks_of(scene, name, places):
        gyration = float(np.sqrt(disk.polar_inertia_kg_m2 / disk.mass_kg))
        yield Disk(name=disk.name, at_m=disk.at_m, gyration_m=gyration)


def _view(element: Superelement) -> FloatArray | None:
    """Outline of a body seen along y: least and largest x by slices of z."""
    surface = element.surface
    if surface is None:
        return None
    if surface.kind == "meridian":
        z, height = surface.points_m[surface.cells].transpose(2, 0, 1)
        low, high = -height, height
    else:
        corners = surface.points_m[surface.cells]
        z, low, high = corners[:, :, 2], corners[:, :, 0], corners[:, :, 0]
    places = np.linspace(z.min(), z.max(), _SLICES)
    first = np.searchsorted(places, z.min(axis=1), side="right") - 1
    last = np.searchsorted(places, z.max(axis=1), side="left")
    least, most = np.full(_SLICES, np.inf), np.full(_SLICES, -np.inf)
    for a, b, lower, upper in zip(first, last, low.min(axis=1), high.max(axis=1), strict=True):
        span = slice(max(int(a), 0), min(int(b), _SLICES - 1) + 1)
        least[span] = np.minimum(least[span], lower)
        most[span] = np.maximum(most[span], upper)
    known = most >= least
    upper = np.column_stack([places[known], most[known]])
    lower = np.column_stack([places[known], least[known]])
    return np.vstack([upper, lower[::-1]])


def _view_radius(outline: FloatArray | None, z: float) -> float:
    if outline is None:
        return 0.0
    upper = outline[: len(outline) // 2]
    return float(np.interp(z, upper[:, 0], upper[:, 1]))
