"""Whether refinement ends: random rotors of all sizes and supports, against their forecast.

Every scene runs in a process of its own with limits of time and memory. A line per scene goes to a
file of JSON lines, from which `--table` makes the last table of docs/data/accuracy.json; a run that
was broken off goes on after its last line.

    .venv/bin/python bench/refinement.py --count 300 --out refinement.jsonl
    .venv/bin/python bench/refinement.py --table refinement.jsonl
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

Data = dict[str, Any]
SHAPES = ("slender", "thick", "thin-walled", "stepped")
SUPPORTS = ("free", "once held", "free casing", "soft", "springs", "rigid")
#: Those that have a twin on soft springs.
LOOSE = ("free", "once held", "free casing")
LEVELS = ("harmonic",) * 8 + ("beam", "solid")
DENSITY, MODULUS = 7850.0, 2.1e11


def scene(seed: int, number: int) -> tuple[Data, Data]:
    """One scene by its number, and what it was drawn from."""
    rng = np.random.default_rng([seed, number])
    shape, support = str(rng.choice(SHAPES)), str(rng.choice(SUPPORTS))
    level = str(rng.choice(LEVELS))
    length = float(10.0 ** rng.uniform(-3.0, np.log10(20.0)))
    sections = _sections(rng, shape, length)
    rim = max(s["outer_radius_m"] for s in sections)
    top = float(rng.uniform(20.0, 200.0)) / rim * 30.0 / np.pi
    start = float(rng.choice([0.0, 0.0, rng.uniform(0.1, 1.0)])) * top
    low = -2.5 if level == "solid" else -5.0
    data: Data = {
        "name": f"refinement_{seed}_{number}",
        "model": {"level": level, "accuracy": float(10.0 ** rng.uniform(low, -2.0))},
        "speeds": {"from_rpm": start, "to_rpm": top, "count": 5},
        "campbell": {"branches": int(rng.integers(4, 9))},
        "bodies": {
            "rotor": {
                "material": "steel",
                "sections": sections,
                "interfaces": [
                    {"name": "a", "kind": "section", "at_m": 0.06 * length},
                    {"name": "b", "kind": "section", "at_m": 0.93 * length},
                ],
            }
        },
    }
    mass, stiff = _size(sections, length)
    springs = {"once held": 1.0, "springs": 10.0 ** rng.uniform(-2.0, 1.0), "rigid": 1e4}
    drawn = {"shape": shape, "support": support, "level": level, "length_m": length}
    return _supported(data, support, springs.get(support, 1.0) * stiff, mass), drawn


def soft_twin(data: Data) -> Data:
    """The same rotor on springs a ten-thousandth as stiff as itself."""
    sections = data["bodies"]["rotor"]["sections"]
    mass, stiff = _size(sections, max(s["end_m"] for s in sections))
    bare = {k: v for k, v in data.items() if k not in ("bearings", "rigid_bodies")}
    return _supported({**bare, "name": bare["name"] + "_soft"}, "soft", stiff, mass)


def _sections(rng: np.random.Generator, shape: str, length: float) -> list[Data]:
    """Steps of a shaft, of one radius but for the stepped ones, and their disks."""
    ratio = {"slender": (40, 150), "thick": (1, 6), "thin-walled": (2, 20), "stepped": (6, 40)}
    radius = length / float(rng.uniform(*ratio[shape]))
    count = int(rng.integers(2, 6)) if shape == "stepped" else int(rng.integers(1, 3))
    ends = np.linspace(0.0, length, count + 1)
    low = 0.4 if shape == "stepped" else 0.85
    radii = radius * rng.uniform(low, 1.0, count)
    bore = float(radii.min() * (1.0 - rng.uniform(0.02, 0.1))) if shape == "thin-walled" else 0.0
    out = [
        {
            "name": f"step_{k}",
            "start_m": float(ends[k]),
            "end_m": float(ends[k + 1]),
            "inner_radius_m": bore,
            "outer_radius_m": float(radii[k]),
        }
        for k in range(count)
    ]
    for k in range(count) if shape == "stepped" else ():
        if rng.random() < 0.4:
            middle, width = 0.5 * (ends[k] + ends[k + 1]), rng.uniform(0.05, 0.4) * length / count
            disk = {
                "name": f"disk_{k}",
                "start_m": float(middle - 0.5 * width),
                "end_m": float(middle + 0.5 * width),
                "inner_radius_m": float(radii[k]),
                "outer_radius_m": float(radii[k] + rng.uniform(0.5, 4.0) * radius),
            }
            out.append(disk)
    return out


def _size(sections: list[Data], length: float) -> tuple[float, float]:
    """Mass, and a stiffness of the order of the shaft's own in bending."""
    mass, moments = 0.0, []
    for s in sections:
        inner, outer, span = s["inner_radius_m"], s["outer_radius_m"], s["end_m"] - s["start_m"]
        mass += DENSITY * np.pi * (outer**2 - inner**2) * span
        if s["name"].startswith("step"):
            moments.append(np.pi / 4.0 * (outer**4 - inner**4))
    return float(mass), float(48.0 * MODULUS * np.mean(moments) / length**3)


def _supported(data: Data, support: str, stiffness: float, mass: float) -> Data:
    """The scene with its bearings, in a casing that nothing holds where it is asked for."""
    if support == "free":
        return data
    if support == "soft":
        stiffness *= 1e-4
    names = ("a",) if support == "once held" else ("a", "b")
    bearings = [{"name": n, "first": f"rotor.{n}", "stiffness_n_per_m": stiffness} for n in names]
    if support != "free casing":
        return {**data, "bearings": bearings}
    a, b = (i["at_m"] for i in data["bodies"]["rotor"]["interfaces"])
    casing = {
        "speed_ratio": 0.0,
        "mass_kg": 2.0 * mass,
        "center_of_gravity_m": [0.0, 0.0, 0.5 * (a + b)],
        "inertia_kg_m2": [mass * b**2, mass * b**2, mass * b**2],
        "interfaces": {"a": a, "b": b},
    }
    joined = [{**bearing, "second": f"casing.{bearing['name']}"} for bearing in bearings]
    return {**data, "rigid_bodies": {"casing": casing}, "bearings": joined}


def _one(data: Data) -> Data:
    """Run a scene in this process, and what it took and gave."""
    from solidwhirl.estimates.documents import accuracy_document
    from solidwhirl.pipeline.run import run_scene
    from solidwhirl.scene_reading.reader import parse_scene

    told: Data = {}
    asked = parse_scene(data)
    start = time.process_time()
    results = run_scene(
        asked, foreseen=lambda plan, expected: told.update(forecast_s=expected.seconds)
    )
    spent = time.process_time() - start
    assert results is not None
    accuracy = accuracy_document(asked, results.estimates, results.rounds)
    return {
        **told,
        "cpu_s": spent,
        "asked": accuracy["asked"],
        "estimate": accuracy["largest_error_estimate"],
        "met": accuracy["met"],
        "rounds": [r["largest_error_estimate"] for r in accuracy["rounds"]],
        "stopped": [r["stopped"] for r in accuracy["rounds"] if r["stopped"]],
        "unknowns": sum(results.rounds[-1].unknowns.values()) if results.rounds else 0,
        "memory_gib": results.peak_memory_gib,
        "failed_checks": [c.name for c in results.checks if c.passed is False],
    }


def _in_process(data: Data, cpu_s: float, memory_gib: float) -> Data:
    """Run a scene in a process of its own, within limits."""
    size = int(memory_gib * 2**30)
    start = time.perf_counter()
    with subprocess.Popen(
        [sys.executable, __file__, "--scene", "-"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (size, size)),
    ) as process:
        given: str | None = json.dumps(data)
        while True:  # a limit of the system would make its clock of CPU time too coarse to measure
            try:
                out, errors = process.communicate(given, timeout=1.0)
                break
            except subprocess.TimeoutExpired:
                given = None
            if _spent_s(process.pid) > cpu_s:
                process.kill()
                return {"ended": f"killed after {cpu_s:g} s of CPU"}
    wall = time.perf_counter() - start
    if process.returncode:
        last = (errors.strip().splitlines() or ["no message"])[-1]
        return {"ended": "error", "message": last[:300], "wall_s": wall}
    return {"ended": "yes", "wall_s": wall, **json.loads(out.splitlines()[-1])}


def _spent_s(pid: int) -> float:
    """Processor time of a process."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _run(numbers: range, seed: int, out: Path, limits: tuple[float, float]) -> None:
    """Run scenes that are not in the file yet."""
    lines = out.read_text().splitlines() if out.exists() else []
    known = {json.loads(line)["number"] for line in lines}
    for number in (n for n in numbers if n not in known):
        data, drawn = scene(seed, number)
        record = {"number": number, **drawn, "asked": data["model"]["accuracy"]}
        record |= _in_process(data, *limits)
        if drawn["support"] in LOOSE and record["ended"] == "yes":
            twin = _in_process(soft_twin(data), *limits)
            record["twin_cpu_s"] = twin.get("cpu_s")
            record["twin_met"] = twin.get("met")
        with out.open("a") as file:
            file.write(json.dumps(record) + "\n")
        shown = ("shape", "support", "level", "length_m", "asked", "ended", "met", "estimate")
        print(number, *(record.get(k) for k in (*shown, "cpu_s", "forecast_s", "twin_cpu_s")))


def _table(path: Path) -> str:
    """The last table of docs/data/accuracy.json, in Markdown."""
    records = [json.loads(line) for line in path.read_text().splitlines()]
    head = (
        "| class | scenes | ended | accuracy met | within 3 × forecast "
        "| CPU over forecast: median, largest | within 3 × soft twin |"
    )
    rows = [head, "|---|---|---|---|---|---|---|"]
    for key, values in (
        ("shape", SHAPES),
        ("support", SUPPORTS),
        ("level", ("harmonic", "beam", "solid")),
    ):
        rows += [_row(v, [r for r in records if r[key] == v]) for v in values]
    return "\n".join([*rows, _row("all", records)])


def _row(name: str, records: list[Data]) -> str:
    ended = [r for r in records if r["ended"] == "yes"]
    ratios = np.array([r["cpu_s"] / r["forecast_s"] for r in ended])
    twins = [r["cpu_s"] / r["twin_cpu_s"] for r in ended if r.get("twin_cpu_s")]
    spread = f"{np.median(ratios):.2f}, {ratios.max():.1f}" if len(ratios) else ""
    loose = f"{sum(t <= 3.0 for t in twins)} of {len(twins)}" if twins else ""
    met = sum(bool(r["met"]) for r in ended)
    return (
        f"| {name} | {len(records)} | {len(ended)} | {met} | {int((ratios <= 3.0).sum())} | "
        f"{spread} | {loose} |"
    )


def main() -> None:
    """Run scenes, one scene, or write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("refinement.jsonl"))
    parser.add_argument("--cpu-s", type=float, default=300.0)
    parser.add_argument("--memory-gib", type=float, default=6.0)
    parser.add_argument("--table", type=Path)
    parser.add_argument("--scene", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.scene:
        print(json.dumps(_one(json.load(sys.stdin))))
    elif given.table:
        print(_table(given.table))
    else:
        numbers = range(given.first, given.first + given.count)
        _run(numbers, given.seed, given.out, (given.cpu_s, given.memory_gib))


if __name__ == "__main__":
    main()
