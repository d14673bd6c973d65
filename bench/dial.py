"""The accuracy dial against fixed settings: error within what is asked, and at what price.

    python bench/dial.py                               three scenes, 1e-2 to 1e-5
    python bench/dial.py --scenes ferraris --accuracies 1e-2 1e-3
    python bench/dial.py --quick                       a quarter of the fixed settings
    python bench/dial.py --table                       table of what was measured before

For every scene and accuracy the dial runs once. All fixed settings of a grid (element order, corner
size, growth, largest size, modes) run too; the cheapest whose true error is not above what the dial
achieved, and not above the accuracy, is what the dial is held against. Times are processor times
of the runs, without loading the program. Every measurement is kept in out/dial.
"""

from __future__ import annotations

import argparse
import itertools
import json
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import true_errors
from effectivity import fixed_scenes

from solidwhirl.model.bodies import build_bodies
from solidwhirl.pipeline.run import Results
from solidwhirl.scene.records import Scene

ROOT = Path(__file__).resolve().parents[1]
OUT = ROOT / "out" / "dial"
ACCURACIES = (1e-2, 1e-3, 1e-4, 1e-5)
#: Fixed settings: orders, corner sizes over the thinnest section, growth, largest element over the
#: length of the body, modes.
ORDERS = (2, 3, 4)
CORNERS = (1.0, 0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4)
GROWTHS = (0.5, 0.8)
SIZES = (0.25,)
MODES = (4, 8, 16)
QUICK = {"growth": 0.8, "modes": 16}


def thinnest(scene: Scene) -> float:
    """Smallest dimension of any section of the scene [m]."""
    out = []
    for body in build_bodies(scene).values():
        for s in body.sections:
            radial = [o - i for i, o in zip(s.inner_radius_m, s.outer_radius_m, strict=True)]
            out.append(min(s.end_m - s.start_m, max(radial)))
    return min(out)


def longest(scene: Scene) -> float:
    """Largest length of a body [m]."""
    bodies = build_bodies(scene).values()
    return max(
        max(s.end_m for s in b.sections) - min(s.start_m for s in b.sections) for b in bodies
    )


def settings(scene: Scene, accuracy: float) -> list[dict[str, Any]]:
    """Fixed settings to be tried for an accuracy, the likely cheap ones first."""
    thickness, length = thinnest(scene), longest(scene)
    out = []
    for modes, growth, size, order, corner in itertools.product(
        MODES, GROWTHS, SIZES, ORDERS, CORNERS
    ):
        # a corner's error is about 2e-2 of its relative size: far coarser or finer is no use
        if not 0.02 * accuracy < 2e-2 * corner < 300.0 * accuracy:
            continue
        out.append(
            {
                "order": order,
                "corner_size_m": corner * thickness,
                "size_m": max(size * length, corner * thickness),
                "growth": growth,
                "modes": modes,
            }
        )
    return out


def measured(scene: Scene, finer: Results, model: dict[str, Any]) -> dict[str, Any]:
    """Processor time and errors of one run; what is refused has no time."""
    try:
        results, seconds = true_errors.run(scene, **model)
    except ValueError as error:
        return {"model": model, "refused": str(error)}
    found = true_errors.pairs(results, finer)
    last = results.rounds[-1]
    return {
        "model": model,
        "cpu_s": seconds,
        "true": true_errors.largest(found, "true"),
        "doubt": true_errors.largest(found, "doubt"),
        "estimate": true_errors.largest(found, "estimate"),
        "rounds": len(results.rounds),
        "unknowns": sum(last.unknowns.values()),
        "modes": max(last.modes.values()),
    }


def measure(
    scene: Scene, accuracies: tuple[float, ...], only: Mapping[str, Any] = MappingProxyType({})
) -> None:
    """Measure what is not there yet of one scene; of the settings those that have these entries."""
    OUT.mkdir(parents=True, exist_ok=True)
    path = OUT / f"{scene.name}.json"
    record = json.loads(path.read_text()) if path.exists() else {"scene": scene.name, "runs": []}
    known = {json.dumps(r["model"], sort_keys=True) for r in record["runs"]}
    wanted: list[dict[str, Any]] = [{"accuracy": a} for a in accuracies]
    fixed = [model for a in accuracies for model in settings(scene, a)]
    wanted += [model for model in fixed if only.items() <= model.items()]
    new = {json.dumps(m, sort_keys=True): m for m in wanted}
    todo = [model for key, model in new.items() if key not in known]
    if not todo:
        return
    finer, _ = true_errors.reference(scene, min(accuracies))
    for model in todo:
        run = measured(scene, finer, model)
        record["runs"].append(run)
        path.write_text(json.dumps(record))
        print(scene.name, run, flush=True)
    _without_estimates(scene, record, accuracies)
    path.write_text(json.dumps(record))


def cheapest(runs: list[dict], accuracy: float, achieved: float) -> dict | None:
    """Cheapest fixed setting that is as accurate as the dial."""
    fixed = [r for r in runs if "accuracy" not in r["model"] and "cpu_s" in r]
    good = [r for r in fixed if r["true"] <= min(accuracy, max(achieved, 0.0))]
    return min(good, key=lambda r: r["cpu_s"], default=None)


def _without_estimates(scene: Scene, record: dict, accuracies: tuple[float, ...]) -> None:
    """Time the cheapest settings with estimates off."""
    for accuracy in accuracies:
        for _, best in _lines_of(record, accuracy):
            if best is not None and "cpu_off_s" not in best:
                _, best["cpu_off_s"] = true_errors.run(scene, estimates="off", **best["model"])


def _lines_of(record: dict, accuracy: float) -> list[tuple[dict, dict | None]]:
    """The dial's run, and the cheapest fixed ones for its own error and for the accuracy."""
    own = [r for r in record["runs"] if r["model"] == {"accuracy": accuracy} and "cpu_s" in r]
    return [
        (run, cheapest(record["runs"], accuracy, limit))
        for run in own
        for limit in (run["true"], accuracy)
    ]


def table(records: list[dict], accuracies: tuple[float, ...]) -> list[str]:
    """Markdown: errors of the dial, and its price against fixed settings."""
    lines = [
        "| scene | accuracy | error | estimate | rounds | unknowns | modes | CPU s "
        "| fixed, same error s | ratio | fixed, within accuracy s | ratio "
        "| order / corner mm / growth / modes |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for record in records:
        for accuracy in accuracies:
            found = _lines_of(record, accuracy)
            if not found:
                continue
            run = found[0][0]
            cells = [
                record["scene"],
                f"{accuracy:g}",
                f"{run['true']:.1e}",
                f"{run['estimate']:.1e}",
            ]
            cells += [f"{run[k]}" for k in ("rounds", "unknowns", "modes")] + [
                f"{run['cpu_s']:.2f}"
            ]
            said = "none found"
            for _, best in found:
                if best is None:
                    cells += ["-", "-"]
                    continue
                cells += [f"{best['cpu_s']:.2f}", f"{run['cpu_s'] / best['cpu_s']:.2f}"]
                m = best["model"]
                said = (
                    f"{m['order']} / {1e3 * m['corner_size_m']:.3g} / {m['growth']} / {m['modes']}"
                )
            lines.append("| " + " | ".join([*cells, said]) + " |")
    return lines


def main() -> None:
    """Measure and write the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--scenes", nargs="+")
    parser.add_argument("--accuracies", type=float, nargs="+", default=ACCURACIES)
    parser.add_argument("--table", action="store_true", help="measure nothing")
    parser.add_argument("--quick", action="store_true", help="fewer fixed settings")
    chosen = parser.parse_args()
    accuracies = tuple(chosen.accuracies)
    scenes = [s for s in fixed_scenes() if chosen.scenes is None or s.name in chosen.scenes]
    if not chosen.table:
        for scene in scenes:
            measure(scene, accuracies, QUICK if chosen.quick else {})
    files = [OUT / f"{scene.name}.json" for scene in scenes]
    records = [json.loads(path.read_text()) for path in files if path.exists()]
    lines = table(records, accuracies)
    (OUT / "dial.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
