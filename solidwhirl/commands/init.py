"""`solidwhirl init`: a scene to begin with."""

from __future__ import annotations

import re
import shlex
from importlib import resources
from pathlib import Path
from string import Template
from typing import Annotated

import typer

from solidwhirl.commands.options import completing, examples, refuse_unwritable
from solidwhirl.console.guard import guarded
from solidwhirl.core.errors import OutputError, choice, writing

#: Kinds of scenes, each a file in `templates`, and what they are.
KINDS = {
    "laval": "a shaft with one disk on two bearings",
    "twin": "two coaxial shafts with an intershaft bearing",
    "engine": "fan, gear, two shafts, casing and mount",
}
EXAMPLES = examples(
    "solidwhirl init",
    "solidwhirl init twin.toml --kind twin",
    "solidwhirl init engines/small.toml --kind engine",
)
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,63}")
_KINDS_TEXT = "; ".join(f"{kind}: {what}" for kind, what in KINDS.items())


def init(
    file: Annotated[Path, typer.Argument(metavar="[SCENE.toml]", help="The file to write.")] = Path(
        "rotor.toml"
    ),
    kind: Annotated[
        str,
        typer.Option(
            metavar="|".join(KINDS), help=_KINDS_TEXT, autocompletion=completing(tuple(KINDS))
        ),
    ] = "laval",
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
) -> None:
    """Write a commented scene that runs as it is, to begin with.

    Asks nothing, and never replaces a file unless told to.
    """

    def work() -> None:
        write_scene(file, kind, replace=force)
        typer.echo(f"written: {file}")
        shown = shlex.quote(str(file))
        typer.echo(f"look:    solidwhirl plan {shown}")
        typer.echo(f"run:     solidwhirl run {shown}")

    guarded(file, work)


def write_scene(file: Path, kind: str, *, replace: bool) -> None:
    """Write a scene of a kind; its name is that of the file where that can be one.

    Raises OutputError: no such kind, the file is there, or can't be written.
    """
    if kind not in KINDS:
        raise OutputError(f"--kind: found {kind!r}; {choice(kind, list(KINDS))}")
    name = file.stem if _NAME.fullmatch(file.stem) else kind
    if file.exists() and not replace:
        raise OutputError(f"{file}: is there already; --force replaces it")
    refuse_unwritable(file.parent)
    shown = shlex.quote(str(file)) if str(file).isprintable() else "SCENE.toml"
    text = scene_text(kind, name=name, file=shown)
    with writing(file):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")


def scene_text(kind: str, *, name: str, file: str) -> str:
    """Return the text of a scene file of one of `KINDS`, whose comments call it `file`."""
    template = resources.files(__package__) / "templates" / f"{kind}.toml"
    return Template(template.read_text(encoding="utf-8")).substitute(name=name, file=file)
