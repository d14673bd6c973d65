"""What a run will cost, said before it starts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from solidwhirl.analyses.kinds.nodal_diameters import NodalDiametersSpec
from solidwhirl.beams.body import MODES
from solidwhirl.bodies.reduction import BodyResult, Discretisation, first_discretisation
from solidwhirl.core.machine import (
    MachineSpeed,
    available_memory_gib,
    machine_speed,
    resident_memory_gib,
)
from solidwhirl.cost.analyses import analyses_s
from solidwhirl.cost.coefficients import BASE_GIB
from solidwhirl.cost.memory import refuse_what_does_not_fit, with_chosen_solvers
from solidwhirl.cost.work import Cost, RunCost, predict_body_cost, predict_cost
from solidwhirl.geometry import Body
from solidwhirl.meshing.imported.records import AnyBody, MeshedBody, is_asymmetric
from solidwhirl.meshing.own.prediction import PredictedMesh, predict_refined, predict_revolved
from solidwhirl.model.plan_records import Plan
from solidwhirl.model.resolution import choose_resolution
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.recovery_references import sectors_of

_HEAD = ("what", "unknowns", "predicted s", "predicted GiB")
_LABELS = {
    "import_solvers": "import of the solvers",
    "meshing": "mesh",
    "campbell": "Campbell diagram",
}
_SHARED = ("import_solvers", "campbell", "critical_speeds")


@dataclass(frozen=True, kw_only=True)
class NodalDiameterCost:
    """Processor time of each of the nodal diameters of a body that an analysis reduces."""

    analysis: str
    body: str
    count: int
    seconds: float


@dataclass(frozen=True, kw_only=True)
class Forecast:
    """Predicted cost of a run on this machine, without pictures and files.

    `first`: with the meshes it begins with; `last`: with meshes of the rule for the accuracy asked,
    where meshes follow their estimates: a round like it comes after the first; None where the first
    is all. `nodal_diameters`: the [[analyses]] that cost as much as bodies do; `analyses`: seconds
    of each of the others by its name.
    """

    first: RunCost
    last: RunCost | None
    nodal_diameters: tuple[NodalDiameterCost, ...] = ()
    analyses: Mapping[str, float] = field(default_factory=dict)

    @property
    def seconds(self) -> float:
        """Processor time of all rounds; the engine is analysed after the last one only."""
        analyses = sum(self.of_analyses.values())
        if self.last is None:
            return self.first.whole.total_s + analyses
        again = sum(cost.total_s for cost in self.first.bodies.values())
        return self.last.whole.total_s + again + analyses

    @property
    def of_analyses(self) -> dict[str, float]:
        """Processor seconds of all [[analyses]] by their names."""
        diameters = {one.analysis: one.count * one.seconds for one in self.nodal_diameters}
        return {**self.analyses, **diameters}

    @property
    def peak_memory_gib(self) -> float:
        """Of the largest round."""
        both = (self.first, self.last or self.first)
        return max(cost.whole.peak_memory_gib for cost in both)

    @property
    def unknowns(self) -> int:
        """Of the last round."""
        return (self.last or self.first).whole.unknowns

    def rows(self) -> tuple[tuple[str, str, str, str], ...]:
        """Table rows as text, head first."""
        analyses = [(f"analysis {n}", "", _seconds(s), "") for n, s in self.of_analyses.items()]
        if self.last is None:
            whole = [("all and analyses", "", _seconds(self.seconds), "")] if analyses else []
            return (*cost_rows(self.first), *analyses, *whole)
        total = ("all rounds", "", f"{self.seconds:.2g}", f"{self.peak_memory_gib:.2g}")
        first = [
            (f"first round: {name}", str(cost.unknowns), f"{cost.total_s:.2g}", "")
            for name, cost in self.first.bodies.items()
        ]
        return (*cost_rows(self.last), *analyses, *first, total)


def forecast(
    scene: Scene,
    plan: Plan,
    bodies: Mapping[str, Body | MeshedBody],
    *,
    machine: MachineSpeed | None = None,
) -> Forecast:
    """Predict the cost of a run."""
    machine = machine or machine_speed()
    modes, estimated = _modes(scene, plan, bodies), scene.model.estimates == "on"
    plan = _solvers_chosen(scene, plan, bodies)
    first = predict_cost(plan, scene, bodies, modes=modes, estimates=estimated, machine=machine)
    rule = scene.model.model_copy(update={"estimates": "off"})
    finer = {}
    for name, own in plan.bodies.items():
        if own.resolution is not None and own.resolution.is_adapted:
            body = bodies[name]
            assert isinstance(body, Body)  # given meshes are not adapted
            wanted = choose_resolution(body, own.level, rule)
            if wanted.size.corner_size_m < own.resolution.size.corner_size_m:
                resolution = replace(wanted, degree=own.resolution.degree)
                finer[name] = replace(own, resolution=resolution)
    last = None
    if finer:
        later = replace(plan, bodies={**plan.bodies, **finer})
        last = predict_cost(later, scene, bodies, modes=modes, estimates=estimated, machine=machine)
    of_diameters = tuple(_of_nodal_diameters(scene, plan, (last or first).bodies))
    coordinates = (last or first).whole.coordinates
    return Forecast(
        first=first,
        last=last,
        nodal_diameters=of_diameters,
        analyses=analyses_s(scene, plan, coordinates, machine),
    )


def _of_nodal_diameters(
    scene: Scene, plan: Plan, costs: Mapping[str, Cost]
) -> Iterator[NodalDiameterCost]:
    """Every nodal diameter costs about what a circumferential order of its body does."""
    for spec in scene.analyses:
        if isinstance(spec, NodalDiametersSpec):
            cost, orders = costs[spec.body], len(plan.bodies[spec.body].solved_orders)
            yield NodalDiameterCost(
                analysis=spec.label,
                body=spec.body,
                count=len(spec.indices(sectors_of(scene, spec.body))[0]),
                seconds=(cost.total_s - cost.seconds.get("meshing", 0.0)) / orders,
            )


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


def shortage_of(
    scene: Scene,
    plan: Plan,
    bodies: Mapping[str, Body | MeshedBody],
    progress: Callable[[str], None] = lambda text: None,
) -> Callable[[Mapping[str, Discretisation], Mapping[str, BodyResult]], str]:
    """Return what `solidwhirl.bodies.refinement.rounds_of` asks before every round."""
    machine = machine_speed()

    def shortage(todo: Mapping[str, Discretisation], reduced: Mapping[str, BodyResult]) -> str:
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
        if not costs:
            return ""
        needed = max(cost.peak_memory_gib for cost in costs) - BASE_GIB
        left = available_memory_gib()
        if scene.model.memory_gib is not None:
            left = min(left, scene.model.memory_gib - resident_memory_gib())
        if needed <= left:
            spent = sum(cost.total_s for cost in costs)
            progress(f"next round: about {spent:.2g} s, {needed:.2g} GiB more")
            return ""
        return f"the next round needs about {needed:.2g} GiB, {max(left, 0.0):.2g} GiB are left"

    return shortage


def _refined(body: AnyBody, level: str, chosen: Discretisation) -> PredictedMesh | None:
    """The next mesh of a body as expected; None: that of its plan."""
    if chosen.local is None:
        return None
    mesh = predict_refined(chosen.local, whole=is_asymmetric(body))
    return mesh if level == "harmonic" or mesh.dimension == 3 else predict_revolved(mesh)


def forecast_document(found: Forecast) -> dict[str, Any]:
    """The forecast as plain data."""
    return {
        "cpu_s": found.seconds,
        "analyses_cpu_s": found.of_analyses,
        "peak_memory_gib": found.peak_memory_gib,
        "unknowns": found.unknowns,
        "extrapolated": (found.last or found.first).whole.extrapolated,
    }


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
    return {
        name: MODES
        if plan.bodies[name].level == "beam"
        else first_discretisation(scene, plan, name).modes
        for name in bodies
    }


def cost_rows(cost: RunCost) -> tuple[tuple[str, str, str, str], ...]:
    """Rows (what, unknowns, predicted s, predicted GiB) as text, the first one is the head.

    Per body one row and one for each of its stages, then what the bodies share, then all. Numbers
    that were extrapolated have "(extrapolated)" after the unknowns.
    """
    rows = [_HEAD]
    for name, body in cost.bodies.items():
        rows.append(_row(name, body, body.total_s))
        rows += [
            (f"  {_label(stage)}", "", _seconds(spent), "") for stage, spent in body.seconds.items()
        ]
    for stage in _SHARED:
        if cost.whole.seconds.get(stage):
            size = "" if stage == "import_solvers" else f"{cost.whole.coordinates} coordinates"
            rows.append((_label(stage), size, _seconds(cost.whole.seconds[stage]), ""))
    # what bodies are compared with belongs to all of them
    own = sum(body.seconds.get("error_estimate", 0.0) for body in cost.bodies.values())
    shared = cost.whole.seconds.get("error_estimate", 0.0) - own
    if shared > 0.0:
        rows.append(("other models", "", _seconds(shared), ""))
    rows.append(_row("all", cost.whole, cost.whole.total_s))
    return tuple(rows)


def _label(stage: str) -> str:
    return _LABELS.get(stage, stage.replace("_", " "))


def _row(what: str, cost: Cost, seconds: float) -> tuple[str, str, str, str]:
    unknowns = f"{cost.unknowns:.3g}" if cost.unknowns >= 1e6 else f"{cost.unknowns}"
    if cost.extrapolated:
        unknowns += " (extrapolated)"
    return what, unknowns, _seconds(seconds), f"{cost.peak_memory_gib:.2g}"


def _seconds(value: float) -> str:
    return f"{value:.2g}" if value < 100.0 else f"{value:.0f}"
