"""Design of supports and speeds: critical speed maps, margins, stability, bearing laws."""

from __future__ import annotations

from typing import Any

import numpy as np

from solidwhirl.analyses_response import RPM, sweep
from solidwhirl.outcome import Outcome, Write
from solidwhirl.rotordyn import AssembledSystem, critical_speeds
from solidwhirl.rotordyn.bearing_notes import bearing_notes
from solidwhirl.rotordyn.critical_speed_map import critical_speed_map
from solidwhirl.rotordyn.pictures_maps import draw_bearing_law, draw_critical_speed_map
from solidwhirl.rotordyn.pictures_margins import draw_separation_margins
from solidwhirl.rotordyn.resonance_samples import with_knots
from solidwhirl.rotordyn.separation_margins import (
    OperatingRange,
    SeparationMargin,
    resonances_of_modes,
    separation_margins,
)
from solidwhirl.rotordyn.stability import stability_chart, stability_threshold
from solidwhirl.rotordyn.whirl import moves_laterally
from solidwhirl.scene import Scene
from solidwhirl.scene_analyses import (
    BearingLawsSpec,
    CriticalSpeedMapSpec,
    SeparationMarginsSpec,
    StabilitySpec,
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
    """Margins of every shaft's critical speeds from its operating range."""
    found: list[SeparationMargin] = []
    for entry in spec.operating:
        ratio = abs(scene.speed_ratio(entry.shaft))
        critical = [
            c
            for c in critical_speeds(
                system,
                excitation_ratio=ratio,
                speed_max_rad_s=spec.search_factor * entry.to_rpm * RPM / ratio,
            )
            # no unbalance excites axial motion and torsion
            if moves_laterally(system, c.shape)
        ]
        operating = OperatingRange(
            shaft=entry.shaft,
            speed_low_rad_s=entry.from_rpm * RPM,
            speed_high_rad_s=entry.to_rpm * RPM,
        )
        found += separation_margins(operating, resonances_of_modes(critical))
    rows = [_margin_document(m) for m in found]
    near = [m for m in rows if m["verdict_15_percent"] != "ok"]
    headline = f"{len(near)} of {len(rows)} critical speeds nearer than 15 %"
    if not rows:
        headline = f"no critical speed below {spec.search_factor:g} times the operating speeds"
    return Outcome(
        kind=spec.kind,
        document={
            "note": "in the manner of API 617; no statement of compliance",
            "operating": [entry.model_dump() for entry in spec.operating],
            "margins": rows,
        },
        files={f"{spec.label}.png": lambda path: draw_separation_margins(found, path, title)}
        if found
        else {},
        headline=headline,
    )


def _margin_document(margin: SeparationMargin) -> dict[str, Any]:
    return {
        "shaft": margin.shaft,
        "critical_speed_rpm": margin.resonance.speed_rad_s / RPM,
        "whirl": margin.resonance.whirl,
        "amplification_factor": margin.resonance.amplification_factor,
        "operating_speed_rpm": margin.operating_speed_rad_s / RPM,
        "position": margin.position,
        "margin": margin.margin,
        "required_api_617": margin.required_api_617,
        "verdict_api_617": margin.verdict_api_617,
        "verdict_15_percent": margin.verdict_15_percent,
        "verdict_20_percent": margin.verdict_20_percent,
    }


def run_stability(spec: StabilitySpec, system: AssembledSystem) -> Outcome:
    """Smallest damping over the speed, and the speed at which a motion begins to grow."""
    chart = stability_chart(system, sweep(spec))
    threshold = stability_threshold(system, spec.to_rpm * RPM)
    document: dict[str, Any] = {
        "speed_rpm": (chart.speeds_rad_s / RPM).tolist(),
        "smallest_log_decrement": chart.log_decrement.tolist(),
        "frequency_hz": chart.frequency_hz.tolist(),
        "largest_growth_rate_per_s": chart.growth_rate_1_s.tolist(),
        "growing_motions": chart.unstable_count.tolist(),
        "threshold": None,
    }
    headline = f"stable up to {spec.to_rpm:.0f} rpm"
    if threshold is not None:
        document["threshold"] = {
            "speed_rpm": threshold.speed_rad_s / RPM,
            "kind": threshold.kind,
            "frequency_hz": threshold.frequency_hz,
        }
        headline = (
            f"unstable ({threshold.kind}) from {threshold.speed_rad_s / RPM:.1f} rpm, "
            f"{threshold.frequency_hz:.2f} Hz"
        )
    return Outcome(kind=spec.kind, document=document, headline=headline)


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
    notes = [note.message for note in bearing_notes(system, speeds[[0, -1]])]
    return Outcome(
        kind=spec.kind,
        document={"bearings": documents, "notes": notes},
        files=files,
        headline=f"{len(documents)} bearings, {len(notes)} notes",
    )
