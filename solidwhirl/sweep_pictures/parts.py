"""What the pictures of a sweep share: labels and axes."""

from __future__ import annotations

import math

import numpy as np

from solidwhirl.core.key_units import label_of
from solidwhirl.rotordyn.plots.chart import Axis, Look, Span
from solidwhirl.rotordyn.plots.frame import SUPERSCRIPTS, number_text
from solidwhirl.sweep.analysis import SweepAnalysis, SweepPictureSettings, ranking
from solidwhirl.sweep.design import SweepDesign

# Room at both ends of an axis of a parameter, as a part of its range.
_ROOM = 0.12


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
    found: SweepAnalysis, settings: SweepPictureSettings, number: int
) -> tuple[Axis, float]:
    """Return the axis of a parameter, and what its values are divided by on it."""
    design = found.design
    chosen, values = design.parameters[number], design.values[:, number]
    label = parameter_label(chosen.name, settings)
    if chosen.choices:
        count = len(chosen.choices)
        return Axis(label=label, places=chosen.choices, low=-0.5, high=count - 0.5), 1.0
    if design.left_out:
        values = np.concatenate([values, design.left_out_values[:, number]])
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    if chosen.logarithmic:
        room = (high / low) ** _ROOM
        return Axis(label=label, low=low / room, high=high * room, is_log=True), 1.0
    scale, label = in_powers_of_ten(label, max(abs(low), abs(high)))
    room = _ROOM * ((high - low) or 1.0)
    return Axis(label=label, low=(low - room) / scale, high=(high + room) / scale), scale


def in_powers_of_ten(label: str, largest: float) -> tuple[float, str]:
    """Return what the numbers of an axis are divided by, and its label with that in its unit.

    The label may have its unit in brackets at the end. Where the largest number is from 0.001 up to
    10 000 nothing is divided.
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


def operating_span(settings: SweepPictureSettings, along: str) -> list[Span]:
    """Return the operating speeds that were asked for, shaded along an axis."""
    if settings.operating_rpm is None:
        return []
    low, high = settings.operating_rpm
    look = Look("@c4", "")
    return [Span(low=low, high=high, along=along, name="operating speeds", look=look)]
