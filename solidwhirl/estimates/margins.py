"""Separation margins with the errors of their critical speeds: what they decide."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from solidwhirl.core.outcome import Outcome
from solidwhirl.estimates.results import Estimates

# A critical speed of the run is that of a margin if its frequency is as near (relative).
_SAME = 1e-6


def with_margin_estimates(outcome: Outcome, estimates: Estimates | None) -> Outcome:
    """Put the errors of critical speeds beside separation margins, and whether these decide.

    `error_estimate` of a margin: of its critical speed; beyond the speeds of the run the largest of
    all. `decided` of the verdict: whether it holds wherever the speeds are within their errors;
    None where they are not estimated. Other analyses come back as they are.
    """
    if outcome.kind != "separation_margins":
        return outcome
    document = outcome.document
    rows = [row | {"error_estimate": _error(row, estimates)} for row in document["margins"]]
    judged = [row for row in rows if row["excited"]]
    decided: bool | None = None
    if estimates is not None and not estimates.campbell.bodies_without_estimate:
        firm = [row for row in judged if _is_firm(row)]
        decided = len(firm) == len(judged)
        if not document["verdict"]["passed"]:
            decided = any(abs(r["margin"]) < (r["required"] or np.inf) for r in firm)
    verdict = document["verdict"] | {"decided": decided}
    worth = {
        True: "",
        False: "; not decided, as the estimated errors of the critical speeds exceed what is left",
        None: "; the critical speeds carry no error estimate",
    }[decided]
    verdict["why"] += worth
    return replace(
        outcome,
        document={**document, "margins": rows, "verdict": verdict},
        headline=outcome.headline + worth,
    )


def _error(row: Mapping[str, Any], estimates: Estimates | None) -> float | None:
    if estimates is None or estimates.campbell.bodies_without_estimate:
        return None
    for critical, error in zip(estimates.critical, estimates.critical_speeds.total, strict=True):
        # the shaft excites at its own speed
        if abs(60.0 * critical.frequency_hz / row["critical_speed_rpm"] - 1.0) <= _SAME:
            return float(error)
    return estimates.largest


def _is_firm(row: Mapping[str, Any]) -> bool:
    """Whether a margin is kept, or missed, wherever the critical speed is within its error."""
    moves = row["error_estimate"] * row["critical_speed_rpm"] / row["operating_speed_rpm"]
    return row["required"] is None or abs(abs(row["margin"]) - row["required"]) > moves
