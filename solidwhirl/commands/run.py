"""`solidwhirl run`: a scene from geometry to its folder of results."""

from __future__ import annotations

import shlex
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from solidwhirl.commands import options
from solidwhirl.console.guard import guarded
from solidwhirl.console.terminal import RUN_SCHEMA, RunProgress, print_document
from solidwhirl.core.stages import Stage, StageName

if TYPE_CHECKING:
    from solidwhirl.pipeline.run import Results
    from solidwhirl.scene.records import Scene

EXAMPLES = options.examples(
    "solidwhirl run scenes/laval.toml",
    "solidwhirl run scenes/laval.toml --out out/laval --level beam --pictures",
    "solidwhirl run scenes/laval.toml --out out/quick --quiet",
    "solidwhirl run scenes/laval.toml --out out/laval --json",
)


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """What `run` takes."""

    context: typer.Context
    scene: options.SceneFile
    out: options.Out = None
    level: options.Level = None
    accuracy: options.Accuracy = None
    store: options.Store = None
    fresh: Annotated[bool, typer.Option("--fresh", help="Compute all stages again.")] = False
    pictures: Annotated[bool, typer.Option(help="Draw PNG pictures; the page needs none.")] = False
    quiet: options.Quiet = False
    as_json: options.AsJson = False

    @property
    def folder(self) -> Path:
        """Where the results go."""
        return options.out_folder(self.out, self.scene)

    @property
    def command(self) -> str:
        """The command line whose results are the same."""
        words = ["solidwhirl", "run", str(self.scene), "--out", str(self.folder)]
        words += ["--level", self.level] if self.level is not None else []
        words += ["--accuracy", f"{self.accuracy:g}"] if self.accuracy is not None else []
        return shlex.join(words)


@options.taking(RunOptions)
def run(asked: RunOptions) -> None:
    """Run a scene from geometry to Campbell plot.

    Writes report.html, report.md, results.json, bodies/ and meshes/ into the folder. An
    interrupted run resumes from its last completed stage.
    Under mpirun the bodies of level solid are reduced on all ranks.
    The exit code is 3 if a check of the results failed, 2 if the scene was refused. Warnings and an
    accuracy that is not met are lines on the error stream, with exit code 0.
    """

    def work() -> None:
        scene = options.chosen_scene(asked.scene, asked.level, asked.accuracy)
        options.refuse_unwritable(asked.folder)
        from mpi4py import MPI

        from solidwhirl.pipeline.run import run_scene

        if MPI.COMM_WORLD.rank != 0:
            run_scene(scene, comm=MPI.COMM_WORLD)
            return
        _run_on_first_rank(scene, asked)

    def told(message: str) -> None:
        if asked.as_json:
            refused = {"scene_file": str(asked.scene), "exit_code": 2, "error": message}
            print_document({"schema": RUN_SCHEMA, **refused})

    guarded(asked.scene, work, told=told, goes_on=lambda: _keeps_stages(asked))


def _keeps_stages(asked: RunOptions) -> bool:
    """Whether stages are kept that the same command would take up."""
    from solidwhirl.files.run_folder import STAGES

    if asked.fresh:
        return False
    try:
        return any((asked.store or asked.folder / STAGES).iterdir())
    except OSError:
        return False


def _run_on_first_rank(scene: Scene, asked: RunOptions) -> None:
    """Run and write a scene on the rank that has the results."""
    from solidwhirl.console import summary
    from solidwhirl.core.check_report import failed, failure_lines
    from solidwhirl.scene.sweep import nominal_text

    # loading the program is part of the time that a user waits
    known = asked.context.obj
    started = known if isinstance(known, float) else time.perf_counter()
    if scene.sweep is not None and not asked.quiet:
        typer.echo(nominal_text(str(asked.scene), scene.sweep), err=True)
    results, document = _written(scene, asked)
    told = summary.summary_document(
        results, document, asked.folder, seconds=time.perf_counter() - started
    )
    if asked.as_json:
        print_document(told)
    elif not asked.quiet:
        summary.print_summary(results, told)
    # those of the scene were said when the run began
    said = set() if asked.quiet else {doubt.message for doubt in results.doubts}
    lines = [f"warning: {text}" for text in summary.warning_texts(document) if text not in said]
    for line in (*lines, *failure_lines(results.checks)):
        typer.secho(line, fg="yellow", err=True)
    if failed(results.checks):
        raise typer.Exit(3)


def _written(scene: Scene, asked: RunOptions) -> tuple[Results, dict[str, Any]]:
    """Compute a scene and write its folder; the results as records and as they are written."""
    from mpi4py import MPI

    from solidwhirl.files.run_folder import STAGES, claimed, refuse_foreign_results
    from solidwhirl.output.documents import write_into
    from solidwhirl.output.picture_processes import in_processes, in_turn
    from solidwhirl.pipeline.cached_stages import StageCache, open_fresh_store, open_store
    from solidwhirl.pipeline.run import run_scene

    progress = RunProgress(quiet=asked.quiet, pictures=asked.pictures)
    with progress, claimed(asked.folder) as folder:
        refuse_foreign_results(folder)
        kept = (open_fresh_store if asked.fresh else open_store)(asked.store or folder / STAGES)
        kept.clear_leftovers()
        results = run_scene(
            scene, comm=MPI.COMM_WORLD, progress=progress, foreseen=progress.foreseen, store=kept
        )
        assert results is not None
        progress(Stage(name=StageName.WRITING))
        document = write_into(
            results,
            folder,
            pictures=asked.pictures,
            begin=in_processes if MPI.COMM_WORLD.size == 1 else in_turn,
            stage_cache=StageCache(store=kept, progress=progress),
            scene_path=asked.scene,
            command=asked.command,
        )
        if asked.store is None:
            kept.prune()
    return results, document
