"""Damping of the branches of the Campbell diagram of a page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from solidwhirl.page.campbell_lines import branches, point_texts
from solidwhirl.page.records import Chart
from solidwhirl.page.traces import SPEED_AXIS, axis, branch_lines

# Decrements above this, close to critical damping, would flatten all others.
_LARGEST_DECREMENT = 2.0


def damping_chart(document: Mapping[str, Any]) -> Chart:
    """Return the logarithmic decrements over the speed; below zero it is unstable."""
    lines = branches(document)
    largest = float(np.nanmax(lines.decrement))
    smallest = float(np.nanmin(lines.decrement))
    top = 1.08 * min(max(largest, 1e-3), _LARGEST_DECREMENT)
    bottom = min(1.2 * smallest, -0.08 * top)
    first, last = float(lines.rpm.min()), float(lines.rpm.max())
    traces = branch_lines(
        lines.rpm,
        lines.decrement,
        lines.whirl,
        point_texts(lines, with_frequency=True),
        "%{x:,.0f} rpm<br><b>log. decrement %{y:.4g}</b><br>%{text}",
    )
    grows = {
        "type": "rect",
        "xref": "paper",
        "x0": 0.0,
        "x1": 1.0,
        "y0": bottom,
        "y1": 0.0,
        "fillcolor": "@bad",
        "opacity": 0.12,
        "line": {"width": 0},
        "layer": "below",
        "label": {"text": "unstable", "font": {"color": "@bad"}},
    }
    caption = "Damping of the branches; the shaded range below zero is unstable."
    if largest > top:
        caption += (
            f" Decrements above {_LARGEST_DECREMENT:g} leave the frame (up to {largest:.3g}): "
            "double-click shows them."
        )
    return Chart(
        name="campbell-damping",
        title="Damping over the speed",
        caption=caption,
        alt=f"Logarithmic decrements of {len(lines.hertz)} branches, {smallest:.3g} to "
        f"{largest:.3g}.",
        traces=traces,
        layout={
            "xaxis": axis(SPEED_AXIS, range=[first, max(last, first + 1.0)]),
            "yaxis": axis("logarithmic decrement [1]", range=[bottom, top]),
            "shapes": [grows],
            "hovermode": "closest",
        },
        height_px=360,
    )
