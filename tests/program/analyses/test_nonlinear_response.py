"""Nonlinear responses of scenes: a rigid rotor whose mid-span spring and film are closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from engine_parts import MASS, RPM
from symmetric_rotor import DAMPING, MOMENT, STIFFNESS, rotor, run

from solidwhirl.core.errors import SceneError
from solidwhirl.datasets.results import datasets
from solidwhirl.rotordyn.nonlinear import starts
from solidwhirl.rotordyn.plots.chart import Curve
from solidwhirl.scene_reading.reader import parse_scene

UNBALANCE = [{"at": "rotor.m", "moment_kg_m": MOMENT}]
CUBIC = {"first": "rotor.m", "kind": "cubic", "radial_n_per_m3": 2.5e13}
ASKED = {
    "kind": "nonlinear_response",
    "unbalances": UNBALANCE,
    "nonlinear": [CUBIC],
    "from_rpm": 1000.0,
    "to_rpm": 20000.0,
    "observe": ["rotor.m", "rotor.a"],
}


@pytest.fixture(scope="module")
def results():
    return run(rotor(100.0, rpm=(0.0, 2e4)), ASKED)


def test_branch_jumps_and_stability(results):
    found = results.analyses["nonlinear_response"].document
    assert found["harmonics"] == 1 and found["truncation_error_estimate"] < 1e-9
    (branch,) = found["branches"]
    assert branch["followed_to_its_end"] and not branch["open_ends"] and not found["notes"]
    omega = np.array(branch["speed_rpm"]) * RPM
    r = np.array(branch["places"]["rotor.m"]["largest_radius_m"])
    held = 2 * STIFFNESS - MASS * omega**2 + 200j * omega + CUBIC["radial_n_per_m3"] * r**2
    np.testing.assert_allclose(np.abs(held) * r, MOMENT * omega**2, rtol=1e-6)
    np.testing.assert_allclose(branch["places"]["rotor.m"]["major_m"], r, rtol=1e-5)
    up, down = found["jumps"]
    assert (up["direction"], down["direction"]) == ("up", "down")
    assert up["speed_rpm"] > down["speed_rpm"]
    assert up["after_m"]["rotor.m"] < up["before_m"]["rotor.m"]
    # between the turning points, and nowhere else, small motions grow
    first, last = np.flatnonzero(branch["turning"])
    stable = np.array(branch["stable"])
    assert not stable[first + 1 : last].any()
    assert stable[:first].all() and stable[last + 1 :].all()


def test_picture_table_and_dataset(results):
    outcome = results.analyses["nonlinear_response"]
    chart, table, accuracy = outcome.blocks()
    curves = {c.name: c for c in chart.marks(Curve) if c.name}
    assert curves["rotor.m, unstable"].look.dash == "dash"
    assert curves["rotor.m"].look.dash == "solid"
    assert len(table.rows) == 4 and accuracy.rows[0][0] == 1
    tree = datasets(results)["analyses/nonlinear_response"]
    assert tree["largest_radius_m"].dims == ("place", "point")
    assert tree["largest_radius_m"].sizes["place"] == 2


def test_rotor_in_a_squeeze_film_alone():
    """Damper in parallel with springs; weight along y makes the orbit no circle."""
    film = {"kind": "squeeze_film", "radius_m": 0.05, "length_m": 0.03, "clearance_m": 2e-4}
    joints = [{"first": f"rotor.{end}", **film, "viscosity_pa_s": 0.02} for end in "ab"]
    data = rotor(DAMPING, rpm=(0.0, 9e3))
    found = run(
        data, {**ASKED, "nonlinear": joints, "to_rpm": 9e3, "gravity_m_per_s2": [0.0, -9.81]}
    )
    document = found.analyses["nonlinear_response"].document
    assert document["harmonics"] > 1 and document["truncation_error_estimate"] < 1e-3
    assert all(document["branches"][0]["stable"]) and not document["jumps"]


def test_subharmonics_are_sought_and_told(monkeypatch):
    """One third of the unbalance's frequency in y, along which the spring stiffens; few starts."""
    monkeypatch.setattr(starts, "_EACH", 1)
    monkeypatch.setattr(starts, "_SPEEDS", 4)
    spring = {"first": "rotor.m", "kind": "cubic", "along_n_per_m3": [0.0, 1e15]}
    asked = {**ASKED, "nonlinear": [spring], "from_rpm": 17500.0, "to_rpm": 20000.0}
    found = run(rotor(40.0, rpm=(0.0, 2.2e4)), {**asked, "period_multiples": [3]})
    outcome = found.analyses["nonlinear_response"]
    periods = [b["period_multiple"] for b in outcome.document["branches"]]
    assert periods[0] == 1 and 3 in periods
    assert "repeating after 3 turns" in outcome.headline
    names = {c.name for c in outcome.blocks()[0].marks(Curve)}
    assert "rotor.m, 3 turns" in names
    tree = datasets(found)["analyses/nonlinear_response"]
    assert set(tree["period_multiple"].values.tolist()) == set(periods)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"nonlinear": [{**CUBIC, "first": "rotor.x"}]}, "nonlinear[0].first: no interface"),
        ({"nonlinear": [{**CUBIC, "second": "grond"}]}, "nonlinear[0].second: no interface"),
        ({"nonlinear": [{**CUBIC, "second": "rotor.m"}]}, "must differ"),
        ({"nonlinear": [{**CUBIC, "kind": "square"}]}, "'cubic', 'clearance', 'squeeze_film'"),
        ({"nonlinear": []}, "nonlinear"),
        ({"period_multiples": [0]}, "period_multiples[0]"),
        ({"to_rpm": 500.0}, "to_rpm = 500 is not above from_rpm = 1000"),
        (
            {"nonlinear": [{"first": "rotor.m", "second": "rotor.a", "kind": "clearance",
                            "gap_m": 1e-5, "stiffness_n_per_m": 1e6, "friction": 0.1}]},
            "nonlinear[0].friction: 'rotor.m' and 'rotor.a' turn at one speed",
        ),
    ],
)  # fmt: skip
def test_refusals(changes, says):
    with pytest.raises(SceneError) as error:
        parse_scene({**rotor(), "analyses": [{**ASKED, **changes}]})
    assert says in str(error.value)
