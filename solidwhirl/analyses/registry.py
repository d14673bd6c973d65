"""All kinds of analysis; each entry of [[analyses]] of a scene is one.

A kind brings its computation along, so it is imported when a scene or a result asks for it.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Iterator, Mapping
from functools import partial, reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import (
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    TypeAdapter,
    ValidationInfo,
)
from pydantic_core import core_schema

from solidwhirl.analyses.base import Analysis

# Record of each kind, in this package.
_RECORDS = {
    "unbalance_response": "responses.unbalance_response:UnbalanceResponseSpec",
    "place_map": "responses.place_map:PlaceMapSpec",
    "waterfall": "responses.waterfall:WaterfallSpec",
    "critical_speed_map": "kinds.critical_speed_map:CriticalSpeedMapSpec",
    "stiffness_study": "kinds.stiffness_study:StiffnessStudySpec",
    "rotating_campbell": "kinds.rotating_campbell:RotatingCampbellSpec",
    "mode_shapes": "kinds.mode_shapes:ModeShapesSpec",
    "separation_margins": "kinds.separation_margins:SeparationMarginsSpec",
    "api617": "api617.analysis:Api617Spec",
    "stability": "kinds.stability:StabilitySpec",
    "sensitivity": "kinds.sensitivity:SensitivitySpec",
    "bearing_laws": "kinds.bearing_laws:BearingLawsSpec",
    "run_up": "responses.run_up:RunUpSpec",
    "static": "responses.static:StaticSpec",
    "state_space": "kinds.state_space:StateSpaceSpec",
    "recovery": "recovery.analysis:RecoverySpec",
    "nodal_diameters": "nodal_diameters.analysis:NodalDiametersSpec",
    "asymmetric_response": "responses.asymmetric_response:AsymmetricResponseSpec",
    "nonlinear_response": "responses.nonlinear_response:NonlinearResponseSpec",
    "level_comparison": "kinds.level_comparison:LevelComparisonSpec",
    "impact_test": "measured.impact_test:ImpactTestSpec",
}


class _Kinds(Mapping[str, type[Analysis]]):
    """Records by kind; one is imported when it is looked up."""

    def __getitem__(self, kind: str) -> type[Analysis]:
        found: type[Analysis] = pkgutil.resolve_name(f"{__package__}.{_RECORDS[kind]}")
        return found

    def __contains__(self, kind: object) -> bool:
        return kind in _RECORDS

    def __iter__(self) -> Iterator[str]:
        return iter(_RECORDS)

    def __len__(self) -> int:
        return len(_RECORDS)


#: Class by kind.
KINDS = _Kinds()


class _ByKind:
    """Checks a table as the record of its `kind`, with the errors of a union of all records."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        def read(kind: str, value: Any, info: ValidationInfo) -> Analysis:
            return KINDS[kind].model_validate(value, context=info.context)

        return core_schema.tagged_union_schema(
            {
                kind: core_schema.with_info_plain_validator_function(partial(read, kind))
                for kind in KINDS
            },
            discriminator="kind",
        )

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> Any:
        union: Any = reduce(or_, KINDS.values())
        every = Annotated[union, Field(discriminator="kind")]
        return handler(TypeAdapter(every).core_schema)


if TYPE_CHECKING:
    from solidwhirl.analyses.api617.analysis import Api617Spec
    from solidwhirl.analyses.kinds.bearing_laws import BearingLawsSpec
    from solidwhirl.analyses.kinds.critical_speed_map import CriticalSpeedMapSpec
    from solidwhirl.analyses.kinds.level_comparison import LevelComparisonSpec
    from solidwhirl.analyses.kinds.mode_shapes import ModeShapesSpec
    from solidwhirl.analyses.kinds.rotating_campbell import RotatingCampbellSpec
    from solidwhirl.analyses.kinds.sensitivity import SensitivitySpec
    from solidwhirl.analyses.kinds.separation_margins import SeparationMarginsSpec
    from solidwhirl.analyses.kinds.stability import StabilitySpec
    from solidwhirl.analyses.kinds.state_space import StateSpaceSpec
    from solidwhirl.analyses.kinds.stiffness_study import StiffnessStudySpec
    from solidwhirl.analyses.measured.impact_test import ImpactTestSpec
    from solidwhirl.analyses.nodal_diameters.analysis import NodalDiametersSpec
    from solidwhirl.analyses.recovery.analysis import RecoverySpec
    from solidwhirl.analyses.responses.asymmetric_response import AsymmetricResponseSpec
    from solidwhirl.analyses.responses.nonlinear_response import NonlinearResponseSpec
    from solidwhirl.analyses.responses.place_map import PlaceMapSpec
    from solidwhirl.analyses.responses.run_up import RunUpSpec
    from solidwhirl.analyses.responses.static import StaticSpec
    from solidwhirl.analyses.responses.unbalance_response import UnbalanceResponseSpec
    from solidwhirl.analyses.responses.waterfall import WaterfallSpec

    # `spec.kind == "run_up"` tells which record it is, without an import
    AnalysisSpec = (
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
        | NonlinearResponseSpec
        | LevelComparisonSpec
        | ImpactTestSpec
    )
else:
    AnalysisSpec = Annotated[Analysis, _ByKind()]
