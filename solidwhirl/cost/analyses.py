"""What the [[analyses]] of a scene will cost, from how much they have to solve."""

from __future__ import annotations

from solidwhirl.core.machine import MachineSpeed
from solidwhirl.cost import coefficients as measured
from solidwhirl.cost.work import REFERENCE_MACHINE, engine_kind, exciters, spectrum_s
from solidwhirl.model.plan_records import Plan
from solidwhirl.scene.records import Scene


def analyses_s(
    scene: Scene, plan: Plan, coordinates: int, machine: MachineSpeed = REFERENCE_MACHINE
) -> dict[str, float]:
    """Predict the processor seconds of each analysis by its name, without those that cost nothing.

    `coordinates`: of the engine. Each kind says what it has to solve (`Analysis.work`).
    """
    factor = 1.0 / machine.relative_to(REFERENCE_MACHINE)
    kind, shafts = engine_kind(plan, scene), exciters(plan, scene)
    out = {}
    for spec in scene.analyses:
        work = spec.work(shafts)
        seconds = work.spectra * spectrum_s(kind, coordinates) + sum(
            count * _each_s(name, coordinates)
            for name, count in work._asdict().items()
            if name in measured.DENSE
        )
        if seconds:
            out[spec.label] = factor * seconds
    return out


def _each_s(name: str, coordinates: int) -> float:
    once, grows, power = measured.DENSE[name]
    return float(once + grows * (coordinates / 100.0) ** power)
