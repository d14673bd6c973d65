"""The event that a run emits when a stage begins; who shows it makes the text."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum


class StageName(StrEnum):
    """What a stage computes."""

    MESHING = "meshing"
    REDUCTION = "reduction"
    NODAL_DIAMETER = "nodal_diameter"
    ASSEMBLY = "assembly"
    CAMPBELL = "campbell"
    CRITICAL_SPEEDS = "critical_speeds"
    ERROR_ESTIMATES = "error_estimates"
    ANALYSIS = "analysis"
    WRITING = "writing"


_TEXTS = {
    StageName.MESHING: "mesh {}",
    StageName.REDUCTION: "reduce {}",
    StageName.NODAL_DIAMETER: "reduce {}",
    StageName.ASSEMBLY: "assemble the system",
    StageName.CAMPBELL: "Campbell diagram",
    StageName.CRITICAL_SPEEDS: "critical speeds",
    StageName.ERROR_ESTIMATES: "error estimates",
    StageName.ANALYSIS: "{}",
    StageName.WRITING: "write the results",
}


@dataclass(frozen=True, kw_only=True)
class Stage:
    """A stage of a run. Two are equal if they compute the same of the same body."""

    name: StageName
    body: str = ""
    detail: str = field(default="", compare=False)
    #: Predicted time [s]; 0 where nothing is known
    seconds: float = field(default=0.0, compare=False)

    def __str__(self) -> str:
        """One line, such as "reduce rotor"."""
        return _TEXTS[self.name].format(self.body) + self.detail


#: Told each stage that begins, and remarks, which are text. Both print as one line.
Progress = Callable[[Stage | str], None]


def silent(event: Stage | str) -> None:
    """Tell nobody."""
