"""Complex coordinates: eigenvalues as in real ones, and refusal of what is not isotropic."""

import numpy as np
import pytest
import scipy.linalg as la
from rotors import connect, turning

from solidwhirl import rotordyn as rd

SPEED = 700.0


def _element(name="shaft", components=("ux", "uy", "rx", "ry")):
    disk = rd.Disk(name="disk", position_m=0.2, mass_kg=12.0, polar_kg_m2=0.2, diametral_kg_m2=0.12)
    return rd.beam_superelement(
        name, np.linspace(0, 0.7, 6), 0.02, 0.0, (2e11, 0.3, 7800.0),
        {"left": 0.0, "disk": 0.2, "right": 0.7}, [disk], components=components,
    )  # fmt: skip


def _system(stiffness=None, damping=None, components=("ux", "uy", "rx", "ry"), **options):
    bearings = [
        connect(
            end,
            f"shaft.{end}",
            stiffness=np.eye(2) * 1e7 if stiffness is None else np.array(stiffness),
            damping=np.eye(2) * 400.0 if damping is None else np.array(damping),
        )
        for end in ("left", "right")
    ]
    rotor = turning(_element(components=components), **options)
    return rd.assemble({"shaft": rotor}, tuple(bearings))


def _eigenvalues(mass, velocity, stiffness):
    n = len(mass)
    top = np.hstack([np.zeros((n, n)), np.eye(n)])
    bottom = np.hstack([-la.solve(mass, stiffness), -la.solve(mass, velocity)])
    return la.eigvals(np.vstack([top, bottom]))


def test_eigenvalues_are_those_of_the_real_form():
    assembled = _system(
        internal_damping=rd.InternalDamping(stiffness_coefficient_s=2e-6, modal_ratio=0.01)
    )
    form = rd.complex_form(assembled)
    assert form.size == assembled.size // 2
    assert form.rest.size == 0
    half = _eigenvalues(*form.at_speed(SPEED))
    matrices = rd.matrices_at_speed(assembled, SPEED)
    full = _eigenvalues(matrices.mass, matrices.damping + matrices.gyroscopic, matrices.stiffness)
    # every λ of z stands for itself and its conjugate in the real form
    expected = np.concatenate([half, half.conj()])
    distance = np.abs(full[:, None] - expected).min(axis=1) / np.abs(full)
    # eigenvalues of an unscaled companion matrix: rounding times the ratio of frequencies, 1e3
    assert distance.max() < 1e-9


def test_forward_whirl_is_positive():
    # Gyroscopic stiffening lifts forward whirl: the positive frequencies of a mode lie higher.
    form = rd.complex_form(_system(damping=np.zeros((2, 2))))
    values = _eigenvalues(*form.at_speed(SPEED)).imag
    forward, backward = np.sort(values[values > 0]), np.sort(-values[values < 0])
    assert (forward[:3] > backward[:3]).all()


def test_axial_motion_and_torsion_are_left_over():
    form = rd.complex_form(_system(components=("ux", "uy", "uz", "rx", "ry", "rz")))
    assembled = form.assembled
    assert form.size * 2 + form.rest.size == assembled.size
    turned = assembled.spin_generator
    assert not turned[:, form.rest].any()
    assert np.array_equal(turned[form.second, form.first], form.second_sign)


@pytest.mark.parametrize(
    "changes",
    [
        {"stiffness": [[1e7, 0.0], [0.0, 1.01e7]]},
        {"stiffness": [[1e7, 1e5], [-1e5, 1e7]]},
        {"damping": [[400.0, 0.0], [0.0, 300.0]]},
    ],
)
def test_what_is_not_isotropic_has_no_complex_form(changes):
    assert rd.complex_form(_system(**changes)) is None


def test_modal_ratio_is_the_damping_of_a_free_body():
    rotor = turning(_element(), 0.0, internal_damping=rd.InternalDamping(modal_ratio=0.02))
    free = rd.assemble({"shaft": rotor}, ())
    from solidwhirl.rotordyn import modes_at_speed

    ratios = modes_at_speed(free, 0.0).damping_ratio
    assert ratios == pytest.approx(np.full(ratios.size, 0.02), rel=1e-6)
