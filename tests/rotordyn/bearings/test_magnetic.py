"""Magnetic bearings against a closed form, other formulations and the exact H∞ norm."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as la
from rotors import one_rotor, steel_shaft

from solidwhirl.rotordyn import (
    AnalysisError,
    Bearing,
    End,
    InternalDamping,
    Rotor,
    assemble,
    matrices_at_speed,
    modes_at_speed,
    rigid_superelement,
)
from solidwhirl.rotordyn.assembly.coordinates import seat_motion
from solidwhirl.rotordyn.assembly.magnetic_laws import MagneticLaw
from solidwhirl.rotordyn.assembly.system import at_rate, at_whirl_ratio, bearing_force_rows
from solidwhirl.rotordyn.bearings import controllers as ct
from solidwhirl.rotordyn.bearings.magnetic import MagneticBearing
from solidwhirl.rotordyn.response.unbalance import Unbalance, unbalance_response
from solidwhirl.rotordyn.stability.intervals import unstable_intervals
from solidwhirl.rotordyn.stability.magnetic_loops import (
    MagneticLoop,
    magnetic_sensitivity,
    system_sensitivity,
)


def both(controller):
    return ct.side_by_side(controller, controller)


def loop(name, bearing, actuator, sensor=None):
    ends = (End(body="rotor", interface=i) for i in (actuator, sensor or actuator))
    actuator, sensor = ends
    return MagneticLoop(name=name, bearing=bearing, actuator=actuator, sensor=sensor)


def point_mass():
    body = rigid_superelement(
        "rotor", 1.0, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), {"a": 0.0}, components=("ux", "uy")
    )
    return one_rotor(body)


def test_closed_form_of_a_point_mass():
    """Go = (0.5 s + 3)/(s² − 1): |Gs| is largest at 1.4295 rad/s, 4.250."""
    bearing = MagneticBearing(
        current_stiffness_n_per_a=1.0,
        negative_stiffness_n_per_m=1.0,
        controller=both(ct.pid(3.0, 0.0, 0.5)),
    )
    found = magnetic_sensitivity(point_mass(), [loop("m", bearing, "a")], 0.0)
    # |Gs|² = (u + 1)² / ((2 − u)² + u/4) with u = ω² is stationary at u = 47/23
    for axis in found.axes:
        assert axis.peak == pytest.approx(4.250, abs=6e-4)
        assert axis.frequency_rad_s == pytest.approx(1.4295, abs=6e-5)
        assert axis.frequency_rad_s**2 == pytest.approx(47 / 23, rel=1e-6)
        assert axis.zone == "C"
    roots = np.roots([1.0, 0.5, 2.0])
    np.testing.assert_allclose(
        np.sort_complex(found.eigenvalues), np.sort_complex(np.tile(roots, 2)), atol=1e-12
    )
    assert found.message.startswith("zone C")


def test_unstable_loop_is_told_and_not_rated():
    weak = MagneticBearing(
        current_stiffness_n_per_a=1.0,
        negative_stiffness_n_per_m=1.0,
        controller=both(ct.pid(0.5, 0.0, 0.5)),
    )
    found = magnetic_sensitivity(point_mass(), [loop("m", weak, "a")], 0.0)
    assert not found.is_stable and found.axes == ()
    assert found.message.startswith("unstable")


def beam_rotor():
    disks = [(0.35, 8.0, 0.05, 0.03), (0.05, 3.0, 0.01, 0.006)]
    stations = np.linspace(0.0, 0.8, 9)
    places = {"left": 0.1, "seen": 0.12, "right": 0.7}
    inside = InternalDamping(stiffness_coefficient_s=2e-6)
    shaft = steel_shaft("rotor", stations, 0.02, places, disks)
    return one_rotor(shaft, internal_damping=inside)


def chain(p=2e4, d=60.0):
    parts = (ct.low_pass(6e4, 0.7), ct.delay(1e-5, 2), ct.notch(3000.0, 0.3, 0.6))
    return ct.series(ct.pid(p, 2e4, d, 3e4), *parts)


def beam_loops():
    own = {"current_stiffness_n_per_a": 200.0, "negative_stiffness_n_per_m": 1e6}
    bearing = MagneticBearing(**own, controller=both(chain()))
    other = MagneticBearing(**own, controller=ct.side_by_side(chain(), chain(1.5e4, 50.0)))
    return [loop("left", bearing, "left", "seen"), loop("right", other, "right")]


def whole_state_space(system, loops, speed):
    """x = (q, q', controllers), e into all sensors, y = signal after the summing points.

    Signals are joined by feedback of two systems, not by the matrices of the package.
    """
    m, c, g, k = matrices_at_speed(system, speed)
    n = len(m)
    magnets = np.vstack([seat_motion(system, one.actuator)[:2] for one in loops])
    sensors = np.vstack([seat_motion(system, one.sensor)[:2] for one in loops])
    ks = np.repeat([one.bearing.negative_stiffness_n_per_m for one in loops], 2)
    ki = np.repeat([one.bearing.current_stiffness_n_per_a for one in loops], 2)
    k = k - magnets.T @ np.diag(ks) @ magnets
    plant_a = np.block([[np.zeros((n, n)), np.eye(n)], [-la.solve(m, k), -la.solve(m, c + g)]])
    plant_b = np.vstack((np.zeros((n, len(ki))), la.solve(m, magnets.T * ki)))
    plant_c = np.hstack((sensors, np.zeros_like(sensors)))
    h = ct.side_by_side(*(one.bearing.controller for one in loops))
    a = np.block([[plant_a - plant_b @ h.d @ plant_c, -plant_b @ h.c], [h.b @ plant_c, h.a]])
    b = np.vstack((-plant_b @ h.d, h.b))
    return a, b, np.hstack((plant_c, np.zeros((len(ki), len(h.a)))))


def has_crossing(a, b, c, level):
    """Whether |1 + c (iω − a)⁻¹ b| is a level somewhere, by an eigenvalue of the Hamiltonian."""
    r = 1.0 - level**2
    d = np.ones((1, 1))
    h11 = a - b @ d.T @ c / r
    top = np.hstack((h11, -level * b @ b.T / r))
    low = np.hstack((level * c.T @ c / r, -h11.T))
    values = la.eigvals(np.vstack((top, low)))
    return (np.abs(values.real) < 1e-7 * np.abs(values)).any()


def test_beam_rotor_against_its_state_space_and_the_exact_peak():
    system, loops, speed = beam_rotor(), beam_loops(), 800.0
    found = magnetic_sensitivity(system, loops, speed, highest_rad_s=5e4)
    a, b, c = whole_state_space(system, loops, speed)
    a, (scale, _) = la.matrix_balance(a, permute=False, separate=True)
    b, c = b / scale[:, None], c * scale
    values = la.eigvals(a)
    assert found.is_stable and values.real.max() < 0
    for value in found.eigenvalues:
        assert abs(values - value).min() < 1e-6 * max(abs(value), 1.0)
    for k, axis in enumerate(found.axes):
        inner = la.solve(1j * axis.frequency_rad_s * np.eye(len(a)) - a, b[:, k])
        assert abs(1 + c[k] @ inner) == pytest.approx(axis.peak, rel=1e-7)
        bk, ck = b[:, [k]], c[[k]]
        assert not has_crossing(a, bk, ck, axis.peak * 1.0005)
        assert has_crossing(a, bk, ck, axis.peak * 0.9995)


def test_sensitivity_is_that_of_one_loop_with_the_others_closed():
    """1/(1 + Go), Go from the loop of one axis opened and all others closed."""
    system, loops, speed = beam_rotor(), beam_loops(), 800.0
    axis = magnetic_sensitivity(system, loops, speed, highest_rad_s=5e4).axes[1]
    m, c, g, k = matrices_at_speed(system, speed)
    s = 1j * axis.frequency_rad_s
    z = k + s * (c + g) + s**2 * m
    force = np.zeros(len(m))
    for one in loops:
        rows, seen = (seat_motion(system, end)[:2] for end in (one.actuator, one.sensor))
        z = z - one.bearing.negative_stiffness_n_per_m * rows.T @ rows
        h = one.bearing.sensor_stiffness(s)
        if one is loops[0]:
            opened, force = seen[1], rows.T @ h[:, 1]
            h = h * [1, 0]
        z = z + rows.T @ h @ seen
    open_loop = opened @ la.solve(z, force)
    assert abs(1 / (1 + open_loop)) == pytest.approx(axis.peak, rel=1e-9)


def test_dynamic_stiffness_and_parts_of_a_controller():
    s = 30.0 + 2000.0j
    expected = 2e4 + 2e4 / s + 60 * s / (1 + s / 3e4)
    expected *= 1 / (1 + 1.4 * s / 6e4 + (s / 6e4) ** 2)
    expected *= (s**2 + 1800 * s + 9e6) / (s**2 + 3600 * s + 9e6)
    t = 1e-5 * s
    expected *= (1 - t / 2 + t**2 / 12) / (1 + t / 2 + t**2 / 12)
    assert chain().response(s)[0, 0] == pytest.approx(expected, rel=1e-10)
    bearing = beam_loops()[0].bearing
    z = bearing.dynamic_stiffness(800.0, s)
    np.testing.assert_allclose(z, (200 * expected - 1e6) * np.eye(2), rtol=1e-9)
    late = ct.delay(1e-3).response(1000.0j)[0, 0]
    assert abs(late) == pytest.approx(1.0) and abs(late - np.exp(-1j)) < 1e-5
    # an ideal derivative before a filter
    smooth = ct.series(ct.pid(3.0, 0.0, 0.5), ct.low_pass(50.0)).response(s)[0, 0]
    assert smooth == pytest.approx((3 + 0.5 * s) / (1 + s / 50), rel=1e-12)
    with pytest.raises(AnalysisError, match=r"needed is \(2, 2\)"):
        MagneticBearing(
            current_stiffness_n_per_a=1.0,
            negative_stiffness_n_per_m=0.0,
            controller=ct.low_pass(1.0),
        )


# -- magnetic bearings as laws of a system -------------------------------------------------------


def with_laws(bare, loops):
    """The same bearings as joints of the system."""
    bearings = [
        Bearing(
            name=one.name,
            first=one.actuator,
            sensor=None if one.sensor == one.actuator else one.sensor,
            speed_law=MagneticLaw(name=one.name, bearing=one.bearing),
        )
        for one in loops
    ]
    return assemble(bare.system.rotors, (*bare.system.bearings, *bearings))


def test_closed_loop_modes_and_sensitivity_of_a_system():
    bare, loops, speed = beam_rotor(), beam_loops(), 800.0
    system = with_laws(bare, loops)
    a, _, _ = whole_state_space(bare, loops, speed)
    balanced, _ = la.matrix_balance(a, permute=False)
    wanted = la.eigvals(balanced)
    modes = modes_at_speed(system, speed)
    found = np.concatenate((modes.eigenvalues, modes.eigenvalues.conj(), modes.real_eigenvalues))
    lively = np.abs(wanted.real) < 0.99 * np.abs(wanted)
    for value in wanted[lively]:
        assert np.abs(found - value).min() < 1e-6 * abs(value)
    assert modes.zero_count == 0 and len(found) == len(wanted)
    assert 2 * modes.eigenvalues.size == np.count_nonzero(wanted.imag)
    # a root of the states is one of the bearings as they are at its own rate
    for value, shape in zip(modes.eigenvalues[:6], modes.shapes[:, :6].T, strict=True):
        m, c, g, k = matrices_at_speed(at_rate(system, complex(value)), speed)
        terms = (k @ shape, value * (c + g) @ shape, value**2 * m @ shape)
        assert la.norm(sum(terms)) < 1e-6 * max(la.norm(term) for term in terms)
    rated = system_sensitivity(system, speed, highest_rad_s=5e4)
    before = magnetic_sensitivity(bare, loops, speed, highest_rad_s=5e4)
    for one, other in zip(rated.axes, before.axes, strict=True):
        assert (one.loop, one.axis, one.zone) == (other.loop, other.axis, other.zone)
        assert one.peak == pytest.approx(other.peak, rel=1e-9)


def test_fast_roots_beside_ones_that_creep():
    """A proportional part that hardly carries the magnets' own pull: roots 1e6 times as slow.

    m s² + ki (P + D s/(1 + s/w)) − ks = 0 is a cubic; its pair is known to the rounding of its
    coefficients, not to that of the slowest root.
    """
    roll_off, own = 2 * np.pi * 3000.0, 150.0
    bearing = MagneticBearing(
        current_stiffness_n_per_a=own,
        negative_stiffness_n_per_m=own * 4999.0,
        controller=both(ct.pid(5000.0, 0.0, 90.0, roll_off)),
    )
    system = with_laws(point_mass(), [loop("m", bearing, "a")])
    cubic = [1.0 / roll_off, 1.0, own * 90.0 + own / roll_off, own]
    (fast,) = (root for root in np.roots(cubic) if root.imag > 0)
    found = modes_at_speed(system, 0.0).eigenvalues
    np.testing.assert_allclose(found, [fast, fast], rtol=1e-12)


def test_response_and_forces_with_sensors_apart():
    bare, loops, speed = beam_rotor(), beam_loops(), 800.0
    system = with_laws(bare, loops)
    u = [Unbalance(body="rotor", interface="seen", moment_kg_m=1e-4)]
    found = unbalance_response(system, u, np.array([speed])).exciters[0]
    m, c, g, k = matrices_at_speed(bare, speed)
    s = 1j * speed
    z = k + s * (c + g) + s**2 * m
    for one in loops:
        rows, seen = (seat_motion(bare, end)[:2] for end in (one.actuator, one.sensor))
        z = z + rows.T @ one.bearing.sensor_stiffness(s) @ seen - 1e6 * rows.T @ rows
    place = seat_motion(bare, End(body="rotor", interface="seen"))[:2]
    q = la.solve(z, 1e-4 * speed**2 * place.T @ [1.0, -1.0j])
    np.testing.assert_allclose(found.at_node("rotor", "seen"), [place @ q], rtol=1e-8)
    joint = system.law_joints[0]
    steady = at_whirl_ratio(system, 1.0)
    k6, c6 = bearing_force_rows(steady, system.system.bearings[0], speed)
    rows, seen = (seat_motion(bare, e)[:2] for e in (loops[0].actuator, loops[0].sensor))
    pull = loops[0].bearing.sensor_stiffness(s) @ (seen @ q) - 1e6 * rows @ q
    mine = (k6 + s * c6)[:2] @ moved(bare, system, q)
    np.testing.assert_allclose(mine, pull, rtol=1e-7)
    assert joint.motion.shape[0] == 4


def moved(bare, system, q):
    """Coordinates of one system from those of another with the same bodies."""
    return la.lstsq(system.transformation, bare.transformation @ q)[0]


def test_proportional_and_derivative_control_is_a_spring_and_a_damper():
    body = rigid_superelement(
        "rotor", 12.0, (0.0, 0.0, 0.0), (0.5, 0.5, 0.9), {"a": -0.4, "b": 0.3},
        components=("ux", "uy", "rx", "ry"),
    )  # fmt: skip
    own = {"current_stiffness_n_per_a": 200.0, "negative_stiffness_n_per_m": 1e6}
    bearing = MagneticBearing(**own, controller=both(ct.pid(2e4, 0.0, 4.0)))
    ends = [End(body="rotor", interface=i) for i in "ab"]
    weak = MagneticBearing(**own, controller=both(ct.pid(4e3, 0.0, 4.0)))
    rotor = {"rotor": Rotor(element=body, speed_ratio=1.0)}
    plain, magnetic, drops = (
        assemble(rotor, tuple(Bearing(name=e.interface, first=e, **keys) for e in ends))
        for keys in (
            {"stiffness_n_per_m": 3e6 * np.eye(2), "damping_n_s_per_m": 800.0 * np.eye(2)},
            {"speed_law": MagneticLaw(name="m", bearing=bearing)},
            {"speed_law": MagneticLaw(name="m", bearing=weak)},
        )
    )
    wanted, found = (modes_at_speed(system, 500.0) for system in (plain, magnetic))
    np.testing.assert_allclose(found.eigenvalues, wanted.eigenvalues, rtol=1e-9)
    assert unstable_intervals(magnetic, 0.0, 1000.0) == ()
    (window,) = unstable_intervals(drops, 0.0, 1000.0)
    assert window.kind == "divergence" and not window.opens


def test_an_integrator_holds_what_is_slow():
    gain, slope = ct.pid(2e4, 2e4, 60.0, 3e4).slow_gain()
    assert gain[0, 0] > 1e7 and not slope.any()
    gain, slope = ct.pid(2e4, 0.0, 60.0, 3e4).slow_gain()
    assert gain[0, 0] == pytest.approx(2e4) and slope[0, 0] == pytest.approx(60.0)
