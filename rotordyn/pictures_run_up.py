"""Pictures of a run-up: speeds and forces over time, normalised responses, and spectrograms."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.errors import AnalysisError
from solidwhirl.rotordyn.force_spectrum import Spectrogram
from solidwhirl.rotordyn.picture_frame import (
    COLORS,
    DASHES,
    SMALL_PT,
    SUPERSCRIPTS,
    TEXT_PT,
    TITLE_PT,
    draw_grid,
    name_speeds,
    new_figure,
    styled,
    write_figure,
)
from solidwhirl.rotordyn.run_up_record import RunUp
from solidwhirl.rotordyn.run_up_response import NormalisedResponse

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_RPM = 30.0 / np.pi
# Colours and dashes of curves.
_STYLES = tuple(zip(COLORS[:7], DASHES, strict=True))
# Columns of the picture into which a long record is gathered.
_COLUMNS = 1600
# Amplitudes below this share of the largest have the darkest colour.
_DARKEST = 1e-4


@styled
def draw_run_up(run: RunUp, bearing: str, path: str | Path, title: str) -> None:
    """Draw the speed of all spools and the force through one bearing over time.

    Parameters
    ----------
    run
        The record.
    bearing
        Its name; the force on its second side, or the ground, is shown.
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf). Replaced when complete.
    title
        Above the picture.

    Raises
    ------
    AnalysisError
        If the force was not recorded or the suffix is not a kind of picture that can be written.
    """
    force = run.bearing_force_n(bearing)
    figure = new_figure(path)
    panels = figure.subplots(3, 1, sharex=True)
    _draw_speeds(panels[0], run)
    unit, factor = _force_unit(force[:2])
    for panel, axis, values, (color, _) in zip(panels[1:], "xy", force, _STYLES, strict=False):
        times, low, high = _envelope(run.time_s, factor * values)
        panel.fill_between(times, low, high, color=color, linewidth=0.3)
        panel.set_ylabel(f"force on {bearing}\nalong {axis} [{unit}]")
        draw_grid(panel)
    panels[2].set_xlabel("time [s]")
    panels[2].set_xlim(0.0, float(run.time_s[-1]))
    figure.suptitle(fill(title, 80), fontsize=TITLE_PT)
    figure.align_ylabels()
    write_figure(figure, path)


@styled
def draw_normalised_responses(
    responses: Mapping[str, NormalisedResponse],
    path: str | Path,
    title: str,
    frequency_max_hz: float | None = None,
) -> None:
    """Draw force per excitation force over the frequency, one curve for each model.

    Parameters
    ----------
    responses
        By the name of the model, or of the body whose order is shown.
    path, title
        See `draw_run_up`.
    frequency_max_hz
        End of the frequency axis; None goes as far as the responses.

    Raises
    ------
    AnalysisError
        If there is nothing to draw or the suffix is not a kind of picture that can be written.
    """
    if not responses or not any(np.isfinite(r.ratio).any() for r in responses.values()):
        raise AnalysisError("there is no response to draw")
    figure = new_figure(path)
    axes = figure.add_subplot()
    top = 0.0
    for at, (name, response) in enumerate(responses.items()):
        color, dashes = _STYLES[at % len(_STYLES)]
        known = np.isfinite(response.ratio) & (response.ratio > 0)
        frequency = response.frequency_hz[known]
        axes.plot(frequency, response.ratio[known], color=color, linestyle=dashes, linewidth=1.3,
                  label=name)  # fmt: skip
        top = max(top, float(frequency.max(initial=0.0)))
    axes.set_yscale("log")
    axes.set_xlim(0.0, top if frequency_max_hz is None else frequency_max_hz)
    axes.set_xlabel("frequency [Hz]")
    axes.set_ylabel("force per excitation force [N/N]")
    axes.set_title(fill(title, 70), fontsize=TITLE_PT)
    draw_grid(axes)
    if len(responses) > 1:
        figure.legend(loc="outside right upper", frameon=False, fontsize=SMALL_PT,
                      handlelength=3.2)  # fmt: skip
    write_figure(figure, path)


@styled
def draw_spectrogram(
    result: Spectrogram,
    run: RunUp,
    path: str | Path,
    title: str,
    frequency_max_hz: float | None = None,
) -> None:
    """Draw the short-time spectrum of a force with the 1/rev lines of all spools.

    Parameters
    ----------
    result
        Of a force in N.
    run
        The run-up it comes from, for its speeds.
    path, title
        See `draw_run_up`.
    frequency_max_hz
        End of the frequency axis; None shows all.

    Raises
    ------
    AnalysisError
        If the force is zero or the suffix is not a kind of picture that can be written.
    """
    from matplotlib.colors import LogNorm

    largest = float(result.amplitude.max())
    if not largest > 0:
        raise AnalysisError("the spectrogram is zero; there is nothing to draw")
    top = float(result.frequency_hz[-1]) if frequency_max_hz is None else frequency_max_hz
    shown = result.frequency_hz <= top
    unit, factor = _force_unit(result.amplitude)
    figure = new_figure(path)
    axes = figure.add_subplot()
    mesh = axes.pcolormesh(
        result.time_s,
        result.frequency_hz[shown],
        factor * np.maximum(result.amplitude[shown], 0.1 * _DARKEST * largest),
        norm=LogNorm(_DARKEST * factor * largest, factor * largest),
        cmap="cividis",
        shading="nearest",
        rasterized=True,
    )
    figure.colorbar(mesh, ax=axes, label=f"amplitude of the force [{unit}]", extend="min", pad=0.02)
    end = float(result.time_s[-1])
    for ratio, names in _spools(run).items():
        frequency = ratio * np.abs(run.speed_rad_s) / (2.0 * np.pi)
        times, _, line = _envelope(run.time_s, frequency)
        inside = line <= top
        axes.plot(times[inside], line[inside], color="white", linewidth=0.9, linestyle=(0, (4, 3)))
        if inside.any():
            axes.annotate(
                f"1/rev {names}",
                (end, min(float(np.interp(end, times, line)), top)),
                xytext=(4, 0),
                textcoords="offset points",
                fontsize=SMALL_PT,
                va="center",
                annotation_clip=False,
            )
    axes.set_xlim(float(result.time_s[0]), end)
    axes.set_ylim(0.0, top)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("frequency [Hz]")
    axes.set_title(fill(title, 70), fontsize=TITLE_PT)
    write_figure(figure, path)


def _draw_speeds(axes: Axes, run: RunUp) -> None:
    """Draw the speed of each body that turns, with its sign, named at the end of its line."""
    signed: dict[float, list[str]] = {}
    for name, ratio in run.speed_ratios.items():
        if ratio != 0:
            signed.setdefault(ratio, []).append(name)
    for (ratio, names), (color, dashes) in zip(signed.items(), _STYLES, strict=False):
        rpm = ratio * run.profile.speeds_rad_s * _RPM
        axes.plot(run.profile.times_s, rpm, color=color, linestyle=dashes, linewidth=1.6)
        axes.annotate(
            ", ".join(names),
            (run.profile.duration_s, float(rpm[-1])),
            xytext=(4, 0),
            textcoords="offset points",
            fontsize=TEXT_PT,
            va="center",
            annotation_clip=False,
        )
    name_speeds(axes.yaxis)
    axes.set_ylabel("speed [rpm]")
    draw_grid(axes)


def _spools(run: RunUp) -> dict[float, str]:
    """Return the names of the bodies of each |speed ratio| that turns."""
    found: dict[float, list[str]] = {}
    for name, ratio in run.speed_ratios.items():
        if ratio != 0:
            found.setdefault(abs(ratio), []).append(name)
    return {ratio: ", ".join(names) for ratio, names in found.items()}


def _envelope(times: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the least and the largest value in each column of the picture."""
    width = max(1, values.size // _COLUMNS)
    whole = values.size // width * width
    columns = values[:whole].reshape(-1, width)
    # neighbours share a sample, so that the band has no gaps
    edge = np.append(columns[1:, 0], values[whole - 1])
    low = np.minimum(columns.min(axis=1), edge)
    high = np.maximum(columns.max(axis=1), edge)
    middle = times[:whole].reshape(-1, width).mean(axis=1)
    return np.asarray(middle), np.asarray(low), np.asarray(high)


def _force_unit(force: FloatArray) -> tuple[str, float]:
    """Return a unit in which the largest force is a number of a few digits, and its factor."""
    largest = float(np.abs(force).max(initial=0.0))
    for unit, factor in (("kN", 1e-3), ("N", 1.0), ("mN", 1e3), ("µN", 1e6)):
        if largest * factor >= 1.0:
            return unit, factor
    if largest == 0.0:
        return "N", 1.0
    exponent = int(np.floor(np.log10(largest)))
    return f"10{str(exponent).translate(SUPERSCRIPTS)} N", float(f"1e{-exponent}")
