"""Pareto fronts and slopes in log-log."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

IntArray = npt.NDArray[np.int_]

#: No slope is fitted to fewer points.
FEWEST = 3


@dataclass(frozen=True, kw_only=True)
class Slope:
    """A power law y = c xⁿ through points, by least squares of the logarithms.

    Attributes
    ----------
    slope
        n.
    factor
        c, in the units of y and x.
    standard_error
        Of the slope, from the scatter about the line.
    scatter_log10
        Root mean square deviation of log10 y from the line, with the points less two as divisor.
    points
        How many.
    """

    slope: float
    factor: float
    standard_error: float
    scatter_log10: float
    points: int


def pareto_front(cost: npt.ArrayLike, error: npt.ArrayLike) -> IntArray:
    """Return the points that no other one beats, by increasing cost.

    Parameters
    ----------
    cost, error
        (n,) each; points with nan are on no front.

    Returns
    -------
    Indices of the points that have a smaller error than all that cost as much or less; of equal
    ones the first.
    """
    spent, wrong = np.asarray(cost, dtype=float), np.asarray(error, dtype=float)
    order = np.lexsort((wrong, spent))
    front, best = [], np.inf
    for k in order:
        if np.isfinite(spent[k]) and wrong[k] < best:
            front.append(int(k))
            best = wrong[k]
    return np.array(front, dtype=int)


def fit_slope(x: Sequence[float], y: Sequence[float]) -> Slope | None:
    """Fit a power law.

    Parameters
    ----------
    x, y
        Positive numbers, as many of both.

    Returns
    -------
    Slope, or None for fewer than three points or no two different x.
    """
    abscissa, ordinate = np.log10(np.asarray(x, float)), np.log10(np.asarray(y, float))
    count = len(abscissa)
    if count < FEWEST or np.ptp(abscissa) == 0.0:
        return None
    centred = abscissa - abscissa.mean()
    square = float(centred @ centred)
    slope = float(centred @ ordinate) / square
    constant = float(ordinate.mean() - slope * abscissa.mean())
    rest = ordinate - constant - slope * abscissa
    scatter = float(np.sqrt(rest @ rest / (count - 2)))
    return Slope(
        slope=slope,
        factor=10.0**constant,
        standard_error=scatter / float(np.sqrt(square)),
        scatter_log10=scatter,
        points=count,
    )
