"""What each effect of a plan costs, and what leaving one out saves: forecasts with and without."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

from solidwhirl.core.errors import USER_ERRORS
from solidwhirl.cost.analyses import SECTORS, fields_s, reduced_s
from solidwhirl.cost.forecast import Forecast, forecast_with
from solidwhirl.cost.machine import Machine
from solidwhirl.cost.stand_in import stand_in
from solidwhirl.geometry import Body, GeometryError
from solidwhirl.meshing.imported.records import AnyBody
from solidwhirl.model.effects import make_plan
from solidwhirl.model.plan_records import BodyPlan, Plan
from solidwhirl.model.resolution import choose_resolution
from solidwhirl.scene.records import EffectsSpec, Scene

# Asking for one of these asks for both.
_PAIR = ("stress_stiffening", "spin_softening")


@dataclass(frozen=True, kw_only=True)
class EffectCost:
    """Processor seconds and peak memory [GiB] that an effect adds, or would add."""

    seconds: float
    memory_gib: float


def effect_costs(
    scene: Scene,
    plan: Plan,
    bodies: Mapping[str, AnyBody],
    expected: Forecast,
    machine: Machine,
) -> dict[str, EffectCost]:
    """Predict what each effect adds to a run, or would add where it is left out.

    `expected`: forecast of the plan on the machine. Effects whose other choice the scene refuses,
    or whose cost would be extrapolated beyond what was measured, are left out.
    """
    out = {}
    # what an effect changes of parts and run-ups is little, and other plans need not assemble
    engine = stand_in(scene, plan, bodies)
    for effect in plan.effects:
        with suppress(*USER_ERRORS, GeometryError):
            if effect.name in _DIRECT:
                seconds = _DIRECT[effect.name](expected, scene)
                out[effect.name] = EffectCost(seconds=seconds, memory_gib=0.0)
                continue
            changed = _other_choice(scene, plan, bodies, effect.name, not effect.on)
            if changed is None:
                continue
            other = forecast_with(engine, *changed, bodies, machine)
            if other.extrapolated and not expected.extrapolated:
                continue  # such as a whole rotor as a solid: no number to rely on
            more, less = (expected, other) if effect.on else (other, expected)
            seconds = more.seconds - less.seconds
            if effect.name == "error_estimate" and effect.on:
                seconds = _estimates_s(expected)
            out[effect.name] = EffectCost(
                seconds=max(0.0, seconds),
                memory_gib=max(0.0, more.peak_memory_gib - less.peak_memory_gib),
            )
    return out


def _other_choice(
    scene: Scene, plan: Plan, bodies: Mapping[str, AnyBody], name: str, on: bool
) -> tuple[Scene, Plan] | None:
    """The scene and its plan with one effect the other way round; None: there is none."""
    if name == "asymmetry":
        return scene, _whole_bodies(scene, plan, bodies) if on else _round_bodies(plan)
    choice = "on" if on else "off"
    if name == "error_estimate":
        model = scene.model.model_copy(update={"estimates": choice})
        return scene.model_copy(update={"model": model}), _with(plan, name, on=on)
    if name == "spin_softening" and not on:
        return scene, _without_its_matrix(plan)
    if name in EffectsSpec.model_fields:
        asked = dict.fromkeys(_PAIR if name in _PAIR else (name,), choice)
        changed = scene.model_copy(update={"effects": scene.effects.model_copy(update=asked)})
    elif name == "coupling_comparison":
        model = scene.model.model_copy(update={"compare_coupling": choice})
        changed = scene.model_copy(update={"model": model})
    else:
        return None
    drawn = {n: body for n, body in bodies.items() if isinstance(body, Body)}
    level = next((plan.bodies[n].level for n, b in drawn.items() if not b.features), None)
    other = make_plan(changed, drawn, level)
    return None if other.on(name) is plan.on(name) else (changed, other)


def _whole_bodies(scene: Scene, plan: Plan, bodies: Mapping[str, AnyBody]) -> Plan:
    """The plan if bodies of revolution were meshed whole and solved in a frame that turns."""

    def whole(own: BodyPlan, body: AnyBody) -> BodyPlan:
        out = replace(own, level="solid", orders=(), shape="asymmetric")
        if not isinstance(body, Body):
            return out
        out = replace(out, matrices=3, factorisations=3, eigenproblems=2, solver="auto")
        return replace(out, resolution=choose_resolution(body, "solid", scene.model))

    changed = {name: whole(own, bodies[name]) for name, own in plan.bodies.items()}
    return replace(_with(plan, "asymmetry", on=True), bodies=changed)


def _round_bodies(plan: Plan) -> Plan:
    """The plan if asymmetric bodies were the same in all directions."""
    return _with(plan, "asymmetry", on=False)


def _without_its_matrix(plan: Plan) -> Plan:
    """The plan without spin softening alone: of sectors it follows from the mass."""
    fewer = {
        name: replace(own, matrices=own.matrices - len(own.orders))
        if own.level == "harmonic"
        else own
        for name, own in plan.bodies.items()
    }
    return replace(_with(plan, "spin_softening", on=False), bodies=fewer)


def _with(plan: Plan, name: str, *, on: bool) -> Plan:
    effects = [replace(e, on=on) if e.name == name else e for e in plan.effects]
    return replace(plan, effects=tuple(effects))


def _estimates_s(expected: Forecast) -> float:
    """Of all rounds: without estimates there are more modes, for which a forecast would count."""
    costs = [(expected.last or expected.first).whole]
    costs += expected.first.bodies.values() if expected.last else []
    return sum(cost.seconds.get("error_estimate", 0.0) for cost in costs)


def _checks_s(expected: Forecast, scene: Scene) -> float:
    return (expected.last or expected.first).whole.seconds.get("checks", 0.0)


def _contact_s(expected: Forecast, scene: Scene) -> float:
    """Of all rounds; without joints there is another body."""
    rounds = filter(None, (expected.first, expected.last))
    bodies = (body for one in rounds for body in one.bodies.values())
    return sum(body.seconds.get("contact", 0.0) for body in bodies)


def _recovery_s(expected: Forecast, scene: Scene) -> float:
    """What is asked for; else a state of all bodies with a mesh."""
    named = {a.label for a in scene.analyses if a.kind == "recovery"}
    if named:
        return sum(expected.analyses[name].seconds for name in named)
    bodies = (expected.last or expected.first).bodies.values()
    return sum(
        reduced_s(body) + fields_s(body, SECTORS) for body in bodies if "meshing" in body.seconds
    )


def _second_order_s(expected: Forecast, scene: Scene) -> float:
    """One more circumferential order of every body."""
    return sum(reduced_s(body) for body in (expected.last or expected.first).bodies.values())


# Effects whose cost needs no other plan; those that no scene can ask for would solve every body
# once more: in another order, or as it is deformed.
_DIRECT = {
    "checks": _checks_s,
    "joints": _contact_s,
    "recovery": _recovery_s,
    "nodal_diameter_modes": _second_order_s,
    "change_of_shape": _second_order_s,
}
