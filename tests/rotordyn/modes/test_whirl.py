"""Whirl direction from made-up orbits, where the answer is known."""

from __future__ import annotations

import numpy as np
import pytest
from rotors import ground, hub, one_rotor, steel_shaft, twin_bodies, with_axial_and_torsion

from solidwhirl.rotordyn import modes_at_speed, whirl_direction

FORWARD, BACKWARD = np.array([1.0, -1j]), np.array([1.0, 1j])
LINE = np.array([1.0, 0.5])


# A free shaft: its independent coordinates are its own.
SHAFT = twin_bodies()[0]
FREE = one_rotor(SHAFT)


def _shape(translations, tilts):
    shape = np.zeros((SHAFT.size, 1), dtype=complex)
    # The axis tip goes along (ry, −rx).
    for orbits, (first, second), sign in ((translations, "xy", 1.0), (tilts, "yx", -1.0)):
        kind = "u" if sign > 0 else "r"
        for node, orbit in orbits.items():
            shape[SHAFT.interface_index(node, kind + first)] = orbit[0]
            shape[SHAFT.interface_index(node, kind + second)] = sign * orbit[1]
    return shape


@pytest.mark.parametrize(
    ("translations", "tilts", "expected"),
    [
        ({"A": FORWARD, "B": 3 * FORWARD}, {}, "forward"),
        ({"A": BACKWARD, "B": 3j * BACKWARD}, {}, "backward"),
        ({"A": FORWARD, "B": BACKWARD}, {}, "mixed"),
        ({"A": LINE, "B": 2j * LINE}, {}, "straight"),
        ({"A": LINE, "B": FORWARD}, {}, "forward"),
        ({"A": FORWARD + 0.3 * BACKWARD, "C": LINE}, {}, "forward"),
        # An ellipse four times as long as wide, against the spin.
        ({"A": np.array([1.0, 0.25j])}, {}, "backward"),
        # An orbit below 1/100 of the largest does not count.
        ({"A": FORWARD, "B": 0.005 * BACKWARD}, {}, "forward"),
        ({"A": FORWARD, "B": 0.05 * BACKWARD}, {}, "mixed"),
        # Minor axis 1/2000 of the major one.
        ({"A": np.array([1.0, -0.0005j])}, {}, "straight"),
        # No translation at any node: the tilt decides; with translation it does not.
        ({}, {"A": FORWARD}, "forward"),
        ({}, {"A": BACKWARD, "B": 2 * BACKWARD}, "backward"),
        ({"A": FORWARD}, {"B": BACKWARD}, "forward"),
        ({}, {}, "straight"),
    ],
)
def test_direction_of_known_orbits(translations, tilts, expected):
    # whatever phase and size
    factors = np.array([1.0, 1j, -2.0, 1e-9 * np.exp(0.7j)])
    found = whirl_direction(FREE, _shape(translations, tilts) * factors)
    assert found.tolist() == [expected] * 4


def test_nutation_of_a_spinning_disk_is_forward():
    for ratio, whirl in ((1.0, "forward"), (-1.0, "backward")):
        system = one_rotor(hub(), (), ratio)
        assert whirl_direction(system, modes_at_speed(system, 50.0).shapes).tolist() == [whirl]


def test_axial_and_torsional_modes_are_named():
    ends = {"a": 0.0, "b": 1.0}
    lateral = steel_shaft("s", np.linspace(0, 1, 9), 0.03, ends)
    full = with_axial_and_torsion(lateral, 1.0, 0.03, "a", "b")
    system = one_rotor(full, [ground("rotor", end, 1e8) for end in ends])
    modes = modes_at_speed(system, 800.0)
    directions = whirl_direction(system, modes.shapes)
    rods = np.sqrt(12 * np.array([2e11 / 2.6, 2e11]) / 7800)
    at = [int(np.abs(modes.eigenvalues.imag - w).argmin()) for w in rods]
    assert directions[at].tolist() == ["torsional", "axial"]
    assert np.isin(np.delete(directions, at)[:8], ("forward", "backward")).all()
