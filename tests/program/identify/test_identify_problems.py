"""Problem files: places in a scene, and what is refused with which message."""

from __future__ import annotations

import pytest
from cylinder import LENGTH, MASS, POLAR, RADIUS

from solidwhirl.core.errors import SceneError
from solidwhirl.identify.run import read_problem
from solidwhirl.scene_reading.paths import PlaceError, find_place, with_values

# -- places ---------------------------------------------------------------------------------------


def test_places_lead_to_numbers():
    data = {"a": {"list": [{"name": "x", "r": [1.0, 2.0]}, {"name": "y", "r": 3}]}}
    place = find_place(data, "a.list[x].r[1]")
    assert place.steps == ("a", "list", 0, "r", 1)
    assert find_place(data, "a.list[1].r").steps == ("a", "list", 1, "r")
    changed = with_values(data, {place: 5.0})
    assert changed["a"]["list"][0]["r"] == [1.0, 5.0]
    assert data["a"]["list"][0]["r"] == [1.0, 2.0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty text"),
        ("a..b", "is no place"),
        ("[0].a", "is no place"),
        ("a.lisd[x].r[0]", r"a has no 'lisd'; did you mean 'list'\? allowed are list"),
        ("a.list[z].r", r"a\.list has no entry \[z\]; allowed are x, y"),
        ("a.list[x].r[2]", r"a\.list\[x\]\.r has no entry \[2\]; allowed are 0 to 1"),
        ("a.list[x].r", "is a list in the scene; a number is needed"),
        ("a.list[x].name", "is a text in the scene"),
        ("a.list.r", "a.list is a list, which has no key 'r'"),
        ("a[x]", r"a is a table, \[x\] needs a list"),
    ],
)
def test_places_that_are_none(text, message):
    data = {"a": {"list": [{"name": "x", "r": [1.0, 2.0]}, {"name": "y", "r": 3}]}}
    with pytest.raises(PlaceError, match=message):
        find_place(data, text)


# -- refusals -------------------------------------------------------------------------------------


ELSEWHERE = {"name": "again"}
F1 = {"name": "f", "quantity": "frequency_hz", "value": 1.0}
START = "bodies.rotor.sections[shaft].start_m"
REFUSED = {
    # settings and top level
    r"settings\.accuracies: unknown key; did you mean 'accuracy'": {"settings": {"accuracies": 1}},
    r"settings\.coarse_accuracy: 0\.02 is finer than": {"settings": {"accuracy": 0.05}},
    r"settings\.starts: .*found 0": {"settings": {"starts": 0}},
    r"target: unknown key; did you mean 'targets'": {"target": []},
    r"parameters: .*at least 1": {"parameters": []},
    r"none\.toml: no such file": {"scene": "none.toml"},
    # parameters
    r"parameters\[0\]\.upper: 0\.01 is not above lower": {"parameters": [RADIUS | {"upper": 0.01}]},
    r"parameters\[0\]\.start: 1 lies outside the bounds 0\.02 to 0\.2": {
        "parameters": [RADIUS | {"start": 1.0}]
    },
    r"parameters\[0\]\.places: 'radius' stands nowhere": {"parameters": [RADIUS | {"places": []}]},
    r"parameters\[1\]\.places: .* is filled by parameters\[0\]\.places already": {
        "parameters": [RADIUS, RADIUS | ELSEWHERE]
    },
    r"parameters\[1\]\.name: 'radius' is the name of parameters\[0\] too": {
        "parameters": [RADIUS, LENGTH | {"name": "radius"}]
    },
    r"parameters\[0\]\.start: missing": {
        "parameters": [{k: v for k, v in RADIUS.items() if k != "start"}]
    },
    r"parameters\[0\]\.places: .*did you mean 'outer_radius_m'": {
        "parameters": [RADIUS | {"places": ["bodies.rotor.sections[shaft].outer_radius"]}]
    },
    # derived places and comments
    r"derived\[0\]\.places: 'name' is a text": {
        "derived": [{"places": ["name"], "terms": {"radius": 1.0}}]
    },
    r"derived\[0\]\.terms: no parameter 'radios'; did you mean 'radius'": {
        "derived": [{"places": [START], "terms": {"radios": 1.0}}]
    },
    r"comments: .*did you mean 'shaft'": {"comments": {START.replace("shaft", "shat"): "x"}},
    # targets
    r"targets\[0\]\.body: no body 'rotr'; did you mean 'rotor'": {
        "targets": [MASS | {"body": "rotr"}]
    },
    r"targets\[0\]\.quantity: .*'mass_kg'.*found 'weight'": {
        "targets": [MASS | {"quantity": "weight"}]
    },
    r"targets\[0\]\.value: 0; deviations are relative": {"targets": [MASS | {"value": 0.0}]},
    r"targets\[0\]\.mode: mass_kg has neither mode": {"targets": [MASS | {"mode": 1}]},
    r"targets\[1\]: the same quantity as targets\[0\]": {"targets": [MASS, MASS | ELSEWHERE]},
    r"targets\[1\]\.name: 'mass' is the name of targets\[0\]": {
        "targets": [MASS, POLAR | {"name": "mass"}]
    },
    r"targets\[0\]\.mode: missing": {"targets": [F1]},
    r"targets\[0\]\.body: frequency_hz is a quantity of the whole scene": {
        "targets": [F1 | {"mode": 1, "body": "rotor"}]
    },
    r"targets\[0\]\.tolerance: .*greater than 0": {"targets": [MASS | {"tolerance": 0.0}]},
}


@pytest.mark.parametrize("message", REFUSED)
def test_problems_that_are_refused(problem, message):
    path = problem(**REFUSED[message])
    with pytest.raises(SceneError, match=message) as caught:
        read_problem(path)
    # every line names the file
    name = "none.toml" if "none" in message else "problem.toml"
    assert all(name in line.split(": ")[0] for line in str(caught.value).splitlines())


def test_all_problems_of_a_file_at_once(problem):
    with pytest.raises(SceneError) as caught:
        read_problem(problem([{**RADIUS, "start": 9.0}], [{**MASS, "value": 0.0}]))
    assert len(caught.value.problems) == 2


def test_list_of_wrong_entries_is_not_called_empty(problem):
    with pytest.raises(SceneError, match="tolerance") as caught:
        read_problem(problem(targets=[MASS | {"tolerance": 0.0}]))
    assert len(caught.value.problems) == 1


def test_problem_that_is_no_toml_is_refused(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text("name = ")
    with pytest.raises(SceneError, match=r"bad\.toml:1:8: is not valid TOML"):
        read_problem(path)
