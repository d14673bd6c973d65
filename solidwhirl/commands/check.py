"""`solidwhirl check`: what must hold for superelement files and the folders of runs."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer
from pydantic import BaseModel, StrictBool, StrictFloat, StrictStr, TypeAdapter, ValidationError
from rich.console import Console
from rich.table import Table
from rich.text import Text

from solidwhirl.commands.options import AsJson, examples
from solidwhirl.console.guard import guarded
from solidwhirl.core.check_report import checks_document, checks_line, failed, failure_lines
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.rotordyn.core.foreign import json_data, regular_bytes
from solidwhirl.rotordyn.storage.files import check_superelement_file
from solidwhirl.rotordyn.superelement.invariants import Invariant, compared, undecided

_LONGEST_RESULTS = 500_000_000
_FILES = "everything in this folder"
_OUTCOMES = {True: ("passed", "green"), False: ("failed", "bold red"), None: ("-", "dim")}


class _Recorded(BaseModel):
    """A check as a run records it; runs of other releases may leave entries out."""

    name: StrictStr = ""
    where: StrictStr = ""
    concerns: StrictStr = ""
    reason: StrictStr = ""
    value: StrictFloat | None = None
    limit: StrictFloat | None = None
    passed: StrictBool | None


@dataclass(frozen=True, kw_only=True)
class Checked:
    """The checks of one file or folder."""

    path: Path
    checks: tuple[Invariant, ...]
    problem: str


EXAMPLES = examples(
    "solidwhirl check out/laval", "solidwhirl check out/laval/bodies/rotor.h5 --json"
)


def check(
    paths: Annotated[
        list[Path], typer.Argument(metavar="PATH...", help="Superelement files, folders of runs.")
    ],
    as_json: AsJson = False,
) -> None:
    """Check what must hold for superelement files and the folders of runs.

    The exit code is 3 if a check fails, 2 if something can not be read.
    """

    def work() -> None:
        raise typer.Exit(check_command(paths, as_json=as_json))

    guarded(paths[0], work)


def check_command(paths: Sequence[Path], *, as_json: bool) -> int:
    """Check files and folders, print what was found, and return the exit code.

    Returns 0: all passed; 3: some failed; 2: something can't be read.
    """
    found = tuple(one for path in paths for one in check_path(path))
    if as_json:
        typer.echo(json.dumps(_document(found), indent=1, allow_nan=False))
    else:
        console = Console(width=None if sys.stdout.isatty() else 140)
        for one in found:
            _show(console, one)
    for one in found:
        if one.problem:
            typer.echo(f"error: {_plain(one.problem)}", err=True)
        for line in failure_lines(one.checks):
            typer.echo(f"{one.path}: {_plain(line)}", err=True)
    return exit_code(found)


def exit_code(found: Sequence[Checked]) -> int:
    """Return 2 if something can't be read, else 3 if a check failed, else 0."""
    if any(one.problem for one in found):
        return 2
    return 3 if any(failed(one.checks) for one in found) else 0


def check_path(path: Path) -> tuple[Checked, ...]:
    """Check one file, or a folder: its manifest, its bodies and what its run recorded."""
    if not path.is_dir():
        return (_file(path),)
    bodies = [_file(file) for file in sorted((path / "bodies").glob("*.h5"))]
    return (_folder(path), *bodies)


def _file(path: Path) -> Checked:
    try:
        return Checked(path=path, checks=check_superelement_file(path), problem="")
    except SuperelementError as error:
        return Checked(path=path, checks=(), problem=str(error))


def _folder(path: Path) -> Checked:
    """Manifest and recorded checks of a run."""
    from solidwhirl.files.run_folder import verify_folder

    problems = verify_folder(path)
    name = "files are as the run wrote them"
    said = "; ".join(problems)
    manifest = compared(name, "folder", len(problems), 0.0, _FILES, said)
    try:
        recorded = _recorded(path / "results.json")
    except (OSError, ValueError) as error:
        text = f"{path / 'results.json'}: {error}"
        return Checked(path=path, checks=(manifest,), problem=text)
    return Checked(path=path, checks=(manifest, *recorded), problem="")


def _recorded(path: Path) -> list[Invariant]:
    """Return the checks that a run recorded: failed ones one by one, the others as one."""
    name, all_ = "checks recorded by the run", "what they are about"
    document = json_data(regular_bytes(path, _LONGEST_RESULTS))
    if not isinstance(document, dict):
        raise ValueError("no results of a run")
    if "invariants" not in document:
        return [undecided(name, path.name, all_, "the run recorded none")]
    try:
        entries = TypeAdapter(list[_Recorded]).validate_python(document["invariants"])
    except ValidationError as error:
        raise ValueError("invariants is no list of checks") from error
    checks = [Invariant(**entry.model_dump()) for entry in entries]
    bad = failed(checks)
    text = f"{len(checks)} recorded: {checks_line(checks)}"
    return [compared(name, path.name, len(bad), 0.0, all_, text), *bad]


def _document(found: Sequence[Checked]) -> dict[str, Any]:
    return {
        "schema": "solidwhirl-checks-1",
        "exit_code": exit_code(found),
        "paths": [
            {
                "path": str(one.path),
                "problem": one.problem or None,
                "checks": checks_document(one.checks),
            }
            for one in found
        ],
    }


def _show(console: Console, one: Checked) -> None:
    """Print the table of one file or folder."""
    if one.problem and not one.checks:
        return
    table = Table(title=Text(_plain(str(one.path))), title_justify="left")
    for head in ("check", "value", "limit", "", "can't be trusted if it fails", "remark"):
        table.add_column(head, overflow="fold")
    for check in one.checks:
        word, style = _OUTCOMES[check.passed]
        table.add_row(
            Text(_plain(check.name)),
            _number(check.value),
            _number(check.limit),
            Text(word, style=style),
            Text(_plain(check.concerns)),
            Text(_plain(check.reason)),
        )
    console.print(table)


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.2g}"


def _plain(text: str) -> str:
    """Return text of a stranger's file without anything that moves a terminal."""
    return "".join(c if c.isprintable() else "?" for c in text)
