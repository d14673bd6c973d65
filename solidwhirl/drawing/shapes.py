"""Plain shapes of a drawing: polygons, lines, circles and words with a look; y downwards.

Colours are "ink", "muted", "paper", and "c0", "c1", ... for bodies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray

#: Width of a letter, height of a line, and size of the letters, units of the picture.
LETTER, LINE, SIZE = 6.7, 15.0, 12.0


class Style(NamedTuple):
    """Colours of area and line, "" for none; `hatch` is the number of a body, -1 for none."""

    fill: str = ""
    stroke: str = ""
    width: float = 1.0
    dashes: tuple[float, ...] = ()
    opacity: float = 1.0
    hatch: int = -1


class Polygon(NamedTuple):
    """A closed line through points (k, 2)."""

    points: FloatArray
    style: Style


class Line(NamedTuple):
    """A line through points, which encloses nothing."""

    points: Sequence[tuple[float, float]]
    style: Style


class Circle(NamedTuple):
    """A circle about a point."""

    x: float
    y: float
    radius: float
    style: Style


class Words(NamedTuple):
    """A line of text: its anchor is its "start", "middle" or "end"; angle clockwise, degrees."""

    x: float
    y: float
    text: str
    anchor: str = "middle"
    angle: float = 0.0
    color: str = "ink"


class Group(NamedTuple):
    """Shapes that have a name on hover."""

    title: str
    shapes: Sequence[Shape]


Shape = Polygon | Line | Circle | Words | Group


@dataclass(frozen=True, kw_only=True, eq=False)
class Drawing:
    """Size of a picture, its shapes from back to front, and the number of bodies (hatchings)."""

    width: float
    height: float
    shapes: tuple[Shape, ...]
    bodies: int


def ruler_steps(low: float, high: float, most: int) -> list[float]:
    """Return round places within a range, at most so many but more than a third of that."""
    span = high - low
    raw = span / most
    power = 10.0 ** np.floor(np.log10(raw))
    step = next(f * power for f in (1.0, 2.0, 5.0, 10.0) if f * power >= raw * (1.0 - 1e-9))
    first = np.ceil(low / step - 1e-9)
    last = np.floor(high / step + 1e-9)
    return [float(k * step) + 0.0 for k in np.arange(first, last + 1.0)]
