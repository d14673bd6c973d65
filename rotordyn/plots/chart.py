"""Charts as records: what is drawn, with labels and units, whoever draws it.

`matplotlib_chart` draws them on paper; a page in a browser may draw the same ones.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S

HZ_PER_RAD_S = 0.5 / np.pi
SPEED_LABEL = "speed of the reference shaft"
# Curves shown at the start; the others can be switched on where a chart can be changed.
_SHOWN = 8
_DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")
_MARKS = ("circle", "square", "diamond", "triangle-up", "x", "cross", "star", "pentagon")


@dataclass(frozen=True)
class Look:
    """Colour, dashes and mark of what is drawn.

    `color` is a number with # or one of @ink, @muted, @faint, @paper, @forward, @backward,
    @mixed, @straight, @band, @good, @bad, @c0 to @c7, with an opacity behind it as in "@ink/0.5".
    `dash` is "" without a line, `mark` "" without marks; "-open" at its end leaves it empty.
    `width` and `size` of marks are in pixels of a screen.
    """

    color: str = "@ink"
    dash: str = "solid"
    mark: str = ""
    size: float = 6.0
    width: float = 2.0


#: Looks of the directions of whirl and of other kinds of motion, told apart without colour too.
WHIRL_LOOKS = {
    "forward": Look("@forward", "solid", "circle"),
    "backward": Look("@backward", "dash", "square-open"),
    "mixed": Look("@mixed", "dashdot", "diamond"),
    "straight": Look("@straight", "dot", "diamond-open"),
    "torsional": Look("@c2", "longdashdot", "triangle-up-open"),
    "axial": Look("@c3", "longdash", "triangle-right-open"),
    "coupled": Look("@mixed", "dot", "star"),
    "disk": Look("@straight", "dot", "x-thin-open"),
}
_WHIRL_NAMES = {
    "straight": "lateral, in a line",
    "torsional": "torsional",
    "axial": "axial",
    "coupled": "torsional and axial",
    "disk": "disk alone",
}
RING = Look("@ink", "", "circle-open", 14)
WHITE = Look("#ffffff", "dash")


def whirl_look(whirl: str | None) -> Look:
    """Return the look of a whirl; without one it is that of a line."""
    return WHIRL_LOOKS.get(whirl or "straight", WHIRL_LOOKS["straight"])


def whirl_name(whirl: str) -> str:
    """Return the name of a whirl or a kind of motion as legends have it."""
    return _WHIRL_NAMES.get(whirl, f"{whirl} whirl")


def series_look(number: int) -> Look:
    """Return the look of one of several curves, from 0; no colour has a mark twice before 64."""
    mark = _MARKS[(number + number // 8) % len(_MARKS)]
    return Look(f"@c{number % 8}", _DASHES[number % len(_DASHES)], mark)


@dataclass(frozen=True, kw_only=True)
class Axis:
    """An axis."""

    #: What it says; the unit is empty where places have names
    label: str
    unit: str = ""
    #: Ends; None is as far as what is drawn
    low: float | None = None
    high: float | None = None
    #: Whether it is logarithmic
    is_log: bool = False
    #: Names of 0, 1, 2 and so on along it; empty for the numbers themselves
    places: Sequence[str] = ()
    #: Format of a value
    digits: str = ".5g"
    #: Between numbers; 0 leaves it open
    step: float = 0.0

    @property
    def title(self) -> str:
        """The label with the unit in brackets."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label


def speed_axis(low: float, high: float, label: str = SPEED_LABEL) -> Axis:
    """Return an axis of speeds in rpm; a range without length gets one."""
    return Axis(label=label, unit="rpm", low=low, high=max(high, low + 1.0), digits=",.0f")


def size_axis(label: str, unit: str, low: float, high: float) -> Axis:
    """Return a logarithmic axis of what reaches from low to high, seven decades at most."""
    low = max(low, 1e-7 * high)
    return Axis(label=label, unit=unit, low=low, high=1.6 * high, is_log=True, digits=".4g")


@dataclass(frozen=True, kw_only=True, eq=False)
class Curve:
    """A line through points, or marks alone; nan in them is a gap."""

    #: Shape (n,)
    x: FloatArray
    y: FloatArray
    #: In the legend; curves with one name and look belong together. Empty: none.
    name: str = ""
    look: Look = Look()
    #: What a reader is told at each point, lines parted by line feeds; empty: the values alone
    texts: Sequence[str] = ()
    #: Half lengths of error bars, shape (n,), and their axis; None without
    errors: FloatArray | None = None
    errors_along: str = "x"
    #: Whether it waits in the legend where a chart can be changed
    is_quiet: bool = False
    #: Whether it belongs to the axis at the right
    on_right: bool = False
    #: A name at its first point, on a screen
    written: str = ""
    #: Whether paper has its places along x written beside the points
    is_numbered: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class Fill:
    """The area between two curves over x, each of shape (n,); nan is a gap."""

    x: FloatArray
    low: FloatArray
    high: FloatArray
    name: str = ""
    look: Look = Look("@band", "")


@dataclass(frozen=True, kw_only=True, eq=False)
class Span:
    """A range along one axis, over the whole of the other one or a part of it."""

    #: Ends; equal ones make a line
    low: float
    high: float
    #: The axis of the range
    along: str = "x"
    #: In the legend, and what a reader is told
    name: str = ""
    text: str = ""
    look: Look = Look("@muted", "")
    #: Ends along the other axis; None is all of it
    between: tuple[float, float] | None = None
    #: Whether it is hatched; else it is shaded
    is_hatched: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class Rule:
    """A straight line across at a place along one axis, with a text at its end."""

    at: float
    along: str = "x"
    name: str = ""
    text: str = ""
    look: Look = Look("@muted", "dash", width=1.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Label:
    """A text at the "right", the "left" or "above" of a point, where a line leaves the frame."""

    x: float
    y: float
    text: str
    side: str


@dataclass(frozen=True, kw_only=True, eq=False)
class Note:
    """A text within the frame, whose "left" or "right" end or "center" is at a point."""

    x: float
    y: float
    text: str
    align: str


@dataclass(frozen=True, kw_only=True, eq=False)
class Heat:
    """A map of values (y, x) in colours by their logarithm, four decades at most."""

    #: Centres of the cells, rising, shapes (n,) and (m,)
    x: FloatArray
    y: FloatArray
    #: Shape (m, n), not below zero
    values: FloatArray
    #: Of the scale of colours
    label: str
    unit: str
    #: Value from which on colours are the same
    brightest: float = np.inf


@dataclass(frozen=True, kw_only=True, eq=False)
class Ridges:
    """Lines over x one behind the other: in space on a screen, each above its place on paper."""

    #: Points of the lines, shape (n,), and their places, rising, shape (m,)
    x: FloatArray
    y: FloatArray
    #: Heights, shape (m, n)
    values: FloatArray
    #: Of the heights
    label: str
    unit: str
    #: Units of y for one of the heights, on paper
    rise: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Bars:
    """Bars of one kind from the places of the axis that has names.

    Upright ones stand beside those of other kinds, or upon them (`Chart.is_stacked`), and tell
    their texts where they are pointed at; lying ones begin at `start`, else at zero, and have
    their texts at their ends.
    """

    values: FloatArray
    name: str
    look: Look
    start: FloatArray | None = None
    texts: Sequence[str] = ()


Mark = Curve | Fill | Span | Rule | Label | Note | Heat | Ridges | Bars


@dataclass(frozen=True, kw_only=True, eq=False)
class Toggle:
    """What can be shown and hidden."""

    label: str
    marks: Sequence[Mark]
    is_shown: bool = True


@dataclass(frozen=True, kw_only=True, eq=False)
class Option:
    """One of several things to be shown, with axes of its own where they differ."""

    label: str
    marks: Sequence[Mark] = ()
    x: Axis | None = None
    y: Axis | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Choice:
    """Things of which one is shown, the first at the start.

    On paper each has its own frame if `on_paper` is "each", else the first alone is drawn.
    """

    label: str
    options: Sequence[Option]
    on_paper: str = "first"


Part = Mark | Toggle | Choice


@dataclass(frozen=True, kw_only=True, eq=False)
class Chart:
    """A chart."""

    #: Identifier: letters, digits, hyphens
    name: str
    #: Above it; caption and alt stand below it, and for those who can't see it
    title: str
    x: Axis
    y: Axis
    #: From back to front
    parts: Sequence[Part]
    caption: str = ""
    alt: str = ""
    #: Axis at the right; None without curves on it
    right: Axis | None = None
    #: Lines beside it on paper
    notes: Sequence[str] = ()
    #: On a screen
    height_px: int = 420
    #: Whether both axes have the same scale
    is_to_scale: bool = False
    #: Whether names show
    has_legend: bool = True
    #: Whether bars stand upon each other, negative ones below zero
    is_stacked: bool = False

    def marks(self, kind: type[Any] | None = None) -> list[Any]:
        """Return all marks, or those of a kind, of all toggles and options too."""
        found: list[Any] = []
        for part in self.parts:
            if isinstance(part, Toggle):
                found += part.marks
            elif isinstance(part, Choice):
                found += [mark for option in part.options for mark in option.marks]
            else:
                found.append(part)
        return [m for m in found if kind is None or isinstance(m, kind)]


class Run(NamedTuple):
    """Points first to last (included) of a branch along which the whirl stays the same."""

    whirl: str
    first: int
    last: int


def whirl_runs(whirl: Sequence[str | None]) -> Iterator[Run]:
    """Cut a branch into runs of one whirl; a step has the whirl of its faster end.

    The whirl is None or "" where the branch has ended.
    """
    step = [b or a or "" for a, b in pairwise(whirl)]
    if not step and whirl and whirl[0]:
        yield Run(str(whirl[0]), 0, 0)
    start = 0
    for stop in range(1, len(step) + 1):
        if stop < len(step) and step[stop] == step[start]:
            continue
        if step[start]:
            yield Run(step[start], start, stop)
        start = stop


def branch_curves(
    x: FloatArray, y: FloatArray, whirl: Any, texts: Sequence[Sequence[str]] = ()
) -> list[Curve]:
    """Return branches y (b, s) over x (s,) in runs of one whirl, those of each whirl together.

    `whirl` and `texts` are b × s; the whirl is None or "" where a branch does not exist.
    """
    found = [
        Curve(
            x=x[run.first : run.last + 1],
            y=y[b, run.first : run.last + 1],
            name=whirl_name(run.whirl),
            look=whirl_look(run.whirl),
            texts=texts[b][run.first : run.last + 1] if texts else (),
        )
        for b, branch in enumerate(whirl)
        for run in whirl_runs([str(w) if w else None for w in branch])
        if run.whirl in WHIRL_LOOKS
    ]
    order = [whirl_name(w) for w in WHIRL_LOOKS]
    return sorted(found, key=lambda curve: order.index(curve.name))


def hertz_text(frequency_hz: float, digits: int = 4) -> str:
    """Return a frequency with its unit and so many digits, never with a power of ten."""
    text = np.format_float_positional(frequency_hz, digits, fractional=False, trim="-")
    return f"{text} Hz"


def metric(largest: float, unit: str) -> tuple[str, float]:
    """Return a unit with a prefix in which a size is a number of a few digits, and its factor."""
    size = abs(float(largest)) or 1e-6
    for power, prefix in zip(range(9, -12, -3), "GMk mµn", strict=True):
        if size * 10.0**-power >= 1.0:
            return prefix.strip() + unit, 10.0**-power
    return "p" + unit, 1e12


def same_ratios(ratios: Mapping[str, float]) -> dict[float, list[str]]:
    """Return the names of each |ratio| that is not zero."""
    named: dict[float, list[str]] = {}
    for name, ratio in ratios.items():
        if ratio != 0.0:
            named.setdefault(abs(ratio), []).append(name)
    return named


def operating_toggle(speeds_rad_s: Mapping[str, tuple[float, float]]) -> list[Toggle]:
    """Return lowest and highest operating speeds, by what a reader is told, as hatched ranges."""
    spans: dict[tuple[float, float], Span] = {}
    for text, (low, high) in speeds_rad_s.items():
        name = "operating speed"
        ends = (low * RPM_PER_RAD_S, high * RPM_PER_RAD_S)
        told = f"{spans[ends].text}\n{text}" if ends in spans else text
        spans[ends] = Span(low=ends[0], high=ends[1], name=name, text=told, is_hatched=True)
    return [Toggle(label="operating speeds", marks=[*spans.values()])] if spans else []


def is_quiet(number: int) -> bool:
    """Whether one of many curves, from 0, waits to be asked for."""
    return number >= _SHOWN
