"""Pieces of SVG; colours are the page's CSS variables."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

import numpy as np
from numpy.typing import NDArray

# Width of a letter and height of a line at the size of the labels.
LETTER, LINE, SIZE = 6.7, 15.0, 12.0


def number(value: float) -> str:
    """Write a coordinate with one decimal, as short as can be."""
    text = f"{value:.1f}"
    return text[:-2] if text.endswith(".0") else text


def polygon(points: NDArray[np.float64], attributes: str) -> str:
    """Return a polygon through points (k, 2)."""
    listed = " ".join(f"{number(x)},{number(y)}" for x, y in points)
    return f'<polygon points="{listed}" {attributes}/>'


def line(x1: float, y1: float, x2: float, y2: float, attributes: str) -> str:
    """Return a line."""
    ends = f'x1="{number(x1)}" y1="{number(y1)}" x2="{number(x2)}" y2="{number(y2)}"'
    return f"<line {ends} {attributes}/>"


def polyline(points: Iterable[tuple[float, float]], attributes: str) -> str:
    """Return a line through points, which encloses nothing."""
    listed = " ".join(f"{number(x)},{number(y)}" for x, y in points)
    return f'<polyline points="{listed}" fill="none" {attributes}/>'


def text(x: float, y: float, words: str, *, anchor: str = "middle", more: str = "") -> str:
    """Return a text."""
    place = f'x="{number(x)}" y="{number(y)}" text-anchor="{anchor}"'
    return f"<text {place} {more}>{escape(words)}</text>"


def document(width: float, height: float, parts: Iterable[str], alt: str) -> str:
    """Return a whole picture."""
    style = f'font-family="inherit" font-size="{SIZE:g}" fill="var(--ink)"'
    box = f'viewBox="0 0 {number(width)} {number(height)}"'
    said = f'role="img" aria-label="{escape(alt)}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {box} {said} {style}>'
    return "\n".join([head, *parts, "</svg>"])


def ruler_steps(low: float, high: float, most: int) -> list[float]:
    """Return round places within a range, at most so many but more than a third of that."""
    span = high - low
    raw = span / most
    power = 10.0 ** np.floor(np.log10(raw))
    step = next(f * power for f in (1.0, 2.0, 5.0, 10.0) if f * power >= raw * (1.0 - 1e-9))
    first = np.ceil(low / step - 1e-9)
    last = np.floor(high / step + 1e-9)
    return [float(k * step) + 0.0 for k in np.arange(first, last + 1.0)]
