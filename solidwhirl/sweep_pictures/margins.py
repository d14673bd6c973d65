"""Maps of separation margins over two parameters of a sweep."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from solidwhirl.core.key_units import wrapped
from solidwhirl.rotordyn.plots import frame
from solidwhirl.rotordyn.plots.matplotlib_chart import set_axis
from solidwhirl.sweep.analysis import SweepAnalysis, SweepPictureSettings
from solidwhirl.sweep.margins import MarginMap
from solidwhirl.sweep_pictures.parts import cases_text, parameter_axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LEVELS = (0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0)
_LIMITS = ((15.0, "dashed"), (20.0, "solid"))
_INSIDE = "#D55E00"
_FRAMES = 3


@frame.styled
def draw_margin_maps(found: SweepAnalysis, settings: SweepPictureSettings, path: Path) -> None:
    """Draw the first three margin maps to a picture file."""
    from matplotlib.colors import BoundaryNorm

    shown = found.maps[:_FRAMES]
    down = 1 if len(shown) < _FRAMES else 2
    figure = frame.new_figure(path, frame.TWO_COLUMNS_MM, 116.0 if down == 1 else 172.0)
    frames = figure.subplots(down, min(2, len(shown)), squeeze=False).ravel()
    for axes in frames[len(shown) :]:
        axes.set_visible(False)
    norm = BoundaryNorm(_LEVELS, 256, extend="max")
    rows: dict[str, Any] = {}
    for axes, one in zip(frames, shown, strict=False):
        drawn = _draw_map(axes, found, settings, one, norm, rows)
        heads = [one.title] if len({m.title for m in shown}) > 1 else []
        if one.margin.size and one.least_over:
            heads.append(f"least over all {', '.join(one.least_over)}")
        axes.set_title(wrapped("; ".join(heads), 44), fontsize=frame.TEXT_PT)
    figure.colorbar(drawn, ax=list(frames), label="least separation margin [%]", ticks=_LEVELS,
                    extend="max")  # fmt: skip
    of = ":" if settings.operating_rpm is None else " of"
    title = f"Separation margin{of} {shown[0].title}\n{found.design.scene}, {cases_text(found)}"
    lines = [fill(line, 80) for line in title.split("\n")]
    figure.suptitle("\n".join(lines), fontsize=frame.TITLE_PT)
    notes = list(dict.fromkeys(n for one in shown for n in one.notes))
    if len(found.maps) > _FRAMES:
        notes.append(f"{len(found.maps) - _FRAMES} more maps in sweep.json")
    figure.legend(list(rows.values()), list(rows), loc="outside lower center", ncols=5,
                  frameon=False, fontsize=frame.SMALL_PT,
                  title="\n".join(fill(n, 100) for n in notes),
                  title_fontsize=frame.SMALL_PT)  # fmt: skip
    frame.write_figure(figure, path)


def _draw_map(
    axes: Axes,
    found: SweepAnalysis,
    settings: SweepPictureSettings,
    one: MarginMap,
    norm: Any,
    rows: dict[str, Any],
) -> Any:
    """Filled contours, those at 15 and 20 %, and the cases; returns what the colour scale is of.

    `rows` are those of the legend by their text.
    """
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch
    from matplotlib.patheffects import withStroke

    design, percent = found.design, 100.0 * one.margin
    columns = [design.number(n) for n in (one.x_name, one.y_name)]
    scales = []
    for column, which, values in zip(columns, ("x", "y"), (one.x, one.y), strict=True):
        axis, scale = parameter_axis(found, settings, column)
        scales.append(scale)
        axis = replace(axis, low=values.min() / scale, high=values.max() / scale)
        if axis.is_log:
            axes.set(**{f"{which}scale": "log"})
        set_axis(axes, axis, which)
    places = one.x / scales[0], one.y / scales[1]
    if np.isfinite(percent).any():
        axes.contourf(*places, percent, _LEVELS, cmap="cividis", norm=norm, extend="max")
    if (percent == 0.0).any():
        axes.contourf(*places, np.where(percent == 0.0, 1.0, 0.0), [0.5, 1.5], colors=[_INSIDE])
        rows["critical speed inside"] = Patch(facecolor=_INSIDE)
    for limit, dashes in _LIMITS:
        if np.nanmin(percent, initial=np.inf) < limit < np.nanmax(percent, initial=-np.inf):
            line = {"linestyles": dashes, "linewidths": 1.5}
            axes.contour(*places, percent, [limit], colors="white", linewidths=3.0)
            axes.contour(*places, percent, [limit], colors="black", **line)
            rows[f"{limit:.0f} %"] = Line2D([], [], color="black", linestyle=dashes, linewidth=1.5)
    halo = [withStroke(linewidth=2.4, foreground="white")]
    x, y = (design.values[:, columns] / scales).T
    drawn = axes.scatter(
        x, y, c=100.0 * one.case_margin, cmap="cividis", norm=norm, s=22, edgecolors="black",
        linewidths=0.6, zorder=3, clip_on=False, path_effects=halo,
    )  # fmt: skip
    rows["case"] = drawn
    if design.left_out:
        x, y = (design.left_out_values[:, columns] / scales).T
        rows["case left out"] = axes.scatter(
            x, y, marker="x", color="black", s=38, linewidths=1.7, zorder=4, clip_on=False,
            path_effects=halo,
        )  # fmt: skip
    axes.set_facecolor("#E5E5E5")
    return drawn
