"""Checks of all that a run computed, and of its analyses against the system from its parts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solidwhirl.analyses.base import spin_of
from solidwhirl.analyses.unbalances import amplitudes_of, end_of, unbalance_at
from solidwhirl.core.outcome import Outcome
from solidwhirl.pipeline.asymmetry import asymmetry_checks
from solidwhirl.pipeline.body_stages import Job
from solidwhirl.pipeline.engine_stages import Diagram, Engine
from solidwhirl.rotordyn import AssembledSystem, CriticalSpeed, campbell
from solidwhirl.rotordyn.checks import plain_responses
from solidwhirl.rotordyn.checks.plain_system import PlainSystem
from solidwhirl.rotordyn.checks.system_checks import check_system
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM
from solidwhirl.rotordyn.superelement.invariants import Invariant, check_superelement

# Speeds of a response that are solved again.
_MOST = 24


def run_checks(engine: Engine, diagram: Diagram) -> tuple[Invariant, ...]:
    """Check the reductions, the superelements, the system, its modes and its critical speeds."""
    job = engine.job
    found = [check for result in engine.reduced.values() for check in result.work.checks]
    for element in engine.elements.values():
        found += check_superelement(element)
    if diagram.asymmetry is not None:
        found += asymmetry_checks(diagram.asymmetry)
        still = campbell(engine.system, [0.0], branch_count=job.scene.campbell.branches)
        at_rest = check_system(
            engine.system,
            diagram.at_rest,
            still,
            {},
            frequency_max_hz=None,
            branch_count=job.scene.campbell.branches,
            speed_max_rad_s=0.0,
        )
        return (*found, *at_rest)
    top = float(job.plan.speeds_rad_s.max())
    found += check_system(
        engine.system,
        diagram.at_rest,
        diagram.campbell,
        _by_excitation(job, diagram, top),
        frequency_max_hz=job.scene.campbell.frequency_max_hz,
        branch_count=job.scene.campbell.branches,
        speed_max_rad_s=top,
    )
    return tuple(found)


def _by_excitation(
    job: Job, diagram: Diagram, top_rad_s: float
) -> dict[float, list[CriticalSpeed]]:
    """Critical speeds of every excitation that was looked for, none included."""
    ratios = job.scene.speed_ratios()
    if top_rad_s == 0.0:
        return {}
    found: dict[float, list[CriticalSpeed]] = {abs(r): [] for r in ratios.values() if r != 0.0}
    for excited in diagram.critical_speeds:
        found[abs(ratios[excited.shafts[0]])].append(excited.critical)
    return found


def analysis_result_checks(
    system: AssembledSystem, critical: Sequence[CriticalSpeed], outcomes: Mapping[str, Outcome]
) -> tuple[Invariant, ...]:
    """Check stability and responses as they are written, and collect checks made on the way."""
    plain = PlainSystem.of(system)
    found: list[Invariant] = []
    for name, outcome in outcomes.items():
        document = outcome.document
        found += [Invariant(**check) for check in document.get("checks", ())]
        if outcome.kind == "stability":
            found += _stability(plain, document, name)
        elif outcome.kind == "unbalance_response":
            found += _responses(plain, document, critical, name)
    return tuple(found)


def _stability(plain: PlainSystem, document: Mapping[str, Any], name: str) -> tuple[Invariant, ...]:
    speeds = np.array(document["speed_rpm"]) * RAD_S_PER_RPM
    rows = document["unstable_intervals"]
    keys = ("from_rpm", "to_rpm", "largest_growth_at_rpm")
    intervals = [tuple(row[key] * RAD_S_PER_RPM for key in keys) for row in rows]
    some = speeds[np.linspace(0, speeds.size - 1, min(speeds.size, _MOST)).astype(int)]
    marks = [*some.tolist(), *plain.knots_rad_s]
    return plain_responses.check_stability(
        plain, intervals, (0.0, float(speeds.max())), marks, name
    )


def _responses(
    plain: PlainSystem, document: Mapping[str, Any], critical: Sequence[CriticalSpeed], name: str
) -> Iterator[Invariant]:
    speeds = np.array(document["speed_rpm"]) * RAD_S_PER_RPM
    spin = document["spin_rpm"]
    knots = [] if spin is not None else list(plain.knots_rad_s)
    damped = [c.speed_rad_s for c in critical if abs(c.log_decrement) > plain_responses.DAMPED]
    unbalances = [
        unbalance_at(u["at"], u["moment_kg_m"], u["phase_deg"]) for u in document["unbalances"]
    ]
    for exciter in document["exciters"]:
        loads = [load for load in unbalances if load.body in exciter["bodies"]]
        if not any(load.moment_kg_m for load in loads):
            continue
        curves = [
            plain_responses.Curve(end_of(at), amplitudes_of(found))
            for at, found in exciter["places"].items()
        ]
        chosen = _chosen(speeds, exciter, knots)
        yield from plain_responses.check_unbalance_response(
            plain, loads, speeds, curves, chosen, [*knots, *damped], name, spin_of(spin)
        )


def _chosen(
    speeds: NDArray[np.float64], exciter: Mapping[str, Any], knots: Sequence[float]
) -> list[int]:
    """Speeds to solve again: the highest peaks, knots, the ends and a spread."""
    peaks = [p for found in exciter["peaks"].values() for p in found]
    highest = sorted(peaks, key=lambda p: -p["amplitude_m"])[:_MOST]
    wanted = [p["speed_rpm"] * RAD_S_PER_RPM for p in highest] + list(knots)[:_MOST]
    spread = np.linspace(0, speeds.size - 1, min(speeds.size, _MOST)).astype(int).tolist()
    return sorted({*spread, *(int(np.argmin(np.abs(speeds - at))) for at in wanted)})
