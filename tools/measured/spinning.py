"""Blades measured while they turn: frequencies over the speed with the measured points."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.cache.files import StageStore
from solidwhirl.core.blocks import numbers
from solidwhirl.core.stages import silent
from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts
from solidwhirl.scene_reading.reader import read_scene

ROOT = Path(__file__).resolve().parents[2]
SPINNING: dict[str, Any] = tomllib.loads(
    Path(__file__).with_name("spinning.toml").read_text(encoding="utf-8")
)


class Blades:
    """Frequencies of blades over the speed: of one nodal diameter, as the hub is held."""

    def __init__(self, scene: str, store: StageStore) -> None:
        results = run_scene(
            read_scene(ROOT / "scenes" / "measured" / f"{scene}.toml"), progress=silent, store=store
        )
        assert results is not None
        found = results.analyses["nodal_diameters"].document
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
    modes: FloatArray = blades.frequency_hz.T
    parts: list[charts.Mark] = [
        charts.Curve(x=blades.speed_rpm, y=hz, name="predicted", look=charts.Look("@c0"))
        for hz in modes
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


def spinning_sections(folder: Path, store: StageStore) -> tuple[list[str], dict[str, Any]]:
    """Return the part of the page about turning blades, and its numbers."""
    lines: list[str] = ["## Blades that turn"]
    data: dict[str, Any] = {}
    for case in SPINNING["cases"]:
        lines += [f"### {case['title']}", f"Source: {case['source']}.", case["text"]]
        rows, drawn = [], []
        for run in case["runs"]:
            blades = Blades(run["scene"], store)
            points = [(p["speed_rpm"], hz) for p in run["points"] for hz in p["measured_hz"]]
            drawn.append((run, diagram(blades, points, *case["range_hz"])))
            for point in run["points"]:
                for mode, hz in zip(point["modes"], point["measured_hz"], strict=True):
                    ours, error = blades.at(point["speed_rpm"], mode)
                    data.setdefault(run["scene"], []).append(
                        {
                            "speed_rpm": point["speed_rpm"],
                            "measured_hz": hz,
                            "frequency_hz": ours,
                            "frequency_error_estimate": error,
                        }
                    )
                    rows.append(
                        f"| [{run['name']}](../scenes/measured/{run['scene']}.toml) "
                        f"| {point['speed_rpm']:g} | {hz:g} "
                        f"| {ours:.4g} | {100 * error:.2g} | {100 * (ours / hz - 1):+.1f} |"
                    )
        for run, chart in drawn:
            draw_charts([chart], folder / f"{run['scene']}.png", f"{case['title']}, {run['name']}")
            lines.append(f"![{run['name']}](measured/{run['scene']}.png)")
        lines.append(
            "| blade | speed [rpm] | measured [Hz] | predicted [Hz] | error [%] | difference [%] "
            "|\n|---|---|---|---|---|---|\n" + "\n".join(rows)
        )
        lines.append(case["why"])
    return lines, data
