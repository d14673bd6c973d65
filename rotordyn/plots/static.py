"""Chart of shafts under static loads: how they sag, and the forces on them as arrows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.plots import chart as charts

# Length of the largest arrow beside the range of the deflections.
_LONGEST = 0.35
# Forces below this fraction of the largest of all directions are none.
_NONE = 1e-6
# Numbers of arrows at one place are as far apart, of the range of the deflections.
_APART = 0.06
_SUPPORT = charts.Look("@ink", "solid", width=2.4)
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

    Arrows are the forces on the shafts: their length tells the size, within one state.
    """
    size = max(float(np.abs(x.deflection_m).max(initial=0.0)) for s in states for x in s.lines)
    unit, factor = charts.metric(size, "m")
    single = len(states) == 1
    named = _label if single else _written
    options = [charts.Option(label=s.label, marks=_marks(s, factor, named)) for s in states]
    return charts.Chart(
        name=f"static-{direction}",
        title=f"Deflection and forces along {direction}",
        caption="Deflection of the axis of each body under its loads, much enlarged. Arrows are "
        "forces of bearings on the first side that they join, and (broken) loads beside weight.",
        alt=f"Deflected shafts along {direction} with the forces of their bearings.",
        x=charts.Axis(label="axial position", unit="m", digits=".4g"),
        y=charts.Axis(label=f"deflection along {direction}", unit=unit, digits=".4g"),
        parts=options[0].marks
        if single
        else [charts.Choice(label="speed", options=options, on_paper="each")],
        height_px=420,
    )


def _marks(
    state: LoadedState, factor: float, named: Callable[[float, float, str], charts.Mark]
) -> list[charts.Mark]:
    marks: list[charts.Mark] = [
        charts.Rule(at=0.0, along="y", look=charts.Look("@ink", "solid", width=0.8))
    ]
    for number, line in enumerate(state.lines):
        look = replace(charts.series_look(number), mark="")
        marks.append(
            charts.Curve(x=line.axial_m, y=factor * line.deflection_m, name=line.name, look=look)
        )
    every = [factor * line.deflection_m for line in state.lines]
    # the line without deflection is seen too
    span = float(np.ptp(np.concatenate([*every, np.zeros(1)]))) or 1.0
    largest = max((abs(arrow.force_n) for arrow in state.arrows), default=0.0)
    shown = [arrow for arrow in state.arrows if abs(arrow.force_n) > _NONE * state.largest_n]
    drawn, written = [], list[tuple[float, float]]()
    for arrow in sorted(shown, key=lambda arrow: (not arrow.of_support, arrow.force_n < 0.0)):
        tip, long = factor * arrow.deflection_m, _LONGEST * span * arrow.force_n / largest
        at = tip - long
        while any(x == arrow.axial_m and abs(y - at) < _APART * span for x, y in written):
            at -= _APART * span
        written.append((arrow.axial_m, at))
        drawn.append((*_arrow(arrow, tip, long), named(arrow.axial_m, at, _said(arrow))))
    # what looks alike one after the other, so that it is one entry of a legend
    return [*marks, *(mark for same in zip(*drawn, strict=True) for mark in same)]


def _said(arrow: Arrow) -> str:
    unit, factor = charts.metric(arrow.force_n, "N")
    return f"{arrow.name} {factor * arrow.force_n:.4g} {unit}"


def _arrow(arrow: Arrow, tip: float, long: float) -> tuple[charts.Mark, ...]:
    """A line, and the head with which it touches the shaft."""
    look, said = _SUPPORT if arrow.of_support else _GIVEN, _said(arrow)
    head = charts.Look(look.color, "", "triangle-up" if long > 0.0 else "triangle-down", 11.0)
    kind = "force of a bearing" if arrow.of_support else "load"
    place = np.array([arrow.axial_m, arrow.axial_m])
    return (
        charts.Curve(
            x=place, y=tip - np.array([long, 0.0]), name=kind, look=look, texts=[said] * 2
        ),
        charts.Curve(x=place[:1], y=np.array([tip]), look=head, texts=[said]),
    )


def _label(x: float, y: float, text: str) -> charts.Mark:
    return charts.Label(x=x, y=y, text=text, side="right")


def _written(x: float, y: float, text: str) -> charts.Mark:
    """A text that is shown and hidden with its option."""
    dot = charts.Look("@ink", "", "circle", 3.0)
    return charts.Curve(x=np.array([x]), y=np.array([y]), look=dot, written=text)
