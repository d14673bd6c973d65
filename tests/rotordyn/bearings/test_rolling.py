"""Rolling bearings against printed numbers, closed forms, difference quotients and limits."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.integrate import quad

from solidwhirl.rotordyn import AnalysisError
from solidwhirl.rotordyn.bearings.balls import BallBearing
from solidwhirl.rotordyn.bearings.elements import element_forces, row_motion
from solidwhirl.rotordyn.bearings.hertz import BEARING_STEEL, SILICON_NITRIDE, point_contact
from solidwhirl.rotordyn.bearings.rollers import RollerBearing
from solidwhirl.rotordyn.bearings.rolling import (
    BearingSet,
    RingLoad,
    ring_states,
)
from solidwhirl.rotordyn.bearings.rolling import loaded_ring as loaded_rings

# ISO/TS 16281 rounds π√2/3 in the contact constant to 1.48; the printed numbers below are with it.
ROUNDED = dataclasses.replace(
    BEARING_STEEL, youngs_modulus_pa=207e9 * 1.48 / (np.pi * np.sqrt(2.0) / 3.0)
)
SIZE = {"ball_diameter_m": 9.525e-3, "pitch_diameter_m": 46e-3, "rings": ROUNDED, "balls": ROUNDED}
GROOVE = BallBearing(ball_count=9, **SIZE)
ANGULAR = BallBearing(ball_count=12, contact_angle_rad=np.radians(25.0), **SIZE)
ROLLERS = RollerBearing(
    roller_count=14,
    roller_diameter_m=10e-3,
    effective_length_m=10e-3,
    pitch_diameter_m=65e-3,
    radial_clearance_m=20e-6,
)
UM = 1e6
ONE = (row_motion(1, 0.0),)


@dataclasses.dataclass
class Ring:
    """One equilibrium, its first ball at +x."""

    motion: np.ndarray
    load: np.ndarray
    stiffness: np.ndarray
    inner_load_n: np.ndarray
    outer_load_n: np.ndarray
    inner_angle_rad: np.ndarray
    outer_angle_rad: np.ndarray


def of(states):
    found = states.found
    names = ("inner_load_n", "outer_load_n", "inner_angle_rad", "outer_angle_rad")
    own = {name: getattr(found, name)[0] for name in names}
    return Ring(states.motion[0, :5], found.force[0, :5], states.stiffness[0], **own)


def loaded_ring(*args, **more):
    return of(loaded_rings(*args, **more))


def preloaded_ring(bearing, preload_n, speed_rad_s=0.0):
    load = RingLoad(load_n=(0.0, 0.0, 0.0), preload_n=preload_n, preload="rigid")
    return of(ring_states(BearingSet(row=bearing), load, np.array([speed_rad_s]), np.zeros(1)))


def forces(bearing, motion, own):
    seven = np.append(motion, [0.0, 0.0])[None]
    return element_forces(bearing, ONE, seven, np.zeros(1), np.array([own]))


def test_deep_groove_under_a_radial_load():
    found = loaded_ring(GROOVE, (1000.0, 0.0, 0.0))
    assert pytest.approx(299448, abs=1) == GROOVE.stiffness_n_per_m15 / 1000**1.5
    assert found.motion[0] * UM == pytest.approx(13.834, abs=6e-4)
    assert found.inner_load_n.max() == pytest.approx(487.2, abs=0.06)
    along, across = np.diag(found.stiffness)[:2] / UM
    assert (along, across) == pytest.approx((108.43, 80.91), abs=6e-3)


def test_angular_contact_under_an_axial_load():
    found = loaded_ring(ANGULAR, (0.0, 0.0, 500.0))
    assert pytest.approx(299543, abs=1) == ANGULAR.stiffness_n_per_m15 / 1000**1.5
    assert found.motion[2] * UM == pytest.approx(10.734, abs=6e-4)
    np.testing.assert_allclose(found.inner_load_n, 94.51, atol=6e-3)
    np.testing.assert_allclose(np.degrees(found.inner_angle_rad), 26.159, atol=6e-4)
    # closed form of the stiffness at the contact angle found
    z, a, load = 12, found.inner_angle_rad[0], found.inner_load_n[0]
    c = ANGULAR.stiffness_n_per_m15
    deep = (load / c) ** (2 / 3)
    across = load / (ANGULAR.groove_distance_m + deep)
    kn = 1.5 * c * np.sqrt(deep)
    axial = z * (kn * np.sin(a) ** 2 + across * np.cos(a) ** 2)
    radial = 0.5 * z * (kn * np.cos(a) ** 2 + across * np.sin(a) ** 2)
    np.testing.assert_allclose(np.diag(found.stiffness)[:3], [radial, radial, axial], rtol=1e-11)
    assert (axial / UM, radial / UM) == pytest.approx((73.24, 148.09), abs=6e-3)


def test_hertz_against_quadrature_of_its_pressure():
    """Approach of two bodies under the elliptic pressure, by the potential of the half space."""
    total, difference, soft = 400.0, 0.93, 2 * 0.91 / 207e9
    contact = point_contact(total, difference, soft)
    a, b = contact.axes_per_load
    assert a / b == pytest.approx(contact.axis_ratio)

    def potential(curved):
        # Johnson (1985), equation 3.37 to 3.42, with w = substitution for the infinite range
        def at(t):
            w = (t / (1 - t)) ** 2
            measure = 2 * t / (1 - t) ** 3
            more = 1.0 if curved is None else curved**2 + w * a * a
            root = np.sqrt((a * a + w * a * a) * (b * b + w * a * a) * w * a * a)
            return measure * a * a / root / more

        return quad(at, 0.0, 1.0, epsabs=0, epsrel=1e-11, limit=200)[0]

    peak = contact.pressure_pa(1.0)
    scale = 0.5 * a * b * peak * soft
    approach = scale * potential(None)
    assert contact.stiffness_n_per_m15 == pytest.approx(approach**-1.5, rel=1e-9)
    curvatures = np.array([2 * scale * potential(a), 2 * scale * potential(b)])
    assert curvatures.sum() == pytest.approx(total, rel=1e-9)
    assert curvatures[1] - curvatures[0] == pytest.approx(total * difference, rel=1e-9)


def test_sphere_on_sphere_is_the_circle_of_hertz():
    contact, stiff = point_contact(4 / 0.01, 0.0, 2e-11), 1 / 2e-11
    # two spheres of radius 10 mm: Q = 4/3 E* R^(1/2) δ^(3/2) with R = 5 mm
    assert contact.stiffness_n_per_m15 == pytest.approx(4 / 3 * stiff * np.sqrt(0.005), rel=1e-12)


@pytest.mark.parametrize("speed", [0.0, 500.0, 2500.0])
@pytest.mark.parametrize(
    ("bearing", "load"),
    [
        (ANGULAR, (200.0, -100.0, 600.0)),
        (dataclasses.replace(GROOVE, radial_clearance_m=15e-6), (300.0, 500.0, -100.0)),
        (dataclasses.replace(ANGULAR, balls=SILICON_NITRIDE), (50.0, 20.0, 300.0)),
        (ROLLERS, (3000.0, 1000.0, 0.0)),
    ],
)
def test_stiffness_is_the_derivative_of_the_load(bearing, load, speed):
    found = loaded_ring(bearing, load, tilt_rad=(1e-4, -2e-4), speed_rad_s=speed)
    held = list(bearing.carried)
    np.testing.assert_allclose(found.load[held], np.array(load)[held], atol=1e-8 * max(load))
    own, h = bearing.centrifugal_n(speed), 2e-10  # an edge of contact is a kink

    def load_at(motion):
        return forces(bearing, motion, own).force[0, :5]

    moved = [(load_at(found.motion + h * e) - load_at(found.motion - h * e)) for e in np.eye(5)]
    numeric = np.array(moved).T / (2 * h)
    scale = np.sqrt(np.outer(*2 * [np.diag(found.stiffness) + 1e-9]))
    assert (np.abs(numeric - found.stiffness) / scale).max() < 2e-6
    np.testing.assert_allclose(found.stiffness, found.stiffness.T, atol=1e-9 * scale.max())


def test_speed_to_zero_is_the_bearing_at_rest():
    for bearing, load in ((ANGULAR, (50.0, 0.0, 500.0)), (ROLLERS, (2000.0, 0.0, 0.0))):
        rest = loaded_ring(bearing, load)
        slow = loaded_ring(bearing, load, speed_rad_s=0.1)
        np.testing.assert_allclose(
            slow.stiffness, rest.stiffness, rtol=1e-5, atol=1e-7 * rest.stiffness.max()
        )


def test_forces_on_a_ball_balance_at_speed():
    speed = 2500.0
    found = loaded_ring(ANGULAR, (100.0, 50.0, 500.0), speed_rad_s=speed)
    inner, outer = found.inner_load_n, found.outer_load_n
    a, b = found.inner_angle_rad, found.outer_angle_rad
    np.testing.assert_allclose(inner * np.sin(a), outer * np.sin(b), rtol=1e-9)
    own = outer * np.cos(b) - inner * np.cos(a)
    mass = BEARING_STEEL.density_kg_per_m3 * np.pi / 6 * 9.525e-3**3
    cage = 0.5 * speed * (1 - 9.525 / 46 * np.cos(np.radians(25)))
    np.testing.assert_allclose(own, mass * 23e-3 * cage**2, rtol=1e-9)
    assert (a > b).all()


def test_preload_held_in_place_grows_with_speed_and_by_springs_stays():
    fixed = preloaded_ring(ANGULAR, 500.0)
    np.testing.assert_allclose(
        fixed.stiffness, loaded_ring(ANGULAR, (0.0, 0.0, 500.0)).stiffness, rtol=1e-9, atol=1e-3
    )
    assert preloaded_ring(ANGULAR, 500.0, speed_rad_s=2000.0).load[2] > 600.0
    by_springs = loaded_ring(ANGULAR, (0.0, 0.0, 500.0), speed_rad_s=2000.0)
    assert by_springs.stiffness[0, 0] < fixed.stiffness[0, 0]


def test_roller_line_contact_and_its_load_distribution():
    """Sum over the rollers of ISO/TS 16281 at the motion found."""
    found = loaded_ring(ROLLERS, (4000.0, 0.0, 0.0))
    angle = 2 * np.pi * np.arange(14) / 14
    deep = np.maximum(found.motion[0] * 1e3 * np.cos(angle) - 0.01, 0.0)  # mm
    load = 35948 * 10.0 ** (8 / 9) * deep ** (10 / 9)
    np.testing.assert_allclose(found.inner_load_n, load, rtol=1e-9)
    assert load @ np.cos(angle) == pytest.approx(4000.0, rel=1e-9)
    assert found.stiffness[2].tolist() == [0.0] * 5


@pytest.mark.parametrize(
    ("bearing", "load", "message"),
    [
        (ANGULAR, (100.0, 0.0, 0.0), "leaves its shoulder; more axial load"),
        (ANGULAR, (0.0, 0.0, -100.0), "leaves its shoulder"),
        (GROOVE, (1e7, 0.0, 0.0), "pressed in by"),
        (ROLLERS, (10.0, 0.0, 5.0), r"carries none along \['z'\]"),
        (GROOVE, (0.0, 0.0, 0.0), "without a load"),
    ],
)
def test_loads_that_are_not_carried(bearing, load, message):
    with pytest.raises(AnalysisError, match=message):
        loaded_ring(bearing, load)


def test_impossible_geometry_is_named_at_once():
    with pytest.raises(AnalysisError, match=r"2 balls.*groove radii of 0.5"):
        dataclasses.replace(GROOVE, ball_count=2, inner_groove=0.5)
    with pytest.raises(AnalysisError, match="do not fit"):
        dataclasses.replace(GROOVE, ball_count=30)
    with pytest.raises(AnalysisError, match="effective length"):
        dataclasses.replace(ROLLERS, effective_length_m=-1.0)


def test_balls_that_hardly_touch_find_their_place():
    """Far from the equilibrium of the ring too: axial forces on every ball balance."""
    own = ANGULAR.centrifugal_n(1000.0)
    found = forces(ANGULAR, np.array([0.0, -4.8e-5, 1.1e-5, 0.0, 0.0]), own)
    inner, outer = found.inner_load_n, found.outer_load_n
    axial = inner * np.sin(found.inner_angle_rad) - outer * np.sin(found.outer_angle_rad)
    radial = outer * np.cos(found.outer_angle_rad) - inner * np.cos(found.inner_angle_rad)
    np.testing.assert_allclose(axial, 0.0, atol=1e-9 * outer.max())
    np.testing.assert_allclose(radial, own, rtol=1e-8)


def test_pressure_of_a_line_contact():
    """Hertz: p² = Q E* / (π L R) with 1/R = 1/R1 + 1/R2."""
    found = RollerBearing(
        roller_count=12, roller_diameter_m=0.01, effective_length_m=0.01, pitch_diameter_m=0.05
    ).pressure_pa(1000.0, 0.0)
    curved, modulus = 1 / 0.005 + 1 / 0.02, 207e9 / (2 * (1 - 0.3**2))
    assert found == pytest.approx(np.sqrt(1000.0 * modulus * curved / (np.pi * 0.01)), rel=1e-12)
