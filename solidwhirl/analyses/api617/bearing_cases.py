"""What one set of bearing laws gives: responses to its unbalances, and both levels of stability."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from solidwhirl.analyses.api617.records import SourceSpec, StageSpec
from solidwhirl.analyses.api617.response import Asked, case_document
from solidwhirl.analyses.api617.stability import (
    Coefficients,
    level_1_document,
    level_2_document,
    with_level_1_coefficients,
    without,
)
from solidwhirl.rotordyn import AssembledSystem, End
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM
from solidwhirl.rotordyn.lateral.unbalance_cases import (
    Journals,
    PlacementRules,
    unbalance_cases,
)

#: The set of laws that the scene itself gives.
OWN = "as in the scene"


@dataclass(frozen=True, kw_only=True)
class StabilityAsked:
    """What the stability analysis is told.

    `applied_at`: places of the cross-coupling of level I; `coefficients`: of bearings that depend
    on the frequency, in level I; `first_critical_rpm`: on rigid supports.
    """

    stages: Sequence[StageSpec]
    sources: Sequence[SourceSpec]
    applied_at: Sequence[End]
    coefficients: Coefficients
    first_critical_rpm: float


@dataclass(frozen=True, kw_only=True)
class LateralAsked:
    """What is asked of every set of bearing laws."""

    journals: Journals
    rules: PlacementRules
    response: Asked
    stability: StabilityAsked


def bearing_case_document(
    system: AssembledSystem, laws: Mapping[str, str], asked: LateralAsked
) -> dict[str, Any]:
    """Return the responses and the stability of a system with one set of laws as plain data.

    `laws`: of bearings that differ from those of the scene. The unbalances follow from the modes of
    this system.
    """
    machine = asked.response.machine
    limit = asked.response.range_factor * machine.high_rpm * RAD_S_PER_RPM
    cases = unbalance_cases(system, machine.shaft, asked.journals, asked.rules, limit)
    return {
        "laws": dict(laws),
        "cases": {case.name: case_document(system, case, asked.response) for case in cases},
        **_stability(system, asked),
    }


def _stability(system: AssembledSystem, asked: LateralAsked) -> dict[str, Any]:
    machine, own = asked.response.machine, asked.stability
    base = without(system, [name for source in own.sources for name in source.bearings or ()])
    level_1 = level_2 = None
    if own.stages:
        rotor = with_level_1_coefficients(base, machine, own.coefficients)
        level_1 = level_1_document(
            rotor, machine, own.stages, own.applied_at, own.first_critical_rpm
        )
        level_1["coefficients"] = own.coefficients if base.depends_on_frequency else "over_speed"
    if own.sources:
        level_2 = level_2_document(system, machine, own.sources, own.stages)
    return {"level_1": level_1, "level_2": level_2}
