"""`solidwhirl pictures`: all pictures of a run for a paper or a talk, from the stages it kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from solidwhirl.commands import options
from solidwhirl.console.guard import guarded
from solidwhirl.console.terminal import telling
from solidwhirl.core.errors import OutputError, choice, writing
from solidwhirl.core.errors import unknown as unknown_name
from solidwhirl.core.stages import Progress
from solidwhirl.files import picture_index
from solidwhirl.files.picture_index import Draw, Picture
from solidwhirl.pictures.picture_names import refuse_unknown_names

if TYPE_CHECKING:
    from solidwhirl.pipeline.cached_stages import StageCache
    from solidwhirl.scene.records import Scene

EXAMPLES = options.examples(
    "solidwhirl pictures scenes/laval.toml --out out/laval --only campbell",
    "solidwhirl pictures scenes/laval.toml --out out/laval --formats pdf,svg",
)
FORMATS = picture_index.STILL_FORMATS + picture_index.MOVING_FORMATS
#: Modes shown in space without being asked for more.
MODES = 4


@dataclass(frozen=True, kw_only=True)
class PictureOptions:
    """What `pictures` takes."""

    scene: options.SceneFile
    out: options.Out = None
    formats: Annotated[
        str,
        typer.Option(metavar="LIST", help="Of pdf, svg, png, gif and mp4, with commas between."),
    ] = "png"
    only: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="A picture, or a pattern with *; may be repeated."),
    ] = None
    modes: Annotated[
        int, typer.Option(min=0, metavar="N", help="Modes shown in space at most.")
    ] = MODES
    store: options.Store = None
    level: options.Level = None
    accuracy: options.Accuracy = None
    quiet: options.Quiet = False


@options.taking(PictureOptions)
def pictures(asked: PictureOptions) -> None:
    """Draw the pictures of a run for print, its modes in space, and films of them.

    In the folder of a run nothing of it is computed again. pictures.md lists what was drawn.
    The exit code is 1 if some could not be drawn.
    """

    def work() -> None:
        scene = options.chosen_scene(asked.scene, asked.level, asked.accuracy)
        out = options.out_folder(asked.out, asked.scene)
        options.refuse_unwritable(out)
        with telling(asked.quiet) as progress:
            done = pictures_command(
                scene,
                out,
                progress,
                formats=asked.formats,
                only=asked.only or (),
                modes=asked.modes,
                store=asked.store,
            )
        if not asked.quiet:
            typer.echo(f"{len(done.files)} pictures, listed in {done.index}")
        for name, why in done.failed:
            typer.echo(f"not drawn: {name}: {why}", err=True)
        if done.failed:
            raise typer.Exit(1)

    guarded(asked.scene, work)


@dataclass(frozen=True, kw_only=True)
class DrawnPictures:
    """Picture files in the order of the catalogue, their page, and what failed, with the reason."""

    files: tuple[Path, ...]
    index: Path
    failed: tuple[tuple[str, str], ...]


def pictures_command(
    scene: Scene,
    out: Path,
    progress: Progress,
    *,
    formats: str = "png",
    only: Sequence[str] = (),
    modes: int = MODES,
    store: Path | None = None,
) -> DrawnPictures:
    """Draw the pictures of a scene's run; what can not be drawn does not stop the others.

    Raises OutputError: an unknown format or name, a film that is asked for alone without a format
    for it, or a folder that can't be written.
    """
    from solidwhirl.files.run_folder import STAGES, claimed
    from solidwhirl.output.picture_processes import in_processes
    from solidwhirl.pictures.catalogue import pictures_of
    from solidwhirl.pipeline.cached_stages import StageCache, engine_part, open_store
    from solidwhirl.pipeline.run import run_scene

    kinds = chosen_formats(formats)
    refuse_unknown_names(scene, only, modes)
    _refuse_films_alone(only, kinds)
    with claimed(out) as folder:
        kept = open_store(store or folder / STAGES)
        results = run_scene(scene, progress=progress, store=kept)
        assert results is not None
        pictures = pictures_of(results, modes, progress)
        chosen = chosen_pictures(pictures, only)
        stage_cache = StageCache(store=kept, progress=progress)
        content = (engine_part(scene), scene.analyses, scene.name, scene.title)
        entries: dict[str, list[Path]] = {}
        failed: list[tuple[str, str]] = []
        kept_ones = [_kept(picture, stage_cache, content) for picture in chosen]
        with in_processes(_stills(kept_ones, folder, kinds)) as begun:
            for picture in kept_ones:
                if drawn := _draw(picture, folder, kinds, begun, progress, failed):
                    entries[picture.name] = drawn
        files = tuple(path for drawn in entries.values() for path in drawn)
        if not files and not failed:
            raise _no_format(kinds, [p.name for p in chosen])
        index = folder / picture_index.INDEX
        picture_index.write_index(index, scene.title or scene.name, pictures, entries)
    return DrawnPictures(files=files, index=index, failed=tuple(failed))


def chosen_formats(text: str) -> tuple[str, ...]:
    """Return the formats of a text such as "pdf,svg".

    Raises OutputError: an unknown format, or none.
    """
    asked = tuple(dict.fromkeys(part.strip().lower() for part in text.split(",") if part.strip()))
    unknown = [part for part in asked if part not in FORMATS]
    if unknown or not asked:
        what = f"unknown {unknown[0]!r}" if unknown else "no format"
        raise OutputError(f"--formats: {what}; {choice((unknown or [''])[0], FORMATS)}")
    return asked


def chosen_pictures(pictures: Sequence[Picture], only: Sequence[str]) -> tuple[Picture, ...]:
    """Return the pictures whose names fit one of some patterns; all of them without patterns.

    Raises OutputError: a pattern fits none; the message lists the names.
    """
    for pattern in only:
        if not any(fnmatchcase(p.name, pattern) for p in pictures):
            known = [p.name for p in pictures]
            raise OutputError(f"--only: {unknown_name('picture', pattern, known)}")
    return tuple(p for p in pictures if not only or any(fnmatchcase(p.name, o) for o in only))


def _refuse_films_alone(only: Sequence[str], kinds: Sequence[str]) -> None:
    """Refuse names of films without a format for one, before anything is computed."""
    films = [name for name in only if name.startswith("mode_") and name.endswith("_film")]
    if only and len(films) == len(only) and not {*kinds} & {*picture_index.MOVING_FORMATS}:
        raise _no_format(kinds, films)


def _no_format(kinds: Sequence[str], names: Sequence[str]) -> OutputError:
    return OutputError(f"--formats: none of {', '.join(kinds)} is a format of {', '.join(names)}")


def _kept(picture: Picture, stage_cache: StageCache, content: Any) -> Picture:
    """The picture, taken from the store where it was drawn before."""
    if picture.name == "cost":  # of this run
        return picture
    key = stage_cache.key("picture of a run", content, picture.name)
    return replace(picture, draw=stage_cache.picture(key, picture.draw))


def _files(picture: Picture, folder: Path, kinds: Sequence[str]) -> list[Path]:
    """The files of one picture in all its formats that are asked for."""
    return [folder / f"{picture.name}.{kind}" for kind in kinds if kind in picture.formats]


def _stills(pictures: Sequence[Picture], folder: Path, kinds: Sequence[str]) -> dict[Path, Draw]:
    """What draws the files of pictures that do not move; films tell how far they are."""
    return {
        path: picture.draw
        for picture in pictures
        if picture.kind != "film"
        for path in _files(picture, folder, kinds)
    }


def _draw(
    picture: Picture,
    folder: Path,
    kinds: Sequence[str],
    begun: Mapping[Path, Draw],
    progress: Progress,
    failed: list[tuple[str, str]],
) -> list[Path]:
    """Draw one picture in all its formats that are asked for, or wait for those begun."""
    drawn = []
    for path in _files(picture, folder, kinds):
        progress(f"draw {path.name}")
        try:
            with writing(path):
                path.parent.mkdir(parents=True, exist_ok=True)
                begun.get(path, picture.draw)(path)
        except (ValueError, ImportError) as error:
            failed.append((path.name, str(error)))
            progress(f"{path.name} is not drawn: {error}")
        else:
            drawn.append(path)
    return drawn
