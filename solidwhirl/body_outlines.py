"""Cross-sections and rigid disks of the bodies of a scene in (z, r), for all drawings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solidwhirl.geometry import Body
from solidwhirl.scene import Scene
from solidwhirl.scene_joints import BeamSpec

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class PlacedDisk:
    """A rigid disk of a body.

    Attributes
    ----------
    name
        Of the disk.
    at_m
        Place of its centre of gravity along z.
    mass_kg, polar_inertia_kg_m2
        Its inertia.
    """

    name: str
    at_m: float
    mass_kg: float
    polar_inertia_kg_m2: float


def profile_areas(body: Body) -> tuple[FloatArray, ...]:
    """Return the sections of a profile, without its fillets.

    Parameters
    ----------
    body
        The profile.

    Returns
    -------
    tuple of ndarray
        One polygon (4, 2) of (z, r), m, for each section: along the inner radius and back along
        the outer one.
    """
    areas = []
    for s in body.sections:
        (inner_0, inner_1), (outer_0, outer_1) = s.inner_radius_m, s.outer_radius_m
        corners = [(s.start_m, inner_0), (s.end_m, inner_1), (s.end_m, outer_1)]
        areas.append(np.array([*corners, (s.start_m, outer_0)], dtype=float))
    return tuple(areas)


def beam_areas(beam: BeamSpec) -> tuple[FloatArray, ...]:
    """Return the sections of a beam as rectangles, see `profile_areas`.

    Parameters
    ----------
    beam
        Of the scene.
    """
    stations, count = beam.stations_m, len(beam.stations_m) - 1
    outer = np.broadcast_to(np.array(beam.outer_radius_m), count)
    inner = np.broadcast_to(np.array(beam.inner_radius_m or (0.0,)), count)
    return tuple(
        np.array([(a, low), (b, low), (b, high), (a, high)], dtype=float)
        for a, b, low, high in zip(stations[:-1], stations[1:], inner, outer, strict=True)
    )


def disks_of(scene: Scene, name: str, places_m: dict[str, float]) -> tuple[PlacedDisk, ...]:
    """Return the rigid disks of a body that have a mass.

    Parameters
    ----------
    scene
        The scene.
    name
        Of the body.
    places_m
        Place along z of each of its interfaces.
    """
    if name in scene.beams:
        found = tuple(
            PlacedDisk(
                name=b.name,
                at_m=float(b.at_m),
                mass_kg=b.mass_kg,
                polar_inertia_kg_m2=b.polar_inertia_kg_m2,
            )
            for b in scene.beams[name].disks
        )
    else:
        body = scene.finite_element_bodies().get(name)
        found = tuple(
            PlacedDisk(
                name=d.name,
                at_m=float(places_m[d.interface] + d.offset_m),
                mass_kg=d.mass_kg,
                polar_inertia_kg_m2=d.polar_inertia_kg_m2,
            )
            for d in (() if body is None else body.rigid_disks)
        )
    return tuple(disk for disk in found if disk.mass_kg > 0.0)
