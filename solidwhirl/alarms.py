"""Alarms of a run: one line for each cause, the speed in rpm first."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from solidwhirl.operating import Operating
from solidwhirl.stability_documents import RPM, Stability, covering, interval_text


@dataclass(frozen=True, kw_only=True)
class Alarm:
    """Something physical that the results warn of.

    Attributes
    ----------
    kind
        "unstable", "unstable operation", "response above threshold" (run-ups too) or "run-up
        diverged".
    message
        One line, rpm first.
    speed_rpm
        Of the reference shaft, where it begins.
    """

    kind: str
    message: str
    speed_rpm: float


def alarms_of(
    stability: Stability, operating: Sequence[Operating], analyses: Mapping[str, Any]
) -> tuple[Alarm, ...]:
    """Return the alarms of a run.

    Parameters
    ----------
    stability
        Of the range of speeds.
    operating
        From `operating_speeds`.
    analyses
        Kind and document of each analysis by its name, as in `results.json`.
    """
    return (
        *_unstable(stability),
        *_operation(stability, operating),
        *_responses(stability, analyses),
        *_run_ups(analyses),
    )


def _unstable(stability: Stability) -> Iterator[Alarm]:
    for interval in stability.intervals:
        yield Alarm(
            kind="unstable",
            message=interval_text(interval),
            speed_rpm=interval.low_rad_s * RPM,
        )


def _operation(stability: Stability, operating: Sequence[Operating]) -> Iterator[Alarm]:
    """One line for each shaft that operates where the system is unstable."""
    for own in operating:
        low, high = own.reference_rpm
        found = covering(stability.intervals, low, high)
        if found:
            begins = max(found[0].low_rad_s * RPM, low)
            yield Alarm(
                kind="unstable operation",
                message=f"{begins * own.ratio:.6g} rpm: {own.shaft} operates at {_range(own)} and "
                "is unstable from here on" + ("" if len(found) == 1 else ", in parts"),
                speed_rpm=begins,
            )


def _range(own: Operating) -> str:
    low, high = own.from_rpm, own.to_rpm
    return f"{high:g} rpm" if low == high else f"{low:g} to {high:g} rpm"


def _responses(stability: Stability, analyses: Mapping[str, Any]) -> Iterator[Alarm]:
    """Linear responses exist where the system is unstable, but no rotor runs there."""
    begins: dict[str, float] = {}
    for name, entry in analyses.items():
        reached = _reached(entry, stability)
        if reached is not None:
            begins[name] = reached
    if begins:
        first, names = min(begins.values()), " and ".join(begins)
        yield Alarm(
            kind="response above threshold",
            message=f"{first:.6g} rpm: no steady vibration exists from here on, although {names} "
            "goes beyond",
            speed_rpm=first,
        )


def _reached(entry: Mapping[str, Any], stability: Stability) -> float | None:
    """Lowest unstable speed of the reference shaft that a response or a run-up reaches."""
    if entry["kind"] == "unbalance_response":
        speeds = entry["speed_rpm"]
        low, high = min(speeds), max(speeds)
    elif entry["kind"] == "run_up" and not entry.get("diverged"):
        low, high = 0.0, entry["to_rpm"]
    else:
        return None
    found = covering(stability.intervals, low, high)
    return max(low, found[0].low_rad_s * RPM) if found else None


def _run_ups(analyses: Mapping[str, Any]) -> Iterator[Alarm]:
    for name, entry in analyses.items():
        stopped = entry.get("diverged") if entry["kind"] == "run_up" else None
        if stopped:
            yield Alarm(
                kind="run-up diverged",
                message=f"{stopped['speed_rpm']:.6g} rpm: {name} diverged and was stopped after "
                f"{stopped['time_s']:.4g} s at an amplitude of {stopped['amplitude_m']:.3g} m",
                speed_rpm=stopped["speed_rpm"],
            )
        models = entry.get("complexity", {}).get("diverged", ())
        if models:
            first = min(models, key=lambda model: float(model["speed_rpm"]))
            yield Alarm(
                kind="compared model diverged",
                message=f"{first['speed_rpm']:.6g} rpm: {name} is not compared with "
                + ", ".join(f"{m['name']!r}" for m in models)
                + f", which diverged and was stopped at {first['amplitude_m']:.3g} m",
                speed_rpm=first["speed_rpm"],
            )
