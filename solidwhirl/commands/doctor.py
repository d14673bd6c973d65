"""`solidwhirl doctor`: whether the installation is complete."""

from __future__ import annotations

import typer

from solidwhirl.commands.options import AsJson, examples
from solidwhirl.console.doctor import examine, exit_code, report_document, report_lines
from solidwhirl.console.terminal import print_document

EXAMPLES = examples("solidwhirl doctor", "solidwhirl doctor --json")


def doctor(as_json: AsJson = False) -> None:
    """Check the installation, and say what to install.

    The exit code is 1 if something is missing that runs need.
    """
    found = examine()
    if as_json:
        print_document(report_document(found))
    else:
        for line in report_lines(found):
            typer.echo(line)
    raise typer.Exit(exit_code(found))
