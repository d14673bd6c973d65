"""Asymmetric bodies at rest, at some angle, under weight."""

from __future__ import annotations

import numpy as np
import pytest
from flat_rotors import flat_mass
from rotors import turning

from solidwhirl.rotordyn import Bearing, End, assemble
from solidwhirl.rotordyn.asymmetric import at_rest, standing_at
from solidwhirl.rotordyn.response.static import static_response


@pytest.mark.parametrize("ratio", [1.0, -1.0])
def test_flat_mass_under_its_weight(ratio):
    """Springs of the body turn with it, a film that holds it does not; its own mass is off axis."""
    mass, own, film = 3.0, np.diag([4e5, 9e5]), np.array([[2e5, 8e4], [-5e4, 3e5]])
    rotors = {"r": turning(flat_mass(mass, [4e5, 9e5], (2e-3, 0.0)), ratio)}
    held = Bearing(name="b", first=End(body="r", interface="hub"), stiffness_n_per_m=film)
    assembled = assemble(at_rest(rotors), (held,))
    acting = film if ratio > 0 else film * [[1.0, -1.0], [-1.0, 1.0]]
    for degrees in (0.0, 30.0, 90.0, -140.0):
        angle = np.radians(degrees)
        system = standing_at(assembled, rotors, angle)
        found = static_response(system, [0.5, -9.0, 0.0])
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        moved = np.linalg.solve(turn @ own @ turn.T + acting, mass * np.array([0.5, -9.0]))
        np.testing.assert_allclose(found.bearing_motions["b"][:2], moved, rtol=1e-12)
        element = system.system.rotors["r"].element
        centre = 2e-3 * np.array([np.cos(angle), np.sin(angle)])
        np.testing.assert_allclose(element.center_of_gravity_m[:2], centre, atol=1e-15)
