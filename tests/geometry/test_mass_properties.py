"""Mass properties against hand formulas, published numbers, invariances and brute force."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from outlines import chords_of, loops_of
from shapes import body, interface, section, shaft_and_disk

from solidwhirl.geometry import (
    GeometryError,
    MassProperties,
    RigidDisk,
    mass_by_material_kg,
    mass_properties,
    masses_beyond_kg,
    section_mass_properties,
    subdivide,
)

RHO = 7800.0
# Closed forms against closed forms: some tens of operations in double precision.
ROUND_OFF = 1e-13


def values(found: MassProperties) -> tuple[float, float, float, float]:
    return (
        found.mass_kg,
        float(found.center_of_gravity_m[2]),
        found.polar_inertia_kg_m2,
        found.diametral_inertia_kg_m2,
    )


def ring(inner, outer, width, z=0.0) -> tuple[float, float, float, float]:
    """Textbook hollow cylinder centred at z."""
    mass = RHO * math.pi * (outer**2 - inner**2) * width
    square = outer**2 + inner**2
    return mass, z, mass * square / 2.0, mass * (3.0 * square + width**2) / 12.0


@pytest.mark.parametrize(
    ("inner", "outer", "width"), [(0.0, 0.02, 0.4), (0.03, 0.05, 1.1), (0.02, 0.15, 0.03)]
)
def test_cylinder_tube_disk(inner, outer, width):
    found = section_mass_properties(section("a", -0.2, -0.2 + width, inner, outer))
    assert values(found) == pytest.approx(
        ring(inner, outer, width, -0.2 + width / 2.0), rel=ROUND_OFF
    )


def test_thin_wall_keeps_its_digits():
    # The wall is 1e-9 m at 1 m; the mean-radius formula is exact for the mass, 2 pi R t L rho.
    inner = 1.0
    outer = 1.0 + 2.0**-30  # representable, so that the thickness is exactly 2^-30
    found = section_mass_properties(section("a", 0.0, 1.0, inner, outer))
    assert found.mass_kg == pytest.approx(
        RHO * 2.0 * math.pi * (inner + 2.0**-31) * 2.0**-30, rel=ROUND_OFF
    )


def test_cone():
    """Solid cone, base radius R at z = 0, height h: m = rho pi R^2 h/3, zc = h/4, ..."""
    radius, height = 0.3, 0.7
    found = section_mass_properties(section("cone", 0.0, height, 0.0, (radius, 0.0)))
    mass = RHO * math.pi * radius**2 * height / 3.0
    assert values(found) == pytest.approx(
        (
            mass,
            height / 4.0,
            0.3 * mass * radius**2,
            3.0 / 80.0 * mass * (4.0 * radius**2 + height**2),
        ),
        rel=ROUND_OFF,
    )


def test_published_rotors():
    found = mass_properties(shaft_and_disk())
    shaft = mass_properties(replace(shaft_and_disk(), sections=shaft_and_disk().sections[:1]))
    assert shaft.mass_kg == pytest.approx(3.9207, rel=2e-5)  # five published digits
    about_zero = found.diametral_inertia_kg_m2 + found.mass_kg * found.center_of_gravity_m[2] ** 2
    # Ten published digits.
    assert found.polar_inertia_kg_m2 == pytest.approx(0.1868057908, rel=1e-9)
    assert about_zero == pytest.approx(0.7196344504, rel=1e-9)
    # disks of the twin rotor, six digits: half a unit of the last one is 3e-6 at most
    for inner, outer, published in (
        (0.02, 0.15, (16.2464, 0.186022, 0.0942293)),
        (0.035, 0.1, (6.45079, 0.0362051, 0.0185863)),
    ):
        mass, _, *inertias = values(section_mass_properties(section("d", 0.0, 0.03, inner, outer)))
        assert (mass, *inertias) == pytest.approx(published, rel=3e-6)


def test_splitting_changes_nothing():
    whole = section("a", 0.1, 0.9, (0.02, 0.1), (0.3, 0.15))
    cut = 0.37
    parts = [
        replace(
            whole,
            start_m=start,
            end_m=end,
            inner_radius_m=(whole.radii_at(start)[0], whole.radii_at(end)[0]),
            outer_radius_m=(whole.radii_at(start)[1], whole.radii_at(end)[1]),
        )
        for start, end in ((0.1, cut), (cut, 0.9))
    ]
    joined = mass_properties(body(*(replace(part, name=f"part {part.end_m}") for part in parts)))
    assert values(joined) == pytest.approx(values(section_mass_properties(whole)), rel=ROUND_OFF)


def test_translation_moves_the_centre_only():
    here = shaft_and_disk(fillet=0.004)
    moved = replace(
        here,
        sections=tuple(
            replace(s, start_m=s.start_m + 3.0, end_m=s.end_m + 3.0) for s in here.sections
        ),
    )
    one, two = values(mass_properties(here)), values(mass_properties(moved))
    # The offset of 3 m costs one digit of the 0.4 m long body.
    assert two[1] - 3.0 == pytest.approx(one[1], rel=1e-12)
    assert two[::2] == pytest.approx(one[::2], rel=1e-12)
    assert two[3] == pytest.approx(one[3], rel=1e-12)


def test_fillets_by_green_on_chords():
    """The same integrals over the filleted outline with arcs as chords: error falls as h^2."""
    shape = body(
        section("shaft", 0.0, 0.4, 0.01, (0.02, 0.03)),
        section("disk", 0.1, 0.2, (0.0225, 0.025), (0.1, 0.15)),
        fillet=0.008,
    )
    exact = np.array(values(mass_properties(shape)))
    sharp = mass_properties(replace(shape, fillet_radius_m=0.0))
    assert exact[0] > sharp.mass_kg + 0.01  # two fillets of some 14 mm^2 at 25 mm: 35 grams
    found = subdivide(shape)
    errors = []
    for count in (50, 100, 200):
        moments = np.zeros(4)
        for loop in loops_of(found):
            moments += revolved_moments(chords_of(found, loop, per_arc=count))
        mass, axial, square, polar = 2.0 * math.pi * RHO * moments
        centre = axial / mass
        brute = (mass, centre, polar, polar / 2.0 + square - mass * centre**2)
        errors.append(np.abs(np.array(brute) / exact - 1.0).max())
    assert errors[-1] < 1e-6
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert rates == pytest.approx([2.0, 2.0], abs=0.05)


def test_masses_by_material_make_up_the_body():
    """Two materials, fillets included: their sum is the mass without rigid disks."""
    shape = body(
        section("shaft", 0.0, 0.4, 0.01, (0.02, 0.03)),
        section("disk", 0.1, 0.2, (0.0225, 0.025), (0.1, 0.15)),
        fillet=0.008,
    )
    shaft, disk = shape.sections
    light = replace(disk.material, name="light", density_kg_per_m3=0.5 * RHO)
    mixed = replace(shape, sections=(shaft, replace(disk, material=light)))
    found = mass_by_material_kg(mixed)
    assert list(found) == [shaft.material.name, "light"]
    assert math.fsum(found.values()) == pytest.approx(mass_properties(mixed).mass_kg, rel=ROUND_OFF)
    (whole,) = mass_by_material_kg(shape).values()
    assert whole == pytest.approx(mass_properties(shape).mass_kg, rel=ROUND_OFF)


def revolved_moments(polygon: np.ndarray) -> np.ndarray:
    """Return the integrals of r, z r, z^2 r, r^3 over a polygon, as minus the sums of edges.

    Green: integral of F = -(contour integral of G dz) with dG/dr = F. Simpson and Boole weights
    are exact to degree 5.
    """
    start, step = polygon, np.roll(polygon, -1, axis=0) - polygon
    total = np.zeros(4)
    for share, weight in zip((0.0, 0.25, 0.5, 0.75, 1.0), (7, 32, 12, 32, 7), strict=True):
        z, r = (start + share * step).T
        primitive = np.array([r**2 / 2, z * r**2 / 2, z**2 * r**2 / 2, r**4 / 4])
        total -= weight / 90.0 * primitive @ step[:, 0]
    return total


def test_rigid_disk_sits_at_master_plus_offset():
    disk = RigidDisk(
        name="fan",
        interface="flange",
        mass_kg=50.0,
        polar_inertia_kg_m2=2.0,
        diametral_inertia_kg_m2=1.1,
        offset_m=-0.25,
    )
    shaft = section("shaft", 0.0, 2.0, 0.0, 0.02)
    found = mass_properties(
        body(shaft, interfaces=[interface("flange", "outer", 1.9, 2.0)], disks=[disk])
    )
    mass, z, polar, diametral = ring(0.0, 0.02, 2.0, 1.0)
    total, place = mass + 50.0, 1.95 - 0.25
    centre = (mass * z + 50.0 * place) / total
    assert values(found) == pytest.approx(
        (
            total,
            centre,
            polar + 2.0,
            diametral + 1.1 + mass * (z - centre) ** 2 + 50.0 * (place - centre) ** 2,
        ),
        rel=ROUND_OFF,
    )


def test_refusals():
    with pytest.raises(GeometryError, match="'a' and 'b' overlap"):
        mass_properties(body(section("a", 0.0, 1.0, 0.0, 0.1), section("b", 0.5, 1.5, 0.05, 0.2)))


def test_centre_of_gravity_is_read_only():
    with pytest.raises(ValueError, match="read-only"):
        mass_properties(shaft_and_disk()).center_of_gravity_m[2] = 1.0


def test_masses_beyond_places_along_the_axis():
    """A truncated cone cut where its radius is known: π ρ h (a² + ab + b²) / 3, and a disk."""
    cone = section("cone", 0.0, 0.4, 0.0, (0.02, 0.06))
    drawn = body(cone, interfaces=(interface("hub", "section", 0.35),))
    disk = RigidDisk(
        name="disk", interface="hub", mass_kg=3.0, polar_inertia_kg_m2=0.02,
        diametral_inertia_kg_m2=0.01,
    )  # fmt: skip

    def volume(a, b, height):
        return math.pi * height * (a * a + a * b + b * b) / 3.0

    density = drawn.sections[0].material.density_kg_per_m3
    below, above = masses_beyond_kg(replace(drawn, rigid_disks=(disk,)), 0.1, 0.3)
    assert below == pytest.approx(density * volume(0.02, 0.03, 0.1), rel=ROUND_OFF)
    assert above == pytest.approx(density * volume(0.05, 0.06, 0.1) + 3.0, rel=ROUND_OFF)
    both = masses_beyond_kg(drawn, 0.17, 0.17)
    assert sum(both) == pytest.approx(mass_properties(drawn).mass_kg, rel=ROUND_OFF)
