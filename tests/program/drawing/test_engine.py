"""The drawing of an engine: what is only known by its nodes has a place of its own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from engine_runs import beam_scene

from solidwhirl.drawing.bodies import Silhouette, profile_features, profile_parts, silhouettes_of
from solidwhirl.drawing.engine import (
    engine_caption,
    engine_drawing,
    joint_labels,
    node_labels,
)
from solidwhirl.drawing.shapes import Group, Line, Polygon, Words
from solidwhirl.model.bodies import build_bodies
from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import parse_scene, read_scene

SCENES = Path(__file__).resolve().parents[3] / "scenes"


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
    few = scene.campbell.model_copy(update={"branches": 2})
    rings = _drawn(run_scene(scene.model_copy(update={"speeds": slow, "campbell": few})))
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


def test_blades_are_drawn_with_their_number():
    scene = read_scene(SCENES / "drum_stages.toml")
    (profile,) = build_bodies(scene).values()
    parts = profile_parts(profile)
    body = Silhouette(
        name="drum",
        kind="cut",
        areas_m=tuple(p.corners_m for p in parts),
        nodes_m={i.name: (i.start_m, 0.0) for i in profile.interfaces},
        seats_m={i.name: 0.03 for i in profile.interfaces},
        disks=(),
        center_m=(0.2, 0.0),
        speed_ratio=1.0,
        features=profile_features(profile),
    )
    drawing = engine_drawing(scene, [body], (1040.0, 560.0), (), ())
    drum = next(s for s in drawing.shapes if isinstance(s, Group) and s.title == "drum")
    rows = {s.title: s.shapes for s in drum.shapes if isinstance(s, Group)}
    assert list(rows) == [
        f"drum: row_{k}, {n} blades, titanium" for k, n in enumerate((24, 31, 37), start=1)
    ]
    for number, shapes in zip(("24", "31", "37"), rows.values(), strict=True):
        assert [s.text for s in shapes if isinstance(s, Words)] == [number]
        assert sum(isinstance(s, Polygon) for s in shapes) == 2
    # tips at 0.18 m are the highest that is drawn, on both sides of the axis
    heights = np.concatenate([s.points[:, 1] for s in rows["drum: row_1, 24 blades, titanium"][:2]])
    scale = np.ptp(heights) / (2 * 0.18)
    assert heights.min() > 0.0 and heights.max() < drawing.height
    (first, _) = (s.points for s in rows["drum: row_3, 37 blades, titanium"][:2])
    # rounding of a difference of heights some hundred units large
    np.testing.assert_allclose(np.ptp(first[:, 1]) / scale, 0.042, rtol=1e-12)
    assert "hatching: blades from the side" in engine_caption(scene, [body])


def test_what_stands_in_one_place_is_drawn_on_its_side(small_scene):
    """A keyway below the axis, flats on both sides of it."""
    shaft = {"name": "shaft", "start_m": 0.0, "end_m": 0.4, "outer_radius_m": 0.02}
    key = {"name": "key", "in": "shaft", "width_m": 0.006, "depth_m": 0.004, "angle_deg": 180.0}
    flats = {"name": "wrench", "in": "shaft", "count": 2, "distance_m": 0.018}
    rotor = {
        "sections": [shaft],
        "interfaces": [],
        "keyways": [{**key, "start_m": 0.1, "end_m": 0.2}],
        "flats": [{**flats, "start_m": 0.3, "end_m": 0.35}],
    }
    data = small_scene(body=rotor)
    data["bearings"] = []
    scene = parse_scene(data)
    profile = build_bodies(scene)["rotor"]
    body = Silhouette(
        name="rotor",
        kind="cut",
        areas_m=tuple(p.corners_m for p in profile_parts(profile)),
        nodes_m={},
        seats_m={},
        disks=(),
        center_m=(0.2, 0.0),
        speed_ratio=1.0,
        features=profile_features(profile),
    )
    drawing = engine_drawing(scene, [body], (1040.0, 560.0), (), ())
    group = next(s for s in drawing.shapes if isinstance(s, Group) and s.title == "rotor")
    sides = {
        s.title: [p.points[:, 1].mean() for p in s.shapes if isinstance(p, Polygon)]
        for s in group.shapes
        if isinstance(s, Group)
    }
    (below,), flat = sides["rotor: key, 1 keyways, steel"], sides["rotor: wrench, 2 flats, steel"]
    # heights count downwards
    assert len(flat) == 2 and below > np.mean(flat)
    assert "keyways and flats from the side" in engine_caption(scene, [body])
