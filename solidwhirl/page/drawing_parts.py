"""Symbols of the engine drawing: hatched bodies, bearings, ground, gears, disks, centres."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solidwhirl.page.silhouettes import Silhouette
from solidwhirl.page.svg import line, number, polygon

FloatArray = NDArray[np.float64]
# Directions of hatching in degrees and its distance, by body: they differ without their colour.
_HATCHES = ((45, 6), (-45, 6), (0, 5), (90, 5), (45, 10), (-45, 10), (0, 9), (90, 9))
_COLORS = 8
# Half the size of a bearing's box, of a wheel, and distance of what lies beyond it.
BOX, WHEEL, BEYOND = 6.0, 7.0, 20.0
_INK = 'stroke="var(--ink)" stroke-width="1.4" fill="none"'


@dataclass(frozen=True, kw_only=True)
class Frame:
    """Where metres are on the picture.

    Attributes
    ----------
    left, axis
        Of z = first_m and of the axis.
    first_m
        The first z.
    scale
        Units of the picture per metre, alike in both directions.
    """

    left: float
    axis: float
    first_m: float
    scale: float

    def x(self, z_m: float) -> float:
        """Along the axis."""
        return self.left + (z_m - self.first_m) * self.scale

    def y(self, height_m: float) -> float:
        """Across, upwards."""
        return self.axis - height_m * self.scale

    def points(self, area_m: FloatArray) -> FloatArray:
        """Corners (k, 2) of (z, height) on the picture."""
        z, height = area_m.T
        x = self.left + (z - self.first_m) * self.scale
        return np.column_stack([x, self.axis - height * self.scale])


class Joint(NamedTuple):
    """A bearing as it is drawn: its place and radii, what lies beyond, its rank there."""

    x: float
    inner: float
    outer: float
    beyond: str
    rank: int


def color(index: int) -> str:
    """Colour of a body."""
    return f"var(--c{index % _COLORS})"


def patterns(count: int) -> Iterator[str]:
    """Return the hatchings of bodies, and that of the ground."""
    yield "<defs>"
    for k in range(count):
        angle, step = _HATCHES[k % len(_HATCHES)]
        yield (
            f'<pattern id="drawing-hatch-{k}" patternUnits="userSpaceOnUse" width="{step}" '
            f'height="{step}" patternTransform="rotate({angle})"><rect width="{step}" '
            f'height="{step}" fill="{color(k)}" fill-opacity="0.13"/><line x1="0" y1="0" '
            f'x2="{step}" y2="0" stroke="{color(k)}" stroke-width="1.3" stroke-opacity="0.75"/>'
            "</pattern>"
        )
    yield "</defs>"


def shade(material: str, materials: Sequence[str]) -> str:
    """Return the look of a material under the hatching: the more to the right, the darker.

    Parameters
    ----------
    material
        Its name.
    materials
        Those of the engine; of one alone nothing is shaded.
    """
    darkest = 0.3 / max(len(materials) - 1, 1)
    opacity = darkest * materials.index(material) if material in materials else 0.0
    return f'fill="var(--ink)" fill-opacity="{opacity:.2g}"'


def body_parts(
    frame: Frame, body: Silhouette, index: int, materials: Sequence[str] = ()
) -> Iterator[str]:
    """Return the areas of a body, shaded by material and named on hover, and its rigid disks.

    Parameters
    ----------
    frame
        Of the picture.
    body
        The body.
    index
        Its number, which chooses colour and hatching.
    materials
        Of the engine.
    """
    look = (
        f'fill="url(#drawing-hatch-{index})" stroke="{color(index)}" stroke-width="1.1" '
        'stroke-linejoin="round"'
    )
    for k, area in enumerate(body.areas_m):
        points = frame.points(area)
        if not body.labels:
            yield polygon(points, look)
            continue
        yield f"<g><title>{escape(body.labels[k])}</title>"
        if body.materials[k] in materials[1:]:
            yield polygon(points, shade(body.materials[k], materials))
        yield polygon(points, look) + "</g>"
    for disk in body.disks:
        x, reach = frame.x(disk.at_m), disk.gyration_m * frame.scale
        own = f'stroke="{color(index)}" stroke-width="1.6"'
        yield line(x, frame.axis - reach, x, frame.axis + reach, own + ' stroke-dasharray="2 3"')
        for y in (frame.axis - reach, frame.axis + reach):
            yield (
                f'<rect x="{number(x - 5)}" y="{number(y - 3)}" width="10" height="6" rx="1.5" '
                f'fill="{color(index)}"><title>rigid disk {body.name}: {disk.name}</title></rect>'
            )


def center_mark(frame: Frame, body: Silhouette, index: int) -> str:
    """Return the mark of a centre of gravity: a circle with two dark quarters."""
    x, y, r = frame.x(body.center_m[0]), frame.y(body.center_m[1]), 5.5
    quarter = f"M{number(x)},{number(y)}"
    return (
        f'<g><title>centre of gravity of {body.name}</title><circle cx="{number(x)}" '
        f'cy="{number(y)}" r="{r}" fill="var(--paper)" stroke="{color(index)}" stroke-width="1.5"/>'
        f'<path d="{quarter}h{r}a{r},{r} 0 0 0 -{r},-{r}z{quarter}h-{r}a{r},{r} 0 0 0 {r},{r}z" '
        f'fill="{color(index)}"/></g>'
    )


def joint_parts(frame: Frame, joint: Joint, casing: float) -> Iterator[str]:
    """Return a bearing on both sides of the axis: a crossed box, and what it is held by.

    Parameters
    ----------
    frame
        Of the picture.
    joint
        The bearing; `beyond` is "ground", "casing" or "body".
    casing
        Distance of the casing from the axis.
    """
    for side in (-1.0, 1.0):
        middle = 0.5 * (joint.inner + joint.outer)
        if joint.beyond != "body":
            middle = joint.inner + BOX + joint.rank * (2 * BOX + 10)
        y = frame.axis + side * middle
        if joint.beyond == "casing" and casing > middle + BOX:
            yield line(joint.x, y + side * BOX, joint.x, frame.axis + side * casing, _INK)
        if joint.rank and joint.beyond == "ground":
            yield line(joint.x, frame.axis + side * joint.inner, joint.x, y - side * BOX, _INK)
        if joint.beyond == "ground":
            yield from _ground(joint.x, y + side * BOX, side)
        yield from _box(joint.x, y)


def _box(x: float, y: float) -> Iterator[str]:
    corner = f'x="{number(x - BOX)}" y="{number(y - BOX)}" width="{2 * BOX:g}" height="{2 * BOX:g}"'
    yield f'<rect {corner} fill="var(--paper)" stroke="var(--ink)" stroke-width="1.4"/>'
    yield line(x - BOX, y - BOX, x + BOX, y + BOX, _INK)
    yield line(x - BOX, y + BOX, x + BOX, y - BOX, _INK)


def _ground(x: float, y: float, side: float) -> Iterator[str]:
    foot = y + side * 4
    yield line(x, y, x, foot, _INK)
    yield line(x - 10, foot, x + 10, foot, _INK)
    for k in range(-1, 3):
        start = x + 6 * k - 3
        yield line(start, foot, start - 4, foot + side * 4, 'stroke="var(--ink)" stroke-width="1"')


def gear_parts(first: tuple[float, float], second: tuple[float, float]) -> Iterator[str]:
    """Return a gear: a wheel at each seat and a line between them.

    Parameters
    ----------
    first, second
        Places of the seats on the picture.
    """
    yield line(*first, *second, 'stroke="var(--ink)" stroke-width="1.6" stroke-dasharray="6 3"')
    for x, y in (first, second):
        circle = f'cx="{number(x)}" cy="{number(y)}"'
        yield (
            f'<circle {circle} r="{WHEEL:g}" fill="var(--paper)" stroke="var(--ink)" '
            'stroke-width="3" stroke-dasharray="2.2 2.2"/>'
        )
        yield f'<circle {circle} r="{WHEEL - 2.5:g}" fill="none" stroke="var(--ink)"/>'
