"""Runs of small scenes at the beam level, which take milliseconds."""

from __future__ import annotations

from pathlib import Path

import pytest

from solidwhirl.build import beam, bearing, disk
from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import parse_scene, read_scene

SCENES = Path(__file__).parents[2] / "scenes"


def beam_scene(name, **changes):
    """A scene of the program at the beam level, without error estimates."""
    scene = read_scene(SCENES / f"{name}.toml")
    model = scene.model.model_copy(update={"level": "beam", "estimates": "off"})
    return scene.model_copy(update={"model": model, **changes})


@pytest.fixture(scope="session")
def laval():
    return run_scene(beam_scene("laval"))


@pytest.fixture(scope="session")
def twin():
    return run_scene(beam_scene("ferraris", analyses=()))


WHEEL = disk("wheel", mass_kg=8.0, polar=0.04, diametral=0.02, at_m=0.2)
SOFT = {"stiffness_n_per_m": 1e7}
GEARED = {
    "name": "geared",
    "materials": {
        "m": {"density_kg_per_m3": 7800.0, "youngs_modulus_pa": 2e11, "poissons_ratio": 0.3}
    },
    "speeds": {"from_rpm": 0, "to_rpm": 3000, "count": 3},
    "campbell": {"branches": 4},
    "beams": {
        "slow": beam(
            [0.0, 0.5],
            0.02,
            {"front": 0.1, "seat": 0.5},
            material="m",
            speed_ratio=0.5,
            disks=[WHEEL],
        ),
        "fast": beam(
            [0.55, 0.8, 1.2],
            [0.03, 0.02],
            {"seat": 0.55, "rear": 1.1},
            material="m",
            inner_radius_m=[0.01],
        ),
    },
    "rigid_bodies": {
        "casing": {
            "mass_kg": 50.0,
            "center_of_gravity_m": [0.0, 0.0, 0.6],
            "inertia_kg_m2": [5.0, 5.0, 4.0],
            "interfaces": {"front": 0.1, "middle": 0.55, "rear": 1.1},
        }
    },
    "bearings": [
        bearing("b1", "slow.front", "casing.front", tilt_stiffness_n_m_per_rad=1e4, **SOFT),
        bearing("b2", "slow.seat", "casing.middle", **SOFT),
        bearing("b3", "fast.seat", "casing.middle", **SOFT),
        bearing("b4", "fast.rear", "casing.rear", **SOFT),
        bearing("mount", "casing.middle", rigid=["ux", "uy", "uz", "rx", "ry", "rz"]),
    ],
    "gears": [{"name": "gear", "first": "fast.seat", "second": "slow.seat", "ratio": 0.5}],
    "model": {"estimates": "off"},
}


@pytest.fixture(scope="session")
def geared():
    return run_scene(parse_scene(GEARED))
