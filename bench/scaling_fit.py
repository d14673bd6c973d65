"""From the measurements of bench/scaling.py to the coefficients of the cost model.

Seconds and memory follow power laws of the unknowns; every call of a factorisation, an assembly or
an eigen-solution is one observation. Repeats of a case are merged by taking the shortest time.
"""

from __future__ import annotations

import json
from collections import defaultdict
from pathlib import Path

import numpy as np
from scipy.optimize import lsq_linear, nnls

from solidwhirl.core.machine import MachineSpeed
from solidwhirl.cost import coefficients as present

#: Unknowns and columns that the coefficients are given at.
UNKNOWNS, COLUMNS = 1e5, 10.0
#: Powers of unknowns and columns where the measurements do not span a factor of three or 1.5.
DEFAULTS = {
    "assembly": (1.0, 0.0),
    "factorisation": (1.3, 0.0),
    "static_solutions": (1.1, 1.0),
    "eigensolutions": (1.1, 1.0),
    "projection": (1.0, 1.0),
    "estimate": (1.0, 1.0),
}
#: Least and largest powers of the unknowns: linear work, and fill of a nested dissection in 3D.
POWERS = {
    "assembly": (0.95, 1.3),
    "factorisation": (1.0, 2.0),
    "static_solutions": (1.0, 1.4),
    "eigensolutions": (1.0, 1.6),
    "projection": (0.95, 1.3),
    "estimate": (0.95, 1.3),
}
#: The same of the columns: no work per column to orthogonalisation of all.
COLUMN_POWERS = (0.0, 2.0)
#: Powers of memory that are tried: N log N in the plane, up to N^(4/3) and more in space.
MEMORY_POWERS = {"harmonic": (1.0, 1.3), "revolved": (1.0, 1.3), "solid": (1.1, 1.5)}
#: Matrices of a lateral reduction with all effects on, as `solidwhirl.model.effects` counts them.
MATRICES = {"harmonic": 7, "revolved": 3, "solid": 5}
#: Meshes of a body: its meridian, half a sector, the whole.
LEVELS = tuple(MATRICES)
#: Stages whose time is fitted against the columns, too.
BY_COLUMNS = ("static_solutions", "eigensolutions", "projection", "estimate")
#: Observations below this number of unknowns, or this time, are overhead.
SMALLEST, SHORTEST_S = 3000, 1e-3


def merged(rows: list[dict]) -> list[dict]:
    """Repeats of one case as one row with the shortest times."""
    groups = defaultdict(list)
    for row in rows:
        groups[row["key"]].append(row)
    out = []
    for same in groups.values():
        best = dict(same[0])
        for name, value in best.items():
            if name.endswith("_s") or name.endswith("_per_speed") or name == "peak_gib":
                best[name] = min(row[name] for row in same)
            if name == "calls":
                best[name] = [
                    {**call, "seconds": min(row["calls"][k]["seconds"] for row in same)}
                    for k, call in enumerate(value)
                ]
        out.append(best)
    return out


def observations(rows: list[dict]) -> dict[str, list[tuple[float, float, float]]]:
    """(unknowns, columns, seconds) by "level.order.stage"."""
    found = defaultdict(list)
    for row in rows:
        if row["level"] not in LEVELS or row["ranks"] > 1:
            continue
        made, level = row["made_unknowns"], row["level"]
        sums: dict[str, float] = defaultdict(float)
        largest, solved = made, 0
        for call in row["calls"]:
            stage, n = call["stage"], call["unknowns"]
            largest = max(largest, n)
            if stage in ("projection", "estimate", "eigensolutions"):
                sums[stage] += call["seconds"]
                solved = max(solved, n if stage == "eigensolutions" else 0)
                continue
            if stage == "assembly":
                call = {**call, "seconds": call["seconds"] / MATRICES[level]}
            degree = row["degree"] + (n > 1.2 * made)
            found[f"{level}.{degree}.{stage}"].append((n, call["columns"], call["seconds"]))
        # at rest and at the top speed; pairs as `solidwhirl.cost.work` counts them
        pairs = 3 * row["modes"] + 4 if level == "solid" else row["modes"] + 2
        eigen = (solved, pairs, sums.pop("eigensolutions") / 2.0)
        found[f"{level}.{row['degree']}.eigensolutions"].append(eigen)
        for stage, seconds in sums.items():
            n = largest if stage == "estimate" else made
            found[f"{level}.{row['degree']}.{stage}"].append((n, row["columns"], seconds))
    return dict(found)


def power_law(stage: str, points: list[tuple[float, float, float]]) -> tuple[float, float, float]:
    """Seconds at 1e5 unknowns and 10 columns, and the powers of both.

    The logarithm of the time is fitted; a power that the points can not tell is the default.
    """
    table = np.array([p for p in points if p[0] >= SMALLEST and p[2] >= SHORTEST_S] or points)
    default = DEFAULTS[stage]
    x = np.log(table[:, 0] / UNKNOWNS)
    y = np.log(np.maximum(table[:, 1], 1.0) / COLUMNS)
    t = np.log(np.maximum(table[:, 2], 1e-9))
    free = (
        np.ptp(x) > np.log(3.0),
        stage in BY_COLUMNS and np.ptp(y) > np.log(1.5),
    )
    given = sum(p * v for p, v, wanted in zip(default, (x, y), free, strict=True) if not wanted)
    columns = [np.ones(len(t))] + [v for v, wanted in zip((x, y), free, strict=True) if wanted]
    limits = [(-np.inf, np.inf)] + [
        limit for limit, wanted in zip((POWERS[stage], COLUMN_POWERS), free, strict=True) if wanted
    ]
    bounds = tuple(zip(*limits, strict=True))
    solved = list(lsq_linear(np.column_stack(columns), t - given, bounds=bounds).x)
    factor = float(np.exp(solved.pop(0)))
    powers = [solved.pop(0) if wanted else p for p, wanted in zip(default, free, strict=True)]
    return factor, float(powers[0]), float(powers[1])


def laws(rows: list[dict]) -> dict[str, tuple[float, float, float]]:
    """Power laws of all stages."""
    return {
        name: power_law(name.rsplit(".", 1)[1], points)
        for name, points in sorted(observations(rows).items())
    }


def relative_fit(design: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, float]:
    """Coefficients >= 0 with the least relative error, and its root mean square."""
    scaled = design / values[:, None]
    solution, _ = nnls(scaled, np.ones(len(values)))
    return solution, float(np.sqrt(np.mean((scaled @ solution - 1.0) ** 2)))


def meshing(rows: list[dict]) -> dict[str, tuple[float, float, float]]:
    """Seconds per mesh, per cell, and per cell and graded place."""
    out = {}
    for level in LEVELS:
        graded = [r for r in rows if r["level"] == "mesh" and r["kind"] == level]
        cells, places = (np.array([r[k] for r in graded]) for k in ("cells", "graded_places"))
        design = np.column_stack([np.ones(len(cells)), cells, cells * places])
        fit, _ = relative_fit(design, np.array([r["meshing_s"] for r in graded]))
        out[level] = tuple(float(c) for c in fit)
    return out


def memory(rows: list[dict]) -> dict[str, tuple[float, float, float]]:
    """GiB at 1e5 unknowns beyond the program itself, its power, and copies of the columns."""
    groups = defaultdict(list)
    for row in rows:
        if row["level"] in LEVELS and row["ranks"] == 1:
            own = "estimate" if "mesh" in row["estimates"] else "reduction"
            groups[f"{row['level']}.{row['degree']}.{own}"].append(row)
    out = {}
    for name, same in sorted(groups.items()):
        n, m = (np.array([r[k] for r in same]) for k in ("made_unknowns", "columns"))
        used = np.array([r["peak_gib"] - r["base_gib"] for r in same])
        fits = []
        low, high = MEMORY_POWERS[same[0]["level"]]
        for power in np.linspace(low, high, 9):
            design = np.column_stack([(n / UNKNOWNS) ** power, 8.0 * n * m / 1024.0**3])
            fit, error = relative_fit(design, used)
            fits.append((error, float(fit[0]), float(power), float(fit[1])))
        out[name] = min(fits)[1:]
    return out


def write_module(path: Path, rows: list[dict], machine: dict) -> None:
    """Write the coefficients as the module that `solidwhirl.cost.work` reads.

    What was not measured keeps its coefficients, and the machine that they are of; times of this
    one are then converted to it.
    """
    kept = {*LEVELS, "mesh", "engine"} - {r["level"] for r in rows}
    factor, name = 1.0, machine["name"]
    if kept:
        here = MachineSpeed(gflops=machine["gflops"], gbytes_per_s=machine["gbytes_per_s"])
        there = MachineSpeed(gflops=present.GFLOPS, gbytes_per_s=present.GBYTES_PER_S)
        factor, name = here.relative_to(there), present.MACHINE
        machine = {"gflops": present.GFLOPS, "gbytes_per_s": present.GBYTES_PER_S}
    work = [r for r in rows if r["level"] in LEVELS]
    base = present.BASE_GIB if kept else float(np.median([r["base_gib"] for r in work]))
    largest = present.LARGEST | {
        level: max(r["made_unknowns"] for r in work if r["level"] == level)
        for level in LEVELS
        if level not in kept
    }

    def with_kept(found: dict, before: dict) -> dict:
        own = {k: v for k, v in before.items() if k.partition(".")[0] in kept}
        return dict(sorted({**own, **found}.items()))

    of_laws = {k: (factor * s, *powers) for k, (s, *powers) in laws(rows).items()}
    of_meshes = present.MESHING if "mesh" in kept else meshing(rows)

    def table(title: str, kind: str, values: dict[str, tuple[float, ...]]) -> str:
        lines = [f"{title}: dict[str, {kind}] = {{"]
        for key, row in values.items():
            lines.append(f'    "{key}": ({", ".join(f"{v:.4g}" for v in row)}),')
        return "\n".join([*lines, "}"])

    three = "tuple[float, float, float]"
    text = f'''"""Coefficients of the cost model, written by `python bench/scaling.py --fit`."""

from __future__ import annotations

#: Where they were measured, and the rates of one core there [1e9/s, 1e9 bytes/s].
MACHINE = "{name}"
GFLOPS, GBYTES_PER_S = {machine["gflops"]:.4g}, {machine["gbytes_per_s"]:.4g}
#: Largest number of unknowns measured, by level; beyond it the laws are extrapolated.
LARGEST = {json.dumps(largest)}
#: Memory of the program with its solvers [GiB].
BASE_GIB = {base:.4g}
#: "level.order.stage": seconds at 1e5 unknowns and 10 columns, powers of unknowns and columns.
{table("LAWS", three, with_kept(of_laws, present.LAWS))}
#: Level: seconds per mesh, per cell, and per cell and graded place.
{table("MESHING", three, of_meshes)}
#: "level.order.what": GiB at 1e5 unknowns, its power, and copies of the columns of the basis.
{table("MEMORY", three, with_kept(memory(rows), present.MEMORY))}
'''
    path.write_text(text, encoding="utf-8")
