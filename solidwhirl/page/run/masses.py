"""Section: mass properties of the bodies, and their own frequencies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from solidwhirl.page.drawing.materials import materials_table
from solidwhirl.page.frame.records import Block, Run, Section, Table

# Frequencies listed of each body.
_SHOWN = 6


def section(run: Run) -> Section | None:
    """Mass properties."""
    bodies = run.document["bodies"]
    blocks = [
        properties_table(bodies),
        *materials_table(run.results.scene, run.results.geometry, bodies),
        *_tensors(bodies),
        sizes_table(bodies),
        *_disks(run),
        *interfaces_table(bodies),
    ]
    return Section(name="masses", title="Mass properties", blocks=blocks)


def properties_table(bodies: Mapping[str, Any]) -> Table:
    """Return mass, centre, inertias and own frequencies of bodies of `results.json`."""
    rows = [
        (
            name,
            b["mass_kg"],
            1e3 * b["center_of_gravity_m"][2],
            b["polar_inertia_kg_m2"],
            b["diametral_inertia_kg_m2"],
            ", ".join(f"{f:.2f}" for f in _lateral(b)) or None,
        )
        for name, b in bodies.items()
    ]
    if len(bodies) > 1:
        mass = sum(b["mass_kg"] for b in bodies.values())
        moment = sum(b["mass_kg"] * b["center_of_gravity_m"][2] for b in bodies.values())
        rows.append(("**together**", mass, 1e3 * moment / mass, None, None, None))
    return Table(
        head=(
            "body", "mass [kg]", "centre of gravity z [mm]", "polar inertia [kg m²]",
            "diametral inertia [kg m²]", "free lateral frequencies at rest [Hz]",
        ),
        rows=rows,
        caption="Rigid disks included. Inertias are about the centre of gravity of each body; a "
        "diametral inertia is given where it is the same about x and y. Free: nothing holds the "
        "body.",
    )  # fmt: skip


def _lateral(body: Mapping[str, Any]) -> list[float]:
    """Frequencies of a body; those of a body of revolution come in pairs."""
    step = 1 if body["level"] == "imported" else 2
    return list(body["free_frequencies_hz"][: _SHOWN * step : step])


def _tensors(bodies: Mapping[str, Any]) -> Iterator[Block]:
    """Whole tensors of those whose products of inertia are not zero."""
    rows = []
    for name, b in bodies.items():
        if "inertia_kg_m2" not in b:
            continue
        tensor = np.asarray(b["inertia_kg_m2"], dtype=float)
        off = np.abs(tensor - np.diag(np.diag(tensor))).max()
        uneven = abs(tensor[0, 0] - tensor[1, 1])
        x, y, _ = b["center_of_gravity_m"]
        if max(off, uneven) > 1e-9 * tensor.max() or x or y:
            parts = (tensor[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
            rows.append((name, 1e3 * x, 1e3 * y, *(float(v) for v in parts)))
    if rows:
        yield Table(
            title="Bodies that are not round",
            head=("body", "x [mm]", "y [mm]", "Ixx [kg m²]", "Iyy [kg m²]", "Izz [kg m²]",
                  "Ixy [kg m²]", "Ixz [kg m²]", "Iyz [kg m²]"),
            rows=rows,
            caption="Place of the centre of gravity and entries of the tensor of inertia about it.",
        )  # fmt: skip


def sizes_table(bodies: Mapping[str, Any]) -> Table:
    """Return how large the models of bodies of `results.json` are."""
    return Table(
        title="From unknowns to coordinates",
        head=("body", "level", "unknowns", "coordinates after reduction",
              "hoop strain at top speed"),
        rows=[
            (
                name,
                b["level"],
                b["full_dofs"],
                b["reduced_dofs"],
                _exponent(b.get("hoop_strain_at_top_speed")),
            )
            for name, b in bodies.items()
        ],
    )  # fmt: skip


def _exponent(value: float | None) -> str | None:
    return None if value is None else f"{value:.1e}"


def _disks(run: Run) -> Iterator[Block]:
    scene = run.results.scene
    rows = []
    for name, body in scene.finite_element_bodies().items():
        for d in body.rigid_disks:
            place = f"{name}.{d.interface}"
            inertias = (d.polar_inertia_kg_m2, d.diametral_inertia_kg_m2)
            rows.append((f"{name}: {d.name}", place, d.mass_kg, *inertias, 1e3 * d.offset_m))
    for name, beam in scene.beams.items():
        for b in beam.disks:
            inertias = (b.polar_inertia_kg_m2, b.diametral_inertia_kg_m2)
            rows.append(
                (f"{name}: {b.name}", f"z = {1e3 * b.at_m:.4g} mm", b.mass_kg, *inertias, 0.0)
            )
    if rows:
        yield Table(
            folded=f"Rigid disks ({len(rows)})",
            head=("disk", "at", "mass [kg]", "polar inertia [kg m²]",
                  "diametral inertia [kg m²]", "offset [mm]"),
            rows=rows,
        )  # fmt: skip


def interfaces_table(bodies: Mapping[str, Any]) -> Iterator[Table]:
    """Yield the interfaces of bodies of `results.json`: where, how large, what was asked for."""
    rows = [
        (
            f"{name}.{found['name']}",
            _millimetres(found["position_m"]),
            _millimetres(found["mean_position_m"]) if "mean_position_m" in found else None,
            1e6 * found["area_m2"] if "area_m2" in found else None,
            found.get("asked"),
            found.get("cut_facets"),
        )
        for name, body in bodies.items()
        for found in body.get("interfaces", ())
    ]
    if rows:
        yield Table(
            title="Interfaces",
            head=(
                "interface", "node (x, y, z) [mm]", "centre of area [mm]", "area [mm²]",
                "asked for", "facets cut",
            ),
            rows=rows,
            caption="Bearings, gears and disks hold a body at the node. Facets that a box cuts do "
            "not belong to its interface.",
        )  # fmt: skip


def _millimetres(place: list[float]) -> str:
    return ", ".join(f"{1e3 * value:.5g}" for value in place)
