"""Parallel coordinates of a sweep: every case a line over its parameters and results."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np

from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray
from solidwhirl.sweep.analysis import SweepAnalysis, SweepPictureSettings
from solidwhirl.sweep.records import distinct_warnings
from solidwhirl.sweep_pictures.parts import cases_text, parameter_label, shown_parameters

# Axes of each kind.
_AXES = 20
_STYLE = "body{font-family:sans-serif;margin:1.5em auto;max-width:1400px;color:#222}"


def parallel_page(found: SweepAnalysis, settings: SweepPictureSettings) -> str:
    """Return parallel coordinates as a page: ranges are chosen by dragging along the axes.

    Axes are the most influential parameters, then critical speeds and responses. The drawing
    library is inside; cases that lack a result of an axis are left out and counted.
    """
    from plotly.graph_objects import Figure, Parcoords
    from plotly.offline import get_plotlyjs

    design = found.design
    shown = [k for k in shown_parameters(found)[:_AXES] if np.ptp(design.values[:, k]) > 0.0]
    # a result that few cases have would hide the others
    results = [q for q in found.quantities if np.isfinite(q.values).mean() >= 0.5][:_AXES]
    known = np.array([q.values for q in results]).reshape(-1, len(design.rows))
    whole = np.isfinite(known).all(axis=0)
    dimensions = [_parameter(found, settings, k, whole) for k in shown]
    for q in results:
        label = escape(settings.labels.get(q.name, q.label))
        dimensions.append({"label": label, "values": q.values[whole]})
    color = dimensions[len(shown) if results else 0]
    trace = Parcoords(
        dimensions=dimensions,
        line={
            "color": color["values"],
            "colorscale": "Cividis",
            "showscale": True,
            "colorbar": {"title": {"text": color["label"]}},
        },
        labelangle=-12,
        labelside="top",
    )
    layout = {"height": 620, "margin": {"t": 130, "l": 90, "r": 60}, "font": {"size": 13}}
    part = Figure(trace, {**layout, "template": None}).to_html(
        full_html=False, include_plotlyjs=False, config={"displaylogo": False, "responsive": True}
    )
    lost = int((~whole).sum())
    said = [cases_text(found), *([f"{lost} without all results are not drawn"] if lost else [])]
    title = escape(f"All cases: {design.scene}")
    warned = [f"warning: {text}" for text in distinct_warnings(design.every_row)]
    notes = "".join(f"<li>{escape(n)}</li>" for n in (*found.notes, *warned))
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        f"<style>{_STYLE}</style>\n<script>{get_plotlyjs()}</script></head><body>\n"
        f"<h1>{title}</h1>\n<p>{escape('; '.join(said))}. Drag along an axis to choose a range, "
        f"double-click to take it back, drag a name to move its axis.</p>\n{part}\n"
        f"<ul>{notes}</ul>\n</body></html>\n"
    )


def _parameter(
    found: SweepAnalysis, settings: SweepPictureSettings, number: int, whole: BoolArray
) -> dict[str, Any]:
    """The axis of a parameter: its words, or its numbers by their logarithm."""
    parameter, values = found.design.parameters[number], found.design.values[:, number]
    axis: dict[str, Any] = {"label": escape(parameter_label(parameter.name, settings))}
    if parameter.choices:
        words = [escape(choice) for choice in parameter.choices]
        places = [*range(len(words))]
        return {**axis, "values": values[whole], "tickvals": places, "ticktext": words}
    if not parameter.logarithmic:
        return {**axis, "values": values[whole]}
    ticks = _round_numbers(values)
    return {
        **axis,
        "values": np.log10(values[whole]),
        "tickvals": np.log10(ticks),
        "ticktext": [f"{v:.4g}" for v in ticks],
    }


def _round_numbers(values: FloatArray) -> FloatArray:
    """1, 2, 5, 10 ... within a range, its ends where there are fewer than two."""
    low, high = values.min(), values.max()
    decades = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1.0)
    ticks = np.outer(decades, [1.0, 2.0, 5.0]).ravel()
    within = ticks[(ticks >= low * (1.0 - 1e-9)) & (ticks <= high * (1.0 + 1e-9))]
    return within if within.size > 1 else np.array([low, high])
