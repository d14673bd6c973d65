"""Stability of a system over its range of speeds, and at its operating speeds, as plain data."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from solidwhirl.operating import Operating
from solidwhirl.rotordyn import AssembledSystem
from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.stability import (
    StabilityChart,
    UnstableInterval,
    WhirlDecrements,
    unstable_intervals,
    whirl_decrements,
)
from solidwhirl.scene import Scene
from solidwhirl.scene_analyses import StabilitySpec

RPM = 30.0 / math.pi
# Frequencies of a stability analysis, per turn of the fastest body.
_ORDERS = 3.0
# So slow that a system is as at rest.
_REST_RAD_S = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False)
class Stability:
    """Where a system is unstable, and how its first modes are damped where it operates.

    Attributes
    ----------
    low_rpm, high_rpm
        Range of speeds looked at, of the reference shaft.
    intervals
        Where it is unstable, by rising speed.
    at_operating
        Entries of `at_operating`, one for each end of the operating speeds of each shaft.
    """

    low_rpm: float
    high_rpm: float
    intervals: tuple[UnstableInterval, ...]
    at_operating: tuple[dict[str, Any], ...]

    @property
    def stable(self) -> bool:
        """Whether nothing grows in the whole range."""
        return not self.intervals

    @property
    def unstable_from_rpm(self) -> float | None:
        """Lowest speed at which something grows; None if nothing does."""
        return min((i.low_rad_s * RPM for i in self.intervals), default=None)


def stability_of(
    system: AssembledSystem, high_rpm: float, operating: Sequence[Operating]
) -> Stability:
    """Look for instability from rest to the highest speed, and at operating speeds.

    Parameters
    ----------
    system
        The system.
    high_rpm
        Highest speed of the reference shaft.
    operating
        From `operating_speeds`.
    """
    intervals = intervals_up_to(system, high_rpm)
    return Stability(
        low_rpm=0.0,
        high_rpm=high_rpm,
        intervals=intervals,
        at_operating=at_operating(system, operating, intervals),
    )


def intervals_up_to(system: AssembledSystem, high_rpm: float) -> tuple[UnstableInterval, ...]:
    """Return the unstable intervals from rest to a speed of the reference shaft."""
    return unstable_intervals(system, 0.0, max(high_rpm / RPM, _REST_RAD_S))


def interval_document(interval: UnstableInterval) -> dict[str, Any]:
    """Return an unstable interval as plain data; speeds of the reference shaft."""
    return {
        "from_rpm": interval.low_rad_s * RPM,
        "to_rpm": interval.high_rad_s * RPM,
        "opens": interval.opens,
        "closes": interval.closes,
        "kind": interval.kind,
        "largest_growth_rate_per_s": interval.growth_1_s,
        "largest_growth_at_rpm": interval.speed_rad_s * RPM,
        "frequency_hz": interval.frequency_hz,
        "whirl": interval.whirl or None,
    }


def interval_text(interval: UnstableInterval) -> str:
    """Return an unstable interval as one line, rpm first."""
    low, high = interval.low_rad_s * RPM, interval.high_rad_s * RPM
    text = f"{low:.6g} to {high:.6g} rpm: unstable"
    if not interval.closes:
        text = f"{low:.6g} rpm: unstable from here on"
    if interval.kind == "divergence":
        return f"{text} (divergence)"
    whirl = f"{interval.whirl} whirl, " if interval.whirl else ""
    return f"{text} (flutter, {whirl}{interval.frequency_hz:.4g} Hz)"


def covering(
    intervals: Sequence[UnstableInterval], low_rpm: float, high_rpm: float
) -> tuple[UnstableInterval, ...]:
    """Return the unstable intervals that a range of speeds of the reference shaft touches."""
    return tuple(
        i for i in intervals if i.low_rad_s * RPM <= high_rpm and low_rpm <= i.high_rad_s * RPM
    )


def at_operating(
    system: AssembledSystem,
    operating: Sequence[Operating],
    intervals: Sequence[UnstableInterval],
) -> tuple[dict[str, Any], ...]:
    """Return the damping of the first modes at both ends of all operating speeds.

    Parameters
    ----------
    system
        The system.
    operating
        From `operating_speeds`.
    intervals
        Where the system is unstable.
    """
    ends = [(o, rpm) for o in operating for rpm in dict.fromkeys((o.from_rpm, o.to_rpm))]
    if not ends:
        return ()
    speeds = np.array([rpm / o.ratio / RPM for o, rpm in ends])
    found = whirl_document(whirl_decrements(system, speeds))
    return tuple(
        {
            "shaft": o.shaft,
            "shaft_speed_rpm": rpm,
            "speed_rpm": rpm / o.ratio,
            "stable": not covering(intervals, rpm / o.ratio, rpm / o.ratio),
            **{
                key: {name: values[k] for name, values in found[key].items()}
                for key in ("first_forward", "first_backward")
            },
        }
        for k, (o, rpm) in enumerate(ends)
    )


def whirl_document(found: WhirlDecrements | StabilityChart) -> dict[str, Any]:
    """Return decrement and frequency of the first forward and backward mode over the speed."""
    return {
        key: {
            "log_decrement": decrements(own.log_decrement),
            "frequency_hz": own.frequency_hz.tolist(),
        }
        for key, own in (
            ("first_forward", found.first_forward),
            ("first_backward", found.first_backward),
        )
    }


def highest_frequency_hz(scene: Scene, spec: StabilitySpec) -> float:
    """Return up to which frequency modes are looked at where the analysis does not say.

    That of the Campbell diagram where it has one, else three times per turn of the fastest body.
    """
    if scene.campbell.frequency_max_hz is not None:
        return scene.campbell.frequency_max_hz
    fastest = max(abs(ratio) for ratio in scene.speed_ratios().values())
    return _ORDERS * (fastest or 1.0) * spec.to_rpm / 60.0


def stability_headline(stability: Stability, document: Mapping[str, Any]) -> str:
    """Return what an engineer acts on: the first unstable range, or the least damping.

    Parameters
    ----------
    stability
        Of the range of speeds.
    document
        `smallest_log_decrement` and `speed_rpm` of the analysis.
    """
    if stability.intervals:
        return "; ".join(interval_text(i) for i in stability.intervals)
    head = f"stable up to {stability.high_rpm:.6g} rpm"
    for entry in stability.at_operating:
        own = entry["first_forward"]
        if own["log_decrement"] is not None and np.isfinite(own["log_decrement"]):
            head += (
                f"; log decrement {own['log_decrement']:.3g} of the first forward mode "
                f"({own['frequency_hz']:.4g} Hz) at {entry['shaft_speed_rpm']:.6g} rpm "
                f"of {entry['shaft']}"
            )
    return head


def decrements(values: FloatArray) -> list[Any]:
    """Return logarithmic decrements as plain data: rounding (exactly 0) is null."""
    array = np.asarray(values, dtype=float)
    plain: list[Any] = np.where(array == 0.0, np.nan, array).tolist()
    return plain
