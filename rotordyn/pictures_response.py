"""Pictures of the unbalance response: amplitude and phase, orbits, bearing forces."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from solidwhirl.rotordyn.arrays import ComplexArray, FloatArray
from solidwhirl.rotordyn.errors import AnalysisError
from solidwhirl.rotordyn.orbits import elliptic_orbits
from solidwhirl.rotordyn.parts import End
from solidwhirl.rotordyn.picture_frame import (
    COLORS,
    DASHES,
    MARKERS,
    ONE_COLUMN_MM,
    SMALL_PT,
    TEXT_PT,
    TITLE_PT,
    TWO_COLUMNS_MM,
    USUAL_HEIGHT_MM,
    Dashes,
    draw_grid,
    name_speeds,
    new_figure,
    styled,
    write_figure,
)
from solidwhirl.rotordyn.unbalance import ExciterResponse, UnbalanceResponse
from solidwhirl.rotordyn.unbalance_peaks import resonance_peaks

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_RPM = 30.0 / np.pi
_MICRO = 1e6
# Colours by node or bearing; dashes by exciter.
# Markers go with the colours.
_COLORS, _DASHES, _MARKERS = COLORS[:7], DASHES[:4], MARKERS[:7]
# A peak is labelled if it rises by this factor above its saddles.
_LABELLED = 2.0
_MOST_LABELS = 12
# Labels nearer than this fraction of the axis would cover each other.
_LABEL_WIDTH = 0.02
# Orbits smaller than this fraction of the largest beside them get no dot and arrow.
_SMALL_ORBIT = 0.15
_MOST_ORBITS = 8


class Picture(NamedTuple):
    """A figure and the file it is for."""

    figure: Figure
    target: Path

    def save(self) -> None:
        """Write the file; it is replaced when complete."""
        write_figure(self.figure, self.target)


def new_picture(
    path: str | Path, width_mm: float = TWO_COLUMNS_MM, height_mm: float = USUAL_HEIGHT_MM
) -> Picture:
    """Begin a picture.

    Parameters
    ----------
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf).
    width_mm, height_mm
        Size.

    Returns
    -------
    Picture
        With an empty figure.

    Raises
    ------
    AnalysisError
        If the suffix is not a kind of picture that can be written.
    """
    return Picture(new_figure(path, width_mm, height_mm), Path(path))


@styled
def draw_unbalance_response(
    response: UnbalanceResponse, nodes: Sequence[End], path: str | Path, title: str
) -> None:
    """Draw amplitude and phase of some nodes over the speed.

    Parameters
    ----------
    response
        At rising speeds. Nodes are told apart by colour, exciters by dashes.
    nodes
        One to seven.
    path
        The file; its suffix chooses the kind. Replaced when complete.
    title
        Above the picture.

    Raises
    ------
    AnalysisError
        If a node is unknown, there are none or too many, or the file cannot be of that kind.
    """
    _check_count("nodes", len(nodes))
    picture = new_picture(path)
    upper, lower = picture.figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
    rpm = response.speeds_rad_s * _RPM
    labels: list[tuple[float, float]] = []
    for dashes, exciter in zip(_dashes(response), response.exciters, strict=True):
        for place, node in enumerate(nodes):
            motion = exciter.at_node(node.body, node.interface)
            style = _line_style(place, dashes, rpm.size)
            height = _MICRO * _major(motion)
            upper.plot(rpm, np.where(height > 0, height, np.nan), **style)
            lower.plot(rpm, _phase(motion[:, 0]), **style)
            labels += _peak_labels(exciter, height)
    _scale_heights(upper)
    _label_peaks(upper, labels, rpm)
    upper.set_ylabel("major semi-axis [µm]")
    lower.set_ylabel("phase of ux [°]")
    lower.set_ylim(-190.0, 190.0)
    lower.set_yticks([-180, -90, 0, 90, 180])
    _finish(picture, (upper, lower), rpm, title)
    _legend(picture.figure, response, [node.label for node in nodes])
    picture.save()


@styled
def draw_bearing_forces(response: UnbalanceResponse, path: str | Path, title: str) -> None:
    """Draw the lateral force that each bearing transmits over the speed.

    Parameters
    ----------
    response
        With one to seven bearings, told apart by colour; exciters by dashes.
    path
        The file; its suffix chooses the kind. Replaced when complete.
    title
        Above the picture.

    Raises
    ------
    AnalysisError
        If there are no bearings or too many, or the file cannot be of that kind.
    """
    names = list(response.exciters[0].bearing_forces)
    _check_count("bearings", len(names))
    picture = new_picture(path)
    axes = picture.figure.add_subplot()
    rpm = response.speeds_rad_s * _RPM
    labels: list[tuple[float, float]] = []
    for dashes, exciter in zip(_dashes(response), response.exciters, strict=True):
        for place, name in enumerate(names):
            height = _major(exciter.bearing_forces[name][:, :2])
            shown = np.where(height > 0, height, np.nan)
            axes.plot(rpm, shown, **_line_style(place, dashes, rpm.size))
            labels += _peak_labels(exciter, height)
    _scale_heights(axes)
    _label_peaks(axes, labels, rpm)
    axes.set_ylabel("largest lateral force [N]")
    _finish(picture, (axes,), rpm, title)
    _legend(picture.figure, response, names)
    picture.save()


@styled
def draw_orbits(
    response: UnbalanceResponse,
    nodes: Sequence[End],
    speeds_rad_s: Sequence[float],
    path: str | Path,
    title: str,
) -> None:
    """Draw the orbits of some nodes at some speeds, each in a square of its own scale.

    Parameters
    ----------
    response
        Must hold the speeds. Nodes are told apart by colour, exciters by dashes.
    nodes
        One to seven.
    speeds_rad_s
        One to eight of the speeds of the response, rad/s.
    path
        The file; its suffix chooses the kind. Replaced when complete.
    title
        Above the picture. The mark of the node is at the time 0, an arrow the sense of the turn.

    Raises
    ------
    AnalysisError
        If a node or speed is unknown, there are none or too many, or the file cannot be of that
        kind.
    """
    _check_count("nodes", len(nodes))
    if not 1 <= len(speeds_rad_s) <= _MOST_ORBITS:
        raise AnalysisError(f"{len(speeds_rad_s)} speeds; 1 to {_MOST_ORBITS} can be drawn")
    places = [_place_of(response, float(speed)) for speed in speeds_rad_s]
    columns = min(4, len(places))
    rows = -(-len(places) // columns)
    width = ONE_COLUMN_MM if columns == 1 else TWO_COLUMNS_MM
    picture = new_picture(path, width, 24.0 + rows * (6.0 + 0.9 * width / columns))
    grid = picture.figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in grid[len(places) :]:
        axes.set_axis_off()
    for axes, at in zip(grid, places, strict=False):
        motions = [
            [_MICRO * e.at_node(node.body, node.interface)[at] for node in nodes]
            for e in response.exciters
        ]
        reach = float(np.nanmax(_major(np.array(motions)))) or 1.0
        for dashes, group in zip(_dashes(response), motions, strict=True):
            for look, motion in zip(zip(_COLORS, _MARKERS, strict=True), group, strict=False):
                _draw_orbit(axes, motion, look, dashes, _SMALL_ORBIT * reach)
        reach *= 1.15
        axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
        axes.set_title(f"{response.speeds_rad_s[at] * _RPM:.0f} rpm", fontsize=TEXT_PT)
        axes.locator_params(nbins=4, steps=[1, 2, 5, 10])
        draw_grid(axes)
    for axes in grid[max(0, len(places) - columns) : len(places)]:
        axes.set_xlabel("x [µm]", fontsize=TEXT_PT)
    picture.figure.supylabel("y [µm]", fontsize=TEXT_PT)
    picture.figure.suptitle(fill(title, int(0.45 * width)), fontsize=TITLE_PT)
    names, beside = [node.label for node in nodes], 2 if columns == 1 else 4
    _legend(picture.figure, response, names, "outside lower center", beside)
    picture.save()


def _check_count(what: str, count: int) -> None:
    if not 1 <= count <= len(_COLORS):
        raise AnalysisError(f"{count} {what}; 1 to {len(_COLORS)} can be told apart in a picture")


def _dashes(response: UnbalanceResponse) -> list[Dashes]:
    return [_DASHES[k % len(_DASHES)] for k in range(len(response.exciters))]


def _line_style(place: int, dashes: Dashes, points: int) -> dict[str, Any]:
    """Return the style of a curve: colour and marker by its place, markers of curves apart."""
    apart = max(1, points // 9)
    return {
        "color": _COLORS[place],
        "linestyle": dashes,
        "linewidth": 1.3,
        "marker": _MARKERS[place],
        "markersize": 3.2,
        "markevery": (place * apart // len(_COLORS), apart),
    }


def _major(motion: ComplexArray) -> FloatArray:
    """Return the major semi-axis of (x, y) amplitudes, of any unit."""
    return elliptic_orbits(motion[..., 0], motion[..., 1]).major_m


def _phase(motion: ComplexArray) -> FloatArray:
    """Return a phase in degrees with a gap where it leaves at one side, and where there is none."""
    phase = np.where(motion == 0, np.nan, np.degrees(np.angle(motion)))
    jump = np.flatnonzero(np.abs(np.diff(phase)) > 180.0)
    phase[jump + 1] = np.nan
    return phase


def _peak_labels(exciter: ExciterResponse, height: FloatArray) -> list[tuple[float, float]]:
    """Return rpm and height as drawn of a curve's peaks; none of a curve with too few speeds."""
    if exciter.speeds_rad_s.size < 3:
        return []
    peaks = resonance_peaks(exciter.speeds_rad_s, height, _LABELLED)
    places = np.array([peak.position_rad_s for peak in peaks])
    drawn = np.interp(places, exciter.speeds_rad_s, height)
    return list(zip((_RPM * places).tolist(), drawn.tolist(), strict=True))


def _label_peaks(axes: Axes, labels: list[tuple[float, float]], rpm: FloatArray) -> None:
    """Write the speed of the highest peaks upright; one label where several curves peak."""
    width = _LABEL_WIDTH * float(np.ptp(rpm))
    written: list[float] = []
    for place, height in sorted(labels, key=lambda label: -label[1]):
        if any(abs(place - other) < width for other in written):
            continue
        if len(written) == _MOST_LABELS:
            return
        written.append(place)
        axes.annotate(
            f"{place:.0f}",
            (place, height),
            xytext=(0, 3),
            textcoords="offset points",
            ha="center",
            va="bottom",
            rotation=90,
            fontsize=SMALL_PT,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.4},
        )


def _scale_heights(axes: Axes) -> None:
    """Set a logarithmic axis over the highest six decades, with room for labels above."""
    axes.set_yscale("log")
    heights = np.concatenate([np.asarray(line.get_ydata(), dtype=float) for line in axes.lines])
    heights = heights[np.isfinite(heights)]
    if heights.size:
        top = float(heights.max())
        bottom = max(float(heights.min()), 1e-6 * top)
        axes.set_ylim(0.7 * bottom, top * (top / bottom) ** 0.19 * 1.2)


def _finish(picture: Picture, panels: Sequence[Axes], rpm: FloatArray, title: str) -> None:
    """Set what all curves over the speed have in common."""
    for axes in panels:
        draw_grid(axes)
    low, high = float(rpm.min()), float(rpm.max())
    panels[-1].set_xlim(low, max(high, low + 1.0))
    name_speeds(panels[-1].xaxis)
    picture.figure.align_ylabels()
    panels[-1].set_xlabel("speed of the reference shaft [rpm]")
    panels[0].set_title(fill(title, 60), fontsize=TITLE_PT)


def _legend(
    figure: Figure,
    response: UnbalanceResponse,
    names: Sequence[str],
    place: str = "outside right upper",
    columns: int = 1,
) -> None:
    """Tell the colours, and the dashes where there is more than one exciter."""
    from matplotlib.lines import Line2D

    rows = [
        (Line2D([], [], color=color, linewidth=1.3, marker=mark, markersize=3.2), name)
        for color, mark, name in zip(_COLORS, _MARKERS, names, strict=False)
    ]
    for dashes, exciter in zip(_dashes(response), response.exciters, strict=True):
        text = f"excited by {', '.join(exciter.bodies)}, {exciter.frequency_ratio:g}×"
        rows.append((Line2D([], [], color="#595959", linestyle=dashes, linewidth=1.4), text))
    figure.legend(
        [line for line, _ in rows],
        [text for _, text in rows],
        loc=place,
        ncols=columns,
        frameon=False,
        fontsize=SMALL_PT,
        handlelength=3.2,
    )


def _draw_orbit(
    axes: Axes, motion: ComplexArray, look: tuple[str, str], dashes: Dashes, small: float
) -> None:
    """Draw one ellipse, unless small with its mark at the time 0 and an arrow a third later."""
    color, marker = look
    turn = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 181))
    x, y = (turn * motion[0]).real, (turn * motion[1]).real
    if not np.isfinite(x).all():
        return
    axes.plot(x, y, color=color, linestyle=dashes, linewidth=1.3)
    if _major(motion[None])[0] < small:
        return
    axes.plot(x[0], y[0], color=color, marker=marker, markersize=4.5)
    axes.annotate(
        "",
        (x[62], y[62]),
        (x[58], y[58]),
        arrowprops={"arrowstyle": "-|>", "color": color, "linewidth": 0.0, "mutation_scale": 11},
    )


def _place_of(response: UnbalanceResponse, speed: float) -> int:
    speeds = response.speeds_rad_s
    at = int(np.abs(speeds - speed).argmin())
    if abs(speeds[at] - speed) > 1e-9 * max(abs(speed), 1.0):
        raise AnalysisError(
            f"speed {speed:.10g} rad/s is not one of the response; the nearest is "
            f"{speeds[at]:.10g} rad/s"
        )
    return at
