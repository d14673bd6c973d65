"""Maps of a page: response over frequency and place, speed or bearing stiffness."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from solidwhirl.page.records import Chart, Choice, Option, Run, Section, Table
from solidwhirl.page.traces import (
    MAP_COLORS,
    SPEED_AXIS,
    FloatArray,
    Trace,
    analyses_of_kind,
    axis,
    line,
    log_axis,
    marks,
    metric,
    numbers,
    percent,
    series_style,
    slug,
    speed_axes,
)
from solidwhirl.rotordyn.response_maps import shown_range

# Amplitudes below this part of the largest are drawn as dark as this.
_DARKEST = 1e-4
# Cells of a map.
_COLUMNS, _ROWS = 600, 200
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
        blocks.append(stiffness_chart(name, entry))
    if not blocks:
        return None
    return Section(
        name="response-maps",
        title="Response maps",
        blocks=blocks,
        note="Where the engine is sensitive: over the place of an unbalance, the motion of the "
        "ground, the stiffness of supports.",
    )


def heat(
    x: FloatArray, y: Any, values: FloatArray, label: str, hover: str, brightest: float = np.inf
) -> Trace:
    """Return a map of values over four decades at most, by the logarithm of the value.

    Parameters
    ----------
    x, y
        Along the axes, shapes (n,) and (m,).
    values
        Shape (m, n); not below zero.
    label
        Of the scale of colours, with its unit.
    hover
        Template of what is shown at a point; ``%{customdata}`` is the value.
    brightest
        Value from which on colours are the same.
    """
    x, y, values = _coarser(x, y, values)
    largest = min(float(np.nanmax(values, initial=0.0)), brightest)
    low = _DARKEST * largest if largest > 0.0 else 1.0
    top = np.log10(largest) if largest > 0.0 else 1.0
    ticks = np.arange(np.ceil(np.log10(low)), np.floor(top) + 1.0)
    return {
        "type": "heatmap",
        "x": x,
        "y": y,
        "z": np.log10(np.maximum(values, low)),
        "customdata": np.asarray(values, dtype=float),
        "zmin": float(np.log10(low)),
        "zmax": float(top),
        "colorscale": MAP_COLORS,
        "zsmooth": False,
        "hovertemplate": hover + "<extra></extra>",
        "colorbar": {
            "title": {"text": label, "side": "right"},
            "thickness": 12,
            "tickvals": [float(t) for t in ticks],
            "ticktext": [f"{10.0**t:g}" for t in ticks],
        },
    }


def _brightest(values: FloatArray) -> float:
    """Where colours of a map of responses end."""
    return shown_range(values)[1] if np.any(values > 0.0) else np.inf


def _coarser(x: FloatArray, y: Any, values: FloatArray) -> tuple[FloatArray, Any, FloatArray]:
    """A map with some columns and rows at most, each cell the largest of those that it covers."""
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


def place_blocks(name: str, entry: Mapping[str, Any]) -> list[Any]:
    """Return charts and peaks of a place map.

    Parameters
    ----------
    name
        Of the analysis.
    entry
        Its part of `results.json`.
    """
    places = list(entry["places"])
    rpm = numbers(entry["speed_rpm"])
    amplitude = numbers(entry["amplitude_m"]).reshape(len(places), -1)
    unit, factor = metric(float(np.nanmax(amplitude, initial=0.0)), "m")
    hertz = numbers(entry["frequency_hz"]).reshape(amplitude.shape)
    every = factor * amplitude
    traces: list[Trace] = []
    for k, place in enumerate(places):
        values = every[k]
        traces.append(
            line(
                rpm,
                np.where(values > 0.0, values, np.nan),
                place,
                series_style(k),
                text=[f"{f:.5g} Hz" for f in hertz[k]],
                hovertemplate=f"<b>unbalance at {place}</b><br>%{{x:,.1f}} rpm, %{{text}}<br>"
                f"%{{y:.4g}} {unit}<extra></extra>",
            )
        )
    positive = every[every > 0.0] if amplitude.any() else np.ones(1)
    low, high = float(positive.min()), float(positive.max())
    single = len(traces)
    traces.append(
        heat(
            rpm,
            places,
            every,
            f"displacement [{unit}]",
            f"<b>unbalance at %{{y}}</b><br>%{{x:,.1f}} rpm<br>%{{customdata:.4g}} {unit}",
            _brightest(every),
        )
    )
    where = entry["observed"]
    chart = Chart(
        name=f"places-{slug(name)}",
        title=f"Unbalance at one place after the other ({name})",
        caption=f"Displacement (major semi-axis) of {where} for {entry['moment_kg_m']:g} kg m at "
        f"each place. Most sensitive: {entry['most_sensitive_place']}.",
        alt=f"Response to an unbalance at {', '.join(places)} over the speed; the table of peaks "
        "has the numbers.",
        traces=traces,
        layout=speed_axes(rpm, f"largest displacement [{unit}]", low, high),
        height_px=440,
        controls=[
            Choice(
                label="drawn as",
                options=[
                    Option(label="curves", traces=list(range(single))),
                    Option(
                        label="map",
                        traces=[single],
                        layout={
                            "yaxis.type": "category",
                            "yaxis.title.text": "unbalance at",
                            "yaxis.range": [-0.5, len(places) - 0.5],
                            "yaxis.dtick": 1,
                        },
                    ),
                ],
            )
        ],
    )
    return [chart, *_place_peaks(name, entry)]


def _place_peaks(name: str, entry: Mapping[str, Any]) -> list[Table]:
    rows = [
        [
            place,
            f"{p['speed_rpm']:.1f}",
            f"{p['frequency_hz']:.5g}",
            p["amplitude_m"],
            p["amplification"],
            percent(p.get("frequency_error_estimate")),
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
    hover = f"%{{x:.4g}} Hz, %{{y:,.0f}} rpm<br><b>%{{customdata:.4g}} {unit}</b>"
    traces = [heat(hertz, rpm, values, f"displacement [{unit}]", hover, _brightest(values))]
    if entry["peaks"]:
        traces.append(_map_peaks(entry["peaks"], factor, unit))
    ground = f"{entry['ground_amplitude_m']:g} m of the ground along {entry['direction']}"
    flat = Chart(
        name=f"ground-{slug(name)}",
        title=f"Response to ground motion ({name})",
        caption=f"Absolute displacement of {entry['observed']} for {ground}, over the frequency of "
        "the ground and the speed, the highest in each step of frequency. Rings mark the highest "
        "peaks.",
        alt=f"Map of the response of {entry['observed']} over frequency and speed.",
        traces=traces,
        layout={
            "xaxis": axis(
                "frequency of the ground [Hz]", range=[float(hertz[0]), float(hertz[-1])]
            ),
            "yaxis": axis(SPEED_AXIS, range=[float(rpm[0]), float(rpm[-1])]),
        },
        height_px=440,
    )
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


def _map_peaks(peaks: Sequence[Mapping[str, Any]], factor: float, unit: str) -> Trace:
    ring = series_style(0)._replace(color="#ffffff", symbol="circle-open")
    return marks(
        [p["frequency_hz"] for p in peaks],
        [p["speed_rpm"] for p in peaks],
        "peaks",
        ring,
        11,
        text=[f"{factor * p['amplitude_m']:.4g} {unit}" for p in peaks],
        hovertemplate="<b>peak %{text}</b><br>%{x:.5g} Hz, %{y:,.0f} rpm<extra></extra>",
        showlegend=False,
    )


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


def stiffness_chart(name: str, entry: Mapping[str, Any]) -> Chart:
    """Return the map of a stiffness study with the chosen stiffness; see `place_blocks`."""
    stiffness, hertz = numbers(entry["stiffness_n_per_m"]), numbers(entry["frequency_hz"])
    amplitude = numbers(entry["highest_m"]).reshape(stiffness.size, hertz.size)
    unit, factor = metric(float(np.nanmax(amplitude, initial=0.0)), "m")
    values = factor * amplitude
    traces = [
        heat(
            hertz,
            stiffness,
            values,
            f"displacement [{unit}]",
            f"%{{x:.4g}} Hz, %{{y:.4g}} N/m<br><b>%{{customdata:.4g}} {unit}</b>",
            _brightest(values),
        )
    ]
    white = series_style(0)._replace(color="#ffffff", dash="dash")
    chosen = entry["chosen_stiffness_n_per_m"]
    operating = entry["operating_speed_rpm"] / 60.0
    low, high = (1.0 - entry["margin"]) * operating, (1.0 + entry["margin"]) * operating
    ends = [float(stiffness[0]), float(stiffness[-1])]
    traces += [
        line(
            [hertz[0], hertz[-1]],
            [chosen, chosen],
            "chosen stiffness",
            white,
            hovertemplate=f"chosen stiffness {chosen:.4g} N/m, at most "
            f"{factor * entry['chosen_amplitude_m']:.4g} {unit} around the operating speed"
            "<extra></extra>",
        ),
        line(
            [low, low, np.nan, high, high],
            [*ends, np.nan, *ends],
            "band around the operating speed",
            white._replace(dash="dot"),
            hovertemplate="%{x:.4g} Hz<extra></extra>",
        ),
    ]
    where = f"{entry['observed']} for {entry['moment_kg_m']:g} kg m at {entry['excited']}"
    text = (
        f"Displacement of {where} over frequency, the highest in each step, and the stiffness of "
        f"{', '.join(entry['bearings'])}. White: the stiffness with the smallest response within "
        f"±{100 * entry['margin']:g} % of {entry['operating_speed_rpm']:g} rpm (dashed), and that "
        f"band (dotted). It is {chosen:.4g} N/m."
    )
    if entry["choice_is_at_the_end_of_the_range"]:
        text += " It lies at the end of the range: a better one may lie outside."
    return Chart(
        name=f"stiffness-{slug(name)}",
        title=f"Response over bearing stiffness ({name})",
        caption=text,
        alt=f"Map of the response over frequency and stiffness; chosen {chosen:.4g} N/m.",
        traces=traces,
        layout={
            "xaxis": axis("frequency of the force [Hz]", range=[float(hertz[0]), float(hertz[-1])]),
            "yaxis": log_axis("stiffness of the bearings [N/m]", *ends),
            "showlegend": False,
        },
        height_px=460,
    )
