"""Section: the drawing to scale, with bodies, bearings, gears, nodes and a ruler."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from solidwhirl.page.drawing_labels import Label, label_block, label_height
from solidwhirl.page.drawing_parts import (
    BEYOND,
    BOX,
    Frame,
    Joint,
    body_parts,
    center_mark,
    color,
    gear_parts,
    joint_parts,
    patterns,
    shade,
)
from solidwhirl.page.materials import sections_table
from solidwhirl.page.records import Picture, Run, Section, Table
from solidwhirl.page.silhouettes import Silhouette, silhouettes_of
from solidwhirl.page.svg import (
    LETTER,
    document,
    line,
    number,
    polyline,
    ruler_steps,
    text,
)
from solidwhirl.page.traces import FloatArray
from solidwhirl.scene import Scene
from solidwhirl.scene_joints import BearingSpec

_WIDTH, _MARGIN, _TALLEST = 1040.0, 40.0, 560.0
_RULER, _LEGEND_LINE = 46.0, 22.0
_MOST_TICKS = 12
# On the first screen of a page: width and height of the bodies, height and least width.
_SMALL, _FIRST_SCREEN, _LEAST = (760.0, 170.0), 290, 560


@dataclass(frozen=True, kw_only=True)
class _Plan:
    """What is drawn and where: bodies, frame, distance of the casing, height of the half."""

    bodies: tuple[Silhouette, ...]
    frame: Frame
    casing: float
    half: float
    width: float

    def body(self, name: str) -> Silhouette:
        return next(b for b in self.bodies if b.name == name)


def section(run: Run) -> Section:
    """Drawing of all bodies and what joins them.

    Parameters
    ----------
    run
        The run.
    """
    scene = run.results.scene
    bodies = silhouettes_of(run.results)
    names = ", ".join(b.name for b in bodies)
    alt = (
        f"Longitudinal section with the bodies {names}, {len(scene.bearings)} bearings and "
        f"{len(scene.gears)} gears; places are in the tables."
    )
    picture = Picture(data=drawing_svg(scene, bodies), caption=_caption(bodies, scene), alt=alt,
                       scroll_px=900)  # fmt: skip
    return Section(
        name="engine",
        title="Drawing to scale",
        blocks=(picture, _places(bodies), *sections_table(scene), *_joints(scene)),
    )


def small_picture(run: Run) -> Picture:
    """Return the drawing for the first screen of a page: as high as there is room for.

    Parameters
    ----------
    run
        The run.
    """
    scene, bodies = run.results.scene, silhouettes_of(run.results)
    names = [(z, words.partition(":")[0]) for z, words in _joint_labels(scene, bodies)]
    return Picture(
        data=_drawing(scene, bodies, ((), names), _SMALL),
        caption="",
        alt="Longitudinal section of all bodies, to scale.",
        scroll_px=_LEAST,
        height_px=_FIRST_SCREEN,
    )


def _caption(bodies: Sequence[Silhouette], scene: Scene) -> str:
    """What the symbols mean, as far as they are there."""
    said = ["Section through the axis, alike scaled in both directions; each body has a hatching."]
    materials = materials_of(bodies)
    if len(materials) > 1:
        said.append("Materials are shaded, see the legend.")
    elif materials:
        said.append(f"All sections are of {materials[0]}.")
    if any(b.kind == "view" for b in bodies):
        said.append("Bodies from a mesh show their outline seen from the side.")
    if any(b.disks for b in bodies):
        said.append("Bars at the ends of a dotted line: a rigid disk, at its radius of gyration.")
    if scene.bearings:
        said.append("Crossed box: bearing; with a hatched foot: on the ground.")
    if scene.gears:
        said.append("Toothed circles: gear.")
    said.append("Circle with dark quarters: centre of gravity. Small rings on the axis: nodes.")
    return " ".join(said)


def materials_of(bodies: Sequence[Silhouette]) -> tuple[str, ...]:
    """Return the names of the materials of all sections, in the order in which they appear.

    Parameters
    ----------
    bodies
        From `silhouettes_of`.
    """
    return tuple(dict.fromkeys(name for b in bodies for name in b.materials))


def drawing_svg(scene: Scene, bodies: Sequence[Silhouette]) -> str:
    """Return the drawing of an engine as SVG.

    Parameters
    ----------
    scene
        For bearings and gears.
    bodies
        From `silhouettes_of`.
    """
    return _drawing(
        scene, bodies, (_node_labels(bodies), _joint_labels(scene, bodies)), (_WIDTH, _TALLEST)
    )


def _drawing(
    scene: Scene,
    bodies: Sequence[Silhouette],
    labels_at: tuple[Sequence[tuple[float, str]], Sequence[tuple[float, str]]],
    size: tuple[float, float],
) -> str:
    """The drawing with labels above and below it; its width and the largest height of bodies."""
    width, tallest = size
    above, below = labels_at
    low, high, radius = _extent(bodies)
    width = max(width, 2 * _MARGIN + 16.0 * max(len(above), len(below)))
    scale = min((width - 2 * _MARGIN) / (high - low), tallest / max(2 * radius, 1e-9))
    left = 0.5 * (width - (high - low) * scale)
    grounds = _most_grounds(scene)
    casing = radius * scale + BEYOND
    half = casing + 12.0 if _has_casing(scene) else radius * scale + 8.0
    half += grounds * (2 * BOX + 10) + (8.0 if grounds else 0.0)
    legend = _legend(bodies, width)
    labels = tuple(Label(x=left + (z - low) * scale, words=(w,)) for z, w in above)
    joints = tuple(_stacked([(left + (z - low) * scale, w) for z, w in below]))
    top = len(legend) * _LEGEND_LINE + 8.0 + label_height(labels, width)
    frame = Frame(left=left, axis=top + half, first_m=low, scale=scale)
    plan = _Plan(bodies=tuple(bodies), frame=frame, casing=casing, half=half, width=width)
    bottom = frame.axis + half
    height = bottom + label_height(joints, width) + _RULER
    parts = [
        *patterns(len(bodies)),
        *(part for row in legend for part in row),
        *label_block(labels, width, base=top, target=frame.axis, upwards=True),
        *label_block(joints, width, base=bottom, target=frame.axis + 3.0, upwards=False),
        *_machine(scene, plan),
        *_ruler(plan, low, high, height - _RULER + 6.0),
    ]
    return document(width, height, parts, "drawing to scale")


def _extent(bodies: Sequence[Silhouette]) -> tuple[float, float, float]:
    """First and last z and largest radius of all that is drawn."""
    places = [z for b in bodies for z, _ in b.nodes_m.values()]
    places += [b.center_m[0] for b in bodies] + [d.at_m for b in bodies for d in b.disks]
    radii = [d.gyration_m for b in bodies for d in b.disks]
    radii += [abs(h) for b in bodies for _, h in b.nodes_m.values()]
    for b in bodies:
        for area in b.areas_m:
            places += [float(area[:, 0].min()), float(area[:, 0].max())]
            radii.append(float(np.abs(area[:, 1]).max()))
    low, high = min(places), max(places)
    radius = max(radii, default=0.0)
    if high - low <= 1e-9 * max(abs(low), abs(high), 1e-9):
        half = max(radius, 0.5)
        return low - half, high + half, radius
    return low, high, radius


def _has_casing(scene: Scene) -> bool:
    return any(b.speed_ratio == 0.0 for b in scene.rigid_bodies.values())


def _most_grounds(scene: Scene) -> int:
    """Most bearings on the ground at one place, which are drawn one outside the other."""
    grounded = [b.first for b in scene.bearings if b.second == "ground"]
    ends = [end for b in scene.bearings for end in (b.first, b.second)]
    return max((ends.count(end) for end in grounded), default=0)


def _node_labels(bodies: Sequence[Silhouette]) -> list[tuple[float, str]]:
    several = len(bodies) > 1
    found = [
        (z, f"{b.name}.{name}" if several else name)
        for b in bodies
        for name, (z, _) in b.nodes_m.items()
    ]
    return sorted(found)


def _stacked(found: Sequence[tuple[float, str]]) -> Iterator[Label]:
    """Labels of what is at one place on the picture, one under the other."""
    places: dict[int, list[str]] = {}
    for x, words in found:
        places.setdefault(round(x), []).append(words)
    for x, lines in places.items():
        yield Label(x=float(x), words=tuple(lines))


def _joint_labels(scene: Scene, bodies: Sequence[Silhouette]) -> list[tuple[float, str]]:
    by_name = {b.name: b for b in bodies}
    found = []
    for joint in scene.bearings:
        body, _, node = joint.first.partition(".")
        found.append((by_name[body].nodes_m[node][0], f"{joint.name}: {stiffness_text(joint)}"))
    for gear in scene.gears:
        places = []
        for end in (gear.first, gear.second):
            body, _, node = end.partition(".")
            places.append(by_name[body].nodes_m[node][0])
        found.append((sum(places) / 2, f"{gear.name}: gear, ratio {gear.ratio:g}"))
    return sorted(found)


def stiffness_text(bearing: BearingSpec) -> str:
    """Say in a few words how a bearing holds.

    Parameters
    ----------
    bearing
        The bearing.
    """
    said = []
    if bearing.rigid:
        every = {"ux", "uy", "uz", "rx", "ry", "rz"} <= set(bearing.rigid)
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
    """Return a 2 x 2 matrix of coefficients in a few words, with all that is not zero.

    Parameters
    ----------
    matrix
        [[xx, xy], [yx, yy]], not all zero.
    unit
        Of its entries.

    Returns
    -------
    str
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


def _machine(scene: Scene, plan: _Plan) -> Iterator[str]:
    """Bodies, casings, axis, joints, nodes and centres, from back to front."""
    frame, materials = plan.frame, materials_of(plan.bodies)
    for k, body in enumerate(plan.bodies):
        yield f"<g><title>{body.name}</title>"
        yield from body_parts(frame, body, k, materials)
        if body.kind == "none":
            yield from _bare_body(plan, body, k)
        yield "</g>"
    ends = (plan.width - frame.left + 14.0, frame.axis)
    yield line(frame.left - 14.0, frame.axis, *ends,
               'stroke="var(--muted)" stroke-dasharray="14 4 2 4"')  # fmt: skip
    for joint in _placed_joints(scene, plan):
        yield from joint_parts(frame, joint, plan.casing)
    for gear in scene.gears:
        yield from gear_parts(*(_seat(plan, end) for end in (gear.first, gear.second)))
    for k, body in enumerate(plan.bodies):
        for z, height in body.nodes_m.values():
            x, y = number(frame.x(z)), number(frame.y(height))
            yield (
                f'<circle cx="{x}" cy="{y}" r="2.6" fill="var(--paper)" stroke="{color(k)}" '
                'stroke-width="1.3"/>'
            )
    for k, body in enumerate(plan.bodies):
        yield center_mark(frame, body, k)


def _bare_body(plan: _Plan, body: Silhouette, index: int) -> Iterator[str]:
    """A body of which only its nodes are known: a casing as a bar, another as a line."""
    frame = plan.frame
    places = [frame.x(z) for z, _ in body.nodes_m.values()] + [frame.x(body.center_m[0])]
    first, last = min(places) - 8.0, max(places) + 8.0
    if body.speed_ratio == 0.0:
        for y in (frame.axis - plan.casing, frame.axis + plan.casing):
            look = f'fill="url(#drawing-hatch-{index})" stroke="{color(index)}"'
            box = f'x="{number(first)}" y="{number(y - 5)}" width="{number(last - first)}"'
            yield f'<rect {box} height="10" {look}/>'
    else:
        look = f'stroke="{color(index)}" stroke-width="5" stroke-linecap="round"'
        yield polyline([(first, frame.axis), (last, frame.axis)], look)


def _placed_joints(scene: Scene, plan: _Plan) -> Iterator[Joint]:
    ranks: dict[str, int] = {}
    for bearing in scene.bearings:
        name, _, node = bearing.first.partition(".")
        body = plan.body(name)
        x = plan.frame.x(body.nodes_m[node][0])
        own = _radius(plan, body, node)
        rank = ranks.get(bearing.first, 0)
        ranks[bearing.first] = rank + 1
        if bearing.second == "ground":
            yield Joint(x, own, own, "ground", rank)
            continue
        ranks[bearing.second] = ranks.get(bearing.second, 0) + 1
        other_name, _, other_node = bearing.second.partition(".")
        other = plan.body(other_name)
        radius = _radius(plan, other, other_node)
        if "none" in (body.kind, other.kind):
            yield Joint(x, min(own, radius), max(own, radius), "casing", rank)
        elif "view" in (body.kind, other.kind):  # whose bore is not known
            seat = (own if other.kind == "view" else radius) + BOX
            yield Joint(x, seat, seat, "body", rank)
        else:
            yield Joint(x, min(own, radius), max(own, radius), "body", rank)


def _radius(plan: _Plan, body: Silhouette, node: str) -> float:
    """Distance from the axis, on the picture, of what is fixed to a node."""
    if body.kind == "none":
        return plan.casing + 5.0 if body.speed_ratio == 0.0 else 3.0
    return body.seats_m[node] * plan.frame.scale


def _seat(plan: _Plan, end: str) -> tuple[float, float]:
    name, _, node = end.partition(".")
    body = plan.body(name)
    return plan.frame.x(body.nodes_m[node][0]), plan.frame.axis - _radius(plan, body, node)


def _legend(bodies: Sequence[Silhouette], width: float) -> list[list[str]]:
    """Rows of swatches: bodies with their speed ratios, and materials where there are several."""
    rows: list[list[str]] = [[]]
    x = _MARGIN
    entries = [
        (
            f"{body.name} (speed × {body.speed_ratio:g})",
            f'fill="url(#drawing-hatch-{k})" stroke="{color(k)}"',
        )
        for k, body in enumerate(bodies)
    ]
    materials = materials_of(bodies)
    if len(materials) > 1:
        entries += [(m, f'{shade(m, materials)} stroke="var(--muted)"') for m in materials]
    for words, look in entries:
        need = 34.0 + LETTER * len(words) + 18.0
        if x + need > width - _MARGIN and rows[-1]:
            rows.append([])
            x = _MARGIN
        y = 6.0 + _LEGEND_LINE * (len(rows) - 1)
        swatch = f'<rect x="{number(x)}" y="{number(y)}" width="26" height="13" {look}/>'
        rows[-1] += [swatch, text(x + 33.0, y + 11.0, words, anchor="start")]
        x += need
    return rows


def _ruler(plan: _Plan, low: float, high: float, y: float) -> Iterator[str]:
    look = 'stroke="var(--muted)"'
    frame = plan.frame
    yield line(frame.x(low), y, frame.x(high), y, look)
    for z in ruler_steps(1e3 * low, 1e3 * high, _MOST_TICKS):
        x = frame.x(1e-3 * z)
        yield line(x, y, x, y + 5.0, look)
        yield text(x, y + 18.0, f"{z + 0.0:g}", more='fill="var(--muted)"')
    yield text(0.5 * (frame.x(low) + frame.x(high)), y + 34.0, "z [mm]",
               more='fill="var(--muted)"')  # fmt: skip


def _places(bodies: Sequence[Silhouette]) -> Table:
    rows = [
        (f"{b.name}.{name}", 1e3 * z, 1e3 * b.seats_m[name] if b.kind != "none" else None)
        for b in bodies
        for name, (z, _) in b.nodes_m.items()
    ]
    return Table(
        folded=f"Nodes ({len(rows)})",
        head=("node", "z [mm]", "radius of the seat [mm]"),
        rows=rows,
    )


def _joints(scene: Scene) -> Iterator[Table]:
    rows: list[tuple[str, str, str, str, str]] = []
    for b in scene.bearings:
        damping = np.array(b.damping_n_s_per_m, dtype=float)
        said = matrix_text(damping, "N s/m") if damping.any() else ""
        rows.append((b.name, b.first, b.second, stiffness_text(b), said))
    for g in scene.gears:
        teeth = g.mesh_stiffness_n_per_m
        held = "rigid teeth" if teeth is None else f"teeth {teeth:.3g} N/m"
        rows.append((g.name, g.first, g.second, f"gear, ratio {g.ratio:g}, {held}", ""))
    if rows:
        yield Table(
            folded=f"Bearings and gears ({len(rows)})",
            head=("name", "first", "second", "stiffness", "damping"),
            rows=rows,
        )
