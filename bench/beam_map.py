"""Beams against solids over the slenderness of a disk: where beams stop being good enough.

A steel disk of radius 0.1 m at a third of a shaft of 0.8 m on two bearings of 1e8 N/m, up to a rim
speed of 200 m/s; the truth is the harmonic level at accuracy 1e-3.

    .venv/bin/python bench/beam_map.py --side 6 --out docs/study/beam-map.png
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn.estimates.differences import campbell_differences
from solidwhirl.rotordyn.plots.frame import TWO_COLUMNS_MM, in_style, new_figure, write_figure
from solidwhirl.scene_reading.reader import parse_scene

# The rotor of both maps: a steel disk of this radius at a third of a shaft on two bearings.
_DISK_RADIUS_M = 0.1
_SPAN_M = 0.8
_DISK_AT_M = _SPAN_M / 3.0
_STIFFNESS_N_PER_M = 1e8
# Webbed disk: shaft and inner radius of the rim over the disk's radius.
_WEB_SHAFT, _RIM = 0.25, 0.75
# A rim speed of 200 m/s.
_TOP_RPM = 2000.0 * 30.0 / np.pi
_PAIRS = 2
_ACCURACY = 1e-3
# Ends of the axes, all over the radius of the disk, evenly spread in the logarithm.
_AXES = {
    "solid disk": ("disk_width_over_radius", (0.05, 1.6), "shaft_over_disk_radius", (0.1, 0.7)),
    "webbed disk": ("web_thickness_over_radius", (0.01, 0.32), "rim_width_over_radius", (0.1, 0.8)),
}


def map_scene(name: str, x: float, y: float, level: str) -> dict[str, Any] | None:
    """Return the scene of one point as data, None where the web is as wide as the rim or wider.

    Parameters
    ----------
    name
        "solid disk" or "webbed disk".
    x, y
        Place in the map; see the names of its axes.
    level
        "beam" or "harmonic".
    """
    radius, shaft = _DISK_RADIUS_M, (y if name == "solid disk" else _WEB_SHAFT) * _DISK_RADIUS_M
    if name == "solid disk":
        disks = [_ring("disk", x, shaft, radius)]
    elif x >= y:
        return None
    else:
        rim = _RIM * radius
        disks = [_ring("web", x, shaft, rim), _ring("rim", y, rim, radius)]
    shaft_section = {"name": "shaft", "start_m": 0.0, "end_m": _SPAN_M, "outer_radius_m": shaft}
    ends = (("left", 0.0), ("right", _SPAN_M))
    return {
        "name": "map-point",
        "model": {
            "level": level,
            "accuracy": _ACCURACY,
            "compare_coupling": "off",
            "estimates": "on" if level == "harmonic" else "off",
        },
        "campbell": {"branches": 2 * _PAIRS},
        "speeds": {"list_rpm": [0.0, 0.5 * _TOP_RPM, _TOP_RPM]},
        "bodies": {
            "rotor": {
                "material": "steel",
                "sections": [shaft_section, *disks],
                "interfaces": [{"name": n, "kind": "section", "at_m": z} for n, z in ends],
            }
        },
        "bearings": [
            {"name": n, "first": f"rotor.{n}", "stiffness_n_per_m": _STIFFNESS_N_PER_M}
            for n, _ in ends
        ],
    }


def _ring(name: str, width_over_radius: float, inner: float, outer: float) -> dict[str, Any]:
    half = 0.5 * width_over_radius * _DISK_RADIUS_M
    return {
        "name": name,
        "start_m": _DISK_AT_M - half,
        "end_m": _DISK_AT_M + half,
        "inner_radius_m": inner,
        "outer_radius_m": outer,
    }


def point(name: str, x: float, y: float) -> dict[str, Any]:
    """Largest relative error of beams in the first two whirl pairs, or why there is none."""
    diagrams = []
    for level in ("beam", "harmonic"):
        data = map_scene(name, x, y, level)
        if data is None:
            return {"x": x, "y": y, "message": "the web is no thinner than the rim"}
        # the truth has more branches, so that those at the edge find their partners
        data["campbell"]["branches"] += 4 * (level == "harmonic")
        try:
            results = run_scene(parse_scene(data))
        except ValueError as error:
            return {"x": x, "y": y, "message": f"{level}: {error}"}
        diagrams.append(results.campbell)
    found = campbell_differences(*diagrams)
    error = found.frequency / (1.0 - found.frequency)
    lost = bool((found.partner < 0).any())
    return {"x": x, "y": y, "relative_error": None if lost else float(np.nanmax(np.abs(error)))}


def draw(maps: dict[str, list[dict[str, Any]]], path: Path) -> None:
    """Draw the error in per cent, a frame for each map."""
    from matplotlib.colors import LogNorm

    with in_style():
        figure = new_figure(path, TWO_COLUMNS_MM, 92.0)
        frames = figure.subplots(1, len(maps), squeeze=False)[0]
        for axes, (name, points) in zip(frames, maps.items(), strict=True):
            x, y = (np.array(sorted({p[k] for p in points})) for k in "xy")
            error = np.full((len(y), len(x)), np.nan)
            for p in points:
                if "relative_error" in p:
                    value = min(p["relative_error"] or 0.25, 0.25)
                    place = np.searchsorted(y, p["y"]), np.searchsorted(x, p["x"])
                    error[place] = value
                    axes.text(p["x"], p["y"], f"{100 * value:.2g}", ha="center", va="center")
            shown = axes.pcolormesh(x, y, error, cmap="cividis", norm=LogNorm(1e-4, 0.25))
            labels = (_AXES[name][k].replace("_over_", " / ").replace("_", " ") for k in (0, 2))
            axes.set(xscale="log", yscale="log", title=name)
            axes.set_xlabel(next(labels) + " [1]")
            axes.set_ylabel(next(labels) + " [1]")
        figure.colorbar(shown, ax=frames, label="largest relative error of beams [1]")
        write_figure(figure, path)


def main() -> None:
    """Compute both maps, draw them, and keep the numbers beside the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--side", type=int, default=6, help="points a side")
    parser.add_argument("--out", type=Path, default=Path("beam-map.png"))
    given = parser.parse_args()
    maps: dict[str, list[dict[str, Any]]] = {}
    for name, (_, x_ends, _, y_ends) in _AXES.items():
        x, y = (np.geomspace(*ends, given.side).round(5).tolist() for ends in (x_ends, y_ends))
        maps[name] = [point(name, a, b) for b in y for a in x]
    given.out.with_suffix(".json").write_text(json.dumps(maps, indent=1), encoding="utf-8")
    draw(maps, given.out)


if __name__ == "__main__":
    main()
