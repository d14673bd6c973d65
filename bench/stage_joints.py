"""Stages joined to their drum by the field of order 1: what that neglects, and what is said of it.

    python bench/stage_joints.py                  table, rows in out/stage_joints.json
    python bench/stage_joints.py --data docs/data/stage_joints.json

The bladed disk of the verification page (12 or 6 blades) is cut on a cylinder. Its truth is the
same mesh in one piece; the two pieces of that mesh meet by the field of the joint alone, so that
nothing but the joint differs. One edge along the joint has a field of degree 2, two edges a finer
one. The estimate has two parts: what the orders 1 ± N would change ("stage_joints"), and what a
higher degree along the joint would, which is by how much the estimate of the mesh rises where the
mesh is cut. Own meshes of stage and drum, as a run makes them, have no truth in one piece; there
the first part is compared with what the orders 1 ± N change.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy.linalg
from mpi4py import MPI

from solidwhirl.geometry import Blade, Body, Interface, Material, Section
from solidwhirl.meshing import Mesh, MeshSize
from solidwhirl.meshing.own.features.sector import mesh_sector
from solidwhirl.meshing.own.joined import mesh_joined
from solidwhirl.meshing.records import Parts
from solidwhirl.reduction import ReductionRequest, reduce_body
from solidwhirl.rotordyn import Superelement

ROOT = Path(__file__).resolve().parents[1]
INNER, RIM, HALF, BLADE = 0.03, 0.10, 0.006, 0.05
MODES = 3
#: Blades, joint radius [m]
CASES = ((12, 0.05), (12, 0.08), (6, 0.08))
#: Known from other meshes: first modes by order 1 and with 1 ± N [ppm], of a rigid ring [%]
SOURCE = {
    (12, 0.05): ((1, 3, 3), (1, 3, 3), (5.6, 33, 9.3)),
    (12, 0.08): ((280, 298, 2020), (4, 6, 20), (6.7, 30, 1.4)),
    (6, 0.08): ((3000, 2000, 41700), (180, 130, 1090), (3.2, 31, 4.5)),
}
SIZE = MeshSize(size_m=0.006, corner_size_m=0.003, growth=0.5)
#: Edges along the joint: degree 2 is one, and what the table is made with
EDGES = (1, 2)
JOINT = "joint"


def bladed_disk(count: int, joint_m: float) -> Body:
    """Disk in two sections that meet at the joint."""
    steel = Material(
        name="steel", density_kg_per_m3=7800.0, youngs_modulus_pa=2e11, poissons_ratio=0.3
    )
    sections = [
        Section(
            name=name, start_m=-HALF, end_m=HALF, inner_radius_m=(inner, inner),
            outer_radius_m=(outer, outer), material=steel,
        )
        for name, inner, outer in (("drum", INNER, joint_m), ("rim", joint_m, RIM))
    ]  # fmt: skip
    blades = Blade(
        name="blades", on="rim", count=count, length_m=BLADE, chord_m=(0.02, 0.02),
        thickness_m=(0.004, 0.004), stagger_deg=(30.0, 30.0), material=steel,
    )  # fmt: skip
    bore = Interface(name="bore", kind="inner", coupling="rigid", start_m=-HALF, end_m=HALF)
    return Body(name="disk", sections=tuple(sections), interfaces=(bore,), features=(blades,))


def joint_facets(mesh: Mesh, side: int) -> np.ndarray:
    """Second-order facets of the cells of one section that lie in another one's."""
    faces = ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))
    middle = {(0, 1): 4, (1, 2): 5, (0, 2): 6, (0, 3): 7, (2, 3): 8, (1, 3): 9}  # gmsh
    sides: list[dict[tuple[int, ...], np.ndarray]] = []
    for own in (0, 1):
        cells = mesh.cells[of_drum(mesh) == (own == 0)]
        found = {}
        for a, b, c in faces:
            nodes = [a, b, c, middle[a, b], middle[b, c], middle[a, c]]
            for row in cells[:, nodes]:
                found[tuple(sorted(row[:3]))] = row
        sides.append(found)
    return np.array([row for key, row in sides[side].items() if key in sides[1 - side]])


def of_drum(mesh: Mesh) -> np.ndarray:
    """Which cells are inside the joint."""
    return mesh.cell_section == mesh.section_names.index("drum")


def cut(mesh: Mesh, joint_m: float, edges: int) -> Mesh:
    """The same mesh in pieces: drum, stage, and copies of the drum for the orders 1 ± N."""
    assert mesh.sector is not None
    pieces = [0, 1, 0, 0]
    count = mesh.sector.count
    points, cells, facets, bore, parts, starts = [], [], [], [], [], 0
    for part, side in enumerate(pieces):
        own = mesh.cells[of_drum(mesh) == (side == 0)]
        used = np.unique(own)
        number = np.full(len(mesh.points), -1)
        number[used] = np.arange(len(used)) + starts
        points.append(mesh.points[used])
        cells.append(number[own])
        facets.append(number[joint_facets(mesh, side)])
        parts.append(np.full(len(own), part))
        if part == 0:
            bore = number[mesh.interfaces["bore"]]
        starts += len(used)
    z = np.linspace(-HALF, HALF, edges + 1)
    ends = np.stack([np.column_stack([z[k : k + 2], [joint_m, joint_m]]) for k in range(edges)])
    order = np.concatenate([np.flatnonzero(of_drum(mesh) == (side == 0)) for side in pieces])
    return replace(
        mesh,
        points=np.concatenate(points),
        cells=np.concatenate(cells),
        cell_section=mesh.cell_section[order],
        cell_material=mesh.cell_material[order],
        interfaces={"bore": bore},
        outline=np.empty(0, dtype=np.int64),
        parts=Parts(
            sectors=(mesh.sector,) * len(pieces),
            shifts=(0, None, count, -count),
            cell_part=np.concatenate(parts),
            joint_facets=np.concatenate(facets),
            joint_edges_m=ends,
        ),
    )


def reduced(body: Body, mesh: Mesh, **changes: Any) -> Superelement:
    """Lateral superelement at rest with the modes looked at, and some more."""
    usual = {
        "level": "solid", "orders": (1,), "components": ("ux", "uy", "rx", "ry"), "degree": 2,
        "modes": MODES + 3, "maximum_speed_rad_s": 0.0, "gyroscopic": False, "centrifugal": False,
        "estimates": ("mode_truncation", "mesh"),
    }  # fmt: skip
    request = ReductionRequest(**(usual | changes))
    return reduce_body(body, mesh, MPI.COMM_SELF, request, {})[0]


def held_hz(element: Superelement) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Lowest frequencies with the bore held, one of each pair, and their errors by part."""
    kept = [k for k, c in enumerate(element.coordinates) if c.interface != "bore"]
    at = np.ix_(kept, kept)
    squared, shapes = scipy.linalg.eigh(element.stiffness[at], element.mass[at])
    errors = {form.part: np.zeros(MODES) for form in element.error_forms}
    for k in range(MODES):
        q = np.zeros(element.size)
        q[kept] = shapes[:, 2 * k]
        load = np.concatenate([q, -squared[2 * k] * q, 0.0 * q, 0.0 * q])
        for form in element.error_forms:
            energy = form.safety * (load @ form.gram @ load)
            errors[form.part][k] = 0.5 * energy / squared[2 * k]
    return np.sqrt(squared[: 2 * MODES : 2]) / (2.0 * np.pi), errors


def rigid_ring_hz(body: Body, mesh: Mesh, joint_m: float) -> np.ndarray:
    """Of the mesh in one piece, with all nodes of the joint on one rigid ring."""
    ring = Interface(
        name="ring", kind="outer", coupling="rigid", start_m=-HALF, end_m=HALF,
        radius_m=(0.999 * joint_m, 1.001 * joint_m),
    )  # fmt: skip
    body = replace(body, interfaces=(*body.interfaces, ring))
    mesh = replace(mesh, interfaces={**mesh.interfaces, "ring": joint_facets(mesh, 0)})
    return held_hz(reduced(body, mesh, modes=3 * MODES, estimates=()))[0]


def measure(count: int, joint_m: float) -> dict[str, Any]:
    """All rows of one case."""
    start = time.process_time()
    body = bladed_disk(count, joint_m)
    mesh = mesh_sector(body, SIZE)
    truth, in_one = held_hz(reduced(body, mesh))
    row: dict[str, Any] = {
        "blades": count,
        "joint_m": joint_m,
        "pitches_to_roots": (RIM - joint_m) / (2.0 * np.pi * RIM / count),
        "truth_hz": truth.tolist(),
        "by_edges": [],
    }
    for edges in EDGES:
        pieces = cut(mesh, joint_m, edges)
        alone, estimate = held_hz(reduced(body, pieces))
        both, _ = held_hz(reduced(body, pieces, neighbours=True, estimates=()))
        error, orders = alone / truth - 1.0, estimate["stage_joints"]
        degree = estimate["mesh"] - in_one["mesh"]
        row["by_edges"].append(
            {
                "edges": edges,
                "order_1": error.tolist(),
                "with_neighbours": (both / truth - 1.0).tolist(),
                "estimate_of_orders": orders.tolist(),
                "estimate_of_degree": degree.tolist(),
                "estimate_over_true": ((orders + degree) / error).tolist(),
            }
        )
    row["rigid_ring"] = (rigid_ring_hz(body, mesh, joint_m) / truth - 1.0).tolist()
    own = mesh_joined(body, SIZE)
    alone, parts = held_hz(reduced(body, own, estimates=("mode_truncation",)))
    both, _ = held_hz(reduced(body, own, neighbours=True, estimates=()))
    stiffer, estimate = alone / both - 1.0, parts["stage_joints"]
    row["own_meshes"] = {
        "order_1_over_neighbours": stiffer.tolist(),
        "estimate": estimate.tolist(),
        "estimate_over_change": (estimate / stiffer).tolist(),
    }
    row["cpu_s"] = time.process_time() - start
    return row


def told(row: dict[str, Any]) -> str:
    """One case as text, the source's figures in brackets."""
    source = SOURCE[row["blades"], row["joint_m"]]
    lines = [
        f"{row['blades']} blades, joint at {row['joint_m']} m, "
        f"{row['pitches_to_roots']:.2f} pitches from the roots ({row['cpu_s']:.0f} s)"
    ]

    def ppm(values: list[float]) -> str:
        return " ".join(f"{1e6 * v:9.1f}" for v in values)

    for found in row["by_edges"]:
        lines += [
            f"  {found['edges']} edges: order 1 {ppm(found['order_1'])} ppm {source[0]}",
            f"           1 ± N   {ppm(found['with_neighbours'])} ppm {source[1]}",
            f"           orders  {ppm(found['estimate_of_orders'])} ppm estimated",
            f"           degree  {ppm(found['estimate_of_degree'])} ppm estimated, both over true "
            + " ".join(f"{v:.2f}" for v in found["estimate_over_true"]),
        ]
    own = row["own_meshes"]
    lines += [
        f"  own meshes: order 1 over 1 ± N {ppm(own['order_1_over_neighbours'])} ppm; estimate over"
        " it " + " ".join(f"{v:.2f}" for v in own["estimate_over_change"]),
        "  rigid ring " + " ".join(f"{100 * v:.1f}" for v in row["rigid_ring"]) + f" % {source[2]}",
    ]
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=ROOT / "out" / "stage_joints.json")
    path: Path = parser.parse_args().data
    rows = []
    for count, joint_m in CASES:
        rows.append(measure(count, joint_m))
        print(told(rows[-1]), flush=True)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({"rows": rows}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
