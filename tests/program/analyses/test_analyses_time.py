"""Run-ups and state-space models of scenes against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from engine_parts import RPM
from symmetric_rotor import (
    DAMPING,
    LATERAL_RAD_S,
    MOMENT,
    STIFFNESS,
    compliance,
    outcome,
    rotor,
    run,
)

pytestmark = pytest.mark.solver

UNBALANCE = [{"at": "rotor.m", "moment_kg_m": MOMENT, "phase_deg": 30.0}]
SWEEP = {"unbalances": UNBALANCE, "observe": ["rotor.m"], "to_rpm": 9e3, "count": 181}

# -- run-up ---------------------------------------------------------------------------------------

RUN = {"ramp_s": 0.2, "hold_s": 0.4, "to_rpm": 4e3, "sampling_hz": 1e4, "record_hz": 5e3}
RUN |= {"mount": "A", "unbalances": UNBALANCE, "observe": ["rotor.m"]}


def test_run_up_ends_in_the_steady_response(tmp_path):
    sweep = {**SWEEP, "from_rpm": 3.9e3, "to_rpm": 4e3, "count": 5}
    results = run(rotor(), {"kind": "run_up", **RUN}, {"kind": "unbalance_response", **sweep})
    (exciter,) = results.analyses["unbalance_response"].document["exciters"]
    steady = exciter["places"]["rotor.m"]["major_m"][-1]
    results.analyses["run_up"].files["run_up.npz"](tmp_path / "run_up.npz")
    record = np.load(tmp_path / "run_up.npz")
    assert record["outputs"].tolist() == ["rotor.m"]
    np.testing.assert_allclose(1.0 / np.diff(record["time_s"]), RUN["record_hz"], rtol=1e-6)
    late = record["time_s"] > 0.55  # the transient has decayed by exp(-33 * 0.35) = 1e-5
    radius = np.hypot(*record["translation_m"][0, :2][:, late])
    np.testing.assert_allclose(radius, steady, rtol=1e-4)
    omega = 4e3 * RPM
    force = np.hypot(*record["mount_force_n"][:2][:, late])
    wanted = np.abs(STIFFNESS + 1j * DAMPING * omega) * steady
    np.testing.assert_allclose(force, wanted, rtol=1e-4)
    np.testing.assert_allclose(record["speed_rad_s"][late], omega, rtol=1e-12)
    energy = results.analyses["run_up"].document["energy"]
    assert energy["largest_error_j"] < 1e-5 * energy["largest_j"]
    assert energy["largest_j"] >= energy["dissipated_j"]


def test_run_up_across_a_resonance_has_its_peak_alone():
    """Up to 9000 rpm, 150 Hz: one peak, at the translation that the unbalance excites."""
    document = outcome(rotor(), "run_up", **{**RUN, "ramp_s": 2.0, "to_rpm": 9e3})
    (peak,) = document["normalised_response"]["peaks"]
    # bands of 1 Hz; a damped force through spring and damper is largest at the natural frequency
    assert peak["frequency_hz"] == pytest.approx(LATERAL_RAD_S / (2 * np.pi), abs=1.0)


def test_rigid_rotor_needs_no_modes():
    """A model without the flexibility that a body does not have is the same model."""
    asked = {"compare_flexible": [["rotor"], []], "bands_hz": [[10.0, 60.0], [100.0, 200.0]]}
    document = outcome(rotor(), "run_up", **RUN, **asked)
    found = document["complexity"]
    assert found["excited_to_hz"] == pytest.approx(4e3 / 60.0, rel=1e-9)
    names = [model["name"] for model in found["models"]]
    assert names == ["all modes", "modes of rotor", "no modes"]
    full = found["models"][0]["peak_force_n"]
    assert full == pytest.approx(document["largest_mount_force_n"], rel=1e-9)
    for model in found["models"]:
        assert abs(model["peak_force_error"]) < 1e-9
        compared, beyond = model["response_error_by_band"]
        assert compared < 1e-6
        assert beyond is None  # beyond the excitation


# -- state space ----------------------------------------------------------------------------------


@pytest.mark.parametrize("form", ["polynomial", "table"])
def test_state_space(form, tmp_path):
    """C (i w - A)^-1 B + D is the compliance; velocity i w and acceleration -w^2 times that."""
    data = rotor()
    if form == "table":
        law = {"kind": "polynomial", "argument_unit": "rpm", "argument_range": [0.0, 9e3]}
        data["speed_laws"] = {"law": {**law, "stiffness_x": [1.0], "stiffness_y": [1.0]}}
        data["bearings"][0]["speed_law"] = "law"
    asked = {"inputs": ["rotor.m"], "outputs": ["rotor.m"], "to_rpm": 9e3, "speed_count": 3}
    results = run(data, {"kind": "state_space", **asked})
    entry = results.analyses["state_space"]
    assert entry.document["form"] == form
    entry.files["state_space.npz"](tmp_path / "model.npz")
    model = np.load(tmp_path / "model.npz")
    if form == "table":
        matrices = [model[name][1] for name in "ABCD"]
        np.testing.assert_allclose(model["speeds"], np.array([0.0, 4.5e3, 9e3]) * RPM, rtol=1e-12)
    else:
        matrices = [sum(model[f"{n}{p}"] * (4.5e3 * RPM) ** p for p in range(3)) for n in "ABCD"]
    a, b, c, d = matrices
    names = model["output_names"].tolist()
    column = model["input_names"].tolist().index("force rotor.m.ux")
    for omega in (200.0, 577.0, 900.0):
        gain = (c @ np.linalg.solve(1j * omega * np.eye(len(a)) - a, b) + d)[:, column]
        for power, quantity in enumerate(("displacement", "velocity", "acceleration")):
            found = gain[names.index(f"{quantity} rotor.m.ux")]
            assert found == pytest.approx((1j * omega) ** power * compliance(omega), rel=1e-9)
