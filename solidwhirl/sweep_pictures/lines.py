"""Critical speeds of a sweep against its parameters."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from solidwhirl.rotordyn.core.arrays import IntArray
from solidwhirl.rotordyn.plots.frame import (
    SMALL_PT,
    TWO_COLUMNS_MM,
    add_legend,
    draw_grid,
    name_speeds,
    new_figure,
    number_text,
    styled,
    write_figure,
)
from solidwhirl.sweep.analysis import SweepAnalysis, SweepPictureSettings
from solidwhirl.sweep.design import SweepDesign
from solidwhirl.sweep.sensitivity import ladder
from solidwhirl.sweep.tracks import CriticalTrack
from solidwhirl.sweep_pictures.parts import (
    cases_text,
    parameter_axis,
    shown_parameters,
    whirl_style,
    write_notes,
    write_title,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Parameters that have a frame of their own, and frames in one row.
_FRAMES, _ACROSS = 6, 3
# Numbers of tracks closer than this share of the frame stand together.
_LEVELS = 40.0
# Relative errors that can be seen.
_VISIBLE = 1e-3


@styled
def draw_critical_speeds(found: SweepAnalysis, settings: SweepPictureSettings, path: Path) -> None:
    """Draw critical speeds against each parameter to a picture file.

    Parameters
    ----------
    found
        One scene: of a grid the cases through the baseline are joined, samples are points.
    settings
        The operating speeds are shaded.
    path
        The file; replaced when complete.
    """
    design = found.design
    shown = shown_parameters(found)[:_FRAMES]
    across = 2 if len(shown) == 4 else min(len(shown), _ACROSS)
    down = -(-len(shown) // across)
    figure = new_figure(path, TWO_COLUMNS_MM, 104.0 if down == 1 else 72.0 * down + 16.0)
    frames = figure.subplots(down, across, sharey=True, squeeze=False)
    for axes, parameter in zip(frames.ravel(), shown, strict=False):
        if settings.operating_rpm is not None:
            axes.axhspan(*settings.operating_rpm, color="#EBD37A", alpha=0.6, linewidth=1.5,
                         zorder=0.6, label="operating speeds")  # fmt: skip
        for track in found.tracks:
            _draw_track(axes, design, track, parameter)
        _number_tracks(axes, found, parameter)
        _mark_left_out(axes, design, parameter)
        parameter_axis(axes, found, settings, parameter, "x")
        draw_grid(axes, "major", "both")
        axes.margins(x=0.12)
    for axes in frames.ravel()[len(shown) :]:
        axes.set_visible(False)
    for row in frames:
        row[0].set_ylabel("critical speed of the reference shaft [rpm]")
        name_speeds(row[0].yaxis)
    title = f"Critical speeds: {design.scene}, {cases_text(found)}"
    if design.kind == "one_at_a_time" and len(design.parameters) > 1:
        title += "; each parameter alone, the others at the baseline"
    write_title(figure, title)
    left = [design.parameters[k].name for k in shown_parameters(found)[_FRAMES:]]
    notes = [f"not shown: {', '.join(left)}"] if left else []
    errors = np.array([t.error_estimate for t in found.tracks])
    if np.isfinite(errors).any() and np.nanmax(errors) <= _VISIBLE:
        largest = number_text(float(np.nanmax(errors)), 2)
        notes.append(f"estimated errors of up to {largest} of the speed are too small to be drawn")
    write_notes(figure, [*notes, *found.notes])
    add_legend(figure, list(frames.ravel()), place="outside right center")
    write_figure(figure, path)


def _draw_track(axes: Axes, design: SweepDesign, track: CriticalTrack, parameter: int) -> None:
    style = whirl_style(track.whirl)
    joined = design.kind == "one_at_a_time"
    rows = _shown_rows(design, parameter)
    x, speed = design.values[rows, parameter], track.speed_rpm[rows]
    if not np.isfinite(speed).any():
        return
    error = track.error_estimate[rows] * speed
    size = 4.5 if joined else max(2.0, 4.0 - 0.01 * len(rows))
    line = style.dashes if joined and not design.parameters[parameter].choices else "none"
    axes.plot(x, speed, color=style.color, linestyle=line, marker=style.marker, markersize=size,
              markerfacecolor=style.face, linewidth=1.4, label=track.whirl,
              alpha=1.0 if joined else 0.7)  # fmt: skip
    known = np.isfinite(error) & np.isfinite(speed)
    if known.any() and np.nanmax(track.error_estimate[rows]) > _VISIBLE:
        axes.errorbar(x[known], speed[known], yerr=error[known], fmt="none", ecolor=style.color,
                      elinewidth=1.0, capsize=3.0 if joined else 0.0,
                      alpha=1.0 if joined else 0.5, label="estimated error")  # fmt: skip
    doubtful = track.doubtful[rows] & np.isfinite(speed)
    if doubtful.any():
        axes.plot(x[doubtful], speed[doubtful], linestyle="none", marker="o", markersize=size + 5.0,
                  markerfacecolor="none", markeredgecolor="black", label="matched in doubt",
                  zorder=4)  # fmt: skip


def _shown_rows(design: SweepDesign, parameter: int) -> IntArray:
    if design.kind == "one_at_a_time":
        return ladder(design, parameter)
    return np.arange(len(design.rows))


def _number_tracks(axes: Axes, found: SweepAnalysis, parameter: int) -> None:
    """Numbers where the tracks end, those of coinciding ones together."""
    rows = _shown_rows(found.design, parameter)
    x = found.design.values[rows, parameter]
    span = np.ptp(axes.get_ylim())
    ends: dict[tuple[float, int], list[tuple[int, float]]] = {}
    for track in found.tracks:
        known = np.flatnonzero(np.isfinite(track.speed_rpm[rows]))
        if known.size:
            last = known[np.argmax(x[known])]
            speed = float(track.speed_rpm[rows][last])
            place = float(x[last]), round(_LEVELS * speed / span)
            ends.setdefault(place, []).append((track.number, speed))
    for (end, _), same in ends.items():
        text = ", ".join(str(number) for number, _ in same)
        axes.annotate(text, (end, float(np.mean([speed for _, speed in same]))), xytext=(6, 0),
                      textcoords="offset points", fontsize=SMALL_PT, va="center",
                      annotation_clip=False)  # fmt: skip


def _mark_left_out(axes: Axes, design: SweepDesign, parameter: int) -> None:
    """Crosses on the lower edge where cases failed."""
    if design.left_out:
        axes.plot(design.left_out_values[:, parameter], np.zeros(len(design.left_out)),
                  linestyle="none", marker="x", color="black", markersize=5.5, clip_on=False,
                  transform=axes.get_xaxis_transform(), label="case left out")  # fmt: skip
