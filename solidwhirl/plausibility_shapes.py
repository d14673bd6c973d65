"""Sizes and masses of the bodies of a scene, for a look at their units."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from solidwhirl.bodies import scene_materials
from solidwhirl.geometry import Body, Material, section_mass_properties
from solidwhirl.mesh_bodies import build_mesh_bodies
from solidwhirl.scene import Scene


@dataclass(frozen=True, kw_only=True)
class RigidMass:
    """A rigid mass on a body.

    Attributes
    ----------
    key
        Where it stands in the scene.
    mass_kg, polar_kg_m2, diametral_kg_m2
        Its mass and inertias.
    """

    key: str
    mass_kg: float
    polar_kg_m2: float
    diametral_kg_m2: float


@dataclass(frozen=True, kw_only=True)
class Shape:
    """What is known of a body without computing anything.

    Attributes
    ----------
    name, key
        Of the body, and where it stands in the scene.
    length_m, radius_m
        Overall length and largest radius.
    own_mass_kg
        Mass of its material.
    rigid
        Rigid masses on it.
    materials
        Its materials, that of the first section first.
    """

    name: str
    key: str
    length_m: float
    radius_m: float
    own_mass_kg: float
    rigid: tuple[RigidMass, ...]
    materials: tuple[Material, ...]

    @property
    def size_m(self) -> float:
        """Largest dimension."""
        return max(self.length_m, 2.0 * self.radius_m)

    @property
    def mass_kg(self) -> float:
        """Mass with that of the rigid masses."""
        return self.own_mass_kg + sum(r.mass_kg for r in self.rigid)


def body_shapes(scene: Scene, bodies: Mapping[str, Body]) -> Iterator[Shape]:
    """Shapes of the bodies with a profile.

    Parameters
    ----------
    scene
        The scene.
    bodies
        Their geometry.
    """
    for name, body in bodies.items():
        disks = [
            RigidMass(
                key=f"bodies.{name}.rigid_disks[{k}]",
                mass_kg=d.mass_kg,
                polar_kg_m2=d.polar_inertia_kg_m2,
                diametral_kg_m2=d.diametral_inertia_kg_m2,
            )
            for k, d in enumerate(scene.bodies[name].rigid_disks)
        ]
        sections = body.sections
        yield Shape(
            name=name,
            key=f"bodies.{name}",
            length_m=max(s.end_m for s in sections) - min(s.start_m for s in sections),
            radius_m=max(max(s.outer_radius_m) for s in sections),
            own_mass_kg=sum(section_mass_properties(s).mass_kg for s in sections),
            rigid=tuple(disks),
            materials=tuple({s.material.name: s.material for s in sections}.values()),
        )


def mesh_shapes(scene: Scene) -> Iterator[Shape]:
    """Shapes of the bodies with a mesh of their own.

    Parameters
    ----------
    scene
        The scene.
    """
    for name, body in build_mesh_bodies(scene).items():
        request = body.request
        materials = [m for m in (request.material, *(m for _, m in request.materials)) if m]
        density = max(m.density_kg_per_m3 for m in materials)
        yield Shape(
            name=name,
            key=f"mesh_bodies.{name}",
            length_m=body.length_m,
            radius_m=body.radius_m,
            own_mass_kg=density * body.volume_m3 if body.mass is None else body.mass.mass_kg,
            rigid=tuple(
                RigidMass(
                    key=f"mesh_bodies.{name}.rigid_disks[{k}]",
                    mass_kg=d.mass_kg,
                    polar_kg_m2=d.polar_inertia_kg_m2,
                    diametral_kg_m2=d.diametral_inertia_kg_m2,
                )
                for k, d in enumerate(body.rigid_disks)
            ),
            materials=tuple({m.name: m for m in materials}.values()),
        )


def beam_shapes(scene: Scene) -> Iterator[Shape]:
    """Shapes of the beams of a scene.

    Parameters
    ----------
    scene
        The scene.
    """
    materials = scene_materials(scene)
    for name, beam in scene.beams.items():
        disks = [
            RigidMass(
                key=f"beams.{name}.disks[{k}]",
                mass_kg=d.mass_kg,
                polar_kg_m2=d.polar_inertia_kg_m2,
                diametral_kg_m2=d.diametral_inertia_kg_m2,
            )
            for k, d in enumerate(beam.disks)
        ]
        material = materials.get(beam.material)
        lengths = np.diff(beam.stations_m)
        outer, inner = (
            np.broadcast_to(r, lengths.shape) for r in (beam.outer_radius_m, beam.inner_radius_m)
        )
        volume = float(math.pi * ((outer - inner) * (outer + inner) * lengths).sum())
        yield Shape(
            name=name,
            key=f"beams.{name}",
            length_m=beam.stations_m[-1] - beam.stations_m[0],
            radius_m=max(beam.outer_radius_m),
            own_mass_kg=volume * (material.density_kg_per_m3 if material is not None else 0.0),
            rigid=tuple(disks),
            materials=(material,) if material is not None else (),
        )
