"""Error estimates of frequencies against the true errors of truncated bodies."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rotors import (
    SKEW,
    connect,
    ground,
    one_rotor,
    truncated,
    turning,
    twin_bearings,
    twin_bodies,
    twin_rotors,
    with_stress,
)
from scipy.optimize import brentq

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.estimates.eigenvalue_errors import (
    decrement_errors,
    error_scale,
    frequency_errors,
)
from solidwhirl.rotordyn.perturbation.left_vectors import (
    balance_of,
    dynamic_stiffness,
    mirror_signs,
    mode_pairs,
    state_products,
)
from solidwhirl.rotordyn.superelement.record import ErrorForm

PART, ENDS = "mode_truncation", ("left", "right")


def _supports(stiffness, damping=0.0, cross=0.0, isotropic=False):
    """Bearings at both ends, softer in y unless isotropic, with a skew part `cross`."""
    in_y = (1.0, 1.0) if isotropic else (0.7, 0.6)
    own = (stiffness * np.diag([1.0, in_y[0]]) + cross * SKEW, damping * np.diag([1.0, in_y[1]]))
    return [connect(end, f"rotor.{end}", None, *own) for end in ("left", "right")]


def _both(body, cut, held, speed, ratio=1.0, count=None):
    """Modes of the whole body, the system of that cut, and its modes."""
    whole, system = one_rotor(body, held, ratio), one_rotor(cut, held, ratio)
    return *(rd.modes_at_speed(s, speed, count) for s in (whole, system)), system


def _true_errors(exact, modes, count):
    """Relative change of each eigenvalue, by nearest one."""
    near = np.abs(exact.eigenvalues[:, None] - modes.eigenvalues[:count])
    assert len(set(near.argmin(axis=0))) == count
    return near.min(axis=0) / np.abs(modes.eigenvalues[:count])


@pytest.mark.parametrize("speed", [0.0, 500.0, -500.0, 1500.0])
@pytest.mark.parametrize(
    "options",
    [
        {"stiffness": 7e7},
        {"stiffness": 1e6},
        {"stiffness": 1e10},
        {"stiffness": 7e7, "damping": 700.0},
        {"stiffness": 7e7, "damping": 7e4},
        {"stiffness": 7e7, "damping": 2e3, "cross": 2e7},
        {"stiffness": 7e7, "isotropic": True},
        {"stiffness": 7e7, "isotropic": True, "damping": 2e4},
    ],
)
def test_estimates_are_the_true_errors_to_first_order(full, options, speed):
    exact, modes, system = _both(full, truncated(full, 16), _supports(**options), speed)
    if options.get("isotropic") and speed == 0.0:  # pairs: each has its own nearest
        true = np.abs(exact.eigenvalues[:6] - modes.eigenvalues[:6]) / np.abs(modes.eigenvalues[:6])
    else:
        true = _true_errors(exact, modes, 6)
    found = frequency_errors(system, modes)
    # First order: what is left is (s/ω_c)², up to 0.05 for the sixth mode, and second order of
    # neighbours; beside 1e-11, the accuracy of the eigenvalues themselves.
    np.testing.assert_allclose(found.parts[PART][:6], true, rtol=0.1, atol=1e-11)
    assert set(found.parts) == {PART, "eigen_solver"}
    np.testing.assert_array_equal(found.total, found.parts[PART] + found.parts["eigen_solver"])
    assert found.bodies_without_estimate == ()


@pytest.mark.parametrize("options", [{"damping": 7e4}, {"damping": 2e3, "cross": 2e7}])
def test_errors_of_decrements(full, options):
    """Against the decrements of the whole body, of modes with enough damping to lose some."""
    held = _supports(7e7, **options)
    exact, modes, system = _both(full, truncated(full, 22), held, 500.0)
    near = np.abs(exact.eigenvalues[:, None] - modes.eigenvalues[:4]).argmin(axis=0)
    true = np.abs(exact.log_decrement[near] - modes.log_decrement[:4])
    np.testing.assert_allclose(decrement_errors(system, modes)[:4], true, rtol=0.1, atol=1e-10)


@pytest.mark.parametrize(
    ("options", "has_mirror"),
    [
        ({"damping": 700.0}, True),
        ({"damping": 2e3, "cross": 2e7, "isotropic": True}, True),
        ({"damping": 2e3, "cross": 2e7}, True),
        ({"damping": 2e3, "cross": 2e7, "even": 1e7}, False),
    ],
)
def test_left_vectors_are_those_of_the_mirrored_system(full, options, has_mirror):
    """They annihilate D(s); symmetric cross terms beside skew ones leave no mirror."""
    even = options.pop("even", 0.0) * np.array([[0.0, 1.0], [1.0, 0.0]])
    held = [
        dataclasses.replace(b, stiffness_n_per_m=b.stiffness_n_per_m + even)
        for b in _supports(7e7, **options)
    ]
    system = one_rotor(truncated(full, 16), held)
    modes = rd.modes_at_speed(system, 500.0)
    matrices = rd.matrices_at_speed(system, 500.0)
    signs = mirror_signs(matrices)
    assert (signs is not None) == has_mirror
    pairs = mode_pairs(matrices, modes)
    for rate, left in zip(pairs.rates, pairs.left.T, strict=True):
        dynamic = dynamic_stiffness(matrices, rate)
        size = np.abs(left) @ np.abs(dynamic)
        assert (np.abs(left @ dynamic) <= 1e-7 * size.max()).all()
    if signs is not None:
        velocity = matrices.damping + matrices.gyroscopic
        for matrix in (matrices.mass, velocity, matrices.stiffness):
            mirrored = signs[:, None] * matrix * signs
            assert np.abs(mirrored - matrix.T).max() <= 1e-10 * np.abs(matrix).max()


def test_error_of_the_estimate_falls_with_the_square_of_the_cutoff(full):
    """What is left out, made stiffer by f²: its error falls by f², that of the estimate by f⁴."""
    held, kept = _supports(7e7, damping=700.0), 8
    misses = []
    for factor in (1.0, 2.0, 4.0):
        stiffness = np.array(full.stiffness)
        first = truncated(full, kept).size
        rest = np.arange(first, full.size)
        stiffness[rest, rest] *= factor**2
        body = dataclasses.replace(full, stiffness=stiffness)
        exact, modes, system = _both(body, truncated(body, kept), held, 800.0, count=10)
        true = _true_errors(exact, modes, 4)
        misses.append(np.abs(frequency_errors(system, modes).parts[PART][:4] / true - 1.0))
    rates = np.log2(np.array(misses[:-1]) / np.array(misses[1:]))
    # second order in 1/factor; signs of several terms of that order may cancel for a while
    assert np.median(rates) == pytest.approx(2.0, abs=0.3)
    assert (rates > 1.2).all()


def test_amplification_bounds_the_error_at_rest(full):
    """K_ww − ω²M_ww lies between K_ww (1 − ω²/ω_c²) and K_ww, so the error between both forms."""
    held, kept = _supports(7e7), 8
    cutoff = 2.0 * np.pi * full.coordinates[truncated(full, kept).size].frequency_hz
    exact = rd.modes_at_speed(one_rotor(full, held), 0.0, 4)
    low, high = (
        frequency_errors(system, rd.modes_at_speed(system, 0.0, 4)).parts[PART]
        for limit in (np.inf, cutoff)
        for system in [one_rotor(truncated(full, kept, cutoff=limit), held)]
    )
    modes = rd.modes_at_speed(one_rotor(truncated(full, kept), held), 0.0, 4)
    true = 1.0 - exact.eigenvalues.imag / modes.eigenvalues.imag
    # the change of s is itself of first order in the change of s², to half the relative error
    assert (low * (1 - 1e-3) <= true).all() and (true <= high * (1 + 1e-3)).all()
    assert (high > low * (1 + 1e-4)).all()


def test_wrong_static_shapes_show_in_the_residual_of_k(full):
    held = _supports(7e7, damping=700.0)
    exact, modes, system = _both(full, truncated(full, 16, slack=2e-5), held, 500.0, count=10)
    true = _true_errors(exact, modes, 4)
    clean = one_rotor(truncated(full, 16), held)
    cleaner = frequency_errors(clean, rd.modes_at_speed(clean, 500.0, 4)).parts[PART]
    assert (true > 3.0 * cleaner).any()
    # (s/ω_c)² and the second order of the wrong shapes
    np.testing.assert_allclose(frequency_errors(system, modes).parts[PART][:4], true, rtol=0.05)


@pytest.mark.parametrize("factor", [1e-4, 1e-6])
def test_change_of_stress_stiffness(full, factor):
    """A body whose Kgeo is really larger; what is left of the linear estimate falls with it."""
    held = _supports(7e7, damping=700.0)
    changed = with_stress(full, 0.5 + factor)
    form = ErrorForm(
        part="mesh", gram=np.zeros((4 * full.size, 4 * full.size)), safety=1.0,
        stiffness_change=changed.stress_stiffening - full.stress_stiffening, cutoff_rad_s=np.inf,
    )  # fmt: skip
    body = dataclasses.replace(full, error_forms=(form,))
    exact, modes, system = _both(changed, body, held, 1500.0, -2.0, 8)
    true = np.abs(1.0 - exact.eigenvalues / modes.eigenvalues)
    found = frequency_errors(system, modes).parts["mesh"]
    # second order of the change, and 1e-12 of accuracy of the eigenvalues
    np.testing.assert_allclose(found, true, rtol=2e2 * factor + 1e-12 / true.min())


@pytest.mark.parametrize("joint", [1e8, None])
@pytest.mark.parametrize("ratio", [-1.3, 2.5])
def test_bodies_with_speeds_of_their_own(ratio, joint):
    bodies = [with_stress(body, 0.5) for body in twin_bodies()]
    cut = [truncated(bodies[0], 10), truncated(bodies[1], 4)]

    def system(*both):
        return rd.assemble(twin_rotors(ratio, bodies=both), twin_bearings(1e8, joint))

    exact = rd.modes_at_speed(system(*bodies), 1200.0)
    both = system(*cut)
    modes = rd.modes_at_speed(both, 1200.0)
    found = frequency_errors(both, modes).parts[PART]
    # the fifth and sixth mode come near the modes left out
    np.testing.assert_allclose(found[:6], _true_errors(exact, modes, 6), rtol=0.1)
    # each body apart adds up to both, to the second order
    single = [system(cut[0], bodies[1]), system(bodies[0], cut[1])]
    parts = [frequency_errors(s, rd.modes_at_speed(s, 1200.0, 6)) for s in single]
    together = sum(part.parts[PART] for part in parts)
    np.testing.assert_allclose(together, found[:6], rtol=0.02)


def _two_equal_rotors(first, second, stiffness=7e7, spring=None):
    """Two bodies on equal isotropic bearings, joined in the middle by a spring or not at all."""
    held = [ground(name, end, k) for name, k in (("one", 7e7), ("two", stiffness)) for end in ENDS]
    if spring:
        held.append(connect("j", "one.left", "two.left", spring))
    return rd.assemble({"one": turning(first), "two": turning(second)}, tuple(held))


def test_repeated_modes_keep_their_own_errors(full):
    """Four equal frequencies: those of one body are wrong, those of its exact twin are not."""
    body = truncated(full, 8)
    blank = dataclasses.replace(body, error_forms=())
    system = _two_equal_rotors(body, blank)
    modes = rd.modes_at_speed(system, 0.0, 8)
    alone = one_rotor(body, _supports(7e7, isotropic=True))
    wanted = frequency_errors(alone, rd.modes_at_speed(alone, 0.0, 4)).parts[PART]
    np.testing.assert_allclose(wanted[::2], wanted[1::2], rtol=1e-8)  # both planes
    # any basis of the four shapes will do
    rng = np.random.default_rng(2)
    turn, _ = np.linalg.qr(rng.standard_normal((4, 4)))
    for shapes in (modes.shapes[:, :4], modes.shapes[:, :4] @ turn):
        family = None if modes.family is None else modes.family[:4]
        four = {"eigenvalues": modes.eigenvalues[:4], "shapes": shapes, "family": family}
        mixed = dataclasses.replace(modes, **four)
        found = np.sort(frequency_errors(system, mixed).parts[PART])
        # rounding of the four equal eigenvalues against an error of 1e-5
        np.testing.assert_allclose(found, [0.0, 0.0, *wanted[:2]], atol=1e-9)
    found = frequency_errors(system, modes)
    # what one body does not tell is missing in the sum
    assert found.bodies_without_estimate == ("two",) and np.isnan(found.total).all()


def test_modes_closer_than_their_errors_are_changed_together(full):
    """A weak spring mixes two rotors that are in tune only by the error of one of them.

    The mixed modes are ±κ apart; with the error gone the rotors are out of tune and their modes
    apart: one has moved by the whole error, the other not at all. First order of each mode alone
    would give both one half.
    """
    body = truncated(full, 4)

    def first_mode(element, stiffness):
        system = one_rotor(element, _supports(stiffness, isotropic=True))
        return rd.modes_at_speed(system, 0.0, 1).eigenvalues[0].imag

    wrong = first_mode(body, 7e7)
    in_tune = brentq(lambda k: first_mode(full, k) - wrong, 6.9e7, 7.2e7, xtol=1.0)
    coarse, exact = (_two_equal_rotors(one, full, in_tune, spring=3e2) for one in (body, full))
    modes, true = rd.modes_at_speed(coarse, 0.0, 4), rd.modes_at_speed(exact, 0.0, 4)
    gap = np.ptp(modes.eigenvalues.imag) / wrong
    moved = np.sort(modes.eigenvalues.imag - true.eigenvalues.imag)[[0, -1]] / wrong
    assert gap < 0.2 * moved[1]  # closer than the error
    found = np.sort(frequency_errors(coarse, modes).parts[PART])
    np.testing.assert_allclose(found[2:], moved[1], rtol=0.05)
    assert (found[:2] < 2.0 * gap).all()


@pytest.mark.parametrize("speed", [0.0, 700.0])
def test_left_vectors(full, speed):
    for held in (
        _supports(7e7),
        _supports(7e7, damping=7e4, cross=2e7),
        _supports(1e15, damping=7e4, cross=1e6),
        _supports(7e7, damping=7e4, isotropic=True),
    ):
        system = one_rotor(full, held)
        matrices = rd.matrices_at_speed(system, speed)
        modes = rd.modes_at_speed(system, speed, 8)
        pairs = mode_pairs(matrices, modes)
        states = state_products(matrices, pairs.rates, pairs.left, pairs.right)
        # left vectors of one mode do no work on the states of the others
        size = np.abs(pairs.rates[:, None]) + np.abs(pairs.rates)
        loose = np.abs(states - np.eye(8)) * np.abs(pairs.rates) / size
        assert loose.max() < 1e-6
        for k, rate in enumerate(pairs.rates):
            dynamic = dynamic_stiffness(matrices, complex(rate))
            scale = balance_of(matrices, complex(rate))
            force = (pairs.left[:, k] @ dynamic) * scale
            bound = (np.abs(pairs.left[:, k]) @ np.abs(dynamic)) * scale
            # the accuracy of the eigenvalue beside the stiffest support
            assert np.abs(force).max() < 1e-8 * bound.max()


def test_solver_part_is_the_error_of_a_wrong_eigenvalue(full):
    system = one_rotor(full, _supports(7e7, damping=2e3))
    modes = rd.modes_at_speed(system, 600.0, 6)
    right = frequency_errors(system, modes)
    assert right.parts["eigen_solver"].max() < 1e-8
    assert right.bodies_without_estimate == () and set(right.parts) == {"mesh", "eigen_solver"}
    wrong = dataclasses.replace(modes, eigenvalues=modes.eigenvalues * (1.0 + 1e-5))
    found = frequency_errors(system, wrong).parts["eigen_solver"]
    # D(s) grows linearly near its zero; the neighbours are 1e4 times farther
    np.testing.assert_allclose(found, 1e-5, rtol=1e-2)


def test_interface_coupling_is_shown_and_not_summed(full):
    body = truncated(full, 8)
    form = body.error_forms[0]
    coupling = dataclasses.replace(form, part="interface_coupling")
    body = dataclasses.replace(body, error_forms=(form, coupling))
    system = one_rotor(body, _supports(7e7))
    found = frequency_errors(system, rd.modes_at_speed(system, 300.0, 4))
    np.testing.assert_allclose(found.parts["interface_coupling"], found.parts[PART])
    np.testing.assert_array_equal(found.total, found.parts[PART] + found.parts["eigen_solver"])


def test_errors_of_frequencies_near_zero_are_measured_against_the_lowest_elastic_one(full):
    """A slow precession has no scale of its own; the phase of s is no matter."""
    system = one_rotor(full, ())
    lowest = 2.0 * np.pi * full.free_frequencies_hz.min()
    rates = np.array([1e-6j, -1e-6, lowest * 1e-2j, lowest * (1.0 - 1.0j), 1e3j * lowest])
    expected = lowest * np.array([1e-2, 1e-2, 1e-2, np.sqrt(2.0), 1e3])
    np.testing.assert_allclose(error_scale(system, rates), expected)
