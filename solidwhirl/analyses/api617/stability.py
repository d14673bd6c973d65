"""Levels I and II of the stability analysis of API 617."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal

import numpy as np

from solidwhirl.analyses.api617.records import Machine, SourceSpec, StageSpec
from solidwhirl.analyses.unbalances import end_of
from solidwhirl.rotordyn import AssembledSystem, Bearing, End
from solidwhirl.rotordyn.assembly.system import assemble, at_rate
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM
from solidwhirl.rotordyn.estimates.eigenvalue_errors import (
    bodies_without_forms,
    decrement_errors,
)
from solidwhirl.rotordyn.lateral.cross_coupling import (
    cross_coupling_sweep,
    first_forward_mode,
    with_cross_coupling,
)
from solidwhirl.rotordyn.lateral.rigid_supports import axial_m, shaft_bodies
from solidwhirl.rotordyn.modes.eigen import mode_columns, modes_at_speed
from solidwhirl.rotordyn.standards.api617_stability import (
    MOST_TIMES,
    StageKind,
    screened,
    stage_cross_coupling_n_per_m,
)

#: Of bearings that depend on the frequency, in level I.
Coefficients = Literal["synchronous", "own_frequency"]


def without(system: AssembledSystem, bearings: Iterable[str]) -> AssembledSystem:
    """Return the system without some bearings; itself if none is named."""
    left_out = set(bearings)
    if not left_out:
        return system
    parts = system.system
    kept: tuple[Bearing, ...] = tuple(b for b in parts.bearings if b.name not in left_out)
    return assemble(parts.rotors, kept, parts.reference, parts.gears)


def level_1_document(
    base: AssembledSystem,
    machine: Machine,
    stages: Sequence[StageSpec],
    places: Sequence[End],
    first_critical_rpm: float,
) -> dict[str, Any]:
    """Return level I: applied cross-coupling up to the loss of stability, and the screening.

    `base`: the system without seals. `places`: where the cross-coupling is applied, in the ratio of
    that of the stages at the same places if there are several.
    """
    own = [stage_document(stage, machine) for stage in stages]
    total = sum(stage["cross_coupling_n_per_m"] for stage in own)
    sense = _sense(base, machine.shaft)
    speed = machine.reference_rad_s(machine.high_rpm)
    shares = _shares(places, own)
    sweep = cross_coupling_sweep(base, speed, shares, MOST_TIMES * total, total, sense)
    at = int(np.abs(sweep.stiffness_n_per_m - total).argmin())
    decrement, hertz = float(sweep.log_decrement[at]), float(sweep.frequency_hz[at])
    applied = with_cross_coupling(base, {end: share * total for end, share in shares.items()})
    densities = [stage["mean_density_kg_per_m3"] for stage in own]
    known = [density for density in densities if density is not None]
    density = max(known) if len(known) == len(own) else None
    kind: StageKind = "radial" if any(s.kind == "radial" for s in stages) else "axial"
    ratio = machine.high_rpm / first_critical_rpm
    times = sweep.lost_at_n_per_m / total
    found = screened(kind, times, decrement, density, ratio)
    return {
        "stages": own,
        "expected_n_per_m": total,
        "applied_at": {end.label: share for end, share in shares.items()},
        "applied_n_per_m": sweep.stiffness_n_per_m.tolist(),
        "log_decrement": sweep.log_decrement.tolist(),
        "frequency_hz": sweep.frequency_hz.tolist(),
        "lost_at_n_per_m": sweep.lost_at_n_per_m,
        "times_expected": times,
        "log_decrement_at_expected": decrement,
        "error_estimate": _decrement_error(applied, speed, hertz),
        "kind": kind,
        "mean_density_kg_per_m3": density,
        "critical_speed_ratio": ratio,
        "region_b": found.region_b,
        "detailed": found.detailed,
        "why": found.why,
    }


def with_level_1_coefficients(
    base: AssembledSystem, machine: Machine, coefficients: Coefficients
) -> AssembledSystem:
    """Return the base rotor with the coefficients of bearings that level I takes.

    "synchronous": those that depend on the frequency as they are at the speed of the shaft.
    """
    if coefficients == "own_frequency":
        return base
    return at_rate(base, 1j * machine.high_rpm * RAD_S_PER_RPM)


def _decrement_error(system: AssembledSystem, speed: float, hertz: float) -> float | None:
    """Relative error of the decrement of the mode of a frequency; None where it is not known."""
    if bodies_without_forms(system):
        return None
    modes = modes_at_speed(system, speed)
    own = mode_columns(modes, np.array([np.abs(modes.frequency_hz - hertz).argmin()]))
    error = float(decrement_errors(system, own)[0])
    return error / abs(float(own.log_decrement[0]) or 1.0)


def stage_document(stage: StageSpec, machine: Machine) -> dict[str, Any]:
    """Return the expected cross-coupling of a stage, and the mean density of its gas."""
    rpm = stage.speed_rpm or machine.high_rpm
    suction, discharge = stage.suction_density_kg_per_m3, stage.discharge_density_kg_per_m3
    value = stage_cross_coupling_n_per_m(
        stage.kind, stage.power_w, stage.diameter_m, stage.height_m, rpm, stage.ratio or 1.0
    )
    return {
        "at": stage.at,
        "kind": stage.kind,
        "speed_rpm": rpm,
        "cross_coupling_n_per_m": value,
        "mean_density_kg_per_m3": None
        if suction is None or discharge is None
        else 0.5 * (suction + discharge),
    }


def _shares(places: Sequence[End], stages: Sequence[Mapping[str, Any]]) -> dict[End, float]:
    """Parts of the cross-coupling by place: those of the stages there, else equal ones."""
    if len(places) > 1:
        own = {
            end: sum(s["cross_coupling_n_per_m"] for s in stages if s["at"] == end.label)
            for end in places
        }
        if all(own.values()):
            total = sum(own.values())
            return {end: value / total for end, value in own.items()}
    return {end: 1.0 / len(places) for end in places}


def middle_of(system: AssembledSystem, shaft: str, seats: Mapping[str, End]) -> End:
    """Return the interface of a shaft that is nearest to the middle between its outer journals."""
    ends = [axial_m(system, seat) for seat in seats.values()]
    middle = 0.5 * (ends[0] + ends[-1])
    nodes = [
        End(body=body, interface=node.name)
        for body in shaft_bodies(system, shaft)
        for node in system.system.rotors[body].element.interfaces
        if {"ux", "uy"} <= set(system.system.rotors[body].element.components_at(node.name))
    ]
    return min(nodes, key=lambda end: abs(axial_m(system, end) - middle))


def level_2_document(
    system: AssembledSystem,
    machine: Machine,
    sources: Sequence[SourceSpec],
    stages: Sequence[StageSpec],
) -> dict[str, Any]:
    """Return level II: the first forward mode of the base rotor, with each group, and complete.

    `stages`: by whose places groups name their expected cross-coupling.
    """
    every = [name for source in sources for name in source.bearings or ()]
    expected = {
        stage.at: stage_document(stage, machine)["cross_coupling_n_per_m"] for stage in stages
    }
    rows = [_row(without(system, every), machine, "base rotor", {})]
    for source in sources:
        kept = source.bearings or ()
        with_one = without(system, [name for name in every if name not in kept])
        rows.append(_row(with_one, machine, source.name, _couplings([source], expected)))
    complete = _row(system, machine, "complete rotor", _couplings(sources, expected))
    return {
        "rows": [*rows, complete],
        "log_decrement": complete["log_decrement"],
        "error_estimate": complete["error_estimate"],
    }


def _couplings(sources: Iterable[SourceSpec], expected: Mapping[str, float]) -> dict[str, float]:
    """Cross-coupled stiffness of groups by place, N/m."""
    own: dict[str, float] = {}
    for source in sources:
        given = [(c.at, c.stiffness_n_per_m) for c in source.cross_couplings]
        for at, value in (*given, *((at, expected[at]) for at in source.stages)):
            own[at] = own.get(at, 0.0) + value
    return own


def _row(
    system: AssembledSystem, machine: Machine, label: str, couplings: Mapping[str, float]
) -> dict[str, Any]:
    speed = machine.reference_rad_s(machine.high_rpm)
    coupled = with_cross_coupling(system, {end_of(at): q for at, q in couplings.items()})
    mode = first_forward_mode(coupled, speed, _sense(system, machine.shaft))
    return {
        "rotor": label,
        "cross_coupling_n_per_m": sum(couplings.values()),
        "log_decrement": mode.log_decrement,
        "error_estimate": _decrement_error(coupled, speed, mode.frequency_hz),
        "frequency_rpm": 60.0 * mode.frequency_hz,
    }


def _sense(system: AssembledSystem, shaft: str) -> float:
    return -1.0 if system.system.rotors[shaft].speed_ratio < 0.0 else 1.0
