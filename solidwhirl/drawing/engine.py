"""The drawing of an engine to scale as plain shapes: bodies, joints, nodes, labels, rulers.

A page writes it as SVG, print draws it with matplotlib. Lengths are units of the picture: letters
are 12 high; y points downwards.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from solidwhirl.drawing.bodies import Silhouette
from solidwhirl.drawing.labels import Label, label_block, label_height
from solidwhirl.drawing.shapes import (
    LETTER,
    LINE,
    Circle,
    Drawing,
    Group,
    Line,
    Polygon,
    Shape,
    Style,
    Words,
    ruler_steps,
)
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.superelement.validation import MOTIONS
from solidwhirl.scene.joints import BearingSpec
from solidwhirl.scene.records import Scene

_MARGIN, _RULER, _LEGEND_LINE = 58.0, 46.0, 22.0
_MOST_TICKS, _TICK_WIDTH = 12, 36.0
# Half the size of a bearing's box, of a wheel, and distance of what lies beyond it.
_BOX, _WHEEL, _BEYOND = 6.0, 7.0, 20.0
# Distance of bearings on the ground at one place, drawn one outside the other.
_STEP = 2 * _BOX + 10
_INK, _AXIS = Style(stroke="ink", width=1.4), Style(stroke="muted", dashes=(14, 4, 2, 4))
_RULE, _TEETH = Style(stroke="muted"), Style(stroke="ink", width=1.6, dashes=(6, 3))
#: Place along z, m, and words.
Named = tuple[float, str]


@dataclass(frozen=True, kw_only=True)
class _Plan:
    """What is drawn and where: left of the first z, axis, scale, casing, half the height.

    `bare` has the distances from the axis of bodies of which nothing but nodes is known.
    """

    bodies: tuple[Silhouette, ...]
    bare: Mapping[str, float]
    left: float
    axis: float
    first_m: float
    scale: float
    casing: float
    half: float
    width: float

    def x(self, z_m: float) -> float:
        return self.left + (z_m - self.first_m) * self.scale

    def y(self, height_m: float) -> float:
        return self.axis - height_m * self.scale

    def points(self, area_m: FloatArray) -> FloatArray:
        """Corners (k, 2) of (z, height) on the picture."""
        return np.array([[self.x(z), self.y(height)] for z, height in area_m])

    def node(self, end: str) -> tuple[Silhouette, float, float]:
        """Body of "body.node", where the node is along the picture, its seat's distance."""
        name, _, node = end.partition(".")
        body = next(b for b in self.bodies if b.name == name)
        seat = self.bare.get(name, body.seats_m[node] * self.scale)
        return body, self.x(body.nodes_m[node][0]), seat


class _Joint(NamedTuple):
    """A bearing: its place and radii, what lies beyond, its rank there, whether it is rigid."""

    x: float
    inner: float
    outer: float
    beyond: str
    rank: int
    rigid: bool


def materials_of(bodies: Sequence[Silhouette]) -> tuple[str, ...]:
    """Return the names of the materials of all sections, in the order in which they appear."""
    return tuple(dict.fromkeys(name for b in bodies for name in b.materials))


def engine_drawing(
    scene: Scene,
    bodies: Sequence[Silhouette],
    size: tuple[float, float],
    above: Sequence[Named],
    below: Sequence[Named],
) -> Drawing:
    """Return the drawing of an engine, with labels above and below it.

    `size` is its width and the largest height of the bodies.
    """
    width, tallest = size
    low, high, radius = _extent(bodies)
    width = max(width, 2 * _MARGIN + 16.0 * max(len(above), len(below)))
    scale = min((width - 2 * _MARGIN) / (high - low), tallest / max(2 * radius, 1e-9))
    left = 0.5 * (width - (high - low) * scale)
    casing = radius * scale + _BEYOND
    bare = _bare_distances(scene, bodies, scale, casing)
    has_casing = any(b.speed_ratio == 0.0 for b in scene.rigid_bodies.values())
    half = casing + 12.0 if has_casing else radius * scale + 8.0
    half = max(half, _reach_of_grounds(scene, bodies, bare, scale) + 8.0)
    legend = _legend(bodies, width)
    labels = [Label(x=left + (z - low) * scale, words=(w,)) for z, w in above]
    joints = _stacked([(left + (z - low) * scale, w) for z, w in below])
    top = legend[-1][1] * _LEGEND_LINE + 8.0 + label_height(labels, width)
    plan = _Plan(
        bodies=tuple(bodies),
        bare=bare,
        left=left,
        axis=top + half,
        first_m=low,
        scale=scale,
        casing=casing,
        half=half,
        width=width,
    )
    bottom = plan.axis + half
    height = bottom + label_height(joints, width) + _RULER
    shapes = (
        *(shape for shape, _ in legend),
        *label_block(labels, width, top, plan.axis, "up"),
        *label_block(joints, width, bottom, plan.axis + 3.0, "down"),
        *_machine(scene, plan),
        *_rulers(plan, (low, high, radius), height - _RULER + 6.0),
    )
    return Drawing(width=width, height=height, shapes=shapes, bodies=len(bodies))


def _extent(bodies: Sequence[Silhouette]) -> tuple[float, float, float]:
    """First and last z and largest radius of all that is drawn."""
    places = [z for b in bodies for z, _ in b.nodes_m.values()]
    places += [b.center_m[0] for b in bodies] + [d.at_m for b in bodies for d in b.disks]
    radii = [d.radius_m for b in bodies for d in b.disks]
    radii += [abs(h) for b in bodies for _, h in b.nodes_m.values()]
    for b in bodies:
        for area in (*b.areas_m, *(f.area_m for f in b.features)):
            places += [float(area[:, 0].min()), float(area[:, 0].max())]
            radii.append(float(np.abs(area[:, 1]).max()))
    low, high = min(places), max(places)
    radius = max(radii, default=0.0)
    if high - low <= 1e-9 * max(abs(low), abs(high), 1e-9):
        half = max(radius, 0.5)
        return low - half, high + half, radius
    return low, high, radius


def _bare_distances(
    scene: Scene, bodies: Sequence[Silhouette], scale: float, casing: float
) -> dict[str, float]:
    """A casing lies around all, a ring that turns around what it is borne on."""
    by_name = {b.name: b for b in bodies}
    found = {}
    for body in bodies:
        if body.kind != "none":
            continue
        seats = [
            by_name[other.partition(".")[0]].seats_m[other.partition(".")[2]] * scale
            for b in scene.bearings
            for own, other in ((b.first, b.second), (b.second, b.first))
            if own.partition(".")[0] == body.name and other != "ground"
        ]
        around = max(seats) + 2 * _BOX + 2.0 if seats else 3.0
        found[body.name] = casing + 5.0 if body.speed_ratio == 0.0 else around
    return found


def _reach_of_grounds(
    scene: Scene, bodies: Sequence[Silhouette], bare: Mapping[str, float], scale: float
) -> float:
    """Farthest bearing on the ground; those at one place are drawn one outside the other."""
    seats = {f"{b.name}.{node}": seat for b in bodies for node, seat in b.seats_m.items()}
    ends = [end for b in scene.bearings for end in (b.first, b.second)]
    return max(
        (
            bare.get(b.first.partition(".")[0], seats[b.first] * scale)
            + ends.count(b.first) * _STEP
            for b in scene.bearings
            if b.second == "ground"
        ),
        default=0.0,
    )


def engine_caption(scene: Scene, bodies: Sequence[Silhouette]) -> str:
    """Return what the symbols mean, as far as they are there."""
    said = ["Section through the axis, to scale; each body has a hatching."]
    materials = materials_of(bodies)
    if len(materials) > 1:
        said.append("Materials are shaded, see the legend.")
    elif materials:
        said.append(f"All sections are of {materials[0]}.")
    kinds = list(dict.fromkeys(f.kind for b in bodies for f in b.features))
    if kinds:
        named = " and ".join(filter(None, [", ".join(kinds[:-1]), kinds[-1]]))
        said.append(f"Without hatching: {named} from the side, with their number.")
    if any(b.kind == "view" for b in bodies):
        said.append("Bodies from a mesh show their outline seen from the side.")
    if any(b.disks for b in bodies):
        said.append("Bars at the ends of a dotted line: a rigid disk of the radius √(2 Ip/m).")
    if scene.bearings:
        said.append("Crossed box: bearing, dark: rigid; with a hatched foot: on the ground.")
    if scene.gears:
        said.append("Toothed circles: gear.")
    said.append("Circle with dark quarters: centre of gravity. Small rings on the axis: nodes.")
    return " ".join(said)


def node_labels(bodies: Sequence[Silhouette]) -> list[Named]:
    """Return the names of all nodes along the axis."""
    several = len(bodies) > 1
    return sorted(
        (z, f"{b.name}.{name}" if several else name)
        for b in bodies
        for name, (z, _) in b.nodes_m.items()
    )


def joint_labels(scene: Scene, bodies: Sequence[Silhouette]) -> list[Named]:
    """Return names and stiffness of bearings, and names and ratios of gears, along the axis."""
    at = {f"{b.name}.{node}": z for b in bodies for node, (z, _) in b.nodes_m.items()}
    found = [(at[j.first], f"{j.name}: {stiffness_text(j)}") for j in scene.bearings]
    found += [
        (0.5 * (at[g.first] + at[g.second]), f"{g.name}: gear, ratio {g.ratio:g}")
        for g in scene.gears
    ]
    return sorted(found)


def _stacked(found: Sequence[Named]) -> list[Label]:
    """Labels of what is at one place on the picture, one under the other."""
    places: dict[int, list[str]] = {}
    for x, words in found:
        places.setdefault(round(x), []).append(words)
    return [Label(x=float(x), words=tuple(lines)) for x, lines in places.items()]


def stiffness_text(bearing: BearingSpec) -> str:
    """Say in a few words how a bearing holds."""
    said = []
    if bearing.rigid:
        every = set(MOTIONS) <= set(bearing.rigid)
        said.append("rigid" if every else f"rigid {' '.join(bearing.rigid)}")
    matrix = np.array(bearing.stiffness_n_per_m, dtype=float)
    if matrix.any():
        said.append(matrix_text(matrix, "N/m"))
    if bearing.speed_law is not None:
        said.append(f"law {bearing.speed_law}")
    damping = np.array(bearing.damping_n_s_per_m, dtype=float)
    if not said and damping.any():
        said.append(matrix_text(damping, "N s/m"))
    return ", ".join(said) or "no lateral stiffness"


def matrix_text(matrix: FloatArray, unit: str) -> str:
    """Return a matrix [[xx, xy], [yx, yy]] in a few words, with all that is not zero.

    Such as "2e7 N/m", "2e7, 3e7 N/m" or "±1.2e6 N/m cross" for xy = -yx = 1.2e6.
    """
    (x, xy), (yx, y) = matrix
    said = []
    if x or y:
        said.append(f"{_short(x)} {unit}" if x == y else f"{_short(x)}, {_short(y)} {unit}")
    if xy or yx:
        sign = "±" if xy > 0.0 else "∓"
        cross = f"{sign}{_short(abs(xy))}" if xy == -yx else f"{_short(xy)}, {_short(yx)}"
        said.append(f"{cross if xy != yx else _short(xy)} {unit} cross")
    return ", ".join(said)


def _short(value: float) -> str:
    """Three digits, without the plus and zeros of an exponent."""
    return f"{value:.3g}".replace("e+0", "e").replace("e+", "e")


def _machine(scene: Scene, plan: _Plan) -> Iterator[Shape]:
    """Bodies, casings, axis, joints, nodes and centres, from back to front."""
    materials = materials_of(plan.bodies)
    for k, body in enumerate(plan.bodies):
        own = (*_areas(plan, body, k, materials), *_features(plan, body, k))
        shapes = (*own, *_disks(plan, body, k))
        yield Group(title=body.name, shapes=(*shapes, *_bare_body(plan, body, k)))
    yield Line(((plan.left - 14.0, plan.axis), (plan.width - plan.left + 14.0, plan.axis)), _AXIS)
    for joint in _placed_joints(scene, plan):
        yield from _bearing(plan, joint)
    for gear in scene.gears:
        ends = [plan.node(end)[1:] for end in (gear.first, gear.second)]
        yield from _gear([(x, plan.axis - seat) for x, seat in ends])
    for k, body in enumerate(plan.bodies):
        ring = Style(fill="paper", stroke=f"c{k}", width=1.3)
        for z, height in body.nodes_m.values():
            yield Circle(plan.x(z), plan.y(height), 2.6, ring)
    for k, body in enumerate(plan.bodies):
        yield _center(plan, body, k)


def shade(material: str, materials: Sequence[str]) -> Style:
    """Return the look of a material under the hatching: the more to the right, the darker."""
    darkest = 0.3 / max(len(materials) - 1, 1)
    opacity = darkest * materials.index(material) if material in materials else 0.0
    return Style(fill="ink", opacity=opacity)


def _areas(plan: _Plan, body: Silhouette, k: int, materials: Sequence[str]) -> Iterator[Shape]:
    """Areas shaded by material, hatched by body, named on hover; those of a cut twice."""
    look = Style(stroke=f"c{k}", width=1.1, hatch=k)
    for number, area in enumerate(body.areas_m):
        sides = [Polygon(plan.points(side), look) for side in _mirrored(area, body.kind)]
        if not body.labels:
            yield from sides
            continue
        material = body.materials[number]
        for side in sides:
            under = Polygon(side.points, shade(material, materials))
            shown = (under, side) if material in materials[1:] else (side,)
            yield Group(title=body.labels[number], shapes=shown)


def _features(plan: _Plan, body: Silhouette, k: int) -> Iterator[Shape]:
    """Blades, holes, ... without hatching, as the plane does not cut all of them."""
    for found in body.features:
        look = Style(fill="paper", stroke=f"c{k}", width=1.1)
        both = _mirrored(found.area_m, body.kind)
        seen = both if not found.side else [found.area_m * (1.0, found.side)]
        sides = [plan.points(side) for side in seen]
        shapes: list[Shape] = [Polygon(side, look) for side in sides]
        width, height = np.ptp(sides[0], axis=0)
        text = f"{found.count}"
        if width > LETTER * len(text) and height > LINE:
            x, y = 0.5 * (sides[0].min(axis=0) + sides[0].max(axis=0))
            shapes.append(Words(float(x), float(y) + 4.0, text, color=f"c{k}"))
        yield Group(title=f"{body.name}: {found.text}", shapes=shapes)


def _mirrored(area: FloatArray, kind: str) -> list[FloatArray]:
    """An area above the axis and below it; one of four corners that reaches it in one piece."""
    if kind == "view":
        return [area]
    lower = area * (1.0, -1.0)
    if len(area) == 4 and area[0, 1] == area[1, 1] == 0.0:
        return [np.vstack([lower[[3, 2]], area[[2, 3]]])]
    return [area, lower]


def _disks(plan: _Plan, body: Silhouette, k: int) -> Iterator[Shape]:
    """Rigid disks as bars at the ends of a dotted line."""
    for disk in body.disks:
        x, reach = plan.x(disk.at_m), disk.radius_m * plan.scale
        ends = ((x, plan.axis - reach), (x, plan.axis + reach))
        rims = tuple(_box(x, y, 5.0, 3.0, Style(fill=f"c{k}")) for _, y in ends)
        dotted = Line(ends, Style(stroke=f"c{k}", width=1.6, dashes=(2, 3)))
        yield Group(title=f"rigid disk {body.name}: {disk.name}", shapes=(dotted, *rims))


def _box(x: float, y: float, wide: float, high: float, style: Style) -> Polygon:
    """A rectangle about a point, of half sizes."""
    signs = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    return Polygon(np.array([x, y]) + signs * (wide, high), style)


def _bare_body(plan: _Plan, body: Silhouette, k: int) -> Iterator[Shape]:
    """A body of which only its nodes are known: a casing as a bar, another as a line."""
    if body.kind != "none":
        return
    places = [plan.x(z) for z, _ in body.nodes_m.values()] + [plan.x(body.center_m[0])]
    first, last = min(places) - 8.0, max(places) + 8.0
    for side in (-1.0, 1.0):
        y = plan.axis + side * plan.bare[body.name]
        if body.speed_ratio != 0.0:
            yield Line(((first, y), (last, y)), Style(stroke=f"c{k}", width=5.0))
        else:
            look = Style(stroke=f"c{k}", hatch=k)
            yield _box(0.5 * (first + last), y - side * 5.0, 0.5 * (last - first), 5.0, look)


def _placed_joints(scene: Scene, plan: _Plan) -> Iterator[_Joint]:
    ranks: dict[str, int] = {}
    for bearing in scene.bearings:
        body, x, own = plan.node(bearing.first)
        rank = ranks.get(bearing.first, 0)
        ranks[bearing.first] = rank + 1
        rigid = bool(bearing.rigid)
        if bearing.second == "ground":
            yield _Joint(x, own, own, "ground", rank, rigid)
            continue
        ranks[bearing.second] = ranks.get(bearing.second, 0) + 1
        other, _, seat = plan.node(bearing.second)
        inner, outer, beyond = min(own, seat), max(own, seat), "body"
        if any(b.kind == "none" and b.speed_ratio == 0.0 for b in (body, other)):
            beyond = "casing"
        elif "view" in (body.kind, other.kind):  # whose bore is not known
            inner = outer = (own if other.kind == "view" else seat) + _BOX
        yield _Joint(x, inner, outer, beyond, rank, rigid)


def _bearing(plan: _Plan, joint: _Joint) -> Iterator[Shape]:
    """A crossed box on both sides of the axis, filled if it is rigid, and what holds it."""
    for side in (-1.0, 1.0):
        middle = 0.5 * (joint.inner + joint.outer)
        far = joint.beyond == "body" and joint.outer - joint.inner > 4 * _BOX
        if far or joint.beyond != "body":
            middle = joint.inner + _BOX + joint.rank * _STEP * (not far)
        x, y = joint.x, plan.axis + side * middle
        if far:
            yield Line(((x, y), (x, plan.axis + side * joint.outer)), _INK)
        if joint.beyond == "casing" and plan.casing > middle + _BOX:
            yield Line(((x, y + side * _BOX), (x, plan.axis + side * plan.casing)), _INK)
        if joint.beyond == "ground":
            if joint.rank:
                seat = plan.axis + side * joint.inner
                yield Line(((x, seat), (x, y - side * _BOX)), _INK)
            yield from _ground(x, y + side * _BOX, side)
        fill = "ink" if joint.rigid else "paper"
        yield _box(x, y, _BOX, _BOX, Style(fill=fill, stroke="ink", width=1.4))
        for slope in () if joint.rigid else (1.0, -1.0):
            yield Line(((x - _BOX, y - slope * _BOX), (x + _BOX, y + slope * _BOX)), _INK)


def _ground(x: float, y: float, side: float) -> Iterator[Shape]:
    foot = y + side * 4
    yield Line(((x, y), (x, foot)), _INK)
    yield Line(((x - 10, foot), (x + 10, foot)), _INK)
    for k in range(-1, 3):
        start = x + 6 * k - 3
        yield Line(((start, foot), (start - 4, foot + side * 4)), Style(stroke="ink"))


def _gear(seats: Sequence[tuple[float, float]]) -> Iterator[Shape]:
    """A wheel at each seat and a line between them."""
    yield Line(tuple(seats), _TEETH)
    for x, y in seats:
        yield Circle(x, y, _WHEEL, Style(fill="paper", stroke="ink", width=3.0, dashes=(2.2, 2.2)))
        yield Circle(x, y, _WHEEL - 2.5, Style(stroke="ink"))


def _center(plan: _Plan, body: Silhouette, k: int) -> Group:
    """The mark of a centre of gravity: a circle with two dark quarters."""
    x, y, r = plan.x(body.center_m[0]), plan.y(body.center_m[1]), 5.5
    quarters = []
    for first in (0.0, np.pi):
        angle = first + np.linspace(-0.5 * np.pi, 0.0, 7)
        arc = np.column_stack([x + r * np.cos(angle), y + r * np.sin(angle)])
        quarters.append(Polygon(np.vstack([arc, (x, y)]), Style(fill=f"c{k}")))
    ring = Circle(x, y, r, Style(fill="paper", stroke=f"c{k}", width=1.5))
    return Group(title=f"centre of gravity of {body.name}", shapes=(ring, *quarters))


def _legend(bodies: Sequence[Silhouette], width: float) -> list[tuple[Shape, int]]:
    """Swatches with the number of their row: bodies with their speed ratios, and materials."""
    entries = [
        (f"{b.name} (speed × {b.speed_ratio:g})", Style(stroke=f"c{k}", hatch=k))
        for k, b in enumerate(bodies)
    ]
    materials = materials_of(bodies)
    if len(materials) > 1:
        entries += [(m, shade(m, materials)._replace(stroke="muted")) for m in materials]
    found: list[tuple[Shape, int]] = []
    x, row = _MARGIN, 1
    for words, look in entries:
        need = 34.0 + LETTER * len(words) + 18.0
        if x + need > width - _MARGIN and found:
            x, row = _MARGIN, row + 1
        y = 6.0 + _LEGEND_LINE * (row - 1)
        found.append((_box(x + 13.0, y + 6.5, 13.0, 6.5, look), row))
        found.append((Words(x + 33.0, y + 11.0, words, anchor="start"), row))
        x += need
    return found


def _rulers(plan: _Plan, extent: tuple[float, float, float], y: float) -> Iterator[Shape]:
    """Places along the axis below the drawing, and distances from it to the left."""
    low, high, radius = extent
    yield Line(((plan.x(low), y), (plan.x(high), y)), _RULE)
    most = min(_MOST_TICKS, int((high - low) * plan.scale / _TICK_WIDTH))
    for z in ruler_steps(1e3 * low, 1e3 * high, max(1, most)):
        x = plan.x(1e-3 * z)
        yield Line(((x, y), (x, y + 5.0)), _RULE)
        yield Words(x, y + 18.0, f"{z + 0.0:g}", color="muted")
    yield Words(0.5 * (plan.x(low) + plan.x(high)), y + 34.0, "z [mm]", color="muted")
    room, x = radius * plan.scale, plan.left - 20.0
    if room < 16.0:
        return
    yield Line(((x, plan.axis - room), (x, plan.axis + room)), _RULE)
    for r in ruler_steps(0.0, 1e3 * radius, max(1, int(room / 24.0))):
        for at in {plan.y(1e-3 * r), plan.y(-1e-3 * r)}:
            yield Line(((x - 5.0, at), (x, at)), _RULE)
            yield Words(x - 8.0, at + 4.0, f"{r + 0.0:g}", anchor="end", color="muted")
    yield Words(x + 6.0, plan.axis - room - 10.0, "r [mm]", anchor="end", color="muted")
