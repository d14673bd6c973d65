"""The hard cases: rows of a data file, each with a call that measures it.

The tests and the page of the documentation are made of the same rows.
"""

from __future__ import annotations

import csv
import importlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent


@dataclass(frozen=True, kw_only=True)
class HardCase:
    """One hard case and how far the program is from right on it.

    Attributes
    ----------
    case
        What is hard, such as "supports of 1e16 N/m".
    level
        "harmonic", "solid", "assembled", "reduced file" or "scene".
    elsewhere
        What commonly goes wrong with it, in one sentence.
    figure
        What is measured, with its unit; smaller is better.
    limit
        Largest figure allowed.
    reason
        Where the limit comes from.
    measure
        Computes the figure.
    """

    case: str
    level: str
    elsewhere: str
    figure: str
    limit: float
    reason: str
    measure: Callable[[], float]


@cache
def _names(module: str) -> dict[str, Any]:
    """What a call may use: the names of `cases_<module>.py` and of all builders."""
    builders = [path.stem for path in sorted(FOLDER.glob("builders_*.py"))]
    found: dict[str, Any] = {}
    for name in (*builders, f"cases_{module}"):
        found |= vars(importlib.import_module(name))
    return found


def cases_by_module() -> tuple[tuple[str, HardCase], ...]:
    """Rows of cases.csv; `measure` is a call with the names of `cases_<module>.py`."""
    found = []
    with (FOLDER / "cases.csv").open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            module, call, limit = row.pop("module"), row.pop("measure"), float(row.pop("limit"))
            measure = partial(eval, compile(call, "cases.csv", "eval"), _names(module))
            found.append((module, HardCase(**row, limit=limit, measure=measure)))
    return tuple(found)


def all_cases() -> tuple[HardCase, ...]:
    """Cases of all modules."""
    return tuple(case for _, case in cases_by_module())
