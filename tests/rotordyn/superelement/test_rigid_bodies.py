"""Rigid bodies with several interfaces: exact constraints, stiff joints, whirl of a rigid rotor."""

import numpy as np
import pytest
import scipy.linalg as la
from rotors import connect, turning

from solidwhirl.rotordyn import (
    SuperelementError,
    assemble,
    beam_superelement,
    modes_at_speed,
    rigid_superelement,
)
from solidwhirl.rotordyn.assembly.reactions import joint_forces

MASS, DIAMETRAL, POLAR = 20.0, 0.4, 0.25
PLACES = {"a": -0.3, "middle": 0.1, "b": 0.5}


def _body(**options):
    return rigid_superelement(
        "drum", MASS, [0.0, 0.0, 0.05], [DIAMETRAL, DIAMETRAL, POLAR], PLACES, **options
    )


def _spring(end, stiffness, body="drum", second=None):
    name, other = end if body == "drum" else f"{body} {end}", second and f"{second}.{end}"
    return connect(name, f"{body}.{end}", other, stiffness)


def _closed_form(speed, stiffness_a, stiffness_b):
    """Whirl speeds of a rigid rotor on two isotropic springs, in z = x + i y, signed (rad/s)."""
    arms = np.array([PLACES["a"] - 0.05, PLACES["b"] - 0.05])
    springs = np.array([stiffness_a, stiffness_b])
    K = np.array([[springs.sum(), springs @ arms], [springs @ arms, springs @ arms**2]])
    M = np.diag([MASS, DIAMETRAL])
    g = np.diag([0.0, POLAR])
    # M ω² − Ω g ω − K = 0
    top = np.hstack([np.zeros((2, 2)), np.eye(2)])
    bottom = np.hstack([la.solve(M, K), speed * la.solve(M, g)])
    return np.sort(la.eigvals(np.vstack([top, bottom])).real)


@pytest.mark.parametrize("speed", [0.0, 800.0])
def test_rigid_rotor_on_two_springs(speed):
    lateral = _body(components=("ux", "uy", "rx", "ry"))
    assembled = assemble({"drum": turning(lateral, 1.0)}, (_spring("a", 3e6), _spring("b", 1e6)))
    assert assembled.size == 4
    found = np.sort(modes_at_speed(assembled, speed).eigenvalues.imag)
    expected = np.sort(np.abs(_closed_form(speed, 3e6, 1e6)))
    assert found == pytest.approx(expected, rel=1e-10)


def test_free_rigid_body_has_no_frequency():
    modes = modes_at_speed(assemble({"drum": turning(_body(), 0.0)}, ()), 0.0)
    assert modes.frequency_hz.size == 0
    assert modes.zero_count == 12


@pytest.mark.parametrize("stiffness", [1e10, 1e16])
def test_stiff_springs_at_three_places_keep_the_digits_of_a_soft_one(stiffness):
    # Three seats on one line are one more than a rigid body needs, so one spring bends nothing.
    # Between the drum and a light beam the springs are stiff; the beam hangs on soft ones.
    beam = beam_superelement("beam", [-0.3, 0.1, 0.5], 0.05, 0.0, (2e11, 0.3, 7800.0), PLACES)
    joints = [_spring(name, stiffness, second="beam") for name in PLACES]
    soft = [_spring(name, 1e3, "beam") for name in ("a", "b")]
    rotors = {
        "drum": turning(_body(components=("ux", "uy", "rx", "ry")), 0.0),
        "beam": turning(beam, 0.0),
    }
    found = modes_at_speed(assemble(rotors, (*joints, *soft)), 0.0).eigenvalues.imag[:4]
    # two rigid bodies moving as one on 2 kN/m
    weight = beam.mass_kg
    center = (MASS * 0.05 + weight * 0.1) / (MASS + weight)
    tilt = DIAMETRAL + beam.inertia_kg_m2[0, 0]
    tilt += MASS * (0.05 - center) ** 2 + weight * (0.1 - center) ** 2
    arms = np.array([-0.3, 0.5]) - center
    K = 1e3 * np.array([[2.0, arms.sum()], [arms.sum(), arms @ arms]])
    expected = np.sqrt(la.eigh(K, np.diag([MASS + weight, tilt]), eigvals_only=True))
    # the beam bends by 1e3 / 3e6 of the soft springs' motion at most
    assert found == pytest.approx(np.repeat(expected, 2), rel=3e-4)
    assert found[0] == pytest.approx(found[1], rel=1e-9)


def test_clamped_casing_does_not_move():
    casing = _body()
    rotor = beam_superelement(
        "shaft", [0.0, 0.4, 0.8], 0.03, 0.0, (2e11, 0.3, 7800.0), {"a": 0.0, "b": 0.8}
    )

    mount = connect("mount", "drum.middle", rigid=("ux", "uy", "uz", "rx", "ry", "rz"))
    shaft = {"shaft": turning(rotor, 1.0)}
    drum = {"drum": turning(casing, 0.0)}
    seats = (_spring(end, 1e8, "shaft", "drum") for end in "ab")
    on_casing = assemble(shaft | drum, (*seats, mount))
    on_ground = assemble(shaft, tuple(_spring(end, 1e8, "shaft") for end in "ab"))
    for speed in (0.0, 500.0):
        found = modes_at_speed(on_casing, speed).frequency_hz
        assert found == pytest.approx(modes_at_speed(on_ground, speed).frequency_hz, rel=1e-9)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mass_kg": -1.0}, "mass_kg is -1.0"),
        ({"inertia_kg_m2": [1.0, 1.0, 0.0]}, "inertia_kg_m2 is"),
        ({"interface_positions_m": {}}, "has no interface"),
        ({"components": ("q",)}, "allowed are some of"),
        ({"center_of_gravity_m": [0.0, 1.0]}, "center_of_gravity_m is"),
    ],
)
def test_impossible_bodies(changes, message):
    values = {
        "mass_kg": 1.0,
        "center_of_gravity_m": [0.0, 0.0, 0.0],
        "inertia_kg_m2": [1.0, 1.0, 1.0],
        "interface_positions_m": {"a": 0.0},
    }
    with pytest.raises(SuperelementError, match=message):
        rigid_superelement("body", **{**values, **changes})


def test_exact_joint_of_a_rigid_body_carries_what_statics_says():
    # 10 kg with the centre of gravity at 0.3 m, hung on a spring at 0 and a pin at 1 m.
    body = rigid_superelement(
        "drum",
        10.0,
        [0.0, 0.0, 0.3],
        [0.4, 0.4, 0.2],
        {"spring": 0.0, "middle": 0.6, "pin": 1.0},
        components=("ux", "uy", "rx", "ry"),
    )
    pin = connect("pin", "drum.pin", rigid=("ux", "uy"))
    held = assemble({"drum": turning(body, 0.0)}, (_spring("spring", 2e5), pin))
    weight = 10.0 * 9.81
    # weight along −x on every coordinate of the body, as its mass matrix spreads it
    load = body.mass @ body.rigid_body_modes[:, 0] * -9.81
    rest = la.solve(held.stiffness, held.transformation.T @ load)
    still = np.zeros_like(rest)
    forces = joint_forces(held, 0.0, rest, still, still, {"drum": load}).bearings
    # moments about the pin: the spring carries 0.7 of the weight
    assert forces["spring"][0] == pytest.approx(-0.7 * weight, rel=1e-10)
    assert forces["pin"][0] == pytest.approx(-0.3 * weight, rel=1e-10)
