"""Blades, holes, slots and the like: what fits, what they have in common, what they weigh."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from shapes import STEEL, body, section
from sometimes import often

from solidwhirl.geometry import (
    MATERIALS,
    Blade,
    Body,
    Flat,
    GeometryError,
    Hole,
    Keyway,
    RingCut,
    Slot,
    feature_mass_properties,
    layout_of,
    mass_by_material_kg,
    mass_properties,
    mirror_angle,
    places_rad,
    sector_count,
    side_view,
    subdivide,
    symmetry,
)

RHO = 7800.0
DISK = section("disk", -0.02, 0.02, 0.03, 0.1)
FAN = Blade(
    name="fan",
    on="disk",
    count=12,
    length_m=0.05,
    chord_m=(0.02, 0.02),
    thickness_m=(0.004, 0.004),
    material=STEEL,
)
BOLTS = Hole(name="bolts", within="disk", count=8, pitch_radius_m=0.06, diameter_m=0.012)
KEYS = Slot(
    name="keys", within="disk", count=6, width_m=0.01, depth_m=0.01, start_m=-0.02, end_m=0.0
)


def carrying(*features, sections=(DISK,), **options) -> Body:
    return replace(body(*sections, **options), features=features)


KEYWAY = Keyway(name="key", within="disk", width_m=0.016, depth_m=0.012, start_m=-0.015, end_m=0.02)
FLAT = Flat(name="flat", within="disk", distance_m=0.075, start_m=-0.02, end_m=0.01)
CUT = RingCut(name="cut", within="disk", width_deg=70.0, depth_m=0.03, start_m=-0.02, end_m=0.015)


def is_inside(feature, disk, x, y, z):
    """Whether points are inside a feature whose middle is at θ = 0."""
    r, top = np.hypot(x, y), max(disk.outer_radius_m)
    share = (z - disk.start_m) / (disk.end_m - disk.start_m)
    surface = disk.outer_radius_m[0] + share * (disk.outer_radius_m[1] - disk.outer_radius_m[0])
    if isinstance(feature, Blade):
        along = (x - top) / feature.length_m
        pairs = (feature.chord_m, feature.thickness_m, feature.stagger_deg)
        chord, thickness, stagger = (a + along * (b - a) for a, b in pairs)
        angle = np.radians(stagger)
        dz = z - feature.at_m
        s = dz * np.cos(angle) + y * np.sin(angle)
        t = y * np.cos(angle) - dz * np.sin(angle)
        inside = (np.abs(s) <= chord / 2) & (np.abs(t) <= thickness / 2) & (r >= surface)
        return inside & (x > 0.0) & (x <= top + feature.length_m)
    if isinstance(feature, Hole):
        inside = np.hypot(x - feature.pitch_radius_m, y) <= feature.diameter_m / 2
        return inside & (z >= feature.start_m) & (z <= disk.end_m)
    inside = (z >= feature.start_m) & (z <= feature.end_m) & (r <= surface)
    if isinstance(feature, Flat):
        return inside & (x >= feature.distance_m)
    if isinstance(feature, RingCut):
        inside &= np.abs(np.arctan2(y, x)) <= math.radians(feature.width_deg) / 2
        return inside & (r >= top - feature.depth_m)
    half = feature.width_m / 2
    inside &= (np.abs(y) <= half) & (x >= top - feature.depth_m)
    if feature.ends == "square":
        return inside
    straight = np.clip(z, feature.start_m + half, feature.end_m - half)
    return inside & (np.hypot(y, z - straight) <= half)


def brute_force(feature, disk, points=160):
    """Volume, first and second moments of a set of features by counting points of a grid."""
    reach = max(disk.outer_radius_m) + (feature.length_m if isinstance(feature, Blade) else 0.0)
    high = 0.04 if isinstance(feature, Blade) else 0.0
    edges = [(0.02, reach), (-0.07, 0.07), (disk.start_m - high, disk.end_m + high)]
    steps = [(last - first) / points for first, last in edges]
    # one point anywhere in each cell, so that no plane falls between two layers of points
    cells = np.indices((points,) * 3) + np.random.default_rng(1).random((3,) + (points,) * 3)
    x, y, z = (low + c * step for (low, _), c, step in zip(edges, cells, steps, strict=True))
    own = np.stack([v[is_inside(feature, disk, x, y, z)] for v in (x, y, z)], axis=1)
    cell, total = math.prod(steps), [0.0, np.zeros(3), np.zeros((3, 3))]
    for angle in places_rad(feature):
        c, s = np.cos(angle), np.sin(angle)
        at = own @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        total = [a + cell * b for a, b in zip(total, (len(at), at.sum(0), at.T @ at), strict=True)]
    return total


def moments(found, without):
    """Volume and its moments of what is in one body and not in the other, of steel."""

    def of(p):
        mass, centre, inertia = p.mass_kg, p.center_of_gravity_m, p.inertia_kg_m2
        second = np.trace(inertia) / 2 * np.eye(3) - inertia + mass * np.outer(centre, centre)
        return mass / RHO, mass * centre / RHO, second / RHO

    return [a - b for a, b in zip(of(found), of(without), strict=True)]


def test_bladed_disk_of_the_published_sector_mass():
    """Roots hang over the disk's faces, and end at its radius there; 7 digits are given."""
    disk = section("disk", -0.006, 0.006, 0.03, 0.1)
    found = mass_properties(carrying(replace(FAN, stagger_deg=(30.0, 30.0)), sections=(disk,)))
    assert found.mass_kg / 12 == pytest.approx(0.2542194, abs=5.1e-8)


def test_blades_without_stagger_in_closed_form():
    # a plate less the segment of a circle that it begins at
    r, t, c = 0.1, 0.004, 0.02
    below = t / 2 * math.sqrt(r**2 - t**2 / 4) + r**2 * math.asin(t / 2 / r)
    titanium = MATERIALS["titanium"]
    masses = mass_by_material_kg(carrying(replace(FAN, material=titanium)))
    expected = titanium.density_kg_per_m3 * 12 * c * (t * 0.15 - below)
    assert list(masses) == ["steel", "titanium"]
    assert masses["titanium"] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("across", [90.0, -90.0, 180.0])
def test_blades_turned_by_a_quarter_or_a_half(across):
    """Chord and thickness exchange names with every quarter turn; the plate is the same."""
    disk = section("disk", -0.03, 0.03, 0.03, 0.1)
    plate = replace(
        FAN, chord_m=(0.02, 0.016), thickness_m=(0.004, 0.003), stagger_deg=(20.0, 35.0)
    )
    turned = tuple(angle + across if across < 0 else angle - across for angle in (20.0, 35.0))
    same = replace(plate, stagger_deg=turned)
    if across != 180.0:
        same = replace(same, chord_m=plate.thickness_m, thickness_m=plate.chord_m)
    found, expected = (mass_properties(carrying(b, sections=(disk,))) for b in (same, plate))
    assert found.mass_kg == pytest.approx(expected.mass_kg, rel=1e-12)
    for key in ("polar_inertia_kg_m2", "diametral_inertia_kg_m2"):
        assert getattr(found, key) == pytest.approx(getattr(expected, key), rel=1e-12)
    seen, also = (side_view(b, disk) for b in (same, plate))
    assert seen == pytest.approx(also, abs=1e-15)


def test_a_blade_in_the_plane_of_rotation():
    """With 90 degrees the chord lies across the axis: the blade of the closed form, exchanged."""
    flat = replace(FAN, chord_m=(0.004,) * 2, thickness_m=(0.02,) * 2, stagger_deg=(90.0, 90.0))
    found, expected = (mass_properties(carrying(b)) for b in (flat, FAN))
    assert found.mass_kg == pytest.approx(expected.mass_kg, rel=1e-9)


def test_holes_in_closed_form():
    full, found = mass_properties(body(DISK)), mass_properties(carrying(BOLTS))
    radius, width, pitch = 0.006, 0.04, 0.06
    mass = 8 * RHO * math.pi * radius**2 * width
    assert full.mass_kg - found.mass_kg == pytest.approx(mass, rel=1e-12)
    polar = mass * (pitch**2 + radius**2 / 2)
    assert full.polar_inertia_kg_m2 - found.polar_inertia_kg_m2 == pytest.approx(polar, rel=1e-12)
    own = (3 * radius**2 + width**2) / 12
    diametral = mass * (pitch**2 / 2 + own)
    removed = full.diametral_inertia_kg_m2 - found.diametral_inertia_kg_m2
    assert removed == pytest.approx(diametral, rel=1e-12)


def test_slots_in_closed_form():
    full, found = mass_properties(body(DISK)), mass_properties(carrying(KEYS))
    r, w = 0.1, 0.01
    above = w / 2 * math.sqrt(r**2 - w**2 / 4) + r**2 * math.asin(w / 2 / r) - w * 0.09
    volume = 6 * 0.02 * above
    assert full.mass_kg - found.mass_kg == pytest.approx(RHO * volume, rel=1e-12)
    # the middle of what is cut is at z = -0.01 m, that of the disk at 0
    centre = found.center_of_gravity_m[2] * found.mass_kg
    assert centre == pytest.approx(RHO * volume * 0.01, rel=1e-12)


CONE = section("disk", -0.02, 0.02, 0.03, (0.1, 0.09))


TWISTED = Blade(
    name="fan",
    on="disk",
    count=9,
    length_m=0.06,
    chord_m=(0.03, 0.02),
    thickness_m=(0.008, 0.005),
    stagger_deg=(10.0, 50.0),
    at_m=0.004,
    angle_deg=7.0,
    material=STEEL,
)
SETS = {
    "blades": TWISTED,
    "two blades": replace(TWISTED, count=2),
    "one blade": replace(TWISTED, count=1, angle_deg=200.0),
    "slots": replace(KEYS, depth_m=0.03, start_m=-0.01, end_m=0.015),
    "slots of two poles": replace(
        KEYS, count=2, depth_m=0.03, start_m=-0.01, end_m=0.015, per_group=3, pitch_deg=17.0
    ),
    "two slots of one pole": replace(
        KEYS, count=1, depth_m=0.02, start_m=-0.01, end_m=0.015, per_group=2, pitch_deg=40.0,
        angle_deg=25.0,
    ),
    "keyway": replace(KEYWAY, depth_m=0.03, angle_deg=30.0),
    "square keyways": replace(KEYWAY, depth_m=0.03, count=2, angle_deg=30.0, ends="square"),
    "flat": replace(FLAT, angle_deg=140.0),
    "flats": replace(FLAT, count=2),
    "cut": replace(CUT, angle_deg=-50.0),
    "cuts": replace(CUT, count=3, width_deg=40.0),
    "blind hole": replace(BOLTS, count=1, diameter_m=0.03, start_m=-0.005, angle_deg=70.0),
}  # fmt: skip


@pytest.mark.parametrize(
    "case", often(SETS, "one blade", "slots of two poles", "keyway", "flats", "cut", "blind hole")
)
def test_on_a_cone_as_by_counting_points(case):
    """Cells on the surface, some 15 000, are counted or not by chance: half a per cent is safe."""
    feature = SETS[case]
    full, found = mass_properties(body(CONE)), mass_properties(carrying(feature, sections=(CONE,)))
    sign = 1 if isinstance(feature, Blade) else -1
    expected = brute_force(feature, CONE)
    result = [sign * m for m in moments(found, full)]
    reach = np.array([0.1, 0.1, 0.02])
    scales = [1.0, reach, np.outer(reach, reach)]
    for a, b, scale in zip(result, expected, scales, strict=True):
        assert np.all(np.abs(a - b) < 0.005 * expected[0] * scale)
    # what equal turns leave out is not there at all
    centre, inertia = found.center_of_gravity_m, found.inertia_kg_m2
    if feature.count > 1:
        assert not centre[:2].any() and not inertia[:2, 2].any()
    if feature.count > 2:
        assert inertia[0, 1] == 0.0 and inertia[0, 0] == inertia[1, 1]


def test_a_flat_in_closed_form():
    """A segment of a circle, whose moments are in every handbook."""
    full, found = mass_properties(body(DISK)), mass_properties(carrying(FLAT))
    r, d, width = 0.1, 0.075, 0.03
    half = math.acos(d / r)
    area = r**2 * (half - math.sin(half) * math.cos(half))
    first = 2 / 3 * (r * math.sin(half)) ** 3
    square_x = r**4 / 4 * (half - math.sin(4 * half) / 4)
    volume, moment, second = moments(full, found)
    assert volume == pytest.approx(area * width, rel=1e-11)
    assert moment == pytest.approx([first * width, 0.0, -0.005 * area * width], rel=1e-11)
    assert second[0, 0] == pytest.approx(square_x * width, rel=1e-10)
    assert found.center_of_gravity_m[0] == pytest.approx(-RHO * first * width / found.mass_kg)


def test_a_cut_in_closed_form():
    full, found = mass_properties(body(DISK)), mass_properties(carrying(replace(CUT, angle_deg=90)))
    half, (a, b), width = math.radians(35.0), (0.07, 0.1), 0.035
    volume, moment, second = moments(full, found)
    assert volume == pytest.approx(half * (b**2 - a**2) * width, rel=1e-11)
    first = 2 / 3 * (b**3 - a**3) * math.sin(half) * width
    assert moment[:2] == pytest.approx([0.0, first], rel=1e-11, abs=1e-18)
    square = (b**4 - a**4) / 4 * width
    across = [square * (half + sign * math.sin(2 * half) / 2) for sign in (-1, 1)]
    assert np.diag(second)[:2] == pytest.approx(across, rel=1e-10)


def test_a_shallow_keyway_is_as_large_as_its_plan():
    """Of a shaft so large that its surface is flat to 1e-5 of the depth."""
    large = section("disk", -0.02, 0.02, 50.0, 100.0)
    found = feature_mass_properties(replace(KEYWAY, depth_m=0.01), large)
    length, half = 0.035, 0.008
    plan = 2 * half * (length - 2 * half) + math.pi * half**2
    assert found.mass_kg == pytest.approx(-RHO * 0.01 * plan, rel=3e-5)
    assert found.center_of_gravity_m == pytest.approx([99.995, 0.0, 0.0025], rel=3e-5)


def test_refined_quadrature_agrees(monkeypatch):
    from solidwhirl.geometry import feature_shapes

    wide = replace(FAN, chord_m=(0.05, 0.06), stagger_deg=(35.0, 60.0), count=5)
    keyway = replace(KEYWAY, depth_m=0.03)
    features = (wide, replace(KEYS, depth_m=0.03), keyway, FLAT, replace(CUT, width_deg=350.0))
    bodies = [carrying(f, sections=(CONE,)) for f in features]
    coarse = [mass_properties(b) for b in bodies]
    monkeypatch.setattr(feature_shapes, "_ACROSS", 48)
    monkeypatch.setattr(feature_shapes, "_ALONG", 24)
    for before, after in zip(coarse, map(mass_properties, bodies), strict=True):
        assert before.mass_kg == pytest.approx(after.mass_kg, rel=1e-12)
        scale = np.trace(after.inertia_kg_m2)
        assert np.abs(before.inertia_kg_m2 - after.inertia_kg_m2).max() < 1e-11 * scale
        assert before.center_of_gravity_m == pytest.approx(after.center_of_gravity_m, abs=1e-13)


def test_features_leave_no_trace_in_the_meridian():
    plain, found = subdivide(body(DISK)), subdivide(carrying(FAN, BOLTS))
    assert np.array_equal(plain.points, found.points)
    assert plain.curves == found.curves


# What is allowed up to a length, in closed form: 1 per mille below it passes, above it does not.
LIMITS = {
    "blades meet": lambda f: carrying(
        replace(FAN, thickness_m=(f * 0.2 * math.sin(math.pi / 12),) * 2)
    ),
    "holes meet": lambda f: carrying(
        replace(BOLTS, count=24, diameter_m=f * 0.12 * math.sin(math.pi / 24))
    ),
    "slots meet": lambda f: carrying(
        replace(KEYS, count=30, depth_m=0.05, width_m=f * 0.1 * math.tan(math.pi / 30))
    ),
    "holes in the rim": lambda f: carrying(replace(BOLTS, pitch_radius_m=f * 0.1 - 0.006)),
    "holes in the bore": lambda f: carrying(replace(BOLTS, pitch_radius_m=0.03 / f + 0.006)),
    "slots in the bore": lambda f: carrying(replace(KEYS, depth_m=f * 0.07)),
    "shallow slots": lambda f: carrying(
        replace(KEYS, depth_m=(0.1 - math.sqrt(0.1**2 - 0.005**2)) / f)
    ),
    "holes of two circles": lambda f: carrying(
        replace(BOLTS, pitch_radius_m=0.05, diameter_m=0.01, count=4),
        # between the first two of four, 45 deg away, and as large as leaves nothing between
        Hole(
            name="more",
            within="disk",
            count=8,
            pitch_radius_m=0.07,
            diameter_m=2 * f * (0.02 - 0.005),
        ),
    ),
    "holes below slots": lambda f: carrying(
        replace(BOLTS, count=6, pitch_radius_m=0.06), replace(KEYS, depth_m=f * 0.034)
    ),
    "blades beside slots": lambda f: carrying(
        replace(FAN, angle_deg=15.0, at_m=-0.01),
        # from the slot's wall to half the pitch, less half the blade
        replace(KEYS, count=12, width_m=f * 0.2 * math.sin(math.pi / 12 - math.asin(0.02))),
    ),
    "blades above a neighbour": lambda f: carrying(
        # 40 deg of stagger less at the tip, so that the chord's end passes over the next section
        replace(FAN, length_m=0.03, chord_m=(0.02, f * 0.0599), thickness_m=(1e-4, 1e-4), count=3),
        sections=(DISK, section("high", 0.02 + 0.00995, 0.05, 0.05, 0.13), NECK),
    ),
}
NECK = section("neck", 0.02, 0.02 + 0.00995, 0.05, 0.06)


@pytest.mark.parametrize("case", LIMITS)
def test_limits(case):
    subdivide(LIMITS[case](0.999))
    with pytest.raises(GeometryError, match=r"^body 'rotor': (blades|holes|slots) '"):
        subdivide(LIMITS[case](1.001))


TWO = (section("disk", -0.02, 0.02, 0.03, 0.1), section("next", 0.02, 0.06, 0.03, 0.08))

REFUSED = {
    "unknown section": (
        lambda: carrying(replace(FAN, on="disc")),
        r"body 'rotor': blades 'fan': there is no section 'disc'; known: disk",
    ),
    "same name": (
        lambda: carrying(FAN, replace(BOLTS, name="fan")),
        r"two features are called 'fan'",
    ),
    "name of a section": (
        lambda: carrying(replace(FAN, name="disk")),
        r"blades 'disk': a section has this name",
    ),
    "none": (lambda: replace(BOLTS, count=0), r"holes 'bolts': count is 0, must be 1 to 10000$"),
    "too many": (lambda: replace(BOLTS, count=10_001), r"must be 1 to 10000$"),
    "round ends that do not fit": (
        lambda: replace(KEYWAY, width_m=0.035),
        r"keyways 'key': they are 0.035 m long and 0.035 m wide; with round ends they must be long",
    ),
    "groups without a pitch": (
        lambda: replace(KEYS, per_group=2),
        r"slots 'keys': per_group is 2 and pitch_deg is not given; groups of two or more need",
    ),
    "a pitch without groups": (
        lambda: replace(KEYS, pitch_deg=3.0),
        r"slots 'keys': per_group is 1 and pitch_deg is 3; .* slots without groups have none",
    ),
    "an empty group": (lambda: replace(KEYS, per_group=0), r"per_group is 0, must be 1 to 100$"),
    "a pitch of nothing": (
        lambda: replace(KEYS, per_group=2, pitch_deg=0.0),
        r"slots 'keys': pitch is 0 deg, must lie between 0 and 360 deg",
    ),
    "groups that meet": (
        lambda: carrying(replace(KEYS, per_group=9, pitch_deg=7.0)),
        r"slots 'keys': neighbours meet at .* 54 of them leave",
    ),
    "flat in the bore": (
        lambda: carrying(replace(FLAT, distance_m=0.03)),
        r"flats 'flat': their bottom is at r = 0.03 m, must be beyond the bore of section 'disk'",
    ),
    "flat beside the section": (
        lambda: carrying(replace(FLAT, distance_m=0.1)),
        r"flats 'flat': their bottom is 0.1 m from the axis, the surface .* 'disk' only 0.1 m",
    ),
    "flat through the axis": (
        lambda: replace(FLAT, distance_m=0.0),
        r"flats 'flat': distance is 0.0 m, must be",
    ),
    "a sharp hexagon": (
        lambda: carrying(replace(FLAT, count=6, distance_m=0.1 * math.cos(math.pi / 6))),
        r"flats 'flat': neighbours meet at",
    ),
    "cuts all around": (
        lambda: replace(CUT, width_deg=360.0),
        r"cuts 'cut': width is 360 deg, must lie between 0 and 360 deg",
    ),
    "cuts that meet": (
        lambda: carrying(replace(CUT, count=2, width_deg=180.0)),
        r"cuts 'cut': neighbours meet at",
    ),
    "keyway in a flat": (
        lambda: carrying(FLAT, replace(KEYWAY, angle_deg=30.0)),
        r"flats 'flat' and keyways 'key' meet at",
    ),
    "a hole closed at both ends": (
        lambda: carrying(replace(BOLTS, start_m=-0.01, end_m=0.01)),
        r"holes 'bolts': they reach from z = -0.01 m to 0.01 m and are closed at both ends",
    ),
    "a hole that ends before it begins": (
        lambda: carrying(replace(BOLTS, start_m=0.02)),
        r"they end at z = 0.02 m, where or before",
    ),
    "a blind hole goes on in no through hole": (
        lambda: carrying(
            BOLTS, replace(BOLTS, name="b", within="next", start_m=0.03), sections=TWO
        ),
        r"'next' closes them",
    ),
    "stagger": (
        lambda: replace(FAN, stagger_deg=(0.0, -181.0)),
        r"stagger at the tip is -181 deg, must lie between -180 and 180",
    ),
    "chord": (lambda: replace(FAN, chord_m=(0.0, 0.1)), r"chord at the root is 0.0 m, must be"),
    "thickness": (lambda: replace(FAN, thickness_m=(1.0, math.inf)), r"thickness at the tip is"),
    "length": (lambda: replace(FAN, length_m=-1.0), r"length is -1.0 m, must be finite and pos"),
    "angle": (lambda: replace(FAN, angle_deg=math.nan), r"blades 'fan': found nan"),
    "slots turned round": (
        lambda: replace(KEYS, end_m=-0.03),
        r"slots 'keys': they start at z = -0.02 m and end at z = -0.03 m",
    ),
    "blades beside": (
        lambda: carrying(replace(FAN, at_m=0.02)),
        r"radial line is at z = 0.02 m, must stand on section 'disk', between z = -0.02 m and",
    ),
    "wide root": (
        lambda: carrying(replace(FAN, chord_m=(0.21, 0.21), stagger_deg=(80.0, 80.0), count=3)),
        r"the root is wider than the surface r = 0.1 m",
    ),
    "slots outside": (
        lambda: carrying(replace(KEYS, start_m=-0.03)),
        r"from z = -0.03 m to 0 m, must stay within section 'disk', z = -0.02 m to 0.02 m",
    ),
    "slots covered": (
        lambda: carrying(KEYS, sections=(DISK, section("ring", -0.015, -0.012, 0.1, 0.11))),
        r"slots 'keys': 'ring' covers them at z = -0.015 m",
    ),
    "slots under a fillet": (
        lambda: carrying(
            KEYS, sections=(DISK, section("ring", 0.002, 0.01, 0.1, 0.11)), fillet=0.004
        ),
        r"slots 'keys': 'fillet at z = 0.002 m, r = 0.1 m' covers them",
    ),
    "holes closed": (
        lambda: carrying(BOLTS, sections=TWO),
        r"holes 'bolts': 'next' closes them at z = 0.02 m, where it reaches from r = 0.03 m to "
        r"0.08 m; .* give it equal holes",
    ),
    "holes that go on turned": (
        lambda: carrying(
            BOLTS, replace(BOLTS, name="b", within="next", angle_deg=3.0), sections=TWO
        ),
        r"'next' closes them",
    ),
    "holes into a fillet": (
        lambda: carrying(
            replace(BOLTS, pitch_radius_m=0.09),
            sections=TWO,
            fillet=0.006,
        ),
        r"'fillet at z = 0.02 m, r = 0.08 m' closes them",
    ),
    "two rows in one place": (
        lambda: carrying(FAN, replace(FAN, name="more", count=18, angle_deg=10.0)),
        r"blades 'fan' and blades 'more' meet at",
    ),
    "two rows that lean over each other": (
        lambda: carrying(
            replace(FAN, at_m=-0.01, chord_m=(0.01, 0.03)),
            replace(FAN, name="more", at_m=0.01, chord_m=(0.01, 0.03)),
        ),
        r"blades 'fan' and blades 'more' meet at z = ",
    ),
    "blades over slots": (
        lambda: carrying(FAN, KEYS),
        r"blades 'fan' and slots 'keys' meet",
    ),
    "holes into slots": (
        lambda: carrying(replace(BOLTS, pitch_radius_m=0.09), KEYS),
        r"holes 'bolts' and slots 'keys' meet",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refusals(case):
    make, message = REFUSED[case]
    with pytest.raises(GeometryError, match=message):
        made = make()
        subdivide(made)


FITTING = {
    "holes that go on": lambda: carrying(
        BOLTS, replace(BOLTS, name="b", within="next", angle_deg=135.0), sections=TWO
    ),
    "slots that go on": lambda: carrying(
        replace(KEYS, end_m=0.02),
        replace(KEYS, name="k", within="next", start_m=0.02, end_m=0.03),
        sections=TWO,
    ),
    "as wide as the ring": lambda: carrying(replace(FAN, chord_m=(0.04, 0.04))),
    "over two flush sections": lambda: carrying(
        replace(FAN, chord_m=(0.05, 0.05)), sections=(DISK, section("b", 0.02, 0.03, 0.05, 0.1))
    ),
    "close rows with stagger": lambda: carrying(
        replace(FAN, count=60, chord_m=(0.03, 0.04), thickness_m=(1e-3, 5e-4), stagger_deg=(60, 70))
    ),
    "rows of two counts one behind the other": lambda: carrying(
        replace(FAN, at_m=-0.0101), replace(FAN, name="more", count=18, at_m=0.0101)
    ),
    "a through hole that goes on blind": lambda: carrying(
        BOLTS, replace(BOLTS, name="b", within="next", end_m=0.03), sections=TWO
    ),
    "two flats, a keyway and a cut between": lambda: carrying(
        replace(FLAT, count=2, distance_m=0.09),
        replace(KEYWAY, angle_deg=90.0),
        replace(CUT, angle_deg=-90.0, width_deg=60.0),
    ),
    "nearly a ring": lambda: carrying(replace(CUT, width_deg=359.0)),
    "a thousand holes": lambda: carrying(
        replace(BOLTS, count=1000, pitch_radius_m=0.09, diameter_m=0.0005)
    ),
}


@pytest.mark.parametrize("case", FITTING)
def test_what_fits(case):
    subdivide(FITTING[case]())


def mirrored_about(features, angle) -> bool:
    """Whether sets of places around the circle are the same after a reflection, one by one."""
    for f in features:
        places = math.radians(f.angle_deg) + 2 * math.pi * np.arange(f.count) / f.count
        image = 2 * angle - places
        apart = np.abs(np.exp(1j * image)[:, None] - np.exp(1j * places)).min(axis=1)
        if apart.max() > 1e-7:
            return False
    return True


@pytest.mark.parametrize("seed", range(40))
def test_mirror_angle_of_sets_of_any_counts(seed):
    rng = np.random.default_rng(seed)
    sectors = int(rng.integers(1, 7))
    features = [
        replace(
            BOLTS,
            name=f"f{k}",
            count=sectors * int(rng.integers(1, 5)),
            angle_deg=float(rng.integers(0, 24) * 180.0 / (12 * sectors)),
        )
        for k in range(int(rng.integers(1, 4)))
    ]
    item = carrying(*features)
    divisor, found = sector_count(item.features), mirror_angle(item)
    # all planes of symmetry lie on this grid, since all angles do
    tried = np.arange(24 * 24) * math.pi / (24 * 24 * sectors)
    planes = [a for a in tried if mirrored_about(features, a) and a < math.pi / divisor - 1e-9]
    if found is None:
        assert not planes
    else:
        assert found == pytest.approx(min(planes), abs=1e-9)
        assert mirrored_about(features, found + math.pi / divisor)


def test_stagger_has_no_mirror_plane():
    assert mirror_angle(carrying(replace(FAN, stagger_deg=(0.0, 1e-6)))) is None
    assert mirror_angle(carrying(replace(FAN, angle_deg=370.0))) == pytest.approx(math.radians(10))


def test_bodies_by_how_they_bend():
    assert symmetry(body(DISK)) == "round"
    assert symmetry(carrying(FAN, BOLTS)) == "cyclic" and sector_count((FAN, BOLTS)) == 4
    for features in ((BOLTS, KEYS), (FAN, KEYWAY), (replace(FAN, count=2),)):
        assert symmetry(carrying(*features)) == "asymmetric"
    drum = section("drum", 0.02, 0.1, 0.03, 0.06), section("last", 0.1, 0.12, 0.03, 0.1)
    rows = FAN, replace(FAN, name="more", on="last", count=7)
    staged = carrying(*rows, sections=(DISK, *drum))
    assert symmetry(staged) == "staged" and layout_of(staged).counts == (12, 7)
    assert symmetry(replace(staged, features=(*rows, KEYWAY))) == "asymmetric"


def _width_at(outline, radius):
    """Axial range of an outline at a distance from the axis, on its sides."""
    z, r = np.vstack([outline, outline[:1]]).T
    crossed = [
        a + (radius - c) / (d - c) * (b - a)
        for a, b, c, d in zip(z[:-1], z[1:], r[:-1], r[1:], strict=True)
        if min(c, d) <= radius < max(c, d)
    ]
    return min(crossed), max(crossed)


def test_blades_are_seen_as_wide_as_their_plate_reaches():
    twisted = replace(FAN, stagger_deg=(20.0, -50.0), thickness_m=(0.006, 0.002), at_m=0.004)
    outline = side_view(twisted, DISK)
    assert outline[:, 1].min() == 0.1 and outline[:, 1].max() == pytest.approx(0.15)
    y, z = np.meshgrid(np.linspace(-0.02, 0.02, 801), np.linspace(-0.02, 0.03, 1001))
    for share in (0.0, 0.375, 0.75):
        angle, thickness = math.radians(20.0 - 70.0 * share), 0.006 - 0.004 * share
        along = (z - 0.004) * math.cos(angle) + y * math.sin(angle)
        across = y * math.cos(angle) - (z - 0.004) * math.sin(angle)
        inside = z[(np.abs(along) <= 0.01) & (np.abs(across) <= 0.5 * thickness)]
        # the corner lies within one step of the grid, 5e-5 m, on both axes
        found = _width_at(outline, 0.1 + 0.05 * share)
        assert found == pytest.approx((inside.min(), inside.max()), abs=1.5e-4)


def test_holes_and_slots_are_seen_from_the_side():
    z, r = side_view(BOLTS, DISK).T
    assert (z.min(), z.max()) == (-0.02, 0.02)
    assert (r.min(), r.max()) == pytest.approx((0.054, 0.066))
    cone = replace(DISK, outer_radius_m=(0.1, 0.08))
    expected = [(-0.02, 0.09), (0.0, 0.09), (0.0, 0.09), (-0.02, 0.1)]
    assert side_view(KEYS, cone) == pytest.approx(np.array(expected))
    z, r = side_view(replace(BOLTS, end_m=0.01), DISK).T
    assert (z.min(), z.max()) == (-0.02, 0.01)
    expected = [(-0.02, 0.075), (0.01, 0.075), (0.01, 0.085), (-0.02, 0.1)]
    assert side_view(FLAT, cone) == pytest.approx(np.array(expected))
