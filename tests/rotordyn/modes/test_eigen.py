"""Modes at one speed: against brute force, closed forms, and beside very stiff springs."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as la
from hypothesis import given, settings
from hypothesis import strategies as st
from rotors import (
    between_bearings,
    connect,
    eigenvalues_of,
    general,
    ground,
    hub,
    one_rotor,
    steel_shaft,
    three_disk_element,
    twin,
    with_axial_and_torsion,
)

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.core.kept import Kept
from solidwhirl.rotordyn.core.ledger import SYSTEMS
from solidwhirl.rotordyn.modes import eigen
from solidwhirl.rotordyn.modes.eigen import whole_group_count

QUICK = settings(max_examples=25, deadline=None, derandomize=True)


def _random_system(seed, damped, cross=0.0):
    """Random M and K positive definite, G skew; damping and cross-coupling at the hub."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(4, 9))
    units = 10.0 ** rng.uniform(-2, 2, n)

    def spd():
        a = rng.standard_normal((n, n))
        return units[:, None] * (a @ a.T + 0.5 * np.eye(n)) * units

    g = rng.standard_normal((n, n))
    element = general(spd(), 1e4 * spd(), units[:, None] * (g - g.T) * units)
    skew, drain = [[0.0, cross], [-cross, 0.0]], damped * units[:2] ** 2
    return one_rotor(element, [connect("hub", "rotor.hub", None, skew, drain)])


def _residual(system, speed, modes):
    """Largest |Q(λ)φ| over the sum of the sizes of its terms, by rows scaled to M."""
    m, c, g, k = rd.matrices_at_speed(system, speed)
    root = np.sqrt(np.diag(m))
    worst = 0.0
    for value, shape in zip(modes.eigenvalues, modes.shapes.T, strict=True):
        terms = [value**2 * m @ shape, value * (c + g) @ shape, k @ shape]
        total = sum(la.norm(term / root) for term in terms)
        worst = max(worst, la.norm(sum(terms) / root) / total)
    return worst


@QUICK
@given(seed=st.integers(0, 10**6), speed=st.floats(0, 300), damped=st.sampled_from([0.0, 5.0]))
def test_spectrum_equals_brute_force_and_shapes_solve_the_problem(seed, speed, damped):
    system = _random_system(seed, damped, 50.0 * damped)
    n, exact = system.size, eigenvalues_of(system, speed)
    modes = rd.modes_at_speed(system, speed)
    found = np.concatenate(
        [modes.eigenvalues, modes.eigenvalues.conj(), modes.real_eigenvalues.astype(complex)]
    )
    # Conjugate pairs and real eigenvalues make up all 2n; paired by nearest.
    assert found.size == 2 * n and modes.zero_count == 0
    distance = np.abs(found[:, None] - exact[None, :])
    assert (distance.min(axis=1) < 1e-7 * np.abs(found)).all()
    assert (distance.min(axis=0) < 1e-7 * np.abs(exact)).all()
    # Backward stable solvers on well-scaled random matrices.
    assert _residual(system, speed, modes) < 1e-10


@QUICK
@given(seed=st.integers(0, 10**6), speed=st.floats(1, 300))
def test_undamped_states_are_orthogonal_in_energy(seed, speed):
    system = _random_system(seed, 0.0)
    modes = rd.modes_at_speed(system, speed)
    assert (modes.eigenvalues.real == 0).all()
    m, _, _, k = rd.matrices_at_speed(system, speed)
    shapes, omega = modes.shapes, modes.eigenvalues.imag
    energy = shapes.conj().T @ k @ shapes
    energy += np.multiply.outer(omega, omega) * (shapes.conj().T @ m @ shapes)
    size = np.sqrt(np.diag(energy).real)
    np.testing.assert_allclose(energy / np.outer(size, size), np.eye(omega.size), atol=1e-9)


def test_modes_at_rest_are_real_and_normalised():
    system = between_bearings(three_disk_element(), 7e7, 5e7)
    modes = rd.modes_at_speed(system, 0.0)
    assert not modes.shapes.imag.any()
    assert modes.eigenvalues.size == system.size
    gram = modes.shapes.conj().T @ system.mass @ modes.shapes
    np.testing.assert_allclose(gram, np.eye(system.size), atol=1e-9)


def test_fewer_modes_are_the_lowest_ones():
    few, every = rd.modes_at_speed(twin(), 900.0, 5), rd.modes_at_speed(twin(), 900.0)
    np.testing.assert_allclose(few.frequency_hz, every.frequency_hz[:5], rtol=1e-12)


# Stiff springs: the difference from exactly rigid constraints is C/k, with nothing added.


def _one_ended(k, c):
    """Held at one end only, so that the tilts stay free and K is singular."""
    options = {"rigid": ("ux", "uy")} if k is None else {"stiffness": k}
    left = connect("left", "rotor.left", **options)
    right = connect("right", "rotor.right", damping=c)
    return one_rotor(three_disk_element(), [left, right])


STIFF = {
    "supports and joint": lambda k: twin(support=k, joint=k),
    "free tilt": lambda k: _one_ended(k, 0.0),
    "damped": lambda k: _one_ended(k, 200.0),
}


@pytest.mark.parametrize("case", STIFF)
@pytest.mark.parametrize("speed", [0.0, 1000.0])
def test_stiff_supports_converge_to_rigid_ones_without_noise(case, speed):
    build = STIFF[case]
    limit = rd.modes_at_speed(build(None), speed).eigenvalues[:6]
    stiffness = 10.0 ** np.arange(2, 17)
    error = np.array(
        [rd.modes_at_speed(build(k), speed).eigenvalues[:6] / limit - 1 for k in stiffness]
    )
    high = stiffness >= 1e11
    constant = error[stiffness == 1e11] * 1e11
    # The next term of the expansion is (C/k)², 1e-4 of the first at 1e11; 2e-12 is for rounding.
    allowed = 1e-3 * np.abs(constant / stiffness[high, None]) + 2e-12
    assert (np.abs(error[high] - constant / stiffness[high, None]) < allowed).all()
    # All the way from a soft to a rigid support no mode falls.
    if case != "damped":
        frequencies = (1 + error.real) * limit.imag
        assert (np.diff(frequencies, axis=0) > -1e-9 * limit.imag).all()


# Free bodies, negative stiffness, overdamped motion.


@pytest.mark.parametrize("stiffness", [1e4, 1e8])
@pytest.mark.parametrize("ratio", [1.0, 0.7], ids=["isotropic", "anisotropic"])
@pytest.mark.parametrize(("speed", "drag"), [(0.01, 0.0), (1e-4, 0.0), (0.0, 1e-3), (0.0, 1e-6)])
def test_zeros_are_counted_whatever_is_slow(stiffness, ratio, speed, drag):
    """Free tilt beside damped translation: a nutation at Ω Ip/Id, or decay at c/Id, twice."""
    support = ground("rotor", "hub", stiffness, ratio * stiffness, 5.0, 7.0 * ratio, drag=drag)
    modes = rd.modes_at_speed(one_rotor(hub(), [support]), speed)
    assert modes.zero_count == 2
    if drag:
        np.testing.assert_allclose(modes.real_eigenvalues, [-drag / 0.05] * 2, rtol=1e-7)
    else:
        assert modes.eigenvalues[0].imag == pytest.approx(speed * 0.1 / 0.05, rel=1e-7)


@pytest.mark.parametrize("slow", [1e-2, 1e-5])
def test_one_slow_mode_takes_no_digits_from_the_others(slow):
    """Against the state matrix in units of the fast modes, which is accurate for those."""
    rng = np.random.default_rng(3)
    turn = la.qr(rng.standard_normal((6, 6)))[0]
    omega = np.array([slow, 300.0, 700.0, 1500.0, 4000.0, 9000.0])
    element = general(np.eye(6), turn * omega**2 @ turn.T, np.zeros((6, 6)))
    system = one_rotor(element, [connect("hub", "rotor.hub", damping=(20.0, 3.0))])
    exact = eigenvalues_of(system, 0.0, 1e3)
    exact = exact[exact.imag > 1.0]
    found = rd.modes_at_speed(system, 0.0).eigenvalues
    np.testing.assert_allclose(found[found.imag > 1.0], exact[np.argsort(exact.imag)], rtol=1e-12)


@pytest.mark.parametrize("damping", [0.0, 300.0])
@pytest.mark.parametrize("speed", [0.0, 900.0])
@pytest.mark.parametrize("k", [1e7, 1e12, 1e16])
def test_shaft_free_to_slide_and_turn(damping, speed, k):
    """The usual solid rotor: six components, held laterally; uz and rz are rigid zeros."""
    length, radius = 1.0, 0.03
    stations = np.linspace(0, length, 9)
    ends = {"a": 0.0, "b": length, "mid": 0.5}
    lateral = steel_shaft("s", stations, radius, ends)
    full = with_axial_and_torsion(lateral, length, radius, "a", "b")
    assert all(invariant.passed for invariant in rd.check_superelement(full))
    bearings = [*(ground("rotor", end, k) for end in "ab"), ground("rotor", "mid", 0.0, cx=damping)]
    modes = rd.modes_at_speed(one_rotor(full, bearings), speed)
    only = rd.modes_at_speed(one_rotor(lateral, bearings), speed)
    assert modes.zero_count == 4 and only.zero_count == 0
    assert modes.eigenvalues.size == only.eigenvalues.size + 2
    # One free rod with consistent mass: ω = √12 c / L with the wave speed c.
    added = np.sqrt(12 * np.array([2e11, 2e11 / 2.6]) / 7800) / length
    for value in (*only.eigenvalues[:8], *1j * added):
        assert np.abs(modes.eigenvalues - value).min() < 1e-9 * abs(value)


def test_negative_support_stiffness_is_reported():
    support = ground("rotor", "hub", -1e4, tilt=100)
    modes = rd.modes_at_speed(one_rotor(hub(), [support]), 0.0)
    assert modes.negative_stiffness_count == 2
    divergence = np.sqrt(1e4 / 10.0)
    exact = np.repeat([-divergence, divergence], 2)
    np.testing.assert_allclose(modes.real_eigenvalues, exact, rtol=1e-10)


def test_overdamped_motion_is_counted_apart():
    k, m, c = 1e4, 10.0, 1e4
    support = ground("rotor", "hub", k, cx=c, tilt=100)
    modes = rd.modes_at_speed(one_rotor(hub(mass_kg=m), [support]), 0.0)
    root = np.sqrt(c**2 - 4 * m * k)
    exact = np.repeat([(-c - root) / (2 * m), (-c + root) / (2 * m)], 2)
    np.testing.assert_allclose(modes.real_eigenvalues, exact, rtol=1e-10)
    # Tilt: √(100 / 0.05) rad/s.
    np.testing.assert_allclose(modes.eigenvalues, 1j * np.sqrt([2000.0, 2000.0]), rtol=1e-10)


@pytest.mark.parametrize(
    ("speed", "count", "message"),
    [(np.inf, None, "speed_rad_s is inf"), (0.0, 0, "count is 0")],
)
def test_arguments_without_meaning_are_refused(speed, count, message):
    with pytest.raises(rd.AnalysisError, match=message):
        rd.modes_at_speed(twin(), speed, count)


def test_a_coordinate_without_mass_is_named():
    singular = general(np.ones((4, 4)), np.eye(4), np.zeros((4, 4)))
    with pytest.raises(rd.AnalysisError, match="mass matrix is not positive definite"):
        rd.modes_at_speed(one_rotor(singular), 0.0)


@pytest.mark.parametrize(
    ("count", "expected"), [(1, 2), (2, 2), (3, 3), (4, 7), (5, 7), (7, 7), (8, 8), (20, 8)]
)
def test_groups_of_equal_frequencies_are_not_cut(count, expected):
    omega = np.array([1.0, 1.0 + 1e-9, 2.0, 3.0, 3.0, 3.0, 3.0, 5.0])
    assert whole_group_count(1j * omega, count) == expected
    assert whole_group_count(1j * omega[:0], count) == 0


def test_odd_numbers_of_modes_and_branches_at_rest_are_made_even():
    system = between_bearings(three_disk_element(), 5e7)
    for count in (1, 3, 5):
        modes = rd.modes_at_speed(system, 0.0, count)
        assert modes.eigenvalues.size == modes.shapes.shape[1] == count + 1
        assert rd.campbell(system, [0.0, 300.0], branch_count=count).whirl.shape[0] == count + 1
        # at speed the pairs have come apart, and the count is that asked for
        assert rd.modes_at_speed(system, 300.0, count).eigenvalues.size == count


def test_modes_at_many_speeds_are_kept_beside_one_system(monkeypatch):
    """The matrices of a system count once, however many speeds its modes are known at."""
    system, speeds = between_bearings(three_disk_element(), 1e7), np.linspace(1.0, 300.0, 40)
    shapes = rd.modes_at_speed(system, 1.0).shapes.nbytes
    matrices = 6 * system.mass.nbytes + system.transformation.nbytes
    monkeypatch.setattr(eigen, "_known", Kept(matrices + 40 * shapes))
    for known in (False, True):
        with SYSTEMS.counted() as counts:
            for speed in speeds:
                rd.modes_at_speed(system, float(speed))
        assert counts["eigenproblems"] == (0 if known else 40)
    monkeypatch.setattr(eigen, "_known", Kept(matrices - 1))
    with SYSTEMS.counted() as counts:
        rd.modes_at_speed(system, 1.0)
        rd.modes_at_speed(system, 1.0)
    assert counts["eigenproblems"] == 2  # a system that is too large is not kept
