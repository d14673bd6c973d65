"""`solidwhirl pictures`: pictures of a run for a paper or a talk."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from solidwhirl.commands.options import (
    Accuracy,
    Level,
    Quiet,
    SceneFile,
    chosen_scene,
    examples,
    refuse_unwritable,
)
from solidwhirl.console.guard import guarded
from solidwhirl.console.terminal import telling

EXAMPLES = examples(
    "solidwhirl pictures scenes/laval.toml --out out/laval --only campbell",
    "solidwhirl pictures scenes/laval.toml --out out/laval --formats pdf,svg",
)


def pictures(
    scene: SceneFile,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the run, or a new one.")],
    formats: Annotated[
        str,
        typer.Option(metavar="LIST", help="Of pdf, svg, png, gif and mp4, with commas between."),
    ] = "png",
    only: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="A picture, or a pattern with *; may be repeated."),
    ] = None,
    modes: Annotated[
        int, typer.Option(min=0, metavar="N", help="Modes shown in space at most.")
    ] = 4,
    store: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", envvar="SOLIDWHIRL_STORE", help="Where stages are kept; OUT/.stages."
        ),
    ] = None,
    level: Level = None,
    accuracy: Accuracy = None,
    quiet: Quiet = False,
) -> None:
    """Draw the pictures of a run for print, its modes in space, and films of them.

    In the folder of a run nothing of it is computed again. pictures.md lists what was drawn.
    The exit code is 1 if some could not be drawn.
    """

    def work() -> None:
        chosen = chosen_scene(scene, level, accuracy)
        refuse_unwritable(out)
        from solidwhirl.commands.pictures_command import pictures_command

        with telling(quiet) as progress:
            done = pictures_command(
                chosen, out, progress, formats=formats, only=only or (), modes=modes, store=store
            )
        if not quiet:
            typer.echo(f"{len(done.files)} pictures, listed in {done.index}")
        for name, why in done.failed:
            typer.echo(f"not drawn: {name}: {why}", err=True)
        if done.failed:
            raise typer.Exit(1)

    guarded(scene, work)
