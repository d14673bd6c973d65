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
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.plots import frame

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Points of paper for a pixel of a screen: widths of lines, sizes of marks.
_WIDTH_PT, _SIZE_PT = 0.75, 0.58
# Longer notes stand below a picture.
_BESIDE = 60
# Axes that span less than this factor have more numbers than powers of ten.
_FEW = 100.0
# Letters of titles of frames side by side.
_ACROSS = 72
# Colours of a map below this part of the largest are the same.
_DARKEST = 1e-4
# Marks along a curve, and frames side by side.
_MARKED, _COLUMNS = 10, 3
# Height of a page for many frames.
_PAGE_MM = 240.0
# Numbers nearer than this fraction of the axis would cover each other, and how many have room.
_LABEL_WIDTH, _MOST_LABELS = 0.02, 12
_HATCHES = ("", "///", "xxx", "...", "\\\\\\", "+++", "---")


def draw_titled_charts(drawn: Sequence[charts.Chart], path: str | Path, title: str) -> None:
    """Draw charts as `draw_charts`; a single one has its own title behind the one above it."""
    draw_charts(drawn, path, f"{title}: {drawn[0].title}" if len(drawn) == 1 else title)


@frame.styled
def draw_charts(drawn: Sequence[charts.Chart], path: str | Path, title: str) -> None:
    """Draw charts to a picture file, one below the other, with a title above them.

    Options of a choice that is drawn whole stand side by side. The suffix chooses the kind of file
    (.png, .svg, .pdf), which is replaced when the new one is complete. Raises AnalysisError: if
    there is nothing to draw, or the suffix is not a kind of picture that can be written.
    """
    rows = [_frames_of(chart) for chart in drawn]
    if not rows or not all(rows):
        raise AnalysisError("there is nothing to draw")
    if len(rows) == 1 and len(rows[0]) > 1:
        same_y = len({id(chart.y) for chart, _ in rows[0]}) == 1
        many = drawn[0].is_to_scale or (same_y and len(rows[0]) == _COLUMNS)
        across = min(_COLUMNS if many else 2, len(rows[0]))
        rows = [rows[0][k : k + across] for k in range(0, len(rows[0]), across)]
    single = len(drawn) == 1
    same_x = not single and len({chart.x.unit for chart in drawn}) == 1
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
            lines = name.replace(", ", ",\n", 1).split("\n")
            own_title = "\n".join(fill(line, _ACROSS // columns) for line in lines)
            axes.set_title(own_title, fontsize=frame.TEXT_PT)
            if columns > 1:
                axes.set_xlabel(fill(axes.get_xlabel(), _ACROSS // columns))
            if same_x and number + 1 < len(rows):
                axes.set_xlabel("")
            if axes is not own[0] and chart.y is row[0][0].y:
                axes.set_ylabel("")
    _entitle(figure, grid, fill(title, 60))
    figure.align_ylabels()
    notes = [note for chart in drawn for note in chart.notes]
    long = [fill(note, frame.LETTERS) for note in notes if len(note) > _BESIDE]
    if long:
        figure.supxlabel("\n".join(long), fontsize=frame.SMALL_PT, x=0.01, ha="left")
    if any(chart.has_legend for chart in drawn):
        below = single and (columns > 1 or bool(drawn[0].marks(charts.Heat)))
        place = "outside lower center" if below else "outside right upper"
        short = "\n".join(note for note in notes if len(note) <= _BESIDE)
        frame.add_legend(figure, figure.axes, short, place, 3 if below else 1)
    frame.write_figure(figure, path)


Frame = tuple[charts.Chart, str]


def _frames_of(chart: charts.Chart) -> list[Frame]:
    """A chart with what paper shows of its choices: one frame for each option drawn there."""
    whole = next(
        (p for p in chart.parts if isinstance(p, charts.Choice) and p.on_paper == "each"), None
    )
    options: Sequence[charts.Option | None] = whole.options if whole else (None,)
    frames = []
    for option in options:
        parts: list[charts.Part] = []
        x, y = chart.x, chart.y
        for part in chart.parts:
            if isinstance(part, charts.Toggle):
                parts += part.marks
            elif isinstance(part, charts.Choice):
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
    first = rows[0][0][0]
    if first.is_to_scale:
        slender = min(1.0, _aspect(first))
        width = frame.ONE_COLUMN_MM if columns == 1 and slender > 0.5 else frame.TWO_COLUMNS_MM
        return frame.new_figure(
            path, width, 30.0 + len(rows) * (14.0 + 0.9 * slender * width / columns)
        )
    places, height = first.y.places, frame.USUAL_HEIGHT_MM + 45.0 * (len(rows) - 1)
    if places:
        lines = 1 + max(place.count("\n") for place in places)
        height = (34.0 + (2.5 + 3.5 * lines) * len(places)) * len(rows)
    height = min(height, max(_PAGE_MM, height / len(rows)))
    return frame.new_figure(path, frame.TWO_COLUMNS_MM, height)


def _aspect(chart: charts.Chart) -> float:
    """Height over width of what is drawn to scale; of axes whose ends are set that of the frame."""
    if chart.x.low is not None:
        return 1.0
    sides = [np.concatenate([getattr(c, key) for c in chart.marks(charts.Curve)]) for key in "xy"]
    width, height = (float(np.nanmax(side) - np.nanmin(side)) for side in sides)
    return height / width


def _entitle(figure: Figure, grid: Any, title: str) -> None:
    """Put the title above the frame, or above all of several side by side."""
    if grid.shape[1] > 1:
        figure.suptitle(title, fontsize=frame.TITLE_PT)
    else:  # room for names of lines that leave at the top
        own = grid[0, 0].get_title()
        grid[0, 0].set_title(f"{title}\n{own}" if own else title, pad=20.0, fontsize=frame.TITLE_PT)


def _draw(figure: Figure, axes: Axes, chart: charts.Chart) -> None:
    for which, axis in (("x", chart.x), ("y", chart.y)):
        if axis.is_log:
            axes.set(**{f"{which}scale": "log"})
    right: list[Axes] = []
    for number, part in enumerate(chart.parts):
        order = 2.0 + 1e-3 * number  # later ones cover earlier ones
        match part:
            case charts.Curve() if part.on_right and chart.right is not None:
                if not right:
                    right.append(axes.twinx())
                    right[0].set_yscale("log" if chart.right.is_log else "linear")
                    set_axis(right[0], chart.right, "y")
                _draw_curve(right[0], part, order)
            case charts.Curve():
                _draw_curve(axes, part, order)
            case charts.Fill():
                color, opacity = frame.color_of(part.look)
                axes.fill_between(part.x, part.low, part.high, color=color, alpha=0.8 * opacity,
                                  linewidth=0.3, label=part.name or None, zorder=order)  # fmt: skip
            case charts.Span():
                _draw_span(axes, part)
            case charts.Rule():
                _draw_rule(axes, part)
            case charts.Label():
                _draw_label(axes, part)
            case charts.Note():
                axes.text(part.x, part.y, part.text, ha=part.align, va="center",
                          fontsize=frame.SMALL_PT, zorder=order)  # fmt: skip
            case charts.Heat():
                _draw_heat(figure, axes, part, chart.y)
            case charts.Ridges():
                _draw_ridges(axes, part)
            case charts.Bars():
                _draw_bars(axes, part, chart)
    set_axis(axes, chart.x, "x")
    set_axis(axes, chart.y, "y")
    _number(
        axes, [part for part in chart.parts if isinstance(part, charts.Curve) and part.is_numbered]
    )
    for axis, own in ((chart.x, axes.xaxis), (chart.y, axes.yaxis)):
        if axis.is_log and axis.unit != "rpm":
            _number_decades(own)
    if chart.is_to_scale:
        axes.set_aspect("equal")
        axes.locator_params(nbins=3, steps=[1, 2, 5, 10])
    if not chart.marks(charts.Heat):
        axes.grid(
            which="both" if chart.x.is_log else "major", color=frame.GRID_COLOR, linewidth=0.6
        )
        axes.set_axisbelow(True)


def _number_decades(own: Any) -> None:
    """Name 1, 2 and 5 on a logarithmic axis on which powers of ten would be too few."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = own.get_view_interval()
    if high < _FEW * low:
        own.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        own.set_minor_formatter(NullFormatter())
        own.set_major_formatter(FuncFormatter(lambda value, _: frame.number_text(value)))


def set_axis(axes: Axes, axis: charts.Axis, which: str) -> None:
    """Set the ends, the numbers and the label of an axis, "x" or "y"."""
    own = axes.xaxis if which == "x" else axes.yaxis
    if axis.low is not None and axis.high is not None:
        (axes.set_xlim if which == "x" else axes.set_ylim)(axis.low, axis.high)
    if axis.places:
        names = [p.replace(", ", "\n") if which == "x" else p for p in axis.places]
        own.set_ticks(range(len(names)), names, fontsize=frame.SMALL_PT)
    elif axis.step:
        from matplotlib.ticker import MultipleLocator

        own.set_major_locator(MultipleLocator(axis.step))
    elif axis.unit == "rpm":
        frame.name_speeds(own)
    own.set_label_text(fill(axis.title, 60 if which == "x" else 40))


def _draw_bars(axes: Axes, bars: charts.Bars, chart: charts.Chart) -> None:
    """Draw upright bars beside those of other kinds, or lying ones with texts at their ends."""
    every = chart.marks(charts.Bars)
    number, color = every.index(bars), frame.color_of(bars.look)[0]
    look: dict[str, Any] = {
        "color": color, "label": bars.name or None, "edgecolor": "white",
        "hatch": _HATCHES[number % len(_HATCHES)],
    }  # fmt: skip
    at = np.arange(float(len(bars.values)))
    if chart.y.places:
        start = np.zeros_like(at) if bars.start is None else bars.start
        drawn = axes.barh(at, bars.values, 0.62, left=start, **look)
        if bars.texts:
            axes.bar_label(drawn, bars.texts, padding=3, fontsize=frame.SMALL_PT)
        return
    if chart.is_stacked:
        sign, bottom = np.where(bars.values < 0.0, -1.0, 1.0), np.zeros_like(at)
        for other in every[:number]:
            bottom += np.where(sign * other.values > 0.0, other.values, 0.0)
        axes.bar(at, bars.values, 0.7, bottom=bottom, **look)
        return
    width = 0.8 / len(every)
    axes.bar(at + width * (number - 0.5 * (len(every) - 1)), bars.values, width, **look)


def _draw_ridges(axes: Axes, ridges: charts.Ridges) -> None:
    """Draw lines above their places, the first in front."""
    color, count = frame.color_of(charts.Look("@c0"))[0], ridges.y.size
    for k, (at, height) in reversed(list(enumerate(zip(ridges.y, ridges.values, strict=True)))):
        line, order = at + ridges.rise * height, 1.0 + (count - k) / count
        axes.fill_between(ridges.x, at, line, color="white", linewidth=0, zorder=order)
        axes.plot(ridges.x, line, color=color, linewidth=0.7, zorder=order)


def _draw_curve(axes: Axes, curve: charts.Curve, order: float) -> None:
    """Draw a line with some of its marks, or all marks where there is no line."""
    look, style = curve.look, frame.style_of(curve.look)
    color, opacity = frame.color_of(look)
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
        along_x, along_y = (curve.errors if curve.errors_along == a else None for a in "xy")
        axes.errorbar(curve.x, curve.y, xerr=along_x, yerr=along_y, fmt="none", ecolor=color,
                      capsize=3.0)  # fmt: skip


def _number(axes: Axes, curves: Sequence[charts.Curve]) -> None:
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
            ha="center", va="bottom", rotation=90, fontsize=frame.SMALL_PT,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.4},
        )  # fmt: skip
    if written and axes.get_yscale() == "log":  # room above
        low, high = axes.get_ylim()
        axes.set_ylim(low, high * (high / low) ** 0.2)


def _draw_span(axes: Axes, span: charts.Span) -> None:
    along_x = span.along == "x"
    if span.low == span.high:
        line: dict[str, Any] = {"color": "#8A8A8A", "linewidth": 2.4, "label": span.name or None}
        if span.between is not None:
            (axes.vlines if along_x else axes.hlines)(span.low, *span.between, zorder=1.4, **line)
        else:
            (axes.axvline if along_x else axes.axhline)(span.low, zorder=0.4, **line)
        return
    color, _ = frame.color_of(span.look)
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


def _draw_rule(axes: Axes, rule: charts.Rule) -> None:
    color, _ = frame.color_of(rule.look)
    along_x = rule.along == "x"
    named = rule.name if rule.name else rule.text
    (axes.axvline if along_x else axes.axhline)(
        rule.at, color=color, linestyle=frame.DASHES_OF[rule.look.dash],
        linewidth=_WIDTH_PT * rule.look.width, label=named or None,
    )  # fmt: skip
    if rule.name and rule.text:  # along its line
        place, coordinates = (rule.at, 0.02), ("data", "axes fraction")
        axes.annotate(
            rule.text, place if along_x else place[::-1], xytext=(-3, 0) if along_x else (0, 3),
            xycoords=coordinates if along_x else coordinates[::-1], textcoords="offset points",
            rotation=90 if along_x else 0, ha="right" if along_x else "left", va="bottom",
            fontsize=frame.SMALL_PT,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.4},
        )  # fmt: skip


def _draw_label(axes: Axes, label: charts.Label) -> None:
    """Write a text beside a point, outside the frame where a line leaves it."""
    offset, ha, va = {
        "right": ((4, 0), "left", "center"),
        "left": ((-4, 0), "right", "center"),
        "above": ((0, 4), "center", "bottom"),
    }[label.side]
    axes.annotate(label.text, (label.x, label.y), xytext=offset, textcoords="offset points", ha=ha,
                  va=va, fontsize=frame.SMALL_PT, annotation_clip=False)  # fmt: skip


def _draw_heat(figure: Figure, axes: Axes, heat: charts.Heat, y: charts.Axis) -> None:
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
