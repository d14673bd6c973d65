"""Error estimates of everything that a run reports, split into parts."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np

from solidwhirl import rotordyn as rd
from solidwhirl.beams.error import beam_theory_error
from solidwhirl.core.displays import indented, percent
from solidwhirl.estimates.comparators import Comparison
from solidwhirl.rotordyn.asymmetric import at_rest as standing
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray, StringArray
from solidwhirl.rotordyn.critical_speeds.followed import followed_critical_speeds
from solidwhirl.rotordyn.estimates.campbell_errors import CampbellErrors, campbell_errors
from solidwhirl.rotordyn.estimates.critical_speed_errors import (
    CriticalSpeedErrors,
    critical_speed_errors,
)
from solidwhirl.rotordyn.estimates.differences import frequency_partners
from solidwhirl.rotordyn.estimates.eigenvalue_errors import (
    FrequencyErrors,
    error_scale,
    frequency_errors,
)
from solidwhirl.rotordyn.modes.damping import DEFAULT_RULE, DampingRule
from solidwhirl.rotordyn.modes.whirl import motion_at_speed
from solidwhirl.rotordyn.superelement.residual_energy import NOT_SUMMED

# Speeds at which the branches of other models are computed; between them errors are linear.
_SPEEDS = 5
_PER_SPEED = ("eigenvalues", "frequency_hz", "whirl", "shares", "log_decrement", "overlap")


@dataclass(frozen=True, kw_only=True, eq=False)
class Estimates:
    """Relative error estimates of a run.

    `critical_speeds` are in the order of `critical`. `free_frequencies`: body to (k,) estimates of
    the frequencies of the free body at rest. `comparisons`: other models that were computed for it.
    `rule`: which of the modes count; the others are critically damped. `resonances`: estimates of
    other resonances that count.
    """

    at_rest: FrequencyErrors
    campbell: CampbellErrors
    critical_speeds: CriticalSpeedErrors
    free_frequencies: Mapping[str, FloatArray]
    comparisons: tuple[Comparison, ...]
    critical: tuple[rd.CriticalSpeed, ...]
    rule: DampingRule = DEFAULT_RULE
    resonances: tuple[float, ...] = ()

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
        """Largest estimate of modes and critical speeds that count, nan if there is none.

        Of the bodies that have an estimate.
        """
        told = self.campbell.parts.keys() - {*NOT_SUMMED, "eigen_solver"}
        if self.campbell.bodies_without_estimate and not told:
            return float("nan")
        branches = self.campbell.known[self.rule.counts(self.campbell.campbell.eigenvalues)]
        speeds = [
            float(known)
            for known, critical in zip(self.critical_speeds.known, self.critical, strict=True)
            if critical.counts(self.rule)
        ]
        values = np.concatenate([branches, speeds, self.resonances])
        known = values[np.isfinite(values)]
        return float(known.max()) if len(known) else float("nan")


class BeamVariants(NamedTuple):
    """Models of the engine with the other choices of beam theory, and their beams by name."""

    systems: tuple[rd.AssembledSystem, ...]
    elements: tuple[Mapping[str, rd.Superelement], ...]


def estimate_errors(
    system: rd.AssembledSystem,
    elements: Mapping[str, rd.Superelement],
    at_rest: rd.Modes,
    diagram: rd.Campbell,
    critical: Sequence[rd.CriticalSpeed],
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
    few = _at_few_speeds(diagram)
    # one model may be the second of a comparison and the first of the next
    modes_of = cache(_modes)
    for pair in comparisons:
        _add(rest_parts, pair, _at_rest_differences(at_rest, pair, modes_of))
        found = _branch_differences(few, pair, modes_of)
        _add(branch_parts, pair, _over_speeds(diagram, few, found))
        _add(speed_parts, pair, _speed_differences(critical, pair))
    free = {}
    if beams is not None:
        own_hz = at_rest.frequency_hz
        others = [modes_of(v, 0.0).modes.frequency_hz for v in beams.systems]
        found = _theory_errors(own_hz, [_filled(own_hz, hertz) for hertz in others])
        rest_parts["beam_theory"] = found * own_hz / _scale_hz(system, own_hz)
        own_hz = diagram.frequency_hz
        of_branches = (
            _theory_branch_errors(diagram, beams.systems, modes_of)
            * own_hz
            / _scale_hz(system, own_hz)
        )
        branch_parts["beam_theory"] = of_branches
        speed_parts["beam_theory"] = _critical_speed_errors_of_beams(critical, diagram, of_branches)
        own = {name: elements[name] for name in beams.elements[0]}
        free = _theory_free_errors(own, beams.elements)
    compared = [
        name for pair in comparisons if pair.part == "mesh" for name in pair.second_elements
    ]
    without = unestimated(elements, compared)
    free |= free_errors(elements, without, comparisons)
    return Estimates(
        at_rest=replace(rest, parts=rest_parts, bodies_without_estimate=without),
        campbell=replace(branches, parts=branch_parts, bodies_without_estimate=without),
        critical_speeds=replace(speeds, parts=speed_parts, bodies_without_estimate=without),
        free_frequencies=free,
        comparisons=comparisons,
        critical=tuple(critical),
    )


def unestimated(
    elements: Mapping[str, rd.Superelement], compared: Collection[str] = ()
) -> tuple[str, ...]:
    """Return the bodies that deform and do not tell what their elements miss, by name.

    Neither by a form "mesh" nor by another model: `compared`.
    """
    return tuple(
        name
        for name, element in elements.items()
        if element.level != "lumped"
        and name not in compared
        and all(form.part != "mesh" for form in element.error_forms)
    )


def free_errors(
    elements: Mapping[str, rd.Superelement],
    without: Sequence[str],
    comparisons: tuple[Comparison, ...] = (),
) -> dict[str, FloatArray]:
    """Errors of the frequencies of the free bodies that have forms, but of those `without` one."""
    known = (n for n, e in elements.items() if e.error_forms and n not in without)
    return {name: _free(elements[name], name, comparisons) for name in known}


def _add(parts: dict[str, FloatArray], pair: Comparison, difference: FloatArray) -> None:
    parts[pair.part] = parts.get(pair.part, np.zeros_like(difference)) + difference


def _at_rest_differences(at_rest: rd.Modes, pair: Comparison, modes_of: ModesOf) -> FloatArray:
    """Differences of the modes at rest, both sorted by frequency; nan beyond the shorter list."""
    second = modes_of(pair.second, 0.0).modes
    first = at_rest if pair.first is None else modes_of(pair.first, 0.0).modes
    out = np.full(len(at_rest.frequency_hz), np.nan)
    count = min(len(out), len(first.frequency_hz), len(second.frequency_hz))
    f, g = first.frequency_hz[:count], second.frequency_hz[:count]
    out[:count] = pair.safety * np.abs(f - g) / _scale_hz(pair.second, f)
    if pair.part == "mesh":  # what the finer model itself is wrong by
        out[:count] += frequency_errors(pair.second, second).known[:count]
    return out


class _Seen(NamedTuple):
    """Modes of another model at one speed, and how they whirl."""

    modes: rd.Modes
    whirl: StringArray


def _modes(system: rd.AssembledSystem, speed_rad_s: float) -> _Seen:
    modes = rd.modes_at_speed(system, speed_rad_s)
    motion = motion_at_speed(system, modes.shapes, modes.eigenvalues, speed_rad_s)
    return _Seen(modes, motion.whirl)


ModesOf = Callable[[rd.AssembledSystem, float], _Seen]


def _paired(
    few: rd.Campbell, hertz: FloatArray, at: int, other: _Seen
) -> tuple[FloatArray, IntArray]:
    """Frequencies of another model that belong to those of branches at a speed, and its modes."""
    partner = frequency_partners(hertz, few.whirl[:, at], other.modes.frequency_hz, other.whirl)
    return _at_partners(partner, other.modes.frequency_hz), partner


def _branch_differences(few: rd.Campbell, pair: Comparison, modes_of: ModesOf) -> FloatArray:
    """Differences along the branches of a diagram, speed by speed."""
    out = np.full(few.frequency_hz.shape, np.nan)
    for at, speed in enumerate(few.speeds_rad_s.tolist()):
        own = few.frequency_hz[:, at]
        if pair.first is not None:
            own, _ = _paired(few, own, at, modes_of(pair.first, speed))
        seen = modes_of(pair.second, speed)
        other, partner = _paired(few, own, at, seen)
        out[:, at] = pair.safety * np.abs(own - other) / _scale_hz(pair.second, own)
        if pair.part == "mesh":  # what the finer model itself is wrong by
            out[:, at] += _at_partners(partner, frequency_errors(pair.second, seen.modes).known)
    return out


def _speed_differences(critical: Sequence[rd.CriticalSpeed], pair: Comparison) -> FloatArray:
    """Differences of the critical speeds, each followed from one model to the next."""
    first = list(critical) if pair.first is None else followed_critical_speeds(pair.first, critical)
    second = followed_critical_speeds(pair.second, first)
    out = np.full(len(critical), np.nan)
    for k, (one, other) in enumerate(zip(first, second, strict=True)):
        if one is not None and other is not None:
            out[k] = pair.safety * abs(one.speed_rad_s - other.speed_rad_s) / one.speed_rad_s
            if pair.part == "mesh":
                out[k] += float(critical_speed_errors(pair.second, [other]).known[0])
    return out


def _scale_hz(system: rd.AssembledSystem, frequency_hz: FloatArray) -> FloatArray:
    """What errors of frequencies are measured against."""
    return error_scale(system, 2.0 * np.pi * frequency_hz) / (2.0 * np.pi)


def _at_partners(partner: IntArray, values: FloatArray) -> FloatArray:
    """Rows of the partners; nan where there is none."""
    out = np.full((len(partner), *values.shape[1:]), np.nan)
    has = partner >= 0
    out[has] = values[partner[has]]
    return out


def _free(element: rd.Superelement, name: str, comparisons: tuple[Comparison, ...]) -> FloatArray:
    """Errors of the frequencies of one free body at rest, in their order."""
    wanted = element.free_frequencies_hz
    alone = rd.assemble(standing({name: rd.Rotor(element=element, speed_ratio=1.0)}), ())
    modes = rd.modes_at_speed(alone, 0.0)
    found = frequency_errors(alone, modes)
    near = np.abs(modes.frequency_hz[None, :] - wanted[:, None]).argmin(axis=1)
    out = np.asarray(found.known[near])
    for pair in comparisons:
        if pair.part == "interface_coupling" or name not in pair.second_elements:
            continue
        first = pair.first_elements[name].free_frequencies_hz
        second = pair.second_elements[name].free_frequencies_hz
        count = min(len(out), len(first), len(second))
        out[:count] += pair.safety * np.abs(first[:count] - second[:count]) / first[:count]
        out[count:] = np.nan
    return out


# What beam theory may be wrong by in the results of a scene on the beam level.


def _theory_branch_errors(
    diagram: rd.Campbell, variants: Sequence[rd.AssembledSystem], modes_of: ModesOf
) -> FloatArray:
    """Errors of the branches of a Campbell diagram, (b, s), between a few speeds linear in them."""
    few = _at_few_speeds(diagram)
    own, others = few.frequency_hz, []
    for variant in variants:
        columns = [
            _paired(few, own[:, at], at, modes_of(variant, speed))[0]
            for at, speed in enumerate(few.speeds_rad_s.tolist())
        ]
        others.append(np.column_stack(columns))
    return _over_speeds(diagram, few, _theory_errors(own, others))


def _at_few_speeds(diagram: rd.Campbell) -> rd.Campbell:
    """The diagram at some of its speeds, first and last among them."""
    count = len(diagram.speeds_rad_s)
    at = np.unique(np.linspace(0, count - 1, min(_SPEEDS, count)).round()).astype(int)
    return replace(
        diagram,
        speeds_rad_s=diagram.speeds_rad_s[at],
        **{name: getattr(diagram, name)[:, at] for name in _PER_SPEED},
    )


def _over_speeds(diagram: rd.Campbell, few: rd.Campbell, errors: FloatArray) -> FloatArray:
    """Errors along the branches of a diagram, (b, s), from those at few speeds."""
    at = (diagram.speeds_rad_s, few.speeds_rad_s)
    out = np.array([np.interp(*at, row) for row in errors]).reshape(diagram.frequency_hz.shape)
    return np.where(np.isfinite(diagram.frequency_hz), out, np.nan)


def _critical_speed_errors_of_beams(
    critical: Sequence[rd.CriticalSpeed], diagram: rd.Campbell, errors: FloatArray
) -> FloatArray:
    """Errors of critical speeds from those of the branches that make them, (k,).

    A branch of slope f' meets the line f = αΩ/2π, and a change e of its frequency moves the meeting
    by e f / (f - Ω f'). `errors`: of the branches of the diagram of the same engine, (b, s).
    """
    out = np.full(len(critical), np.nan)
    speeds = diagram.speeds_rad_s
    if len(speeds) < 2:
        return out
    for k, point in enumerate(critical):
        # the nearest branch that is there on both sides
        rows = [np.interp(point.speed_rad_s, speeds, row) for row in diagram.frequency_hz]
        gap = np.abs(np.array(rows) - point.frequency_hz)
        if not np.isfinite(gap).any():
            continue
        branch = int(np.nanargmin(gap))
        slope = np.interp(
            point.speed_rad_s, speeds, np.gradient(diagram.frequency_hz[branch], speeds)
        )
        lever = point.frequency_hz / abs(point.frequency_hz - point.speed_rad_s * slope)
        out[k] = lever * np.interp(point.speed_rad_s, speeds, errors[branch])
    return out


def _theory_free_errors(
    elements: Mapping[str, rd.Superelement], variants: Sequence[Mapping[str, rd.Superelement]]
) -> dict[str, FloatArray]:
    """Errors of the frequencies of the free bodies at rest, by name."""
    out = {}
    for name, element in elements.items():
        own = element.free_frequencies_hz
        others = [_filled(own, v[name].free_frequencies_hz) for v in variants]
        out[name] = _theory_errors(own, others)
    return out


def _filled(own: FloatArray, other: FloatArray) -> FloatArray:
    """The other list at the length of the first, nan where it ends."""
    out = np.full(own.shape, np.nan)
    count = min(len(own), len(other))
    out[:count] = other[:count]
    return out


def _theory_errors(own: FloatArray, others: Sequence[FloatArray]) -> FloatArray:
    values = np.array([own, *others])
    known = np.isfinite(values).all(axis=0) & (values > 0.0).all(axis=0)
    out = np.full(own.shape, np.nan)
    if known.any():
        out[known] = beam_theory_error(values[:, known])
    return out
