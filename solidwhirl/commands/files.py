"""Commands that write bodies in files of other programs, schemas and versions."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from solidwhirl.commands.options import Force, completing, examples, taking
from solidwhirl.console.guard import guarded

EXPORT_EXAMPLES = examples(
    "solidwhirl export out/laval/bodies/rotor.h5 --format sid -o out/rotor.SID_FEM",
    "solidwhirl export out/laval/bodies/rotor.h5 --format npz -o out/rotor.npz",
)
FORMATS_EXAMPLES = examples("solidwhirl formats")
SCHEMA_EXAMPLES = examples("solidwhirl schema scene", "solidwhirl schema results")
VERSION_EXAMPLES = examples("solidwhirl version")
# Options of `export` that some formats take.
_OF_FORMATS = ("modes", "damping", "layout", "records", "speed_rpm")


def _formats_beginning(incomplete: str) -> list[str]:
    from solidwhirl.commands.export_command import FORMATS

    return [name for name in FORMATS if name.startswith(incomplete)]


@dataclass(frozen=True, kw_only=True)
class ExportOptions:
    """What `export` takes."""

    body: Annotated[Path, typer.Argument(metavar="BODY.h5", help="A superelement file.")]
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="What to write.")]
    form: Annotated[
        str,
        typer.Option(
            "--format",
            metavar="FORMAT",
            help="`solidwhirl formats` lists them.",
            autocompletion=_formats_beginning,
        ),
    ]
    modes: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="Elastic modes; all if not given.")
    ] = None
    damping: Annotated[
        float | None, typer.Option(min=0.0, max=1.0, metavar="RATIO", help="Of all elastic modes.")
    ] = None
    layout: Annotated[
        str | None, typer.Option(metavar="fembs|mode", help="Columns of Ge and Gr in sid.")
    ] = None
    records: Annotated[
        int | None, typer.Option(metavar="13|18|19", help="Last record group in mbdyn.")
    ] = None
    speed_rpm: Annotated[
        float | None, typer.Option(metavar="RPM", help="Matrices at this speed as well.")
    ] = None
    force: Force = False


@taking(ExportOptions)
def export(asked: ExportOptions) -> None:
    """Write a superelement in the files of other programs, and say what they can not carry."""

    def work() -> None:
        from solidwhirl.commands.export_command import export_command

        given = ((n, getattr(asked, n)) for n in _OF_FORMATS)
        options = {name: value for name, value in given if value is not None}
        export_command(asked.body, asked.form, asked.out, options, force=asked.force)

    guarded(asked.body, work)


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
    from solidwhirl.core.errors import choice
    from solidwhirl.scene_reading.schema import results_schema, scene_schema

    made = {"scene": scene_schema, "results": results_schema}.get(of)
    if made is None:
        raise typer.BadParameter(f"{of!r}; {choice(of, ('scene', 'results'))}")
    typer.echo(json.dumps(made(), indent=1, ensure_ascii=False))


def version() -> None:
    """Print the versions of the program and of what it runs on."""
    from solidwhirl.core.versions import package_versions

    for name, number in package_versions().items():
        typer.echo(f"{name} {number}")
