"""Analyses, run-ups and state-space models of scenes: their numbers against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from engine_parts import DIAMETRAL, MASS, RPM
from symmetric_rotor import (
    ARM,
    DAMPING,
    LATERAL_RAD_S,
    MOMENT,
    POLAR,
    SPAN,
    STIFFNESS,
    compliance,
    outcome,
    rotor,
    run,
)

from solidwhirl.pipeline.run import run_scene
from solidwhirl.rotordyn.state_space.file import read_state_space
from solidwhirl.scene_reading.reader import parse_scene

pytestmark = pytest.mark.solver


def whirl_compliance(omega):
    """Tilt per moment, in synchronous forward whirl."""
    inertia = DIAMETRAL - POLAR
    return 1.0 / (2 * ARM**2 * (STIFFNESS + 1j * DAMPING * omega) - inertia * omega**2)


UNBALANCE = [{"at": "rotor.m", "moment_kg_m": MOMENT, "phase_deg": 30.0}]
AT_PLACES = {"moment_kg_m": MOMENT, "frequency_max_hz": 150.0, "frequency_count": 60}
SWEEP = {"unbalances": UNBALANCE, "observe": ["rotor.m"], "to_rpm": 9e3, "count": 181}

# -- numbers --------------------------------------------------------------------------------------


def test_unbalance_response():
    found = outcome(rotor(), "unbalance_response", **SWEEP)["exciters"][0]
    omega = 2 * np.pi * np.array(found["frequency_hz"])
    motion = MOMENT * omega**2 * compliance(omega)
    # the speeds that are asked for, and others around the resonance
    gaps = np.abs(omega[:, None] - np.linspace(0.0, 9e3, 181) * RPM).min(axis=0)
    assert gaps.max() < 1e-9 and 181 < omega.size < 250
    place = found["places"]["rotor.m"]
    for key in ("amplitude_x_m", "amplitude_y_m", "major_m"):
        np.testing.assert_allclose(place[key], np.abs(motion), rtol=1e-9, atol=1e-20)
    phase = np.degrees(np.angle(motion[1:])) + 30.0
    np.testing.assert_allclose(place["phase_x_deg"][1:], phase, atol=1e-6)
    turned = (np.array(place["phase_x_deg"]) - place["phase_y_deg"])[1:] % 360.0
    np.testing.assert_allclose(turned, 90.0, atol=1e-6)  # y follows x a quarter later
    assert set(place["orbit"][1:]) == {"forward"}
    # the rotating force |k + i c w| u; a force that turns is no larger than its components
    wanted = np.abs((STIFFNESS + 1j * DAMPING * omega) * motion)
    for name in "AB":
        np.testing.assert_allclose(found["bearing_force_n"][name], wanted, rtol=1e-9, atol=1e-12)


def test_place_map():
    """At the place itself: translation, and tilt with the lever squared."""
    found = outcome(rotor(), "place_map", places=["rotor.m", "rotor.b"], **AT_PLACES)
    omega = 2 * np.pi * np.array(found["frequency_hz"][0])
    np.testing.assert_array_equal(*found["frequency_hz"])
    # what is asked for, and others around resonances
    assert (
        np.abs(omega[:, None] / (2 * np.pi) - np.arange(2.5, 151.0, 2.5)).min(axis=0).max() < 1e-9
    )
    np.testing.assert_allclose(np.array(found["speed_rpm"]) * RPM, omega, rtol=1e-12)
    for row, arm in zip(found["amplitude_m"], (0.0, ARM), strict=True):
        wanted = np.abs(MOMENT * omega**2 * (compliance(omega) + arm**2 * whirl_compliance(omega)))
        np.testing.assert_allclose(row, wanted, rtol=1e-9)
    most = int(np.max(found["amplitude_m"], axis=1).argmax())
    assert found["most_sensitive_place"] == ("rotor.m", "rotor.b")[most]
    # a body excites at its own speed: frequency = |ratio| speed / 60 at every peak
    places = {"rotor.m": 1.0, "fast.m": 2.0}
    found = outcome(two_rotors(), "place_map", places=list(places), **AT_PLACES)
    for place, ratio in places.items():
        assert found["peaks"][place]
        for peak in found["peaks"][place]:
            assert peak["frequency_hz"] == pytest.approx(ratio * peak["speed_rpm"] / 60.0)


@pytest.mark.parametrize("spin_rpm", [0.0, 3000.0])
def test_a_force_that_turns_at_another_speed(spin_rpm):
    """The tilt has the gyroscopic moment of the spin, whatever the frequency of the force."""
    asked = {"places": ["rotor.b"], **AT_PLACES, "speed_rpm": spin_rpm}
    found = outcome(rotor(), "place_map", **asked)
    omega = 2 * np.pi * np.array(found["frequency_hz"][0])
    support = 2 * ARM**2 * (STIFFNESS + 1j * DAMPING * omega)
    tilt = 1.0 / (support - DIAMETRAL * omega**2 + POLAR * spin_rpm * RPM * omega)
    wanted = np.abs(MOMENT * omega**2 * (compliance(omega) + ARM**2 * tilt))
    np.testing.assert_allclose(found["amplitude_m"][0], wanted, rtol=1e-9)
    unbalances = [{"at": "rotor.b", "moment_kg_m": MOMENT}]
    swept = {"unbalances": unbalances, "observe": ["rotor.b"], "to_rpm": 9e3}
    other = outcome(rotor(), "unbalance_response", **swept, speed_rpm=spin_rpm)
    peaks = found["peaks"]["rotor.b"]
    assert other["spin_rpm"] == found["spin_rpm"] == spin_rpm and peaks
    for peak, same in zip(peaks, other["exciters"][0]["peaks"]["rotor.b"], strict=True):
        assert peak["speed_rpm"] == pytest.approx(60.0 * peak["frequency_hz"])
        for key in ("frequency_hz", "amplitude_m"):
            assert peak[key] == pytest.approx(same[key], rel=1e-6)


def two_rotors():
    """Two equal rotors, the second at twice the speed and backward."""
    data = rotor()
    data["rigid_bodies"]["fast"] = {**data["rigid_bodies"]["rotor"], "speed_ratio": -2.0}
    data["bearings"] += [
        {**b, "name": b["name"] * 2, "first": b["first"].replace("rotor", "fast")}
        for b in data["bearings"]
    ]
    return data


@pytest.mark.parametrize("direction", ["x", "y"])
def test_waterfall(direction):
    """One mass on a moving ground: |k + i c w| / |k - m w^2 + i c w|, whatever the spin."""
    asked = {"observe": "rotor.m", "direction": direction, "amplitude_m": 1e-5}
    asked |= {"frequency_max_hz": 150.0, "frequency_count": 50, "to_rpm": 9e3, "speed_count": 3}
    found = outcome(rotor(), "waterfall", **asked)
    assert found["speed_rpm"] == pytest.approx([0.0, 4.5e3, 9e3])
    omega = 2 * np.pi * np.array(found["frequency_hz"])
    wanted = 1e-5 * np.abs(2 * (STIFFNESS + 1j * DAMPING * omega) * compliance(omega))
    np.testing.assert_allclose(found["amplitude_m"], [wanted] * 3, rtol=1e-9)
    # between these frequencies too
    fine = np.linspace(omega[0], omega[-1], 100_001)
    all_over = 1e-5 * np.abs(2 * (STIFFNESS + 1j * DAMPING * fine) * compliance(fine))
    highest = np.array(found["highest_m"])
    np.testing.assert_allclose(highest.max(axis=1), all_over.max(), rtol=1e-4)
    assert (highest >= wanted * (1 - 1e-12)).all()


def test_critical_speed_map():
    asked = {"bearings": ["A", "B"], "excited_by": "rotor", "search_to_rpm": 9e4, **SPAN}
    results = run(rotor(0.0), {"kind": "critical_speed_map", **asked})
    found = results.analyses["critical_speed_map"].document
    stiffness = np.array(found["stiffness_n_per_m"])
    np.testing.assert_allclose(stiffness, [1e6, 2e6, 4e6], rtol=1e-12)
    speeds = np.array(found["critical_speed_rpm"]) * RPM
    closed = [np.sqrt(2 * stiffness / MASS)]  # and tilt, synchronous in either sense
    closed += [ARM * np.sqrt(2 * stiffness / (DIAMETRAL + s * POLAR)) for s in (-1.0, 1.0)]
    for wanted in closed:
        assert np.abs(speeds / wanted - 1.0).max(axis=1).min() < 1e-9
    own = sorted(c.critical.speed_rad_s for c in results.critical_speeds)
    at_own = np.sort(speeds[:, 1])
    assert len(own) >= 2
    np.testing.assert_allclose(at_own[: len(own)], own, rtol=1e-9)


def test_stiffness_study():
    """The choice is the stiffness whose largest response within 20 % is smallest."""
    asked = {"bearings": ["A", "B"], "excite": "rotor.m", "observe": "rotor.m", **AT_PLACES, **SPAN}
    asked |= {"frequency_count": 300, "operating_speed_rpm": 5e3}
    found = outcome(rotor(), "stiffness_study", **asked)
    omega = 2 * np.pi * np.array(found["frequency_hz"])
    stiffness = np.array(found["stiffness_n_per_m"])
    wanted = np.abs(MOMENT * omega**2 * compliance(omega, stiffness[:, None]))
    np.testing.assert_allclose(found["amplitude_m"], wanted, rtol=1e-9)
    fine = np.linspace(0.8, 1.2, 20_001) * 5e3 * RPM
    best = np.abs(MOMENT * fine**2 * compliance(fine, stiffness[:, None])).max(axis=1)
    assert found["chosen_stiffness_n_per_m"] == stiffness[best.argmin()]
    assert found["chosen_amplitude_m"] == pytest.approx(best.min(), rel=1e-4)
    assert found["choice_is_at_the_end_of_the_range"] == (best.argmin() != 1)


def test_energies_of_a_body_and_a_bearing_of_one_name():
    data = rotor()
    data["bearings"][0]["name"] = "rotor"
    (found,) = outcome(data, "mode_shapes", speeds_rpm=[0.0], modes=2)["speeds"]
    parts = [*found["strain_energy_of_bodies"].values(), *found["strain_energy_of_joints"].values()]
    np.testing.assert_allclose(np.sum(parts, axis=0), 1.0)


def test_bearing_laws():
    powers = [1.0, -2e-5, 3e-9]
    law = {"kind": "polynomial", "argument_unit": "rpm", "argument_range": [0.0, 5e3]}
    law |= {"stiffness_x": powers, "stiffness_y": [1.0], "damping_x": [2.0, 1e-4]}
    data = rotor(speed_laws={"law": law})
    data["bearings"][1]["speed_law"] = "law"
    found = outcome(data, "bearing_laws", to_rpm=6e3)
    (entry,) = found["bearings"].values()
    rpm = np.array(entry["speed_of_its_rotor_rpm"])
    assert rpm[[0, -1]] == pytest.approx([0.0, 6e3])
    wanted = STIFFNESS * np.stack((np.polyval(powers[::-1], rpm), np.ones_like(rpm)), axis=1)
    np.testing.assert_allclose(entry["stiffness_n_per_m"], wanted, rtol=1e-12)
    wanted = DAMPING * np.stack((2.0 + 1e-4 * rpm, np.ones_like(rpm)), axis=1)
    np.testing.assert_allclose(entry["damping_n_s_per_m"], wanted, rtol=1e-12)
    (note,) = found["notes"]
    assert note.startswith("5000 to 6000 rpm: law 'law' covers 0 to 5000 rpm")
    assert "(bearing B)" in note


def test_unbalance_response_without_bearings(tmp_path):
    """A shaft free in space gives way to a slow force as its mass does, 7800 pi 0.03^2 kg."""
    shaft = {"material": "steel", "outer_radius_m": [0.03], "stations_m": [0.0, 0.5, 1.0]}
    shaft["interfaces"] = {"a": 0.0, "m": 0.5, "b": 1.0}
    data = {**rotor(), "bearings": [], "rigid_bodies": {}, "beams": {"rotor": shaft}}
    # 0.5 Hz against some hundred for its first bending frequency, squared
    results = run(data, {"kind": "unbalance_response", **SWEEP, "to_rpm": 30.0})
    mass = 7800.0 * np.pi * 0.03**2
    entry = results.analyses["unbalance_response"]
    (exciter,) = entry.document["exciters"]
    found = exciter["places"]["rotor.m"]["major_m"][1:]
    np.testing.assert_allclose(found, MOMENT / mass, rtol=1e-4)
    for name, write in entry.files.items():
        write(tmp_path / name)


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


@pytest.mark.verify
def test_slow_force_at_the_mount_moves_the_mass_of_the_engine(scene_data, tmp_path):
    """The engine let go at its mount, as a wing sees it."""
    data = scene_data("uhbr_engine_free")
    # a mass needs no mesh, and no estimate
    data["model"] |= {"level": "beam", "estimates": "off"}
    data["analyses"] = [a for a in data["analyses"] if a["kind"] == "state_space"]
    results = run_scene(parse_scene(data))
    results.analyses["state_space"].files["state_space.h5"](tmp_path / "engine.h5")
    model = read_state_space(tmp_path / "engine.h5")
    a, b, c, d = model.at_speed(0.0)
    omega = 2 * np.pi * 0.2
    response = c @ np.linalg.solve(1j * omega * np.eye(len(a)) - a, b) + d
    force = model.input_names.index("force casing.P.ux")
    motion = model.output_names.index("acceleration casing.P.ux")
    # Table 4 of Müller and Hennings: 2021.42 kg, P in the centre of gravity. The softest mode, at
    # 12 Hz, adds (0.2 / 12)² of a part of the mass.
    assert 1 / response[motion, force].real == pytest.approx(2021.42, rel=1e-4)
