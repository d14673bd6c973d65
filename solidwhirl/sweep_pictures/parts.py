"""What the pictures of a sweep share: labels, axes, legend and notes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from solidwhirl.rotordyn.plots.frame import (
    SMALL_PT,
    SUPERSCRIPTS,
    TITLE_PT,
    WHIRL_STYLES,
    Style,
    number_text,
)
from solidwhirl.sweep.analysis import SweepAnalysis, SweepPictureSettings, ranking
from solidwhirl.sweep.design import SweepDesign
from solidwhirl.sweep.labels import label_of, wrapped

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_OTHER_WHIRL = Style("#CC79A7", (0, (3, 1, 1, 1, 1, 1)), "^")
_NOTES = 4


def shown_parameters(found: SweepAnalysis) -> list[int]:
    """Return columns of the parameters, the most influential first."""
    names = [p.name for p in found.design.parameters]
    order = [names.index(n) for n in ranking(found.sensitivities)]
    return order + [k for k in range(len(names)) if k not in order]


def cases_text(found: SweepAnalysis) -> str:
    """Return "33 cases, 1 left out", and how many have no row yet."""
    design = found.design
    word = "samples" if design.kind == "samples" else "cases"
    lost = f", {len(design.left_out)} left out" if design.left_out else ""
    missing = f", {design.missing} missing" if design.missing else ""
    return f"{len(design.rows)} {word}{lost}{missing}"


def parameter_label(name: str, settings: SweepPictureSettings) -> str:
    """Return the label of a parameter or response."""
    return settings.labels.get(name, label_of(name))


def parameter_axis(
    axes: Axes, found: SweepAnalysis, settings: SweepPictureSettings, parameter: int, which: str
) -> None:
    """Label an axis with a parameter: its unit, its words, its logarithm."""
    chosen = found.design.parameters[parameter]
    label = parameter_label(chosen.name, settings)
    if chosen.choices:
        getattr(axes, f"set_{which}ticks")(range(len(chosen.choices)), chosen.choices)
    elif chosen.logarithmic:
        getattr(axes, f"set_{which}scale")("log")
    else:
        from matplotlib.ticker import FuncFormatter, MaxNLocator

        largest = float(np.abs(found.design.values[:, parameter]).max(initial=0.0))
        scale, label = in_powers_of_ten(label, largest)
        axis = axes.xaxis if which == "x" else axes.yaxis
        axis.set_major_locator(MaxNLocator(4 if which == "x" else 6, steps=[1, 2, 2.5, 5, 10]))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value / scale:.6g}"))
    getattr(axes, f"set_{which}label")(wrapped(label, 34))


def in_powers_of_ten(label: str, largest: float) -> tuple[float, str]:
    """Return what the numbers of an axis are divided by, and its label with that in its unit.

    Parameters
    ----------
    label
        With the unit in brackets at its end, or without one.
    largest
        The largest number without its sign; from 0.001 up to 10 000 nothing is divided.
    """
    exponent = math.floor(math.log10(largest)) if largest > 0.0 else 0
    if -4 < exponent < 4:
        return 1.0, label
    power = "10" + str(exponent).translate(SUPERSCRIPTS)
    name, bracket, unit = label.rpartition(" [")
    said = f"{name} [{power} {unit}" if bracket else f"{label} [{power}]"
    return float(f"1e{exponent}"), said


def value_text(design: SweepDesign, name: str, value: float) -> str:
    """Return a value of a parameter, a word by its number."""
    choices = design.parameters[design.number(name)].choices
    return choices[int(value)] if choices else number_text(value, 4)


def whirl_style(whirl: str) -> Style:
    """Return how a critical speed is drawn; one of several whirls has a style of its own."""
    return WHIRL_STYLES.get(whirl, _OTHER_WHIRL)


def write_notes(figure: Figure, notes: Sequence[str]) -> None:
    """Write the first notes below the diagram."""
    said = list(notes[:_NOTES])
    if len(notes) > _NOTES:
        said.append(f"and {len(notes) - _NOTES} more notes in sweep.json")
    if said:
        figure.supxlabel(
            "\n".join(fill(n, 118) for n in said), fontsize=SMALL_PT, x=0.01, ha="left"
        )


def write_title(figure: Figure, title: str) -> None:
    """Write what is above all frames."""
    figure.suptitle("\n".join(fill(line, 80) for line in title.split("\n")), fontsize=TITLE_PT)
