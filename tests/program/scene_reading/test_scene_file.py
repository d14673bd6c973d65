"""A wrong scene file ends in one message with file, key, finding and what is allowed."""

from __future__ import annotations

import pickle
import re
import tomllib
from pathlib import Path

import pytest

from solidwhirl.core.errors import SceneError
from solidwhirl.scene_reading.reader import parse_scene, read_scene, scene_hash

WRONG = tomllib.loads(Path(__file__).with_name("wrong.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("case", WRONG)
def test_wrong_entry_is_refused_at_its_place_before_meshing(
    invoke, ferraris, case, changed, refusal
):
    wrong = WRONG[case]
    text = changed(ferraris, wrong["old"], wrong["new"])
    done, written = invoke(text)
    message = refusal(done, "bad.toml")
    place = re.search(r"bad\.toml:(\d+):(\d+): ", message.splitlines()[0])
    begin = text.split("\n")[int(place[1]) - 1][int(place[2]) - 1 :]
    assert begin.startswith(wrong["at"]), begin
    for text in wrong["said"]:
        assert text in message, (text, message)
    assert "mesh " not in message, "found out only while meshing"
    assert not written


def test_all_problems_at_once(invoke, ferraris, changed, refusal):
    text = changed(ferraris, '"inner.A"', '"A"')
    text = changed(text, '"inner.B"', '"inner.X"')
    text = changed(text, '"outer.D"', '"outr.D"')
    done, _ = invoke(text)
    first, *below = lines = refusal(done, "bad.toml").strip().splitlines()
    assert first.startswith("error: ") and all(re.match(r" {7}\S*bad\.toml:", b) for b in below)
    keys = [re.search(r"bad\.toml:\d+:\d+: (\S+):", line).group(1) for line in lines]
    assert keys == ["bearings[0].first", "bearings[1].first", "bearings[4].first"]
    assert "did you mean 'outer.D'?" in lines[2]
    text = changed(changed(ferraris, "count = 21", "count = 0"), "[model]", "[model]\norder = 9")
    lines = refusal(invoke(text)[0], "bad.toml").strip().splitlines()
    keys = [re.search(r"bad\.toml:\d+:\d+: (\S+):", line).group(1) for line in lines]
    assert keys == ["speeds.count", "model.order"]


def test_bearing_without_any_interface_to_hold(small_scene):
    data = small_scene()
    data["bodies"]["rotor"]["interfaces"] = []
    with pytest.raises(SceneError, match=r"bearings\[0\].first.*no body has an interface"):
        parse_scene(data)


@pytest.mark.parametrize(
    "bearing",
    [
        {"stiffness_n_per_m": [[1e7, 1e5], [-1e5, 1e7]], "rigid": ["ux"]},  # row and column
        {"stiffness_n_per_m": [[0.0, 1e5], [0.0, 1e7]], "rigid": ["ux"]},  # row only
        {"stiffness_n_per_m": [[0.0, 0.0], [1e5, 1e7]], "rigid": ["ux"]},  # column only
        {"stiffness_n_per_m": 0.0, "damping_n_s_per_m": 10.0, "rigid": ["uy"]},
        {"axial_stiffness_n_per_m": 1.0, "rigid": ["uz"]},
        {"tilt_damping_n_m_s_per_rad": [0.0, 1.0], "rigid": ["ry"]},
        {"torsion_stiffness_n_m_per_rad": 1.0, "rigid": ["rz"]},
    ],
)
def test_rigid_motion_that_a_spring_acts_on(small_scene, bearing):
    with pytest.raises(SceneError, match=rf"bearings\[0\].rigid: {bearing['rigid'][0]} is rigid"):
        parse_scene(small_scene(bearing=bearing))


@pytest.mark.parametrize(
    "bearing",
    [
        {"stiffness_n_per_m": [0.0, 1e7], "rigid": ["ux"]},
        {"tilt_stiffness_n_m_per_rad": [0.0, 1e3], "rigid": ["rx", "uz", "rz"]},
    ],
)
def test_rigid_motion_beside_the_springs(small_scene, bearing):
    assert parse_scene(small_scene(bearing=bearing)).bearings[0].rigid == tuple(bearing["rigid"])


def test_readable_forms_of_the_same(small_scene):
    """One number for both ends and for k·I, a pair for a diagonal, true for on."""
    short = small_scene(effects={"tilt": True, "torsion": False})
    long = small_scene(effects={"tilt": "on", "torsion": "off"})
    for section in long["bodies"]["rotor"]["sections"]:
        section["outer_radius_m"] = [section["outer_radius_m"]] * 2
    long["bearings"][0]["stiffness_n_per_m"] = [10_000_000, 1e7]
    long["bearings"][1]["stiffness_n_per_m"] = [[1e7, 0], [0, 1e7]]
    assert parse_scene(short) == parse_scene(long)
    assert scene_hash(parse_scene(short)) == scene_hash(parse_scene(long))
    other = small_scene(bearing={"stiffness_n_per_m": 1.000001e7})
    assert scene_hash(parse_scene(other)) != scene_hash(parse_scene(short))


def test_path_is_part_of_the_error(tmp_path):
    path = tmp_path / "x.toml"
    path.write_text("colour = 1", encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        read_scene(path)
    assert caught.value.path == str(path)
    assert len(caught.value.problems) == 2  # name is missing, colour is unknown
    assert str(caught.value).count(str(path)) == 2
    assert [problem.path for problem in caught.value.problems] == [("name",), ("colour",)]
    other = pickle.loads(pickle.dumps(caught.value))  # as a pool of processes hands it back
    assert str(other) == str(caught.value)
    assert [problem.path for problem in other.problems] == [("name",), ("colour",)]
