"""Charts of response maps: place of the unbalance, ground motion, support stiffness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.response.maps import shown_range

# Lines of a waterfall in space.
_RIDGES = 41


def _heat(x: FloatArray, y: FloatArray, sizes_m: FloatArray) -> tuple[charts.Heat, float]:
    """A map of displacements, and the factor from metres to its unit."""
    unit, factor = charts.metric(float(np.nanmax(sizes_m, initial=0.0)), "m")
    values = factor * sizes_m
    brightest = shown_range(values)[1] if np.any(values > 0.0) else np.inf
    heat = charts.Heat(
        x=x, y=y, values=values, label="displacement", unit=unit, brightest=brightest
    )
    return heat, factor


def place_chart(
    places: Sequence[str], speed_rpm: FloatArray, hertz: FloatArray, amplitude_m: FloatArray
) -> charts.Chart:
    """Return the response to an unbalance at one place after the other, as curves and as a map.

    `places`: p of them. `speed_rpm`: of the reference shaft, rising, shape (s,). `hertz`,
    `amplitude_m`: frequency of the unbalance and largest displacement, shape (p, s).
    """
    heat, _ = _heat(speed_rpm, np.arange(float(len(places))), amplitude_m)
    every, unit = heat.values, heat.unit
    positive = every[every > 0.0] if np.any(every > 0.0) else np.ones(1)
    curves = [
        charts.Curve(
            x=speed_rpm,
            y=np.where(values > 0.0, values, np.nan),
            name=place,
            look=replace(charts.series_look(k), mark=""),
            texts=[f"unbalance at {place}, {f:.5g} Hz" for f in hertz[k]],
        )
        for k, (place, values) in enumerate(zip(places, every, strict=True))
    ]
    rows = charts.Axis(label="unbalance at", places=places, low=-0.5, high=len(places) - 0.5)
    options = [
        charts.Option(label="curves", marks=curves),
        charts.Option(label="map", marks=[heat], y=rows),
    ]
    return charts.Chart(
        name="places",
        title="Unbalance at one place after the other",
        alt=f"Response to an unbalance at {', '.join(places)} over the speed; the table of peaks "
        "has the numbers.",
        x=replace(charts.speed_axis(float(speed_rpm.min()), float(speed_rpm.max())), digits=",.1f"),
        y=charts.size_axis(
            "largest displacement", unit, float(positive.min()), float(positive.max())
        ),
        parts=[charts.Choice(label="drawn as", options=options, on_paper="each")],
        height_px=440,
    )


def ground_chart(
    hertz: FloatArray,
    speed_rpm: FloatArray,
    highest_m: FloatArray,
    peaks: Sequence[tuple[float, float, float]] = (),
) -> charts.Chart:
    """Return the response to ground motion over frequency and speed.

    `hertz`, `speed_rpm`: rising, shapes (f,) and (s,). `highest_m`: major semi-axis, the highest in
    each step of frequency, shape (s, f). `peaks`: frequency in Hz, speed in rpm and height in m of
    peaks to mark.
    """
    heat, factor = _heat(hertz, speed_rpm, highest_m)
    ends = float(hertz[0]), float(hertz[-1])
    speeds = charts.speed_axis(float(speed_rpm[0]), float(speed_rpm[-1]))
    turn = _turn_line(hertz, speed_rpm, 1.0, "1/rev of the reference shaft")
    marks: list[charts.Mark] = [heat, *turn]
    if peaks:
        x, y, height = zip(*peaks, strict=True)
        texts = [f"peak {factor * h:.4g} {heat.unit}" for h in height]
        ring = charts.Look("#ffffff", "", "circle-open", 11)
        marks.append(charts.Curve(x=np.array(x), y=np.array(y), look=ring, texts=texts))
    return charts.Chart(
        name="ground",
        title="Response to ground motion",
        x=charts.Axis(label="frequency of the ground", unit="Hz", low=ends[0], high=ends[1]),
        y=speeds,
        parts=marks,
        height_px=440,
    )


def with_sidebands(
    chart: charts.Chart, hertz: FloatArray, speed_rpm: FloatArray, twice: float
) -> charts.Chart:
    """Return the chart of a response to ground motion for engines with asymmetric bodies.

    `chart`: of `ground_chart`, with its frequencies and speeds. `twice`: twice the speed of the
    bodies over that of the reference shaft.
    """
    line = _turn_line(hertz, speed_rpm, twice, "2/rev of the asymmetric bodies")
    dotted = [replace(curve, look=replace(curve.look, dash="dot")) for curve in line]
    return replace(
        chart, x=replace(chart.x, label="frequency of the motion"), parts=[*chart.parts, *dotted]
    )


def _turn_line(
    hertz: FloatArray, speed_rpm: FloatArray, multiple: float, name: str
) -> list[charts.Curve]:
    """The frequency of a multiple of the speed, where it is inside a map."""
    rate = multiple / 60.0
    low = max(float(hertz[0]) / rate, float(speed_rpm[0]))
    high = min(float(hertz[-1]) / rate, float(speed_rpm[-1]))
    turn = np.array([low, high])
    return [charts.Curve(x=rate * turn, y=turn, name=name, look=charts.WHITE)] if low < high else []


def stiffness_chart(
    hertz: FloatArray,
    stiffness_n_per_m: FloatArray,
    highest_m: FloatArray,
    chosen: tuple[float, tuple[float, float]] | None = None,
) -> charts.Chart:
    """Return the response over frequency and support stiffness (design of experiments).

    `hertz`, `stiffness_n_per_m`: rising, shapes (f,) and (k,). `highest_m`: major semi-axis, the
    highest in each step of frequency, shape (k, f). `chosen`: stiffness to mark, N/m, and the ends
    of its band, Hz; None marks nothing.
    """
    ends = float(stiffness_n_per_m[0]), float(stiffness_n_per_m[-1])
    marks: list[charts.Mark] = [_heat(hertz, stiffness_n_per_m, highest_m)[0]]
    if chosen is not None:
        value, (low, high) = chosen
        name = "band around the operating speed"
        marks += [
            charts.Curve(x=hertz[[0, -1]], y=np.array([value, value]), name="chosen stiffness",
                         look=charts.WHITE),
            charts.Curve(x=np.array([low, low, np.nan, high, high]),
                         y=np.array([*ends, np.nan, *ends]), name=name,
                         look=replace(charts.WHITE, dash="dot")),
        ]  # fmt: skip
    return charts.Chart(
        name="stiffness",
        title="Response over bearing stiffness",
        x=charts.Axis(label="frequency of the force", unit="Hz", low=float(hertz[0]),
               high=float(hertz[-1])),
        y=charts.Axis(label="stiffness of the bearings", unit="N/m", low=ends[0], high=ends[1],
               is_log=True, digits=".4g"),
        parts=marks,
        height_px=460,
    )  # fmt: skip


def ridge_chart(hertz: FloatArray, speed_rpm: FloatArray, highest_m: FloatArray) -> charts.Chart:
    """Return the same as `ground_chart` as lines in space, one for each of some speeds."""
    heat, _ = _heat(hertz, speed_rpm, highest_m)
    rows = np.unique(np.linspace(0, speed_rpm.size - 1, min(speed_rpm.size, _RIDGES)).astype(int))
    values = heat.values[rows]
    rise = 0.5 * float(np.ptp(speed_rpm)) / (float(values.max()) or 1.0)
    return charts.Chart(
        name="waterfall",
        title="Waterfall",
        caption="The same as lines in space, one for each speed. Turn it with the mouse or finger.",
        x=charts.Axis(label="frequency", unit="Hz", digits=".4g"),
        y=charts.Axis(label="speed", unit="rpm", digits=",.0f"),
        parts=[
            charts.Ridges(x=hertz, y=speed_rpm[rows], values=values, label="displacement",
                          unit=heat.unit, rise=rise)
        ],
        height_px=460,
        has_legend=False,
    )  # fmt: skip
