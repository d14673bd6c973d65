"""Records of a batch: one case to compute, and the one row that it leaves in the table."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field

Value = float | str
#: A number of a file: an absent one is null there, and one object here, so that rows can be equal.
Number = Annotated[
    float,
    Field(strict=True),
    BeforeValidator(lambda value: math.nan if value is None else value),
    AfterValidator(lambda value: math.nan if math.isnan(value) else value),
]
Status = Literal["done", "failed", "checks_failed"]


@dataclass(frozen=True, kw_only=True)
class BatchCase:
    """One case of a batch: a scene, or a scene with other values at some places."""

    # Name of the case and of its folder: SCENE, or SCENE-0007 for the seventh case of a sweep
    name: str
    scene_path: Path  # the scene file; files that the scene names lie relative to its folder
    values: Mapping[str, Value]  # value by parameter; empty for a scene without `[sweep]`
    data: Mapping[str, Any]  # content of the scene with the values put in, without `[sweep]`
    # SHA-256 of the case's scene with the level and accuracy of the command line: a row of the same
    # digest needs no computing again
    digest: str
    # method, sweep_cases: how the sweep takes its values, and how many cases it has; empty and 0
    # without `[sweep]`
    method: str = ""
    sweep_cases: int = 0


@dataclass(frozen=True, kw_only=True)
class BatchRow:
    """What one case came to; a line of the journal and a row of the table."""

    # case, scene: name of the case, and of its scene
    case: str
    scene: str
    # `done`; `checks_failed`: results are there, but an invariant is violated; `failed`: none
    status: Status
    message: str = ""  # why, for the latter two; of all, which bodies have no error estimate
    # Warnings of its run, as `run` says them; empty in rows of earlier releases
    warnings: tuple[str, ...] = ()
    # Value by parameter of the sweep
    values: Mapping[str, Number | str] = field(default_factory=dict)
    # digest, method, sweep_cases: those of the case; the latter two are empty and 0 in rows of
    # earlier releases
    digest: str = ""
    method: str = ""
    sweep_cases: int = 0
    seconds: Number = 0.0  # wall time of the case
    peak_memory_gib: Number = math.nan  # largest resident memory of one rank; nan if not known
    ranks: int = 1  # processes that computed it
    # critical_speed_rpm, critical_frequency_hz, critical_whirl: critical speeds by rising speed of
    # the reference shaft: speed, frequency, whirl
    critical_speed_rpm: tuple[Number, ...] = ()
    critical_frequency_hz: tuple[Number, ...] = ()
    critical_whirl: tuple[str, ...] = ()
    # Kind of motion of each by shares of the energy; empty in rows of earlier releases
    critical_kind: tuple[str, ...] = ()
    # Relative error of each, of speed and frequency alike; nan if not known
    critical_error_estimate: tuple[Number, ...] = ()
    # The lateral motion of interfaces of each (`rotordyn.campbell.branch_numbers`); the same
    # interfaces in all cases of a scene. Empty in rows of earlier releases.
    critical_motion: tuple[tuple[Number, ...], ...] = ()
    campbell_speed_rpm: tuple[Number, ...] = ()  # speeds of the diagram (s)
    # campbell_frequency_hz, campbell_log_decrement: branch × speed; nan where a branch was not
    # found
    campbell_frequency_hz: tuple[tuple[Number, ...], ...] = ()
    campbell_log_decrement: tuple[tuple[Number, ...], ...] = ()
    # Of each branch the lateral motion of interfaces at the last speed at which it exists, as
    # `critical_motion`. Empty where no speed is above 0, and in rows of earlier releases.
    campbell_motion: tuple[tuple[Number, ...], ...] = ()
    # Scalars of the analyses by `<analysis>.<quantity>`
    responses: Mapping[str, Number] = field(default_factory=dict)


# A number that stands alone: neither part of a name nor a place in a list.
_NUMBER = re.compile(r"(?<![\w.\[-])[-+]?\d+(\.\d+)?([eE][-+]?\d+)?(?![\w\]])")


def in_order(rows: Iterable[BatchRow]) -> tuple[BatchRow, ...]:
    """Return rows by scene and number of the case, whatever order they ended in."""
    return tuple(sorted(rows, key=lambda row: (row.scene, len(row.case), row.case)))


def distinct_warnings(rows: Iterable[BatchRow]) -> list[str]:
    """Return each warning of some rows once, in the words of the first case that has it.

    Warnings that differ in numbers alone, as the values of a sweep make them, are one. Behind the
    text stand how many cases have it, and the first.
    """
    found: dict[str, tuple[str, list[str]]] = {}
    for row in in_order(rows):
        for text in row.warnings:
            _, cases = found.setdefault(_NUMBER.sub("#", text), (text, []))
            if row.case not in cases[-1:]:
                cases.append(row.case)
    return [
        f"{text} [{f'{len(cases)} cases, first ' if len(cases) > 1 else ''}{cases[0]}]"
        for text, cases in found.values()
    ]
