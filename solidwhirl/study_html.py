"""The page of a study: its pictures to be looked at closely, in one file that needs no network."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from solidwhirl.study_document import Study
from solidwhirl.study_styles import (
    FARTHEST,
    LIMITS,
    axis_label,
    drawn_error,
    drawn_series,
    label_of,
    map_grid,
    row_text,
    series_style,
)
from solidwhirl.study_table import StudyRow, StudyTable

Figure = dict[str, Any]
Value = Callable[[StudyRow], float]

_ERROR = "largest relative error [1]"
_STYLE = (
    "body{font-family:sans-serif;margin:1.5em auto;max-width:1100px;color:#222}"
    "td,th{padding:.15em .6em;text-align:right;border-bottom:1px solid #ddd}"
    "td:first-child,th:first-child{text-align:left}"
    "table{border-collapse:collapse;font-size:90%}"
)


def study_page(study: Study, document: Mapping[str, Any]) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    study
        The study.
    document
        From `solidwhirl.study_document.study_document`.

    Returns
    -------
    str
        With the drawing library inside, once; hovering over a point tells its settings.
    """
    from plotly.io import to_html
    from plotly.offline import get_plotlyjs

    title = escape(f"Accuracy against cost: {study.scene.title or study.scene.name}")
    figures = _figures(study.table, document)
    parts = [
        to_html(figure, full_html=False, include_plotlyjs=False, validate=True,
                default_height=f"{figure['layout']['height']}px",
                config={"displaylogo": False, "showSendToCloud": False, "responsive": True})
        for figure in figures
    ]  # fmt: skip
    notes = "".join(f"<li>{escape(note)}</li>" for note in study.notes)
    accuracy = document["reference"]["accuracy"]
    return "\n".join(
        [
            f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>',
            f"<style>{_STYLE}</style>",
            f"<script>{get_plotlyjs()}</script></head><body>",
            f"<h1>{title}</h1>",
            f"<p>Errors against the harmonic level at accuracy {accuracy:g}, whose own estimate is "
            f"{study.table.floor:.1e}. Times are processor times of whole processes.</p>",
            f"<ul>{notes}</ul>",
            *parts,
            _table(document["cases"]),
            "</body></html>\n",
        ]
    )


def _figures(table: StudyTable, document: Mapping[str, Any]) -> list[Figure]:
    figures = [
        _cost(table, "cpu_s", "processor time, start of the program included [s]",
              "Error against time", table.time_front),
        _cost(table, "peak_memory_gib", "peak memory [GiB]", "Error against memory",
              table.memory_front),
        _over_unknowns(table, "error", lambda r: drawn_error(r, table), _ERROR),
        _over_unknowns(table, "cpu_s", lambda r: r.solve_cpu_s, "processor time without start [s]"),
        _over_unknowns(table, "memory_gib", lambda r: r.solve_memory_gib,
                       "peak memory beyond the program's own [GiB]"),
        _estimates(table),
    ]  # fmt: skip
    return figures + [_map(found) for found in document["beam_map"]]


def _layout(title: str, x: str, y: str) -> dict[str, Any]:
    axis = {"type": "log", "gridcolor": "#E5E5E5", "exponentformat": "power"}
    return {
        "title": {"text": title},
        "height": 520,
        "xaxis": {**axis, "title": {"text": x}},
        "yaxis": {**axis, "title": {"text": y}},
        "plot_bgcolor": "white",
        "hovermode": "closest",
        "template": None,
    }


def _points(series: Any, rows: Sequence[StudyRow], x: Value, y: Value) -> dict[str, Any]:
    style = series_style(series)
    return {
        "type": "scatter",
        "mode": "markers",
        "name": label_of(series),
        "x": [x(r) for r in rows],
        "y": [y(r) for r in rows],
        "text": [row_text(r) for r in rows],
        "hovertemplate": "%{text}<extra></extra>",
        "marker": {
            "symbol": style.symbol + ("-open" if style.hollow else ""),
            "color": style.color,
            "size": 10,
        },
    }


def _line(x: Sequence[float], y: Sequence[float], name: str, **line: Any) -> dict[str, Any]:
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": list(x),
        "y": list(y),
        "line": {"color": "#595959", "width": 1.5, **line},
        "hoverinfo": "skip",
    }


def _cost(table: StudyTable, key: str, label: str, title: str, front: Sequence[str]) -> Figure:
    def cost(row: StudyRow) -> float:
        return row.measured(key)

    def error(row: StudyRow) -> float:
        return drawn_error(row, table)

    drawn = drawn_series(table.rows)
    data = [_points(series, rows, cost, error) for series, rows in drawn.items()]
    best = {r.outcome.case.name: r for r in table.rows}
    ends = [best[name] for name in front]
    data.append(_line([cost(r) for r in ends], [error(r) for r in ends], "Pareto front",
                      shape="hv"))  # fmt: skip
    shown = [cost(r) for rows in drawn.values() for r in rows]
    if shown and table.floor > 0.0:
        data.append(_line([min(shown), max(shown)], [table.floor] * 2,
                          "estimated error of the reference", dash="dot"))  # fmt: skip
    return {"data": data, "layout": _layout(title, label, _ERROR)}


def _over_unknowns(table: StudyTable, quantity: str, value: Value, label: str) -> Figure:
    data = []
    for series, rows in drawn_series(table.rows).items():
        points = [
            r for r in rows
            if r.outcome.case.group in ("mesh", "dial", "beam") and value(r) > 0.0
        ]  # fmt: skip
        if points:
            data.append(_points(series, points, lambda r: r.measured("unknowns"), value))
    for fitted in (s for s in table.slopes if s.quantity == quantity):
        rows = [r for r in table.rows if r.outcome.case.name in fitted.names]
        unknowns = [r.measured("unknowns") for r in rows]
        ends = [min(unknowns), max(unknowns)]
        law = [fitted.slope.factor * n**fitted.slope.slope for n in ends]
        name = f"slope {fitted.slope.slope:.2f} ± {fitted.slope.standard_error:.2f}"
        data.append(_line(ends, law, name, color=series_style(fitted.series).color))
    return {
        "data": data,
        "layout": _layout(f"{label} over the unknowns", "unknowns before reduction [1]", label),
    }


def _estimates(table: StudyTable) -> Figure:
    data, true = [], []
    for series, rows in drawn_series(table.rows).items():
        known = [r for r in rows if np.isfinite(r.campbell.estimate) and r.campbell.true > 0.0]
        if known:
            data.append(
                _points(series, known, lambda r: r.campbell.true, lambda r: r.campbell.estimate)
            )
            true += [r.campbell.true for r in known]
    if true:
        ends = [min(true), max(true)]
        data.append(_line(ends, ends, "estimate = error"))
    label = "largest estimated relative error [1]"
    return {"data": data, "layout": _layout("Estimated against true error", _ERROR, label)}


def _map(found: Mapping[str, Any]) -> Figure:
    """Cells with their errors, and the contours at 1 % and 5 %."""
    x, y, error = map_grid(found["points"])
    percent = np.where(np.isfinite(error), 100.0 * error, np.nan)
    logs = np.log10(np.where(np.isfinite(error), error, np.nan))
    text = [
        ["" if np.isnan(v) else "&gt; 25 %" if v >= 100.0 * FARTHEST else f"{v:.2g} %" for v in row]
        for row in percent
    ]
    heat = {
        "type": "heatmap",
        "x": x,
        "y": y,
        "z": _nulls(logs),
        "text": text,
        "texttemplate": "%{text}",
        "hovertemplate": "%{x:.3g} by %{y:.3g}: %{text}<extra></extra>",
        "colorscale": "Cividis",
        "zmin": -4.0,
        "zmax": float(np.log10(FARTHEST)),
        "colorbar": {"title": {"text": "log10 of the<br>relative error"}},
    }
    lines = [
        {
            "type": "contour",
            "x": x,
            "y": y,
            "z": _nulls(logs),
            "contours": {
                "coloring": "none",
                "start": float(np.log10(limit)),
                "end": float(np.log10(limit)),
                "size": 1.0,
            },
            "line": {"color": color, "width": 3},
            "name": f"{limit:.0%}",
            "showscale": False,
            "showlegend": True,
            "hoverinfo": "skip",
        }
        for limit, color in zip(LIMITS, ("#D55E00", "#000000"), strict=True)
        if np.isfinite(error).any() and np.nanmin(error) < limit < np.nanmax(error)
    ]
    layout = _layout(f"Beams against solids: {found['map']}", axis_label(found["x_name"]),
                     axis_label(found["y_name"]))  # fmt: skip
    for axis, places in (("xaxis", x), ("yaxis", y)):
        layout[axis] |= {"tickvals": places, "ticktext": [f"{v:.3g}" for v in places]}
    layout["legend"] = {"orientation": "h"}
    return {"data": [heat, *lines] if min(error.shape) > 1 else [heat], "layout": layout}


def _nulls(values: Any) -> list[list[float | None]]:
    return [[float(v) if np.isfinite(v) else None for v in row] for row in values]


def _table(cases: Sequence[Mapping[str, Any]]) -> str:
    """All cases that are done, as they are in study.md."""
    head = ("case", "unknowns", "CPU [s]", "memory [GiB]", "error", "estimate", "critical speeds")
    rows = ["<table><tr>" + "".join(f"<th>{h}</th>" for h in head) + "</tr>"]
    for case in cases:
        if case["status"] != "done":
            continue
        numbers = (
            (case["unknowns"], ".0f"),
            (case["cpu_s"], ".2f"),
            (case["peak_memory_gib"], ".3f"),
            (case["campbell"]["relative_error"], ".1e"),
            (case["campbell"]["estimated_relative_error"], ".1e"),
            (case["critical_speeds"]["relative_error"], ".1e"),
        )
        cells = "".join(
            f"<td>{'' if value is None else format(value, kind)}</td>" for value, kind in numbers
        )
        rows.append(f"<tr><td>{escape(case['name'])}</td>{cells}</tr>")
    return "\n".join([*rows, "</table>"])
