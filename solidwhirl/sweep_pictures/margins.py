"""Maps of separation margins over two parameters of a sweep."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from solidwhirl.rotordyn.plots.frame import (
    SMALL_PT,
    TEXT_PT,
    TWO_COLUMNS_MM,
    new_figure,
    styled,
    write_figure,
)
from solidwhirl.sweep.analysis import SweepAnalysis, SweepPictureSettings
from solidwhirl.sweep.labels import wrapped
from solidwhirl.sweep.margins import MarginMap
from solidwhirl.sweep_pictures.parts import cases_text, parameter_axis, write_title

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LEVELS = (0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0)
_LIMITS = ((15.0, "dashed"), (20.0, "solid"))
_INSIDE = "#D55E00"
_FRAMES = 3


@styled
def draw_margin_maps(found: SweepAnalysis, settings: SweepPictureSettings, path: Path) -> None:
    """Draw the first three margin maps to a picture file."""
    from matplotlib.colors import BoundaryNorm

    shown = found.maps[:_FRAMES]
    down = 1 if len(shown) < _FRAMES else 2
    figure = new_figure(path, TWO_COLUMNS_MM, 116.0 if down == 1 else 172.0)
    frames = figure.subplots(down, min(2, len(shown)), squeeze=False).ravel()
    for axes in frames[len(shown) :]:
        axes.set_visible(False)
    norm = BoundaryNorm(_LEVELS, 256, extend="max")
    rows: dict[str, Any] = {}
    for axes, one in zip(frames, shown, strict=False):
        drawn = _draw_map(axes, found, one, norm)
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            rows.setdefault(label, handle)
        rows |= {k: v for k, v in _limit_rows(axes, one).items() if k not in rows}
        design = found.design
        parameter_axis(axes, found, settings, design.number(one.x_name), "x")
        parameter_axis(axes, found, settings, design.number(one.y_name), "y")
        heads = [one.title] if len({m.title for m in shown}) > 1 else []
        if one.margin.size and one.least_over:
            heads.append(f"least over all {', '.join(one.least_over)}")
        axes.set_title(wrapped("; ".join(heads), 44), fontsize=TEXT_PT)
    figure.colorbar(drawn, ax=list(frames), label="least separation margin [%]", ticks=_LEVELS,
                    extend="max")  # fmt: skip
    of = ":" if settings.operating_rpm is None else " of"
    title = f"Separation margin{of} {shown[0].title}\n{found.design.scene}, {cases_text(found)}"
    write_title(figure, title)
    notes = list(dict.fromkeys(n for one in shown for n in one.notes))
    if len(found.maps) > _FRAMES:
        notes.append(f"{len(found.maps) - _FRAMES} more maps in sweep.json")
    figure.legend(list(rows.values()), list(rows), loc="outside lower center", ncols=5,
                  frameon=False, fontsize=SMALL_PT, title="\n".join(fill(n, 100) for n in notes),
                  title_fontsize=SMALL_PT)  # fmt: skip
    write_figure(figure, path)


def _draw_map(axes: Axes, found: SweepAnalysis, one: MarginMap, norm: Any) -> Any:
    """Filled contours and the cases; returns what the colour scale is of."""
    from matplotlib.patheffects import withStroke

    design = found.design
    columns = [design.number(n) for n in (one.x_name, one.y_name)]
    x, y = design.values[:, columns].T
    percent = 100.0 * one.case_margin
    if np.isfinite(one.margin).any():
        axes.contourf(one.x, one.y, 100.0 * one.margin, _LEVELS, cmap="cividis", norm=norm,
                      extend="max")  # fmt: skip
        inside = np.where(one.margin == 0.0, 1.0, 0.0)
        if inside.any():
            axes.contourf(one.x, one.y, inside, [0.5, 1.5], colors=[_INSIDE])
    drawn = axes.scatter(x, y, c=percent, cmap="cividis", norm=norm, s=22, edgecolors="black",
                         linewidths=0.6, zorder=3, clip_on=False, label="case",
                         path_effects=[withStroke(linewidth=2.2, foreground="white")])  # fmt: skip
    if len(design.left_out):
        lost_x, lost_y = design.left_out_values[:, columns].T
        axes.scatter(lost_x, lost_y, marker="x", color="black", s=38,
                     linewidths=1.7, zorder=4, clip_on=False,
                     path_effects=[withStroke(linewidth=3.5, foreground="white")],
                     label="case left out")  # fmt: skip
    axes.set_facecolor("#E5E5E5")
    return drawn


def _limit_rows(axes: Axes, one: MarginMap) -> dict[str, Any]:
    """Contours at 15 and 20 % and the hatched range without margin; their rows in a legend."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    rows: dict[str, Any] = {}
    known = one.margin[np.isfinite(one.margin)]
    if not known.size:
        return rows
    for limit, dashes in _LIMITS:
        if known.min() < limit / 100.0 < known.max():
            axes.contour(one.x, one.y, 100.0 * one.margin, [limit], colors="white",
                         linewidths=3.0)  # fmt: skip
            axes.contour(one.x, one.y, 100.0 * one.margin, [limit], colors="black",
                         linestyles=dashes, linewidths=1.5)  # fmt: skip
            rows[f"{limit:.0f} %"] = Line2D([], [], color="black", linestyle=dashes, linewidth=1.5)
    if (known == 0.0).any():
        rows["critical speed inside"] = Patch(facecolor=_INSIDE)
    return rows
