"""Error estimates of everything that a run reports, split into parts."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np

from solidwhirl.core.displays import indented, percent
from solidwhirl.estimates.beams import (
    MORE_BRANCHES,
    at_rest_errors,
    branch_errors,
    critical_speed_errors_of_beams,
    free_errors,
)
from solidwhirl.estimates.comparators import Comparison
from solidwhirl.rotordyn import (
    AssembledSystem,
    Campbell,
    CriticalSpeed,
    Modes,
    Rotor,
    Superelement,
    assemble,
    campbell,
    critical_speeds,
    modes_at_speed,
)
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray
from solidwhirl.rotordyn.estimates.campbell_errors import CampbellErrors, campbell_errors
from solidwhirl.rotordyn.estimates.critical_speed_errors import (
    CriticalSpeedErrors,
    critical_speed_errors,
)
from solidwhirl.rotordyn.estimates.differences import (
    campbell_differences,
    critical_speed_differences,
)
from solidwhirl.rotordyn.estimates.eigenvalue_errors import (
    FrequencyErrors,
    error_scale,
    frequency_errors,
)
from solidwhirl.rotordyn.modes.damping import DEFAULT_RULE, DampingRule


@dataclass(frozen=True, kw_only=True, eq=False)
class Estimates:
    """Relative error estimates of a run.

    `critical_speeds` are in the order of `critical`. `free_frequencies`: body to (k,) estimates of
    the frequencies of the free body at rest. `comparisons`: other models that were computed for it.
    `rule`: which of the modes count; the others are critically damped.
    """

    at_rest: FrequencyErrors
    campbell: CampbellErrors
    critical_speeds: CriticalSpeedErrors
    free_frequencies: Mapping[str, FloatArray]
    comparisons: tuple[Comparison, ...]
    critical: tuple[CriticalSpeed, ...]
    rule: DampingRule = DEFAULT_RULE

    def __repr__(self) -> str:
        parts = []
        for name, values in self.campbell.parts.items():
            known = values[np.isfinite(values)]
            if known.size:
                parts.append(f"{name} {percent(float(known.max()))}")
        head = f"Estimates: at most {percent(self.largest)}"
        return "\n".join([head, *indented(parts)])

    @property
    def largest(self) -> float:
        """Largest estimate of modes and critical speeds that count, nan if there is none."""
        branches = self.campbell.total[self.rule.counts(self.campbell.campbell.eigenvalues)]
        speeds = [
            float(total)
            for total, critical in zip(self.critical_speeds.total, self.critical, strict=True)
            if critical.counts(self.rule)
        ]
        values = np.concatenate([branches, np.array(speeds)])
        known = values[np.isfinite(values)]
        return float(known.max()) if len(known) else float("nan")


class BeamVariants(NamedTuple):
    """Models of the engine with the other choices of beam theory, and their beams by name."""

    systems: tuple[AssembledSystem, ...]
    elements: tuple[Mapping[str, Superelement], ...]


def estimate_errors(
    system: AssembledSystem,
    elements: Mapping[str, Superelement],
    at_rest: Modes,
    diagram: Campbell,
    critical: Sequence[CriticalSpeed],
    comparisons: tuple[Comparison, ...] = (),
    beams: BeamVariants | None = None,
) -> Estimates:
    """Estimate the errors of modes at rest, Campbell diagram and critical speeds of an engine.

    `comparisons`: other models of the same engine; `beams`: models that differ in the choices of
    beam theory.
    """
    rest = frequency_errors(system, at_rest)
    branches = campbell_errors(system, diagram)
    speeds = critical_speed_errors(system, critical, branches)
    rest_parts, branch_parts = dict(rest.parts), dict(branches.parts)
    speed_parts = dict(speeds.parts)
    # one model may be the second of a comparison and the first of the next
    count = len(diagram.frequency_hz) + MORE_BRANCHES
    diagram_of = cache(lambda other: campbell(other, diagram.speeds_rad_s, branch_count=count))
    speeds_of = cache(lambda other: _critical_like(critical, other, diagram))
    for pair in comparisons:
        _add(rest_parts, pair, _at_rest_differences(at_rest, pair))
        _add(branch_parts, pair, _branch_differences(diagram, pair, diagram_of))
        _add(speed_parts, pair, _speed_differences(critical, pair, speeds_of))
    free = {}
    if beams is not None:
        own_hz = at_rest.frequency_hz
        found = at_rest_errors(at_rest, beams.systems)
        rest_parts["beam_theory"] = found * own_hz / _scale_hz(system, own_hz)
        own_hz = diagram.frequency_hz
        of_branches = branch_errors(diagram, beams.systems) * own_hz / _scale_hz(system, own_hz)
        branch_parts["beam_theory"] = of_branches
        speed_parts["beam_theory"] = critical_speed_errors_of_beams(critical, diagram, of_branches)
        own = {name: elements[name] for name in beams.elements[0]}
        free = free_errors(own, beams.elements)
    free |= {n: _free(e, n, comparisons) for n, e in elements.items() if e.error_forms}
    return Estimates(
        at_rest=replace(rest, parts=rest_parts),
        campbell=replace(branches, parts=branch_parts),
        critical_speeds=replace(speeds, parts=speed_parts),
        free_frequencies=free,
        comparisons=comparisons,
        critical=tuple(critical),
    )


def _add(parts: dict[str, FloatArray], pair: Comparison, difference: FloatArray) -> None:
    parts[pair.part] = parts.get(pair.part, np.zeros_like(difference)) + difference


def _at_rest_differences(at_rest: Modes, pair: Comparison) -> FloatArray:
    """Differences of the modes at rest, both sorted by frequency; nan beyond the shorter list."""
    second = modes_at_speed(pair.second, 0.0)
    first = at_rest if pair.first is None else modes_at_speed(pair.first, 0.0)
    out = np.full(len(at_rest.frequency_hz), np.nan)
    count = min(len(out), len(first.frequency_hz), len(second.frequency_hz))
    f, g = first.frequency_hz[:count], second.frequency_hz[:count]
    out[:count] = pair.safety * np.abs(f - g) / _scale_hz(pair.second, f)
    if pair.part == "mesh":  # what the finer model itself is wrong by
        out[:count] += frequency_errors(pair.second, second).total[:count]
    return out


def _branch_differences(
    diagram: Campbell, pair: Comparison, diagram_of: Callable[[AssembledSystem], Campbell]
) -> FloatArray:
    """Differences along the branches of the diagram."""
    second = diagram_of(pair.second)
    first = diagram if pair.first is None else diagram_of(pair.first)
    found = campbell_differences(first, second)
    own = first.frequency_hz
    out = pair.safety * np.abs(found.frequency) * own / _scale_hz(pair.second, own)
    if pair.part == "mesh":
        out += _at_partners(found.partner, campbell_errors(pair.second, second).total)
    if pair.first is None:
        return out
    # from the branches of the first model to those of the scene's own
    return _at_partners(campbell_differences(diagram, first).partner, out)


def _speed_differences(
    critical: Sequence[CriticalSpeed],
    pair: Comparison,
    speeds_of: Callable[[AssembledSystem], list[CriticalSpeed]],
) -> FloatArray:
    """Differences of the critical speeds."""
    second = speeds_of(pair.second)
    first = list(critical) if pair.first is None else speeds_of(pair.first)
    found = critical_speed_differences(first, second)
    out = pair.safety * np.abs(found.speed)
    if pair.part == "mesh":
        known = critical_speed_errors(pair.second, second).total
        out += _at_partners(found.partner, known)
    if pair.first is None:
        return out
    return _at_partners(critical_speed_differences(critical, first).partner, out)


def _scale_hz(system: AssembledSystem, frequency_hz: FloatArray) -> FloatArray:
    """What errors of frequencies are measured against."""
    return error_scale(system, 2.0 * np.pi * frequency_hz) / (2.0 * np.pi)


def _at_partners(partner: IntArray, values: FloatArray) -> FloatArray:
    """Rows of the partners; nan where there is none."""
    out = np.full((len(partner), *values.shape[1:]), np.nan)
    has = partner >= 0
    out[has] = values[partner[has]]
    return out


def _critical_like(
    critical: Sequence[CriticalSpeed], system: AssembledSystem, diagram: Campbell
) -> list[CriticalSpeed]:
    """Critical speeds of another system for the same excitations, a little beyond the range."""
    top = 1.05 * float(diagram.speeds_rad_s.max())
    top = min(top, system.speed_limit_rad_s)
    ratios = sorted({round(2.0 * np.pi * c.frequency_hz / c.speed_rad_s, 9) for c in critical})
    return [
        c
        for ratio in ratios
        for c in critical_speeds(system, excitation_ratio=ratio, speed_max_rad_s=top)
    ]


def _free(element: Superelement, name: str, comparisons: tuple[Comparison, ...]) -> FloatArray:
    """Errors of the frequencies of one free body at rest, in their order."""
    wanted = element.free_frequencies_hz
    alone = assemble({name: Rotor(element=element, speed_ratio=1.0)}, ())
    modes = modes_at_speed(alone, 0.0)
    found = frequency_errors(alone, modes)
    near = np.abs(modes.frequency_hz[None, :] - wanted[:, None]).argmin(axis=1)
    out = np.asarray(found.total[near])
    for pair in comparisons:
        if pair.part == "interface_coupling" or name not in pair.second_elements:
            continue
        first = pair.first_elements[name].free_frequencies_hz
        second = pair.second_elements[name].free_frequencies_hz
        count = min(len(out), len(first), len(second))
        out[:count] += pair.safety * np.abs(first[:count] - second[:count]) / first[:count]
        out[count:] = np.nan
    return out
