"""Effectivity of the error estimates: estimate over true error, on fixed scenes and random rotors.

    python bench/effectivity.py                     fifty rotors of seed 1 and the fixed scenes
    python bench/effectivity.py --count 10 --seed 2 --accuracies 1e-2 1e-3
    python bench/effectivity.py --table             tables of what was measured before
    python bench/effectivity.py --beams --count 26 --seed 7     the beam level

The true error is the difference from a run of the same scene at a twentieth of the finest accuracy
with elements of order 4, whose own estimate counts as doubt: errors it can not tell to a fifth are
left out. Every scene's result is kept in out/effectivity and not measured again.

Beams are held against the harmonic level at 1e-3, and nothing of them is kept.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

import numpy as np
import random_rotors
import true_errors
from true_errors import Pair

from solidwhirl.scene.records import Scene
from solidwhirl.scene_reading.reader import parse_scene, read_scene

ROOT = Path(__file__).resolve().parents[1]
OUT = ROOT / "out" / "effectivity"
ACCURACIES = (1e-2, 1e-3, 1e-4)
#: Steel shaft with a disk, free, of the verification page.
REFERENCE_ROTOR = {
    "name": "reference_rotor",
    "speeds": {"to_rpm": 20_000, "count": 5},
    "campbell": {"branches": 10},
    "bodies": {
        "rotor": {
            "material": "steel",
            "sections": [
                {"name": "shaft", "start_m": 0.0, "end_m": 0.4, "outer_radius_m": 0.02},
                {
                    "name": "disk",
                    "start_m": 0.145,
                    "end_m": 0.175,
                    "inner_radius_m": 0.02,
                    "outer_radius_m": 0.15,
                },
            ],
            "interfaces": [
                {"name": "left", "kind": "section", "at_m": 0.0},
                {"name": "right", "kind": "section", "at_m": 0.4},
            ],
        }
    },
}
KINDS = ("campbell", "critical_speed", "at_rest")


def fixed_scenes() -> list[Scene]:
    """The reference rotor, the twin rotor and the LP unit."""
    files = [read_scene(ROOT / "scenes" / f"{name}.toml") for name in ("ferraris", "uhbr_lp")]
    return [parse_scene(REFERENCE_ROTOR), *files]


def measure(scene: Scene, accuracies: tuple[float, ...]) -> dict:
    """Pairs of estimates and errors of one scene at some accuracies."""
    reference, seconds = true_errors.reference(scene, min(accuracies))
    record = {
        "scene": scene.name,
        "reference_estimate": reference.rounds[-1].estimate,
        "reference_cpu_s": seconds,
        "runs": [],
    }
    for accuracy in accuracies:
        results, seconds = true_errors.run(scene, accuracy=accuracy)
        found = true_errors.pairs(results, reference)
        record["runs"].append(
            {
                "accuracy": accuracy,
                "cpu_s": seconds,
                "rounds": len(results.rounds),
                "unknowns": dict(results.rounds[-1].unknowns),
                "pairs": [asdict(pair) for pair in found],
            }
        )
    return record


def collect(scenes: list[Scene], accuracies: tuple[float, ...]) -> list[dict]:
    """Measure what is not there yet; what is refused (a `ValueError`) is listed and left out."""
    OUT.mkdir(parents=True, exist_ok=True)
    found = []
    for scene in scenes:
        path = OUT / f"{scene.name}.json"
        if path.exists():
            found.append(json.loads(path.read_text()))
            continue
        try:
            record = measure(scene, accuracies)
        except ValueError as error:
            record = {"scene": scene.name, "refused": str(error), "runs": []}
        path.write_text(json.dumps(record))
        found.append(record)
        print(scene.name, record.get("refused", ""), flush=True)
    return found


def runs(records: list[dict], accuracy: float) -> Iterator[tuple[str, list[Pair]]]:
    """Pairs of all scenes at one accuracy."""
    for record in records:
        for run in record["runs"]:
            if run["accuracy"] == accuracy:
                yield record["scene"], [Pair(**pair) for pair in run["pairs"]]


def distribution(values: np.ndarray, total: int) -> str:
    """Cells of a table: how many, smallest, median, largest, shares below 1, in 1 to 3, above."""
    if not len(values):
        return f"0 of {total} | | | | | | |"
    inside = np.mean((values >= 1.0) & (values <= 3.0))
    cells = [
        f"{len(values)} of {total}",
        *(f"{v:.2f}" for v in np.quantile(values, [0.0, 0.5, 1.0])),
    ]
    shares = [np.mean(values < 1.0), inside, np.mean(values > 3.0)]
    return " | ".join([*cells, *(f"{100 * share:.1f} %" for share in shares)]) + " |"


def table(title: str, records: list[dict], accuracies: tuple[float, ...]) -> list[str]:
    """Effectivity of the largest error of every scene, and of all frequencies one by one."""
    lines = [
        f"### {title}",
        "",
        "| accuracy | of | count | smallest | median | largest | below 1 | 1 to 3 | above 3 |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for accuracy in accuracies:
        found = list(runs(records, accuracy))
        if not found:
            continue
        worst = [
            true_errors.largest(p, "estimate") / true_errors.largest(p, "true")
            for _, p in found
            if p
        ]
        lines.append(
            f"| {accuracy:g} | largest error | {distribution(np.array(worst), len(found))}"
        )
        for kind in KINDS:
            own = [q for _, p in found for q in p if q.kind == kind]
            values = np.array([q.effectivity for q in own if q.known])
            lines.append(f"| | {kind.replace('_', ' ')} | {distribution(values, len(own))}")
        missed = [name for name, p in found if true_errors.largest(p, "true") > accuracy]
        lines.append(f"| | scenes whose error exceeds the accuracy | {len(missed)} | | | | | | |")
    return [*lines, ""]


def worst_cases(records: list[dict], accuracies: tuple[float, ...], count: int = 12) -> list[str]:
    """Frequencies furthest outside 1 to 3."""
    rows = []
    for accuracy in accuracies:
        for name, found in runs(records, accuracy):
            for q in found:
                if q.known and not 1.0 <= q.effectivity <= 3.0:
                    part = max(q.parts, key=lambda p: q.parts[p])
                    rows.append((abs(np.log(q.effectivity / 1.7)), accuracy, name, q, part))
    rows.sort(key=lambda row: -row[0])
    return [
        f"| {name} | {accuracy:g} | {q.kind} {q.place} | {q.frequency_hz:.5g} | {q.true:.1e} | "
        f"{q.estimate:.1e} | {q.effectivity:.2f} | {part} |"
        for _, accuracy, name, q, part in rows[:count]
    ]


def beams(scenes: list[Scene]) -> Iterator[str]:
    """Lines of a table of the beam level: estimate over error, rotor by rotor, and of all."""
    yield "| rotor | frequencies | underestimated | least ratio | median | largest error | note |"
    yield "|---|---|---|---|---|---|---|"
    every: list[float] = []
    for scene in scenes:
        try:
            results, _ = true_errors.run(scene, level="beam", accuracy=1e-2)
            finer, _ = true_errors.run(scene, accuracy=1e-3)
        except ValueError as error:
            yield f"| {scene.name} | | | | | | {error} |"
            continue
        found = [pair for pair in true_errors.pairs(results, finer) if pair.known]
        every += (own := [pair.effectivity for pair in found])
        error = max((pair.true for pair in found), default=np.nan)
        yield f"| {scene.name} | {beam_cells(own)} | {error:.1e} | |"
    yield f"| all | {beam_cells(every)} | | |"


def beam_cells(ratios: list[float]) -> str:
    """Cells of the table: how many, how many below 1, smallest, median."""
    values = np.array(ratios)
    least, median = (values.min(), np.median(values)) if values.size else (np.nan, np.nan)
    return f"{values.size} | {(values < 1.0).sum()} | {least:.2f} | {median:.1f}"


def main() -> None:
    """Measure and write tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--accuracies", type=float, nargs="+", default=ACCURACIES)
    parser.add_argument("--table", action="store_true", help="measure nothing")
    parser.add_argument("--beams", action="store_true", help="the beam level of random rotors")
    parser.add_argument("--no-fixed", action="store_true", help="random rotors only")
    chosen = parser.parse_args()
    if chosen.beams:
        for line in beams(random_rotors.scenes(chosen.count, chosen.seed)):
            print(line, flush=True)
        return
    accuracies = tuple(chosen.accuracies)
    if not chosen.table:
        rotors = random_rotors.scenes(chosen.count, chosen.seed)
        collect(rotors + ([] if chosen.no_fixed else fixed_scenes()), accuracies)
    files = [json.loads(path.read_text()) for path in sorted(OUT.glob("*.json"))]
    random = [r for r in files if r["scene"].startswith(f"random_{chosen.seed}_")]
    lines = table(f"Random rotors, seed {chosen.seed}", random, accuracies)
    for record in files:
        if not record["scene"].startswith("random_"):
            lines += table(record["scene"], [record], accuracies)
    lines += ["| scene | accuracy | place | Hz | error | estimate | effectivity | part |"]
    lines += ["|---|---|---|---|---|---|---|---|", *worst_cases(files, accuracies)]
    (OUT / "effectivity.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
