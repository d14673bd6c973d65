"""The row of a case, from the document of its results or from what stopped it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, Literal

from solidwhirl.core.errors import clean
from solidwhirl.scene_checks.operating import critical_speeds_that_count
from solidwhirl.sweep.records import BatchCase, BatchRow

_NAN = float("nan")
Scalars = Iterator[tuple[str, float | None]]


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
            + [alarm["message"] for alarm in document["verdict"]["alarms"]]
        ),
        seconds=seconds,
        peak_memory_gib=_number(document["peak_memory_gib"]),
        ranks=ranks,
        critical_speed_rpm=_numbers(c["speed_rpm"] for c in critical),
        critical_frequency_hz=_numbers(c["frequency_hz"] for c in critical),
        critical_whirl=tuple(str(c["whirl"] or "") for c in critical),
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
    case: BatchCase, message: str, seconds: float, ranks: int, peak_memory_gib: float
) -> BatchRow:
    """Return the row of a case that came to nothing."""
    return BatchRow(
        **_identity(case),
        status="failed",
        message=clean(message),
        seconds=seconds,
        ranks=ranks,
        peak_memory_gib=peak_memory_gib,
    )


def responses_of(analyses: Mapping[str, Any]) -> dict[str, float]:
    """Return the scalars of analyses by `<analysis>.<quantity>`; what is absent is left out."""
    found = {}
    for name, analysis in analyses.items():
        scalars = _SCALARS.get(analysis["kind"])
        for key, value in scalars(analysis) if scalars else ():
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
        "largest_vibration_um": _largest(s.get("peak_to_peak_um") for s in swings),
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


def _largest(values: Iterable[Any]) -> float | None:
    return max((float(v) for v in values if v is not None), default=None)


def _smallest(values: Iterable[Any]) -> float | None:
    return min((float(v) for v in values if v is not None), default=None)


def _highest(peaks: Sequence[Mapping[str, Any]]) -> Mapping[str, Any]:
    """The peak of the largest amplitude; nothing where there is none."""
    return max(peaks, key=lambda p: _number(p["amplitude_m"]), default={})


def _peak(where: str, peaks: Sequence[Mapping[str, Any]]) -> Scalars:
    highest = _highest(peaks)
    yield f"{where}.peak_amplitude_m", highest.get("amplitude_m")
    yield f"{where}.peak_speed_rpm", highest.get("speed_rpm")
    yield f"{where}.peak_amplification", highest.get("amplification")


def _unbalance_response(analysis: Mapping[str, Any]) -> Scalars:
    """Bodies of other speeds excite apart: their names tell the responses from each other."""
    exciters = analysis["exciters"]
    for exciter in exciters:
        mark = f"{'+'.join(exciter['bodies'])}." if len(exciters) > 1 else ""
        for place, orbit in exciter["places"].items():
            yield f"{mark}{place}.largest_amplitude_m", _largest(orbit["major_m"])
            yield from _peak(f"{mark}{place}", exciter["peaks"].get(place, ()))
        for bearing, force in exciter["bearing_force_n"].items():
            yield f"{mark}{bearing}.largest_force_n", _largest(force)


def _place_map(analysis: Mapping[str, Any]) -> Scalars:
    for place, amplitudes in zip(analysis["places"], analysis["amplitude_m"], strict=True):
        yield f"{place}.largest_amplitude_m", _largest(amplitudes)
        yield from _peak(place, analysis["peaks"].get(place, ()))


def _waterfall(analysis: Mapping[str, Any]) -> Scalars:
    where = analysis["observed"]
    yield (
        f"{where}.largest_amplitude_m",
        _largest(a for row in analysis["highest_m"] for a in row),
    )


def _stiffness_study(analysis: Mapping[str, Any]) -> Scalars:
    for key in ("chosen_stiffness_n_per_m", "chosen_amplitude_m"):
        yield key, analysis[key]


def _separation_margins(analysis: Mapping[str, Any]) -> Scalars:
    """Distance of the nearest excited critical speed, and what of it is left beyond what is asked.

    Nothing is left where no margin would be enough: that number is infinite, and left out.
    """
    yield "passed", float(analysis["verdict"]["passed"])
    for shaft in dict.fromkeys(entry["shaft"] for entry in analysis["operating"]):
        own = [m for m in analysis["margins"] if m["shaft"] == shaft and m["excited"]]
        yield f"{shaft}.smallest_margin", _smallest(abs(m["margin"]) for m in own)
        missed = [m for m in own if m["verdict_api_617"] != "ok"]
        yield f"{shaft}.missed_margins_api_617", len(missed)
        if all(m["required_api_617"] is not None for m in own):
            left = [abs(m["margin"]) - m["required_api_617"] for m in own]
            yield f"{shaft}.smallest_excess_api_617", _smallest(left)


def _stability(analysis: Mapping[str, Any]) -> Scalars:
    undamped = _decrements(analysis["frequency_hz"], analysis["smallest_log_decrement"])
    yield "smallest_log_decrement", _smallest(d for d in undamped if d == d)
    yield "largest_growth_rate_per_s", _largest(analysis["largest_growth_rate_per_s"])
    yield "threshold_speed_rpm", (analysis["threshold"] or {}).get("speed_rpm")


def _run_up(analysis: Mapping[str, Any]) -> Scalars:
    yield f"{analysis['mount']}.largest_force_n", analysis["largest_mount_force_n"]


def _recovery(analysis: Mapping[str, Any]) -> Scalars:
    for state in analysis["states"]:
        for body, found in state["bodies"].items():
            where = f"{state['state']}.{body}"
            yield f"{where}.largest_displacement_m", found.get("largest_displacement_m")
            for part in ("dynamic", "steady", "total"):
                stress = found.get(part) or {}
                yield f"{where}.{part}_largest_von_mises_pa", stress.get("largest_von_mises_pa")


_SCALARS: Mapping[str, Callable[[Mapping[str, Any]], Scalars]] = {
    "unbalance_response": _unbalance_response,
    "place_map": _place_map,
    "waterfall": _waterfall,
    "stiffness_study": _stiffness_study,
    "separation_margins": _separation_margins,
    "stability": _stability,
    "run_up": _run_up,
    "recovery": _recovery,
}
