"""Materials of a page: of which each section is, and what the bodies weigh by material."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.bodies import build_bodies, scene_materials
from solidwhirl.geometry import Body, mass_by_material_kg, section_mass_properties
from solidwhirl.page.records import Table
from solidwhirl.scene import Scene


class Part(NamedTuple):
    """A section of a body: places along z and radii at both ends, m, its material and mass, kg."""

    name: str
    start_m: float
    end_m: float
    inner_m: tuple[float, float]
    outer_m: tuple[float, float]
    material: str
    mass_kg: float


def profile_parts(body: Body) -> tuple[Part, ...]:
    """Return the sections of a profile.

    Parameters
    ----------
    body
        The profile.
    """
    return tuple(
        Part(
            s.name,
            s.start_m,
            s.end_m,
            s.inner_radius_m,
            s.outer_radius_m,
            s.material.name,
            section_mass_properties(s).mass_kg,
        )
        for s in body.sections
    )


def beam_parts(scene: Scene, name: str) -> tuple[Part, ...]:
    """Return the sections of a beam of a scene, numbered from 1.

    Parameters
    ----------
    scene
        The scene.
    name
        Of the beam.
    """
    beam = scene.beams[name]
    density = scene_materials(scene)[beam.material].density_kg_per_m3
    count = len(beam.stations_m) - 1
    outer = np.broadcast_to(np.array(beam.outer_radius_m), count).tolist()
    inner = np.broadcast_to(np.array(beam.inner_radius_m or (0.0,)), count).tolist()
    places = zip(beam.stations_m[:-1], beam.stations_m[1:], inner, outer, strict=True)
    return tuple(
        Part(
            f"section {k}",
            a,
            b,
            (low, low),
            (high, high),
            beam.material,
            math.pi * (high - low) * (high + low) * (b - a) * density,
        )
        for k, (a, b, low, high) in enumerate(places, start=1)
    )


def sections_table(scene: Scene) -> Iterator[Table]:
    """Return the sections of all bodies with their materials; none where there are no sections.

    Parameters
    ----------
    scene
        The scene.
    """
    parts = {name: profile_parts(body) for name, body in build_bodies(scene).items()}
    parts |= {name: beam_parts(scene, name) for name in scene.beams}
    rows = [
        (
            f"{name}: {p.name}",
            1e3 * p.start_m,
            1e3 * p.end_m,
            _radii(p.inner_m),
            _radii(p.outer_m),
            p.material,
            p.mass_kg,
        )
        for name in scene.speed_ratios()
        for p in parts.get(name, ())
    ]
    if rows:
        yield Table(
            folded=f"Sections and their materials ({len(rows)})",
            head=("section", "from z [mm]", "to z [mm]", "inner radius [mm]", "outer radius [mm]",
                  "material", "mass [kg]"),
            rows=rows,
            caption="Without fillets and rigid disks.",
        )  # fmt: skip


def _radii(ends_m: tuple[float, float]) -> str:
    first, last = (f"{1e3 * r:.5g}" for r in ends_m)
    return first if first == last else f"{first} to {last}"


def materials_table(scene: Scene, bodies: Mapping[str, Any]) -> Iterator[Table]:
    """Return the mass of every body by material; none where no material is known.

    Parameters
    ----------
    scene
        The scene.
    bodies
        `bodies` of `results.json`.
    """
    known = scene_materials(scene)
    rows: list[tuple[str, str, float | None, float, str]] = []
    for name, masses in _masses(scene, bodies).items():
        entries: list[tuple[str, float | None, float]] = [
            (material, known[material].density_kg_per_m3, mass) for material, mass in masses.items()
        ]
        disks = _disks_kg(scene, name)
        if disks > 0.0:
            entries.append(("rigid disks", None, disks))
        whole = bodies[name]["mass_kg"]
        rows += [
            (name, material, density, mass, f"{100 * mass / whole:.3g}")
            for material, density, mass in entries
        ]
    if rows:
        yield Table(
            title="Mass by body and material",
            head=("body", "material", "density [kg/m³]", "mass [kg]", "of the body [%]"),
            rows=rows,
            caption="Volume of the sections and fillets as drawn times the density; of a body from "
            "a mesh the volume of the mesh.",
        )


def _masses(scene: Scene, bodies: Mapping[str, Any]) -> dict[str, dict[str, float]]:
    """Mass without rigid disks by body and material, in the order of the scene."""
    profiles = build_bodies(scene)
    meshes = scene.finite_element_bodies()
    found = {}
    for name in scene.speed_ratios():
        if name in profiles:
            found[name] = mass_by_material_kg(profiles[name])
        elif name in scene.beams:
            parts = beam_parts(scene, name)
            found[name] = {scene.beams[name].material: math.fsum(p.mass_kg for p in parts)}
        elif name in meshes:
            spec = meshes[name]
            named = {*getattr(spec, "materials", {}).values(), spec.material} - {None}
            # a mesh of several materials has no volume by material here
            if len(named) == 1:
                rest = bodies[name]["mass_kg"] - _disks_kg(scene, name)
                found[name] = {str(m): rest for m in named}
    return found


def _disks_kg(scene: Scene, name: str) -> float:
    if name in scene.beams:
        return math.fsum(d.mass_kg for d in scene.beams[name].disks)
    body = scene.finite_element_bodies().get(name)
    return 0.0 if body is None else math.fsum(d.mass_kg for d in body.rigid_disks)
