"""Sizes and masses of the bodies of a scene, for a look at their units."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from solidwhirl.geometry import Body, Material, section_mass_properties
from solidwhirl.model.bodies import scene_materials
from solidwhirl.model.mesh_bodies import build_mesh_bodies
from solidwhirl.scene.joints import BeamDiskSpec
from solidwhirl.scene.meshes import RigidDiskSpec
from solidwhirl.scene.records import Scene

Disk = RigidDiskSpec | BeamDiskSpec


@dataclass(frozen=True, kw_only=True)
class Shape:
    """What is known of a body without computing anything."""

    key: str
    length_m: float
    radius_m: float
    own_mass_kg: float
    disks: Mapping[str, Disk]  #: Rigid ones on it, by their keys
    materials: tuple[Material, ...]  #: Its materials, that of the first section first

    @property
    def name(self) -> str:
        """Of the body."""
        return self.key.partition(".")[2]

    @property
    def size_m(self) -> float:
        """Largest dimension."""
        return max(self.length_m, 2.0 * self.radius_m)

    @property
    def mass_kg(self) -> float:
        """Mass with that of the rigid disks."""
        return self.own_mass_kg + sum(disk.mass_kg for disk in self.disks.values())


def shapes_of(scene: Scene, bodies: Mapping[str, Body]) -> Iterator[Shape]:
    """Shapes of the bodies with a profile, whose geometry is given, of meshes, and of beams."""
    for name, body in bodies.items():
        key, sections = f"bodies.{name}", body.sections
        yield Shape(
            key=key,
            length_m=max(s.end_m for s in sections) - min(s.start_m for s in sections),
            radius_m=max(max(s.outer_radius_m) for s in sections),
            own_mass_kg=sum(section_mass_properties(s).mass_kg for s in sections),
            disks=_by_key(f"{key}.rigid_disks", scene.bodies[name].rigid_disks),
            materials=_different(s.material for s in sections),
        )
    for name, mesh in build_mesh_bodies(scene).items():
        key, request = f"mesh_bodies.{name}", mesh.request
        materials = [m for m in (request.material, *(m for _, m in request.materials)) if m]
        density = max(m.density_kg_per_m3 for m in materials)
        yield Shape(
            key=key,
            length_m=mesh.length_m,
            radius_m=mesh.radius_m,
            own_mass_kg=density * mesh.volume_m3 if mesh.mass is None else mesh.mass.mass_kg,
            disks=_by_key(f"{key}.rigid_disks", scene.mesh_bodies[name].rigid_disks),
            materials=_different(materials),
        )
    known = scene_materials(scene)
    for name, beam in scene.beams.items():
        key, material = f"beams.{name}", known.get(beam.material)
        lengths = np.diff(beam.stations_m)
        outer, inner = np.array(beam.section_radii_m)
        volume = float(math.pi * ((outer - inner) * (outer + inner) * lengths).sum())
        yield Shape(
            key=key,
            length_m=beam.stations_m[-1] - beam.stations_m[0],
            radius_m=max(beam.outer_radius_m),
            own_mass_kg=volume * (material.density_kg_per_m3 if material is not None else 0.0),
            disks=_by_key(f"{key}.disks", beam.disks),
            materials=(material,) if material is not None else (),
        )


def _by_key(table: str, disks: Iterable[Disk]) -> dict[str, Disk]:
    return {f"{table}[{k}]": disk for k, disk in enumerate(disks)}


def _different(materials: Iterable[Material]) -> tuple[Material, ...]:
    return tuple({m.name: m for m in materials}.values())
