"""A hub that is shrunk on: its joint in the results and on the page, and refused scenes."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from solidwhirl.console.summary import warning_texts
from solidwhirl.core.errors import UserError
from solidwhirl.model.bodies import build_bodies
from solidwhirl.model.effects import make_plan
from solidwhirl.output.documents import results_document
from solidwhirl.output.report import report_text
from solidwhirl.page.frame.records import Run
from solidwhirl.page.run import joints as page_joints
from solidwhirl.pipeline.alarms import joint_alarms
from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import parse_scene


def shrunk(level: str = "harmonic", holes=(), **joint):
    fit = {"between": ["shaft", "hub"], "interference_m": 40e-6, "yield_pa": 6e8} | joint
    return parse_scene(
        {
            "name": "shrunk",
            "model": {"level": level, "accuracy": 0.02, "order": 2, "size_m": 0.05, "modes": 4},
            "speeds": {"to_rpm": 9000, "count": 2},
            "bodies": {
                "rotor": {
                    "material": "steel",
                    "sections": [
                        {"name": "shaft", "start_m": 0.0, "end_m": 0.6, "outer_radius_m": 0.03},
                        {"name": "hub", "start_m": 0.25, "end_m": 0.33, "inner_radius_m": 0.03,
                         "outer_radius_m": 0.06},
                    ],
                    "interfaces": [{"name": "left", "kind": "section", "at_m": 0.05}],
                    "joints": [fit],
                    "holes": list(holes),
                }
            },
            "bearings": [{"name": "one", "first": "rotor.left", "stiffness_n_per_m": 1e8}],
            "analyses": [] if level == "beam" else [
                {"kind": "recovery", "bodies": ["rotor"], "states": [
                    {"mode": 3, "speed_rpm": 9000}
                ]}
            ],
        }
    )  # fmt: skip


@pytest.fixture(scope="module")
def harmonic():
    return run_scene(shrunk())


def test_a_joint_stands_in_the_results_and_on_the_page(harmonic) -> None:
    document = results_document(harmonic)
    (found,) = document["bodies"]["rotor"]["joints"]
    assert found["between"] == ["shaft", "hub"]
    assert found["speed_rpm"][0] == 0.0
    assert found["speed_rpm"][-1] == pytest.approx(9000.0)
    assert found["mean_pressure_pa"][-1] < found["mean_pressure_pa"][0]
    assert 9000.0 < found["lifts_at_rpm"] < found["loose_at_rpm"]
    assert len(found["pressure_pa"][0]) == len(found["along_m"])
    assert all(check["passed"] for check in document["invariants"])
    section = page_joints.section(Run(results=harmonic, document=document))
    assert section is not None
    table = section.blocks[0]
    assert table.rows[0][0] == "rotor: hub on shaft"
    assert len(table.rows) == 2


def test_a_face_that_lifts_in_the_range_of_speeds_is_a_warning(harmonic) -> None:
    """Speeds of the reference shaft; what begins to lift beyond the largest speed is none."""
    assert not harmonic.alarms
    body = harmonic.bodies["rotor"]
    (joint,) = body.work.joints
    top = joint.speeds_rad_s[-1]
    part = np.append(np.zeros(len(joint.speeds_rad_s) - 1), 0.564)
    lifting = replace(joint, lifts_at_rad_s=0.9 * top, lifted_part=part)
    (alarm,) = joint_alarms("rotor", -2.0, [lifting, replace(joint, lifts_at_rad_s=None)])
    assert alarm.speed_rpm == pytest.approx(4050.0)
    lifted = replace(body, work=replace(body.work, joints=(lifting,)))
    found = replace(harmonic, bodies={"rotor": lifted})
    message = (
        "8100 rpm: the face of hub on shaft (rotor) begins to lift; 56 % of it is open at 9000 rpm"
    )
    document = results_document(found)
    assert document["doubts"][-1]["message"] == message
    assert document["verdict"]["alarms"][0]["kind"] == "joint lifts"
    assert message in warning_texts(document)
    assert f"**warning:** {message}" in report_text(found, document)


def test_beams_say_that_they_are_bonded() -> None:
    scene = shrunk("beam")
    (effect,) = (e for e in make_plan(scene, build_bodies(scene)).effects if e.name == "joints")
    assert not effect.on
    assert "45 degrees" in effect.why


def test_both_levels_agree_and_recover_all_of_the_energy(harmonic) -> None:
    """Frequencies within the sum of the estimates; the springs' energy is that of the field too."""
    found = [results_document(results) for results in (harmonic, run_scene(shrunk("solid")))]
    assert all(check["passed"] for document in found for check in document["invariants"])
    (meridian,), (solid,) = (d["bodies"]["rotor"]["joints"] for d in found)
    assert solid == meridian
    rows, errors = (
        [np.array([row[-1] for row in d["campbell"][key]]) for d in found]
        for key in ("frequency_hz", "frequency_error_estimate")
    )
    assert (np.abs(rows[1] / rows[0] - 1.0) <= errors[0] + errors[1]).all()


def test_features_refuse_joints() -> None:
    with pytest.raises(UserError, match=r"joints are of bodies of revolution, .* holes 'row'"):
        build_bodies(shrunk("solid", holes=[
            {"name": "row", "in": "hub", "count": 4, "pitch_radius_m": 0.045, "diameter_m": 0.006}
        ]))  # fmt: skip


def test_a_hub_that_yields_is_refused_by_its_body() -> None:
    message = r"bodies\.rotor: at \S+ rpm section 'hub' yields .* yield_pa is 1e\+08"
    with pytest.raises(UserError, match=message):
        run_scene(shrunk(yield_pa=1e8))


def test_sections_that_do_not_touch_are_refused_with_their_key() -> None:
    with pytest.raises(UserError, match=re.escape("bodies.rotor: body 'rotor': joint between")):
        build_bodies(shrunk(between=["shaft", "rim"]))
