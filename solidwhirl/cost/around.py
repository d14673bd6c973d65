"""What a run costs before its first body and after its last analysis."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from solidwhirl.analyses.work import EngineSize
from solidwhirl.bodies.beams_tried import beams_are_tried
from solidwhirl.cost import run_coefficients as measured
from solidwhirl.cost.machine import REFERENCE, Machine
from solidwhirl.geometry import Body
from solidwhirl.meshing.imported.records import AnyBody
from solidwhirl.model.plan_records import Plan
from solidwhirl.scene.records import Scene

_UNKNOWNS = 1e5
# Pictures of every run, and those of its error estimates.
_DIAGRAMS, _ERRORS = 1, 2


class Writing(NamedTuple):
    """Processor seconds of what is written: files, page, and pictures where they are asked for."""

    files_s: float
    page_s: float
    pictures_s: float


def start_s(
    scene: Scene, plan: Plan, bodies: Mapping[str, AnyBody], machine: Machine = REFERENCE
) -> float:
    """Seconds until the level of the bodies is known: imports, and beams where they are tried."""
    once, body, section = measured.START
    profiles = {name: own for name, own in bodies.items() if isinstance(own, Body)}
    each = sum(body + section * len(own.sections) for own in profiles.values())
    return machine.factor("start") * (once + each * beam_models_tried(scene, plan, profiles))


def beam_models_tried(scene: Scene, plan: Plan, bodies: Mapping[str, Body]) -> int:
    """How many models of beams the choice of the level makes: one, where it shows they won't do."""
    if not beams_are_tried(scene, bodies):
        return 0
    if any(own.level != "beam" for own in plan.bodies.values()):
        return 1
    from solidwhirl.beams.error import VARIANTS  # loads all that makes beams

    return len(VARIANTS)


def writing(scene: Scene, plan: Plan, unknowns: int, machine: Machine = REFERENCE) -> Writing:
    """Seconds of what is written; `unknowns`: of the meshes that are written and shown."""
    size, count = unknowns / _UNKNOWNS, len(scene.analyses)
    once, each, record = measured.FILES
    page, analysis, shown, drawn, fields = measured.PAGE
    first, picture = measured.PICTURES
    recorded = records(scene)
    return Writing(
        files_s=machine.factor("page") * (once + each * size + record * recorded),
        page_s=machine.factor("page")
        * (
            page + analysis * count + shown * size + drawn * recorded + fields * plan.on("recovery")
        ),
        pictures_s=machine.factor("pictures") * (first + picture * pictures(scene, plan)),
    )


def records(scene: Scene) -> float:
    """Millions of numbers over the time that analyses keep in files of their own."""
    kept = (a.work(EngineSize()).values for a in scene.analyses if a.has_record)
    return sum(kept) / 1e6


def pictures(scene: Scene, plan: Plan) -> int:
    """How many pictures a run draws, at most."""
    bearings = {b.name: b.speed_law is not None for b in scene.bearings}
    files = [file for a in scene.analyses for file in a.possible_files(bearings)]
    own = _DIAGRAMS + (_ERRORS if plan.on("error_estimate") else 0)
    return own + sum(file.endswith(".png") for file in files)
