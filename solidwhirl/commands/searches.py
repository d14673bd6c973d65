"""`solidwhirl study` and `solidwhirl identify`: many runs that answer one question."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from solidwhirl.commands.options import Quiet, SceneFile, examples, refuse_unwritable
from solidwhirl.console.guard import guarded
from solidwhirl.console.terminal import telling

STUDY_EXAMPLES = examples(
    "solidwhirl study scenes/laval.toml --out out/study --quick",
    "solidwhirl study scenes/laval.toml --out out/study",
)
IDENTIFY_EXAMPLES = examples("solidwhirl identify scenes/identify/uhbr_fan.toml --out out/fan.toml")


def study(
    scene: SceneFile,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results.")],
    quick: Annotated[bool, typer.Option("--quick", help="A small matrix of settings.")] = False,
    peers: Annotated[
        Path | None,
        typer.Option(metavar="FILE.json", help="Points of other programs, drawn beside."),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Measure what accuracy costs: error against time and memory over levels, meshes and modes.

    Writes study.json, study.md and study.png. A study that was interrupted continues.
    """

    def work() -> None:
        refuse_unwritable(out)
        from solidwhirl.study.report import PICTURE, REPORT
        from solidwhirl.study.run import study_command

        with telling(quiet) as progress:
            found = study_command(scene, out, progress, quick=quick, peers=peers)
        if quiet:
            return
        typer.echo(f"picture: {out / PICTURE}")
        typer.echo(f"table: {out / REPORT}")
        done, failed, skipped = found.counts
        typer.echo(f"{done} cases, {failed} failed, {skipped} skipped")

    guarded(scene, work)


def identify(
    problem: Annotated[Path, typer.Argument(metavar="PROBLEM.toml", help="The problem file.")],
    out: Annotated[Path, typer.Option(metavar="SCENE.toml", help="The scene file to write.")],
    quiet: Quiet = False,
) -> None:
    """Find numbers of a scene that nobody gives from masses and frequencies that are known.

    Writes the scene with the values found, and a record of how well the data determine them.
    A search that was broken off goes on where it stopped.
    """

    def work() -> None:
        refuse_unwritable(out.parent)
        from solidwhirl.identify.record import missed_lines, value_lines
        from solidwhirl.identify.run import REPORT, identify_command

        with telling(quiet) as progress:
            found = identify_command(problem, out, progress)
        if not quiet:
            for line in value_lines(found):
                typer.echo(line)
            typer.echo(f"scene: {out}")
            typer.echo(f"record: {out.with_suffix(REPORT)}")
        if not found.met:
            typer.echo(f"targets that are not met: {', '.join(missed_lines(found))}", err=True)
            raise typer.Exit(1)

    guarded(problem, work)
