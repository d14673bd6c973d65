"""Commands that check results, and write them or the geometry in files of other programs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from solidwhirl.commands.options import Force, SceneFile, completing, examples
from solidwhirl.console.guard import guarded

CHECK_EXAMPLES = examples(
    "solidwhirl check out/laval",
    "solidwhirl check out/laval/bodies/rotor.h5 --json",
)
GEOMETRY_EXAMPLES = examples(
    "solidwhirl geometry scenes/laval.toml --step out/laval.step",
    "solidwhirl geometry scenes/ferraris.toml --step out/step --length-unit m",
)
EXPORT_EXAMPLES = examples(
    "solidwhirl export out/laval/bodies/rotor.h5 --format sid -o out/rotor.SID_FEM",
    "solidwhirl export out/laval/bodies/rotor.h5 --format npz -o out/rotor.npz",
)
FORMATS_EXAMPLES = examples("solidwhirl formats")
SCHEMA_EXAMPLES = examples(
    "solidwhirl schema scene",
    "solidwhirl schema results",
)
VERSION_EXAMPLES = examples("solidwhirl version")


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

    def work() -> None:
        from solidwhirl.commands.check_command import check_command

        raise typer.Exit(check_command(paths, as_json=as_json))

    guarded(paths[0], work)


def geometry(
    scene: SceneFile,
    step: Annotated[Path, typer.Option(metavar="FILE|DIR", help="A file, or one for each body.")],
    length_unit: Annotated[
        str,
        typer.Option(
            metavar="mm|m",
            help="Unit of lengths in the file.",
            autocompletion=completing(("mm", "m")),
        ),
    ] = "mm",
    force: Force = False,
) -> None:
    """Write the bodies of a scene as closed solids in STEP files."""

    def work() -> None:
        from solidwhirl.commands.geometry_command import geometry_command

        for path in geometry_command(scene, step, length_unit=length_unit, force=force):
            typer.echo(f"written: {path}")

    guarded(scene, work)


def _formats_beginning(incomplete: str) -> list[str]:
    from solidwhirl.commands.export_command import FORMATS

    return [name for name in FORMATS if name.startswith(incomplete)]


def export(
    body: Annotated[Path, typer.Argument(metavar="BODY.h5", help="A superelement file.")],
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="What to write.")],
    form: Annotated[
        str,
        typer.Option(
            "--format",
            metavar="FORMAT",
            help="`solidwhirl formats` lists them.",
            autocompletion=_formats_beginning,
        ),
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
    force: Force = False,
) -> None:
    """Write a superelement in the files of other programs, and say what they can not carry."""

    def work() -> None:
        from solidwhirl.commands.export_command import export_command

        given = {"modes": modes, "damping": damping, "layout": layout, "records": records}
        given |= {"speed_rpm": speed_rpm}
        options = {name: value for name, value in given.items() if value is not None}
        export_command(body, form, out, options, force=force)

    guarded(body, work)


def formats() -> None:
    """List the formats of `export`, and their options."""
    from solidwhirl.commands.export_command import formats_text

    typer.echo(formats_text())


def schema(
    of: Annotated[
        str,
        typer.Argument(
            metavar="scene|results",
            help="Scene files, or results.json.",
            autocompletion=completing(("scene", "results")),
        ),
    ],
) -> None:
    """Print the JSON schema of scene files or of results.json, for editors and other programs."""
    from solidwhirl.scene_reading.schema import results_schema, scene_schema

    made = {"scene": scene_schema, "results": results_schema}.get(of)
    if made is None:
        raise typer.BadParameter(f"{of!r}; allowed are scene, results")
    typer.echo(json.dumps(made(), indent=1, ensure_ascii=False))


def version() -> None:
    """Print the versions of the program and of what it runs on."""
    from solidwhirl.core.versions import package_versions

    for name, number in package_versions().items():
        typer.echo(f"{name} {number}")
