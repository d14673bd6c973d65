"""Scene records of the recovery: states of the engine whose displacement and stress are wanted."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from solidwhirl.scene_base import (
    MOST,
    Count,
    FileName,
    Name,
    NotNegative,
    Place,
    Positive,
    Record,
    alike_in_files,
)

_MOST_STATES, _MOST_TIMES, _MOST_PHASES = 50, 500, 120
_SOURCES = ("mode", "response", "run_up")


def _several(value: Any) -> Any:
    """A number stands for a list of one."""
    return (value,) if isinstance(value, int | float) else value


def number_text(value: float) -> str:
    """A number as in the names of files: to 1e-6, without zeros at the end."""
    return f"{value:.6f}".rstrip("0").rstrip(".")


class RecoveryStateSpec(Record):
    """One state, or several instants of one run-up: a mode, a response, or a run-up."""

    name: FileName | None = None
    mode: Annotated[Count, Field(le=200)] | None = None
    amplitude_m: Positive | None = None
    response: Name | None = None
    run_up: Name | None = None
    speed_rpm: NotNegative | None = None
    time_s: Annotated[
        tuple[Positive, ...] | None,
        Field(min_length=1, max_length=_MOST_TIMES),
        BeforeValidator(_several),
    ] = None
    peak: Place | None = None
    between_rpm: tuple[NotNegative, Positive] | None = None
    phases: Annotated[int, Field(ge=0, le=_MOST_PHASES, strict=True)] = 0

    @model_validator(mode="after")
    def _one_source(self) -> RecoveryStateSpec:
        given = [key for key in _SOURCES if getattr(self, key) is not None]
        if len(given) != 1:
            raise ValueError(
                f"a state is one of {', '.join(_SOURCES)}; found {', '.join(given) or 'none'}"
            )
        needed = {
            "mode": ("speed_rpm",),
            "response": ("speed_rpm", "peak"),
            "run_up": ("time_s", "peak"),
        }[given[0]]
        places = [k for k in ("speed_rpm", "time_s", "peak") if getattr(self, k) is not None]
        if len(places) != 1 or places[0] not in needed:
            raise ValueError(
                f"{given[0]} needs {' or '.join(needed)}; found {', '.join(places) or 'neither'}"
            )
        if self.amplitude_m is not None and self.mode is None:
            raise ValueError("amplitude_m belongs to a mode; other states have their own amplitude")
        if self.between_rpm is not None:
            if self.peak is None:
                raise ValueError("between_rpm belongs to peak")
            if self.between_rpm[1] <= self.between_rpm[0]:
                raise ValueError("the second of between_rpm must be higher")
        if self.phases and self.run_up is not None:
            raise ValueError("phases belongs to vibrations; a run-up has instants: give time_s")
        if self.time_s is not None and list(self.time_s) != sorted(set(self.time_s)):
            raise ValueError("time_s must be rising")
        return self

    @property
    def label(self) -> str:
        """Name in results and file names."""
        if self.name is not None:
            return self.name
        if self.mode is not None:
            return f"mode{self.mode}_{number_text(self.speed_rpm or 0.0)}rpm"
        of = self.response or self.run_up
        if self.peak is not None:
            return f"{of}_peak"
        return f"{of}_{number_text(self.speed_rpm)}rpm" if self.speed_rpm is not None else str(of)


class RecoverySpec(Record):
    """Displacement and stress in the solid bodies in some states of the engine."""

    kind: Literal["recovery"]
    name: FileName | None = None
    bodies: Annotated[tuple[Name, ...], Field(min_length=1, max_length=MOST)]
    states: Annotated[tuple[RecoveryStateSpec, ...], Field(min_length=1, max_length=_MOST_STATES)]
    quantities: Annotated[
        tuple[Literal["displacement", "stress"], ...], Field(min_length=1, max_length=2)
    ] = ("displacement", "stress")
    sectors: Annotated[int, Field(ge=8, le=360, strict=True)] = 32

    @property
    def label(self) -> str:
        """Name in results and file names."""
        return self.name or self.kind

    @model_validator(mode="after")
    def _different(self) -> RecoverySpec:
        for key in ("bodies", "quantities"):
            if len(set(getattr(self, key))) < len(getattr(self, key)):
                raise ValueError(f"{key} names something twice")
        labels = [state.label for state in self.states]
        alike = alike_in_files(list(dict.fromkeys(labels)))
        for label in labels:
            if labels.count(label) > 1 or (alike and label in alike):
                raise ValueError(f"more than one state is named {label!r}; give them names")
        return self

    @property
    def speeds_rpm(self) -> tuple[float, ...]:
        """Speeds of the reference shaft that the states name; the bases are made for them."""
        return tuple(s.speed_rpm for s in self.states if s.speed_rpm is not None)

    @property
    def refers_to(self) -> tuple[str, ...]:
        """Names of the analyses whose states are recovered."""
        named = [state.response or state.run_up for state in self.states]
        return tuple(dict.fromkeys(name for name in named if name is not None))
