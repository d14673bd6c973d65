"""Pictures of modes: in the frame of a body, along the axis, and by what takes part in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from solidwhirl.rotordyn.campbell.body_frames import RotatingCampbell
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray
from solidwhirl.rotordyn.core.errors import AnalysisError
from solidwhirl.rotordyn.core.units import RPM_PER_RAD_S
from solidwhirl.rotordyn.modes.mode_shapes import BodyShape, ModeShapes
from solidwhirl.rotordyn.plots.chart import (
    Axis,
    Chart,
    Choice,
    Curve,
    Look,
    Mark,
    Option,
    Rule,
    series_look,
    speed_axis,
    whirl_look,
)
from solidwhirl.rotordyn.plots.frame import (
    mode_name,
)
from solidwhirl.rotordyn.plots.matplotlib_chart import draw_charts

# Width of an upright label, as a fraction of the length of the body.
_LABEL_WIDTH = 0.02
# Components and bodies with a smaller part of a branch are not drawn.
_SMALL = 0.05
# Modes drawn in one picture at most.
_MOST_MODES = 16


@dataclass(frozen=True, kw_only=True, eq=False)
class FrameCurves:
    """Frequencies that a turning body sees.

    Attributes
    ----------
    name
        Of the body and its speed ratio.
    rpm
        Its own speed, shape (s,).
    signed_hz
        Components c of branches b, shape (c, b, s): positive where they turn with the spin of the
        body, nan where they are not drawn.
    orders
        Circumferential orders, shape (c,).
    """

    name: str
    rpm: FloatArray
    signed_hz: FloatArray
    orders: Sequence[int]


def is_drawn(share: FloatArray, body_share: FloatArray) -> BoolArray:
    """Return where a component (c, b, s) and the body (b, s) have 5 % and more of a branch."""
    large = np.nan_to_num(share, nan=1.0) >= _SMALL
    return np.asarray(large & (np.nan_to_num(body_share, nan=1.0) >= _SMALL))


def frame_chart(frames: Sequence[FrameCurves]) -> Chart:
    """Return the frequencies that turning bodies see over their own speeds, a body at a time."""
    options = []
    for frame in frames:
        top = 1.05 * float(np.nanmax(np.abs(frame.signed_hz), initial=0.0)) or 1.0
        last = float(frame.rpm.max(initial=1.0)) or 1.0
        end = min(last, 60.0 * top)
        rest = Curve(x=np.array([0.0, end]), y=np.array([0.0, end / 60.0]), name="a force at rest",
                     look=replace(series_look(6), dash="dot", mark="", width=1.0))  # fmt: skip
        options.append(
            Option(
                label=frame.name,
                marks=[*frame_curves(frame), rest],
                x=speed_axis(0.0, last, "speed of the body"),
                y=Axis(label="frequency in the frame of the body", unit="Hz", low=0.0, high=top),
            )
        )
    return Chart(
        name="frame",
        title="Campbell diagram in the frame of a body",
        caption="A component is drawn where it and the body have 5 % or more of the branch. Full "
        "lines turn with the spin of the body in its own frame, broken ones against it: a forward "
        "whirl slower than the body is broken, after its mirror at zero.",
        alt="Frequencies that a turning body sees over its speed.",
        x=Axis(label="speed of the body", unit="rpm"),
        y=Axis(label="frequency in the frame of the body", unit="Hz"),
        parts=[Choice(label="seen by", options=options, on_paper="each")],
        height_px=440,
    )


def frame_curves(frame: FrameCurves) -> list[Curve]:
    """Return the drawn components, those with the spin before those against it."""
    curves = []
    for side, text, whirl in (
        (1.0, "turns with the spin", "forward"),
        (-1.0, "turns against it", "backward"),
    ):
        look = replace(whirl_look(whirl), size=5.0)
        for c, b in np.ndindex(frame.signed_hz.shape[:2]):
            x, y = with_zero(frame.rpm, frame.signed_hz[c, b])
            if not (side * y > 0.0).any():
                continue
            shown = np.where(side * y >= 0.0, np.abs(y), np.nan)
            words = [f"branch {b + 1}, order {frame.orders[c]:+d}"] * x.size
            curves.append(Curve(x=x, y=shown, name=text, look=look, texts=words))
    return curves


def draw_rotating_campbell(
    frames: Sequence[RotatingCampbell], path: str | Path, title: str
) -> None:
    """Draw the frequencies that turning bodies see over their own speeds.

    Arguments `path` and `title`, and the error of a wrong suffix, as in `draw_campbell`.

    Parameters
    ----------
    frames
        One for each body, as in Müller and Hennings, figure 11. A component is drawn where it
        and the body have a part of 5 % and more in the branch, or where that is not known.
        Full lines turn with the body's spin in its own frame, dashed ones against it: a forward
        whirl slower than the body is dashed, after its mirror at zero.

    Raises
    ------
    AnalysisError
        If no body turns.
    """
    turning = [frame for frame in frames if frame.speed_ratio != 0]
    if not turning:
        raise AnalysisError("no body turns; there is no rotating frame to draw in")
    curves = []
    for frame in turning:
        sense = np.sign(frame.speed_ratio) * np.where(frame.speeds_rad_s < 0, -1.0, 1.0)
        drawn = is_drawn(frame.share, frame.body_share)
        curves.append(
            FrameCurves(
                name=frame.body or f"frame at {frame.speed_ratio:g} times the speed",
                rpm=np.abs(frame.spin_rad_s) * RPM_PER_RAD_S,
                signed_hz=np.where(drawn, frame.signed_hz * sense, np.nan),
                orders=frame.orders.tolist(),
            )
        )
    draw_charts([frame_chart(curves)], path, title)


def draw_mode_shapes(shapes: ModeShapes, path: str | Path, title: str) -> None:
    """Draw the lateral deflection of every body along the axis, one frame for each mode.

    Arguments `path` and `title`, and the error of a wrong suffix, as in `draw_campbell`.

    Parameters
    ----------
    shapes
        At most 16 modes; compute fewer for more.

    Raises
    ------
    AnalysisError
        If there are no modes or too many.
    """
    draw_charts([mode_chart(shapes)], path, title)


def draw_body_modes(shapes: ModeShapes, body: str, path: str | Path, title: str) -> None:
    """Draw the lateral deflection of one body in several modes over each other.

    Arguments `path` and `title`, and the error of a wrong suffix, as in `draw_campbell`.

    Parameters
    ----------
    shapes
        At most 16 modes; each is scaled to the largest orbit of all bodies.
    body
        Name of the body, such as the low-pressure unit of Müller and Hennings, figures 12, 13.

    Raises
    ------
    AnalysisError
        If there are no modes or too many, no such body, or the suffix is not a kind of picture
        that can be written.
    """
    shape, count = shapes.body(body), _mode_count(shapes)
    marks: list[Mark] = [_zero(), *_interface_rules(shape)]
    marks += [
        Curve(x=shape.axial_m, y=shape.deflection[:, mode], name=_mode_title(shapes, mode),
              look=series_look(mode))
        for mode in range(count)
    ]  # fmt: skip
    chart = Chart(name="body-modes", title=f"Modes of {body}", x=_axial(), y=_deflection(),
                  parts=marks)  # fmt: skip
    draw_charts([chart], path, title)


def mode_chart(shapes: ModeShapes) -> Chart:
    """Return the lateral deflection of every body along the axis, a mode at a time."""
    options = []
    for mode in range(_mode_count(shapes)):
        marks: list[Mark] = [_zero()]
        for k, body in enumerate(shapes.bodies):
            look = series_look(k)
            nodes = replace(look, dash="", mark=f"{look.mark}-open", size=8.0)
            marks += [
                Curve(x=body.axial_m, y=body.deflection[:, mode], name=body.body,
                      look=replace(look, mark="")),
                Curve(x=body.interface_axial_m, y=body.interface_deflection[:, mode], look=nodes),
            ]  # fmt: skip
        options.append(Option(label=_mode_title(shapes, mode), marks=marks))
    return Chart(
        name="modes", title="Modes along the axis", x=_axial(), y=_deflection(),
        parts=[Choice(label="mode", options=options, on_paper="each")],
    )  # fmt: skip


def _axial() -> Axis:
    return Axis(label="axial position", unit="m")


def _deflection() -> Axis:
    return Axis(label="deflection, largest orbit 1", unit="1", low=-1.12, high=1.12)


def _zero() -> Rule:
    return Rule(at=0.0, along="y", look=Look("@ink", "solid", width=0.8))


def _interface_rules(shape: BodyShape) -> list[Rule]:
    """A line at each interface; names that would touch the one before are left out."""
    room = _LABEL_WIDTH * float(np.ptp(shape.axial_m))
    last, look = -np.inf, Look("@muted", "dash", width=0.9)
    found = []
    for k in np.argsort(shape.interface_axial_m):
        at = float(shape.interface_axial_m[k])
        name = shape.interfaces[k] if at - room >= last else ""
        last = at + room if name else last
        found.append(Rule(at=at, name="interface", text=name, look=look))
    return found


def _mode_count(shapes: ModeShapes) -> int:
    count = shapes.eigenvalues.size
    if not 1 <= count <= _MOST_MODES:
        raise AnalysisError(f"there are {count} modes; 1 to {_MOST_MODES} can be drawn")
    return int(count)


def _mode_title(shapes: ModeShapes, mode: int) -> str:
    name = mode_name(shapes.numbers, mode)
    return f"{name}: {shapes.frequency_hz[mode]:.4g} Hz {shapes.whirl[mode]}"


def with_zero(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a line (s,) with the points added at which it passes zero; nan in y is a gap."""
    with np.errstate(invalid="ignore"):
        at = np.flatnonzero(y[:-1] * y[1:] < 0.0)
    part = y[at] / (y[at] - y[at + 1])
    return (
        np.insert(x, at + 1, x[at] + part * (x[at + 1] - x[at])),
        np.insert(y, at + 1, 0.0),
    )
