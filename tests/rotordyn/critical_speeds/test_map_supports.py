"""Critical speed maps of bearings with tables and cross-coupling."""

from __future__ import annotations

import numpy as np
import pytest
from rotors import connect, one_rotor, steel_shaft, table_law

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.critical_speeds.map import critical_speed_map
from solidwhirl.rotordyn.critical_speeds.map_supports import support_stiffness

STIFFNESSES = np.geomspace(1e6, 1e9, 7)
SPEEDS = np.array([0.0, 300.0, 900.0])


def _machine(film, seal=None):
    ends = {"a": 0.0, "m": 0.4, "b": 0.8}
    shaft = steel_shaft("rotor", np.linspace(0.0, 0.8, 7), 0.03, ends, [(0.4, 40.0, 0.5, 0.3)])
    bearings = [
        rd.Bearing(name=end, first=rd.End(body="rotor", interface=end), **film) for end in "ab"
    ]
    more = [connect("seal", "rotor.m", None, **seal)] if seal else []
    return one_rotor(shaft, [*bearings, *more])


def _tables():
    stiffness = np.array([[[2e7, k], [-k, 6e7]] for k in (1e6, 4e6, 8e6)])
    damping = np.array([[[3e4, 0.0], [0.0, 4e4]]] * 3)
    return {"speed_law": table_law(SPEEDS, stiffness, damping)}


def test_map_replaces_tables():
    """The map with films by tables is that with constant springs in their place."""
    film = _machine(_tables())
    plain = _machine({"stiffness_n_per_m": 1e7 * np.eye(2)})
    found, right = (
        critical_speed_map(s, ["a", "b"], STIFFNESSES, branch_count=3, speed_max_rad_s=1500.0)
        for s in (film, plain)
    )
    np.testing.assert_allclose(found.speed_rad_s, right.speed_rad_s, rtol=1e-9)
    np.testing.assert_allclose(found.rigid_rad_s, right.rigid_rad_s, rtol=1e-12)


def test_other_bearings_count_by_their_symmetric_stiffness():
    """A seal with cross-coupling, which is not varied, is one without."""
    spring = {"stiffness_n_per_m": 1e7 * np.eye(2)}
    skew = np.array([[2e6, 7e5], [-3e5, 1e6]])
    coupled = _machine(spring, {"stiffness": skew, "damping": 500.0 * np.eye(2)})
    even = _machine(spring, {"stiffness": 0.5 * (skew + skew.T)})
    found, right = (
        critical_speed_map(s, ["a", "b"], STIFFNESSES, branch_count=3, speed_max_rad_s=1500.0)
        for s in (coupled, even)
    )
    np.testing.assert_allclose(found.speed_rad_s, right.speed_rad_s, rtol=1e-9)


def test_support_stiffness_is_the_force_of_a_circle():
    """Kxx and Kyy of the table; the part of the force that turns with a forward circle."""
    film = _machine(_tables())
    found = support_stiffness(film, "a", SPEEDS)
    np.testing.assert_allclose(found.kxx_n_per_m, 2e7)
    np.testing.assert_allclose(found.kyy_n_per_m, 6e7)
    time = np.linspace(0.0, 2.0 * np.pi / 900.0, 64, endpoint=False)
    turn = np.exp(900.0j * time)
    x, y = turn.real, turn.imag
    vx, vy = (900.0j * turn).real, (900.0j * turn).imag
    force = 2e7 * x + 8e6 * y + 3e4 * vx + 1j * (-8e6 * x + 6e7 * y + 4e4 * vy)
    assert found.effective_n_per_m[2] == pytest.approx(abs((force / turn).mean()), rel=1e-9)
