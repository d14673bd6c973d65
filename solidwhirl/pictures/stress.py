"""Views of recovered stress on the deformed solid, cut open along the axis."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill

import numpy as np

from solidwhirl.core.outcome import Write
from solidwhirl.files.cut_fields import StateField, half_of, state_field
from solidwhirl.pictures.stills import (
    COLORS,
    Image,
    add_color_bar,
    cropped,
    image_figure,
    look_at,
    scene_in_space,
)
from solidwhirl.rotordyn.plots import frame

_PIXELS = (2000, 1000)
# Largest displacement as drawn, as a part of the length of the body.
_LARGEST = 0.04


@frame.styled
def draw_stress_still(record: Write, path: Path, title: str) -> None:
    """Draw a recovered state: half of the body, deformed, coloured by its stress."""
    image, found, factor = _image(record)
    text = f"displacement drawn {factor:.3g} times as large" if factor else "not deformed"
    figure = image_figure(image, path, f"{fill(title, 80)}\n{text}", (152.0, 14.0))
    add_color_bar(figure, found.largest, fill(f"{found.label} [{found.unit}]", 32), 0.85)
    frame.write_figure(figure, path)


def _image(record: Write) -> tuple[Image, StateField, float]:
    """The view, what it shows, and the factor of displacement."""
    found = state_field(record)
    half = half_of(found.grid)  # cut while it is straight
    moved = np.asarray(half["moved"])
    length = float(np.ptp(np.asarray(half.points)[:, 2]))
    largest_moved = float(np.linalg.norm(moved, axis=1).max(initial=0.0))
    factor = _LARGEST * length / largest_moved if largest_moved > 0.0 else 0.0
    half.points = np.asarray(half.points) + factor * moved
    with scene_in_space(_PIXELS) as plotter:
        plotter.add_mesh(half, scalars="shown", cmap=COLORS, clim=(0.0, found.largest),
                         show_scalar_bar=False, ambient=0.5, diffuse=0.6)  # fmt: skip
        look_at(plotter, 1.3)
        image = np.asarray(plotter.screenshot(return_img=True), dtype=np.uint8)
    return cropped(image), found, factor
