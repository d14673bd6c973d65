"""Critical speeds of a sweep against its parameters."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from solidwhirl.rotordyn.core.arrays import IntArray
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.plots.chart import Axis, Chart, Choice, Curve, Label, Look, Mark, Option
from solidwhirl.rotordyn.plots.frame import number_text
from solidwhirl.sweep.analysis import SweepAnalysis, SweepPictureSettings
from solidwhirl.sweep.design import SweepDesign
from solidwhirl.sweep.sensitivity import ladder
from solidwhirl.sweep.tracks import CriticalTrack
from solidwhirl.sweep_pictures import parts

# Parameters that have a frame of their own.
_FRAMES = 6
# Numbers of tracks closer than this share of the frame stand together.
_LEVELS = 40.0
# Relative errors that can be seen.
_VISIBLE = 1e-3
_OTHER_WHIRL = Look("@c3", "dashdot", "triangle-up")
_LEFT_OUT = Look("@ink", "", "x-thin", 10.0)


def critical_speeds_chart(found: SweepAnalysis, settings: SweepPictureSettings) -> Chart:
    """Return critical speeds against each of the first parameters.

    Of a grid the cases through the baseline are joined, samples are points.
    """
    design, order = found.design, parts.shown_parameters(found)
    every = np.concatenate([t.speed_rpm for t in found.tracks] + [settings.operating_rpm or ()])
    low, high = float(np.nanmin(every)), float(np.nanmax(every))
    room = 0.06 * ((high - low) or high)
    y = Axis(
        label="critical speed of the reference shaft", unit="rpm", low=low - room, high=high + room
    )
    options = []
    for k in order[:_FRAMES]:
        x, scale = parts.parameter_axis(found, settings, k)
        marks = [mark for t in found.tracks for mark in _track(design, t, k, scale)]
        marks += _numbers(found, k, scale, high - low)
        if design.left_out:
            places = design.left_out_values[:, k] / scale
            edge = np.full(places.size, low - room)
            marks.append(Curve(x=places, y=edge, name="case left out", look=_LEFT_OUT))
        options.append(Option(label="", marks=marks, x=x))
    title = f"Critical speeds: {design.scene}, {parts.cases_text(found)}"
    if design.kind == "one_at_a_time" and len(design.parameters) > 1:
        title += "; each parameter alone, the others at the baseline"
    left = [design.parameters[k].name for k in order[_FRAMES:]]
    notes = [f"not shown: {', '.join(left)}"] if left else []
    largest = float(np.nanmax([t.error_estimate for t in found.tracks], initial=0.0))
    if 0.0 < largest <= _VISIBLE:
        said = number_text(largest, 2)
        notes.append(f"estimated errors of up to {said} of the speed are too small to be drawn")
    elif largest:
        notes.append("bars: estimated errors")
    return Chart(
        name="critical-speeds",
        title=title,
        x=Axis(label=""),
        y=y,
        parts=[
            *parts.operating_span(settings, "y"),
            Choice(label="parameter", options=options, on_paper="each"),
        ],
        notes=[*notes, *found.notes],
    )


def _track(
    design: SweepDesign, track: CriticalTrack, parameter: int, scale: float
) -> Iterator[Mark]:
    joined, rows = design.kind == "one_at_a_time", _shown_rows(design, parameter)
    x, speed = design.values[rows, parameter] / scale, track.speed_rpm[rows]
    if not np.isfinite(speed).any():
        return
    look = charts.WHIRL_LOOKS.get(track.whirl, _OTHER_WHIRL)
    if not joined:
        look = replace(look, color=f"{look.color}/0.7", size=max(3.4, 6.9 - 0.017 * len(rows)))
    if not joined or design.parameters[parameter].choices:
        look = replace(look, dash="")
    errors = track.error_estimate[rows]
    seen = float(np.nanmax(errors, initial=0.0)) > _VISIBLE
    yield Curve(x=x, y=speed, name=track.whirl, look=look, errors=errors * speed if seen else None,
                errors_along="y")  # fmt: skip
    doubtful = track.doubtful[rows] & np.isfinite(speed)
    if doubtful.any():
        yield Curve(x=x[doubtful], y=speed[doubtful], name="matched ambiguously", look=charts.RING)


def _shown_rows(design: SweepDesign, parameter: int) -> IntArray:
    if design.kind == "one_at_a_time":
        return ladder(design, parameter)
    return np.arange(len(design.rows))


def _numbers(found: SweepAnalysis, parameter: int, scale: float, span: float) -> Iterator[Label]:
    """Numbers where the tracks end, those of coinciding ones together."""
    rows = _shown_rows(found.design, parameter)
    x = found.design.values[rows, parameter]
    ends: dict[tuple[float, int], list[tuple[int, float]]] = {}
    for track in found.tracks:
        known = np.flatnonzero(np.isfinite(track.speed_rpm[rows]))
        if known.size:
            last = known[np.argmax(x[known])]
            speed = float(track.speed_rpm[rows][last])
            place = float(x[last]), round(_LEVELS * speed / (span or 1.0))
            ends.setdefault(place, []).append((track.number, speed))
    for (end, _), same in ends.items():
        text = ", ".join(str(number) for number, _ in same)
        height = float(np.mean([speed for _, speed in same]))
        yield Label(x=end / scale, y=height, text=text, side="right")
