"""Parameter sweeps: cases, matching, sensitivities, bands and margins.

Grids, lists and samples over any key of a scene.
In: `[sweep]` of a scene, rows of a batch. Out: cases, `SweepAnalysis`.
"""

from __future__ import annotations

from solidwhirl.sweep.cases import batch_cases, case_scene

__all__ = ["batch_cases", "case_scene"]
