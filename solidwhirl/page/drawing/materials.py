"""Materials of a page: of which each section is, and what the bodies weigh by material."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from solidwhirl.drawing.bodies import beam_parts, profile_features, profile_parts
from solidwhirl.geometry import Body, mass_by_material_kg
from solidwhirl.model.bodies import scene_materials
from solidwhirl.page.frame.records import Table
from solidwhirl.scene.records import Scene


def sections_table(scene: Scene, geometry: Mapping[str, Body]) -> Iterator[Table]:
    """Yield the sections of all bodies with their materials; `geometry` has those of profiles."""
    parts = {name: profile_parts(body) for name, body in geometry.items()}
    parts |= {name: beam_parts(scene, name) for name in scene.beams}
    rows = [
        (f"{name}: {p.name}", 1e3 * p.start_m, 1e3 * p.end_m, _radii(p.inner_m), _radii(p.outer_m),
         p.material, p.mass_kg)
        for name in scene.speed_ratios()
        for p in parts.get(name, ())
    ]  # fmt: skip
    if rows:
        yield Table(
            folded=f"Sections and their materials ({len(rows)})",
            head=("section", "from z [mm]", "to z [mm]", "inner radius [mm]", "outer radius [mm]",
                  "material", "mass [kg]"),
            rows=rows,
            caption="Without fillets and rigid disks.",
        )  # fmt: skip


def features_table(geometry: Mapping[str, Body]) -> Iterator[Table]:
    """Yield blades, holes, ... of all bodies, with what all of a set weigh."""
    rows = [
        (f"{name}: {f.name}", f.kind, str(f.count), f.section, f.material, f.mass_kg)
        for name, body in geometry.items()
        for f in profile_features(body)
    ]
    if rows:
        yield Table(
            folded=f"Blades, holes, slots and the like ({len(rows)})",
            head=("set", "what", "number", "section", "material", "mass of all [kg]"),
            rows=rows,
            caption="What is taken away has a negative mass.",
        )


def _radii(ends_m: tuple[float, float]) -> str:
    first, last = (f"{1e3 * r:.5g}" for r in ends_m)
    return first if first == last else f"{first} to {last}"


def materials_table(
    scene: Scene, geometry: Mapping[str, Body], bodies: Mapping[str, Any]
) -> Iterator[Table]:
    """Yield the mass of every body by material; `bodies` is that of `results.json`."""
    known = scene_materials(scene)
    rows: list[tuple[str, str, float | None, float, str]] = []
    for name, masses in _masses(scene, geometry, bodies).items():
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


def _masses(
    scene: Scene, geometry: Mapping[str, Body], bodies: Mapping[str, Any]
) -> dict[str, dict[str, float]]:
    """Mass without rigid disks by body and material, in the order of the scene."""
    meshes = scene.finite_element_bodies()
    found = {}
    for name in scene.speed_ratios():
        if name in geometry:
            found[name] = mass_by_material_kg(geometry[name])
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
