"""What a run comes to: the answers that a design review asks for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from solidwhirl.analyses.base import Operating, Stability
from solidwhirl.analyses.stability_summary import interval_document
from solidwhirl.estimates.documents import coupling_effect
from solidwhirl.pipeline.alarms import Alarm
from solidwhirl.rotordyn.modes.kinds import moves_laterally, shares_in
from solidwhirl.rotordyn.standards.api617_lateral import vibration_limit_m
from solidwhirl.scene_checks.operating import critical_speeds_that_count, margin_of

_UM_PER_M = 1e6


def verdict_document(
    document: Mapping[str, Any],
    stability: Stability,
    operating: Sequence[Operating],
    alarms: Sequence[Alarm],
) -> dict[str, Any]:
    """Return the key `verdict` of `results.json`: plain data with units in the keys.

    `document`: the contents of `results.json` but for the verdict. `operating`: from
    `operating_speeds`.

    Critical speeds are those that count, with amplification and margin. `gravity_critical_speeds`
    is None where no body is asymmetric. `margins.passed` is None
    without an analysis of margins. `vibration` has, of each observed place of each unbalance
    response, the largest amplitude within the operating speeds and over the sweep.
    `coupling_effect` is the relative change of the critical speeds and modes that count by the
    other coupling of the interfaces, None where it was not computed.
    """
    accuracy = document["accuracy"]
    return {
        "stable": stability.stable,
        "speed_range_rpm": [stability.low_rpm, stability.high_rpm],
        "unstable_from_rpm": stability.unstable_from_rpm,
        "unstable_intervals": [interval_document(i) for i in stability.intervals],
        "at_operating": list(stability.at_operating),
        "critical_speeds": list(_critical_speeds(document, operating)),
        "gravity_critical_speeds": _gravity_critical_speeds(document),
        "margins": _margins(document["analyses"]),
        "vibration": list(_vibration(document["analyses"], operating)),
        "accuracy": {
            **{key: accuracy[key] for key in ("asked", "largest_error_estimate", "met")},
            "not_estimated": accuracy["bodies_without_estimate"],
            "covers": "frequencies of the Campbell diagram and critical speeds, of modes that are "
            "not critically damped; discretisation alone, neither the input nor the coupling",
        },
        "coupling_effect": coupling_effect(document),
        "alarms": [asdict(alarm) for alarm in alarms],
    }


def _critical_speeds(
    document: Mapping[str, Any], operating: Sequence[Operating]
) -> Iterator[dict[str, Any]]:
    keys = (
        *("speed_rpm", "frequency_hz", "whirl", "kind", "shares", "log_decrement"),
        *("amplification_factor", "shafts", "exciters", "excited_by", "excited", "excited_why"),
    )
    for entry in critical_speeds_that_count(document):
        margin = margin_of(entry["speed_rpm"], entry["shafts"], operating)
        yield {
            **{key: entry[key] for key in keys},
            "margin": None if margin is None else margin[0],
            "margin_of": None if margin is None else margin[1],
        }


def _gravity_critical_speeds(document: Mapping[str, Any]) -> list[dict[str, Any]] | None:
    """Those of lateral motion at twice the speed; None where all bodies are symmetric."""
    found = document.get("asymmetry")
    if found is None:
        return None
    keys = ("speed_rpm", "damping_ratio", "error_estimate")
    every = found["gravity_critical_speeds"]
    own = [r for r in every if moves_laterally(shares_in(r["shares"])) and abs(r["multiple"]) == 2]
    return [{key: r[key] for key in keys} for r in own]


def _margins(analyses: Mapping[str, Any]) -> dict[str, Any]:
    """All analyses of margins together: the first that fails says why."""
    found = {n: a["verdict"] for n, a in analyses.items() if a["kind"] == "separation_margins"}
    if not found:
        why = "no analysis of separation margins"
        return {"passed": None, "decided": None, "method": None, "why": why}
    failed = [v for v in found.values() if not v["passed"]]
    doubtful = [v for v in found.values() if not v["decided"]]
    decisive = next(iter([*failed, *doubtful, *found.values()]))
    return {
        "passed": not failed,
        "decided": decisive["decided"],
        "method": decisive["method"],
        "why": decisive["why"],
        "judged": list(dict.fromkeys(body for v in found.values() for body in v["judged"])),
        "analyses": list(found),
    }


def _vibration(
    analyses: Mapping[str, Any], operating: Sequence[Operating]
) -> Iterator[dict[str, Any]]:
    """Largest axis of the orbit, both sides, at each observed place.

    The limit of a standard is that of scenes which have chosen the standard.
    """
    limited = any(
        a["verdict"]["method"] == "api617" and a["verdict"].get("chosen")
        for a in analyses.values()
        if a["kind"] == "separation_margins"
    )
    for name, entry in analyses.items():
        if entry["kind"] != "unbalance_response":
            continue
        speeds = np.array(entry["speed_rpm"], dtype=float)
        for exciter in entry["exciters"]:
            for place, orbit in exciter["places"].items():
                size = 2.0 * _UM_PER_M * np.array(orbit["major_m"], dtype=float)
                own = [o for o in operating if o.is_of([place.partition(".")[0]])] or operating
                yield {
                    "analysis": name,
                    "place": place,
                    "unbalance_of": list(exciter["bodies"]),
                    "over_sweep": _largest(speeds, size),
                    "at_operating": _within(speeds, size, own),
                    "api617_limit_um": _limit_um(own) if limited else None,
                }


def _within(
    speeds: np.ndarray[Any, Any], size: np.ndarray[Any, Any], operating: Sequence[Operating]
) -> dict[str, float] | None:
    """Largest in the operating speeds that the sweep covers, their ends included."""
    order = np.argsort(speeds)
    at: list[float] = []
    for own in operating:
        low, high = np.clip(own.reference_rpm, speeds.min(), speeds.max())
        if own.reference_rpm[0] <= speeds.max() and own.reference_rpm[1] >= speeds.min():
            at += [low, high, *speeds[(speeds > low) & (speeds < high)]]
    if not at:
        return None
    where = np.unique(at)
    return _largest(where, np.interp(where, speeds[order], size[order]))


def _largest(speeds: np.ndarray[Any, Any], size: np.ndarray[Any, Any]) -> dict[str, float] | None:
    if not np.isfinite(size).any():
        return None
    k = int(np.nanargmax(size))
    return {"peak_to_peak_um": float(size[k]), "speed_rpm": float(speeds[k])}


def _limit_um(operating: Sequence[Operating]) -> float | None:
    if not operating:
        return None
    fastest = max(o.to_rpm for o in operating)
    return _UM_PER_M * vibration_limit_m(fastest)
