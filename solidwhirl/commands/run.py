"""`solidwhirl run`: a scene from geometry to its folder of results."""

from __future__ import annotations

import shlex
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import click
import typer

from solidwhirl.commands.options import (
    Accuracy,
    AsJson,
    Level,
    Quiet,
    SceneFile,
    Store,
    chosen_scene,
    examples,
    refuse_unwritable,
)
from solidwhirl.console.guard import guarded
from solidwhirl.console.terminal import RunProgress, print_document
from solidwhirl.core.stages import Stage, StageName
from solidwhirl.scene.records import Scene

if TYPE_CHECKING:
    from solidwhirl.geometry import Body
    from solidwhirl.pipeline.run import Results

EXAMPLES = examples(
    "solidwhirl run scenes/laval.toml --out out/laval",
    "solidwhirl run scenes/laval.toml --out out/laval --level beam --no-pictures",
    "solidwhirl run scenes/laval.toml --out out/quick --no-pictures --quiet",
    "solidwhirl run scenes/laval.toml --out out/laval --no-pictures --json",
)


@dataclass(frozen=True, kw_only=True)
class _Places:
    """What a run reads, where it writes, and where stages are kept."""

    scene: Path
    out: Path
    store: Path | None
    fresh: bool
    pictures: bool
    command: str


@dataclass(frozen=True, kw_only=True)
class _Voice:
    """What a run says at its end."""

    quiet: bool
    as_json: bool


def run(
    scene: SceneFile,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results.")],
    level: Level = None,
    accuracy: Accuracy = None,
    store: Store = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="Compute all stages again.")] = False,
    pictures: Annotated[bool, typer.Option(help="Draw PNG pictures; the page needs none.")] = True,
    quiet: Quiet = False,
    as_json: AsJson = False,
) -> None:
    """Run a scene from geometry to Campbell plot.

    Writes report.html, report.md, results.json, pictures, bodies/ and meshes/ into the folder. A
    run that was broken off goes on from its last complete stage.
    Under mpirun the bodies of level solid are reduced on all ranks.
    The exit code is 3 if a check of the results failed, 2 if the scene was refused. Warnings and an
    accuracy that is not met are lines on the error stream, with exit code 0.
    """
    places = _Places(
        scene=scene,
        out=out,
        store=store,
        fresh=fresh,
        pictures=pictures,
        command=_command(scene, out, level, accuracy),
    )

    def work() -> None:
        chosen = chosen_scene(scene, level, accuracy)
        refuse_unwritable(out)
        from mpi4py import MPI

        from solidwhirl.pipeline.run import run_scene

        if MPI.COMM_WORLD.rank != 0:
            run_scene(chosen, comm=MPI.COMM_WORLD)
            return
        _run_on_first_rank(chosen, places, _Voice(quiet=quiet, as_json=as_json))

    guarded(
        scene,
        work,
        told=_refusal(scene) if as_json else _nothing,
        goes_on=lambda: _keeps_stages(places),
    )


def _keeps_stages(places: _Places) -> bool:
    """Whether stages are kept that the same command would take up."""
    from solidwhirl.files.run_folder import STAGES

    if places.fresh:
        return False
    try:
        return any((places.store or places.out / STAGES).iterdir())
    except OSError:
        return False


def _command(scene: Path, out: Path, level: str | None, accuracy: float | None) -> str:
    """The command line whose results are the same."""
    words = ["solidwhirl", "run", str(scene), "--out", str(out)]
    words += ["--level", level] if level is not None else []
    words += ["--accuracy", f"{accuracy:g}"] if accuracy is not None else []
    return shlex.join(words)


def _nothing(message: str) -> None:
    """Say nothing: the message itself goes to the error stream."""


def _refusal(scene: Path) -> Callable[[str], None]:
    from solidwhirl.console.summary import refusal_document

    return lambda message: print_document(refusal_document(scene, message))


def _started_s() -> float:
    """When the program was started [s]: loading it is part of the time that a user waits."""
    context = click.get_current_context(silent=True)
    known = None if context is None else context.obj
    return known if isinstance(known, float) else time.perf_counter()


def _run_on_first_rank(scene: Scene, places: _Places, voice: _Voice) -> None:
    """Run and write a scene on the rank that has the results."""
    from solidwhirl.console.summary import (
        doubt_lines,
        print_summary,
        summary_document,
        warning_lines,
    )
    from solidwhirl.core.check_report import failed
    from solidwhirl.model.bodies import build_bodies
    from solidwhirl.plausibility.units import implausible
    from solidwhirl.scene.sweep import nominal_text

    started = _started_s()
    if scene.sweep is not None and not voice.quiet:
        typer.echo(nominal_text(str(places.scene), scene.sweep), err=True)
    geometry = build_bodies(scene)
    early = tuple(f"warning: {d.message}" for d in implausible(scene, geometry))
    if not voice.quiet:  # a refusal is one message: a quiet run has them at its end
        _say(early)
    results = _written(scene, geometry, places, voice)
    spent = time.perf_counter() - started
    if voice.as_json:
        print_document(summary_document(results, places.out, spent))
    elif not voice.quiet:
        print_summary(results, places.out, spent)
    if voice.quiet:
        _say(early)
    if voice.quiet or voice.as_json:  # else the summary has them
        _say(doubt_lines(results))
    _say(warning_lines(results))
    if failed(results.checks):
        raise typer.Exit(3)


def _say(lines: Iterable[str]) -> None:
    for line in lines:
        typer.echo(line, err=True)


def _written(scene: Scene, geometry: Mapping[str, Body], places: _Places, voice: _Voice) -> Results:
    """Compute a scene and write its folder."""
    from mpi4py import MPI

    from solidwhirl.files.run_folder import claimed, refuse_foreign_results
    from solidwhirl.output.documents import write_into
    from solidwhirl.pipeline.cached_stages import Keeper, open_fresh_store, open_store
    from solidwhirl.pipeline.run import run_scene

    progress = RunProgress(quiet=voice.quiet, pictures=places.pictures)
    with progress, claimed(places.out) as folder:
        refuse_foreign_results(folder.path)
        opened = open_fresh_store if places.fresh else open_store
        kept = opened(places.store or folder.stages)
        kept.clear_leftovers()
        results = run_scene(
            scene,
            comm=MPI.COMM_WORLD,
            progress=progress,
            foreseen=progress.foreseen,
            store=kept,
            geometry=geometry,
        )
        assert results is not None
        progress(Stage(name=StageName.WRITING))
        keeper = Keeper(store=kept, progress=progress)
        write_into(
            results,
            folder,
            pictures=places.pictures,
            keeper=keeper,
            scene_path=places.scene,
            command=places.command,
        )
        if places.store is None:
            kept.prune()
    return results
