"""Views of recovered stress on the deformed solid, cut open along the axis."""

from __future__ import annotations

import tempfile
from pathlib import Path
from textwrap import fill

import numpy as np

from solidwhirl.core.outcome import Write
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
# What is shown, the first of these that the file has, with its name.
_FIELDS = (
    ("von_mises_total", "largest von Mises stress\nover the cycle [MPa]"),
    ("von_mises_dynamic", "largest dynamic von Mises\nstress over the cycle [MPa]"),
    ("von_mises_steady", "von Mises stress of the\ncentrifugal load [MPa]"),
)


@frame.styled
def draw_stress_still(record: Write, path: Path, title: str) -> None:
    """Draw a recovered state: half of the body, deformed, coloured by its stress."""
    image, label, largest, factor = _image(record)
    text = f"displacement drawn {factor:.3g} times as large" if factor else "not deformed"
    figure = image_figure(image, path, f"{fill(title, 80)}\n{text}", (152.0, 14.0))
    add_color_bar(figure, largest, label, 0.85)
    frame.write_figure(figure, path)


def _image(record: Write) -> tuple[Image, str, float, float]:
    """The view, the name and the largest value of its colours, and the factor of displacement."""
    import pyvista

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "state.vtu"
        record(file)
        grid = pyvista.read(file)
    field, label = next((f for f in _FIELDS if f[0] in grid.point_data), ("", ""))
    vibrates = "displacement_0deg" in grid.point_data
    motion = "displacement_0deg" if vibrates else "displacement"
    moved = grid[motion]
    if not field:
        label = "displacement [mm]"
    values = 1e-6 * grid[field] if field else 1e3 * np.linalg.norm(moved, axis=1)
    grid["shown"] = np.asarray(values, dtype=float)
    length = float(np.ptp(np.asarray(grid.points)[:, 2]))
    largest_moved = float(np.linalg.norm(moved, axis=1).max(initial=0.0))
    factor = _LARGEST * length / largest_moved if largest_moved > 0.0 else 0.0
    # cut while it is straight: the half behind the axis as the eye sees it
    half = grid.clip(normal=(-1.0, 0.0, 0.0), origin=(0.0, 0.0, 0.0))
    half.points = np.asarray(half.points) + factor * np.asarray(half[motion], dtype=float)
    largest = float(np.nanmax(grid["shown"])) or 1.0
    with scene_in_space(_PIXELS) as plotter:
        plotter.add_mesh(half, scalars="shown", cmap=COLORS, clim=(0.0, largest),
                         show_scalar_bar=False, ambient=0.5, diffuse=0.6)  # fmt: skip
        look_at(plotter, 1.3)
        image = np.asarray(plotter.screenshot(return_img=True), dtype=np.uint8)
    return cropped(image), label, largest, factor
