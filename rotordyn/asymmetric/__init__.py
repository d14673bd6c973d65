"""Bodies that do not bend alike in all directions, in the frame that turns with them.

In: an engine with such bodies, or matrices of one in its own frame and what holds it at rest. Out:
motions and unstable ranges of speed by Hill's method, Floquet multipliers, run-ups in time.
"""

from __future__ import annotations

from solidwhirl.rotordyn.asymmetric.assembly import RotatingSystem, assemble_rotating, at_rest
from solidwhirl.rotordyn.asymmetric.floquet import floquet_multipliers
from solidwhirl.rotordyn.asymmetric.growth import (
    FittedGrowth,
    GrowthEnd,
    fitted_growth,
    growth_end,
)
from solidwhirl.rotordyn.asymmetric.hill import hill_block
from solidwhirl.rotordyn.asymmetric.instability import (
    UnstableRange,
    closed_by_damping,
    unstable_ranges,
)
from solidwhirl.rotordyn.asymmetric.periodic import Joint, PeriodicSystem, turning_body
from solidwhirl.rotordyn.asymmetric.run_up import run_up_rotating

__all__ = [
    "FittedGrowth",
    "GrowthEnd",
    "Joint",
    "PeriodicSystem",
    "RotatingSystem",
    "UnstableRange",
    "assemble_rotating",
    "at_rest",
    "closed_by_damping",
    "fitted_growth",
    "floquet_multipliers",
    "growth_end",
    "hill_block",
    "run_up_rotating",
    "turning_body",
    "unstable_ranges",
]
