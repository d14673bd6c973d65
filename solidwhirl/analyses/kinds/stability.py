"""Damping of the first modes over the speed, and where the engine is unstable."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from solidwhirl.analyses.base import (
    Engine,
    Points,
    Sweep,
    decrements,
)
from solidwhirl.analyses.stability_summary import (
    Stability,
    interval_document,
    interval_text,
    stability_of,
    whirl_document,
)
from solidwhirl.core.fields import (
    Positive,
)
from solidwhirl.core.outcome import Outcome
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.stability.intervals import stability_chart


class StabilitySpec(Sweep):
    """Smallest damping over the speed and where the engine becomes unstable."""

    kind: Literal["stability"]
    count: Points = 61
    frequency_max_hz: Positive | None = None

    def run(self, engine: Engine) -> Outcome:
        """Damping of the first modes over the speed, and where the engine.system is unstable."""
        speeds = self.speeds_rad_s
        highest = self.frequency_max_hz or _highest_frequency_hz(engine, self)
        chart = stability_chart(engine.system, speeds, highest)
        stability = stability_of(engine.system, self.to_rpm, engine.operating)
        first = stability.intervals[0] if stability.intervals else None
        document: dict[str, Any] = {
            "speed_rpm": (speeds * RPM_PER_RAD_S).tolist(),
            "frequency_max_hz": highest,
            "smallest_log_decrement": decrements(chart.log_decrement),
            "frequency_hz": chart.frequency_hz.tolist(),
            "largest_growth_rate_per_s": chart.growth_rate_1_s.tolist(),
            "growing_motions": chart.unstable_count.tolist(),
            **whirl_document(chart),
            "at_operating": list(stability.at_operating),
            "unstable_intervals": [interval_document(i) for i in stability.intervals],
            "threshold": None
            if first is None
            else {
                "speed_rpm": first.low_rad_s * RPM_PER_RAD_S,
                "kind": first.kind,
                "frequency_hz": first.frequency_hz,
            },
        }
        return Outcome(
            kind=self.kind, document=document, headline=_stability_headline(stability, document)
        )


# Frequencies of a stability analysis, per turn of the fastest body.
_ORDERS = 3.0


def _highest_frequency_hz(engine: Engine, spec: StabilitySpec) -> float:
    """Return up to which frequency modes are looked at where the analysis does not say.

    That of the Campbell diagram where it has one, else three times per turn of the fastest body.
    """
    if engine.campbell_max_hz is not None:
        return engine.campbell_max_hz
    fastest = max(abs(ratio) for ratio in engine.speed_ratios.values())
    return _ORDERS * (fastest or 1.0) * spec.to_rpm / 60.0


def _stability_headline(stability: Stability, document: Mapping[str, Any]) -> str:
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
