"""Ordinary rotors at the solid level: checks, accuracy and cost, beside the harmonic level.

    .venv/bin/python bench/ordinary_rotors.py --out ordinary.json
    .venv/bin/python bench/ordinary_rotors.py --only free_shaft micro
    .venv/bin/python bench/ordinary_rotors.py --table ordinary.json

Every rotor is run in a process of its own: at the solid level, at the harmonic level of the same
accuracy, whose processor time is the measure, and at the harmonic level of accuracy 1e-5 with
elements of order 4, whose diagram and critical speeds are the truth (`true_errors`). Rotors with
features have no harmonic level; the truth is a finer solid.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import true_errors

from solidwhirl.estimates.documents import accuracy_document
from solidwhirl.pipeline.run import Results
from solidwhirl.scene.records import Scene
from solidwhirl.scene_reading.reader import parse_scene

Data = dict[str, Any]
ROOT = Path(__file__).resolve().parents[1]
ACCURACY, REFERENCE_ACCURACY = 2e-3, 1e-5
#: Accuracy of the finer run of a body with features, over that of the run.
FINER = 0.2
HEAD = (
    "rotor | sectors | unknowns | rounds | estimate | error | smallest, median and largest "
    "estimate over error | met | failed checks | CPU [s] | forecast [s] | CPU over that of the "
    "harmonic level | memory [GiB] | forecast [GiB]"
)


def rotors() -> dict[str, Data]:
    """Scenes by name, without model; the twin rotor and the turbocharger are those of scenes/."""
    return {
        "overhung_disk": _one(
            [("shaft", 0.0, 0.6, 0.05), ("disk", 0.6, 0.68, 0.35)], {"a": 0.1, "b": 0.45}, 6000, 1e8
        ),
        "thin_drum": _one(
            [
                ("left", 0.0, 0.15, 0.03),
                ("left_web", 0.15, 0.156, 0.25),
                ("drum", 0.156, 0.55, 0.25, 0.247),
                ("right_web", 0.55, 0.556, 0.25),
                ("right", 0.556, 0.7, 0.03),
            ],
            {"a": 0.05, "b": 0.65},
            6000,
            1e8,
        ),
        "disk_stack": _one(
            [
                ("shaft", 0.0, 1.2, 0.04),
                *((f"disk_{k}", 0.3 + 0.12 * k, 0.32 + 0.12 * k, 0.2, 0.04) for k in range(6)),
            ],
            {"a": 0.1, "b": 1.1},
            9000,
            [1e8, 6e7],
        ),
        "turbocharger": _of_scenes("turbocharger"),
        "free_shaft": _one(
            [
                ("end", 0.0, 0.2, 0.03),
                ("middle", 0.2, 0.6, 0.05),
                ("disk", 0.35, 0.38, 0.18, 0.05),
                ("journal", 0.6, 0.9, 0.025),
            ],
            {"a": 0.05, "b": 0.85},
            12000,
        ),
        "micro": _one(
            [("shaft", 0.0, 1e-3, 5e-5), ("disk", 4e-4, 5e-4, 4e-4, 5e-5)],
            {"a": 1e-4, "b": 9e-4},
            1_000_000,
            5e4,
        ),
        "turbine_shaft": _one(
            [
                ("drive", 0.0, 4.0, 0.25),
                ("body", 4.0, 14.0, 0.5),
                ("wheel_1", 6.0, 6.4, 0.9, 0.5),
                ("wheel_2", 11.0, 11.4, 1.0, 0.5),
                ("end", 14.0, 20.0, 0.28),
            ],
            {"a": 1.0, "b": 18.5},
            3000,
            [2e9, 1e9],
            [2e6, 1e6],
        ),
        "flanged_tube": _one(
            [("tube", 0.0, 1.0, 0.06, 0.05), ("flange", 1.0, 1.03, 0.12, 0.05)],
            {"a": 0.1, "b": 0.8},
            9000,
            5e7,
            coupling="rigid",
        ),
        "cone": _one(
            [
                ("shaft", 0.0, 0.3, 0.03),
                ("cone", 0.3, 0.5, (0.04, 0.15), (0.02, 0.142)),
                ("ring", 0.5, 0.52, 0.16, 0.142),
            ],
            {"a": 0.04, "b": 0.25},
            15000,
            1e8,
        ),
        "once_held": _one(
            [("shaft", 0.0, 0.8, 0.03), ("disk", 0.3, 0.34, 0.2, 0.03)], {"a": 0.1}, 9000, 1e7
        ),
        "two_materials": _one(
            [
                ("shaft", 0.0, 0.5, 0.02, 0.0, "steel"),
                ("wheel", 0.2, 0.24, 0.15, 0.02, "aluminium"),
                ("blisk", 0.36, 0.38, 0.12, 0.02, "titanium"),
            ],
            {"a": 0.05, "b": 0.45},
            20000,
            [5e7, 5e7],
            [500.0, 500.0],
        ),
        "twin_rotor": _of_scenes("ferraris"),
        "drilled_disk": _drilled(),
    }


def _one(
    sections: list[tuple[Any, ...]],
    interfaces: dict[str, float],
    top_rpm: float,
    stiffness_n_per_m: float | list[float] | None = None,
    damping_n_s_per_m: list[float] | None = None,
    *,
    coupling: str = "distributing",
) -> Data:
    """One body of sections (name, start, end, outer, inner radius, material) on its bearings."""
    keys = ("name", "start_m", "end_m", "outer_radius_m", "inner_radius_m", "material")
    bearing = {"stiffness_n_per_m": stiffness_n_per_m}
    if damping_n_s_per_m:
        bearing["damping_n_s_per_m"] = damping_n_s_per_m
    held = interfaces if stiffness_n_per_m else {}
    return {
        "speeds": {"to_rpm": top_rpm, "count": 7},
        "campbell": {"branches": 8},
        "bodies": {
            "rotor": {
                "material": "steel",
                "sections": [dict(zip(keys, s, strict=False)) for s in sections],
                "interfaces": [
                    {"name": n, "kind": "section", "at_m": z, "coupling": coupling}
                    for n, z in interfaces.items()
                ],
            }
        },
        "bearings": [{"name": n, "first": f"rotor.{n}", **bearing} for n in held],
    }


def _drilled() -> Data:
    """A disk with lightening holes on a shaft."""
    data = _one(
        [("shaft", 0.0, 0.4, 0.025), ("disk", 0.18, 0.21, 0.15, 0.025)],
        {"a": 0.05, "b": 0.35},
        12000,
        5e7,
    )
    hole = {"in": "disk", "count": 8, "pitch_radius_m": 0.09, "diameter_m": 0.04}
    data["bodies"]["rotor"]["holes"] = [{"name": "light", **hole}]
    return data


def _of_scenes(name: str) -> Data:
    """A scene of the folder scenes/, without model and analyses."""
    data = tomllib.loads((ROOT / "scenes" / f"{name}.toml").read_text(encoding="utf-8"))
    return {k: v for k, v in data.items() if k not in ("model", "analyses", "operating", "name")}


def scene_of(name: str, accuracy: float = ACCURACY) -> Scene:
    """A rotor of the list as a scene at the solid level."""
    model = {"level": "solid", "accuracy": accuracy}
    return parse_scene({"name": name, **rotors()[name], "model": model})


def failed(results: Results) -> list[str]:
    """Checks of a run that do not hold."""
    return [
        f"{c.name}: {c.value:.1e}, allowed {c.limit:.1e}"
        for c in results.checks
        if c.passed is False
    ]


def counted(results: Results, finer: Results) -> list[true_errors.Pair]:
    """Estimates beside errors of all that is not critically damped."""
    rule = results.estimates.rule
    branches = rule.counts(results.campbell.eigenvalues)
    speeds = [c.critical.counts(rule) for c in results.critical_speeds]
    kept = {"campbell": lambda p: branches[p], "critical_speed": lambda p: speeds[p[0]]}
    pairs = true_errors.pairs(results, finer)
    return [p for p in pairs if p.kind in kept and kept[p.kind](p.place)]


def measure(name: str) -> Data:
    """One rotor at both levels, and against the truth."""
    scene = scene_of(name)
    found, spent = true_errors.run(scene, level="solid")
    accuracy = accuracy_document(scene, found.estimates, found.rounds, found.checks)
    row = {
        "rotor": name,
        "sectors": [b.mesh.sector.count for b in found.bodies.values()],
        "unknowns": _unknowns(found),
        "rounds": [r.estimate for r in found.rounds],
        "stopped": [r.stopped for r in found.rounds if r.stopped],
        "estimate": accuracy["largest_error_estimate"],
        "met": accuracy["met"],
        "failed_checks": failed(found),
        "cpu_s": spent,
        "forecast_s": found.forecast.seconds,
        "memory_gib": found.peak_memory_gib,
        "forecast_gib": found.forecast.peak_memory_gib,
    }
    if any(b.features for b in found.geometry.values()):
        finer, row["reference_cpu_s"] = true_errors.run(
            scene, level="solid", accuracy=FINER * ACCURACY
        )
    else:
        other, row["harmonic_cpu_s"] = true_errors.run(scene)
        row["harmonic_unknowns"] = _unknowns(other)
        finer, row["reference_cpu_s"] = true_errors.run(
            scene, accuracy=REFERENCE_ACCURACY, order=true_errors.REFERENCE_ORDER
        )
    compared = counted(found, finer)
    row["error"] = true_errors.largest(compared, "true")
    # smaller errors have no part in the accuracy
    ratios = [p.effectivity for p in compared if p.known and p.true > 0.05 * ACCURACY]
    row["effectivity"] = [min(ratios), float(np.median(ratios)), max(ratios)] if ratios else []
    row["compared"] = len(ratios)
    return row


def _unknowns(results: Results) -> int:
    return sum(b.element.full_dofs for b in results.bodies.values())


def _in_process(name: str) -> Data:
    """Measure a rotor in a process of its own, on one thread."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, __file__, "--measure", name],
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        return {"rotor": name, "refused": last[:300]}
    return json.loads(done.stdout.splitlines()[-1])


def table(rows: list[Data]) -> str:
    """The rows as Markdown."""
    lines = [f"| {HEAD} |", "|" + "---|" * (HEAD.count("|") + 1)]
    for r in rows:
        if "refused" in r:
            lines.append(f"| {r['rotor']} | refused: {r['refused']} |")
            continue
        ratio = f"{r['cpu_s'] / r['harmonic_cpu_s']:.1f}" if "harmonic_cpu_s" in r else ""
        cells = [
            r["rotor"],
            "/".join(str(n) for n in r["sectors"]),
            str(r["unknowns"]),
            " ".join(f"{e:.1e}" for e in r["rounds"]),
            f"{r['estimate']:.2e}",
            f"{r['error']:.2e}",
            ", ".join(f"{v:.2f}" for v in r["effectivity"]),
            str(r["met"]),
            "; ".join(r["failed_checks"]) or "none",
            f"{r['cpu_s']:.1f}",
            f"{r['forecast_s']:.1f}",
            ratio,
            f"{r['memory_gib']:.2f}",
            f"{r['forecast_gib']:.2f}",
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main() -> None:
    """Measure and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", metavar="ROTOR")
    parser.add_argument("--out", type=Path, help="rows as JSON")
    parser.add_argument("--table", type=Path, help="measure nothing, print the table of rows")
    parser.add_argument("--measure", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.measure:
        print(json.dumps(measure(given.measure)))
        return
    if given.table:
        print(table(json.loads(given.table.read_text(encoding="utf-8"))))
        return
    rows = []
    for name in given.only or rotors():
        rows.append(_in_process(name))
        print(table(rows[-1:]).splitlines()[-1], flush=True)
        if given.out:
            given.out.write_text(json.dumps(rows), encoding="utf-8")
    print(table(rows))


if __name__ == "__main__":
    main()
