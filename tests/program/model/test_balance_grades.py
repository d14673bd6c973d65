"""Unbalances by a grade of ISO 21940: moments by hand, the same responses, faults in files."""

from __future__ import annotations

import numpy as np
import pytest

from solidwhirl.build import beam, bearing, disk, scene, unbalance, with_changes
from solidwhirl.core.errors import SceneError
from solidwhirl.model.balance_grades import with_moments
from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import scene_hash


def small(*unbalances):
    wheel = disk(name="wheel", at_m=0.2, mass_kg=12.0, polar=0.12, diametral=0.065)
    return scene(
        "small",
        beams={
            "rotor": beam([0.0, 0.2, 0.6], 0.02, {"a": 0.0, "wheel": 0.2, "b": 0.6}, disks=[wheel])
        },
        bearings=[
            bearing(n, f"rotor.{n}", stiffness_n_per_m=5e7, damping_n_s_per_m=800.0) for n in "ab"
        ],
        speeds_rpm=[0.0, 6000.0],
        model={"level": "beam", "estimates": "off"},
        analyses=[
            {
                "kind": "unbalance_response",
                "unbalances": unbalances,
                "observe": ["rotor.wheel"],
                "to_rpm": 9000,
                "count": 30,
            }
        ],
    )


def test_a_grade_is_its_moment():
    """The whole mass by hand: shaft and disk; phases and shares stay apart."""
    mass = 12.0 + 7850.0 * np.pi * 0.02**2 * 0.6
    graded = small(
        unbalance("rotor.wheel", grade=2.5, at_rpm=9000.0, share=0.25),
        unbalance("rotor.b", phase_deg=90.0, grade=6.3, at_rpm=3000.0),
    )
    results = run_scene(graded)
    found = results.analyses["unbalance_response"].document
    whole = results.elements["rotor"].mass_kg
    assert whole == pytest.approx(mass, rel=0.01)  # steel of 7800 to 7870 kg/m3
    moments = [u["moment_kg_m"] for u in found["unbalances"]]
    wanted = [0.25 * whole * 2.5e-3 / (300.0 * np.pi), whole * 6.3e-3 / (100.0 * np.pi)]
    assert moments == pytest.approx(wanted, rel=1e-12)
    assert [sorted(u) for u in found["unbalances"]] == [["at", "moment_kg_m", "phase_deg"]] * 2
    plain = small(
        unbalance("rotor.wheel", wanted[0]), unbalance("rotor.b", wanted[1], phase_deg=90.0)
    )
    same = run_scene(plain).analyses["unbalance_response"].document["exciters"][0]["places"]
    np.testing.assert_allclose(
        found["exciters"][0]["places"]["rotor.wheel"]["major_m"],
        same["rotor.wheel"]["major_m"],
        rtol=1e-10,
    )
    assert with_moments(plain, {"rotor": 1.0}) is plain


def test_a_grade_is_kept_by_changes_and_told_as_given():
    graded = small(unbalance("rotor.wheel", grade=2.5, at_rpm=9000))
    assert scene_hash(with_changes(graded, {})) == scene_hash(graded)
    finer = with_changes(graded, {"analyses[0].unbalances[0].grade": 1.0})
    assert finer.analyses[0].unbalances[0].grade == 1.0
    assert scene_hash(finer) != scene_hash(graded)
    dumped = graded.analyses[0].unbalances[0].model_dump()
    assert set(dumped) == {"at", "phase_deg", "grade", "at_rpm", "share"}


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({}, "needs moment_kg_m, or both grade and at_rpm"),
        ({"grade": 2.5}, "needs moment_kg_m, or both grade and at_rpm"),
        ({"at_rpm": 2000}, "needs moment_kg_m, or both grade and at_rpm"),
        ({"moment_kg_m": 1e-4, "grade": 2.5, "at_rpm": 9e3}, "has moment_kg_m and grade; one of"),
        ({"moment_kg_m": 1e-4, "share": 0.5}, "has moment_kg_m and share; one of"),
        ({"moment_kg_m": 0.0}, "moment_kg_m: "),
        ({"grade": 2.5, "at_rpm": 9000, "share": 1.5}, "share: "),
        ({"grade": -1.0, "at_rpm": 9000}, "grade: "),
    ],
)
def test_faults(keys, said):
    with pytest.raises(SceneError) as caught:
        small({"at": "rotor.wheel", **keys})
    assert "analyses[0]" in str(caught.value)
    assert "unbalances[0]" in str(caught.value)
    assert said in str(caught.value)
