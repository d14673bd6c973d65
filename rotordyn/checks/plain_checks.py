"""Checks of results against the unsimplified system: its parts at every speed, as they are given.

A number passes if it is right to `ACCURACY`, or to what rounding of the matrices at that place
allows, whichever is more; both are worked out for each number.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.assembly.system import AssembledSystem
from solidwhirl.rotordyn.campbell.diagram import Campbell
from solidwhirl.rotordyn.checks.mode_counts import (
    all_listed,
    full_spectrum,
    is_counted_by_signs,
    missing_modes,
    modes_below,
)
from solidwhirl.rotordyn.checks.plain_system import (
    PlainMatrices,
    PlainSystem,
    joint_errors,
    root_error,
)
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.core.second_order import SecondOrder
from solidwhirl.rotordyn.core.spectrum import spectrum
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.modes.damping import DEFAULT_RULE
from solidwhirl.rotordyn.superelement.invariants import Invariant, compared, undecided

# Relative accuracy that every number must have, where rounding allows it.
ACCURACY = 1e-9
# Units in the last place that solvers may lose in every term.
ROUNDINGS = 256.0
# and in a speed.
_SPEED_ROUNDINGS = 16.0
_CONSTRAINTS = 1e-9
ROOTS, COUNT = "every root is one of the system", "no mode is missing"
COUNT_SPEEDS = "no critical speed is missing"
# Missing modes and speeds that are listed.
_MOST_FAULTS = 6
# Two roots of one system nearer than this are taken for the same; residuals tell the rest.
_SAME = 1e-6
# Below this part of a range of speeds what is free to drift is told from nothing.
_NEAR_REST = 1e-4
# Part of a root by which its neighbours differ that tell the slope there, to a few digits.
_BESIDE = 1e-6
# Width of an interval (relative) that holds one crossing of a line.
_NARROW = 1e-9
# A root this near to the line of an excitation is neither above nor below.
_ON_THE_LINE = 1e-7
# Processor work of one group of checks, in operations: a second or two.
_WORK = 2e9
_PER_ROOT, _PER_SPECTRUM = 40.0, 240.0
_FEWEST = 3

_JOINTS = "assembled system"


class Miss(NamedTuple):
    """Relative error of a number, the most it may have, and the speed [rad/s]."""

    error: float
    limit: float
    speed: float

    @property
    def share(self) -> float:
        """Error over limit."""
        return self.error / self.limit if np.isfinite(self.error) else np.inf


def some_speeds(
    speeds_rad_s: FloatArray, knots_rad_s: Iterable[float], work_of_one: float
) -> FloatArray:
    """Return the speeds to look at: all if that is quick, else the ends, knots and a spread.

    `speeds_rad_s`: all there are; `work_of_one`: operations per speed. `knots_rad_s`: of speed
    laws; those among the speeds or the nearest ones are kept.
    """
    count = max(_FEWEST, int(_WORK / max(work_of_one, 1.0)))
    if speeds_rad_s.size <= count:
        return speeds_rad_s
    spread = np.linspace(0, speeds_rad_s.size - 1, count).round().astype(int)
    near = [int(np.argmin(np.abs(speeds_rad_s - knot))) for knot in knots_rad_s]
    chosen = near if len(near) <= count else []
    return np.asarray(speeds_rad_s[sorted({*spread.tolist(), *chosen})])


def check_joints(plain: PlainSystem) -> tuple[Invariant, ...]:
    """Check that the coordinates of a system hold what joints forbid, and nothing else."""
    broken, lost = joint_errors(plain)
    concerns = "all frequencies and responses"
    return (
        compared("exact joints are kept", _JOINTS, broken, _CONSTRAINTS, concerns),
        compared("no motion is lost", _JOINTS, abs(lost), 0.0, concerns),
    )


def root_miss(
    matrices: PlainMatrices, value: complex, speed: float, slope: ComplexArray | None = None
) -> Miss:
    """Return the relative error of an eigenvalue and its limit; `slope`: see `root_error`."""
    found, size = root_error(matrices, value, slope), max(abs(value), float(np.finfo(float).tiny))
    return Miss(found.distance / size, ACCURACY + ROUNDINGS * found.rounding / size, speed)


def root_misses(plain: PlainSystem, values: ComplexArray, speed: float) -> list[Miss]:
    """Return the relative error of every eigenvalue of a speed, bearings as they are at it."""
    if not plain.depends_on_frequency:
        matrices = plain.at(speed)
        return [root_miss(matrices, complex(value), speed) for value in values]
    found = []
    for value in values.tolist():
        near = [value * (1.0 + side * _BESIDE) for side in (-1.0, 1.0)]
        before, after = (plain.at(speed, rate).dynamic(rate) for rate in near)
        slope = (after - before) / (near[1] - near[0])
        found.append(root_miss(plain.at(speed, value), value, speed, slope))
    return found


def worst_of(name: str, where: str, concerns: str, misses: Sequence[Miss], text: str) -> Invariant:
    """Return the check of the number nearest to its limit.

    `text`: how many numbers were looked at.
    """
    worst = max(misses, key=lambda one: one.share)
    reason = f"{text}; largest at {worst.speed * RPM_PER_RAD_S:.6g} rpm"
    return compared(name, where, worst.error, worst.limit, concerns, reason)


def check_campbell(
    assembled: AssembledSystem,
    diagram: Campbell,
    frequency_max_hz: float | None = None,
    branch_count: int | None = None,
) -> tuple[Invariant, ...]:
    """Check the branches of a Campbell diagram against the system as it is given.

    `frequency_max_hz`, `branch_count`: as given to `campbell`: which modes the diagram must hold at
    every speed. None with no limit either takes the smallest number of branches at a speed. Returns
    relative error of every root, and modes of the whole spectrum that no branch holds.
    """
    plain, speeds_rad_s = PlainSystem.of(assembled), diagram.speeds_rad_s
    eigenvalues = diagram.eigenvalues
    if branch_count is None:
        branch_count = int(np.isfinite(eigenvalues).sum(axis=0).min())
    where, concerns = "Campbell diagram", "branches of the Campbell diagram"
    cube = float(plain.transformation.shape[1]) ** 3
    work = cube * (_PER_ROOT * len(eigenvalues) + _PER_SPECTRUM)
    order = np.argsort(speeds_rad_s)
    chosen = some_speeds(speeds_rad_s[order], plain.knots_rad_s, work)
    misses, faults = [], []
    for speed in chosen:
        column = eigenvalues[:, int(np.argmin(np.abs(speeds_rad_s - speed)))]
        column = column[np.isfinite(column)]
        found = root_misses(plain, column, float(speed))
        misses += found
        if plain.depends_on_frequency:
            continue
        matrices = plain.at(float(speed))
        are_roots = all(miss.share <= 1.0 for miss in found)
        if are_roots and all_listed(matrices, column, branch_count, frequency_max_hz):
            continue
        missing = missing_modes(
            matrices, column, count=branch_count, frequency_max_hz=frequency_max_hz
        )
        place = f"at {speed * RPM_PER_RAD_S:.6g} rpm"
        faults += [f"{place} {mode.imag / (2.0 * np.pi):.6g} Hz" for mode in missing]
    text = f"at {chosen.size} of {speeds_rad_s.size} speeds"
    out = []
    if misses:
        out.append(worst_of(ROOTS, where, concerns, misses, text))
    if plain.depends_on_frequency:
        reason = "bearings depend on the frequency: modes are counted as they are found"
        return (*out, undecided(COUNT, where, concerns, reason))
    if faults:
        text = f"missing: {'; '.join(faults[:_MOST_FAULTS])}"
    return (*out, compared(COUNT, where, len(faults), 0.0, concerns, text))


def check_critical_roots(
    plain: PlainSystem,
    roots: Sequence[tuple[float, complex]],
    excitation_ratio: float,
    speed_max_rad_s: float,
    operator: SecondOrder | None = None,
) -> tuple[Invariant, ...]:
    """Check critical speeds against the system as it is given.

    `roots`: each critical speed Ω with its eigenvalue λ, Im λ = |α| Ω, by rising Ω;
    `excitation_ratio`, `speed_max_rad_s`: |α|, and the end of the range; `operator`: what roots are
    counted in where bearings depend on the frequency: one frozen at iαΩ has roots that the system,
    with the states of controllers among its unknowns, has not. Returns relative error of
    every root; critical speeds that are missing. The number of roots above the line of the
    excitation changes at critical speeds alone, as roots that begin or end do so at zero frequency;
    it is taken between any two neighbours of the list.
    """
    where, concerns = f"critical speeds, excitation {excitation_ratio:g}", "critical speeds"
    misses = [_at_speed(plain, value, speed) for speed, value in roots]
    out = []
    if misses:
        text = f"{len(misses)} critical speeds"
        out.append(worst_of(ROOTS, where, concerns, misses, text))
    listed = np.array([speed for speed, _ in roots])
    between = _between(listed, speed_max_rad_s, plain.knots_rad_s)
    work = _PER_SPECTRUM * float(plain.transformation.shape[1]) ** 3
    if between.size * work > 10.0 * _WORK:
        reason = f"it takes all roots at {between.size} speeds, too long for so many coordinates"
        return (*out, undecided(COUNT_SPEEDS, where, concerns, reason))
    counted = operator if plain.depends_on_frequency else None
    above = [_above(plain, counted, speed, excitation_ratio) for speed in between]
    faults = []
    for (low, first), (high, last) in pairwise(zip(between, above, strict=True)):
        if first is None or last is None:
            continue
        inside = listed[(listed > low) & (listed < high)]
        net = first - last
        if inside.size >= abs(net) and (inside.size - net) % 2 == 0:
            continue
        # roots so damped that they do not resonate are no critical speeds
        ends = ((float(low), first), (float(high), last))
        met = _meetings(plain, counted, *ends, excitation_ratio)
        if met is None:
            reason = "more roots come and go on the line of the excitation than there are: rounding"
            return (*out, undecided(COUNT_SPEEDS, where, concerns, reason))
        count = DEFAULT_RULE.counts(np.array([m.root for m in met], dtype=complex))
        speeds = np.array([m.speed for m in met])[count]
        lost = [s for s in speeds if not (np.abs(inside - s) <= _SAME * s).any()]
        faults += [f"{speed * RPM_PER_RAD_S:.9g} rpm" for speed in lost]
    text = f"counted at {between.size} speeds"
    if faults:
        text = f"missing: {'; '.join(faults[:_MOST_FAULTS])}"
    return (*out, compared(COUNT_SPEEDS, where, len(faults), 0.0, concerns, text))


class _Meeting(NamedTuple):
    """A speed at which a root meets the line of an excitation."""

    speed: float
    root: complex


def _meetings(
    plain: PlainSystem,
    operator: SecondOrder | None,
    low: tuple[float, int],
    high: tuple[float, int],
    ratio: float,
) -> list[_Meeting] | None:
    """Return what changes the number of roots above a line between two speeds.

    None where it changes more often than there are roots, which rounding alone makes.
    """
    found, wide = [], deque([(low, high)])
    while wide:
        low, high = wide.popleft()
        (start, first), (end, last) = low, high
        middle = 0.5 * (start + end)
        values = _on_line(plain, operator, middle, ratio)
        if end - start <= _NARROW * end:
            order = np.argsort(np.abs(values.imag - ratio * middle))[: abs(first - last)]
            found += [_Meeting(middle, complex(values[at])) for at in order]
        else:
            there = (middle, int(np.count_nonzero(values.imag > ratio * middle)))
            wide += [(a, b) for a, b in ((low, there), (there, high)) if a[1] != b[1]]
        if len(found) + len(wide) > values.size:
            return None
    return sorted(found, key=lambda m: m.speed)


def _on_line(
    plain: PlainSystem, operator: SecondOrder | None, speed: float, ratio: float
) -> ComplexArray:
    """Return all roots with bearings as they are at the frequency of the excitation."""
    line = ratio * speed
    if operator is not None:
        return spectrum(operator, speed, line, line).values
    return full_spectrum(plain.at(speed, 1j * line), line)


def _at_speed(plain: PlainSystem, value: complex, speed: float) -> Miss:
    """Error of a root at a speed that is itself rounded: where a law is steep, that is seen."""
    roots = np.array([value])
    (found,) = root_misses(plain, roots, speed)
    step = _SPEED_ROUNDINGS * float(np.finfo(float).eps) * speed
    beside = [root_misses(plain, roots, speed + side)[0].error for side in (-step, step)]
    moved = max(abs(error - found.error) for error in beside)
    return found._replace(limit=found.limit + moved)


def _between(listed: FloatArray, top: float, knots: Sequence[float]) -> FloatArray:
    """Speeds between the neighbours of a list, near rest, at the end and at knots."""
    ends = np.unique(np.concatenate(([1e-3 * top, top], listed[(listed > 0) & (listed < top)])))
    middle = 0.5 * (ends[1:] + ends[:-1])
    # equal ones are one root twice, with nothing between them
    apart = np.diff(ends) > _SAME * ends[1:]
    inner = [knot for knot in knots if 1e-3 * top < knot < top]
    lowest = 0.5 * float(listed.min(initial=np.inf))
    low = min(1e-3 * top, max(_NEAR_REST * top, lowest))
    return np.asarray(np.unique(np.concatenate(([low], middle[apart], inner, [top]))))


def _above(
    plain: PlainSystem, operator: SecondOrder | None, speed: float, ratio: float
) -> int | None:
    """Number of roots above the line of an excitation; None if one lies on it."""
    line = ratio * speed
    matrices = plain.at(float(speed), 1j * line)
    if operator is None and is_counted_by_signs(matrices):
        sides = (1.0 - _ON_THE_LINE, 1.0 + _ON_THE_LINE)
        below, at_most = (modes_below(matrices, side * line) for side in sides)
        return len(matrices.mass) - below if below == at_most else None
    away = _on_line(plain, operator, float(speed), ratio).imag - line
    if (np.abs(away) <= _ON_THE_LINE * line).any():
        return None
    return int(np.count_nonzero(away > 0))
