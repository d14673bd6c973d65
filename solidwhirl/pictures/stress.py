"""Views of recovered stress on the deformed solid, cut open along the axis."""

from __future__ import annotations

import tempfile
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np

from solidwhirl.core.outcome import Write
from solidwhirl.pictures.stills import Image, cropped, look_at, scene_in_space
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
_COLORS = "cividis"


@frame.styled
def draw_stress_still(record: Write, path: Path, title: str) -> None:
    """Draw a recovered state: half of the body, deformed, coloured by its stress."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    image, label, largest, factor = _image(record)
    height, width = image.shape[:2]
    figure = frame.new_figure(path, frame.TWO_COLUMNS_MM, 152.0 * height / width + 14.0)
    axes = figure.add_subplot()
    axes.imshow(image, interpolation="antialiased")
    axes.set_axis_off()
    text = f"displacement drawn {factor:.3g} times as large" if factor else "not deformed"
    figure.suptitle(f"{fill(title, 80)}\n{text}", fontsize=frame.TITLE_PT)
    bar = figure.colorbar(
        ScalarMappable(Normalize(0.0, largest), _COLORS), ax=axes, shrink=0.85, pad=0.01, aspect=28
    )
    bar.set_label(label)
    frame.write_figure(figure, path)


def _image(record: Write) -> tuple[Image, str, float, float]:
    """The view, the name and the largest value of its colours, and the factor of displacement."""
    import pyvista

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "state.vtu"
        record(file)
        grid = pyvista.read(file)
    field, label = next((f for f in _FIELDS if f[0] in grid.point_data), ("", ""))
    moved = next(grid[n] for n in ("displacement_0deg", "displacement") if n in grid.point_data)
    if not field:
        field, label = "size", "displacement [mm]"
        grid[field] = 1e9 * np.linalg.norm(moved, axis=1)  # in MPa's factor below: mm
    grid["shown"] = 1e-6 * np.asarray(grid[field], dtype=float)
    length = float(np.ptp(np.asarray(grid.points)[:, 2]))
    largest_moved = float(np.linalg.norm(moved, axis=1).max(initial=0.0))
    factor = _LARGEST * length / largest_moved if largest_moved > 0.0 else 0.0
    # cut while it is straight: the half behind the axis as the eye sees it
    half = grid.clip(normal=(-1.0, 0.0, 0.0), origin=(0.0, 0.0, 0.0))
    half.points = np.asarray(half.points) + factor * _vectors(half)
    largest = float(np.nanmax(grid["shown"])) or 1.0
    with scene_in_space(_PIXELS) as plotter:
        plotter.add_mesh(half, scalars="shown", cmap=_COLORS, clim=(0.0, largest),
                         show_scalar_bar=False, ambient=0.5, diffuse=0.6)  # fmt: skip
        look_at(plotter, 1.3)
        image = np.asarray(plotter.screenshot(return_img=True), dtype=np.uint8)
    return cropped(image), label, largest, factor


def _vectors(grid: Any) -> Any:
    name = "displacement_0deg" if "displacement_0deg" in grid.point_data else "displacement"
    return np.asarray(grid[name], dtype=float)
