"""The whole run of a scene: geometry, mesh, reduction, assembly, analyses.

Stages with cache, checks, alarms and the verdict.
In: `Scene`. Out: `Results`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from solidwhirl.pipeline.run import ExcitedCriticalSpeed, Results, run_scene

__all__ = ["ExcitedCriticalSpeed", "Results", "run_scene"]


def __getattr__(name: str) -> Any:
    # a plan takes the choice of the level from here, and loads nothing of a run
    if name in __all__:
        from solidwhirl.pipeline import run

        return getattr(run, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
