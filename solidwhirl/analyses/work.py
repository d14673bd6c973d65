"""How much an analysis has to solve, for what it will cost."""

from __future__ import annotations

from typing import NamedTuple


class Work(NamedTuple):
    """Dense problems of the engine, about.

    `spectra`: eigenproblems with all modes; `solves`: complex systems of equations; `steps`: steps
    in time; `results`: what is made once for each, such as peaks, tables and records.
    """

    spectra: float = 0.0
    solves: float = 0.0
    steps: float = 0.0
    results: float = 0.0
