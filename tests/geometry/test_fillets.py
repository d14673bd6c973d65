"""Fillets: shape, area, tangency, neighbours, and everything that does not fit."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from outlines import area_of, chords_of, conforming
from shapes import body, interface, section, shaft_and_disk

from solidwhirl.geometry import MATERIALS, GeometryError, mass_properties, merge_fillets, subdivide


def fillet_faces(found):
    return [face for face in found.faces if {n for n, _ in face.loop} & set(found.fillet_arcs)]


def wedge_fillet_area(radius, interior_angle):
    """Kite of the two tangents less the sector, for the empty wedge 2 pi - interior angle."""
    wedge = 2.0 * math.pi - interior_angle
    return radius**2 * (1.0 / math.tan(wedge / 2.0) - (math.pi - wedge) / 2.0)


def check_tangent(found):
    """Assert that every arc leaves the neighbouring outline without a kink, on its circle."""
    for number in found.fillet_arcs:
        arc = found.curves[number]
        centre = found.points[arc.centre]
        for point in (arc.start, arc.end):
            spoke = found.points[point] - centre
            others = [
                c
                for n, c in enumerate(found.curves)
                if n in found.boundary and n != number and point in (c.start, c.end)
            ]
            assert len(others) == 1
            if others[0].centre is None:
                edge = found.points[others[0].end] - found.points[others[0].start]
                # cosine of the angle between edge and spoke; coordinates round at 1e-16
                assert abs(edge @ spoke) / np.hypot(*edge) / np.hypot(*spoke) < 1e-12


def test_square_corner():
    radius = 0.005
    found = subdivide(shaft_and_disk(fillet=radius))
    conforming(found)
    check_tangent(found)
    faces = fillet_faces(found)
    assert [area_of(found, face.loop) for face in faces] == pytest.approx(
        [radius**2 * (1.0 - math.pi / 4.0)] * 2, rel=1e-11
    )
    assert len(found.faces) == 4
    assert [corner.filleted for corner in found.corners] == [True, True]
    tangents = {
        tuple(np.round(found.points[p], 12))
        for n in found.fillet_arcs
        for p in (found.curves[n].start, found.curves[n].end)
    }
    assert tangents == {(0.14, 0.02), (0.145, 0.025), (0.175, 0.025), (0.18, 0.02)}


def test_oblique_corners():
    """A disk on a cone has one acute and one obtuse empty wedge."""
    radius = 0.01
    cone = section("cone", 0.0, 1.0, 0.0, (0.1, 0.4))
    disk = section("disk", 0.4, 0.5, (0.22, 0.25), 0.6)
    found = subdivide(body(cone, disk, fillet=radius))
    conforming(found)
    check_tangent(found)
    areas = [area_of(found, face.loop) for face in fillet_faces(found)]
    expected = [wedge_fillet_area(radius, c.interior_angle_rad) for c in found.corners]
    # Areas of 1e-5 m^2 from a shoelace over coordinates of 0.1 m.
    assert areas == pytest.approx(expected, rel=1e-9)
    assert abs(areas[0] - areas[1]) > 0.1 * areas[0]


def test_material_is_that_of_the_section_listed_first():
    titanium, steel = MATERIALS["titanium"], MATERIALS["steel"]
    shaft = section("shaft", 0.0, 1.0, 0.0, 0.1, steel)
    disk = section("disk", 0.4, 0.5, 0.1, 0.3, titanium)
    for order in ((shaft, disk), (disk, shaft)):
        shape = body(*order, fillet=0.01)
        found = subdivide(shape)
        assert {face.section for face in fillet_faces(found)} == {0}
        assert {found.materials[face.material] for face in fillet_faces(found)} == {
            order[0].material
        }
        # Pappus: centroid of the region between a square corner and its arc, from the corner.
        area = 0.01**2 * (1.0 - math.pi / 4.0)
        centroid = 0.01 * (1.0 - (2.0 / 3.0) / (4.0 - math.pi))
        added = 2.0 * area * 2.0 * math.pi * (0.1 + centroid) * order[0].material.density_kg_per_m3
        sharp = mass_properties(replace(shape, fillet_radius_m=0.0)).mass_kg
        # The fillets are 1e-4 of the mass: 1e-12 of the whole is 1e-8 of them.
        assert mass_properties(shape).mass_kg - sharp == pytest.approx(added, rel=1e-8)


def test_collinear_curves_count_as_one_edge():
    """The tangent piece runs over a seat's end and a joint between two shaft sections."""
    found = subdivide(
        body(
            section("left", 0.0, 0.395, 0.0, 0.1),
            section("right", 0.395, 1.0, 0.0, 0.1),
            section("disk", 0.4, 0.5, 0.1, 0.3),
            fillet=0.01,
            interfaces=[interface("seat", "outer", 0.1, 0.39)],
        )
    )
    conforming(found)
    check_tangent(found)
    faces = fillet_faces(found)
    assert sorted(len(face.loop) for face in faces) == [3, 4]
    # The left corner's outline belongs to right (1) and disk (2).
    assert {face.section for face in faces} == {1}
    seat = found.curves[found.interfaces["seat"][0]]
    assert np.sort(found.points[[seat.start, seat.end], 0]) == pytest.approx([0.1, 0.39])


def groove(width, fillet, **options):
    return body(
        section("shaft", 0.0, 1.0, 0.0, 0.1),
        section("one", 0.3, 0.4, 0.1, 0.2),
        section("two", 0.4 + width, 0.6 + width, 0.1, 0.2),
        fillet=fillet,
        **options,
    )


@pytest.mark.parametrize(("width", "fillet"), [(0.02, 0.01), (0.03, 0.015), (0.02, 0.00999)])
def test_groove_with_a_full_radius(width, fillet):
    """Two fillets may use up their common edge; their arcs then meet in one tangent point."""
    found = subdivide(groove(width, fillet))
    conforming(found)
    check_tangent(found)
    total = sum(area_of(found, face.loop) for face in found.faces)
    sharp = 0.1 + 0.1 * 0.1 + 0.2 * 0.1
    assert total - sharp == pytest.approx(4.0 * fillet**2 * (1.0 - math.pi / 4.0), rel=1e-9)


def test_fillet_as_long_as_its_edge():
    """The tangent point falls on the end of a shoulder as high as the radius."""
    found = subdivide(
        body(
            section("shaft", 0.0, 0.3, 0.0, 0.1), section("step", 0.3, 0.6, 0.0, 0.11), fillet=0.01
        )
    )
    conforming(found)
    (arc,) = (found.curves[number] for number in found.fillet_arcs)
    step = next(k for k, place in enumerate(found.points) if np.allclose(place, (0.3, 0.11)))
    assert step in (arc.start, arc.end)
    assert area_of(found, fillet_faces(found)[0].loop) == pytest.approx(
        0.01**2 * (1.0 - math.pi / 4.0), rel=1e-9
    )
    conforming(merge_fillets(found))


def test_all_corners_of_a_cavity_get_fillets():
    parts = (
        section("tube", 0.0, 1.0, 0.1, 0.2),
        section("one", 0.0, 0.1, 0.2, 0.6),
        section("two", 0.9, 1.0, 0.2, 0.6),
        section("drum", 0.1, 0.9, 0.5, 0.6),
    )
    found = subdivide(body(*parts, fillet=0.05))
    conforming(found)
    check_tangent(found)
    assert len(found.fillet_arcs) == 4


def test_flat_corners_stay_as_they_are():
    """A kink of 1e-7 rad would give a fillet 5 nm long: reported, not filleted."""
    parts = (
        section("a", 0.0, 0.5, 0.0, 0.1),
        section("b", 0.5, 1.0, 0.0, (0.1, 0.1 + 1e-5)),
        section("c", 0.2, 0.3, 0.1, 0.2),
    )
    found = subdivide(body(*parts, fillet=0.01))
    conforming(found)
    assert sorted(corner.filleted for corner in found.corners) == [False, True, True]


@pytest.mark.parametrize(
    ("width", "fillet", "message"),
    [
        (
            0.02,
            0.0101,
            r"fillet of radius 0.0101 m at z = 0.4 m, r = 0.1 m does not fit: it needs 0.0101 m of "
            r"the adjacent straight edge, available are 0.02 m less 0.0101 m of the neighbouring",
        ),
        (0.3, 0.11, r"at z = 0.3 m, r = 0.1 m does not fit: it needs 0.11 m .* are 0.1 m$"),
        (0.02, 1e-8, "fillet radius 1e-08 m is below the smallest length allowed, 1e-06 m"),
    ],
)
def test_refused_radii(width, fillet, message):
    with pytest.raises(GeometryError, match=message):
        subdivide(groove(width, fillet))


def test_refused_where_another_part_is_in_the_way():
    """The tip of a bar reaches between the corner and the arc."""
    parts = (
        section("shaft", 0.0, 1.0, 0.0, 0.1),
        section("disk", 0.4, 0.5, 0.1, 0.3),
        section("other", 0.1, 0.11, 0.1, 0.6),
        section("bar", 0.11, 0.39, (0.4, 0.105), (0.5, 0.2)),
    )
    with pytest.raises(GeometryError, match=r"at z = 0.4 m, r = 0.1 m .* runs into section 'bar'"):
        subdivide(body(*parts, fillet=0.05))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("outer", 0.2, 0.3), "covers a part of the interface 'seat'; move .* 0.005 m"),
        (("outer", 0.2, 0.297), "covers a part of the interface 'seat'"),
        (("section", 0.297), "widens the cross-section of the interface 'seat'"),
        # the whole plane at the foot of a disk loses its corner to the fillet
        (("section", 0.3), "covers a part of the interface 'seat'"),
    ],
)
def test_refused_over_an_interface(arguments, message):
    seat = interface("seat", *arguments)
    with pytest.raises(GeometryError, match=rf"at z = 0.3 m, r = 0.1 m {message}"):
        subdivide(groove(0.05, 0.005, interfaces=[seat]))


@pytest.mark.parametrize(
    "arguments",
    [
        ("outer", 0.2, 0.295),
        ("section", 0.297, None, (0.0, 0.1)),
        ("section", 0.3, None, (0.0, 0.1)),
    ],
)
def test_interfaces_beside_a_fillet_are_untouched(arguments):
    """Clear of it, or limited to the shaft."""
    seat = interface("seat", *arguments)
    found = subdivide(groove(0.05, 0.005, interfaces=[seat]))
    assert len(found.interfaces["seat"]) == 1


def smallest_face_angle(found):
    """Return the smallest angle [rad] between consecutive curves of any face, arcs as chords."""
    smallest = math.pi
    for face in found.faces:
        # Arcs cut fine enough that a chord at a cusp differs from its tangent by 0.4 degrees.
        places = chords_of(found, face.loop, per_arc=100)
        before = places - np.roll(places, 1, axis=0)
        after = np.roll(places, -1, axis=0) - places
        turn = np.arctan2(
            before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], (before * after).sum(axis=1)
        )
        smallest = min(smallest, float(np.min(math.pi - turn)))
    return smallest


@pytest.mark.parametrize("width", [0.02, 0.05])
def test_merging_removes_the_cusps(width):
    shape = groove(
        width,
        0.01,
        interfaces=[interface("seat", "outer", 0.1, 0.2), interface("mid", "section", 0.35)],
    )
    apart = subdivide(shape)
    merged = merge_fillets(apart)
    conforming(merged)
    assert len(merged.faces) == len(apart.faces) - 4
    assert len(merged.fillet_arcs) == 8
    assert merged.materials == apart.materials
    total = [sum(area_of(f, face.loop) for face in f.faces) for f in (apart, merged)]
    assert total[1] == pytest.approx(total[0], rel=1e-13)
    assert smallest_face_angle(apart) < math.radians(1.0)
    assert smallest_face_angle(merged) > math.radians(85.0)
    for name, curves in apart.interfaces.items():
        ends = [
            sorted(
                tuple(f.points[p]) for n in numbers for p in (f.curves[n].start, f.curves[n].end)
            )
            for f, numbers in ((apart, curves), (merged, merged.interfaces[name]))
        ]
        assert ends[0] == ends[1]
    corner_places = [[tuple(f.points[c.point]) for c in f.corners] for f in (apart, merged)]
    assert corner_places[0] == corner_places[1]


def test_merging_keeps_materials():
    titanium = MATERIALS["titanium"]
    found = subdivide(
        body(
            section("shaft", 0.0, 1.0, 0.0, 0.1),
            section("disk", 0.4, 0.5, 0.1, 0.3, titanium),
            fillet=0.01,
        )
    )
    merged = merge_fillets(found)
    conforming(merged)

    def area(f, material):
        return sum(area_of(f, face.loop) for face in f.faces if face.material == material)

    for material in (0, 1):
        assert area(merged, material) == pytest.approx(area(found, material), rel=1e-13)
    # The halves at the titanium disk cannot be joined to it.
    assert len(merged.faces) == 4


def test_merging_without_fillets_changes_nothing():
    found = subdivide(shaft_and_disk())
    merged = merge_fillets(found)
    assert merged.curves == found.curves
    assert merged.faces == found.faces
    assert np.array_equal(merged.points, found.points)
