"""Complex coordinates: eigenvalues as in real ones, and refusal of what is not isotropic."""

import numpy as np
import pytest
import scipy.linalg as la

from solidwhirl.rotordyn import (
    Bearing,
    Disk,
    End,
    InternalDamping,
    Rotor,
    assemble,
    beam_superelement,
    complex_form,
    matrices_at_speed,
)

SPEED = 700.0


def _element(name="shaft", components=("ux", "uy", "rx", "ry")):
    disk = Disk(name="disk", position_m=0.2, mass_kg=12.0, polar_kg_m2=0.2, diametral_kg_m2=0.12)
    return beam_superelement(
        name, np.linspace(0, 0.7, 6), 0.02, 0.0, (2e11, 0.3, 7800.0),
        {"left": 0.0, "disk": 0.2, "right": 0.7}, [disk], components=components,
    )  # fmt: skip


def _system(stiffness=None, damping=None, components=("ux", "uy", "rx", "ry"), **options):
    bearings = [
        Bearing(
            name=end,
            first=End(body="shaft", interface=end),
            stiffness_n_per_m=np.eye(2) * 1e7 if stiffness is None else np.array(stiffness),
            damping_n_s_per_m=np.eye(2) * 400.0 if damping is None else np.array(damping),
        )
        for end in ("left", "right")
    ]
    rotor = Rotor(element=_element(components=components), speed_ratio=1.0, **options)
    return assemble({"shaft": rotor}, tuple(bearings))


def _eigenvalues(mass, velocity, stiffness):
    n = len(mass)
    top = np.hstack([np.zeros((n, n)), np.eye(n)])
    bottom = np.hstack([-la.solve(mass, stiffness), -la.solve(mass, velocity)])
    return la.eigvals(np.vstack([top, bottom]))


def test_eigenvalues_are_those_of_the_real_form():
    assembled = _system(
        internal_damping=InternalDamping(stiffness_coefficient_s=2e-6, modal_ratio=0.01)
    )
    form = complex_form(assembled)
    assert form.size == assembled.size // 2
    assert form.rest.size == 0
    half = _eigenvalues(*form.at_speed(SPEED))
    matrices = matrices_at_speed(assembled, SPEED)
    full = _eigenvalues(matrices.mass, matrices.damping + matrices.gyroscopic, matrices.stiffness)
    # every λ of z stands for itself and its conjugate in the real form
    expected = np.concatenate([half, half.conj()])
    distance = np.abs(full[:, None] - expected).min(axis=1) / np.abs(full)
    # eigenvalues of an unscaled companion matrix: rounding times the ratio of frequencies, 1e3
    assert distance.max() < 1e-9


def test_forward_whirl_is_positive():
    # Gyroscopic stiffening lifts forward whirl: the positive frequencies of a mode lie higher.
    form = complex_form(_system(damping=np.zeros((2, 2))))
    values = _eigenvalues(*form.at_speed(SPEED)).imag
    forward, backward = np.sort(values[values > 0]), np.sort(-values[values < 0])
    assert (forward[:3] > backward[:3]).all()


def test_axial_motion_and_torsion_are_left_over():
    form = complex_form(_system(components=("ux", "uy", "uz", "rx", "ry", "rz")))
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
    assert complex_form(_system(**changes)) is None


def test_internal_damping_of_a_shaft_on_rigid_bearings_drives_it_above_the_critical_speed():
    # Without other damping the threshold is the critical speed itself (Genta 2005, 2.5).
    rotor = Rotor(
        element=_element(),
        speed_ratio=1.0,
        internal_damping=InternalDamping(stiffness_coefficient_s=1e-5),
    )
    held = tuple(
        Bearing(name=end, first=End(body="shaft", interface=end), rigid=("ux", "uy"))
        for end in ("left", "right")
    )
    form = complex_form(assemble({"shaft": rotor}, held))

    def growth(speed):
        values = _eigenvalues(*form.at_speed(speed))
        forward = values[values.imag > 0]
        return forward[np.argmin(forward.imag)]

    def critical(speed):
        return growth(speed).imag - speed

    low, high = 10.0, 3000.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if critical(middle) > 0 else (low, middle)
    # at the critical speed of forward whirl the shaft does not deform in its own frame
    assert abs(growth(low).real) < 1e-7 * low
    assert growth(0.98 * low).real < 0
    assert growth(1.02 * low).real > 0


def test_modal_ratio_is_the_damping_of_a_free_body():
    rotor = Rotor(
        element=_element(), speed_ratio=0.0, internal_damping=InternalDamping(modal_ratio=0.02)
    )
    free = assemble({"shaft": rotor}, ())
    from solidwhirl.rotordyn import modes_at_speed

    ratios = modes_at_speed(free, 0.0).damping_ratio
    assert ratios == pytest.approx(np.full(ratios.size, 0.02), rel=1e-6)


def test_law_of_speed_enters_both_forms():
    from solidwhirl.rotordyn.assembly.bearing_laws import PolynomialLaw

    law = PolynomialLaw(
        name="law",
        argument_unit="rad/s",
        argument_range=(0.0, 1000.0),
        stiffness_x=(1.0, 1e-3),
        stiffness_y=(1.0, 1e-3),
        damping_x=(1.0, -2e-4),
        damping_y=(1.0, -2e-4),
    )
    rotor = Rotor(element=_element(), speed_ratio=-0.5)
    bearings = tuple(
        Bearing(
            name=end,
            first=End(body="shaft", interface=end),
            stiffness_n_per_m=np.eye(2) * 1e7,
            damping_n_s_per_m=np.eye(2) * 400.0,
            speed_law=law,
        )
        for end in ("left", "right")
    )
    assembled = assemble({"shaft": rotor}, bearings)
    form = complex_form(assembled)
    # the body turns at 350 rad/s: factors 1.35 and 0.93
    plain = _system(stiffness=np.eye(2) * 1.35e7, damping=np.eye(2) * 400 * 0.93)
    expected = complex_form(plain)
    stiffness, damping = form.real_parts(SPEED)
    assert stiffness == pytest.approx(
        expected.stiffness + SPEED**2 * 0.25 * expected.centrifugal_stiffness, rel=1e-12, abs=1e-3
    )
    assert damping == pytest.approx(expected.damping, rel=1e-12, abs=1e-9)
    assert form.gyroscopic == pytest.approx(-0.5 * expected.gyroscopic, abs=1e-12)
    assert not assembled.has_constant_bearings
    assert not assembled.is_conservative
