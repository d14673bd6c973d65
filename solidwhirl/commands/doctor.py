"""`solidwhirl doctor`: whether the installation is complete, and how fast the machine is."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from solidwhirl.commands.options import AsJson, examples
from solidwhirl.console.doctor import examine, exit_code, report_document, report_lines
from solidwhirl.console.guard import guarded
from solidwhirl.console.terminal import print_document

EXAMPLES = examples(
    "solidwhirl doctor", "solidwhirl doctor --json", "solidwhirl doctor --calibrate"
)
Calibrate = Annotated[
    bool,
    typer.Option("--calibrate", help="Measure this machine in 20 s; forecasts are right then."),
]


def doctor(as_json: AsJson = False, calibrate: Calibrate = False) -> None:
    """Check the installation, and say what to install.

    The exit code is 1 if something is missing that runs need.
    With --calibrate standard jobs are measured instead, and kept for the forecasts of `plan` and
    `run` in the cache folder of the user.
    """
    if calibrate:
        guarded(Path("doctor --calibrate"), lambda: _calibrate(as_json))
        return
    found = examine()
    if as_json:
        print_document(report_document(found))
    else:
        for line in report_lines(found):
            typer.echo(line)
    raise typer.Exit(exit_code(found))


def _calibrate(as_json: bool) -> None:
    from solidwhirl.console.calibration import calibrate, calibration_document, calibration_lines
    from solidwhirl.cost.machine import calibration_file

    jobs = calibrate()
    if as_json:
        print_document(calibration_document(jobs, calibration_file()))
        return
    for line in calibration_lines(jobs):
        typer.echo(line)
