"""Uncertainty of Campbell diagrams and critical speeds over samples: quantiles and theirs."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
from scipy import stats

from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray, ReadOnlyArrays
from solidwhirl.sweep.design import SweepDesign
from solidwhirl.sweep.matching import match_curves
from solidwhirl.sweep.tracks import shapes_of

#: Quantiles of the bands.
LEVELS = (0.05, 0.5, 0.95)
#: Fewer samples give no band.
LEAST_SAMPLES = 20


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Quantiles(ReadOnlyArrays):
    """Quantiles of samples and their confidence limits."""

    count: IntArray  # samples at each point (...); bands are drawn from 20 on
    value: FloatArray  # quantile, (levels, ...); nan below two samples
    # low, high: limits of the true quantile with the confidence asked for, (levels, ...); nan where
    # that many samples give none
    low: FloatArray
    high: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class CampbellBands(ReadOnlyArrays):
    """Branches of a sampled sweep."""

    speed_rpm: FloatArray  # of the reference shaft (s)
    # cases, other_speeds: cases used, and those left out because their diagrams have other speeds
    cases: int
    other_speeds: int
    frequency_hz: Quantiles  # quantiles by branch and speed, (levels, branches, s)
    doubtful: IntArray  # cases in which the branch may be another one, (branches)


def order_statistics(count: int, level: float, confidence: float) -> tuple[int, int]:
    """Return the ranks of the sample values between which a quantile lies.

    `count`: number n of independent samples. `level`: p of the quantile. `confidence`: two-sided:
    each of both limits fails with half of 1 - confidence at most.
    Returns ranks, from 1 to n; 0 and n + 1 where the samples give no limit on that side.

    The number of samples below the quantile is binomial (n, p), whatever the distribution, so that
    P(X_(l) > q) = P(B < l) and P(X_(u) < q) <= P(B >= u): H. A. David, H. N. Nagaraja, Order
    Statistics (2003), section 7.1.
    """
    tail = 0.5 * (1.0 - confidence)
    # largest l with P(B <= l - 1) <= tail, smallest u with P(B >= u) <= tail
    below = stats.binom.cdf(np.arange(count + 1), count, level)
    lower = int(np.searchsorted(below, tail, side="right"))
    upper = int(np.searchsorted(below, 1.0 - tail, side="left")) + 1
    return lower, upper


def least_samples(level: float, confidence: float) -> int:
    """Return how many independent samples limit a quantile on both sides."""
    outer = max(level, 1.0 - level)
    return int(np.ceil(np.log(0.5 * (1.0 - confidence)) / np.log(outer)))


def quantiles(samples: FloatArray, confidence: float = 0.95) -> Quantiles:
    """Return the 5, 50 and 95 % quantiles of samples, with their limits by order statistics.

    `samples`: shape (n, ...); nan where a sample has no value, which is left out there.

    The quantile is interpolated between the values of rank p (n − 1) + 1 (Hyndman and Fan's
    definition 7). The limits assume independent samples; space-filling ones usually scatter less.
    """
    ordered = np.sort(samples, axis=0)
    count = np.isfinite(ordered).sum(axis=0)
    shape = (len(LEVELS), *count.shape)
    value, low, high = (np.full(shape, np.nan) for _ in range(3))
    for size in np.unique(count[count >= 2]):
        where = count == size
        known = ordered[:size, where]
        for k, level in enumerate(LEVELS):
            value[k][where] = np.quantile(known, level, axis=0)
            lower, upper = order_statistics(int(size), level, confidence)
            if lower >= 1:
                low[k][where] = known[lower - 1]
            if upper <= size:
                high[k][where] = known[upper - 1]
    return Quantiles(count=count, value=value, low=low, high=high)


def campbell_bands(design: SweepDesign, confidence: float = 0.95) -> CampbellBands | None:
    """Return the bands of the branches of a sampled sweep, matched by shape where rows have these.

    Returns None unless 20 samples have diagrams over the same speeds.
    """
    drawn = [(k, r) for k, r in enumerate(design.rows) if r.campbell_frequency_hz]
    if design.kind != "samples" or not drawn:
        return None
    speeds = Counter(r.campbell_speed_rpm for _, r in drawn).most_common(1)[0][0]
    same = [(k, r) for k, r in drawn if r.campbell_speed_rpm == speeds]
    if len(same) < LEAST_SAMPLES:
        return None
    curves = [np.array(r.campbell_frequency_hz, dtype=float) for _, r in same]
    shapes = shapes_of([r.campbell_motion for _, r in same], [len(c) for c in curves])
    kinds = [[(0, "")] * len(c) for c in curves]
    matched = match_curves(design.scaled[[k for k, _ in same]], curves, kinds, shapes)
    samples = np.full((len(same), len(matched.index), len(speeds)), np.nan)
    for branch, index in enumerate(matched.index):
        for case, number in enumerate(index):
            if number >= 0:
                samples[case, branch] = curves[case][number]
    return CampbellBands(
        speed_rpm=np.array(speeds, dtype=float),
        cases=len(same),
        other_speeds=len(drawn) - len(same),
        frequency_hz=quantiles(samples, confidence),
        doubtful=matched.doubtful.sum(axis=1),
    )
