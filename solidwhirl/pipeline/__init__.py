"""The whole run of a scene: geometry, mesh, reduction, assembly, analyses.

Stages with cache, checks, alarms and the verdict.
In: `Scene`. Out: `Results`.
"""

from __future__ import annotations

from solidwhirl.pipeline.run import ExcitedCriticalSpeed, Results, run_scene

__all__ = ["ExcitedCriticalSpeed", "Results", "run_scene"]
