"""Shifts that the general eigenproblem is solved from."""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.core.dense import scale_by_stiffness, solve_general


def test_signs_of_rounding_leave_a_shift():
    """A soft pair counted as negative, which over the mass it is not, gives the same roots."""
    mass, rates = np.diag([2.0, 2.0, 1.0, 1.0]), np.array([30.0, 40.0, 5e3, 6e3])
    stiffness = mass * rates**2
    velocity = np.zeros((4, 4))
    velocity[2, 3], velocity[3, 2] = 7.0, -7.0
    scaled = scale_by_stiffness(stiffness, mass)
    assert scaled.is_definite
    found = solve_general(scaled._replace(negative_count=2), stiffness, velocity, 4)
    np.testing.assert_allclose(found.eigenvalues.imag[:2], rates[:2], rtol=1e-12)
    # (k3 − ω² m)(k4 − ω² m) = (7 ω)²
    fast = np.roots(
        [1.0, 0.0, -(rates[2] ** 2 + rates[3] ** 2 + 49.0), 0.0, np.prod(rates[2:]) ** 2]
    )
    np.testing.assert_allclose(found.eigenvalues.imag[2:], np.sort(fast[fast > 0]), rtol=1e-11)
