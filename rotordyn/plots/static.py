"""Chart of shafts under static loads: how they sag, and the forces on them as arrows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.plots import chart as charts

# Length of the largest arrow beside the range of the deflections.
_LONGEST = 0.35
# Forces below this fraction of the largest of all directions are none.
_NONE = 1e-6
# Room of a letter and of an edge along x, of a row along y and of all rows, as parts of the frame.
_LETTER, _EDGE, _ROW, _MOST_ROWS = 0.0125, 0.01, 0.05, 0.6
_SUPPORT = charts.Look("@ink", "solid", width=2.4)
_LEADER = charts.Look("@muted", "dot", width=1.0)
_GIVEN = charts.Look("@bad", "dash", width=2.4)


@dataclass(frozen=True, kw_only=True, eq=False)
class LoadedLine:
    """A body along its axis, m: places and deflections along one direction, shape (p,) each."""

    name: str
    axial_m: FloatArray
    deflection_m: FloatArray


@dataclass(frozen=True, kw_only=True)
class Arrow:
    """A force along one direction on a shaft at a place and a deflection there."""

    name: str
    axial_m: float
    deflection_m: float
    force_n: float
    #: Whether a support exerts it; else it is a load
    of_support: bool = True


@dataclass(frozen=True, kw_only=True, eq=False)
class LoadedState:
    """What is drawn at one speed."""

    label: str
    lines: Sequence[LoadedLine]
    arrows: Sequence[Arrow]
    #: Largest force in any direction, N
    largest_n: float


def static_chart(direction: str, states: Sequence[LoadedState]) -> charts.Chart:
    """Return the deflection along a direction, "x" or "y", a state at a time.

    Arrows are the forces on the shafts: their length tells the size, within one state. Their
    numbers stand in rows above and below all that is drawn.
    """
    size = max(float(np.abs(x.deflection_m).max(initial=0.0)) for s in states for x in s.lines)
    unit, factor = charts.metric(size, "m")
    single = len(states) == 1
    drawn = [_arrows(state, factor) for state in states]
    frame = _frame(states, drawn, factor)
    options = [
        charts.Option(label=s.label, marks=_marks(s, arrows, places, factor, frame))
        for s, arrows, places in zip(states, drawn, frame.places, strict=True)
    ]
    low, high = frame.ends_along_y
    return charts.Chart(
        name=f"static-{direction}",
        title=f"Deflection and forces along {direction}",
        caption="Deflection of the axis of each body under its loads, much enlarged. Arrows are "
        "forces of bearings on the first side that they join, and (broken) loads beside weight.",
        alt=f"Deflected shafts along {direction} with the forces of their bearings.",
        x=charts.Axis(
            label="axial position", unit="m", digits=".4g", low=frame.left, high=frame.right
        ),
        y=charts.Axis(
            label=f"deflection along {direction}", unit=unit, digits=".4g", low=low, high=high
        ),
        parts=options[0].marks
        if single
        else [charts.Choice(label="speed", options=options, on_paper="each")],
        height_px=420,
    )


class _Drawn(NamedTuple):
    """An arrow in the units of the chart: where it ends, how long it is, and what is said of it."""

    arrow: Arrow
    tip: float
    long: float
    said: str

    @property
    def tail(self) -> float:
        return self.tip - self.long


def _arrows(state: LoadedState, factor: float) -> list[_Drawn]:
    every = [factor * line.deflection_m for line in state.lines]
    # the line without deflection is seen too
    span = float(np.ptp(np.concatenate([*every, np.zeros(1)]))) or 1.0
    largest = max((abs(arrow.force_n) for arrow in state.arrows), default=0.0)
    shown = [arrow for arrow in state.arrows if abs(arrow.force_n) > _NONE * state.largest_n]
    found = []
    for arrow in sorted(shown, key=lambda arrow: (not arrow.of_support, arrow.force_n < 0.0)):
        unit, scale = charts.metric(arrow.force_n, "N")
        found.append(
            _Drawn(
                arrow=arrow,
                tip=factor * arrow.deflection_m,
                long=_LONGEST * span * arrow.force_n / largest,
                said=f"{arrow.name} {scale * arrow.force_n:.4g} {unit}",
            )
        )
    return found


class _Place(NamedTuple):
    """Where the number of an arrow stands along x and how, and in which row from the shafts on."""

    x: float
    align: str
    is_below: bool
    row: int


class _Frame(NamedTuple):
    """Ends of what is drawn at all speeds, and where the numbers of each stand beyond them."""

    left: float
    right: float
    low: float
    high: float
    places: Sequence[Sequence[_Place]]

    @property
    def rows_below(self) -> int:
        return self._rows(True)

    @property
    def rows_above(self) -> int:
        return self._rows(False)

    def _rows(self, is_below: bool) -> int:
        every = (at for own in self.places for at in own if at.is_below == is_below)
        return max((1 + at.row for at in every), default=0)

    @property
    def row(self) -> float:
        """Height of a row of numbers: a part of the whole."""
        rows = self.rows_below + self.rows_above
        part = min(_ROW, _MOST_ROWS / max(rows, 1))
        return part * (self.high - self.low) / (1.0 - part * (rows + 1))

    @property
    def ends_along_y(self) -> tuple[float, float]:
        """Ends of the axis, with half a row of room beyond the last one."""
        room = 0.5 * self.row
        return (
            self.low - self.rows_below * self.row - room,
            self.high + self.rows_above * self.row + room,
        )


def _frame(
    states: Sequence[LoadedState], drawn: Sequence[Sequence[_Drawn]], factor: float
) -> _Frame:
    places = [line.axial_m for state in states for line in state.lines]
    places.append(np.array([d.arrow.axial_m for arrows in drawn for d in arrows]))
    along = np.concatenate(places)
    heights = [factor * line.deflection_m for state in states for line in state.lines]
    ends = [end for arrows in drawn for d in arrows for end in (d.tip, d.tail)]
    across = np.concatenate([*heights, np.array([0.0, *ends])])
    left, right = float(along.min()), float(along.max())
    room = 0.06 * (right - left) or 0.1
    left, right = left - room, right + room
    low, high = float(across.min()), float(across.max())
    edge = _EDGE * (high - low) or 1.0
    numbers = [_places(arrows, left, right) for arrows in drawn]
    return _Frame(left, right, low - edge, high + edge, numbers)


def _places(arrows: Sequence[_Drawn], left: float, right: float) -> list[_Place]:
    """Places of the numbers of arrows, in their order: none beside another it would touch."""
    width = right - left
    ends: dict[tuple[bool, int], float] = {}
    found: dict[int, _Place] = {}
    for k in sorted(range(len(arrows)), key=lambda k: arrows[k].arrow.axial_m):
        drawn = arrows[k]
        middle = (drawn.arrow.axial_m - left) / width
        long = _LETTER * len(drawn.said)
        below, align, x = drawn.long > 0.0, "center", middle
        if middle < 0.5 * long + _EDGE:
            align, x = "left", _EDGE
        elif middle > 1.0 - 0.5 * long - _EDGE:
            align, x = "right", 1.0 - _EDGE
        start = x - {"left": 0.0, "center": 0.5, "right": 1.0}[align] * long
        row = next(r for r in range(len(arrows)) if ends.get((below, r), -1.0) < start)
        ends[(below, row)] = start + long
        found[k] = _Place(left + x * width, align, below, row)
    return [found[k] for k in range(len(arrows))]


def _marks(
    state: LoadedState,
    arrows: Sequence[_Drawn],
    places: Sequence[_Place],
    factor: float,
    frame: _Frame,
) -> list[charts.Mark]:
    marks: list[charts.Mark] = [
        charts.Rule(at=0.0, along="y", look=charts.Look("@ink", "solid", width=0.8))
    ]
    for number, line in enumerate(state.lines):
        look = replace(charts.series_look(number), mark="")
        marks.append(
            charts.Curve(x=line.axial_m, y=factor * line.deflection_m, name=line.name, look=look)
        )
    # what looks alike one after the other, so that it is one entry of a legend
    marks += [mark for same in zip(*map(_arrow, arrows), strict=True) for mark in same]
    for drawn, at in zip(arrows, places, strict=True):
        beyond = (at.row + 0.5) * frame.row
        y = frame.low - beyond if at.is_below else frame.high + beyond
        near = y + (0.35 if at.is_below else -0.35) * frame.row
        place = np.full(2, drawn.arrow.axial_m)
        marks.append(charts.Curve(x=place, y=np.array([drawn.tail, near]), look=_LEADER))
        marks.append(charts.Note(x=at.x, y=y, text=drawn.said, align=at.align))
    return marks


def _arrow(drawn: _Drawn) -> tuple[charts.Mark, ...]:
    """A line, and the head with which it touches the shaft."""
    look = _SUPPORT if drawn.arrow.of_support else _GIVEN
    head = charts.Look(look.color, "", "triangle-up" if drawn.long > 0.0 else "triangle-down", 11.0)
    kind = "force of a bearing" if drawn.arrow.of_support else "load"
    place = np.full(2, drawn.arrow.axial_m)
    return (
        charts.Curve(
            x=place,
            y=np.array([drawn.tail, drawn.tip]),
            name=kind,
            look=look,
            texts=[drawn.said] * 2,
        ),
        charts.Curve(x=place[:1], y=np.array([drawn.tip]), look=head, texts=[drawn.said]),
    )
