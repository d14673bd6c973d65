"""Records of a batch: one case to compute, and the one row that it leaves in the table."""

from __future__ import annotations

import math
from collections.abc import Mapping
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
STATUSES: tuple[Status, ...] = ("done", "failed", "checks_failed")


@dataclass(frozen=True, kw_only=True)
class BatchCase:
    """One case of a batch: a scene, or a scene with other values at some places.

    Attributes
    ----------
    name
        Name of the case and of its folder: SCENE, or SCENE-0007 for the seventh case of a sweep.
    scene_path
        The scene file; files that the scene names lie relative to its folder.
    values
        Value by parameter; empty for a scene without `[sweep]`.
    data
        Content of the scene with the values put in, without `[sweep]`.
    digest
        SHA-256 of the case's scene with the level and accuracy of the command line: a row of the
        same digest needs no computing again.
    method, sweep_cases
        How the sweep takes its values, and how many cases it has; empty and 0 without `[sweep]`.
    """

    name: str
    scene_path: Path
    values: Mapping[str, Value]
    data: Mapping[str, Any]
    digest: str
    method: str = ""
    sweep_cases: int = 0


@dataclass(frozen=True, kw_only=True)
class BatchRow:
    """What one case came to; a line of the journal and a row of the table.

    Attributes
    ----------
    case, scene
        Name of the case, and of its scene.
    status
        `done`; `checks_failed`: results are there, but an invariant is violated; `failed`: none.
    message
        Why, for the latter two; empty if done.
    values
        Value by parameter of the sweep.
    digest, method, sweep_cases
        Those of the case; the latter two are empty and 0 in rows of earlier releases.
    seconds
        Wall time of the case.
    peak_memory_gib
        Largest resident memory of one rank; nan if not known.
    ranks
        Processes that computed it.
    critical_speed_rpm, critical_frequency_hz, critical_whirl
        Critical speeds by rising speed of the reference shaft: speed, frequency, whirl.
    critical_error_estimate
        Relative error of each, of speed and frequency alike; nan if not known.
    critical_motion
        The lateral motion of interfaces of each (`rotordyn.campbell.branch_numbers`); the same
        interfaces in all cases of a scene. Empty in rows of earlier releases.
    campbell_speed_rpm
        Speeds of the diagram (s).
    campbell_frequency_hz, campbell_log_decrement
        Branch × speed; nan where a branch was not found.
    campbell_motion
        Of each branch the lateral motion of interfaces at the last speed at which it exists, as
        `critical_motion`. Empty where no speed is above 0, and in rows of earlier releases.
    responses
        Scalars of the analyses by `<analysis>.<quantity>`.
    """

    case: str
    scene: str
    status: Status
    message: str = ""
    values: Mapping[str, Number | str] = field(default_factory=dict)
    digest: str = ""
    method: str = ""
    sweep_cases: int = 0
    seconds: Number = 0.0
    peak_memory_gib: Number = math.nan
    ranks: int = 1
    critical_speed_rpm: tuple[Number, ...] = ()
    critical_frequency_hz: tuple[Number, ...] = ()
    critical_whirl: tuple[str, ...] = ()
    critical_error_estimate: tuple[Number, ...] = ()
    critical_motion: tuple[tuple[Number, ...], ...] = ()
    campbell_speed_rpm: tuple[Number, ...] = ()
    campbell_frequency_hz: tuple[tuple[Number, ...], ...] = ()
    campbell_log_decrement: tuple[tuple[Number, ...], ...] = ()
    campbell_motion: tuple[tuple[Number, ...], ...] = ()
    responses: Mapping[str, Number] = field(default_factory=dict)
