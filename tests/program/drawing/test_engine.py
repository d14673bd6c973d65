"""The drawing of an engine: what is only known by its nodes has a place of its own."""

from __future__ import annotations

import numpy as np
from engine_runs import beam_scene

from solidwhirl.drawing.bodies import silhouettes_of
from solidwhirl.drawing.engine import engine_drawing, joint_labels, node_labels
from solidwhirl.drawing.shapes import Group, Line, Polygon, Words
from solidwhirl.pipeline.run import run_scene


def _drawn(results):
    bodies = silhouettes_of(results)
    labels = node_labels(bodies), joint_labels(results.scene, bodies)
    return engine_drawing(results.scene, bodies, (800.0, 400.0), *labels)


def _reach(group):
    """Lowest and highest place of the shapes of a body."""
    parts = [p for s in group.shapes for p in (s.shapes if isinstance(s, Group) else [s])]
    y = np.concatenate([np.asarray(p.points)[:, 1] for p in parts])
    return y.min(), y.max()


def test_rings_lie_around_their_shaft_and_casings_around_all(geared):
    scene = beam_scene("turbocharger", analyses=())
    slow = scene.speeds.model_copy(update={"to_rpm": 100.0, "count": 2})
    rings = _drawn(run_scene(scene.model_copy(update={"speeds": slow})))
    groups = {g.title: g for g in rings.shapes if isinstance(g, Group)}
    (low, high), shaft = _reach(groups["turbine_ring"]), _reach(groups["rotor"])
    assert all(isinstance(s, Line) for s in groups["turbine_ring"].shapes)
    axis = 0.5 * (shaft[0] + shaft[1])
    assert axis - low == high - axis and shaft[0] < low < axis
    drawing = _drawn(geared)
    groups = {g.title: g for g in drawing.shapes if isinstance(g, Group)}
    assert all(isinstance(s, Polygon) for s in groups["casing"].shapes)
    shafts = [_reach(groups[name]) for name in ("slow", "fast")]
    low, high = _reach(groups["casing"])
    assert all(low < a and b < high for a, b in shafts)
    # and nothing leaves the picture
    assert high < drawing.height and low > 0.0
    words = [s.text for s in drawing.shapes if isinstance(s, Words)]
    assert "mount: rigid" in words and words.count("z [mm]") == words.count("r [mm]") == 1
