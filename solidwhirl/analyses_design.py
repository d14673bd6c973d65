"""Design of supports and speeds: critical speed maps, margins, stability, bearing laws."""

from __future__ import annotations

from typing import Any

import numpy as np

from solidwhirl.analyses_response import RPM, sweep
from solidwhirl.operating import operating_of_margins, operating_speeds
from solidwhirl.outcome import Outcome, Write
from solidwhirl.rotordyn import AssembledSystem, CriticalSpeed, critical_speeds
from solidwhirl.rotordyn.bearing_notes import bearing_notes, note_lines
from solidwhirl.rotordyn.critical_speed_map import critical_speed_map
from solidwhirl.rotordyn.excitation import unbalance_excitation
from solidwhirl.rotordyn.pictures_maps import draw_bearing_law, draw_critical_speed_map
from solidwhirl.rotordyn.pictures_margins import draw_separation_margins
from solidwhirl.rotordyn.resonance_samples import with_knots
from solidwhirl.rotordyn.separation_margins import (
    MarginMethod,
    OperatingRange,
    SeparationMargin,
    margin_verdict,
    resonances_of_modes,
    separation_margins,
)
from solidwhirl.rotordyn.stability import stability_chart
from solidwhirl.rotordyn.whirl import moves_laterally
from solidwhirl.scene import Scene
from solidwhirl.scene_analyses import (
    BearingLawsSpec,
    CriticalSpeedMapSpec,
    OperatingSpec,
    SeparationMarginsSpec,
    StabilitySpec,
)
from solidwhirl.stability_documents import (
    decrements,
    highest_frequency_hz,
    interval_document,
    stability_headline,
    stability_of,
    whirl_document,
)


def run_critical_speed_map(
    spec: CriticalSpeedMapSpec, scene: Scene, system: AssembledSystem, title: str
) -> Outcome:
    """Undamped critical speeds over the stiffness of supports."""
    stiffness = np.geomspace(
        spec.stiffness_from_n_per_m, spec.stiffness_to_n_per_m, spec.stiffness_count
    )
    ratio = abs(scene.speed_ratio(spec.excited_by))
    found = critical_speed_map(
        system,
        spec.bearings,
        stiffness,
        excitation_ratio=ratio,
        branch_count=spec.branches,
        speed_max_rad_s=spec.search_to_rpm * RPM / ratio,
    )
    operating = {}
    if spec.operating_speed_rpm is not None:
        operating[spec.excited_by] = spec.operating_speed_rpm * RPM / ratio
    return Outcome(
        kind=spec.kind,
        document={
            "bearings": list(spec.bearings),
            "excited_by": spec.excited_by,
            "stiffness_n_per_m": stiffness.tolist(),
            "critical_speed_rpm": (found.speed_rad_s / RPM).tolist(),
            "shaft_speed_rpm": (ratio * found.speed_rad_s / RPM).tolist(),
            "whirl": [[w or None for w in branch] for branch in found.whirl.tolist()],
            "free_rpm": (found.free_rad_s / RPM).tolist(),
            "rigid_rpm": (found.rigid_rad_s / RPM).tolist(),
            "operating_speed_rpm": spec.operating_speed_rpm,
        },
        files={
            f"{spec.label}.png": lambda path: draw_critical_speed_map(found, path, title, operating)
        }
        if np.isfinite(found.speed_rad_s).any()
        else {},
        headline=f"{len(found.speed_rad_s)} branches over {spec.stiffness_count} stiffnesses",
    )


def run_separation_margins(
    spec: SeparationMarginsSpec, scene: Scene, system: AssembledSystem, title: str
) -> Outcome:
    """Margins of every shaft's critical speeds from its operating range, and the verdict."""
    found: list[SeparationMargin] = []
    damped: list[dict[str, Any]] = []
    ranges = operating_of_margins(scene, spec)
    for entry in ranges:
        critical = _critical_speeds_of(entry, spec, scene, system)
        counts = [c.counts(scene.criteria.rule) for c in critical]
        damped += [
            _critically_damped(entry.shaft, c)
            for c, own in zip(critical, counts, strict=True)
            if not own
        ]
        counted = [c for c, own in zip(critical, counts, strict=True) if own]
        shafts = _alike(scene, entry.shaft)
        excitations = [unbalance_excitation(system, c.shape, shafts) for c in counted]
        operating = OperatingRange(
            shaft=entry.shaft,
            speed_low_rad_s=entry.from_rpm * RPM,
            speed_high_rad_s=entry.to_rpm * RPM,
        )
        found += separation_margins(operating, resonances_of_modes(counted, excitations))
    method = MarginMethod(kind=spec.method, percent=spec.percent)
    verdict = margin_verdict(found, method)
    return Outcome(
        kind=spec.kind,
        document={
            "note": "in the manner of API 617; no statement of compliance",
            "operating": [entry.model_dump() for entry in ranges],
            "verdict": {
                "method": spec.method,
                "percent": spec.percent if spec.method == "percent" else None,
                "passed": verdict.passed,
                "why": verdict.why,
                "worst": _margin_document(verdict.worst, method) if verdict.worst else None,
            },
            "margins": [_margin_document(m, method) for m in found],
            "critically_damped": damped,
        },
        files={f"{spec.label}.png": lambda path: draw_separation_margins(found, path, title)}
        if found
        else {},
        headline=f"{'pass' if verdict.passed else 'FAIL'} by {method.text}: {verdict.why}",
    )


def _critical_speeds_of(
    entry: OperatingSpec, spec: SeparationMarginsSpec, scene: Scene, system: AssembledSystem
) -> list[CriticalSpeed]:
    """Critical speeds of lateral motion that a shaft may excite up to a multiple of its speed."""
    ratio = abs(scene.speed_ratio(entry.shaft))
    limit = spec.search_factor * entry.to_rpm * RPM / ratio
    found = critical_speeds(system, excitation_ratio=ratio, speed_max_rad_s=limit)
    return [c for c in found if moves_laterally(system, c.shape)]


def _alike(scene: Scene, shaft: str) -> list[str]:
    """Bodies that turn as a shaft does: their unbalance is one with its own."""
    ratios = scene.speed_ratios()
    return [name for name, ratio in ratios.items() if ratio == ratios[shaft]]


def _critically_damped(shaft: str, critical: CriticalSpeed) -> dict[str, Any]:
    return {
        "shaft": shaft,
        "critical_speed_rpm": 2.0 * np.pi * critical.frequency_hz / RPM,
        "whirl": critical.whirl,
        "amplification_factor": critical.amplification_factor,
    }


def _margin_document(margin: SeparationMargin, method: MarginMethod) -> dict[str, Any]:
    resonance = margin.resonance
    return {
        "shaft": margin.shaft,
        "critical_speed_rpm": resonance.speed_rad_s / RPM,
        "whirl": resonance.whirl,
        "amplification_factor": resonance.amplification_factor,
        "excited": resonance.excited,
        "excited_why": resonance.why,
        "operating_speed_rpm": margin.operating_speed_rad_s / RPM,
        "position": margin.position,
        "margin": margin.margin,
        "required": method.required(margin),
        "required_api_617": margin.required_api_617,
        "verdict_api_617": margin.verdict_api_617,
        "verdict_15_percent": margin.verdict_15_percent,
        "verdict_20_percent": margin.verdict_20_percent,
    }


def run_stability(spec: StabilitySpec, scene: Scene, system: AssembledSystem) -> Outcome:
    """Damping of the first modes over the speed, and where the system is unstable."""
    speeds = sweep(spec)
    highest = spec.frequency_max_hz or highest_frequency_hz(scene, spec)
    chart = stability_chart(system, speeds, highest)
    stability = stability_of(system, spec.to_rpm, operating_speeds(scene))
    first = stability.intervals[0] if stability.intervals else None
    document: dict[str, Any] = {
        "speed_rpm": (speeds / RPM).tolist(),
        "frequency_max_hz": highest,
        "smallest_log_decrement": decrements(chart.log_decrement),
        "frequency_hz": chart.frequency_hz.tolist(),
        "largest_growth_rate_per_s": chart.growth_rate_1_s.tolist(),
        "growing_motions": chart.unstable_count.tolist(),
        **whirl_document(chart),
        "at_operating": list(stability.at_operating),
        "unstable_intervals": [interval_document(i) for i in stability.intervals],
        "threshold": None
        if first is None
        else {
            "speed_rpm": first.low_rad_s / RPM,
            "kind": first.kind,
            "frequency_hz": first.frequency_hz,
        },
    }
    return Outcome(
        kind=spec.kind, document=document, headline=stability_headline(stability, document)
    )


def run_bearing_laws(spec: BearingLawsSpec, system: AssembledSystem, title: str) -> Outcome:
    """Coefficients of the bearings that depend on the speed."""
    speeds = with_knots(np.linspace(0.0, spec.to_rpm * RPM, 401), system.knots_rad_s)
    documents: dict[str, Any] = {}
    files: dict[str, Write] = {}
    named = {b.name: b for b in system.system.bearings}
    for joint in system.law_joints:
        values = [joint.coefficients(float(speed)) for speed in speeds]
        documents[joint.bearing] = {
            "law": joint.law.name,
            "speed_of_its_rotor_rpm": (np.abs(joint.speed_ratio) * speeds / RPM).tolist(),
            "stiffness_n_per_m": [np.diag(k).tolist() for k, _ in values],
            "damping_n_s_per_m": [np.diag(c).tolist() for _, c in values],
        }
        bearing = named[joint.bearing]
        own = np.abs(joint.speed_ratio) * speeds

        def draw(path: Any, bearing: Any = bearing, own: Any = own) -> None:
            draw_bearing_law(bearing, own, path, f"{title}: bearing {bearing.name}", {})

        files[f"{spec.label}_{joint.bearing}.png"] = draw
    notes = list(note_lines(bearing_notes(system, speeds[[0, -1]])))
    return Outcome(
        kind=spec.kind,
        document={"bearings": documents, "notes": notes},
        files=files,
        headline=f"{len(documents)} bearings, {len(notes)} notes",
    )
