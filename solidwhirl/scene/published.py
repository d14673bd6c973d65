"""Scene records of published or measured values that the results are compared with."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import Field, model_validator

from solidwhirl.core.fields import Finite, Positive, Record, Title

_PATH = re.compile(r"[A-Za-z][\w-]*(?:\.[A-Za-z][\w-]*|\[\d{1,6}\])+")
#: Parts of `results.json` that hold numbers of the engine.
COMPARED = ("analyses", "bodies", "campbell", "critical_speeds", "modes_at_rest")


class ReferenceSpec(Record):
    """A value that somebody else has of a number in the results."""

    quantity: Annotated[str, Field(max_length=200)]
    value: Finite
    source: Annotated[Title, Field(min_length=1)]
    title: Title = ""
    tolerance: Positive | None = None

    @model_validator(mode="after")
    def _path(self) -> ReferenceSpec:
        first = re.split(r"[.\[]", self.quantity, maxsplit=1)[0]
        if not _PATH.fullmatch(self.quantity) or first not in COMPARED:
            raise ValueError(
                f"quantity is {self.quantity!r}; it is the place of a number in results.json, such "
                f"as 'critical_speeds[0].frequency_hz', and begins with {', '.join(COMPARED)}"
            )
        if self.value == 0.0 and self.tolerance is not None:
            raise ValueError("tolerance is relative, and value is 0; leave it out")
        return self
