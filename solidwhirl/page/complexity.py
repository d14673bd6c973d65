"""Models of less complexity in a run-up of a page, and what they miss."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from solidwhirl.page.records import Chart, Table
from solidwhirl.page.traces import Trace, axis, numbers, series_style, slug


def complexity_chart(name: str, entry: Mapping[str, Any]) -> Chart:
    """Return errors of simpler models by band of frequency.

    Parameters
    ----------
    name
        Of the analysis.
    entry
        `complexity` of its part of `results.json`.
    """
    bands = [f"{low:g} to {high:g} Hz" for low, high in entry["bands_hz"]]
    traces: list[Trace] = []
    shapes = ("", "/", "x", ".", "\\", "+", "-")
    for k, model in enumerate(entry["models"][1:]):
        values = 100.0 * numbers(model["response_error_by_band"])
        color = series_style(k).color
        traces.append(
            {
                "type": "bar",
                "x": ["largest force", *bands],
                "y": np.concatenate([[100.0 * numbers(model["peak_force_error"])], values]),
                "name": model["name"],
                "marker": {
                    "color": color,
                    "pattern": {
                        "shape": shapes[k % len(shapes)],
                        "fillmode": "overlay",
                        "fgcolor": "@paper",
                    },
                },
                "hovertemplate": f"<b>{model['name']}</b><br>%{{x}}<br>%{{y:.4g}} %<extra></extra>",
            }
        )
    return Chart(
        name=f"complexity-{slug(name)}",
        title=f"What simpler models miss ({name})",
        caption="Difference from the model with all modes: of the largest force, and of the "
        "normalised response by band of frequency." + beyond(entry) + _stopped(entry),
        alt="Bars of the errors of simpler models; the table has the numbers.",
        traces=traces,
        layout={
            "xaxis": axis("quantity", type="category"),
            "yaxis": axis("difference from all modes [%]"),
            "barmode": "group",
        },
        height_px=360,
    )


def beyond(found: Mapping[str, Any]) -> str:
    """Return a sentence on the bands that reach beyond what is excited; empty without any.

    Parameters
    ----------
    found
        As `entry` in `complexity_chart`.
    """
    top = found["excited_to_hz"]
    cut = [f"{low:g} to {high:g} Hz" for low, high in found["bands_hz"] if high > top]
    if not cut:
        return ""
    return (
        f" Nothing is excited above {top:.5g} Hz: the {'bands' if len(cut) > 1 else 'band'} "
        f"{', '.join(cut)} {'are' if len(cut) > 1 else 'is'} compared up to there only."
    )


def _stopped(found: Mapping[str, Any]) -> str:
    """A sentence on the models that diverged; empty without any."""
    said = ", ".join(
        f"{m['name']} at {m['speed_rpm']:.6g} rpm, {m['amplitude_m']:.3g} m"
        for m in found.get("diverged", ())
    )
    return f" Diverged, stopped and not compared: {said}." if said else ""


def complexity_table(found: Mapping[str, Any]) -> Table:
    """Return forces and errors of the models in numbers.

    Parameters
    ----------
    found
        As `entry` in `complexity_chart`.
    """
    return Table(
        head=[
            "model",
            "coordinates",
            "largest force [N]",
            "its difference [%]",
            *[f"{low:g} to {high:g} Hz [%]" for low, high in found["bands_hz"]],
            "time [s]",
        ],
        rows=[
            [
                m["name"],
                m["coordinates"],
                m["peak_force_n"],
                _hundredfold(m["peak_force_error"]),
                *[_hundredfold(e) for e in m["response_error_by_band"]],
                f"{m['wall_time_s']:.3g}",
            ]
            for m in found["models"]
        ],
    )


def _hundredfold(value: float | None) -> str | None:
    return None if value is None else f"{100.0 * value:.3g}"
