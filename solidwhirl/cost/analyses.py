"""What the [[analyses]] of a scene cost: of its engine, and those that reduce bodies again."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from solidwhirl.analyses.registry import AnalysisSpec
from solidwhirl.analyses.work import EngineSize
from solidwhirl.cost import run_coefficients as measured
from solidwhirl.cost.engine import memory_gib, seconds_of, step_s
from solidwhirl.cost.machine import Machine
from solidwhirl.cost.stand_in import SteppedPart
from solidwhirl.cost.work import Cost
from solidwhirl.model.plan_records import Plan
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.recovery_references import sectors_of

if TYPE_CHECKING:
    from solidwhirl.analyses.nodal_diameters.analysis import NodalDiametersSpec
    from solidwhirl.analyses.recovery.analysis import RecoverySpec

_UNKNOWNS = 1e5
#: Places around the axis at which a state is recovered where the scene says nothing.
SECTORS = 32
# Values of a field at each unknown: displacements, stresses, and what they are made of.
_FIELDS = 20.0
_GIB = 1024.0**3


@dataclass(frozen=True, kw_only=True)
class AnalysisCost:
    """Processor seconds of an analysis, and its memory beside the program [GiB].

    `body`, `parts`: the body that it reduces again, and in how many parts, each `part_s` long.
    """

    seconds: float
    memory_gib: float
    body: str = ""
    parts: int = 0
    part_s: float = 0.0


def analysis_costs(
    scene: Scene,
    plan: Plan,
    size: EngineSize,
    bodies: Mapping[str, Cost],
    machine: Machine,
    stepped: Mapping[str, Sequence[SteppedPart]],
    on_level: Callable[[str], AnalysisCost],
) -> dict[str, AnalysisCost]:
    """Predict what each analysis costs, by its name.

    `bodies`: cost of each in its last round; `stepped`: parts that run-ups step, see
    `solidwhirl.cost.stand_in`; `on_level`: of the engine with its bodies on another level.
    """

    def cost(spec: AnalysisSpec) -> AnalysisCost:
        if spec.kind == "nodal_diameters":
            return _nodal_diameters(scene, plan, spec, bodies[spec.body])
        if spec.kind == "recovery":
            return _recovery(spec, bodies, machine)
        if spec.kind == "level_comparison":
            return on_level(spec.level)
        work = spec.work(size)
        parts = stepped.get(spec.label, ())
        spent = seconds_of(work, size) + sum(p.steps * step_s(p.coordinates) for p in parts)
        return AnalysisCost(
            seconds=machine.factor("dense") * spent, memory_gib=memory_gib(work, size)
        )

    return {spec.label: cost(spec) for spec in scene.analyses}


def reduced_s(body: Cost) -> float:
    """Seconds of a reduction alone, without mesh and estimates."""
    left_out = ("meshing", "error_estimate")
    return body.total_s - sum(body.seconds.get(stage, 0.0) for stage in left_out)


def _nodal_diameters(
    scene: Scene, plan: Plan, spec: NodalDiametersSpec, body: Cost
) -> AnalysisCost:
    """Every nodal diameter costs about what a circumferential order of its body does."""
    count = len(spec.indices(sectors_of(scene, spec.body))[0])
    order = (body.total_s - body.seconds.get("meshing", 0.0)) / len(
        plan.bodies[spec.body].solved_orders
    )
    each = measured.NODAL_DIAMETER * order
    return AnalysisCost(
        seconds=count * each,
        memory_gib=body.peak_memory_gib,
        body=spec.body,
        parts=count,
        part_s=each,
    )


def _recovery(spec: RecoverySpec, bodies: Mapping[str, Cost], machine: Machine) -> AnalysisCost:
    """The last reduction of each body once more, and fields of the states around the axis."""
    states = sum(state.instants for state in spec.states)
    seconds = memory = 0.0
    for name in spec.bodies:
        fields = states * fields_s(bodies[name], spec.sectors)
        seconds += reduced_s(bodies[name]) + machine.factor("meridian") * fields
        memory = max(memory, 8.0 * _FIELDS * spec.sectors * bodies[name].unknowns / _GIB)
    return AnalysisCost(seconds=seconds, memory_gib=memory)


def fields_s(body: Cost, sectors: int) -> float:
    """Seconds of the fields of one state, at so many places around the axis."""
    once, size = measured.FIELDS
    return once + size * field_size(body, sectors)


def field_size(body: Cost, sectors: int) -> float:
    """Unknowns of a body and places around its axis, over 1e5 and 32."""
    return body.unknowns / _UNKNOWNS * sectors / SECTORS
