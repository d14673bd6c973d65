"""Speed laws of a scene that are computed from a bearing's physics."""

from __future__ import annotations

import numpy as np
import pytest
from engine_parts import RPM, rigid_rotor

from solidwhirl.model.effects import make_plan
from solidwhirl.model.system_parts import bearings
from solidwhirl.rotordyn.bearings.balls import BallBearing
from solidwhirl.rotordyn.bearings.rolling import loaded_ring
from solidwhirl.scene_reading.reader import SceneError, parse_scene

OIL = {"diameter_m": 0.1, "length_m": 0.03, "radial_clearance_m": 1e-4, "viscosity_pa_s": 0.1}
BALLS = {
    "kind": "rolling",
    "count": 12,
    "element_diameter_m": 9.525e-3,
    "pitch_diameter_m": 46e-3,
    "contact_angle_deg": 25.0,
    "load_n": [0.0, -100.0, 0.0],
    "preload_n": 500.0,
    "highest_rpm": 20000.0,
}
FILM = {"kind": "short_bearing", **OIL, "load_n": [0.0, -525.0], "speed_rpm": [300.0, 6000.0]}
DAMPER = {"kind": "squeeze_film", **OIL, "orbit_ratio": 0.3, "highest_rpm": 12000.0}


def scene_of(law, ratio=1.0):
    data = rigid_rotor(speed_laws={"law": law})
    data["bearings"][0] = {"name": "A", "first": "rotor.a", "speed_law": "law"}
    data["rigid_bodies"]["rotor"]["speed_ratio"] = ratio
    return parse_scene(data)


def at(law, rpm):
    scene = scene_of(law)
    first = bearings(scene, make_plan(scene, {}))[0]
    return first.speed_law.coefficients(rpm * RPM, np.zeros((2, 2)), np.zeros((2, 2)))


def test_rolling_bearing():
    ring = BallBearing(
        ball_count=12,
        ball_diameter_m=9.525e-3,
        pitch_diameter_m=46e-3,
        contact_angle_rad=np.radians(25.0),
    )
    exact = loaded_ring(ring, (0.0, -100.0, 500.0), speed_rad_s=7777.0 * RPM)
    found = at(BALLS, 7777.0).stiffness_n_per_m
    wanted = exact.lateral_stiffness_n_per_m
    np.testing.assert_allclose(found, wanted, atol=1e-4 * wanted.max())


def test_short_bearing_as_printed():
    """Friswell et al. (2010), section 5.5.1, at 1500 rpm."""
    found = at(FILM, 1500.0)
    wanted = np.array([[12.8080, 16.3936], [-25.0604, 8.8153]]) * 1e6
    np.testing.assert_allclose(found.stiffness_n_per_m, wanted, atol=1e-4 * 25.06e6)


def test_squeeze_film():
    found = at(DAMPER, 1000.0 / RPM)
    np.testing.assert_allclose(found.stiffness_n_per_m, 97.814e6 * np.eye(2), rtol=1e-5)
    np.testing.assert_allclose(found.damping_n_s_per_m, 244282 * np.eye(2), rtol=1e-5)


@pytest.mark.parametrize(
    ("law", "message"),
    [
        ({**FILM, "radial_clearance_m": -1e-4}, "radial_clearance_m"),
        ({**FILM, "load_n": [0.0, -1e9]}, "cannot be carried at"),
        ({**FILM, "speed_rpm": [300.0, 200.0]}, "the second must be higher"),
        ({**BALLS, "load_n": [0.0, -100.0, -600.0]}, "cannot be carried: a loaded ball leaves"),
        ({**BALLS, "elements": "rollers"}, "rollers need roller_length_m"),
        ({**DAMPER, "orbit_ratio": 1.0}, "orbit_ratio"),
    ],
)
def test_bad_input_has_one_clear_message(law, message):
    with pytest.raises(SceneError, match=message) as caught:
        scene_of(law)
    assert "speed_laws.law" in str(caught.value)


def test_oblique_load_under_a_shaft_that_turns_backward_is_refused():
    with pytest.raises(SceneError, match="for a load_n along x or y only"):
        scene_of({**FILM, "load_n": [300.0, -525.0]}, ratio=-1.0)
