"""What one picture of a run is: its name, what it shows, and how it is drawn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

Draw = Callable[[Path], None]
#: Endings of still pictures, and of moving ones.
STILL_FORMATS, MOVING_FORMATS = ("pdf", "svg", "png"), ("gif", "mp4")


@dataclass(frozen=True, kw_only=True, eq=False)
class Picture:
    """One picture of a run."""

    name: str  # of its file, without the ending
    # "plot": drawn as lines and text; "still": a view of the bodies in space, an image with lines
    # and text around it; "film": moving
    kind: Literal["plot", "still", "film"]
    caption: str  # what is to be seen, a sentence or two
    draw: Draw  # writes the file that it is given; the ending chooses the format

    @property
    def formats(self) -> tuple[str, ...]:
        """Endings that it can be written with."""
        return MOVING_FORMATS if self.kind == "film" else STILL_FORMATS
