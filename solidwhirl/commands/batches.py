"""`solidwhirl batch` and `batch-pictures`: many cases on the ranks of a job."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from solidwhirl.commands.options import (
    Accuracy,
    Level,
    Quiet,
    Store,
    examples,
    out_folder,
    taking,
)
from solidwhirl.console.guard import guarded

EXAMPLES = examples(
    "solidwhirl batch scenes/laval.toml scenes/ferraris.toml --out out/batch",
    "mpirun -n 2 solidwhirl batch scenes/sweep.toml --out out/sweep --resume",
    "solidwhirl batch scenes/sweep.toml --out out/sweep --slurm out/sweep.slurm",
)
PICTURES_EXAMPLES = examples("solidwhirl batch-pictures out/sweep --operating-rpm 8500 9000")

Operating = Annotated[
    tuple[float, float] | None,
    typer.Option(metavar="LOW HIGH", help="Operating speeds of the reference shaft, in pictures."),
]


@dataclass(frozen=True, kw_only=True)
class BatchOptions:
    """What `batch` takes."""

    scenes: Annotated[
        list[Path], typer.Argument(metavar="SCENE.toml...", help="Scenes, with [sweep] or without.")
    ]
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Folder of all cases and their table; out/NAME without, out/batch of many scenes.",
        ),
    ] = None
    ranks_per_scene: Annotated[
        int, typer.Option(min=1, metavar="K", help="Ranks that compute a case together.")
    ] = 1
    resume: Annotated[bool, typer.Option("--resume", help="Do only what is missing.")] = False
    store: Store = None
    slurm: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write a Slurm script and run nothing.")
    ] = None
    level: Level = None
    accuracy: Accuracy = None
    pictures: Annotated[bool, typer.Option(help="Draw pictures of the sweeps at the end.")] = True
    operating_rpm: Operating = None
    quiet: Quiet = False


@taking(BatchOptions)
def batch(asked: BatchOptions) -> None:
    """Run many scenes, or all cases of a sweep, on the ranks of an MPI job.

    The exit code is 1 if a case failed; its message is in the table, and the others are done.
    """
    alone = asked.scenes[0] if len(asked.scenes) == 1 else Path("batch")
    out = out_folder(asked.out, alone)

    def work() -> None:
        from solidwhirl.batch.case import CaseSettings
        from solidwhirl.batch.command import batch_command

        code = batch_command(
            asked.scenes,
            CaseSettings(
                out=out,
                store=asked.store,
                level=asked.level,
                accuracy=asked.accuracy,
                pictures=asked.pictures,
            ),
            ranks_per_scene=asked.ranks_per_scene,
            resume=asked.resume,
            slurm=asked.slurm,
            quiet=asked.quiet,
            operating_rpm=asked.operating_rpm,
        )
        if code:
            raise typer.Exit(code)

    guarded(out, work)


def batch_pictures(
    out: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a batch.")],
    operating_rpm: Operating = None,
    quiet: Quiet = False,
) -> None:
    """Draw the pictures of the sweeps of a batch again, from its rows; nothing is computed."""

    def work() -> None:
        from solidwhirl.batch.pictures import redraw

        files = redraw(out, operating_rpm)
        if not files and not quiet:
            typer.echo(f"{out}: no pictures: no scene has a sweep of two cases that are done")
        for path in () if quiet else files:
            typer.echo(path)

    guarded(out, work)
