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
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder of the results; out/study/NAME without."),
    ] = None,
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
        folder = Path("out", "study", scene.stem) if out is None else out
        refuse_unwritable(folder)
        from solidwhirl.study.report import PICTURE, REPORT
        from solidwhirl.study.run import study_command

        with telling(quiet) as progress:
            found = study_command(scene, folder, progress, quick=quick, peers=peers)
        if quiet:
            return
        typer.echo(f"picture: {folder / PICTURE}")
        typer.echo(f"table: {folder / REPORT}")
        done, failed, skipped = found.counts
        typer.echo(f"{done} cases, {failed} failed, {skipped} skipped")

    guarded(scene, work)


def identify(
    problem: Annotated[Path, typer.Argument(metavar="PROBLEM.toml", help="The problem file.")],
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="SCENE.toml", help="The scene file to write; out/PROBLEM.toml without."
        ),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Identify unknown scene parameters from known masses and frequencies.

    Writes the scene with the values found, and a record of how well the data determine them.
    An interrupted search resumes where it stopped.
    """

    def work() -> None:
        file = Path("out", problem.name) if out is None else out
        refuse_unwritable(file.parent)
        from solidwhirl.identify.record import missed_lines, value_lines
        from solidwhirl.identify.run import REPORT, identify_command

        with telling(quiet) as progress:
            found = identify_command(problem, file, progress)
        if not quiet:
            for line in value_lines(found):
                typer.echo(line)
            typer.echo(f"scene: {file}")
            typer.echo(f"record: {file.with_suffix(REPORT)}")
        if not found.met:
            typer.echo(f"targets that are not met: {', '.join(missed_lines(found))}", err=True)
            raise typer.Exit(1)

    guarded(problem, work)
