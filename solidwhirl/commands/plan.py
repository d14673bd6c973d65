"""`solidwhirl plan`: what a run would compute, and what it would cost."""

from __future__ import annotations

import shutil
import sys
from typing import Any

import typer

from solidwhirl.commands.options import Accuracy, AsJson, Level, SceneFile, chosen_scene, examples
from solidwhirl.console.guard import guarded

EXAMPLES = examples(
    "solidwhirl plan scenes/ferraris.toml",
    "solidwhirl plan scenes/laval.toml --level solid --accuracy 0.01",
    "solidwhirl plan scenes/laval.toml --level beam --json",
)


def plan(
    scene: SceneFile, level: Level = None, accuracy: Accuracy = None, as_json: AsJson = False
) -> None:
    """Print what a scene calls for, what is left out, why, and what it costs.

    Computes nothing: a second. Where the choice of the level has to try beams that takes some more
    the first time; the choice is kept in the cache folder of the user.
    """

    def work() -> None:
        from solidwhirl.cost.effects import effect_costs
        from solidwhirl.cost.forecast import forecast
        from solidwhirl.cost.machine import this_machine
        from solidwhirl.meshing.imported.records import AnyBody
        from solidwhirl.model.bodies import build_bodies
        from solidwhirl.model.effects import make_plan
        from solidwhirl.model.mesh_bodies import build_mesh_bodies
        from solidwhirl.pipeline.level import planned_level
        from solidwhirl.plausibility.units import implausible

        chosen = chosen_scene(scene, level, accuracy)
        bodies = build_bodies(chosen)
        solids: dict[str, AnyBody] = {**bodies, **build_mesh_bodies(chosen)}
        decided = make_plan(chosen, bodies, planned_level(chosen, bodies))
        doubts = implausible(chosen, bodies)
        machine = this_machine()
        expected = forecast(chosen, decided, solids, machine=machine)
        effects = effect_costs(chosen, decided, solids, expected, machine)
        if as_json:
            from solidwhirl.console.terminal import print_document
            from solidwhirl.cost.tables import forecast_document
            from solidwhirl.output.plan_documents import costs_document, plan_document

            document: dict[str, Any] = {
                "schema": "solidwhirl-plan-1",
                "scene": chosen.name,
                **plan_document(decided),
                "doubts": [doubt.message for doubt in doubts],
                "predicted_cost": {
                    **forecast_document(expected),
                    "calibrated": machine.calibrated,
                    "parts": costs_document(decided, expected, effects),
                },
            }
            print_document(document)
            return
        from solidwhirl.console.plain_text import plain_text
        from solidwhirl.output.plan_text import Costs, accuracy_text, cost_parts, plan_parts
        from solidwhirl.scene.sweep import nominal_text

        nominal = [] if chosen.sweep is None else [nominal_text(str(scene), chosen.sweep)]
        nominal.append(f"Accuracy asked for: {accuracy_text(chosen)}.")
        planned = plan_parts(decided, doubts, Costs(expected, effects))
        said = "`solidwhirl doctor --calibrate` makes it right for this machine, in 20 s."
        rough = [] if machine.calibrated else [said]
        typer.echo(plain_text([*nominal, *planned, *cost_parts(expected), *rough], _width()))

    guarded(scene, work)


def _width() -> int:
    """Of the terminal; lines are long where none limits them."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else 200
