"""What a recovery is asked: states of the engine."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, WithJsonSchema, WrapValidator, model_validator

from solidwhirl.analyses.base import number_text
from solidwhirl.core.fields import (
    Count,
    FileName,
    Name,
    NotNegative,
    Place,
    Positive,
    Record,
    several,
)

MOST_STATES, _MOST_TIMES, _MOST_PHASES = 50, 500, 120
_SOURCES = ("mode", "response", "run_up")
#: Source of a state that has a speed alone.
SPIN = "spin"


class RecoveryStateSpec(Record):
    """A mode, a response, one or several instants of a run-up, or steady spin: a speed alone."""

    name: FileName | None = None
    mode: Annotated[Count, Field(le=200)] | None = None
    amplitude_m: Positive | None = None
    response: Name | None = None
    run_up: Name | None = None
    speed_rpm: NotNegative | None = None
    time_s: Annotated[
        tuple[Positive, ...] | None,
        Field(min_length=1, max_length=_MOST_TIMES),
        WrapValidator(several),
        WithJsonSchema(
            {"anyOf": [{"type": "number"}, {"type": "array", "items": {"type": "number"}}]}
        ),
    ] = None
    peak: Place | None = None
    between_rpm: tuple[NotNegative, Positive] | None = None
    phases: Annotated[int, Field(ge=0, le=_MOST_PHASES, strict=True)] = 0

    @model_validator(mode="after")
    def _one_source(self) -> RecoveryStateSpec:
        given = [key for key in _SOURCES if getattr(self, key) is not None]
        if len(given) > 1 or not (given or self.speed_rpm is not None):
            raise ValueError(
                f"a state is one of {', '.join(_SOURCES)}, or speed_rpm alone; found "
                f"{', '.join(given) or 'none'}"
            )
        needed = {
            "mode": ("speed_rpm",),
            "response": ("speed_rpm", "peak"),
            "run_up": ("time_s", "peak"),
            SPIN: ("speed_rpm",),
        }[self.source]
        places = [k for k in ("speed_rpm", "time_s", "peak") if getattr(self, k) is not None]
        if len(places) != 1 or places[0] not in needed:
            found = ", ".join(places) or "neither"
            raise ValueError(f"{self.source} needs {' or '.join(needed)}; found {found}")
        if self.amplitude_m is not None and self.mode is None:
            raise ValueError("amplitude_m belongs to a mode; other states have their own amplitude")
        if self.between_rpm is not None:
            if self.peak is None:
                raise ValueError("between_rpm belongs to peak")
            if self.between_rpm[1] <= self.between_rpm[0]:
                raise ValueError("the second of between_rpm must be higher")
        if self.phases and self.run_up is not None:
            raise ValueError("phases belongs to vibrations; a run-up has instants: give time_s")
        if self.phases and self.is_spin:
            raise ValueError("phases belongs to vibrations; steady spin has none")
        if self.time_s is not None and list(self.time_s) != sorted(set(self.time_s)):
            raise ValueError("time_s must be rising")
        return self

    @property
    def source(self) -> str:
        """Its source: "mode", "response", "run_up", or `SPIN`."""
        return next((key for key in _SOURCES if getattr(self, key) is not None), SPIN)

    @property
    def instants(self) -> int:
        """How many there are: those of a run-up each have their own."""
        return len(self.time_s or (0.0,))

    @property
    def is_spin(self) -> bool:
        """Whether nothing moves but the spin."""
        return self.source == SPIN

    @property
    def label(self) -> str:
        """Name in results and file names."""
        if self.name is not None:
            return self.name
        if self.mode is not None:
            return f"mode{self.mode}_{number_text(self.speed_rpm or 0.0)}rpm"
        of = self.response or self.run_up or SPIN
        if self.peak is not None:
            return f"{of}_peak"
        return f"{of}_{number_text(self.speed_rpm)}rpm" if self.speed_rpm is not None else str(of)
