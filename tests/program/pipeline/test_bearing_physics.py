"""Speed laws of a scene that are computed from a bearing's physics."""

from __future__ import annotations

import numpy as np
import pytest
from engine_parts import MASS, RPM, rigid_rotor
from symmetric_rotor import run

from solidwhirl.model.bearing_validity import validity_notes
from solidwhirl.model.effects import make_plan
from solidwhirl.model.system_parts import bearings
from solidwhirl.rotordyn.bearings.balls import BallBearing
from solidwhirl.rotordyn.bearings.rolling import BearingSet, RingLoad, ring_states
from solidwhirl.rotordyn.bearings.short_film import ShortFilm
from solidwhirl.rotordyn.bearings.squeeze_film import SqueezeFilmDamper
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
    """The law between the rows of its table; under this load all balls stay in contact."""
    ring = BallBearing(
        ball_count=12,
        ball_diameter_m=9.525e-3,
        pitch_diameter_m=46e-3,
        contact_angle_rad=np.radians(25.0),
    )
    load = RingLoad(load_n=(0.0, -100.0, 500.0))
    positions = 2.0 * np.pi / 12 * np.arange(8) / 8
    speeds = np.full(8, 7777.0 * RPM)
    wanted = ring_states(BearingSet(row=ring), load, speeds, positions).stiffness.mean(axis=0)
    found = at(BALLS, 7777.0).stiffness_n_per_m
    lateral = np.ix_([0, 1], [0, 1])
    np.testing.assert_allclose(found[lateral], wanted[lateral], atol=1e-4 * wanted[0, 0])
    root = np.sqrt(np.diag(wanted))
    apart = wanted.copy()
    apart[2, [0, 1, 3, 4]] = apart[[0, 1, 3, 4], 2] = 0.0
    assert (np.abs(found - apart) / np.outer(root, root)).max() < 1e-4


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
        ({**BALLS, "arrangement": "DB"}, "spacing_m has 0 distances; arrangement 'DB' of 2 rows"),
        ({**BALLS, "arrangement": "<", "spacing_m": 0.02}, "of 1 rows needs none"),
        ({**BALLS, "motions": ["ux", "uy", "rx"]}, "motions is .*; allowed is one of"),
        ({**BALLS, "contact_angle_deg": 0.0, "arrangement": ">"}, "of angular contact bearings"),
        ({**BALLS, "preload": "rigid", "load_n": [0.0, 0.0, 50.0]}, "held by a rigid preload"),
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


def test_film_around_a_ring_that_stands_still():
    """A mass in a ring: unbalance and modes have K and C of their own frequency."""
    law = {**DAMPER, "viscosity_pa_s": 1e-3}
    ring = {"mass_kg": 4.0, "center_of_gravity_m": [0.0, 0.0, 0.0],
            "inertia_kg_m2": [0.1, 0.1, 0.1], "interfaces": {"a": 0.0}}  # fmt: skip
    data = rigid_rotor(speed_laws={"film": law}, rpm=(0.0, 6000.0))
    data["rigid_bodies"]["ring"] = ring
    stiff = {"stiffness_n_per_m": 5e6, "tilt_stiffness_n_m_per_rad": 1e6}
    data["bearings"] = [
        {"name": "ball", "first": "rotor.m", "second": "ring.a", **stiff},
        {"name": "film", "first": "ring.a", "speed_law": "film"},
        {"name": "cage", "first": "ring.a", **stiff, "stiffness_n_per_m": 1e6},
    ]
    found = run(
        data,
        {"kind": "unbalance_response", "to_rpm": 6000.0, "count": 7, "observe": ["rotor.m"],
         "unbalances": [{"at": "rotor.m", "moment_kg_m": 1e-4}]},
        {"kind": "stability", "to_rpm": 6000.0, "count": 3},
    )  # fmt: skip
    film = SqueezeFilmDamper(
        film=ShortFilm(**{**OIL, "viscosity_pa_s": 1e-3}), orbit_ratio=0.3
    ).coefficients

    def dynamic(s):
        k, c = film(abs(s.imag))
        own = np.array([[5e6, -5e6], [-5e6, 6e6 + k + s * c]])
        return own + s**2 * np.diag([MASS, 4.0])

    omega = 3000.0 * RPM
    wanted = abs(np.linalg.solve(dynamic(1j * omega), [1e-4 * omega**2, 0.0])[0])
    document = found.analyses["unbalance_response"].document
    at = int(np.argmin(np.abs(np.array(document["speed_rpm"]) - 3000.0)))
    orbit = document["exciters"][0]["places"]["rotor.m"]
    assert document["speed_rpm"][at] == pytest.approx(3000.0)
    assert orbit["major_m"][at] == pytest.approx(wanted, rel=1e-9)
    lateral = [complex(v) for v in found.campbell.eigenvalues[:, 0] if np.isfinite(v)]
    sizes = [np.linalg.svd(dynamic(v), compute_uv=False)[-1] / 5e6 for v in lateral]
    assert np.count_nonzero(np.array(sizes) < 1e-8) >= 2
    assert found.analyses["stability"].document["unstable_intervals"] == []


@pytest.mark.parametrize(
    ("law", "quantities"),
    [
        ({**BALLS, "load_n": [0.0, -2.5e4, 0.0], "preload_n": 1.2e4, "highest_rpm": 3e4},
         ["contact pressure [Pa]", "speed times pitch diameter [mm/min]"]),
        ({**FILM, "length_m": 0.06, "load_n": [0.0, -3e5]},
         ["L/D of a land", "eccentricity ratio"]),
        ({**DAMPER, "orbit_ratio": 0.5, "density_kg_per_m3": 870.0, "viscosity_pa_s": 5e-3},
         ["orbit over clearance", "squeeze Reynolds number"]),
        (FILM, []),
        (DAMPER, []),
        ({**BALLS, "highest_rpm": 1e4}, []),
    ],
)  # fmt: skip
def test_use_beyond_theory_is_told_with_figure_and_limit(law, quantities):
    notes = validity_notes(scene_of(law), 2.5e4 * RPM)
    assert [note.beyond.quantity for note in notes] == quantities
    for note in notes:
        assert note.bearing == "A" and note.beyond.value > note.beyond.limit
        assert f"limit {note.beyond.limit:.3g}" in note.message
