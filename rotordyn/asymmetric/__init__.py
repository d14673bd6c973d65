"""Bodies that do not bend alike in all directions, in the frame that turns with them.

In: matrices of a body in its own frame, and what holds it at rest. Out: motions and unstable ranges
of speed by Hill's method, Floquet multipliers.
"""

from __future__ import annotations

from solidwhirl.rotordyn.asymmetric.assembly import RotatingSystem, assemble_rotating, at_rest
from solidwhirl.rotordyn.asymmetric.floquet import floquet_multipliers
from solidwhirl.rotordyn.asymmetric.hill import hill_block
from solidwhirl.rotordyn.asymmetric.instability import UnstableRange, unstable_ranges
from solidwhirl.rotordyn.asymmetric.periodic import Joint, PeriodicSystem, turning_body

__all__ = [
    "Joint",
    "PeriodicSystem",
    "RotatingSystem",
    "UnstableRange",
    "assemble_rotating",
    "at_rest",
    "floquet_multipliers",
    "hill_block",
    "turning_body",
    "unstable_ranges",
]
