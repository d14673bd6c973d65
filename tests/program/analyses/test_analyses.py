"""Analyses of scenes: their numbers against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from engine_parts import DIAMETRAL, MASS, RPM
from symmetric_rotor import (
    ARM,
    DAMPING,
    MOMENT,
    POLAR,
    SPAN,
    STIFFNESS,
    compliance,
    outcome,
    rotor,
    run,
)

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


def test_unbalance_peak_is_at_the_critical_speed():
    """Both are within half the damping squared of each other, 0.2 %, and one step of the sweep."""
    results = run(rotor(), {"kind": "unbalance_response", **SWEEP})
    exciter = results.analyses["unbalance_response"].document["exciters"][0]
    (peak,) = exciter["peaks"]["rotor.m"]
    critical = min(c.critical.speed_rad_s / RPM for c in results.critical_speeds)
    assert abs(peak["speed_rpm"] - critical) < 50.0
    ratio = 2 * DAMPING / (2 * np.sqrt(2 * STIFFNESS * MASS))
    # 1 / 2 zeta holds to zeta^2
    assert peak["amplification"] == pytest.approx(0.5 / ratio, rel=0.03)


def test_peaks_of_rounding_are_none():
    """A couple of unbalances tilts the rotor: its middle stands still but for rounding."""
    couple = [
        {"at": "rotor.a", "moment_kg_m": MOMENT},
        {"at": "rotor.b", "moment_kg_m": MOMENT, "phase_deg": 180.0},
    ]
    spec = {**SWEEP, "unbalances": couple, "observe": ["rotor.m", "rotor.a"], "to_rpm": 2e4}
    found = outcome(rotor(), "unbalance_response", **spec)["exciters"][0]
    assert found["peaks"]["rotor.m"] == []
    assert 0.0 < np.max(found["places"]["rotor.m"]["major_m"]) < 1e-15
    (tilt,) = found["peaks"]["rotor.a"]
    natural = np.sqrt(2 * ARM**2 * STIFFNESS / (DIAMETRAL - POLAR))
    ratio = ARM**2 * DAMPING / ((DIAMETRAL - POLAR) * natural)
    highest = natural / np.sqrt(1 - 2 * ratio**2)
    assert tilt["frequency_hz"] == pytest.approx(highest / (2 * np.pi), rel=1e-4)


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


def test_peaks_of_a_place_map_seen_elsewhere_have_estimates():
    asked = {"places": ["rotor.m", "rotor.a"], "observe": "rotor.b", **AT_PLACES}
    found = outcome(rotor(), "place_map", **asked)
    for place, arm in (("rotor.m", 0.0), ("rotor.a", -ARM)):
        assert found["peaks"][place]
        for peak in found["peaks"][place]:
            near = 2 * np.pi * peak["frequency_hz"] * (1 + np.linspace(-1e-4, 1e-4, 2001))
            curve = near**2 * (compliance(near) + arm * ARM * whirl_compliance(near))
            off = abs(peak["amplitude_m"] / (MOMENT * np.abs(curve).max()) - 1)
            assert off <= peak["amplitude_error_estimate"] + 1e-9


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
    found = outcome(
        rotor(),
        "waterfall",
        observe="rotor.m",
        direction=direction,
        amplitude_m=1e-5,
        frequency_max_hz=150.0,
        frequency_count=50,
        to_rpm=9e3,
        speed_count=3,
    )
    assert found["speed_rpm"] == pytest.approx([0.0, 4.5e3, 9e3])
    omega = 2 * np.pi * np.array(found["frequency_hz"])
    wanted = 1e-5 * np.abs(2 * (STIFFNESS + 1j * DAMPING * omega) * compliance(omega))
    np.testing.assert_allclose(found["amplitude_m"], [wanted] * 3, rtol=1e-9)
    # between these frequencies too
    fine = np.linspace(omega[0], omega[-1], 100_001)
    all_over = 1e-5 * np.abs(2 * (STIFFNESS + 1j * DAMPING * fine) * compliance(fine))
    highest = np.array(found["highest_m"])
    np.testing.assert_allclose(highest.max(axis=1), all_over.max(), rtol=1e-4)
    for peak in found["peaks"]:
        near = 2 * np.pi * peak["frequency_hz"] * (1 + np.linspace(-1e-4, 1e-4, 2001))
        curve = 1e-5 * np.abs(2 * (STIFFNESS + 1j * DAMPING * near) * compliance(near))
        off = abs(peak["amplitude_m"] / curve.max() - 1)
        assert off <= peak["sampling_error_estimate"] + 1e-9
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
    found = outcome(
        rotor(),
        "stiffness_study",
        bearings=["A", "B"],
        excite="rotor.m",
        observe="rotor.m",
        moment_kg_m=MOMENT,
        frequency_max_hz=150.0,
        frequency_count=300,
        operating_speed_rpm=5e3,
        **SPAN,
    )
    omega = 2 * np.pi * np.array(found["frequency_hz"])
    stiffness = np.array(found["stiffness_n_per_m"])
    wanted = np.abs(MOMENT * omega**2 * compliance(omega, stiffness[:, None]))
    np.testing.assert_allclose(found["amplitude_m"], wanted, rtol=1e-9)
    fine = np.linspace(0.8, 1.2, 20_001) * 5e3 * RPM
    best = np.abs(MOMENT * fine**2 * compliance(fine, stiffness[:, None])).max(axis=1)
    assert found["chosen_stiffness_n_per_m"] == stiffness[best.argmin()]
    assert found["chosen_amplitude_m"] == pytest.approx(best.min(), rel=1e-4)
    assert found["choice_is_at_the_end_of_the_range"] == (best.argmin() != 1)


def test_rotating_campbell():
    """A whirl forward at w is seen at |w - n W|, one backward at w + n W."""
    data = two_rotors()
    results = run(data, {"kind": "rotating_campbell", "bodies": ["rotor", "fast"]})
    found = results.analyses["rotating_campbell"].document
    inertial = results.campbell.frequency_hz
    turn = results.campbell.speeds_rad_s / (2 * np.pi)
    for body, ratio in (("rotor", 1.0), ("fast", -2.0)):
        frame = found["bodies"][body]
        assert frame["speed_ratio"] == ratio
        for order in (1, -1):
            seen = frame["frequency_hz"][frame["orders"].index(order)]
            np.testing.assert_allclose(seen, np.abs(inertial - order * ratio * turn), atol=1e-9)
        total = np.nansum(frame["share"], axis=0)[:, -1]  # none where the body stands still
        assert np.minimum(total, np.abs(total - 1.0)).max() < 1e-9
    assert found["speed_rpm"] == pytest.approx([0.0, 9e3])


def test_mode_shapes_of_a_rotor_on_a_casing():
    """Two masses in a row; shares of kinetic and strain energy from 2×2 eigenvectors."""
    data = rotor(0.0)
    casing = {**data["rigid_bodies"]["rotor"], "speed_ratio": 0.0, "mass_kg": 30.0}
    data["rigid_bodies"]["casing"] = casing
    for bearing, z in zip(data["bearings"], "ab", strict=True):
        bearing["second"] = f"casing.{z}"
    data["bearings"] += [
        {"name": f"mount_{z}", "first": f"casing.{z}", "stiffness_n_per_m": 5e6} for z in "ab"
    ]
    (found,) = outcome(data, "mode_shapes", speeds_rpm=[0.0], modes=8)["speeds"]
    values, shapes = np.linalg.eig(
        np.diag([1 / MASS, 1 / 30.0]) @ np.array([[4e6, -4e6], [-4e6, 14e6]])
    )
    for value, shape in zip(values, shapes.T, strict=True):
        at = np.abs(2 * np.pi * np.array(found["frequency_hz"]) / np.sqrt(value) - 1.0).argmin()
        assert 2 * np.pi * found["frequency_hz"][at] == pytest.approx(np.sqrt(value), rel=1e-9)
        kinetic = np.array([MASS, 30.0]) * shape**2
        strain = np.array([4e6 * (shape[0] - shape[1]) ** 2, 10e6 * shape[1] ** 2])
        kinetic, strain = kinetic / kinetic.sum(), strain / strain.sum()
        assert found["kinetic_energy"]["casing"][at] == pytest.approx(kinetic[1], rel=1e-7)
        joints = found["strain_energy_of_joints"]
        assert joints["A"][at] == pytest.approx(strain[0] / 2, rel=1e-7)
        assert joints["mount_b"][at] == pytest.approx(strain[1] / 2, rel=1e-7)


def test_energies_of_a_body_and_a_bearing_of_one_name():
    data = rotor()
    data["bearings"][0]["name"] = "rotor"
    (found,) = outcome(data, "mode_shapes", speeds_rpm=[0.0], modes=2)["speeds"]
    parts = [*found["strain_energy_of_bodies"].values(), *found["strain_energy_of_joints"].values()]
    np.testing.assert_allclose(np.sum(parts, axis=0), 1.0)


def test_separation_margins():
    """Translation below the range, backward tilt inside, forward tilt above."""
    operating = {"shaft": "rotor", "from_rpm": 8e3, "to_rpm": 9e3}
    results = run(
        rotor(rpm=(0.0, 2e4)),
        {"kind": "separation_margins", "operating": [operating], "search_factor": 2e4 / 9e3},
    )
    rows = results.analyses["separation_margins"].document["margins"]
    wanted = sorted(c.critical.speed_rad_s / RPM for c in results.critical_speeds)
    assert [r["critical_speed_rpm"] for r in rows] == pytest.approx(wanted, rel=1e-9)
    assert {r["position"] for r in rows} == {"below", "inside", "above"}
    for row in rows:
        edge, more = {"below": (8e3, 0.0), "above": (9e3, 0.1)}.get(row["position"], (None, 0.0))
        margin = row["critical_speed_rpm"] / edge - 1.0 if edge else 0.0
        assert row["margin"] == pytest.approx(margin, rel=1e-9)
        assert row["verdict_15_percent"] == ("ok" if abs(margin) >= 0.15 else "inside margin")
        assert row["verdict_20_percent"] == ("ok" if abs(margin) >= 0.20 else "inside margin")
        # the formulas of API 617 below and above, none outside a range
        required = more + 0.17 * (1.0 - 1.0 / (row["amplification_factor"] - 1.5))
        if row["amplification_factor"] > 2.5:
            wanted_617 = required if edge else math.inf
            assert row["required_api_617"] == pytest.approx(wanted_617, rel=1e-9)
    factors = [2 * np.pi / (2 * c.critical.log_decrement) for c in results.critical_speeds]
    found = [r["amplification_factor"] for r in rows]
    # AF = 1 / 2 zeta is pi / delta to zeta^2 / 2
    np.testing.assert_allclose(found, factors, rtol=0.03)


def test_stability_of_a_damped_rotor():
    """At rest delta = 2 pi zeta / sqrt(1 - zeta^2), the smaller of translation and tilt."""
    found = outcome(rotor(), "stability", to_rpm=9e3, count=7)
    inertia = np.array([MASS, DIAMETRAL / ARM**2])
    zeta = 2 * DAMPING / (2 * np.sqrt(2 * STIFFNESS * inertia))
    wanted = min(2 * np.pi * zeta / np.sqrt(1 - zeta**2))
    assert found["smallest_log_decrement"][0] == pytest.approx(wanted, rel=1e-9)
    assert found["threshold"] is None
    assert found["growing_motions"] == [0] * 7
    assert np.all(np.array(found["largest_growth_rate_per_s"]) < 0.0)


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


# -- any number of bearings ------------------------------------------------------------------------


def test_unbalance_response_with_many_bearings(tmp_path):
    """Two as well as eight of a quarter of the stiffness each."""
    data = rotor()
    for bearing in data["bearings"][:2] * 3:
        data["bearings"].append({**bearing, "name": f"more_{len(data['bearings'])}"})
    for bearing in data["bearings"]:
        bearing |= {"stiffness_n_per_m": STIFFNESS / 4, "damping_n_s_per_m": DAMPING / 4}
    results = run(data, {"kind": "unbalance_response", **SWEEP})
    check_response(results.analyses["unbalance_response"], compliance, tmp_path)


def test_unbalance_response_without_bearings(tmp_path):
    """A shaft free in space gives way to a slow force as its mass does, 7800 pi 0.03^2 kg."""
    shaft = {"material": "steel", "outer_radius_m": [0.03], "stations_m": [0.0, 0.5, 1.0]}
    shaft["interfaces"] = {"a": 0.0, "m": 0.5, "b": 1.0}
    data = {**rotor(), "bearings": [], "rigid_bodies": {}, "beams": {"rotor": shaft}}
    # 0.5 Hz against some hundred for its first bending frequency, squared
    results = run(data, {"kind": "unbalance_response", **SWEEP, "to_rpm": 30.0})
    mass = 7800.0 * np.pi * 0.03**2
    entry = results.analyses["unbalance_response"]
    check_response(entry, lambda omega: 1.0 / (mass * omega**2), tmp_path, 1e-4)


def check_response(entry, wanted, folder, tolerance=1e-9):
    (exciter,) = entry.document["exciters"]
    omega = 2 * np.pi * np.array(exciter["frequency_hz"][1:])
    found = exciter["places"]["rotor.m"]["major_m"][1:]
    np.testing.assert_allclose(found, MOMENT * omega**2 * np.abs(wanted(omega)), rtol=tolerance)
    for name, write in entry.files.items():
        write(folder / name)
