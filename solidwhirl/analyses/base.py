"""What all analyses of a scene share: the base of their records, and what they look at."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import (
    Field,
    field_validator,
    model_validator,
)

from solidwhirl.core.fields import (
    MOST,
    Count,
    FileName,
    Name,
    NotNegative,
    Place,
    Positive,
    Record,
)
from solidwhirl.core.outcome import Outcome
from solidwhirl.rotordyn import AssembledSystem, Campbell
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM
from solidwhirl.rotordyn.modes.damping import DampingRule

Points = Annotated[Count, Field(ge=2, le=20001)]
Places = Annotated[tuple[Place, ...], Field(min_length=1, max_length=MOST)]
Names = Annotated[tuple[Name, ...], Field(min_length=1, max_length=MOST)]

# Files and folders of a run that are no analysis.
_TAKEN = (
    *("campbell", "campbell_errors", "critical_speeds", "report", "results", "bodies", "meshes"),
    "verdict",
)
# Speeds at which shapes are drawn.
MOST_SPEEDS = 200
# Points of a map, steps of a run-up.
_MOST_POINTS = 2e6


def number_text(value: float) -> str:
    """A number as in the names of files: to 1e-6, without zeros at the end."""
    return f"{value:.6f}".rstrip("0").rstrip(".")


class OperatingSpec(Record):
    """Operating speeds of one shaft itself."""

    shaft: Name
    from_rpm: Positive
    to_rpm: Positive

    @model_validator(mode="after")
    def _rising(self) -> OperatingSpec:
        if self.to_rpm < self.from_rpm:
            raise ValueError(f"to_rpm = {self.to_rpm:g} is below from_rpm = {self.from_rpm:g}")
        return self


class Operating(NamedTuple):
    """Speeds of a shaft itself between which it runs, rpm, and its ratio to the reference."""

    shaft: str
    from_rpm: float
    to_rpm: float
    ratio: float

    @property
    def text(self) -> str:
        """What a legend says."""
        same = self.from_rpm == self.to_rpm
        speeds = f"{self.to_rpm:g}" if same else f"{self.from_rpm:g} to {self.to_rpm:g}"
        return f"operating speed of {self.shaft}, {speeds} rpm"

    @property
    def reference_rpm(self) -> tuple[float, float]:
        """Lowest and highest speed of the reference shaft, rpm."""
        return self.from_rpm / self.ratio, self.to_rpm / self.ratio


@dataclass(frozen=True, kw_only=True, eq=False)
class Engine:
    """What an analysis may look at.

    Attributes
    ----------
    system, diagram
        The assembled engine and its Campbell diagram.
    title
        Of pictures.
    speed_ratios
        Of the bodies to the reference shaft.
    operating
        Operating speeds of the shafts, those that analyses name included.
    operating_entries
        `[[operating]]` of the scene.
    damping_rule
        Which roots count as resonances.
    campbell_max_hz
        Highest frequency of the diagram, where the scene gives one.
    analyses
        All analyses of the scene by name.
    recoveries
        Makes the recovery of a body by its name (`reduction.recovery.stresses`).
    """

    system: AssembledSystem
    diagram: Campbell
    title: str
    speed_ratios: Mapping[str, float]
    operating: tuple[Operating, ...]
    operating_entries: tuple[OperatingSpec, ...]
    damping_rule: DampingRule
    campbell_max_hz: float | None
    analyses: Mapping[str, Analysis]
    recoveries: Callable[[str], Any]

    def speed_ratio(self, body: str) -> float:
        """Speed of a body over that of the reference shaft."""
        return self.speed_ratios[body]


class Analysis(Record):
    """What all analyses share: a name for results and pictures, the kind if there is none."""

    name: FileName | None = None

    @field_validator("name")
    @classmethod
    def _free(cls, value: str | None) -> str | None:
        if value is not None and value.lower() in _TAKEN:
            raise ValueError(f"{value!r} is the name of a file of every run; choose another")
        return value

    @property
    def label(self) -> str:
        """Name in results and file names."""
        return self.name or str(self.kind)  # type: ignore[attr-defined]

    def operating_named(self) -> Iterator[OperatingSpec]:
        """Yield the operating speeds that the analysis itself names."""
        yield from ()

    def run(self, engine: Engine) -> Outcome:
        """Compute what is asked.

        Raises
        ------
        AnalysisError
            The engine has no answer, such as an undamped resonance that is hit exactly.
        """
        raise NotImplementedError(self.label)


class Sweep(Analysis):
    """Speeds of the reference shaft."""

    from_rpm: NotNegative = 0.0
    to_rpm: Positive
    count: Points = 201

    @model_validator(mode="after")
    def _rising(self) -> Sweep:
        refuse_falling(self.from_rpm, self.to_rpm)
        return self

    @property
    def speeds_rad_s(self) -> FloatArray:
        """Speeds of the reference shaft, shape (count,)."""
        return np.asarray(np.linspace(self.from_rpm, self.to_rpm, self.count) * RAD_S_PER_RPM)


def refuse_falling(from_rpm: float, to_rpm: float) -> None:
    """Refuse a range of speeds that does not rise."""
    if to_rpm <= from_rpm:
        raise ValueError(f"to_rpm = {to_rpm:g} is not above from_rpm = {from_rpm:g}")


class Frequencies(Analysis):
    """Excitation frequencies from one step above zero to the highest."""

    frequency_max_hz: Positive
    frequency_count: Points = 500

    @property
    def frequencies_rad_s(self) -> FloatArray:
        """Angular frequencies in equal steps, without zero, shape (frequency_count,)."""
        return equal_steps(self.frequency_max_hz, self.frequency_count)


def refuse_large(what: str, rows: int, columns: int) -> None:
    """Refuse a map with more points than a run can hold."""
    if rows * columns > _MOST_POINTS:
        raise ValueError(
            f"{what} is {rows} x {columns} = {rows * columns}; a map has at most {_MOST_POINTS:.0f}"
        )


class Stiffnesses(Analysis):
    """Support stiffnesses, evenly spaced in their logarithm."""

    bearings: Names
    stiffness_from_n_per_m: Positive
    stiffness_to_n_per_m: Positive
    stiffness_count: Points = 31

    @model_validator(mode="after")
    def _rising(self) -> Stiffnesses:
        if self.stiffness_to_n_per_m <= self.stiffness_from_n_per_m:
            raise ValueError("stiffness_to_n_per_m is not above stiffness_from_n_per_m")
        return self


def equal_steps(frequency_max_hz: float, count: int) -> FloatArray:
    """Return angular frequencies in equal steps up to the highest, without zero."""
    steps = np.arange(1, count + 1) / count
    return np.asarray(2.0 * np.pi * frequency_max_hz * steps)


def decrements(values: FloatArray) -> list[Any]:
    """Return logarithmic decrements as plain data: rounding (exactly 0) is null."""
    array = np.asarray(values, dtype=float)
    plain: list[Any] = np.where(array == 0.0, np.nan, array).tolist()
    return plain
