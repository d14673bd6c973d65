"""What beam theory may be wrong by in the results of a scene on the beam level."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from solidwhirl.beams.error import beam_theory_error
from solidwhirl.rotordyn import (
    AssembledSystem,
    Campbell,
    CriticalSpeed,
    Modes,
    Superelement,
    campbell,
    modes_at_speed,
)
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.estimates.differences import campbell_differences

#: Branches that a compared diagram has more, so that those at the upper edge find their partners.
MORE_BRANCHES = 4
# Speeds at which the branches of the variants are computed.
_SPEEDS = 5
_PER_SPEED = ("eigenvalues", "frequency_hz", "whirl", "log_decrement", "overlap")


def at_rest_errors(at_rest: Modes, variants: Sequence[AssembledSystem]) -> FloatArray:
    """Errors of the modes at rest, (m,); nan beyond the shortest list of the variants."""
    own = at_rest.frequency_hz
    return _errors(own, [_filled(own, modes_at_speed(v, 0.0).frequency_hz) for v in variants])


def branch_errors(diagram: Campbell, variants: Sequence[AssembledSystem]) -> FloatArray:
    """Errors of the branches of a Campbell diagram, (b, s), between a few speeds linear in them."""
    speeds = diagram.speeds_rad_s
    chosen = np.unique(np.linspace(0, len(speeds) - 1, min(_SPEEDS, len(speeds))).round())
    at = chosen.astype(int)
    own = diagram.frequency_hz[:, at]
    few = replace(
        diagram,
        speeds_rad_s=speeds[at],
        **{name: getattr(diagram, name)[:, at] for name in _PER_SPEED},
    )
    others = []
    for variant in variants:
        second = campbell(variant, speeds[at], branch_count=len(own) + MORE_BRANCHES)
        others.append((1.0 - campbell_differences(few, second).frequency) * own)
    found = _errors(own, others)
    out = np.array([np.interp(speeds, speeds[at], errors) for errors in found])
    out = out.reshape(diagram.frequency_hz.shape)
    return np.where(np.isfinite(diagram.frequency_hz), out, np.nan)


def critical_speed_errors_of_beams(
    critical: Sequence[CriticalSpeed], diagram: Campbell, errors: FloatArray
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


def free_errors(
    elements: Mapping[str, Superelement], variants: Sequence[Mapping[str, Superelement]]
) -> dict[str, FloatArray]:
    """Errors of the frequencies of the free bodies at rest, by name."""
    out = {}
    for name, element in elements.items():
        own = element.free_frequencies_hz
        others = [_filled(own, v[name].free_frequencies_hz) for v in variants]
        out[name] = _errors(own, others)
    return out


def _filled(own: FloatArray, other: FloatArray) -> FloatArray:
    """The other list at the length of the first, nan where it ends."""
    out = np.full(own.shape, np.nan)
    count = min(len(own), len(other))
    out[:count] = other[:count]
    return out


def _errors(own: FloatArray, others: Sequence[FloatArray]) -> FloatArray:
    values = np.array([own, *others])
    known = np.isfinite(values).all(axis=0) & (values > 0.0).all(axis=0)
    out = np.full(own.shape, np.nan)
    if known.any():
        out[known] = beam_theory_error(values[:, known])
    return out
