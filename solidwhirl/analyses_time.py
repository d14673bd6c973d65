"""Run-up of the engine of a scene and the model complexity it requires."""

from __future__ import annotations

from solidwhirl.outcome import Outcome
from solidwhirl.rotordyn import AssembledSystem
from solidwhirl.scene_analyses import RunUpSpec


def run_run_up(spec: RunUpSpec, system: AssembledSystem, title: str) -> Outcome:
    """Run-up."""
    raise NotImplementedError
