"""Pictures of modes: in the frame of a body, along the axis, and by what takes part in them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from solidwhirl.rotordyn.arrays import BoolArray, FloatArray
from solidwhirl.rotordyn.errors import AnalysisError
from solidwhirl.rotordyn.frames import RotatingCampbell
from solidwhirl.rotordyn.mode_shapes import BodyShape, ModeShapes
from solidwhirl.rotordyn.picture_frame import (
    COLORS,
    DASHES,
    MARKERS,
    SMALL_PT,
    TEXT_PT,
    TITLE_PT,
    TWO_COLUMNS_MM,
    draw_grid,
    mode_name,
    name_speeds,
    new_figure,
    styled,
    write_figure,
)

_T = TypeVar("_T")

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

# Width of a letter of a label, as a fraction of the length of the body.
_LABEL_WIDTH = 0.014
_RPM = 30.0 / np.pi
# Components and bodies with a smaller part of a branch are not drawn.
_SMALL = 0.05
# Modes drawn in one picture at most.
_MOST_MODES = 16
# Height on a page for the frames of modes.
_PAGE_MM = 215.0


@styled
def draw_rotating_campbell(
    frames: Sequence[RotatingCampbell], path: str | Path, title: str
) -> None:
    """Draw the frequencies that turning bodies see over their own speeds.

    Parameters
    ----------
    frames
        One for each body, as in Müller and Hennings, figure 11. A component is drawn where it
        and the body have a part of 5 % and more in the branch, or where that is not known.
        Full lines turn with the body's spin in its own frame, dashed ones against it: a forward
        whirl slower than the body is dashed, after its mirror at zero.
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf). Replaced when complete.
    title
        Above the diagram.

    Raises
    ------
    AnalysisError
        If no body turns, or the suffix is not a kind of picture that can be written.
    """
    from matplotlib.lines import Line2D

    turning = [frame for frame in frames if frame.speed_ratio != 0]
    if not turning:
        raise AnalysisError("no body turns; there is no rotating frame to draw in")
    figure = new_figure(path)
    axes = figure.add_subplot()
    handles = []
    for place, frame in enumerate(turning):
        color, marker = _cycle(COLORS, place), _cycle(MARKERS, place)
        # Bodies that move together see the same frequencies: the first lines show below others.
        width = 1.2 + 1.4 * (len(turning) - 1 - place) / max(1, len(turning) - 1)
        _draw_frame(axes, frame, width, (color, marker))
        name = frame.body or f"frame at {frame.speed_ratio:g} times the speed"
        handles.append(Line2D([], [], color=color, marker=marker, markersize=4, label=name))
    fastest = max(float(np.abs(frame.spin_rad_s).max()) for frame in turning) * _RPM
    drawn = np.concatenate([frame.frequency_hz[_drawn(frame)] for frame in turning])
    top = 1.05 * float(np.nanmax(drawn, initial=1.0))
    end = min(fastest, 60.0 * top)
    axes.plot([0.0, end], [0.0, end / 60.0], color="black", linewidth=0.8, linestyle=(0, (1, 2)))
    handles += [
        Line2D([], [], color="#595959", label="turns with the spin"),
        Line2D([], [], color="#595959", linestyle=DASHES[1], label="turns against it"),
        Line2D([], [], color="black", linewidth=0.8, linestyle=(0, (1, 2)), label="force at rest"),
    ]
    axes.set_xlim(0.0, fastest)
    axes.set_ylim(0.0, top)
    name_speeds(axes.xaxis)
    axes.set_xlabel("speed of the body [rpm]")
    axes.set_ylabel("frequency in the frame of the body [Hz]")
    axes.set_title(fill(title, 60), fontsize=TITLE_PT)
    draw_grid(axes)
    figure.legend(handles=handles, loc="outside right upper", frameon=False, fontsize=SMALL_PT,
                  handlelength=2.6)  # fmt: skip
    write_figure(figure, path)


@styled
def draw_mode_shapes(shapes: ModeShapes, path: str | Path, title: str) -> None:
    """Draw the lateral deflection of every body along the axis, one frame for each mode.

    Parameters
    ----------
    shapes
        At most 16 modes; compute fewer for more.
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf). Replaced when complete.
    title
        Above the frames.

    Raises
    ------
    AnalysisError
        If there are no modes or too many, or the suffix is not a kind of picture that can be
        written.
    """
    count = _mode_count(shapes)
    columns = 1 if count == 1 else 2
    rows = -(-count // columns)
    height = 25.0 + rows * min(37.0, _PAGE_MM / rows)
    figure = new_figure(path, TWO_COLUMNS_MM, max(90.0, height))
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    frames = list(grid.flat)
    for mode, axes in enumerate(frames[:count]):
        for place, body in enumerate(shapes.bodies):
            _draw_body(axes, body, mode, place)
        axes.axhline(0.0, color="black", linewidth=0.6)
        axes.set_ylim(-1.12, 1.12)
        axes.set_title(_mode_title(shapes, mode), fontsize=TEXT_PT)
        draw_grid(axes)
    for unused in frames[count:]:
        unused.set_visible(False)
    for axes in frames[max(0, count - columns) : count]:
        axes.set_xlabel("axial position [m]")
        axes.tick_params(labelbottom=True)
    figure.supylabel("lateral deflection, largest orbit 1 [1]", fontsize=TEXT_PT)
    figure.suptitle(fill(title, 80), fontsize=TITLE_PT)
    handles = [_body_row(body, place) for place, body in enumerate(shapes.bodies)]
    columns = min(4, max(1, len(handles)))
    figure.legend(
        handles=handles, loc="outside lower center", ncols=columns, frameon=False,
        fontsize=SMALL_PT, handlelength=3.2,
    )  # fmt: skip
    write_figure(figure, path)


@styled
def draw_body_modes(shapes: ModeShapes, body: str, path: str | Path, title: str) -> None:
    """Draw the lateral deflection of one body in several modes over each other.

    Parameters
    ----------
    shapes
        At most 16 modes; each is scaled to the largest orbit of all bodies.
    body
        Name of the body, such as the low-pressure unit of Müller and Hennings, figures 12, 13.
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf). Replaced when complete.
    title
        Above the diagram.

    Raises
    ------
    AnalysisError
        If there are no modes or too many, no such body, or the suffix is not a kind of picture
        that can be written.
    """
    shape, count = shapes.body(body), _mode_count(shapes)
    figure = new_figure(path)
    axes = figure.add_subplot()
    for mode in range(count):
        axes.plot(
            shape.axial_m,
            shape.deflection[:, mode],
            color=_cycle(COLORS, mode),
            linestyle=_cycle(DASHES, mode),
            linewidth=1.5,
            marker=_cycle(MARKERS, mode),
            markersize=4,
            # a colour that comes again has open markers
            markerfacecolor=_cycle(COLORS, mode) if mode < len(COLORS) else "white",
            markevery=(3 * mode % 7, max(1, shape.axial_m.size // 8)),
            label=_mode_title(shapes, mode),
        )
    _draw_interfaces(axes, shape)
    axes.axhline(0.0, color="black", linewidth=0.6)
    axes.set_ylim(-1.12, 1.12)
    axes.set_xlabel("axial position [m]")
    axes.set_ylabel("lateral deflection, largest orbit 1 [1]")
    axes.set_title(fill(title, 60), pad=18.0, fontsize=TITLE_PT)
    draw_grid(axes)
    figure.legend(loc="outside right upper", frameon=False, fontsize=SMALL_PT, handlelength=3.2)
    write_figure(figure, path)


def _draw_interfaces(axes: Axes, shape: BodyShape) -> None:
    """Draw a line at each interface; names that would touch the one before are left out."""
    room = _LABEL_WIDTH * float(np.ptp(shape.axial_m))
    last = -np.inf
    for k in np.argsort(shape.interface_axial_m):
        name, place = shape.interfaces[k], float(shape.interface_axial_m[k])
        axes.axvline(place, color="#7F7F7F", linewidth=0.7, linestyle=(0, (2, 2)), zorder=0.8)
        half = 0.5 * room * len(name)
        if place - half < last:
            continue
        last = place + half
        axes.annotate(
            name, (place, 1.12), xytext=(0, 2), textcoords="offset points", ha="center",
            va="bottom", fontsize=SMALL_PT, annotation_clip=False,
        )  # fmt: skip


def _mode_count(shapes: ModeShapes) -> int:
    count = shapes.eigenvalues.size
    if not 1 <= count <= _MOST_MODES:
        raise AnalysisError(f"there are {count} modes; 1 to {_MOST_MODES} can be drawn")
    return int(count)


def _mode_title(shapes: ModeShapes, mode: int) -> str:
    name = mode_name(shapes.numbers, mode)
    return f"{name}: {shapes.frequency_hz[mode]:.4g} Hz {shapes.whirl[mode]}"


def _draw_body(axes: Axes, body: BodyShape, mode: int, place: int) -> None:
    """Draw the centre line of one body and its interface nodes."""
    color = _cycle(COLORS, place)
    axes.plot(
        body.axial_m,
        body.deflection[:, mode],
        color=color,
        linestyle=_cycle(DASHES, place),
        linewidth=1.5,
        label=body.body,
    )
    axes.plot(
        body.interface_axial_m,
        body.interface_deflection[:, mode],
        color=color,
        linestyle="none",
        marker=_cycle(MARKERS, place),
        markersize=4.5,
        markerfacecolor="white",
    )


def _body_row(body: BodyShape, place: int) -> Line2D:
    """Row of a body in a legend: its line and the mark of its interface nodes."""
    from matplotlib.lines import Line2D

    return Line2D(
        [], [], color=_cycle(COLORS, place), linestyle=_cycle(DASHES, place), linewidth=1.5,
        marker=_cycle(MARKERS, place), markersize=4.5, markerfacecolor="white", label=body.body,
    )  # fmt: skip


def _drawn(frame: RotatingCampbell) -> BoolArray:
    """Return which points of the components belong in the picture, shape (c, b, s)."""
    large = np.nan_to_num(frame.share, nan=1.0) >= _SMALL
    large &= np.nan_to_num(frame.body_share, nan=1.0) >= _SMALL
    return np.asarray(large & np.isfinite(frame.signed_hz))


def _draw_frame(axes: Axes, frame: RotatingCampbell, width: float, look: tuple[str, str]) -> None:
    """Draw the components of one body, step by step where both ends are drawn."""
    rpm = np.abs(frame.spin_rad_s) * _RPM
    sense = np.sign(frame.speed_ratio) * np.where(frame.speeds_rad_s < 0, -1.0, 1.0)
    drawn = _drawn(frame)
    for component in range(frame.orders.size):
        for branch in range(frame.signed_hz.shape[1]):
            signed = frame.signed_hz[component, branch] * sense
            kept = drawn[component, branch]
            for start, stop in _runs(kept[:-1] & kept[1:]):
                x, y = _with_zero(rpm[start : stop + 1], signed[start : stop + 1])
                for side, dashes in ((1.0, DASHES[0]), (-1.0, DASHES[1])):
                    if not (side * y > 0).any():
                        continue
                    axes.plot(
                        x,
                        np.where(side * y >= 0, np.abs(y), np.nan),
                        color=look[0],
                        linestyle=dashes,
                        linewidth=width,
                        marker=look[1],
                        markersize=3.5,
                        markevery=max(1, rpm.size // 8),
                    )


def _runs(flags: BoolArray) -> list[tuple[int, int]]:
    """Return begin and end of the runs of true steps."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flags, [False])).astype(int)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _with_zero(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a line with the points added at which it passes zero."""
    at = np.flatnonzero(y[:-1] * y[1:] < 0)
    part = y[at] / (y[at] - y[at + 1])
    return (
        np.insert(x, at + 1, x[at] + part * (x[at + 1] - x[at])),
        np.insert(y, at + 1, 0.0),
    )


def _cycle(values: Sequence[_T], place: int) -> _T:
    return values[place % len(values)]
