"""Joints and laws of scenes that can not be, or not be meant, and what is said of them."""

from __future__ import annotations

import numpy as np
import pytest
from engine_parts import RIGID

from solidwhirl.pipeline.run import run_scene
from solidwhirl.plausibility.units import implausible
from solidwhirl.scene_reading.reader import SceneError, parse_scene


def held(name, **options):
    return [{"name": f"{name}_{end}", "first": f"{name}.{end}", **options} for end in "ab"]


def _scene(ratio=1.0, bearing=None, **tables):
    bearing = {"stiffness_n_per_m": 1e6} if bearing is None else bearing
    body = RIGID | {"speed_ratio": ratio}
    data = {
        "name": "joints",
        "rigid_bodies": {"R": body},
        "bearings": held("R", **bearing),
        "speeds": {"from_rpm": 0.0, "to_rpm": 9000.0, "count": 7},
    }
    return data | tables


def _with_second(ratio, **tie):
    data = _scene()
    data["rigid_bodies"]["S"] = RIGID | {"speed_ratio": ratio}
    data["bearings"] += held("S", stiffness_n_per_m=1e6)
    data["bearings"].append({"name": "tie", "first": "R.a", "second": "S.a", **tie})
    return data


@pytest.mark.parametrize("ratio", [-1.0, 2.0, 0.0])
@pytest.mark.parametrize("tie", [{"rigid": ["rz"]}, {"torsion_stiffness_n_m_per_rad": 1e4}])
def test_joints_that_would_wind_up(ratio, tie):
    key = next(iter(tie))
    text = rf"bearings\[4\].{key}: 'tie' ties rz of 'R', speed_ratio 1, to 'S', {ratio:g}, and"
    with pytest.raises(SceneError, match=text):
        parse_scene(_with_second(ratio, **tie))
    parse_scene(_with_second(1.0, **tie))


@pytest.mark.parametrize(
    ("key", "value"), [("mass_kg", 1e-300), ("inertia_kg_m2", [1e-300, 1e-300, 1.5e-300])]
)
def test_numbers_that_underflow(key, value):
    data = _scene()
    data["rigid_bodies"]["R"][key] = value
    with pytest.raises(SceneError, match=rf"R.{key}.*is too small; allowed is 1e-30 and more"):
        parse_scene(data)


def test_speeds_that_can_not_be_meant():
    law = {
        "kind": "table",
        "speed_rpm": [0.0, 1e-14, 100.0],
        "stiffness_n_per_m": [1e6] * 3,
        "damping_n_s_per_m": [0.0] * 3,
    }
    with pytest.raises(SceneError, match="speed_rpm has 0 and 1e-14, which are one speed beside"):
        parse_scene(_scene(bearing={"speed_law": "t"}, speed_laws={"t": law}))
    # nor speeds that no rotor has
    assert implausible(parse_scene(_scene()), {}) == ()
    (doubt,) = implausible(parse_scene(_scene(speeds={"to_rpm": 1e12, "count": 3})), {})
    assert doubt.found == "'R' at up to 1e+12 rpm"


def _film_scene(ratio, **options):
    film = [[2e6, 9e5], [-9e5, 1.5e6]]
    law = {
        "kind": "table",
        "speed_rpm": [0.0, 9000.0],
        "stiffness_n_per_m": [[2e6, 1.5e6], film],
        "damping_n_s_per_m": [600.0, 600.0],
    }
    analyses = [{"kind": "stability", "to_rpm": 9000.0, "count": 31}]
    bearing = {"speed_law": "film", **options}
    return parse_scene(_scene(ratio, bearing, speed_laws={"film": law}, analyses=analyses))


def test_a_film_turns_with_its_shaft():
    thresholds, notes = [], []
    for ratio, options in ((1.0, {}), (-1.0, {}), (-1.0, {"cross_coupling": "as_given"})):
        run = run_scene(_film_scene(ratio, **options))
        thresholds.append(run.analyses["stability"].document["threshold"]["speed_rpm"])
        notes.append([note.kind for note in run.bearing_notes])
    assert thresholds[1] == pytest.approx(thresholds[0], rel=1e-9)
    assert notes == [[], ["mirrored"] * 2, ["not mirrored"] * 2]
    assert np.isfinite(thresholds).all()
