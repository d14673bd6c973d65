"""Which bodies are computed with either coupling of their interfaces, to tell what it does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from solidwhirl.geometry import Body, GeometryError, Interface
from solidwhirl.model.at_level import at_level
from solidwhirl.model.effects import plan_of
from solidwhirl.model.plan_records import Plan
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.interface_motions import places_of_joints

# Accuracy of the pair of models that tell what the coupling of the interfaces does.
_COARSE = 1e-2


@dataclass(frozen=True, kw_only=True)
class Couplings:
    """Bodies as they are and with the other coupling, to be reduced coarsely on their meridians.

    `scene`, `plan`: how; `as_is`, `flipped`: the bodies, without blades, holes and slots.
    """

    scene: Scene
    plan: Plan
    as_is: Mapping[str, Body]
    flipped: Mapping[str, Body]


def couplings_compared(scene: Scene, bodies: Mapping[str, Body]) -> Couplings | None:
    """Return the bodies whose couplings are compared; None where no joint acts on one."""
    joints, looked_at = places_of_joints(scene), places_looked_at(scene)
    as_is, flipped = {}, {}
    for name, body in bodies.items():
        # interfaces that nothing acts on add no stiffness, but cost time
        used = tuple(i for i in body.interfaces if f"{name}.{i.name}" in joints)
        seen = tuple(i for i in body.interfaces if f"{name}.{i.name}" in looked_at)
        kept = tuple(i for i in body.interfaces if i in (*used, *seen) or i.coupling == "rigid")
        if used:
            other = tuple(_flipped(i) if i in used else i for i in kept)
            as_is[name] = replace(body, features=(), interfaces=kept)
            flipped[name] = replace(as_is[name], interfaces=other)
    if not flipped:
        return None
    coarse = at_level(scene, "harmonic", _COARSE)
    plan = plan_of(coarse, as_is)
    return Couplings(scene=coarse, plan=plan, as_is=as_is, flipped=flipped)


def places_looked_at(scene: Scene) -> frozenset[str]:
    """Return the places of unbalance responses, whose peaks are compared, and of sensors."""
    found = {bearing.sensor for bearing in scene.bearings if bearing.sensor is not None}
    for spec in scene.analyses:
        if spec.kind == "unbalance_response":
            found |= {u.at for u in spec.unbalances} | set(spec.observe)
    return frozenset(found)


def _flipped(interface: Interface) -> Interface:
    """The interface with the other coupling; as it is where its kind has but one."""
    rigid = interface.coupling == "rigid"
    try:
        return replace(interface, coupling="distributing" if rigid else "rigid")
    except GeometryError:
        return interface
