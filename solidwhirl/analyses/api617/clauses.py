"""Verdicts of API 617 clause by clause, and what they come to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal

from solidwhirl.rotordyn.standards.api617_lateral import Edition, vibration_limit_m
from solidwhirl.rotordyn.standards.api617_stability import LEAST_DECREMENT

Verdict = Literal["pass", "fail", "undecided", "not applicable"]

# Subjects whose figures are amplitudes; those of the others have no unit.
_IN_METRES = ("vibration", "clearance")

# Clauses by edition; of the 6th those of the first tutorial, API RP 684.
_CLAUSES: dict[str, dict[Edition, str]] = {
    "margin": {"8th": "4.8.2.10", "9th": "6.8.2", "legacy": "SP6.8.2.10"},
    "vibration": {"8th": "4.8.2.11", "9th": "6.8.2", "legacy": "SP6.8.2"},
    "clearance": {"8th": "4.8.2", "9th": "6.8.2.11", "legacy": "SP6.8.2"},
    "level 1": {"8th": "4.8.5", "9th": "6.8.4", "legacy": "SP6.8.5"},
    "level 2": {"8th": "4.8.6", "9th": "6.8.4", "legacy": "SP6.8.6"},
}


def clause_rows(document: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return a row for each thing that a clause asks, of each set of bearing laws."""
    edition: Edition = document["edition"]
    rows = []
    for name, found in document["bearing_cases"].items():
        own = [
            *_margin_rows(found),
            *_vibration_rows(found, document["speeds"]["maximum_continuous_rpm"]),
            *_clearance_rows(found),
            _level_1_row(found, is_asked=document["stability_is_asked"]),
            _level_2_row(found),
        ]
        rows += [
            {"bearings": name, **row, "clause": _CLAUSES[row["subject"]][edition]} for row in own
        ]
    return rows


def verdict_of(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the verdict of all rows, and the row with the least to spare."""
    verdicts = [row["verdict"] for row in rows]
    word = "pass"
    if "fail" in verdicts:
        word = "fail"
    elif "undecided" in verdicts or "pass" not in verdicts:
        word = "undecided"
    judged = [r for r in rows if r["to_spare"] is not None and r["verdict"] in ("pass", "fail")]
    worst = min(judged, key=lambda row: row["to_spare"], default=None)
    decisive = worst
    if word == "undecided":
        decisive = next((row for row in rows if row["verdict"] == "undecided"), None)
    return {
        "verdict": word,
        "passed": word == "pass",
        "worst_to_spare": None if worst is None else worst["to_spare"],
        "why": "nothing to judge"
        if decisive is None
        else row_text(decisive, with_bearings=len({row["bearings"] for row in rows}) > 1),
    }


def verdicts_by_bearings(rows: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Return the verdict of the rows of each set of bearing laws by its name."""
    names = dict.fromkeys(row["bearings"] for row in rows)
    return {name: verdict_of([r for r in rows if r["bearings"] == name]) for name in names}


def row_text(row: Mapping[str, Any], *, with_bearings: bool = False) -> str:
    """Return a row as one line; `with_bearings` tells of which set of bearing laws it is."""
    place = f", {row['where']}" if row["where"] else ""
    place += f", bearings {row['bearings']}" if with_bearings else ""
    note = f" ({row['note']})" if row["note"] else ""
    said = f"{row['clause']}, {row['what']}{place}{note}"
    value, limit = (figure_text(row, key) for key in ("value", "limit"))
    if "–" in (value, limit):
        return said
    return f"{said}: {value}, asked {limit}"


def figure_text(row: Mapping[str, Any], key: str) -> str:
    """Return the "value" or the "limit" of a row with its unit, "–" if there is none."""
    in_metres = row["subject"] in _IN_METRES
    value = row[f"{key}_m" if in_metres else key]
    if value is None:
        return "–"
    sign = {"at least": "≥ ", "at most": "≤ "}[row["wants"]] if key == "limit" else ""
    if in_metres:
        return f"{sign}{1e6 * value:.3g} µm"
    return f"{sign}{100.0 * value:.1f} %" if row["subject"] == "margin" else f"{sign}{value:.3g}"


def _row(
    subject: str,
    what: str,
    where: str,
    verdict: Verdict,
    note: str = "",
    *,
    value: float | None = None,
    limit: float | None = None,
    error: float | None = None,
) -> dict[str, Any]:
    """A row; `to_spare` is what is left, as a part of the limit or of the operating speed.

    `error`: of the value, of margins a part of the speed, else relative.
    """
    in_metres = subject in _IN_METRES
    to_spare = None
    if value is not None and limit is not None:
        more = limit - value if in_metres else value - limit
        to_spare = more if subject == "margin" else more / limit
        reach = 0.0 if error is None else error * (1.0 if subject == "margin" else abs(value))
        if verdict in ("pass", "fail") and abs(more) <= reach:
            note = f"{note}; " * bool(note) + "the error reaches across the limit"
    none = {"value": None, "limit": None, "value_m": None, "limit_m": None}
    own = {"value_m": value, "limit_m": limit} if in_metres else {"value": value, "limit": limit}
    return {
        "subject": subject, "what": what, "where": where, **none, **own,
        "wants": "at most" if in_metres else "at least", "to_spare": to_spare,
        "error_estimate": error, "verdict": verdict, "note": note,
    }  # fmt: skip


def _margin_rows(found: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Of each response peak that is a critical speed, or may be one."""
    for case, own in found["cases"].items():
        told = False
        for name, probe in own["probes"].items():
            for peak in probe["peaks"]:
                if peak["verdict"] == "not applicable":
                    continue
                told = True
                # such as "static at rotor.disk", the unbalance
                place = case.replace(" at ", " unbalance at ", 1)
                yield _margin_row(f"{place}, {name}", peak)
        if not told:
            note = "no response peak has an amplification factor of 2.5"
            yield _row("margin", "separation margin", case, "pass", note)


def _margin_row(where: str, peak: Mapping[str, Any]) -> dict[str, Any]:
    at = f"of the peak at {peak['speed_rpm']:.0f} rpm"
    factor = peak["amplification_factor"]
    note = "" if factor is None else f"amplification factor {factor:.3g}"
    value, limit = abs(peak["margin"]), peak["required_margin"]
    if factor is None:
        note = "amplification factor undefined: no half-power points on both sides"
        if peak["verdict"] == "pass":
            note += "; the margin is enough for any"
        limit = None
    if peak["position"] == "inside":
        note, limit = f"{note}; inside the operating speeds", None
    error = peak["speed_error_estimate"]
    if error is not None:
        error *= peak["speed_rpm"] / peak["reference_rpm"]
    row = _row("margin", f"separation margin {at}", where, peak["verdict"], note,
               value=value, limit=limit, error=error)  # fmt: skip
    if row["verdict"] == "fail" and row["to_spare"] is None:
        row["to_spare"] = -1.0
    return row


def _vibration_rows(found: Mapping[str, Any], speed_max_rpm: float) -> Iterator[dict[str, Any]]:
    limit = vibration_limit_m(speed_max_rpm)
    for case, own in found["cases"].items():
        name, probe = max(own["probes"].items(), key=lambda item: item[1]["largest_m"])
        value = probe["largest_m"]
        yield _row(
            "vibration", "vibration at operating speeds", f"{case}, {name}",
            "pass" if value <= limit else "fail", f"at {probe['largest_at_rpm']:.0f} rpm",
            value=value, limit=limit, error=probe["largest_error_estimate"],
        )  # fmt: skip


def _clearance_rows(found: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    what = "75 % of the clearance"
    for case, own in found["cases"].items():
        for clearance in own["clearances"]:
            value, limit = clearance["scaled_m"], clearance["allowed_m"]
            verdict: Verdict = "pass" if value <= limit else "fail"
            note = f"scale factor {own['scale_factor']:.3g}, at {clearance['at_rpm']:.0f} rpm"
            if clearance["floating_ring"]:
                verdict, note = "not applicable", "floating ring"
            yield _row("clearance", what, f"{case}, {clearance['at']}", verdict, note,
                       value=value, limit=limit, error=clearance["error_estimate"])  # fmt: skip
    if not any(own["clearances"] for own in found["cases"].values()):
        yield _row("clearance", what, "", "not applicable", "no clearance given")


def _level_1_row(found: Mapping[str, Any], *, is_asked: bool) -> dict[str, Any]:
    level, what = found["level_1"], "stability, level I"
    if not is_asked:
        note = "the machine runs below the first critical speed on rigid supports"
        return _row("level 1", what, "", "not applicable", note)
    if level is None:
        return _row("level 1", what, "", "undecided", "no stages given")
    if not level["detailed"]:
        value = level["log_decrement_at_expected"]
        return _row("level 1", what, "", "pass", level["why"],
                    value=value, limit=LEAST_DECREMENT, error=level["error_estimate"])  # fmt: skip
    if found["level_2"] is None:
        note = f"{level['why']}: level II is asked for, and level_2 is not given"
        return _row("level 1", what, "", "undecided", note)
    return _row("level 1", what, "", "not applicable", f"{level['why']}: level II decides")


def _level_2_row(found: Mapping[str, Any]) -> dict[str, Any]:
    level, what = found["level_2"], "stability, level II"
    if level is None:
        return _row("level 2", what, "", "not applicable", "level_2 is not given")
    value = level["log_decrement"]
    verdict: Verdict = "pass" if value >= LEAST_DECREMENT else "fail"
    note = "log decrement of the complete rotor"
    return _row("level 2", what, "", verdict, note,
                value=value, limit=LEAST_DECREMENT, error=level["error_estimate"])  # fmt: skip
