"""Beams against solids over the slenderness of a disk: where beams stop being good enough."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solidwhirl.scene_file import parse_scene
from solidwhirl.study_errors import diagram_document, matched_errors, wider_diagram
from solidwhirl.study_measure import Progress, peak_memory_gib

FloatArray = NDArray[np.float64]

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


def map_rows(name: str, side: int) -> tuple[dict[str, Any], ...]:
    """Return the rows of a map, each a payload for `run_map_row`.

    Parameters
    ----------
    name
        "solid disk" or "webbed disk".
    side
        Points a side.
    """
    x_name, x_ends, y_name, y_ends = _AXES[name]
    x, y = (np.geomspace(*ends, side).round(5).tolist() for ends in (x_ends, y_ends))
    return tuple(
        {"map": name, "x_name": x_name, "y_name": y_name, "x": x, "y": value} for value in y
    )


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


def run_map_row(payload: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Compute one row of a map.

    Parameters
    ----------
    payload
        From `map_rows`.
    progress
        Called with one line per point.

    Returns
    -------
    dict
        "points", one per x: see docs/study.md; and the process' peak memory.
    """
    points = []
    for x in payload["x"]:
        progress(f"{payload['map']}, {x:g} by {payload['y']:g}")
        points.append({"x": x, "y": payload["y"], **_point(payload["map"], x, payload["y"])})
    return {"points": points, "peak_memory_gib": peak_memory_gib()}


def _point(name: str, x: float, y: float) -> dict[str, Any]:
    """Errors of the beam level's first whirl pairs at one point, or why there are none."""
    from solidwhirl.pipeline import run_scene

    diagrams = {}
    for level in ("beam", "harmonic"):
        data = map_scene(name, x, y, level)
        if data is None:
            return {"status": "absent", "message": "the web is no thinner than the rim"}
        try:
            results = run_scene(parse_scene(data))
        except ValueError as error:
            return {"status": "failed", "level": level, "message": str(error)}
        assert results is not None  # one process
        element = results.elements["rotor"]
        if element.level != level:
            return {"status": "failed", "level": level, "message": f"{level} is not available"}
        diagram = results.campbell if level == "beam" else wider_diagram(results)
        diagrams[level] = diagram_document(diagram)
    found = matched_errors(diagrams["beam"], diagrams["harmonic"])
    lost = bool((found.partner < 0).any())
    return {
        "status": "done",
        "relative_error": None if lost else float(np.nanmax(np.abs(found.error))),
        "relative_error_first_pair": _largest(found.error[:2]),
        "branches_without_partner": int((found.partner < 0).sum()),
        "frequency_hz": [branch[0] for branch in diagrams["harmonic"]["frequency_hz"]],
    }


def _largest(error: FloatArray) -> float | None:
    known = np.abs(error[np.isfinite(error)])
    return float(known.max()) if known.size else None
