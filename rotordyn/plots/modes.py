"""Charts of modes: in the frame of a body, along the axis, and by what takes part in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray
from solidwhirl.rotordyn.modes.kinds import motion_words
from solidwhirl.rotordyn.modes.mode_shapes import BodyShape, ModeShapes
from solidwhirl.rotordyn.modes.participation import Participation
from solidwhirl.rotordyn.plots import chart as charts
from solidwhirl.rotordyn.plots.frame import mode_name

# Width of an upright label, as a fraction of the length of the body.
_LABEL_WIDTH = 0.02
# Components and bodies with a smaller part of a branch are not drawn.
_SMALL = 0.05
# Points of a deflection that is drawn.
_POINTS = 80
# Parts of a mode that are drawn, and by how much a part counts for it.
_MOST_PARTS, _SMALL_PART = 12, 0.005


@dataclass(frozen=True, kw_only=True, eq=False)
class FrameCurves:
    """Frequencies that a turning body sees."""

    #: Of the body and its speed ratio
    name: str
    #: Its own speed, shape (s,)
    rpm: FloatArray
    #: Components c of branches b, shape (c, b, s): positive where they turn with the spin of the
    #: body, nan where they are not drawn
    signed_hz: FloatArray
    #: Circumferential orders, shape (c,)
    orders: Sequence[int]
    #: Components of branches that are drawn at first, shape (c, b); None for all
    first: BoolArray | None = None


def is_drawn(share: FloatArray, body_share: FloatArray) -> BoolArray:
    """Return where a component (c, b, s) and the body (b, s) have 5 % and more of a branch."""
    large = np.nan_to_num(share, nan=1.0) >= _SMALL
    return np.asarray(large & (np.nan_to_num(body_share, nan=1.0) >= _SMALL))


def frame_chart(frames: Sequence[FrameCurves]) -> charts.Chart:
    """Return the frequencies that turning bodies see over their own speeds, a body at a time."""
    options = []
    for frame in frames:
        shown = frame.signed_hz if frame.first is None else frame.signed_hz[frame.first]
        top = 1.05 * float(np.nanmax(np.abs(shown), initial=0.0)) or 1.0
        last = float(frame.rpm.max(initial=1.0)) or 1.0
        end = min(last, 60.0 * top)
        line = np.array([0.0, end])
        look = replace(charts.series_look(6), dash="dot", mark="", width=1.0)
        still = charts.Curve(x=line, y=line / 60.0, name="a force at rest", look=look)
        options.append(
            charts.Option(
                label=frame.name,
                marks=[*frame_curves(frame), still],
                x=charts.speed_axis(0.0, last, "speed of the body"),
                y=charts.Axis(
                    label="frequency in the frame of the body", unit="Hz", low=0.0, high=top
                ),
            )
        )
    return charts.Chart(
        name="frame",
        title="Campbell diagram in the frame of a body",
        caption="A component is drawn where it and the body have 5 % or more of the branch. Full "
        "lines turn with the spin of the body in its own frame, broken ones against it: a forward "
        "whirl slower than the body is broken, after its mirror at zero.",
        alt="Frequencies that a turning body sees over its speed.",
        x=charts.Axis(label="speed of the body", unit="rpm"),
        y=charts.Axis(label="frequency in the frame of the body", unit="Hz"),
        parts=[charts.Choice(label="seen by", options=options, on_paper="each")],
        height_px=440,
    )


def frame_curves(frame: FrameCurves) -> list[charts.Curve]:
    """Return the drawn components, those with the spin before those against it.

    What is not drawn at first waits in the legend.
    """
    curves = []
    for side, text, whirl in (
        (1.0, "turns with the spin", "forward"),
        (-1.0, "turns against it", "backward"),
    ):
        look = replace(charts.whirl_look(whirl), size=5.0)
        for c, b in np.ndindex(frame.signed_hz.shape[:2]):
            x, y = with_zero(frame.rpm, frame.signed_hz[c, b])
            if not (side * y > 0.0).any():
                continue
            shown = np.where(side * y >= 0.0, np.abs(y), np.nan)
            words = [f"branch {b + 1}, order {frame.orders[c]:+d}"] * x.size
            quiet = frame.first is not None and not frame.first[c, b]
            faint = charts.Look("@faint", look.dash, width=0.8)
            name, own = (f"others: {text}", faint) if quiet else (text, look)
            curves.append(
                charts.Curve(x=x, y=shown, name=name, look=own, texts=words, is_quiet=quiet)
            )
    return sorted(curves, key=lambda curve: not curve.is_quiet)


def mode_names(shapes: ModeShapes) -> list[str]:
    """Return what modes are called: number, frequency and whirl."""
    return [
        f"mode {mode_name(shapes.numbers, k)}, {charts.hertz_text(f)}, {motion_words(w, s)}"
        for k, (f, w, s) in enumerate(
            zip(shapes.frequency_hz, shapes.whirl, shapes.shares, strict=True)
        )
    ]


def deflection_chart(found: Sequence[tuple[str, Sequence[str], ModeShapes]]) -> charts.Chart:
    """Return the lateral deflection of every body along the axis, a mode at a time.

    `found`: what a speed is called, the names of the modes, and these.
    """
    options = []
    for label, names, shapes in found:
        for mode, name in enumerate(names):
            marks: list[charts.Mark] = [_ZERO]
            for k, body in enumerate(shapes.bodies):
                marks += _deflections(body, mode, charts.series_look(k))
            options.append(charts.Option(label=f"{label}: {name}", marks=marks))
    return charts.Chart(
        name="deflections",
        title="Deflection along the axis",
        caption="Lateral deflection of the centre line of each body in the plane of the largest "
        "orbit, at the moment it is largest (1 there); marks are interfaces. A mode without "
        "lateral motion (axial, torsion, disks alone) is zero.",
        alt="Deflection of the bodies along the axis for a chosen mode.",
        x=_AXIAL,
        y=_DEFLECTION,
        parts=[charts.Choice(label="mode", options=options, on_paper="each")],
        height_px=360,
    )


def _deflections(body: BodyShape, mode: int, look: charts.Look) -> list[charts.Curve]:
    """Line and interfaces of one body in one mode."""
    order = np.argsort(body.axial_m, kind="stable")
    step = max(1, -(-order.size // _POINTS))
    kept = order[np.unique(np.append(np.arange(0, order.size, step), order.size - 1))]
    ends = replace(look, dash="", mark=f"{look.mark}-open", size=8.0)
    texts = [f"{body.body}.{name}" for name in body.interfaces]
    return [
        charts.Curve(x=body.axial_m[kept], y=body.deflection[kept, mode], name=body.body,
              look=replace(look, mark="")),
        charts.Curve(x=body.interface_axial_m, y=body.interface_deflection[:, mode], look=ends,
              texts=texts),
    ]  # fmt: skip


def body_chart(shapes: ModeShapes, body: str, at: str) -> charts.Chart:
    """Return the lateral deflection of one body in several modes over each other.

    As Müller and Hennings, figures 12 and 13. Each mode is scaled to the largest orbit of all
    bodies; `at` tells the speed.
    """
    shape = shapes.body(body)
    marks: list[charts.Mark] = [_ZERO, *_interface_rules(shape)]
    marks += [
        charts.Curve(
            x=shape.axial_m, y=shape.deflection[:, k], name=name, look=charts.series_look(k)
        )
        for k, name in enumerate(mode_names(shapes))
    ]
    title = f"Modes of {body}, {at}"
    return charts.Chart(name="body-modes", title=title, x=_AXIAL, y=_DEFLECTION, parts=marks)


def share_chart(
    found: Sequence[tuple[str, Sequence[str], Participation]], kind: Literal["kinetic", "strain"]
) -> charts.Chart:
    """Return the shares of bodies and joints in the energy of modes; arguments as above."""
    found = [(label, _told_apart(names), shares) for label, names, shares in found]
    places = list(dict.fromkeys(name for _, names, _ in found for name in names))
    options = [
        charts.Option(
            label=label, marks=share_bars(shares, kind), x=charts.Axis(label="mode", places=names)
        )
        for label, names, shares in found
    ]
    what, said = {
        "kinetic": (
            "Kinetic energy by body",
            "kinetic energy of the vibration, which shows whose mode it is.",
        ),
        "strain": (
            "Strain energy by body and joint",
            "energy of the stiffness: a mode whose energy is in a bearing moves when that is "
            "changed. The centrifugal part is not drawn, so at speed bars may end above or below "
            "100 %.",
        ),
    }[kind]
    return charts.Chart(
        name=f"shares-{kind}",
        title=what,
        caption=f"Share of each in the mean {said}",
        alt=f"Stacked bars: {what.lower()} for each mode.",
        x=charts.Axis(label="mode", places=places),
        y=charts.Axis(label=f"share of the {kind} energy", unit="%", digits=".1f"),
        parts=options[0].marks
        if len(options) == 1
        else [charts.Choice(label="modes", options=options)],
        height_px=380,
        is_stacked=True,
    )


def _told_apart(names: Sequence[str]) -> list[str]:
    """Number names that occur again: bars of one name would stand upon each other."""
    before = [list(names[:k]).count(name) for k, name in enumerate(names)]
    return [f"{name} ({n + 1})" if n else name for name, n in zip(names, before, strict=True)]


def share_bars(found: Participation, kind: str) -> list[charts.Bars]:
    """Return the bars of each body, or of each body and joint, that counts."""
    parts = list(zip(found.bodies, found.kinetic_bodies, strict=True))
    if kind == "strain":
        parts = list(zip(found.bodies, found.strain_bodies, strict=True))
        parts += list(zip(found.joints, found.strain_joints, strict=True))
    shares = {name: np.nan_to_num(values) for name, values in parts}
    largest = {name: float(np.abs(v).max(initial=0.0)) for name, v in shares.items()}
    ranked = sorted(shares, key=lambda name: -largest[name])[:_MOST_PARTS]
    return [
        charts.Bars(values=100.0 * values, name=name, look=charts.series_look(number))
        for number, (name, values) in enumerate(shares.items())
        if name in ranked and largest[name] > _SMALL_PART
    ]


_AXIAL = charts.Axis(label="axial position", unit="m", digits=".4g")
_DEFLECTION = charts.Axis(
    label="deflection over the largest", unit="1", low=-1.12, high=1.12, digits=".3f"
)
_ZERO = charts.Rule(at=0.0, along="y", look=charts.Look("@ink", "solid", width=0.8))


def _interface_rules(shape: BodyShape) -> list[charts.Rule]:
    """A line at each interface; names that would touch the one before are left out."""
    room = _LABEL_WIDTH * float(np.ptp(shape.axial_m))
    last, look = -np.inf, charts.Look("@muted", "dash", width=0.9)
    found = []
    for k in np.argsort(shape.interface_axial_m):
        at = float(shape.interface_axial_m[k])
        name = shape.interfaces[k] if at - room >= last else ""
        last = at + room if name else last
        found.append(charts.Rule(at=at, name="interface", text=name, look=look))
    return found


def with_zero(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a line (s,) with the points added at which it passes zero; nan in y is a gap."""
    with np.errstate(invalid="ignore"):
        at = np.flatnonzero(y[:-1] * y[1:] < 0.0)
    part = y[at] / (y[at] - y[at + 1])
    return (
        np.insert(x, at + 1, x[at] + part * (x[at + 1] - x[at])),
        np.insert(y, at + 1, 0.0),
    )
