"""Error estimates of the branches of a Campbell diagram."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.campbell.body_frames import branch_columns
from solidwhirl.rotordyn.campbell.diagram import Campbell
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.estimates.eigenvalue_errors import (
    WIDEST,
    FrequencyErrors,
    bodies_without_forms,
    frequency_errors,
)
from solidwhirl.rotordyn.modes.eigen import Modes, mode_columns, modes_at_speed
from solidwhirl.rotordyn.perturbation.lowest_modes import LowestModes

# Modes above the highest branch that may be as close to it as it is wrong.
_ABOVE = 4
# Frequencies closer than this (relative) may be one.
_SAME = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class CampbellErrors(FrequencyErrors):
    """Hold relative error estimates of the eigenvalues of a Campbell diagram.

    Parts have the shape (b, s), nan where a branch is absent; see `campbell_errors` for what
    "mode_truncation" and "speed_interpolation" share.
    """

    campbell: Campbell


def campbell_errors(assembled: AssembledSystem, campbell: Campbell) -> CampbellErrors:
    """Estimate the relative errors of the branches of a Campbell diagram, by branch and speed.

    The modes are found as the diagram found them, which does not keep them. Raises AnalysisError if
    the diagram does not belong to the system.

    The basis of a body is made of modes at rest and at top speed. With e(Ω) the error of the
    reduction along a branch and t = (Ω² − a²) / (b² − a²) between its slowest and its fastest
    speed a and b (rest and top speed of the diagram, as a rule),
    "speed_interpolation" = max(0, e(Ω) − [(1 − t) e(a) + t e(b)]) and "mode_truncation" is the
    rest: what exceeds the line between both ends comes from speeds the basis was not made for.
    """
    shape, modes_at = campbell.eigenvalues.shape, _modes_at(assembled, campbell)
    parts = {"eigen_solver": np.full(shape, np.nan)}
    for place, speed in enumerate(campbell.speeds_rad_s):
        alive = np.flatnonzero(np.isfinite(campbell.eigenvalues[:, place]))
        if not alive.size:
            continue
        modes = modes_at(float(speed))
        columns = branch_columns(campbell.eigenvalues[alive, place], modes.eigenvalues, speed)
        kept = np.arange(min(int(columns.max()) + 1 + _ABOVE, modes.eigenvalues.size))
        found = frequency_errors(assembled, mode_columns(modes, kept))
        for part, values in found.parts.items():
            parts.setdefault(part, np.full(shape, np.nan))[alive, place] = values[columns]
    if "mode_truncation" in parts:
        whole = parts["mode_truncation"]
        over = interpolation_part(campbell.speeds_rad_s, whole)
        parts["speed_interpolation"], parts["mode_truncation"] = over, whole - over
    return CampbellErrors(
        campbell=campbell,
        parts=parts,
        bodies_without_estimate=bodies_without_forms(assembled),
    )


def _modes_at(assembled: AssembledSystem, campbell: Campbell) -> Callable[[float], Modes]:
    """Return what finds the modes at a speed, as far as some above the highest branch."""
    top = np.nan_to_num(campbell.eigenvalues.imag).max(axis=0, initial=0.0) * (1.0 + _SAME)
    highest = dict(zip(campbell.speeds_rad_s.tolist(), top.tolist(), strict=True))

    def needed(modes: Modes) -> int:
        frequencies, branches = modes.eigenvalues.imag, highest[modes.speed_rad_s]
        # what is farther above is never changed together with a branch
        near = np.count_nonzero(frequencies * (1.0 - WIDEST) <= branches)
        return min(int(near), int(np.count_nonzero(frequencies <= branches)) + _ABOVE)

    def lowest(speed_rad_s: float) -> Modes:
        modes = modes_at_speed(assembled, speed_rad_s, 2 * (len(campbell.eigenvalues) + _ABOVE))
        enough = needed(modes) <= modes.eigenvalues.size
        return modes if enough else modes_at_speed(assembled, speed_rad_s)

    if assembled.is_conservative or assembled.depends_on_frequency:
        return lowest
    # where the whole spectrum is computed anyway, some of it would save nothing
    found = LowestModes(assembled, assembled.size, needed)
    found.coming_rad_s = campbell.speeds_rad_s
    return found.at


def interpolation_part(speeds_rad_s: FloatArray, errors: FloatArray) -> FloatArray:
    """Return what exceeds the line between the ends of each branch, straight in Ω².

    `speeds_rad_s`: Ω, shape (s,); `errors`: e along each branch, shape (b, s), nan where it is
    absent. Returns max(0, e − line), shape (b, s), nan where the branch is absent; 0 at both ends.
    """
    square = speeds_rad_s**2
    over = np.full(errors.shape, np.nan)
    for row, values in zip(over, errors, strict=True):
        alive = np.flatnonzero(np.isfinite(values))
        if not alive.size:
            continue
        first, last = (alive[k(square[alive])] for k in (np.argmin, np.argmax))
        span = square[last] - square[first]
        part = (square[alive] - square[first]) / (span if span > 0 else 1.0)
        line = (1.0 - part) * values[first] + part * values[last]
        row[alive] = np.maximum(0.0, values[alive] - line)
        row[[first, last]] = 0.0
    return over
