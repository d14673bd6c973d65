"""The analyses of a scene beyond modes, Campbell diagram and critical speeds."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from solidwhirl.analyses_design import (
    run_bearing_laws,
    run_critical_speed_map,
    run_separation_margins,
    run_stability,
)
from solidwhirl.analyses_modes import run_mode_shapes, run_rotating_campbell, run_state_space
from solidwhirl.analyses_recovery import run_recovery
from solidwhirl.analyses_response import (
    run_place_map,
    run_stiffness_study,
    run_unbalance_response,
    run_waterfall,
)
from solidwhirl.analyses_time import run_run_up
from solidwhirl.outcome import Outcome
from solidwhirl.rotordyn import AssembledSystem, Campbell
from solidwhirl.scene import Scene
from solidwhirl.scene_analyses import (
    AnalysisSpec,
    BearingLawsSpec,
    CriticalSpeedMapSpec,
    ModeShapesSpec,
    PlaceMapSpec,
    RotatingCampbellSpec,
    RunUpSpec,
    SeparationMarginsSpec,
    StabilitySpec,
    StiffnessStudySpec,
    UnbalanceResponseSpec,
    WaterfallSpec,
)
from solidwhirl.scene_recovery import RecoverySpec


def run_analysis(
    spec: AnalysisSpec,
    scene: Scene,
    system: AssembledSystem,
    diagram: Campbell,
    recoveries: Callable[[str], Any] | None = None,
) -> Outcome:
    """Run one analysis.

    Parameters
    ----------
    spec
        What is asked.
    scene, system, diagram
        The scene, its assembled engine and its Campbell diagram.
    recoveries
        Makes the recovery of a body by its name; needed for the kind "recovery".

    Raises
    ------
    AnalysisError
        The engine has no answer, such as an undamped resonance that is hit exactly.
    """
    title = scene.title or scene.name
    match spec:
        case UnbalanceResponseSpec():
            return run_unbalance_response(spec, system, title)
        case PlaceMapSpec():
            return run_place_map(spec, system, title)
        case WaterfallSpec():
            return run_waterfall(spec, system, title)
        case CriticalSpeedMapSpec():
            return run_critical_speed_map(spec, scene, system, title)
        case StiffnessStudySpec():
            return run_stiffness_study(spec, system, title)
        case RotatingCampbellSpec():
            return run_rotating_campbell(spec, system, diagram, title)
        case ModeShapesSpec():
            return run_mode_shapes(spec, system, diagram, title)
        case SeparationMarginsSpec():
            return run_separation_margins(spec, scene, system, title)
        case StabilitySpec():
            return run_stability(spec, scene, system)
        case BearingLawsSpec():
            return run_bearing_laws(spec, system, title)
        case RunUpSpec():
            return run_run_up(spec, system, title)
        case RecoverySpec():
            assert recoveries is not None
            return run_recovery(spec, scene, system, recoveries)
    return run_state_space(spec, system)
