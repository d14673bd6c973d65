"""The row of a case, from the document of its results or from what stopped it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Literal

from solidwhirl.analyses.base import largest_of
from solidwhirl.analyses.registry import KINDS
from solidwhirl.console.summary import warning_texts
from solidwhirl.core.errors import clean, one_line
from solidwhirl.scene_checks.operating import critical_speeds_that_count
from solidwhirl.sweep.records import BatchCase, BatchRow

_NAN = float("nan")


def row_of_document(
    case: BatchCase, document: Mapping[str, Any], seconds: float, ranks: int
) -> BatchRow:
    """Return the row of a case from the document of its results.

    `document`: what `results.json` holds (`solidwhirl.output.documents.results_document`).
    `seconds`, `ranks`: wall time and processes.
    """
    failures = [c for c in document["invariants"] if c["passed"] is False]
    critical = sorted(critical_speeds_that_count(document), key=lambda c: _number(c["speed_rpm"]))
    diagram = document["campbell"]
    status: Literal["done", "checks_failed"] = "checks_failed" if failures else "done"
    return BatchRow(
        **_identity(case),
        status=status,
        message="; ".join(
            [f"check failed: {c['where']}: {c['name']}" for c in failures]
            + [f"not estimated: {n}" for n in document["verdict"]["accuracy"]["not_estimated"]]
        ),
        warnings=tuple(one_line(text) for text in warning_texts(document)),
        seconds=seconds,
        peak_memory_gib=_number(document["peak_memory_gib"]),
        ranks=ranks,
        critical_speed_rpm=_numbers(c["speed_rpm"] for c in critical),
        critical_frequency_hz=_numbers(c["frequency_hz"] for c in critical),
        critical_whirl=tuple(str(c["whirl"] or "") for c in critical),
        critical_kind=tuple(str(c["kind"]) for c in critical),
        critical_error_estimate=_numbers(c.get("frequency_error_estimate") for c in critical),
        critical_motion=tuple(
            _numbers(c["interface_motion"]) for c in critical if "interface_motion" in c
        ),
        campbell_speed_rpm=_numbers(diagram["speed_rpm"]),
        campbell_frequency_hz=tuple(_numbers(b) for b in diagram["frequency_hz"]),
        campbell_log_decrement=tuple(
            _decrements(*branch)
            for branch in zip(diagram["frequency_hz"], diagram["log_decrement"], strict=True)
        ),
        campbell_motion=tuple(_numbers(b) for b in diagram.get("interface_motion", ())),
        responses={**responses_of(document["analyses"]), **verdict_scalars(document["verdict"])},
    )


def failed_row(
    case: BatchCase,
    message: str,
    seconds: float,
    ranks: int,
    peak_memory_gib: float,
    *,
    said: Iterable[str] = (),
) -> BatchRow:
    """Return the row of a case that came to nothing; `said`: what its run told before."""
    head = "warning: "
    return BatchRow(
        **_identity(case),
        status="failed",
        message=clean(message),
        warnings=tuple(one_line(s).removeprefix(head) for s in said if s.startswith(head)),
        seconds=seconds,
        ranks=ranks,
        peak_memory_gib=peak_memory_gib,
    )


def responses_of(analyses: Mapping[str, Any]) -> dict[str, float]:
    """Return the scalars of analyses by `<analysis>.<quantity>`; what is absent is left out."""
    found = {}
    for name, analysis in analyses.items():
        for key, value in KINDS[analysis["kind"]].scalars(analysis):
            number = _number(value)
            if number == number:
                found[f"{name}.{key}".replace("/", "_")] = number
    return found


def verdict_scalars(verdict: Mapping[str, Any]) -> dict[str, float]:
    """Return what a design review asks for as `verdict.<quantity>`; what is absent is left out."""
    first = [end["first_forward"] for end in verdict["at_operating"]]
    forward = _decrements([f["frequency_hz"] for f in first], [f["log_decrement"] for f in first])
    swings = [v["at_operating"] or {} for v in verdict["vibration"]]
    found = {
        "stable": verdict["stable"],
        "unstable_from_rpm": verdict["unstable_from_rpm"],
        "first_forward_log_decrement": min((d for d in forward if d == d), default=None),
        "margins_passed": verdict["margins"]["passed"],
        "margins_decided": verdict["margins"]["decided"],
        "accuracy_met": verdict["accuracy"]["met"],
        "largest_vibration_um": largest_of(s.get("peak_to_peak_um") for s in swings),
    }
    return {f"verdict.{key}": float(value) for key, value in found.items() if value is not None}


def _identity(case: BatchCase) -> dict[str, Any]:
    scene = str(case.data.get("name", case.name))
    own = {key: getattr(case, key) for key in ("values", "digest", "method", "sweep_cases")}
    return {"case": case.name, "scene": scene, **own}


def _number(value: Any) -> float:
    return _NAN if value is None else float(value)


def _numbers(values: Iterable[Any]) -> tuple[float, ...]:
    return tuple(_number(v) for v in values)


def _decrements(frequency_hz: Iterable[Any], decrements: Iterable[Any]) -> tuple[float, ...]:
    """Decrements of a branch: 0 where it vibrates without damping, nan where it is absent."""
    pairs = zip(frequency_hz, decrements, strict=True)
    return tuple(0.0 if d is None and f is not None else _number(d) for f, d in pairs)
