"""Checks of everything a run computed."""

from __future__ import annotations

from collections.abc import Mapping

from solidwhirl.bodies.reduction import BodyResult
from solidwhirl.model.plan_records import Plan
from solidwhirl.pipeline.engine_stages import Diagram
from solidwhirl.rotordyn import AssembledSystem, CriticalSpeed, Invariant, Superelement
from solidwhirl.rotordyn.checks.system_checks import check_system
from solidwhirl.rotordyn.superelement.invariants import check_superelement
from solidwhirl.scene.records import Scene


def run_checks(
    scene: Scene,
    plan: Plan,
    bodies: Mapping[str, BodyResult],
    elements: Mapping[str, Superelement],
    system: AssembledSystem,
    diagram: Diagram,
) -> tuple[Invariant, ...]:
    """Check the reductions, the superelements, the system, its modes and its critical speeds.

    Parameters
    ----------
    bodies
        Bodies that were meshed, with the checks of their reductions.
    diagram
        Modes at rest, Campbell diagram and critical speeds.
    """
    found = [check for result in bodies.values() for check in result.work.checks]
    for element in elements.values():
        found += check_superelement(element)
    top = float(plan.speeds_rad_s.max())
    found += check_system(
        system,
        diagram.at_rest,
        diagram.campbell,
        _by_excitation(scene, diagram, top),
        frequency_max_hz=scene.campbell.frequency_max_hz,
        branch_count=scene.campbell.branches,
        speed_max_rad_s=top,
    )
    return tuple(found)


def _by_excitation(
    scene: Scene, diagram: Diagram, top_rad_s: float
) -> dict[float, list[CriticalSpeed]]:
    """Critical speeds of every excitation that was looked for, none included."""
    ratios = scene.speed_ratios()
    if top_rad_s == 0.0:
        return {}
    found: dict[float, list[CriticalSpeed]] = {abs(r): [] for r in ratios.values() if r != 0.0}
    for excited in diagram.critical_speeds:
        found[abs(ratios[excited.excited_by[0]])].append(excited.critical)
    return found
