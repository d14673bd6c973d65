"""What a page and its pictures tell of a lateral analysis of API 617."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
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
    speeds = document["speeds"]
    head = (
        f"**{_WORDS[verdict['verdict']]} by API 617, {edition_text(document['edition'])}**, "
        f"{document['shaft']}, {speeds['minimum_rpm']:g} to {speeds['maximum_continuous_rpm']:g} "
        f"rpm, trip {speeds['trip_rpm']:g} rpm: {verdict['why']}."
    )
    cases = document["bearing_cases"]
    found: list[AnalysisBlock] = [
        Text(text=head, kind="plain" if verdict["passed"] else "warning"),
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


def _several(document: Mapping[str, Any]) -> bool:
    return len(document["bearing_cases"]) > 1


def _with_bearings(document: Mapping[str, Any], row: list[Any], name: str) -> list[Any]:
    """A row of a table with its set of bearing laws in front, where there are several."""
    return [name, *row] if _several(document) else row


def _unbalance_cases(
    document: Mapping[str, Any],
) -> Iterator[tuple[str, str, Mapping[str, Any]]]:
    for name, found in document["bearing_cases"].items():
        for case, own in found["cases"].items():
            yield name, case, own


def _clause_table(document: Mapping[str, Any]) -> Table:
    return Table(
        title="Clauses",
        head=_with_bearings(
            document,
            ["clause", "what", "where", "figure", "asked", "to spare", "error", "verdict", "note"],
            "bearings",
        ),
        rows=[
            _with_bearings(document, _clause_cells(row), row["bearings"])
            for row in document["clauses"]
        ],
        caption="To spare: of margins as a part of the speed, else of the limit. The error is that "
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
    return Table(
        title="Unbalances",
        head=_with_bearings(
            document,
            [
                *("at", "kind", "W [kg]", "unbalance [g mm]", "angle [°]"),
                *("modes [rpm]", "scale factor"),
            ],
            "bearings",
        ),
        rows=[
            _with_bearings(
                document,
                [
                    u["at"],
                    case["kind"],
                    f"{u['load_kg']:.4g}",
                    f"{_GRAM_MM * u['moment_kg_m']:.4g}",
                    f"{u['phase_deg']:.0f}",
                    ", ".join(f"{rpm:.0f}" for rpm in case["modes_rpm"]),
                    f"{case['scale_factor']:.4g}",
                ],
                name,
            )
            for name, _, case in _unbalance_cases(document)
            for u in case["unbalances"]
        ],
        caption="One run for each set of unbalances, for the undamped critical speeds whose shapes "
        "ask for it. By the scale factor amplitudes are raised to the limit of vibration, for "
        "clearances.",
    )


def _peak_table(document: Mapping[str, Any]) -> Table:
    rows = [
        _with_bearings(document, [case, probe, *_peak_cells(peak)], name)
        for name, case, found in _unbalance_cases(document)
        for probe, own in found["probes"].items()
        for peak in own["peaks"]
    ]
    return Table(
        title="Peaks at the probes",
        head=_with_bearings(
            document,
            [
                *("unbalance", "probe", "speed [rpm]", "peak to peak [µm]"),
                *("amplification factor [1]", "margin", "asked [%]", "error of the speed"),
                "verdict",
            ],
            "bearings",
        ),
        rows=rows,
        caption="Amplification factor from half-power points. Peaks below 2.5 are no critical "
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
    return Table(
        title="Stability, level I",
        head=_with_bearings(
            document,
            ["log decrement at QA", "error", "Q0 [N/m]", "Q0/QA", "screening"],
            "bearings",
        ),
        rows=[
            _with_bearings(
                document,
                [
                    f"{level['log_decrement_at_expected']:.4f}",
                    error_words(level["error_estimate"]),
                    "not reached"
                    if level["lost_at_n_per_m"] is None
                    else f"{level['lost_at_n_per_m']:.4g}",
                    "–" if level["times_expected"] is None else f"{level['times_expected']:.3g}",
                    level["why"],
                ],
                name,
            )
            for name, level in _levels(document, "level_1").items()
        ],
        caption="At the maximum continuous speed, the first forward mode; level II is asked for "
        "where the screening says so.",
    )


def _level_2_table(document: Mapping[str, Any]) -> Table:
    return Table(
        title="Stability, level II",
        head=_with_bearings(
            document,
            [
                *("rotor", "cross-coupling added [N/m]", "log decrement, first forward [1]"),
                *("error", "frequency [rpm]"),
            ],
            "bearings",
        ),
        rows=[
            _with_bearings(
                document,
                [
                    r["rotor"],
                    f"{r['cross_coupling_n_per_m']:.4g}",
                    f"{r['log_decrement']:.4f}",
                    error_words(r["error_estimate"]),
                    f"{r['frequency_rpm']:.0f}",
                ],
                name,
            )
            for name, level in _levels(document, "level_2").items()
            for r in level["rows"]
        ],
        caption="At the maximum continuous speed: without the groups, with each alone, with all; "
        "cross-coupling of seals is in their bearing laws. Bearings are taken at the frequency of "
        f"the mode. {LEAST_DECREMENT:g} is asked for of the complete rotor.",
    )


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
