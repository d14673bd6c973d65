"""Orbits of a page: the paths of places of the shafts in an unbalance response."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any

import numpy as np

from solidwhirl.page.records import Chart, Choice, Option
from solidwhirl.page.traces import (
    Trace,
    axis,
    line,
    marks,
    metric,
    numbers,
    series_style,
    slug,
    style_of,
)

# Speeds whose orbits can be chosen.
_MOST_ORBITS = 12
_POINTS = 73
# Names of orbits smaller than this part of the largest would lie over each other.
_NAMED = 0.1


def orbit_chart(
    name: str, entry: Mapping[str, Any], orbits_at_rpm: Sequence[float] = ()
) -> Chart | None:
    """Return the orbits at the peaks and at wanted speeds; None where nothing moves.

    Parameters
    ----------
    name
        Of the analysis.
    entry
        Its part of `results.json`.
    orbits_at_rpm
        Speeds whose orbits are wanted beside those at the peaks.
    """
    rpm = numbers(entry["speed_rpm"])
    traces: list[Trace] = []
    options: list[Option] = []
    for exciter in entry["exciters"]:
        wanted = [*orbits_at_rpm, *_highest_peaks(exciter)]
        rows = list(dict.fromkeys(int(np.abs(rpm - w).argmin()) for w in wanted))[:_MOST_ORBITS]
        for row in sorted(rows):
            motions = exciter["places"].items()
            largest = max(float(numbers(m["major_m"])[row]) for _, m in motions)
            if not largest > 0.0:
                continue
            unit, factor = metric(largest, "m")
            before = len(traces)
            for k, (place, motion) in enumerate(motions):
                traces += _orbit(place, motion, row, factor, unit, k)
                if float(numbers(motion["major_m"])[row]) < _NAMED * largest:
                    traces[-1]["mode"] = "markers"
            # room for the names
            reach = 1.25 * factor * largest
            options.append(
                Option(
                    label=f"{rpm[row]:.0f} rpm, unbalance of {', '.join(exciter['bodies'])}",
                    traces=list(range(before, len(traces))),
                    layout={
                        "xaxis.title.text": f"displacement along x [{unit}]",
                        "yaxis.title.text": f"displacement along y [{unit}]",
                        "xaxis.range": [-reach, reach],
                        "yaxis.range": [-reach, reach],
                    },
                )
            )
    if not options:
        return None
    return Chart(
        name=f"orbits-{slug(name)}",
        title=f"Orbits ({name})",
        caption="Paths of the shaft at the speeds of the peaks and those that the scene asks for. "
        "Forward orbits are full lines with a filled circle, backward ones dashed with an open "
        "square; the mark is where the point is when the unbalance at angle zero points along +x.",
        alt="Elliptic orbits of the observed places at a chosen speed.",
        traces=traces,
        layout={
            "xaxis": axis("displacement along x", constrain="domain"),
            "yaxis": axis("displacement along y", scaleanchor="x", scaleratio=1),
        },
        height_px=480,
        controls=[Choice(label="at", options=options)],
    )


def _highest_peaks(exciter: Mapping[str, Any]) -> list[float]:
    """Speeds of the highest peaks of all places."""
    peaks = sorted(chain.from_iterable(exciter["peaks"].values()), key=lambda p: -p["amplitude_m"])
    return [p["speed_rpm"] for p in peaks[:_MOST_ORBITS]]


def _orbit(
    place: str, motion: Mapping[str, Any], row: int, factor: float, unit: str, number: int
) -> list[Trace]:
    """The path and the place on it at phase zero."""
    turns = np.linspace(0.0, 2.0 * np.pi, _POINTS)
    path = []
    for direction in "xy":
        amplitude = factor * float(numbers(motion[f"amplitude_{direction}_m"])[row])
        phase = np.radians(float(numbers(motion[f"phase_{direction}_deg"])[row]))
        path.append(amplitude * np.cos(turns + phase))
    sense = {"forward": "forward", "backward": "backward"}.get(motion["orbit"][row], "planar")
    style = style_of(sense)
    own = series_style(number)._replace(dash=style.dash, symbol=style.symbol)
    hover = f"<b>{place}</b>, {sense}<br>x %{{x:.4g}} {unit}<br>y %{{y:.4g}} {unit}<extra></extra>"
    return [
        line(path[0], path[1], f"{place} ({sense})", own, hovertemplate=hover),
        marks(
            path[0][:1],
            path[1][:1],
            place,
            own,
            10,
            mode="markers+text",
            text=[place],
            textposition="top center",
            textfont={"color": own.color},
            hovertemplate=hover,
            showlegend=False,
        ),
    ]
