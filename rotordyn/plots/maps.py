"""Pictures of critical speed maps and of bearing laws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.assembly.bearing_laws import law_pieces
from solidwhirl.rotordyn.assembly.parts import Bearing
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.critical_speeds.map import CriticalSpeedMap
from solidwhirl.rotordyn.plots.chart import (
    Axis,
    Chart,
    Choice,
    Curve,
    Look,
    Option,
    Part,
    Rule,
    Span,
    branch_curves,
    speed_axis,
)
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts
from solidwhirl.rotordyn.response.resonance_samples import with_knots

# Half widths of the bands about an operating speed.
_BANDS = (0.20, 0.15)
# Points of a law's curve.
_CURVE_POINTS = 400


def map_chart(
    critical_map: MapCurves, operating_rpm: Mapping[str, float], shaft: str = "reference shaft"
) -> Chart:
    """Return critical speeds over the stiffness of bearings.

    Parameters
    ----------
    critical_map
        The branches.
    operating_rpm
        Operating speeds of the shaft by name: lines with bands of 15 and 20 % on both sides.
    shaft
        Whose speeds are drawn.
    """
    stiffness, rpm = critical_map.stiffness_n_per_m, critical_map.speed_rpm
    ends = float(stiffness[0]), float(stiffness[-1])
    parts: list[Part] = []
    for name, speed in operating_rpm.items():
        parts += [
            Span(low=speed * (1.0 - wide), high=speed * (1.0 + wide), along="y",
                 name=f"operating speed ±{100 * wide:.0f} %", look=Look("@c4", ""))
            for wide in _BANDS
        ]  # fmt: skip
        text = f"operating speed of {name}, {speed:.0f} rpm"
        look = Look("@ink", "longdash", width=1.2)
        parts.append(Rule(at=speed, along="y", name="operating speed", text=text, look=look))
    limits = (("without these bearings", critical_map.free_rpm, "dot"),
              ("with rigid bearings", critical_map.rigid_rpm, "longdashdot"))  # fmt: skip
    for text, values, dash in limits:
        look = Look("@muted", dash, width=1.0)
        parts += [
            Curve(x=np.array(ends), y=np.array([v, v]), name=text, look=look)
            for v in values
            if np.isfinite(v) and v > 0.0
        ]
    texts = [
        [f"branch {b + 1}, {w or 'none'}" for w in branch]
        for b, branch in enumerate(critical_map.whirl)
    ]
    parts += branch_curves(stiffness, rpm, critical_map.whirl, texts)
    look = Look("@c3", "dash", width=1.6)
    parts += [
        Rule(at=value, name="stiffness as chosen", text=names, look=look)
        for value, names in critical_map.chosen.items()
        if ends[0] <= value <= ends[1]
    ]
    shown = [*rpm[np.isfinite(rpm)], *operating_rpm.values()] or [1.0]  # none: an empty frame
    low, high = float(min(shown)), float(max(shown))
    speeds = Axis(
        label=f"critical speed of the {shaft}" if shaft == "reference shaft"
        else f"critical speed of {shaft}",
        unit="rpm", low=low / 1.3, high=1.3 * high, is_log=True, digits=",.1f",
    )  # fmt: skip
    linear = replace(speeds, low=0.0, high=1.05 * high, is_log=False)
    scales = [Option(label="logarithmic"), Option(label="linear", y=linear)]
    return Chart(
        name="map",
        title="Critical speed map",
        caption=f"Undamped critical speeds of {shaft} over the stiffness of "
        f"{', '.join(critical_map.bearings)}. On the left they tend to those without these "
        "bearings, on the right to those with rigid ones (thin lines).",
        alt=f"{len(rpm)} branches of critical speeds over bearing stiffness from {ends[0]:.3g} "
        f"to {ends[1]:.3g} N/m.",
        x=Axis(label=f"stiffness of {', '.join(critical_map.bearings)}", unit="N/m",
               low=ends[0] / (1.0 + 0.05 * (ends[0] == ends[1])),
               high=ends[1] * (1.0 + 0.05 * (ends[0] == ends[1])), is_log=True, digits=".4g"),
        y=speeds,
        parts=[*parts, Choice(label="speed axis", options=scales)],
        height_px=480,
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True, eq=False)
class MapCurves:
    """What a critical speed map shows.

    Attributes
    ----------
    bearings
        Names of those that were varied.
    stiffness_n_per_m
        Rising, shape (s,).
    speed_rpm, whirl
        Of the branches, b × s; nan and empty where there is none.
    free_rpm, rigid_rpm
        Critical speeds without the bearings and with rigid ones.
    chosen
        Names of bearings by the stiffness that they have, N/m.
    """

    bearings: Sequence[str]
    stiffness_n_per_m: FloatArray
    speed_rpm: FloatArray
    whirl: Sequence[Sequence[str | None]]
    free_rpm: FloatArray
    rigid_rpm: FloatArray
    chosen: Mapping[float, str] = field(default_factory=dict)


def draw_critical_speed_map(
    critical_map: CriticalSpeedMap,
    path: str | Path,
    title: str,
    operating_rad_s: Mapping[str, float],
) -> None:
    """Draw critical speeds over the stiffness of bearings to a picture file.

    Arguments `path` and `title`, and the error of a wrong suffix, as in `draw_campbell`.

    Parameters
    ----------
    critical_map
        The branches. Whirl shows by colour, dashes and marker. Thin lines are the critical speeds
        without the bearings and with rigid ones.
    operating_rad_s
        Operating speeds by name, as Ω of the reference shaft, rad/s: lines with bands of 15 and
        20 % on both sides.

    Raises
    ------
    AnalysisError
        If the map has no branch.
    """
    if not np.isfinite(critical_map.speed_rad_s).any():
        raise AnalysisError("the map has no critical speed to draw")
    curves = MapCurves(
        bearings=critical_map.bearings,
        stiffness_n_per_m=critical_map.stiffness_n_per_m,
        speed_rpm=critical_map.speed_rad_s * RPM_PER_RAD_S,
        whirl=critical_map.whirl.tolist(),
        free_rpm=critical_map.free_rad_s * RPM_PER_RAD_S,
        rigid_rpm=critical_map.rigid_rad_s * RPM_PER_RAD_S,
        chosen=_chosen(critical_map),
    )
    operating = {name: speed * RPM_PER_RAD_S for name, speed in operating_rad_s.items()}
    draw_charts([map_chart(curves, operating)], path, title)


def _chosen(critical_map: CriticalSpeedMap) -> dict[float, str]:
    """The bearings by the stiffness that they have."""
    places: dict[float, list[str]] = {}
    pairs = critical_map.chosen_stiffness_n_per_m
    for name, pair in zip(critical_map.bearings, pairs, strict=True):
        same = pair[0] == pair[1]
        for value, mark in zip(pair, ("", "") if same else (" (x)", " (y)"), strict=True):
            if name + mark not in places.setdefault(float(value), []):
                places[float(value)].append(name + mark)
    return {value: ", ".join(names) for value, names in places.items()}


def draw_bearing_law(
    bearing: Bearing,
    speeds_rad_s: npt.ArrayLike,
    path: str | Path,
    title: str,
    operating_rad_s: Mapping[str, float],
) -> None:
    """Draw the stiffness and damping of a bearing over its spin speed to a picture file.

    Arguments `path` and `title`, and the error of a wrong suffix, as in `draw_campbell`.

    Parameters
    ----------
    bearing
        With a speed law.
    speeds_rad_s
        Lowest and highest spin speed of its first side to show, rad/s.
    operating_rad_s
        Spin speeds of that side to mark, by name, rad/s.

    Raises
    ------
    AnalysisError
        If the bearing has no law.

    Notes
    -----
    Values are divided by that of xx at the lowest speed shown. The range the law was made for is
    shaded green, and hatched is where the damping is negative.
    """
    law = bearing.speed_law
    if law is None:
        raise AnalysisError(f"bearing {bearing.name!r} has no speed law to draw")
    ends = np.asarray(speeds_rad_s, dtype=float)
    speeds = np.linspace(ends.min(), ends.max(), _CURVE_POINTS)
    pieces = law_pieces(law, bearing.stiffness_n_per_m, bearing.damping_n_s_per_m)
    if pieces is not None:
        speeds = with_knots(speeds, pieces.knots_rad_s)
    found = [
        law.coefficients(float(s), bearing.stiffness_n_per_m, bearing.damping_n_s_per_m)
        for s in speeds
    ]
    rpm = speeds * RPM_PER_RAD_S
    stiffness = np.array([p.stiffness_n_per_m for p in found])
    damping = np.array([p.damping_n_s_per_m for p in found])
    low, high = (end * RPM_PER_RAD_S for end in law.speed_range_rad_s)
    ink = Look("@ink", "solid", width=1.2)
    parts: list[Part] = [
        Span(low=max(low, float(rpm[0])), high=min(high, float(rpm[-1])),
             name=f"range of {law.name}", look=Look("@good", "")),
        *_negative_spans(rpm, damping),
        Rule(at=0.0, along="y", look=replace(ink, width=0.8)),
        *_coefficient_curves(rpm, stiffness, "k", "N/m"),
        *_coefficient_curves(rpm, damping, "d", "N s/m"),
        *(Rule(at=s * RPM_PER_RAD_S, name="speed", text=name, look=ink)
          for name, s in operating_rad_s.items()),
    ]  # fmt: skip
    chart = Chart(
        name="law",
        title="Coefficients of a bearing",
        x=speed_axis(float(rpm[0]), float(rpm[-1]), f"spin speed of {bearing.first.body}"),
        y=Axis(label="coefficient over its xx value at the lowest speed", unit="1"),
        parts=parts,
    )
    draw_charts([chart], path, title)


def _negative_spans(rpm: FloatArray, damping: FloatArray) -> list[Span]:
    """Speeds at which the symmetric part of the damping (s, 2, 2) has a negative eigenvalue."""
    lowest = np.linalg.eigvalsh(0.5 * (damping + damping.transpose(0, 2, 1)))[:, 0]
    negative = lowest < -1e-12 * np.abs(damping).max(initial=0.0)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], negative.astype(int), [0]))))
    return [
        Span(low=float(rpm[a]), high=float(rpm[b - 1]), name="negative damping", is_hatched=True)
        for a, b in edges.reshape(-1, 2)
    ]


def _coefficient_curves(
    rpm: FloatArray, matrices: FloatArray, symbol: str, unit: str
) -> list[Curve]:
    """The entries of (s, 2, 2) that are not zero, over xx at the first speed."""
    reference = float(matrices[0, 0, 0]) or float(np.abs(matrices).max(initial=0.0))
    if reference == 0:
        return []
    dash = {"k": "solid", "d": "dash"}[symbol]
    color = {"k": "@c0", "d": "@c1"}[symbol]
    found = []
    for name, row, column, width, mark in (
        ("xx", 0, 0, 2.6, ""),
        ("yy", 1, 1, 1.4, "square-open"),
        ("xy", 0, 1, 1.0, "triangle-up-open"),
        ("yx", 1, 0, 1.0, "triangle-left-open"),
    ):
        curve = matrices[:, row, column] / reference
        if curve.any():
            label = f"{symbol}_{name}" + (f" ({reference:.3g} {unit})" if name == "xx" else "")
            look = Look(color, dash, mark, width=width)
            found.append(Curve(x=rpm, y=curve, name=label, look=look))
    return found
