"""Pictures of static loads: their numbers are within the frame and on no line."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from solidwhirl.rotordyn.plots import matplotlib_chart
from solidwhirl.rotordyn.plots.static import Arrow, LoadedLine, LoadedState, static_chart

NAMES = ("A", "front_bearing", "a_rather_long_name_of_a_bearing", "hp.wheel")


def state(rng, speed):
    """A shaft that bends somehow, with forces at random places and at both ends."""
    z = np.sort(np.concatenate(([0.0, 1.3], rng.uniform(0.0, 1.3, 40))))
    bent = 1e-5 * np.polynomial.polynomial.polyval(z - 0.6, rng.normal(size=4))
    places = [0.0, 1.3, *rng.choice(z, 4)]
    arrows = [
        Arrow(
            name=NAMES[k % 4], axial_m=float(at), deflection_m=float(np.interp(at, z, bent)),
            force_n=float(100.0 * rng.normal()), of_support=k < 3,
        )
        for k, at in enumerate(places)
    ]  # fmt: skip
    line = LoadedLine(name="rotor", axial_m=z, deflection_m=bent)
    largest = max((abs(arrow.force_n) for arrow in arrows), default=0.0)
    return LoadedState(label=f"{speed} rpm", lines=[line], arrows=arrows, largest_n=largest)


@pytest.mark.parametrize("seed", range(6))
def test_numbers_of_arrows(monkeypatch, tmp_path, seed):
    """No text leaves the frame, touches a point of the shaft between or another text."""
    figures: list[Figure] = []
    monkeypatch.setattr(
        matplotlib_chart.frame, "write_figure", lambda figure, path: figures.append(figure)
    )
    one = state(np.random.default_rng(seed), 0)
    matplotlib_chart.draw_titled_charts([static_chart("y", [one])], tmp_path / "a.png", "Machine")
    (figure,) = figures
    figure.draw_without_rendering()
    (axes,) = figure.axes
    boxes = [text.get_window_extent() for text in axes.texts]
    assert len(boxes) == len(one.arrows)
    inside = axes.get_window_extent()
    bent = axes.lines[1]
    fine = np.linspace(*bent.get_xdata()[[0, -1]], 2000)
    curve = np.interp(fine, bent.get_xdata(), bent.get_ydata())
    points = axes.transData.transform(np.column_stack((fine, curve)))
    for k, box in enumerate(boxes):
        assert inside.x0 <= box.x0 and box.x1 <= inside.x1
        assert inside.y0 <= box.y0 and box.y1 <= inside.y1
        assert not any(box.contains(*point) for point in points)
        assert not any(box.overlaps(other) for other in boxes[:k])


def test_speeds_share_one_frame():
    """Every option has its numbers within the ends of the axes of all."""
    rng = np.random.default_rng(9)
    chart = static_chart("x", [state(rng, speed) for speed in (0, 3000)])
    (choice,) = chart.parts
    for option in choice.options:
        notes = [mark for mark in option.marks if hasattr(mark, "align")]
        assert len(notes) == 6
        assert all(chart.x.low < note.x < chart.x.high for note in notes)
        assert all(chart.y.low < note.y < chart.y.high for note in notes)
