"""Response at probes and clearances to the unbalances that API 617 asks for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from solidwhirl.analyses.api617.records import ClearanceSpec, Machine, ProbeSpec
from solidwhirl.analyses.unbalances import end_of
from solidwhirl.rotordyn import AssembledSystem
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.estimates.eigenvalue_errors import bodies_without_forms
from solidwhirl.rotordyn.estimates.response_errors import amplitude_error, probe_peak_errors
from solidwhirl.rotordyn.lateral.unbalance_cases import UnbalanceCase
from solidwhirl.rotordyn.response.orbits import amplitude_along
from solidwhirl.rotordyn.response.unbalance import (
    ExciterResponse,
    orbit_peaks,
    probe_peaks,
    resolving_speeds,
    unbalance_response,
)
from solidwhirl.rotordyn.response.unbalance_peaks import ResonancePeak
from solidwhirl.rotordyn.standards.api617_lateral import (
    CLEARANCE_PART,
    CRITICALLY_DAMPED,
    LARGEST_SCALE,
    Edition,
    actual_margin,
    largest_required_margin,
    required_margin,
    scale_factor,
    vibration_limit_m,
)

# Speeds beyond those looked at, where the upper flank of the last peak may lie, times these.
_FLANK = 4.0 / 3.0
# Speeds that are asked for; resonances get more.
COUNT = 151


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What responses are looked at for."""

    machine: Machine
    edition: Edition
    range_factor: float
    probes: Sequence[ProbeSpec]
    clearances: Sequence[ClearanceSpec]


def case_document(system: AssembledSystem, case: UnbalanceCase, asked: Asked) -> dict[str, Any]:
    """Return the response to one case of unbalance as plain data; speeds are of the shaft itself.

    Peak to peak amplitudes, critical speeds with their margins, the scale factor, and what is left
    of the clearances.
    """
    machine = asked.machine
    top = asked.range_factor * machine.high_rpm
    marks = [machine.low_rpm, machine.high_rpm, machine.trip_rpm, top]
    rpm = np.union1d(np.linspace(0.0, _FLANK * top, COUNT), marks)
    speeds = np.array([machine.reference_rad_s(float(one)) for one in rpm])
    found = resolving_speeds(system, case.unbalances, speeds)
    exciter = unbalance_response(system, case.unbalances, found).exciters[0]
    shaft_rpm = exciter.frequencies_rad_s * RPM_PER_RAD_S
    probes = {
        f"{probe.at} at {angle:g}°": _probe(system, case, asked, exciter, probe.at, angle)
        for probe in asked.probes
        for angle in probe.angle_deg
    }
    top_probe = max(probes.values(), key=lambda p: float(p["largest_m"]))
    largest = float(top_probe["largest_m"])
    scale = scale_factor(vibration_limit_m(machine.high_rpm), largest)
    # what is scaled to the limit of vibration takes the error of the largest with it
    scaled_error = top_probe["largest_error_estimate"] if scale < LARGEST_SCALE else 0.0
    return {
        "kind": case.kind,
        "modes_rpm": [value * RPM_PER_RAD_S for value in case.modes_rad_s],
        "unbalances": [
            {
                "at": u.end.label,
                "moment_kg_m": u.moment_kg_m,
                "phase_deg": float(np.degrees(u.phase_rad)),
                "load_kg": load,
            }
            for u, load in zip(case.unbalances, case.loads_kg, strict=True)
        ],
        "speed_rpm": shaft_rpm.tolist(),
        "probes": probes,
        "largest_m": largest,
        "scale_factor": scale,
        "clearances": [
            _clearance(system, case, asked, exciter, own, (scale, scaled_error))
            for own in asked.clearances
        ],
    }


def _probe(
    system: AssembledSystem,
    case: UnbalanceCase,
    asked: Asked,
    exciter: ExciterResponse,
    place: str,
    angle_deg: float,
) -> dict[str, Any]:
    """What one probe sees, its peaks, and the largest amplitude at operating speeds."""
    end, angle = end_of(place), float(np.radians(angle_deg))
    x, y = exciter.at_node(end.body, end.interface).T
    motion = amplitude_along(x, y, angle)
    moving = exciter.frequencies_rad_s > 0.0
    omega, seen = exciter.frequencies_rad_s[moving], np.abs(motion[moving])
    peaks = probe_peaks(system, case.unbalances, end, angle, omega, seen)
    machine = asked.machine
    peaks = tuple(
        p
        for p in peaks
        if p.position_rad_s * RPM_PER_RAD_S <= asked.range_factor * machine.high_rpm
    )
    over_speed = [_over_speed(p, machine.ratio) for p in peaks]
    errors = probe_peak_errors(system, case.unbalances, end, angle, over_speed)
    known = not errors.bodies_without_estimate
    documents = [
        {
            **_peak_document(peak, machine, asked.edition),
            "speed_error_estimate": float(errors.position_total[k]) if known else None,
            "height_error_estimate": float(errors.height_total[k]) if known else None,
        }
        for k, peak in enumerate(peaks)
    ]
    largest = largest_within(
        2.0 * seen, omega * RPM_PER_RAD_S, documents, machine.low_rpm, machine.high_rpm
    )
    return {
        "at": place,
        "angle_deg": angle_deg,
        "peak_to_peak_m": (2.0 * np.abs(motion)).tolist(),
        "phase_deg": np.where(moving, np.degrees(np.angle(motion)), np.nan).tolist(),
        "peaks": documents,
        "largest_m": largest[0],
        "largest_at_rpm": largest[1],
        "largest_error_estimate": _error(system, case, (place, angle), largest[1], machine),
    }


def _error(
    system: AssembledSystem,
    case: UnbalanceCase,
    seen: tuple[str, float | None],
    rpm: float,
    machine: Machine,
) -> float | None:
    """Relative error of the amplitude along a direction, or of an orbit, at a speed of the shaft.

    None where a body does not know its error.
    """
    if bodies_without_forms(system) or not rpm > 0.0:
        return None
    place, angle = seen
    speed = machine.reference_rad_s(rpm)
    return amplitude_error(system, case.unbalances, end_of(place), angle, speed)


def _over_speed(peak: ResonancePeak, ratio: float) -> ResonancePeak:
    """A peak over the frequency as one over the speed of the reference shaft."""
    return replace(
        peak,
        position_rad_s=peak.position_rad_s / ratio,
        half_power_low_rad_s=peak.half_power_low_rad_s / ratio,
        half_power_high_rad_s=peak.half_power_high_rad_s / ratio,
    )


def _peak_document(peak: ResonancePeak, machine: Machine, edition: Edition) -> dict[str, Any]:
    """One peak with its margins; without an amplification factor only a margin of any is enough."""
    rpm = peak.position_rad_s * RPM_PER_RAD_S
    position, reference, margin = actual_margin(rpm, machine.low_rpm, machine.high_rpm)
    factor = float(peak.amplification)
    known = bool(np.isfinite(factor))
    if known:
        required = required_margin(factor, position, edition)
        verdict = "pass" if abs(margin) >= required else "fail"
        verdict = "not applicable" if factor < CRITICALLY_DAMPED else verdict
    else:
        required = largest_required_margin(position)
        verdict = "pass" if abs(margin) >= required else "undecided"
    return {
        "speed_rpm": rpm,
        "peak_to_peak_m": 2.0 * float(peak.amplitude),
        "half_power_low_rpm": float(peak.half_power_low_rad_s) * RPM_PER_RAD_S,
        "half_power_high_rpm": float(peak.half_power_high_rad_s) * RPM_PER_RAD_S,
        "amplification_factor": factor if known else None,
        "position": position,
        "reference_rpm": reference,
        "margin": margin,
        "required_margin": required if known else None,
        "verdict": verdict,
    }


def largest_within(
    sizes_m: FloatArray,
    rpm: FloatArray,
    peaks: Sequence[Mapping[str, Any]],
    low: float,
    high: float,
) -> tuple[float, float]:
    """Return the largest of samples and of peaks between them in a range, ends included.

    Its speed comes second.
    """
    near = 1e-9 * high
    inside = (rpm >= low - near) & (rpm <= high + near)
    tops = [(float(s), float(r)) for s, r in zip(sizes_m[inside], rpm[inside], strict=True)]
    tops += [(p["peak_to_peak_m"], p["speed_rpm"]) for p in peaks if low <= p["speed_rpm"] <= high]
    return max(tops)


def _clearance(
    system: AssembledSystem,
    case: UnbalanceCase,
    asked: Asked,
    exciter: ExciterResponse,
    own: ClearanceSpec,
    scaling: tuple[float, float | None],
) -> dict[str, Any]:
    """The largest scaled motion at a clearance up to the trip speed, and what it may be.

    `scaling`: scale factor and its relative error.
    """
    scale, scale_error = scaling
    end = end_of(own.at)
    major = exciter.orbits().major_m[:, exciter.nodes.index(end)]
    moving = exciter.frequencies_rad_s > 0.0
    omega = exciter.frequencies_rad_s[moving]
    tops = [
        {"peak_to_peak_m": 2.0 * p.amplitude, "speed_rpm": p.position_rad_s * RPM_PER_RAD_S}
        for p in orbit_peaks(system, case.unbalances, end, omega, major[moving])
    ]
    rpm = exciter.frequencies_rad_s * RPM_PER_RAD_S
    size, at = largest_within(2.0 * major, rpm, tops, 0.0, asked.machine.trip_rpm)
    error = _error(system, case, (own.at, None), at, asked.machine)
    return {
        "at": own.at,
        "diametral_m": own.diametral_m,
        "floating_ring": own.floating_ring,
        "peak_to_peak_m": size,
        "at_rpm": at,
        "scaled_m": scale * size,
        "allowed_m": CLEARANCE_PART * own.diametral_m,
        "error_estimate": None if error is None or scale_error is None else error + scale_error,
    }
