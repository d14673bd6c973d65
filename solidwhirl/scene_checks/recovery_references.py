"""What a recovery names and can not have, found before anything is meshed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from solidwhirl.core.errors import unknown
from solidwhirl.geometry.features import FEWEST
from solidwhirl.scene.records import Scene

if TYPE_CHECKING:
    from solidwhirl.analyses.recovery.analysis import RecoverySpec
    from solidwhirl.analyses.recovery.records import RecoveryStateSpec


def recovery_problems(scene: Scene) -> list[str]:
    """What the recoveries of a scene name and can not have: a line each, key first."""
    problems = []
    written: set[str] = set()
    for k, spec in enumerate(scene.analyses):
        if spec.kind != "recovery":
            continue
        problems += [f"analyses[{k}].{text}" for text in _problems(scene, spec)]
        for file in (f"{spec.label}_{b}_{s.label}" for b in spec.bodies for s in spec.states):
            if file.lower() in written:
                problems.append(f"analyses[{k}].states: {file} would be written twice; rename one")
            written.add(file.lower())
    return problems


def recovered_bodies(scene: Scene) -> tuple[str, ...]:
    """Bodies whose solid a recovery of the scene asks for."""
    asked = [b for spec in scene.analyses if spec.kind == "recovery" for b in spec.bodies]
    return tuple(dict.fromkeys(asked))


def recovers_beams(scene: Scene, spec: RecoverySpec) -> bool:
    """Whether a recovery asks for a body that the scene has as a beam."""
    return scene.model.level == "beam" and not scene.bodies.keys().isdisjoint(spec.bodies)


def meshes_for(scene: Scene) -> tuple[str, ...]:
    """Bodies whose mesh an analysis of the scene asks for."""
    own = [spec.body for spec in scene.analyses if spec.kind == "nodal_diameters"]
    return tuple(dict.fromkeys([*recovered_bodies(scene), *own]))


def no_solid(scene: Scene, body: str) -> str:
    """Why a body of a scene has no mesh; empty if it has one."""
    if body in scene.interface_names() and body not in scene.finite_element_bodies():
        return f"{body!r} is no solid; only [bodies.NAME] and [mesh_bodies.NAME] have a mesh"
    if scene.model.level == "beam" and body in scene.bodies:
        return (
            f'with model.level = "beam" {body!r} has no mesh; choose "auto", "harmonic" or "solid"'
        )
    return ""


def sectors_of(scene: Scene, name: str) -> int | None:
    """Number of equal sectors of a body; None of one of revolution, or where it has none."""
    if name in scene.mesh_bodies:
        return scene.mesh_bodies[name].sectors
    common = math.gcd(*_feature_counts(scene, name))
    return common if common >= FEWEST else None


def _feature_counts(scene: Scene, name: str) -> list[int]:
    """How many places every set of blades, holes, ... of a body of sections has."""
    if name not in scene.bodies:
        return []
    body = scene.bodies[name]
    groups = (group.blades.count for group in body.stage_groups if group.blades is not None)
    sets = (body.blades, body.holes, body.slots, body.keyways, body.flats, body.cuts)
    own = (feature.count for features in sets for feature in features)
    return [*own, *(n for several in groups for n in several)]


def no_common_sector(scene: Scene, name: str) -> str:
    """Why a body of sections has no equal sectors; empty if it has."""
    counts = _feature_counts(scene, name)
    # a count that no body can have is refused with its own reason
    if not counts or min(counts) < 1 or math.gcd(*counts) >= FEWEST:
        return ""
    told = ", ".join(str(n) for n in sorted(set(counts)))
    return f"the features of {name!r} have the counts {told}, which leave no {FEWEST} equal sectors"


def _problems(scene: Scene, spec: RecoverySpec) -> Iterator[str]:
    known = scene.interface_names()
    for k, body in enumerate(spec.bodies):
        why = no_common_sector(scene, body)
        if why:
            yield (
                f"bodies[{k}]: {why}; displacement and stress are recovered of equal sectors: give "
                "counts with a common divisor of 3 or more, or describe each stage as a body"
            )
        if body in known and body not in scene.finite_element_bodies():
            yield (
                f"bodies[{k}]: {body!r} is no solid; only [bodies.NAME] and [mesh_bodies.NAME] "
                "have stress in a solid"
            )
    if recovers_beams(scene, spec):
        yield (
            'bodies: with model.level = "beam" there is no solid to recover; choose "auto", '
            '"harmonic" or "solid"'
        )
    for k, state in enumerate(spec.states):
        for text in _state_problems(scene, state):
            yield f"states[{k}].{text}"


def _state_problems(scene: Scene, state: RecoveryStateSpec) -> Iterator[str]:
    if state.is_spin and "off" in (scene.effects.stress_stiffening, scene.effects.spin_softening):
        yield "speed_rpm: steady spin has no stress without the effect stress_stiffening"
    places = scene.places()
    if state.peak is not None and state.peak not in places:
        yield f"peak: {unknown('interface', state.peak, places)}"
    for key, kind in (("response", "unbalance_response"), ("run_up", "run_up")):
        name = getattr(state, key)
        if name is None:
            continue
        named = {
            a.label: a
            for a in scene.analyses
            if a.kind == kind and (a.kind == "unbalance_response" or a.kind == "run_up")
        }
        if name not in named:
            yield f"{key}: {unknown(f'analysis of kind {kind}', name, list(named))}"
            continue
        found = named[name]
        if found.kind == "unbalance_response" and found.speed_rpm is not None:
            yield f"{key}: {name!r} has speed_rpm; a state is one in which the unbalance turns too"
        if found.kind == "run_up":
            end = found.ramp_s + found.hold_s
            late = [t for t in state.time_s or () if t > end]
            if late:
                yield f"time_s: {late[0]:g} is after the end of {name!r} at {end:g} s"
        if state.between_rpm is not None and state.between_rpm[0] >= found.to_rpm:
            yield f"between_rpm: {state.between_rpm[0]:g} is not below to_rpm of {name!r}"
