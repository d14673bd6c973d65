"""The analyses of a scene beyond modes, Campbell diagram and critical speeds."""

from __future__ import annotations

from solidwhirl.outcome import Outcome
from solidwhirl.rotordyn import AssembledSystem, Campbell
from solidwhirl.scene import Scene
from solidwhirl.scene_analyses import AnalysisSpec


def run_analysis(
    spec: AnalysisSpec, scene: Scene, system: AssembledSystem, diagram: Campbell
) -> Outcome:
    """Run one analysis.

    Parameters
    ----------
    spec
        What is asked.
    scene, system, diagram
        The scene, its assembled engine and its Campbell diagram.

    Raises
    ------
    AnalysisError
        The engine has no answer, such as an undamped resonance that is hit exactly.
    """
    raise NotImplementedError
