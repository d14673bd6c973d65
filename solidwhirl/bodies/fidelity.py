"""Which level an accuracy needs, where the scene leaves the choice to the program."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from solidwhirl.beams.error import beam_theory_error
from solidwhirl.beams.profile import BeamLevelError
from solidwhirl.beams.scene_bodies import BeamBodies, beam_bodies
from solidwhirl.bodies.beams_tried import beams_are_tried
from solidwhirl.bodies.refinement import asked_modes, sample_speeds
from solidwhirl.geometry import Body
from solidwhirl.model.effects import make_plan
from solidwhirl.model.plan_records import Plan
from solidwhirl.model.system_parts import engine_of, simple_elements
from solidwhirl.rotordyn import modes_at_speed
from solidwhirl.scene.records import Scene

# Beams are taken if their estimate is that much better than what is asked: the estimate of beam
# theory is a spread of models, not a bound.
_RESERVE = 0.5

# Makes the beam models of bodies, their variants with them.
Beams = Callable[[Scene, Plan, Mapping[str, Body]], BeamBodies]


def _estimated_beams(scene: Scene, plan: Plan, bodies: Mapping[str, Body]) -> BeamBodies:
    return beam_bodies(scene, plan, bodies, estimated=True)


def chosen_level(scene: Scene, bodies: Mapping[str, Body], beams: Beams = _estimated_beams) -> str:
    """Choose the cheapest level that is accurate enough, where the scene says "auto".

    Beams cost milliseconds and tell their own error; where that is not good enough, the harmonic
    level is at least as accurate as a solid mesh for every body of revolution, and cheaper. Bodies
    with features are solids wherever others are not, and beams are not tried beside them.
    """
    model = scene.model
    if model.level != "auto":
        return model.level
    if beams_are_tried(scene, bodies) and _beams_suffice(scene, bodies, beams):
        return "beam"
    return "harmonic"


def _beams_suffice(scene: Scene, bodies: Mapping[str, Body], make: Beams) -> bool:
    trial = scene.model_copy(update={"model": scene.model.model_copy(update={"level": "beam"})})
    plan = make_plan(trial, bodies)
    try:
        beams = make(trial, plan, bodies)
    except BeamLevelError:
        return False
    simple = simple_elements(trial, plan)
    systems = [
        engine_of(trial, plan, {**simple, **own}) for own in (beams.elements, *beams.variants)
    ]
    asked = asked_modes(trial)
    for speed in sample_speeds(plan):
        found = [modes_at_speed(s, speed).frequency_hz for s in systems]
        count = asked.number_of(found[0])
        if min(len(f) for f in found) < count:
            return False
        errors = beam_theory_error(np.array([f[:count] for f in found])) if count else np.zeros(1)
        if errors.max() > _RESERVE * scene.model.accuracy:
            return False
    return True
