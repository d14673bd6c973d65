"""Bearings with added mass and over the frequency of the motion, against ROSS.

ROSS 2 takes one axis, at the speed of the rotor, and puts a smoothing spline through it, which is
exact for a table that is linear. So tables are linear in the speed; over the frequency ROSS gets
the values along it where the speed is the frequency, and those of one mode at a time.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from ross_shafts import STEEL, bearing, complex_of, shaft

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn import critical_speeds, modes_at_speed
from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response

pytestmark = pytest.mark.verify
ENDS = ("xx", "xy", "yx", "yy")
KNOTS = np.array([0.0, 200.0, 500.0, 900.0])
SPEEDS = [150.0, 420.0]
UNBALANCE = {
    "node": 3, "unbalance_kg_m": 1e-4, "phase_rad": 0.3,
    "speeds_rad_s": np.linspace(20.0, 800.0, 14).tolist(), "read_nodes": [0, 2, 5],
}  # fmt: skip
# K, C, M at rest, and what each of speed and frequency adds at the last knot
REST = np.array([[[2e7, 4e6], [-3e6, 3e7]], [[3e3, 5e2], [-4e2, 4e3]], [[20.0, 3.0], [-4.0, 15.0]]])
OVER_SPEED = np.array(
    [[[1e7, 5e6], [-6e6, -5e6]], [[-1e3, 2e2], [1e2, 2e3]], [[5.0, 1.0], [1.0, -4.0]]]
)
OVER_FREQUENCY = np.array(
    [[[-8e6, 2e6], [1e6, 6e6]], [[2e3, -1e2], [3e2, -1e3]], [[-6.0, 2.0], [-1.0, 5.0]]]
)


def values(speed, frequency):
    """K, C, M at a speed and a frequency, (3, 2, 2); frequencies beyond the table are its end."""
    over = min(abs(frequency), KNOTS[-1]) / KNOTS[-1]
    return REST + speed / KNOTS[-1] * OVER_SPEED + over * OVER_FREQUENCY


def case(rows, **asked):
    """The shaft on two bearings whose table ROSS reads at the speed, rows (s, 3, 2, 2)."""
    table = {
        letter + end: rows[:, k].reshape(-1, 4)[:, e].tolist()
        for k, letter in enumerate("kcm")
        for e, end in enumerate(ENDS)
    }
    held = [{"node": n, "speeds_rad_s": KNOTS.tolist(), "table": table} for n in (0, 6)]
    return {"material": STEEL, "shafts": [shaft(held)], "asked": asked}


ALONG_SPEED = np.array([values(speed, 0.0) for speed in KNOTS])
# where the frequency is the speed: what unbalance and critical speeds see
SYNCHRONOUS = np.array([values(speed, speed) for speed in KNOTS])
CASES = {
    "mass": case(
        ALONG_SPEED, modes={"speeds": SPEEDS, "count": 10}, critical=4, response=UNBALANCE
    ),
    "frequency": case(SYNCHRONOUS, critical=4, response=UNBALANCE),
}


def law(name):
    """The table as this program takes it."""
    if name == "mass":
        frequencies, rows = np.zeros(0), ALONG_SPEED
    else:
        frequencies = KNOTS
        rows = np.array([[values(speed, own) for own in KNOTS] for speed in KNOTS])
    stiffness, damping, mass = np.moveaxis(rows, -3, 0)
    return rd.FrequencyTableLaw(
        name=name, speeds_rad_s=KNOTS, frequencies_rad_s=frequencies, interpolation="linear",
        stiffness_n_per_m=stiffness, damping_n_s_per_m=damping, mass_kg=mass,
    )  # fmt: skip


@pytest.fixture
def systems(system_of):
    plain = CASES["mass"] | {"shafts": [shaft([bearing(0, 0.0), bearing(6, 0.0)])]}
    found = system_of(plain).system
    return {
        name: rd.assemble(
            found.rotors, tuple(replace(b, speed_law=law(name)) for b in found.bearings), "0"
        )
        for name in CASES
    }


@pytest.fixture(scope="module")
def ross(run_ross):
    return run_ross(CASES)


def test_modes_with_added_mass(ross, systems):
    for speed, pairs in zip(SPEEDS, ross["mass"]["modes"], strict=True):
        expected = complex_of(pairs)
        ours = modes_at_speed(systems["mass"], speed).eigenvalues
        ours = ours[ours.imag > 1.0][: expected.size]
        np.testing.assert_allclose(ours, expected, rtol=1e-9)


@pytest.mark.parametrize("name", CASES)
def test_critical_speeds(ross, systems, name):
    theirs = [value for value in ross[name]["critical"] if value < KNOTS[-1]]
    assert len(theirs) >= 3
    found = critical_speeds(systems[name], speed_max_rad_s=KNOTS[-1])
    ours = np.array([one.speed_rad_s for one in found])
    nearest = ours[np.abs(ours[:, None] - theirs).argmin(axis=0)]
    np.testing.assert_allclose(nearest, theirs, rtol=1e-8)


@pytest.mark.parametrize("name", CASES)
def test_response_to_unbalance(ross, systems, name):
    theirs = complex_of(ross[name]["response"])
    placed = [Unbalance(body="0", interface="3", moment_kg_m=1e-4, phase_rad=0.3)]
    speeds = UNBALANCE["speeds_rad_s"]
    (exciter,) = unbalance_response(systems[name], placed, speeds).exciters
    for place, node in enumerate(UNBALANCE["read_nodes"]):
        size = np.abs(theirs[:, place]).max(axis=-1, keepdims=True)
        missed = np.abs(exciter.at_node("0", f"{node}") - theirs[:, place]) / size
        assert missed.max() < 1e-9


def test_modes_over_the_frequency(run_ross, systems):
    """Every mode is one of ROSS's rotor with the coefficients of the mode's own frequency."""
    cases, wanted = {}, {}
    for speed in SPEEDS:
        found = modes_at_speed(systems["frequency"], speed).eigenvalues
        for k, own in enumerate(found[found.imag > 1.0][:6]):
            stiffness, damping, mass = values(speed, own.imag).tolist()
            held = [
                {"node": n, "stiffness": stiffness, "damping": damping, "mass": mass}
                for n in (0, 6)
            ]
            name = f"{speed} {k}"
            wanted[name] = own
            cases[name] = {
                "material": STEEL, "shafts": [shaft(held)],
                "asked": {"modes": {"speeds": [speed], "count": 20}},
            }  # fmt: skip
    for name, theirs in run_ross(cases).items():
        every = complex_of(theirs["modes"][0])
        assert np.abs(every - wanted[name]).min() < 1e-9 * abs(wanted[name]), name
