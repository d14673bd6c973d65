"""Charts of `solidwhirl.rotordyn.plots.chart` as the page draws them, with plotly."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby, pairwise
from typing import Any

import numpy as np

from solidwhirl.page.frame import records
from solidwhirl.rotordyn.plots import chart as charts

Trace = dict[str, Any]

# Blue to yellow in equal steps of lightness, told apart with any colour vision and in grey.
MAP_COLORS = "Cividis"
# Amplitudes below this part of the largest are drawn as dark as this; cells of a map.
_DARKEST = 1e-4
_COLUMNS, _ROWS = 600, 200
# Points of a line in space.
_RIDGE_POINTS = 800
# Decades of an axis that is marked within them.
_FEW_DECADES = 1.8
# Letters of the name of a row.
_LETTERS = 90
_PATTERNS = ("", "/", "x", ".", "\\", "+", "-")
_HATCHED = {
    "fillcolor": "@faint",
    "fillpattern": {
        "shape": "/", "fgcolor": "@muted", "bgcolor": "rgba(0,0,0,0)", "size": 9, "solidity": 0.12,
    },
    "line": {"color": "@muted", "width": 1},
}  # fmt: skip


def page_chart(chart: charts.Chart, analysis: str = "") -> records.Chart:
    """Return a chart as a block of the page; an analysis whose it is stands in its name."""
    drawing = _Drawing(chart)
    return records.Chart(
        name=f"{chart.name}-{slug(analysis)}" if analysis else chart.name,
        title=chart.title,
        caption=chart.caption,
        alt=chart.alt,
        traces=drawing.traces,
        layout=drawing.layout(),
        height_px=chart.height_px,
        controls=drawing.controls,
    )


class _Drawing:
    """Traces, shapes, annotations and controls of one chart."""

    def __init__(self, chart: charts.Chart) -> None:
        self.chart = chart
        self.traces: list[Trace] = []
        self.shapes: list[dict[str, Any]] = []
        self.annotations: list[dict[str, Any]] = []
        self.controls: list[records.Toggle | records.Choice] = []
        for plain, group in groupby(
            chart.parts, lambda p: not isinstance(p, charts.Toggle | charts.Choice)
        ):
            parts: list[Any] = [*group]
            if plain:
                self._add(parts)
            else:
                self.controls += map(self._control, parts)

    def _control(self, part: charts.Toggle | charts.Choice) -> records.Toggle | records.Choice:
        if isinstance(part, charts.Toggle):
            shown = self._add(part.marks)
            return records.Toggle(label=part.label, traces=shown, shown=part.is_shown)
        options = [
            records.Option(label=o.label, traces=self._add(o.marks, o.x, o.y), layout=_changes(o))
            for o in part.options
        ]
        return records.Choice(label=part.label, options=options)

    def _add(
        self,
        marks: Sequence[charts.Mark],
        x: charts.Axis | None = None,
        y: charts.Axis | None = None,
    ) -> list[int]:
        """Add marks and return the numbers of their traces."""
        before = len(self.traces)
        axes = x or self.chart.x, y or self.chart.y
        for _, same in groupby(marks, _kind):
            group: list[Any] = [*same]
            if isinstance(group[0], charts.Curve):
                self.traces.append(_curve_trace(group, axes, self.chart.right))
            elif isinstance(group[0], charts.Fill):
                self.traces.append(_fill_trace(group, axes))
            else:
                for mark in group:
                    self._add_one(mark, axes, len(self.traces) - before)
        named: set[str] = set()  # a name of ranges stands once in the legend
        for trace in self.traces[before:]:
            if "legendgroup" in trace:
                trace["showlegend"] = trace["name"] not in {"", *named}
                named.add(trace["name"])
        return list(range(before, len(self.traces)))

    def _add_one(self, mark: Any, axes: tuple[charts.Axis, charts.Axis], number: int) -> None:
        match mark:
            case charts.Span() if mark.is_hatched or mark.between:
                self.traces.append(_span_trace(mark, axes))
            case charts.Span():
                self.shapes.append(_span_shape(mark))
            case charts.Rule():
                self.shapes.append(_rule_shape(mark))
            case charts.Label():
                self.annotations.append(_annotation(mark))
            case charts.Note():
                self.traces.append(_note_trace(mark))
            case charts.Heat():
                self.traces.append(_heat_trace(mark, axes))
            case charts.Ridges():
                self.traces.append(_ridge_trace(mark, axes))
            case charts.Bars():
                self.traces.append(_bars_trace(mark, axes, number))

    def layout(self) -> dict[str, Any]:
        """Return what differs from the layout of the page."""
        chart = self.chart
        if ridges := chart.marks(charts.Ridges):
            return _in_space(chart, ridges[0])
        layout: dict[str, Any] = {
            "xaxis": axis_layout(chart.x),
            "yaxis": axis_layout(chart.y, _LETTERS),
        }
        if chart.marks(charts.Bars) and not chart.y.places:
            layout["barmode"] = "relative" if chart.is_stacked else "group"
            layout["xaxis"] = {"title": {"text": chart.x.title}, "type": "category"}
        if chart.right is not None:
            layout["yaxis2"] = axis_layout(chart.right) | {
                "overlaying": "y", "side": "right", "showgrid": False, "tickmode": "auto",
            }  # fmt: skip
            layout["margin"] = {"r": 64}
        if chart.is_to_scale:
            layout["xaxis"]["constrain"] = "domain"
            layout["yaxis"] |= {"scaleanchor": "x", "scaleratio": 1, "constrain": "domain"}
        if self.shapes:
            layout["shapes"] = self.shapes
        if self.annotations:
            layout["annotations"] = self.annotations
        if not chart.has_legend:
            layout["showlegend"] = False
        return layout


def axis_layout(axis: charts.Axis, most: int = 24) -> dict[str, Any]:
    """Return an axis; a logarithmic one of many decades is marked at whole ones only.

    Names of places are cut to so many letters.
    """
    found: dict[str, Any] = {"title": {"text": axis.title}}
    if axis.low is not None and axis.high is not None:
        ends = [axis.low, axis.high]
        if axis.is_log:
            ends = np.log10(ends).tolist()
            if ends[1] - ends[0] >= _FEW_DECADES:
                found["dtick"] = 1
        found["range"] = ends
    if axis.is_log:
        found |= {"type": "log", "exponentformat": "power"}
    if axis.places:
        numbers = list(range(len(axis.places)))
        names = [name if len(name) < most else name[: most - 2] + " …" for name in axis.places]
        found |= {"tickmode": "array", "tickvals": numbers, "ticktext": names}
    if axis.step:
        found |= {"tickmode": "linear", "tick0": 0, "dtick": axis.step}
    return found


def _changes(option: charts.Option) -> dict[str, Any]:
    """What axes of an option change in a layout, by plotly's dotted names."""
    changes: dict[str, Any] = {}
    named, bars = (
        any(isinstance(mark, k) for mark in option.marks) for k in (charts.Heat, charts.Bars)
    )
    for key, axis in (("xaxis", option.x), ("yaxis", option.y)):
        if axis is None:
            continue
        own: dict[str, Any] = {"type": "log" if axis.is_log else "linear", **axis_layout(axis)}
        if axis.places and bars:
            own = {"title": own["title"], "type": "category"}
        elif axis.places and named:  # rows of a map have their names for coordinates
            own = {"title": own["title"], "type": "category", "dtick": 1, "range": own["range"]}
        changes |= {f"{key}.{k}": v for k, v in own.items() if k != "title"}
        changes[f"{key}.title.text"] = axis.title
    return changes


def _kind(mark: charts.Mark) -> tuple[Any, ...]:
    """What marks that are one trace have in common."""
    return (type(mark), *(getattr(mark, key, "") for key in ("name", "look", "written")))


def _hover(name: str, axes: tuple[charts.Axis, charts.Axis], value: str = "y") -> str:
    """What a reader is told at a point: name, place and value with their units, text."""
    x, y = axes
    lines = [f"<b>{name}</b>"] if name else []
    if not x.places:
        lines.append(f"%{{x:{x.digits}}} {x.unit}")
    if not y.places:
        lines.append(f"<b>%{{{value}:{y.digits}}} {y.unit}</b>")
    return "<br>".join(lines)


def _joined(parts: Iterable[Any]) -> Any:
    """Lines one after the other with gaps between them."""
    gap = np.array([np.nan])
    rows = [row for part in parts for row in (np.asarray(part, dtype=float), gap)]
    return np.concatenate(rows[:-1])


def _curve_trace(
    curves: Sequence[charts.Curve], axes: tuple[charts.Axis, charts.Axis], right: charts.Axis | None
) -> Trace:
    first = curves[0]
    look, on_right = first.look, first.on_right and right is not None
    shown = axes[0], right if on_right and right else axes[1]
    modes = [word for word, own in (("lines", look.dash), ("markers", look.mark)) if own]
    trace: Trace = {
        "type": "scatter",
        "mode": "+".join(modes),
        "x": _joined([c.x for c in curves]),
        "y": _joined([c.y for c in curves]),
        "name": first.name,
        "showlegend": bool(first.name) and look.color != "#ffffff",  # not seen on paper
        "hovertemplate": _hover(first.name, shown),
    }
    if look.dash:
        trace["line"] = {"color": look.color, "dash": look.dash, "width": look.width}
        trace["connectgaps"] = False
    if look.mark:
        edge = {} if look.dash else {"line": {"color": look.color, "width": 1.5}}
        trace["marker"] = {"color": look.color, "symbol": look.mark, "size": look.size, **edge}
        trace["cliponaxis"] = False  # a mark at the edge of the frame is drawn whole
    if any(c.texts for c in curves):
        trace["text"] = [
            text.replace("\n", "<br>") for c in curves for text in (*c.texts, "")
        ][:-1]  # fmt: skip
        trace["hovertemplate"] += "<br>%{text}"
    trace["hovertemplate"] += "<extra></extra>"
    if first.written:
        trace |= {
            "mode": "markers+text", "hovertext": trace.pop("text", []), "text": [first.written],
            "textposition": "top center", "textfont": {"color": look.color},
        }  # fmt: skip
        trace["hovertemplate"] = trace["hovertemplate"].replace("%{text}", "%{hovertext}")
    if first.errors is not None:
        trace[f"error_{first.errors_along}"] = {
            "type": "data", "array": _joined([c.errors for c in curves]), "color": look.color,
            "thickness": 1.5,
        }  # fmt: skip
    if first.is_quiet:
        trace["visible"] = "legendonly"
    if on_right:
        trace["yaxis"] = "y2"
    return trace


def _fill_trace(fills: Sequence[charts.Fill], axes: tuple[charts.Axis, charts.Axis]) -> Trace:
    """Outlines of areas as one trace; an area ends where its curves do."""
    xs, ys = [], []
    for fill in fills:
        known = np.isfinite(fill.low) & np.isfinite(fill.high)
        edges = np.flatnonzero(np.diff(np.concatenate([[0], known.astype(int), [0]])))
        for a, b in edges.reshape(-1, 2):
            x, low, high = fill.x[a:b], fill.low[a:b], fill.high[a:b]
            xs.append(np.concatenate([x, x[::-1], x[:1]]))
            ys.append(np.concatenate([high, low[::-1], high[:1]]))
    look = fills[0].look
    told = (
        {"hoveron": "points", "hovertemplate": _hover(fills[0].name, axes) + "<extra></extra>"}
        if look.dash
        else {"hoverinfo": "skip"}
    )
    return {
        "type": "scatter",
        "mode": "lines",
        "x": _joined(xs),
        "y": _joined(ys),
        "fill": "toself",
        "fillcolor": f"{look.color}/0.55" if look.dash else look.color,
        "line": {"color": look.color, "width": look.width if look.dash else 0},
        "name": fills[0].name,
        **told,
    }


def _span_trace(span: charts.Span, axes: tuple[charts.Axis, charts.Axis]) -> Trace:
    other = axes[1] if span.along == "x" else axes[0]
    ends = span.between or (other.low or 0.0, other.high or 1.0)
    along = np.array([span.low, span.low, span.high, span.high, span.low])
    across = np.array([ends[0], ends[1], ends[1], ends[0], ends[0]])
    x, y = (along, across) if span.along == "x" else (across, along)
    plain = {key: value for key, value in _HATCHED.items() if key != "fillpattern"}
    return {
        "type": "scatter",
        "mode": "lines",
        "x": x,
        "y": y,
        "fill": "toself",
        **(_HATCHED if span.is_hatched else plain),
        "name": span.name,
        "text": span.text.replace("\n", "<br>"),
        "hoverinfo": "text",
        "hoveron": "fills",
        "legendgroup": span.name,
    }


def _span_shape(span: charts.Span) -> dict[str, Any]:
    """A shaded range, which stands behind the grid."""
    return {
        "type": "rect",
        **_across(span.along, span.low, span.high),
        "fillcolor": span.look.color,
        "opacity": 0.12,
        "line": {"width": 0},
        "layer": "below",
        "label": {
            "text": span.text, "font": {"color": span.look.color}, "textposition": "top left",
        },
    }  # fmt: skip


def _rule_shape(rule: charts.Rule) -> dict[str, Any]:
    look = rule.look
    return {
        "type": "line",
        **_across(rule.along, rule.at, rule.at),
        "line": {"color": look.color, "width": look.width, "dash": look.dash},
        "label": {
            "text": rule.text, "font": {"color": look.color, "size": 10}, "textposition": "end",
        },
    }  # fmt: skip


def _across(along: str, low: float, high: float) -> dict[str, Any]:
    """Where a shape lies that reaches over the whole of the other axis."""
    other = "y" if along == "x" else "x"
    return {
        f"{along}0": low, f"{along}1": high,
        f"{other}ref": "paper", f"{other}0": 0.0, f"{other}1": 1.0,
    }  # fmt: skip


def _annotation(label: charts.Label) -> dict[str, Any]:
    return {
        "x": label.x,
        "y": label.y,
        "text": label.text,
        "showarrow": False,
        "xanchor": "right",
        "yanchor": "top" if label.side == "above" else "bottom",
        "font": {"color": "@ink", "size": 11},
        "bgcolor": "@paper",
        "opacity": 0.85,
    }


def _note_trace(note: charts.Note) -> Trace:
    """A text as a trace of its own, which is shown and hidden with its option."""
    sides = {"left": "middle right", "center": "middle center", "right": "middle left"}
    return {
        "type": "scatter", "mode": "text", "x": [note.x], "y": [note.y], "text": [note.text],
        "textposition": sides[note.align], "textfont": {"color": "@ink", "size": 11},
        "showlegend": False, "hoverinfo": "skip",
    }  # fmt: skip


def coarser(x: Any, y: Any, values: Any) -> tuple[Any, Any, Any]:
    """Return a map with some columns and rows at most, each cell the largest that it covers."""
    for axis_number, most in ((1, _COLUMNS), (0, _ROWS)):
        if values.shape[axis_number] <= most:
            continue
        edges = np.linspace(0, values.shape[axis_number], most + 1).astype(int)[:-1]
        values = np.maximum.reduceat(values, edges, axis=axis_number)
        if axis_number == 1:
            x = x[edges]
        else:
            y = np.asarray(y)[edges]
    return x, y, values


def _heat_trace(heat: charts.Heat, axes: tuple[charts.Axis, charts.Axis]) -> Trace:
    x, y, values = coarser(heat.x, heat.y, heat.values)
    largest = min(float(np.nanmax(values, initial=0.0)), heat.brightest)
    low = _DARKEST * largest if largest > 0.0 else 1.0
    top = np.log10(largest) if largest > 0.0 else 1.0
    ticks = np.arange(np.ceil(np.log10(low)), np.floor(top) + 1.0)
    along = axes[0]
    place = "%{y}" if axes[1].places else f"%{{y:{axes[1].digits}}} {axes[1].unit}"
    return {
        "type": "heatmap",
        "x": x,
        "y": list(axes[1].places) or y,
        "z": np.log10(np.maximum(values, low)),
        "customdata": np.asarray(values, dtype=float),
        "zmin": float(np.log10(low)),
        "zmax": float(top),
        "colorscale": MAP_COLORS,
        "zsmooth": False,
        "hovertemplate": f"%{{x:{along.digits}}} {along.unit}, {place}<br>"
        f"<b>%{{customdata:.4g}} {heat.unit}</b><extra></extra>",
        "colorbar": {
            "title": {"text": f"{heat.label} [{heat.unit}]", "side": "right"},
            "thickness": 12,
            "tickvals": [float(t) for t in ticks],
            "ticktext": [f"{10.0**t:g}" for t in ticks],
        },
    }


def _in_space(chart: charts.Chart, ridges: charts.Ridges) -> dict[str, Any]:
    """Layout of lines in space."""
    titles = {"x": chart.x.title, "y": chart.y.title, "z": f"{ridges.label} [{ridges.unit}]"}
    return {
        "scene": {
            **{f"{key}axis": {"title": {"text": title}} for key, title in titles.items()},
            "aspectratio": {"x": 1.6, "y": 1.2, "z": 0.7},
            "camera": {"eye": {"x": -1.3, "y": -1.9, "z": 0.9}, "center": {"z": -0.15}},
        },
        "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
        "showlegend": False,
    }


def _ridge_trace(ridges: charts.Ridges, axes: tuple[charts.Axis, charts.Axis]) -> Trace:
    """Lines one behind the other; between the points of one the highest is kept."""
    size = ridges.x.size
    edges = np.unique(np.linspace(0, size, min(size, _RIDGE_POINTS) + 1).astype(int))
    kept = np.array(
        [
            [low + int(values[low:high].argmax()) for low, high in pairwise(edges)]
            for values in ridges.values
        ]
    )
    z = np.take_along_axis(ridges.values, kept, axis=1)
    darkest = _DARKEST * max(float(z.max()), 1e-300)
    x, y = axes
    return {
        "type": "scatter3d",
        "mode": "lines",
        "x": _joined(ridges.x[kept]),
        "y": _joined(np.repeat(ridges.y[:, None], kept.shape[1], axis=1)),
        "z": _joined(z),
        "line": {
            "color": np.log10(np.maximum(np.nan_to_num(_joined(z)), darkest)),
            "colorscale": MAP_COLORS,
            "width": 3,
        },
        "hovertemplate": f"%{{x:{x.digits}}} {x.unit}, %{{y:{y.digits}}} {y.unit}<br>"
        f"%{{z:.4g}} {ridges.unit}<extra></extra>",
        "connectgaps": False,
        "name": ridges.label,
    }


def _bars_trace(bars: charts.Bars, axes: tuple[charts.Axis, charts.Axis], number: int) -> Trace:
    lying = bool(axes[1].places)
    pattern = {"shape": _PATTERNS[number % len(_PATTERNS)], "fillmode": "overlay",
               "fgcolor": "@paper"}  # fmt: skip
    rows: Trace = {
        "x": [place.replace(", ", "<br>") for place in axes[0].places], "y": bars.values,
        **({"text": list(bars.texts), "textposition": "none"} if bars.texts else {}),
    }  # fmt: skip
    if lying:
        rows = {
            "x": bars.values, "y": np.arange(float(len(bars.values))), "orientation": "h",
            "base": bars.start, "customdata": list(axes[1].places), "width": 0.65,
            "text": list(bars.texts), "insidetextfont": {"color": "@paper"}, "cliponaxis": False,
        }  # fmt: skip
    place, value, axis = ("%{customdata}", "x", axes[0]) if lying else ("%{x}", "y", axes[1])
    return {
        "type": "bar",
        **rows,
        "name": bars.name,
        "marker": {"color": bars.look.color, "pattern": pattern},
        "hovertemplate": f"<b>{bars.name}</b><br>{place}<br>%{{{value}:{axis.digits}}} "
        f"{axis.unit}{'<br>%{text}' if bars.texts and not lying else ''}<extra></extra>",
    }


def slug(text: str) -> str:
    """Return a text, such as the name of an analysis, as part of an identifier in the page.

    Other signs than letters and digits become hyphens with their number: two texts stay two.
    """
    return "".join(
        c if c.isascii() and c.isalnum() else "-" if c == "_" else f"-{ord(c):x}-" for c in text
    )
