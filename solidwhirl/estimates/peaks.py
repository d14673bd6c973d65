"""Error estimates of the resonance peaks of unbalance responses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, TypeAlias

import numpy as np

from solidwhirl.analyses.base import Analysis, spin_of
from solidwhirl.analyses.responses.place_map import PlaceMapSpec
from solidwhirl.analyses.responses.unbalance_response import UnbalanceResponseSpec
from solidwhirl.analyses.unbalances import end_of, turning_at, unbalance_at, unbalance_of
from solidwhirl.core.outcome import Outcome
from solidwhirl.estimates.comparators import Comparison
from solidwhirl.rotordyn import AssembledSystem, End
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM
from solidwhirl.rotordyn.estimates.response_errors import unbalance_peak_errors
from solidwhirl.rotordyn.response.unbalance import (
    Unbalance,
    frequency_ratio,
    orbit_peaks,
    resolving_speeds,
    unbalance_response,
)
from solidwhirl.rotordyn.response.unbalance_peaks import ResonancePeak
from solidwhirl.rotordyn.superelement.residual_energy import NOT_SUMMED

# Speeds of the force, and the spin of the reference shaft where it is another, rad/s.
_Swept: TypeAlias = tuple[FloatArray, float | None]
# Peaks of two models further apart than this (relative) are not the same.
_FARTHEST = 0.1
# A sample is a peak's own if it is nearer than this (relative).
_SAME_SPEED = 1e-12


def with_peak_estimates(
    outcome: Outcome,
    spec: Analysis,
    system: AssembledSystem,
    comparisons: tuple[Comparison, ...],
) -> Outcome:
    """Put error estimates beside the peaks of an unbalance response or a place map.

    Other analyses come back as they are. `comparisons`: other models of the engine.
    """
    if not isinstance(spec, UnbalanceResponseSpec | PlaceMapSpec):
        return outcome
    speeds = np.asarray(outcome.document["speed_rpm"]) * RAD_S_PER_RPM
    estimated = partial(_estimated, system, comparisons, (speeds, spin_of(spec.speed_rpm)))
    if isinstance(spec, UnbalanceResponseSpec):
        placed = [unbalance_of(u) for u in spec.unbalances]
        exciters = []
        for exciter in outcome.document["exciters"]:
            own = turning_at(system, placed, exciter["frequency_ratio"])
            of_place = exciter["peaks"].items()
            peaks = {place: estimated(own, end_of(place), found) for place, found in of_place}
            exciters.append({**exciter, "peaks": peaks})
        return replace(outcome, document={**outcome.document, "exciters": exciters})
    peaks = {}
    for place, found in outcome.document["peaks"].items():
        own = [unbalance_at(place, spec.moment_kg_m)]
        peaks[place] = estimated(own, end_of(spec.observe or place), found)
    return replace(outcome, document={**outcome.document, "peaks": peaks})


def _estimated(
    system: AssembledSystem,
    comparisons: tuple[Comparison, ...],
    swept: _Swept,
    unbalances: Sequence[Unbalance],
    node: End,
    found: Sequence[Mapping[str, Any]],
) -> list[dict[str, Any]]:
    """Peaks of one place with relative errors of their frequency and height."""
    if not found:
        return []
    peaks = [_as_peak(p, swept[0]) for p in found]
    errors = unbalance_peak_errors(system, unbalances, node, peaks, swept[1])
    position, height = dict(errors.position), dict(errors.height)
    ratio = frequency_ratio(system, unbalances[0])
    for pair in comparisons:
        second = _peaks_of(pair.second, unbalances, node, swept, ratio)
        first = list(peaks)
        if pair.first is not None:
            first = _peaks_of(pair.first, unbalances, node, swept, ratio)
        for parts, values in zip((position, height), _apart(peaks, first, second), strict=True):
            parts[pair.part] = parts.get(pair.part, 0.0) + pair.safety * values
    out = []
    for k, peak in enumerate(found):
        places, heights = ({n: float(v[k]) for n, v in p.items()} for p in (position, height))
        errors_of = {
            "frequency_error_estimate": _sum(places),
            "amplitude_error_estimate": _sum(heights),
            "error_parts": places,
        }
        out.append({**peak, **errors_of})
    return out


def _sum(parts: Mapping[str, float]) -> float:
    return float(sum(v for part, v in parts.items() if part not in NOT_SUMMED))


def _as_peak(document: Mapping[str, Any], speeds_rad_s: FloatArray) -> ResonancePeak:
    """A peak over the speed, its flanks the samples beside it."""
    speed = float(document["speed_rpm"]) * RAD_S_PER_RPM
    amplification = document["amplification"]
    known = amplification is not None and np.isfinite(amplification) and amplification > 0.0
    below = speeds_rad_s[speeds_rad_s < speed * (1.0 - _SAME_SPEED)]
    above = speeds_rad_s[speeds_rad_s > speed * (1.0 + _SAME_SPEED)]
    return ResonancePeak(
        position_rad_s=speed,
        amplitude=float(document["amplitude_m"]),
        prominence=np.inf,
        half_power_low_rad_s=float(below[-1]) if below.size else np.nan,
        half_power_high_rad_s=float(above[0]) if above.size else np.nan,
        amplification=float(amplification) if known else np.nan,
    )


def _apart(
    peaks: Sequence[ResonancePeak], first: Sequence[ResonancePeak], second: Sequence[ResonancePeak]
) -> FloatArray:
    """How far the peaks of two models lie apart, in place and height: relative, (2, peaks)."""
    shift = np.full((2, len(peaks)), np.nan)
    for k, peak in enumerate(peaks):
        a, b = _nearest(first, peak), _nearest(second, peak)
        if a is not None and b is not None:
            shift[0, k] = abs(a.position_rad_s - b.position_rad_s) / peak.position_rad_s
            shift[1, k] = abs(a.amplitude - b.amplitude) / peak.amplitude
    return shift


def _peaks_of(
    system: AssembledSystem,
    unbalances: Sequence[Unbalance],
    node: End,
    swept: _Swept,
    ratio: float,
) -> list[ResonancePeak]:
    """Peaks over the speed of another model at a place."""
    rotors = system.system.rotors
    known = {(name, n.name) for name in rotors for n in rotors[name].element.interfaces}
    used = {(u.body, u.interface) for u in unbalances} | {(node.body, node.interface)}
    if not used <= known:  # models of joints alone have no other interfaces
        return []
    speeds = resolving_speeds(system, unbalances, *swept)
    response = unbalance_response(system, unbalances, speeds, swept[1])
    exciter = response.exciters[0]
    at = exciter.nodes.index(node)
    moving = exciter.frequencies_rad_s > 0.0
    found = orbit_peaks(
        system,
        unbalances,
        node,
        exciter.frequencies_rad_s[moving],
        exciter.orbits().major_m[moving, at],
        spin_rad_s=swept[1],
    )
    return [replace(p, position_rad_s=p.position_rad_s / ratio) for p in found]


def _nearest(peaks: Sequence[ResonancePeak], like: ResonancePeak) -> ResonancePeak | None:
    if not peaks:
        return None
    near = min(peaks, key=lambda p: abs(p.position_rad_s - like.position_rad_s))
    gap = abs(near.position_rad_s - like.position_rad_s)
    return near if gap <= _FARTHEST * like.position_rad_s else None
