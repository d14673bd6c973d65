"""Charts of a lateral analysis of API 617: responses, damping over cross-coupling, screening."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from solidwhirl.core.blocks import margin_words, numbers
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.plots.response import unwrapped
from solidwhirl.rotordyn.standards.api617_lateral import vibration_limit_m
from solidwhirl.rotordyn.standards.api617_stability import LEAST_DECREMENT, region_border

_SPEED = "speed of the shaft itself"
_MICRO = 1e6
# Ends of the screening figure, kg/m³ and critical speed ratio.
_DENSITY, _RATIO = 80.0, 3.5
_LIMIT = charts.Look("@ink", "dash", width=1.0)
_TRIP = charts.Look("@muted", "dashdot", width=1.0)


def response_charts(document: Mapping[str, Any], bearings: str) -> list[charts.Chart]:
    """Return amplitude and phase at the probes over the speed, for each case of unbalance.

    `bearings`: the set of laws.
    """
    cases = document["bearing_cases"][bearings]["cases"]
    several = len(document["bearing_cases"]) > 1
    of_set = f", bearings {bearings}" if several else ""
    number = [*document["bearing_cases"]].index(bearings)
    behind = f"-{number}" if number else ""
    top = max(case["speed_rpm"][-1] for case in cases.values())
    axis = charts.speed_axis(0.0, top, _SPEED)
    limit = _MICRO * vibration_limit_m(document["speeds"]["maximum_continuous_rpm"])
    probes = [own for case in cases.values() for own in case["probes"].values()]
    high = 1.15 * max(limit, *(_MICRO * max(p["peak_to_peak_m"]) for p in probes))
    speeds = _speeds(document)
    amplitude = charts.Chart(
        name=f"api617-amplitude{behind}",
        title=f"Vibration at the probes{of_set}",
        caption="Peak to peak, with the unbalances of the analysis, not scaled. Hatched: operating "
        "speeds. Lines across: the limit of vibration there (dashed), the trip speed (dash and "
        "dot). Rings mark peaks.",
        alt="Peak to peak amplitude at each probe over the speed; the table of peaks has the "
        "numbers.",
        x=axis,
        y=charts.Axis(label="peak to peak", unit="µm", low=0.0, high=high, digits=".4g"),
        parts=[
            *speeds,
            charts.Curve(
                x=np.array([0.0, top]), y=np.array([limit, limit]),
                name=f"limit of vibration, {limit:.3g} µm", look=_LIMIT,
            ),
            _trip(document, high),
            _by_case(cases, _amplitudes),
        ],
        height_px=460,
    )  # fmt: skip
    phase = charts.Chart(
        name=f"api617-phase{behind}",
        title=f"Phase at the probes{of_set}",
        caption="Against the unbalance at angle zero, cut where lines leave ±180°.",
        alt="Phase at each probe over the speed.",
        x=axis,
        y=charts.Axis(label="phase", unit="°", low=-185.0, high=185.0, step=90.0, digits=".1f"),
        parts=[*speeds, _trip(document, 185.0, -185.0), _by_case(cases, _phases)],
        height_px=320,
    )
    return [amplitude, phase]


def _speeds(document: Mapping[str, Any]) -> list[charts.Part]:
    speeds = document["speeds"]
    low, high = speeds["minimum_rpm"], speeds["maximum_continuous_rpm"]
    text = f"{low:g} to {high:g} rpm"
    return [charts.Span(low=low, high=high, name="operating speed", text=text, is_hatched=True)]


def _trip(document: Mapping[str, Any], high: float, low: float = 0.0) -> charts.Curve:
    at = document["speeds"]["trip_rpm"]
    name = f"trip speed, {at:g} rpm"
    return charts.Curve(x=np.array([at, at]), y=np.array([low, high]), name=name, look=_TRIP)


def _by_case(
    cases: Mapping[str, Mapping[str, Any]],
    marks: Callable[[Mapping[str, Any]], list[charts.Mark]],
) -> charts.Choice:
    options = [charts.Option(label=name, marks=marks(case)) for name, case in cases.items()]
    return charts.Choice(label="unbalance", options=options, on_paper="each")


def _amplitudes(case: Mapping[str, Any]) -> list[charts.Mark]:
    rpm = numbers(case["speed_rpm"])
    marks: list[charts.Mark] = []
    for k, (probe, own) in enumerate(case["probes"].items()):
        look = replace(charts.series_look(k), mark="")
        size = _MICRO * numbers(own["peak_to_peak_m"])
        marks.append(charts.Curve(x=rpm, y=size, name=probe, look=look))
        peaks = own["peaks"]
        if peaks:
            marks.append(
                charts.Curve(
                    x=numbers([p["speed_rpm"] for p in peaks]),
                    y=_MICRO * numbers([p["peak_to_peak_m"] for p in peaks]),
                    look=replace(charts.RING, color=look.color),
                    texts=[_peak_text(p) for p in peaks],
                )
            )
    return marks


def _peak_text(peak: Mapping[str, Any]) -> str:
    factor = peak["amplification_factor"]
    said = "undefined" if factor is None else f"{factor:.3g}"
    return f"amplification factor {said}\n{margin_words(peak['margin'])}: {peak['verdict']}"


def _phases(case: Mapping[str, Any]) -> list[charts.Mark]:
    rpm = numbers(case["speed_rpm"])
    marks: list[charts.Mark] = []
    for k, (probe, own) in enumerate(case["probes"].items()):
        x, y = unwrapped(rpm, numbers(own["phase_deg"]))
        look = replace(charts.series_look(k), mark="")
        marks.append(charts.Curve(x=x, y=y, name=probe, look=look))
    return marks


def stability_charts(document: Mapping[str, Any]) -> list[charts.Chart]:
    """Return damping over applied cross-coupling, and the screening if its figures are known."""
    levels = {
        name: found["level_1"]
        for name, found in document["bearing_cases"].items()
        if found["level_1"]
    }
    if not levels:
        return []
    first = next(iter(levels.values()))
    return [_cross_coupling_chart(levels), *_region_charts(first)]


def _cross_coupling_chart(levels: Mapping[str, Mapping[str, Any]]) -> charts.Chart:
    """The damping of the first forward mode over applied cross-coupling, of each set of laws."""
    most = max(level["applied_n_per_m"][-1] for level in levels.values())
    every = [d for level in levels.values() for d in level["log_decrement"]]
    unit, factor = charts.metric(most, "N/m")
    high, low = 1.1 * max(*every, 2.0 * LEAST_DECREMENT), min(*every, 0.0)
    low -= 0.05 * (high - low)
    right = 1.05 * factor * most
    marks: list[charts.Part] = [
        charts.Rule(at=0.0, along="y", look=charts.Look("@muted", "solid", width=1.0)),
        charts.Curve(
            x=np.array([0.0, right]), y=np.full(2, LEAST_DECREMENT),
            name=f"asked for at QA, {LEAST_DECREMENT:g}", look=_LIMIT,
        ),
    ]  # fmt: skip
    for number, (name, level) in enumerate(levels.items()):
        of_set = f", {name}" if len(levels) > 1 else ""
        marks += _damping_curves(level, (unit, factor), number, of_set)
    return charts.Chart(
        name="api617-stability",
        title="Damping over applied cross-coupling",
        caption="Log decrement of the first forward mode at the maximum continuous speed, without "
        "seals, up to ten times the expected cross-coupling QA or the loss of stability Q0. "
        "Circles: at QA; crosses: Q0.",
        alt="Log decrement of the first forward mode over the applied cross-coupled stiffness.",
        x=charts.Axis(label="applied cross-coupling", unit=unit, low=0.0, high=right, digits=".4g"),
        y=charts.Axis(label="log decrement", unit="1", low=low, high=high, digits=".4g"),
        parts=marks,
        height_px=380,
    )


def _damping_curves(
    level: Mapping[str, Any], scale: tuple[str, float], number: int, of_set: str
) -> list[charts.Part]:
    """One set of bearing laws: its curve, its point at QA, and where stability is lost."""
    unit, factor = scale
    look = replace(charts.series_look(number), mark="")
    applied, lost = numbers(level["applied_n_per_m"]), level["lost_at_n_per_m"]
    found: list[charts.Part] = [
        charts.Curve(
            x=factor * applied, y=numbers(level["log_decrement"]),
            name=f"first forward mode{of_set}", look=look,
            texts=[charts.hertz_text(f) for f in level["frequency_hz"]],
        ),
        charts.Curve(
            x=np.array([factor * level["expected_n_per_m"]]),
            y=np.array([level["log_decrement_at_expected"]]),
            name="" if number else f"at QA = {factor * level['expected_n_per_m']:.3g} {unit}",
            look=replace(charts.RING, color=look.color),
        ),
    ]  # fmt: skip
    if lost is not None and 0.0 < lost <= applied.max():
        found.append(
            charts.Curve(
                x=np.array([factor * lost]), y=np.zeros(1),
                name=f"Q0 = {factor * lost:.4g} {unit}{of_set}",
                look=charts.Look(look.color, "", "x", 10.0),
            )
        )  # fmt: skip
    return found


def _region_charts(level: Mapping[str, Any]) -> Sequence[charts.Chart]:
    """Density and critical speed ratio beside the border of region B, if both are known."""
    density, ratio = level["mean_density_kg_per_m3"], level["critical_speed_ratio"]
    if density is None or ratio is None:
        return []
    over = np.linspace(0.0, 60.0, 121)
    right, up = max(_DENSITY, 1.1 * density), max(_RATIO, 1.1 * ratio)
    border = np.array([region_border(float(d)) for d in over])
    line = charts.Curve(
        x=np.append(over, 60.0), y=np.append(border, 0.0), name="border of region B",
        look=charts.Look("@ink", "solid"),
    )  # fmt: skip
    point = charts.Curve(
        x=np.array([density]), y=np.array([ratio]), name="this machine",
        look=charts.Look("@bad" if level["region_b"] else "@c0", "", "circle", 12.0),
    )  # fmt: skip
    return [
        charts.Chart(
            name="api617-region",
            title="Screening by density and critical speed ratio",
            caption="Above or at the right of the line is region B. It is looked at where "
            "stability is lost between 2 and 10 times the expected cross-coupling.",
            alt="Mean density and critical speed ratio beside the border of region B.",
            x=charts.Axis(
                label="mean gas density", unit="kg/m³", low=0.0, high=right, digits=".4g"
            ),
            y=charts.Axis(label="critical speed ratio", unit="1", low=0.0, high=up, digits=".4g"),
            parts=[line, point],
            height_px=340,
        )
    ]
