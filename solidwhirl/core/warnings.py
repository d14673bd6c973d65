"""What a doubt about a scene says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, kw_only=True)
class Doubt:
    """Something in a scene that its author may not mean, such as a number in another unit."""

    key: str
    #: The number with its unit, or what else was found
    found: str
    usual: str
    mistake: str

    @property
    def message(self) -> str:
        """One sentence with all of it."""
        return f"{self.key}: {self.found}; usual is {self.usual}. {self.mistake}"


def warnings_of(document: Mapping[str, Any]) -> list[str]:
    """Return the warnings of a run, each once.

    `document`: the contents of `results.json`: what is doubtful about the input, alarms of the
    results, and what the bearings' coefficients do not cover.
    """
    every = [doubt["message"] for doubt in document.get("doubts", ())]
    return list(dict.fromkeys([*every, *document.get("bearing_notes", ())]))
