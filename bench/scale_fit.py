"""Measurements of bench/multigrid.py and bench/ranks.py as a module, and laws for the program."""

from __future__ import annotations

import json
import platform
from pathlib import Path

import numpy as np

#: Quantities by road: those that grow with the size of the problem.
QUANTITIES = {
    "direct": ("factor_entries", "memory_gib", "setup_s", "static_s", "modes_s"),
    "iterative": ("memory_gib", "setup_s", "static_s", "modes_s"),
}
_PER = 1e5
# Sizes that say nothing any more.
_FAR = 1e9


def machine_name() -> str:
    """Processor of this machine."""
    for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.machine()


def reductions(root: Path) -> dict[str, list[dict]]:
    """Rows of bench/ranks.py by road."""
    folder = root / "out" / "ranks"
    return {
        road: json.loads((folder / f"{road}.json").read_text(encoding="utf-8"))
        for road in QUANTITIES
        if (folder / f"{road}.json").is_file()
    }


def others(rows: list[dict], held: dict[float, float]) -> float:
    """GiB per 1e5 unknowns solved for of all that is no solver's, from reductions on one rank."""
    found = []
    for row in rows:
        if row["ranks"] == 1:
            solved = row["made_unknowns"] / 2.0
            solver = np.interp(np.log(solved), np.log(list(held)), np.log(list(held.values())))
            own = row["peak_gib"][0] - row["base_gib"] - np.exp(solver)
            found.append(own / solved * _PER)
    return float(max(found))


def more_ranks(rows: list[dict]) -> float:
    """Memory of all ranks over that of one, the program itself left out, at most."""
    one = {r["unknowns"]: r["peak_gib"][0] - r["base_gib"] for r in rows if r["ranks"] == 1}
    return max(
        [1.0]
        + [(sum(r["peak_gib"]) - r["ranks"] * r["base_gib"]) / one[r["unknowns"]] for r in rows]
    )


def write_module(root: Path, rows: list[dict]) -> Path:
    """Write bench/scale_coefficients.py from the rows of both roads, and the program's laws."""
    by_road = {
        road: sorted((r for r in rows if r["road"] == road), key=lambda r: r["solved"])
        for road in QUANTITIES
    }
    last = by_road["direct"][-1]
    lines = [
        '"""Growth of both solvers of a solid, written by `python bench/multigrid.py --fit`."""',
        "",
        "from __future__ import annotations",
        "",
        "#: Where it was measured, on one thread.",
        f'MACHINE = "{machine_name()}"',
        "#: Entries of a row of the stiffness, and modes of one eigensolution.",
        f"ROW_ENTRIES, MODES = {last['stiffness_entries'] / last['solved']:.4g}, "
        f"{len(last['values'])}",
        "#: By road and quantity, over the unknowns solved for; seconds of one solution, 12 modes.",
        "MEASURED: dict[str, dict[str, tuple[float, ...]]] = {",
    ]
    for road, names in QUANTITIES.items():
        lines.append(f'    "{road}": {{')
        for name in ("solved", *names):
            values = ", ".join(f"{r[name]:.4g}" if name != "solved" else str(r[name])
                               for r in by_road[road])  # fmt: skip
            lines.append(f'        "{name}": ({values}),')
        lines.append("    },")
    lines.append("}")
    whole = reductions(root)
    held = {r["solved"]: r["memory_gib"] for r in by_road["direct"]}
    direct = whole["direct"]
    # of several sizes the slope: the mesher itself takes some
    sizes = {r["made_unknowns"]: r["meshing_peak_gib"] - r["base_gib"] for r in direct}
    if len(sizes) > 1:
        mesh = float(np.polyfit(list(sizes), list(sizes.values()), 1)[0])
    else:
        mesh = max(gib / n for n, gib in sizes.items())
    # multigrid takes no less than a factorisation, which is measured on more ranks
    factors = ", ".join(
        f'"{road}": {max(more_ranks(r) for r in (whole.get(road, direct), direct)):.3g}'
        for road in QUANTITIES
    )
    lines += [
        "#: GiB of the program on each rank; of a reduction's matrices and vectors and of the mesh",
        "#: on rank 0 while it is made, per 1e5 unknowns solved for.",
        f"PROGRAM_GIB = {np.mean([r['base_gib'] for r in direct]):.3g}",
        f"OTHERS_GIB, MESH_GIB = {others(direct, held):.3g}, {2.0 * mesh * _PER:.3g}",
        "#: Memory of several ranks over that of one, the program left out.",
        f"RANKS_FACTOR = {{{factors}}}",
    ]
    path = root / "bench" / "scale_coefficients.py"
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    write_laws(root)
    return path


def write_laws(root: Path) -> None:
    """Write solidwhirl/cost/solver_coefficients.py: what the program predicts solvers with."""
    from scale_laws import law, measured

    names = ["direct.memory_gib", *(f"iterative.{q}" for q in QUANTITIES["iterative"])]
    laws = {name: law(*name.split(".")) for name in names}
    lines = [
        '"""Growth of both solvers of a solid, written by `python bench/multigrid.py --fit`."""',
        "",
        "from __future__ import annotations",
        "",
        "#: Modes of one eigensolution, and unknowns solved for in the largest measurement.",
        f"MODES, LARGEST = {measured.MODES}, {next(iter(laws.values())).largest:.0f}",
        '#: "solver.quantity": GiB or s at 1e5 unknowns solved for, their power as fitted, and by '
        "theory.",
        "SOLVERS: dict[str, tuple[float, float, float]] = {",
        *(f'    "{n}": ({v.value:.6g}, {v.power:.6g}, {v.theory:.6}),' for n, v in laws.items()),
        "}",
    ]
    path = root / "solidwhirl" / "cost" / "solver_coefficients.py"
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")


def write_tables(root: Path, tables: dict[str, str]) -> Path:
    """Write Markdown tables as rows of docs/data/scaling.json."""
    path = root / "docs" / "data" / "scaling.json"
    parts = []
    for name, table in tables.items():
        columns, _, *rows = ([c.strip() for c in line.strip("|").split("|")]
                             for line in table.strip().splitlines())  # fmt: skip
        shown = ",\n".join(f"      {json.dumps(row)}" for row in rows)
        parts.append(f'  "{name}": {{\n    "columns": {json.dumps(columns)},\n'
                     f'    "rows": [\n{shown}\n    ]\n  }}')  # fmt: skip
    path.write_text("{\n" + ",\n".join(parts) + "\n}\n", encoding="utf-8")
    return path


def ranks_table(whole: dict[str, list[dict]]) -> str:
    """Memory and time of reductions on several ranks, both roads, Markdown."""
    lines = [
        "| unknowns of the mesh | solver | ranks | rank 0 [GiB] | the others, at most [GiB] | "
        "all [GiB] | wall [s] | processor time of a rank [s] | fixed-interface modes differ by |",
        "|" + "---|" * 9,
    ]
    for road, rows in whole.items():
        one = {r["unknowns"]: np.array(r["held_hz"]) for r in rows if r["ranks"] == 1}
        for r in rows:
            peaks, apart = r["peak_gib"], ""
            if r["ranks"] > 1 and len(one.get(r["unknowns"], ())):
                difference = np.abs(np.array(r["held_hz"]) / one[r["unknowns"]] - 1.0).max()
                apart = f"{difference:.0e}"
            others = f"{max(peaks[1:]):.3g}" if peaks[1:] else ""
            cells = (r["made_unknowns"], road, r["ranks"], f"{peaks[0]:.3g}", others,
                     f"{sum(peaks):.3g}", f"{r['wall_s']:.3g}", f"{max(r['busy_s']):.3g}",
                     apart)  # fmt: skip
            lines.append("| " + " | ".join(str(c) for c in cells) + " |")
    return "\n".join(lines) + "\n"


def cluster_tables() -> dict[str, str]:
    """What the laws say of 5 and 50 million unknowns, from the module as it is written now."""
    from scale_table import (
        Cluster,
        equal_time,
        factor_limit,
        scale_markdown,
        scale_table,
    )

    nodes = Cluster(cores_per_node=64, memory_per_node_gib=256.0)
    limits = ["| | unknowns solved for |", "|---|---|"]
    for count in (1, 4, 16):
        low, high = factor_limit(nodes, count)
        limits.append(f"| a factor fits {count} such node{'s'[: count > 1]} up to | "
                      f"{low:.2g} to {high:.2g} |")  # fmt: skip
    expected, least, largest = equal_time()
    until = f"to {largest:.2g}" if largest < _FAR else "or more"
    limits.append(f"| the iteration takes less processor time from | {expected:.2g} "
                  f"({least:.2g} {until}) |")  # fmt: skip
    rows = scale_table((5e5, 5e6, 5e7), nodes)
    return {"cluster": scale_markdown(rows), "limits": "\n".join(limits) + "\n"}
