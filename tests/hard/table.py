"""The record of a hard case; the tests and the page of the documentation are made of the same."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class HardCase:
    """One hard case and how far the program is from right on it.

    Attributes
    ----------
    case
        What is hard, such as "supports of 1e16 N/m".
    level
        "harmonic", "solid", "assembled" or "reduced file".
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


def all_cases() -> tuple[HardCase, ...]:
    """Cases of all modules beside this one, in the order of their names."""
    found: list[HardCase] = []
    for path in sorted(Path(__file__).parent.glob("cases_*.py")):
        spec = importlib.util.spec_from_file_location(f"hard_{path.stem}", path)
        assert spec is not None and spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        found += module.CASES
    return tuple(found)
