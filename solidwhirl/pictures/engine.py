"""The drawing of an engine to scale, for print."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from textwrap import fill, wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from solidwhirl.drawing.bodies import Silhouette
from solidwhirl.drawing.engine import engine_caption, engine_drawing, joint_labels, node_labels
from solidwhirl.drawing.shapes import SIZE, Circle, Group, Line, Polygon, Shape, Style, Words
from solidwhirl.rotordyn.plots import frame
from solidwhirl.scene.records import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Hatches of cross-sections, which tell bodies apart without colour.
_HATCHES = ("////", "\\\\\\\\", "----", "||||", "//", "\\\\", "--", "||")
# Points and mm of a unit of the drawing, by the size of its letters; height of the title, mm.
_POINT = frame.SMALL_PT / SIZE
_MM = _POINT * 25.4 / 72.0
_TITLE_MM, _LINE_MM, _TALLEST_MM = 10.0, 3.4, 190.0
# Letters of the caption in a line.
_LETTERS = 125


@frame.styled
def draw_engine(scene: Scene, bodies: Sequence[Silhouette], path: Path, title: str) -> None:
    """Draw the engine of a scene to scale; the suffix chooses the kind of file (.png, .svg, .pdf).

    `bodies`: what is seen of each, as of `silhouettes_of` of a run.

    Bodies with a shape are cut along the axis; those without one, such as a rigid casing, are a bar
    around them. Rigid disks are shown as the uniform thin disk with their polar inertia,
    √(2 Ip / m). Node names stand above, bearings and gears below.
    """
    size, above = (frame.TWO_COLUMNS_MM / _MM, _TALLEST_MM / _MM), node_labels(bodies)
    drawing = engine_drawing(scene, bodies, size, above, joint_labels(scene, bodies))
    letters = int(_LETTERS * drawing.width * _MM / frame.TWO_COLUMNS_MM)
    caption = wrap(engine_caption(scene, bodies), letters)
    below_mm = 3.0 + _LINE_MM * len(caption)
    width_mm, height_mm = drawing.width * _MM, drawing.height * _MM + _TITLE_MM + below_mm
    figure = frame.new_figure(path, width_mm, height_mm)
    figure.set_layout_engine("none")
    axes = figure.add_axes(
        (0.0, below_mm / height_mm, 1.0, 1.0 - (_TITLE_MM + below_mm) / height_mm)
    )
    axes.set_axis_off()
    axes.set(xlim=(0.0, drawing.width), ylim=(drawing.height, 0.0), aspect="equal")
    for order, shape in enumerate(drawing.shapes):
        _draw(axes, shape, order)
    figure.text(0.5, 2.0 / height_mm, "\n".join(caption), ha="center", fontsize=frame.SMALL_PT)
    figure.suptitle(fill(title, 90), fontsize=frame.TITLE_PT, y=1.0 - 2.0 / height_mm, va="top")
    frame.write_figure(figure, path)


def _draw(axes: Axes, shape: Shape, order: int) -> None:
    from matplotlib import patches

    match shape:
        case Group():
            for part in shape.shapes:
                _draw(axes, part, order)
        case Polygon():
            _fill(axes, shape.style, order, lambda **look: patches.Polygon(shape.points, **look))
        case Circle():
            place = (shape.x, shape.y)
            _fill(axes, shape.style, order,
                  lambda **look: patches.Circle(place, shape.radius, **look))  # fmt: skip
        case Line():
            x, y = np.transpose(shape.points)
            axes.plot(x, y, color=_color(shape.style.stroke), alpha=shape.style.opacity,
                      linewidth=_POINT * shape.style.width, linestyle=_dashes(shape.style),
                      solid_capstyle="butt", dash_capstyle="butt", zorder=order)  # fmt: skip
        case Words():
            ha = {"start": "left", "middle": "center", "end": "right"}[shape.anchor]
            axes.text(shape.x, shape.y, shape.text, ha=ha, va="baseline", rotation=-shape.angle,
                      rotation_mode="anchor", fontsize=frame.SMALL_PT, color=_color(shape.color),
                      zorder=order)  # fmt: skip


def _fill(axes: Axes, style: Style, order: int, patch: Any) -> None:
    """Add a patch: a hatched one as a tint, its hatching and its line."""
    line = {
        "edgecolor": _color(style.stroke),
        "linewidth": _POINT * style.width if style.stroke else 0.0,
        "linestyle": _dashes(style),
        "zorder": order,
    }
    if style.hatch < 0:
        opacity = style.opacity if style.fill else None
        axes.add_patch(patch(facecolor=(_color(style.fill), opacity), **line))
        return
    color, hatch = _color(f"c{style.hatch}"), _HATCHES[style.hatch % len(_HATCHES)]
    axes.add_patch(patch(facecolor=(color, 0.13), linewidth=0.0, zorder=order))
    axes.add_patch(
        patch(facecolor="none", edgecolor=(color, 0.75), hatch=hatch, linewidth=0.0, zorder=order)
    )
    axes.add_patch(patch(facecolor="none", **line))


def _dashes(style: Style) -> Any:
    # matplotlib scales dashes by the width of the line
    return (0, tuple(d / style.width for d in style.dashes)) if style.dashes else "solid"


def _color(name: str) -> str:
    known = {"": "none", "ink": "black", "muted": frame.QUIET_COLOR, "paper": "white"}
    return known[name] if name in known else frame.COLORS[int(name[1:]) % len(frame.COLORS)]
