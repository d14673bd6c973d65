"""Values that a scene was identified from, as references of the scene that is written."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from solidwhirl.identify_problem import ProblemSpec, TargetSpec, is_mass_target

_NAMES = {
    "mass_kg": "mass",
    "center_of_gravity_m": "centre of gravity",
    "polar_inertia_kg_m2": "polar inertia",
    "diametral_inertia_kg_m2": "diametral inertia",
}


def with_references(data: Mapping[str, Any], spec: ProblemSpec) -> dict[str, Any]:
    """Return the scene with a reference for every target that its results will hold.

    Parameters
    ----------
    data
        Content of a scene file; its own references of other quantities stay.
    spec
        The problem; targets at a speed are left out, for the results need not hold that speed.
    """
    targets = [t for t in spec.targets if is_mass_target(t) or t.speed_rpm == 0.0]
    fitted = [_reference(target) for target in targets]
    known = {entry["quantity"] for entry in fitted}
    others = [entry for entry in data.get("references", ()) if entry["quantity"] not in known]
    return {**data, "references": [*fitted, *others]}


def _reference(target: TargetSpec) -> dict[str, Any]:
    if is_mass_target(target):
        title, quantity = (
            f"{target.body}: {_NAMES[target.quantity]}",
            f"bodies.{target.body}.{target.quantity}",
        )
        if target.quantity == "center_of_gravity_m":
            quantity += "[2]"
    else:
        assert target.mode is not None
        title = f"mode {target.mode} at rest"
        quantity = f"modes_at_rest.frequency_hz[{target.mode - 1}]"
    source = f"{target.source}; identified from it" if target.source else "identified from it"
    return {
        "quantity": quantity,
        "title": title,
        "value": target.value,
        "source": source,
        "tolerance": target.tolerance,
    }
