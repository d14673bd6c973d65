"""Bodies that do not bend alike in all directions, in the frame that turns with them.

In: matrices of a body in its own frame, and what holds it at rest. Out: exponents and multipliers
of Floquet, motions by Hill's method, unstable ranges of speed by both.
"""

from __future__ import annotations

from solidwhirl.rotordyn.asymmetric.exponents import floquet_exponents
from solidwhirl.rotordyn.asymmetric.floquet import floquet_multipliers
from solidwhirl.rotordyn.asymmetric.hill import hill_block
from solidwhirl.rotordyn.asymmetric.instability import (
    UnstableRange,
    closed_by_damping,
    unstable_ranges,
)
from solidwhirl.rotordyn.asymmetric.meetings import Meeting
from solidwhirl.rotordyn.asymmetric.periodic import Joint, PeriodicSystem, turning_body

__all__ = [
    "Joint",
    "Meeting",
    "PeriodicSystem",
    "UnstableRange",
    "closed_by_damping",
    "floquet_exponents",
    "floquet_multipliers",
    "hill_block",
    "turning_body",
    "unstable_ranges",
]
