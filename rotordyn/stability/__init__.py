"""Where a motion grows by itself.

Eigenvalues as continuous paths over the speed; every crossing of the axis is bracketed.
In: `AssembledSystem` and a range. Out: unstable intervals, decrements of the first modes.
"""

from __future__ import annotations

from solidwhirl.rotordyn.stability.intervals import (
    StabilityChart,
    UnstableInterval,
    represented_hz,
    stability_chart,
    unstable_intervals,
)
from solidwhirl.rotordyn.stability.whirl_decrements import (
    FirstMode,
    WhirlDecrements,
    whirl_decrements,
)

__all__ = [
    "FirstMode",
    "StabilityChart",
    "UnstableInterval",
    "WhirlDecrements",
    "represented_hz",
    "stability_chart",
    "unstable_intervals",
    "whirl_decrements",
]
