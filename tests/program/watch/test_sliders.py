"""Sliders of a scene: which numbers, their ranges, and the scene at other positions."""

from __future__ import annotations

import tomllib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from watched_scene import SCENE

from solidwhirl.core.errors import SceneError
from solidwhirl.scene_reading.reader import parse_scene
from solidwhirl.watch.sliders import controls_of, scene_at

DATA = tomllib.loads(SCENE)


def _named(data=DATA):
    return {s.name: s for s in controls_of(data).sliders}


def _with_bearing(**keys):
    return {**DATA, "bearings": [{**DATA["bearings"][0], **keys}, *DATA["bearings"][1:]]}


def test_every_number_of_supports_and_speeds_has_a_slider():
    found = _named()
    assert [(s.group, s.label, s.unit, s.value) for s in found.values()] == [
        ("Bearing a", "stiffness xx", "N/m", 1e7),
        ("Bearing a", "stiffness yy", "N/m", 2e7),
        ("Bearing a", "damping", "N·s/m", 500.0),
        ("Bearing b", "stiffness", "N/m", 1e7),
        ("Operating speed of rotor", "from", "rpm", 9000.0),
        ("Operating speed of rotor", "to", "rpm", 9500.0),
    ]
    stiff = found["bearings.0.stiffness_n_per_m.0"]
    assert stiff.is_log and (stiff.low, stiff.high) == pytest.approx((1e5, 1e9))
    speed = found["operating.0.from_rpm"]
    assert not speed.is_log and 0.0 < speed.low < speed.value < speed.high


def test_numbers_that_are_zero_or_negative_have_linear_sliders():
    data = _with_bearing(stiffness_n_per_m=[[1e7, -3e6], [0.0, 0.0]], axial_damping_n_s_per_m=0.0)
    found = _named(data)
    ranges = {k: (s.low, s.high) for k, s in found.items() if not s.is_log and "bear" in k}
    key = "bearings.0.stiffness_n_per_m"
    assert ranges == {
        f"{key}.0.1": (-6e6, 6e6),
        f"{key}.1.0": (-1e7, 1e7),  # as large as others of its key
        f"{key}.1.1": (0.0, 1e7),  # on the diagonal
        "bearings.0.axial_damping_n_s_per_m": (0.0, 1e4),
    }


def test_tables_and_rigid_motions_are_told_as_text():
    law = {"kind": "table", "speed_rpm": [0, 100], "stiffness_n_per_m": [1e7, 2e7]}
    data = _with_bearing(speed_law="oil", rigid=["uz"], tilt_stiffness_n_m_per_rad=1e3)
    controls = controls_of({**data, "speed_laws": {"oil": law}})
    assert [s.label for s in controls.sliders if s.group == "Bearing a"] == ["tilt stiffness"]
    assert controls.fixed == (
        ("Bearing a", "stiffness and damping by the table oil over the speed"),
        ("Bearing a", "rigid: uz"),
    )
    from_file = {"oil": {"kind": "file", "file": "oil.csv"}}
    assert controls_of({**data, "speed_laws": from_file}).fixed == controls.fixed
    data = {**data, "speed_laws": {"oil": {"kind": "preset", "preset": "lee_isotropic"}}}
    assert ("Bearing a", "times the law oil over the speed") in controls_of(data).fixed
    assert "bearings.0.stiffness_n_per_m.0" in _named(data)


def test_a_single_operating_speed_is_one_slider():
    operating = [{"shaft": "rotor", "from_rpm": 9000, "to_rpm": 9000}]
    controls = controls_of({**DATA, "operating": operating})
    slider = controls.sliders[-1]
    assert (slider.label, len(slider.paths)) == ("speed", 2)
    moved = controls.moved({slider.name: 8000.0})
    assert moved == {("operating", 0, "from_rpm"): 8000.0, ("operating", 0, "to_rpm"): 8000.0}


@settings(deadline=None)
@given(st.data())
def test_the_scene_at_positions_is_that_of_a_file_with_these_numbers(data):
    controls = controls_of(DATA)
    chosen = data.draw(st.sets(st.sampled_from(controls.sliders)))
    positions = {
        s.name: data.draw(st.floats(s.low, s.high)) for s in chosen if "operating" not in s.name
    }
    numbers = controls.moved(positions)
    assert {k: v for k, v in positions.items() if v != _named()[k].value} == {
        ".".join(map(str, path)): value for path, value in numbers.items()
    }
    scene = scene_at(parse_scene(DATA), DATA, numbers)
    text = SCENE
    for key in ("stiffness_n_per_m = [1e7,   2e7]", "damping_n_s_per_m = 500.0"):
        text = text.replace(key, "")
    changed = tomllib.loads(text)
    for bearing, source in zip(changed["bearings"], DATA["bearings"], strict=True):
        bearing.update(source)
    for path, value in numbers.items():
        bearing = changed["bearings"][path[1]]
        if len(path) == 3:
            bearing[path[2]] = value
        else:
            bearing[path[2]] = [
                value if k == path[3] else v for k, v in enumerate(bearing[path[2]])
            ]
    assert scene == parse_scene(changed)


def test_numbers_that_can_not_be_are_refused():
    scene = parse_scene(DATA)
    with pytest.raises(SceneError, match=r"operating\[0\].*to_rpm = 9500 is below from_rpm"):
        scene_at(scene, DATA, {("operating", 0, "from_rpm"): 9600.0})
    with pytest.raises(SceneError, match=r"bearings\[1\].stiffness_n_per_m"):
        scene_at(scene, DATA, {("bearings", 1, "stiffness_n_per_m"): 1e40})
