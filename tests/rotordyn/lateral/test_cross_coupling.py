"""Loss of stability under cross-coupled stiffness against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from rotors import ground, hub, one_rotor, steel_shaft

from solidwhirl.rotordyn import End
from solidwhirl.rotordyn.lateral.cross_coupling import (
    cross_coupling_sweep,
    first_forward_mode,
    with_cross_coupling,
)

HUB = End(body="rotor", interface="hub")


@pytest.mark.parametrize("ratio", [1.0, -1.0])
def test_point_mass(ratio):
    """m λ² + c λ + k ∓ i Q = 0: stability is lost at Q = c √(k/m), whichever way it turns."""
    mass, stiffness, damping = 100.0, 1e7, 2000.0
    bearing = ground("rotor", "hub", stiffness, cx=damping, tilt=(1e8, 1e8))
    system = one_rotor(hub(mass), [bearing], ratio)
    lost = damping * np.sqrt(stiffness / mass)
    found = cross_coupling_sweep(system, 300.0, {HUB: 1.0}, 2.0 * lost, 0.5 * lost, ratio)
    assert lost == pytest.approx(632_456.0, rel=1e-6)
    assert found.lost_at_n_per_m == pytest.approx(lost, rel=1e-9)
    assert found.stiffness_n_per_m[-1] == found.lost_at_n_per_m
    at = list(found.stiffness_n_per_m).index(0.5 * lost)
    assert found.log_decrement[0] == pytest.approx(0.19879, abs=5e-6)
    assert found.log_decrement[at] == pytest.approx(0.09935, abs=5e-6)
    roots = [np.roots([mass, damping, stiffness - 1j * q]) for q in found.stiffness_n_per_m]
    value = np.array([r[r.imag.argmax()] for r in roots])
    np.testing.assert_allclose(
        found.log_decrement, -2.0 * np.pi * value.real / value.imag, atol=1e-9
    )
    np.testing.assert_allclose(found.frequency_hz, value.imag / (2.0 * np.pi), rtol=1e-10)


def test_loss_beyond_the_range_and_none_at_all():
    bearing = ground("rotor", "hub", 1e7, cx=2000.0, tilt=(1e8, 1e8))
    system = one_rotor(hub(100.0), [bearing])
    found = cross_coupling_sweep(system, 300.0, {HUB: 1.0}, 1e5, 1e4)
    assert found.lost_at_n_per_m == pytest.approx(2000.0 * np.sqrt(1e5), rel=1e-9)
    assert found.stiffness_n_per_m[-1] == 1e5
    # below 1024 times the range there is no loss; and unstable without any Q
    assert cross_coupling_sweep(system, 300.0, {HUB: 1.0}, 100.0, 10.0).lost_at_n_per_m == np.inf
    driven = with_cross_coupling(system, {HUB: 7e5})
    assert cross_coupling_sweep(driven, 300.0, {HUB: 1.0}, 1e5, 1e4).lost_at_n_per_m == 0.0


def test_the_loss_is_a_root_of_the_whole_system():
    """A flexible shaft on unlike bearings: nothing grows below Q0, something above."""
    shaft = steel_shaft(
        "rotor", [0.0, 0.3, 0.5, 1.0], [0.03] * 3, {"a": 0.0, "wheel": 0.5, "b": 1.0},
        [(0.5, 20.0, 0.2, 0.12)],
    )  # fmt: skip
    bearings = [ground("rotor", end, 2e7, 4e7, cx=2e4) for end in "ab"]
    system, speed = one_rotor(shaft, bearings), 800.0
    wheel = End(body="rotor", interface="wheel")
    found = cross_coupling_sweep(system, speed, {wheel: 1.0}, 1e8, 1e6)
    from rotors import eigenvalues_of

    for factor, grows in ((0.999, False), (1.001, True)):
        driven = with_cross_coupling(system, {wheel: factor * found.lost_at_n_per_m})
        assert (eigenvalues_of(driven, speed, 500.0).real.max() > 0.0) is np.bool_(grows)
    mode = first_forward_mode(system, speed)
    assert found.log_decrement[0] == mode.log_decrement > 0.0
