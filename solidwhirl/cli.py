"""The command line."""

from __future__ import annotations

import os
import time
from typing import Annotated

import typer

from solidwhirl.commands import (
    batches,
    check,
    doctor,
    files,
    geometry,
    init,
    pictures,
    plan,
    run,
    searches,
    watch,
)
from solidwhirl.commands.options import Command, examples
from solidwhirl.console.exit_handling import end_of_defect, keep_petsc_from_signals
from solidwhirl.console.streams import lasting_streams

# A terminal that can only take plain text gets help without boxes.
_PLAIN = os.environ.get("TERM", "").lower() in ("dumb", "unknown")

app = typer.Typer(
    add_completion=True,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None if _PLAIN else "markdown",
    help="Turbine rotors as solids, reduced to superelements, assembled to rotordynamics.",
    epilog=examples(
        "solidwhirl init rotor.toml",
        "solidwhirl run rotor.toml --out out/rotor",
        "solidwhirl run --help",
    ),
)


def _print_versions(asked: bool) -> None:
    if asked:
        files.version()
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version",
            callback=_print_versions,
            is_eager=True,
            help="Print the versions of the program and of what it runs on.",
        ),
    ] = False,
) -> None:
    pass


app.command(cls=Command, epilog=init.EXAMPLES)(init.init)
app.command(cls=Command, epilog=run.EXAMPLES)(run.run)
app.command(cls=Command, epilog=plan.EXAMPLES)(plan.plan)
app.command(cls=Command, epilog=searches.STUDY_EXAMPLES)(searches.study)
app.command(cls=Command, epilog=searches.IDENTIFY_EXAMPLES)(searches.identify)
app.command(cls=Command, epilog=check.EXAMPLES)(check.check)
app.command(cls=Command, epilog=batches.EXAMPLES)(batches.batch)
app.command(cls=Command, epilog=batches.PICTURES_EXAMPLES)(batches.batch_pictures)
app.command(cls=Command, epilog=pictures.EXAMPLES)(pictures.pictures)
app.command(cls=Command, epilog=watch.EXAMPLES)(watch.watch)
app.command(cls=Command, epilog=geometry.EXAMPLES)(geometry.geometry)
app.command(cls=Command, epilog=files.EXPORT_EXAMPLES)(files.export)
app.command(cls=Command, epilog=files.FORMATS_EXAMPLES)(files.formats)
app.command(cls=Command, epilog=files.SCHEMA_EXAMPLES)(files.schema)
app.command(cls=Command, epilog=doctor.EXAMPLES)(doctor.doctor)
app.command(cls=Command, epilog=files.VERSION_EXAMPLES)(files.version)


def main() -> None:
    """Entry point of the command `solidwhirl`."""
    streams = lasting_streams()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ["MPLBACKEND"] = "agg"  # pictures are files, whatever the user's own ones are
    keep_petsc_from_signals()
    try:
        app(obj=time.perf_counter())  # what commands load counts as their time
    except SystemExit as end:
        if not isinstance(end.code, int | None):
            raise
        raise SystemExit(streams.exit_code(end.code or 0)) from None
    except Exception as error:
        end_of_defect(error)
