"""`solidwhirl plan`: what a run would compute, and what it would cost."""

from __future__ import annotations

import shutil
import sys
from typing import Annotated, Any

import typer

from solidwhirl.commands.options import Accuracy, AsJson, Level, SceneFile, chosen_scene, examples
from solidwhirl.console.guard import guarded

EXAMPLES = examples(
    "solidwhirl plan scenes/ferraris.toml",
    "solidwhirl plan scenes/laval.toml --level solid --accuracy 0.01",
    "solidwhirl plan scenes/laval.toml --costs",
    "solidwhirl plan scenes/laval.toml --level beam --json",
)


def plan(
    scene: SceneFile,
    level: Level = None,
    accuracy: Accuracy = None,
    costs: Annotated[
        bool, typer.Option("--costs", help="Predict time and memory of every part.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Print what a run would compute and leave out, why, and how long it would take.

    Computes nothing: a second. Where the choice of the level has to try beams that takes some more
    the first time; the choice is kept in the cache folder of the user.
    Warnings are lines on standard error.
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
        from solidwhirl.plausibility.supports import free_motion_doubt
        from solidwhirl.plausibility.units import implausible, refuse_bursting
        from solidwhirl.scene.sweep import nominal_text
        from solidwhirl.scene_reading.weight import free_lateral_groups

        chosen = chosen_scene(scene, level, accuracy)
        bodies = build_bodies(chosen)
        refuse_bursting(chosen, bodies)
        solids: dict[str, AnyBody] = {**bodies, **build_mesh_bodies(chosen)}
        decided = make_plan(chosen, bodies, planned_level(chosen, bodies))
        free = [free_motion_doubt(*found) for found in free_lateral_groups(chosen)]
        doubts = (*implausible(chosen, bodies), *free)
        for doubt in doubts:
            typer.secho(f"warning: {doubt.message}", fg="yellow", err=True)
        machine = this_machine()
        expected = forecast(chosen, decided, solids, machine=machine)
        if as_json:
            effects = effect_costs(chosen, decided, solids, expected, machine)
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
        from solidwhirl.output.plan_text import (
            Costs,
            accuracy_text,
            brief_parts,
            cost_parts,
            plan_parts,
        )

        if chosen.sweep is not None:
            typer.echo(nominal_text(str(scene), chosen.sweep), err=True)
        if costs:
            effects = effect_costs(chosen, decided, solids, expected, machine)
            parts = [*plan_parts(decided, Costs(expected, effects)), *cost_parts(expected)]
        else:
            parts = brief_parts(decided, expected)
        said = "`solidwhirl doctor --calibrate` makes times right for this machine, in 20 s."
        parts.insert(0, f"Accuracy asked for: {accuracy_text(chosen)}.")
        parts += [] if machine.calibrated else [said]
        typer.echo(plain_text(parts, _width()))

    guarded(scene, work)


def _width() -> int:
    """Of the terminal; lines are long where none limits them."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else 200
