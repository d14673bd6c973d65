"""Campbell diagram of a sampled sweep: medians, bands and how sure these are."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from solidwhirl.rotordyn.plots.frame import (
    SMALL_PT,
    TWO_COLUMNS_MM,
    add_legend,
    draw_grid,
    name_speeds,
    new_figure,
    styled,
    write_figure,
)
from solidwhirl.sweep.analysis import SweepAnalysis, SweepPictureSettings
from solidwhirl.sweep.bands import LEAST_SAMPLES, CampbellBands
from solidwhirl.sweep_pictures.parts import write_notes, write_title

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Neighbours are told apart; the record of a row has no whirl of branches.
_COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
_RANGES = ("black", "#7A7A7A")
_GREY, _DOTS = "#595959", (0, (1, 1.5))


@styled
def draw_campbell_bands(found: SweepAnalysis, settings: SweepPictureSettings, path: Path) -> None:
    """Draw the bands of the branches, and the critical speeds, to a picture file."""
    bands = found.bands
    if bands is None:
        return
    figure = new_figure(path, TWO_COLUMNS_MM, 112.0)
    axes = figure.add_subplot()
    for branch in range(bands.frequency_hz.value.shape[1]):
        _draw_branch(axes, bands, branch)
    # rows of the legend in no branch's colour
    limits = f"{100 * settings.confidence:g} % confidence limits\nof the 5 and 95 % quantiles"
    axes.fill_between([], [], [], color=_GREY, alpha=0.4, linewidth=0.0, label="5 to 95 %")
    axes.plot([], [], color=_GREY, linewidth=1.6, label="median")
    axes.plot([], [], color=_GREY, linewidth=0.9, linestyle=_DOTS, label=limits)
    top = 1.06 * float(np.nanmax(bands.frequency_hz.value))
    fastest = float(bands.speed_rpm.max())
    _draw_critical(axes, found, fastest, top)
    if settings.operating_rpm is not None:
        axes.axvspan(*settings.operating_rpm, color="#EBD37A", alpha=0.6, linewidth=1.5,
                     zorder=0.6, label="operating speeds")  # fmt: skip
    axes.set_xlim(float(bands.speed_rpm.min()), fastest)
    axes.set_ylim(0.0, top)
    name_speeds(axes.xaxis)
    axes.set_xlabel("speed of the reference shaft [rpm]")
    axes.set_ylabel("natural frequency [Hz]")
    draw_grid(axes, "major", "both")
    title = f"Campbell diagram of {bands.cases} samples: {found.design.scene}"
    write_title(figure, title)
    write_notes(figure, _notes(found, bands))
    add_legend(figure, (axes,), place="outside right center")
    write_figure(figure, path)


def _draw_branch(axes: Axes, bands: CampbellBands, branch: int) -> None:
    """Median, band and the limits of its edges, where 20 samples have the branch."""
    spread = bands.frequency_hz
    enough = spread.count[branch] >= LEAST_SAMPLES
    low, middle, high = (np.where(enough, v[branch], np.nan) for v in spread.value)
    color = _COLORS[branch % len(_COLORS)]
    speed = bands.speed_rpm
    axes.fill_between(speed, low, high, color=color, alpha=0.3, linewidth=0.0)
    axes.plot(speed, middle, color=color, linewidth=1.6)
    for values in (spread.low, spread.high):
        for level in (0, -1):
            edge = np.where(enough, values[level, branch], np.nan)
            axes.plot(speed, edge, color=color, linewidth=0.9, linestyle=_DOTS)


def _draw_critical(axes: Axes, found: SweepAnalysis, fastest: float, top: float) -> None:
    """Excitation lines; critical speeds from their 5 to their 95 % quantile along them."""
    spread = found.critical_quantiles
    ratios: list[float] = []
    for number, track in enumerate(found.tracks):
        ratio = track.excitation_ratio / 60.0
        if not any(abs(ratio / r - 1.0) < 1e-3 for r in ratios):
            ratios.append(ratio)
            end = min(fastest, top / ratio)
            axes.plot([0.0, end], [0.0, ratio * end], color="black", linewidth=0.8, zorder=1.5)
            axes.annotate(f"{track.excitation_ratio:.3g}×", (end, ratio * end), xytext=(4, 4),
                          textcoords="offset points", fontsize=SMALL_PT,
                          annotation_clip=False)  # fmt: skip
        if spread is None or spread.count[number] < LEAST_SAMPLES:
            continue
        low, middle, high = spread.value[:, number]
        # ends are marked, and neighbours differ: ranges may overlap along one line
        axes.plot([low, high], [ratio * low, ratio * high], color=_RANGES[number % 2],
                  linewidth=3.0, solid_capstyle="butt", marker="|", markersize=9,
                  markeredgewidth=1.4, zorder=4 + number % 2,
                  label="critical speed, 5 to 95 %")  # fmt: skip
        axes.plot(middle, ratio * middle, linestyle="none", marker="o", markersize=5, zorder=6,
                  markerfacecolor="white", markeredgecolor="black",
                  label="critical speed, median")  # fmt: skip


def _notes(found: SweepAnalysis, bands: CampbellBands) -> list[str]:
    notes = [n for n in found.notes if "left out" in n] + list(found.band_notes)
    counts = bands.frequency_hz.count.max(axis=1)
    for branch, count in enumerate(counts):
        if count < bands.cases:
            few = ", not drawn" if count < LEAST_SAMPLES else ""
            notes.append(f"branch {branch + 1}: found in {count} of {bands.cases} samples{few}")
    doubtful = [
        f"branch {b + 1} in {n}" for b, n in enumerate(bands.doubtful)
        if n and counts[b] >= LEAST_SAMPLES
    ]  # fmt: skip
    if doubtful:
        notes.append(f"samples matched in doubt: {', '.join(doubtful)}")
    return notes
