"""Mode shapes of a page: in space, along the axis, and who takes part in them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from solidwhirl.analyses.base import MODE_SHAPES
from solidwhirl.core.blocks import whirl_text
from solidwhirl.drawing.modes import ShownModes, shown_modes
from solidwhirl.drawing.motion import EngineInSpace, engine_in_space
from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.records import ModeViewer, Run, Section, Table
from solidwhirl.page.modes.viewer_data import viewer_data
from solidwhirl.rotordyn.modes.damping import log_decrement
from solidwhirl.rotordyn.modes.mode_shapes import mode_shapes
from solidwhirl.rotordyn.modes.participation import participation
from solidwhirl.rotordyn.plots.chart import hertz_text
from solidwhirl.rotordyn.plots.frame import mode_name
from solidwhirl.rotordyn.plots.modes import deflection_chart, share_chart


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
