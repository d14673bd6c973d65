"""The command line: a command is imported when it is called, its help when that is asked for."""

from __future__ import annotations

import ast
import gc
import os
import time
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import typer
from typer.core import TyperCommand, TyperGroup

# A terminal that can only take plain text gets help without boxes.
_PLAIN = os.environ.get("TERM", "").lower() in ("dumb", "unknown")
_MARKUP: Literal["markdown"] | None = None if _PLAIN else "markdown"


class _Place(NamedTuple):
    """Where a command is: module in `solidwhirl.commands`, function, and examples of its help."""

    module: str
    function: str
    examples: str = "EXAMPLES"


_COMMANDS = {
    "init": _Place("init", "init"),
    "run": _Place("run", "run"),
    "plan": _Place("plan", "plan"),
    "study": _Place("searches", "study", "STUDY_EXAMPLES"),
    "identify": _Place("searches", "identify", "IDENTIFY_EXAMPLES"),
    "check": _Place("check", "check"),
    "batch": _Place("batches", "batch"),
    "batch-pictures": _Place("batches", "batch_pictures", "PICTURES_EXAMPLES"),
    "pictures": _Place("pictures", "pictures"),
    "watch": _Place("watch", "watch"),
    "geometry": _Place("geometry", "geometry"),
    "bearing": _Place("bearing", "bearing"),
    "export": _Place("files", "export", "EXPORT_EXAMPLES"),
    "formats": _Place("files", "formats", "FORMATS_EXAMPLES"),
    "schema": _Place("files", "schema", "SCHEMA_EXAMPLES"),
    "doctor": _Place("doctor", "doctor"),
    "version": _Place("files", "version", "VERSION_EXAMPLES"),
}
# New objects before garbage is looked for: what is imported stays, and is far more than the number
# that Python expects.
_COLLECTED = 100_000
_EXAMPLES = ("solidwhirl init rotor.toml", "solidwhirl run rotor.toml")


class Commands(TyperGroup):
    """The commands; what is not called is not imported."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names in the order of the help."""
        return list(_COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command that knows its help alone, or the whole one once it was called."""
        if cmd_name in _COMMANDS and cmd_name not in self.commands:
            return TyperCommand(cmd_name, callback=None, help=_help(cmd_name))
        return super().get_command(ctx, cmd_name)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Load the command that is called."""
        if args[0] in _COMMANDS:
            self.commands[args[0]] = command(args[0])
        elif not args[0].startswith("-"):
            from solidwhirl.core.errors import choice, clean

            ctx.fail(f"no command {clean(args[0], 60)!r}; {choice(args[0], list(_COMMANDS))}")
        return super().resolve_command(ctx, args)


@cache
def command(name: str) -> Any:
    """Import a command of the command line."""
    from solidwhirl.commands.options import Command

    place = _COMMANDS[name]
    module = import_module(f"solidwhirl.commands.{place.module}")
    alone = typer.Typer(
        add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=_MARKUP
    )
    made = alone.command(name, cls=Command, epilog=getattr(module, place.examples))
    made(getattr(module, place.function))
    return typer.main.get_command(alone)


def every_command() -> dict[str, Any]:
    """Import all commands."""
    return {name: command(name) for name in _COMMANDS}


def _help(name: str) -> str:
    """What a command says of itself, from its source."""
    place = _COMMANDS[name]
    source = Path(__file__).parent / "commands" / f"{place.module}.py"
    tree = ast.parse(source.read_text(encoding="utf-8"))
    found = (n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name == place.function)
    return ast.get_docstring(next(found)) or ""


app = typer.Typer(
    cls=Commands,
    add_completion=True,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=_MARKUP,
    help="Turbine rotors as solids, reduced to superelements, assembled to rotordynamics.",
    epilog="\n\n".join(("Examples:", *_EXAMPLES, "solidwhirl run --help")),
)


def _print_versions(asked: bool) -> None:
    if asked:
        from solidwhirl.commands import files

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


def main() -> None:
    """Entry point of the command `solidwhirl`."""
    from solidwhirl.console.exit_handling import end_of_defect, keep_petsc_from_signals
    from solidwhirl.console.streams import lasting_streams

    streams = lasting_streams()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ["MPLBACKEND"] = "agg"  # pictures are files, whatever the user's own ones are
    # none is used, and looking for some reads about every package that is installed
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    gc.set_threshold(_COLLECTED)
    keep_petsc_from_signals()
    try:
        app(obj=time.perf_counter())  # what commands load counts as their time
    except SystemExit as end:
        if not isinstance(end.code, int | None):
            raise
        raise SystemExit(streams.exit_code(end.code or 0)) from None
    except Exception as error:
        end_of_defect(error)
    finally:
        # what is left goes with the process: at its end Python would look for garbage in all that
        # was imported, several times
        gc.freeze()
