"""The Campbell diagram: branches of modes over the speed.

Tracking from speed to speed, births and ends of branches, notes, other frames.
In: `AssembledSystem` and speeds. Out: `Campbell`.
"""

from __future__ import annotations

from solidwhirl.rotordyn.campbell.diagram import Campbell, campbell

__all__ = ["Campbell", "campbell"]
