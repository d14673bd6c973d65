"""Response to unbalances over the speed: amplitude, phase, orbits and bearing forces."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    Field,
)

from solidwhirl.analyses.base import (
    Engine,
    Places,
    Sweep,
)
from solidwhirl.analyses.unbalances import (
    ROUNDING,
    UnbalanceSpec,
    end_of,
    listed_peaks,
    numbered,
    parts,
    peak_documents,
    turning_at,
    unbalance_of,
)
from solidwhirl.core.fields import (
    MOST,
    Count,
    Positive,
)
from solidwhirl.core.outcome import MOST_CURVES, MOST_ORBITS, Outcome, Write
from solidwhirl.rotordyn import AssembledSystem, End
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM, RPM_PER_RAD_S
from solidwhirl.rotordyn.plots.response import (
    draw_bearing_forces,
    draw_orbits,
    draw_unbalance_response,
)
from solidwhirl.rotordyn.response.orbits import elliptic_orbits
from solidwhirl.rotordyn.response.unbalance import (
    ExciterResponse,
    Unbalance,
    UnbalanceResponse,
    orbit_peaks,
    resolving_speeds,
    unbalance_response,
)


class UnbalanceResponseSpec(Sweep):
    """Response to unbalances over the speed: amplitude, phase, orbits and bearing forces."""

    kind: Literal["unbalance_response"]
    count: Annotated[Count, Field(ge=4, le=20001)] = 201
    unbalances: Annotated[tuple[UnbalanceSpec, ...], Field(min_length=1, max_length=MOST)]
    observe: Places
    orbits_at_rpm: Annotated[tuple[Positive, ...], Field(max_length=64)] = ()

    def run(self, engine: Engine) -> Outcome:
        """Unbalance response over the speed at the places that the engine observes."""
        unbalances = [unbalance_of(u) for u in self.unbalances]
        speeds = resolving_speeds(engine.system, unbalances, self.speeds_rad_s)
        response = unbalance_response(engine.system, unbalances, speeds)
        nodes = [end_of(place) for place in self.observe]
        exciters = [
            _exciter_document(
                e, nodes, engine.system, turning_at(engine.system, unbalances, e.frequency_ratio)
            )
            for e in response.exciters
        ]
        files = _response_files(self, engine.system, response, engine.title)
        peaks = [p for e in exciters for p in e["peaks"][self.observe[0]]]
        return Outcome(
            kind=self.kind,
            document={
                "speed_rpm": (response.speeds_rad_s * RPM_PER_RAD_S).tolist(),
                "unbalances": [u.model_dump() for u in self.unbalances],
                "exciters": exciters,
            },
            files=files,
            headline=f"peaks at {self.observe[0]}: " + listed_peaks(peaks),
        )


def _response_files(
    spec: UnbalanceResponseSpec, system: AssembledSystem, response: UnbalanceResponse, title: str
) -> dict[str, Write]:
    """Pictures, each with as many curves as can be told apart, the others in further ones."""
    nodes = parts([end_of(place) for place in spec.observe], MOST_CURVES)
    files: dict[str, Write] = {}
    for suffix, own in numbered(nodes):
        files[f"{spec.label}{suffix}.png"] = partial(_draw_response, response, own, title)
    names = parts(list(response.exciters[0].bearing_forces), MOST_CURVES)
    for suffix, some in numbered(names):
        shown = _with_bearings(response, some)
        files[f"{spec.label}_bearing_forces{suffix}.png"] = partial(_draw_forces, shown, title)
    if spec.orbits_at_rpm:
        speeds = sorted({rpm * RAD_S_PER_RPM for rpm in spec.orbits_at_rpm})
        there = unbalance_response(system, response.unbalances, speeds)
        pairs = [(own, at) for own in nodes for at in parts(speeds, MOST_ORBITS)]
        for suffix, (own, at) in numbered(pairs):
            files[f"{spec.label}_orbits{suffix}.png"] = partial(_draw_orbits, there, own, at, title)
    return files


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
