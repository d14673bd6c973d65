"""Which parameter moves which result: one at a time, or by regression and ranks of samples."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from scipy import stats

from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray
from solidwhirl.sweep.design import SweepDesign
from solidwhirl.sweep.tracks import Quantity

# Off the straight line by more than this share of the swing, or less of the variance explained.
_CURVED, _EXPLAINED = 0.05, 0.9
# Inputs that are correlated more strongly than this share their effects.
_CORRELATED = 0.3
# A parameter of which less than this share is its own cannot be told from the others.
_DEPENDENT = 1e-9
_LEAST_RANKED = 5
NAN = float("nan")


@dataclass(frozen=True, kw_only=True)
class OneAtATime:
    """Effect of one parameter with the others at the baseline."""

    # parameter, low, high, baseline: name; its values at the ends and at the baseline, the number
    # of the choice for words
    parameter: str
    low: float
    high: float
    baseline: float
    # at_baseline, at_low, at_high: the result there, nan where it was not found
    at_baseline: float
    at_low: float
    at_high: float
    # smallest, largest: of the result over all values
    smallest: float
    largest: float
    # d ln(result) / d ln(parameter) at the baseline: 0.5 for a square root; nan unless both are
    # positive numbers
    elasticity: float
    slope: float  # d result / d parameter at the baseline; nan for words
    # Largest distance from the straight line through the ends over the swing; nan with two values
    # and for words
    off_line: float
    linear: bool  # whether that is within 5 %


@dataclass(frozen=True, kw_only=True)
class Regression:
    """Effect of one parameter over samples; every pair of limits holds with the confidence."""

    parameter: str
    # coefficient, coefficient_limits: standardised regression coefficient: standard deviations of
    # the result by standard deviation of the parameter, others held; limits from Student's t
    coefficient: float
    coefficient_limits: tuple[float, float]
    # rank_correlation, rank_limits: Spearman's; limits from Fisher's transform with the variance of
    # Bonett and Wright (2000)
    rank_correlation: float
    rank_limits: tuple[float, float]
    # elasticity, elasticity_limits: exponent of the power law through the samples; nan unless all
    # values are positive
    elasticity: float
    elasticity_limits: tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Sensitivity:
    """Effects of all parameters on one result."""

    # quantity, label: name of the result, and with its unit
    quantity: str
    label: str
    kind: Literal["one_at_a_time", "samples"]  # how they were found
    cases: int  # number of cases with this result that were used
    # one_at_a_time, regressions: the effects, the strongest first; one of both is empty
    one_at_a_time: tuple[OneAtATime, ...]
    regressions: tuple[Regression, ...]
    # r_squared, adjusted_r_squared, power_law_r_squared: share of the variance that the straight
    # plane, or the power law, explains; nan for one at a time
    r_squared: float
    adjusted_r_squared: float
    power_law_r_squared: float
    linear: bool  # whether all effects are straight within 5 %, or R² is at least 0.9
    notes: tuple[str, ...]  # what a reader must know


def sensitivity(
    design: SweepDesign, quantity: Quantity, confidence: float = 0.95
) -> Sensitivity | None:
    """Return how one result depends on the parameters of a sweep.

    Returns None if nothing varies, the result is missing at the baseline, or too few samples have
    it.

    Saltelli et al., Sensitivity Analysis (2000), for regression and ranks. The limits are those
    of independent samples; space-filling ones (Latin hypercube, Sobol) scatter less.
    """
    if design.kind == "none":
        return None
    if design.kind == "one_at_a_time":
        return _one_at_a_time(design, quantity)
    return _samples(design, quantity, confidence)


def _one_at_a_time(design: SweepDesign, quantity: Quantity) -> Sensitivity | None:
    if not np.isfinite(quantity.values[design.baseline]):
        return None
    effects = [_effect(design, quantity.values, k) for k in range(len(design.parameters))]
    effects.sort(key=lambda e: -(e.largest - e.smallest))
    curved = [e.parameter for e in effects if not e.linear]
    used = np.unique(np.concatenate([ladder(design, k) for k in range(len(effects))]))
    notes = [f"not linear in {', '.join(curved)}"] if curved else []
    if doubtful := int(quantity.doubtful[used].sum()):
        notes.append(f"{doubtful} of {len(used)} cases matched ambiguously")
    if missing := int((~np.isfinite(quantity.values[used])).sum()):
        notes.append(f"not found in {missing} of {len(used)} cases")
    return Sensitivity(
        quantity=quantity.name, label=quantity.label, kind="one_at_a_time", cases=len(used),
        one_at_a_time=tuple(effects), regressions=(), r_squared=NAN, adjusted_r_squared=NAN,
        power_law_r_squared=NAN, linear=not curved, notes=tuple(notes),
    )  # fmt: skip


def ladder(design: SweepDesign, parameter: int, through: int | None = None) -> IntArray:
    """Return the cases that differ from one in a parameter alone, by its rising value."""
    base = design.baseline if through is None else through
    others = np.delete(design.values, parameter, axis=1)
    same = np.flatnonzero((others == others[base]).all(axis=1))
    return np.asarray(same[np.argsort(design.values[same, parameter], kind="stable")])


def _effect(design: SweepDesign, values: FloatArray, parameter: int) -> OneAtATime:
    rows = ladder(design, parameter)
    found = rows[np.isfinite(values[rows])]
    x, y = design.values[found, parameter], values[found]
    chosen = design.parameters[parameter]
    here = int(np.flatnonzero(found == design.baseline)[0])
    whole = design.values[rows, parameter]
    swing, off = np.ptp(y), NAN
    if not chosen.choices and len(found) > 2 and swing > 0.0 and x[-1] > x[0]:
        line = np.interp(x, x[[0, -1]], y[[0, -1]])
        off = float(np.abs(y - line).max() / swing)
    positive = not chosen.choices and x[0] > 0.0 and (y > 0.0).all()
    return OneAtATime(
        parameter=chosen.name, low=float(whole[0]), high=float(whole[-1]), baseline=float(x[here]),
        at_baseline=float(y[here]), at_low=float(values[rows[0]]), at_high=float(values[rows[-1]]),
        smallest=float(y.min()), largest=float(y.max()),
        elasticity=_derivative(np.log(x), np.log(y), here) if positive else NAN,
        slope=NAN if chosen.choices else _derivative(x, y, here),
        off_line=off, linear=not off > _CURVED,
    )  # fmt: skip


def _derivative(x: FloatArray, y: FloatArray, at: int) -> float:
    """Slope of the parabola through a point and its neighbours, or of the line to the only one."""
    places, first = np.unique(x, return_index=True)
    if len(places) < 2:
        return NAN
    slopes = np.gradient(y[first], places, edge_order=2 if len(places) > 2 else 1)
    return float(slopes[np.searchsorted(places, x[at])])


def _samples(design: SweepDesign, quantity: Quantity, confidence: float) -> Sensitivity | None:
    known = np.isfinite(quantity.values)
    x, y, names, notes = _columns(design, quantity.values, known)
    count = len(y)
    if not names or count < max(len(names) + 2, _LEAST_RANKED) or np.ptp(y) == 0.0:
        return None
    if not known.all():
        notes.append(f"not found in {(~known).sum()} of {known.size} cases, which are left out")
    if quantity.doubtful[known].any():
        notes.append(f"{quantity.doubtful[known].sum()} of {count} cases matched ambiguously")
    plane = _regression(x, y, confidence)
    positive = (x > 0.0).all() and (y > 0.0).all()
    powers = _regression(np.log(x), np.log(y), confidence) if positive else None
    spread = x.std(axis=0, ddof=1) / y.std(ddof=1)
    effects = []
    for k, name in enumerate(names):
        rank = float(stats.spearmanr(x[:, k], y)[0])
        effects.append(
            Regression(
                parameter=name,
                coefficient=float(plane.slope[k] * spread[k]),
                coefficient_limits=plane.limits(k, spread[k]),
                rank_correlation=rank,
                rank_limits=rank_limits(rank, count, confidence),
                elasticity=NAN if powers is None else float(powers.slope[k]),
                elasticity_limits=(NAN, NAN) if powers is None else powers.limits(k, 1.0),
            )
        )
    effects.sort(key=lambda e: -abs(e.coefficient))
    linear = plane.r_squared >= _EXPLAINED
    if not linear:
        notes.insert(
            0, f"not linear: the plane explains {100 * plane.r_squared:.0f} % of the variance"
        )
    return Sensitivity(
        quantity=quantity.name, label=quantity.label, kind="samples", cases=count,
        one_at_a_time=(), regressions=tuple(effects), r_squared=plane.r_squared,
        adjusted_r_squared=1.0 - (1.0 - plane.r_squared) * (count - 1) / (count - len(names) - 1),
        power_law_r_squared=NAN if powers is None else powers.r_squared,
        linear=linear, notes=tuple(notes),
    )  # fmt: skip


def _columns(
    design: SweepDesign, values: FloatArray, known: IntArray
) -> tuple[FloatArray, FloatArray, list[str], list[str]]:
    """Numbers and words of two choices of the cases that have the result; notes."""
    names: list[str] = []
    kept: list[FloatArray] = []
    notes: list[str] = []
    for k, parameter in enumerate(design.parameters):
        column = design.values[known, k]
        if len(parameter.choices) > 2:
            notes.append(f"{parameter.name} is left out: more than two words have no order")
        elif column.size == 0 or np.ptp(column) == 0.0:
            notes.append(f"{parameter.name} is left out: one value in the cases with this result")
        else:
            standard = (column - column.mean()) / column.std()
            former = np.column_stack([np.ones(column.size), *kept])
            rest = standard - former @ np.linalg.lstsq(former, standard, rcond=None)[0]
            if rest @ rest <= _DEPENDENT * column.size:
                notes.append(f"{parameter.name} is left out: it follows from the others")
                continue
            names.append(parameter.name)
            kept.append(column)
    x = np.column_stack(kept) if kept else np.zeros((int(known.sum()), 0))
    if len(names) > 1:
        among = np.abs(np.corrcoef(x.T) - np.eye(len(names))).max()
        if among > _CORRELATED:
            notes.append(f"parameters are correlated by up to {among:.2f} and share effects")
    return x, values[known], names, notes


class _Plane(NamedTuple):
    slope: FloatArray
    half_width: FloatArray
    r_squared: float

    def limits(self, k: int, factor: float) -> tuple[float, float]:
        middle, half = self.slope[k] * factor, self.half_width[k] * factor
        return float(middle - half), float(middle + half)


def _regression(x: FloatArray, y: FloatArray, confidence: float) -> _Plane:
    """Least squares with an intercept; half widths of the slopes' confidence intervals."""
    scale, response = x.std(axis=0), y - y.mean()
    standard = (x - x.mean(axis=0)) / scale
    inverse = np.linalg.pinv(standard)
    slope = inverse @ response
    rest = response - standard @ slope
    free = len(y) - x.shape[1] - 1
    error = np.sqrt((rest @ rest / free) * (inverse**2).sum(axis=1))
    half = stats.t.ppf(0.5 + 0.5 * confidence, free) * error
    r_squared = float(1.0 - rest @ rest / (response @ response))
    return _Plane(slope / scale, half / scale, r_squared)


def rank_limits(correlation: float, count: int, confidence: float) -> tuple[float, float]:
    """Return confidence limits of Spearman's rank correlation.

    tanh(atanh r ± z √((1 + r²/2) / (n − 3))): D. G. Bonett, T. A. Wright, Psychometrika 65 (2000).
    """
    if abs(correlation) >= 1.0:
        return correlation, correlation
    half = stats.norm.ppf(0.5 + 0.5 * confidence) * np.sqrt(
        (1.0 + 0.5 * correlation**2) / (count - 3)
    )
    middle = np.arctanh(correlation)
    return float(np.tanh(middle - half)), float(np.tanh(middle + half))
