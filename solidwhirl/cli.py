"""The command line."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from pydantic import ValidationError
from rich.console import Console
from rich.markdown import Markdown

from solidwhirl.endings import end_of_defect, keep_petsc_from_signals
from solidwhirl.errors import OutputError, SceneError
from solidwhirl.guard import guarded
from solidwhirl.progress_line import telling
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
Operating = Annotated[
    tuple[float, float] | None,
    typer.Option(metavar="LOW HIGH", help="Operating speeds of the reference shaft, in pictures."),
]
Store = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR",
        envvar="SOLIDWHIRL_STORE",
        help="Folder of completed stages that several runs share; OUT/.stages without.",
    ),
]


@app.command()
def run(
    scene: SceneFile,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results.")],
    level: Level = None,
    accuracy: Accuracy = None,
    store: Store = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="Compute all stages again.")] = False,
    pictures: Annotated[bool, typer.Option(help="Draw pictures; without, numbers only.")] = True,
    quiet: Annotated[bool, typer.Option("--quiet", help="Say nothing but errors.")] = False,
) -> None:
    """Run a scene from geometry to Campbell plot.

    Writes results.json, report.md, campbell.png, bodies/ and meshes/ into the folder. A run that
    was broken off goes on from its last complete stage.
    Under mpirun the bodies of level solid are reduced on all ranks.
    """

    def work() -> None:
        chosen = _scene(scene, level, accuracy)
        _refuse_unwritable(out)
        from mpi4py import MPI

        if MPI.COMM_WORLD.rank != 0:
            from solidwhirl.pipeline import run_scene

            run_scene(chosen, comm=MPI.COMM_WORLD)
            return
        from solidwhirl.run_command import RunPlaces, run_command

        places = RunPlaces(path=scene, out=out, store=store, fresh=fresh)
        if code := run_command(chosen, places, pictures=pictures, quiet=quiet):
            raise typer.Exit(code)

    guarded(scene, work)


@app.command()
def plan(scene: SceneFile, level: Level = None, accuracy: Accuracy = None) -> None:
    """Print what a scene calls for, what is left out, why, and what it costs."""

    def work() -> None:
        from solidwhirl.bodies import build_bodies
        from solidwhirl.forecast import forecast
        from solidwhirl.levels import chosen_level
        from solidwhirl.mesh_bodies import build_mesh_bodies
        from solidwhirl.meshing.user_mesh_records import AnyBody
        from solidwhirl.plan import make_plan
        from solidwhirl.plausibility import implausible
        from solidwhirl.report import cost_text, plan_text
        from solidwhirl.scene_sweep import nominal_text

        chosen = _scene(scene, level, accuracy)
        bodies = build_bodies(chosen)
        solids: dict[str, AnyBody] = {**bodies, **build_mesh_bodies(chosen)}
        decided = make_plan(chosen, bodies, chosen_level(chosen, bodies))
        text = plan_text(decided, implausible(chosen, bodies))
        if chosen.sweep is not None:
            text = f"{nominal_text(str(scene), chosen.sweep)}\n\n{text}"
        if solids:
            text += "\n\n" + cost_text(forecast(chosen, decided, solids))
        console = Console(width=None if sys.stdout.isatty() else 200)
        console.print(Markdown(text))

    guarded(scene, work)


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

        with telling(quiet) as progress:
            done = study_command(scene, out, progress, quick=quick)
        if quiet:
            return
        typer.echo(f"page: {done.page}")
        typer.echo(f"table: {done.report}")
        typer.echo(f"{done.done} cases, {done.failed} failed, {done.skipped} skipped")

    guarded(scene, work)


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

        with telling(quiet) as progress:
            done = identify_command(problem, out, progress)
        if not quiet:
            typer.echo(f"scene: {done.scene}")
            typer.echo(f"record: {done.report}")
        if not done.met:
            typer.echo(f"targets that are not met: {', '.join(done.missed)}", err=True)
            raise typer.Exit(1)

    guarded(problem, work)


@app.command()
def check(
    paths: Annotated[
        list[Path],
        typer.Argument(metavar="PATH...", help="Superelement files, folders of runs."),
    ],
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Check what must hold for superelement files and the folders of runs.

    The exit code is 3 if a check fails, 2 if something can not be read.
    """
    from solidwhirl.check_command import check_command

    raise typer.Exit(check_command(paths, as_json=as_json))


@app.command()
def batch(
    scenes: Annotated[
        list[Path], typer.Argument(metavar="SCENE.toml...", help="Scenes, with [sweep] or without.")
    ],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of all cases and their table.")],
    ranks_per_scene: Annotated[
        int, typer.Option(min=1, metavar="K", help="Ranks that compute a case together.")
    ] = 1,
    resume: Annotated[bool, typer.Option("--resume", help="Do only what is missing.")] = False,
    store: Store = None,
    slurm: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write a Slurm script and run nothing.")
    ] = None,
    level: Level = None,
    accuracy: Accuracy = None,
    pictures: Annotated[bool, typer.Option(help="Draw pictures; without, numbers only.")] = True,
    operating_rpm: Operating = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="Say nothing but errors.")] = False,
) -> None:
    """Run many scenes, or all cases of a sweep, on the ranks of an MPI job.

    The exit code is 1 if a case failed; its message is in the table, and the others are done.
    """

    def work() -> None:
        from solidwhirl.batch_command import batch_command

        code = batch_command(
            scenes,
            out,
            ranks_per_scene=ranks_per_scene,
            resume=resume,
            store=store,
            level=level,
            accuracy=accuracy,
            slurm=slurm,
            quiet=quiet,
            pictures=pictures,
            operating_rpm=operating_rpm,
        )
        if code:
            raise typer.Exit(code)

    guarded(out, work)


@app.command()
def batch_pictures(
    out: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a batch.")],
    operating_rpm: Operating = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="Say nothing but errors.")] = False,
) -> None:
    """Draw the pictures of the sweeps of a batch again, from its rows; nothing is computed."""

    def work() -> None:
        from solidwhirl.batch_pictures import redraw

        files = redraw(out, operating_rpm)
        if not files and not quiet:
            typer.echo(f"{out}: no pictures: no scene has a sweep of two cases that are done")
        for path in () if quiet else files:
            typer.echo(path)

    guarded(out, work)


@app.command()
def geometry(
    scene: SceneFile,
    step: Annotated[Path, typer.Option(metavar="FILE|DIR", help="A file, or one for each body.")],
    length_unit: Annotated[
        str, typer.Option(metavar="mm|m", help="Unit of lengths in the file.")
    ] = "mm",
) -> None:
    """Write the bodies of a scene as closed solids in STEP files."""

    def work() -> None:
        from solidwhirl.geometry_command import geometry_command

        for path in geometry_command(scene, step, length_unit=length_unit):
            typer.echo(f"written: {path}")

    guarded(scene, work)


@app.command()
def export(
    body: Annotated[Path, typer.Argument(metavar="BODY.h5", help="A superelement file.")],
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="What to write.")],
    form: Annotated[
        str, typer.Option("--format", metavar="FORMAT", help="`solidwhirl formats` lists them.")
    ],
    modes: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="Elastic modes; all if not given.")
    ] = None,
    damping: Annotated[
        float | None,
        typer.Option(min=0.0, max=1.0, metavar="RATIO", help="Of all elastic modes."),
    ] = None,
    layout: Annotated[
        str | None, typer.Option(metavar="fembs|mode", help="Columns of Ge and Gr in sid.")
    ] = None,
    records: Annotated[
        int | None, typer.Option(metavar="13|18|19", help="Last record group in mbdyn.")
    ] = None,
    speed_rpm: Annotated[
        float | None, typer.Option(metavar="RPM", help="Matrices at this speed as well.")
    ] = None,
) -> None:
    """Write a superelement in the files of other programs, and say what they can not carry."""

    def work() -> None:
        from solidwhirl.export_command import export_command

        given = {"modes": modes, "damping": damping, "layout": layout, "records": records}
        given |= {"speed_rpm": speed_rpm}
        options = {name: value for name, value in given.items() if value is not None}
        export_command(body, form, out, options)

    guarded(body, work)


@app.command()
def formats() -> None:
    """List the formats of `export`, and their options."""
    from solidwhirl.export_command import formats_text

    typer.echo(formats_text())


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
    from solidwhirl.run_folder import writing_problem

    nearest = out
    while not nearest.exists() and nearest != nearest.parent:
        nearest = nearest.parent
    if not nearest.is_dir():
        raise OutputError(f"{out}: can not be written: {nearest} is not a folder")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise OutputError(f"{out}: can not be written: no permission in {nearest}")
    problem = writing_problem(nearest)  # as root may write what it may not
    if problem is not None:
        raise OutputError(f"{out}: can not be written: {problem} in {nearest}")


def main() -> None:
    """Entry point of the command `solidwhirl`."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    keep_petsc_from_signals()
    try:
        app()
    except Exception as error:
        end_of_defect(error)
