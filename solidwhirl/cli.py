"""The command line."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from pydantic import ValidationError
from rich.console import Console
from rich.markdown import Markdown

from solidwhirl.errors import OutputError, SceneError
from solidwhirl.geometry import GeometryError
from solidwhirl.scene import Scene

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="Turbine rotors as solids, reduced to superelements, assembled to rotordynamics.",
)
SceneFile = Annotated[Path, typer.Argument(metavar="SCENE.toml", help="The scene file.")]
Level = Annotated[
    str | None,
    typer.Option(metavar="auto|beam|harmonic|solid", help="Instead of the scene's level."),
]
Accuracy = Annotated[
    float | None, typer.Option(metavar="TOL", help="Instead of the scene's relative accuracy.")
]


@app.command()
def run(
    scene: SceneFile,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results.")],
    level: Level = None,
    accuracy: Accuracy = None,
    pictures: Annotated[bool, typer.Option(help="Draw pictures; without, numbers only.")] = True,
    quiet: Annotated[bool, typer.Option("--quiet", help="Say nothing but errors.")] = False,
) -> None:
    """Run a scene from geometry to Campbell plot.

    Writes results.json, report.md, campbell.png, bodies/ and meshes/ into the folder.
    Under mpirun the bodies of level solid are reduced on all ranks.
    """

    def work() -> None:
        chosen = _scene(scene, level, accuracy)
        _refuse_unwritable(out)
        from mpi4py import MPI

        from solidwhirl.pipeline import run_scene
        from solidwhirl.results import write_results

        console = Console(stderr=True, quiet=quiet or MPI.COMM_WORLD.rank != 0)
        with console.status("") as status:

            def progress(text: str) -> None:
                status.update(text)
                if not console.is_terminal:
                    console.print(text)

            results = run_scene(chosen, comm=MPI.COMM_WORLD, progress=progress)
        if results is None:
            return
        write_results(results, out, pictures=pictures)
        drawn = (("Campbell plot", "campbell.png"),) if pictures else ()
        for title, name in (
            *drawn,
            ("report", "report.md"),
            ("results", "results.json"),
        ):
            if not quiet:
                typer.echo(f"{title}: {out / name}")

    _guarded(scene, work)


@app.command()
def plan(scene: SceneFile, level: Level = None, accuracy: Accuracy = None) -> None:
    """Print what a scene calls for, what is left out, why, and what it costs."""

    def work() -> None:
        from solidwhirl.bodies import build_bodies
        from solidwhirl.forecast import forecast
        from solidwhirl.levels import chosen_level
        from solidwhirl.plan import make_plan
        from solidwhirl.report import cost_text, plan_text

        chosen = _scene(scene, level, accuracy)
        bodies = build_bodies(chosen)
        decided = make_plan(chosen, bodies, chosen_level(chosen, bodies))
        text = plan_text(decided)
        if bodies:
            text += "\n\n" + cost_text(forecast(chosen, decided, bodies))
        console = Console(width=None if sys.stdout.isatty() else 200)
        console.print(Markdown(text))

    _guarded(scene, work)


@app.command()
def study(
    scene: SceneFile,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results.")],
    quick: Annotated[bool, typer.Option("--quick", help="A small matrix of settings.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Say nothing but errors.")] = False,
) -> None:
    """Measure what accuracy costs: error against time and memory over levels, meshes and modes.

    Writes study.json, study.md, study.html and pictures. A study that was broken off goes on.
    """

    def work() -> None:
        _refuse_unwritable(out)
        from solidwhirl.study import study_command

        console = Console(stderr=True, quiet=quiet)
        with console.status("") as status:

            def progress(text: str) -> None:
                status.update(text)
                if not console.is_terminal:
                    console.print(text)

            done = study_command(scene, out, progress, quick=quick)
        if quiet:
            return
        typer.echo(f"page: {done.page}")
        typer.echo(f"table: {done.report}")
        typer.echo(f"{done.done} cases, {done.failed} failed, {done.skipped} skipped")

    _guarded(scene, work)


@app.command()
def identify(
    problem: Annotated[Path, typer.Argument(metavar="PROBLEM.toml", help="The problem file.")],
    out: Annotated[Path, typer.Option(metavar="SCENE.toml", help="The scene file to write.")],
    quiet: Annotated[bool, typer.Option("--quiet", help="Say nothing but errors.")] = False,
) -> None:
    """Find numbers of a scene that nobody gives from masses and frequencies that are known.

    Writes the scene with the values found, and a record of how well the data determine them.
    A search that was broken off goes on where it stopped.
    """

    def work() -> None:
        _refuse_unwritable(out.parent)
        from solidwhirl.identify import identify_command

        console = Console(stderr=True, quiet=quiet)
        with console.status("") as status:

            def progress(text: str) -> None:
                status.update(text)
                if not console.is_terminal:
                    console.print(text)

            done = identify_command(problem, out, progress)
        if not quiet:
            typer.echo(f"scene: {done.scene}")
            typer.echo(f"record: {done.report}")
        if not done.met:
            typer.echo(f"targets that are not met: {', '.join(done.missed)}", err=True)
            raise typer.Exit(1)

    _guarded(problem, work)


@app.command()
def version() -> None:
    """Print the versions of the program and of what it runs on."""
    from solidwhirl.versions import package_versions

    for name, number in package_versions().items():
        typer.echo(f"{name} {number}")


def _scene(path: Path, level: str | None, accuracy: float | None) -> Scene:
    from solidwhirl.scene_file import read_scene, with_model

    scene = read_scene(path)
    try:
        return with_model(scene, level=level, accuracy=accuracy)
    except ValidationError as error:
        problems = [_option_problem(e) for e in error.errors()]
        raise SceneError("command line", problems) from error


def _option_problem(error: Any) -> str:
    """One line; only the level can contradict another key of the scene."""
    if not error["loc"]:
        return f"--level: {str(error['msg']).removeprefix('Value error, ')}"
    return f"--{error['loc'][0]}: {error['msg']}, found {error['input']!r}"


def _refuse_unwritable(out: Path) -> None:
    """Find out before the long work, not after, that the folder can not be written."""
    nearest = out
    while not nearest.exists() and nearest != nearest.parent:
        nearest = nearest.parent
    if not nearest.is_dir():
        raise OutputError(f"{out}: can not be written: {nearest} is not a folder")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise OutputError(f"{out}: can not be written: no permission in {nearest}")


def _guarded(scene: Path, work: Callable[[], None]) -> None:
    """Run a command; what the user caused ends in one message and exit code 2."""
    logging.getLogger().setLevel(logging.WARNING)  # the form compiler talks at INFO level
    try:
        work()
    except SceneError as error:
        _stop(str(error))
    except OutputError as error:
        _stop(str(error))
    except _user_errors() as error:
        _stop(f"{scene}: {error}")
    except np.linalg.LinAlgError as error:
        _stop(
            f"{scene}: the numbers of this scene can not be solved ({error}); check masses, "
            "inertias, stiffnesses and units"
        )


def _user_errors() -> tuple[type[Exception], ...]:
    """Errors of stages that were reached; a stage that was not imported raised nothing."""
    kinds: list[type[Exception]] = [GeometryError]
    for module, names in (
        ("solidwhirl.meshing", ("MeshingError",)),
        ("solidwhirl.cost", ("CostError",)),
        ("solidwhirl.study", ("StudyError",)),
        ("solidwhirl.reduction", ("ReductionError",)),
        ("solidwhirl.rotordyn", ("AssemblyError", "AnalysisError", "SuperelementError")),
    ):
        loaded: Any = sys.modules.get(module)
        kinds += [getattr(loaded, name) for name in names if loaded is not None]
    return tuple(kinds)


def _stop(message: str) -> None:
    """Print the message and leave with code 2, on all ranks."""
    typer.echo(f"error: {message}", err=True)
    mpi: Any = sys.modules.get("mpi4py.MPI")
    if mpi is not None and mpi.COMM_WORLD.size > 1:
        sys.stderr.flush()
        mpi.COMM_WORLD.Abort(2)
    raise typer.Exit(2)


def main() -> None:
    """Entry point of the command `solidwhirl`."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    app()
