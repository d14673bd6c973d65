"""The table of a study: errors against one truth, Pareto fronts and slopes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import linregress

from solidwhirl.rotordyn import Campbell
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, IntArray
from solidwhirl.rotordyn.estimates.differences import (
    campbell_differences,
    critical_speed_differences,
)
from solidwhirl.study.cases import StudyCase
from solidwhirl.study.measure import Measured

# Errors nearer to what the truth or another approximation is wrong by are not of the mesh.
_CLEAR_OF_FLOOR = 3.0
# Least time and memory beyond that of the start which a fit takes for a measurement.
_LEAST_S, _LEAST_GIB = 0.02, 0.005
# Frequencies below this share of the largest are those of motions that nothing holds.
_FREE = 1e-6
#: A level is shown where its unknowns span this factor, a slope where three rungs span that one.
LEVEL_SPAN, SLOPE_SPAN, _FEWEST = 30.0, 4.0, 3
QUANTITIES = ("error", "cpu_s", "memory_gib")


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What became of a case, "done", "failed" or "skipped": its measurement, or why none."""

    case: StudyCase
    status: str
    message: str = ""
    measured: Measured | None = None


@dataclass(frozen=True, kw_only=True)
class ErrorPair:
    """Largest true and estimated relative error of one kind of result; nan where there is none."""

    true: float = np.nan
    estimate: float = np.nan
    #: effectivity, least_effectivity: estimate / true: of the largest, and the smallest of the
    #: results one by one; nan where the true error is not clear of that of the reference
    effectivity: float = np.nan
    least_effectivity: float = np.nan
    #: Results that the reference has no partner for: they are off by more than 25 %
    unmatched: int = 0


@dataclass(frozen=True, kw_only=True)
class StudyRow:
    """A case with its errors; those of cases that are not done are nan."""

    outcome: Outcome
    campbell: ErrorPair = ErrorPair()
    critical_speeds: ErrorPair = ErrorPair()

    def value(self, quantity: str) -> float:
        """Return "unknowns", "error", or "cpu_s" and "memory_gib" without the program's start."""
        found = self.outcome.measured
        if found is None:
            return np.nan
        if quantity == "cpu_s":
            return found.usage.cpu_s - found.startup.cpu_s
        if quantity == "memory_gib":
            return found.usage.peak_memory_gib - found.startup.peak_memory_gib
        return self.campbell.true if quantity == "error" else float(found.unknowns)

    @property
    def comparable(self) -> bool:
        """Whether its error can be held against its cost."""
        wanted = self.outcome.case.ladder != "reference"
        return wanted and bool(np.isfinite(self.campbell.true)) and not self.campbell.unmatched


@dataclass(frozen=True, kw_only=True)
class StudySlope:
    """A power law y = factor · unknowns^slope through a series, by least squares of logarithms."""

    series: str
    quantity: str  #: One of `QUANTITIES`; costs are without the program's start
    slope: float
    factor: float
    #: standard_error, scatter_log10: of the slope; root mean square deviation of log10 y from the
    #: line
    standard_error: float
    scatter_log10: float
    points: int
    left_out: int  #: Points left out: errors too near the floor, or costs too small to be measured


@dataclass(frozen=True, kw_only=True)
class StudyTable:
    """All rows of a study."""

    rows: tuple[StudyRow, ...]
    floor: float  #: Estimated error of the reference: smaller errors can't be told from it
    #: time_front, memory_front: names of the cases that no other one beats, by increasing cost
    time_front: tuple[str, ...]
    memory_front: tuple[str, ...]
    slopes: tuple[StudySlope, ...]
    spans: dict[str, float]  #: Largest over smallest number of unknowns of each level

    @property
    def shown_levels(self) -> frozenset[str]:
        """Beams and the levels with a real ladder; all where none has one."""
        ladders = {k for k, span in self.spans.items() if k != "beam" and span >= LEVEL_SPAN}
        return frozenset({*ladders, "beam"} if ladders else self.spans)

    def shown(self, row: StudyRow) -> bool:
        """Whether a row is drawn."""
        return row.comparable and row.outcome.case.level in self.shown_levels


def study_table(outcomes: Sequence[Outcome]) -> StudyTable:
    """Hold all cases against the reference, which is the first one and done."""
    truth = outcomes[0].measured
    assert truth is not None
    floor = _largest(truth.campbell_estimate)
    floor = floor if np.isfinite(floor) else 0.0
    rows = tuple(_row(o, truth, floor) for o in outcomes)
    able = [r for r in rows if r.comparable]
    error = np.array([max(r.campbell.true, floor) for r in able])
    used = [r.outcome.measured.usage for r in able if r.outcome.measured]
    fronts = [
        tuple(able[k].outcome.case.name for k in pareto_front(cost, error))
        for cost in ([u.cpu_s for u in used], [u.peak_memory_gib for u in used])
    ]
    return StudyTable(
        rows=rows,
        floor=floor,
        time_front=fronts[0],
        memory_front=fronts[1],
        slopes=_slopes(able, floor),
        spans=_spans(able),
    )


def pareto_front(cost: Sequence[float], error: FloatArray) -> list[int]:
    """Return the points with a smaller error than all that cost as much or less, by cost."""
    front: list[int] = []
    for k in np.lexsort((error, np.asarray(cost, dtype=float))):
        if not front or error[k] < error[front[-1]]:
            front.append(int(k))
    return front


def _spans(rows: Sequence[StudyRow]) -> dict[str, float]:
    unknowns: dict[str, list[float]] = {}
    for row in rows:
        unknowns.setdefault(row.outcome.case.level, []).append(row.value("unknowns"))
    return {level: max(found) / min(found) for level, found in unknowns.items()}


def _row(outcome: Outcome, truth: Measured, floor: float) -> StudyRow:
    found = outcome.measured
    if found is None:
        return StudyRow(outcome=outcome)
    # branches of motions that nothing holds have no relative error
    keep = held_branches(found.campbell)
    branches = campbell_differences(
        _part(found.campbell, keep), _part(truth.campbell, held_branches(truth.campbell))
    )
    speeds = critical_speed_differences(found.critical_speeds, truth.critical_speeds)
    estimate = found.campbell_estimate
    return StudyRow(
        outcome=outcome,
        campbell=_pair(
            branches.frequency,
            estimate[keep] if len(estimate) == len(keep) else np.zeros((0, 0)),
            branches.partner,
            floor,
        ),
        critical_speeds=_pair(
            speeds.speed[:, None], found.critical_estimate[:, None], speeds.partner, floor
        ),
    )


def held_branches(diagram: Campbell) -> BoolArray:
    """Return which branches are not those of free motions, (b,)."""
    highest = np.nanmax(np.nan_to_num(diagram.frequency_hz), axis=1, initial=0.0)
    return np.asarray(highest > _FREE * highest.max(initial=0.0))


def _part(diagram: Campbell, keep: BoolArray) -> Campbell:
    names = ("eigenvalues", "frequency_hz", "log_decrement", "whirl", "shares", "overlap")
    return replace(diagram, **{name: getattr(diagram, name)[keep] for name in names})


def _pair(
    difference: FloatArray, estimate: FloatArray, partner: IntArray, floor: float
) -> ErrorPair:
    """Largest errors; effectivity where the truth is known well enough."""
    # differences are relative to the model, errors to the truth
    true = [_largest(np.abs(row)) for row in difference / (1.0 - difference)]
    guess = [_largest(row) for row in estimate] if len(estimate) else [np.nan] * len(true)
    clear = [
        (g, t)
        for g, t in zip(guess, true, strict=True)
        if np.isfinite(g) and t > _CLEAR_OF_FLOOR * floor
    ]
    return ErrorPair(
        true=_largest(np.array(true)),
        estimate=_largest(np.array(guess)),
        effectivity=max(g for g, _ in clear) / max(t for _, t in clear) if clear else np.nan,
        least_effectivity=min(g / t for g, t in clear) if clear else np.nan,
        unmatched=int((partner < 0).sum()),
    )


def _largest(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else float("nan")


def _slopes(rows: Sequence[StudyRow], floor: float) -> tuple[StudySlope, ...]:
    """Slopes over the unknowns of every mesh ladder."""
    found = []
    meshes = [r for r in rows if r.outcome.case.ladder in ("graded", "uniform", "adaptive")]
    for series in dict.fromkeys(r.outcome.case.series for r in meshes):
        own = [r for r in meshes if r.outcome.case.series == series]
        for quantity in QUANTITIES:
            points = [
                (r.value("unknowns"), r.value(quantity)) for r in own if _counts(r, quantity, floor)
            ]
            slope = fitted(series, quantity, points, len(own) - len(points))
            found += [slope] if slope else []
    return tuple(found)


def _counts(row: StudyRow, quantity: str, floor: float) -> bool:
    """Whether a value is clearly that of the mesh, or above what can be measured."""
    if quantity == "error":
        assert row.outcome.measured is not None
        other = floor + row.outcome.measured.parts.get("mode_truncation", 0.0)
        return row.campbell.true > _CLEAR_OF_FLOOR * other
    return row.value(quantity) > {"cpu_s": _LEAST_S, "memory_gib": _LEAST_GIB}[quantity]


def fitted(
    series: str, quantity: str, points: Sequence[tuple[float, float]], left_out: int
) -> StudySlope | None:
    """Fit a power law; None where no three points span a factor 4 in unknowns."""
    if len(points) < _FEWEST:
        return None
    x, y = np.log10(np.array(points)).T
    if np.ptp(x) < np.log10(SLOPE_SPAN):
        return None
    line = linregress(x, y)
    rest = y - line.intercept - line.slope * x
    return StudySlope(
        series=series,
        quantity=quantity,
        slope=float(line.slope),
        factor=float(10.0**line.intercept),
        standard_error=float(line.stderr),
        scatter_log10=float(np.sqrt(rest @ rest / (len(x) - 2))),
        points=len(x),
        left_out=left_out,
    )
