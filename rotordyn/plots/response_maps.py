"""Charts of response maps: place of the unbalance, ground motion, support stiffness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from solidwhirl.rotordyn.assembly.parts import End
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.plots.chart import (
    HZ_PER_RAD_S,
    WHITE,
    Axis,
    Chart,
    Choice,
    Curve,
    Heat,
    Look,
    Mark,
    Option,
    metric,
    series_look,
    size_axis,
    speed_axis,
)
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts
from solidwhirl.rotordyn.response.maps import GroundMotionMap, PlaceMap, StepPeaks, shown_range
from solidwhirl.rotordyn.response.stiffness_maps import StiffnessChoice, StiffnessMap


def brightest(values: FloatArray) -> float:
    """Return where the colours of a map of responses end."""
    return shown_range(values)[1] if np.any(values > 0.0) else np.inf


def place_chart(
    places: Sequence[str], speed_rpm: FloatArray, hertz: FloatArray, amplitude_m: FloatArray
) -> Chart:
    """Return the response to an unbalance at one place after the other, as curves and as a map.

    Parameters
    ----------
    places
        p of them.
    speed_rpm
        Of the reference shaft, rising, shape (s,).
    hertz, amplitude_m
        Frequency of the unbalance and largest displacement, shape (p, s).
    """
    unit, factor = metric(float(np.nanmax(amplitude_m, initial=0.0)), "m")
    every = factor * amplitude_m
    positive = every[every > 0.0] if np.any(every > 0.0) else np.ones(1)
    curves = [
        Curve(
            x=speed_rpm,
            y=np.where(values > 0.0, values, np.nan),
            name=place,
            look=replace(series_look(k), mark=""),
            texts=[f"unbalance at {place}, {f:.5g} Hz" for f in hertz[k]],
        )
        for k, (place, values) in enumerate(zip(places, every, strict=True))
    ]
    rows = Axis(label="unbalance at", places=places, low=-0.5, high=len(places) - 0.5)
    heat = Heat(
        x=speed_rpm,
        y=np.arange(float(len(places))),
        values=every,
        label="displacement",
        unit=unit,
        brightest=brightest(every),
    )
    options = [
        Option(label="curves", marks=curves),
        Option(label="map", marks=[heat], y=rows),
    ]
    return Chart(
        name="places",
        title="Unbalance at one place after the other",
        alt=f"Response to an unbalance at {', '.join(places)} over the speed; the table of peaks "
        "has the numbers.",
        x=replace(speed_axis(float(speed_rpm.min()), float(speed_rpm.max())), digits=",.1f"),
        y=size_axis("largest displacement", unit, float(positive.min()), float(positive.max())),
        parts=[Choice(label="drawn as", options=options, on_paper="each")],
        height_px=440,
    )


def ground_chart(
    hertz: FloatArray,
    speed_rpm: FloatArray,
    highest_m: FloatArray,
    peaks: Sequence[tuple[float, float, float]] = (),
) -> Chart:
    """Return the response to ground motion over frequency and speed.

    Parameters
    ----------
    hertz, speed_rpm
        Rising, shapes (f,) and (s,).
    highest_m
        Major semi-axis, the highest in each step of frequency, shape (s, f).
    peaks
        Frequency in Hz, speed in rpm and height in m of peaks to mark.
    """
    unit, factor = metric(float(np.nanmax(highest_m, initial=0.0)), "m")
    values = factor * highest_m
    ends = float(hertz[0]), float(hertz[-1])
    speeds = speed_axis(float(speed_rpm[0]), float(speed_rpm[-1]))
    turn = np.array([max(60.0 * ends[0], speeds.low or 0.0), min(60.0 * ends[1], speed_rpm[-1])])
    marks: list[Mark] = [
        Heat(
            x=hertz, y=speed_rpm, values=values, label="displacement", unit=unit,
            brightest=brightest(values),
        )
    ]  # fmt: skip
    if turn[0] < turn[1]:
        name = "1/rev of the reference shaft"
        marks.append(Curve(x=turn / 60.0, y=turn, name=name, look=WHITE))
    if peaks:
        x, y, height = zip(*peaks, strict=True)
        texts = [f"peak {factor * h:.4g} {unit}" for h in height]
        ring = Look("#ffffff", "", "circle-open", 11)
        marks.append(Curve(x=np.array(x), y=np.array(y), look=ring, texts=texts))
    return Chart(
        name="ground",
        title="Response to ground motion",
        x=Axis(label="frequency of the ground", unit="Hz", low=ends[0], high=ends[1]),
        y=speeds,
        parts=marks,
        height_px=440,
    )


def stiffness_chart(
    hertz: FloatArray,
    stiffness_n_per_m: FloatArray,
    highest_m: FloatArray,
    chosen: tuple[float, tuple[float, float]] | None = None,
) -> Chart:
    """Return the response over frequency and support stiffness (design of experiments).

    Parameters
    ----------
    hertz, stiffness_n_per_m
        Rising, shapes (f,) and (k,).
    highest_m
        Major semi-axis, the highest in each step of frequency, shape (k, f).
    chosen
        Stiffness to mark, N/m, and the ends of its band, Hz; None marks nothing.
    """
    unit, factor = metric(float(np.nanmax(highest_m, initial=0.0)), "m")
    values = factor * highest_m
    ends = float(stiffness_n_per_m[0]), float(stiffness_n_per_m[-1])
    marks: list[Mark] = [
        Heat(
            x=hertz, y=stiffness_n_per_m, values=values, label="displacement", unit=unit,
            brightest=brightest(values),
        )
    ]  # fmt: skip
    if chosen is not None:
        value, (low, high) = chosen
        name = "band around the operating speed"
        marks += [
            Curve(x=hertz[[0, -1]], y=np.array([value, value]), name="chosen stiffness",
                  look=WHITE),
            Curve(x=np.array([low, low, np.nan, high, high]), y=np.array([*ends, np.nan, *ends]),
                  name=name, look=replace(WHITE, dash="dot")),
        ]  # fmt: skip
    return Chart(
        name="stiffness",
        title="Response over bearing stiffness",
        x=Axis(label="frequency of the force", unit="Hz", low=float(hertz[0]),
               high=float(hertz[-1])),
        y=Axis(label="stiffness of the bearings", unit="N/m", low=ends[0], high=ends[1],
               is_log=True, digits=".4g"),
        parts=marks,
        height_px=460,
    )  # fmt: skip


def draw_place_map(place_map: PlaceMap, node: End, path: str | Path, title: str) -> None:
    """Draw the response of a node over the speed and the place of the unbalance.

    Arguments `path` and `title`, and the error of a wrong suffix, as in `draw_campbell`.

    Parameters
    ----------
    place_map
        The map, at rising speeds.
    node
        Where the response is shown.

    Raises
    ------
    AnalysisError
        If the map does not have the node.
    """
    if node not in place_map.nodes:
        known = [other.label for other in place_map.nodes]
        raise AnalysisError(f"the map has no node {node.label}; it has {known}")
    chart = place_chart(
        [place.label for place in place_map.places],
        place_map.speeds_rad_s * RPM_PER_RAD_S,
        place_map.frequencies_rad_s * HZ_PER_RAD_S,
        place_map.major_m()[:, :, place_map.nodes.index(node)],
    )
    draw_charts([chart], path, f"{title}: displacement of {node.label}")


def draw_ground_motion(
    ground_map: GroundMotionMap, path: str | Path, title: str, peaks: StepPeaks | None = None
) -> None:
    """Draw the response to ground motion over frequency and speed (waterfall diagram).

    Arguments `path` and `title`, and the error of a wrong suffix, as in `draw_campbell`.

    Parameters
    ----------
    ground_map
        The map, at rising speeds and frequencies. A line marks the frequency of the reference
        shaft's turn.
    peaks
        Of `ground_motion_peaks`: the highest response in each step is shown. None shows that at
        the frequencies of the map, which may miss sharp resonances.

    Raises
    ------
    AnalysisError
        If the amplitude of the ground is zero.
    """
    if ground_map.amplitude_m == 0:
        raise AnalysisError("amplitude_m of the map is 0; there is no motion to compare with")
    chart = ground_chart(
        ground_map.frequencies_rad_s * HZ_PER_RAD_S,
        ground_map.speeds_rad_s * RPM_PER_RAD_S,
        ground_map.major_m() if peaks is None else peaks.height_m,
    )
    moved = f"{abs(ground_map.amplitude_m):.3g} m of the ground along {ground_map.direction}"
    draw_charts([chart], path, f"{title}: displacement of {ground_map.node.label} for {moved}")


def draw_stiffness_map(
    stiffness_map: StiffnessMap,
    path: str | Path,
    title: str,
    choice: StiffnessChoice | None = None,
    peaks: StepPeaks | None = None,
) -> None:
    """Draw the response over frequency and support stiffness (design of experiments).

    Arguments `path` and `title`, and the error of a wrong suffix, as in `draw_campbell`.

    Parameters
    ----------
    stiffness_map
        The map, at rising frequencies and stiffness.
    choice
        Its band and stiffness are marked; None marks nothing.
    peaks
        Of `stiffness_map_peaks`, as in `draw_ground_motion`.
    """
    chosen = None
    if choice is not None:
        low, high = (edge * HZ_PER_RAD_S for edge in choice.band_rad_s)
        chosen = choice.stiffness_n_per_m, (low, high)
    chart = stiffness_chart(
        stiffness_map.frequencies_rad_s * HZ_PER_RAD_S,
        stiffness_map.stiffness_n_per_m,
        stiffness_map.major_m() if peaks is None else peaks.height_m,
        chosen,
    )
    label = f"stiffness of {', '.join(stiffness_map.bearings)}"
    chart = replace(chart, y=replace(chart.y, label=label))
    draw_charts([chart], path, f"{title}: displacement of {stiffness_map.node.label}")
