"""Magnetic bearings of scenes: springs and dampers by control, sensitivity, sensors apart."""

from __future__ import annotations

import numpy as np
import pytest
from engine_parts import DIAMETRAL, MASS
from symmetric_rotor import ARM, MOMENT, rotor, run

from solidwhirl.core.errors import SceneError
from solidwhirl.datasets.results import datasets
from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn.modes.controlled import controlled, state_matrix
from solidwhirl.rotordyn.plots.chart import Rule
from solidwhirl.scene.magnetic_bearings import MagneticLawSpec
from solidwhirl.scene_reading.reader import parse_scene

PID = {"kind": "pid", "proportional_a_per_m": 1.5e4, "derivative_a_s_per_m": 4.0}
AMB = {
    "kind": "magnetic",
    "current_stiffness_n_per_a": 200.0,
    "negative_stiffness_n_per_m": 1e6,
    "controller": PID,
}
ASKED = {"kind": "sensitivity", "to_rpm": 9e3, "count": 2}
SPIN = {
    "kind": "unbalance_response",
    "unbalances": [{"at": "rotor.m", "moment_kg_m": MOMENT}],
    "observe": ["rotor.a"],
    "to_rpm": 9e3,
    "count": 5,
}


def magnetic(law=AMB, **keys):
    data = rotor(speed_laws={"amb": law})
    ends = (("A", "rotor.a"), ("B", "rotor.b"))
    data["bearings"] = [{"name": n, "first": f, "speed_law": "amb", **keys} for n, f in ends]
    return data


@pytest.fixture(scope="module")
def results():
    return run(magnetic(), ASKED, SPIN, {"kind": "stability", "to_rpm": 9e3, "count": 2})


def test_sensitivity_of_a_rigid_rotor(results):
    """At rest translation and tilt are apart, and T of a sensor is the sum of both."""
    assert results.analyses["sensitivity"].document["stable"] == [True, True]
    found = run(magnetic(), {**ASKED, "to_rpm": 1e-3}).analyses["sensitivity"].document
    k, c = 200.0 * 1.5e4 - 1e6, 200.0 * 4.0

    def sensitivity(frequency_hz):
        s = 2j * np.pi * np.asarray(frequency_hz)
        control, spring = 200.0 * (1.5e4 + 4.0 * s), k + c * s
        shift = control / (MASS * s**2 + 2 * spring)
        return abs(1 - shift - control * ARM**2 / (DIAMETRAL * s**2 + 2 * spring * ARM**2))

    curves, axis = found["curves"], found["axes"][0]
    wanted = sensitivity(curves["frequency_hz"])
    for gain in curves["sensitivity"]:
        np.testing.assert_allclose(gain, wanted, rtol=1e-6)
    assert axis["peak"][0] == pytest.approx(sensitivity(axis["at_hz"][0]), rel=1e-6)
    assert axis["peak"][0] >= wanted.max() * (1 - 1e-9)


def test_proportional_and_derivative_control_is_a_spring_and_a_damper(results):
    plain = run(rotor(800.0), SPIN).analyses["unbalance_response"].document
    found = results.analyses["unbalance_response"].document
    wanted, given = (d["exciters"][0]["peaks"] for d in (plain, found))
    assert [p["speed_rpm"] for p in given["rotor.a"]] == pytest.approx(
        [p["speed_rpm"] for p in wanted["rotor.a"]], rel=1e-9
    )
    np.testing.assert_allclose(
        results.campbell.eigenvalues[:, 0], np.array(run(rotor(800.0)).campbell.eigenvalues)[:, 0]
    )
    assert results.analyses["stability"].document["unstable_intervals"] == []


def test_page_picture_and_dataset(results):
    outcome = results.analyses["sensitivity"]
    table, *charts = outcome.blocks()
    assert [chart.name for chart in charts] == ["sensitivity", "sensitivity-peaks"]
    assert [rule.at for rule in charts[0].marks(Rule)] == [3.0, 4.0, 5.0]
    assert len(table.rows) == 4 and table.rows[0][0] == "A x"
    tree = datasets(results)["analyses/sensitivity"]
    assert tree["peak"].dims == ("axis", "speed_rpm")
    assert outcome.headline.startswith(f"zone {outcome.document['axes'][0]['zone'][0]}")


def test_forms_of_a_controller_and_sensors_apart():
    """The same controller as a transfer function and as a state space."""
    top = (1.5e4 / 6e3 + 4.0, 1.5e4)  # 1.5e4 + 4 s / (1 + s / 6e3)
    forms = [
        {**PID, "roll_off_hz": 6e3 / (2 * np.pi)},
        {"kind": "transfer", "numerator": top, "denominator": (1 / 6e3, 1.0)},
        {"kind": "state_space", "a": [[-6e3]], "b": [[1.0]], "c": [[-4.0 * 6e3**2]],
         "d": [[1.5e4 + 4.0 * 6e3]]},
    ]  # fmt: skip
    peaks = []
    for form in forms:
        data = magnetic({**AMB, "controller": form})
        data["bearings"][0]["sensor"] = "rotor.a"  # where the magnets are
        found = run(data, ASKED).analyses["sensitivity"].document
        peaks.append([axis["peak"] for axis in found["axes"]])
    np.testing.assert_allclose(peaks[1], peaks[0], rtol=1e-9)
    np.testing.assert_allclose(peaks[2], peaks[0], rtol=1e-9)


def test_a_state_space_without_states_is_a_gain():
    gain = {"kind": "state_space", "a": [], "b": [], "c": [], "d": [[1.5e4]]}
    law = MagneticLawSpec.model_validate({**AMB, "controller": gain})
    np.testing.assert_array_equal(law.bearing().controller.response(1j), 1.5e4 * np.eye(2))


@pytest.mark.parametrize(
    ("law", "keys", "says"),
    [
        ({**AMB, "controller": {**PID, "kind": "pd"}}, {}, "'pid', 'transfer', 'state_space'"),
        ({**AMB, "controller": {"kind": "transfer", "numerator": [1.0, 2.0], "denominator": [1.0]}},
         {}, "the numerator's order must not be above"),
        ({**AMB, "controller": {"kind": "state_space", "a": [[1.0]], "b": [[1.0], [2.0]],
                                "c": [[1.0]], "d": [[0.0]]}}, {}, "b has 2 rows; a has 1"),
        ({**AMB, "low_pass_damping_ratio": 0.7}, {}, "low_pass_damping_ratio needs low_pass_hz"),
        (AMB, {"sensor": "rotor.x"}, "sensor: no interface 'rotor.x'"),
        (AMB, {"stiffness_n_per_m": 1e6}, "leave out"),
        ({"kind": "preset", "preset": "lee_isotropic"}, {"sensor": "rotor.m"}, "kind magnetic"),
    ],
)  # fmt: skip
def test_refusals(law, keys, says):
    with pytest.raises(SceneError) as error:
        parse_scene(magnetic(law, **keys))
    assert says in str(error.value)


def test_no_magnets():
    with pytest.raises(SceneError, match="no bearing has a law of that kind"):
        parse_scene({**rotor(), "analyses": [ASKED]})


@pytest.mark.solver
def test_meshed_spindle_with_a_sensor_beside_its_magnets():
    """States that are much faster than the rotor, and an interface where nothing but a sensor is.

    Roots of the Campbell diagram solve the closed system's state matrix, which scales otherwise.
    """
    pid = {"kind": "pid", "proportional_a_per_m": 2e4, "derivative_a_s_per_m": 45}
    law = {"kind": "magnetic", "current_stiffness_n_per_a": 250, "amplifier_hz": 8000}
    law |= {"negative_stiffness_n_per_m": 1.2e6, "controller": {**pid, "roll_off_hz": 4000}}
    wheel = {"name": "wheel", "start_m": 0.6, "end_m": 0.63, "outer_radius_m": 0.09}
    places = {"left": 0.1, "right": 0.5, "probe": 0.53}
    spindle = {
        "name": "spindle",
        "speeds": {"list_rpm": [0.0, 24000.0]},
        "model": {"level": "harmonic", "accuracy": 5e-2},
        "bodies": {
            "rotor": {
                "material": "steel",
                "sections": [
                    {"name": "shaft", "start_m": 0.0, "end_m": 0.7, "outer_radius_m": 0.025},
                    {**wheel, "inner_radius_m": 0.025},
                ],
                "interfaces": [
                    {"name": n, "kind": "section", "at_m": at} for n, at in places.items()
                ],
            }
        },
        "speed_laws": {"amb": law},
        "bearings": [
            {"name": "left", "first": "rotor.left", "speed_law": "amb"},
            {"name": "right", "first": "rotor.right", "sensor": "rotor.probe", "speed_law": "amb"},
        ],
    }
    results = run_scene(parse_scene(spindle))
    assert all(check.passed is not False for check in results.checks)
    (coupling,) = [c for c in results.estimates.comparisons if c.part == "interface_coupling"]
    assert coupling.second_elements.keys() == {"rotor"}
    known = np.linalg.eigvals(state_matrix(controlled(results.system), 0.0))
    found = results.campbell.eigenvalues[:, 0]
    away = np.abs(np.subtract.outer(found[np.isfinite(found)], known)).min(axis=1)
    assert found.size > 2
    # the state matrix loses digits to its fastest states, near 1e5 1/s
    assert away.max() < 1e-9 * np.abs(known).max()
