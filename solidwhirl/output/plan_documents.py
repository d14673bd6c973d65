"""A plan and what it costs, as plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from solidwhirl.cost.effects import EffectCost
from solidwhirl.cost.forecast import Forecast
from solidwhirl.model.plan_records import Plan
from solidwhirl.model.resolution import Resolution
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S


def plan_document(plan: Plan) -> dict[str, Any]:
    """The plan as plain data."""
    return {
        "effects": [asdict(effect) for effect in plan.effects],
        "analyses": [{"name": name, "kind": kind} for name, kind in plan.analyses],
        "speeds_beyond": [
            {"analysis": a.analysis, "to_rpm": a.speed_rpm, "source": a.source}
            for a in plan.speeds_beyond
        ],
        "bodies": {
            name: {
                "level": b.level,
                "circumferential_orders": list(b.orders),
                "interface_components": list(b.components),
                "motions_by_interface": {k: list(v) for k, v in b.interface_components.items()},
                **_resolution(b.resolution),
                "maximum_speed_rpm": b.maximum_speed_rad_s * RPM_PER_RAD_S,
                "matrices": b.matrices,
                "factorisations_at_most": b.factorisations,
                "eigenproblems_at_most": b.eigenproblems,
                "solver": None if b.level == "beam" else b.solver,
            }
            for name, b in plan.bodies.items()
        },
    }


def costs_document(
    plan: Plan, expected: Forecast, effects: Mapping[str, EffectCost]
) -> dict[str, Any]:
    """What effects and analyses cost, as plain data: of an effect that is off, what that saves."""
    return {
        "effects": {
            effect.name: {
                "on": effect.on,
                ("adds_cpu_s" if effect.on else "saves_cpu_s"): effects[effect.name].seconds,
                ("adds_gib" if effect.on else "saves_gib"): effects[effect.name].memory_gib,
            }
            for effect in plan.effects
            if effect.name in effects
        },
        "analyses": {
            name: {"cpu_s": cost.seconds, "memory_gib": cost.memory_gib}
            for name, cost in expected.analyses.items()
        },
    }


def _resolution(found: Resolution | None) -> dict[str, Any]:
    """Mesh to begin with; beams have none."""
    return {
        "element_order": None if found is None else found.degree,
        "corner_size_m": None if found is None else found.size.corner_size_m,
        "size_m": None if found is None else found.size.size_m,
        "expected_relative_error": None if found is None else found.expected_error,
    }
