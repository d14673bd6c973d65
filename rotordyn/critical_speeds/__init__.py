"""Critical speeds and their map over bearing stiffness.

Direct eigenproblems for constant bearings, sign counts for bearings that depend on the speed, paths
of the roots over the speed with damping.
In: `AssembledSystem` and a range. Out: `CriticalSpeed` records, `CriticalSpeedMap`.
"""

from __future__ import annotations

from solidwhirl.rotordyn.critical_speeds.search import count_critical_speeds, critical_speeds

__all__ = ["count_critical_speeds", "critical_speeds"]
