"""Which level an accuracy needs, where the scene leaves the choice to the program."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from solidwhirl.beams.error import VARIANTS, beam_theory_error
from solidwhirl.beams.profile import BeamLevelError
from solidwhirl.beams.scene_bodies import beam_models
from solidwhirl.bodies.beams_tried import beams_are_tried
from solidwhirl.bodies.refinement import asked_modes, sample_speeds
from solidwhirl.geometry import Body
from solidwhirl.model.effects import make_plan
from solidwhirl.model.plan_records import Plan
from solidwhirl.model.system_parts import engine_of, simple_elements
from solidwhirl.rotordyn import Superelement, modes_at_speed
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.scene.records import Scene

# Beams are taken if their estimate is that much better than what is asked: the estimate of beam
# theory is a spread of models, not a bound.
_RESERVE = 0.5

# Makes the beam models of bodies, then their variants, each when it is asked for.
Beams = Callable[[Scene, Plan, Mapping[str, Body]], Iterable[Mapping[str, Superelement]]]


def chosen_level(scene: Scene, bodies: Mapping[str, Body], beams: Beams = beam_models) -> str:
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
    simple, speeds, asked = simple_elements(trial, plan), sample_speeds(plan), asked_modes(trial)
    found: list[list[FloatArray]] = []  # of each model, at each speed
    try:
        for own in make(trial, plan, bodies):
            system = engine_of(trial, plan, {**simple, **own})
            found.append([modes_at_speed(system, speed).frequency_hz for speed in speeds])
            counts = [asked.number_of(frequencies) for frequencies in found[0]]
            if any(f.size < count for f, count in zip(found[-1], counts, strict=True)):
                return False
            # models that are not made yet count as the first one: the error is no less
            models = found + found[:1] * (len(VARIANTS) - len(found))
            for k, count in enumerate(counts):
                errors = beam_theory_error([model[k][:count] for model in models])
                if errors.max(initial=0.0) > _RESERVE * scene.model.accuracy:
                    return False
    except BeamLevelError:
        return False
    return True
