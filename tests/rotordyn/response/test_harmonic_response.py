"""Harmonic response against direct solutions, modal sums, and laws any linear structure obeys."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as la
from rotors import (
    connect,
    ground,
    one_rotor,
    polynomial_law,
    three_disk,
    twin,
    twin_bodies,
    twin_rotors,
    with_axial_and_torsion,
)

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.core.ledger import SYSTEMS
from solidwhirl.rotordyn.modes.complex_form import complex_form
from solidwhirl.rotordyn.response.coupled_circles import solve_split, split_system
from solidwhirl.rotordyn.response.harmonic_response import harmonic_response, independent_loads

# Points (Ω, ω) in rad/s: synchronous, below, above, and with the shaft at rest.
SPEEDS = np.array([0.0, 0.0, 150.0, 700.0, 700.0, 2600.0])
FREQUENCIES = np.array([90.0, 800.0, 150.0, 300.0, 1100.0, 3400.0])


INSIDE = rd.InternalDamping(stiffness_coefficient_s=2e-6)


def engine(ky=3e7, c=900.0, at_d=None, inside=INSIDE):
    """Counter-rotating shafts on damped bearings, internal damping; `ky` breaks the isotropy."""
    between = connect("between", "inner.C", "outer.C", 2e8, 400.0)
    held = [ground("inner", "A", 3e7, ky, c), ground("inner", "B", 3e7, 3e7, c)]
    bearings = (*held, ground("outer", "D", 5e7, 5e7, c) if at_d is None else at_d, between)
    return rd.assemble(twin_rotors(-1.4, internal_damping=inside), bearings, "inner")


def _loads(system, count=2, points=SPEEDS.size):
    random = np.random.default_rng(7)
    shape = (points, system.size, count)
    return random.standard_normal(shape) + 1j * random.standard_normal(shape)


def _dynamic_stiffness(system, speed, omega):
    m = rd.matrices_at_speed(system, speed)
    return m.stiffness + 1j * omega * (m.damping + m.gyroscopic) - omega**2 * m.mass


@pytest.mark.parametrize("kind", ["isotropic", "planes", "isotropic law"])
def test_solution_is_that_of_the_full_equations(kind):
    law = polynomial_law(*[(1.0, 2e-4)] * 2, *[(1.0, -1e-4)] * 2, top=3000.0)
    round_law = ground("outer", "D", 4e7, 4e7, 700.0, speed_law=law)
    at_d = round_law if kind == "isotropic law" else None
    system = engine(2e7 if kind == "planes" else 3e7, at_d=at_d)
    # Isotropic: in circles, half of the coordinates; else all at once.
    assert (complex_form(system) is None) == (kind == "planes")
    loads = _loads(system)
    found = harmonic_response(system, SPEEDS, FREQUENCIES, loads)
    for speed, omega, load, q in zip(SPEEDS, FREQUENCIES, loads, found.displacement, strict=True):
        direct = la.solve(_dynamic_stiffness(system, speed, omega), load)
        # Condition 1e4 to 1e6 here; 1e-10 is what the half form must keep.
        np.testing.assert_allclose(q, direct, rtol=0, atol=1e-10 * np.abs(direct).max())
    assert found.relative_residual.max() < 1e-11


# Bearings at D that are not the same in all directions.
ODD_LAW = polynomial_law((1.0, 2e-4), (0.4, 0.0, 1e-7), (1.0, -1e-4), (0.5,), top=3000.0)
PLANES = ((6e7, 4e7), (900.0, 100.0))
ODD = {
    "planes": connect("D", "outer.D", None, *PLANES),
    "cross": connect("D", "outer.D", None, [[4e7, 1e7], [-2e7, 4e7]], [[500, 80], [90, 500]]),
    "tilt": connect("D", "outer.D", None, *PLANES, tilt=(1e5, 4e5), drag=[[5.0, 1.0], [0.0, 2.0]]),
    "law": connect("D", "outer.D", None, 4e7, 700.0, speed_law=ODD_LAW),
}


@pytest.mark.parametrize("kind", ODD)
def test_circles_coupled_by_bearings_solve_the_full_equations(kind):
    system = engine(2e7, at_d=ODD[kind])
    assert complex_form(system) is None and split_system(system, 500.0) is not None
    random = np.random.default_rng(11)
    speeds, frequencies = random.uniform(0.0, 3000.0, (2, 40))
    speeds[:8] = speeds[0]
    loads = _loads(system, 2, 40)
    found = harmonic_response(system, speeds, frequencies, loads)
    for at in range(40):
        direct = la.solve(_dynamic_stiffness(system, speeds[at], frequencies[at]), loads[at])
        error = np.abs(found.displacement[at] - direct).max()
        assert error < 1e-9 * np.abs(direct).max()
    assert found.relative_residual.max() < 1e-10


@pytest.mark.parametrize("kind", ["round", "undamped", *ODD])
def test_many_frequencies_at_one_speed_share_its_modes(kind):
    c = 0.0 if kind == "undamped" else 900.0
    system = engine(3e7 if kind == "round" else 2e7, c, ODD.get(kind), inside=None)
    random = np.random.default_rng(5)
    speeds = np.repeat([0.0, 400.0, 2600.0], 30)
    frequencies = random.uniform(0.0, 3500.0, speeds.size)
    loads = _loads(system, 2, speeds.size)
    loads[40:42] = 0.0
    with SYSTEMS.counted() as counts:
        found = harmonic_response(system, speeds, frequencies, loads)
    assert counts == {"eigenproblems": 3}
    for at in range(speeds.size):
        direct = la.solve(_dynamic_stiffness(system, speeds[at], frequencies[at]), loads[at])
        error = np.abs(found.displacement[at] - direct).max()
        assert error <= 1e-10 * np.abs(direct).max()
    assert found.relative_residual.max() < 1e-11


def test_a_point_at_a_resonance_of_the_bodies_alone_is_solved_in_full():
    shaft = twin_bodies()[0]
    bearings = [ground("rotor", end, 5e7, 5e7, cx=400.0) for end in ("A", "B")]
    system = one_rotor(shaft, bearings)
    undamped = one_rotor(shaft, [ground("rotor", end, 5e7, 5e7) for end in ("A", "B")])
    at = rd.modes_at_speed(undamped, 300.0).eigenvalues[1].imag
    frequencies = np.append(np.linspace(50.0, 900.0, 30), at)
    loads = _loads(system, 1, 1)
    with SYSTEMS.counted() as counts:
        found = harmonic_response(system, 300.0, frequencies, loads)
    assert counts["responses"] <= 1
    direct = la.solve(_dynamic_stiffness(system, 300.0, at), loads[0])
    assert np.abs(found.displacement[-1] - direct).max() < 1e-9 * np.abs(direct).max()


def test_resonance_of_the_isotropic_part_alone_is_passed():
    # The mean of the two planes has a resonance where the system has none.
    shaft = twin_bodies()[0]

    def system(kx, ky):
        return one_rotor(shaft, [ground("rotor", end, kx, ky) for end in ("A", "B")])

    odd = system(6e7, 4e7)
    at = rd.critical_speeds(system(5e7, 5e7), 1.0, 3000.0)[0].speed_rad_s
    points = np.concatenate((np.linspace(100.0, 200.0, 30), at * (1 + np.array([0.0, 1e-12]))))
    loads = _loads(odd, 1, 32)
    found = harmonic_response(odd, points, points, loads).displacement
    assert solve_split(split_system(odd, 1.0), points, points, loads)[1][-2:].all()
    for point, load, q in zip(points, loads, found, strict=True):
        direct = la.solve(_dynamic_stiffness(odd, point, point), load)
        np.testing.assert_allclose(q, direct, rtol=0, atol=1e-9 * np.abs(direct).max())


def test_axial_motion_and_torsion_are_solved_beside_the_circles():
    shaft = with_axial_and_torsion(twin_bodies()[0], 0.4, 0.02, "A", "B")
    free = shaft.interface_index("B", "uz"), shaft.interface_index("B", "rz")
    bearings = [
        ground("rotor", "A", 1e7, cx=50.0, axial_stiffness_n_per_m=1e6, rigid=("rz",)),
        ground("rotor", "B", 1e7, cx=50.0),
    ]
    system = one_rotor(shaft, bearings)
    body = np.zeros((1, shaft.size), complex)
    body[0, list(free)] = 3.0, 2.0j
    body[0, shaft.interface_index("A", "ux")] = 5.0
    load = independent_loads(system, {"rotor": body})
    q = harmonic_response(system, 200.0, 700.0, load[:, :, None]).displacement[0, :, 0]
    direct = la.solve(_dynamic_stiffness(system, 200.0, 700.0), load[0])
    np.testing.assert_allclose(q, direct, rtol=0, atol=1e-11 * np.abs(direct).max())


def test_stiff_supports_cost_no_digits():
    # Bearings of 1e16 N/m beside rigid ones: what remains is their own softness, 1e-8 of the shaft.
    points = np.array([300.0, 900.0, 1500.0])

    def response(system):
        element = system.system.rotors["inner"].element
        load = np.zeros((1, element.size), complex)
        load[0, element.size - 2] = 1.0
        force = independent_loads(system, {"inner": load})[:, :, None]
        q = harmonic_response(system, points, points, force).displacement[..., 0]
        return q @ system.transformation[system.body_slices["inner"]][-2]

    stiff, rigid = (response(twin(support=stiffness)) for stiffness in (1e16, None))
    np.testing.assert_allclose(stiff, rigid, rtol=1e-8)


def test_no_load_means_no_motion_even_where_the_system_drifts():
    free = one_rotor(twin_bodies()[0], [])
    none = harmonic_response(free, 100.0, [0.0, 50.0], np.zeros((1, free.size, 1)))
    assert not none.displacement.any()
    load = np.zeros((1, free.size, 1))
    load[0, 0] = 1.0
    with pytest.raises(rd.AnalysisError, match=r"speed 100 rad/s and frequency 0 rad/s.*drift"):
        harmonic_response(free, 100.0, 0.0, load)


@pytest.mark.parametrize("system", [twin(), three_disk(0.0, 0.0)], ids=["twin", "three disks"])
def test_undamped_resonance_is_refused(system):
    critical = rd.critical_speeds(system, 1.0, 2000.0)[0].speed_rad_s
    load = np.zeros((1, system.size, 1), complex)
    load[0, :2, 0] = 1.0, -1j
    message = rf"speed {critical:.6g}\d* rad/s .*undamped resonance"
    for others in ([50.0], np.linspace(10.0, 50.0, 40)):
        points = np.append(others, critical)
        with pytest.raises(rd.AnalysisError, match=message):
            harmonic_response(system, points, points, load)
    # One part in a million beside it there is an answer.
    beside = harmonic_response(system, critical * 1.000001, critical * 1.000001, load)
    assert beside.relative_residual.max() < 1e-6


@pytest.mark.parametrize(
    ("speeds", "frequencies", "shape", "message"),
    [
        (np.nan, 1.0, (1, "n", 1), "speeds_rad_s needs finite"),
        ([1.0, 2.0], [1.0, 2.0, 3.0], (1, "n", 1), "speeds_rad_s needs finite numbers, one or 3"),
        (1.0, -1.0, (1, "n", 1), "frequencies_rad_s holds -1.0"),
        (1.0, 1.0, ("n",), "loads has shape"),
        (1.0, [1.0, 2.0], (3, "n", 1), "loads has shape"),
        (1.0, 1.0, (1, 5, 1), "loads has shape"),
    ],
)
def test_wrong_arguments_are_refused(speeds, frequencies, shape, message):
    system = three_disk()
    load = np.ones([system.size if length == "n" else length for length in shape])
    with pytest.raises(rd.AnalysisError, match=message):
        harmonic_response(system, speeds, frequencies, load)


def test_loads_on_bodies_are_checked():
    system = three_disk()
    wrong = (np.ones(3), r"body_loads\['rotor'\] has shape \(3,\)")
    for loads, message in (({}, "body_loads is empty"), ({"rotor": wrong[0]}, wrong[1])):
        with pytest.raises(rd.AnalysisError, match=message):
            independent_loads(system, loads)
    with pytest.raises(rd.AnalysisError, match="not finite"):
        harmonic_response(system, 1.0, 1.0, np.full((1, system.size, 1), np.inf))
