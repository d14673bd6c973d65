"""Numbers, axes and legends that all pictures share."""

from __future__ import annotations

import os
import re
import subprocess
import sys

import numpy as np
import pytest

from solidwhirl.rotordyn.plots.frame import (
    ONE_COLUMN_MM,
    add_legend,
    name_speeds,
    new_figure,
    number_text,
    picture,
    plain_power,
    thousands,
)


def test_numbers_have_powers_of_ten_and_speeds_groups_of_digits():
    for value, text in {
        0.0: "0",
        0.05: "0.05",
        123.4: "123",
        -2.5: "\u22122.5",
        5.0118e8: "5.01×10⁸",
        1e5: "10⁵",
        3.7e-4: "3.7×10⁻⁴",
        -1.2e-7: "\u22121.2×10⁻⁷",
    }.items():
        assert number_text(value) == text
    assert number_text(37414.0, 5) == "37414"
    assert number_text(3.7414e-4, 5) == "3.7414×10⁻⁴"
    speeds = {7500.0: "7500", 12500.0: "12\u2009500", -20000.0: "\u221220\u2009000", 0.5: "0.5"}
    assert [thousands(value) for value in speeds] == [*speeds.values()]


def _named(axes):
    axes.figure.draw_without_rendering()
    low, high = axes.get_ylim()
    labels = [*axes.yaxis.get_majorticklabels(), *axes.yaxis.get_minorticklabels()]
    return {t.get_text() for t in labels if t.get_text() and low <= t.get_position()[1] <= high}


@pytest.mark.parametrize(
    ("low", "named"),
    [(900.0, {"1000", "2000", "5000", "10\u2009000", "20\u2009000"}),
     (9.0, {"10", "100", "1000", "10\u2009000"})],
)  # fmt: skip
def test_two_and_five_are_named_on_a_short_logarithmic_axis(tmp_path, low, named):
    axes = new_figure(tmp_path / "a.png").add_subplot()
    axes.set(yscale="log", ylim=(low, 30e3))
    name_speeds(axes.yaxis)
    assert _named(axes) == named


def test_a_legend_names_each_label_once(tmp_path):
    figure = new_figure(tmp_path / "a.png", ONE_COLUMN_MM)
    frames = figure.subplots(1, 2)
    for axes, labels in zip(frames, (("a", "b"), ("b", "c")), strict=True):
        for label in labels:
            axes.plot(np.arange(2), label=label)
    add_legend(figure, list(frames), "and a note")
    (legend,) = figure.legends
    assert [t.get_text() for t in legend.get_texts()] == ["a", "b", "c", "and a note"]
    bare = new_figure(tmp_path / "b.png")
    add_legend(bare, [bare.add_subplot()])
    assert not bare.legends


HOSTILE = ("Price $1_$2", r"100 $\unknown$", r"$\frac{$ \$ 100 %_^{}", "$", "質量 $m_{$")


def _texts(path):
    return re.findall(r">([^<]+)</text>", path.read_text("utf-8"))


@pytest.mark.parametrize("text", HOSTILE)
def test_dollars_are_dollars_in_any_text(tmp_path, text):
    file = tmp_path / "a.svg"
    with picture(file, text) as (figure, axes):
        axes.plot([0.0, 1.0], [0.0, 1.0], label=text)
        axes.set(xlabel=text, ylabel=text)
        axes.set_xticks([0.0, 1.0], [text, text])
        axes.annotate(text, (0.5, 0.5))
        figure.suptitle(text)
        add_legend(figure, [axes], note=text + " ")
    assert sum(found.strip() == text for found in _texts(file)) == 9


def test_numbers_of_axes_have_plain_powers(tmp_path):
    file = tmp_path / "a.svg"
    with picture(file, "") as (figure, axes):
        axes.plot([1e-9, 1e-3], [-1e8, 5e8])
        axes.set(xscale="log")
        figure.colorbar(axes.imshow([[1e-7, 2e-7]], extent=(1e-9, 1e-3, -1e8, 5e8), aspect="auto"))
    found = _texts(file)
    assert {"10⁻⁹", "10⁻³", "×10⁸", "×10⁻⁷"} <= {*found}
    assert not [text for text in found if "$" in text or "mathdefault" in text]


def test_formulas_of_numbers_become_letters():
    assert plain_power(r"$\mathdefault{2\times10^{-3}}$") == "2×10⁻³"
    assert plain_power("$\\times\\mathdefault{10^{\u22127}}\\mathdefault{+1}$") == "×10⁻⁷+1"
    assert plain_power("0.5") == "0.5"


def test_settings_and_backends_of_the_user_change_no_picture(tmp_path):
    """A backend that there is not, text by LaTeX, another size of letters."""
    (tmp_path / "matplotlibrc").write_text("text.usetex: True\nfont.size: 30\nlines.color: red\n")
    code = (
        "from solidwhirl.rotordyn.plots.frame import picture\n"
        "with picture('a.svg', 'a') as (figure, axes):\n    axes.plot([1, 2], [3, 4])"
    )
    pictures = []
    for folder, backend in ((tmp_path, "bogus"), (tmp_path / "plain", "agg")):
        folder.mkdir(exist_ok=True)
        paths = os.pathsep.join(filter(None, sys.path))
        environment = {**os.environ, "MPLBACKEND": backend, "PYTHONPATH": paths}
        command = [sys.executable, "-c", code]
        subprocess.run(command, cwd=folder, env=environment, check=True, timeout=120)
        pictures.append((folder / "a.svg").read_text("utf-8"))
    assert pictures[0] == pictures[1]
