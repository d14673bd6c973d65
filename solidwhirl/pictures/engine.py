"""Drawing of an engine to scale: cross-sections, rigid disks, bearings, gears, names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from solidwhirl.pictures.labels import spread
from solidwhirl.pictures.outlines import Outline, outlines_of
from solidwhirl.pipeline import Results
from solidwhirl.rotordyn.parts import Bearing, End, Gear
from solidwhirl.rotordyn.picture_frame import (
    COLORS,
    QUIET_COLOR,
    SMALL_PT,
    TITLE_PT,
    TWO_COLUMNS_MM,
    new_figure,
    styled,
    write_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Hatches of cross-sections, which tell bodies apart without colour.
_HATCHES = ("////", "\\\\\\\\", "xxxx", "....", "----", "++++", "||||", "oooo")
# Side of a bearing's symbol, and of the gap to the casing or the ground, as parts of the length.
_SYMBOL, _GAP = 0.018, 0.05
# Width of a letter and height of a line, mm, at the size of small letters.
_LETTER_MM, _LINE_MM = 1.45, 3.1
# Width of the frame and least and largest height of the drawing in it, mm.
_FRAME_MM, _LOWEST_MM, _HIGHEST_MM = 156.0, 26.0, 190.0
# Left of the frame, below it with the legend, the title, and a letter of an upright name, mm.
_LEFT_MM, _BELOW_MM, _TITLE_MM, _NAME_MM = 18.0, 25.0, 9.0, 1.7
# Width of the frame over the length of the engine; height of the band with names of bearings, mm.
_WIDER, _BAND_MM = 1.12, 6.0
_CASING_COLOR = "#595959"


@dataclass(frozen=True, kw_only=True, eq=False)
class _Frame:
    """What the parts of the drawing share: sizes in mm, factor from m to mm."""

    outlines: dict[str, Outline]
    low_mm: float
    high_mm: float
    reach_mm: float
    ground_mm: float

    @property
    def length_mm(self) -> float:
        return self.high_mm - self.low_mm

    @property
    def symbol_mm(self) -> float:
        return _SYMBOL * self.length_mm

    @property
    def data_per_mm(self) -> float:
        """Millimetres of the engine for one of the paper."""
        return _WIDER * self.length_mm / _FRAME_MM

    def outermost_mm(self, axial_mm: float) -> float:
        """Largest radius of any body at a place."""
        found = (o.radii_at(1e-3 * axial_mm) for o in self.outlines.values())
        return max((1e3 * radii[1] for radii in found if radii is not None), default=0.0)


@styled
def draw_engine(results: Results, path: Path, title: str) -> None:
    """Draw the engine of a run to scale.

    Parameters
    ----------
    results
        The run. Bodies with a shape are cut along the axis; those without one, such as a rigid
        casing, are a line around them. Rigid disks are shown as the uniform thin disk with their
        polar inertia, √(2 Ip / m). Interface names stand above, those of bearings below.
    path
        The file; its suffix chooses the kind (.png, .svg, .pdf).
    title
        Above the drawing.
    """
    frame = _frame(outlines_of(results))
    engine = results.system.system
    names = [f"{o.body}.{i}" for o in frame.outlines.values() for i in o.interfaces]
    above = _TITLE_MM + 5.0 + _NAME_MM * max(len(name) for name in names)
    half = _half_height(frame, engine.bearings)
    drawing_mm = min(2.0 * half / frame.data_per_mm + _BAND_MM, _HIGHEST_MM)
    height_mm = above + drawing_mm + _BELOW_MM
    figure = new_figure(path, TWO_COLUMNS_MM, height_mm)
    # names outside of the frame would not be given room
    figure.set_layout_engine("none")
    axes = figure.add_axes(
        (_LEFT_MM / TWO_COLUMNS_MM, _BELOW_MM / height_mm,
         _FRAME_MM / TWO_COLUMNS_MM, drawing_mm / height_mm)
    )  # fmt: skip
    for place, outline in enumerate(frame.outlines.values()):
        _draw_body(axes, outline, place)
        _draw_disks(axes, outline, place)
    _draw_casings(axes, frame)
    marks = _draw_bearings(axes, frame, engine.bearings)
    marks += _draw_gears(axes, frame, engine.gears)
    axes.axhline(0.0, color="black", linewidth=0.7, linestyle=(0, (9, 2, 2, 2)), zorder=4)
    band = _BAND_MM * frame.data_per_mm if marks else 0.0
    _finish(axes, frame, (-half - band, half))
    _name_interfaces(axes, frame, half)
    _name_marks(axes, frame, marks, -half - band)
    figure.suptitle(fill(title, 90), fontsize=TITLE_PT, y=1.0 - 2.0 / height_mm, va="top")
    _legend(figure, frame, engine.bearings, engine.gears)
    write_figure(figure, path)


def _half_height(frame: _Frame, bearings: Sequence[Bearing]) -> float:
    """Height of the frame above the axis: room for all bodies, and mounts outside of a casing."""
    mounted = [b.first.body for b in bearings if b.second is None]
    outside = any(not frame.outlines[body].areas for body in mounted)
    reach = frame.ground_mm + (3.2 * frame.symbol_mm if outside else 0.0)
    return max(1.05 * reach, 0.5 * _LOWEST_MM * frame.data_per_mm)


def _finish(axes: Axes, frame: _Frame, limits: tuple[float, float]) -> None:
    """Set the limits, one scale for both directions, and the axes in mm."""
    aside = 0.5 * (_WIDER - 1.0) * frame.length_mm
    axes.set_xlim(frame.low_mm - aside, frame.high_mm + aside)
    axes.set_ylim(*limits)
    axes.set_aspect("equal")
    axes.set_ylabel("radius [mm]")
    axes.set_xlabel("axial position [mm]")
    axes.spines[["top", "right"]].set_visible(False)
    axes.yaxis.set_major_formatter(lambda value, _: f"{abs(value):g}")
    axes.locator_params(axis="y", nbins=7)


def _frame(outlines: Sequence[Outline]) -> _Frame:
    places = [z for o in outlines for a in o.areas for z in (a[:, 0].min(), a[:, 0].max())]
    places += [z for o in outlines for z in o.interfaces.values()]
    reach = [o.reach_m for o in outlines] + [d.radius_m for o in outlines for d in o.disks]
    low, high = 1e3 * min(places), 1e3 * max(places)
    if high == low:  # one rigid body with one interface
        low, high = low - 100.0, high + 100.0
    reach_mm = 1e3 * max(reach) or 0.1 * (high - low)
    ground = reach_mm + _GAP * (high - low)
    return _Frame(
        outlines={o.body: o for o in outlines},
        low_mm=low,
        high_mm=high,
        reach_mm=reach_mm,
        ground_mm=ground,
    )


def _draw_body(axes: Axes, outline: Outline, place: int) -> None:
    """Fill and hatch the cross-section on both sides of the axis, and draw its outline."""
    from matplotlib.collections import LineCollection, PolyCollection

    color = COLORS[place % len(COLORS)]
    for side in (1.0, -1.0):
        scale = 1e3 * np.array([1.0, side])
        if outline.areas:
            cut = [scale * a for a in outline.areas]
            axes.add_collection(
                PolyCollection(cut, facecolor=color, alpha=0.22, linewidth=0, zorder=2)
            )
            hatch = PolyCollection(cut, facecolor="none", edgecolor=color, linewidth=0, zorder=2)
            hatch.set_hatch(_HATCHES[place % len(_HATCHES)])
            hatch.set_alpha(0.75)
            axes.add_collection(hatch)
        if outline.lines:
            axes.add_collection(
                LineCollection(
                    [scale * line for line in outline.lines],
                    colors=[color],
                    linewidths=1.0,
                    capstyle="round",
                    zorder=3,
                )
            )


def _draw_disks(axes: Axes, outline: Outline, place: int) -> None:
    """Draw rigid disks as dashed upright lines with a bar at the rim."""
    color = COLORS[place % len(COLORS)]
    for disk in outline.disks:
        z, r = 1e3 * disk.axial_m, 1e3 * disk.radius_m
        axes.plot([z, z], [-r, r], color=color, linewidth=1.6, linestyle=(0, (3, 1)), zorder=3.5)
        axes.plot([z, z], [-r, r], color=color, linestyle="none", marker="_", markersize=7,
                  markeredgewidth=1.6, zorder=3.5)  # fmt: skip


def _draw_casings(axes: Axes, frame: _Frame) -> None:
    """Draw bodies without a shape as a line on both sides, over the reach of their interfaces."""
    for outline in frame.outlines.values():
        if outline.areas or not outline.interfaces:
            continue
        ends = [1e3 * min(outline.interfaces.values()), 1e3 * max(outline.interfaces.values())]
        for side in (1.0, -1.0):
            axes.plot(ends, [side * frame.ground_mm] * 2, color=_CASING_COLOR, linewidth=2.2,
                      solid_capstyle="round", zorder=3)  # fmt: skip


def _radius_mm(frame: _Frame, end: End | None, other_mm: float | None) -> float:
    """Radius at which a bearing touches a body: that of its surfaces nearest to the other one."""
    if end is None:
        return frame.ground_mm
    outline = frame.outlines[end.body]
    found = outline.radii_at(outline.interfaces[end.interface])
    if found is None:
        return frame.ground_mm if not outline.areas else 0.0
    inner, outer = (1e3 * r for r in found)
    if other_mm is None or inner == 0.0:
        return outer
    return min((inner, outer), key=lambda r: abs(r - other_mm))


def _draw_bearings(
    axes: Axes, frame: _Frame, bearings: Sequence[Bearing]
) -> list[tuple[str, float, float]]:
    """Draw a crossed square (filled if rigid) and a line to the other side; return their names."""
    used: list[float] = []
    marks = []
    for bearing in bearings:
        first = frame.outlines[bearing.first.body]
        z = own = 1e3 * first.interfaces[bearing.first.interface]
        while any(abs(z - other) < 1.3 * frame.symbol_mm for other in used):
            z += 0.65 * frame.symbol_mm  # beside those at the same place
        used.append(z)
        start = _radius_mm(frame, bearing.first, None)
        if bearing.second is None:
            # beyond the bodies around it; a casing is the outermost line
            end = max(start, frame.outermost_mm(z)) if first.areas else start
            end += 2.2 * frame.symbol_mm
        else:
            end = _radius_mm(frame, bearing.second, start)
            start = _radius_mm(frame, bearing.first, end)
        for side in (1.0, -1.0):
            _draw_bearing(axes, frame, (own, z), (side * start, side * end), bearing)
        marks.append((bearing.name, z, -max(start, end)))
    return marks


def _draw_bearing(
    axes: Axes,
    frame: _Frame,
    at: tuple[float, float],
    ends: tuple[float, float],
    bearing: Bearing,
) -> None:
    """Draw one side of one bearing."""
    from matplotlib.patches import Rectangle

    (own, z), (start, end) = at, ends
    size = frame.symbol_mm
    side = 1.0 if start + end >= 0.0 else -1.0
    outward = side if abs(end) >= abs(start) else -side
    middle = 0.5 * (start + end) if abs(end - start) < 1.5 * size else start + 0.5 * outward * size
    # a support stands on the centre line of what has no shape there
    axes.plot([own, z, z], [start, start, end], color="black", linewidth=0.8, zorder=4.5)
    filled = "black" if bearing.rigid else "white"
    box = Rectangle((z - 0.5 * size, middle - 0.5 * size), size, size, facecolor=filled,
                    edgecolor="black", linewidth=0.8, zorder=5)  # fmt: skip
    axes.add_patch(box)
    if not bearing.rigid:
        for slope in (1.0, -1.0):
            axes.plot(
                [z - 0.5 * size, z + 0.5 * size],
                [middle - 0.5 * slope * size, middle + 0.5 * slope * size],
                color="black",
                linewidth=0.6,
                zorder=5.1,
            )
    if bearing.second is None:
        reach = 0.9 * size
        axes.plot([z - reach, z + reach], [end, end], color="black", linewidth=1.0, zorder=4.5)
        for k in np.linspace(-reach, reach, 5):
            axes.plot([z + k, z + k - 0.35 * size], [end, end + 0.4 * side * size], color="black",
                      linewidth=0.5, zorder=4.5)  # fmt: skip


def _draw_gears(axes: Axes, frame: _Frame, gears: Sequence[Gear]) -> list[tuple[str, float, float]]:
    """Draw a toothed line from seat to seat; return their names with the ratio."""
    marks = []
    for gear in gears:
        places = [1e3 * frame.outlines[end.body].interfaces[end.interface] for end in gear.ends]
        radii = [min(_radius_mm(frame, end, None), 0.5 * frame.reach_mm) for end in gear.ends]
        for side in (1.0, -1.0):
            for z, r in zip(places, radii, strict=True):
                axes.plot([z, z], [0.0, side * (r + frame.symbol_mm)], color="black",
                          linewidth=1.6, zorder=5)  # fmt: skip
            top = side * (max(radii) + frame.symbol_mm)
            count = 9
            along = np.linspace(places[0], places[1], count)
            wave = top + 0.25 * frame.symbol_mm * np.where(np.arange(count) % 2, 1.0, -1.0)
            axes.plot(along, wave, color="black", linewidth=0.9, zorder=5)
        middle = 0.5 * sum(places)
        marks.append((f"{gear.name} {gear.ratio:g}:1", middle, -max(radii) - frame.symbol_mm))
    return marks


def _name_interfaces(axes: Axes, frame: _Frame, half_mm: float) -> None:
    """Write the names of all interfaces upright above the frame, with lines to their places."""
    names, places, colors = [], [], []
    for place, outline in enumerate(frame.outlines.values()):
        for name, z in outline.interfaces.items():
            names.append(f"{outline.body}.{name}")
            places.append(1e3 * z)
            colors.append(COLORS[place % len(COLORS)] if outline.areas else _CASING_COLOR)
            axes.plot(1e3 * z, 0.0, marker="o", markersize=2.6, color=colors[-1], zorder=6)
    room = _LINE_MM * frame.data_per_mm
    shown = spread(places, [room] * len(places))
    for name, z, x, color in zip(names, places, shown, colors, strict=True):
        axes.plot([z, z], [0.0, half_mm], color=QUIET_COLOR, linewidth=0.35, zorder=1)
        axes.annotate(
            name,
            (z, half_mm),
            xytext=(x, half_mm + 4.0 * frame.data_per_mm),
            ha="center",
            va="bottom",
            rotation=90,
            fontsize=SMALL_PT,
            color=color,
            annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": QUIET_COLOR, "linewidth": 0.35,
                        "shrinkA": 0.5, "shrinkB": 0.0},
        )  # fmt: skip


def _name_marks(
    axes: Axes, frame: _Frame, marks: list[tuple[str, float, float]], bottom_mm: float
) -> None:
    """Write the names of bearings and gears in the band above the lower edge of the frame."""
    if not marks:
        return
    to_data = frame.data_per_mm
    widths = [(_LETTER_MM * len(name) + 2.0) * to_data for name, _, _ in marks]
    shown = spread([z for _, z, _ in marks], widths)
    for (name, z, y), x in zip(marks, shown, strict=True):
        axes.annotate(
            name,
            (z, y),
            xytext=(x, bottom_mm + 1.2 * to_data),
            ha="center",
            va="bottom",
            fontsize=SMALL_PT,
            fontweight="bold",
            annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": QUIET_COLOR, "linewidth": 0.35,
                        "shrinkA": 0.0, "shrinkB": 0.0},
        )  # fmt: skip


def _legend(
    figure: Figure, frame: _Frame, bearings: Sequence[Bearing], gears: Sequence[Gear]
) -> None:
    """Tell the bodies with their speed ratios, and the symbols that are in the drawing."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    rows: list[Any] = []
    for place, outline in enumerate(frame.outlines.values()):
        color = COLORS[place % len(COLORS)]
        speed = (
            f"{outline.speed_ratio:g}× speed".replace("-", "−")
            if outline.speed_ratio
            else "at rest"
        )
        text = f"{outline.body} ({speed})"
        if outline.areas:
            hatch = _HATCHES[place % len(_HATCHES)]
            rows.append(Patch(facecolor=color + "38", edgecolor=color, hatch=hatch, label=text))
        else:
            rows.append(Line2D([], [], color=_CASING_COLOR, linewidth=2.2, label=text))
    square: dict[str, Any] = {
        "linestyle": "none",
        "marker": "s",
        "markersize": 5.5,
        "markeredgecolor": "black",
    }
    if any(not b.rigid for b in bearings):
        rows.append(Line2D([], [], markerfacecolor="white", label="bearing", **square))
    if any(b.rigid for b in bearings):
        rows.append(Line2D([], [], markerfacecolor="black", label="rigid joint", **square))
    if gears:
        rows.append(Line2D([], [], color="black", linewidth=0.9, label="gear"))
    if any(o.disks for o in frame.outlines.values()):
        dashes = (0, (3, 1))
        rows.append(Line2D([], [], color=QUIET_COLOR, linewidth=1.6, linestyle=dashes,
                           label="rigid disk, √(2 Ip/m)"))  # fmt: skip
    figure.legend(handles=rows, loc="lower center", ncols=min(5, len(rows)),
                  frameon=False, fontsize=SMALL_PT)  # fmt: skip
