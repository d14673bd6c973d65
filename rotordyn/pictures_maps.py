"""Pictures of critical speed maps and of bearing laws."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.bearing_laws import law_pieces
from solidwhirl.rotordyn.critical_speed_map import CriticalSpeedMap
from solidwhirl.rotordyn.errors import AnalysisError
from solidwhirl.rotordyn.parts import Bearing
from solidwhirl.rotordyn.picture_frame import (
    QUIET_COLOR,
    SMALL_PT,
    WHIRL_STYLES,
    Style,
    add_legend,
    draw_grid,
    name_speeds,
    picture,
    styled,
)
from solidwhirl.rotordyn.resonance_samples import with_knots

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_RPM = 30.0 / np.pi
# Half widths of the bands about an operating speed.
_BANDS = (0.20, 0.15)
# Points of a law's curve.
_CURVE_POINTS = 400
# Markers along it.
_MARKS = 10
# An asymptote higher than this times the highest branch beside it belongs to none that is drawn.
_BESIDE = 1.05


_COEFFICIENTS = {
    "k": Style("#0072B2", "solid", ""),
    "d": Style("#D55E00", (0, (5, 2)), ""),
}


@styled
def draw_critical_speed_map(
    critical_map: CriticalSpeedMap,
    path: str | Path,
    title: str,
    operating_rad_s: Mapping[str, float],
) -> None:
    """Draw critical speeds over the stiffness of bearings to a picture file.

    Parameters
    ----------
    critical_map
        The branches. Whirl shows by colour, dashes and marker. Short lines at the sides are the
        critical speeds without the bearings and with rigid ones.
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf). Replaced when complete.
    title
        Above the diagram.
    operating_rad_s
        Operating speeds by name, as Ω of the reference shaft, rad/s: lines with bands of 15 and
        20 % on both sides.

    Raises
    ------
    AnalysisError
        If the map has no branch, or the suffix is not a kind of picture that can be written.
    """
    rpm = critical_map.speed_rad_s * _RPM
    if not np.isfinite(rpm).any():
        raise AnalysisError("the map has no critical speed to draw")
    stiffness = critical_map.stiffness_n_per_m
    with picture(path, title) as (figure, axes):
        axes.set_xscale("log")
        axes.set_yscale("log")
        for speeds, whirl in zip(rpm, critical_map.whirl, strict=True):
            _draw_branch(axes, stiffness, speeds, whirl)
        _draw_operating(axes, operating_rad_s)
        _draw_asymptotes(axes, critical_map)
        _draw_chosen(axes, critical_map)
        axes.set_xlim(*_log_limits(stiffness, 1.0))
        shown = np.concatenate(
            (rpm[np.isfinite(rpm)], np.array([*operating_rad_s.values()]) * _RPM)
        )
        axes.set_ylim(*_log_limits(shown, 1.3))
        name_speeds(axes.yaxis)
        axes.set_xlabel("stiffness of " + fill(", ".join(critical_map.bearings), 60) + " [N/m]")
        axes.set_ylabel("critical speed of the reference shaft [rpm]")
        draw_grid(axes, "both", "both")
        add_legend(figure, (axes,))


def _log_limits(values: FloatArray, room: float) -> tuple[float, float]:
    """Return limits of a logarithmic axis with room on both sides."""
    low, high = float(values.min()), float(values.max())
    room = max(room, 1.05) if low == high else room
    return low / room, high * room


def _draw_branch(
    axes: Axes, stiffness: FloatArray, rpm: FloatArray, whirl: npt.NDArray[np.str_]
) -> None:
    """Draw one branch in runs of equal whirl."""
    present = np.flatnonzero(np.isfinite(rpm))
    runs = np.split(
        present,
        1 + np.flatnonzero((np.diff(present) > 1) | (whirl[present[1:]] != whirl[present[:-1]])),
    )
    for run in runs:
        style = WHIRL_STYLES[str(whirl[run[0]])]
        # A run is joined to the next one where only the whirl changes.
        following = run[-1] + 1
        joined = following < rpm.size and np.isfinite(rpm[following])
        shown = np.append(run, following) if joined else run
        axes.plot(
            stiffness[shown],
            rpm[shown],
            color=style.color,
            linestyle=style.dashes,
            linewidth=1.6,
            marker=style.marker,
            markerfacecolor=style.face,
            markersize=3.5,
            markevery=max(1, stiffness.size // 10),
            label=str(whirl[run[0]]),
        )


def _draw_operating(axes: Axes, operating_rad_s: Mapping[str, float]) -> None:
    """Draw operating speeds, their bands, and their names outside the frame."""
    for name, speed in operating_rad_s.items():
        rpm = speed * _RPM
        for band, color in zip(_BANDS, ("#F3E6B3", "#EBD37A"), strict=True):
            axes.axhspan(
                rpm * (1 - band),
                rpm * (1 + band),
                color=color,
                zorder=0.5,
                label=f"operating speed ±{100 * band:.0f} %",
            )
        axes.axhline(rpm, color="black", linewidth=0.9, zorder=1.5)
        axes.annotate(
            f"{name}\n{rpm:.0f} rpm",
            (1.0, rpm),
            xycoords=("axes fraction", "data"),
            xytext=(4, 0),
            textcoords="offset points",
            va="center",
            fontsize=SMALL_PT,
            annotation_clip=False,
        )


def _draw_asymptotes(axes: Axes, critical_map: CriticalSpeedMap) -> None:
    """Draw short lines at the sides where branches go: no bearings left, rigid bearings right."""
    drawn, named = critical_map.speed_rad_s, False
    for ends, speeds, whirls, column in (
        ((0.0, 0.06), critical_map.free_rad_s, critical_map.free_whirl, 0),
        ((0.94, 1.0), critical_map.rigid_rad_s, critical_map.rigid_whirl, -1),
    ):
        highest = np.nanmax(np.append(drawn[:, column], 0.0))
        for speed, whirl in zip(speeds, whirls, strict=True):
            if speed > _BESIDE * highest:
                continue
            axes.plot(
                ends,
                [speed * _RPM] * 2,
                transform=axes.get_yaxis_transform(),
                color=WHIRL_STYLES[str(whirl)].color,
                linewidth=4.0,
                alpha=0.35,
                solid_capstyle="butt",
            )
            named = True
    if named:
        axes.plot([], [], color=QUIET_COLOR, linewidth=4.0, alpha=0.35, solid_capstyle="butt",
                  label="without (left), rigid (right)")  # fmt: skip


def _draw_chosen(axes: Axes, critical_map: CriticalSpeedMap) -> None:
    """Mark the stiffness that the bearings have, with their names at the bottom."""
    places: dict[float, list[str]] = {}
    for name, pair in zip(
        critical_map.bearings, critical_map.chosen_stiffness_n_per_m, strict=True
    ):
        same = pair[0] == pair[1]
        for value, mark in zip(pair, ("", "") if same else (" (x)", " (y)"), strict=True):
            if name + mark not in places.setdefault(float(value), []):
                places[float(value)].append(name + mark)
    low, high = critical_map.stiffness_n_per_m[[0, -1]]
    for value, names in places.items():
        if not low <= value <= high:
            continue
        axes.axvline(value, color="#CC79A7", linewidth=1.2, linestyle=(0, (2, 1)), zorder=1.4,
                     label="stiffness as chosen")  # fmt: skip
        axes.annotate(
            ", ".join(names),
            (value, 0.02),
            xycoords=("data", "axes fraction"),
            xytext=(-3, 0),
            textcoords="offset points",
            rotation=90,
            ha="right",
            va="bottom",
            fontsize=SMALL_PT,
        )


@styled
def draw_bearing_law(
    bearing: Bearing,
    speeds_rad_s: npt.ArrayLike,
    path: str | Path,
    title: str,
    operating_rad_s: Mapping[str, float],
) -> None:
    """Draw the stiffness and damping of a bearing over its spin speed to a picture file.

    Parameters
    ----------
    bearing
        With a speed law.
    speeds_rad_s
        Lowest and highest spin speed of its first side to show, rad/s.
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf). Replaced when complete.
    title
        Above the diagram.
    operating_rad_s
        Spin speeds of that side to mark, by name, rad/s.

    Raises
    ------
    AnalysisError
        If the bearing has no law, or the suffix is not a kind of picture that can be written.

    Notes
    -----
    Values are divided by that of xx at the lowest speed shown. The range the law was made for is
    shaded green, and hatched red is where the damping is negative.
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
    rpm = speeds * _RPM
    with picture(path, title) as (figure, axes):
        low, high = (end * _RPM for end in law.speed_range_rad_s)
        axes.axvspan(low, high, color="#DDF0E8", zorder=0.2, label=f"range of {law.name}")
        damping = np.array([pair.damping_n_s_per_m for pair in found])
        _draw_coefficients(axes, rpm, np.array([p.stiffness_n_per_m for p in found]), "k", "N/m")
        _draw_coefficients(axes, rpm, damping, "d", "N s/m")
        _hatch_negative(axes, rpm, damping)
        _mark_speeds(axes, operating_rad_s)
        axes.axhline(0.0, color="black", linewidth=0.6)
        axes.set_xlim(float(rpm[0]), float(rpm[-1]))
        name_speeds(axes.xaxis)
        axes.set_xlabel(f"spin speed of {bearing.first.body} [rpm]")
        axes.set_ylabel("coefficient over its xx value\nat the lowest speed [1]")
        draw_grid(axes, "major", "both")
        add_legend(figure, (axes,))


def _hatch_negative(axes: Axes, rpm: FloatArray, damping: FloatArray) -> None:
    """Hatch where the symmetric part of the damping (s, 2, 2) has a negative eigenvalue."""
    lowest = np.linalg.eigvalsh(0.5 * (damping + damping.transpose(0, 2, 1)))[:, 0]
    negative = lowest < -1e-12 * np.abs(damping).max(initial=0.0)
    if not negative.any():
        return
    axes.fill_between(
        rpm,
        0.0,
        1.0,
        where=negative.tolist(),
        transform=axes.get_xaxis_transform(),
        facecolor="none",
        edgecolor="#D55E00",
        alpha=0.45,
        hatch="///",
        linewidth=0.0,
        zorder=0.4,
        label="negative damping",
    )


def _mark_speeds(axes: Axes, speeds_rad_s: Mapping[str, float]) -> None:
    """Draw upright lines at speeds with their names."""
    for name, speed in speeds_rad_s.items():
        axes.axvline(speed * _RPM, color="black", linewidth=0.9)
        axes.annotate(
            name,
            (speed * _RPM, 0.98),
            xycoords=("data", "axes fraction"),
            xytext=(-3, 0),
            textcoords="offset points",
            rotation=90,
            ha="right",
            va="top",
            fontsize=SMALL_PT,
        )


def _draw_coefficients(
    axes: Axes, rpm: FloatArray, matrices: FloatArray, symbol: str, unit: str
) -> None:
    """Draw the entries of (s, 2, 2) that are not zero, over xx at the first speed."""
    reference = float(matrices[0, 0, 0])
    if reference == 0:
        reference = float(np.abs(matrices).max(initial=0.0))
    if reference == 0:
        return
    style = _COEFFICIENTS[symbol]
    pairs = (
        ("xx", 0, 0, 2.0, ""),
        ("yy", 1, 1, 1.0, "s"),
        ("xy", 0, 1, 0.8, "^"),
        ("yx", 1, 0, 0.8, "v"),
    )
    apart = max(1, rpm.size // _MARKS)
    for name, row, column, width, marker in pairs:
        curve = matrices[:, row, column] / reference
        if not curve.any():
            continue
        label = f"{symbol}$_{{{name}}}$"
        axes.plot(
            rpm,
            curve,
            color=style.color,
            linestyle=style.dashes,
            linewidth=width,
            marker=marker,
            markersize=4.0,
            markerfacecolor="white",
            markevery=(apart // 2, apart),
            label=f"{label} ({reference:.3g} {unit})" if name == "xx" else label,
        )
