"""Beam superelements against statics, mass properties and frequencies in closed form."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as la
from rotors import STEEL, one_rotor, steel_shaft
from scipy.optimize import brentq

from solidwhirl.rotordyn import Disk, SuperelementError, beam_superelement, modes_at_speed
from solidwhirl.rotordyn.beams.elements import shear_coefficient

LIGHT = {"name": "d", "position_m": 0.5, "mass_kg": -1, "polar_kg_m2": 0, "diametral_kg_m2": 0}


def test_shear_coefficient_of_cowper():
    # Cowper 1966: 6(1+ν)/(7+6ν) solid; thin tube 2(1+ν)/(4+3ν).
    assert shear_coefficient(0.3, 0.0) == pytest.approx(6 * 1.3 / 8.8)
    assert shear_coefficient(0.3, 1.0) == pytest.approx(2 * 1.3 / 4.9)


@pytest.mark.parametrize("elements", [1, 5])
def test_tip_stiffness_of_a_cantilever_is_exact(elements):
    length, outer, inner = 0.5, 0.03, 0.01
    stations, ends = np.linspace(0, length, elements + 1), {"root": 0.0, "tip": length}
    shaft = steel_shaft("shaft", stations, outer, ends, inner=inner)
    area, second = np.pi * (outer**2 - inner**2), np.pi * (outer**4 - inner**4) / 4
    shear = shear_coefficient(0.3, inner / outer) * 2e11 / 2.6 * area
    bending = 2e11 * second
    own, mixed = length**3 / (3 * bending) + length / shear, length**2 / (2 * bending)
    flexibility = np.array([[own, mixed], [mixed, length / bending]])
    for translation, tilt, sign in (("ux", "ry", 1.0), ("uy", "rx", -1.0)):
        at = [shaft.interface_index("tip", c) for c in (translation, tilt)]
        mirror = np.diag([1.0, sign])
        found = mirror @ la.inv(shaft.stiffness[np.ix_(at, at)]) @ mirror
        np.testing.assert_allclose(found, flexibility, rtol=1e-9)


def test_free_shaft_frequency_of_a_slender_beam():
    # Free-free Euler beam: cos kL cosh kL = 1; a radius of 1/400 of the length adds 2e-4 by shear.
    root = brentq(lambda x: np.cos(x) * np.cosh(x) - 1, 4.5, 5.0)
    radius, length = 0.0025, 1.0
    exact = root**2 / (2 * np.pi) * np.sqrt(2e11 / 7800) * radius / 2 / length**2
    shaft = steel_shaft("shaft", np.linspace(0, 1, 21), radius, {"a": 0.25})
    np.testing.assert_allclose(shaft.free_frequencies_hz[:2], exact, rtol=3e-4)
    modes = modes_at_speed(one_rotor(shaft, []), 0.0)
    np.testing.assert_allclose(modes.frequency_hz[:10], shaft.free_frequencies_hz, rtol=1e-9)


def test_coordinates_are_what_they_say():
    shaft = steel_shaft("shaft", np.linspace(0, 1, 9), 0.05, {"a": 0.0, "b": 1.0})
    modal = [c for c in shaft.coordinates if c.kind == "modal"]
    assert [c.label for c in shaft.coordinates[:4]] == ["a.ux", "a.uy", "a.rx", "a.ry"]
    assert len(modal) == shaft.size - 8 == 4 * 9 - 8
    # Clamped at both ends: an eigenproblem of the modal block alone gives their frequencies.
    values = la.eigh(shaft.stiffness[8:, 8:], shaft.mass[8:, 8:], eigvals_only=True)
    listed = [c.frequency_hz for c in modal]
    np.testing.assert_allclose(np.sqrt(values) / (2 * np.pi), listed, rtol=1e-9)
    np.testing.assert_allclose(shaft.fixed_interface_frequencies_hz, listed)


def test_recovery_reproduces_rigid_motion():
    shaft = steel_shaft("shaft", np.linspace(0.2, 1.2, 9), 0.05, {"a": 0.3, "b": 1.1})
    moved = shaft.recovery_modes @ shaft.rigid_body_modes
    z = shaft.recovery_points_m[:, 2]
    expected = np.zeros((z.size, 3, 6))
    expected[:, 0, 0] = expected[:, 1, 1] = 1.0
    expected[:, 0, 4], expected[:, 1, 3] = z, -z
    np.testing.assert_allclose(moved, expected, atol=1e-12)


def test_mass_properties_of_a_hollow_shaft_with_a_disk():
    disk = (0.8, 5.0, 0.04, 0.03)
    shaft = steel_shaft("shaft", np.linspace(0, 1, 5), 0.05, {"a": 0.0}, [disk], inner=0.02)
    mass = 7800 * np.pi * (0.05**2 - 0.02**2)
    center = (0.5 * mass + 0.8 * 5) / (mass + 5)
    polar = mass * (0.05**2 + 0.02**2) / 2 + 0.04
    diametral = mass * (3 * (0.05**2 + 0.02**2) + 1) / 12 + 0.03
    diametral += mass * (0.5 - center) ** 2 + 5 * (0.8 - center) ** 2
    assert shaft.mass_kg == pytest.approx(mass + 5, rel=1e-12)
    np.testing.assert_allclose(shaft.center_of_gravity_m, [0, 0, center], rtol=1e-12)
    inertia = np.diag([diametral, diametral, polar])
    np.testing.assert_allclose(shaft.inertia_kg_m2, inertia, rtol=1e-12)


def test_interfaces_and_disks_become_nodes():
    seats, disk = {"a": 0.25, "b": 1.0 - 1e-12}, (0.7, 5.0, 0.04, 0.03)
    shaft = steel_shaft("shaft", [0.0, 1.0], 0.05, seats, [disk])
    np.testing.assert_allclose(shaft.recovery_points_m[:, 2], [0.0, 0.25, 0.7, 1.0])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"stations_m": [0.0]}, "two or more"),
        ({"stations_m": [0.0, 1.0, 0.5]}, r"stations_m\[2\] is 0.5, not above 1.0"),
        ({"outer_radius_m": [0.1, 0.1, 0.1]}, r"outer_radius_m has shape \(3,\)"),
        ({"inner_radius_m": 0.06}, "inner radius 0.06 m and outer radius 0.05 m"),
        ({"material": (-1.0, 0.3, 7800.0)}, "youngs_modulus_pa is -1.0"),
        ({"material": (2e11, 0.6, 7800.0)}, "poissons_ratio is 0.6"),
        ({"material": (2e11, 0.3, 0.0)}, "density_kg_m3 is 0.0"),
        ({"material": 2e11}, "material is one argument"),
        ({"interface_stations": {}}, "interface_stations is empty"),
        ({"interface_stations": {"a": 2.0}}, "interface 'a' is at 2.0 m, off the shaft"),
        ({"interface_stations": {"a": 0.5, "b": 0.5}}, "'a' and 'b' are both at 0.5 m"),
        ({"disks": [Disk(**LIGHT)]}, "disk 'd': mass_kg is -1"),
    ],
)
def test_shafts_out_of_range_are_refused(change, message):
    good = {
        "name": "s", "stations_m": [0.0, 0.5, 1.0], "outer_radius_m": 0.05, "inner_radius_m": 0.0,
        "material": STEEL, "interface_stations": {"a": 0.0},
    }  # fmt: skip
    assert beam_superelement(**good).size == 12
    with pytest.raises(SuperelementError, match=message):
        beam_superelement(**{**good, **change})
