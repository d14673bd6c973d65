"""How records show themselves: a few lines with units instead of all their arrays."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S

# Lines of a list, and entries of a row, before the rest is counted.
MOST_LINES, _MOST_WORDS = 8, 6


def row(words: Iterable[str]) -> str:
    """Return words with commas, the last ones counted where there are many."""
    every = list(words)
    more = len(every) - _MOST_WORDS
    return ", ".join([*every[:_MOST_WORDS], *([f"and {more} more"] if more > 0 else [])])


def hertz(values: npt.ArrayLike) -> str:
    """Return frequencies in a row with their unit."""
    known = np.ravel(values)
    return row(f"{v:.2f}" for v in known) + " Hz" if known.size else "none"


def lines_of(head: str, rest: Sequence[str]) -> str:
    """Return a first line and indented ones, the last ones counted where there are many."""
    more = len(rest) - MOST_LINES
    shown = [*rest[:MOST_LINES], *([f"and {more} more"] if more > 0 else [])]
    return "\n".join([head, *(f"  {line}" for line in shown)])


def speed_range(speeds_rad_s: FloatArray) -> str:
    """Return how many speeds there are, and the first and last in rpm."""
    rpm = speeds_rad_s * RPM_PER_RAD_S
    if rpm.size < 2:
        return f"{rpm.size} speed" + "".join(f", {v:.6g} rpm" for v in rpm)
    return f"{rpm.size} speeds from {rpm[0]:.6g} to {rpm[-1]:.6g} rpm"


def count_of(number: int, what: str) -> str:
    """Return a number with its noun."""
    return f"{number} {what if number == 1 else what + 's'}"
