"""What an analysis of a scene hands on: numbers for results.json, pictures and files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from solidwhirl.core.displays import indented

if TYPE_CHECKING:
    from solidwhirl.core.blocks import AnalysisBlock

Write = Callable[[Path], None]
# Curves of one picture that can be told apart by colour, and speeds whose orbits have room in one.
MOST_CURVES, MOST_ORBITS = 7, 8


@dataclass(frozen=True, kw_only=True, eq=False)
class Drawing:
    """Draws a picture in two steps, of which the second needs no run.

    It writes the file that it is given, as any other `Write` does.
    """

    #: Makes what is to be seen from the run: plain records
    shown: Callable[[], Any]
    #: Draws that to a file; a function of a module, so that another process can have it
    draw: Callable[[Any, Path], None]

    def __call__(self, path: Path) -> None:
        """Take both steps."""
        self.ready()(path)

    def ready(self) -> Write:
        """Return what draws the second step alone."""
        return partial(self.draw, self.shown())


@dataclass(frozen=True)
class PageSection:
    """Where on a page an analysis is told: anchor, heading, a sentence below it, and its order."""

    name: str
    title: str
    note: str
    order: int


OTHERS = PageSection("other-analyses", "Other analyses", "All numbers are in `results.json`.", 130)


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome:
    """Results of one analysis."""

    kind: str
    #: What results.json holds; units in the keys
    document: Mapping[str, Any]
    #: Pictures and data by file name, each a function that writes the file it is given
    files: Mapping[str, Write] = field(default_factory=dict)
    #: One line for the report
    headline: str = ""
    #: What its pictures show, a sentence
    caption: str = ""
    #: Where it is told
    section: PageSection = OTHERS
    #: Makes the texts, tables and charts that tell it; None: nothing was told to do so
    blocks: Callable[[], Sequence[AnalysisBlock]] | None = None

    def __repr__(self) -> str:
        lines = [self.headline, f"document: {', '.join(self.document)}"]
        lines += [f"files: {', '.join(self.files)}"] if self.files else []
        return "\n".join([f"Outcome of {self.kind}", *indented([x for x in lines if x])])


def is_picture(file: str) -> bool:
    """Whether a file of an analysis is a picture, by its name."""
    return Path(file).suffix in (".png", ".svg", ".pdf")
