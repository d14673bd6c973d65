"""Other units that the printed numbers allow: as good as the identified one, or with more asked."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import approx_fprime, lsq_linear, minimize
from scipy.stats import qmc

from solidwhirl.cache.files import StageStore
from solidwhirl.core.stages import silent
from solidwhirl.geometry import MATERIALS, Material
from solidwhirl.identify.model import InfeasibleError, Model, lean_scene, model_scene
from solidwhirl.identify.problem import Problem, TargetSpec, is_mass_target, read_problem
from solidwhirl.pipeline.cached_stages import StageCache
from solidwhirl.pipeline.run import Results, run_for_page
from solidwhirl.rotordyn import modes_at_speed

Change = Callable[[dict[str, Any], str], dict[str, Any]]
ROOT = Path(__file__).resolve().parents[2]
#: Equally good units that are sought, and directions in which they are sought
UNITS, TRIES = 10, 24
# Steps that bring one back to the targets, the pull towards where it is, in tolerances per range,
# and its distance from the identified one in the unit cube of the parameters.
_STEPS, _PULL, _AWAY = 10, 1.0, 0.35
#: Units with the masses of Table 4 that are drawn, and models of the climb from the best
DRAWN, CLIMBED = 24, 40
# First step of that climb in the unit cube.
_FIRST = 0.2
# Tolerances to which closed forms are met.
_NEAR = 0.1
# Finite difference of closed forms.
_DIFFERENCE = 1e-4
# Fixed-interface pairs that are kept for each pair that is asked for.
_KEPT = 3
# Stiffness of a body that is taken for rigid, over its own.
_RIGID = 1e4


@dataclass(frozen=True, kw_only=True, eq=False)
class Turning:
    """Modes of a unit at rest and at a speed, and how far it is from the identified one.

    `rest_hz`: pairs at rest; `frequency_hz`, `whirl`: modes at the speed in fixed axes; `away`:
    largest change of a parameter in shares of its range.
    """

    rest_hz: list[float]
    frequency_hz: list[float]
    whirl: list[str]
    away: float

    def seen_by(self, speed_rpm: float) -> np.ndarray:
        """Return the frequencies that the unit sees at that speed."""
        return rotating(self.frequency_hz, self.whirl, speed_rpm / 60.0)


def rotating(hertz: Sequence[float], whirl: Sequence[str], spin_hz: float) -> np.ndarray:
    """Return |f - spin| of forward whirl and f + spin of backward whirl."""
    return np.array(
        [
            abs(f - spin_hz) if sense == "forward" else f + spin_hz
            for f, sense in zip(hertz, whirl, strict=True)
        ]
    )


def problem_of(unit: str) -> tuple[Problem, dict[str, Any]]:
    """Return the identification problem of a unit and the record of its solution."""
    folder = ROOT / "scenes" / "identify"
    record = (folder / f"uhbr_{unit}.identification.json").read_text(encoding="utf-8")
    return read_problem(folder / f"uhbr_{unit}.toml"), json.loads(record)


def equally_good(unit: str, speed_rpm: float, store: StageStore) -> list[Turning]:
    """Return units with the same masses and frequencies at rest, the identified one first.

    They lie along directions that the targets do not see, brought back until all targets are those
    of the identified unit to their tolerances.
    """
    problem, record = problem_of(unit)
    model = Model(problem, store)
    model.limit = None
    start = model.point(_values(record))
    slopes = _slopes(record)

    def deviations(point: np.ndarray) -> np.ndarray:
        return model.deviations(model.whole(point, problem.spec.settings.coarse_accuracy))

    wanted = deviations(start)
    units = [_turning(problem, model.values(start), speed_rpm, 0.0, store)]
    random = np.random.default_rng(problem.spec.settings.seed)
    free = np.linalg.svd(slopes)[2][np.linalg.matrix_rank(slopes) :].T
    for _ in range(TRIES):
        if len(units) > UNITS:
            break
        direction = free @ random.standard_normal(free.shape[1])
        point = _inside(start + _AWAY * direction / np.abs(direction).max())
        try:
            met = _brought_back(lambda u: deviations(u) - wanted, point, slopes)
            if met is not None:
                away = float(np.abs(met - start).max())
                units.append(_turning(problem, model.values(met), speed_rpm, away, store))
        except InfeasibleError:
            continue
    return units


def _slopes(record: dict[str, Any]) -> np.ndarray:
    """Deviations of the targets in tolerances per range of the parameters, from the record."""
    tolerance = np.array([t["tolerance_percent"] / 100.0 for t in record["targets"]])
    return np.array(record["sensitivities"]["per_range"]) / tolerance[:, None]


def _brought_back(
    missed_at: Callable[[np.ndarray], np.ndarray],
    point: np.ndarray,
    slopes: np.ndarray,
    near: float = 1.0,
) -> np.ndarray | None:
    """Return the point moved to where no target misses by `near` tolerances; None if it can not.

    Least steps within the bounds, with slopes that learn from each of them (Broyden 1965).
    """
    missed, pull = missed_at(point), _PULL * np.eye(point.size)
    for _ in range(_STEPS):
        if np.abs(missed).max() < near:
            return point
        asked = np.concatenate((-missed, np.zeros(point.size)))
        step = lsq_linear(np.vstack((slopes, pull)), asked, bounds=(-point, 1.0 - point)).x
        point = _inside(point + step)
        before, missed = missed, missed_at(point)
        slopes = slopes + np.outer(missed - before - slopes @ step, step) / (step @ step)
    return None


def _inside(point: np.ndarray) -> np.ndarray:
    return np.clip(point, 0.0, 1.0)


def _turning(
    problem: Problem, values: dict[str, float], speed_rpm: float, away: float, store: StageStore
) -> Turning:
    """Modes of the unit at rest and at a speed."""
    accuracy = problem.spec.settings.coarse_accuracy
    stage_cache = StageCache(store=store, progress=silent)
    key = stage_cache.key("turned", problem.fingerprint, accuracy, speed_rpm, values)

    def modes() -> Turning:
        data = lean_scene(problem.scene_at(values))
        diagram = _computed(problem, data, [0.0, speed_rpm], accuracy).campbell
        hertz, whirl = diagram.frequency_hz[:, -1], diagram.whirl[:, -1]
        order = np.argsort(hertz)
        return Turning(
            rest_hz=np.sort(diagram.frequency_hz[:, 0])[::2].tolist(),
            frequency_hz=hertz[order].tolist(),
            whirl=[str(w) for w in whirl[order]],
            away=away,
        )

    return stage_cache.stage("modes", key, modes)


def _computed(
    problem: Problem, data: dict[str, Any], speeds_rpm: list[float], accuracy: float
) -> Results:
    """Results of a scene of a problem at some speeds, as its search computes them."""
    return run_for_page(model_scene(problem, data, accuracy, speeds_rpm))


# -- numbers of modes ------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True, eq=False)
class Counted:
    """Pairs of bending modes at rest: frequency of one, and how many are below a limit.

    `error`: largest relative difference of a pair below the limit, or of that one, from a model
    for the coarser accuracy of the search; `near`: pairs no further from the limit than that.
    """

    pair_hz: float
    below: int
    error: float
    near: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Reached:
    """How high a pair of modes can be in units with the masses of the identified one.

    `drawn_hz`: of units drawn within the bounds; `highest_hz`: after the climb; `best`: modes of
    that unit and `first`: of the identified one.
    """

    drawn_hz: list[float]
    highest_hz: float
    best: Turning
    first: Turning


def counted(unit: str, pair: int, limit_hz: float, changed: Change) -> Counted:
    """Count the pairs of modes of the identified unit with something changed in its scene."""
    problem, record = problem_of(unit)
    data = changed(problem.scene_at(_values(record)), unit)
    data["model"] = {**data["model"], "modes": _KEPT * pair}
    settings = problem.spec.settings
    fine, coarse = (
        modes_at_speed(_computed(problem, data, [0.0], accuracy).system, 0.0).frequency_hz[::2]
        for accuracy in (settings.accuracy, settings.coarse_accuracy)
    )
    below = int(np.count_nonzero(fine < limit_hz))
    told = max(below, pair)
    error = float(np.abs(coarse[:told] / fine[:told] - 1.0).max())
    near = int(np.count_nonzero(np.abs(fine / limit_hz - 1.0) <= error))
    return Counted(pair_hz=float(fine[pair - 1]), below=below, error=error, near=near)


def on_bearings(scene: dict[str, Any], unit: str) -> dict[str, Any]:
    """Return the scene of a unit as identified, on its bearings."""
    return lean_scene(scene)


def with_rigid_stages(scene: dict[str, Any], unit: str) -> dict[str, Any]:
    """Return the scene with all parts next to rigid that are not of the material of the shaft."""
    scene = lean_scene(scene)
    body = scene["bodies"][unit]
    parts = (*body["sections"], *body.get("stage_groups", ()))
    others = {part["material"] for part in parts if "material" in part} - {body["material"]}
    scene["materials"] = {name: stiffer(MATERIALS[name], _RIGID) for name in others}
    return scene


def stiffer(material: Material, factor: float) -> dict[str, float]:
    """Return an entry of a scene for a material with its modulus times a factor."""
    return {
        "youngs_modulus_pa": factor * material.youngs_modulus_pa,
        "poissons_ratio": material.poissons_ratio,
        "density_kg_per_m3": material.density_kg_per_m3,
    }


def with_nodes_held(scene: dict[str, Any], unit: str) -> dict[str, Any]:
    """Return the scene with all nodes n1, n2, ... held instead of the bearings."""
    names = [i["name"] for i in scene["bodies"][unit]["interfaces"]]
    nodes = [name for name in names if re.fullmatch(r"n\d+", name)]
    held = {"rigid": ["ux", "uy", "rx", "ry"]}
    joints = [{"name": f"held_{node}", "first": f"{unit}.{node}", **held} for node in nodes]
    return lean_scene({**scene, "bearings": joints})


def highest_pair(unit: str, pair: int, speed_rpm: float, store: StageStore) -> Reached:
    """Return how high a pair of modes can be in units with the masses of Table 4 in their bounds.

    Units are drawn within the bounds and brought to the masses, which have closed forms; from the
    one whose pair is highest a climb follows the directions that the masses leave free.
    """
    problem, record = problem_of(unit)
    model = _of_pair(problem, pair, store)
    settings = problem.spec.settings
    start = model.point(_values(record))

    def height(point: np.ndarray | None) -> float:
        try:
            return 0.0 if point is None else float(model.whole(point, settings.coarse_accuracy)[-1])
        except InfeasibleError:
            return 0.0

    ends = qmc.LatinHypercube(d=start.size, seed=settings.seed).random(DRAWN)
    # nearer ones too, since far away most have no geometry
    shares = np.linspace(0.0, 1.0, DRAWN + 1)[1:, None]
    tried = (_with_masses(model, u) for u in (start, *(start + shares * (ends - start))))
    points = [p for p in tried if p is not None]
    heights = [height(p) for p in points]
    best = points[int(np.argmax(heights))]
    free = np.linalg.svd(_mass_slopes(model, best))[2][model.mass_rows.sum() :].T
    found: list[tuple[float, np.ndarray]] = [(max(heights), best)]

    def depth(steps: np.ndarray) -> float:
        along, across = np.split(steps, [free.shape[1]])
        # a first step takes a mass to the end of its tolerance
        missed = (1.0 - _NEAR) * np.clip(across / _FIRST, -1.0, 1.0)
        point = _with_masses(model, _inside(best + free @ along), missed)
        here = height(point)
        if point is not None:
            found.append((here, point))
        return -here

    settings_of_climb = {"maxiter": CLIMBED, "rhobeg": _FIRST}
    begin = np.zeros(free.shape[1] + model.mass_rows.sum())
    minimize(depth, begin, method="COBYLA", options=settings_of_climb)
    highest, point = max(found, key=lambda pair: pair[0])
    away = float(np.abs(point - start).max())
    return Reached(
        drawn_hz=[h for h in heights[1:] if h],
        highest_hz=highest,
        best=_turning(problem, model.values(point), speed_rpm, away, store),
        first=_turning(problem, model.values(start), speed_rpm, 0.0, store),
    )


def _values(record: dict[str, Any]) -> dict[str, float]:
    """Identified values of the parameters."""
    return {p["name"]: p["value"] for p in record["parameters"]}


def _of_pair(problem: Problem, pair: int, store: StageStore) -> Model:
    """The masses and the frequency of a pair of modes as the only targets."""
    masses = tuple(t for t in problem.spec.targets if is_mass_target(t))
    # only its quantity is asked for, not how far it is from a value
    highest = TargetSpec(name="highest", quantity="frequency_hz", value=1.0, mode=2 * pair)
    spec = problem.spec.model_copy(update={"targets": (*masses, highest)})
    scene = {**problem.scene, "model": {**problem.scene["model"], "modes": 2 * pair}}
    model = Model(replace(problem, spec=spec, scene=scene), store)
    model.limit = None
    return model


def _with_masses(
    model: Model, point: np.ndarray, missed: np.ndarray | float = 0.0
) -> np.ndarray | None:
    """Return a near point that misses the masses by so many tolerances; None without one."""
    try:
        slopes = _mass_slopes(model, point)
        return _brought_back(
            lambda u: _mass_deviations(model, u) - missed, point, slopes, near=_NEAR
        )
    except InfeasibleError:
        return None


def _mass_deviations(model: Model, point: np.ndarray) -> np.ndarray:
    return model.deviations(model.masses(point))[model.mass_rows]


def _mass_slopes(model: Model, point: np.ndarray) -> np.ndarray:
    # to the inside of the bounds
    step = np.where(point < 0.5, _DIFFERENCE, -_DIFFERENCE)
    return np.atleast_2d(approx_fprime(point, lambda u: _mass_deviations(model, u), step))
