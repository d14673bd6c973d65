"""Operating speeds that a scene names in its analyses, for charts over the speed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from solidwhirl.operating import Operating, margin_of
from solidwhirl.operating import operating_speeds as scene_operating
from solidwhirl.page.traces import Trace, band

if TYPE_CHECKING:
    from solidwhirl.pipeline import Results

_RAD_S = math.pi / 30.0


def operating_speeds(
    document: Mapping[str, Any], ratios: Mapping[str, float]
) -> tuple[Operating, ...]:
    """Return the operating speeds of shafts, each once.

    Parameters
    ----------
    document
        The contents of `results.json`.
    ratios
        Speed ratio of every body.
    """
    return tuple(
        Operating(o["shaft"], o["from_rpm"], o["to_rpm"], abs(ratios[o["shaft"]]))
        for o in document["operating"]
    )


def operating_rad_s(results: Results) -> dict[str, tuple[float, float]]:
    """Return the operating speeds as speeds of the reference shaft, for static diagrams.

    Parameters
    ----------
    results
        Of a run.

    Returns
    -------
    dict
        Lowest and highest speed, rad/s, by what a legend says.
    """
    return {
        o.text: (o.from_rpm / o.ratio * _RAD_S, o.to_rpm / o.ratio * _RAD_S)
        for o in scene_operating(results.scene)
    }


def margin_words(margin: float) -> str:
    """Return the distance of a critical speed from operating speeds in words.

    Parameters
    ----------
    margin
        (N_c − N_op) / N_op, 0 inside.

    Returns
    -------
    str
        Such as "66.3 % below", or "inside".
    """
    if margin == 0.0:
        return "inside"
    size = 100.0 * abs(margin)
    said = f"{size:.1f}" if round(size, 1) > 0.0 else "less than 0.1"
    return f"{said} % {'above' if margin > 0.0 else 'below'}"


def margin_text(
    speed_rpm: float, shafts: Sequence[str], operating: Sequence[Operating]
) -> str | None:
    """Return the distance of `margin_of` in words; arguments as there."""
    found = margin_of(speed_rpm, shafts, operating)
    if found is None:
        return None
    margin, shaft = found
    return f"**inside** {shaft}" if margin == 0.0 else f"{margin_words(margin)} {shaft}"


def operating_bands(speeds: tuple[Operating, ...], bottom: float, top: float) -> list[Trace]:
    """Return operating speeds as hatched bands over the speed of the reference shaft.

    Parameters
    ----------
    speeds
        From `operating_speeds`.
    bottom, top
        Of the bands along y.
    """
    return [
        band(
            o.from_rpm / o.ratio,
            o.to_rpm / o.ratio,
            bottom,
            top,
            "operating speed",
            text=o.text,
            legendgroup="operating",
            showlegend=k == 0,
        )
        for k, o in enumerate(speeds)
    ]


def unstable_shapes(intervals: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return unstable intervals as shaded speeds, for the `shapes` of a layout.

    Parameters
    ----------
    intervals
        `unstable_intervals` of `results.json`; speeds of the reference shaft.
    """
    return [
        {
            "type": "rect",
            "x0": i["from_rpm"],
            "x1": i["to_rpm"],
            "yref": "paper",
            "y0": 0.0,
            "y1": 1.0,
            "fillcolor": "@bad",
            "opacity": 0.12,
            "line": {"width": 0},
            "layer": "below",
            "label": {"text": "unstable", "font": {"color": "@bad"}, "textposition": "top left"},
        }
        for i in intervals
    ]
