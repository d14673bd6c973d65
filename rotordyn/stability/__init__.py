"""Where a motion grows by itself.

Eigenvalues as continuous paths over the speed; every crossing of the axis is bracketed.
In: `AssembledSystem` and a range. Out: unstable intervals, decrements of the first modes.
"""

from __future__ import annotations

from solidwhirl.rotordyn.stability.intervals import stability_chart, unstable_intervals

__all__ = ["stability_chart", "unstable_intervals"]
