"""Pictures of response maps: place of the unbalance, ground motion, support stiffness."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.errors import AnalysisError
from solidwhirl.rotordyn.parts import End
from solidwhirl.rotordyn.picture_frame import (
    SMALL_PT,
    TITLE_PT,
    add_legend,
    name_speeds,
    number_text,
    styled,
)
from solidwhirl.rotordyn.pictures_response import Picture, new_picture
from solidwhirl.rotordyn.response_maps import GroundMotionMap, PlaceMap, StepPeaks, shown_range
from solidwhirl.rotordyn.response_maps_stiffness import StiffnessChoice, StiffnessMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_RPM = 30.0 / np.pi
_HZ = 0.5 / np.pi
_MICRO = 1e6


@styled
def draw_place_map(place_map: PlaceMap, node: End, path: str | Path, title: str) -> None:
    """Draw the response of a node over the speed and the place of the unbalance.

    Parameters
    ----------
    place_map
        The map, at rising speeds.
    node
        Where the response is shown.
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf). Replaced when complete.
    title
        Above the picture.

    Raises
    ------
    AnalysisError
        If the map does not have the node, or the file cannot be of that kind.
    """
    if node not in place_map.nodes:
        known = [other.label for other in place_map.nodes]
        raise AnalysisError(f"the map has no node {node.label}; it has {known}")
    height = _MICRO * place_map.major_m()[:, :, place_map.nodes.index(node)]
    picture = new_picture(path)
    axes = picture.figure.add_subplot()
    rows = np.arange(float(len(place_map.places)))
    frequencies = place_map.frequencies_rad_s
    if (frequencies == frequencies[0]).all():
        x, label = frequencies[0] * _HZ, "frequency of the unbalance [Hz]"
    else:
        x, label = place_map.speeds_rad_s * _RPM, "speed of the reference shaft [rpm]"
    _heat(picture, axes, x, rows, height, f"major semi-axis at {node.label} [µm]")
    axes.set_yticks(rows, [place.label for place in place_map.places], fontsize=SMALL_PT)
    if label.endswith("[rpm]"):
        name_speeds(axes.xaxis)
    axes.set_xlabel(label)
    axes.set_ylabel("place of the unbalance")
    axes.set_title(fill(title, 60), fontsize=TITLE_PT)
    picture.save()


@styled
def draw_ground_motion(
    ground_map: GroundMotionMap, path: str | Path, title: str, peaks: StepPeaks | None = None
) -> None:
    """Draw the response to ground motion over frequency and speed (waterfall diagram).

    Parameters
    ----------
    ground_map
        The map, at rising speeds and frequencies. The colour is the major semi-axis over the
        amplitude of the ground; a line marks the frequency of the reference shaft's turn.
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf). Replaced when complete.
    title
        Above the picture.
    peaks
        Of `ground_motion_peaks`: the highest response in each step is shown. None shows that at
        the frequencies of the map, which may miss sharp resonances.

    Raises
    ------
    AnalysisError
        If the amplitude of the ground is zero, or the file cannot be of that kind.
    """
    if ground_map.amplitude_m == 0:
        raise AnalysisError("amplitude_m of the map is 0; there is no motion to compare with")
    picture = new_picture(path)
    axes = picture.figure.add_subplot()
    hertz, rpm = ground_map.frequencies_rad_s * _HZ, ground_map.speeds_rad_s * _RPM
    height = ground_map.major_m() if peaks is None else peaks.height_m
    ratio = height / abs(ground_map.amplitude_m)
    label = f"major semi-axis at {ground_map.node.label} / motion of the ground"
    _heat(picture, axes, hertz, rpm, ratio, label)
    limits = axes.get_xlim(), axes.get_ylim()
    turn = [0.0, rpm[-1]]
    axes.plot(np.divide(turn, 60.0), turn, label="1/rev of the reference shaft", **_on_colors())
    axes.set(xlim=limits[0], ylim=limits[1])
    name_speeds(axes.yaxis)
    add_legend(picture.figure, (axes,), place="outside lower center", columns=2)
    axes.set_xlabel(f"frequency of the ground along {ground_map.direction} [Hz]")
    axes.set_ylabel("speed of the reference shaft [rpm]")
    axes.set_title(fill(title, 60), fontsize=TITLE_PT)
    picture.save()


@styled
def draw_stiffness_map(
    stiffness_map: StiffnessMap,
    path: str | Path,
    title: str,
    choice: StiffnessChoice | None = None,
    peaks: StepPeaks | None = None,
) -> None:
    """Draw the response over frequency and support stiffness (design of experiments).

    Parameters
    ----------
    stiffness_map
        The map, at rising frequencies and stiffness.
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf). Replaced when complete.
    title
        Above the picture.
    choice
        Its band and stiffness are marked; None marks nothing.
    peaks
        Of `stiffness_map_peaks`, as in `draw_ground_motion`.

    Raises
    ------
    AnalysisError
        If the file cannot be of that kind.
    """
    picture = new_picture(path)
    axes = picture.figure.add_subplot()
    hertz, stiffness = stiffness_map.frequencies_rad_s * _HZ, stiffness_map.stiffness_n_per_m
    height = _MICRO * (stiffness_map.major_m() if peaks is None else peaks.height_m)
    label = f"major semi-axis at {stiffness_map.node.label} [µm]"
    axes.set_yscale("log")
    _heat(picture, axes, hertz, stiffness, height, label)
    if choice is not None:
        for edge in choice.band_rad_s:
            axes.axvline(edge * _HZ, label="band about the operating speed", **_on_colors())
        middle = 0.5 * sum(choice.band_rad_s) * _HZ
        value = choice.stiffness_n_per_m
        axes.plot(
            middle, value, marker="o", markersize=8, markerfacecolor="white",
            markeredgecolor="black", clip_on=False, linestyle="none", label="stiffness chosen",
        )  # fmt: skip
        axes.annotate(
            f"{number_text(value)} N/m",
            (middle, value),
            xytext=(0, 9 if value < 0.5 * stiffness[-1] else -17),
            textcoords="offset points",
            ha="center",
            fontsize=SMALL_PT,
            bbox={"boxstyle": "round,pad=0.2", "facecolor": "white", "edgecolor": "none"},
        )
    add_legend(picture.figure, (axes,), place="outside lower center", columns=2)
    axes.set_xlabel("frequency of the force [Hz]")
    axes.set_ylabel("stiffness of " + fill(", ".join(stiffness_map.bearings), 40) + " [N/m]")
    axes.set_title(fill(title, 60), fontsize=TITLE_PT)
    picture.save()


def _on_colors() -> dict[str, Any]:
    """Style of a line that is seen on dark and on bright colours, and on paper."""
    from matplotlib.patheffects import withStroke

    edge = withStroke(linewidth=2.4, foreground="black")
    return {"color": "white", "linewidth": 1.1, "linestyle": (0, (5, 2)), "path_effects": [edge]}


def _heat(
    picture: Picture, axes: Axes, x: FloatArray, y: FloatArray, height: FloatArray, label: str
) -> None:
    """Draw heights (y, x) with a logarithmic, perceptually uniform scale of colours."""
    from matplotlib.colors import LogNorm

    bottom, top = shown_range(height)
    along = np.exp(_edges(np.log(y))) if axes.get_yscale() == "log" else _edges(y)
    mesh = axes.pcolormesh(
        _edges(x),
        along,
        np.where(height > 0, height, np.nan),
        norm=LogNorm(vmin=bottom, vmax=top),
        cmap="viridis",
        rasterized=True,
    )
    below, above = np.nanmin(height[height > 0]) < bottom, np.nanmax(height) > top
    extend = ("neither", "min", "max", "both")[int(below) + 2 * int(above)]
    bar = picture.figure.colorbar(mesh, ax=axes, extend=extend)
    bar.set_label(label)


def _edges(centers: FloatArray) -> FloatArray:
    """Return the edges of cells around rising centres; a single one gets a width of 1."""
    if not (np.diff(centers) > 0).all():
        raise AnalysisError("the speeds, frequencies and stiffness of a map must rise to be drawn")
    if centers.size == 1:
        return np.asarray(centers[0] + np.array([-0.5, 0.5]))
    middle = 0.5 * (centers[1:] + centers[:-1])
    first, last = 2.0 * centers[0] - middle[0], 2.0 * centers[-1] - middle[-1]
    return np.concatenate(([first], middle, [last]))
