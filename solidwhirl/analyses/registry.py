"""All kinds of analysis; each entry of [[analyses]] of a scene is one."""

from __future__ import annotations

from typing import Annotated, get_args

from pydantic import Field

from solidwhirl.analyses.base import Analysis
from solidwhirl.analyses.kinds.api617 import Api617Spec
from solidwhirl.analyses.kinds.asymmetric_response import AsymmetricResponseSpec
from solidwhirl.analyses.kinds.bearing_laws import BearingLawsSpec
from solidwhirl.analyses.kinds.critical_speed_map import CriticalSpeedMapSpec
from solidwhirl.analyses.kinds.mode_shapes import ModeShapesSpec
from solidwhirl.analyses.kinds.nodal_diameters import NodalDiametersSpec
from solidwhirl.analyses.kinds.nonlinear_response import NonlinearResponseSpec
from solidwhirl.analyses.kinds.place_map import PlaceMapSpec
from solidwhirl.analyses.kinds.rotating_campbell import RotatingCampbellSpec
from solidwhirl.analyses.kinds.run_up import RunUpSpec
from solidwhirl.analyses.kinds.sensitivity import SensitivitySpec
from solidwhirl.analyses.kinds.separation_margins import SeparationMarginsSpec
from solidwhirl.analyses.kinds.stability import StabilitySpec
from solidwhirl.analyses.kinds.state_space import StateSpaceSpec
from solidwhirl.analyses.kinds.static import StaticSpec
from solidwhirl.analyses.kinds.stiffness_study import StiffnessStudySpec
from solidwhirl.analyses.kinds.unbalance_response import UnbalanceResponseSpec
from solidwhirl.analyses.kinds.waterfall import WaterfallSpec
from solidwhirl.analyses.recovery.analysis import RecoverySpec

AnalysisSpec = Annotated[
    UnbalanceResponseSpec
    | PlaceMapSpec
    | WaterfallSpec
    | CriticalSpeedMapSpec
    | StiffnessStudySpec
    | RotatingCampbellSpec
    | ModeShapesSpec
    | SeparationMarginsSpec
    | Api617Spec
    | StabilitySpec
    | SensitivitySpec
    | BearingLawsSpec
    | RunUpSpec
    | StaticSpec
    | StateSpaceSpec
    | RecoverySpec
    | NodalDiametersSpec
    | AsymmetricResponseSpec
    | NonlinearResponseSpec,
    Field(discriminator="kind"),
]

#: Class by kind.
KINDS: dict[str, type[Analysis]] = {
    get_args(spec.model_fields["kind"].annotation)[0]: spec
    for spec in get_args(get_args(AnalysisSpec)[0])
}
