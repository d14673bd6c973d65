"""The table of a study: one row per case, with its true and its estimated errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from solidwhirl.study_errors import as_array, critical_errors, held_branches, matched_errors
from solidwhirl.study_fit import Slope, fit_slope, pareto_front
from solidwhirl.study_runner import CaseOutcome

FloatArray = npt.NDArray[np.float64]

# Errors nearer to what the truth or another approximation is wrong by are not of the mesh.
_CLEAR_OF_FLOOR = 3.0
# Least time and memory beyond that of the start which a fit takes for a measurement.
_LEAST_S, _LEAST_GIB = 0.02, 0.005


@dataclass(frozen=True, kw_only=True)
class ErrorPair:
    """True and estimated error of one kind of result; nan where there is none.

    Attributes
    ----------
    true
        Largest relative error against the reference.
    estimate
        Largest estimated one of the same results.
    effectivity
        estimate / true, nan where the true error is below that of the reference.
    least_effectivity
        The smallest of the results one by one (branches, critical speeds).
    unmatched
        Results that the reference has no partner for: they are off by more than 25 %.
    """

    true: float
    estimate: float
    effectivity: float
    least_effectivity: float
    unmatched: int


NO_ERROR = ErrorPair(
    true=np.nan, estimate=np.nan, effectivity=np.nan, least_effectivity=np.nan, unmatched=0
)


@dataclass(frozen=True, kw_only=True)
class StudyRow:
    """One case with its results.

    Attributes
    ----------
    outcome
        The case and what was measured.
    campbell, critical_speeds
        Errors.
    truncation
        Estimated error of the truncation of the basis, nan if it is not known.
    """

    outcome: CaseOutcome
    campbell: ErrorPair
    critical_speeds: ErrorPair
    truncation: float

    @property
    def series(self) -> tuple[str, int | None, str]:
        """Level, element order and ladder: cases that are drawn and fitted together."""
        case = self.outcome.case
        return case.level, case.order, case.ladder

    def measured(self, key: str) -> float:
        """Return a measured number, nan where there is none."""
        return float(self.outcome.result.get(key, np.nan))

    @property
    def solve_cpu_s(self) -> float:
        """Processor time without that of starting the program."""
        return self.measured("cpu_s") - self.measured("startup_cpu_s")

    @property
    def solve_memory_gib(self) -> float:
        """Peak memory beyond that of the program itself."""
        return self.measured("peak_memory_gib") - self.measured("startup_memory_gib")

    @property
    def comparable(self) -> bool:
        """Whether its error can be held against its cost."""
        wanted = self.outcome.case.group in ("mesh", "dial", "modes", "beam")
        return wanted and bool(np.isfinite(self.campbell.true)) and not self.campbell.unmatched


@dataclass(frozen=True, kw_only=True)
class StudySlope:
    """A slope over the unknowns.

    Attributes
    ----------
    series
        Level, element order and ladder.
    quantity
        "error", "cpu_s" or "memory_gib"; the last two without the program's start.
    slope
        The power law.
    left_out
        Points left out: errors too near the floor, or costs too small to be measured.
    names
        Cases that were fitted.
    """

    series: tuple[str, int | None, str]
    quantity: str
    slope: Slope
    left_out: int
    names: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class StudyTable:
    """All rows of a study.

    Attributes
    ----------
    rows
        In the order of the cases, rows of the map left out.
    floor
        Estimated error of the reference: smaller errors can't be told from it.
    time_front, memory_front
        Names on the Pareto fronts.
    slopes
        All that have points enough.
    """

    rows: tuple[StudyRow, ...]
    floor: float
    time_front: tuple[str, ...]
    memory_front: tuple[str, ...]
    slopes: tuple[StudySlope, ...]


def study_table(outcomes: Sequence[CaseOutcome]) -> StudyTable:
    """Hold all cases against the reference.

    Parameters
    ----------
    outcomes
        From `solidwhirl.study_runner.run_cases`, the reference first.
    """
    reference = outcomes[0].result
    estimates = _total(reference)
    floor = float(np.nanmax(estimates)) if np.isfinite(estimates).any() else 0.0
    rows = tuple(_row(o, reference["truth"], floor) for o in outcomes if o.case.group != "beam_map")
    able = [r for r in rows if r.comparable]
    error = np.maximum([r.campbell.true for r in able], floor)
    fronts = {
        key: tuple(
            able[k].outcome.case.name for k in pareto_front([r.measured(key) for r in able], error)
        )
        for key in ("cpu_s", "peak_memory_gib")
    }
    return StudyTable(
        rows=rows,
        floor=floor,
        time_front=fronts["cpu_s"],
        memory_front=fronts["peak_memory_gib"],
        slopes=tuple(_slopes(able, floor)),
    )


def _row(outcome: CaseOutcome, truth: Mapping[str, Any], floor: float) -> StudyRow:
    result = outcome.result
    if outcome.status != "done":
        return StudyRow(
            outcome=outcome, campbell=NO_ERROR, critical_speeds=NO_ERROR, truncation=np.nan
        )
    found = matched_errors(result["campbell"], truth["campbell"])
    partner, speeds = critical_errors(result["critical_speeds"], truth["critical_speeds"])
    estimate = _total(result)
    if estimate.size:
        estimate = estimate[held_branches(result["campbell"])]
    estimates = result["estimates"] or {}
    of_speeds = as_array(estimates.get("critical_speeds", ()))
    parts = estimates.get("campbell_parts", {})
    return StudyRow(
        outcome=outcome,
        campbell=_pair(found.error, estimate, int((found.partner < 0).sum()), floor),
        critical_speeds=_pair(speeds[:, None], of_speeds[:, None], int((partner < 0).sum()), floor),
        truncation=float(parts.get("mode_truncation") or 0.0) if parts else np.nan,
    )


def _total(result: Mapping[str, Any]) -> FloatArray:
    estimates = result.get("estimates")
    return as_array(estimates["campbell"]) if estimates else np.zeros((0, 0))


def _pair(error: FloatArray, estimate: FloatArray, unmatched: int, floor: float) -> ErrorPair:
    """Largest errors; effectivity where the truth is known well enough."""
    true = _largest_by_row(np.abs(error))
    guess = _largest_by_row(estimate) if estimate.size else np.full(len(true), np.nan)
    both = np.isfinite(true) & np.isfinite(guess)
    clear = both & (true > _CLEAR_OF_FLOOR * floor) & (true > 0.0)
    effectivity = float(guess[clear].max() / true[clear].max()) if clear.any() else np.nan
    return ErrorPair(
        true=_largest(true),
        estimate=_largest(guess),
        effectivity=effectivity,
        least_effectivity=float((guess[clear] / true[clear]).min()) if clear.any() else np.nan,
        unmatched=unmatched,
    )


def _largest(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else float("nan")


def _largest_by_row(values: FloatArray) -> FloatArray:
    return np.array([_largest(row) for row in values])


def _slopes(rows: Sequence[StudyRow], floor: float) -> list[StudySlope]:
    """Slopes over the unknowns of every series of meshes."""
    found = []
    meshes = [r for r in rows if r.outcome.case.group in ("mesh", "dial")]
    for series in dict.fromkeys(r.series for r in meshes):
        own = [r for r in meshes if r.series == series]
        kept = {
            "error": [r for r in own if _clear(r, floor)],
            "cpu_s": [r for r in own if r.solve_cpu_s > _LEAST_S],
            "memory_gib": [r for r in own if r.solve_memory_gib > _LEAST_GIB],
        }
        value = {
            "error": lambda r: r.campbell.true,
            "cpu_s": lambda r: r.solve_cpu_s,
            "memory_gib": lambda r: r.solve_memory_gib,
        }
        for quantity, points in kept.items():
            slope = fit_slope(
                [r.measured("unknowns") for r in points], [value[quantity](r) for r in points]
            )
            if slope is not None:
                names = tuple(r.outcome.case.name for r in points)
                found.append(
                    StudySlope(series=series, quantity=quantity, slope=slope,
                               left_out=len(own) - len(points), names=names)
                )  # fmt: skip
    return found


def _clear(row: StudyRow, floor: float) -> bool:
    """Whether an error is clearly that of the mesh: above the truth's own and the truncation's."""
    other = floor + (row.truncation if np.isfinite(row.truncation) else 0.0)
    return row.campbell.true > _CLEAR_OF_FLOOR * other
