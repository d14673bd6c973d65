"""Bodies that do not bend alike in all directions, in the frame that turns with them.

In: an engine with such bodies, or matrices of one in its own frame and what holds it at rest. Out:
exponents and multipliers of Floquet, motions by Hill's method, unstable ranges of speed by both,
resonances, steady motion, response to motion of the ground, run-ups in time. A name is imported
when it is first asked for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from solidwhirl.rotordyn.core.later import import_later

if TYPE_CHECKING:
    from solidwhirl.rotordyn.asymmetric.assembly import RotatingSystem, assemble_rotating
    from solidwhirl.rotordyn.asymmetric.in_time.growth import (
        FittedGrowth,
        GrowthEnd,
        fitted_growth,
        growth_end,
    )
    from solidwhirl.rotordyn.asymmetric.in_time.run_up import run_up_rotating
    from solidwhirl.rotordyn.asymmetric.parametric.exponents import floquet_exponents
    from solidwhirl.rotordyn.asymmetric.parametric.floquet import floquet_multipliers
    from solidwhirl.rotordyn.asymmetric.parametric.hill import hill_block
    from solidwhirl.rotordyn.asymmetric.parametric.instability import (
        UnstableRange,
        closed_by_damping,
        unstable_ranges,
    )
    from solidwhirl.rotordyn.asymmetric.parametric.meetings import Meeting
    from solidwhirl.rotordyn.asymmetric.periodic import Joint, PeriodicSystem, turning_body
    from solidwhirl.rotordyn.asymmetric.standing import at_rest, standing_at

__all__ = [
    "FittedGrowth",
    "GrowthEnd",
    "Joint",
    "Meeting",
    "PeriodicSystem",
    "RotatingSystem",
    "UnstableRange",
    "assemble_rotating",
    "at_rest",
    "closed_by_damping",
    "fitted_growth",
    "floquet_exponents",
    "floquet_multipliers",
    "growth_end",
    "hill_block",
    "run_up_rotating",
    "standing_at",
    "turning_body",
    "unstable_ranges",
]

import_later(__name__)
