"""Spectra solved at half size: the same eigenvalues and modes as the whole problem has."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as la
from rotors import connect, eigenvalues_of, state_eigenvalues, steel_shaft, turning

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.modes.split_spectrum import planes_apart, split_spectrum

ALL = ("ux", "uy", "uz", "rx", "ry", "rz")
SPEED = 900.0


def _engine(
    stiffness=((2e7, 0.0), (0.0, 2e7)),
    damping=0.0,
    components=("ux", "uy", "rx", "ry"),
    free=False,
    **own,
):
    """Two spools of different speed and sense on a bearing between them and three to the ground.

    Free, the three join a long body to the spools instead.
    """
    ends = {"left": 0.0, "right": 0.7}
    rotors = {}
    for name, ratio, radius in (("a", 1.0, 0.02), ("b", -1.3, 0.035)):
        own_shape = (np.linspace(0.0, 0.7, 5), radius, ends, [(0.25, 9.0, 0.15, 0.09)])
        element = steel_shaft(name, *own_shape, inner=0.6 * radius, components=components)
        rotors[name] = turning(element, ratio, **own)
    if free:
        long = (np.linspace(-0.1, 0.8, 4), 0.06, ends)
        frame = steel_shaft("frame", *long, inner=0.05, components=components)
        rotors["frame"] = turning(frame, 0.0)
    places = {"a.left": None, "a.right": None, "b.left": None, "b.right": "a.right"}
    bearings = []
    for first, second in places.items():
        below = f"frame.{first[2:]}" if free else None
        bearings.append(connect(first, first, second or below, np.array(stiffness), damping))
    return rd.assemble(rotors, tuple(bearings))


def _whole(assembled, speed):
    """Eigenvalues of the companion matrix of the whole system, with Im λ > 0."""
    values = eigenvalues_of(assembled, speed)
    values = values[values.imag > 1.0]
    return values[np.argsort(values.imag)]


def _check_shapes(assembled, speed, values, shapes):
    m, c, g, k = rd.matrices_at_speed(assembled, speed)
    for value, shape in zip(values, shapes.T, strict=True):
        parts = [value**2 * m @ shape, value * (c + g) @ shape, k @ shape]
        assert la.norm(sum(parts)) < 1e-9 * max(la.norm(p) for p in parts)


CASES = {
    "isotropic": {},
    "isotropic, damped": {"damping": 500.0},
    "internal damping": {
        "damping": 500.0,
        "internal_damping": rd.InternalDamping(stiffness_coefficient_s=3e-6),
    },
    "free, damped": {"damping": 500.0, "free": True},
    "planes differ": {"stiffness": ((2e7, 0.0), (0.0, 5e6))},
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("speed", [SPEED, -SPEED])
def test_eigenvalues_and_residuals(case, speed):
    assembled = _engine(**CASES[case])
    modes = rd.modes_at_speed(assembled, speed)
    expected = _whole(assembled, speed)
    lowest = slice(0, 16)
    distance = np.abs(modes.eigenvalues[lowest, None] - expected).min(axis=1)
    # the companion matrix itself keeps about 1e-16 of its largest eigenvalue, 1e6 rad/s
    assert (distance < 1e-8 * np.abs(modes.eigenvalues[lowest])).all()
    _check_shapes(assembled, speed, modes.eigenvalues[lowest], modes.shapes[:, lowest])


def test_anisotropic_system_is_solved_by_planes_and_isotropic_by_halves():
    apart, even = _engine(**CASES["planes differ"]), _engine()
    assert planes_apart(apart) is not None
    assert split_spectrum(apart, rd.matrices_at_speed(apart, SPEED), SPEED, 8) is None
    assert split_spectrum(even, rd.matrices_at_speed(even, SPEED), SPEED, 8) is not None
    crossed = _engine(stiffness=((2e7, 3e6), (3e6, 2e7)))
    assert planes_apart(crossed) is None


@pytest.mark.parametrize("case", ["isotropic", "isotropic, damped", "free, damped"])
def test_families_are_the_senses_of_whirl(case):
    modes = rd.modes_at_speed(_engine(**CASES[case]), SPEED, 12)
    assembled = _engine(**CASES[case])
    for family, shape in zip(modes.family, modes.shapes.T, strict=True):
        body = assembled.transformation @ shape
        x, y = body[0], body[1]
        # x + i y of a circle is one exponential: Y = -i X forward, +i X backward
        assert y == pytest.approx(-1j * family * x, abs=1e-9 * abs(x) + 1e-15)


def test_free_motions_are_counted_as_in_the_whole_problem():
    modes = rd.modes_at_speed(_engine(**CASES["free, damped"]), SPEED)
    m, c, g, k = rd.matrices_at_speed(_engine(**CASES["free, damped"]), SPEED)
    n = len(m)
    assert modes.zero_count == 2 * n - 2 * modes.eigenvalues.size - modes.real_eigenvalues.size
    # drift of two directions, place and velocity; tilts turn steadily or, as one nutation, whirl
    assert modes.zero_count == 6
    scale = 1.0 / np.sqrt(np.diag(m))
    values = state_eigenvalues(*(scale[:, None] * a * scale for a in (m, c + g, k)))
    assert (np.abs(values) < 1.0).sum() == modes.zero_count


def test_axial_motion_and_torsion_stand_beside():
    whole, lateral = _engine(components=ALL), _engine()
    modes = rd.modes_at_speed(whole, SPEED)
    beside = modes.family == 0
    kept = modes.eigenvalues[~beside][:12]
    assert kept == pytest.approx(rd.modes_at_speed(lateral, SPEED).eigenvalues[:12], rel=1e-10)
    # both bodies slide and turn freely: two zeros each for position and velocity
    assert modes.zero_count == 8
    shear = np.sqrt(2e11 / 2.6 / 7800.0)
    assert modes.eigenvalues[beside].imag.min() < np.pi * shear / 0.7


def test_spin_couples_motions_of_order_0():
    """A body whose G ties axial motion to torsion, as the radial motion of a solid is tied."""
    plain = _engine(components=ALL)
    rotors, bearings = plain.system.rotors, plain.system.bearings
    element = rotors["a"].element
    axial, torsion = (
        next(i for i, c in enumerate(element.coordinates) if c.component == component)
        for component in ("uz", "rz")
    )
    gyroscopic = np.array(element.gyroscopic)
    gyroscopic[axial, torsion], gyroscopic[torsion, axial] = 5.0, -5.0
    own = replace(rotors["a"], element=replace(element, gyroscopic=gyroscopic))
    tied = rd.assemble({**rotors, "a": own}, bearings)
    modes = rd.modes_at_speed(tied, SPEED)
    beside = modes.family == 0
    assert beside.any()
    _check_shapes(tied, SPEED, modes.eigenvalues[beside], modes.shapes[:, beside])
    before = rd.modes_at_speed(plain, SPEED)
    before = before.eigenvalues[before.family == 0]
    assert np.abs(modes.eigenvalues[beside, None] - before).min(axis=1).max() > 1.0
