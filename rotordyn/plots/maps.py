"""Chart of critical speeds over the stiffness of bearings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.plots import chart as charts

# Half widths of the bands about an operating speed.
_BANDS = (0.20, 0.15)


@dataclass(frozen=True, kw_only=True, eq=False)
class MapCurves:
    """What a critical speed map shows."""

    #: Names of those that were varied
    bearings: Sequence[str]
    #: Rising, shape (s,)
    stiffness_n_per_m: FloatArray
    #: Of the branches, b × s; nan and empty where there is none
    speed_rpm: FloatArray
    whirl: Sequence[Sequence[str | None]]
    #: Critical speeds without the bearings and with rigid ones
    free_rpm: FloatArray
    rigid_rpm: FloatArray
    #: Names of bearings by the stiffness that they have, N/m
    chosen: Mapping[float, str] = field(default_factory=dict)
    #: Stiffness of bearings over the speed: name, N/m and rpm of each, (s,)
    supports: Sequence[tuple[str, FloatArray, FloatArray]] = ()


def map_chart(
    critical_map: MapCurves, operating_rpm: Mapping[str, float], shaft: str = "reference shaft"
) -> charts.Chart:
    """Return critical speeds over the stiffness of bearings.

    `critical_map`: the branches. `operating_rpm`: operating speeds of the shaft by name: lines with
    bands of 15 and 20 % on both sides. `shaft`: whose speeds are drawn.
    """
    stiffness, rpm = critical_map.stiffness_n_per_m, critical_map.speed_rpm
    ends = float(stiffness[0]), float(stiffness[-1])
    parts = _map_parts(critical_map, operating_rpm)
    shown = [*rpm[np.isfinite(rpm)], *operating_rpm.values()] or [1.0]  # none: an empty frame
    low, high = float(min(shown)), float(max(shown))
    speeds = charts.Axis(
        label=f"critical speed of the {shaft}" if shaft == "reference shaft"
        else f"critical speed of {shaft}",
        unit="rpm", low=low / 1.3, high=1.3 * high, is_log=True, digits=",.1f",
    )  # fmt: skip
    linear = replace(speeds, low=0.0, high=1.05 * high, is_log=False)
    scales = [charts.Option(label="logarithmic"), charts.Option(label="linear", y=linear)]
    return charts.Chart(
        name="map",
        title="Critical speed map",
        caption=f"Undamped critical speeds of {shaft} over the stiffness of "
        f"{', '.join(critical_map.bearings)}. On the left they tend to those without these "
        "bearings, on the right to those with rigid ones (thin lines)."
        + (" Stiffness of bearings over the speed: where it crosses a branch is a critical speed."
           if critical_map.supports else ""),
        alt=f"{len(rpm)} branches of critical speeds over bearing stiffness from {ends[0]:.3g} "
        f"to {ends[1]:.3g} N/m.",
        x=charts.Axis(label=f"stiffness of {', '.join(critical_map.bearings)}", unit="N/m",
               low=ends[0] / (1.0 + 0.05 * (ends[0] == ends[1])),
               high=ends[1] * (1.0 + 0.05 * (ends[0] == ends[1])), is_log=True, digits=".4g"),
        y=speeds,
        parts=[*parts, charts.Choice(label="speed axis", options=scales)],
        height_px=480,
    )  # fmt: skip


def _map_parts(critical_map: MapCurves, operating_rpm: Mapping[str, float]) -> list[charts.Part]:
    """Operating speeds with their bands, limits, branches and the stiffness as chosen."""
    stiffness, rpm = critical_map.stiffness_n_per_m, critical_map.speed_rpm
    ends = float(stiffness[0]), float(stiffness[-1])
    parts: list[charts.Part] = []
    for name, speed in operating_rpm.items():
        parts += [
            charts.Span(low=speed * (1.0 - wide), high=speed * (1.0 + wide), along="y",
                 name=f"operating speed ±{100 * wide:.0f} %", look=charts.Look("@c4", ""))
            for wide in _BANDS
        ]  # fmt: skip
        text = f"operating speed of {name}, {speed:.0f} rpm"
        look = charts.Look("@ink", "longdash", width=1.2)
        parts.append(charts.Rule(at=speed, along="y", name="operating speed", text=text, look=look))
    limits = (("without these bearings", critical_map.free_rpm, "dot"),
              ("with rigid bearings", critical_map.rigid_rpm, "longdashdot"))  # fmt: skip
    for text, values, dash in limits:
        look = charts.Look("@muted", dash, width=1.0)
        parts += [
            charts.Curve(x=np.array(ends), y=np.array([v, v]), name=text, look=look)
            for v in values
            if np.isfinite(v) and v > 0.0
        ]
    texts = [
        [f"branch {b + 1}, {w or 'none'}" for w in branch]
        for b, branch in enumerate(critical_map.whirl)
    ]
    parts += charts.branch_curves(stiffness, rpm, critical_map.whirl, texts)
    for place, (text, values, speeds) in enumerate(critical_map.supports):
        dash = ("dash", "dot", "dashdot")[place % 3]
        look = charts.Look(f"@c{3 + place // 3 % 5}", dash, width=1.6)
        inside = (values >= ends[0]) & (values <= ends[1])
        x = np.where(inside, values, np.nan)
        parts.append(charts.Curve(x=x, y=np.where(inside, speeds, np.nan), name=text, look=look))
    look = charts.Look("@c3", "dash", width=1.6)
    parts += [
        charts.Rule(at=value, name="stiffness as chosen", text=names, look=look)
        for value, names in critical_map.chosen.items()
        if ends[0] <= value <= ends[1]
    ]
    return parts
