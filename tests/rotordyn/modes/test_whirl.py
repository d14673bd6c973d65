"""Whirl direction from made-up orbits, where the answer is known."""

from __future__ import annotations

import numpy as np
import pytest
from rotors import ground, hub, one_rotor, twin_bodies, with_axial_and_torsion

from solidwhirl.rotordyn import beam_superelement, modes_at_speed, whirl_direction

FORWARD, BACKWARD = np.array([1.0, -1j]), np.array([1.0, 1j])
LINE = np.array([1.0, 0.5])


@pytest.fixture
def shaft():
    """A free shaft: its independent coordinates are its own."""
    element = twin_bodies()[0]
    return element, one_rotor(element, [])


def _shape(element, translations, tilts=None):
    shape = np.zeros((element.size, 1), dtype=complex)
    for node, orbit in translations.items():
        for component, value in zip(("ux", "uy"), orbit, strict=True):
            shape[element.interface_index(node, component)] = value
    for node, orbit in (tilts or {}).items():
        # The axis tip goes along (ry, −rx).
        shape[element.interface_index(node, "ry")] = orbit[0]
        shape[element.interface_index(node, "rx")] = -orbit[1]
    return shape


@pytest.mark.parametrize(
    ("translations", "tilts", "expected"),
    [
        ({"A": FORWARD, "B": 3 * FORWARD}, {}, "forward"),
        ({"A": BACKWARD, "B": 3j * BACKWARD}, {}, "backward"),
        ({"A": FORWARD, "B": BACKWARD}, {}, "mixed"),
        ({"A": LINE, "B": 2j * LINE}, {}, "planar"),
        ({"A": LINE, "B": FORWARD}, {}, "forward"),
        # An ellipse four times as long as wide, against the spin.
        ({"A": np.array([1.0, 0.25j])}, {}, "backward"),
        # An orbit below 1/100 of the largest does not count.
        ({"A": FORWARD, "B": 0.005 * BACKWARD}, {}, "forward"),
        ({"A": FORWARD, "B": 0.05 * BACKWARD}, {}, "mixed"),
        # Minor axis 1/2000 of the major one.
        ({"A": np.array([1.0, -0.0005j])}, {}, "planar"),
        # No translation at any node: the tilt decides; with translation it does not.
        ({}, {"A": FORWARD}, "forward"),
        ({}, {"A": BACKWARD, "B": 2 * BACKWARD}, "backward"),
        ({"A": FORWARD}, {"B": BACKWARD}, "forward"),
        ({}, {}, "planar"),
    ],
)
def test_direction_of_known_orbits(shaft, translations, tilts, expected):
    element, system = shaft
    assert whirl_direction(system, _shape(element, translations, tilts)).tolist() == [expected]


def test_direction_does_not_depend_on_phase_or_size(shaft):
    element, system = shaft
    shape = _shape(element, {"A": FORWARD + 0.3 * BACKWARD, "C": LINE})
    factors = np.array([1.0, 1j, -2.0, 1e-9 * np.exp(0.7j)])
    assert (whirl_direction(system, shape * factors) == "forward").all()


def test_nutation_of_a_spinning_disk_is_forward():
    system = one_rotor(hub(), [])
    assert whirl_direction(system, modes_at_speed(system, 50.0).shapes).tolist() == ["forward"]
    turned = one_rotor(hub(), [], ratio=-1.0)
    assert whirl_direction(turned, modes_at_speed(turned, 50.0).shapes).tolist() == ["backward"]


def test_axial_and_torsional_modes_are_planar():
    ends = {"a": 0.0, "b": 1.0}
    lateral = beam_superelement("s", np.linspace(0, 1, 9), 0.03, 0.0, (2e11, 0.3, 7800.0), ends)
    full = with_axial_and_torsion(lateral, 1.0, 0.03, "a", "b")
    system = one_rotor(full, [ground("rotor", end, 1e8) for end in ends])
    modes = modes_at_speed(system, 800.0)
    directions = whirl_direction(system, modes.shapes)
    rods = np.sqrt(12 * np.array([2e11 / 2.6, 2e11]) / 7800)
    at = [int(np.abs(modes.eigenvalues.imag - w).argmin()) for w in rods]
    assert directions[at].tolist() == ["planar", "planar"]
    assert (np.delete(directions, at)[:8] != "planar").all()
