"""Resonance peaks of a response curve: where they are, how high and how sharp."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError

_HALF_POWER = np.sqrt(0.5)
# Accuracy of a summit, as a fraction of the interval it is sought in.
SUMMIT = 1e-6
# Accuracy of a half-power point, as a fraction of its distance from the summit.
_CROSSING = 1e-9
# Samples beside a summit that are looked at first.
_NEAR = 64


@dataclass(frozen=True, kw_only=True)
class ResonancePeak:
    """Hold one peak of a response curve.

    `position_rad_s`: speed or frequency of the peak, between the samples, rad/s; `amplitude`:
    height there, in the unit of the curve. `prominence`: height over that of the higher of the two
    saddles beside the peak; 1 is no peak. `half_power_low_rad_s`, `half_power_high_rad_s`: where
    the curve has fallen to 1/√2 of the height; nan where it does not before it rises again or
    ends. `amplification`: position / (high − low): the amplification factor of API 617 (Axial and
    Centrifugal Compressors), 1/(2ζ) for a single lightly damped mode; nan without both sides.
    """

    position_rad_s: float
    amplitude: float
    prominence: float
    half_power_low_rad_s: float
    half_power_high_rad_s: float
    amplification: float


def resonance_peaks(
    position_rad_s: npt.ArrayLike, amplitude: npt.ArrayLike, minimum_prominence: float = 1.05
) -> tuple[ResonancePeak, ...]:
    """Find the peaks of a response curve.

    `position_rad_s`: speeds or frequencies, rising, shape (s,); `amplitude`: heights, 0 or more,
    in any unit, shape (s,). `minimum_prominence`: leave out what rises above its saddles by a
    smaller factor; 1 or more. The result is by rising position. A peak lies on the parabola
    through the logarithms of the highest sample and its neighbours, so its height depends on the
    samples where it is narrower than a few of them: sample with `resolving_samples` or
    `resolving_speeds`, and refine with `refined_peaks`. Raises AnalysisError if the arrays do not
    fit or the positions do not rise.
    """
    x = np.asarray(position_rad_s, dtype=float)
    y = np.asarray(amplitude, dtype=float)
    if x.ndim != 1 or x.shape != y.shape or x.size < 3 or not (np.diff(x) > 0).all():
        raise AnalysisError(
            "position_rad_s and amplitude need equal shapes (s,) with s of 3 or more and rising "
            f"positions; found {x.shape} and {y.shape}"
        )
    if not (np.isfinite(x).all() and np.isfinite(y).all()) or y.min() < 0:
        raise AnalysisError("positions must be finite, amplitudes finite and 0 or more")
    if not minimum_prominence >= 1:
        raise AnalysisError(f"minimum_prominence is {minimum_prominence}; 1 or more is allowed")
    if not y.any():
        return ()
    height = np.log(np.maximum(y, y[y > 0].min()))
    least = max(np.log(minimum_prominence), 1e-12)
    tops = _tops(height)
    rises = _prominences(height, tops)
    return tuple(
        _peak(x, height, at, float(np.exp(rise)))
        for at, rise in zip(tops, rises, strict=True)
        if rise >= least
    )


# As `find_peaks` of scipy.signal, whose import takes a quarter of a second.


def _tops(height: FloatArray) -> list[int]:
    """Samples that are higher than those beside them; of a level top the middle."""
    starts = np.flatnonzero(np.diff(height, prepend=np.nan) != 0.0)
    ends = np.append(starts[1:], height.size) - 1
    level = height[starts]
    inner = np.flatnonzero((level[1:-1] > level[:-2]) & (level[1:-1] > level[2:])) + 1
    return [int(at) for at in (starts[inner] + ends[inner]) // 2]


def _prominences(height: FloatArray, tops: Sequence[int]) -> list[float]:
    """How far each of rising tops rises above the higher of the saddles on its sides.

    A saddle is the lowest sample on the way to the next higher top on that side, or to the end.
    """
    saddles = [
        _saddles(height, tops),
        _saddles(height[::-1], [height.size - 1 - at for at in tops[::-1]])[::-1],
    ]
    return [float(height[at] - max(pair)) for at, *pair in zip(tops, *saddles, strict=True)]


def _saddles(height: FloatArray, tops: Sequence[int]) -> list[float]:
    """The lowest sample between each top and the next higher sample before it, or the start."""
    out: list[float] = []
    before = 0
    higher: list[tuple[float, float]] = []  # tops that nothing hides, falling, with their saddles
    for at in tops:
        lowest, own = float(height[before : at + 1].min()), float(height[at])
        while higher and higher[-1][0] <= own:
            lowest = min(lowest, higher.pop()[1])
        higher.append((own, lowest))
        out.append(lowest)
        before = at
    return out


def summit(
    curve: Callable[[float], float], low: float, high: float, knots: npt.ArrayLike = ()
) -> float:
    """Return where a curve is highest in an interval.

    `low`, `high`: ends of the interval; the curve has one summit between two neighbouring knots.
    `knots`: where it may have corners, rising. Returns good to `SUMMIT` of the interval; exact
    where the summit is a corner.
    """
    # Imported here as it takes longer than all of the rest of this package.
    from scipy.optimize import minimize_scalar

    inside = [float(knot) for knot in np.asarray(knots, dtype=float) if low < knot < high]
    places = list(inside)
    for begin, end in pairwise((low, *inside, high)):
        # Offsets, as the search stops at 1.5e-8 of its variable: sharp peaks need more digits.
        middle, half = 0.5 * (begin + end), 0.5 * (end - begin)
        found = minimize_scalar(
            lambda offset, middle=middle: -curve(middle + float(offset)),
            bounds=(-half, half),
            method="bounded",
            options={"xatol": SUMMIT * 2.0 * half},
        )
        places.append(middle + float(found.x))
    return max(places, key=curve) if len(places) > 1 else places[0]


def refined_peaks(
    peaks: Sequence[ResonancePeak],
    position_rad_s: npt.ArrayLike,
    amplitude: npt.ArrayLike,
    curve: Callable[[float], float],
    knots: npt.ArrayLike = (),
) -> tuple[ResonancePeak, ...]:
    """Replace the summits of sampled peaks by those of the curve itself.

    `peaks`: from `resonance_peaks` of the samples; `position_rad_s`, `amplitude`: the samples,
    shape (s,) each; `curve`: height at a position; `knots`: where it may have corners, rising. Each
    the highest place between the neighbours of its highest sample. A peak that the curve has no
    solution at, as it is without damping, is left as it was.
    """
    x, y = np.asarray(position_rad_s, dtype=float), np.asarray(amplitude, dtype=float)
    refined = []
    for peak in peaks:
        after = int(np.clip(np.searchsorted(x, peak.position_rad_s), 1, x.size - 1))
        highest = after if y[after] >= y[after - 1] else after - 1
        at = int(np.clip(highest, 1, x.size - 2))
        try:
            place = summit(curve, float(x[at - 1]), float(x[at + 1]), knots)
            refined.append(_moved(peak, x, y, place, curve))
        except AnalysisError:
            refined.append(peak)
    return tuple(refined)


def _moved(
    peak: ResonancePeak, x: FloatArray, y: FloatArray, place: float, curve: Callable[[float], float]
) -> ResonancePeak:
    """Return a peak with another summit, and its half-power points."""
    top = curve(place)
    low, high = (
        _half_power(place, np.append(place, x[on]), np.append(top, y[on]), curve)
        for on in (np.flatnonzero(x < place)[::-1], np.flatnonzero(x > place))
    )
    return _made(place, top, peak.prominence * top / peak.amplitude, low, high)


def _half_power(
    place: float, x: FloatArray, y: FloatArray, curve: Callable[[float], float]
) -> float:
    """Return where a curve has half of the power of its summit, which comes first in x and y."""
    from scipy.optimize import brentq

    level = y[0] * _HALF_POWER
    end = _fallen(y, level)
    if end is None:
        return float("nan")
    offset = brentq(
        lambda offset: curve(place + offset) - level,
        x[end - 1] - place,
        x[end] - place,
        xtol=np.finfo(float).tiny,
        rtol=_CROSSING,
    )
    return place + float(offset)


def _peak(x: FloatArray, height: FloatArray, at: int, prominence: float) -> ResonancePeak:
    position, top = _summit(x[at - 1 : at + 2], height[at - 1 : at + 2])
    level = top + np.log(_HALF_POWER)
    low = _crossing(x[: at + 1][::-1], height[: at + 1][::-1], level)
    high = _crossing(x[at:], height[at:], level)
    return _made(position, float(np.exp(top)), prominence, low, high)


def _made(
    position: float, amplitude: float, prominence: float, low: float, high: float
) -> ResonancePeak:
    return ResonancePeak(
        position_rad_s=position,
        amplitude=amplitude,
        prominence=prominence,
        half_power_low_rad_s=low,
        half_power_high_rad_s=high,
        amplification=position / (high - low),
    )


def _summit(x: FloatArray, y: FloatArray) -> tuple[float, float]:
    """Return the vertex of the parabola through three points."""
    left, right = (y[1] - y[0]) / (x[1] - x[0]), (y[2] - y[1]) / (x[2] - x[1])
    bend = (right - left) / (x[2] - x[0])
    if bend >= 0:
        return float(x[1]), float(y[1])
    slope = left + bend * (x[1] - x[0])
    step = -0.5 * slope / bend
    return float(x[1] + step), float(y[1] + 0.5 * slope * step)


def _crossing(x: FloatArray, y: FloatArray, level: float) -> float:
    """Return where a curve falls below a level on its way from a peak, nan if it rises before."""
    end = _fallen(y, level)
    if end is None:
        return float("nan")
    part = (y[end - 1] - level) / (y[end - 1] - y[end])
    return float(x[end - 1] + part * (x[end] - x[end - 1]))


def _fallen(y: FloatArray, level: float) -> int | None:
    """Return the first sample below a level on the way from a peak, None if it rises before."""
    count = _NEAR
    while True:  # most fall within few samples
        near = y[:count]
        rising, below = np.diff(near) > 0.0, near <= level
        if count >= y.size or rising.any() or below.any():
            break
        count *= 4
    end = int(below.argmax())
    if not below[end] or end == 0 or rising[:end].any():
        return None
    return end
