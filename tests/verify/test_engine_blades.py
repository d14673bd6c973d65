"""The low pressure unit of the engine with blades: three rows on one drum, of unlike counts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import load_toml, parse_scene

pytestmark = [pytest.mark.verify, pytest.mark.solver]

SCENES = Path(__file__).resolve().parents[2] / "scenes"
# Titanium of the program.
YOUNGS, DENSITY = 1.138e11, 4430.0


def tapered_cantilever_hz(length, roots_thickness, tips_thickness):
    """First bending frequency of a plate of linear thickness, by Ritz with x², x³, ...

    Euler-Bernoulli: E t³ / 12 against rho t, both of unit chord.
    """
    x, weight = np.polynomial.legendre.leggauss(40)
    x, weight = 0.5 * (x + 1.0), 0.5 * weight
    thickness = roots_thickness + (tips_thickness - roots_thickness) * x
    power = np.arange(2, 9)[:, None]
    bend = power * (power - 1) * x ** (power - 2)
    stiffness = (bend * weight * YOUNGS * thickness**3 / 12.0) @ bend.T / length**3
    mass = (x**power * weight * DENSITY * thickness) @ (x**power).T * length
    return float(np.sqrt(eigh(stiffness, mass, eigvals_only=True)[0]) / (2.0 * np.pi))


@pytest.fixture(scope="module")
def unit():
    """The unit on its bearings to the ground, at rest."""
    data = load_toml(SCENES / "uhbr_engine_bladed.toml")
    bearings = [
        {"name": b["name"], "first": b["first"], "stiffness_n_per_m": b["stiffness_n_per_m"]}
        for b in data["bearings"]
        if b["first"].startswith("lp.")
    ]
    return {
        "name": "lp",
        "model": data["model"] | {"estimates": "off"},
        "speeds": {"to_rpm": 0},
        "campbell": {"frequency_max_hz": 120},
        "bodies": {"lp": data["bodies"]["lp"] | {"speed_ratio": 1.0}},
        "bearings": bearings,
    }


def test_rows_of_a_drum_have_modes_of_their_blades(unit):
    """Each compressor row has a mode with one nodal diameter where its clamped blade has it."""
    found = run_scene(parse_scene(unit)).at_rest.frequency_hz
    rows = [b for b in unit["bodies"]["lp"]["blades"] if b["name"].startswith("lpc")]
    assert len({row["count"] for row in rows}) == len(rows) == 3
    for row in rows:
        clamped = tapered_cantilever_hz(row["length_m"], *row["thickness_m"])
        assert np.abs(found / clamped - 1.0).min() < 0.015
