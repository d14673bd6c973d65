"""A rigid spindle on rolling bearings, against its five motions written out in numpy."""

from __future__ import annotations

import numpy as np
import pytest

from solidwhirl.output.documents import results_document
from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import SceneError, parse_scene

RPM = np.pi / 30.0
MASS, ACROSS, POLAR = 20.0, 0.4, 0.1
PLACES = {"front": -0.1, "rear": 0.15}
PAIR = {
    "kind": "rolling",
    "count": 16,
    "element_diameter_m": 9e-3,
    "pitch_diameter_m": 65e-3,
    "contact_angle_deg": 18.0,
    "arrangement": "DB",
    "spacing_m": 0.016,
    "load_n": [0.0, 0.0, 0.0],
    "preload_n": 300.0,
    "preload": "rigid",
    "highest_rpm": 16000.0,
}
REAR = {**PAIR, "arrangement": ">", "preload": "spring", "motions": ["ux", "uy", "rx", "ry"]}
del REAR["spacing_m"]


def scene(laws, analyses=(), **more):
    return parse_scene(
        {
            "name": "spindle",
            "speeds": {"list_rpm": [0.0, 9000.0, 16000.0]},
            "campbell": {"branches": 5},
            "rigid_bodies": {
                "rotor": {
                    "speed_ratio": 1.0,
                    "mass_kg": MASS,
                    "center_of_gravity_m": [0.0, 0.0, 0.0],
                    "inertia_kg_m2": [ACROSS, ACROSS, POLAR],
                    "interfaces": PLACES,
                }
            },
            "speed_laws": laws,
            "bearings": [
                {"name": name, "first": f"rotor.{name}", "speed_law": name, **more.get(name, {})}
                for name in PLACES
            ],
            "analyses": list(analyses),
        }
    )


def frequencies(found, speed):
    """Frequencies [Hz] on ux, uy, uz, rx, ry of the centre of gravity at a speed."""
    stiffness = np.zeros((5, 5))
    for name, z in PLACES.items():
        law = found.speed_laws[name]
        table = law.ring_table()
        at = int(np.argmin(np.abs(table.speeds_rad_s - speed)))
        assert table.speeds_rad_s[at] == pytest.approx(speed, abs=1e-9)
        k = table.stiffness[at].copy()
        k[2, [0, 1, 3, 4]] = k[[0, 1, 3, 4], 2] = 0.0
        if "uz" not in law.motions:
            k[2, 2] = 0.0
        seat = np.eye(5)
        seat[0, 4], seat[1, 3] = z, -z
        stiffness += seat.T @ k @ seat
    mass = np.diag([MASS, MASS, MASS, ACROSS, ACROSS])
    turning = np.zeros((5, 5))
    turning[3, 4], turning[4, 3] = speed * POLAR, -speed * POLAR
    inverse = np.linalg.inv(mass)
    first = np.block([[np.zeros((5, 5)), np.eye(5)], [-inverse @ stiffness, -inverse @ turning]])
    values = np.linalg.eigvals(first)
    return np.sort(values.imag[values.imag > 0]) / (2.0 * np.pi)


@pytest.mark.parametrize("load", [[0.0, 0.0, 0.0], [120.0, 90.0, 0.0]])
def test_modes_of_a_spindle(load):
    """Round without a lateral load, solved in complex form; unlike in x and y with one."""
    laws = {"front": {**PAIR, "load_n": load}, "rear": REAR}
    own = scene(laws)
    document = results_document(run_scene(own))
    assert not [c for c in document["invariants"] if c["passed"] is False]
    diagram = document["campbell"]
    for at, rpm in ((0, 0.0), (2, 16000.0)):
        found = np.sort([branch[at] for branch in diagram["frequency_hz"]])
        np.testing.assert_allclose(found, frequencies(own, rpm * RPM), rtol=1e-9)


def test_laws_tell_tilt_axial_stiffness_and_range():
    groove = {**PAIR, "count": 9, "contact_angle_deg": 0.0, "radial_clearance_m": 8e-6,
              "load_n": [0.0, -400.0, 0.0], "preload_n": 0.0, "preload": "spring",
              "arrangement": "<", "spacing_m": []}  # fmt: skip
    found = run_scene(
        scene({"front": groove, "rear": PAIR}, [{"kind": "bearing_laws", "to_rpm": 16000.0}])
    )
    own = results_document(found)["analyses"]["bearing_laws"]["bearings"]
    for name, law in found.scene.speed_laws.items():
        table = law.ring_table()
        assert own[name]["axial_stiffness_n_per_m"][0] == pytest.approx(table.stiffness[0, 2, 2])
        assert own[name]["tilt_stiffness_n_m_per_rad"][-1] == pytest.approx(
            np.diag(table.stiffness[-1])[3:]
        )
        assert own[name]["least_stiffness_n_per_m"][0] == pytest.approx(table.least[0, :2])
    low, high = (own["front"][f"{key}_stiffness_n_per_m"][0] for key in ("least", "most"))
    assert low[0] < 0.9 * own["front"]["stiffness_n_per_m"][0][0] < 0.9 * high[0]


def test_what_the_law_holds_is_given_once():
    laws = {"front": PAIR, "rear": REAR}
    with pytest.raises(SceneError, match="axial_stiffness_n_per_m: the law 'front' holds uz too"):
        scene(laws, front={"axial_stiffness_n_per_m": 1e6})
    scene(laws, rear={"axial_stiffness_n_per_m": 1e6})
    with pytest.raises(SceneError, match="tilt_stiffness_n_m_per_rad: the law 'rear' holds rx too"):
        scene(laws, rear={"tilt_stiffness_n_m_per_rad": 1e3})
