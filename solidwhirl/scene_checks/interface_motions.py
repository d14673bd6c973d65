"""Which motions each interface of a scene must carry: those that something acts on."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from solidwhirl.rotordyn.superelement.validation import MOTIONS
from solidwhirl.scene.bearing_physics import AbsoluteLaw
from solidwhirl.scene.joints import BearingSpec, RigidBodySpec
from solidwhirl.scene.records import Scene

LATERAL = ("ux", "uy")
# Motions by the effect they belong to, whose name begins the keys of a bearing that act on them.
_MOTIONS = {"tilt": ("rx", "ry"), "axial": ("uz",), "torsion": ("rz",)}
EFFECT_OF = {motion: effect for effect, motions in _MOTIONS.items() for motion in motions}
# Carried together: both planes, so that a body stays the same in all directions; and all of order
# 0, since a body that moves along its axis turns about it too, freely if nothing acts on that.
_TOGETHER = ({"rx", "ry"}, {"uz", "rz"})


def motions_acted_on(scene: Scene) -> dict[str, tuple[tuple[str, str], ...]]:
    """Motions that are not lateral, each with the name of what acts on it, by "body.interface"."""
    found: dict[str, list[tuple[str, str]]] = {}
    for place, motion, why in _actions(scene):
        found.setdefault(place, []).append((motion, why))
    return {place: tuple(dict.fromkeys(pairs)) for place, pairs in found.items()}


def places_of_joints(scene: Scene) -> frozenset[str]:
    """Interfaces "body.interface" that a bearing, gear or rigid disk holds or loads."""
    found = {place for bearing in scene.bearings for place in (bearing.first, bearing.second)}
    found |= {place for gear in scene.gears for place in (gear.first, gear.second)}
    for name, body in scene.finite_element_bodies().items():
        found |= {f"{name}.{disk.interface}" for disk in body.rigid_disks}
    return frozenset(found - {"ground"})


def is_off_axis(body: RigidBodySpec) -> bool:
    """Whether a rigid body's lateral motion couples to uz and rz: its c.g. is off the axis."""
    return any(body.center_of_gravity_m[:2])


def acting_on(scene: Scene, effect: str) -> list[str]:
    """Names of what acts on the motions of an effect ("tilt", "axial", "torsion"), each once."""
    names = [why for _, motion, why in _actions(scene) if EFFECT_OF[motion] == effect]
    return list(dict.fromkeys(names))


def _actions(scene: Scene) -> Iterator[tuple[str, str, str]]:
    for bearing in scene.bearings:
        law = scene.law_of(bearing)
        held = law.held if isinstance(law, AbsoluteLaw) else ()
        for motion in dict.fromkeys((*_of_bearing(bearing), *held)):
            for place in (bearing.first, bearing.second):
                if place != "ground":
                    yield place, motion, bearing.name
    for gear in scene.gears:
        for place in (gear.first, gear.second):
            yield place, "rz", gear.name
    for analysis in scene.analyses:
        for place in getattr(analysis, "drives", ()):
            yield place, "rz", f"drive of {analysis.label}"
        for place in getattr(analysis, "axial_places", ()):
            yield place, "uz", f"hammer of {analysis.label}"
        for force in getattr(analysis, "forces", ()):
            for motion in force.motions:
                if motion in EFFECT_OF:
                    yield force.at, motion, f"force of {analysis.label}"
    for name, body in scene.finite_element_bodies().items():
        for disk in body.rigid_disks:
            for motion in ("rx", "ry"):
                yield f"{name}.{disk.interface}", motion, disk.name


@lru_cache(maxsize=256)
def _of_bearing(bearing: BearingSpec) -> tuple[str, ...]:
    """Motions beside the lateral ones that a bearing acts on; a plan asks for every effect."""
    found: list[str] = []
    for effect, motions in _MOTIONS.items():
        keys = [key for key in BearingSpec.model_fields if key.startswith(effect)]
        acts = any(np.any(np.asarray(getattr(bearing, key))) for key in keys)
        found += (m for m in motions if acts or m in bearing.rigid)
    return tuple(found)


def carried_motions(scene: Scene, on: set[str]) -> dict[str, tuple[str, ...]]:
    """Motions that every interface carries under the effects that are on.

    Returns by place "body.interface", in the order ux, uy, uz, rx, ry, rz. An effect that the scene
    switches on itself, not by what acts, is carried by all interfaces. Where an interface carries
    one of uz and rz it carries both, also beside an effect that is off.
    """
    acted = motions_acted_on(scene)
    everywhere = {
        motion
        for motion, effect in EFFECT_OF.items()
        if effect in on and getattr(scene.effects, effect) == "on"
    }
    solids = scene.finite_element_bodies().items()
    disks = {f"{n}.{disk.interface}" for n, b in solids for disk in b.rigid_disks}
    out: dict[str, tuple[str, ...]] = {}
    for body, names in scene.interface_names().items():
        places = [f"{body}.{name}" for name in names]
        # a rigid disk takes part in all that its body can do: it has mass and polar inertia
        moved = {m for at in places for m, _ in acted.get(at, ()) if EFFECT_OF[m] in on}
        moved &= {"uz", "rz"}
        for place in places:
            motions = {m for m, _ in acted.get(place, ()) if EFFECT_OF[m] in on}
            motions |= everywhere | set(LATERAL) | (moved if place in disks else set())
            motions |= {m for pair in _TOGETHER if motions & pair for m in pair}
            out[place] = tuple(m for m in MOTIONS if m in motions)
    return out
