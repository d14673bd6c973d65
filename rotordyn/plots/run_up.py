"""Charts of a run-up: speeds and forces over time, spectra, and normalised responses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.plots.frame import number_text
from solidwhirl.rotordyn.run_up.force_spectrum import Spectrogram

# Columns of an envelope, of a line, and lines of a spectrum that is drawn.
_COLUMNS, _FEW, _LINES = 900, 200, 3000
# Height of the tallest spectrum of a waterfall over the height that all take.
_TALLEST = 0.48


def envelope(
    time_s: FloatArray, values: FloatArray, columns: int = _COLUMNS
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return times, lowest and highest values of pieces of a signal that reach each other.

    `time_s`, `values`: shape (t,). `columns`: number of pieces at most. Returns the middle of each
    piece, and the least and the largest value from its first point to the first of the next piece.
    """
    edges = np.unique(
        np.linspace(0, time_s.size - 1, min(columns, time_s.size - 1) + 1).astype(int)
    )
    low = np.minimum(np.minimum.reduceat(values, edges[:-1]), values[edges[1:]])
    high = np.maximum(np.maximum.reduceat(values, edges[:-1]), values[edges[1:]])
    return 0.5 * (time_s[edges[:-1]] + time_s[edges[1:]]), low, high


def _swell(time_s: FloatArray, values: FloatArray, name: str, number: int) -> charts.Fill:
    times, low, high = envelope(time_s, values)
    look = charts.Look(charts.series_look(number).color, "solid", width=0.7)
    return charts.Fill(x=times, low=low, high=high, name=name, look=look)


def speed_chart(
    time_s: FloatArray, speed_rad_s: FloatArray, ratios: Mapping[str, float]
) -> charts.Chart:
    """Return the speeds of all spools over the time, with their signs.

    `time_s`, `speed_rad_s`: Ω over the time, shape (t,). `ratios`: speed ratio by body.
    """
    signed: dict[float, list[str]] = {}
    for name, ratio in ratios.items():
        if ratio != 0:
            signed.setdefault(ratio, []).append(name)
    curves = [
        charts.Curve(
            x=time_s,
            y=ratio * speed_rad_s * RPM_PER_RAD_S,
            name=f"speed of {', '.join(names)}",
            look=replace(charts.series_look(number), mark=""),
        )
        for number, (ratio, names) in enumerate(signed.items())
    ]
    return charts.Chart(
        name="speeds", title="Speeds", x=_time(time_s), y=charts.Axis(label="speed", unit="rpm"),
        parts=curves, height_px=240,
    )  # fmt: skip


def force_chart(
    time_s: FloatArray, force_n: FloatArray, bearing: str, speed_rad_s: FloatArray | None = None
) -> charts.Chart:
    """Return the force through a bearing over the time as envelopes along x and y.

    `time_s`: shape (t,). `force_n`: along x and y, shape (2 or more, t). `bearing`: its name.
    `speed_rad_s`: Ω, drawn over an axis at the right; None draws none.
    """
    unit, factor = charts.metric(float(np.abs(force_n[:2]).max()), "N")
    parts: list[charts.Part] = [
        charts.Toggle(
            label=f"along {axis}",
            marks=[_swell(time_s, factor * force_n[k], f"force along {axis}", k)],
            is_shown=axis == "x",
        )
        for k, axis in enumerate("xy")
    ]
    if speed_rad_s is not None:
        parts.append(charts.Toggle(label="speed", marks=[_speed(time_s, speed_rad_s)]))
    return charts.Chart(
        name="mount",
        title=f"Force through {bearing}",
        caption="Envelope of the force in time: every column reaches from the least to the largest "
        "value in it. It swells where the speed passes a resonance. Broken line: speed.",
        alt=f"Force through {bearing} over the time.",
        x=_time(time_s),
        y=charts.Axis(label=f"force on {bearing}", unit=unit, digits=".4g"),
        right=None if speed_rad_s is None else _speed_axis(speed_rad_s),
        parts=parts,
        height_px=400,
    )


def motion_chart(
    time_s: FloatArray, moved_m: FloatArray, places: Sequence[str], speed_rad_s: FloatArray
) -> charts.Chart:
    """Return the motion along x of some places over the time as envelopes.

    `time_s`, `speed_rad_s`: shape (t,). `moved_m`: displacements, shape (p, t). `places`: p names.
    """
    unit, factor = charts.metric(float(np.abs(moved_m).max(initial=0.0)), "m")
    fills = [
        _swell(time_s, factor * own, f"{place}, along x", k)
        for k, (place, own) in enumerate(zip(places, moved_m, strict=True))
    ]
    return charts.Chart(
        name="motion",
        title="Displacement during the run-up",
        caption="Envelope of the displacement along x of the observed places. Broken line: speed.",
        alt=f"Displacement of {', '.join(places)} over the time.",
        x=_time(time_s),
        y=charts.Axis(label="displacement along x", unit=unit, digits=".4g"),
        right=_speed_axis(speed_rad_s),
        parts=[*fills, _speed(time_s, speed_rad_s)],
        height_px=380,
    )


def spectrum_chart(
    hertz: FloatArray, force_n: FloatArray, peaks: Sequence[tuple[float, float]]
) -> charts.Chart:
    """Return the spectrum of a force over the whole record.

    `hertz`, `force_n`: above zero, shape (f,). `peaks`: frequency in Hz and height in N of peaks to
    mark.
    """
    unit, factor = charts.metric(float(force_n.max()), "N")
    x, height = _thinned(hertz, factor * force_n)
    low, high = max(1e-7 * float(height.max()), 0.5 * float(height.min())), float(height.max())
    line = replace(charts.series_look(0), mark="", width=1.2)
    marks: list[charts.Mark] = [
        charts.Curve(x=x, y=np.maximum(height, low), name="force along x", look=line)
    ]
    if peaks:
        at, tall = np.array(peaks).T
        ring = charts.Look(charts.series_look(1).color, "", "circle-open", 10)
        marks.append(charts.Curve(x=at, y=factor * tall, name="peaks", look=ring))
    return charts.Chart(
        name="spectrum",
        title="Spectrum of the force",
        caption="Amplitudes of the force along x over the whole record (Hann window). While the "
        "speed changes a line is smeared over the frequencies that it passes.",
        alt=f"Spectrum of the force; peaks at {', '.join(f'{p[0]:.4g}' for p in peaks)} Hz.",
        x=charts.Axis(label="frequency", unit="Hz", low=0.0, high=float(hertz[-1])),
        y=charts.Axis(
            label="amplitude", unit=unit, low=low, high=2.0 * high, is_log=True, digits=".4g"
        ),
        parts=marks,
        height_px=380,
    )


def spectrogram_chart(
    pieces: Spectrogram,
    time_s: FloatArray,
    speed_rad_s: FloatArray,
    ratios: Mapping[str, float],
    top_hz: float,
) -> charts.Chart:
    """Return short-time spectra of a force with the lines of all spools.

    `pieces`: of a force in N. `time_s`, `speed_rad_s`: Ω over the time, shape (t,). `ratios`: speed
    ratio by body. `top_hz`: end of the frequency axis.
    """
    shown = pieces.frequency_hz <= top_hz
    part = pieces.amplitude[shown]
    unit, factor = charts.metric(float(part.max()), "N")
    heat = charts.Heat(x=pieces.time_s, y=pieces.frequency_hz[shown], values=factor * part,
                label="amplitude of the force", unit=unit)  # fmt: skip
    times, _, turns = envelope(time_s, np.abs(speed_rad_s) * charts.HZ_PER_RAD_S, _FEW)
    look = replace(charts.WHITE, width=1.2)
    lines: list[charts.Mark] = []
    for ratio, names in charts.same_ratios(ratios).items():
        y, text = ratio * turns, f"1/rev of {', '.join(names)}"
        lines.append(
            charts.Curve(x=times, y=np.where(y <= top_hz, y, np.nan), name=text, look=look)
        )
        lines.append(
            charts.Label(x=float(times[-1]), y=min(float(y[-1]), top_hz), text=text, side="right")
        )
    return charts.Chart(
        name="spectrogram",
        title="Spectrogram of the force",
        caption="Short-time spectra of the force along x. White broken lines: once per turn of "
        "each shaft. Bright bars that stay at one frequency are the engine's own.",
        alt="Spectrogram of the force over time and frequency.",
        x=charts.Axis(label="time", unit="s", low=float(pieces.time_s[0]),
                      high=float(pieces.time_s[-1]), digits=".3g"),
        y=charts.Axis(label="frequency", unit="Hz", low=0.0, high=top_hz, digits=".4g"),
        parts=[heat, charts.Toggle(label="lines of the shafts", marks=lines)],
        height_px=440,
        has_legend=False,
    )  # fmt: skip


def waterfall_chart(pieces: Spectrogram, turns_hz: FloatArray) -> charts.Chart:
    """Return spectra of a force one behind the other while the engine runs up.

    `pieces`: of a force in N, s of them. `turns_hz`: |Ω| / 2π at each, shape (s,).
    """
    times, height = pieces.time_s, pieces.amplitude.T
    reach = float(np.ptp(times)) or 1.0
    rise = _TALLEST * reach / (float(height.max()) or 1.0)
    ends = float(pieces.frequency_hz[0]), float(pieces.frequency_hz[-1])
    look = replace(charts.series_look(1), dash="dash", mark="")
    return charts.Chart(
        name="run-up-waterfall",
        title="Spectra of the force during the run-up",
        x=charts.Axis(label="frequency", unit="Hz", low=ends[0], high=ends[1]),
        y=charts.Axis(label="time", unit="s", low=float(times[0]) - 0.02 * reach,
               high=float((times + rise * height.max(axis=1)).max())),
        parts=[
            charts.Ridges(x=pieces.frequency_hz, y=times, values=height, label="force", unit="N",
                   rise=rise),
            charts.Curve(x=turns_hz, y=times, name="1/rev of the reference shaft", look=look),
        ],
        notes=[f"spectra rise by {number_text(1.0 / rise)} N for 1 s"],
    )  # fmt: skip


def normalised_chart(hertz: FloatArray, responses: Mapping[str, FloatArray]) -> charts.Chart:
    """Return force per excitation force over the frequency.

    `hertz`: shape (f,). `responses`: ratios (f,) by the name of the model, or of the body whose
    order is shown.
    """
    curves = []
    for number, (name, ratio) in enumerate(responses.items()):
        known = np.isfinite(ratio) & (ratio > 0)
        look = replace(charts.series_look(number), mark="")
        curves.append(charts.Curve(x=hertz[known], y=ratio[known], name=name, look=look))
    top = max((float(curve.x.max(initial=0.0)) for curve in curves), default=0.0)
    return charts.Chart(
        name="normalised",
        title="Normalised response",
        x=charts.Axis(label="frequency", unit="Hz", low=0.0, high=top or float(hertz[-1])),
        y=charts.Axis(label="force per excitation force", unit="N/N", is_log=True),
        parts=curves,
        has_legend=len(responses) > 1,
    )


def _time(time_s: FloatArray) -> charts.Axis:
    return charts.Axis(label="time", unit="s", low=0.0, high=float(time_s[-1]), digits=".4g")


def _speed_axis(speed_rad_s: FloatArray) -> charts.Axis:
    top = 1.05 * RPM_PER_RAD_S * float(speed_rad_s.max())
    return charts.Axis(
        label=charts.SPEED_LABEL, unit="rpm", low=0.0, high=max(top, 1.0), digits=",.0f"
    )


def _speed(time_s: FloatArray, speed_rad_s: FloatArray) -> charts.Curve:
    times, _, rpm = envelope(time_s, speed_rad_s * RPM_PER_RAD_S, _FEW)
    look = replace(charts.series_look(6), dash="dash", mark="")
    return charts.Curve(x=times, y=rpm, name="speed (right axis)", look=look, on_right=True)


def _thinned(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """At most some points, of every piece the highest."""
    if x.size <= _LINES:
        return x, y
    edges = np.unique(np.linspace(0, x.size, _LINES + 1).astype(int))
    kept = np.array([a + int(y[a:b].argmax()) for a, b in pairwise(edges)])
    return x[kept], y[kept]
