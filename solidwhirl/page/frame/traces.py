"""Pieces of plotly traces of views that are no `Chart`, and numbers and names of documents."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray as FloatArray
from solidwhirl.rotordyn.plots.chart import series_look

Trace = dict[str, Any]

# Blue to yellow in equal steps of lightness, told apart with any colour vision and in grey.
MAP_COLORS = "Cividis"


class WhirlStyle(NamedTuple):
    """Colour, dashes and mark of a direction of whirl."""

    color: str
    dash: str
    symbol: str


def series_style(number: int) -> WhirlStyle:
    """Return the style of one of several curves, from 0; all of it recurs after 24."""
    look = series_look(number)
    return WhirlStyle(look.color, look.dash, look.mark)


def numbers(values: Any) -> FloatArray:
    """Return numbers of a document as an array; None becomes nan."""
    return np.asarray(values, dtype=float)


def line(x: Any, y: Any, name: str, style: WhirlStyle, **more: Any) -> Trace:
    """Return a line through points, with further keys of the trace."""
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


def axis(title: str, **more: Any) -> dict[str, Any]:
    """Return an axis with a title."""
    return {"title": {"text": title}, **more}


def analyses_of_kind(document: Mapping[str, Any], *kinds: str) -> dict[str, Mapping[str, Any]]:
    """Return the analyses of some kinds in `results.json` by name."""
    return {k: v for k, v in document.get("analyses", {}).items() if v["kind"] in kinds}


def slug(text: str) -> str:
    """Return a text, such as the name of an analysis, as part of an identifier in the page.

    Other signs than letters and digits become hyphens with their number: two texts stay two.
    """
    return "".join(
        c if c.isascii() and c.isalnum() else "-" if c == "_" else f"-{ord(c):x}-" for c in text
    )
