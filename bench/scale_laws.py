"""Time and memory of both solvers of a solid over its size, from measured laws of growth.

Power laws are fitted to measurements of whole solids (`scale_coefficients`, written by
bench/multigrid.py). Beyond the largest of them the power is uncertain: the range is spanned by the
fitted power and that of the theory. Factors of a solid under nested dissection: entries N^(4/3),
operations N² (George, SIAM J. Numer. Anal. 10 (1973) 345-363); multigrid: all of them N.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
import scale_coefficients as measured

#: How the systems of a solid are solved.
ROADS = ("direct", "iterative")
#: "road.quantity": power of the unknowns by theory.
THEORY: Mapping[str, float] = {
    "direct.factor_entries": 4.0 / 3.0,
    "direct.memory_gib": 4.0 / 3.0,
    "direct.setup_s": 2.0,
    "direct.static_s": 4.0 / 3.0,
    "direct.modes_s": 4.0 / 3.0,
    "iterative.memory_gib": 1.0,
    "iterative.setup_s": 1.0,
    "iterative.static_s": 1.0,
    "iterative.modes_s": 1.0,
}
_REFERENCE = 1e5


class ScaleError(ValueError):
    """A prediction that is not known."""


@dataclass(frozen=True, kw_only=True)
class Law:
    """A quantity that grows with a power of the unknowns solved for.

    Attributes
    ----------
    value
        At 1e5 unknowns.
    power
        Fitted.
    theory
        Power by theory.
    largest
        Unknowns of the largest measurement.
    """

    value: float
    power: float
    theory: float
    largest: float

    def at(self, unknowns: float) -> float:
        """Value by the fit; beyond the measurements the geometric mean of the range."""
        low, high = self.range_at(unknowns)
        return float(np.sqrt(low * high))

    def range_at(self, unknowns: float) -> tuple[float, float]:
        """Least and largest value: from the largest measurement on by either power."""
        beyond = max(unknowns / self.largest, 1.0)
        known = self.value * (min(unknowns, self.largest) / _REFERENCE) ** self.power
        ends = sorted(known * beyond**power for power in (self.power, self.theory))
        return float(ends[0]), float(ends[1])


def power_law(unknowns: Sequence[float], values: Sequence[float], theory: float) -> Law:
    """Fit a law of growth, least squares in logarithms; larger sizes count more."""
    n = np.asarray(unknowns, dtype=float)
    weight = np.sqrt(n / n.max())
    power, constant = np.polyfit(np.log(n / _REFERENCE), np.log(values), 1, w=weight)
    return Law(
        value=float(np.exp(constant)), power=float(power), theory=theory, largest=float(n.max())
    )


@cache
def law(road: str, quantity: str) -> Law:
    """Return the law of a quantity of one road.

    Parameters
    ----------
    road
        Of `ROADS`.
    quantity
        As in `THEORY`: ``memory_gib`` of the solver with its vectors, ``setup_s``, ``static_s`` of
        one solution, ``modes_s`` of one eigensolution; processor seconds of one core.

    Raises
    ------
    ScaleError
        Not measured.
    """
    name = f"{road}.{quantity}"
    if name not in THEORY:
        raise ScaleError(f"{name!r} is not known; known are {', '.join(THEORY)}")
    rows = measured.MEASURED[road]
    return power_law(rows["solved"], rows[quantity], THEORY[name])
