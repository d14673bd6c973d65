"""What a page and its pictures tell of a lateral analysis of API 617."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from solidwhirl.analyses.api617.clauses import figure_text, verdicts_by_bearings
from solidwhirl.analyses.api617.pictures import response_charts, stability_charts
from solidwhirl.core.blocks import AnalysisBlock, Table, Text, margin_words
from solidwhirl.rotordyn.plots.campbell import error_words
from solidwhirl.rotordyn.standards.api617_stability import LEAST_DECREMENT

_EDITIONS = {"8th": "8th edition", "9th": "9th edition", "legacy": "6th edition"}
_WORDS = {"pass": "Pass", "fail": "FAIL", "undecided": "Undecided"}
_COEFFICIENTS = {
    "synchronous": "Bearings that depend on the frequency are taken at the synchronous one.",
    "own_frequency": "Bearings that depend on the frequency are taken at that of the mode.",
    "over_speed": "No bearing depends on the frequency: coefficients are those of the tables over "
    "the speed, as they are after synchronous reduction.",
}
_CHANGE = "largest change of the vector from the bearings of the scene to another set"
_MICRO, _GRAM_MM = 1e6, 1e6


def edition_text(edition: str) -> str:
    """Return an edition in words."""
    return _EDITIONS[edition]


def blocks(document: Mapping[str, Any]) -> list[AnalysisBlock]:
    """Return verdict, clauses, responses, stability, ISO, and what is assumed."""
    verdict = document["verdict"]
    speeds, left_out = document["speeds"], verdict["not_judged"]
    head = (
        f"**{_WORDS[verdict['verdict']]} by API 617, {edition_text(document['edition'])}**, "
        f"{document['shaft']}, {speeds['minimum_rpm']:g} to {speeds['maximum_continuous_rpm']:g} "
        f"rpm, trip {speeds['trip_rpm']:g} rpm: {verdict['why']}."
        + (f" {said[:1].upper()}{said[1:]}." if (said := verdict["judged_text"]) else "")
    )
    cases = document["bearing_cases"]
    found: list[AnalysisBlock] = [
        Text(text=head, kind="plain" if verdict["passed"] and not left_out else "warning"),
        *([_set_table(document)] if len(cases) > 1 else []),
        _clause_table(document),
        _placement_table(document),
    ]
    for name, own in cases.items():
        if own["cases"]:
            found += response_charts(document, name)
    if any(own["cases"] for own in cases.values()):
        found.append(_peak_table(document))
    if any(own["level_1"] for own in cases.values()):
        found += [*stability_charts(document), _stage_table(document), _level_1_table(document)]
    if any(own["level_2"] for own in cases.values()):
        found.append(_level_2_table(document))
    found += [_journal_table(document), _iso_table(document)]
    assumed = "\n".join(f"- {line}" for line in document["assumptions"])
    said = "To be checked against the bought standard, as these are of public sources:"
    return [*found, Text(text=f"{said}\n\n{assumed}", kind="note")]


def _set_table(document: Mapping[str, Any]) -> Table:
    """What each set of bearing laws comes to; the worst decides."""
    rows = document["clauses"]
    verdicts = verdicts_by_bearings(rows)
    return Table(
        title="Sets of bearing laws",
        head=["bearings", "laws", "verdict", "least to spare in"],
        rows=[
            [
                name,
                ", ".join(f"{at}: {law}" for at, law in own["laws"].items()) or "of the scene",
                _WORDS[verdicts[name]["verdict"]].lower()
                if verdicts[name]["passed"]
                else f"**{_WORDS[verdicts[name]['verdict']]}**",
                verdicts[name]["why"],
            ]
            for name, own in document["bearing_cases"].items()
        ],
        caption="Every clause is evaluated for each set; the worst decides.",
    )


def _by_bearings(
    document: Mapping[str, Any],
    title: str,
    head: list[str],
    rows: Iterable[tuple[str, list[Any]]],
    caption: str,
) -> Table:
    """A table whose rows have their set of bearing laws in front, where there are several."""
    several = len(document["bearing_cases"]) > 1
    return Table(
        title=title,
        head=["bearings", *head] if several else head,
        rows=[[name, *row] if several else row for name, row in rows],
        caption=caption,
    )


def _unbalance_cases(
    document: Mapping[str, Any],
) -> Iterator[tuple[str, str, Mapping[str, Any]]]:
    for name, found in document["bearing_cases"].items():
        for case, own in found["cases"].items():
            yield name, case, own


def _clause_table(document: Mapping[str, Any]) -> Table:
    return _by_bearings(
        document,
        "Clauses",
        ["clause", "what", "where", "figure", "asked", "to spare", "error", "verdict", "note"],
        ((row["bearings"], _clause_cells(row)) for row in document["clauses"]),
        "To spare: of margins as a part of the speed, else of the limit. The error is that "
        "of the model's discretisation, where it is known, of margins as a part of the speed, else "
        "of the figure.",
    )


def _clause_cells(row: Mapping[str, Any]) -> list[Any]:
    return [
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


def _placement_table(document: Mapping[str, Any]) -> Table:
    return _by_bearings(
        document,
        "Unbalances",
        [
            *("at", "kind", "W [kg]", "unbalance [g mm]", "angle [°]"),
            *("modes [rpm]", "scale factor"),
        ],
        (
            (name, _placement_cells(case, unbalance))
            for name, _, case in _unbalance_cases(document)
            for unbalance in case["unbalances"]
        ),
        "One run for each set of unbalances, for the undamped critical speeds whose shapes "
        "ask for it. By the scale factor amplitudes are raised to the limit of vibration, for "
        "clearances.",
    )


def _placement_cells(case: Mapping[str, Any], unbalance: Mapping[str, Any]) -> list[Any]:
    return [
        unbalance["at"],
        case["kind"],
        f"{unbalance['load_kg']:.4g}",
        f"{_GRAM_MM * unbalance['moment_kg_m']:.4g}",
        f"{unbalance['phase_deg']:.0f}",
        ", ".join(f"{rpm:.0f}" for rpm in case["modes_rpm"]),
        f"{case['scale_factor']:.4g}",
    ]


def _peak_table(document: Mapping[str, Any]) -> Table:
    return _by_bearings(
        document,
        "Peaks at the probes",
        [
            *("unbalance", "probe", "speed [rpm]", "peak to peak [µm]"),
            *("amplification factor [1]", "margin", "asked [%]", "error of the speed"),
            "verdict",
        ],
        (
            (name, [case, probe, *_peak_cells(peak)])
            for name, case, found in _unbalance_cases(document)
            for probe, own in found["probes"].items()
            for peak in own["peaks"]
        ),
        "Amplification factor from half-power points. Peaks below 2.5 are no critical "
        "speeds; undefined ones do not fall by 3 dB on both sides.",
    )


def _peak_cells(peak: Mapping[str, Any]) -> list[Any]:
    factor, required = peak["amplification_factor"], peak["required_margin"]
    return [
        f"{peak['speed_rpm']:.1f}",
        f"{_MICRO * peak['peak_to_peak_m']:.4g}",
        factor if factor is not None else "undefined",
        margin_words(peak["margin"]),
        "–" if required is None else f"{100.0 * required:.1f}",
        error_words(peak["speed_error_estimate"]),
        peak["verdict"],
    ]


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
    level = next(iter(_levels(document, "level_1").values()))
    applied = ", ".join(f"{at} ({part:.3g})" for at, part in level["applied_at"].items())
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
        caption=f"QA = {level['expected_n_per_m']:.4g} N/m, applied at {applied}. Critical speed "
        f"ratio: {level['critical_speed_ratio']:.3g}. {_COEFFICIENTS[level['coefficients']]}",
    )


def _levels(document: Mapping[str, Any], level: str) -> dict[str, Mapping[str, Any]]:
    found = document["bearing_cases"]
    return {name: own[level] for name, own in found.items() if own[level]}


def _level_1_table(document: Mapping[str, Any]) -> Table:
    return _by_bearings(
        document,
        "Stability, level I",
        ["log decrement at QA", "error", "Q0 [N/m]", "Q0/QA", "screening"],
        ((name, _level_1_cells(level)) for name, level in _levels(document, "level_1").items()),
        "At the maximum continuous speed, the first forward mode; level II is asked for "
        "where the screening says so.",
    )


def _level_1_cells(level: Mapping[str, Any]) -> list[Any]:
    lost, times = level["lost_at_n_per_m"], level["times_expected"]
    return [
        f"{level['log_decrement_at_expected']:.4f}",
        error_words(level["error_estimate"]),
        "not reached" if lost is None else f"{lost:.4g}",
        "–" if times is None else f"{times:.3g}",
        level["why"],
    ]


def _level_2_table(document: Mapping[str, Any]) -> Table:
    return _by_bearings(
        document,
        "Stability, level II",
        [
            *("rotor", "cross-coupling added [N/m]", "log decrement, first forward [1]"),
            *("error", "frequency [rpm]"),
        ],
        (
            (name, _level_2_cells(row))
            for name, level in _levels(document, "level_2").items()
            for row in level["rows"]
        ),
        "At the maximum continuous speed: without the groups, with each alone, with all; "
        "cross-coupling of seals is in their bearing laws. Bearings are taken at the frequency of "
        f"the mode. {LEAST_DECREMENT:g} is asked for of the complete rotor.",
    )


def _level_2_cells(row: Mapping[str, Any]) -> list[Any]:
    return [
        row["rotor"],
        f"{row['cross_coupling_n_per_m']:.4g}",
        f"{row['log_decrement']:.4f}",
        error_words(row["error_estimate"]),
        f"{row['frequency_rpm']:.0f}",
    ]


def _iso_table(document: Mapping[str, Any]) -> Table:
    iso = document["iso"]
    borders = " / ".join(f"{_MICRO * b:.1f}" for b in iso["zone_borders_m"])
    planes, change = iso["in_planes_kg_m"], iso["largest_change"]
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
                "a change of the vibration is significant from [µm peak to peak]",
                f"{_MICRO * iso['significant_change_m']:.1f}, 25 % of the border B/C",
            ],
            *([] if change is None else [[_CHANGE, _change_text(change, iso)]]),
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


def _change_text(change: Mapping[str, Any], iso: Mapping[str, Any]) -> str:
    word = "significant" if iso["change_is_significant"] else "not significant"
    return (
        f"{_MICRO * change['change_m']:.3g} µm: {word} ({change['bearings']}, "
        f"{change['unbalance']}, {change['probe']}, {change['speed_rpm']:.0f} rpm)"
    )
