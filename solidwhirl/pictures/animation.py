"""A mode as a film: the bodies whirl, points go round on their orbits."""

from __future__ import annotations

import importlib
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.core.errors import OutputError
from solidwhirl.pictures.engine_shape import EngineShape
from solidwhirl.pictures.stills import Image, frame_of, inked_part, scene_in_space, view
from solidwhirl.rotordyn.core.atomic import replacing
from solidwhirl.rotordyn.plots.frame import styled

# Frames of one period and per second, pixels of the view, dots per inch of what is around it.
_FRAMES, _RATE_HZ = 24, 12
_PIXELS, _DPI, _ZOOM = (1000, 560), 130, 1.15
# Widths and heights that every player takes.
_BLOCK = 16


def mode_frames(
    shape: EngineShape, title: str, told: Callable[[int, int], None] = lambda frame, frames: None
) -> list[Image]:
    """Return the images of one period of a mode, each (h, w, 3)."""
    views: list[Image] = []
    with scene_in_space(_PIXELS, "msaa") as plotter:
        for k in range(_FRAMES):
            # what has the name of something shown takes its place
            phase = 2.0 * np.pi * k / _FRAMES
            views.append(view(plotter, shape, phase, None if k else _ZOOM))
            told(k + 1, _FRAMES)
    part = inked_part(np.min(views, axis=0))
    return _framed([v[part] for v in views], shape, title)


@styled
def _framed(views: list[Image], shape: EngineShape, title: str) -> list[Image]:
    """Each view with title, bar and legend around it; these are drawn once."""
    import PIL.Image

    figure = frame_of(views[0], Path("film.png"), title, shape)
    figure.set_dpi(_DPI)
    canvas: Any = figure.canvas
    canvas.draw()
    around = np.array(canvas.buffer_rgba())[:, :, :3]
    (shown,) = figure.axes[0].images
    box = shown.get_window_extent()
    left, bottom, right, top = (round(v) for v in (box.x0, box.y0, box.x1, box.y1))
    frames = []
    for image in views:
        # only the view changes: the rest is drawn once
        size = (right - left, top - bottom)
        own = np.asarray(PIL.Image.fromarray(image).resize(size, PIL.Image.Resampling.LANCZOS))
        whole = around.copy()
        whole[len(whole) - top : len(whole) - bottom, left:right] = own
        frames.append(_even(whole))
    return frames


def _even(image: Any) -> Image:
    """The image with white at its right and lower edge, up to sizes that players take."""
    height, width = image.shape[:2]
    rows, columns = -height % _BLOCK, -width % _BLOCK
    padded = np.pad(image, ((0, rows), (0, columns), (0, 0)), constant_values=255)
    return np.ascontiguousarray(padded, dtype=np.uint8)


def write_film(frames: list[Image], path: Path) -> None:
    """Write frames that repeat, as GIF or MP4 by the ending of the file.

    Raises OutputError: another ending, or MP4 where the package imageio-ffmpeg is not installed.
    """
    import imageio.v2 as imageio

    kind = path.suffix.lower().lstrip(".")
    if kind not in ("gif", "mp4"):
        raise OutputError(f"{path}: a film is gif or mp4, found {path.suffix!r}")
    if kind == "mp4":
        try:
            importlib.import_module("imageio_ffmpeg")
        except ImportError as error:
            raise OutputError(
                f"{path}: mp4 needs the package imageio-ffmpeg; install it, or choose gif"
            ) from error
    # the writers choose by the ending of the name, which a temporary file does not have
    with replacing(path) as temporary, tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"film.{kind}"
        if kind == "gif":
            imageio.mimwrite(file, frames, duration=1000.0 / _RATE_HZ, loop=0)
        else:
            # three turns, so that players that do not repeat show something
            imageio.mimwrite(
                file, frames * 3, fps=_RATE_HZ, codec="libx264", macro_block_size=_BLOCK
            )
        shutil.copyfile(file, temporary)
