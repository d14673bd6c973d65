"""What a run will cost, said before it starts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from solidwhirl.beam_level import MODES
from solidwhirl.body_reduction import BodyResult, Discretisation, first_discretisation
from solidwhirl.cost import (
    ESTIMATES,
    REFERENCE_MACHINE,
    Cost,
    RunCost,
    predict_body_cost,
    predict_cost,
)
from solidwhirl.cost_coefficients import BASE_GIB
from solidwhirl.cost_memory import refuse_what_does_not_fit, with_chosen_solvers
from solidwhirl.cost_table import cost_rows
from solidwhirl.fineness import choose_fineness, is_adapted
from solidwhirl.geometry import Body
from solidwhirl.machine import (
    MachineSpeed,
    available_memory_gib,
    machine_speed,
    resident_memory_gib,
)
from solidwhirl.meshing.prediction import predict_refined
from solidwhirl.meshing.user_mesh_records import MeshedBody
from solidwhirl.plan_records import Plan
from solidwhirl.scene import Scene


@dataclass(frozen=True, kw_only=True)
class Forecast:
    """Predicted cost of a run on this machine, without the [[analyses]].

    Attributes
    ----------
    first
        With the meshes it begins with.
    last
        With meshes of the rule for the accuracy asked, where meshes follow their estimates: a
        round like it comes after the first; None where the first is all.
    """

    first: RunCost
    last: RunCost | None

    @property
    def seconds(self) -> float:
        """Processor time of all rounds; the engine is analysed after the last one only."""
        if self.last is None:
            return self.first.whole.total_s
        again = sum(cost.total_s for cost in self.first.bodies.values())
        return self.last.whole.total_s + again

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
        if self.last is None:
            return cost_rows(self.first)
        last = cost_rows(self.last)
        total = ("all rounds", "", f"{self.seconds:.2g}", f"{self.peak_memory_gib:.2g}")
        first = [
            (f"first round: {name}", str(cost.unknowns), f"{cost.total_s:.2g}", "")
            for name, cost in self.first.bodies.items()
        ]
        return (*last, *first, total)


def forecast(
    scene: Scene,
    plan: Plan,
    bodies: Mapping[str, Body | MeshedBody],
    *,
    machine: MachineSpeed | None = None,
) -> Forecast:
    """Predict the cost of a run.

    Parameters
    ----------
    scene, plan
        The scene, its level chosen, and its plan.
    bodies
        Geometry by name.
    machine
        Speed of the machine; None: that of this one is measured.
    """
    machine = machine or machine_speed()
    modes, estimated = _modes(scene, plan, bodies), scene.model.estimates == "on"
    plan = _solvers_chosen(scene, plan, bodies)
    first = predict_cost(plan, scene, bodies, modes=modes, estimates=estimated, machine=machine)
    rule = scene.model.model_copy(update={"estimates": "off"})
    finer = {}
    for name, own in plan.bodies.items():
        if own.fineness is not None and is_adapted(own.level, scene.model):
            body = bodies[name]
            assert isinstance(body, Body)  # meshes of their own are solids
            wanted = choose_fineness(body, own.level, rule)
            if wanted.size.corner_size_m < own.fineness.size.corner_size_m:
                fineness = replace(wanted, degree=own.fineness.degree)
                finer[name] = replace(own, fineness=fineness)
    if not finer:
        return Forecast(first=first, last=None)
    later = replace(plan, bodies={**plan.bodies, **finer})
    last = predict_cost(later, scene, bodies, modes=modes, estimates=estimated, machine=machine)
    return Forecast(first=first, last=last)


def refuse_too_large(
    scene: Scene, plan: Plan, bodies: Mapping[str, Body | MeshedBody], expected: Forecast
) -> None:
    """Refuse bodies whose first mesh needs more memory than is available, before it is made.

    Parameters
    ----------
    scene, plan, bodies, expected
        The scene, its plan, its geometry and its forecast.

    Raises
    ------
    MemoryShortageError
        With the numbers and what would fit.
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
    """Return what `solidwhirl.dial.rounds_of` asks before every round.

    Parameters
    ----------
    scene, plan, bodies
        The scene, its plan and its geometry.
    progress
        Told what the round will cost.
    """
    machine = machine_speed()

    def shortage(todo: Mapping[str, Discretisation], reduced: Mapping[str, BodyResult]) -> str:
        costs = [_again(scene, plan, bodies[n], c, machine) for n, c in todo.items()]
        if not costs:
            return ""
        needed = max(cost.peak_memory_gib for cost in costs) - BASE_GIB
        spent = sum(cost.total_s for cost in costs)
        progress(f"next round: about {spent:.2g} s, {needed:.2g} GiB more")
        left = available_memory_gib()
        if scene.model.memory_gib is not None:
            left = min(left, scene.model.memory_gib - resident_memory_gib())
        if needed <= left:
            return ""
        return f"the next round needs about {needed:.2g} GiB, {max(left, 0.0):.2g} GiB are left"

    return shortage


def _again(
    scene: Scene,
    plan: Plan,
    body: Body | MeshedBody,
    chosen: Discretisation,
    machine: MachineSpeed = REFERENCE_MACHINE,
) -> Cost:
    """Cost of a body with the discretisation of a round."""
    own = plan.bodies[body.name]
    wanted = ESTIMATES if own.level == "harmonic" else ESTIMATES[:1]
    return predict_body_cost(
        body,
        own,
        modes=chosen.modes,
        estimates=wanted if scene.model.estimates == "on" else (),
        machine=machine,
        mesh=None if chosen.local is None else predict_refined(chosen.local),
    )


def forecast_document(found: Forecast) -> dict[str, Any]:
    """The forecast as plain data."""
    return {
        "cpu_s": found.seconds,
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
