"""Direct against iterative: time and memory of the held body's solutions and modes over its size.

    python bench/multigrid.py             all sizes: table and JSON in out/multigrid (half an hour)
    python bench/multigrid.py --small     up to 50 000 unknowns
    python bench/multigrid.py --methods   four ways to the modes without a factorisation, one size
    python bench/multigrid.py --fit       writes the coefficients of the solvers as well, and
                                          docs/data/scaling.json, after bench/ranks.py
    python bench/multigrid.py --reuse --fit   no new measurements

Every case runs in a process of its own; roads of one size run one after the other, so that both see
the same load. Processor time of one thread; memory beyond that of the assembled matrices.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
OUT = ROOT / "out" / "multigrid"
#: Unknowns of the whole solid, all of which are solved for.
SIZES = (30_000, 60_000, 120_000, 250_000, 500_000, 1_000_000)
SMALL = SIZES[:2]
COUNT, LOADS = 12, 8
METHODS = ("lobpcg", "slepc_lobpcg", "slepc_krylovschur_cg", "slepc_jd")


def memory_mib(name: str) -> float:
    """VmRSS or VmHWM of this process."""
    for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines():
        if line.startswith(name):
            return int(line.split()[1]) / 1024.0
    raise SystemExit(f"no {name} here")


def held_body(unknowns: int):
    """Operators of the rotor of bench/scaling.py held at two planes."""
    import scaling_case
    from mpi4py import MPI

    from solidwhirl.meshing import mesh_solid
    from solidwhirl.reduction.operators.matrices import OperatorEffects, build_operators

    body = scaling_case.rotor(2)
    mesh = mesh_solid(body, scaling_case.mesh_size(body, "solid", 2, unknowns))
    effects = OperatorEffects(
        gyroscopic=False,
        centrifugal=False,
        components={i.name: ("ux", "uy") for i in body.interfaces},
        shape="round",
    )
    return build_operators(body, mesh, MPI.COMM_SELF, order=None, degree=2, effects=effects)


def count_cycles() -> list[int]:
    """Have the columns counted that go through the multigrid; the last entry counts."""
    from solidwhirl.reduction.solvers.hierarchy import Hierarchy

    columns, cycle = [0], Hierarchy.cycle

    def counted(self, load, level=0):
        columns[-1] += load.shape[1] if level == 0 else 0
        return cycle(self, load, level)

    Hierarchy.cycle = counted
    return columns


def measure(case: dict) -> dict:
    """One road: setting up, static solutions, modes."""
    from solidwhirl.reduction.basis.overspeed import operator_places
    from solidwhirl.reduction.operators.solver_choice import prepared_solver
    from solidwhirl.reduction.solvers.constrained import ConstrainedFactor, eigenpairs
    from solidwhirl.reduction.solvers.iterative_modes import iterative_pairs
    from solidwhirl.reduction.solvers.vectors import apply

    operators = held_body(case["unknowns"])
    rows = operators.coupling.held
    none = rows[:, :0]
    loads = apply(operators.mass, np.random.default_rng(1).standard_normal((len(rows), LOADS)))
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    before = memory_mib("VmRSS")
    cycles = count_cycles()
    clock = [time.process_time()]
    solver = prepared_solver(
        operators.stiffness,
        operators.stiffness,
        rows,
        lambda: operator_places(operators),
        choice=case["road"],
        free=none,
        momentum=none,
    )
    clock.append(time.process_time())
    cycles.append(0)
    solver.solve(loads, None)
    clock.append(time.process_time())
    cycles.append(0)
    if isinstance(solver, ConstrainedFactor):
        values, _ = eigenpairs(solver, operators.mass, shift=0.0, count=COUNT)
    else:
        values, _ = iterative_pairs(solver, operators.mass, count=COUNT)
    clock.append(time.process_time())
    peak = memory_mib("VmHWM")
    entries = flops = 0.0
    if isinstance(solver, ConstrainedFactor):
        factor = solver.solver.getPC().getFactorMatrix()
        entries = float(factor.getMumpsInfog(29))
        entries = -1e6 * entries if entries < 0.0 else entries
        flops = float(factor.getMumpsRinfog(3))
        factor.destroy()
    return {
        **case,
        "solved": len(rows),
        "stiffness_entries": operators.stiffness.getInfo()["nz_used"],
        "setup_s": clock[1] - clock[0],
        "static_s": (clock[2] - clock[1]) / LOADS,
        "modes_s": clock[3] - clock[2],
        "memory_gib": (peak - before) / 1024.0,
        "matrices_gib": before / 1024.0,
        "solver_gib": solver.memory_bytes / 1024.0**3,
        "factor_entries": entries,
        "factor_flops": flops,
        "static_cycles": cycles[1] / LOADS,
        "modes_cycles": cycles[2],
        "values": [float(v) for v in values[:COUNT]],
    }


def slepc_modes(case: dict) -> dict:
    """Modes by one of SLEPc's methods on the projected pencil, or by the program's own."""
    from petsc4py import PETSc
    from slepc4py import SLEPc

    from solidwhirl.reduction.basis.overspeed import operator_places
    from solidwhirl.reduction.solvers.iterative_modes import iterative_pairs
    from solidwhirl.reduction.solvers.multigrid import constrained_iteration
    from solidwhirl.reduction.solvers.vectors import apply

    operators = held_body(case["unknowns"])
    rows, mass = operators.coupling.held, operators.mass
    none = rows[:, :0]
    held = constrained_iteration(
        operators.stiffness,
        operators.stiffness,
        rows,
        operator_places(operators),
        free=none,
        momentum=none,
    )
    cycles = 0

    class Projected:
        """Q^T A Q with the projection Q on the held fields."""

        def __init__(self, matrix) -> None:
            self.matrix = matrix

        def mult(self, _matrix, x, y) -> None:
            moved = held.cleaned(x.array_r[:, None].copy())
            y.array[:] = held_load(apply(self.matrix, moved))[:, 0]

    def held_load(load):
        weights = np.linalg.solve(held.normals.T @ held.answers, held.answers.T @ load)
        return load - held.normals @ weights

    class Preconditioner:
        def apply(self, _pc, x, y) -> None:
            nonlocal cycles
            cycles += 1
            y.array[:] = held.preconditioned(x.array_r[:, None].copy())[:, 0]

    def shell(matrix):
        out = PETSc.Mat().createPython(matrix.getSizes(), Projected(matrix), comm=matrix.comm)
        out.setUp()
        return out

    start = time.process_time()
    if case["method"] == "lobpcg":
        values, _ = iterative_pairs(held, mass, count=COUNT, tolerance=1e-6)
    else:
        eps = SLEPc.EPS().create(PETSc.COMM_SELF)
        eps.setOperators(shell(operators.stiffness), shell(mass))
        eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
        eps.setDimensions(nev=COUNT)
        eps.setTolerances(tol=1e-6, max_it=2000)
        st = eps.getST()
        ksp = st.getKSP()
        if case["method"] == "slepc_krylovschur_cg":
            eps.setType(SLEPc.EPS.Type.KRYLOVSCHUR)
            eps.setTarget(0.0)
            eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
            st.setType(SLEPc.ST.Type.SINVERT)
            ksp.setType(PETSc.KSP.Type.CG)
            ksp.setTolerances(rtol=1e-9, max_it=500)
        else:
            jd = case["method"] == "slepc_jd"
            eps.setType(SLEPc.EPS.Type.JD if jd else SLEPc.EPS.Type.LOBPCG)
            eps.setWhichEigenpairs(SLEPc.EPS.Which.SMALLEST_REAL)
            st.setType(SLEPc.ST.Type.PRECOND)
            if jd:
                ksp.setType(PETSc.KSP.Type.GMRES)
                ksp.setTolerances(rtol=1e-2, max_it=20)
        pc = ksp.getPC()
        pc.setType(PETSc.PC.Type.PYTHON)
        pc.setPythonContext(Preconditioner())
        first = []
        rng = np.random.default_rng(0)
        for _ in range(COUNT if case["method"] == "slepc_lobpcg" else 1):
            v = operators.stiffness.createVecRight()
            field = held.preconditioned(apply(mass, rng.standard_normal((len(rows), 1))))
            v.array[:] = field[:, 0]
            first.append(v)
        eps.setInitialSpace(first)
        eps.solve()
        found = eps.getConverged()
        values = np.sort([eps.getEigenvalue(k).real for k in range(found)])[:COUNT]
    return {
        **case,
        "solved": len(rows),
        "modes_s": time.process_time() - start,
        "cycles": cycles,
        "values": [float(v) for v in values],
    }


def run(case: dict, limit_s: float = 3600.0) -> dict | None:
    """One case in its own process."""
    command = [sys.executable, __file__, "--case", json.dumps(case)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=limit_s)
    except subprocess.TimeoutExpired:
        print(f"{case}: no end after {limit_s:g} s", flush=True)
        return None
    if done.returncode != 0:
        print(f"{case}: {done.stderr.strip().splitlines()[-1:]}", flush=True)
        return None
    row = json.loads(done.stdout.splitlines()[-1])
    print({k: v for k, v in row.items() if k != "values"}, flush=True)
    return row


def difference(row: dict, other: dict | None) -> float:
    """Largest relative difference of the eigenvalues."""
    if other is None:
        return float("nan")
    count = min(len(row["values"]), len(other["values"]))
    return float(
        np.abs(np.array(row["values"][:count]) / np.array(other["values"][:count]) - 1.0).max()
    )


def table(rows: list[dict]) -> str:
    """Markdown: both roads of every size side by side."""
    head = ("solved for", "solver", "set up [s]", "one solution [s]", f"{COUNT} modes [s]",
            "all [s]", "memory [GiB]", "entries", "eigenvalues differ by")  # fmt: skip
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    direct = {r["unknowns"]: r for r in rows if r["road"] == "direct"}
    for r in rows:
        whole = r["setup_s"] + LOADS * r["static_s"] + r["modes_s"]
        apart = difference(r, direct.get(r["unknowns"])) if r["road"] != "direct" else 0.0
        cells = (r["solved"], r["road"], f"{r['setup_s']:.3g}", f"{r['static_s']:.3g}",
                 f"{r['modes_s']:.3g}", f"{whole:.3g}", f"{r['memory_gib']:.3g}",
                 f"{r['factor_entries']:.3g}", f"{apart:.1e}" if apart else "")  # fmt: skip
        lines.append("| " + " | ".join(str(c) for c in cells) + " |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Measure, or be one case."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--case", help="one case, for the processes that this starts")
    for name, text in (
        ("small", "small sizes only"),
        ("methods", "methods for the modes"),
        ("fit", "write the coefficients"),
        ("reuse", "take the last measurements"),
    ):
        parser.add_argument(f"--{name}", action="store_true", help=text)
    options = parser.parse_args()
    if options.case:
        case = json.loads(options.case)
        print(json.dumps(slepc_modes(case) if "method" in case else measure(case)))
        return
    OUT.mkdir(parents=True, exist_ok=True)
    if options.methods:
        rows = [run({"method": m, "unknowns": 30_000}, 300.0) for m in METHODS]
        found = [r for r in rows if r]
        for r in found:
            print(r["method"], f"{r['modes_s']:.3g} s", r["cycles"], difference(r, found[0]))
        (OUT / "methods.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        return
    stored = OUT / "multigrid.json"
    if options.reuse:
        kept = json.loads(stored.read_text(encoding="utf-8"))
    else:
        kept = []
        for unknowns in SMALL if options.small else SIZES:
            for road in ("direct", "iterative"):
                row = run({"road": road, "unknowns": unknowns})
                kept += [row] if row else []
                stored.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    (OUT / "multigrid.md").write_text(table(kept), encoding="utf-8")
    print(table(kept))
    if options.fit:
        import scale_fit

        print(scale_fit.write_module(ROOT, kept))
        ranks = scale_fit.ranks_table(scale_fit.reductions(ROOT))
        tables = {"roads": table(kept), "ranks": ranks, **scale_fit.cluster_tables()}
        print(scale_fit.write_tables(ROOT, tables))


if __name__ == "__main__":
    main()
