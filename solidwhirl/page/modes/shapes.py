"""Mode shapes of a page: in space, along the axis, and who takes part in them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from solidwhirl.drawing.modes import ShownModes, hertz_text, shown_modes
from solidwhirl.drawing.motion import EngineInSpace, engine_in_space
from solidwhirl.page.frame.marks import whirl_text
from solidwhirl.page.frame.records import Chart, Choice, ModeViewer, Option, Run, Section, Table
from solidwhirl.page.frame.traces import Trace, axis, line, marks, series_style
from solidwhirl.page.modes.viewer_data import viewer_data
from solidwhirl.rotordyn.modes.damping import log_decrement
from solidwhirl.rotordyn.modes.mode_shapes import BodyShape, ModeShapes, mode_shapes
from solidwhirl.rotordyn.modes.participation import Participation, participation
from solidwhirl.rotordyn.plots.frame import mode_name

# Points of a deflection that is drawn.
_POINTS = 80
# Parts of a mode that are drawn, and by how much a part counts for it.
_MOST_PARTS, _SMALL = 12, 0.005
_PATTERNS = ("", "/", "x", ".", "\\", "+", "-", "|")


def section(run: Run) -> Section | None:
    """Return the mode shapes of a run; None where it has no modes."""
    system = run.results.system
    shown = shown_modes(run.results)
    if not shown:
        return None
    shapes = [mode_shapes(system, s.modes) for s in shown]
    fast = [s for s in shown if s.rpm.size and np.ptp(s.rpm) == 0.0]
    blocks: list[Any] = [
        viewer(engine_in_space(run.results), shown),
        deflection_chart(shown, shapes),
        mode_table(fast),
    ]
    if fast and len(system.system.rotors) + len(system.system.bearings) > 1:
        shares = [participation(system, s.modes) for s in fast]
        # of one body alone every bar would be 100 %
        kinds = ("kinetic", "strain") if len(system.system.rotors) > 1 else ("strain",)
        blocks += [share_chart(fast, shares, kind) for kind in kinds]
    return Section(
        name="mode-shapes",
        title="Mode shapes",
        blocks=blocks,
        note="How the engine moves in its modes, much enlarged.",
    )


def viewer(engine: EngineInSpace, shown: Sequence[ShownModes]) -> ModeViewer:
    """Return the viewer of the modes in space."""
    count = sum(len(s.texts) for s in shown)
    return ModeViewer(
        name="mode-viewer",
        title="Modes in space",
        caption="Bodies move as in the chosen mode, much enlarged and slowed down; they turn as "
        "often per period of the vibration as in the engine. Along the axis stand the orbits of "
        "the shaft. Each mode has its own scale.",
        alt=f"Viewer of {count} mode shapes in space, with controls for speed and mode; the charts "
        "and tables below show the same modes.",
        data=viewer_data(engine, shown),
    )


def deflection_chart(shown: Sequence[ShownModes], shapes: Sequence[ModeShapes]) -> Chart:
    """Return the deflection of the bodies along the axis for each mode."""
    traces: list[Trace] = []
    options: list[Option] = []
    for modes, found in zip(shown, shapes, strict=True):
        for k, text in enumerate(modes.texts):
            before = len(traces)
            for number, body in enumerate(found.bodies):
                traces += _deflections(body, k, number)
            options.append(
                Option(label=f"{modes.label}: {text}", traces=list(range(before, len(traces))))
            )
    return Chart(
        name="deflections",
        title="Deflection along the axis",
        caption="Lateral deflection of the centre line of each body in the plane of the largest "
        "orbit, at the moment it is largest (1 there); marks are interfaces. A mode without "
        "lateral motion (axial, torsion, disks alone) is zero.",
        alt="Deflection of the bodies along the axis for a chosen mode.",
        traces=traces,
        layout={
            "xaxis": axis("z [m]"),
            "yaxis": axis("deflection over the largest [1]", range=[-1.12, 1.12], zeroline=True),
        },
        height_px=360,
        controls=[Choice(label="mode", options=options)],
    )


def _deflections(body: BodyShape, mode: int, number: int) -> list[Trace]:
    """Line and interfaces of one body in one mode."""
    style = series_style(number)
    order = np.argsort(body.axial_m, kind="stable")
    step = max(1, -(-order.size // _POINTS))
    kept = np.unique(np.append(order[::step], order[-1:])) if order.size else order
    kept = kept[np.argsort(body.axial_m[kept], kind="stable")]
    own = line(
        body.axial_m[kept],
        body.deflection[kept, mode],
        body.body,
        style,
        hovertemplate=f"<b>{body.body}</b><br>z %{{x:.4g}} m<br>%{{y:.3f}}<extra></extra>",
    )
    if not body.interfaces:
        return [own]
    ends = marks(
        body.interface_axial_m,
        body.interface_deflection[:, mode],
        f"interfaces of {body.body}",
        style,
        8,
        text=list(body.interfaces),
        hovertemplate=f"<b>{body.body}.%{{text}}</b><br>z %{{x:.4g}} m<br>%{{y:.3f}}"
        "<extra></extra>",
        showlegend=False,
    )
    return [own, ends]


def mode_table(shown: Sequence[ShownModes]) -> Table:
    """Return frequencies, whirl and damping of modes at speeds; arguments as `deflection_chart`."""
    rows = []
    for modes in shown:
        found = modes.modes.eigenvalues
        decrements = log_decrement(found)
        for k, value in enumerate(found):
            hertz = float(value.imag / (2.0 * np.pi))
            rows.append(
                [
                    f"{modes.rpm[k]:.0f}",
                    mode_name(modes.numbers, k),
                    f"{hertz:.5g}",
                    whirl_text(modes.whirl[k]),
                    float(decrements[k]) or None,  # rounding is no damping
                ]
            )
    return Table(
        head=["speed [rpm]", "mode", "frequency [Hz]", "whirl", "log. decrement [1]"],
        rows=rows,
        folded=f"Modes in numbers ({len(rows)})",
    )


def share_chart(shown: Sequence[ShownModes], shares: Sequence[Participation], kind: str) -> Chart:
    """Return the shares of bodies and joints in the energy of modes."""
    traces: list[Trace] = []
    options: list[Option] = []
    for modes, found in zip(shown, shares, strict=True):
        before = len(traces)
        traces += share_bars(modes, found, kind)
        options.append(Option(label=modes.label, traces=list(range(before, len(traces)))))
    what = {
        "kinetic": "Kinetic energy by body",
        "strain": "Strain energy by body and joint",
    }[kind]
    return Chart(
        name=f"shares-{kind}",
        title=what,
        caption="Share of each in the mean "
        + (
            "kinetic energy of the vibration, which shows whose mode it is."
            if kind == "kinetic"
            else "energy of the stiffness: a mode whose energy is in a bearing moves when that "
            "is changed. The centrifugal part is not drawn, so at speed bars may end above or "
            "below 100 %."
        ),
        alt=f"Stacked bars: {what.lower()} for each mode.",
        traces=traces,
        layout={
            "xaxis": axis("mode", type="category"),
            "yaxis": axis(f"share of the {kind} energy [%]"),
            "barmode": "relative",
        },
        height_px=380,
        controls=[Choice(label="modes", options=options)] if len(options) > 1 else [],
    )


def share_bars(modes: ShownModes, found: Participation, kind: str) -> list[Trace]:
    """Return one bar trace for each body or joint; arguments as `share_chart`."""
    if kind == "kinetic":
        parts = list(zip(found.bodies, found.kinetic_bodies, strict=True))
    else:
        parts = list(zip(found.bodies, found.strain_bodies, strict=True))
        parts += list(zip(found.joints, found.strain_joints, strict=True))
    parts = [(n, np.nan_to_num(v)) for n, v in parts]
    ranked = sorted(parts, key=lambda part: -float(np.abs(part[1]).max(initial=0.0)))
    chosen = {n for n, v in ranked[:_MOST_PARTS] if np.abs(v).max(initial=0.0) > _SMALL}
    names = [
        f"{mode_name(modes.numbers, k)}<br>{hertz_text(value.imag / (2.0 * np.pi))}"
        for k, value in enumerate(modes.modes.eigenvalues)
    ]
    return [
        {
            "type": "bar",
            "x": names,
            "y": 100.0 * values,
            "name": name,
            "marker": {
                "color": series_style(number).color,
                "pattern": {
                    "shape": _PATTERNS[number % len(_PATTERNS)],
                    "fillmode": "overlay",
                    "fgcolor": "@paper",
                    "size": 7,
                },
                "line": {"color": "@paper", "width": 1},
            },
            "hovertemplate": f"<b>{name}</b><br>%{{y:.1f}} %<extra></extra>",
        }
        for number, (name, values) in enumerate(parts)
        if name in chosen
    ]
