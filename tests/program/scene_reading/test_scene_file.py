"""A wrong scene file ends in one message with file, key, finding and what is allowed."""

from __future__ import annotations

import pickle
import re
import tomllib
from pathlib import Path

import pytest

from solidwhirl.core.errors import SceneError
from solidwhirl.scene_reading.reader import parse_scene, parse_toml, read_scene, scene_hash

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


@pytest.mark.parametrize(
    ("text", "place", "said"),
    [
        ("x = [1 2]", "1:7", "is a comma missing after 1?"),
        ("x = [\n  1.5, # one\n  2 # two\n  # more\n  3,\n]", "3:4", "is a comma missing after 2?"),
        ("x = [{ a = 1 }\n\n { b = 2 }]", "1:15", "is a comma missing after }?"),
        ('x = { a = "t" b = 2 }', "1:14", 'is a comma missing after "t"?'),
        ("x = { a = [1, 2 3] }", "1:16", "is a comma missing after 2?"),
        ("x = [[1, 2]\n[3, 4]]", "1:12", "is a comma missing after ]?"),
        ("x = [1, 2\ny = 3\n", "1:10", "is the closing ] missing after 2?"),
        ("x = [1, 2\n[bodies.a]\nb = 1\n", "1:10", "is the closing ] missing after 2?"),
        ("x = { a = 1\nb = 2 }", "1:12", "is the closing } missing after 1?"),
        ("x = { a = 1,\n b = 2 }", "1:13", "an inline table stands on one line"),
        ("x = { a = 1, }", "1:14", "no comma stands before }"),
    ],
)
def test_a_missing_comma_or_bracket_is_told_where_it_is(text, place, said):
    with pytest.raises(SceneError) as refused:
        parse_toml(text.encode(), "scene.toml")
    assert str(refused.value).startswith(f"scene.toml:{place}: is not valid TOML: ")
    assert said in str(refused.value)


def test_whole_numbers_have_64_bits_as_toml_says():
    """Thousands of digits are more than Python writes out, whatever message they stand in."""
    small, large = -(2**63), 2**63 - 1
    assert parse_toml(f"x = [{small}, {large}]".encode(), "a.toml") == {"x": [small, large]}
    text = f"x = [{{ y = 0x{'f' * 5000} }}]\nz = {small - 1}\nf = 1e300\n"
    with pytest.raises(SceneError) as refused:
        parse_toml(text.encode(), "a.toml")
    assert [p.path for p in refused.value.problems] == [("x", 0, "y"), ("z",)]
    assert str(refused.value).startswith("a.toml: x[0].y: a whole number of 20000 bits; ")


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("1e8 N/m", "a number k, a pair [kx, ky] or [[kxx, kxy], [kyx, kyy]] is needed, found "),
        ([1e8, 1e8, 0.0], "a number k, a pair [kx, ky] or"),
        (True, "a number k, a pair [kx, ky] or"),
        (float("nan"), "Input should be a finite number"),
        (1e40, "Input should be less than"),
    ],
)
def test_a_number_that_stands_for_several_is_refused_once(small_scene, value, said):
    data = small_scene()
    data["bearings"][0]["stiffness_n_per_m"] = value
    with pytest.raises(SceneError) as refused:
        parse_scene(data)
    (problem,) = refused.value.problems
    assert problem.startswith(f"bearings[0].stiffness_n_per_m: {said}"), problem


def test_one_wrong_radius_and_one_wrong_end_of_a_pair(small_scene):
    data = small_scene()
    data["bodies"]["rotor"]["sections"][0]["outer_radius_m"] = -0.1
    data["bearings"][0]["stiffness_n_per_m"] = [1e8, "soft"]
    with pytest.raises(SceneError) as refused:
        parse_scene(data)
    first, second = refused.value.problems
    assert first.startswith("bodies.rotor.sections[0].outer_radius_m: ")
    assert second.startswith("bearings[0].stiffness_n_per_m[1]: ")


def _ring(data, **more):
    """A scene with a bearing more, and interfaces of both ends."""
    place = data["bearings"][0]["first"]
    return data | {"bearings": [*data["bearings"], {"name": "ring", "first": place} | more]}


def test_a_bearing_at_many_places_is_as_many_bearings(small_scene):
    """The same scene as with each of them written, by its hash; laws and ends go along."""
    data = small_scene()
    places = [b["first"] for b in data["bearings"]]
    seal = {"stiffness_n_per_m": [[1e6, 2e5], [-2e5, 1e6]], "damping_n_s_per_m": 30.0}
    once = parse_scene(_ring(data, first=places, **seal))
    each = [{"name": f"ring_{p.partition('.')[2]}", "first": p} | seal for p in places]
    written = parse_scene(data | {"bearings": [*data["bearings"], *each]})
    assert len(once.bearings) == len(data["bearings"]) + len(places) > 3
    assert scene_hash(once) == scene_hash(written)
    assert [b.key for b in once.bearings[-2:]] == [f"bearings[{len(data['bearings'])}]"] * 2


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"first": []}, "first has 0 places"),
        ({"second": ["ground", "ground", "ground"], "first": ["a.b", "a.c"]}, "second has 3"),
        ({"first": ["rotor.nowhere", "rotor.away"]}, "first: no interface 'rotor.nowhere'"),
        ({"first": ["rotor.nowhere", 3]}, "first: Input should be a valid string"),
    ],
)
def test_wrong_places_of_a_bearing_are_told_at_its_entry(small_scene, more, said):
    data = small_scene()
    with pytest.raises(SceneError) as refused:
        parse_scene(_ring(data, **more))
    assert refused.value.problems[0].startswith(f"bearings[{len(data['bearings'])}]")
    assert said in refused.value.problems[0]


def test_a_choice_is_proposed(small_scene):
    with pytest.raises(SceneError, match="found 'harmnic'; did you mean 'harmonic'"):
        parse_scene(small_scene() | {"model": {"level": "harmnic"}})
