"""Time and memory of both levels against the unknowns, and the coefficients of the cost model.

    python bench/scaling.py               all sizes: table, JSON and picture in out/scaling
    python bench/scaling.py --small       small sizes, some minutes
    python bench/scaling.py --fit         also write solidwhirl/cost/coefficients.py
    python bench/scaling.py --reuse --fit no new measurements
    python bench/scaling.py --only mesh   these again, the rest as it was: harmonic, revolved,
                                          solid, mesh, engine

With --fit the coefficients of what was not measured stay as they are. Every case runs in a process
of its own, one after another; the shortest processor time of the repeats counts. Cases with two
ranks run under mpirun and are shown, not fitted.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
from pathlib import Path

import numpy as np
import scaling_fit

from solidwhirl.core.machine import available_memory_gib, machine_speed

ROOT = Path(__file__).resolve().parents[1]
OUT = ROOT / "out" / "scaling"
CASE = Path(__file__).with_name("scaling_case.py")
SMALL = {
    "harmonic": (5_000, 20_000, 60_000),
    "revolved": (5_000, 20_000, 60_000),
    "solid": (15_000, 40_000, 90_000, 200_000),
}
FULL = {
    "harmonic": (3_000, 10_000, 30_000, 60_000, 100_000, 180_000, 300_000),
    "revolved": (3_000, 10_000, 30_000, 60_000, 100_000, 180_000),
    "solid": (15_000, 30_000, 60_000, 120_000, 240_000, 500_000),
}
#: Cases larger than this run once.
REPEATED = 50_000
REPEATS = 2
MODES, PLANES = 8, 2


def cases(sizes: dict[str, tuple[int, ...]]) -> list[dict]:
    """All cases: sizes; more modes and interfaces; error estimates; meshes; engines."""
    out = []

    def reduction(level, degree, unknowns, *, modes=MODES, planes=PLANES, estimates=(), ranks=1):
        out.append(
            {
                "level": level,
                "degree": degree,
                "unknowns": unknowns,
                "modes": modes,
                "planes": planes,
                "estimates": estimates,
                "ranks": ranks,
            }
        )

    both = ("mode_truncation", "mesh")
    for level, degree in [("harmonic", d) for d in (2, 3, 4)] + [("revolved", d) for d in (2, 3)]:
        for unknowns in sizes[level]:
            reduction(level, degree, unknowns)
        for unknowns in [n for n in sizes[level] if n <= 100_000]:
            reduction(level, degree, unknowns, estimates=both)
        for estimates in ((), both):
            reduction(level, degree, 20_000, modes=30, planes=12, estimates=estimates)
    for unknowns in sizes["solid"]:
        reduction("solid", 2, unknowns)
    reduction("solid", 2, 30_000, modes=20, planes=8)
    for unknowns in (15_000, 60_000):
        reduction("solid", 2, unknowns, estimates=("mode_truncation",))
    if sizes is FULL:
        for unknowns in sizes["solid"][2:]:
            reduction("solid", 2, unknowns, ranks=2)
    flat = (2e-3, 1e-4)
    for kind, corners in (("harmonic", flat), ("revolved", flat), ("solid", (6e-3, 2e-3))):
        for disks in (1, 3, 8):
            for corner in corners:
                out.append({"level": "mesh", "kind": kind, "disks": disks, "corner_m": corner})
    for kind in ("even", "uneven", "damped"):
        for stations in (6, 12, 20, 30)[: 3 if kind == "damped" else 4]:
            out.append({"level": "engine", "kind": kind, "stations": stations})
    return out


def run(case: dict) -> dict:
    """One case in its own process."""
    command = [sys.executable, str(CASE), json.dumps(case)]
    ranks = case.get("ranks", 1)
    if ranks > 1:
        options = ["--allow-run-as-root", "--oversubscribe", "-n", str(ranks)]
        command = ["mpirun", *options, *command]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    if done.returncode != 0:
        raise SystemExit(f"{case}:\n{done.stderr[-3000:]}")
    return {**json.loads(done.stdout.splitlines()[-1]), "key": json.dumps(case)}


def measure(sizes: dict[str, tuple[int, ...]], only: str | None) -> list[dict]:
    """All cases, or those of one level, with their repeats, merged."""
    rows = []
    for case in cases(sizes):
        if only not in (None, case["level"]):
            continue
        repeats = REPEATS if case.get("unknowns", 0) <= REPEATED else 1
        for _ in range(repeats):
            rows.append(run(case))
        print(json.dumps(case), flush=True)
    return scaling_fit.merged(rows)


def this_machine() -> dict:
    """Name and rates of this machine."""
    speeds = [machine_speed() for _ in range(5)]
    model = platform.processor() or platform.machine()
    for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("model name"):
            model = line.partition(":")[2].strip()
            break
    memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 1024.0**3
    return {
        "name": f"{model}, {os.cpu_count()} cores, {memory:.0f} GiB, one thread",
        "gflops": max(s.gflops for s in speeds),
        "gbytes_per_s": max(s.gbytes_per_s for s in speeds),
        "available_gib": available_memory_gib(),
    }


def plain(rows: list[dict]) -> list[dict]:
    """Rows of the picture: reductions without estimates, of the standard basis."""
    return [
        r
        for r in rows
        if r["level"] in scaling_fit.LEVELS
        and not r["estimates"]
        and (r["modes"], r["planes"]) == (MODES, PLANES)
    ]


def series(rows: list[dict]) -> dict[str, list[dict]]:
    """Rows of a curve by its label, by rising unknowns."""
    out: dict[str, list[dict]] = {}
    for row in sorted(plain(rows), key=lambda r: r["made_unknowns"]):
        label = f"{row['level']}, order {row['degree']}"
        label += f", {row['ranks']} ranks" if row["ranks"] > 1 else ""
        out.setdefault(label, []).append(row)
    return out


def value(row: dict, what: str) -> float:
    """Seconds of a reduction or peak memory; wall time where ranks wait for each other."""
    if what == "peak_gib":
        return row["peak_gib"]
    return row["reduction_s"] if row["ranks"] == 1 else row["reduction_wall_s"]


def exponents(rows: list[dict]) -> dict[str, dict[str, float]]:
    """Slope of log time and log memory (beyond the program) over log unknowns, upper half."""
    out = {}
    for label, same in series(rows).items():
        n = np.array([r["made_unknowns"] for r in same])
        kept = n >= np.median(n)
        if kept.sum() < 2:
            continue
        time_s = np.array([value(r, "reduction_s") for r in same])
        gib = np.array([r["peak_gib"] - r["ranks"] * r["base_gib"] for r in same])
        out[label] = {
            "time": float(np.polyfit(np.log(n[kept]), np.log(time_s[kept]), 1)[0]),
            "memory": float(np.polyfit(np.log(n[kept]), np.log(gib[kept]), 1)[0]),
        }
    return out


def table(rows: list[dict], machine: dict) -> str:
    """Markdown of all reductions and of the exponents."""
    head = ("level", "order", "ranks", "unknowns", "columns", "estimates", "mesh [s]",
            "reduction [s]", "peak [GiB]")  # fmt: skip
    lines = [f"Machine: {machine['name']}.", ""]
    lines += ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for r in rows:
        if r["level"] in scaling_fit.LEVELS:
            cells = (r["level"], r["degree"], r["ranks"], r["made_unknowns"], r["columns"],
                     ", ".join(r["estimates"]), f"{r['meshing_s']:.3g}",
                     f"{value(r, 'reduction_s'):.3g}", f"{r['peak_gib']:.3g}")  # fmt: skip
            lines.append("| " + " | ".join(str(c) for c in cells) + " |")
    lines += ["", "Exponents over the unknowns (upper half of the sizes):", ""]
    lines += ["| curve | time | memory |", "|---|---|---|"]
    for label, slopes in exponents(rows).items():
        lines.append(f"| {label} | {slopes['time']:.2f} | {slopes['memory']:.2f} |")
    return "\n".join(lines) + "\n"


def draw(rows: list[dict], path: Path) -> None:
    """Time and memory over the unknowns, both axes logarithmic."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    slopes = exponents(rows)
    figure, axes = plt.subplots(1, 2, figsize=(11.0, 4.5), constrained_layout=True)
    for axis, what, label, slope in (
        (axes[0], "reduction_s", "time of the reduction [s]", "time"),
        (axes[1], "peak_gib", "peak memory [GiB]", "memory"),
    ):
        for name, same in series(rows).items():
            n = [r["made_unknowns"] for r in same]
            power = f" (exponent {slopes[name][slope]:.2f})" if name in slopes else ""
            axis.loglog(n, [value(r, what) for r in same], "o-", label=name + power)
        axis.set_xlabel("unknowns before reduction [1]")
        axis.set_ylabel(label)
        axis.grid(visible=True, which="both", alpha=0.3)
        axis.legend(fontsize="small")
    figure.savefig(path, dpi=150)
    plt.close(figure)


def main() -> None:
    """Measure or reuse, write the results, and the coefficients if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--small", action="store_true", help="small sizes only")
    parser.add_argument("--fit", action="store_true", help="write the coefficients")
    parser.add_argument("--reuse", action="store_true", help="take the last measurements")
    parser.add_argument(
        "--only", help="measure these again: harmonic, revolved, solid, mesh or engine"
    )
    options = parser.parse_args()
    OUT.mkdir(parents=True, exist_ok=True)
    stored = OUT / "scaling.json"
    found = {"rows": []}
    if options.reuse or (options.only and stored.exists()):
        found = json.loads(stored.read_text(encoding="utf-8"))
    rows, machine = found["rows"], found.get("machine") or this_machine()
    if not options.reuse:
        rows = [r for r in rows if r["level"] != options.only]
        rows += measure(SMALL if options.small else FULL, options.only)
        content = {"machine": machine, "exponents": exponents(rows), "rows": rows}
        stored.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    (OUT / "scaling.md").write_text(table(rows, machine), encoding="utf-8")
    draw(rows, OUT / "scaling.png")
    print(table(rows, machine))
    if options.fit:
        path = ROOT / "solidwhirl" / "cost" / "coefficients.py"
        scaling_fit.write_module(path, rows, machine)
        print(f"wrote {path}")


if __name__ == "__main__":
    main()
