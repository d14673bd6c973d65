"""Samples around resonances, against sums of modes in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solidwhirl.rotordyn.response.resonance_samples import resolving_samples, resonances, with_knots
from solidwhirl.rotordyn.response.unbalance_peaks import resonance_peaks


def modes(natural, ratios, parts):
    """Function: Σ_k p_k / (ω_k² − x² + 2 i ζ_k ω_k x), shape (s, c)."""
    natural, ratios = np.asarray(natural, dtype=float), np.asarray(ratios, dtype=float)

    def respond(x):
        below = natural**2 - x[:, None] ** 2 + 2j * ratios * natural * x[:, None]
        return (1.0 / below) @ np.asarray(parts, dtype=float)

    return respond


@pytest.mark.parametrize("ratio", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("count", [11, 361])
def test_height_and_width_of_a_peak_do_not_depend_on_the_samples(ratio, count):
    """Two modes a thousandth apart and one alone, of which samples show one or none."""
    natural = [300.0, 300.0 * (1.0 + 40.0 * ratio), 777.7]
    respond = modes(natural, [ratio] * 3, np.diag([1.0, 0.5, 2.0]))
    x = resolving_samples(np.linspace(0.0, 1000.0, count), respond)
    values = np.abs(respond(x))
    for column, omega in enumerate(natural):
        peak = max(resonance_peaks(x[1:], values[1:, column]), key=lambda p: p.amplitude)
        height = (1.0, 0.5, 2.0)[column] / (2.0 * ratio * omega**2 * np.sqrt(1.0 - ratio**2))
        # the parabola through samples 0.1 half-widths apart
        assert peak.amplitude == pytest.approx(height, rel=1e-4)
        place = omega * np.sqrt(1 - 2 * ratio**2)
        assert peak.position_rad_s == pytest.approx(place, rel=1e-2 * ratio)
        # 1 / 2 zeta holds to zeta; half power between samples 0.2 half-widths apart
        assert peak.amplification == pytest.approx(0.5 / ratio, rel=2.0 * ratio + 2e-3)


@given(st.integers(0, 10**6), st.integers(1, 12))
@settings(max_examples=6, deadline=None, derandomize=True)
def test_every_sharp_mode_of_many_is_found(seed, number):
    """Poles are those of the modes, also of those that no sample comes near."""
    random = np.random.default_rng(seed)
    natural = np.sort(random.uniform(50.0, 950.0, number))
    ratios = 10.0 ** random.uniform(-6.0, -3.0, number)
    respond = modes(natural, ratios, random.uniform(0.3, 3.0, (number, 4)))
    x = resolving_samples(np.linspace(0.0, 1000.0, 201), respond)
    for omega, ratio in zip(natural, ratios, strict=True):
        # within a tenth of the half-width of the peak
        assert np.abs(x - omega).min() < 0.1 * ratio * omega


def test_the_samples_that_are_given_stay_and_broad_peaks_need_no_others():
    given_samples = np.linspace(0.0, 100.0, 301)
    broad = resolving_samples(given_samples, modes([50.0], [0.2], [[1.0]]))
    np.testing.assert_array_equal(broad, given_samples)
    sharp = resolving_samples(given_samples, modes([50.0], [1e-4], [[1.0]]))
    assert set(given_samples) < set(sharp)
    assert (np.diff(sharp) > 0.0).all() and sharp[0] == 0.0 and sharp[-1] == 100.0


def test_without_damping_the_place_shows_and_no_sample_is_on_it():
    respond = modes([50.123], [0.0], [[1.0]])
    x = resolving_samples(np.linspace(0.0, 90.0, 46), respond)
    (peak,) = resonance_peaks(x[1:], np.abs(respond(x))[1:, 0])
    assert peak.position_rad_s == pytest.approx(50.123, rel=1e-7)
    assert np.abs(x / 50.123 - 1.0).min() == pytest.approx(0.9e-4, rel=0.01)


def test_poles_are_the_natural_frequencies_with_their_damping():
    natural, ratios = np.array([120.0, 300.0, 640.0]), np.array([1e-5, 1e-3, 1e-2])
    respond = modes(natural, ratios, np.ones((3, 3)))
    x = np.linspace(1.0, 1000.0, 200)
    found = resonances(x, respond(x))
    np.testing.assert_allclose(found.places, natural * np.sqrt(1.0 - ratios**2), rtol=1e-9)
    np.testing.assert_allclose(found.half_widths, ratios * natural, rtol=1e-3)


def test_few_samples_and_nothing_that_moves_are_no_error():
    for samples in ([], [5.0], [0.0, 5.0], [1.0, 2.0, 3.0]):
        assert set(samples) <= set(resolving_samples(samples, modes([50.0], [0.01], [[1.0]])))
    x = np.linspace(0.0, 10.0, 30)
    np.testing.assert_array_equal(resolving_samples(x, lambda p: np.zeros((p.size, 3))), x)


def test_knots_that_differ_by_rounding_are_one():
    """Times a speed ratio both are one frequency."""
    twice = np.array([1.5, np.nextafter(1.5, 2.0), 1.75])
    np.testing.assert_array_equal(with_knots([0.0, 1.0, 2.0], twice), [0.0, 1.0, 1.5, 1.75, 2.0])
