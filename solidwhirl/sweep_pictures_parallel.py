"""Parallel coordinates of a sweep: every case a line over its parameters and results."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from solidwhirl.rotordyn.picture_frame import (
    SMALL_PT,
    TWO_COLUMNS_MM,
    new_figure,
    number_text,
    styled,
    thousands,
    write_figure,
)
from solidwhirl.sweep_analysis import SweepAnalysis, SweepPictureSettings
from solidwhirl.sweep_design import FloatArray
from solidwhirl.sweep_labels import wrapped
from solidwhirl.sweep_picture_parts import (
    cases_text,
    in_powers_of_ten,
    parameter_label,
    shown_parameters,
    write_notes,
    write_title,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Axes of each kind; the page has room for more.
_PARAMETERS, _RESULTS, _PAGE = 6, 4, 20
_STYLE = "body{font-family:sans-serif;margin:1.5em auto;max-width:1400px;color:#222}"


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class ParallelAxis:
    """One axis.

    Attributes
    ----------
    label
        With the unit.
    values
        Of the cases done, nan where absent.
    choices
        Words of a parameter, empty for numbers.
    logarithmic
        Whether factors are equal distances.
    result
        Whether it is a result.
    """

    label: str
    values: FloatArray
    choices: tuple[str, ...]
    logarithmic: bool
    result: bool

    def places(self, values: FloatArray) -> FloatArray:
        """Return values as heights from 0 to 1."""
        known = self.values[np.isfinite(self.values)]
        low, high = float(known.min()), float(known.max())
        if self.choices:
            low, high = 0.0, max(float(len(self.choices) - 1), 1.0)
        if self.logarithmic:
            return np.asarray(np.log(values / low) / np.log(high / low))
        return np.asarray((values - low) / (high - low))


def parallel_axes(
    found: SweepAnalysis, settings: SweepPictureSettings, parameters: int, results: int
) -> tuple[ParallelAxis, ...]:
    """Return the axes: the most influential parameters, then critical speeds and responses.

    Parameters
    ----------
    found
        One scene.
    settings
        The labels.
    parameters, results
        Numbers of them at most.
    """
    design = found.design
    first = [
        ParallelAxis(
            label=parameter_label(design.parameters[k].name, settings), values=design.values[:, k],
            choices=design.parameters[k].choices, logarithmic=design.parameters[k].logarithmic,
            result=False,
        )
        for k in shown_parameters(found)[:parameters]
        if design.values.size and np.ptp(design.values[:, k]) > 0.0
    ]  # fmt: skip
    # a result that few cases have would hide the others
    common = [q for q in found.quantities if np.isfinite(q.values).mean() >= 0.5]
    second = [
        ParallelAxis(
            label=settings.labels.get(q.name, q.label), values=q.values, choices=(),
            logarithmic=False, result=True,
        )
        for q in common[:results]
    ]  # fmt: skip
    return (*first, *second)


@styled
def draw_parallel(found: SweepAnalysis, settings: SweepPictureSettings, path: Path) -> None:
    """Draw parallel coordinates to a picture file.

    Parameters
    ----------
    found, settings
        One scene and the labels.
    path
        The file; replaced when complete.
    """
    axes_of = parallel_axes(found, settings, _PARAMETERS, _RESULTS)
    results = [k for k, a in enumerate(axes_of) if a.result]
    key = results[0] if results else 0
    figure = new_figure(path, TWO_COLUMNS_MM, 100.0)
    axes = figure.add_subplot()
    heights = np.array([a.places(a.values) for a in axes_of])
    shown = _draw_lines(axes, heights, axes_of[key].values)
    _draw_left_out(axes, found, axes_of, settings)
    said = [_draw_axis(axes, place, one) for place, one in enumerate(axes_of)]
    axes.set_xlim(-0.25, len(axes_of) - 0.5)
    axes.set_ylim(-0.06, 1.06)
    said = [_with_unit_whole(label) for label in said]
    labels = [wrapped(label, 12 if len(axes_of) > 7 else 17) for label in said]
    axes.set_xticks(range(len(labels)), labels, fontsize=6.0 if len(axes_of) > 7 else SMALL_PT)
    axes.set_yticks([])
    axes.tick_params(axis="x", length=0)
    for edge in axes.spines.values():
        edge.set_visible(False)
    figure.colorbar(shown, ax=axes, label=axes_of[key].label, pad=0.01, aspect=35)
    write_title(figure, f"All cases: {found.design.scene}, {cases_text(found)}")
    lost = int((~np.isfinite(heights)).any(axis=0).sum())
    notes = [f"cases that lack a result: {lost}, their lines are broken there"] if lost else []
    if found.design.left_out:
        notes.append("dashed: cases left out, parameters alone")
    write_notes(figure, notes)
    write_figure(figure, path)


def _draw_lines(axes: Axes, heights: FloatArray, colors: FloatArray) -> Any:
    """One line for each case in the colour of its result; the rare colours on top."""
    from matplotlib.collections import LineCollection

    steps = np.arange(len(heights))
    order = np.argsort(np.nan_to_num(np.abs(colors - np.nanmedian(colors))), kind="stable")
    segments = [np.column_stack([steps, heights[:, k]]) for k in order]
    count = len(segments)
    lines = LineCollection(segments, cmap="cividis", array=colors[order],
                           linewidths=1.2 if count <= 60 else 0.7,
                           alpha=0.9 if count <= 60 else 0.6)  # fmt: skip
    axes.add_collection(lines)
    return lines


def _draw_left_out(
    axes: Axes,
    found: SweepAnalysis,
    axes_of: tuple[ParallelAxis, ...],
    settings: SweepPictureSettings,
) -> None:
    """Dashed lines over the parameters alone; outside the axes where no case was done."""
    design = found.design
    parameters = [a for a in axes_of if not a.result]
    columns = [
        next(k for k, p in enumerate(design.parameters)
             if parameter_label(p.name, settings) == a.label)
        for a in parameters
    ]  # fmt: skip
    for values in design.left_out_values:
        own = values[columns]
        heights = [float(a.places(own[[k]])[0]) for k, a in enumerate(parameters)]
        axes.plot(range(len(heights)), np.clip(heights, -0.05, 1.05), color="black", linewidth=1.1,
                  linestyle=(0, (4, 3)), zorder=3)  # fmt: skip


def _draw_axis(axes: Axes, place: int, one: ParallelAxis) -> str:
    """A vertical line with its numbers or words; returns its label."""
    from matplotlib.patheffects import withStroke

    axes.axvline(place, color="black", linewidth=1.2 if one.result else 0.7, zorder=3.5)
    label = one.label
    if one.choices:
        ticks = np.arange(len(one.choices), dtype=np.float64)
        texts = list(one.choices)
    else:
        ticks = _ticks(one)
        if one.logarithmic:
            texts = [number_text(v, 5) for v in ticks]
        elif label.endswith("[rpm]"):
            texts = [thousands(v) for v in ticks]
        else:
            scale, label = in_powers_of_ten(label, float(np.nanmax(np.abs(one.values))))
            texts = [f"{v / scale:.5g}" for v in ticks]
    for height, text in zip(one.places(ticks), texts, strict=True):
        axes.plot([place - 0.02, place + 0.02], [height, height], color="black", linewidth=0.9,
                  zorder=3.6)  # fmt: skip
        axes.annotate(text, (place, height), xytext=(4, 0), textcoords="offset points",
                      va="center", fontsize=SMALL_PT, zorder=4,
                      path_effects=[withStroke(linewidth=2.0, foreground="white")])  # fmt: skip
    return label


def _with_unit_whole(label: str) -> str:
    """A label whose unit is not broken over lines."""
    name, bracket, unit = label.partition(" [")
    return name + bracket + unit.replace(" ", "\u00a0")


def _ticks(one: ParallelAxis) -> FloatArray:
    """Round numbers within the range, its ends where there are fewer than two."""
    from matplotlib.ticker import Locator, LogLocator, MaxNLocator

    known = one.values[np.isfinite(one.values)]
    low, high = float(known.min()), float(known.max())
    locators: list[Locator] = [MaxNLocator(5)]
    if one.logarithmic:
        locators.insert(0, LogLocator(subs=(1.0, 2.0, 5.0)))
    for locator in locators:
        found = np.array(locator.tick_values(low, high), dtype=np.float64)
        slack = 1e-9 * (high - low)
        within = found[(found >= low - slack) & (found <= high + slack)]
        if within.size > 1:
            return within
    return np.array([low, high])


def parallel_page(found: SweepAnalysis, settings: SweepPictureSettings) -> str:
    """Return parallel coordinates as a page: ranges are chosen by dragging along the axes.

    Parameters
    ----------
    found, settings
        One scene and the labels.

    Returns
    -------
    str
        HTML with the drawing library inside; cases that lack a result of an axis are left out
        and counted.
    """
    from plotly.io import to_html
    from plotly.offline import get_plotlyjs

    axes_of = parallel_axes(found, settings, _PAGE, _PAGE)
    whole = np.isfinite([a.values for a in axes_of]).all(axis=0)
    results = [a for a in axes_of if a.result] or list(axes_of)
    trace = {
        "type": "parcoords",
        "dimensions": [_dimension(a, whole) for a in axes_of],
        "line": {
            "color": results[0].values[whole].tolist(),
            "colorscale": "Cividis",
            "showscale": True,
            "colorbar": {"title": {"text": escape(results[0].label)}},
        },
        "labelangle": -12,
        "labelside": "top",
    }
    layout = {"height": 620, "margin": {"t": 130, "l": 90, "r": 60}, "font": {"size": 13},
              "template": None}  # fmt: skip
    lost = int((~whole).sum())
    said = [cases_text(found), *([f"{lost} without all results are not drawn"] if lost else [])]
    title = escape(f"All cases: {found.design.scene}")
    part = to_html({"data": [trace], "layout": layout}, full_html=False, include_plotlyjs=False,
                   validate=True, config={"displaylogo": False, "responsive": True})  # fmt: skip
    notes = "".join(f"<li>{escape(n)}</li>" for n in found.notes)
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        f"<style>{_STYLE}</style>\n<script>{get_plotlyjs()}</script></head><body>\n"
        f"<h1>{title}</h1>\n<p>{escape('; '.join(said))}. Drag along an axis to choose a range, "
        f"double-click to take it back, drag a name to move its axis.</p>\n{part}\n"
        f"<ul>{notes}</ul>\n</body></html>\n"
    )


def _dimension(one: ParallelAxis, whole: Any) -> dict[str, Any]:
    values = one.values[whole]
    named = {"label": escape(one.label)}
    if one.choices:
        return {**named, "values": values.tolist(), "tickvals": list(range(len(one.choices))),
                "ticktext": [escape(c) for c in one.choices]}  # fmt: skip
    if one.logarithmic:
        ticks = _ticks(one)
        return {**named, "values": np.log10(values).tolist(), "tickvals": np.log10(ticks).tolist(),
                "ticktext": [f"{v:.4g}" for v in ticks]}  # fmt: skip
    return {**named, "values": values.tolist()}
