"""Settings of the direct solver and of the block Krylov space, on the solid reference rotor.

Prints markdown tables of CPU time and memory; every row runs in a process of its own.
`python bench/solver_settings.py [corner size in mm]`.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time

import numpy as np

SETTINGS = (
    {"type": "cholesky"},
    {"type": "cholesky", "mat_mumps_icntl_7": 6},
    {"type": "cholesky", "mat_mumps_icntl_7": 2},
    {"type": "cholesky", "mat_mumps_icntl_7": 5},
    {"type": "cholesky", "mat_mumps_cntl_1": 0.0},
    {"type": "cholesky", "mat_mumps_icntl_24": 1},
    {"type": "lu"},
)
BLOCKS = (1, 2, 4, 8, 16, 32, 64)
KRYLOV_BLOCKS = (1, 2, 4, 8, 12)


def operators(corner_m: float):
    """Matrices of the reference rotor, lateral motion."""
    from harmonic_and_solid import reference_rotor
    from mpi4py import MPI

    from solidwhirl.meshing import MeshSize, mesh_solid
    from solidwhirl.reduction.operators.matrices import OperatorEffects, build_operators

    body = reference_rotor()
    size = MeshSize(
        size_m=0.1, corner_size_m=corner_m, growth=0.3, through_thickness=2.0, around=16
    )
    effects = OperatorEffects(
        gyroscopic=False,
        centrifugal=False,
        components={i.name: ("ux", "uy") for i in body.interfaces},
        shape="round",
    )
    mesh = mesh_solid(body, size)
    return build_operators(body, mesh, MPI.COMM_SELF, order=None, degree=2, effects=effects)


def measure_factor(corner_m: float, setting: dict) -> dict:
    """Factorise and solve blocks of right-hand sides with PETSc options."""
    from petsc4py import PETSc

    from solidwhirl.reduction.solvers.constrained import bordered

    body = operators(corner_m)
    matrix = bordered(body.stiffness, body.coupling.held)
    kind = setting["type"]
    if kind == "lu":
        matrix = matrix.convert("aij", PETSc.Mat())
    for key, value in setting.items():
        if key != "type":
            PETSc.Options().setValue(key, value)
    solver = PETSc.KSP().create(matrix.comm)
    solver.setOperators(matrix)
    solver.setType("preonly")
    pc = solver.getPC()
    pc.setType(kind)
    pc.setFactorSolverType("mumps")
    pc.setFactorSetUpSolverType()
    start = time.process_time()
    solver.setUp()
    factored = time.process_time()
    factor = pc.getFactorMatrix()
    row = {
        "setting": ", ".join(f"{k.removeprefix('mat_mumps_')} {v}" for k, v in setting.items()),
        "ordering used": factor.getMumpsInfog(7),
        "unknowns": matrix.getSize()[0],
        "factor s": factored - start,
        "Gflop": factor.getMumpsRinfog(3) / 1e9,
        "memory MB": factor.getMumpsInfog(22),
    }
    right = PETSc.Mat().createDense((matrix.getSize()[0], max(BLOCKS)), comm=matrix.comm)
    right.setUp()
    right.setRandom()
    answer = right.duplicate()
    for block in BLOCKS:
        factor.setMumpsIcntl(27, block)
        start = time.process_time()
        factor.matSolve(right, answer)
        row[f"{block}: ms"] = 1e3 * (time.process_time() - start) / max(BLOCKS)
    return row


def measure_krylov(corner_m: float, block: int) -> dict:
    """28 fixed-interface modes with a block size."""
    from solidwhirl.reduction.solvers import block_krylov
    from solidwhirl.reduction.solvers.constrained import eigenpairs, factorise

    body = operators(corner_m)
    factor = factorise(body.stiffness, body.coupling.held)
    block_krylov.BLOCK = block
    start = time.process_time()
    values, _ = eigenpairs(factor, body.mass, shift=0.0, count=28)
    return {
        "Krylov block": block,
        "28 modes s": time.process_time() - start,
        "28th Hz": float(np.sqrt(values[27]) / (2.0 * np.pi)),
    }


def table(corner_m: float, kind: str, cases: tuple) -> None:
    """Run the cases and print a table."""
    head = None
    for case in cases:
        command = [sys.executable, __file__, json.dumps([corner_m, kind, case])]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        row = json.loads(done.stdout.splitlines()[-1])
        if head is None:
            head = list(row)
            print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
        cells = (f"{v:.4g}" if isinstance(v, float) else str(v) for v in row.values())
        print("| " + " | ".join(cells) + " |", flush=True)
    print()


def main() -> None:
    """Both tables, or one row for the parent process."""
    given = sys.argv[1] if len(sys.argv) > 1 else "1.5"
    if given.startswith("["):
        corner, kind, case = json.loads(given)
        measure = measure_factor if kind == "factor" else measure_krylov
        print(json.dumps(measure(corner, case)))
        return
    table(1e-3 * float(given), "factor", SETTINGS)
    table(1e-3 * float(given), "krylov", KRYLOV_BLOCKS)


if __name__ == "__main__":
    main()
