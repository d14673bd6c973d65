"""Pictures of what a run cost, and of its checks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import fill

import numpy as np

from solidwhirl.rotordyn import Invariant
from solidwhirl.rotordyn.plots.frame import (
    COLORS,
    SMALL_PT,
    TITLE_PT,
    TWO_COLUMNS_MM,
    add_legend,
    draw_grid,
    new_figure,
    number_text,
    styled,
    write_figure,
)

# Checks with less than this part of their limit are drawn at it.
_LEAST = 1e-6


@styled
def draw_cost(timings_s: Mapping[str, float], path: Path, title: str) -> None:
    """Draw the wall time of the stages of a run as bars.

    Parameters
    ----------
    timings_s
        By stage.
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf).
    title
        Above the picture.
    """
    names = list(timings_s)
    figure = new_figure(path, TWO_COLUMNS_MM, 30.0 + 6.0 * len(names))
    axes = figure.add_subplot()
    spent = np.array([timings_s[name] for name in names])
    bars = axes.barh(range(len(names)), spent, height=0.65, color=COLORS[5], edgecolor=COLORS[0])
    axes.bar_label(bars, [f"{s:.2f} s" for s in spent], padding=3, fontsize=SMALL_PT)
    axes.set_yticks(range(len(names)), [name.replace("_", " ") for name in names])
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.set_xlim(0.0, 1.15 * float(spent.max(initial=1e-9)))
    axes.set_xlabel("wall time [s]")
    axes.set_title(fill(title, 70), fontsize=TITLE_PT)
    draw_grid(axes, "major", "x")
    write_figure(figure, path)


@styled
def draw_checks(checks: Sequence[Invariant], path: Path, title: str) -> None:
    """Draw the error of each check over its limit; left of 1 it holds.

    Parameters
    ----------
    checks
        Of the run; those without value or limit are left out.
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf).
    title
        Above the picture.
    """
    worst: dict[str, float] = {}
    for check in checks:
        if check.value is not None and check.limit is not None and check.limit > 0.0:
            share = max(check.value / check.limit, _LEAST)
            worst[check.name] = max(worst.get(check.name, 0.0), share)
    figure = new_figure(path, TWO_COLUMNS_MM, 32.0 + 5.0 * len(worst))
    axes = figure.add_subplot()
    for held, color, marker, text in (
        (True, COLORS[0], "o", "holds"),
        (False, COLORS[1], "X", "does not hold"),
    ):
        rows = [k for k, share in enumerate(worst.values()) if (share <= 1.0) == held]
        if rows:
            axes.plot([list(worst.values())[k] for k in rows], rows, linestyle="none",
                      marker=marker, color=color, markersize=6, label=text)  # fmt: skip
    axes.axvline(1.0, color="black", linewidth=1.0, linestyle=(0, (4, 2)), label="limit")
    axes.set_xscale("log")
    axes.set_yticks(range(len(worst)), [name.replace("_", " ") for name in worst])
    axes.set_ylim(len(worst) - 0.4, -0.6)
    axes.set_xlim(0.5 * _LEAST, 2.0 * max(10.0, *worst.values()))
    least = f"{number_text(_LEAST)} or less at the left end"
    axes.set_xlabel(f"error over its limit, largest of all bodies and modes [1]\n{least}")
    axes.set_title(fill(title, 50), fontsize=TITLE_PT)
    draw_grid(axes, "major", "x")
    add_legend(figure, (axes,), place="outside right center")
    write_figure(figure, path)
