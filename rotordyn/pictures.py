"""Pictures of results; matplotlib is imported inside the functions that draw."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray, StringArray
from solidwhirl.rotordyn.campbell import Campbell
from solidwhirl.rotordyn.critical_speeds import CriticalSpeed
from solidwhirl.rotordyn.picture_frame import (
    SMALL_PT,
    TITLE_PT,
    TWO_COLUMNS_MM,
    WHIRL_STYLES,
    Style,
    draw_grid,
    name_speeds,
    new_figure,
    styled,
    write_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_RPM = 30.0 / np.pi
_SPEED_LABEL = "speed of the reference shaft, with which forward whirl turns [rpm]"
_OPERATING = "operating speed"
# Critical speeds listed beside the diagram.
_LISTED = 14
# Decrements above this, close to critical damping, would flatten all others.
_LARGEST_DECREMENT = 2.0


# Marks of notes on branches, and lines of notes on the whole diagram with their text.
_MARKS = {
    "crossing": Style("#7F7F7F", "none", "x"),
    "veering": Style("#CC79A7", "none", "s"),
    "ambiguous": Style("#000000", "none", "*"),
    "begun": Style("#000000", "none", "<"),
    "ended": Style("#000000", "none", ">"),
}
_LIMITS = {
    "range": Style("#000000", (0, (4, 3)), "end of the basis"),
    "indefinite": Style("#CC79A7", (0, (1, 2)), "stiffness indefinite"),
}


@styled
def draw_campbell(
    campbell: Campbell,
    critical_speeds: Sequence[CriticalSpeed],
    path: str | Path,
    title: str,
    excitation_ratios: Mapping[str, float],
    operating_rad_s: Mapping[str, tuple[float, float]] | None = None,
) -> None:
    """Draw a Campbell diagram to a picture file.

    Parameters
    ----------
    campbell
        The branches. Their whirl shows by colour, dashes and marker.
    critical_speeds
        Marked by circles and listed beside the diagram with their speed in rpm.
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf). Replaced when complete.
    title
        Above the diagram.
    excitation_ratios
        Ratio of each excitation line by name, such as the speed ratio of each shaft; the line is
        |ratio| · Ω. Lines of equal |ratio| are drawn once with all their names.
    operating_rad_s
        Lowest and highest operating speed by name, as speeds of the reference shaft, drawn as
        hatched bands; equal ones as a line. None draws none.

    Raises
    ------
    AnalysisError
        If the suffix is not a kind of picture that can be written.
    """
    figure = new_figure(path)
    axes = figure.add_subplot()
    _draw_diagram(axes, campbell, critical_speeds, title, excitation_ratios)
    _draw_operating(axes, operating_rad_s or {})
    axes.set_xlabel(_SPEED_LABEL)
    _add_legend(figure, axes, critical_speeds)
    write_figure(figure, path)


@styled
def draw_annotated_campbell(
    campbell: Campbell,
    critical_speeds: Sequence[CriticalSpeed],
    path: str | Path,
    title: str,
    excitation_ratios: Mapping[str, float],
    operating_rad_s: Mapping[str, tuple[float, float]] | None = None,
) -> None:
    """Draw a Campbell diagram with marks where branches cross, veer, end or are in doubt.

    Parameters
    ----------
    campbell, critical_speeds, path, title, excitation_ratios, operating_rad_s
        As in `draw_campbell`; the marks are those of `campbell.notes`.

    Raises
    ------
    AnalysisError
        If the suffix is not a kind of picture that can be written.
    """
    figure = new_figure(path)
    axes = figure.add_subplot()
    _draw_diagram(axes, campbell, critical_speeds, title, excitation_ratios)
    _draw_operating(axes, operating_rad_s or {})
    _draw_notes(axes, campbell)
    axes.set_xlabel(_SPEED_LABEL)
    _add_legend(figure, axes, critical_speeds)
    write_figure(figure, path)


@styled
def draw_damped_campbell(
    campbell: Campbell,
    critical_speeds: Sequence[CriticalSpeed],
    path: str | Path,
    title: str,
    excitation_ratios: Mapping[str, float],
    operating_rad_s: Mapping[str, tuple[float, float]] | None = None,
) -> None:
    """Draw an annotated Campbell diagram with the logarithmic decrements below it.

    Parameters
    ----------
    campbell, critical_speeds, path, title, excitation_ratios, operating_rad_s
        As in `draw_campbell`. Decrements above 2 leave the strip, which says so; the range
        below zero, where a mode grows by itself, is shaded.

    Raises
    ------
    AnalysisError
        If the suffix is not a kind of picture that can be written.
    """
    figure = new_figure(path, TWO_COLUMNS_MM, 157.0)
    axes, strip = figure.subplots(2, 1, sharex=True, height_ratios=[2.4, 1.0])
    _draw_diagram(axes, campbell, critical_speeds, title, excitation_ratios)
    _draw_operating(axes, operating_rad_s or {})
    _draw_notes(axes, campbell)
    _draw_decrements(strip, campbell)
    strip.set_xlabel(_SPEED_LABEL)
    figure.align_ylabels()
    _add_legend(figure, axes, critical_speeds)
    write_figure(figure, path)


def _draw_diagram(
    axes: Axes,
    campbell: Campbell,
    critical_speeds: Sequence[CriticalSpeed],
    title: str,
    excitation_ratios: Mapping[str, float],
) -> None:
    """Draw branches, excitation lines and critical speeds."""
    rpm = campbell.speeds_rad_s * _RPM
    # without a branch the excitation lines make the frame
    highest = float(np.nanmax(campbell.frequency_hz, initial=0.0))
    top = 1.08 * (highest or max(float(rpm.max()) / 60.0, 1.0))
    for frequency, whirl in zip(campbell.frequency_hz, campbell.whirl, strict=True):
        _draw_branch(axes, rpm, frequency, whirl)
    _draw_excitations(axes, rpm, top, excitation_ratios)
    _draw_critical_speeds(axes, critical_speeds, float(rpm.max()), top)
    axes.set_xlim(float(rpm.min()), max(float(rpm.max()), float(rpm.min()) + 1.0))
    axes.set_ylim(0.0, top)
    name_speeds(axes.xaxis)
    axes.set_ylabel("natural frequency [Hz]")
    # Room between the frame and the title for lines that leave at the top.
    axes.set_title(fill(title, 60), pad=20.0, fontsize=TITLE_PT)
    draw_grid(axes)


def _draw_operating(axes: Axes, operating_rad_s: Mapping[str, tuple[float, float]]) -> None:
    """Hatch the operating speeds inside the frame."""
    for low, high in dict.fromkeys(operating_rad_s.values()):
        if low == high:
            axes.axvline(low * _RPM, color="#8A8A8A", linewidth=2.4, zorder=0.4, label=_OPERATING)
            continue
        axes.axvspan(
            low * _RPM,
            high * _RPM,
            facecolor="#EFEFEF",
            edgecolor="#B5B5B5",
            hatch="///",
            linewidth=0.0,
            zorder=0.4,
            label=_OPERATING,
        )


def _draw_notes(axes: Axes, campbell: Campbell) -> None:
    """Mark the places of the notes: on the branches, or as a line across where all are meant."""
    order = np.argsort(campbell.speeds_rad_s)
    speeds = campbell.speeds_rad_s[order]
    for kind, mark in _MARKS.items():
        places = []
        for note in campbell.notes:
            if note.kind == kind and note.branches:
                values = campbell.frequency_hz[list(note.branches)][:, order]
                found = [_frequency_near(speeds, row, note.speed_rad_s) for row in values]
                places.append((note.speed_rad_s * _RPM, float(np.mean(found))))
        if places:
            axes.plot(
                *np.array(places).T,
                linestyle="none",
                marker=mark.marker,
                markersize=7,
                markerfacecolor="none",
                markeredgecolor=mark.color,
                markeredgewidth=1.3,
                zorder=3.5,
                label=kind,
            )
    for kind, line in _LIMITS.items():
        across = [n.speed_rad_s * _RPM for n in campbell.notes if n.kind == kind]
        for place, speed in enumerate(across):
            axes.axvline(
                speed,
                color=line.color,
                linestyle=line.dashes,
                linewidth=1.0,
                label=line.marker if place == 0 else None,
            )


def _frequency_near(speeds: FloatArray, frequency: FloatArray, speed: float) -> float:
    """Return the frequency of a branch at a speed, its last one where it has ended."""
    alive = np.isfinite(frequency)
    return float(np.interp(speed, speeds[alive], frequency[alive]))


def _draw_decrements(axes: Axes, campbell: Campbell) -> None:
    """Draw the logarithmic decrements and shade where they are negative."""
    rpm = campbell.speeds_rad_s * _RPM
    for decrement, whirl in zip(campbell.log_decrement, campbell.whirl, strict=True):
        _draw_branch(axes, rpm, decrement, whirl)
    largest, smallest = (
        float(f(campbell.log_decrement, initial=0.0)) for f in (np.nanmax, np.nanmin)
    )
    top = 1.08 * min(max(largest, 1e-3), _LARGEST_DECREMENT)
    bottom = min(1.2 * smallest, -0.08 * top)
    axes.axhspan(bottom, 0.0, color="#F6D5C5", zorder=0.5)
    axes.axhline(0.0, color="black", linewidth=0.8)
    axes.set_ylim(bottom, top)
    if largest > top:
        axes.text(
            0.995,
            0.96,
            f"up to {largest:.3g}, above {_LARGEST_DECREMENT:g} not shown",
            transform=axes.transAxes,
            ha="right",
            va="top",
            fontsize=SMALL_PT,
        )
    axes.set_ylabel("log. decrement [1]")
    draw_grid(axes)


def _draw_branch(axes: Axes, rpm: FloatArray, frequency: FloatArray, whirl: StringArray) -> None:
    """Draw one branch in runs of equal whirl; a step has the whirl of its faster end."""
    step = np.where(whirl[1:] == "", whirl[:-1], whirl[1:])
    start = 0
    for stop in range(1, step.size + 1):
        if stop < step.size and step[stop] == step[start]:
            continue
        style = WHIRL_STYLES.get(str(step[start]))
        if style is not None:
            axes.plot(
                rpm[start : stop + 1],
                frequency[start : stop + 1],
                color=style.color,
                linestyle=style.dashes,
                linewidth=1.6,
                marker=style.marker,
                markerfacecolor=style.face,
                markersize=3.5,
                markevery=max(1, rpm.size // 10),
                label=str(step[start]),
            )
        start = stop


def _draw_excitations(axes: Axes, rpm: FloatArray, top: float, ratios: Mapping[str, float]) -> None:
    """Draw the lines |ratio| · Ω, named outside the frame where they leave it."""
    names: dict[float, list[str]] = {}
    for name, ratio in ratios.items():
        if ratio != 0:
            names.setdefault(abs(ratio), []).append(name)
    for ratio, same in names.items():
        fastest = float(rpm.max())
        end = min(fastest, 60.0 * top / ratio)
        height = ratio * end / 60.0
        axes.plot([0.0, end], [0.0, height], color="black", linewidth=0.8, zorder=1.5)
        leaves_right = end == fastest
        axes.annotate(
            f"{ratio:g}× " + ", ".join(same),
            (end, height),
            xytext=(4, 0) if leaves_right else (0, 4),
            textcoords="offset points",
            ha="left" if leaves_right else "center",
            va="center" if leaves_right else "bottom",
            fontsize=SMALL_PT,
            annotation_clip=False,
        )


def _draw_critical_speeds(
    axes: Axes, critical_speeds: Sequence[CriticalSpeed], rpm_max: float, top: float
) -> None:
    """Draw a circle at each critical speed inside the frame."""
    shown = [
        (critical.speed_rad_s * _RPM, critical.frequency_hz)
        for critical in critical_speeds
        if critical.speed_rad_s * _RPM <= rpm_max and critical.frequency_hz <= top
    ]
    if shown:
        axes.plot(
            [speed for speed, _ in shown],
            [frequency for _, frequency in shown],
            linestyle="none",
            marker="o",
            markersize=8,
            markerfacecolor="none",
            markeredgecolor="black",
            zorder=4,
            label="critical speed",
        )


def _add_legend(figure: Figure, axes: Axes, critical_speeds: Sequence[CriticalSpeed]) -> None:
    """Put the whirl directions and the list of critical speeds beside the diagram."""
    from matplotlib.lines import Line2D

    handles, labels = axes.get_legend_handles_labels()
    known = dict(zip(labels, handles, strict=True))
    limits = (line.marker for line in _LIMITS.values())
    shown = (*WHIRL_STYLES, "critical speed", _OPERATING, *_MARKS, *limits)
    rows = [(name, known[name]) for name in shown if name in known]
    nothing = Line2D([], [], linestyle="none")
    if critical_speeds:
        rows += [("", nothing), ("critical speeds [rpm]", nothing)]
    rows += [
        (f"{critical.speed_rad_s * _RPM:.0f}  {critical.whirl}", nothing)
        for critical in sorted(critical_speeds, key=lambda c: c.speed_rad_s)[:_LISTED]
    ]
    if len(critical_speeds) > _LISTED:
        rows.append((f"and {len(critical_speeds) - _LISTED} more", nothing))
    figure.legend(
        [handle for _, handle in rows],
        [name for name, _ in rows],
        loc="outside right upper",
        frameon=False,
        fontsize=SMALL_PT,
    )
