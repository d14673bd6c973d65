"""`solidwhirl geometry`: the parametric bodies of a scene as STEP files for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from solidwhirl.commands.options import Force, SceneFile, completing, examples
from solidwhirl.console.guard import guarded
from solidwhirl.core.errors import OutputError, choice, writing
from solidwhirl.files.run_folder import refuse_existing
from solidwhirl.geometry import GeometryError

EXAMPLES = examples(
    "solidwhirl geometry scenes/laval.toml --step out/laval.step",
    "solidwhirl geometry scenes/ferraris.toml --step out/step --length-unit m",
)
_UNITS_M = {"mm": 1e-3, "m": 1.0}
_SUFFIXES = (".step", ".stp")


def geometry(
    scene: SceneFile,
    step: Annotated[Path, typer.Option(metavar="FILE|DIR", help="A file, or one for each body.")],
    length_unit: Annotated[
        str,
        typer.Option(
            metavar="mm|m",
            help="Unit of lengths in the file.",
            autocompletion=completing(tuple(_UNITS_M)),
        ),
    ] = "mm",
    force: Force = False,
) -> None:
    """Write the bodies of a scene as closed solids in STEP files."""

    def work() -> None:
        for path in geometry_command(scene, step, length_unit=length_unit, force=force):
            typer.echo(f"written: {path}")

    guarded(scene, work)


def geometry_command(
    scene: Path, step: Path, *, length_unit: str = "mm", force: bool = True
) -> tuple[Path, ...]:
    """Write the bodies of a scene as closed solids of revolution, and return the files.

    `step`: a file .step or .stp for all bodies together, or a folder for one file of each.
    `length_unit`: of the coordinates in the files, "mm" or "m".
    Raises SceneError, GeometryError, MeshingError, OutputError: a scene that can't be read or has
    no body with a profile, solids that can't be made, a file that can't be written or is there
    already, or an unknown unit.
    """
    from solidwhirl.meshing.own.step_write import write_step
    from solidwhirl.model.bodies import build_bodies
    from solidwhirl.scene_reading.reader import read_scene

    if length_unit not in _UNITS_M:
        said = choice(length_unit, list(_UNITS_M))
        raise OutputError(f"--length-unit: found {length_unit!r}; {said}")
    bodies = build_bodies(read_scene(scene))
    if not bodies:
        raise GeometryError(
            "the scene has no [bodies.NAME]; beams, rigid bodies, imported bodies and meshes have "
            "no profile that could be written as STEP"
        )
    files = {step: tuple(bodies.values())}
    if step.suffix.lower() not in _SUFFIXES:
        files = {step / f"{name}.step": (body,) for name, body in bodies.items()}
    refuse_existing(files, force=force)
    with writing(step):
        for path, own in files.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            write_step(own, path, unit_m=_UNITS_M[length_unit])
    return tuple(files)
