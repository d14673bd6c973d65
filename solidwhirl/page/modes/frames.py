"""The Campbell diagram of a page as bodies see it that turn."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from solidwhirl.page.frame.plotly_chart import page_chart
from solidwhirl.page.frame.records import Run, Section
from solidwhirl.page.frame.traces import analyses_of_kind, numbers
from solidwhirl.rotordyn.plots.modes import FrameCurves, frame_chart, is_drawn


def section(run: Run) -> Section | None:
    """Return the diagrams in the frames of bodies; None where the scene asks for none."""
    found = analyses_of_kind(run.document, "rotating_campbell")
    if not found:
        return None
    return Section(
        name="rotating-frames",
        title="Frequencies that the bodies see",
        blocks=[page_chart(frame_chart(frames_of(e)), name) for name, e in found.items()],
        note="What a strain gauge on a turning body would measure.",
    )


def frames_of(entry: Mapping[str, Any]) -> list[FrameCurves]:
    """Return what bodies see, from the part of `results.json` of an analysis."""
    rpm, found = numbers(entry["speed_rpm"]), []
    for body, frame in entry["bodies"].items():
        hertz, orders = numbers(frame["frequency_hz"]), np.array(frame["orders"])
        # a positive order turns with +z, and so does a body with a positive ratio, until mirrored
        against = np.array(frame["mirrored"], dtype=bool) ^ (
            orders[:, None, None] * np.sign(frame["speed_ratio"]) < 0
        )
        drawn = is_drawn(numbers(frame["share"]), numbers(frame["share_of_kinetic_energy"]))
        found.append(
            FrameCurves(
                name=f"{body} (speed ratio {frame['speed_ratio']:.5g})",
                rpm=np.abs(frame["speed_ratio"]) * rpm,
                signed_hz=np.where(drawn, np.where(against, -hertz, hertz), np.nan),
                orders=orders.tolist(),
            )
        )
    return found
