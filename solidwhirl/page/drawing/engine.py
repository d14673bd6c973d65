"""Section: the drawing to scale, with bodies, bearings, gears, nodes and rulers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from solidwhirl.drawing import engine as drawn
from solidwhirl.drawing.bodies import Silhouette, silhouettes_of
from solidwhirl.page.drawing.materials import features_table, sections_table
from solidwhirl.page.drawing.svg import svg_of
from solidwhirl.page.frame.records import Picture, Run, Section, Table
from solidwhirl.scene.records import Scene

_SIZE = (1040.0, 560.0)
# On the first screen of a page: width and height of the bodies, height and least width.
_SMALL, _FIRST_SCREEN, _LEAST = (580.0, 230.0), 360, 480


def section(run: Run) -> Section:
    """Return the drawing of all bodies and what joins them, with tables of its places."""
    scene = run.results.scene
    bodies = silhouettes_of(run.results)
    names = ", ".join(b.name for b in bodies)
    alt = (
        f"Longitudinal section with the bodies {names}, {len(scene.bearings)} bearings and "
        f"{len(scene.gears)} gears; places are in the tables."
    )
    labels = (drawn.node_labels(bodies), drawn.joint_labels(scene, bodies))
    picture = Picture(
        data=svg_of(drawn.engine_drawing(scene, bodies, _SIZE, *labels)),
        caption=drawn.engine_caption(scene, bodies),
        alt=alt,
        scroll_px=900,
    )
    return Section(
        name="engine",
        title="Drawing to scale",
        blocks=(
            picture,
            _places(bodies),
            *sections_table(scene, run.results.geometry),
            *features_table(run.results.geometry),
            *_joints(scene),
        ),
    )


def small_picture(run: Run) -> Picture:
    """Return the drawing for the first screen of a page: as high as there is room for."""
    return small_drawing(run.results.scene, silhouettes_of(run.results))


def small_drawing(scene: Scene, bodies: Sequence[Silhouette]) -> Picture:
    """Return the drawing of the bodies of a scene, with the names of its joints alone."""
    names = [(z, words.partition(":")[0]) for z, words in drawn.joint_labels(scene, bodies)]
    return Picture(
        data=svg_of(drawn.engine_drawing(scene, bodies, _SMALL, (), names)),
        caption="",
        alt="Longitudinal section of all bodies, to scale.",
        scroll_px=_LEAST,
        height_px=_FIRST_SCREEN,
    )


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
        said = drawn.matrix_text(damping, "N s/m") if damping.any() else ""
        rows.append((b.name, b.first, b.second, drawn.stiffness_text(b), said))
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
