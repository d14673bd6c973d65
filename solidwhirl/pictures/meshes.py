"""Meshes of meridians, as lines."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill

import numpy as np

from solidwhirl.meshing import Mesh
from solidwhirl.rotordyn.plots.frame import (
    COLORS,
    SMALL_PT,
    TITLE_PT,
    TWO_COLUMNS_MM,
    new_figure,
    styled,
    write_figure,
)

# Triangles above this number are an image in the file, not lines.
_MOST_LINES = 20_000
_FRAME_MM, _LOWEST_MM, _HIGHEST_MM = 160.0, 12.0, 150.0


@styled
def draw_meridian_mesh(mesh: Mesh, degree: int, path: Path, title: str) -> None:
    """Draw the triangles of a meridian to scale, coloured by material."""
    from matplotlib.collections import PolyCollection
    from matplotlib.patches import Patch

    points = 1e3 * np.asarray(mesh.points)
    length, height = np.ptp(points, axis=0)
    drawn = float(np.clip(height / length * _FRAME_MM, _LOWEST_MM, _HIGHEST_MM))
    figure = new_figure(path, TWO_COLUMNS_MM, drawn + 28.0)
    axes = figure.add_subplot()
    corners = points[mesh.cells[:, :3]]
    rows = []
    for k, material in enumerate(mesh.materials):
        own = corners[mesh.cell_material == k]
        color = COLORS[k % len(COLORS)]
        axes.add_collection(
            PolyCollection(list(own), facecolor=color + "30", edgecolor=color, linewidth=0.25,
                           rasterized=len(corners) > _MOST_LINES)
        )  # fmt: skip
        rows.append(Patch(facecolor=color + "30", edgecolor=color,
                          label=f"{material.name}, {len(own)} elements"))  # fmt: skip
    axes.set_aspect("equal")
    axes.margins(0.02)
    axes.set_xlabel("axial position [mm]")
    axes.set_ylabel("radius [mm]")
    axes.locator_params(axis="y", nbins=5)
    axes.spines[["top", "right"]].set_visible(False)
    figure.suptitle(fill(title, 80), fontsize=TITLE_PT)
    rows.append(Patch(facecolor="none", edgecolor="none", label=f"order of elements {degree}"))
    figure.legend(handles=rows, loc="outside lower center", ncols=4, frameon=False,
                  fontsize=SMALL_PT)  # fmt: skip
    write_figure(figure, path)
