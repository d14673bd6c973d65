"""A drawing as SVG; its colours are the page's CSS variables."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

from solidwhirl.drawing import shapes

_COLORS = 8
# Directions of hatching in degrees and its distance, by body: they differ without their colour.
_HATCHES = ((45, 6), (-45, 6), (0, 5), (90, 5), (45, 10), (-45, 10), (0, 9), (90, 9))


def svg_of(drawing: shapes.Drawing, alt: str = "drawing to scale") -> str:
    """Return a drawing as SVG, with what it is for those who can't see it."""
    style = f'font-family="inherit" font-size="{shapes.SIZE:g}" fill="var(--ink)"'
    box = f'viewBox="0 0 {_number(drawing.width)} {_number(drawing.height)}"'
    said = f'role="img" aria-label="{escape(alt)}"'
    parts = [*_patterns(drawing.bodies), *map(_element, drawing.shapes)]
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {box} {said} {style}>'
    return "\n".join([head, *parts, "</svg>"])


def _element(shape: shapes.Shape) -> str:
    match shape:
        case shapes.Polygon():
            return f'<polygon points="{_listed(shape.points)}" {_look(shape.style)}/>'
        case shapes.Line():
            return f'<polyline points="{_listed(shape.points)}" {_look(shape.style)}/>'
        case shapes.Circle():
            place = f'cx="{_number(shape.x)}" cy="{_number(shape.y)}" r="{_number(shape.radius)}"'
            return f"<circle {place} {_look(shape.style)}/>"
        case shapes.Group():
            inside = "".join(map(_element, shape.shapes))
            return f"<g><title>{escape(shape.title)}</title>{inside}</g>"
        case shapes.Words():
            x, y = _number(shape.x), _number(shape.y)
            turn = f' transform="rotate({shape.angle:g} {x} {y})"' if shape.angle else ""
            tint = "" if shape.color == "ink" else f' fill="{_color(shape.color)}"'
            place = f'x="{x}" y="{y}" text-anchor="{shape.anchor}"'
            return f"<text {place}{turn}{tint}>{escape(shape.text)}</text>"


def _look(style: shapes.Style) -> str:
    fill = f"url(#drawing-hatch-{style.hatch})" if style.hatch >= 0 else _color(style.fill)
    found = [f'fill="{fill}"']
    if style.stroke:
        found.append(f'stroke="{_color(style.stroke)}" stroke-width="{style.width:g}"')
        found.append('stroke-linejoin="round"' if style.hatch >= 0 else "")
    if style.dashes:
        found.append(f'stroke-dasharray="{" ".join(f"{d:g}" for d in style.dashes)}"')
    if style.opacity < 1.0:
        found.append(f'{"fill" if style.fill else "stroke"}-opacity="{style.opacity:.2g}"')
    return " ".join(filter(None, found))


def _color(name: str) -> str:
    if name[:1] == "c":
        name = f"c{int(name[1:]) % _COLORS}"
    return f"var(--{name})" if name else "none"


def _patterns(count: int) -> Iterator[str]:
    """The hatchings of bodies."""
    yield "<defs>"
    for k in range(count):
        angle, step = _HATCHES[k % len(_HATCHES)]
        color = _color(f"c{k}")
        yield (
            f'<pattern id="drawing-hatch-{k}" patternUnits="userSpaceOnUse" width="{step}" '
            f'height="{step}" patternTransform="rotate({angle})"><rect width="{step}" '
            f'height="{step}" fill="{color}" fill-opacity="0.13"/><line x1="0" y1="0" '
            f'x2="{step}" y2="0" stroke="{color}" stroke-width="1.3" stroke-opacity="0.75"/>'
            "</pattern>"
        )
    yield "</defs>"


def _listed(points: object) -> str:
    return " ".join(f"{_number(x)},{_number(y)}" for x, y in points)  # type: ignore[attr-defined]


def _number(value: float) -> str:
    """A coordinate with one decimal, as short as can be."""
    text = f"{value:.1f}"
    return text[:-2] if text.endswith(".0") else text
