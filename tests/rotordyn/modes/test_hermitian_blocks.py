"""Bodies whose planes couple: Hermitian blocks in complex form.

Once a body of revolution in other modal coordinates, which changes no result; once a hub with
hinged blades, against Floquet multipliers of all its blades in the turning frame.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from bladed_hub import BladedHub
from rotors import (
    between_bearings,
    connect,
    mixed,
    one_rotor,
    polynomial_law,
    three_disk_element,
    turning_pairs,
    with_stress,
)
from sometimes import often

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.campbell.body_frames import campbell_seen_by_body
from solidwhirl.rotordyn.critical_speeds.map import critical_speed_map
from solidwhirl.rotordyn.critical_speeds.search import count_critical_speeds
from solidwhirl.rotordyn.exchange.multibody.body_fixed import body_fixed_form
from solidwhirl.rotordyn.modes.modal_truncation import truncated_system
from solidwhirl.rotordyn.modes.whirl import motion_at_speed
from solidwhirl.rotordyn.response.harmonic_response import harmonic_response, independent_loads
from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response
from solidwhirl.rotordyn.run_up.integration import run_up
from solidwhirl.rotordyn.run_up.speed_profile import SpeedProfile
from solidwhirl.rotordyn.stability import unstable_intervals
from solidwhirl.rotordyn.superelement.circumferential_orders import body_turns

# Of numbers that no slow motion enters.
SAME = 1e-9
LAW = polynomial_law((1.0, 2e-4, 1e-7), (1.0, 2e-4, 1e-7), top=6000.0)
INSIDE = rd.InternalDamping(stiffness_coefficient_s=2e-5)
CASES = {
    "conservative": lambda e: between_bearings(e, 7e7),
    "stressed": lambda e: between_bearings(e, 7e7),
    "free": one_rotor,
    "planes": lambda e: between_bearings(e, 7e7, 5e7),
    "damped": lambda e: between_bearings(e, 7e7, None, 700.0),
    "damped inside": lambda e: between_bearings(e, 7e7, None, 700.0, inside=INSIDE),
    "law": lambda e: between_bearings(e, 7e7, speed_law=LAW),
}


def systems(case):
    """A system and the same with modal coordinates that couple the planes."""
    body = three_disk_element()
    body = with_stress(body, 0.3) if case == "stressed" else body
    return CASES[case](body), CASES[case](mixed(body))


def rounding(system, rates):
    """What the change of coordinates, rounding K by eps, makes of |λ|: eps K/M over |λ|."""
    return 8 * system.size * np.finfo(float).eps * system.body_rate / np.abs(rates) + 1e-11 * rates


def dtypes(form):
    names = ("mass", "gyroscopic", "stiffness", "centrifugal_stiffness", "damping", "circulatory")
    return {name: getattr(form, name).dtype.kind for name in names}


def test_blocks_are_complex_only_where_planes_couple():
    plain, other = (rd.complex_form(s) for s in systems("damped inside"))
    assert set(dtypes(plain).values()) == {"f"}
    assert {dtypes(other)[k] for k in ("mass", "gyroscopic", "stiffness", "circulatory")} == {"c"}
    with_law = rd.complex_form(systems("law")[1])
    assert [law.motion.dtype.kind for law in with_law.laws] == ["f", "f"]
    # the matrices of z are those of the coordinates, with all bearings
    for system in (s for case in ("damped inside", "law") for s in systems(case)):
        form, speed = rd.complex_form(system), 700.0
        matrices, found = rd.matrices_at_speed(system, speed), form.at_speed(speed)
        motion = np.random.default_rng(1).standard_normal(system.size)
        for matrix, block in (
            (matrices.mass, found.mass),
            (matrices.damping + matrices.gyroscopic, found.velocity),
            (matrices.stiffness, found.stiffness),
        ):
            exact = form.to_complex(matrix @ motion)
            assert block @ form.to_complex(motion) == pytest.approx(
                exact, abs=1e-9 * np.abs(exact).max()
            )


def between_planes(body, name, across, along=0.0):
    """A body whose last two motions a matrix couples across the planes and along them."""
    matrix = getattr(body, name).copy()
    first, second = (side[-2:] for side in turning_pairs(body))
    size = np.sqrt(matrix[first[0], first[0]] * matrix[first[1], first[1]])
    for k, sign in ((0, 1.0), (1, -1.0)):
        matrix[first[k], second[1 - k]] += sign * across * size
        matrix[second[1 - k], first[k]] += sign * across * size
        for side in (first, second):
            matrix[side[k], side[1 - k]] += along * size
    return dataclasses.replace(body, **{name: matrix}), across * size


def test_a_small_coupling_of_planes_stays_where_another_matrix_has_a_large_one():
    """Left out, 1e-11 of a stiffness was 2e-8 of a response with an amplification of 2700."""
    body, size = between_planes(three_disk_element(), "stiffness", 5e-12)
    assert dtypes(rd.complex_form(between_bearings(body, 7e7)))["stiffness"] == "f"
    form = rd.complex_form(between_bearings(between_planes(body, "mass", 0.1, 0.2)[0], 7e7))
    # rounding of the sums with the bearings
    assert np.abs(form.stiffness.imag).max() == pytest.approx(size, rel=1e-3)


def test_a_matrix_that_a_turn_changes_has_no_complex_form():
    body = mixed(three_disk_element())
    change = np.zeros_like(body.mass)
    first, second = turning_pairs(body)
    change[first[-1], second[-2]] = change[second[-2], first[-1]] = 0.2 * body.mass[-1, -1]
    uneven = dataclasses.replace(body, mass=body.mass + change)
    assert body_turns(body) is not None and body_turns(uneven) is None
    assert rd.complex_form(between_bearings(uneven, 7e7)) is None


@pytest.mark.parametrize("speed", [0.0, 300.0, -1500.0])
@pytest.mark.parametrize("case", CASES)
def test_modes_are_the_same(case, speed):
    plain, other = systems(case)
    first, second = (rd.modes_at_speed(s, speed, 14) for s in (plain, other))
    allowed = rounding(plain, np.abs(first.eigenvalues))
    assert (np.abs(second.eigenvalues - first.eigenvalues) <= allowed).all()
    assert second.zero_count == first.zero_count
    whirl = [motion_at_speed(s, m.shapes, m.eigenvalues, speed).whirl
             for s, m in ((plain, first), (other, second))]  # fmt: skip
    # of a pair at rest either may come first
    assert speed == 0.0 or (whirl[0] == whirl[1]).all()
    matrices = rd.matrices_at_speed(other, speed)
    for value, shape in zip(second.eigenvalues, second.shapes.T, strict=True):
        terms = (value**2 * matrices.mass, value * (matrices.damping + matrices.gyroscopic))
        dynamic = sum(terms) + matrices.stiffness
        size = sum(np.abs(t) for t in terms) + np.abs(matrices.stiffness)
        assert np.abs(dynamic @ shape).max() < 1e-9 * (size @ np.abs(shape)).max()


@pytest.mark.parametrize("case", CASES)
def test_critical_speeds_are_the_same(case):
    plain, other = systems(case)
    first, second = (rd.critical_speeds(s, 1.0, 4000.0) for s in (plain, other))
    assert len(first) == len(second) > 3
    for one, two in zip(first, second, strict=True):
        assert two.speed_rad_s == pytest.approx(one.speed_rad_s, rel=SAME)
        # that of a motion that creeps is 1e7, with the digits of its frequency
        assert two.log_decrement == pytest.approx(one.log_decrement, rel=SAME, abs=1e-8)
        assert two.whirl == one.whirl
        matrices = rd.matrices_at_speed(other, two.speed_rad_s)
        velocity = matrices.damping + matrices.gyroscopic
        terms = (two.eigenvalue**2 * matrices.mass, two.eigenvalue * velocity, matrices.stiffness)
        size = sum(np.abs(t) for t in terms) @ np.abs(two.shape)
        assert np.abs(sum(terms) @ two.shape).max() < 1e-8 * size.max()
    if "damped" not in case:
        assert count_critical_speeds(other, 1.0, 4000.0).count == len(first)
    if case in ("conservative", "law"):
        stiffness = np.geomspace(1e6, 1e9, 7)
        maps = [
            critical_speed_map(s, ["rotor.left", "rotor.right"], stiffness, speed_max_rad_s=4000.0)
            for s in (plain, other)
        ]
        np.testing.assert_array_equal(maps[1].whirl, maps[0].whirl)
        assert maps[1].speed_rad_s == pytest.approx(maps[0].speed_rad_s, rel=SAME, nan_ok=True)


@pytest.mark.parametrize("case", ["conservative", "planes", "damped inside"])
def test_responses_are_the_same(case):
    plain, other = systems(case)
    load = [Unbalance(body="rotor", interface="left", moment_kg_m=1e-3, phase_rad=0.3)]
    speeds = np.linspace(20.0, 900.0, 40)  # enough points to split bearings of unlike planes off
    for speed in (speeds, speeds[:3]):
        first, second = (unbalance_response(s, load, speed).exciters[0] for s in (plain, other))
        scale = np.abs(first.translation_m).max()
        assert second.translation_m == pytest.approx(first.translation_m, abs=1e-7 * scale)
    # a load along x alone has circles of both senses
    along = np.zeros((1, plain.system.rotors["rotor"].element.size, 1), dtype=complex)
    along[0, 4] = 1.0
    found = []
    for system in (plain, other):
        force = independent_loads(system, {"rotor": along[:, :, 0]})[:, :, None]
        answer = harmonic_response(system, 400.0, speeds, force)
        assert answer.relative_residual.max() < 1e-9
        found.append(answer.displacement[:, :8, 0])
    assert found[1] == pytest.approx(found[0], abs=1e-7 * np.abs(found[0]).max())
    profile = SpeedProfile(times_s=[0.0, 0.02], speeds_rad_s=[100.0, 300.0])
    ends = [rd.End(body="rotor", interface=end) for end in ("left", "right")]
    how = {"step_s": 1e-4, "outputs": ends}
    runs = [run_up(s, profile, load, **how).translation_m for s in (plain, other)]
    assert runs[1] == pytest.approx(runs[0], abs=1e-6 * np.abs(runs[0]).max())


def test_unstable_speeds_are_the_same():
    first, second = (unstable_intervals(s, 10.0, 3000.0) for s in systems("damped inside"))
    assert len(first) == len(second) == 1
    for one, two in zip(first, second, strict=True):
        assert two.low_rad_s == pytest.approx(one.low_rad_s, rel=1e-6)
        assert (two.whirl, two.kind) == (one.whirl, one.kind)
        assert two.frequency_hz == pytest.approx(one.frequency_hz, rel=1e-6)


@pytest.mark.parametrize("case", ["conservative", "planes", "free"])
def test_diagrams_are_the_same_in_all_frames(case):
    plain, other = systems(case)
    speeds = np.linspace(0.0, 1200.0, 13)
    diagrams = [rd.campbell(s, speeds, branch_count=6) for s in (plain, other)]
    first, second = diagrams
    rates = 2.0 * np.pi * np.array([first.frequency_hz, second.frequency_hz])
    known = np.isfinite(rates[0])
    np.testing.assert_array_equal(np.isfinite(rates[1]), known)
    assert (np.abs(rates[1] - rates[0]) <= rounding(plain, rates[0]))[known].all()
    np.testing.assert_array_equal(second.whirl[:, 1:], first.whirl[:, 1:])
    seen = [
        campbell_seen_by_body(s, d, "rotor") for s, d in zip((plain, other), diagrams, strict=True)
    ]
    np.testing.assert_array_equal(seen[1].orders, seen[0].orders)
    assert seen[1].share == pytest.approx(seen[0].share, abs=1e-7, nan_ok=True)


@pytest.mark.parametrize("case", ["conservative", "damped", "law", "free"])
def test_fewer_modes_keep_the_complex_form(case):
    plain, other = (truncated_system(s, 12) for s in systems(case))
    assert rd.complex_form(other) is not None
    for speed in (0.0, 700.0):
        first, second = (rd.modes_at_speed(s, speed) for s in (plain, other))
        assert second.eigenvalues == pytest.approx(first.eigenvalues, rel=1e-7)
        assert second.zero_count == first.zero_count


def test_the_form_in_the_turning_frame_is_the_same():
    body = three_disk_element()
    first, second = (body_fixed_form(b, modes=8) for b in (body, mixed(body)))
    assert second.frequencies_hz == pytest.approx(first.frequencies_hz, rel=SAME)
    # modes of a pair are known up to a turn, which leaves these as they are
    for name in ("I3", "I4"):
        one, two = (np.abs(getattr(f, name)).reshape(3, -1, 2) ** 2 for f in (first, second))
        assert two.sum(axis=2) == pytest.approx(one.sum(axis=2), abs=1e-9 * max(one.max(), 1e-3))
    for name in ("I5", "stress_stiffening"):
        one, two = (np.linalg.norm(getattr(f, name)) for f in (first, second))
        assert two == pytest.approx(one, rel=1e-7, abs=1e-9)
    assert [c.passed for c in rd.check_superelement(mixed(body))] == [
        c.passed for c in rd.check_superelement(body)
    ]


# Springs on lag and flap that couple them, as a twist of the blade does; blades that rise.
STAGGERED = {"springs": np.array([[2.0, 0.7], [0.7, 5.0]]), "offset": 0.3, "cone": 0.2}
EYE, CROSS = np.eye(2), np.array([[0.0, 1.0], [-1.0, 0.0]])
HELD = {
    "same in all directions": (40.0 * EYE, 0.0 * EYE, 60.0 * EYE, 0.0 * EYE),
    "same and damped": (40.0 * EYE, 2.0 * EYE, 60.0 * EYE, EYE),
    "planes": (np.diag([40.0, 90.0]), 0.0 * EYE, np.diag([60.0, 30.0]), 0.0 * EYE),
    "cross terms": (
        np.diag([40.0, 90.0]) + 5.0 * CROSS,
        np.diag([1.0, 2.0]) + 0.3 * CROSS,
        60.0 * EYE,
        EYE,
    ),
}


def on_support(hub, hold):
    names = ("stiffness", "damping", "tilt", "drag")
    support = connect("support", "rotor.hub", **dict(zip(names, hold, strict=True)))
    return one_rotor(hub.superelement(), [support])


def test_a_bladed_hub_has_the_matrices_of_a_free_body():
    body = BladedHub(count=5, **STAGGERED).superelement()
    failed = [c.name for c in rd.check_superelement(body) if not c.passed]
    assert not failed
    # motion without stiffness, and no force in rigid motion at speed, as the axes are inertial
    change = body.stress_stiffening - body.spin_softening
    rigid = body.rigid_body_modes
    assert np.abs(rigid.T @ change @ rigid).max() < 1e-12 * np.abs(body.spin_softening).max()
    form = rd.complex_form(on_support(BladedHub(count=5, **STAGGERED), HELD["same and damped"]))
    # no choice of planes makes these real: the phase of a loop of couplings is kept by all
    loop = [(0, 1), (1, 2), (2, 3), (3, 0)]
    phases = [form.mass[i, j] + form.stiffness[i, j] for i, j in loop]
    assert abs(np.prod(phases).imag) > 1e-3 * abs(np.prod(phases))
    # the spin couples lag and flap of index 0, too
    assert np.abs(body.gyroscopic[np.ix_(form.rest, form.rest)]).max() > 0.1


@pytest.mark.parametrize(
    ("held", "count", "speed"),
    often(
        [(held, *hub) for held in HELD for hub in ((6, 2.5), (5, 4.0), (3, -1.7))],
        ("same in all directions", 6, 2.5),
        ("same and damped", 3, -1.7),
        ("planes", 3, -1.7),
        ("cross terms", 5, 4.0),
    ),
)
def test_bladed_hub_against_floquet_multipliers(held, count, speed):
    hub = BladedHub(count=count, **STAGGERED)
    system = on_support(hub, HELD[held])
    assert (rd.complex_form(system) is not None) == held.startswith("same")
    modes = rd.modes_at_speed(system, speed)
    period = 2.0 * np.pi / abs(speed)
    values = np.concatenate((modes.eigenvalues, modes.eigenvalues.conj(), modes.real_eigenvalues))
    assert values.size + modes.zero_count == 2 * system.size
    expected, found = hub.multipliers(speed, HELD[held]), np.exp(period * values)
    apart = np.abs(expected - found[:, None]).min(axis=1)
    assert (apart < 1e-8 * np.abs(found)).all()


@pytest.mark.parametrize(
    ("stiffness", "ranges"),
    [
        ((40.0, 40.0), [(3.568785, 5.740075)]),
        ((40.0, 90.0), [(3.736204, 5.235684), (5.354041, 7.799340)]),
    ],
)
def test_ground_resonance(stiffness, ranges):
    """Three blades with lag hinges: two of the modes in the plane meet and drive each other.

    The ends are those of the four equations of hub and lag (Coleman and Feingold 1958, NACA Report
    1351) with hub 7, blades 1, hinges at 0.2, springs of 2, solved apart from this program.
    """
    hub = BladedHub(count=3, springs=np.diag([2.0, 50.0]))
    support = connect("support", "rotor.hub", stiffness=stiffness, tilt=(100.0, 100.0))
    system = one_rotor(hub.superelement(), [support])
    found = unstable_intervals(system, 0.1, 12.0)
    assert [(i.low_rad_s, i.high_rad_s) for i in found] == [
        pytest.approx(ends, abs=1e-6) for ends in ranges
    ]
    assert all(i.opens and i.closes and i.kind == "flutter" for i in found)
