"""Bodies in space as the page draws them, to scale, one at a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.core.blocks import CutBodies
from solidwhirl.page.frame import records
from solidwhirl.page.frame.plotly_chart import MAP_COLORS, Trace
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray

# Largest length and height of the box of a body in the view.
_LONG, _HIGH = 3.0, 1.4


class BodyInSpace(NamedTuple):
    """What a list offers, and what it shows."""

    label: str
    traces: Sequence[Trace]


def surface_trace(
    points_m: FloatArray, triangles: IntArray, name: str, look: Mapping[str, Any]
) -> Trace:
    """Return the surface of a body, points (p, 3) in m; the axis lies along x, y is up."""
    x, y, z = (1e3 * points_m).T
    return {
        "type": "mesh3d",
        "x": z,
        "y": x,
        "z": y,
        "i": triangles[:, 0],
        "j": triangles[:, 1],
        "k": triangles[:, 2],
        "flatshading": True,
        "name": name,
        "hovertemplate": name + "<br>z %{x:.4g}, x %{y:.4g}, y %{z:.4g} mm<extra></extra>",
        **look,
    }


def cut_bodies_chart(block: CutBodies, analysis: str) -> records.Chart:
    """Return bodies cut open, coloured by a value."""
    bodies = []
    for body in block.bodies:
        words = f"{body.label}<br>{body.quantity}<br>%{{intensity:.4g}} {body.unit}"
        look = {
            "intensity": body.values,
            "colorscale": MAP_COLORS,
            "cmin": 0.0,
            "cmax": body.largest,
            "colorbar": {"title": {"text": f"[{body.unit}]"}, "thickness": 14, "len": 0.8},
            "flatshading": False,
            "lighting": {"ambient": 0.9, "diffuse": 0.2, "specular": 0.0},
            "hovertemplate": words + "<br>z %{x:.4g}, x %{y:.4g}, y %{z:.4g} mm<extra></extra>",
        }
        trace = surface_trace(body.points_m, body.triangles, body.label, look)
        bodies.append(BodyInSpace(body.label, [trace]))
    name = f"{block.name}-{analysis}"
    told = {"title": block.title, "caption": block.caption, "alt": block.alt}
    return chart_in_space(name, "state and body", bodies, **told)


def chart_in_space(
    name: str, listed: str, bodies: Sequence[BodyInSpace], **words: str
) -> records.Chart:
    """Return a chart of bodies, of which one is shown.

    `listed`: what the list over the chart is of. `words`: title, caption, alt.
    """
    traces: list[Trace] = []
    options = []
    for body in bodies:
        shown = [*range(len(traces), len(traces) + len(body.traces))]
        layout = {"scene.aspectratio": _aspect(body.traces)}
        options.append(records.Option(label=body.label, traces=shown, layout=layout))
        traces += body.traces
    axis = {"tickformat": ".4~r"}
    return records.Chart(
        name=name,
        traces=traces,
        layout={
            "scene": {
                # by hand: to scale as "data" is, but a slender body stays in view
                "aspectmode": "manual",
                "aspectratio": options[0].layout["scene.aspectratio"],
                "xaxis": {"title": {"text": "z [mm]"}, **axis},
                "yaxis": {"title": {"text": "x [mm]"}, **axis},
                "zaxis": {"title": {"text": "y [mm]"}, **axis},
                "camera": {
                    "eye": {"x": 0.6, "y": -1.45, "z": 0.6},
                    "projection": {"type": "orthographic"},
                },
            },
            "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
            "showlegend": False,
        },
        height_px=500,
        controls=(records.Choice(label=listed, options=options),) if len(options) > 1 else (),
        **words,
    )


def _aspect(traces: Sequence[Trace]) -> dict[str, float]:
    """Sides of the box around what is drawn, as large as the view; the axis lies along x."""
    sides = {key: float(np.nanmax(v) - np.nanmin(v)) for key in "xyz"
             for v in [np.concatenate([t[key] for t in traces])]}  # fmt: skip
    scale = min(_LONG / sides["x"], _HIGH / max(sides["y"], sides["z"]))
    return {key: scale * side for key, side in sides.items()}
