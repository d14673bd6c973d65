"""The hard cases: rows of a data file, each with the name of a function that measures it.

The tests and the page of the documentation are made of the same rows.
"""

from __future__ import annotations

import csv
import importlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from builders_system import BODIES

FOLDER = Path(__file__).parent


@dataclass(frozen=True, kw_only=True)
class HardCase:
    """One hard case and how far the program is from right on it.

    `level`: "harmonic", "solid", "assembled", "reduced file" or "scene"; `elsewhere`: what commonly
    goes wrong with it; `figure`: what `measure` computes, with its unit; smaller is better;
    `reason`: where the limit comes from; `is_long`: whether it waits for `make verify`.
    """

    case: str
    level: str
    elsewhere: str
    figure: str
    limit: float
    reason: str
    is_long: bool
    measure: Callable[[], float]


def _argument(word: str) -> Any:
    """A body by its name, a number or list of JSON, or the word itself."""
    if word in BODIES:
        return BODIES[word]()
    try:
        return json.loads(word)
    except ValueError:
        return word


def _measured(function: Callable[..., float], words: Sequence[str]) -> float:
    return function(*(_argument(word) for word in words))


def cases_by_module() -> tuple[tuple[str, HardCase], ...]:
    """Rows of cases.csv; `measure` is a function of `cases_<module>.py` and its arguments."""
    found = []
    with (FOLDER / "cases.csv").open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            module, limit = row.pop("module"), float(row.pop("limit"))
            name, *words = row.pop("measure").split()
            function = vars(importlib.import_module(f"cases_{module}"))[f"_{name}"]
            measure, is_long = partial(_measured, function, words), bool(row.pop("long"))
            case = HardCase(**row, limit=limit, is_long=is_long, measure=measure)
            found.append((module, case))
    return tuple(found)


def all_cases() -> tuple[HardCase, ...]:
    """Cases of all modules."""
    return tuple(case for _, case in cases_by_module())
