"""Pictures of error estimates: Campbell diagrams with bands, critical speeds with bars."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.arrays import FloatArray, StringArray
from solidwhirl.rotordyn.campbell_errors import CampbellErrors
from solidwhirl.rotordyn.critical_speed_errors import CriticalSpeedErrors
from solidwhirl.rotordyn.critical_speeds import CriticalSpeed
from solidwhirl.rotordyn.error_forms import NOT_SUMMED
from solidwhirl.rotordyn.errors import AnalysisError
from solidwhirl.rotordyn.picture_frame import (
    SMALL_PT,
    TITLE_PT,
    TWO_COLUMNS_MM,
    WHIRL_STYLES,
    Style,
    add_legend,
    draw_grid,
    name_speeds,
    new_figure,
    styled,
    write_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

IntArray = npt.NDArray[np.int_]

_RPM = 30.0 / np.pi
# Relative errors below this are not drawn: they are rounding.
_LEAST = 1e-12
# Critical speeds drawn, from the lowest.
_ROWS = 24
# Okabe and Ito without the colours of whirl, told apart by dashes and markers too.
_PART_STYLES = {
    "mesh": Style("#8C510A", "solid", "o"),
    "circumferential": Style("#56B4E9", (0, (5, 2)), "s"),
    "mode_truncation": Style("#CC79A7", (0, (6, 2, 1, 2)), "^"),
    "speed_interpolation": Style("#E69F00", (0, (1, 1)), "v"),
    "interface_coupling": Style("#7F7F7F", (0, (3, 1, 1, 1)), "P"),
    "beam_theory": Style("#882255", (0, (4, 1)), "X"),
    "eigen_solver": Style("#999999", (0, (1, 2)), "."),
}
_TOTAL_STYLE = Style("#000000", "solid", "D")


@styled
def draw_campbell_errors(
    errors: CampbellErrors,
    path: str | Path,
    title: str,
    excitation_ratios: Mapping[str, float] | None = None,
) -> None:
    """Draw a Campbell diagram with error bands, and the estimates over the speed below it.

    Parameters
    ----------
    errors
        The diagram with its estimates. Bands are frequency · (1 ± total); below, the largest
        estimate of all branches at each speed by part, and the total of every branch (thin).
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf). Replaced when complete.
    title
        Above the diagram; bodies without an estimate are named below it.
    excitation_ratios
        Ratio of each excitation line by name, |ratio| · Ω; None for no lines.

    Raises
    ------
    AnalysisError
        If the suffix is not a kind of picture that can be written.
    """
    figure = new_figure(path, TWO_COLUMNS_MM, 157.0)
    axes, strip = figure.subplots(2, 1, sharex=True, height_ratios=[1.7, 1.0])
    campbell = errors.campbell
    rpm = campbell.speeds_rad_s * _RPM
    for frequency, whirl, total in zip(
        campbell.frequency_hz, campbell.whirl, errors.total, strict=True
    ):
        _draw_branch(axes, rpm, frequency, whirl, total)
    widest = campbell.frequency_hz * (1.0 + np.minimum(errors.total, 0.2))
    top = 1.05 * (float(np.nanmax(widest, initial=0.0)) or 1.0)
    names: dict[float, list[str]] = {}
    for name, ratio in (excitation_ratios or {}).items():
        names.setdefault(abs(ratio), []).append(name)
    for ratio, same in names.items():
        _draw_excitation(axes, rpm, top, ", ".join(same), ratio)
    axes.set_ylim(0.0, top)
    axes.set_xlim(float(rpm.min()), max(float(rpm.max()), float(rpm.min()) + 1.0))
    axes.set_ylabel("natural frequency [Hz]")
    axes.set_title(fill(title, 60), pad=18.0, fontsize=TITLE_PT)
    _draw_estimates(strip, rpm, errors)
    strip.set_xlabel(_with_gaps("speed of the reference shaft [rpm]", errors))
    name_speeds(strip.xaxis)
    figure.align_ylabels()
    for frame in (axes, strip):
        draw_grid(frame, "major", "both")
    add_legend(figure, (axes, strip))
    write_figure(figure, path)


@styled
def draw_critical_speed_errors(
    critical_speeds: Sequence[CriticalSpeed],
    errors: CriticalSpeedErrors,
    path: str | Path,
    title: str,
) -> None:
    """Draw critical speeds with error bars, and beside them the estimates by part.

    Parameters
    ----------
    critical_speeds
        One or more; the first 24 by speed are drawn.
    errors
        Their estimates.
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf). Replaced when complete.
    title
        Above the picture.

    Raises
    ------
    AnalysisError
        If there are no critical speeds, the estimates are of another number of them, or the
        suffix is not a kind of picture that can be written.
    """
    if not critical_speeds or errors.total.size != len(critical_speeds):
        raise AnalysisError(
            f"there are {len(critical_speeds)} critical speeds and {errors.total.size} estimates; "
            "one or more with an estimate each are needed"
        )
    speed = np.array([c.speed_rad_s for c in critical_speeds]) * _RPM
    order = np.argsort(speed, kind="stable")[:_ROWS]
    rows = np.arange(order.size)
    figure = new_figure(path, TWO_COLUMNS_MM, 50.0 + 5.5 * order.size)
    axes, side = figure.subplots(1, 2, sharey=True, width_ratios=[1.0, 1.1])
    for row, place in zip(rows, order, strict=True):
        style = WHIRL_STYLES.get(critical_speeds[place].whirl, _TOTAL_STYLE)
        axes.errorbar(speed[place], row, xerr=speed[place] * errors.total[place], fmt=style.marker,
                      markerfacecolor=style.face, color=style.color, capsize=3.0, markersize=4.5,
                      label=critical_speeds[place].whirl)  # fmt: skip
    names = [f"{speed[k]:.0f} rpm, {critical_speeds[k].frequency_hz:.1f} Hz" for k in order]
    axes.set_yticks(rows, names, fontsize=SMALL_PT)
    axes.set_ylim(order.size - 0.4, -0.6)
    axes.set_xlim(0.0, 1.08 * float((speed * (1.0 + errors.total))[order].max()))
    axes.locator_params(axis="x", nbins=5)
    name_speeds(axes.xaxis)
    axes.set_xlabel("critical speed with\nits estimated error [rpm]")
    _draw_parts_of_rows(side, rows, order, errors)
    side.set_xlabel(_with_gaps("estimated relative error [1]", errors))
    figure.suptitle(fill(title, 60), fontsize=TITLE_PT)
    for frame in (axes, side):
        draw_grid(frame, "major", "both")
    add_legend(figure, (axes, side), place="outside right center")
    write_figure(figure, path)


def _draw_branch(
    axes: Axes, rpm: FloatArray, frequency: FloatArray, whirl: StringArray, total: FloatArray
) -> None:
    """Draw one branch in runs of equal whirl, with its band; a step has that of its faster end."""
    step = np.where(whirl[1:] == "", whirl[:-1], whirl[1:])
    start = 0
    for stop in range(1, step.size + 1):
        if stop < step.size and step[stop] == step[start]:
            continue
        style = WHIRL_STYLES.get(str(step[start]))
        if style is not None:
            run = slice(start, stop + 1)
            axes.plot(rpm[run], frequency[run], color=style.color, linestyle=style.dashes,
                      linewidth=1.2, label=str(step[start]))  # fmt: skip
            low, high = (frequency[run] * (1.0 + sign * total[run]) for sign in (-1.0, 1.0))
            axes.fill_between(rpm[run], low, high, color=style.color, alpha=0.25, linewidth=0.0)
        start = stop


def _draw_excitation(axes: Axes, rpm: FloatArray, top: float, name: str, ratio: float) -> None:
    """Draw the line |ratio| · Ω, named outside the frame where it leaves it."""
    if ratio == 0:
        return
    fastest = float(rpm.max())
    end = min(fastest, 60.0 * top / ratio)
    right = end == fastest
    axes.plot([0.0, end], [0.0, ratio * end / 60.0], color="black", linewidth=0.8, zorder=1.5)
    axes.annotate(
        f"{ratio:g}× {name}",
        (end, ratio * end / 60.0),
        xytext=(4, 0) if right else (0, 4),
        textcoords="offset points",
        ha="left" if right else "center",
        va="center" if right else "bottom",
        fontsize=SMALL_PT,
        annotation_clip=False,
    )


def _draw_estimates(axes: Axes, rpm: FloatArray, errors: CampbellErrors) -> None:
    """Draw the total of each branch thin, and the largest of all branches by part."""
    for total in errors.total:
        axes.plot(rpm, _visible(total), color="#BBBBBB", linewidth=0.7, label="total of a branch")
    for part, values in errors.parts.items():
        if not (values > _LEAST).any():
            continue
        _draw_line(axes, rpm, _largest(values), _PART_STYLES[part], _part_name(part))
    _draw_line(axes, rpm, _largest(errors.total), _TOTAL_STYLE, "total")
    _log_scale(axes, "y", errors.total, errors.parts)
    axes.set_ylabel("estimated relative error,\nlargest of all branches [1]")


def _draw_line(axes: Axes, rpm: FloatArray, values: FloatArray, style: Style, name: str) -> None:
    axes.plot(rpm, _visible(values), color=style.color, linestyle=style.dashes, linewidth=1.5,
              marker=style.marker, markersize=3.5, markevery=max(1, rpm.size // 8),
              label=name)  # fmt: skip


def _draw_parts_of_rows(
    axes: Axes, rows: IntArray, order: IntArray, errors: CriticalSpeedErrors
) -> None:
    """Mark the estimates of each row by part, and the total."""
    whole = {part: (_PART_STYLES[part], values) for part, values in errors.parts.items()}
    for part, (style, values) in {**whole, "total": (_TOTAL_STYLE, errors.total)}.items():
        if not (values[order] > _LEAST).any():
            continue
        hollow = "none" if part == "total" else style.color
        axes.plot(_visible(values[order]), rows, linestyle="none", marker=style.marker,
                  color=style.color, markerfacecolor=hollow, markersize=6,
                  label=_part_name(part))  # fmt: skip
    _log_scale(axes, "x", errors.total[order], errors.parts)


def _part_name(part: str) -> str:
    return part.replace("_", " ") + (" (not summed)" if part in NOT_SUMMED else "")


def _largest(values: FloatArray) -> FloatArray:
    """Return the largest of all branches at each speed, nan where all are absent."""
    return np.asarray(np.fmax.reduce(values, axis=0, initial=np.nan))


def _visible(values: FloatArray) -> FloatArray:
    return np.where(values > _LEAST, values, np.nan)


def _log_scale(axes: Axes, axis: str, total: FloatArray, parts: Mapping[str, FloatArray]) -> None:
    """Set a log scale over whole decades that holds all that is drawn."""
    drawn = np.concatenate([total.ravel(), *[values.ravel() for values in parts.values()]])
    drawn = drawn[np.isfinite(drawn) & (drawn > _LEAST)]
    ends = (drawn.min(), drawn.max()) if drawn.size else (_LEAST, 1.0)
    low, high = 10.0 ** np.floor(np.log10(ends[0])), 10.0 ** np.ceil(np.log10(ends[1]))
    limits = (low, max(high, 10.0 * low))
    if axis == "x":
        axes.set_xscale("log")
        axes.set_xlim(*limits)
    else:
        axes.set_yscale("log")
        axes.set_ylim(*limits)


def _with_gaps(label: str, errors: CampbellErrors | CriticalSpeedErrors) -> str:
    """Return a label that names the bodies without an estimate below it."""
    missing = errors.bodies_without_estimate
    return label + (f"\nno estimate for {', '.join(missing)}" if missing else "")
