"""Forced response of the engine of a scene: unbalance, ground motion, support stiffness."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from solidwhirl.outcome import MOST_CURVES, MOST_ORBITS, Outcome, Write
from solidwhirl.rotordyn import AssembledSystem, End
from solidwhirl.rotordyn.orbit_peaks import orbit_peaks
from solidwhirl.rotordyn.orbits import elliptic_orbits
from solidwhirl.rotordyn.pictures_response import (
    draw_bearing_forces,
    draw_orbits,
    draw_unbalance_response,
)
from solidwhirl.rotordyn.pictures_response_maps import (
    draw_ground_motion,
    draw_place_map,
    draw_stiffness_map,
)
from solidwhirl.rotordyn.resonance_samples import resolving_samples, with_knots
from solidwhirl.rotordyn.response_maps import StepPeaks, ground_motion_map, place_map
from solidwhirl.rotordyn.response_maps_peaks import ground_motion_peaks, stiffness_map_peaks
from solidwhirl.rotordyn.response_maps_stiffness import (
    choose_stiffness,
    stiffness_map_at_speed,
    synchronous_stiffness_map,
)
from solidwhirl.rotordyn.unbalance import (
    ExciterResponse,
    Unbalance,
    UnbalanceResponse,
    frequency_ratio,
    resolving_speeds,
    response_pieces,
    unbalance_response,
)
from solidwhirl.rotordyn.unbalance_peaks import ResonancePeak
from solidwhirl.scene_analyses import (
    PlaceMapSpec,
    StiffnessStudySpec,
    UnbalanceResponseSpec,
    UnbalanceSpec,
    WaterfallSpec,
)

_T = TypeVar("_T")
RPM = np.pi / 30.0
# Part of the largest motion at a speed below which a motion is the solution's rounding.
ROUNDING = 1e-9
# Unbalances turn together if their ratios differ by less than this.
_SAME_RATIO = 1e-9


def end_of(place: str) -> End:
    """Interface of a text "body.interface"."""
    body, _, interface = place.partition(".")
    return End(body=body, interface=interface)


def unbalance_of(spec: UnbalanceSpec) -> Unbalance:
    """Unbalance of a scene's entry."""
    end = end_of(spec.at)
    return Unbalance(
        body=end.body,
        interface=end.interface,
        moment_kg_m=spec.moment_kg_m,
        phase_rad=float(np.radians(spec.phase_deg)),
    )


def sweep(spec: Any) -> NDArray[np.float64]:
    """Speeds [rad/s] of an analysis with from_rpm, to_rpm and count."""
    return np.asarray(np.linspace(spec.from_rpm, spec.to_rpm, spec.count) * RPM)


def frequencies(spec: Any) -> NDArray[np.float64]:
    """Angular frequencies [rad/s] in equal steps up to frequency_max_hz, without zero."""
    steps = np.arange(1, spec.frequency_count + 1) / spec.frequency_count
    return np.asarray(2.0 * np.pi * spec.frequency_max_hz * steps)


def peak_documents(peaks: tuple[ResonancePeak, ...], ratio: float) -> list[dict[str, Any]]:
    """Peaks as plain data; `ratio` is frequency over reference speed."""
    return [
        {
            "frequency_hz": p.position_rad_s / (2.0 * np.pi),
            "speed_rpm": p.position_rad_s / ratio / RPM,
            "amplitude_m": p.amplitude,
            "amplification": p.amplification,
        }
        for p in peaks
    ]


def run_unbalance_response(
    spec: UnbalanceResponseSpec, system: AssembledSystem, title: str
) -> Outcome:
    """Unbalance response over the speed at the places that the scene observes."""
    unbalances = [unbalance_of(u) for u in spec.unbalances]
    speeds = resolving_speeds(system, unbalances, sweep(spec))
    response = unbalance_response(system, unbalances, speeds)
    nodes = [end_of(place) for place in spec.observe]
    exciters = [
        _exciter_document(e, nodes, system, turning_at(system, unbalances, e.frequency_ratio))
        for e in response.exciters
    ]
    files = _response_files(spec, system, response, title)
    peaks = [p for e in exciters for p in e["peaks"][spec.observe[0]]]
    return Outcome(
        kind=spec.kind,
        document={
            "speed_rpm": (response.speeds_rad_s / RPM).tolist(),
            "unbalances": [u.model_dump() for u in spec.unbalances],
            "exciters": exciters,
        },
        files=files,
        headline=f"peaks at {spec.observe[0]}: " + listed_peaks(peaks),
    )


def _response_files(
    spec: UnbalanceResponseSpec, system: AssembledSystem, response: UnbalanceResponse, title: str
) -> dict[str, Write]:
    """Pictures, each with as many curves as can be told apart, the others in further ones."""
    nodes = _parts([end_of(place) for place in spec.observe], MOST_CURVES)
    files: dict[str, Write] = {}
    for suffix, own in _numbered(nodes):
        files[f"{spec.label}{suffix}.png"] = partial(_draw_response, response, own, title)
    names = _parts(list(response.exciters[0].bearing_forces), MOST_CURVES)
    for suffix, some in _numbered(names):
        shown = _with_bearings(response, some)
        files[f"{spec.label}_bearing_forces{suffix}.png"] = partial(_draw_forces, shown, title)
    if spec.orbits_at_rpm:
        speeds = sorted({rpm * RPM for rpm in spec.orbits_at_rpm})
        there = unbalance_response(system, response.unbalances, speeds)
        pairs = [(own, at) for own in nodes for at in _parts(speeds, MOST_ORBITS)]
        for suffix, (own, at) in _numbered(pairs):
            files[f"{spec.label}_orbits{suffix}.png"] = partial(_draw_orbits, there, own, at, title)
    return files


def _parts(items: list[_T], most: int) -> list[list[_T]]:
    return [items[k : k + most] for k in range(0, len(items), most)]


def _numbered(items: list[_T]) -> list[tuple[str, _T]]:
    """Suffixes of file names: none for the first, then _2, _3 and so on."""
    return [(f"_{k + 1}" if k else "", item) for k, item in enumerate(items)]


def _with_bearings(response: UnbalanceResponse, names: list[str]) -> UnbalanceResponse:
    """The response with the forces of some bearings only."""
    exciters = tuple(
        replace(e, bearing_forces={name: e.bearing_forces[name] for name in names})
        for e in response.exciters
    )
    return replace(response, exciters=exciters)


def _draw_response(response: UnbalanceResponse, nodes: list[End], title: str, path: Path) -> None:
    draw_unbalance_response(response, nodes, path, title)


def _draw_forces(response: UnbalanceResponse, title: str, path: Path) -> None:
    draw_bearing_forces(response, path, title)


def _draw_orbits(
    response: UnbalanceResponse, nodes: list[End], speeds: list[float], title: str, path: Path
) -> None:
    draw_orbits(response, nodes, speeds, path, title)


def turning_at(
    system: AssembledSystem, unbalances: list[Unbalance], ratio: float
) -> list[Unbalance]:
    """Those unbalances whose frequency over the reference speed is `ratio`."""
    return [u for u in unbalances if abs(frequency_ratio(system, u) - ratio) <= _SAME_RATIO * ratio]


def _exciter_document(
    exciter: ExciterResponse,
    nodes: list[End],
    system: AssembledSystem,
    unbalances: list[Unbalance],
) -> dict[str, Any]:
    ratio = exciter.frequency_ratio
    moving = exciter.frequencies_rad_s > 0.0
    documents, peaks = {}, {}
    orbits = exciter.orbits()
    rates, largest = exciter.frequencies_rad_s[moving], np.nanmax(orbits.major_m[moving], axis=1)
    for node in nodes:
        at = exciter.nodes.index(node)
        amplitude = exciter.translation_m[:, at]
        documents[node.label] = {
            "amplitude_x_m": np.abs(amplitude[:, 0]).tolist(),
            "amplitude_y_m": np.abs(amplitude[:, 1]).tolist(),
            "phase_x_deg": np.degrees(np.angle(amplitude[:, 0])).tolist(),
            "phase_y_deg": np.degrees(np.angle(amplitude[:, 1])).tolist(),
            "major_m": orbits.major_m[:, at].tolist(),
            "minor_m": orbits.minor_m[:, at].tolist(),
            "orbit": orbits.direction[:, at].tolist(),
        }
        found = orbit_peaks(
            system, unbalances, node, rates, orbits.major_m[moving, at], ROUNDING * largest
        )
        peaks[node.label] = peak_documents(found, ratio)
    return {
        "bodies": list(exciter.bodies),
        "frequency_ratio": ratio,
        "frequency_hz": (exciter.frequencies_rad_s / (2.0 * np.pi)).tolist(),
        "places": documents,
        "peaks": peaks,
        "bearing_force_n": {
            name: elliptic_orbits(force[:, 0], force[:, 1]).major_m.tolist()
            for name, force in exciter.bearing_forces.items()
        },
        "largest_relative_residual": float(np.max(exciter.relative_residual)),
    }


def run_place_map(spec: PlaceMapSpec, system: AssembledSystem, title: str) -> Outcome:
    """Response over the place of an unbalance and its frequency."""
    places = [end_of(place) for place in spec.places]
    ratio = frequency_ratio(
        system,
        Unbalance(body=places[0].body, interface=places[0].interface, moment_kg_m=spec.moment_kg_m),
    )
    found = place_map(system, places, spec.moment_kg_m, _map_speeds(spec, system, ratio))
    observe = end_of(spec.observe) if spec.observe else None
    major = found.major_m()
    at = [found.nodes.index(place) for place in places]
    seen = (
        major[:, :, found.nodes.index(observe)]
        if observe is not None
        else np.stack([major[k, :, own] for k, own in enumerate(at)])
    )
    peaks = {}
    for k, place in enumerate(places):
        own_ratio = float(found.frequencies_rad_s[k, -1] / found.speeds_rad_s[-1])
        own = [Unbalance(body=place.body, interface=place.interface, moment_kg_m=spec.moment_kg_m)]
        turning = orbit_peaks(system, own, observe or place, found.frequencies_rad_s[k], seen[k])
        peaks[place.label] = peak_documents(turning, own_ratio)
    largest = int(np.unravel_index(seen.argmax(), seen.shape)[0])
    shown = observe or places[largest]
    return Outcome(
        kind=spec.kind,
        document={
            "moment_kg_m": spec.moment_kg_m,
            "places": list(spec.places),
            "observed": spec.observe or "each place itself",
            "speed_rpm": (found.speeds_rad_s / RPM).tolist(),
            "frequency_hz": (found.frequencies_rad_s / (2.0 * np.pi)).tolist(),
            "amplitude_m": seen.tolist(),
            "peaks": peaks,
            "most_sensitive_place": spec.places[largest],
        },
        files={f"{spec.label}.png": lambda path: draw_place_map(found, shown, path, title)}
        if major[:, :, found.nodes.index(shown)].any()
        else {},
        headline=f"largest at {spec.places[largest]}: "
        + _list_hz([p["frequency_hz"] for p in peaks[spec.places[largest]]]),
    )


def _map_speeds(spec: PlaceMapSpec, system: AssembledSystem, ratio: float) -> NDArray[np.float64]:
    """Speeds [rad/s] of a place map, with further ones around its resonances."""
    places = [end_of(place) for place in spec.places]

    def respond(speeds: NDArray[np.float64]) -> NDArray[np.complex128]:
        found = place_map(system, places, spec.moment_kg_m, speeds)
        motion = found.translation_m / (found.frequencies_rad_s**2)[:, :, None, None]
        shown = np.nan_to_num(np.moveaxis(motion, 1, 0))
        return np.asarray(shown.reshape(speeds.size, -1))

    speeds = frequencies(spec) / ratio
    pieces = response_pieces(system, ratio, float(speeds[-1]))
    return resolving_samples(speeds, respond, pieces)


def run_waterfall(spec: WaterfallSpec, system: AssembledSystem, title: str) -> Outcome:
    """Response to harmonic ground motion over frequency and speed."""
    steps_rpm = np.linspace(spec.from_rpm, spec.to_rpm, spec.speed_count)
    speeds = with_knots(steps_rpm * RPM, system.knots_rad_s)
    found = ground_motion_map(
        system, spec.amplitude_m, spec.direction, speeds, frequencies(spec), end_of(spec.observe)
    )
    major, steps = found.major_m(), ground_motion_peaks(system, found)
    peaks = _map_peaks(steps, speeds / RPM)
    return Outcome(
        kind=spec.kind,
        document={
            "observed": spec.observe,
            "ground_amplitude_m": spec.amplitude_m,
            "direction": spec.direction,
            "speed_rpm": (speeds / RPM).tolist(),
            "frequency_hz": (found.frequencies_rad_s / (2.0 * np.pi)).tolist(),
            "amplitude_m": major.tolist(),
            "highest_m": steps.height_m.tolist(),
            "peaks": peaks,
        },
        files={f"{spec.label}.png": lambda path: draw_ground_motion(found, path, title, steps)}
        if major.any()
        else {},
        headline="highest: "
        + ", ".join(f"{p['speed_rpm']:.0f} rpm {p['frequency_hz']:.1f} Hz" for p in peaks[:3]),
    )


def _map_peaks(steps: StepPeaks, rpm: NDArray[np.float64]) -> list[dict[str, float]]:
    """Steps of a map that are higher than their eight neighbours, the highest first."""
    major, hertz = steps.height_m, steps.frequency_rad_s / (2.0 * np.pi)
    padded = np.pad(major, 1, constant_values=-np.inf)
    highest = np.ones(major.shape, dtype=bool)
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            if down or right:
                part = padded[1 + down :, 1 + right :][: major.shape[0], : major.shape[1]]
                highest &= major > part
    order = sorted(np.argwhere(highest).tolist(), key=lambda at: -float(major[tuple(at)]))
    return [
        {"speed_rpm": rpm[i], "frequency_hz": hertz[i, j], "amplitude_m": major[i, j]}
        for i, j in order[:10]
    ]


def run_stiffness_study(spec: StiffnessStudySpec, system: AssembledSystem, title: str) -> Outcome:
    """Response over excitation frequency and support stiffness, and the stiffness to choose."""
    stiffness = np.geomspace(
        spec.stiffness_from_n_per_m, spec.stiffness_to_n_per_m, spec.stiffness_count
    )
    place = end_of(spec.excite)
    unbalance = Unbalance(body=place.body, interface=place.interface, moment_kg_m=spec.moment_kg_m)
    rates, observed = frequencies(spec), end_of(spec.observe)
    if spec.speed_rpm is None:
        knots = frequency_ratio(system, unbalance) * np.array(system.knots_rad_s)
        rates = with_knots(rates, knots)
        found = synchronous_stiffness_map(
            system, spec.bearings, stiffness, unbalance, rates, observed
        )
    else:
        found = stiffness_map_at_speed(
            system, spec.bearings, stiffness, unbalance, rates, observed, spec.speed_rpm * RPM
        )
    steps = stiffness_map_peaks(system, found)
    choice = choose_stiffness(found, spec.operating_speed_rpm * RPM, spec.margin, steps)
    return Outcome(
        kind=spec.kind,
        document={
            "bearings": list(spec.bearings),
            "excited": spec.excite,
            "observed": spec.observe,
            "moment_kg_m": spec.moment_kg_m,
            "speed_rpm": spec.speed_rpm,
            "stiffness_n_per_m": stiffness.tolist(),
            "frequency_hz": (found.frequencies_rad_s / (2.0 * np.pi)).tolist(),
            "amplitude_m": found.major_m().tolist(),
            "highest_m": steps.height_m.tolist(),
            "operating_speed_rpm": spec.operating_speed_rpm,
            "margin": spec.margin,
            "chosen_stiffness_n_per_m": choice.stiffness_n_per_m,
            "chosen_amplitude_m": choice.amplitude_m,
            "choice_is_at_the_end_of_the_range": choice.is_at_end,
        },
        files={
            f"{spec.label}.png": lambda path: draw_stiffness_map(found, path, title, choice, steps)
        }
        if found.translation_m.any()
        else {},
        headline=f"smallest response around {spec.operating_speed_rpm:.0f} rpm at "
        f"{choice.stiffness_n_per_m:.3g} N/m",
    )


def listed_peaks(peaks: list[dict[str, Any]]) -> str:
    """Speeds and frequencies of peaks in one line."""
    said = (f"{p['speed_rpm']:.0f} rpm ({p['frequency_hz']:.2f} Hz)" for p in peaks)
    return ", ".join(said) or "none"


def _list_hz(values: list[float]) -> str:
    return ", ".join(f"{v:.2f}" for v in values) + " Hz" if values else "none"
