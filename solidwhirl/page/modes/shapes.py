"""Mode shapes of a page: in space, along the axis, and who takes part in them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from solidwhirl.analyses.base import MODE_SHAPES
from solidwhirl.core.blocks import TurningMode, TurningModes, whirl_text
from solidwhirl.drawing.modes import ShownModes, shown_modes
from solidwhirl.drawing.motion import (
    EngineInSpace,
    engine_in_space,
    mode_in_space,
    with_few_points,
)
from solidwhirl.drawing.surfaces import Piece, kept_of_outline, kept_of_sector
from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.records import ModeViewer, Run, Section, Table
from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, IntArray
from solidwhirl.rotordyn.modes.damping import log_decrement
from solidwhirl.rotordyn.modes.mode_shapes import mode_shapes
from solidwhirl.rotordyn.modes.participation import participation
from solidwhirl.rotordyn.plots.chart import hertz_text
from solidwhirl.rotordyn.plots.frame import mode_name
from solidwhirl.rotordyn.plots.modes import deflection_chart, share_chart
from solidwhirl.rotordyn.superelement.surface import moved_by

_WHOLE = 32767
# Points of all copies of a sector.
_MOST_POINTS = 4000
# Distance of points along the outline of a meridian, over its size.
_OUTLINE = 0.035
#: Numbers below this are zero; a step of them could not be represented.
NOTHING = 1e-290


def section(run: Run) -> Section | None:
    """Return the mode shapes of a run; None where it has no modes."""
    system = run.results.system
    shown = shown_modes(run.results)
    if not shown:
        return None
    shapes = [(s.label, s.texts, mode_shapes(system, s.modes)) for s in shown]
    fast = [s for s in shown if s.rpm.size and np.ptp(s.rpm) == 0.0]
    blocks: list[Any] = [
        viewer(engine_in_space(run.results), shown),
        page_chart(deflection_chart(shapes)),
        mode_table(fast),
    ]
    if fast and len(system.system.rotors) + len(system.system.bearings) > 1:
        shares = [(s.label, _names(s), participation(system, s.modes)) for s in fast]
        # of one body alone every bar would be 100 %
        if len(system.system.rotors) > 1:
            blocks.append(page_chart(share_chart(shares, "kinetic")))
        blocks.append(page_chart(share_chart(shares, "strain")))
    return Section.at(MODE_SHAPES, blocks)


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


def _names(shown: ShownModes) -> list[str]:
    """Numbers and frequencies of modes, as bars have room for."""
    hertz = shown.modes.eigenvalues.imag / (2.0 * np.pi)
    return [f"{mode_name(shown.numbers, k)}, {hertz_text(f)}" for k, f in enumerate(hertz)]


def mode_table(shown: Sequence[ShownModes]) -> Table:
    """Return frequencies, whirl and damping of modes at speeds."""
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


def viewer_data(engine: EngineInSpace, shown: Sequence[ShownModes]) -> dict[str, Any]:
    """Return surfaces, centre lines, joints and motions of modes.

    Notes
    -----
    Motions are whole numbers of 16 bits, real and imaginary part of each amplitude in turn, times
    ``scale``.
    """
    engine = with_few_points(engine)
    rotors = engine.system.system.rotors
    bodies = list(rotors)
    first, last, radius = engine.reach_m
    return {
        "bodies": [{"name": n, "ratio": r.speed_ratio} for n, r in rotors.items()],
        "pieces": [
            {
                "body": bodies.index(p.body),
                "kind": p.surface.kind,
                "disk": bool(p.disk),
                "points": p.surface.points_m,
                "cells": p.surface.cells,
            }
            for p in engine.pieces
        ],
        "stations": {
            "body": np.array([bodies.index(s.body) for s in engine.stations]),
            "z": np.array([s.axial_m for s in engine.stations]),
            "orbit": np.array([s.has_orbit for s in engine.stations], dtype=int),
        },
        "lines": [np.array(at) for at in engine.lines.values()],
        "joints": [joint._asdict() for joint in engine.joints],
        "reach": {"first": first, "last": last, "radius": radius},
        "states": [
            {"label": s.label, "modes": [_mode(engine, s, k) for k in range(len(s.texts))]}
            for s in shown
        ],
    }


def _mode(engine: EngineInSpace, shown: ShownModes, k: int) -> dict[str, Any]:
    mode = mode_in_space(engine, shown, k)
    value = shown.modes.eigenvalues[k]
    return {
        "label": shown.texts[k],
        "hertz": float(value.imag / (2.0 * np.pi)),
        "rpm": float(shown.rpm[k]),
        "whirl": shown.whirl[k],
        "growth": float(value.real),
        "terms": [_terms(piece, mode.coordinates[piece.body]) for piece in engine.pieces],
        "center": packed(mode.center),
        "sense": list(mode.senses),
    }


def _terms(piece: Piece, motion: ComplexArray) -> dict[str, Any]:
    """Amplitudes (p, 3) by circumferential order and family; of a solid order 0, family 0."""
    surface = piece.surface
    q = motion[surface.coordinate]
    orders, families, values = [], [], []
    for order, family in sorted(
        {*zip(surface.order.tolist(), surface.family.tolist(), strict=True)}
    ):
        own = (surface.order == order) & (surface.family == family)
        if np.any(q[own]):
            orders.append(order)
            families.append(family)
            fields = surface.amplitudes if own.all() else surface.amplitudes[:, :, own]
            values.append(moved_by(fields, q[own]))
    return {"order": orders, "family": families, **packed(np.array(values))}


def turning_viewer(block: TurningModes) -> ModeViewer:
    """Return the viewer of modes in the frame that turns with their body."""
    points, count = block.points_m, block.copies
    axial = points[:, 2] if count else points[:, 0]
    radius = np.hypot(points[:, 0], points[:, 1]) if count else points[:, 1]
    if count:
        kept, cells = kept_of_sector(points, block.cells, max(_MOST_POINTS // count, 60))
    else:
        spacing = _OUTLINE * float(np.ptp(points, axis=0).max())
        kept, cells = kept_of_outline(points, block.cells, spacing)
    states = [
        {"label": label, "modes": [_turning_mode(mode, kept, count) for mode in modes]}
        for label, modes in block.states
    ]
    return ModeViewer(
        name=block.name,
        title=block.title,
        caption=block.caption,
        alt=block.alt,
        data={
            "turns": True,
            "bodies": [{"name": block.body, "ratio": 0.0}],
            "pieces": [_turning_piece(points[kept], cells, count)],
            "stations": {k: np.empty(0) for k in ("body", "z", "orbit")},
            "lines": [np.empty(0, dtype=int)],
            "joints": [],
            "reach": {
                "first": float(axial.min()),
                "last": float(axial.max()),
                "radius": float(radius.max()),
            },
            "states": states,
        },
    )


def _turning_piece(points: FloatArray, cells: IntArray, count: int | None) -> dict[str, Any]:
    kind = "sector" if count else "meridian"
    return {
        "body": 0, "kind": kind, "copies": count or 0, "disk": False, "points": points,
        "cells": cells,
    }  # fmt: skip


def _turning_mode(mode: TurningMode, kept: IntArray, count: int | None) -> dict[str, Any]:
    moved, order = mode.displacement[kept], mode.order
    orders, families, values = [order], [0], [moved]
    if count is None and order:
        # A e^{inθ} of the cos and the sin family (a cos, b sin, c cos), (a sin, -b cos, c sin)
        sign = 1j if order > 0 else -1j
        moved = moved * np.array([1.0, sign, 1.0])
        orders, families, values = [abs(order)] * 2, [0, 1], [moved, sign * moved]
    return {
        "label": mode.label,
        "hertz": mode.hertz,
        "rpm": 0.0,
        "whirl": mode.whirl,
        "growth": 0.0,
        "terms": [{"order": orders, "family": families, **packed(np.array(values))}],
        "center": packed(np.empty(0, dtype=complex)),
        "sense": [],
    }


def packed(values: ComplexArray) -> dict[str, Any]:
    """Return complex numbers as whole ones of 16 bits, two to a number of 32, and their scale.

    `values`: of any shape; real and imaginary parts follow each other.
    """
    flat = np.ascontiguousarray(values, dtype=complex).view(float).ravel()
    largest = float(np.abs(flat).max(initial=0.0))
    scale = largest / _WHOLE if largest > NOTHING else 1.0
    whole = np.round(flat / scale).astype("<i2")
    return {"scale": scale, "packed": whole.view("<i4")}
