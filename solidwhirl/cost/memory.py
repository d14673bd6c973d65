"""Refuse before the work begins what the memory that is left can not hold, and say what can."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from solidwhirl.core.errors import MemoryShortageError
from solidwhirl.cost.work import Cost, predict_body_cost, resolution_of
from solidwhirl.geometry import Body
from solidwhirl.meshing.imported.records import MeshedBody
from solidwhirl.model.plan_records import BodyPlan
from solidwhirl.model.resolution import choose_resolution
from solidwhirl.scene.records import ModelSpec

# Factors by which the sizes of a mesh are tried larger.
_COARSER = (1.25, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0)
_LOWEST_ORDER = 2


def refuse_what_does_not_fit(
    bodies: Mapping[str, Body | MeshedBody],
    plans: Mapping[str, BodyPlan],
    model: ModelSpec,
    *,
    modes: Mapping[str, int],
    available_gib: float,
    estimates: bool = False,
) -> None:
    """Refuse bodies whose reduction needs more memory than is available, before they are meshed.

    `model`: the scene's, for the mesh of another level. Raises MemoryShortageError with what is
    needed and available, and what would fit: without the estimate of the mesh's error, another
    element order, a coarser mesh, another level.
    """
    for name, body in bodies.items():
        plan = plans[name]
        cost = predict_body_cost(body, plan, modes=modes[name], estimates=estimates)
        if cost.peak_memory_gib <= available_gib:
            continue
        if isinstance(body, MeshedBody):
            advice = "a coarser mesh" if body.request.step is None else "a larger size_m"
            if None in plan.solved_orders and plan.solver == "direct":
                other = replace(plan, solver="iterative")
                cheaper = predict_body_cost(body, other, modes=modes[name], estimates=estimates)
                if cheaper.peak_memory_gib <= available_gib:
                    advice = f"solver = 'iterative' ({_numbers(cheaper)}), or {advice}"
            raise MemoryShortageError(
                f"mesh_bodies.{name}: would have {_numbers(cost)}, {available_gib:.3g} GiB are "
                f"available; take {advice}"
            )
        found = [
            f"{what} ({_numbers(c)})"
            for what, c in _alternatives(body, plan, model, modes[name], estimates, available_gib)
        ]
        advice = f"What fits: {'; '.join(found)}" if found else "No coarser mesh of its rule fits"
        raise MemoryShortageError(
            f"bodies.{name}: level {plan.level}, element order {resolution_of(plan).degree}, "
            f"would have {_numbers(cost)}, {available_gib:.3g} GiB are available. {advice}."
        )


def with_chosen_solvers(
    bodies: Mapping[str, Body | MeshedBody],
    plans: Mapping[str, BodyPlan],
    *,
    modes: Mapping[str, int],
    available_gib: float,
    estimates: bool = False,
) -> dict[str, BodyPlan]:
    """Return the plans with the solver in the place of "auto" that is expected to be taken."""
    out = dict(plans)
    for name, body in bodies.items():
        plan = plans[name]
        if plan.solver == "auto":
            direct = replace(plan, solver="direct")
            cost = predict_body_cost(body, direct, modes=modes[name], estimates=estimates)
            fits = cost.peak_memory_gib <= available_gib
            out[name] = direct if fits else replace(plan, solver="iterative")
    return out


def _numbers(cost: Cost) -> str:
    return f"about {cost.unknowns:.2g} unknowns and need about {cost.peak_memory_gib:.3g} GiB"


def _alternatives(
    body: Body,
    plan: BodyPlan,
    model: ModelSpec,
    modes: int,
    estimates: bool,
    available_gib: float,
) -> Iterator[tuple[str, Cost]]:
    """What fits, in the order of what it gives up."""
    resolution = resolution_of(plan)
    size, solid = resolution.size, plan.level == "solid"
    tried: list[list[tuple[str, BodyPlan]]] = []
    if estimates:
        tried.append([("estimates = 'off'", plan)])
    lower = range(resolution.degree - 1, _LOWEST_ORDER - 1, -1)
    tried.append(
        [(f"order = {d}", replace(plan, resolution=replace(resolution, degree=d))) for d in lower]
    )
    tried.append([])
    for factor in _COARSER:
        sizes = {key: factor * getattr(size, key) for key in ("size_m", "corner_size_m")}
        larger = replace(size, **sizes)
        what = f"size_m = {larger.size_m:.3g} with corner_size_m = {larger.corner_size_m:.3g}"
        coarser = replace(plan, resolution=replace(resolution, size=larger))
        tried[-1].append((what, coarser))
    if solid and not body.features:
        tried.append([("level = 'harmonic'", _harmonic(body, plan, model))])
    for options in tried:
        for what, other in options:
            wanted = estimates and what != "estimates = 'off'"
            cost = predict_body_cost(body, other, modes=modes, estimates=wanted)
            if cost.peak_memory_gib <= available_gib:
                yield what, cost
                break


def _harmonic(body: Body, plan: BodyPlan, model: ModelSpec) -> BodyPlan:
    """The same body on its meridian; the counts of a sector are near enough."""
    return replace(plan, level="harmonic", resolution=choose_resolution(body, "harmonic", model))
