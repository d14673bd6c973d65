"""Steady responses of a page: unbalance, forces in the bearings, orbits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from solidwhirl.operating import Operating
from solidwhirl.page.operating import operating_bands, operating_speeds
from solidwhirl.page.orbits import orbit_chart
from solidwhirl.page.records import Chart, Choice, Option, Run, Section, Table, Toggle
from solidwhirl.page.traces import (
    SPEED_AXIS,
    FloatArray,
    Trace,
    analyses_of_kind,
    axis,
    line,
    marks,
    metric,
    numbers,
    percent,
    series_style,
    slug,
    speed_axes,
)

# Curves shown at the start; the others can be switched on in the legend.
_SHOWN = 8
# Part of the largest amplitude below which an amplitude is rounding.
_ROUNDING = 1e-9
_LEFT_OUT = "What is below 1e-9 of the largest is rounding, and not drawn."


def section(run: Run) -> Section | None:
    """Return the unbalance responses; None where the scene has none."""
    document = run.document
    found = analyses_of_kind(document, "unbalance_response")
    if not found:
        return None
    operating = operating_speeds(document, run.results.scene.speed_ratios())
    asked = {a.label: a for a in run.results.scene.analyses}
    blocks: list[Any] = []
    for name, entry in found.items():
        wanted = getattr(asked.get(name), "orbits_at_rpm", ()) or ()
        blocks += response_blocks(name, entry, operating, wanted)
    return Section(
        name="unbalance",
        title="Unbalance response",
        blocks=blocks,
        note="Steady motion and bearing forces while the shafts turn with the unbalances of the "
        "scene.",
    )


def response_blocks(
    name: str,
    entry: Mapping[str, Any],
    operating: tuple[Operating, ...] = (),
    orbits_at_rpm: Sequence[float] = (),
) -> list[Any]:
    """Return everything about one unbalance response.

    Parameters
    ----------
    name
        Of the analysis.
    entry
        Its part of `results.json`.
    operating
        Operating speeds to mark.
    orbits_at_rpm
        Speeds whose orbits are wanted beside those at the peaks.
    """
    blocks: list[Any] = [
        _unbalances(name, entry),
        amplitude_chart(name, entry, operating),
        phase_chart(name, entry),
    ]
    if any(e["bearing_force_n"] for e in entry["exciters"]):
        blocks.append(force_chart(name, entry, operating))
    orbits = orbit_chart(name, entry, orbits_at_rpm)
    if orbits is not None:
        blocks.append(orbits)
    peaks = _peak_table(name, entry)
    return [*blocks, peaks] if peaks.rows else blocks


def _unbalances(name: str, entry: Mapping[str, Any]) -> Table:
    return Table(
        title=f"Unbalances ({name})",
        head=["at", "mass times distance [kg m]", "angle [°]"],
        rows=[
            [u["at"], float(u["moment_kg_m"]), float(u["phase_deg"])] for u in entry["unbalances"]
        ],
    )


def _by_exciter(entry: Mapping[str, Any], counts: Sequence[int], start: int) -> list[Choice]:
    """A list of the exciters, where there are several.

    `counts` traces belong to each exciter from `start` on.
    """
    if len(entry["exciters"]) < 2:
        return []
    options, at = [], start
    for exciter, count in zip(entry["exciters"], counts, strict=True):
        options.append(
            Option(
                label="unbalance of "
                + ", ".join(exciter["bodies"])
                + f" ({exciter['frequency_ratio']:.4g}×)",
                traces=list(range(at, at + count)),
            )
        )
        at += count
    return [Choice(label="excited by", options=options)]


def moving(curves: Mapping[str, Any]) -> dict[str, FloatArray]:
    """Return what is more than rounding of curves of one excitation; the rest of them is nan.

    Parameters
    ----------
    curves
        Amplitudes by name, shape (s,) each.

    Returns
    -------
    dict
        Without the curves that are rounding all along.
    """
    values = {name: numbers(curve) for name, curve in curves.items()}
    largest = max((float(np.nanmax(v, initial=0.0)) for v in values.values()), default=0.0)
    kept = {name: np.where(v > _ROUNDING * largest, v, np.nan) for name, v in values.items()}
    return {name: v for name, v in kept.items() if np.isfinite(v).any()}


def _extent(curves: Sequence[FloatArray], unit: str) -> tuple[str, float, float, float]:
    """Unit with a prefix, the factor to it, and the least and the largest value in it."""
    largest = max((float(np.nanmax(c)) for c in curves), default=1.0)
    prefixed, factor = metric(largest, unit)
    least = min((float(np.nanmin(c)) for c in curves), default=1.0)
    return prefixed, factor, factor * least, factor * largest


def amplitude_chart(
    name: str, entry: Mapping[str, Any], operating: tuple[Operating, ...] = ()
) -> Chart:
    """Return the largest displacement over the speed; arguments as `response_blocks`."""
    rpm = numbers(entry["speed_rpm"])
    majors = [
        m
        for e in entry["exciters"]
        for m in moving({k: p["major_m"] for k, p in e["places"].items()}).values()
    ]
    unit, factor, low, high = _extent(majors, "m")
    traces: list[Trace] = operating_bands(operating, low, high)
    start, counts = len(traces), []
    for exciter in entry["exciters"]:
        before = len(traces)
        major = moving({place: m["major_m"] for place, m in exciter["places"].items()})
        for k, (place, motion) in enumerate(exciter["places"].items()):
            if place in major:
                shown = {**motion, "major_m": major[place]}
                traces.append(_amplitude_line(rpm, exciter, place, shown, factor, unit, k))
        for k, (place, peaks) in enumerate(exciter["peaks"].items()):
            if peaks and place in major:
                traces.append(_peak_marks(place, peaks, factor, unit, k))
        counts.append(len(traces) - before)
    return Chart(
        name=f"amplitude-{slug(name)}",
        title=f"Displacement ({name})",
        caption="Major semi-axis of the orbit at each place over the speed. Rings mark the "
        "resonance peaks; their amplification factor is that of API 617 from the half-power "
        f"points. {_LEFT_OUT}",
        alt=f"Displacement at {', '.join(entry['exciters'][0]['places'])} over the speed up to "
        f"{rpm.max():g} rpm; the table of peaks has the numbers.",
        traces=traces,
        layout=speed_axes(rpm, f"largest displacement [{unit}]", low, high),
        height_px=460,
        controls=_controls(entry, counts, start, high),
    )


def _controls(
    entry: Mapping[str, Any], counts: Sequence[int], start: int, high: float
) -> list[Choice | Toggle]:
    """The exciter, the operating speeds where there are any before `start`, and the scale."""
    controls: list[Choice | Toggle] = [*_by_exciter(entry, counts, start)]
    if start:
        controls.append(Toggle(label="operating speeds", traces=list(range(start))))
    linear = {"yaxis.type": "linear", "yaxis.range": [0.0, 1.05 * high]}
    options = [
        Option(label="logarithmic", traces=()),
        Option(label="linear", traces=(), layout=linear),
    ]
    return [*controls, Choice(label="scale", options=options)]


def _amplitude_line(
    rpm: FloatArray,
    exciter: Mapping[str, Any],
    place: str,
    motion: Mapping[str, Any],
    factor: float,
    unit: str,
    number: int,
) -> Trace:
    hertz = numbers(exciter["frequency_hz"])
    texts = [
        f"{f:.5g} Hz, {orbit}, minor semi-axis {factor * m:.4g} {unit}"
        for f, orbit, m in zip(hertz, motion["orbit"], numbers(motion["minor_m"]), strict=True)
    ]
    return line(
        rpm,
        factor * numbers(motion["major_m"]),
        place,
        series_style(number),
        text=texts,
        hovertemplate=f"<b>{place}</b><br>%{{x:,.1f}} rpm<br>%{{y:.4g}} {unit}<br>%{{text}}"
        "<extra></extra>",
        visible=True if number < _SHOWN else "legendonly",
    )


def _peak_marks(
    place: str, peaks: Sequence[Mapping[str, Any]], factor: float, unit: str, number: int
) -> Trace:
    texts = []
    for p in peaks:
        words = [f"{p['frequency_hz']:.6g} Hz"]
        if p["amplification"] is not None:
            words.append(f"amplification factor {p['amplification']:.3g}")
        if p.get("frequency_error_estimate") is not None:
            words.append(f"error of the speed {percent(p['frequency_error_estimate'])}")
        texts.append("<br>".join(words))
    ring = series_style(number)._replace(symbol="circle-open")
    return marks(
        [p["speed_rpm"] for p in peaks],
        factor * numbers([p["amplitude_m"] for p in peaks]),
        f"peaks at {place}",
        ring,
        12,
        text=texts,
        hovertemplate=f"<b>peak at {place}</b><br>%{{x:,.1f}} rpm<br>%{{y:.4g}} {unit}<br>"
        "%{text}<extra></extra>",
        showlegend=False,
        visible=True if number < _SHOWN else "legendonly",
    )


def phase_chart(name: str, entry: Mapping[str, Any]) -> Chart:
    """Return the phase of the displacement over the speed; arguments as `response_blocks`."""
    rpm = numbers(entry["speed_rpm"])
    traces: list[Trace] = []
    counts = []
    for exciter in entry["exciters"]:
        before = len(traces)
        for direction in "xy":
            key = f"amplitude_{direction}_m"
            amplitude = moving({place: m[key] for place, m in exciter["places"].items()})
            for k, (place, motion) in enumerate(exciter["places"].items()):
                phase = numbers(motion[f"phase_{direction}_deg"])
                if place not in amplitude:
                    continue
                phase = np.where(np.isfinite(amplitude[place]), phase, np.nan)
                traces.append(
                    line(
                        *_unwrapped(rpm, phase),
                        f"{place}, along {direction}",
                        series_style(k)._replace(dash="solid" if direction == "x" else "dot"),
                        hovertemplate=f"<b>{place}</b> along {direction}<br>%{{x:,.1f}} rpm<br>"
                        "%{y:.1f}°<extra></extra>",
                        visible=True if k < _SHOWN else "legendonly",
                    )
                )
        counts.append(len(traces) - before)
    return Chart(
        name=f"phase-{slug(name)}",
        title=f"Phase ({name})",
        caption="Phase of the displacement against the unbalance at angle zero: along x full "
        "lines, along y dotted. It turns by 180° where a resonance is passed. Lines are cut where "
        "they leave ±180°.",
        alt="Phase of the displacement along x and y over the speed.",
        traces=traces,
        layout={
            "xaxis": axis(SPEED_AXIS, range=[float(rpm.min()), float(rpm.max())]),
            "yaxis": axis("phase [°]", range=[-185.0, 185.0], tickmode="linear", tick0=0, dtick=90),
        },
        height_px=360,
        controls=_by_exciter(entry, counts, 0),
    )


def _unwrapped(x: FloatArray, phase: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points with a gap where the phase jumps from one end of its range to the other."""
    jumps = np.flatnonzero(np.abs(np.diff(phase)) > 180.0) + 1
    return np.insert(x, jumps, np.nan), np.insert(phase, jumps, np.nan)


def force_chart(
    name: str, entry: Mapping[str, Any], operating: tuple[Operating, ...] = ()
) -> Chart:
    """Return the largest lateral force in each bearing; arguments as `response_blocks`."""
    rpm = numbers(entry["speed_rpm"])
    forces = [f for e in entry["exciters"] for f in moving(e["bearing_force_n"]).values()]
    unit, factor, low, high = _extent(forces, "N")
    traces: list[Trace] = operating_bands(operating, low, high)
    start, counts = len(traces), []
    for exciter in entry["exciters"]:
        before = len(traces)
        strained = moving(exciter["bearing_force_n"])
        for k, bearing in enumerate(exciter["bearing_force_n"]):
            if bearing not in strained:
                continue
            traces.append(
                line(
                    rpm,
                    factor * strained[bearing],
                    bearing,
                    series_style(k),
                    hovertemplate=f"<b>{bearing}</b><br>%{{x:,.1f}} rpm<br>%{{y:.4g}} {unit}"
                    "<extra></extra>",
                    visible=True if k < _SHOWN else "legendonly",
                )
            )
        counts.append(len(traces) - before)
    return Chart(
        name=f"forces-{slug(name)}",
        title=f"Bearing forces ({name})",
        caption="Largest lateral force through each bearing over the speed: the major semi-axis "
        f"of the ellipse that the force draws. {_LEFT_OUT}",
        alt=f"Forces through the bearings up to {high:.4g} {unit}.",
        traces=traces,
        layout=speed_axes(rpm, f"largest lateral force [{unit}]", low, high),
        height_px=420,
        controls=_controls(entry, counts, start, high),
    )


def _peak_table(name: str, entry: Mapping[str, Any]) -> Table:
    rows = []
    for exciter in entry["exciters"]:
        for place, peaks in exciter["peaks"].items():
            for p in peaks:
                rows.append(
                    [
                        place,
                        ", ".join(exciter["bodies"]),
                        f"{p['speed_rpm']:.1f}",
                        f"{p['frequency_hz']:.5g}",
                        p["amplitude_m"],
                        p["amplification"],
                        percent(p.get("frequency_error_estimate")),
                    ]
                )
    return Table(
        head=[
            "place",
            "unbalance of",
            "reference shaft [rpm]",
            "frequency [Hz]",
            "amplitude [m]",
            "amplification factor [1]",
            "estimated error of the speed",
        ],
        rows=rows,
        folded=f"Resonance peaks ({name}, {len(rows)})",
        caption="Without damping a peak has no height; its place is a critical speed.",
    )
