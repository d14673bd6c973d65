"""Pieces of plotly traces that the charts of a page share; whirl looks the same in all of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Trace = dict[str, Any]

SPEED_AXIS = "speed of the reference shaft [rpm]"
# Blue to yellow in equal steps of lightness, told apart with any colour vision and in grey.
MAP_COLORS = "Cividis"
_SERIES = 8
# Decades of an axis that is marked within them.
_FEW_DECADES = 1.8
# Relative errors below this are those of rounding.
_ROUNDING = 1e-6
_DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")
_SYMBOLS = ("circle", "square", "diamond", "triangle-up", "x", "cross", "star", "pentagon")


class WhirlStyle(NamedTuple):
    """Colour, dashes and mark of a direction of whirl."""

    color: str
    dash: str
    symbol: str


WHIRL = {
    "forward": WhirlStyle("@forward", "solid", "circle"),
    "backward": WhirlStyle("@backward", "dash", "square-open"),
    "mixed": WhirlStyle("@mixed", "dashdot", "diamond"),
    "planar": WhirlStyle("@planar", "dot", "diamond-open"),
}
NO_WHIRL = WhirlStyle("@planar", "dot", "diamond-open")


def style_of(whirl: str | None) -> WhirlStyle:
    """Return the style of a whirl; none, and a line, are "planar"."""
    return WHIRL.get(whirl or "planar", NO_WHIRL)


def series_style(number: int) -> WhirlStyle:
    """Return the style of one of several curves that have no whirl.

    Parameters
    ----------
    number
        From 0; colours, dashes and marks recur after 8, 6 and 8 curves, all three after 24.
    """
    return WhirlStyle(
        f"@c{number % _SERIES}",
        _DASHES[number % len(_DASHES)],
        _SYMBOLS[number % len(_SYMBOLS)],
    )


def numbers(values: Any) -> FloatArray:
    """Return numbers of a document as an array; None becomes nan."""
    return np.asarray(values, dtype=float)


def line(x: Any, y: Any, name: str, style: WhirlStyle, **more: Any) -> Trace:
    """Return a line through points.

    Parameters
    ----------
    x, y
        Points.
    name
        In the legend.
    style
        Its colour and dashes.
    more
        Further keys of the trace.
    """
    # a mark at the edge of the frame is drawn whole
    whole = {"cliponaxis": False} if "markers" in more.get("mode", "") else {}
    return {
        "type": "scatter",
        "mode": "lines",
        "x": numbers(x),
        "y": numbers(y),
        "name": name,
        "line": {"color": style.color, "dash": style.dash, "width": 2},
        **whole,
        **more,
    }


def marks(x: Any, y: Any, name: str, style: WhirlStyle, size: int = 9, **more: Any) -> Trace:
    """Return points without a line; arguments as in `line`."""
    return {
        "type": "scatter",
        "mode": "markers",
        "cliponaxis": False,
        "x": numbers(x),
        "y": numbers(y),
        "name": name,
        "marker": {
            "color": style.color,
            "symbol": style.symbol,
            "size": size,
            "line": {"color": style.color, "width": 1.5},
        },
        **more,
    }


def band(low: float, high: float, bottom: float, top: float, name: str, **more: Any) -> Trace:
    """Return a hatched rectangle over the plot, such as a range of operating speeds.

    Parameters
    ----------
    low, high
        Along x.
    bottom, top
        Along y.
    name
        In the legend and on hover.
    more
        Further keys of the trace.
    """
    return {
        "type": "scatter",
        "mode": "lines",
        "x": np.array([low, low, high, high, low], dtype=float),
        "y": np.array([bottom, top, top, bottom, bottom], dtype=float),
        "fill": "toself",
        "fillcolor": "@faint",
        "fillpattern": {
            "shape": "/",
            "fgcolor": "@muted",
            "bgcolor": "rgba(0,0,0,0)",
            "size": 9,
            "solidity": 0.12,
        },
        "line": {"color": "@muted", "width": 1},
        "name": name,
        "text": name,
        "hoverinfo": "text",
        "hoveron": "fills",
        **more,
    }


class Run(NamedTuple):
    """Points first to last (included) of a branch along which the whirl stays the same."""

    whirl: str
    first: int
    last: int


def whirl_runs(whirl: Sequence[str | None]) -> Iterator[Run]:
    """Cut a branch into runs of one whirl; a step has the whirl of its faster end.

    Parameters
    ----------
    whirl
        At every speed; None or "" where the branch has ended.
    """
    step = [b or a or "" for a, b in pairwise(whirl)]
    if not step and whirl and whirl[0]:
        yield Run(str(whirl[0]), 0, 0)
    start = 0
    for stop in range(1, len(step) + 1):
        if stop < len(step) and step[stop] == step[start]:
            continue
        if step[start]:
            yield Run(step[start], start, stop)
        start = stop


def branch_lines(
    x: FloatArray,
    y: FloatArray,
    whirl: Sequence[Sequence[str | None]],
    texts: Sequence[Sequence[str]],
    hover: str,
) -> list[Trace]:
    """Return one trace for each direction of whirl that holds all branches, with gaps between.

    Parameters
    ----------
    x
        Speeds, shape (s,).
    y
        Of the branches, shape (b, s).
    whirl, texts
        Direction and text of every point, b × s.
    hover
        Template of what is shown at a point; ``%{text}`` is its text.
    """
    xs: dict[str, list[FloatArray]] = {}
    ys: dict[str, list[FloatArray]] = {}
    words: dict[str, list[str]] = {}
    gap = np.array([np.nan])
    for k, branch in enumerate(whirl):
        for run in whirl_runs(branch):
            part = slice(run.first, run.last + 1)
            xs.setdefault(run.whirl, []).extend([x[part], gap])
            ys.setdefault(run.whirl, []).extend([y[k, part], gap])
            words.setdefault(run.whirl, []).extend([*texts[k][part], ""])
    traces = []
    for name in [w for w in WHIRL if w in xs]:
        style = WHIRL[name]
        traces.append(
            line(
                np.concatenate(xs[name][:-1]),
                np.concatenate(ys[name][:-1]),
                whirl_name(name),
                style,
                mode="lines+markers",
                text=words[name][:-1],
                hovertemplate=hover + "<extra></extra>",
                marker={"symbol": style.symbol, "size": 6, "color": style.color},
                connectgaps=False,
            )
        )
    return traces


def whirl_name(whirl: str) -> str:
    """Return the name of a direction of whirl as legends have it."""
    return {"planar": "no whirl (in a plane, axial, torsion)", "mixed": "mixed whirl"}.get(
        whirl, f"{whirl} whirl"
    )


def hertz_text(frequency_hz: float, digits: int = 4) -> str:
    """Return a frequency with its unit and so many digits, never with a power of ten.

    Parameters
    ----------
    frequency_hz
        The frequency.
    digits
        Significant ones.
    """
    text = np.format_float_positional(frequency_hz, digits, fractional=False, trim="-")
    return f"{text} Hz"


def percent(value: float | None) -> str:
    """Return a relative error as text."""
    if value is None or not np.isfinite(value):
        return "not known"
    if value < _ROUNDING:
        return f"below ±{100.0 * _ROUNDING:g} %"
    return f"±{100.0 * value:.2g} %"


def log_axis(title: str, low: float, high: float) -> dict[str, Any]:
    """Return a logarithmic axis; one of many decades is marked at whole ones only.

    Parameters
    ----------
    title
        With the unit.
    low, high
        Ends, above zero.
    """
    ends = [float(np.log10(low)), float(np.log10(high))]
    few = ends[1] - ends[0] < _FEW_DECADES
    steps = {} if few else {"dtick": 1}
    return {
        "title": {"text": title},
        "type": "log",
        "range": ends,
        "exponentformat": "power",
        **steps,
    }


def speed_axes(rpm: FloatArray, title: str, low: float, high: float) -> dict[str, Any]:
    """Return axes over the speed of what reaches from low to high, seven decades of it at most."""
    return {
        "xaxis": axis(SPEED_AXIS, range=[float(rpm.min()), float(rpm.max())]),
        "yaxis": log_axis(title, max(low, high * 1e-7), 1.6 * high),
    }


def axis(title: str, **more: Any) -> dict[str, Any]:
    """Return an axis with a title."""
    return {"title": {"text": title}, **more}


def metric(largest: float, unit: str) -> tuple[str, float]:
    """Return a unit with a prefix in which a size is a number of a few digits, and its factor.

    Parameters
    ----------
    largest
        The size.
    unit
        Without prefix.
    """
    size = abs(float(largest))
    for prefix, factor in (("G", 1e-9), ("M", 1e-6), ("k", 1e-3), ("", 1.0), ("m", 1e3)):
        if size * factor >= 1.0:
            return prefix + unit, factor
    for prefix, factor in (("µ", 1e6), ("n", 1e9)):
        if size * factor >= 1.0 or size == 0.0:
            return prefix + unit, factor
    return "p" + unit, 1e12


def analyses_of_kind(document: Mapping[str, Any], *kinds: str) -> dict[str, Mapping[str, Any]]:
    """Return the analyses of some kinds in `results.json` by name."""
    return {k: v for k, v in document.get("analyses", {}).items() if v["kind"] in kinds}


def slug(text: str) -> str:
    """Return a text as part of an identifier in the page.

    Parameters
    ----------
    text
        Such as the name of an analysis; other signs than letters and digits become hyphens with
        their number, so that two texts stay two.
    """
    return "".join(
        c if c.isascii() and c.isalnum() else "-" if c == "_" else f"-{ord(c):x}-" for c in text
    )
