"""The fundamental mistuning model against chains that are solved as a whole."""

from __future__ import annotations

import numpy as np
import pytest

from solidwhirl.rotordyn import AnalysisError
from solidwhirl.rotordyn import nodal_diameters as nd

N, ZETA = 12, 1e-3


def _tuned_hz(coupling, sectors=N):
    """Blades of unit mass and 100 Hz, springs between neighbours: closed form."""
    p = np.arange(sectors)
    return 100.0 * np.sqrt(1.0 + 4.0 * coupling * np.sin(np.pi * p / sectors) ** 2)


def _chain_stiffness(coupling, deviations):
    """K of the whole chain in Hz²; the blades' own frequencies deviate."""
    n = len(deviations)
    ahead = np.roll(np.eye(n), 1, axis=1)
    springs = coupling * (2.0 * np.eye(n) - ahead - ahead.T)
    return 1e4 * (np.diag((1.0 + deviations) ** 2) + springs)


def test_equal_deviations_move_every_frequency_alike():
    tuned = _tuned_hz(0.01)
    found = nd.mistuned_modes(tuned, np.full(N, 0.02))
    assert found.frequency_hz == pytest.approx(np.sort(tuned) * np.sqrt(1.04), rel=1e-12)


def test_frequencies_of_mistuned_chains_converge():
    """The model neglects squares of the deviations and their products with the coupling."""
    pattern = np.random.default_rng(3).standard_normal(N)
    errors = []
    for small in (1.0, 0.5, 0.25):
        deviations, coupling = 0.02 * small * pattern, 0.01 * small
        exact = np.sqrt(np.linalg.eigvalsh(_chain_stiffness(coupling, deviations)))
        found = nd.mistuned_modes(_tuned_hz(coupling), deviations).frequency_hz
        errors.append(np.abs(found / exact - 1.0).max())
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert rates == pytest.approx([2.0, 2.0], abs=0.25)
    largest = 0.02 * np.abs(pattern).max()
    assert errors[0] < 0.5 * largest**2 + largest * 4.0 * 0.01


def test_mode_shapes_over_the_sectors_are_those_of_the_chain():
    deviations = 0.02 * np.random.default_rng(3).standard_normal(N)
    _, exact = np.linalg.eigh(_chain_stiffness(0.01, deviations))
    found = nd.mistuned_modes(_tuned_hz(0.01), deviations).sectors
    assert np.abs(np.sum(exact * found, axis=0)) == pytest.approx(np.ones(N), abs=5e-3)


@pytest.mark.parametrize("order", [0, 3, 10, 15])
def test_forced_response_of_a_mistuned_chain(order):
    """All blades of the chain over a fine grid of frequencies, damping by its own modes."""
    # the model's frequencies err by squares of the deviations, small beside the damping ratio
    deviations = 0.005 * np.random.default_rng(8).standard_normal(N)
    coupling = 0.002
    tuned = _tuned_hz(coupling)
    found = nd.forced_response(tuned, nd.mistuned_modes(tuned, deviations), order, ZETA)
    force = np.exp(2j * np.pi * order * np.arange(N) / N)

    def largest(own):
        squared, shapes = np.linalg.eigh(_chain_stiffness(coupling, own))
        hertz = np.arange(96.0, 104.0, 0.002)[:, None]
        gain = 1.0 / (squared - hertz**2 + 2j * ZETA * np.sqrt(squared) * hertz)
        return np.abs((gain * (shapes.T @ force)) @ shapes.T).max(axis=0)

    exact = largest(deviations) / largest(np.zeros(N)).max()
    assert found.factor == pytest.approx(exact.max(), rel=0.01)
    assert found.amplification == pytest.approx(exact, rel=0.02)


def test_a_tuned_ring_is_not_amplified():
    tuned = _tuned_hz(0.01)
    found = nd.forced_response(tuned, nd.mistuned_modes(tuned, np.zeros(N)), 3, ZETA)
    assert found.amplification == pytest.approx(np.ones(N), rel=1e-4)


def test_no_random_pattern_exceeds_the_bound_of_whitehead():
    sectors = 9
    tuned = _tuned_hz(0.005, sectors)
    patterns = nd.random_deviations(sectors, 0.005, 300, seed=1)
    found = nd.amplification_statistics(tuned, patterns, 2, ZETA)
    assert found.bound == 2.0
    assert 1.3 < found.factors[-1] < 2.0
    assert found.quantiles[0.05] < found.quantiles[0.5] < found.quantiles[0.99]
    worst = nd.forced_response(tuned, nd.mistuned_modes(tuned, found.worst_deviations), 2, ZETA)
    assert worst.factor == found.factors[-1]
    assert (nd.random_deviations(sectors, 0.005, 300, seed=1) == patterns).all()


def test_two_blades_follow_the_closed_form_up_to_the_bound():
    """Deviations d and -d of two blades: shapes (cos φ, sin φ) with tan 2φ = coupling / d.

    With resonances far apart the larger amplitude is (1 + sin 2φ + cos 2φ) / 2 of the static answer
    at the lower frequency; at most (1 + √2) / 2, for d = coupling.
    """
    coupling = 0.004
    tuned = np.array([100.0, 100.0 * np.sqrt(1.0 + 4.0 * coupling)])
    for d in coupling * np.array([0.5, 1.0, 2.0, 5.0]):
        modes = nd.mistuned_modes(tuned, np.array([d, -d]))
        found = nd.forced_response(tuned, modes, 0, 1e-5).factor
        angle = np.arctan2(coupling, d)
        square = 1.0 + 2.0 * coupling - 2.0 * np.hypot(coupling, d)
        exact = 0.5 * (1.0 + np.sin(angle) + np.cos(angle)) / square
        assert found == pytest.approx(exact, rel=2e-3)


def test_wrong_input_is_refused():
    with pytest.raises(AnalysisError, match="3 deviations of blades for 12 sectors"):
        nd.mistuned_modes(_tuned_hz(0.01), np.zeros(3))
    with pytest.raises(AnalysisError, match="without stiffness"):
        nd.mistuned_modes(_tuned_hz(0.01), np.full(N, -0.6))
