"""Maps of a page: response over frequency and place, speed or bearing stiffness."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.records import Chart, Run, Section, Table
from solidwhirl.page.frame.traces import (
    MAP_COLORS,
    FloatArray,
    Trace,
    analyses_of_kind,
    numbers,
    slug,
)
from solidwhirl.rotordyn.plots.campbell import error_words
from solidwhirl.rotordyn.plots.chart import metric
from solidwhirl.rotordyn.plots.response_maps import ground_chart, place_chart, stiffness_chart

# Amplitudes below this part of the largest are drawn as dark as this.
_DARKEST = 1e-4
# Lines of a waterfall in space, and points of one.
_MOST_LINES, _MOST_POINTS = 41, 800


def section(run: Run) -> Section | None:
    """Return place maps, waterfalls and stiffness studies; None where the scene has none."""
    document = run.document
    blocks: list[Any] = []
    for name, entry in analyses_of_kind(document, "place_map").items():
        blocks += place_blocks(name, entry)
    for name, entry in analyses_of_kind(document, "waterfall").items():
        blocks += waterfall_blocks(name, entry)
    for name, entry in analyses_of_kind(document, "stiffness_study").items():
        blocks.append(stiffness_block(name, entry))
    if not blocks:
        return None
    return Section(
        name="response-maps",
        title="Response maps",
        blocks=blocks,
        note="Where the engine is sensitive: over the place of an unbalance, the motion of the "
        "ground, the stiffness of supports.",
    )


def place_blocks(name: str, entry: Mapping[str, Any]) -> list[Any]:
    """Return charts and peaks of a place map.

    Parameters
    ----------
    name
        Of the analysis.
    entry
        Its part of `results.json`.
    """
    rpm = numbers(entry["speed_rpm"])
    shape = (len(entry["places"]), rpm.size)
    amplitude = numbers(entry["amplitude_m"]).reshape(shape)
    drawn = place_chart(
        entry["places"], rpm, numbers(entry["frequency_hz"]).reshape(shape), amplitude
    )
    caption = (
        f"Displacement (major semi-axis) of {entry['observed']} for {entry['moment_kg_m']:g} kg m "
        f"at each place. Most sensitive: {entry['most_sensitive_place']}."
    )
    chart = page_chart(replace(drawn, caption=caption), name)
    return [chart, *_place_peaks(name, entry)]


def _place_peaks(name: str, entry: Mapping[str, Any]) -> list[Table]:
    rows = [
        [
            place,
            f"{p['speed_rpm']:.1f}",
            f"{p['frequency_hz']:.5g}",
            p["amplitude_m"],
            p["amplification"],
            error_words(p.get("frequency_error_estimate")),
        ]
        for place, peaks in entry["peaks"].items()
        for p in peaks
    ]
    if not rows:
        return []
    return [
        Table(
            head=[
                "unbalance at",
                "reference shaft [rpm]",
                "frequency [Hz]",
                "amplitude [m]",
                "amplification factor [1]",
                "estimated error of the speed",
            ],
            rows=rows,
            folded=f"Peaks ({name}, {len(rows)})",
        )
    ]


def waterfall_blocks(name: str, entry: Mapping[str, Any]) -> list[Any]:
    """Return map and lines in space of the response to ground motion; see `place_blocks`."""
    rpm, hertz = numbers(entry["speed_rpm"]), numbers(entry["frequency_hz"])
    amplitude = numbers(entry["highest_m"]).reshape(rpm.size, hertz.size)
    unit, factor = metric(float(np.nanmax(amplitude, initial=0.0)), "m")
    values = factor * amplitude
    peaks = [(p["frequency_hz"], p["speed_rpm"], p["amplitude_m"]) for p in entry["peaks"]]
    ground = f"{entry['ground_amplitude_m']:g} m of the ground along {entry['direction']}"
    drawn = replace(
        ground_chart(hertz, rpm, amplitude, peaks),
        caption=f"Absolute displacement of {entry['observed']} for {ground}, over the frequency of "
        "the ground and the speed, the highest in each step of frequency. Rings mark the highest "
        "peaks.",
        alt=f"Map of the response of {entry['observed']} over frequency and speed.",
    )
    flat = page_chart(drawn, name)
    space = Chart(
        name=f"waterfall-{slug(name)}",
        title=f"Waterfall ({name})",
        caption="The same as lines in space, one for each speed. Turn it with the mouse or finger.",
        alt=f"Waterfall of the response of {entry['observed']} over frequency and speed.",
        traces=[_ridges(hertz, rpm, values, unit)],
        layout={
            "scene": {
                "xaxis": {"title": {"text": "frequency [Hz]"}},
                "yaxis": {"title": {"text": "speed [rpm]"}},
                "zaxis": {"title": {"text": f"displacement [{unit}]"}},
                "aspectratio": {"x": 1.6, "y": 1.2, "z": 0.7},
                "camera": {"eye": {"x": -1.3, "y": -1.9, "z": 0.9}, "center": {"z": -0.15}},
            },
            "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
            "showlegend": False,
        },
        height_px=460,
    )
    return [flat, space]


def _ridges(hertz: FloatArray, rpm: FloatArray, values: FloatArray, unit: str) -> Trace:
    """Lines over the frequency, one for each of some speeds; between points the highest is kept."""
    rows = np.unique(np.linspace(0, rpm.size - 1, min(rpm.size, _MOST_LINES)).astype(int))
    edges = np.unique(np.linspace(0, hertz.size, min(hertz.size, _MOST_POINTS) + 1).astype(int))
    kept = np.array(
        [
            [low + int(values[row, low:high].argmax()) for low, high in pairwise(edges)]
            for row in rows
        ]
    )
    gap = np.full((rows.size, 1), np.nan)
    z = np.take_along_axis(values[rows], kept, axis=1)
    y = np.repeat(rpm[rows, None], kept.shape[1], axis=1)

    def joined(part: FloatArray) -> FloatArray:
        return np.asarray(np.hstack([part, gap]).ravel()[:-1])

    return {
        "type": "scatter3d",
        "mode": "lines",
        "x": joined(hertz[kept]),
        "y": joined(y),
        "z": joined(z),
        "line": {
            "color": np.log10(
                np.maximum(joined(np.nan_to_num(z)), _DARKEST * max(values.max(), 1e-300))
            ),
            "colorscale": MAP_COLORS,
            "width": 3,
        },
        "hovertemplate": f"%{{x:.4g}} Hz, %{{y:,.0f}} rpm<br>%{{z:.4g}} {unit}<extra></extra>",
        "connectgaps": False,
        "name": "response",
    }


def stiffness_block(name: str, entry: Mapping[str, Any]) -> Chart:
    """Return the map of a stiffness study with the chosen stiffness; see `place_blocks`."""
    stiffness, hertz = numbers(entry["stiffness_n_per_m"]), numbers(entry["frequency_hz"])
    amplitude = numbers(entry["highest_m"]).reshape(stiffness.size, hertz.size)
    chosen = entry["chosen_stiffness_n_per_m"]
    operating = entry["operating_speed_rpm"] / 60.0
    band = ((1.0 - entry["margin"]) * operating, (1.0 + entry["margin"]) * operating)
    where = f"{entry['observed']} for {entry['moment_kg_m']:g} kg m at {entry['excited']}"
    text = (
        f"Displacement of {where} over frequency, the highest in each step, and the stiffness of "
        f"{', '.join(entry['bearings'])}. White: the stiffness with the smallest response within "
        f"±{100 * entry['margin']:g} % of {entry['operating_speed_rpm']:g} rpm (dashed), and that "
        f"band (dotted). It is {chosen:.4g} N/m."
    )
    if entry["choice_is_at_the_end_of_the_range"]:
        text += " It lies at the end of the range: a better one may lie outside."
    drawn = replace(
        stiffness_chart(hertz, stiffness, amplitude, (chosen, band)),
        caption=text,
        alt=f"Map of the response over frequency and stiffness; chosen {chosen:.4g} N/m.",
    )
    return page_chart(drawn, name)
