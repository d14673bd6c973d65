"""Solids on 1, 2 and 4 ranks: time of every stage and memory of every rank.

    python bench/ranks.py                   whole meshes, tables in out/ranks
    python bench/ranks.py --body sector     sectors of a rotor, a plane of symmetry in each
    python bench/ranks.py --body staggered  sectors of a disk with blades across
    python bench/ranks.py --small           without the largest size
    python bench/ranks.py --iterative       whole meshes without a factorisation

Ranks of one size run one after another, so that they see about the same load; ratios within a size
count. Ranks beyond the cores of the machine show memory only.
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
OUT = ROOT / "out" / "ranks"
#: Unknowns by what is meshed
SIZES = {
    "whole": (30_000, 100_000, 300_000),
    "sector": (10_000, 30_000, 100_000),
    "staggered": (10_000, 30_000, 100_000),
}
RANKS = (1, 2, 4)
ENVIRONMENT = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",
    "OPENBLAS_NUM_THREADS": "1",
}


def peak_gib() -> float:
    """Largest memory of this process since the last reset."""
    for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines():
        if line.startswith("VmHWM"):
            return int(line.split()[1]) / 1024.0**2
    raise SystemExit("the system does not tell")


def reset_peak() -> None:
    """Have the system forget the largest memory of this process."""
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")


def meshed(case: dict) -> tuple:
    """Body and mesh of about so many unknowns."""
    import scaling_case

    from solidwhirl.meshing import MeshSize, mesh_revolved, mesh_solid
    from solidwhirl.meshing.own.features.sector import mesh_sector
    from solidwhirl.model.bodies import build_bodies
    from solidwhirl.scene_reading.reader import read_scene

    body = scaling_case.rotor(2)
    if case["body"] == "staggered":
        body = build_bodies(read_scene(ROOT / "scenes" / "bladed_disk.toml"))["disk"]
        edge = 0.004 * (18_500 / case["unknowns"]) ** (1.0 / 2.4)  # as meshes turned out
        size = MeshSize(size_m=edge, corner_size_m=edge, growth=1.0)
        return body, mesh_sector(body, size)
    level = "revolved" if case["body"] == "sector" else "solid"
    size = scaling_case.mesh_size(body, level, 2, case["unknowns"])
    if level == "revolved":
        return body, mesh_revolved(body, size)
    mesh = mesh_solid(body, size)
    return scaling_case.whole_body(body, mesh), mesh


def measure(case: dict) -> dict | None:
    """One reduction on the ranks that run this; rank 0 returns the row."""
    import scaling_case
    from mpi4py import MPI

    from solidwhirl.reduction import ReductionRequest, reduce_body

    comm = MPI.COMM_WORLD
    base = peak_gib()
    body, mesh = meshed(case) if comm.rank == 0 else (None, None)
    peak = peak_gib()
    body = comm.bcast(body)
    comm.barrier()
    reset_peak()
    request = ReductionRequest(
        level="solid",
        orders=(1,),
        components=("ux", "uy"),
        degree=2,
        modes=8,
        maximum_speed_rad_s=scaling_case.TOP_RAD_S,
        gyroscopic=True,
        centrifugal=True,
        solver=case["solver"],
    )
    start, busy = time.perf_counter(), time.process_time()
    element, work = reduce_body(body, mesh, comm, request, {})
    wall, busy = time.perf_counter() - start, time.process_time() - busy
    peaks = comm.gather((peak_gib(), busy, base, peak))
    if comm.rank:
        return None
    return {
        **case,
        "made_unknowns": element.full_dofs,
        "wall_s": wall,
        "busy_s": [p[1] for p in peaks],
        "stages_s": dict(work.seconds),
        "peak_gib": [p[0] for p in peaks],
        "base_gib": peaks[0][2],
        "meshing_peak_gib": peaks[0][3],
        "held_hz": [float(f) for f in element.fixed_interface_frequencies_hz],
        "free_hz": [float(f) for f in element.free_frequencies_hz],
    }


def run(case: dict) -> dict:
    """One case under mpirun."""
    command = ["mpirun", "-n", str(case["ranks"]), sys.executable, "-m", "mpi4py", __file__]
    command += ["--case", json.dumps(case)]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        check=False,
        timeout=1800.0,
        env={**os.environ, **ENVIRONMENT},
    )
    if done.returncode != 0:
        raise SystemExit(f"{case}:\n{done.stderr[-3000:]}")
    row = json.loads(next(line for line in done.stdout.splitlines() if line.startswith("{")))
    shown = ("made_unknowns", "ranks", "wall_s", "busy_s", "stages_s", "peak_gib")
    print({k: row[k] for k in shown}, flush=True)
    return row


def table(rows: list[dict]) -> str:
    """Markdown."""
    head = ("unknowns", "ranks", "wall [s]", "busy of a rank [s]", "speed-up",
            "peak of rank 0 [GiB]", "of the others [GiB]", "modes differ by")  # fmt: skip
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    one = {r["unknowns"]: r for r in rows if r["ranks"] == 1}
    for r in rows:
        first = one[r["unknowns"]]
        apart = np.abs(np.array(r["held_hz"]) / np.array(first["held_hz"]) - 1.0).max()
        others = r["peak_gib"][1:]
        ratio = first["wall_s"] / r["wall_s"]
        cells = (r["made_unknowns"], r["ranks"], f"{r['wall_s']:.3g}", f"{max(r['busy_s']):.3g}",
                 f"{ratio:.2f}", f"{r['peak_gib'][0]:.3g}", f"{max(others, default=0.0):.3g}",
                 f"{apart:.0e}")  # fmt: skip
        lines.append("| " + " | ".join(str(c) for c in cells) + " |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Measure, or be one case."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--case", help="one case, for the processes that this starts")
    parser.add_argument("--body", choices=tuple(SIZES), default="whole", help="what is meshed")
    parser.add_argument("--small", action="store_true", help="without the largest size")
    parser.add_argument("--iterative", action="store_true", help="without a factorisation")
    options = parser.parse_args()
    if options.case:
        row = measure(json.loads(options.case))
        if row is not None:
            print(json.dumps(row))
        return
    solver, body = "iterative" if options.iterative else "direct", options.body
    name = solver if body == "whole" else body
    OUT.mkdir(parents=True, exist_ok=True)
    rows = []
    for unknowns in SIZES[body][:2] if options.small else SIZES[body]:
        for ranks in RANKS:
            case = {"body": body, "unknowns": unknowns, "ranks": ranks, "solver": solver}
            rows.append(run(case))
            (OUT / f"{name}.json").write_text(json.dumps(rows, indent=1) + "\n", "utf-8")
    (OUT / f"{name}.md").write_text(table(rows), encoding="utf-8")
    print(table(rows))


if __name__ == "__main__":
    main()
