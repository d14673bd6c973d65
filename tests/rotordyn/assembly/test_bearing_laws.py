"""Speed laws of bearings against hand-evaluated numbers, and the notes on where they are used."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rotors import connect, ground, hub, one_rotor, polynomial_law, table_law, turning

from solidwhirl import rotordyn as rd
from solidwhirl.rotordyn.assembly import bearing_laws
from solidwhirl.rotordyn.assembly.bearing_notes import bearing_notes, note_lines

RPM = np.pi / 30.0
ONE, ZERO = np.eye(2), np.zeros((2, 2))
CROSS = np.array([[1.0, 0.2], [0.0, 1.0]])


def _parts(law, speed, base=ONE):
    """k_xx, k_yy, d_xx, d_yy at a spin speed."""
    stiffness, damping = law.coefficients(speed, base, base)
    assert stiffness[0, 1] == stiffness[1, 0] == damping[0, 1] == damping[1, 0] == 0
    return [stiffness[0, 0], stiffness[1, 1], damping[0, 0], damping[1, 1]]


# Lee's polynomials.


@pytest.mark.parametrize(
    ("speed", "by_hand"),
    [
        (0.0, [1.0, 0.25, 1.0, 0.25]),
        # 1 − 3.52 + 7.06 − 6.77 + 2.46 and so on: every power of 1000 is a shift of the point.
        (1000.0, [0.23, 1.342 / 4, 0.09, 0.37 / 4]),
        (
            100.0,
            [
                1 - 0.352 + 0.0706 - 0.00677 + 0.000246,
                (1 + 0.0967 - 0.0131 + 0.00102 - 0.0000335) / 4,
                1 - 0.36 + 0.0507 - 0.00238,
                (1 - 0.23 + 0.0306 - 0.00139) / 4,
            ],
        ),
    ],
)
def test_lee_by_hand(speed, by_hand):
    np.testing.assert_allclose(_parts(bearing_laws.LEE_ANISOTROPIC, speed), by_hand, rtol=1e-13)
    isotropic = [by_hand[0], by_hand[0], by_hand[2], by_hand[2]]
    np.testing.assert_allclose(_parts(bearing_laws.LEE_ISOTROPIC, speed), isotropic, rtol=1e-13)


# Müller and Hennings, table 5 and the speeds of section 5.1.
# Polynomials in general.


@pytest.mark.parametrize(
    ("unit", "argument"), [("rad/s", 62.83185307179586), ("rpm", 600.0), ("Hz", 10.0)]
)
def test_argument_unit(unit, argument):
    factors = ((1.0, 1.0), (2.0,), (0.0, 0.0, 1.0), (3.0,))
    law = polynomial_law(*factors, top=2 * argument, argument_unit=unit)
    speed = 20 * np.pi
    expected = [1 + argument, 2.0, argument**2, 3.0]
    np.testing.assert_allclose(_parts(law, speed), expected, rtol=1e-14)
    np.testing.assert_allclose(law.speed_range_rad_s, (0.0, 2 * speed), rtol=1e-14)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"argument_unit": "Hertz"}, "argument_unit 'Hertz'; use"),
        ({"argument_range": (5.0, 5.0)}, r"argument_range is \(5.0, 5.0\)"),
        ({"argument_range": (-1.0, 5.0)}, "0 <= low < high"),
        ({"argument_range": (0.0, np.inf)}, "finite"),
        ({"damping_y": ()}, r"damping_y is \(\)"),
        ({"stiffness_x": (1.0, np.nan)}, "stiffness_x"),
    ],
)
def test_faults_of_polynomials_are_named(change, message):
    with pytest.raises(rd.AssemblyError, match=message):
        dataclasses.replace(bearing_laws.LEE_ISOTROPIC, **change)


# Tables.


def _table(values, interpolation, speeds=(100.0, 200.0, 400.0)):
    stiffness = np.multiply.outer(np.asarray(values), np.array([[1.0, 0.5], [-0.5, 2.0]]))
    return table_law(speeds, stiffness, 10 * stiffness, interpolation)


@pytest.mark.parametrize("interpolation", ["linear", "monotone"])
def test_table_meets_its_values_and_holds_the_ends(interpolation):
    law = _table([1.0, 5.0, 4.0], interpolation)
    shape = np.array([[1.0, 0.5], [-0.5, 2.0]])
    for speed, value in ((100, 1), (200, 5), (400, 4), (0, 1), (99, 1), (401, 4), (1e6, 4)):
        stiffness, damping = law.coefficients(float(speed), ZERO, ZERO)
        np.testing.assert_allclose(stiffness, value * shape, rtol=1e-14)
        np.testing.assert_allclose(damping, 10 * value * shape, rtol=1e-14)
    assert law.speed_range_rad_s == (100.0, 400.0)


@pytest.mark.parametrize(
    ("law", "stiffness", "damping", "message"),
    [
        (bearing_laws.LEE_ISOTROPIC, CROSS, ZERO, "stiffness_n_per_m .* has the cross terms"),
        (bearing_laws.LEE_ISOTROPIC, ONE, CROSS, "damping_n_s_per_m of the bearing"),
        (_table([1.0, 2.0, 3.0], "linear"), ONE, ZERO, "absolute values, .* has stiffness"),
        (_table([1.0, 2.0, 3.0], "linear"), ZERO, ONE, "absolute values, .* has damping"),
    ],
)
def test_bearings_that_a_law_does_not_fit_are_refused(law, stiffness, damping, message):
    with pytest.raises(rd.AssemblyError, match=message):
        law.coefficients(1.0, stiffness, damping)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"speeds_rad_s": np.array([1.0])}, "two or more"),
        ({"speeds_rad_s": np.array([0.0, 2.0, 2.0])}, "first < second"),
        ({"speeds_rad_s": np.array([-1.0, 0.0, 2.0])}, "0 <= first"),
        ({"stiffness_n_per_m": np.zeros((2, 2, 2))}, r"stiffness_n_per_m has shape \(2, 2, 2\)"),
        ({"damping_n_s_per_m": np.full((3, 2, 2), np.nan)}, "damping_n_s_per_m has entries"),
        ({"speeds_rad_s": np.array([0.0, 1e-300, 100.0])}, "rows at 0 and 1e-300 rad/s are at one"),
        ({"interpolation": "spline"}, "interpolation 'spline'; use"),
    ],
)
def test_faults_of_tables_are_named(change, message):
    with pytest.raises(rd.AssemblyError, match=message):
        dataclasses.replace(_table([1.0, 2.0, 3.0], "linear"), **change)


# In a system.


def two_hubs(law, stiffness=1e7 * ONE, damping=300.0 * ONE):
    """Shaft at Ω, a second one at −2Ω, and a casing; each on a bearing with a law."""
    ratios = {"inner": 1.0, "outer": -2.0, "casing": 0.0}
    rotors = {name: turning(hub(), r) for name, r in ratios.items()}
    own = (None, stiffness, damping, 1e5)
    held = (connect(f"{name} bearing", f"{name}.hub", *own, speed_law=law) for name in ratios)
    return rd.assemble(rotors, tuple(held))


def test_law_is_taken_at_the_speed_of_the_first_body():
    for speed in (700.0, -700.0):
        m, c, _, k = rd.matrices_at_speed(two_hubs(bearing_laws.LEE_ISOTROPIC), speed)
        lateral = np.flatnonzero(np.diag(m) == 10.0)
        spins = np.repeat([700.0, 1400.0, 0.0], 2)
        expected = [_parts(bearing_laws.LEE_ISOTROPIC, float(spin)) for spin in spins]
        np.testing.assert_allclose(np.diag(k)[lateral], [1e7 * e[0] for e in expected], rtol=1e-12)
        np.testing.assert_allclose(np.diag(c)[lateral], [300 * e[2] for e in expected], rtol=1e-12)


def test_notes_name_bearing_kind_and_speeds():
    notes = bearing_notes(two_hubs(bearing_laws.LEE_ISOTROPIC), np.linspace(0, 1500, 11))
    by_place = {(note.bearing, note.kind): note for note in notes}
    # The inner shaft stays in the range of 2000 rad/s; the outer one, twice as fast, does not.
    assert set(by_place) == {
        ("inner bearing", "negative damping"),
        ("outer bearing", "negative damping"),
        ("outer bearing", "outside range"),
    }
    inner = by_place["inner bearing", "negative damping"]
    outer = by_place["outer bearing", "negative damping"]
    # Real root of 1 − 3.6e-3 Ω + 5.07e-6 Ω² − 2.38e-9 Ω³.
    roots = np.roots([-2.38e-9, 5.07e-6, -3.6e-3, 1.0])
    exact = roots[np.isreal(roots)].real[0]
    assert inner.speed_low_rad_s == pytest.approx(exact, rel=1e-12)
    assert outer.speed_low_rad_s == pytest.approx(exact / 2, rel=1e-12)
    assert inner.speed_high_rad_s == outer.speed_high_rad_s == 1500.0
    assert inner.speed_low_rpm == pytest.approx(10564.14, abs=0.01)
    assert inner.speed_high_rpm == pytest.approx(1500 / RPM, rel=1e-12)
    assert inner.message.startswith(
        "10564.1 to 14323.9 rpm: negative damping by law 'lee_isotropic'"
    )
    assert inner.message.endswith("(bearing inner bearing)")
    outside = by_place["outer bearing", "outside range"]
    assert (outside.speed_low_rad_s, outside.speed_high_rad_s) == (1000.0, 1500.0)
    assert outside.message == (
        "9549.3 to 14323.9 rpm: law 'lee_isotropic' covers 0 to 19098.6 rpm of 'outer'; its "
        "polynomials go on outside (bearing outer bearing)"
    )


def test_no_notes_where_all_is_well():
    assert bearing_notes(two_hubs(bearing_laws.LEE_ISOTROPIC), [0.0, 550.0]) == ()
    # Backward running shafts are at |Ω|.
    system = two_hubs(bearing_laws.LEE_ISOTROPIC)
    assert bearing_notes(system, [-900, 0]) == bearing_notes(system, [0, 900]) != ()


def test_speeds_below_the_range_are_noted():
    law = _table([1e7, 2e7, 3e7], "linear")
    notes = bearing_notes(two_hubs(law, ZERO, ZERO), [0.0, 150.0])
    # The outer shaft turns backward, and the table has cross terms.
    assert [n.bearing for n in notes if n.kind == "mirrored"] == ["outer bearing"]
    outside = {
        n.bearing: (n.speed_low_rad_s, n.speed_high_rad_s) for n in notes if n.kind != "mirrored"
    }
    assert {n.kind for n in notes} == {"outside range", "mirrored"}
    assert outside == {
        "inner bearing": (0.0, 100.0),
        "outer bearing": (0.0, 50.0),
        # The casing stands still, below the table at all speeds.
        "casing bearing": (0.0, 150.0),
    }


def test_bearings_of_one_table_share_a_line():
    law = dataclasses.replace(_table([1e7, 2e7, 3e7], "linear"), name="tpj")
    pads = [connect(name, "rotor.hub", speed_law=law) for name in ("de", "nde")]
    low, high = law.speed_range_rad_s
    notes = bearing_notes(one_rotor(hub(), pads), [0.0, 2.0 * high])
    assert len(notes) == 4  # both ends of the table
    (line,) = note_lines(notes)
    rpm = [f"{v / RPM:.6g}" for v in (low, high, 2.0 * high)]
    assert line == (
        f"0 to {rpm[0]} and {rpm[1]} to {rpm[2]} rpm: table 'tpj' covers {rpm[0]} to {rpm[1]} rpm; "
        "end values are held outside (bearings de, nde)"
    )


def test_dip_between_two_speeds_is_found():
    """(x − 0.3)² − 1e-6 with x = Ω/1000 is negative over 2 rad/s only."""
    narrow = polynomial_law((1.0,), (1.0,), (0.09 - 1e-6, -0.6e-3, 1e-6))
    notes = bearing_notes(two_hubs(narrow), [0.0, 1999.0])
    found = {n.bearing: (n.speed_low_rad_s, n.speed_high_rad_s) for n in notes}
    assert set(found) == {"inner bearing", "outer bearing"}
    # The depth is 1e-6 of the other coefficients, so that rounding is 1e-10 of the width.
    np.testing.assert_allclose(found["inner bearing"], (299.0, 301.0), rtol=1e-9)
    np.testing.assert_allclose(found["outer bearing"], (149.5, 150.5), rtol=1e-9)


def test_cross_terms_can_make_damping_negative():
    """The symmetric part of [[1, c], [c, 1]] is negative for |c| > 1; a skew part never is."""
    speeds = np.array([0.0, 1000.0])
    for skew, expected in ((1.0, 1), (-1.0, 0)):
        damping = np.array([np.eye(2), np.array([[1.0, 2.0], [skew * 2.0, 1.0]])])
        system = two_hubs(table_law(speeds, [1e7, 1e7], damping, "linear"), ZERO, ZERO)
        notes = [n for n in bearing_notes(system, speeds) if n.bearing == "inner bearing"]
        assert [n.kind for n in notes] == ["negative damping"] * expected
        if expected:
            assert notes[0].speed_low_rad_s == pytest.approx(500.0, rel=1e-9)


def test_constant_bearings_are_looked_at_too():
    weak = ground("rotor", "hub", -1e3, 1e6, -5.0, 1.0)
    notes = bearing_notes(one_rotor(hub(), [weak]), [100.0])
    assert [n.kind for n in notes] == ["negative damping", "negative stiffness"]
    assert all(n.speed_low_rad_s == n.speed_high_rad_s == 100.0 for n in notes)


def test_speeds_without_meaning_are_refused():
    for speeds in ([], [np.nan], [np.inf]):
        with pytest.raises(rd.AnalysisError, match="finite speeds"):
            bearing_notes(two_hubs(bearing_laws.LEE_ISOTROPIC), speeds)
