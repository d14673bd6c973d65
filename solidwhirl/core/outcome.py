"""What an analysis of a scene hands on: numbers for results.json, pictures and files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from solidwhirl.core.displays import indented

Write = Callable[[Path], None]
# Curves of one picture that can be told apart by colour, and speeds whose orbits have room in one.
MOST_CURVES, MOST_ORBITS = 7, 8


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome:
    """Results of one analysis.

    Attributes
    ----------
    document
        What results.json holds; units in the keys.
    files
        Pictures and data by file name, each a function that writes the file it is given.
    """

    kind: str
    document: Mapping[str, Any]
    files: Mapping[str, Write] = field(default_factory=dict)
    headline: str = ""

    def __repr__(self) -> str:
        lines = [self.headline, f"document: {', '.join(self.document)}"]
        lines += [f"files: {', '.join(self.files)}"] if self.files else []
        return "\n".join([f"Outcome of {self.kind}", *indented([x for x in lines if x])])


def is_picture(file: str) -> bool:
    """Whether a file of an analysis is a picture, by its name."""
    return Path(file).suffix in (".png", ".svg", ".pdf")
