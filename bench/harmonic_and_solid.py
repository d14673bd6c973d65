"""Time, memory and error of both levels on the reference rotor, against floors of the same run.

    python bench/harmonic_and_solid.py              all cases, about 5 minutes
    python bench/harmonic_and_solid.py --out FILE   also writes the rows as JSON

Errors are the largest of the first three bending frequencies at rest, and of the first two forward
ones at 10 000 rpm, against elements of order 4 whose corners are 0.02 mm wide. Floors: one
factorisation of the same matrix and one solution for each of 32 columns, all of them together; for
the case that says so also that of half the circle, the smallest real problem of order 1 on a mesh
of the whole. Every case runs in a process of its own; ratios are what to quote, machines differ.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
SPEEDS = 21
TOP = 10_000 * np.pi / 30.0
COLUMNS = 32
#: Order of the elements, edge at corners [m], growth, elements through the thickness, sectors.
TRUTH = {"level": "harmonic", "degree": 4, "corner": 2e-5, "growth": 0.4, "through": 2.0}
CASES = (
    {"level": "harmonic", "degree": 2, "corner": 2e-3},
    {"level": "harmonic", "degree": 2, "corner": 5e-4},
    {"level": "harmonic", "degree": 3, "corner": 5e-4},
    {"level": "harmonic", "degree": 4, "corner": 1e-4},
    {"level": "solid", "corner": 4e-3},
    {"level": "solid", "corner": 1e-3},
    {"level": "solid", "corner": 5e-4, "growth": 0.4, "through": 2.0, "sectors": 24},
    {"level": "solid", "corner": 2.5e-4, "growth": 0.4, "through": 3.0, "sectors": 24},
    {"level": "solid", "corner": 8e-5, "growth": 0.3, "through": 6.0, "sectors": 32},
    {"level": "solid", "corner": 3e-4, "through": 3.0, "sectors": 16, "half_turn": True},
    {"level": "solid", "corner": 3e-4, "through": 3.0, "sectors": 16, "unfolded": True},
    {"level": "solid", "corner": 6e-5, "through": 8.0, "sectors": 16},
    {"level": "solid", "corner": 6e-5, "through": 8.0, "sectors": 16, "estimates": True},
)


def reference_rotor():
    from solidwhirl.geometry import MATERIALS, Body, Interface, Section

    steel = MATERIALS["steel"]
    pieces = (("shaft", 0.0, 0.4, 0.0, 0.02), ("disk", 0.145, 0.175, 0.02, 0.15))
    sections = tuple(
        Section(
            name=name,
            start_m=start,
            end_m=end,
            inner_radius_m=(inner, inner),
            outer_radius_m=(outer, outer),
            material=steel,
        )
        for name, start, end, inner, outer in pieces
    )
    planes = tuple(
        Interface(name=name, kind="section", coupling="distributing", start_m=z, end_m=z)
        for name, z in (("left", 0.0), ("right", 0.4))
    )
    return Body(name="rotor", sections=sections, interfaces=planes)


def frequencies(element) -> list[float]:
    """Bending at rest (three) and forward at 10 000 rpm (two) of the free rotor [Hz]."""
    at_rest = element.free_frequencies_hz[::2][:3]
    m, g = element.mass, TOP * element.gyroscopic
    k = element.stiffness + TOP**2 * (element.stress_stiffening - element.spin_softening)
    zero, one = np.zeros_like(m), np.eye(len(m))
    state = np.block([[zero, one], [-np.linalg.solve(m, k), -np.linalg.solve(m, g)]])
    hertz = np.sort(np.linalg.eigvals(state).imag) / (2.0 * np.pi)
    # above the rigid precession the branches of the first bending lie beside each other
    bending = hertz[(hertz > 0.8 * at_rest[0]) & (hertz < 1.2 * at_rest[0])]
    return [*at_rest, *bending[:2]]


def size_of(case: dict):
    """Sizes of the elements of a case."""
    from solidwhirl.meshing import MeshSize

    return MeshSize(
        size_m=0.1,
        corner_size_m=case["corner"],
        growth=case.get("growth", 0.6),
        through_thickness=case.get("through", 1.2),
    )


def meshed(case: dict):
    """The mesh of a case."""
    from solidwhirl.meshing import mesh_meridian
    from solidwhirl.meshing.own.revolved import revolved, unfolded

    mesh = mesh_meridian(reference_rotor(), size_of(case))
    if case["level"] == "harmonic":
        return mesh
    mesh = revolved(mesh, case.get("sectors"))
    return unfolded(mesh) if case.get("unfolded") else mesh


def forecast_gib(case: dict) -> float:
    """Largest memory of one process as it is told before the mesh is made."""
    from solidwhirl.cost.work import predict_body_cost
    from solidwhirl.model.bodies import build_bodies
    from solidwhirl.model.effects import make_plan
    from solidwhirl.scene_reading.reader import read_scene

    scene = read_scene(ROOT / "scenes" / "reference_solid.toml")
    bodies = build_bodies(scene)
    plan = make_plan(scene, bodies, case["level"]).bodies["rotor"]
    resolution = replace(plan.resolution, size=size_of(case), degree=case.get("degree", 2))
    estimates = bool(case.get("estimates"))
    plan = replace(plan, level=case["level"], resolution=resolution)
    return predict_body_cost(bodies["rotor"], plan, modes=8, estimates=estimates).peak_memory_gib


def floor_cpu_s(matrix, rows) -> tuple[float, float]:
    """Time of a factorisation, and of solutions in one block; the shortest of three each."""
    from solidwhirl.reduction.solvers.constrained import factorise

    found = []
    for _ in range(3):
        start = time.process_time()
        factor = factorise(matrix, rows)
        factored = time.process_time()
        factor.solve(np.ones((len(rows), COLUMNS), dtype=rows.dtype), None)
        found.append((factored - start, time.process_time() - factored))
        factor.destroy()
    factored, solved = np.min(found, axis=0)
    return float(factored), float(solved)


def half_turn(mesh):
    """Stiffness and interface rows of u(-x, -y, z) = (ux, uy, -uz), on a mesh of the whole."""
    import scipy.sparse
    from mpi4py import MPI
    from petsc4py import PETSc
    from scipy.spatial import cKDTree

    from solidwhirl.meshing.own.whole import whole_mesh
    from solidwhirl.reduction.operators.matrices import OperatorEffects, build_operators

    body, whole = reference_rotor(), whole_mesh(mesh)[0]
    operators = build_operators(
        body, whole, MPI.COMM_SELF, order=None, degree=2, effects=effects_of(OperatorEffects, "any")
    )
    x = operators.space.tabulate_dof_coordinates()
    gap, partner = cKDTree(x).query(x * [-1.0, -1.0, 1.0])
    assert gap.max() < 1e-9
    leads = np.arange(len(x)) <= partner
    leader = np.where(leads, np.arange(len(x)), partner)
    node, component = np.divmod(np.arange(3 * len(x)), 3)
    sign = np.where(leads[node], 1.0, np.where(component == 2, -1.0, 1.0))
    # along the axis nothing moves on it
    kept = ~((node == partner[node]) & (component == 2))
    free = np.flatnonzero(kept & leads[node])
    number = np.zeros(3 * len(x), dtype=np.int64)
    number[free] = np.arange(len(free))
    shape = (3 * len(x), len(free))
    column = number[3 * leader[node] + component]
    half = scipy.sparse.csr_matrix((sign[kept], (np.flatnonzero(kept), column[kept])), shape)
    indptr, columns, values = operators.stiffness.getValuesCSR()
    stiffness = half.T @ scipy.sparse.csr_matrix((values, columns, indptr)) @ half
    out = PETSc.Mat().createAIJ(
        size=stiffness.shape, csr=(stiffness.indptr, stiffness.indices, stiffness.data)
    )
    out.assemble()
    return out, half.T @ operators.coupling.held


def effects_of(record, shape: str):
    """The stiffness alone, with the interfaces' lateral motions."""
    names = [i.name for i in reference_rotor().interfaces]
    return record(
        gyroscopic=False,
        centrifugal=False,
        components=dict.fromkeys(names, ("ux", "uy")),
        shape=shape,
    )


def measure(case: dict) -> dict:
    """One case: mesh, reduction with prestress, Campbell diagram, and the floors."""
    begun = time.process_time()
    from mpi4py import MPI

    from solidwhirl.reduction import ReductionRequest, reduce_body
    from solidwhirl.reduction.operators.matrices import OperatorEffects, build_operators
    from solidwhirl.rotordyn import Rotor, assemble, campbell

    body, degree = reference_rotor(), case.get("degree", 2)
    request = ReductionRequest(
        level=case["level"],
        orders=(1,),
        components=("ux", "uy"),
        degree=degree,
        modes=8,
        maximum_speed_rad_s=2.0 * TOP,
        gyroscopic=True,
        centrifugal=True,
        estimates=("mode_truncation", "mesh") if case.get("estimates") else (),
    )
    start = time.process_time()
    mesh = meshed(case)
    drawn = time.process_time()
    element, _ = reduce_body(body, mesh, MPI.COMM_SELF, request, {})
    reduced = time.process_time()
    system = assemble({"rotor": Rotor(element=element, speed_ratio=1.0)}, ())
    campbell(system, np.linspace(0.0, 2.0 * TOP, SPEEDS), branch_count=10)
    done = time.process_time()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0**2
    effects = effects_of(OperatorEffects, "cyclic")
    operators = build_operators(body, mesh, MPI.COMM_SELF, order=1, degree=degree, effects=effects)
    factored, solved = floor_cpu_s(operators.stiffness, operators.coupling.held)
    row = {
        **case,
        "unknowns": element.full_dofs // 2,
        "unknowns_of_the_whole": None if mesh.sector is None else _of_the_whole(mesh),
        "frequency_hz": frequencies(element),
        "start_cpu_s": start - begun,
        "mesh_cpu_s": drawn - start,
        "reduction_cpu_s": reduced - drawn,
        "campbell_cpu_s": done - reduced,
        "process_cpu_s": done,
        "peak_memory_gib": peak,
        "forecast_memory_gib": forecast_gib(case),
        "factorisation_cpu_s": factored,
        "solutions_cpu_s": solved,
        "reduction_over_floor": (reduced - drawn) / (factored + solved),
    }
    if case.get("half_turn"):
        matrix, rows = half_turn(mesh)
        floor = sum(floor_cpu_s(matrix, rows))
        row |= {
            "half_turn_unknowns": len(rows),
            "half_turn_floor_cpu_s": floor,
            "process_over_half_turn_floor": reduced / floor,
        }
    return row


def _of_the_whole(mesh) -> int:
    """Displacements of the nodes of all copies, those on cut faces once."""
    on_cut = np.abs(mesh.points[:, 1]) < 1e-12
    axis = int((np.hypot(*mesh.points[:, :2].T) < 1e-12).sum())
    # both cut faces of a copy have as many nodes
    return 3 * (mesh.sector.copies * (len(mesh.points) - int(on_cut.sum())) + axis)


def run(case: dict) -> dict:
    """One case in a process of its own."""
    command = [sys.executable, __file__, "--case", json.dumps(case)]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    return json.loads(done.stdout.splitlines()[-1])


def main() -> None:
    """Run all cases and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--case")
    parser.add_argument("--out", type=Path)
    asked = parser.parse_args()
    if asked.case:
        print(json.dumps(measure(json.loads(asked.case))))
        return
    truth = np.array(run(TRUTH)["frequency_hz"])
    print("converged [Hz]:", np.array2string(truth, precision=4))
    rows, head = [], None
    for case in CASES:
        row = run(case)
        errors = np.array(row.pop("frequency_hz")) / truth - 1.0
        row["error_at_rest"], row["error_at_speed"] = (
            float(np.abs(part).max()) for part in (errors[:3], errors[3:])
        )
        rows.append(row)
        if head is None:
            head = [k for k in row if k not in ("growth", "through", "degree")]
            head = [*head, "sectors", "unfolded"]
            print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
        cells = (row.get(k, "") for k in head)
        text = [f"{v:.3g}" if isinstance(v, float) else str(v) for v in cells]
        print("| " + " | ".join(text) + " |", flush=True)
        if "half_turn_floor_cpu_s" in row:
            print({k: row[k] for k in row if "half_turn" in k}, flush=True)
    if asked.out:
        document = {"converged_hz": truth.tolist(), "rows": rows}
        asked.out.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
