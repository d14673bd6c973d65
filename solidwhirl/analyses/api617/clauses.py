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
    """Return a row for each thing that a clause asks, from the other parts of a document."""
    edition: Edition = document["edition"]
    rows = [
        *_margin_rows(document),
        *_vibration_rows(document),
        *_clearance_rows(document),
        _level_1_row(document),
        _level_2_row(document),
    ]
    return [{**row, "clause": _CLAUSES[row["subject"]][edition]} for row in rows]


def verdict_of(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the verdict of all rows, and the row with the least to spare."""
    verdicts = [row["verdict"] for row in rows]
    word = "pass"
    if "fail" in verdicts:
        word = "fail"
    elif "undecided" in verdicts:
        word = "undecided"
    judged = [r for r in rows if r["to_spare"] is not None and r["verdict"] in ("pass", "fail")]
    worst = min(judged, key=lambda row: row["to_spare"], default=None)
    decisive = worst
    if word == "undecided":
        decisive = next(row for row in rows if row["verdict"] == "undecided")
    return {
        "verdict": word,
        "passed": word == "pass",
        "worst_to_spare": None if worst is None else worst["to_spare"],
        "why": "nothing to judge" if decisive is None else row_text(decisive),
    }


def row_text(row: Mapping[str, Any]) -> str:
    """Return a row as one line."""
    place = f" {row['where']}" if row["where"] else ""
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
) -> dict[str, Any]:
    """A row; `to_spare` is what is left, as a part of the limit or of the operating speed."""
    in_metres = subject in _IN_METRES
    to_spare = None
    if value is not None and limit is not None:
        more = limit - value if in_metres else value - limit
        to_spare = more if subject == "margin" else more / limit
    none = {"value": None, "limit": None, "value_m": None, "limit_m": None}
    own = {"value_m": value, "limit_m": limit} if in_metres else {"value": value, "limit": limit}
    return {
        "subject": subject, "what": what, "where": where, **none, **own,
        "wants": "at most" if in_metres else "at least", "to_spare": to_spare,
        "error_estimate": None, "verdict": verdict, "note": note,
    }  # fmt: skip


def _margin_rows(document: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Of each response peak that is a critical speed, or may be one."""
    for case, found in document["cases"].items():
        told = False
        for probe, own in found["probes"].items():
            for peak in own["peaks"]:
                if peak["verdict"] == "not applicable":
                    continue
                told = True
                yield _margin_row(f"{case}, {probe}", peak)
        if not told:
            note = "no response peak has an amplification factor of 2.5"
            yield _row("margin", "separation margin", case, "pass", note)


def _margin_row(where: str, peak: Mapping[str, Any]) -> dict[str, Any]:
    at = f"of {peak['speed_rpm']:.0f} rpm"
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
    row = _row("margin", f"separation margin {at}", where, peak["verdict"], note,
               value=value, limit=limit)  # fmt: skip
    if row["verdict"] == "fail" and row["to_spare"] is None:
        row["to_spare"] = -1.0
    error = peak["speed_error_estimate"]
    if error is not None:
        row["error_estimate"] = error * peak["speed_rpm"] / peak["reference_rpm"]
    return row


def _vibration_rows(document: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    limit = vibration_limit_m(document["speeds"]["maximum_continuous_rpm"])
    for case, found in document["cases"].items():
        probe, own = max(found["probes"].items(), key=lambda item: item[1]["largest_m"])
        value = own["largest_m"]
        row = _row(
            "vibration", "vibration at operating speeds", f"{case}, {probe}",
            "pass" if value <= limit else "fail", f"at {own['largest_at_rpm']:.0f} rpm",
            value=value, limit=limit,
        )  # fmt: skip
        at_top = [p for p in own["peaks"] if p["speed_rpm"] == own["largest_at_rpm"]]
        row["error_estimate"] = at_top[0]["height_error_estimate"] if at_top else None
        yield row


def _clearance_rows(document: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    for case, found in document["cases"].items():
        for own in found["clearances"]:
            value, limit = own["scaled_m"], own["allowed_m"]
            verdict: Verdict = "pass" if value <= limit else "fail"
            note = f"scale factor {found['scale_factor']:.3g}, at {own['at_rpm']:.0f} rpm"
            if own["floating_ring"]:
                verdict, note = "not applicable", "floating ring"
            yield _row("clearance", "75 % of the clearance", f"{case}, {own['at']}", verdict, note,
                       value=value, limit=limit)  # fmt: skip
    if not any(found["clearances"] for found in document["cases"].values()):
        yield _row("clearance", "75 % of the clearance", "", "not applicable", "no clearance given")


def _level_1_row(document: Mapping[str, Any]) -> dict[str, Any]:
    found, what = document["level_1"], "stability, level I"
    if not document["stability_is_asked"]:
        note = "the machine runs below the first critical speed on rigid supports"
        return _row("level 1", what, "", "not applicable", note)
    if found is None:
        return _row("level 1", what, "", "undecided", "no stages given")
    if not found["detailed"]:
        value = found["log_decrement_at_expected"]
        return _row("level 1", what, "", "pass", found["why"],
                    value=value, limit=LEAST_DECREMENT)  # fmt: skip
    if document["level_2"] is None:
        note = f"{found['why']}: level II is asked for, and level_2 is not given"
        return _row("level 1", what, "", "undecided", note)
    return _row("level 1", what, "", "not applicable", f"{found['why']}: level II decides")


def _level_2_row(document: Mapping[str, Any]) -> dict[str, Any]:
    found, what = document["level_2"], "stability, level II"
    if found is None:
        return _row("level 2", what, "", "not applicable", "level_2 is not given")
    value = found["log_decrement"]
    verdict: Verdict = "pass" if value >= LEAST_DECREMENT else "fail"
    note = "log decrement of the complete rotor"
    return _row("level 2", what, "", verdict, note, value=value, limit=LEAST_DECREMENT)
