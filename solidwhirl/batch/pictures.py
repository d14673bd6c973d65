"""Pictures of a batch in its folder: drawn when it ends, and again without computing."""

from __future__ import annotations

import sys
from pathlib import Path

import typer
from rich.console import Console

from solidwhirl.batch.table import read_batch
from solidwhirl.core.errors import SceneError, clean, writing
from solidwhirl.sweep.analysis import SweepPictureSettings
from solidwhirl.sweep.design import SweepPictureError
from solidwhirl.sweep_pictures.all import draw_batch, drawn_before

#: Folder of the pictures in the folder of a batch.
PICTURES = "pictures"


def picture_settings(operating_rpm: tuple[float, float] | None) -> SweepPictureSettings:
    """Return the settings of the command line.

    `operating_rpm`: lowest and highest operating speed of the reference shaft; None: not said.
    Raises SceneError: they are no range.
    """
    try:
        return SweepPictureSettings(operating_rpm=operating_rpm)
    except SweepPictureError as error:
        raise SceneError("command line", [f"--operating-rpm: {error}"]) from error


def redraw(out: Path, operating_rpm: tuple[float, float] | None = None) -> tuple[Path, ...]:
    """Draw the pictures of a batch from its rows; nothing is computed.

    `out`: folder of the batch. What was drawn before and no longer applies is removed.
    Returns the files, in `pictures` of the folder; none if no scene has a sweep of two cases that
    are done.
    Raises BatchTableError: the folder holds no batch, or a damaged one; SceneError: the speeds are
    no range, or the rows make no picture; OutputError: a picture can't be written.
    """
    settings = picture_settings(operating_rpm)
    rows = read_batch(out)
    folder = out / PICTURES
    old = drawn_before(folder)
    try:
        with writing(folder):
            files = draw_batch(rows, folder, settings=settings)
            for path in set(old) - set(files):
                path.unlink(missing_ok=True)
    except SweepPictureError as error:
        raise SceneError(out, [str(error)]) from error
    return files


def draw_at_end(
    out: Path, operating_rpm: tuple[float, float] | None, console: Console
) -> tuple[Path, ...]:
    """Draw the pictures of a batch that has ended; what fails here is said, its table stays.

    Returns the files; none where drawing failed.
    """
    try:
        files = redraw(out, operating_rpm)
    except Exception as error:  # pictures can be drawn again, cases would be computed again
        said = f"no pictures: {type(error).__name__}: {clean(str(error))}"
        sys.stderr.write(f"warning: {out}: {said}\n")
        return ()
    if files and not console.quiet:
        typer.echo(f"{len(files)} files of pictures: {out / PICTURES}")
    return files
