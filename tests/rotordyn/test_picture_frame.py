"""Numbers, axes and legends that all pictures share."""

from __future__ import annotations

import numpy as np
import pytest

from solidwhirl.rotordyn.picture_frame import (
    ONE_COLUMN_MM,
    add_legend,
    name_speeds,
    new_figure,
    number_text,
    thousands,
)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (0.05, "0.05"),
        (123.4, "123"),
        (-2.5, "\u22122.5"),
        (5.0118e8, "5.01×10⁸"),
        (1e5, "10⁵"),
        (3.7e-4, "3.7×10⁻⁴"),
        (-1.2e-7, "\u22121.2×10⁻⁷"),
    ],
)
def test_numbers_have_powers_of_ten(value, text):
    assert number_text(value) == text


def test_digits_are_kept():
    assert number_text(37414.0, 5) == "37414"
    assert number_text(3.7414e-4, 5) == "3.7414×10⁻⁴"


@pytest.mark.parametrize(
    ("value", "text"),
    [(7500.0, "7500"), (12500.0, "12\u2009500"), (-20000.0, "\u221220\u2009000"), (0.5, "0.5")],
)
def test_speeds_have_groups_of_digits(value, text):
    assert thousands(value) == text


def _named(axes):
    axes.figure.draw_without_rendering()
    low, high = axes.get_ylim()
    labels = [*axes.yaxis.get_majorticklabels(), *axes.yaxis.get_minorticklabels()]
    return {t.get_text() for t in labels if t.get_text() and low <= t.get_position()[1] <= high}


def test_two_and_five_are_named_on_a_short_logarithmic_axis(tmp_path):
    axes = new_figure(tmp_path / "a.png").add_subplot()
    axes.set(yscale="log", ylim=(900.0, 30e3))
    name_speeds(axes.yaxis)
    assert _named(axes) == {"1000", "2000", "5000", "10\u2009000", "20\u2009000"}


def test_powers_alone_are_named_on_a_long_one(tmp_path):
    axes = new_figure(tmp_path / "a.png").add_subplot()
    axes.set(yscale="log", ylim=(9.0, 30e3))
    name_speeds(axes.yaxis)
    assert _named(axes) == {"10", "100", "1000", "10\u2009000"}


def test_a_legend_names_each_label_once(tmp_path):
    figure = new_figure(tmp_path / "a.png", ONE_COLUMN_MM)
    frames = figure.subplots(1, 2)
    for axes, labels in zip(frames, (("a", "b"), ("b", "c")), strict=True):
        for label in labels:
            axes.plot(np.arange(2), label=label)
    add_legend(figure, list(frames), "and a note")
    (legend,) = figure.legends
    assert [t.get_text() for t in legend.get_texts()] == ["a", "b", "c", "and a note"]


def test_nothing_is_written_where_nothing_has_a_label(tmp_path):
    figure = new_figure(tmp_path / "a.png")
    add_legend(figure, [figure.add_subplot()])
    assert not figure.legends
