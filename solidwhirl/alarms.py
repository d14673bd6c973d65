"""Alarms of a run: one line for each cause, the speed in rpm first."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from solidwhirl.operating import Operating
from solidwhirl.stability_documents import Stability, covering, interval_text


@dataclass(frozen=True, kw_only=True)
class Alarm:
    """Something physical that the results warn of.

    Attributes
    ----------
    kind
        "unstable", "unstable operation", "response above threshold" or "run-up above threshold",
        "run-up diverged".
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
        *_run_ups(stability, analyses),
    )


def _unstable(stability: Stability) -> Iterator[Alarm]:
    for interval in stability.intervals:
        text = interval_text(interval)
        yield Alarm(
            kind="unstable",
            message=f"unstable {text}",
            speed_rpm=_rpm(interval.low_rad_s),
        )


def _operation(stability: Stability, operating: Sequence[Operating]) -> Iterator[Alarm]:
    for own in operating:
        low, high = own.reference_rpm
        found = covering(stability.intervals, low, high)
        if found:
            begins = max(_rpm(found[0].low_rad_s), low)
            yield Alarm(
                kind="unstable operation",
                message=f"{begins * own.ratio:.6g} rpm: {own.text}, reach into an unstable range",
                speed_rpm=begins,
            )


def _responses(stability: Stability, analyses: Mapping[str, Any]) -> Iterator[Alarm]:
    """Linear responses exist where the system is unstable, but no rotor runs there."""
    for name, entry in analyses.items():
        if entry["kind"] != "unbalance_response":
            continue
        speeds = [v for v in entry["speed_rpm"] if covering(stability.intervals, v, v)]
        if speeds:
            yield Alarm(
                kind="response above threshold",
                message=f"{min(speeds):.6g} rpm: the response {name} reaches into an unstable "
                "range, where no steady vibration exists",
                speed_rpm=min(speeds),
            )


def _run_ups(stability: Stability, analyses: Mapping[str, Any]) -> Iterator[Alarm]:
    for name, entry in analyses.items():
        if entry["kind"] != "run_up":
            continue
        stopped = entry.get("diverged")
        found = covering(stability.intervals, 0.0, entry["to_rpm"])
        if stopped:
            yield Alarm(
                kind="run-up diverged",
                message=f"{stopped['speed_rpm']:.6g} rpm: the run-up {name} diverged and was "
                f"stopped after {stopped['time_s']:.4g} s at an amplitude of "
                f"{stopped['amplitude_m']:.3g} m",
                speed_rpm=stopped["speed_rpm"],
            )
        elif found:
            begins = _rpm(found[0].low_rad_s)
            yield Alarm(
                kind="run-up above threshold",
                message=f"{begins:.6g} rpm: the run-up {name} passes an unstable range",
                speed_rpm=begins,
            )


def _rpm(speed_rad_s: float) -> float:
    return speed_rad_s * 30.0 / 3.141592653589793
