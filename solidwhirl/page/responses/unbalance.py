"""Steady responses of a page: unbalance, forces in the bearings, orbits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np

from solidwhirl.page.frame.operating import operating_rad_s
from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.records import Run, Section, Table
from solidwhirl.page.frame.traces import analyses_of_kind, numbers
from solidwhirl.rotordyn.plots.campbell import error_words
from solidwhirl.rotordyn.plots.chart import operating_toggle
from solidwhirl.rotordyn.plots.response import (
    ExciterCurves,
    Peak,
    amplitude_chart,
    force_chart,
    orbit_chart,
    phase_chart,
)

# Speeds whose orbits can be chosen.
_MOST_ORBITS = 12


def section(run: Run) -> Section | None:
    """Return the unbalance responses; None where the scene has none."""
    found = analyses_of_kind(run.document, "unbalance_response")
    if not found:
        return None
    operating = operating_rad_s(run.results)
    asked = {a.label: a for a in run.results.scene.analyses}
    blocks: list[Any] = []
    for name, entry in found.items():
        wanted = getattr(asked.get(name), "orbits_at_rpm", ()) or ()
        blocks += response_blocks(name, entry, operating, wanted)
    return Section(
        name="unbalance",
        title="Unbalance response",
        blocks=blocks,
        note="Steady motion and bearing forces while the shafts turn with the unbalances of the "
        "scene.",
    )


def response_blocks(
    name: str,
    entry: Mapping[str, Any],
    operating: Mapping[str, tuple[float, float]],
    orbits_at_rpm: Sequence[float] = (),
) -> list[Any]:
    """Return everything about one unbalance response.

    Parameters
    ----------
    name, entry
        Of the analysis: its name and its part of `results.json`.
    operating
        Operating speeds to mark, rad/s, by what a reader is told.
    orbits_at_rpm
        Speeds whose orbits are wanted beside those at the peaks.
    """
    exciters = exciters_of(entry)
    charts = [amplitude_chart(exciters)]
    if any(e.force_n for e in exciters):
        charts.append(force_chart(exciters))
    shades = operating_toggle(operating)
    charts = [replace(chart, parts=[*shades, *chart.parts]) for chart in charts]
    charts.insert(1, phase_chart(exciters))
    orbits = orbit_chart([(e, _rows(e, orbits_at_rpm)) for e in exciters])
    if orbits is not None:
        charts.append(orbits)
    unbalances = Table(
        title=f"Unbalances ({name})",
        head=["at", "mass times distance [kg m]", "angle [°]"],
        rows=[
            [u["at"], float(u["moment_kg_m"]), float(u["phase_deg"])] for u in entry["unbalances"]
        ],
    )
    peaks = _peak_table(name, entry)
    drawn = [page_chart(chart, name) for chart in charts]
    return [unbalances, *drawn, *([peaks] if peaks.rows else [])]


def exciters_of(entry: Mapping[str, Any]) -> list[ExciterCurves]:
    """Return the curves of an unbalance response in `results.json`."""
    return [
        ExciterCurves(
            bodies=e["bodies"],
            frequency_ratio=e["frequency_ratio"],
            speed_rpm=numbers(entry["speed_rpm"]),
            motion_m={
                place: np.stack(
                    [
                        numbers(m[f"amplitude_{d}_m"])
                        * np.exp(1j * np.radians(numbers(m[f"phase_{d}_deg"])))
                        for d in "xy"
                    ],
                    axis=1,
                )
                for place, m in e["places"].items()
            },
            force_n={name: numbers(f) for name, f in e["bearing_force_n"].items()},
            peaks={
                place: [Peak(p["speed_rpm"], p["amplitude_m"], _peak_text(p)) for p in peaks]
                for place, peaks in e["peaks"].items()
            },
        )
        for e in entry["exciters"]
    ]


def _peak_text(peak: Mapping[str, Any]) -> str:
    words = [f"{peak['frequency_hz']:.6g} Hz"]
    if peak["amplification"] is not None:
        words.append(f"amplification factor {peak['amplification']:.3g}")
    if peak.get("frequency_error_estimate") is not None:
        words.append(f"error of the speed {error_words(peak['frequency_error_estimate'])}")
    return "\n".join(words)


def _rows(exciter: ExciterCurves, wanted: Sequence[float]) -> list[int]:
    """Numbers of the speeds that are wanted and of the highest peaks of all places."""
    peaks = sorted(chain.from_iterable(exciter.peaks.values()), key=lambda p: -p.height)
    speeds = [*wanted, *(p.speed_rpm for p in peaks[:_MOST_ORBITS])]
    near = (int(np.abs(exciter.speed_rpm - speed).argmin()) for speed in speeds)
    return sorted(list(dict.fromkeys(near))[:_MOST_ORBITS])


def _peak_table(name: str, entry: Mapping[str, Any]) -> Table:
    rows = [
        [
            place,
            ", ".join(exciter["bodies"]),
            f"{p['speed_rpm']:.1f}",
            f"{p['frequency_hz']:.5g}",
            p["amplitude_m"],
            p["amplification"],
            error_words(p.get("frequency_error_estimate")),
        ]
        for exciter in entry["exciters"]
        for place, peaks in exciter["peaks"].items()
        for p in peaks
    ]
    return Table(
        head=[
            "place",
            "unbalance of",
            "reference shaft [rpm]",
            "frequency [Hz]",
            "amplitude [m]",
            "amplification factor [1]",
            "estimated error of the speed",
        ],
        rows=rows,
        folded=f"Resonance peaks ({name}, {len(rows)})",
        caption="Without damping a peak has no height; its place is a critical speed.",
    )
