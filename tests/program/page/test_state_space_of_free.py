"""The response of a state space whose A has no full set of eigenvectors: a body free to drift."""

from __future__ import annotations

import warnings
from types import SimpleNamespace

import numpy as np

from solidwhirl.analyses.kinds.state_space import responses


def test_a_mass_free_to_drift():
    """x'' = f / m: |H| = 1 / (m ω²), from a matrix with one eigenvector."""
    mass = 2.0
    parts = (
        np.array([[0.0, 1.0], [0.0, 0.0]]),
        np.array([[0.0], [1.0 / mass]]),
        np.array([[1.0, 0.0]]),
        np.zeros((1, 1)),
    )
    hertz = np.array([0.5, 1.0, 20.0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = responses(SimpleNamespace(at_speed=lambda speed: parts), 0.0, hertz)
    np.testing.assert_allclose(found[:, 0, 0], -1.0 / (mass * (2.0 * np.pi * hertz) ** 2))
