"""Alarms of a run: one line for each cause, the speed in rpm first."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from solidwhirl.analyses.base import Operating, Stability, given_speeds
from solidwhirl.analyses.stability_summary import covering, interval_text
from solidwhirl.core.joint_states import JointState
from solidwhirl.rotordyn.campbell.branches import TrackingNote
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.stability.intervals import UnstableInterval

# Around the speed at which a stiffness is lost, as far as that and an onset are found.
_AROUND = (0.999, 1.001)


@dataclass(frozen=True, kw_only=True)
class Alarm:
    """Something physical that the results warn of."""

    #: "unstable", "unstable operation", "response above threshold" (run-ups too), "run-up
    #: diverged", "compared model diverged", "meets order 1", "steep law" or "joint lifts"
    kind: str
    #: One line, rpm first
    message: str
    speed_rpm: float


def alarms_of(
    stability: Stability, operating: Sequence[Operating], analyses: Mapping[str, Any]
) -> tuple[Alarm, ...]:
    """Return the alarms of a run, one for each onset: what else begins there is said with it.

    `analyses`: kind and document of each analysis by its name, as in `results.json`.
    """
    unstable = (
        *_unstable(stability),
        *_operation(stability, operating),
        *_responses(stability, analyses),
    )
    return (*_one_per_onset(unstable), *_run_ups(analyses))


def diagram_alarms(notes: Sequence[TrackingNote], stability: Stability) -> Iterator[Alarm]:
    """One line for each speed at which a stable mode stands still in space, and for steep laws.

    `notes`: of the Campbell diagram. The frequency of the mode is 1/rev in the axes of the shaft;
    where it is unstable from there on, that is said instead.
    """
    steep = [note for note in notes if note.kind == "steep law"]
    if steep:
        speed_rpm = min(note.speed_rad_s for note in steep) * RPM_PER_RAD_S
        yield Alarm(
            kind="steep law",
            message=f"{speed_rpm:.6g} rpm: the coefficients of a bearing rise with the frequency "
            "more steeply than those of a passive support can, and make a mode of their own "
            f"(branch {', '.join(str(note.branches[0] + 1) for note in steep)}); no verdict rests "
            "on it",
            speed_rpm=speed_rpm,
        )
    for note in notes:
        speed = note.speed_rad_s
        beyond = covering(stability.intervals, *(f * speed * RPM_PER_RAD_S for f in _AROUND))
        if note.kind == "indefinite" and speed > 0.0 and not beyond:
            yield Alarm(
                kind="meets order 1",
                message=f"{speed * RPM_PER_RAD_S:.6g} rpm: a mode stands still in space, at 1/rev "
                "in the axes of what turns: loads that stand still, such as weight, excite it",
                speed_rpm=speed * RPM_PER_RAD_S,
            )


def joint_alarms(body: str, ratio: float, joints: Sequence[JointState]) -> Iterator[Alarm]:
    """One line for each face of a body that lifts up to its largest speed.

    `ratio`: of the body's speed to that of the reference shaft, which alarms are told at.
    """
    for joint in joints:
        first, top = joint.lifts_at_rad_s, float(joint.speeds_rad_s[-1])
        if first is None or first > top:
            continue
        scale = RPM_PER_RAD_S / abs(ratio or 1.0)
        yield Alarm(
            kind="joint lifts",
            message=f"{scale * first:.6g} rpm: the face of {joint.between[1]} on "
            f"{joint.between[0]} ({body}) begins to lift; "
            f"{100.0 * joint.lifted_part[-1]:.2g} % of it is open at {scale * top:.6g} rpm",
            speed_rpm=scale * first,
        )


def _one_per_onset(alarms: Sequence[Alarm]) -> Iterator[Alarm]:
    """Join those that begin at one speed; a shaft that operates there makes the kind."""
    for onset in sorted({alarm.speed_rpm for alarm in alarms}):
        first, *others = (alarm for alarm in alarms if alarm.speed_rpm == onset)
        more = [alarm.message.partition(": ")[2] for alarm in others]
        kinds = {alarm.kind for alarm in (first, *others)}
        yield Alarm(
            kind="unstable operation" if "unstable operation" in kinds else first.kind,
            message="; ".join([first.message, *more]),
            speed_rpm=onset,
        )


def _unstable(stability: Stability) -> Iterator[Alarm]:
    for interval in stability.intervals:
        yield Alarm(
            kind="unstable",
            message=interval_text(interval),
            speed_rpm=interval.low_rad_s * RPM_PER_RAD_S,
        )


def _operation(stability: Stability, operating: Sequence[Operating]) -> Iterator[Alarm]:
    """One line for each shaft that operates where the system is unstable."""
    for own in given_speeds(operating):
        low, high = own.reference_rpm
        found = covering(stability.intervals, low, high)
        if found:
            begins = max(found[0].low_rad_s * RPM_PER_RAD_S, low)
            yield Alarm(
                kind="unstable operation",
                message=f"{begins * own.ratio:.6g} rpm: {own.shaft} operates at {own.speeds_text} "
                f"and is unstable {_extent(found, high, own.ratio)}",
                speed_rpm=begins,
            )


def _extent(found: Sequence[UnstableInterval], high_rpm: float, ratio: float = 1.0) -> str:
    """How far unstable intervals reach in speeds up to one of the reference shaft."""
    if len(found) > 1:
        return "from here on, in parts"
    end = found[0].high_rad_s * RPM_PER_RAD_S
    return "from here on" if end >= high_rpm else f"up to {end * ratio:.6g} rpm"


def _responses(stability: Stability, analyses: Mapping[str, Any]) -> Iterator[Alarm]:
    """Linear responses exist where the system is unstable, but no rotor runs there."""
    ranges = {name: own for name, entry in analyses.items() if (own := _speeds(entry))}
    reached = {n: own for n, own in ranges.items() if covering(stability.intervals, *own)}
    if reached:
        low, high = min(own[0] for own in reached.values()), max(own[1] for own in reached.values())
        found = covering(stability.intervals, low, high)
        first, names = max(low, found[0].low_rad_s * RPM_PER_RAD_S), " and ".join(reached)
        yield Alarm(
            kind="response above threshold",
            message=f"{first:.6g} rpm: no steady vibration exists {_extent(found, high)}, although "
            f"{names} goes there",
            speed_rpm=first,
        )


def _speeds(entry: Mapping[str, Any]) -> tuple[float, float] | None:
    """Lowest and highest speed of the reference shaft in a response or a run-up."""
    if entry["kind"] == "unbalance_response":
        speeds = entry["speed_rpm"]
        return min(speeds), max(speeds)
    if entry["kind"] == "run_up" and not entry.get("diverged"):
        return 0.0, entry["to_rpm"]
    return None


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
