"""Arguments that several commands have, and what their help has at its end."""

from __future__ import annotations

import dataclasses
import inspect
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, get_type_hints

import typer
from pydantic import ValidationError
from typer.core import TyperCommand

from solidwhirl.core.errors import OutputError, SceneError

if TYPE_CHECKING:
    from solidwhirl.scene.records import Scene

# Bytes of a name of a file, and of a path that leaves room for what is made in a folder.
_LONGEST_NAME, _LONGEST_PATH = 255, 3800
LEVELS = ("auto", "beam", "harmonic", "solid")


class Command(TyperCommand):
    """A command that refuses words which can be no path, before they are taken for one.

    An empty one, as a script gets from a variable that is not set, would be the current folder.
    """

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Refuse empty and endless words, then do as all commands do."""
        for word in args:
            name, equals, value = word.partition("=")
            is_option = word.startswith("--")
            problem = _problem(value if equals and is_option else word)
            if problem:
                ctx.fail(f"{name if is_option else 'a word of the command'} {problem}")
        return super().parse_args(ctx, args)


def _problem(value: str) -> str:
    """What is wrong with a word in place of a path; empty if nothing is."""
    if not value:
        return "is empty; a name is needed"
    if len(os.fsencode(value)) > _LONGEST_PATH or any(
        len(os.fsencode(part)) > _LONGEST_NAME for part in value.split("/")
    ):
        return f"{value[:40]}... is too long for a path ({len(value)} characters)"
    return ""


Options = TypeVar("Options")


def taking(record: type[Options]) -> Callable[[Callable[[Options], None]], Callable[..., None]]:
    """Let typer read the options of a command from the annotated fields of a dataclass."""
    hints = get_type_hints(record, include_extras=True)
    parameters = [
        inspect.Parameter(
            field.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=(
                inspect.Parameter.empty if field.default is dataclasses.MISSING else field.default
            ),
            annotation=hints[field.name],
        )
        for field in dataclasses.fields(record)  # type: ignore[arg-type]
    ]

    def made(work: Callable[[Options], None]) -> Callable[..., None]:
        def command(**given: Any) -> None:
            work(record(**given))

        command.__name__, command.__doc__ = work.__name__, work.__doc__
        command.__annotations__ = hints
        command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        return command

    return made


def completing(allowed: tuple[str, ...]) -> Any:
    """Return a completer of a shell for a few words."""

    def complete(incomplete: str) -> list[str]:
        return [word for word in allowed if word.startswith(incomplete)]

    return complete


def out_folder(given: Path | None, scene: Path) -> Path:
    """Return the folder that was given, else `out/NAME` of a scene file `NAME.toml`."""
    return Path("out", scene.stem) if given is None else given


SceneFile = Annotated[Path, typer.Argument(metavar="SCENE.toml", help="The scene file.")]
Out = Annotated[
    Path | None,
    typer.Option(
        "--out", metavar="DIR", help="Folder of the results; out/NAME of a scene file NAME.toml."
    ),
]
Level = Annotated[
    str | None,
    typer.Option(
        metavar="auto|beam|harmonic|solid",
        help="Instead of the scene's level.",
        autocompletion=completing(LEVELS),
    ),
]
Accuracy = Annotated[
    float | None, typer.Option(metavar="TOL", help="Instead of the scene's relative accuracy.")
]
Store = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR",
        envvar="SOLIDWHIRL_STORE",
        help="Folder of completed stages that several runs share; OUT/.stages without.",
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Say nothing but errors and warnings.")]
Force = Annotated[bool, typer.Option("--force", help="Replace files that are there.")]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON document and nothing else on stdout.")
]


def examples(*lines: str) -> str:
    """Return the end of a command's help: lines that can be typed as they are."""
    return "\n\n".join(("Examples:", *lines))


def chosen_scene(path: Path, level: str | None, accuracy: float | None) -> Scene:
    """Read a scene, with the values of the command line in place of its own.

    As beams, its bodies have no stress: recoveries of them are left out, with a warning.

    Raises SceneError: the file or an option is refused.
    """
    from solidwhirl.scene_checks.recovery_references import recovery_problems
    from solidwhirl.scene_reading.analysis_checks import analysis_problems
    from solidwhirl.scene_reading.reader import read_scene, with_model

    scene = read_scene(path)
    try:
        changed = with_model(scene, level=level, accuracy=accuracy)
    except ValidationError as error:
        problems = [_option_problem(e) for e in error.errors()]
        raise SceneError("command line", problems) from error
    if level is None:  # its analyses were looked at with the file
        return changed
    changed = _without_recoveries(changed)
    # what an analysis needs may be there on the scene's own level alone
    problems = [f"--level: {p}" for p in (*recovery_problems(changed), *analysis_problems(changed))]
    if problems:
        raise SceneError("command line", problems)
    return changed


def _without_recoveries(scene: Scene) -> Scene:
    from solidwhirl.scene_checks.recovery_references import recovers_beams

    left = [a.label for a in scene.analyses if a.kind == "recovery" and recovers_beams(scene, a)]
    if left:
        said = f"--level beam leaves out {', '.join(left)}: beams have no stress to recover"
        typer.secho(f"warning: {said}", fg="yellow", err=True)
    kept = tuple(a for a in scene.analyses if a.label not in left)
    return scene.model_copy(update={"analyses": kept})


def _option_problem(error: Any) -> str:
    """One line; only the level can contradict another key of the scene."""
    if not error["loc"]:
        return f"--level: {str(error['msg']).removeprefix('Value error, ')}"
    return f"--{error['loc'][0]}: {error['msg']}, found {error['input']!r}"


def refuse_unwritable(out: Path) -> None:
    """Find out before the long work, not after, that a folder can not be written.

    Raises OutputError: it, or the folder that it would be made in, is no folder or can't be
    written.
    """
    from solidwhirl.files.run_folder import writing_problem

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
