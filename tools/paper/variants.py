"""Other units that the printed numbers allow: as good as the identified one, or with more asked."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.cache.files import StageStore
from solidwhirl.core.stages import silent
from solidwhirl.identify.model import InfeasibleError, Model, lean_scene, model_scene
from solidwhirl.identify.problem import Problem, TargetSpec, read_problem
from solidwhirl.identify.search import search
from solidwhirl.pipeline.cached_stages import StageCache
from solidwhirl.pipeline.run import Results, run_scene
from solidwhirl.rotordyn import modes_at_speed

ROOT = Path(__file__).resolve().parents[2]
# Units that are sought, steps that bring one back to the targets, and its distance from the
# identified one in the unit cube of the parameters.
UNITS, _STEPS, _AWAY = 4, 3, 0.35
#: Directions in which they are sought
TRIES = 4 * UNITS
#: Units of which a second variant is sought, those without a published frequency, and the number of
#: models that each may ask
SEARCHED = {"hp": 60, "fan": 300}
# Tolerance of the frequency that is wanted of it.
_REACHED = 0.05
# Fixed-interface pairs that are kept for each pair that is asked for.
_KEPT = 3


@dataclass(frozen=True, kw_only=True, eq=False)
class Turning:
    """Modes of a unit at a speed in fixed axes, and how far the unit is from the identified one."""

    frequency_hz: list[float]
    whirl: list[str]
    away: float


def problem_of(unit: str) -> tuple[Problem, dict[str, Any]]:
    """Return the identification problem of a unit and the record of its solution."""
    folder = ROOT / "scenes" / "identify"
    record = (folder / f"uhbr_{unit}.identification.json").read_text(encoding="utf-8")
    return read_problem(folder / f"uhbr_{unit}.toml"), json.loads(record)


def equally_good(unit: str, speed_rpm: float, store: StageStore) -> list[Turning]:
    """Return units with the same masses and frequencies at rest, the identified one first.

    They lie along directions that the targets do not see, brought back by Newton steps until all
    targets are those of the identified unit to their tolerances.
    """
    problem, record = problem_of(unit)
    model = Model(problem, store)
    model.limit = None
    start = model.point({p["name"]: p["value"] for p in record["parameters"]})
    slopes = _slopes(record)
    accuracy = problem.spec.settings.coarse_accuracy
    wanted = model.whole(start, accuracy)
    units = [_turning(model, start, speed_rpm, 0.0, store)]
    back = np.linalg.pinv(slopes)
    random = np.random.default_rng(problem.spec.settings.seed)
    free = np.linalg.svd(slopes)[2][np.linalg.matrix_rank(slopes) :].T
    for _ in range(TRIES):
        if len(units) > UNITS:
            break
        direction = free @ random.standard_normal(free.shape[1])
        point = _inside(start + _AWAY * direction / np.abs(direction).max())
        try:
            if (met := _brought_back(model, point, wanted, back)) is not None:
                away = float(np.abs(met - start).max())
                units.append(_turning(model, met, speed_rpm, away, store))
        except InfeasibleError:
            continue
    return units


def _slopes(record: dict[str, Any]) -> np.ndarray:
    """Deviations of the targets in tolerances per range of the parameters, from the record."""
    tolerance = np.array([t["tolerance_percent"] / 100.0 for t in record["targets"]])
    return np.array(record["sensitivities"]["per_range"]) / tolerance[:, None]


def _inside(point: np.ndarray) -> np.ndarray:
    return np.clip(point, 0.0, 1.0)


def _brought_back(
    model: Model, point: np.ndarray, wanted: np.ndarray, back: np.ndarray
) -> np.ndarray | None:
    """Return the point moved to where the targets are as wanted; None if it does not get there."""
    accuracy = model.problem.spec.settings.coarse_accuracy
    for _ in range(_STEPS):
        missed = model.deviations(model.whole(point, accuracy)) - model.deviations(wanted)
        if np.abs(missed).max() < 1.0:
            return point
        point = _inside(point - back @ missed)
    return None


def _turning(
    model: Model, point: np.ndarray, speed_rpm: float, away: float, store: StageStore
) -> Turning:
    """Modes of the unit at a speed."""
    problem, values = model.problem, model.values(point)
    accuracy = problem.spec.settings.coarse_accuracy
    stage_cache = StageCache(store=store, progress=silent)
    key = stage_cache.key("turning", problem.fingerprint, accuracy, speed_rpm, values)

    def modes() -> tuple[list[float], list[str]]:
        data = lean_scene(problem.scene_at(values))
        diagram = _coarse(problem, data, [0.0, speed_rpm]).campbell
        hertz, whirl = diagram.frequency_hz[:, -1], diagram.whirl[:, -1]
        order = np.argsort(hertz)
        return hertz[order].tolist(), [str(w) for w in whirl[order]]

    hertz, whirl = stage_cache.stage("modes", key, modes)
    return Turning(frequency_hz=hertz, whirl=whirl, away=away)


def _coarse(problem: Problem, data: dict[str, Any], speeds_rpm: list[float]) -> Results:
    """Results of a scene of a problem at some speeds, as its search computes them at first."""
    accuracy = problem.spec.settings.coarse_accuracy
    results = run_scene(model_scene(problem, data, accuracy, speeds_rpm))
    assert results is not None  # one process alone
    return results


@dataclass(frozen=True, kw_only=True, eq=False)
class Counted:
    """Pairs of modes of a unit on bearings: the frequency of one, how many are below a limit."""

    pair_hz: float
    below: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Reached:
    """What a search reaches that asks for the frequency of a pair of modes beside the targets.

    `missed`: relative deviations of the other targets, by name; `models`: evaluations of the whole
    model; `ended`: why the search did.
    """

    pair_hz: float
    models: int
    ended: str
    missed: dict[str, float]


def counted(unit: str, pair: int, limit_hz: float) -> Counted:
    """Count the pairs of modes of the identified unit, with more fixed-interface modes kept."""
    problem, record = problem_of(unit)
    data = lean_scene(problem.scene_at({p["name"]: p["value"] for p in record["parameters"]}))
    data["model"] = {**data["model"], "modes": _KEPT * pair}
    hertz = modes_at_speed(_coarse(problem, data, [0.0]).system, 0.0).frequency_hz[::2]
    return Counted(pair_hz=float(hertz[pair - 1]), below=int(np.count_nonzero(hertz < limit_hz)))


def with_highest_mode(unit: str, pair: int, wanted_hz: float, store: StageStore) -> Reached:
    """Identify a unit once more with the frequency of its highest retained mode as a target."""
    problem, record = problem_of(unit)
    highest = TargetSpec(
        name="highest",
        quantity="frequency_hz",
        value=wanted_hz,
        tolerance=_REACHED,
        mode=2 * pair,
    )
    coarse = problem.spec.settings.coarse_accuracy
    settings = problem.spec.settings.model_copy(update={"accuracy": coarse})
    targets = (*problem.spec.targets, highest)
    spec = problem.spec.model_copy(update={"targets": targets, "settings": settings})
    scene = {**problem.scene, "model": {**problem.scene["model"], "modes": 2 * pair}}
    model = Model(replace(problem, spec=spec, scene=scene), store)
    model.given = model.point({p["name"]: p["value"] for p in record["parameters"]})
    model.limit = SEARCHED[unit]
    last, _ = search(model, silent)
    model.limit, models = None, model.evaluations
    found = model.whole(last.point, coarse)
    names = [t.name for t in problem.spec.targets]
    missed = found[:-1] / np.array([t.value for t in problem.spec.targets]) - 1.0
    return Reached(
        pair_hz=float(found[-1]),
        models=models,
        ended=last.ended,
        missed=dict(zip(names, missed.tolist(), strict=True)),
    )
