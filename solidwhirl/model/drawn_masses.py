"""Masses of the bodies of a scene along the axis, from their drawings."""

from __future__ import annotations

from itertools import pairwise

from solidwhirl import geometry as geo
from solidwhirl.model.bodies import build_bodies, known_material, scene_materials
from solidwhirl.scene.joints import BeamSpec
from solidwhirl.scene.records import Scene


def masses_beyond_kg(
    scene: Scene, body: str, low_m: float, high_m: float
) -> tuple[float, float] | None:
    """Return the masses of a body below one place along the axis and above another, kg.

    None of a body that is drawn neither as a profile nor as a beam.
    """
    if body in scene.bodies:
        drawn = build_bodies(scene)[body]
        return geo.masses_beyond_kg(drawn, low_m, high_m)
    if body in scene.beams:
        return _of_beam(scene, scene.beams[body], low_m, high_m)
    return None


def _of_beam(scene: Scene, spec: BeamSpec, low_m: float, high_m: float) -> tuple[float, float]:
    material = known_material(scene_materials(scene), spec.material, "beams")
    places = zip(pairwise(spec.stations_m), *spec.section_radii_m, strict=True)
    sections = [
        geo.Section(
            name=f"section_{k}",
            start_m=start,
            end_m=end,
            inner_radius_m=(inner, inner),
            outer_radius_m=(outer, outer),
            material=material,
        )
        for k, ((start, end), outer, inner) in enumerate(places)
    ]
    below, above = geo.sections_beyond_kg(sections, low_m, high_m)
    return (
        below + sum(disk.mass_kg for disk in spec.disks if disk.at_m < low_m),
        above + sum(disk.mass_kg for disk in spec.disks if disk.at_m > high_m),
    )
