"""Complex coordinates: eigenvalues as in real ones, and refusal of what is not isotropic."""

import numpy as np
import pytest
from rotors import connect, eigenvalues_of, one_rotor, state_eigenvalues, steel_shaft

from solidwhirl import rotordyn as rd

SPEED = 700.0


def _element(**options):
    seats = {"left": 0.0, "disk": 0.2, "right": 0.7}
    disks = [(0.2, 12.0, 0.2, 0.12)]
    return steel_shaft("shaft", np.linspace(0, 0.7, 6), 0.02, seats, disks, **options)


def _system(stiffness=1e7, damping=400.0, inside=None, **options):
    own = ("left", "rotor.left", None, stiffness, damping)
    other = ("right", "rotor.right", None, stiffness, damping)
    return one_rotor(_element(**options), [connect(*own), connect(*other)], internal_damping=inside)


def test_eigenvalues_are_those_of_the_real_form():
    inside = rd.InternalDamping(stiffness_coefficient_s=2e-6, modal_ratio=0.01)
    assembled = _system(inside=inside)
    form = rd.complex_form(assembled)
    assert form.size == assembled.size // 2
    assert form.rest.size == 0
    half = state_eigenvalues(*form.at_speed(SPEED))
    full = eigenvalues_of(assembled, SPEED)
    # every λ of z stands for itself and its conjugate in the real form
    expected = np.concatenate([half, half.conj()])
    distance = np.abs(full[:, None] - expected).min(axis=1) / np.abs(full)
    # eigenvalues of an unscaled companion matrix: rounding times the ratio of frequencies, 1e3
    assert distance.max() < 1e-9


def test_forward_whirl_is_positive():
    # Gyroscopic stiffening lifts forward whirl: the positive frequencies of a mode lie higher.
    form = rd.complex_form(_system(damping=0.0))
    values = state_eigenvalues(*form.at_speed(SPEED)).imag
    forward, backward = np.sort(values[values > 0]), np.sort(-values[values < 0])
    assert (forward[:3] > backward[:3]).all()


def test_axial_motion_and_torsion_are_left_over():
    form = rd.complex_form(_system(components=("ux", "uy", "uz", "rx", "ry", "rz")))
    assembled = form.assembled
    assert form.size * 2 + form.rest.size == assembled.size
    turned = assembled.spin_generator
    assert not turned[:, form.rest].any()
    assert np.array_equal(turned[form.second, form.first], form.second_sign)


def test_modal_ratio_is_the_damping_of_a_free_body():
    free = one_rotor(_element(), (), 0.0, internal_damping=rd.InternalDamping(modal_ratio=0.02))
    ratios = rd.modes_at_speed(free, 0.0).damping_ratio
    assert ratios == pytest.approx(np.full(ratios.size, 0.02), rel=1e-6)
