"""Formulas of API 617, ISO 20816-3 and ISO 21940-11 against numbers by hand."""

from __future__ import annotations

import numpy as np
import pytest

from solidwhirl.rotordyn import AnalysisError
from solidwhirl.rotordyn.response.orbits import elliptic_orbits
from solidwhirl.rotordyn.response.unbalance_peaks import refined_peaks, resonance_peaks
from solidwhirl.rotordyn.standards.api617_lateral import (
    actual_margin,
    required_margin,
    residual_unbalance_kg_m,
    scale_factor,
    vibration_limit_m,
)
from solidwhirl.rotordyn.standards.api617_stability import (
    is_in_region_b,
    region_border,
    screened,
    stage_cross_coupling_n_per_m,
)
from solidwhirl.rotordyn.standards.iso_balance import (
    grade_of_unbalance_mm_per_s,
    in_two_planes,
    permissible_unbalance_kg_m,
)
from solidwhirl.rotordyn.standards.iso_vibration import vibration_zone, zone_borders_m

# -- lateral analysis -----------------------------------------------------------------------------


def test_residual_unbalance():
    assert residual_unbalance_kg_m(1000.0, 10e3) == pytest.approx(635e-6, rel=1e-12)
    assert residual_unbalance_kg_m(1000.0, 30e3) == pytest.approx(254.0e-6, rel=1e-4)
    # one rule meets the other, and per mass it is a grade of 0.665 mm/s
    below, above = (residual_unbalance_kg_m(1.0, rpm) for rpm in (24_999.999, 25e3))
    assert below == pytest.approx(above, rel=1e-4)
    moment = residual_unbalance_kg_m(1.0, 8e3)
    assert grade_of_unbalance_mm_per_s(moment, 1.0, 8e3) == pytest.approx(0.665, rel=1e-4)


@pytest.mark.parametrize(
    ("factor", "below", "above"),
    [
        (2.49, 0.0, 0.0), (2.5, 0.0, 10.0), (3.5, 8.5, 18.5), (4.0, 10.2, 20.2),
        (5.0, 12.143, 22.143), (11.5, 15.3, 25.3), (18.5, 16.0, 26.0), (np.inf, 16.0, 26.0),
    ],
)  # fmt: skip
def test_required_margin(factor, below, above):
    assert 100.0 * required_margin(factor, "below") == pytest.approx(below, abs=5e-4)
    assert 100.0 * required_margin(factor, "above") == pytest.approx(above, abs=5e-4)


@pytest.mark.parametrize(
    ("factor", "below", "above"),
    [(2.49, 0, 0), (2.5, 5, 15), (3.55, 5, 15), (4.0, 10, 20), (9.0, 15, 25), (np.inf, 16, 26)],
)
def test_required_margin_of_the_6th_edition(factor, below, above):
    assert 100.0 * required_margin(factor, "below", "legacy") == pytest.approx(below)
    assert 100.0 * required_margin(factor, "above", "legacy") == pytest.approx(above)


def test_no_margin_is_enough_inside_or_when_unstable():
    assert required_margin(2.0, "inside") == 0.0
    assert required_margin(5.0, "inside") == np.inf
    assert required_margin(-50.0, "below") == np.inf
    with pytest.raises(AnalysisError, match="position is 'under'"):
        required_margin(5.0, "under")


def test_actual_margin():
    assert actual_margin(6000.0, 7000.0, 10e3) == ("below", 7000.0, pytest.approx(-1.0 / 7.0))
    assert actual_margin(12_500.0, 7000.0, 10e3) == ("above", 10e3, pytest.approx(0.25))
    assert actual_margin(9000.0, 7000.0, 10e3) == ("inside", 10e3, 0.0)


def test_vibration_limit_and_scale_factor():
    assert vibration_limit_m(15e3) == pytest.approx(22.718e-6, rel=1e-4)
    assert vibration_limit_m(12e3) == vibration_limit_m(3e3) == 25.4e-6
    assert scale_factor(25.4e-6, 8e-6) == pytest.approx(3.175)
    assert scale_factor(25.4e-6, 3e-6) == scale_factor(25.4e-6, 0.0) == 6.0


def test_major_axis_by_the_formula_of_a_hand_calculation():
    x, y = 3.0 + 1.0j, -0.5 + 2.0j
    mean, half = 0.5 * (abs(x) ** 2 + abs(y) ** 2), 0.5 * (abs(x) ** 2 - abs(y) ** 2)
    wanted = np.sqrt(mean + np.hypot(half, (x * y.conjugate()).real))
    assert float(elliptic_orbits(x, y).major_m) == pytest.approx(wanted, rel=1e-14)


@pytest.mark.parametrize(
    ("damping", "low", "peak", "high", "factor"),
    [(0.1, 0.92097, 1.01015, 1.13155, 4.7969), (0.2, None, None, None, 2.0726),
     (0.17443, None, None, None, 2.5)],
)  # fmt: skip
def test_amplification_of_a_jeffcott_rotor(damping, low, peak, high, factor):
    """Half-power points of the unbalance response in closed form."""

    def curve(r):
        return r**2 / np.hypot(1.0 - r**2, 2.0 * damping * r)

    r = np.linspace(0.05, 4.0, 200)
    found = refined_peaks(resonance_peaks(r, curve(r)), r, curve(r), curve)[0]
    assert found.amplification == pytest.approx(factor, rel=1e-4)
    if low is not None:
        assert found.half_power_low_rad_s == pytest.approx(low, abs=6e-6)
        assert found.position_rad_s == pytest.approx(peak, abs=6e-6)
        assert found.half_power_high_rad_s == pytest.approx(high, abs=6e-6)


def test_no_amplification_where_the_response_does_not_fall_far_enough():
    """From ζ = sin 22.5° on there is no half-power point above the peak."""

    def found(damping):
        r = np.linspace(0.05, 400.0, 20_001)
        return resonance_peaks(r, r**2 / np.hypot(1.0 - r**2, 2.0 * damping * r))[0]

    limit = np.sin(np.pi / 8.0)
    assert np.isfinite(found(0.98 * limit).amplification)
    assert np.isnan(found(1.02 * limit).amplification)


# -- stability ------------------------------------------------------------------------------------


def test_cross_coupling_of_stages():
    radial = stage_cross_coupling_n_per_m("radial", 1e6, 0.4, 0.015, 10e3, 1.3)
    assert radial == pytest.approx(0.62075e6, rel=1e-8)
    axial = stage_cross_coupling_n_per_m("axial", 2e6, 0.6, 0.08, 6e3, 1.3)
    assert axial == pytest.approx(0.099479e6, rel=1e-5)
    # by horsepower and inches the printed constant is 63; 1 klbf/in = 175126.8 N/m
    horsepower, inch = 745.69987, 0.0254
    english = 1e6 / horsepower * 3.0 * 63.0 * 1.3 / (0.4 / inch * 0.015 / inch * 10e3)
    assert radial / 175126.8 == pytest.approx(english, rel=1e-3)
    assert english == pytest.approx(3.5429, rel=5e-4)


def test_region_b():
    assert region_border(40.0) == pytest.approx(2.23)
    assert region_border(16.53) == 2.5 == pytest.approx(region_border(16.5301), abs=2e-4)
    assert not is_in_region_b(40.0, 2.22) and is_in_region_b(40.0, 2.24)
    assert is_in_region_b(60.0, 0.5) and not is_in_region_b(59.9, 1.9)


@pytest.mark.parametrize(
    ("kind", "times", "decrement", "density", "detailed"),
    [
        ("radial", 1.99, 0.3, 1.0, True),
        ("radial", 2.0, 0.3, 1.0, False), ("radial", 2.0, 0.3, 70.0, True),
        ("radial", 5.0, 0.3, None, True), ("radial", 10.0, 0.3, 70.0, False),
        ("radial", 20.0, 0.099, 1.0, True), ("radial", 20.0, 0.1, 1.0, False),
        ("axial", 1.0, 0.1, 70.0, False), ("axial", 20.0, 0.09, 1.0, True),
    ],
)  # fmt: skip
def test_screening(kind, times, decrement, density, detailed):
    assert screened(kind, times, decrement, density, 2.0).detailed is detailed


# -- ISO ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rpm", "borders"), [(10e3, (48.0, 90.0, 132.0)), (3e3, (87.6, 164.3, 241.0))]
)
def test_zones_of_shaft_vibration(rpm, borders):
    assert np.array(zone_borders_m(rpm)) * 1e6 == pytest.approx(borders, abs=0.05)
    assert zone_borders_m(100.0) == zone_borders_m(600.0)
    first, second, third = zone_borders_m(rpm)
    ends = (0.0, first, 1.001 * first, second, third, 1.001 * third)
    assert [vibration_zone(s, rpm) for s in ends] == list("AABBCD")


def test_grades_of_balance():
    assert permissible_unbalance_kg_m(1000.0, 2.5, 10e3) == pytest.approx(2387.3e-6, abs=5e-8)
    # U [g mm] = 9549 G m / n, whose constant has four digits
    for mass, grade, rpm in ((3600.0, 2.5, 3000.0), (0.2, 6.3, 42e3)):
        moment = permissible_unbalance_kg_m(mass, grade, rpm)
        assert moment * 1e6 == pytest.approx(9549.0 * grade * mass / rpm, rel=1e-4)
    assert in_two_planes(10.0, 0.4, 0.6) == pytest.approx((6.0, 4.0))
    assert in_two_planes(10.0, 0.1, 0.9) == pytest.approx((7.0, 3.0))
