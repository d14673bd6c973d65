"""What the page and the report say of the estimate and of what it leaves out."""

from __future__ import annotations

import copy

import pytest
from everything import everything

from solidwhirl.estimates.documents import coupling_effect, coupling_text, several_materials
from solidwhirl.output.report import report_text
from solidwhirl.page.frame.records import Table, Text
from solidwhirl.page.run import accuracy
from solidwhirl.scene_reading.reader import parse_scene


@pytest.fixture
def document(laval):
    return copy.deepcopy(dict(laval.document))


def texts(found):
    return "\n".join(b.text for b in found if isinstance(b, Text))


def tables(found):
    return {b.title: b for b in found if isinstance(b, Table)}


def test_bodies_of_several_materials_are_named(document, laval, small_scene):
    assert document["accuracy"]["bodies_of_several_materials"] == {}
    document["accuracy"]["bodies_of_several_materials"] = {"rotor": ["steel", "titanium"]}
    said = "is of several materials (steel, titanium): the estimate has not been checked"
    assert f"- `rotor` {said}" in texts(accuracy.accuracy_blocks(document))
    assert "| Stability | ✓ **stable**, 0 to 6000 rpm |" in report_text(laval.results, document)
    assert f"- `rotor` {said}" in report_text(laval.results, document)
    assert several_materials(everything().results.scene) == {}
    data = small_scene()
    assert several_materials(parse_scene(data)) == {}
    data["bodies"]["rotor"]["sections"][1]["material"] = "titanium"
    assert several_materials(parse_scene(data)) == {"rotor": ["steel", "titanium"]}


def test_choice_of_the_coupling_has_its_size(document, laval):
    parts = document["campbell"]["error_parts"]
    document["critical_speeds"] = []
    parts["interface_coupling"] = [[0.01, None], [0.032, 0.02]]
    assert coupling_effect(document) == 0.032
    for said in (texts(accuracy.accuracy_blocks(document)), report_text(laval.results, document)):
        assert "move by up to 3.2 %" in said and "rigid where a stiff ring" in said
    del parts["interface_coupling"]
    assert coupling_effect(document) is None
    assert "1.5e-05" not in coupling_text(1.5e-5)


def test_rounds_of_solids_say_what_they_leave_out(document, laval):
    entry = {
        "unknowns": {"rotor": 1000},
        "modes": {"rotor": 8},
        "largest_error_estimate": 2.1e-5,
        "refined": [],
    }
    document["accuracy"]["rounds"] = [entry]
    (body,) = document["bodies"].values()
    title, said = "Rounds of refinement", "is compared with a coarser one after the last round"
    assert title not in tables(accuracy.accuracy_blocks(document))
    assert said not in report_text(laval.results, document)
    body |= {"level": "solid", "source": {"file": "rotor.step"}}
    assert said in tables(accuracy.accuracy_blocks(document))[title].caption
    assert said in report_text(laval.results, document)
