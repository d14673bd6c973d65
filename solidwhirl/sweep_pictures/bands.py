"""Campbell diagram of a sampled sweep: medians, bands and how sure these are."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from solidwhirl.rotordyn.plots.chart import Axis, Chart, Curve, Fill, Label, Look, Mark, speed_axis
from solidwhirl.sweep.analysis import SweepAnalysis, SweepPictureSettings
from solidwhirl.sweep.bands import LEAST_SAMPLES, CampbellBands
from solidwhirl.sweep_pictures.parts import operating_span

# Neighbours are told apart; the record of a row has no whirl of branches.
_COLORS = 4
_RANGES = ("@ink", "@muted")


def bands_chart(found: SweepAnalysis, settings: SweepPictureSettings) -> Chart:
    """Return the bands of the branches, and the critical speeds from their 5 to 95 % quantile."""
    bands = found.bands
    assert bands is not None
    top = 1.06 * float(np.nanmax(bands.frequency_hz.value))
    fastest = float(bands.speed_rpm.max())
    count = bands.frequency_hz.value.shape[1]
    limits = f"{100 * settings.confidence:g} % confidence limits\nof the 5 and 95 % quantiles"
    return Chart(
        name="campbell-bands",
        title=f"Campbell diagram of {bands.cases} samples: {found.design.scene}",
        x=speed_axis(float(bands.speed_rpm.min()), fastest),
        y=Axis(label="natural frequency", unit="Hz", low=0.0, high=top),
        parts=[
            *operating_span(settings, "x"),
            *(mark for b in range(count) for mark in _branch(bands, b, limits)),
            *_critical(found, fastest, top),
        ],
        notes=_notes(found, bands),
    )


def _branch(bands: CampbellBands, branch: int, limits: str) -> Iterator[Mark]:
    """Median, band and the limits of its edges, where 20 samples have the branch."""
    spread = bands.frequency_hz
    enough = spread.count[branch] >= LEAST_SAMPLES
    low, middle, high = (np.where(enough, v[branch], np.nan) for v in spread.value)
    color, speed = f"@c{branch % _COLORS}", bands.speed_rpm
    yield Fill(x=speed, low=low, high=high, name="5 to 95 %", look=Look(f"{color}/0.4", ""))
    yield Curve(x=speed, y=middle, name="median", look=Look(color))
    for values in (spread.low, spread.high):
        for level in (0, -1):
            edge = np.where(enough, values[level, branch], np.nan)
            yield Curve(x=speed, y=edge, name=limits, look=Look(color, "dot", width=1.2))


def _critical(found: SweepAnalysis, fastest: float, top: float) -> Iterator[Mark]:
    """Excitation lines; critical speeds from their 5 to their 95 % quantile along them."""
    spread = found.critical_quantiles
    ratios: list[float] = []
    for number, track in enumerate(found.tracks):
        ratio = track.excitation_ratio / 60.0
        if not any(abs(ratio / r - 1.0) < 1e-3 for r in ratios):
            ratios.append(ratio)
            end = min(fastest, top / ratio)
            x = np.array([0.0, end])
            yield Curve(x=x, y=ratio * x, look=Look("@ink", width=1.0))
            side = "right" if end == fastest else "above"
            yield Label(x=end, y=ratio * end, text=f"{track.excitation_ratio:.3g}×", side=side)
        if spread is None or spread.count[number] < LEAST_SAMPLES:
            continue
        # ends are marked, and neighbours differ: ranges may overlap along one line
        ends, middle = spread.value[[0, 2], number], spread.value[[1], number]
        look = Look(_RANGES[number % 2], "solid", "line-ns", 14.0, 4.0)
        yield Curve(x=ends, y=ratio * ends, name="critical speed, 5 to 95 %", look=look)
        ring = Look("@ink", "", "circle-open", 9.0)
        yield Curve(x=middle, y=ratio * middle, name="critical speed, median", look=ring)


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
        notes.append(f"samples matched ambiguously: {', '.join(doubtful)}")
    return notes
