"""Assembly: faults are named together, and what should not matter does not."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import scipy.linalg as la
from hypothesis import given, settings
from hypothesis import strategies as st
from rotors import (
    connect,
    ground,
    hub,
    one_rotor,
    pinned,
    plane_spring,
    turning,
    twin,
    twin_bearings,
    twin_bodies,
    twin_rotors,
)

from solidwhirl import rotordyn as rd

JOINED = ("ux", "uy", "rx", "ry")
LATERAL = np.array([True, True, False, True, True, False])


def _frequencies(system, speed=1200.0, count=12):
    return rd.modes_at_speed(system, speed, count).frequency_hz


def test_order_and_ends_do_not_matter():
    rotors = twin_rotors(-1.0)
    backwards = dict(reversed(rotors.items()))
    for joint in (None, 3e7):
        *rest, shafts = twin_bearings(joint=joint)
        expected = _frequencies(rd.assemble(rotors, (*rest, shafts)))
        turned = dataclasses.replace(shafts, first=shafts.second, second=shafts.first)
        for bodies, bearings in ((backwards, (shafts, *rest[::-1])), (rotors, (*rest, turned))):
            found = _frequencies(rd.assemble(bodies, bearings))
            np.testing.assert_allclose(found, expected, rtol=1e-9)


def _stepped_shaft(stations, interfaces, disks=()):
    # Radii by position, so that each part gets its own.
    middle = 0.5 * (stations[:-1] + stations[1:])
    outer = np.where(middle < 0.45, 0.03, 0.04)
    return rd.beam_superelement(
        "part", stations, outer, 0.0, (2e11, 0.3, 7800.0), interfaces, disks
    )


def test_splitting_a_shaft_changes_nothing():
    stations = np.linspace(0, 1, 21)
    disk = rd.Disk(name="d", position_m=0.7, mass_kg=30.0, polar_kg_m2=0.5, diametral_kg_m2=0.3)
    whole = _stepped_shaft(stations, {"a": 0.0, "b": 1.0}, [disk])
    left = _stepped_shaft(stations[:7], {"a": 0.0, "cut": 0.3})
    middle = _stepped_shaft(stations[6:13], {"cut": 0.3, "next": 0.6})
    right = _stepped_shaft(stations[12:], {"next": 0.6, "b": 1.0}, [disk])
    one = one_rotor(whole, [ground("rotor", "a", 1e8), ground("rotor", "b", 2e8)])
    parts = {"left": turning(left), "middle": turning(middle), "right": turning(right)}
    joints = (
        ground("left", "a", 1e8),
        ground("right", "b", 2e8),
        connect("cut", "left.cut", "middle.cut", rigid=JOINED),
        connect("next", "right.next", "middle.next", rigid=JOINED),
    )
    three = rd.assemble(parts, joints)
    assert three.size == one.size
    for speed in (0.0, 800.0):
        found, expected = (_frequencies(system, speed, 20) for system in (three, one))
        np.testing.assert_allclose(found, expected, rtol=1e-9)


@pytest.mark.parametrize("ratio", [1.0, -1.0, 1.7])
def test_turning_all_shafts_the_other_way_mirrors_the_whirl(ratio):
    with_it, against = twin(ratio=ratio), twin(ratio=-ratio, inner_ratio=-1.0)
    modes, mirrored = rd.modes_at_speed(with_it, 1200.0, 8), rd.modes_at_speed(against, 1200.0, 8)
    np.testing.assert_allclose(mirrored.frequency_hz, modes.frequency_hz, rtol=1e-10)
    swap = {"forward": "backward", "backward": "forward", "mixed": "mixed", "straight": "straight"}
    directions = rd.whirl_direction(with_it, modes.shapes)
    expected = np.vectorize(swap.get)(directions)
    assert (rd.whirl_direction(against, mirrored.shapes) == expected).all()


@settings(max_examples=6, deadline=None, derandomize=True)
@given(exponents=st.lists(st.floats(5, 9), min_size=8, max_size=8))
def test_loops_of_bearings_equal_plain_addition(exponents):
    """Relative coordinates along a tree, against springs added in the bodies' own coordinates."""
    inner, outer = twin_bodies()
    k = 10.0 ** np.array(exponents)
    ends = (
        ("inner.A", None), ("inner.B", None), ("outer.C", "inner.C"), ("outer.D", "inner.B"),
        ("outer.D", None),
    )  # fmt: skip
    bearings = []
    for index, (first, second) in enumerate(ends):
        kx, ky = k[index], k[(index + 3) % 8]
        cross = 0.3 * np.sqrt(kx * ky)
        bearings.append(connect(f"{index}", first, second, [[kx, cross], [cross, ky]]))
    system = rd.assemble(twin_rotors(-1.0), tuple(bearings))

    plain = la.block_diag(inner.stiffness, outer.stiffness)
    mass = la.block_diag(inner.mass, outer.mass)
    start = {"inner": 0, "outer": inner.size}
    bodies = {"inner": inner, "outer": outer}
    for bearing in bearings:
        rows = np.zeros((2, mass.shape[0]))
        for sign, end in zip((1, -1), bearing.ends, strict=False):
            for i, c in enumerate(("ux", "uy")):
                at = start[end.body] + bodies[end.body].interface_index(end.interface, c)
                rows[i, at] += sign
        plain += rows.T @ bearing.stiffness_n_per_m @ rows
    values = la.eigh(plain, mass, eigvals_only=True)
    found = (2 * np.pi * _frequencies(system, 0.0, 8)) ** 2
    # The plain way loses digits: eps times the highest ω², with a factor for the size.
    assert (np.abs(found - values[:8]) < 1e-14 * values[-1]).all()
    assert 1e-14 * values[-1] < 1e-2 * values[0], "the comparison is too weak"
    assert (np.isin(system.transformation, [0.0, 1.0])).all()


def test_rigid_bearing_to_ground_removes_its_coordinates():
    inner, _ = twin_bodies()
    assert one_rotor(inner).size == inner.size
    held = one_rotor(inner, [pinned("rotor", "A")])
    assert held.size == inner.size - 2
    row = inner.interface_index("A", "uy")
    assert not held.transformation[row].any()


def test_axial_tilt_and_torsion_act_on_their_components():
    tilt = np.array([[3.0, 1.0], [1.0, 5.0]])
    drag = {"tilt_damping_n_m_s_per_rad": 2 * tilt}
    system = one_rotor(hub(), [connect("t", "rotor.hub", tilt=tilt, **drag)])
    np.testing.assert_array_equal(system.stiffness[2:, 2:], tilt)
    np.testing.assert_array_equal(system.damping[2:, 2:], 2 * tilt)
    own = {"axial_stiffness_n_per_m": 4.0, "torsion_damping_n_m_s_per_rad": 6.0}
    axial = connect("a", "rotor.hub", **own)
    stiffness, damping = axial.matrices()
    assert stiffness[2, 2] == 4.0 and damping[5, 5] == 6.0
    with pytest.raises(rd.AssemblyError, match=r"needs components \['uz', 'rz'\]"):
        one_rotor(hub(), [axial])


def test_all_faults_are_listed_at_once():
    rotors = {"a": turning(hub(), 2.0), "b": turning(hub(), np.nan)}
    hub_of_a, spring = "a.hub", {"stiffness": 1.0}
    bearings = (
        connect("1", "c.hub", **spring),
        connect("1", "a.rim", **spring),
        connect("2", hub_of_a, stiffness=np.eye(3)),
        connect("3", hub_of_a, damping=np.full((2, 2), np.inf)),
        connect("4", hub_of_a, hub_of_a, **spring),
        connect("5", hub_of_a, rigid=("ux", "u")),
        connect("6", hub_of_a, rigid=("ux",), **spring),
        connect("7", hub_of_a, axial_stiffness_n_per_m=np.nan),
    )
    with pytest.raises(rd.AssemblyError) as caught:
        rd.assemble(rotors, bearings, reference="a")
    expected = [
        "rotor 'b': speed_ratio is nan",
        "reference rotor 'a' has speed_ratio 2.0",
        "bearing name '1' occurs 2 times",
        "bearing '1': c.hub: no rotor 'c'; there are ['a', 'b']",
        "bearing '1': a.rim: rotor 'a' has interfaces ['hub']",
        "bearing '2': stiffness_n_per_m has shape (3, 3)",
        "bearing '3': damping_n_s_per_m is [[inf, inf], [inf, inf]]",
        "bearing '4': both ends are a.hub",
        "bearing '5': rigid components ['u'] are unknown",
        "bearing '6': ux is rigid and has stiffness or damping",
        "bearing '7': axial_stiffness_n_per_m is nan",
    ]
    for text in expected:
        assert sum(text in problem for problem in caught.value.problems) == 1, text
    assert len(caught.value.problems) == len(expected)


FIXED = connect("f", "a.hub", rigid=JOINED)
HELD = hub(stiffness=plane_spring(1e3, 0.0, 10.0), present=LATERAL)


@pytest.mark.parametrize(
    ("rotors", "more", "message"),
    [
        ({"a": turning(hub())}, {"reference": "x"}, "reference 'x' is not a rotor"),
        ({}, {}, "there are no rotors"),
        ({"a": turning(hub())}, {"bearings": (FIXED,)}, "nothing can move"),
        ({"a": turning(HELD)}, {}, "must clear rigid_body_present"),
    ],
)
def test_systems_that_can_not_be_are_refused(rotors, more, message):
    with pytest.raises(rd.AssemblyError, match=message):
        rd.assemble(rotors, **{"bearings": (), **more})


def test_one_centrifugal_effect_without_the_other_is_refused():
    inner, _ = twin_bodies()
    softening = np.zeros((inner.size, inner.size))
    at = inner.interface_index("A", "ry")
    softening[at, at] = 0.1
    for name in ("spin_softening", "stress_stiffening"):
        alone = dataclasses.replace(inner, **{name: softening})
        with pytest.raises(rd.AssemblyError, match="use both effects or none"):
            one_rotor(alone)
    both = dataclasses.replace(inner, spin_softening=softening, stress_stiffening=softening)
    assert one_rotor(both).size == inner.size


def test_rounding_in_rigid_motion_is_removed():
    inner, _ = twin_bodies()
    rng = np.random.default_rng(1)
    root = np.sqrt(np.diag(inner.mass))
    noise = rng.standard_normal((inner.size, inner.size))
    # Noise of the size that reduction leaves: 1e-12 of the largest stiffness.
    size = np.abs(inner.stiffness / np.outer(root, root)).max() * 1e-12
    noisy = inner.stiffness + size * np.outer(root, root) * (noise + noise.T)
    system = one_rotor(dataclasses.replace(inner, stiffness=noisy))
    for speed, zeros in ((0.0, 8), (500.0, 6)):
        modes = rd.modes_at_speed(system, speed)
        assert modes.zero_count == zeros and modes.negative_stiffness_count == 0
