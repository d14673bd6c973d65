"""Blades measured while they turn: frequencies over the speed with the measured points."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from measured.scenes import run_of, scene_name, scene_of

from solidwhirl.core.blocks import numbers
from solidwhirl.output.plan_text import table
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts

SPINNING: dict[str, Any] = tomllib.loads(
    Path(__file__).with_name("spinning.toml").read_text(encoding="utf-8")
)


class Blades:
    """Frequencies of blades over the speed: of one nodal diameter, as the hub is held."""

    def __init__(self, run: Mapping[str, Any]) -> None:
        found = run_of(scene_of(run, run)).analyses["nodal_diameters"].document
        self.speed_rpm = numbers(found["speed_rpm"])
        self.frequency_hz = numbers(found["frequency_hz"]["forward"])[1]  #: (s, m)
        self.error = numbers(found["frequency_error_estimate"]["forward"])[1]

    def at(self, rpm: float, mode: int) -> tuple[float, float]:
        """Frequency [Hz] and relative error at a speed: squares are linear in its square."""
        squares = self.speed_rpm**2
        hz = np.sqrt(np.interp(rpm**2, squares, self.frequency_hz[:, mode] ** 2))
        return float(hz), float(np.interp(rpm**2, squares, self.error[:, mode]))


def diagram(
    blades: Blades, points: list[tuple[float, float]], low: float, high: float
) -> charts.Chart:
    """Draw frequencies over the speed, with measured points (rpm, Hz)."""
    parts: list[charts.Mark] = [
        charts.Curve(x=blades.speed_rpm, y=hz, name="predicted", look=charts.Look("@c0"))
        for hz in blades.frequency_hz.T
        if np.any((hz > low) & (hz < high))
    ]
    rpm, hz = numbers(points).T
    parts.append(charts.Curve(x=rpm, y=hz, name="measured", look=charts.Look("@ink", "", "circle")))
    return charts.Chart(
        name="campbell",
        title="",
        x=charts.Axis(label="speed", unit="rpm"),
        y=charts.Axis(label="frequency", unit="Hz", low=low, high=high),
        parts=parts,
    )


def spinning_sections(folder: Path) -> tuple[list[str], dict[str, Any]]:
    """Return the part of the page about turning blades, and its numbers."""
    lines: list[str] = ["## Blades that turn"]
    data: dict[str, Any] = {}
    for case in SPINNING["cases"]:
        lines += [f"### {case['title']}", f"Source: {case['source']}.", case["text"]]
        rows: list[tuple[str, ...]] = []
        for run in case["runs"]:
            blades = Blades(run)
            points = [(p["speed_rpm"], hz) for p in run["points"] for hz in p["measured_hz"]]
            chart = diagram(blades, points, *case["range_hz"])
            picture = folder / f"{run['name']}.png"
            draw_charts([chart], picture, f"{case['title']}, {run['title']}")
            lines.append(f"![{run['title']}](measured/{picture.name})")
            data[run["name"]] = list(_compared(blades, run["points"]))
            link = f"[{run['title']}](../scenes/measured/{scene_name(run)}.toml)"
            rows += [_row(link, *point.values()) for point in data[run["name"]]]
        head = "blade | speed [rpm] | measured [Hz] | predicted [Hz] | error [%] | difference [%]"
        lines += [table(head, rows, str), case["why"]]
    return lines, data


def _compared(blades: Blades, points: Iterable[Mapping[str, Any]]) -> Iterator[dict[str, float]]:
    """Measured points with what is predicted there."""
    for point in points:
        for mode, hz in zip(point["modes"], point["measured_hz"], strict=True):
            ours, error = blades.at(point["speed_rpm"], mode)
            yield {
                "speed_rpm": point["speed_rpm"],
                "measured_hz": hz,
                "frequency_hz": ours,
                "frequency_error_estimate": error,
            }


def _row(link: str, rpm: float, measured: float, ours: float, error: float) -> tuple[str, ...]:
    shift = f"{100 * (ours / measured - 1):+.1f}"
    return link, f"{rpm:g}", f"{measured:g}", f"{ours:.4g}", f"{100 * error:.2g}", shift
