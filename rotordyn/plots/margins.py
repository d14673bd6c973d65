"""Picture of separation margins."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.plots.frame import (
    SMALL_PT,
    Style,
    add_legend,
    draw_grid,
    picture,
    styled,
)
from solidwhirl.rotordyn.response.separation_margins import SeparationMargin

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Resonances drawn, and their largest distance.
_ROWS, _FARTHEST = 24, 0.6
_VERDICTS = {
    "ok": Style("#0072B2", "solid", "o"),
    "inside margin": Style("#D55E00", "solid", "X"),
    "unstable": Style("black", "solid", "*"),
}


@styled
def draw_separation_margins(
    margins: Sequence[SeparationMargin], path: str | Path, title: str
) -> None:
    """Draw the distances of resonances from operating speeds to a picture file.

    Arguments `path` and `title`, and the error of a wrong suffix, as in `draw_campbell`.

    Parameters
    ----------
    margins
        Of any number of shafts; those farther than 60 % away are counted, not drawn, and at most
        24 are drawn, the nearest.

    Raises
    ------
    AnalysisError
        If there are no margins.
    """
    if not margins:
        raise AnalysisError("there are no margins to draw")
    near = sorted((m for m in margins if abs(m.margin) <= _FARTHEST), key=lambda m: abs(m.margin))
    shown = sorted(near[:_ROWS], key=lambda m: (m.shaft, m.resonance.speed_rad_s))
    with picture(path, title, 34.0 + 6.0 * len(shown), 50) as (figure, axes):
        for limit, dashes in ((15.0, (0, (4, 2))), (20.0, (0, (1, 1)))):
            for side in (-1, 1):
                axes.axvline(side * limit, color="#595959", linewidth=0.9, linestyle=dashes,
                             label=f"±{limit:.0f} %")  # fmt: skip
        axes.axvline(0.0, color="black", linewidth=1.0)
        for row, item in enumerate(shown):
            _draw_margin(axes, row, item)
        axes.set_yticks(range(len(shown)), [_row_name(item) for item in shown], fontsize=SMALL_PT)
        axes.set_ylim(len(shown) - 0.4, -0.6)
        axes.set_xlim(-100 * _FARTHEST - 4, 100 * _FARTHEST + 4)
        axes.set_ylabel("critical speed, whirl,\namplification factor AF [1]")
        axes.set_xlabel("distance from the operating range of the shaft [%]")
        draw_grid(axes, "major", "x")
        left_out = len(margins) - len(shown)
        add_legend(figure, (axes,), f"{left_out} more, farther away" if left_out else "")


def _row_name(item: SeparationMargin) -> str:
    resonance = item.resonance
    whirl = f" {resonance.whirl}" if resonance.whirl else ""
    factor = resonance.amplification_factor
    height = "AF ∞" if np.isinf(factor) else f"AF {factor:.1f}"
    return f"{item.shaft}: {resonance.speed_rad_s * RPM_PER_RAD_S:.0f} rpm{whirl}, {height}"


def _draw_margin(axes: Axes, row: int, item: SeparationMargin) -> None:
    """Draw one resonance and the margin asked for on its side."""
    asked = item.required_api_617
    sides = {"below": (-1,), "above": (1,), "inside": (-1, 1)}[item.position]
    for side in sides:
        if np.isfinite(asked) and asked > 0:
            axes.barh(row, side * 100 * asked, height=0.5, color="#EBD37A", zorder=1.2,
                      label="asked by API 617")  # fmt: skip
    style = _VERDICTS[item.verdict_api_617]
    axes.plot([0.0, 100 * item.margin], [row, row], color=style.color, linewidth=1.0, zorder=2)
    axes.plot(
        100 * item.margin,
        row,
        marker=style.marker,
        color=style.color,
        markersize=7,
        linestyle="none",
        zorder=3,
        label=item.verdict_api_617,
    )
