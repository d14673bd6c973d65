"""Pictures of numbers that results.json holds: stability, waterfall of a run-up."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solidwhirl.core.outcome import Write
from solidwhirl.page.modes.stability import stability_chart
from solidwhirl.rotordyn.plots import frame
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts
from solidwhirl.rotordyn.run_up.force_spectrum import spectrogram

FloatArray = NDArray[np.float64]
# Length of the pieces of a waterfall, s; spectra in it, and height of the tallest over the height
# that all take.
_PIECE_S, _SPECTRA, _TALLEST = 0.25, 48, 0.16


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


@frame.styled
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
    figure = frame.new_figure(path, frame.TWO_COLUMNS_MM, 130.0)
    axes = figure.add_subplot()
    hertz = pieces.frequency_hz[shown]
    for k in reversed(range(chosen.size)):
        line = at[k] + scale * height[:, k]
        order = 2.0 + (chosen.size - k) / chosen.size
        axes.fill_between(hertz, at[k], line, color="white", linewidth=0, zorder=order)
        axes.plot(hertz, line, color=frame.COLORS[0], linewidth=0.7, zorder=order)
    axes.plot(np.interp(at, time, rpm) / 60.0, at, color=frame.COLORS[1], linestyle=(0, (5, 2)),
              linewidth=1.1, zorder=4, label="1/rev of the reference shaft")  # fmt: skip
    axes.set_xlim(float(hertz[0]), float(hertz[-1]))
    axes.set_ylim(float(at[0]) - 0.02 * reach, float((at + scale * height.max(axis=0)).max()))
    axes.set_xlabel("frequency [Hz]")
    axes.set_ylabel(f"time [s]; spectra rise by {frame.number_text(1.0 / scale)} N for 1 s")
    speeds, times = _round_speeds(time, rpm, at)
    side = axes.secondary_yaxis("right")
    side.set_yticks(times, [frame.thousands(speed) for speed in speeds])
    side.set_ylabel("speed [rpm]")
    axes.set_title(fill(title, 70), fontsize=frame.TITLE_PT)
    axes.grid(visible=True, axis="x", color="#E5E5E5", linewidth=0.6)
    figure.legend(loc="outside lower center", frameon=False, fontsize=frame.SMALL_PT)
    frame.write_figure(figure, path)


def _round_speeds(time: FloatArray, rpm: FloatArray, at: FloatArray) -> tuple[FloatArray, ...]:
    """Round speeds between the first and the last spectrum, and when each is reached first."""
    from matplotlib.ticker import MaxNLocator

    low, high = np.interp(at[[0, -1]], time, rpm)
    speeds = np.array(MaxNLocator(7).tick_values(low, high))
    speeds = speeds[(speeds >= low) & (speeds <= high)]
    reached = np.searchsorted(np.maximum.accumulate(rpm), speeds)
    return speeds, np.asarray(time[np.minimum(reached, time.size - 1)])
