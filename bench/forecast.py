"""The forecast beside what runs take: all scenes and some random rotors, each run cold.

    python bench/forecast.py              measure what is not measured yet, and print the table
    python bench/forecast.py --again      measure everything again (half an hour)
    python bench/forecast.py --repeats 3  on a machine where other programs run
    python bench/forecast.py --fit        fit solidwhirl/cost/run_coefficients.py, after measuring
    python bench/forecast.py --leave-one-out   forecast each by a fit to all others
    python bench/forecast.py --seed 11    with other random rotors than the fit is made of
    python bench/forecast.py --only ferraris random_7_3

Each run is a process of its own (bench/forecast_run.py), whose ledger stays in out/forecast. The
calibration of the machine is measured first where none is kept. Ratios are truth over forecast.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from forecast_run import read

from solidwhirl.cost.forecast import Forecast, forecast
from solidwhirl.cost.machine import REFERENCE, Machine, kept_calibration, this_machine
from solidwhirl.meshing.imported.records import AnyBody
from solidwhirl.model.bodies import build_bodies
from solidwhirl.model.effects import make_plan
from solidwhirl.model.mesh_bodies import build_mesh_bodies
from solidwhirl.model.plan_records import Plan
from solidwhirl.scene.records import Scene

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "out" / "forecast"
SEED, RANDOM = 7, 30
LONGEST_S = 3000.0
#: What a forecast is held against: stages of the run.
STAGES = ("start", "bodies", "engine", "analyses", "writing")
_ENGINE = ("assembly", "campbell", "critical_speeds", "error_estimates")


@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """A scene that was run, its plan, and its ledger."""

    name: str
    scene: Scene
    plan: Plan
    bodies: dict[str, AnyBody]
    ledger: dict[str, Any]

    def spent(self) -> dict[tuple[str, str], list[float]]:
        """Processor seconds of each stage of each body or analysis, time by time."""
        out = defaultdict(list)
        events = self.ledger["events"]
        for event, after in pairwise(events):
            out[event["stage"], event["body"]].append(after["cpu_s"] - event["cpu_s"])
        return dict(out)

    def analyses(self) -> dict[str, float]:
        """Processor seconds of each analysis, with the bodies that it reduces again."""
        out: dict[str, float] = {}
        events, current = self.ledger["events"], ""
        for event, after in pairwise(events):
            if event["stage"] == "writing":
                break
            current = event["body"] if event["stage"] == "analysis" else current
            if current:
                spent = after["cpu_s"] - event["cpu_s"]
                out[current] = out.get(current, 0.0) + spent
        return out

    @property
    def start_s(self) -> float:
        """Until the level of the bodies was known."""
        return float(self.ledger["events"][0]["cpu_s"])

    def truth(self) -> dict[str, float]:
        """Processor seconds by stage; see STAGES."""
        spent, analyses = self.spent(), self.analyses()
        engine = sum(sum(spent.get((stage, ""), [])) for stage in _ENGINE)
        writing = sum(spent["writing", ""])
        last = self.ledger["events"][-1]["cpu_s"]
        rest = last - self.start_s - engine - writing - sum(analyses.values())
        parts = (self.start_s, rest, engine, sum(analyses.values()), writing)
        return dict(zip(STAGES, parts, strict=True))


def foretold(found: Forecast) -> dict[str, float]:
    """Predicted seconds by stage; see STAGES."""
    last = found.last or found.first
    rounds = [last, *([found.first] if found.last else [])]
    bodies = sum(cost.total_s for one in rounds for cost in one.bodies.values())
    own = sum(cost.total_s for cost in last.bodies.values())
    solvers = last.whole.seconds["import_solvers"]
    engine = last.whole.total_s - own - solvers
    analyses = sum(cost.seconds for cost in found.analyses.values())
    writing = found.writing.files_s + found.writing.page_s
    return dict(
        zip(STAGES, (found.start_s, bodies + solvers, engine, analyses, writing), strict=True)
    )


def wanted(only: list[str] | None, seed: int = SEED) -> dict[str, Path]:
    """Scene files by name; random rotors of a seed are written as JSON."""
    out = {}
    for path in sorted((ROOT / "scenes").glob("*.toml")):
        if "[sweep]" not in path.read_text(encoding="utf-8"):
            out[path.stem] = path
    FOLDER.mkdir(parents=True, exist_ok=True)
    for number in range(RANDOM):
        name = f"random_{seed}_{number}"
        path = FOLDER / f"{name}.scene.json"
        if not path.is_file():
            from random_rotors import scene

            drawn = scene(seed, number).model_dump_json(exclude_unset=True, exclude_none=True)
            path.write_text(drawn + "\n", encoding="utf-8")
        out[name] = path
    return {name: path for name, path in out.items() if not only or name in only}


def measure(name: str, path: Path, repeats: int = 1) -> None:
    """Run one scene in processes of its own, and keep the ledger of the shortest run.

    Beside other programs the same run takes up to twice the processor time.
    """
    script, fresh = Path(__file__).with_name("forecast_run.py"), FOLDER / f"{name}.fresh.json"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    shortest = np.inf
    for _ in range(repeats):
        print(f"run {name}", file=sys.stderr, flush=True)
        subprocess.run(
            [sys.executable, str(script), str(path), str(fresh)],
            check=True, timeout=LONGEST_S, env=environment, stdout=subprocess.DEVNULL,
        )  # fmt: skip
        spent = json.loads(fresh.read_text(encoding="utf-8"))["events"][-1]["cpu_s"]
        if spent < shortest:
            shortest = spent
            fresh.replace(FOLDER / f"{name}.json")
    fresh.unlink(missing_ok=True)


def cases(names: dict[str, Path]) -> Iterator[Case]:
    """What is measured of these scenes."""
    for name, path in names.items():
        ledger = FOLDER / f"{name}.json"
        if not ledger.is_file():
            continue
        document = json.loads(ledger.read_text(encoding="utf-8"))
        scene = read(str(path))
        bodies = build_bodies(scene)
        levels = {document["levels"][n] for n, b in bodies.items() if not b.features}
        plan = make_plan(scene, bodies, next(iter(levels), None))
        every = {**bodies, **build_mesh_bodies(scene)}
        yield Case(name=name, scene=scene, plan=plan, bodies=every, ledger=document)


@dataclass(frozen=True, kw_only=True)
class Pair:
    """What was said of a run, and what it took."""

    name: str
    told: dict[str, float]
    took: dict[str, float]
    memory: tuple[float, float]

    @property
    def ratio(self) -> float:
        """Truth over forecast."""
        return sum(self.took.values()) / sum(self.told.values())


def pair(case: Case, machine: Machine) -> Pair:
    """Forecast a run that was measured."""
    found = forecast(case.scene, case.plan, case.bodies, machine=machine)
    memory = (found.peak_memory_gib, case.ledger["peak_memory_gib"])
    return Pair(name=case.name, told=foretold(found), took=case.truth(), memory=memory)


def others_told(cases: list[Case]) -> list[Pair]:
    """Forecast each run by coefficients that were fitted to all others."""
    from forecast_fit import fitted, using

    out = []
    for case in cases:
        with using(fitted([other for other in cases if other is not case])):
            out.append(pair(case, REFERENCE))
    return out


def table(pairs: list[Pair]) -> None:
    """Print forecast and truth, by stage, and how far the worst is off."""
    print("| scene | forecast s | took s | ratio | " + " | ".join(STAGES) + " | memory GiB |")
    print("|" + "---|" * (5 + len(STAGES)))
    for one in pairs:
        cells = [f"{one.told[s]:.2g} / {one.took[s]:.2g}" for s in STAGES]
        sums = f"{sum(one.told.values()):.3g} | {sum(one.took.values()):.3g}"
        memory = " / ".join(f"{gib:.2g}" for gib in one.memory)
        print(f"| {one.name} | {sums} | {one.ratio:.2f} | {' | '.join(cells)} | {memory} |")
    off = np.array([max(one.ratio, 1.0 / one.ratio) for one in pairs])
    print(f"\nwithin 1.5: {int(np.count_nonzero(off <= 1.5))} of {off.size}; ", end="")
    print(f"median {np.median(off):.2f}, worst {off.max():.2f}")
    for stage in STAGES:
        both = [(one.told[stage], one.took[stage]) for one in pairs]
        large = [max(a / b, b / a) for a, b in both if min(a, b) > 0.0 and max(a, b) > 0.3]
        if large:
            print(f"{stage}: median {np.median(large):.2f}, worst {max(large):.2f}")


def main() -> None:
    """Measure, fit, compare."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--again", action="store_true", help="measure everything again")
    parser.add_argument("--fit", action="store_true", help="fit the coefficients of runs")
    parser.add_argument("--leave-one-out", action="store_true", help="by a fit to all other runs")
    parser.add_argument("--seed", type=int, default=SEED, help="of the random rotors")
    parser.add_argument("--only", nargs="*", help="these scenes alone")
    parser.add_argument("--repeats", type=int, default=1, help="runs of each, the shortest counts")
    parser.add_argument("--measured", action="store_true", help="measure nothing")
    asked = parser.parse_args()
    if not asked.measured and (asked.again or kept_calibration() is None):
        subprocess.run([sys.executable, "-m", "solidwhirl", "doctor", "--calibrate"], check=True)
    names = wanted(asked.only, asked.seed)
    if not asked.measured:
        for name, path in names.items():
            if asked.again or not (FOLDER / f"{name}.json").is_file():
                measure(name, path, asked.repeats)
    found = list(cases(names))
    if asked.fit:
        from forecast_fit import fitted, using, write

        values = fitted(found)
        write(values, ROOT / "solidwhirl" / "cost" / "run_coefficients.py")
        with using(values):
            table([pair(case, REFERENCE) for case in found])
        return
    table(others_told(found) if asked.leave_one_out else [pair(c, this_machine()) for c in found])


if __name__ == "__main__":
    main()
