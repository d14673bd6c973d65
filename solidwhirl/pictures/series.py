"""Pictures of numbers that results.json holds: stability, waterfall of a run-up, cost, checks."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from solidwhirl.core.outcome import Write
from solidwhirl.page.modes.stability import stability_chart
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
    thousands,
    write_figure,
)
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts
from solidwhirl.rotordyn.run_up.force_spectrum import spectrogram

if TYPE_CHECKING:
    pass

FloatArray = NDArray[np.float64]
# Length of the pieces of a waterfall, s; spectra in it, and height of the tallest over the height
# that all take.
_PIECE_S, _SPECTRA, _TALLEST = 0.25, 48, 0.16
# Checks with less than this part of their limit are drawn at it.
_LEAST = 1e-6


def draw_stability(document: Mapping[str, Any], path: Path, title: str) -> None:
    """Draw the decrements of the first modes over the speed, unstable speeds shaded.

    Parameters
    ----------
    document
        Of the analysis, as in results.json.
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf).
    title
        Above the picture.
    """
    draw_charts([stability_chart(document)], path, title)


@styled
def draw_waterfall(record: Write, top_hz: float, path: Path, title: str) -> None:
    """Draw spectra of the mount force one behind the other while the engine runs up.

    Parameters
    ----------
    record
        Writes the record of the run-up (.npz).
    top_hz
        End of the frequency axis.
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf).
    title
        Above the picture.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "record.npz"
        record(file)
        with np.load(file) as data:
            time, rpm = data["time_s"], np.abs(data["speed_rad_s"]) * 30.0 / np.pi
            force = data["mount_force_n"][0]
    pieces = spectrogram(time, force, _PIECE_S)
    shown = pieces.frequency_hz <= top_hz
    every = max(1, -(-pieces.time_s.size // _SPECTRA))
    chosen = np.arange(0, pieces.time_s.size, every)
    height = pieces.amplitude[np.ix_(np.flatnonzero(shown), chosen)]
    at = pieces.time_s[chosen]
    reach = float(np.ptp(at)) or 1.0
    scale = 3.0 * _TALLEST * reach / float(height.max() or 1.0)
    figure = new_figure(path, TWO_COLUMNS_MM, 130.0)
    axes = figure.add_subplot()
    hertz = pieces.frequency_hz[shown]
    for k in reversed(range(chosen.size)):
        line = at[k] + scale * height[:, k]
        order = 2.0 + (chosen.size - k) / chosen.size
        axes.fill_between(hertz, at[k], line, color="white", linewidth=0, zorder=order)
        axes.plot(hertz, line, color=COLORS[0], linewidth=0.7, zorder=order)
    axes.plot(np.interp(at, time, rpm) / 60.0, at, color=COLORS[1], linestyle=(0, (5, 2)),
              linewidth=1.1, zorder=4, label="1/rev of the reference shaft")  # fmt: skip
    axes.set_xlim(float(hertz[0]), float(hertz[-1]))
    axes.set_ylim(float(at[0]) - 0.02 * reach, float((at + scale * height.max(axis=0)).max()))
    axes.set_xlabel("frequency [Hz]")
    axes.set_ylabel(f"time [s]; spectra rise by {number_text(1.0 / scale)} N for 1 s")
    speeds, times = _round_speeds(time, rpm, at)
    side = axes.secondary_yaxis("right")
    side.set_yticks(times, [thousands(speed) for speed in speeds])
    side.set_ylabel("speed [rpm]")
    axes.set_title(fill(title, 70), fontsize=TITLE_PT)
    axes.grid(visible=True, axis="x", color="#E5E5E5", linewidth=0.6)
    figure.legend(loc="outside lower center", frameon=False, fontsize=SMALL_PT)
    write_figure(figure, path)


def _round_speeds(time: FloatArray, rpm: FloatArray, at: FloatArray) -> tuple[FloatArray, ...]:
    """Round speeds between the first and the last spectrum, and when each is reached first."""
    from matplotlib.ticker import MaxNLocator

    low, high = np.interp(at[[0, -1]], time, rpm)
    speeds = np.array(MaxNLocator(7).tick_values(low, high))
    speeds = speeds[(speeds >= low) & (speeds <= high)]
    reached = np.searchsorted(np.maximum.accumulate(rpm), speeds)
    return speeds, np.asarray(time[np.minimum(reached, time.size - 1)])


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
