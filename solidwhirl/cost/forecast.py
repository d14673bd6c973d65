"""What a run will cost, said before it starts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from solidwhirl.bodies.reduction import BodyResult, Discretisation, first_discretisation
from solidwhirl.core.errors import MemoryShortageError
from solidwhirl.core.machine import available_memory_gib, resident_memory_gib
from solidwhirl.cost.analyses import AnalysisCost, analysis_costs
from solidwhirl.cost.around import Writing, start_s, writing
from solidwhirl.cost.coefficients import BASE_GIB
from solidwhirl.cost.machine import Machine, this_machine
from solidwhirl.cost.memory import refuse_what_does_not_fit, with_chosen_solvers
from solidwhirl.cost.stand_in import StandIn, stand_in, stepped_parts
from solidwhirl.cost.work import RunCost, mesh_kind, predict_body_cost, predict_cost
from solidwhirl.geometry import Body
from solidwhirl.meshing import Mesh
from solidwhirl.meshing.imported.records import AnyBody, MeshedBody, is_asymmetric
from solidwhirl.meshing.own.prediction import (
    PredictedMesh,
    counted,
    predict_mesh,
    predict_refined,
    predict_revolved,
)
from solidwhirl.model.at_level import alone_at_level
from solidwhirl.model.effects import make_plan
from solidwhirl.model.plan_records import BodyPlan, Plan
from solidwhirl.model.resolution import choose_resolution
from solidwhirl.scene.records import Scene

# A round that is foreseen to have hardly more unknowns than the first one is not made.
_GROWTH = 1.25
# First meshes are better than their rule expects by such factors, by the order of their elements,
# but for those with features; where that is enough there is one round (measured:
# bench/forecast.py).
_BETTER, _LOWEST = {2: 2.0, 3: 10.0}, 2
# Meshes of elements of order 2 become larger by these factors at least, once they are refined
# (measured: bench/forecast.py).
_REFINED = {"harmonic": 2.0, "revolved": 3.0, "solid": 4.0}
# Those of bodies with features grow with the error over what is aimed at, which falls at their
# edges as the size of the elements (measured: bladed wheels, 1e-2 to 2e-3).
_BY_ERROR = 1.6


@dataclass(frozen=True, kw_only=True)
class Forecast:
    """Predicted cost of a run on this machine.

    `first`: with the meshes it begins with; `last`: with meshes of the rule for the accuracy asked,
    where meshes follow their estimates: a round like it comes after the first; None where the first
    is all. `analyses`: of the [[analyses]], by their names; `start_s`: until the level of the
    bodies is known; `writing`: of files, page and pictures.
    """

    first: RunCost
    last: RunCost | None
    analyses: Mapping[str, AnalysisCost]
    start_s: float
    writing: Writing

    @property
    def seconds(self) -> float:
        """Processor time of the whole run, without pictures on paper.

        The engine is analysed after the last round only.
        """
        around = self.start_s + self.writing.files_s + self.writing.page_s
        rounds = (self.last or self.first).whole.total_s
        if self.last is not None:
            rounds += sum(cost.total_s for cost in self.first.bodies.values())
        return around + rounds + sum(cost.seconds for cost in self.analyses.values())

    @property
    def peak_memory_gib(self) -> float:
        """Of the largest round, or the largest analysis after it."""
        both = (self.first, self.last or self.first)
        rounds = max(cost.whole.peak_memory_gib for cost in both)
        largest = max((cost.memory_gib for cost in self.analyses.values()), default=0.0)
        return max(rounds, BASE_GIB + largest)

    @property
    def extrapolated(self) -> bool:
        """Whether a mesh is larger than what was measured."""
        return (self.last or self.first).whole.extrapolated

    @property
    def unknowns(self) -> int:
        """Of the last round."""
        return (self.last or self.first).whole.unknowns


def forecast(
    scene: Scene,
    plan: Plan,
    bodies: Mapping[str, Body | MeshedBody],
    *,
    machine: Machine | None = None,
) -> Forecast:
    """Predict the cost of a run."""
    engine = stand_in(scene, plan, bodies)
    return forecast_with(engine, scene, plan, bodies, machine or this_machine())


def forecast_with(
    engine: StandIn | None,
    scene: Scene,
    plan: Plan,
    bodies: Mapping[str, Body | MeshedBody],
    machine: Machine,
) -> Forecast:
    """Predict the cost of a run; `engine`: what stands in for the assembled one."""
    modes, estimated = _modes(scene, plan, bodies), scene.model.estimates == "on"
    plan = _solvers_chosen(scene, plan, bodies)
    asked: dict[str, Any] = {
        "modes": modes,
        "estimates": estimated,
        "machine": machine,
        "engine": engine,
    }
    first = predict_cost(plan, scene, bodies, **asked)
    finer, meshes = _finer(scene, plan, bodies)
    last = None
    if finer:
        later = replace(plan, bodies={**plan.bodies, **finer})
        last = predict_cost(later, scene, bodies, meshes=meshes, **asked)
    if last is not None and last.whole.unknowns < _GROWTH * first.whole.unknowns:
        last = None
    whole, size = (last or first).whole, (last or first).size
    sizes = {name: cost.coordinates for name, cost in (last or first).bodies.items()}
    return Forecast(
        first=first,
        last=last,
        analyses=analysis_costs(
            scene,
            plan,
            size,
            (last or first).bodies,
            machine,
            stepped_parts(scene, plan, engine, sizes),
            lambda level: _on_level(engine, scene, bodies, level, machine),
        ),
        start_s=start_s(scene, plan, bodies, machine),
        writing=writing(scene, plan, whole.unknowns, machine),
    )


def _on_level(
    engine: StandIn | None,
    scene: Scene,
    bodies: Mapping[str, AnyBody],
    level: str,
    machine: Machine,
) -> AnalysisCost:
    """Cost of the engine with its bodies on another level, as `level_comparison` computes it.

    Bodies that are on it already are found again.
    """
    other = alone_at_level(scene, level)
    drawn = {name: body for name, body in bodies.items() if isinstance(body, Body)}
    found = forecast_with(engine, other, make_plan(other, drawn, level), bodies, machine)
    around = found.start_s + found.writing.files_s + found.writing.page_s
    memory = max(found.peak_memory_gib - BASE_GIB, 0.0)
    return AnalysisCost(seconds=found.seconds - around, memory_gib=memory)


def _finer(
    scene: Scene, plan: Plan, bodies: Mapping[str, Body | MeshedBody]
) -> tuple[dict[str, BodyPlan], dict[str, PredictedMesh]]:
    """Plans of the bodies that are refined, with sizes of the rule for the accuracy; their meshes.

    The order of the elements stays that of the first mesh.
    """
    rule = scene.model.model_copy(update={"estimates": "off"})
    plans, meshes = {}, {}
    for name, own in plan.bodies.items():
        first, body = own.resolution, bodies[name]
        if first is None or not first.is_adapted:
            continue
        assert isinstance(body, Body)  # given meshes are not adapted
        wanted = choose_resolution(body, own.level, rule)
        is_coarse = wanted.size.corner_size_m < first.size.corner_size_m
        better = 1.0 if body.features else _BETTER.get(first.degree, 1.0)
        if not is_coarse or first.expected_error <= better * scene.model.accuracy:
            continue
        plans[name] = replace(own, resolution=replace(wanted, degree=first.degree))
        kind = mesh_kind(body, own)
        before, after = (predict_mesh(body, r.size, kind) for r in (first, wanted))
        if body.features:
            meshes[name] = before.times(_BY_ERROR * first.expected_error / scene.model.accuracy)
            continue
        growth = after.unknowns(first.degree) / before.unknowns(first.degree)
        least = _REFINED[kind] if first.degree == _LOWEST else 1.0
        meshes[name] = after.times(max(least / growth, 1.0))
    return plans, meshes


def refuse_too_large(
    scene: Scene, plan: Plan, bodies: Mapping[str, Body | MeshedBody], expected: Forecast
) -> None:
    """Refuse bodies whose first mesh needs more memory than is available, before it is made.

    Raises MemoryShortageError with the numbers and what would fit.
    """
    available = min(available_memory_gib(), scene.model.memory_gib or np.inf)
    large = {
        n: b for n, b in bodies.items() if expected.first.bodies[n].peak_memory_gib > available
    }
    refuse_what_does_not_fit(
        large,
        _solvers_chosen(scene, plan, large).bodies,
        scene.model,
        modes=_modes(scene, plan, large),
        available_gib=available,
        estimates=scene.model.estimates == "on",
    )


def _free_gib(scene: Scene) -> float:
    """Memory that is left, or that the scene leaves."""
    allowed = scene.model.memory_gib
    left = available_memory_gib()
    if allowed is not None:
        left = min(left, allowed - resident_memory_gib())
    return max(left, 0.0)


def refuse_made_mesh(
    scene: Scene, plan: Plan, body: AnyBody, chosen: Discretisation, mesh: Mesh
) -> None:
    """Refuse a mesh whose reduction needs more memory than is left, now that its numbers are known.

    Raises MemoryShortageError.
    """
    cost = predict_body_cost(
        body,
        plan.bodies[body.name],
        modes=chosen.modes,
        estimates=scene.model.estimates == "on",
        mesh=counted(mesh),
    )
    needed, left = cost.peak_memory_gib - BASE_GIB, _free_gib(scene)
    if needed > left:
        raise MemoryShortageError(
            f"{body.name}: a mesh of {len(mesh.cells)} cells needs about {needed:.2g} GiB to be "
            f"reduced, {left:.2g} GiB are free"
        )


def shortage_of(
    scene: Scene,
    plan: Plan,
    bodies: Mapping[str, Body | MeshedBody],
    progress: Callable[[str], None] = lambda text: None,
) -> Callable[[Mapping[str, Discretisation], Mapping[str, BodyResult]], str]:
    """Return what `solidwhirl.bodies.refinement.rounds_of` asks before every round."""

    def shortage(todo: Mapping[str, Discretisation], reduced: Mapping[str, BodyResult]) -> str:
        if not todo:
            return ""
        machine = this_machine()
        costs = [
            predict_body_cost(
                bodies[name],
                plan.bodies[name],
                modes=chosen.modes,
                estimates=scene.model.estimates == "on",
                machine=machine,
                mesh=_refined(bodies[name], plan.bodies[name].level, chosen),
            )
            for name, chosen in todo.items()
        ]
        needed = max(cost.peak_memory_gib for cost in costs) - BASE_GIB
        left = _free_gib(scene)
        if needed <= left:
            spent = sum(cost.total_s for cost in costs)
            progress(f"next round: about {spent:.2g} s, {needed:.2g} GiB more")
            return ""
        return f"the next round would need about {needed:.2g} GiB, {left:.2g} GiB are free"

    return shortage


def _refined(body: AnyBody, level: str, chosen: Discretisation) -> PredictedMesh | None:
    """The next mesh of a body as expected; None: that of its plan."""
    if chosen.local is None:
        return None
    mesh = predict_refined(chosen.local, whole=is_asymmetric(body))
    return mesh if level == "harmonic" or mesh.dimension == 3 else predict_revolved(mesh)


def _solvers_chosen(scene: Scene, plan: Plan, bodies: Mapping[str, Body | MeshedBody]) -> Plan:
    """The plan with the solvers that the memory leaves."""
    if all(plan.bodies[name].solver != "auto" for name in bodies):
        return plan
    chosen = with_chosen_solvers(
        bodies,
        plan.bodies,
        modes=_modes(scene, plan, bodies),
        available_gib=available_memory_gib(),
        estimates=scene.model.estimates == "on",
    )
    return replace(plan, bodies=chosen)


def _modes(scene: Scene, plan: Plan, bodies: Mapping[str, Body | MeshedBody]) -> dict[str, int]:
    def modes(name: str) -> int:
        if plan.bodies[name].level != "beam":
            return first_discretisation(scene, plan, name).modes
        from solidwhirl.beams.body import MODES  # loads all that makes beams

        return MODES

    return {name: modes(name) for name in bodies}
