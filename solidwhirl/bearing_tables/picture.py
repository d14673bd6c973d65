"""A picture of the coefficients of a table over speed or frequency."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from solidwhirl.bearing_tables.grid import ENDS
from solidwhirl.bearing_tables.records import CoefficientTable, TableFileError
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.plots.chart import Axis, Chart, Curve, series_look

_PARTS = (
    ("stiffness", "N/m", "stiffness_n_per_m"),
    ("damping", "N·s/m", "damping_n_s_per_m"),
    ("mass", "kg", "mass_kg"),
)
# Values of a second axis that are drawn.
_MOST = 3


def draw_table(table: CoefficientTable, path: Path) -> None:
    """Draw stiffness, damping and, where there is any, mass, one below the other.

    Over the speed, or the frequency or load of a table that has no two speeds; of a second axis the
    first, middle and last values are drawn. The suffix of the file chooses the kind of picture.
    Raises TableFileError: a table of one point; AnalysisError: a suffix that is no picture.
    """
    from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts

    named = list(_axes(table))
    if not named:
        raise TableFileError(table.source, "--picture: the table has one point")
    x = Axis(label=named[0][1], unit=named[0][2])
    charts = [
        Chart(
            name=what,
            title=what,
            x=x,
            y=Axis(label=what, unit=unit),
            parts=tuple(_curves(getattr(table, part), named)),
        )
        for what, unit, part in _PARTS
        if part != "mass_kg" or table.mass_kg.any()
    ]
    draw_charts(charts, path, table.source)


_Named = list[tuple[int, str, str, FloatArray]]


def _axes(table: CoefficientTable) -> Iterator[tuple[int, str, str, FloatArray]]:
    """Axes with two values or more: place in the arrays, label, unit, values in it."""
    for at, label, unit, values, scale in (
        (1, "speed of the rotor", "rpm", table.speeds_rad_s, RPM_PER_RAD_S),
        (2, "frequency", "Hz", table.frequencies_rad_s, 0.5 / np.pi),
        (0, "load", "N", table.loads_n, 1.0),
    ):
        if values is not None and values.size > 1:
            yield at, label, unit, values * scale


def _curves(values: FloatArray, named: _Named) -> Iterator[Curve]:
    along = named[0]
    for picked, text in _picked(named[1:]):
        place: list[slice | int] = [0, 0, 0]
        place[along[0]] = slice(None)
        for at, k in picked:
            place[at] = k
        rows = values[tuple(place)].reshape(-1, 4)
        for number, end in enumerate(ENDS):
            look = series_look(number if not picked else 4 * picked[0][1] + number)
            yield Curve(x=along[3], y=rows[:, number], name=f"{end}{text}", look=look)


def _picked(others: _Named) -> Iterator[tuple[list[tuple[int, int]], str]]:
    """Places along the other axes whose curves are drawn, and what names them."""
    if not others:
        yield [], ""
        return
    at, _, unit, values = others[0]
    rest = [(axis[0], 0) for axis in others[1:]]
    texts = "".join(f", {axis[3][0]:.6g} {axis[2]}" for axis in others[1:])
    for k in dict.fromkeys(np.linspace(0, values.size - 1, _MOST).round().astype(int).tolist()):
        yield [(at, k), *rest], f" at {values[k]:.6g} {unit}{texts}"
