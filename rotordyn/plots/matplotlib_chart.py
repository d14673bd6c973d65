"""Charts drawn on paper with matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.plots.chart import (
    Axis,
    Bars,
    Chart,
    Choice,
    Curve,
    Fill,
    Heat,
    Label,
    Look,
    Option,
    Part,
    Ridges,
    Rule,
    Span,
    Toggle,
)
from solidwhirl.rotordyn.plots.frame import (
    DASHES_OF,
    ONE_COLUMN_MM,
    SMALL_PT,
    TEXT_PT,
    TITLE_PT,
    TWO_COLUMNS_MM,
    USUAL_HEIGHT_MM,
    add_legend,
    color_of,
    draw_grid,
    name_speeds,
    new_figure,
    style_of,
    styled,
    write_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Points of paper for a pixel of a screen: widths of lines, sizes of marks.
_WIDTH_PT, _SIZE_PT = 0.75, 0.58
# Colours of a map below this part of the largest are the same.
_DARKEST = 1e-4
# Marks along a curve, and frames side by side.
_MARKED, _COLUMNS = 10, 3
# Height of a page for many frames.
_PAGE_MM = 240.0
# Numbers nearer than this fraction of the axis would cover each other, and how many have room.
_LABEL_WIDTH, _MOST_LABELS = 0.02, 12
_HATCHES = ("", "///", "xxx", "...", "\\\\\\", "+++", "---")


@styled
def draw_charts(charts: Sequence[Chart], path: str | Path, title: str) -> None:
    """Draw charts to a picture file, one below the other.

    Parameters
    ----------
    charts
        One or more. Options of a choice that is drawn whole stand side by side.
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf). Replaced when complete.
    title
        Above the picture.

    Raises
    ------
    AnalysisError
        If there is nothing to draw, or the suffix is not a kind of picture that can be written.
    """
    rows = [_frames_of(chart) for chart in charts]
    if not rows or not all(rows):
        raise AnalysisError("there is nothing to draw")
    if len(rows) == 1 and len(rows[0]) > 1:
        across = min(_COLUMNS if charts[0].is_to_scale else 2, len(rows[0]))
        rows = [rows[0][k : k + across] for k in range(0, len(rows[0]), across)]
    single = len(charts) == 1
    same_x = not single and len({chart.x.unit for chart in charts}) == 1
    columns = max(len(row) for row in rows)
    figure = _new_figure(path, rows, columns)
    heights = [row[0][0].height_px for row in rows]
    grid = figure.subplots(
        len(rows), columns, squeeze=False, height_ratios=heights,
        sharex="col" if same_x else False,
    )  # fmt: skip
    for number, (row, own) in enumerate(zip(rows, grid, strict=True)):
        for axes in own[len(row) :]:
            axes.set_axis_off()
            axes.set_visible(False)
        for (chart, name), axes in zip(row, own, strict=False):
            _draw(figure, axes, chart)
            axes.set_title(name.replace(", ", ",\n", 1), fontsize=TEXT_PT)
            if same_x and number + 1 < len(rows):
                axes.set_xlabel("")
    _entitle(figure, grid, fill(title, 60))
    figure.align_ylabels()
    notes = [note for chart in charts for note in chart.notes]
    if any(chart.has_legend for chart in charts):
        below = single and (columns > 1 or bool(charts[0].marks(Heat)))
        place = "outside lower center" if below else "outside right upper"
        add_legend(figure, list(grid.flat), "\n".join(notes), place, 3 if below else 1)
    write_figure(figure, path)


Frame = tuple[Chart, str]


def _frames_of(chart: Chart) -> list[Frame]:
    """A chart with what paper shows of its choices: one frame for each option drawn there."""
    whole = next((p for p in chart.parts if isinstance(p, Choice) and p.on_paper == "each"), None)
    options: Sequence[Option | None] = whole.options if whole else (None,)
    frames = []
    for option in options:
        parts: list[Part] = []
        x, y = chart.x, chart.y
        for part in chart.parts:
            if isinstance(part, Toggle):
                parts += part.marks
            elif isinstance(part, Choice):
                chosen = option if part is whole and option else part.options[0]
                parts += chosen.marks
                x, y = chosen.x or x, chosen.y or y
            else:
                parts.append(part)
        name = option.label if option is not None and len(options) > 1 else ""
        frames.append((replace(chart, parts=parts, x=x, y=y), name))
    return frames


def _new_figure(path: str | Path, rows: Sequence[Sequence[Frame]], columns: int) -> Figure:
    """A figure whose height follows those of its frames."""
    if rows[0][0][0].is_to_scale:
        width = ONE_COLUMN_MM if columns == 1 else TWO_COLUMNS_MM
        return new_figure(path, width, 30.0 + len(rows) * (14.0 + 0.9 * width / columns))
    first = rows[0][0][0]
    height = USUAL_HEIGHT_MM
    if first.y.places:
        height = (34.0 + 6.0 * len(first.y.places)) * len(rows) - 45.0 * (len(rows) - 1)
    height = min(height + 45.0 * (len(rows) - 1), max(height, _PAGE_MM))
    return new_figure(path, TWO_COLUMNS_MM, height)


def _entitle(figure: Figure, grid: Any, title: str) -> None:
    """Put the title above the frame, or above all of several side by side."""
    if grid.shape[1] > 1:
        figure.suptitle(title, fontsize=TITLE_PT)
    else:  # room for names of lines that leave at the top
        own = grid[0, 0].get_title()
        grid[0, 0].set_title(f"{title}\n{own}" if own else title, pad=20.0, fontsize=TITLE_PT)


def _draw(figure: Figure, axes: Axes, chart: Chart) -> None:
    _set_scale(axes, chart.x, chart.y)
    drawing = _Drawing(figure, axes, chart)
    for order, part in enumerate(chart.parts):
        drawing.add(part, 2.0 + 1e-3 * order)
    _set_axis(axes, chart.x, "x")
    _set_axis(axes, chart.y, "y")
    _number(axes, [part for part in chart.parts if isinstance(part, Curve) and part.is_numbered])
    if chart.is_to_scale:
        axes.set_aspect("equal")
        axes.locator_params(nbins=3, steps=[1, 2, 5, 10])
    if not chart.marks(Heat):
        draw_grid(axes, "both" if chart.x.is_log else "major")


def _set_scale(axes: Axes, x: Axis, y: Axis) -> None:
    if x.is_log:
        axes.set_xscale("log")
    if y.is_log:
        axes.set_yscale("log")


def _set_axis(axes: Axes, axis: Axis, which: str) -> None:
    """Set the ends, the numbers and the label of an axis."""
    own = axes.xaxis if which == "x" else axes.yaxis
    if axis.low is not None and axis.high is not None:
        (axes.set_xlim if which == "x" else axes.set_ylim)(axis.low, axis.high)
    if axis.places:
        names = [p.replace(", ", "\n") if which == "x" else p for p in axis.places]
        own.set_ticks(range(len(names)), names, fontsize=SMALL_PT)
    elif axis.step:
        from matplotlib.ticker import MultipleLocator

        own.set_major_locator(MultipleLocator(axis.step))
    elif axis.unit == "rpm":
        name_speeds(own)
    own.set_label_text(fill(axis.title, 60 if which == "x" else 40))


class _Drawing:
    """One frame while it is drawn."""

    def __init__(self, figure: Figure, axes: Axes, chart: Chart) -> None:
        self.figure, self.axes, self.chart = figure, axes, chart
        self.right: Axes | None = None

    def add(self, mark: Any, order: float) -> None:
        """Draw a mark; later ones cover earlier ones."""
        axes = self.axes
        if isinstance(mark, Curve):
            _draw_curve(self._right() if mark.on_right else axes, mark, order)
        elif isinstance(mark, Fill):
            color, opacity = color_of(mark.look)
            axes.fill_between(mark.x, mark.low, mark.high, color=color, alpha=0.8 * opacity,
                              linewidth=0.3, label=mark.name or None, zorder=order)  # fmt: skip
        elif isinstance(mark, Span):
            _draw_span(axes, mark)
        elif isinstance(mark, Rule):
            _draw_rule(axes, mark)
        elif isinstance(mark, Label):
            _draw_label(axes, mark)
        elif isinstance(mark, Heat):
            _draw_heat(self.figure, axes, mark, self.chart.y)
        elif isinstance(mark, Ridges):
            _draw_ridges(axes, mark)
        elif isinstance(mark, Bars):
            self._add_bars(mark)

    def _right(self) -> Axes:
        assert self.chart.right is not None
        if self.right is None:
            self.right = self.axes.twinx()
            _set_axis(self.right, self.chart.right, "y")
        return self.right

    def _add_bars(self, bars: Bars) -> None:
        """Draw bars beside or upon those of the other kinds."""
        every = [part for part in self.chart.parts if isinstance(part, Bars)]
        number, at = every.index(bars), np.arange(float(len(bars.values)))
        width = 0.7 if self.chart.is_stacked else 0.8 / len(every)
        bottom = 0.0 * bars.values
        if self.chart.is_stacked:
            sign = np.where(bars.values < 0.0, -1.0, 1.0)
            for other in every[:number]:
                bottom += np.where(sign * other.values > 0.0, other.values, 0.0)
        else:
            at = at + width * (number - 0.5 * (len(every) - 1))
        color, _ = color_of(bars.look)
        self.axes.bar(at, bars.values, width, bottom=bottom, color=color, label=bars.name,
                      edgecolor="white", hatch=_HATCHES[number % len(_HATCHES)])  # fmt: skip


def _draw_ridges(axes: Axes, ridges: Ridges) -> None:
    """Draw lines above their places, the first in front."""
    color, count = color_of(Look("@c0"))[0], ridges.y.size
    for k, (at, height) in reversed(list(enumerate(zip(ridges.y, ridges.values, strict=True)))):
        line, order = at + ridges.rise * height, 1.0 + (count - k) / count
        axes.fill_between(ridges.x, at, line, color="white", linewidth=0, zorder=order)
        axes.plot(ridges.x, line, color=color, linewidth=0.7, zorder=order)


def _draw_curve(axes: Axes, curve: Curve, order: float) -> None:
    """Draw a line with some of its marks, or all marks where there is no line."""
    look, style = curve.look, style_of(curve.look)
    color, opacity = color_of(look)
    apart = max(1, curve.x.size // _MARKED)
    line = axes.plot(
        curve.x,
        curve.y,
        color=color,
        alpha=opacity,
        linestyle=style.dashes,
        linewidth=_WIDTH_PT * look.width,
        marker=style.marker,
        markersize=_SIZE_PT * look.size,
        markerfacecolor=("none" if not look.dash else "white") if style.is_open else color,
        markevery=apart if look.dash else 1,
        label=curve.name or None,
        zorder=order,
    )[0]
    if look.color.startswith("#ff"):  # seen on dark and on bright colours, and on paper
        from matplotlib.patheffects import withStroke

        line.set_path_effects([withStroke(linewidth=2.4, foreground="black")])
    if curve.errors is not None:
        axes.errorbar(curve.x, curve.y, xerr=curve.errors, fmt="none", ecolor=color, capsize=3.0)


def _number(axes: Axes, curves: Sequence[Curve]) -> None:
    """Write places along x upright, of the highest points; one where several are near."""
    points = [xy for c in curves for xy in zip(c.x.tolist(), c.y.tolist(), strict=True)]
    width = _LABEL_WIDTH * float(np.ptp(axes.get_xlim()))
    written: list[float] = []
    for place, height in sorted(points, key=lambda point: -point[1]):
        near = any(abs(place - other) < width for other in written)
        if near or len(written) == _MOST_LABELS:
            continue
        written.append(place)
        axes.annotate(
            f"{place:.0f}", (place, height), xytext=(0, 5), textcoords="offset points",
            ha="center", va="bottom", rotation=90, fontsize=SMALL_PT,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.4},
        )  # fmt: skip
    if written and axes.get_yscale() == "log":  # room above
        low, high = axes.get_ylim()
        axes.set_ylim(low, high * (high / low) ** 0.15)


def _draw_span(axes: Axes, span: Span) -> None:
    along_x = span.along == "x"
    if span.low == span.high:
        draw = axes.axvline if along_x else axes.axhline
        draw(span.low, color="#8A8A8A", linewidth=2.4, zorder=0.4, label=span.name or None)
        return
    color, _ = color_of(span.look)
    look: dict[str, Any] = {"facecolor": color, "alpha": 0.2}
    if span.is_hatched:
        look = {"facecolor": "#EFEFEF", "edgecolor": "#B5B5B5", "hatch": "///"}
    elif span.between is not None:
        look = {"facecolor": "#F3E6B3"}
    if span.between is None:
        (axes.axvspan if along_x else axes.axhspan)(
            span.low, span.high, linewidth=0.0, zorder=0.4, label=span.name or span.text or None,
            **look,
        )  # fmt: skip
        return
    from matplotlib.patches import Rectangle

    low, high = span.between
    corner = (span.low, low) if along_x else (low, span.low)
    size = (span.high - span.low, high - low)
    axes.add_patch(
        Rectangle(corner, *(size if along_x else size[::-1]), linewidth=0.0, zorder=0.4,
                  label=span.name or None, **look)
    )  # fmt: skip


def _draw_rule(axes: Axes, rule: Rule) -> None:
    color, _ = color_of(rule.look)
    along_x = rule.along == "x"
    named = rule.name if rule.name else rule.text
    (axes.axvline if along_x else axes.axhline)(
        rule.at, color=color, linestyle=DASHES_OF[rule.look.dash],
        linewidth=_WIDTH_PT * rule.look.width, label=named or None,
    )  # fmt: skip
    if rule.name and rule.text:  # along its line
        place, coordinates = (rule.at, 0.02), ("data", "axes fraction")
        axes.annotate(
            rule.text, place if along_x else place[::-1], xytext=(-3, 0) if along_x else (0, 3),
            xycoords=coordinates if along_x else coordinates[::-1], textcoords="offset points",
            rotation=90 if along_x else 0, ha="right" if along_x else "left", va="bottom",
            fontsize=SMALL_PT,
        )  # fmt: skip


def _draw_label(axes: Axes, label: Label) -> None:
    """Write a text at a point, outside the frame where a line leaves it."""
    right = label.side == "right"
    axes.annotate(
        label.text,
        (label.x, label.y),
        xytext=(4, 0) if right else (0, 4),
        textcoords="offset points",
        ha="left" if right else "center",
        va="center" if right else "bottom",
        fontsize=SMALL_PT,
        annotation_clip=False,
    )


def _draw_heat(figure: Figure, axes: Axes, heat: Heat, y: Axis) -> None:
    """Draw values with a logarithmic, perceptually uniform scale of colours."""
    from matplotlib.colors import LogNorm

    known = heat.values[heat.values > 0]
    if not known.size:
        raise AnalysisError("the map is zero; there is nothing to draw")
    top = min(float(known.max()), heat.brightest)
    bottom = max(_DARKEST * top, float(known.min()))
    along = np.exp(_edges(np.log(heat.y))) if y.is_log else _edges(heat.y)
    mesh = axes.pcolormesh(
        _edges(heat.x), along, np.where(heat.values > 0, heat.values, np.nan),
        norm=LogNorm(vmin=min(bottom, 0.999 * top), vmax=top), cmap="cividis", rasterized=True,
    )  # fmt: skip
    ends = int(known.min() < bottom) + 2 * int(known.max() > top)
    bar = figure.colorbar(mesh, ax=axes, extend=("neither", "min", "max", "both")[ends])
    bar.set_label(f"{heat.label} [{heat.unit}]")


def _edges(centers: FloatArray) -> FloatArray:
    """Return the edges of cells around rising centres; a single one gets a width of 1."""
    if not (np.diff(centers) > 0).all():
        raise AnalysisError("the speeds, frequencies and stiffness of a map must rise to be drawn")
    if centers.size == 1:
        return np.asarray(centers[0] + np.array([-0.5, 0.5]))
    middle = 0.5 * (centers[1:] + centers[:-1])
    first, last = 2.0 * centers[0] - middle[0], 2.0 * centers[-1] - middle[-1]
    return np.concatenate(([first], middle, [last]))
