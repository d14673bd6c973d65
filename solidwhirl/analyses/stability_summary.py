"""Stability over the range of speeds and at the operating speeds, as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from solidwhirl.analyses.base import Operating, Stability, decrements
from solidwhirl.rotordyn import AssembledSystem
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.plots.chart import whirl_name
from solidwhirl.rotordyn.stability.intervals import (
    StabilityChart,
    UnstableInterval,
    unstable_intervals,
)
from solidwhirl.rotordyn.stability.whirl_decrements import WhirlDecrements, whirl_decrements

# So slow that a system is as at rest.
_REST_RAD_S = 1e-6


def stability_of(
    system: AssembledSystem,
    high_rpm: float,
    operating: Sequence[Operating],
    intervals: tuple[UnstableInterval, ...],
) -> Stability:
    """Return the stability from rest to the highest speed, and at operating speeds.

    `operating`: from `operating_speeds`. `intervals`: from `intervals_up_to` that speed.
    """
    damping = _at_operating(system, operating, intervals)
    return Stability(low_rpm=0.0, high_rpm=high_rpm, intervals=intervals, at_operating=damping)


def intervals_up_to(system: AssembledSystem, high_rpm: float) -> tuple[UnstableInterval, ...]:
    """Return the unstable intervals from rest to a speed of the reference shaft."""
    return unstable_intervals(system, 0.0, max(high_rpm / RPM_PER_RAD_S, _REST_RAD_S))


def interval_document(interval: UnstableInterval) -> dict[str, Any]:
    """Return an unstable interval as plain data; speeds of the reference shaft."""
    return {
        "from_rpm": interval.low_rad_s * RPM_PER_RAD_S,
        "to_rpm": interval.high_rad_s * RPM_PER_RAD_S,
        "opens": interval.opens,
        "closes": interval.closes,
        "kind": interval.kind,
        "largest_growth_rate_per_s": interval.growth_1_s,
        "largest_growth_at_rpm": interval.speed_rad_s * RPM_PER_RAD_S,
        "frequency_hz": interval.frequency_hz,
        "whirl": interval.whirl or None,
    }


def interval_text(interval: UnstableInterval) -> str:
    """Return an unstable interval as one line, rpm first."""
    low, high = interval.low_rad_s * RPM_PER_RAD_S, interval.high_rad_s * RPM_PER_RAD_S
    text = f"{low:.6g} to {high:.6g} rpm: unstable"
    if not interval.closes:
        text = f"{low:.6g} rpm: unstable from here on"
    if interval.kind == "divergence":
        return f"{text} (divergence)"
    whirl = f"{whirl_name(interval.whirl)}, " if interval.whirl else ""
    return f"{text} (flutter, {whirl}{interval.frequency_hz:.4g} Hz)"


def covering(
    intervals: Sequence[UnstableInterval], low_rpm: float, high_rpm: float
) -> tuple[UnstableInterval, ...]:
    """Return the unstable intervals that a range of speeds of the reference shaft touches."""
    return tuple(
        i
        for i in intervals
        if i.low_rad_s * RPM_PER_RAD_S <= high_rpm and low_rpm <= i.high_rad_s * RPM_PER_RAD_S
    )


def _at_operating(
    system: AssembledSystem,
    operating: Sequence[Operating],
    intervals: Sequence[UnstableInterval],
) -> tuple[dict[str, Any], ...]:
    """Damping of the first modes at both ends of all operating speeds."""
    ends = [(o, rpm) for o in operating for rpm in dict.fromkeys((o.from_rpm, o.to_rpm))]
    if not ends:
        return ()
    speeds = np.array([rpm / o.ratio / RPM_PER_RAD_S for o, rpm in ends])
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
