"""Time, memory and error of both levels on the reference rotor, against floors of the same run.

Floors: one factorisation of the same matrix, and one triangular solve per basis vector, all of them
together ("block") or one by one ("single"). Every case runs in a process of its
own; ratios are what to quote, machines differ.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time

import numpy as np

#: Converged first bending frequency of the reference rotor (degree 4, corners 0.02 mm) [Hz].
CONVERGED_HZ = 600.449764
SPEEDS = 21
CASES = (
    ("harmonic", 2, 2e-3),
    ("harmonic", 2, 5e-4),
    ("harmonic", 3, 5e-4),
    ("harmonic", 3, 1e-4),
    ("harmonic", 4, 1e-4),
    ("solid", 2, 4e-3),
    ("solid", 2, 2.6e-3),
    ("solid", 2, 1.5e-3),
    ("solid", 2, 7e-4),
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


def measure(level: str, degree: int, corner: float) -> dict:
    """One case: mesh, reduction with prestress, Campbell diagram, and the floors."""
    from mpi4py import MPI

    from solidwhirl.meshing import MeshSize, mesh_meridian, mesh_solid
    from solidwhirl.reduction import ReductionRequest, reduce_body
    from solidwhirl.reduction.operators.matrices import OperatorEffects, build_operators
    from solidwhirl.reduction.solvers.constrained import factorise
    from solidwhirl.rotordyn import Rotor, assemble, campbell

    body = reference_rotor()
    through = 1.2 if level == "solid" else 1.0
    size = MeshSize(
        size_m=0.1, corner_size_m=corner, growth=0.6, through_thickness=through, around=12
    )
    top = 20_000 * np.pi / 30.0
    request = ReductionRequest(
        level=level,
        orders=(1,),
        components=("ux", "uy"),
        degree=degree,
        modes=8,
        maximum_speed_rad_s=top,
        gyroscopic=True,
        centrifugal=True,
    )
    start = time.process_time()
    mesh = (mesh_solid if level == "solid" else mesh_meridian)(body, size)
    meshed = time.process_time()
    element, _ = reduce_body(body, mesh, MPI.COMM_SELF, request, {})
    reduced = time.process_time()
    system = assemble({"rotor": Rotor(element=element, speed_ratio=1.0)}, ())
    campbell(system, np.linspace(0.0, top, SPEEDS), branch_count=10)
    drawn = time.process_time()
    effects = OperatorEffects(
        gyroscopic=False,
        centrifugal=False,
        components={i.name: ("ux", "uy") for i in body.interfaces},
        lateral_only=True,
    )
    order = None if level == "solid" else 1
    operators = build_operators(
        body, mesh, MPI.COMM_SELF, order=order, degree=degree, effects=effects
    )
    floor = time.process_time()
    factor = factorise(operators.stiffness, operators.coupling.rows)
    factored = time.process_time()
    columns = len(element.coordinates) // operators.families
    loads = np.ones((operators.mass.getLocalSize()[0], columns))
    factor.solve(loads, None)
    solved = time.process_time()
    for k in range(columns):
        factor.solve(loads[:, k : k + 1], None)
    single = time.process_time() - solved
    return {
        "level": level,
        "order": degree,
        "corner_mm": 1e3 * corner,
        "unknowns": element.full_dofs,
        "relative_error": element.free_frequencies_hz[0] / CONVERGED_HZ - 1.0,
        "mesh_cpu_s": meshed - start,
        "reduction_cpu_s": reduced - meshed,
        "campbell_cpu_s": drawn - reduced,
        "floor_cpu_s": solved - floor,
        "factorisation_cpu_s": factored - floor,
        "reduction_over_block_floor": (reduced - meshed) / (solved - floor),
        "reduction_over_single_floor": (reduced - meshed) / (factored - floor + single),
        "peak_memory_gib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0**2,
    }


def main() -> None:
    """Run all cases and print a table."""
    if len(sys.argv) > 1:
        level, degree, corner = json.loads(sys.argv[1])
        print(json.dumps(measure(level, degree, corner)))
        return
    head = None
    for case in CASES:
        command = [sys.executable, __file__, json.dumps(case)]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        row = json.loads(done.stdout.splitlines()[-1])
        if head is None:
            head = list(row)
            print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
        cells = (f"{v:.3g}" if isinstance(v, float) else str(v) for v in row.values())
        print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
