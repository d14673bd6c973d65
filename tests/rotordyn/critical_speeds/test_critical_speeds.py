"""Critical speeds: direct solution against branches, closed forms, damping, free motion."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import scipy.linalg as la
from rotors import (
    connect,
    ground,
    hub,
    one_rotor,
    polynomial_law,
    rigid_body,
    table_law,
    three_disk,
    three_disk_element,
    turning,
    twin,
    twin_bearings,
    twin_rotors,
)
from scipy.optimize import brentq

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.assembly.bearing_laws import (
    LEE_ANISOTROPIC,
    LEE_ISOTROPIC,
)
from solidwhirl.rotordyn.checks.plain_checks import check_campbell
from solidwhirl.rotordyn.critical_speeds.search import count_critical_speeds
from solidwhirl.rotordyn.modes.whirl import excitation_by


@pytest.mark.parametrize("ratio", [1.0, 2.0])
def test_direct_solution_finds_every_meeting_of_a_sweep(ratio):
    system, top = twin(), 2500.0
    speeds = np.linspace(0, top, 26)
    # Number of modes below the line grows by one at each meeting of a falling distance, and the
    # difference of counts between two speeds is what the direct solution must give.
    below = [
        np.count_nonzero(rd.modes_at_speed(system, s).eigenvalues.imag < ratio * s) for s in speeds
    ]
    found = np.array([c.speed_rad_s for c in rd.critical_speeds(system, ratio, top)])
    counted = [np.count_nonzero(found < s) for s in speeds]
    assert counted == below


def test_residual_and_sign_of_the_ratio():
    system = twin()
    found = rd.critical_speeds(system, 1.3, 2500.0)
    for critical in found:
        m, _, g, k = rd.matrices_at_speed(system, critical.speed_rad_s)
        omega = 1.3 * critical.speed_rad_s
        terms = [part @ critical.shape for part in (k, 1j * omega * g, -(omega**2) * m)]
        assert la.norm(sum(terms)) < 1e-10 * sum(la.norm(term) for term in terms)
    turned = rd.critical_speeds(system, -1.3, 2500.0)
    assert [c.speed_rad_s for c in turned] == [c.speed_rad_s for c in found]
    assert rd.critical_speeds(system, 1.0, 100.0) == ()
    assert rd.critical_speeds(three_disk(), 1.0, 100.0) == ()


def test_range_of_the_basis_is_the_default_limit():
    rotors = twin_rotors(-1.0)
    inner = dataclasses.replace(rotors["inner"].element, maximum_speed_rad_s=1100.0)
    found = rd.critical_speeds(rd.assemble({**rotors, "inner": turning(inner)}, twin_bearings()))
    assert [round(c.frequency_hz) for c in found] == [159]


@pytest.mark.parametrize(("polar", "count"), [(0.08, 1), (0.03, 2)])
def test_thin_disk_on_a_free_tilt_has_no_forward_speed(polar, count):
    """Only tilt: k = Ω² (Id ∓ Ip), forward needs Id > Ip."""
    k, diametral = 300.0, 0.05
    disk = hub(mass_kg=10.0, polar_kg_m2=polar, diametral_kg_m2=diametral)
    tilt = connect("tilt", "rotor.hub", tilt=k)
    # Translations are free: they have no critical speed and must not disturb.
    found = rd.critical_speeds(one_rotor(disk, [tilt]))
    exact = {
        "backward": np.sqrt(k / (diametral + polar)),
        "forward": np.sqrt(k / max(diametral - polar, 1e-300)),
    }
    assert [c.whirl for c in found] == ["backward", "forward"][:count]
    for critical in found:
        assert critical.speed_rad_s == pytest.approx(exact[critical.whirl], rel=1e-12)


def test_free_body_that_whirls_without_force_is_refused():
    with pytest.raises(rd.AnalysisError, match="every speed is critical"):
        rd.critical_speeds(one_rotor(hub(polar_kg_m2=0.05, diametral_kg_m2=0.05), []))


def test_little_damping_keeps_speeds_of_motions_that_are_rigid_at_rest():
    """Thin disk on an elastic arm, free to tilt about a pin: the nutation has a critical speed."""
    rotors = {"pin": turning(hub(0.5, 1e-3, 1e-3, name="pin")), "disk": turning(hub(10.0, 0.08))}
    joint = connect("joint", "pin.hub", "disk.hub", 1e6, tilt=300.0)
    found = []
    for damping in (0.0, 1e-6):
        drag = {"drag": damping}
        system = rd.assemble(rotors, (joint, ground("pin", "hub", 1e6, **drag)))
        found.append([c.speed_rad_s for c in rd.critical_speeds(system, 1.0, 3000.0)])
    assert len(found[0]) >= 2
    np.testing.assert_allclose(found[1], found[0], rtol=1e-6)


def test_damped_disk_on_tilt_spring_in_closed_form():
    """Id λ² + (c ∓ i Ip Ω) λ + k = 0 for forward and backward whirl; Im λ(Ω) = Ω by bracketing."""
    k, diametral, polar, c = 300.0, 0.05, 0.03, 2.0
    disk = hub(mass_kg=10.0, polar_kg_m2=polar, diametral_kg_m2=diametral)
    tilt = connect("tilt", "rotor.hub", stiffness=1e9, tilt=k, drag=c)
    found = rd.critical_speeds(one_rotor(disk, [tilt]), 1.0, 400.0)

    def miss(speed, sign):
        roots = np.roots([diametral, c - sign * 1j * polar * speed, k])
        return roots.imag.max() - speed

    exact = {w: brentq(miss, 10, 300, args=(s,)) for w, s in (("forward", 1), ("backward", -1))}
    assert {c.whirl for c in found} == set(exact)
    for critical in found:
        assert critical.speed_rad_s == pytest.approx(exact[critical.whirl], rel=1e-9)


@pytest.mark.parametrize(
    ("ratio", "limit", "message"),
    [
        (0.0, None, "excitation_ratio is 0.0"),
        (np.nan, None, "excitation_ratio is nan"),
        (1.0, -5.0, "speed_max_rad_s is -5.0"),
        (1.0, None, "speed_max_rad_s is needed"),
    ],
)
def test_arguments_without_meaning_are_refused(ratio, limit, message):
    with pytest.raises(rd.AnalysisError, match=message):
        rd.critical_speeds(three_disk(), ratio, limit)


# Bearings that depend on the speed.


def _law(stiffness_x, stiffness_y=None):
    return polynomial_law(stiffness_x, stiffness_x if stiffness_y is None else stiffness_y)


def _law_bearing(end, law, stiffness=1e7, damping=0.0, tilt=0.0):
    return connect(end, f"rotor.{end}", None, stiffness, damping, tilt, speed_law=law)


def point_mass(law, stiffness, mass, damping=0.0):
    """Mass on a bearing with a law: k₀ p(Ω) = m Ω² in each plane, tilt far away."""
    disk = hub(mass_kg=mass, polar_kg_m2=1e-3, diametral_kg_m2=1e-3)
    return one_rotor(disk, [_law_bearing("hub", law, stiffness, damping, tilt=1e6)])


def _positive_roots(polynomial, limit):
    roots = np.roots(polynomial[::-1])
    real = roots.real[np.abs(roots.imag) < 1e-9 * np.abs(roots)]
    return np.sort(real[(real > 0) & (real < limit)])


@pytest.mark.parametrize(("stiffness", "mass"), [(1e7, 5.0), (1e7, 20.0), (4.53e7, 100), (1e6, 12)])
@pytest.mark.parametrize("law", [LEE_ANISOTROPIC, LEE_ISOTROPIC], ids=lambda law: law.name)
def test_point_mass_on_lee_bearing_has_the_roots_of_a_polynomial(law, stiffness, mass):
    """One mode has several critical speeds where the bearing stiffens faster than Ω²."""
    limit = 3000.0
    exact = []
    for factors in (law.stiffness_x, law.stiffness_y):
        polynomial = stiffness * np.array(factors)
        polynomial[2] -= mass
        exact.append(_positive_roots(polynomial, limit))
    expected = np.sort(np.concatenate(exact))
    system = point_mass(law, stiffness, mass)
    found = rd.critical_speeds(system, 1.0, limit)
    np.testing.assert_allclose([c.speed_rad_s for c in found], expected, rtol=1e-12)
    count = count_critical_speeds(system, 1.0, limit)
    assert count.count == expected.size
    assert count.falls - count.rises == count.below_at_limit - count.below_at_rest
    assert count.unresolved_rad_s == ()


@pytest.mark.parametrize(("distance", "rtol"), [(1e-2, 1e-11), (1e-4, 1e-11), (1e-7, 1e-8)])
def test_pairs_of_critical_speeds_that_nearly_touch(distance, rtol):
    """k = m (2Ω² − 2Ω₁Ω + Ω₁² − ε²) meets mΩ² at Ω₁ ± ε; rounding moves that by eps/ε."""
    mass, at = 10.0, 777.0
    law = _law((at**2 * (1 - distance**2), -2 * at, 2.0))
    system = point_mass(law, mass, mass)
    found = [c.speed_rad_s / at for c in rd.critical_speeds(system, 1.0, 2000.0)]
    expected = np.repeat([1 - distance, 1 + distance], 2)
    np.testing.assert_allclose(found, expected, rtol=rtol)
    assert count_critical_speeds(system, 1.0, 2000.0).rises == 2


def test_touching_is_reported_and_missing_is_not():
    mass, at = 10.0, 777.0
    touching = point_mass(_law((at**2, -2 * at, 2.0)), mass, mass)
    count = count_critical_speeds(touching, 1.0, 2000.0)
    assert count.count == 0
    # One interval for each whirl direction.
    assert len(count.unresolved_rad_s) == 2
    for low, high in count.unresolved_rad_s:
        assert low <= at <= high <= low * (1 + 2e-3)
    apart = point_mass(_law((at**2 * (1 + 1e-6), -2 * at, 2.0)), mass, mass)
    count = count_critical_speeds(apart, 1.0, 2000.0)
    assert (count.count, count.unresolved_rad_s) == (0, ())
    assert rd.critical_speeds(apart, 1.0, 2000.0) == ()


def test_kink_of_a_table_does_not_hide_a_pair():
    """Stiffness of a table falls and rises linearly: k meets mΩ² twice within 2 rad/s of the kink.

    The kink is where k = mΩ²(1 − 1e-3); by hand on both sides of it.
    """
    mass, kink = 10.0, 1003.3
    at_kink = mass * kink**2 * (1 - 1e-3)
    slope = 40.0 * mass * kink
    ends = kink + np.array([-20.0, 0.0, 20.0])
    table = table_law(ends, at_kink + slope * np.abs(ends - kink), interpolation="linear")
    found = [c.speed_rad_s for c in rd.critical_speeds(point_mass(table, 0.0, mass), 1.0, 1500.0)]
    # mΩ² − k = 0 with k = k₁ ± s (Ω − Ω₁), then at the held end k₁ + 20 s.
    left = np.roots([mass, slope, -at_kink - slope * kink])
    right = np.roots([mass, -slope, -at_kink + slope * kink])
    near = [x for x in (*left, *right) if abs(x - kink) < 2]
    top = np.sqrt((at_kink + 20 * slope) / mass)
    assert len(near) == 2
    np.testing.assert_allclose(found, np.repeat(np.sort([*near, top]), 2), rtol=1e-11)


@pytest.mark.parametrize("ratio", [1.0, 2.0])
def test_law_that_is_constant_changes_nothing(ratio):
    """The search by counting signs against the direct solution."""
    constant = one_rotor(three_disk_element(), [ground("rotor", e, 7e7) for e in ("left", "right")])
    law = _law((1.0,))
    bearings = [_law_bearing(end, law, 7e7) for end in ("left", "right")]
    searched = one_rotor(three_disk_element(), bearings)
    assert constant.has_constant_bearings
    assert not searched.has_constant_bearings
    direct, found = (rd.critical_speeds(s, ratio, 3000.0) for s in (constant, searched))
    assert len(direct) >= 5
    speeds = [[c.speed_rad_s for c in each] for each in (direct, found)]
    np.testing.assert_allclose(speeds[1], speeds[0], rtol=1e-11)
    assert [c.whirl for c in found] == [c.whirl for c in direct]
    for one, two in zip(direct, found, strict=True):
        product = abs(np.vdot(one.shape, two.shape))
        assert product == pytest.approx(la.norm(one.shape) * la.norm(two.shape), rel=1e-8)
    assert count_critical_speeds(searched, ratio, 3000.0).count == len(direct)


def test_shafts_that_nothing_joins_have_the_critical_speeds_of_each():
    held = {"soft": 1e8, "stiff": 2e8}
    bearings = {
        name: [
            connect(f"{name} {end}", f"{name}.{end}", None, k, 0.0, 0.0, speed_law=LEE_ISOTROPIC)
            for end in ("left", "right")
        ]
        for name, k in held.items()
    }
    shafts = {name: turning(three_disk_element()) for name in held}
    both = rd.assemble(shafts, (*bearings["soft"], *bearings["stiff"]), "soft")
    found = [c.speed_rad_s for c in rd.critical_speeds(both, 1.0, 2500.0)]
    alone = [
        c.speed_rad_s
        for name in held
        for c in rd.critical_speeds(rd.assemble({name: shafts[name]}, bearings[name]), 1.0, 2500.0)
    ]
    assert len(alone) >= 8
    np.testing.assert_allclose(found, np.sort(alone), rtol=1e-10)


def test_whirl_directions_apart_or_together():
    """Half-size real problems against one Hermitian problem of full size."""
    bearings = [_law_bearing(end, LEE_ISOTROPIC, 2e8) for end in ("left", "right")]
    system = one_rotor(three_disk_element(), bearings)
    apart = rd.critical_speeds(system, 1.0, 2500.0)
    together = rd.critical_speeds(dataclasses.replace(system, spin_generator=None), 1.0, 2500.0)
    assert len(apart) == len(together) >= 4
    for one, two in zip(apart, together, strict=True):
        assert two.speed_rad_s == pytest.approx(one.speed_rad_s, rel=1e-10)
        assert two.whirl == one.whirl


@pytest.mark.parametrize("at", [93.5356852728801, 777.7, 1234.5])
def test_check_of_roots_knows_that_terms_of_a_law_cancel(at):
    """Where k = k₀ (1 − Ω/Ω₁)² touches zero, what is left of it is rounding of its terms."""
    law = _law((1.0, -2.0 / at, 1.0 / at**2), (1.0, 1e-4))
    system = point_mass(law, 3e4, 0.17)
    diagram = rd.campbell(system, np.linspace(0.0, at, 11), branch_count=4)
    assert not [c for c in check_campbell(system, diagram, None, 4) if c.passed is False]


@pytest.mark.parametrize("damping", [0.0, 50.0])
@pytest.mark.parametrize(
    "odd_row", [[[1.0, 0.9], [-0.9, 1.0]], [[1.0, 0.0], [0.0, 2.0]], [[1.0, 0.2], [0.2, 1.0]]]
)
def test_equal_modes_are_a_forward_and_a_backward_circle(odd_row, damping):
    """Far below the only row that is not isotropic: a mass without tilt has ω² = k/m twice."""
    rows = 1e7 * np.array([np.eye(2), np.eye(2), odd_row])
    law = table_law([0.0, 4000.0, 5000.0], rows, np.array([damping * np.eye(2)] * 3))
    system = point_mass(law, 0.0, 10.0)
    found = rd.critical_speeds(system, 1.0, 4500.0)
    omega = np.sqrt(1e6 - (damping / 20.0) ** 2)
    np.testing.assert_allclose([c.speed_rad_s for c in found], [omega, omega], rtol=1e-9)
    assert sorted(c.whirl for c in found) == ["backward", "forward"]
    excited = {c.whirl: excitation_by(system, c.shape, ["rotor"]).excited for c in found}
    assert excited == {"forward": True, "backward": False}
    modes = rd.modes_at_speed(system, 300.0, 2)
    assert sorted(rd.whirl_direction(system, modes.shapes)) == ["backward", "forward"]


@pytest.mark.parametrize("ratio", [1.0, -1.3])
def test_search_against_a_dense_scan(ratio):
    """Number of modes below the line |α|Ω at many speeds, from the modes at each of them.

    Counter-rotating twin rotor with Lee bearings at A and between the shafts.
    """
    law, top = {"speed_law": LEE_ISOTROPIC}, 3200.0
    of_laws = (ground("inner", "A", 2e7, **law), connect("C", "inner.C", "outer.C", 1e7, **law))
    others = [b for b in twin_bearings(1e9, 1e8) if b.name not in ("inner.A", "C")]
    system = rd.assemble(twin_rotors(-1.3), (*of_laws, *others))
    speeds = np.linspace(0, top, 66)[1:]
    below = [
        np.count_nonzero(rd.modes_at_speed(system, s).eigenvalues.imag < abs(ratio) * s)
        for s in speeds
    ]
    found = np.array([c.speed_rad_s for c in rd.critical_speeds(system, ratio, top)])
    count = count_critical_speeds(system, ratio, top)
    assert count.rises >= 1
    assert count.falls >= 4
    assert (count.below_at_rest, count.below_at_limit) == (0, below[-1])
    assert count.count == found.size
    for speed in found:
        omega = rd.modes_at_speed(system, speed).eigenvalues.imag
        assert np.abs(omega / (abs(ratio) * speed) - 1).min() < 1e-9
    # Each meeting changes the number by one; none changes between two that are found.
    changes = np.flatnonzero(np.diff([0, *below]))
    places = np.unique(np.searchsorted(speeds, found))
    assert set(changes) <= set(places)
    parity = [np.count_nonzero(found < s) % 2 for s in speeds]
    assert parity == [b % 2 for b in below]


def test_negative_damping_of_a_law_shows_in_the_decrement():
    """Mass on Lee's bearing: δ has the sign of d_xx, positive at 400 and negative at 1300 rad/s."""
    for speed, sign in ((400.0, 1), (1300.0, -1)):
        stiffness, damping = LEE_ISOTROPIC.coefficients(speed, np.eye(2), np.eye(2))
        base = 10.0 * speed**2 / stiffness[0, 0]
        system = point_mass(LEE_ISOTROPIC, base, 10.0, 50.0)
        found = rd.critical_speeds(system, 1.0, 1.02 * speed)
        nearest = min(found, key=lambda c: abs(c.speed_rad_s - speed))
        # δ = π c / (m ω) for light damping.
        expected = np.pi * 50.0 * damping[0, 0] / (10.0 * speed)
        assert np.sign(expected) == sign
        assert nearest.log_decrement == pytest.approx(expected, rel=1e-3)


def test_bearing_without_stiffness_at_rest():
    """k = k₁ Ω = mΩ² at k₁/m; near rest the mode is at √(k₁Ω/m), above the excitation."""
    system = point_mass(_law((0.0, 5.0)), 1e3, 10.0)
    found = [c.speed_rad_s for c in rd.critical_speeds(system, 1.0, 2000.0)]
    np.testing.assert_allclose(found, [500.0, 500.0], rtol=1e-12)
    count = count_critical_speeds(system, 1.0, 2000.0)
    assert (count.below_at_rest, count.below_at_limit, count.falls) == (0, 2, 2)


def test_search_needs_a_limit_and_a_constant_part_that_is_not_negative():
    system = point_mass(LEE_ISOTROPIC, 1e7, 10.0)
    with pytest.raises(rd.AnalysisError, match="bearings depend on the speed"):
        rd.critical_speeds(system, 1.0)
    with pytest.raises(rd.AnalysisError, match="counted up to it"):
        count_critical_speeds(system, 1.0)
    negative = one_rotor(hub(), [_law_bearing("hub", LEE_ISOTROPIC, 1e7, tilt=-1e6)])
    with pytest.raises(rd.AnalysisError, match="2 negative eigenvalues"):
        count_critical_speeds(negative, 1.0, 1000.0)


def test_overdamped_motion_that_ceases_to_oscillate_meets_nothing():
    """A skew stiffness lets it oscillate at rest by a millionth; beside rest the spin undoes it."""
    inertia = [0.0049434492044722975, 0.0049434492044722975, 0.004512624550916123]
    seats = {"a": 0.0, "b": 0.375508179839787}
    body = rigid_body("rotor", 0.2623370077821557, 0.3065419571756549, inertia, seats)
    skew = 0.11016458725651422 * np.array([[0.0, 1.0], [-1.0, 0.0]])
    bearings = (
        connect("a", "rotor.a", None, 74.49977990111101 * np.eye(2) + skew, 29.21312277714709),
        connect("b", "rotor.b", None, 1903.5175691359163, 55.02242951785443, 19.035175691359164),
        ground("other", "hub", 1e6, 2e6, tilt=1e5),
    )
    system = rd.assemble({"rotor": turning(body), "other": turning(hub())}, bearings)
    at_rest = rd.modes_at_speed(system, 0.0).eigenvalues
    assert 1e-6 < at_rest[0].imag / -at_rest[0].real < 1.1e-6
    # what is left are slow oscillations of the same body, damped away in a thousandth of a turn
    assert all(c.log_decrement > 1e3 for c in rd.critical_speeds(system, 1.0, 111.5))
