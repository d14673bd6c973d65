"""Labels above and below the engine drawing, none over another, with lines to their places."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from solidwhirl.drawing.shapes import LETTER, LINE, Line, Shape, Style, Words
from solidwhirl.rotordyn.core.arrays import FloatArray

# Labels stay upright if none has to move farther than this.
_FARTHEST = 70.0
_ANGLE = 55.0
_ELBOW = 16.0
_BETWEEN = 10.0


@dataclass(frozen=True, kw_only=True)
class Label:
    """Lines of words and the place along the picture that they are of."""

    x: float
    words: tuple[str, ...]


def _width(label: Label) -> float:
    return LETTER * max(len(line) for line in label.words)


def _single(labels: Sequence[Label]) -> list[Label]:
    """Labels of one line each."""
    return [Label(x=label.x, words=(line,)) for label in labels for line in label.words]


def _flat(labels: Sequence[Label], width: float) -> list[float] | None:
    """Centres of labels side by side; None if they do not fit near their places."""
    widths = [_width(label) + _BETWEEN for label in labels]
    at: list[float] = spread([label.x for label in labels], widths).tolist()
    for k in range(len(at) - 1, -1, -1):
        last = k == len(at) - 1
        most = width - 0.5 * widths[k]
        at[k] = min(at[k], most if last else at[k + 1] - 0.5 * (widths[k] + widths[k + 1]))
    for k in range(len(at)):
        least = 0.5 * widths[k]
        at[k] = max(at[k], at[k - 1] + 0.5 * (widths[k - 1] + widths[k]) if k else least)
    near = all(abs(x - label.x) <= _FARTHEST for label, x in zip(labels, at, strict=True))
    inside = all(x + 0.5 * w <= width + 1e-9 for x, w in zip(at, widths, strict=True))
    return at if inside and near else None


def _slanted(labels: Sequence[Label], width: float) -> list[float]:
    """Feet of slanted labels, inside the picture."""
    step = LINE / math.sin(math.radians(_ANGLE)) - 2.0
    at: list[float] = spread([label.x for label in labels], [step] * len(labels)).tolist()
    room = [0.62 * _width(label) * math.cos(math.radians(_ANGLE)) for label in labels]
    for k in range(len(at) - 1, -1, -1):
        most = width - 4.0 - room[k] if k == len(at) - 1 else at[k + 1] - step
        at[k] = min(at[k], most, width - 12.0 - _width(labels[k]) * math.cos(math.radians(_ANGLE)))
    for k in range(len(at)):
        at[k] = max(at[k], 10.0 if k == 0 else at[k - 1] + step)
    return at


def label_height(labels: Sequence[Label], width: float) -> float:
    """Return the height that labels need, with their lines; their places rise."""
    if not labels:
        return 8.0
    if _flat(labels, width) is not None:
        return LINE * max(len(label.words) for label in labels) + _ELBOW + 6.0
    longest = max(_width(label) for label in labels)
    return longest * math.sin(math.radians(_ANGLE)) + LINE + _ELBOW


def label_block(
    labels: Sequence[Label], width: float, base: float, target: float, way: str
) -> Iterator[Shape]:
    """Return labels, whose places rise, above the drawing (way "up") or below it ("down").

    `base` is the edge of the drawing towards them, `target` where their lines end.
    """
    if not labels:
        return
    flat = _flat(labels, width)
    side = -1.0 if way == "up" else 1.0
    foot = base + side * _ELBOW
    look = Style(stroke="muted", width=0.8, opacity=0.75)
    shown = list(labels) if flat is not None else _single(labels)
    for label, x in zip(shown, flat or _slanted(shown, width), strict=True):
        yield Line(((label.x, target), (label.x, base), (x, foot)), look)
        if flat is not None:
            first = -4.0 - LINE * (len(label.words) - 1) if way == "up" else 13.0
            for k, words in enumerate(label.words):
                yield Words(x, foot + first + k * LINE, words)
            continue
        y = foot + (-3.0 if way == "up" else 9.0)
        yield Words(x, y, label.words[0], anchor="start", angle=side * _ANGLE)


def spread(places: Sequence[float], widths: Sequence[float]) -> FloatArray:
    """Return places of labels, as near as can be to those they belong to, without overlaps.

    The sum of squares of the distances is the smallest one that keeps their order (isotonic
    regression by pooling of neighbours).
    """
    wanted = np.asarray(places, dtype=float)
    order = np.argsort(wanted, kind="stable")
    size = np.asarray(widths, dtype=float)[order]
    # measured from where each would be if all stood side by side, they only need to rise
    packed = np.concatenate(([0.0], np.cumsum(0.5 * (size[1:] + size[:-1]))))[: len(size)]
    groups: list[tuple[float, int]] = []
    for value in wanted[order] - packed:
        total, count = float(value), 1
        while groups and groups[-1][0] / groups[-1][1] > total / count:
            before = groups.pop()
            total, count = total + before[0], count + before[1]
        groups.append((total, count))
    out = np.empty(len(wanted))
    out[order] = packed + [total / n for total, n in groups for _ in range(n)]
    return out
