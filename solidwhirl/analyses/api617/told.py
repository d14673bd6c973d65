"""What a page and its pictures tell of a lateral analysis of API 617."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from solidwhirl.analyses.api617.clauses import figure_text
from solidwhirl.core.blocks import AnalysisBlock, Table, Text, margin_words, numbers
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.plots.campbell import error_words
from solidwhirl.rotordyn.plots.response import unwrapped
from solidwhirl.rotordyn.standards.api617_lateral import vibration_limit_m
from solidwhirl.rotordyn.standards.api617_stability import LEAST_DECREMENT, region_border

_EDITIONS = {"8th": "8th edition", "9th": "9th edition", "legacy": "6th edition"}
_WORDS = {"pass": "Pass", "fail": "FAIL", "undecided": "Undecided"}
_SPEED = "speed of the shaft itself"
_MICRO, _GRAM_MM = 1e6, 1e6
# Ends of the screening figure, kg/m³ and critical speed ratio.
_DENSITY, _RATIO = 80.0, 3.5


def edition_text(edition: str) -> str:
    """Return an edition in words."""
    return _EDITIONS[edition]


def blocks(document: Mapping[str, Any]) -> list[AnalysisBlock]:
    """Return verdict, clauses, responses, stability, ISO, and what is assumed."""
    verdict = document["verdict"]
    speeds = document["speeds"]
    head = (
        f"**{_WORDS[verdict['verdict']]} by API 617, {edition_text(document['edition'])}**, "
        f"{document['shaft']}, {speeds['minimum_rpm']:g} to {speeds['maximum_continuous_rpm']:g} "
        f"rpm, trip {speeds['trip_rpm']:g} rpm: {verdict['why']}."
    )
    found: list[AnalysisBlock] = [
        Text(text=head, kind="plain" if verdict["passed"] else "warning"),
        _clause_table(document),
        _placement_table(document),
    ]
    if document["cases"]:
        found += [*response_charts(document), _peak_table(document)]
    if document["level_1"]:
        found += [cross_coupling_chart(document), *region_charts(document), _stage_table(document)]
    if document["level_2"]:
        found.append(_level_2_table(document))
    found += [_journal_table(document), _iso_table(document)]
    assumed = "\n".join(f"- {line}" for line in document["assumptions"])
    said = "To be checked against the bought standard, as these are of public sources:"
    return [*found, Text(text=f"{said}\n\n{assumed}", kind="note")]


def _clause_table(document: Mapping[str, Any]) -> Table:
    return Table(
        title="Clauses",
        head=["clause", "what", "where", "figure", "asked", "to spare", "error", "verdict", "note"],
        rows=[
            [
                row["clause"],
                row["what"],
                row["where"],
                figure_text(row, "value"),
                figure_text(row, "limit"),
                "–" if row["to_spare"] is None else f"{100.0 * row['to_spare']:.1f} %",
                "–" if row["error_estimate"] is None else error_words(row["error_estimate"]),
                f"**{row['verdict']}**" if row["verdict"] == "fail" else row["verdict"],
                row["note"],
            ]
            for row in document["clauses"]
        ],
        caption="To spare: of margins as a part of the speed, else of the limit. The error is that "
        "of the model's discretisation, where it is known.",
    )


def _placement_table(document: Mapping[str, Any]) -> Table:
    return Table(
        title="Unbalances",
        head=[
            "at",
            "kind",
            "W [kg]",
            "unbalance [g mm]",
            "angle [°]",
            "modes [rpm]",
            "scale factor",
        ],
        rows=[
            [
                u["at"],
                case["kind"],
                f"{u['load_kg']:.4g}",
                f"{_GRAM_MM * u['moment_kg_m']:.4g}",
                f"{u['phase_deg']:.0f}",
                ", ".join(f"{rpm:.0f}" for rpm in case["modes_rpm"]),
                f"{case['scale_factor']:.4g}",
            ]
            for case in document["cases"].values()
            for u in case["unbalances"]
        ],
        caption="One run for each set of unbalances, for the undamped critical speeds whose shapes "
        "ask for it. By the scale factor amplitudes are raised to the limit of vibration, for "
        "clearances.",
    )


def _peak_table(document: Mapping[str, Any]) -> Table:
    rows = [
        [
            case,
            probe,
            f"{p['speed_rpm']:.1f}",
            f"{_MICRO * p['peak_to_peak_m']:.4g}",
            p["amplification_factor"] if p["amplification_factor"] is not None else "undefined",
            margin_words(p["margin"]),
            "–" if p["required_margin"] is None else f"{100.0 * p['required_margin']:.1f}",
            error_words(p["speed_error_estimate"]),
            p["verdict"],
        ]
        for case, found in document["cases"].items()
        for probe, own in found["probes"].items()
        for p in own["peaks"]
    ]
    return Table(
        title="Peaks at the probes",
        head=[
            *("unbalance", "probe", "speed [rpm]", "peak to peak [µm]"),
            *("amplification factor [1]", "margin", "asked [%]", "error of the speed", "verdict"),
        ],
        rows=rows,
        caption="Amplification factor from half-power points. Peaks below 2.5 are no critical "
        "speeds; undefined ones do not fall by 3 dB on both sides.",
    )


def _journal_table(document: Mapping[str, Any]) -> Table:
    first, last = document["overhung_kg"]
    critical = document["first_critical_on_rigid_supports_rpm"]
    said = "none found" if critical is None else f"{critical:.0f} rpm"
    return Table(
        title="Journals",
        head=["bearing", "at", "along the axis [m]", "static load / g [kg]"],
        rows=[
            [j["bearing"], j["at"], f"{j['axial_m']:.4g}", f"{j['load_kg']:.4g}"]
            for j in document["journals"]
        ],
        caption=f"Masses beyond the outer journals: {first:.3g} and {last:.3g} kg. First undamped "
        f"critical speed on rigid supports: {said}.",
    )


def _stage_table(document: Mapping[str, Any]) -> Table:
    level = document["level_1"]
    applied = ", ".join(f"{at} ({part:.3g})" for at, part in level["applied_at"].items())
    lost = level["lost_at_n_per_m"]
    said = "not reached" if lost is None else f"Q0 = {lost:.4g} N/m"
    return Table(
        title="Expected cross-coupling, level I",
        head=["stage at", "kind", "speed [rpm]", "qA [N/m]", "mean density [kg/m³]"],
        rows=[
            [
                s["at"],
                s["kind"],
                f"{s['speed_rpm']:.0f}",
                f"{s['cross_coupling_n_per_m']:.4g}",
                s["mean_density_kg_per_m3"],
            ]
            for s in level["stages"]
        ],
        caption=f"QA = {level['expected_n_per_m']:.4g} N/m, applied at {applied}. Loss of "
        f"stability: {said}. Log decrement at QA: {level['log_decrement_at_expected']:.3g}. "
        f"Critical speed ratio: {level['critical_speed_ratio']:.3g}. {level['why']}.",
    )


def _level_2_table(document: Mapping[str, Any]) -> Table:
    return Table(
        title="Stability, level II",
        head=["rotor", "log decrement, first forward [1]", "frequency [rpm]"],
        rows=[
            [r["rotor"], f"{r['log_decrement']:.4f}", f"{r['frequency_rpm']:.0f}"]
            for r in document["level_2"]["rows"]
        ],
        caption="At the maximum continuous speed: without the groups, with each alone, with all. "
        f"{LEAST_DECREMENT:g} is asked for of the complete rotor.",
    )


def _iso_table(document: Mapping[str, Any]) -> Table:
    iso = document["iso"]
    borders = " / ".join(f"{_MICRO * b:.1f}" for b in iso["zone_borders_m"])
    planes = iso["in_planes_kg_m"]
    split = (
        ""
        if planes is None
        else ", in planes at the outer journals "
        + " and ".join(f"{_GRAM_MM * part:.4g}" for part in planes)
    )
    return Table(
        title="ISO 20816-3 and ISO 21940-11",
        head=["what", "figure"],
        rows=[
            ["zones A/B, B/C, C/D of shaft vibration [µm peak to peak]", borders],
            [
                "largest vibration at operating speeds with the unbalances above",
                f"{_MICRO * iso['largest_m']:.3g} µm: zone {iso['zone']}",
            ],
            [
                f"unbalance permitted by G {iso['grade_mm_per_s']:g} [g mm]",
                f"{_GRAM_MM * iso['permissible_kg_m']:.4g}{split}",
            ],
            [
                "largest unbalance placed here [g mm]",
                f"{_GRAM_MM * iso['largest_placed_kg_m']:.4g}: "
                f"G {iso['grade_of_placed_mm_per_s']:.3g} of the whole rotor",
            ],
        ],
        caption="Beside the clauses; they decide nothing here.",
    )


# -- charts ---------------------------------------------------------------------------------------


def response_charts(document: Mapping[str, Any]) -> list[charts.Chart]:
    """Return amplitude and phase at the probes over the speed, for each case of unbalance."""
    top = max(case["speed_rpm"][-1] for case in document["cases"].values())
    axis = charts.speed_axis(0.0, top, _SPEED)
    limit = _MICRO * vibration_limit_m(document["speeds"]["maximum_continuous_rpm"])
    high = 1.3 * max(limit, *(_MICRO * max(p["peak_to_peak_m"]) for p in _probes(document)))
    amplitude = charts.Chart(
        name="api617-amplitude",
        title="Vibration at the probes",
        caption="Peak to peak, with the unbalances of the analysis, not scaled. Hatched: operating "
        "speeds. The dashed line is the limit of vibration there. Rings mark peaks.",
        alt="Peak to peak amplitude at each probe over the speed; the table of peaks has the "
        "numbers.",
        x=axis,
        y=charts.Axis(label="peak to peak", unit="µm", low=0.0, high=high, digits=".4g"),
        parts=[
            *_speeds(document),
            charts.Rule(at=limit, along="y", name="limit of vibration", text=f"{limit:.3g} µm"),
            _by_case(document, _amplitudes),
        ],
        height_px=460,
    )
    phase = charts.Chart(
        name="api617-phase",
        title="Phase at the probes",
        caption="Against the unbalance at angle zero, cut where lines leave ±180°.",
        alt="Phase at each probe over the speed.",
        x=axis,
        y=charts.Axis(label="phase", unit="°", low=-185.0, high=185.0, step=90.0, digits=".1f"),
        parts=[*_speeds(document), _by_case(document, _phases)],
        height_px=320,
    )
    return [amplitude, phase]


def _probes(document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return [own for case in document["cases"].values() for own in case["probes"].values()]


def _speeds(document: Mapping[str, Any]) -> list[charts.Part]:
    speeds = document["speeds"]
    low, high, trip = (speeds[k] for k in ("minimum_rpm", "maximum_continuous_rpm", "trip_rpm"))
    text = f"{low:g} to {high:g} rpm"
    return [
        charts.Span(low=low, high=high, name="operating speed", text=text, is_hatched=True),
        charts.Rule(at=trip, name="trip speed", text="trip"),
    ]


def _by_case(
    document: Mapping[str, Any], marks: Callable[[Mapping[str, Any]], list[charts.Mark]]
) -> charts.Choice:
    options = [
        charts.Option(label=name, marks=marks(case)) for name, case in document["cases"].items()
    ]
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


def cross_coupling_chart(document: Mapping[str, Any]) -> charts.Chart:
    """Return the damping of the first forward mode over applied cross-coupling."""
    level = document["level_1"]
    applied, expected = numbers(level["applied_n_per_m"]), level["expected_n_per_m"]
    unit, factor = charts.metric(float(applied.max()), "N/m")
    texts = [charts.hertz_text(f) for f in level["frequency_hz"]]
    curve = charts.Curve(
        x=factor * applied, y=numbers(level["log_decrement"]), name="first forward mode",
        look=replace(charts.whirl_look("forward"), mark=""), texts=texts,
    )  # fmt: skip
    point = charts.Curve(
        x=np.array([factor * expected]), y=np.array([level["log_decrement_at_expected"]]),
        name="at the expected cross-coupling QA", look=replace(charts.RING, color="@ink"),
    )  # fmt: skip
    lost = level["lost_at_n_per_m"]
    marks: list[charts.Part] = [
        charts.Rule(at=LEAST_DECREMENT, along="y", name="asked for", text="0.1"),
        charts.Rule(at=0.0, along="y", look=charts.Look("@muted", "solid", width=1.0)),
        curve,
        point,
    ]
    if lost is not None and 0.0 < lost <= applied.max():
        marks.append(charts.Rule(at=factor * lost, name="Q0", text="Q0"))
    return charts.Chart(
        name="api617-stability",
        title="Damping over applied cross-coupling",
        caption="Log decrement of the first forward mode at the maximum continuous speed, without "
        "seals, up to ten times the expected cross-coupling or the loss of stability.",
        alt="Log decrement of the first forward mode over the applied cross-coupled stiffness.",
        x=charts.Axis(label="applied cross-coupling", unit=unit, low=0.0, digits=".4g"),
        y=charts.Axis(label="log decrement", unit="1", digits=".4g"),
        parts=marks,
        height_px=380,
    )


def region_charts(document: Mapping[str, Any]) -> Sequence[charts.Chart]:
    """Return density and critical speed ratio beside the border of region B, if both are known."""
    level = document["level_1"]
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
