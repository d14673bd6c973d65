"""Faces, shared curves and corners of bodies whose subdivision is known by hand."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from outlines import area_of, conforming, loops_of
from shapes import body, interface, section, shaft_and_disk

from solidwhirl.geometry import MATERIALS, subdivide

RIGHT_ANGLE_RAD = 1.5 * math.pi


def curve_between(found, first, last):
    """Return the index of the curve between two places (z, r), None if there is none."""
    for number, curve in enumerate(found.curves):
        ends = found.points[[curve.start, curve.end]]
        if np.allclose(ends, [first, last]) or np.allclose(ends, [last, first]):
            return number
    return None


def corner_places(found):
    return [tuple(np.round(found.points[corner.point], 12)) for corner in found.corners]


def test_shaft_and_disk():
    found = subdivide(shaft_and_disk())
    conforming(found)
    assert [face.section for face in found.faces] == [0, 1]
    assert found.section_names == ("shaft", "disk")
    areas = [area_of(found, face.loop) for face in found.faces]
    assert areas == pytest.approx([0.4 * 0.02, 0.03 * 0.13], rel=1e-13)
    # 8 corners of two rectangles; the disk's two foot points split the shaft's surface.
    assert (len(found.points), len(found.curves)) == (8, 9)
    assert len(found.axis) == 1
    assert len(found.boundary) == 7
    shared = curve_between(found, (0.145, 0.02), (0.175, 0.02))
    assert shared not in (None, *found.boundary)


def test_corners_of_shaft_and_disk():
    corners = subdivide(shaft_and_disk()).corners
    assert [corner.interior_angle_rad for corner in corners] == pytest.approx([RIGHT_ANGLE_RAD] * 2)
    assert not any(corner.filleted for corner in corners)
    assert corner_places(subdivide(shaft_and_disk())) == [(0.145, 0.02), (0.175, 0.02)]


def test_flush_disk_has_one_corner_and_full_length_sleeve_none():
    shaft = section("shaft", 0.0, 0.4, 0.0, 0.02)
    flush = subdivide(body(shaft, section("disk", 0.37, 0.4, 0.02, 0.15)))
    assert corner_places(flush) == [(0.37, 0.02)]
    sleeve = subdivide(body(shaft, section("sleeve", 0.0, 0.4, 0.02, 0.15)))
    assert sleeve.corners == ()


def test_corner_angle_of_a_taper():
    """A cone that rises by 1 in 1 on a cylinder: 180 + 45 degrees of material."""
    found = subdivide(
        body(section("shaft", 0.0, 0.2, 0.0, 0.1), section("cone", 0.2, 0.3, 0.0, (0.1, 0.2)))
    )
    assert [c.interior_angle_rad for c in found.corners] == pytest.approx([1.25 * math.pi])


def test_read_only():
    found = subdivide(shaft_and_disk(interfaces=[interface("end", "face", 0.0)]))
    with pytest.raises(ValueError, match="read-only"):
        found.points[0, 0] = 1.0
    with pytest.raises(TypeError):
        found.interfaces["end"] = ()


def test_bore_makes_no_axis():
    found = subdivide(body(section("tube", 0.0, 1.0, 0.1, 0.2)))
    conforming(found)
    assert found.axis == ()
    assert len(found.boundary) == 4


def test_t_junctions_on_radial_and_axial_edges():
    """Steps of different heights side by side: neighbours share whole curves."""
    found = subdivide(
        body(
            section("low", 0.0, 0.2, 0.0, 0.1),
            section("high", 0.2, 0.3, 0.0, 0.3),
            section("ring", 0.3, 0.4, 0.15, 0.2),
            section("shaft", 0.3, 0.6, 0.0, 0.1),
        )
    )
    conforming(found)
    for r_0, r_1, inside in (
        (0.0, 0.1, True),
        (0.1, 0.15, False),
        (0.15, 0.2, True),
        (0.2, 0.3, False),
    ):
        number = curve_between(found, (0.3, r_0), (0.3, r_1))
        assert number is not None
        assert (number not in found.boundary) == inside
    assert curve_between(found, (0.2, 0.0), (0.2, 0.1)) not in (None, *found.boundary)


def test_sloped_edges_in_contact():
    """A sleeve on a part of a cone: its corners lie on the cone's sloped surface."""
    cone = section("cone", 0.0, 0.9, 0.0, (0.1, 0.37))
    ends = [cone.radii_at(z)[1] for z in (1.0 / 3.0, 0.7)]
    sleeve = section("sleeve", 1.0 / 3.0, 0.7, (ends[0], ends[1]), 0.5)
    found = subdivide(body(cone, sleeve))
    conforming(found)
    assert curve_between(found, (1.0 / 3.0, ends[0]), (0.7, ends[1])) not in (None, *found.boundary)
    assert len(found.corners) == 2
    # Angle between the cone's surface and a radial face: 270 degrees less or more atan(0.3).
    slope = math.atan(0.3)
    assert [c.interior_angle_rad for c in found.corners] == pytest.approx(
        [RIGHT_ANGLE_RAD - slope, RIGHT_ANGLE_RAD + slope]
    )


def test_closed_cavity():
    """Two disks bridged by a drum enclose a void: two outline loops, four corners inside."""
    found = subdivide(
        body(
            section("shaft", 0.0, 1.0, 0.0, 0.1),
            section("one", 0.2, 0.3, 0.1, 0.5),
            section("two", 0.7, 0.8, 0.1, 0.5),
            section("drum", 0.3, 0.7, 0.4, 0.5),
        )
    )
    conforming(found)
    areas = sorted(area_of(found, loop) for loop in loops_of(found))
    assert areas == pytest.approx([-0.4 * 0.3, 0.1 + 0.6 * 0.4], rel=1e-12)
    assert len(found.corners) == 6


def test_triangles_on_the_axis():
    """A solid tip and a conical blind hole both end in a vertex on the axis."""
    found = subdivide(
        body(
            section("tip", 0.0, 0.1, 0.0, (0.0, 0.2)),
            section("solid", 0.1, 0.4, 0.0, 0.2),
            section("drilled", 0.4, 0.5, (0.0, 0.1), 0.2),
        )
    )
    conforming(found)
    assert len(found.faces) == 3
    assert len(found.axis) == 2
    assert found.corners == ()


def test_triangle_with_its_edge_on_a_neighbour():
    found = subdivide(
        body(section("shaft", 0.0, 1.0, 0.0, 0.1), section("wedge", 0.2, 0.5, 0.1, (0.1, 0.3)))
    )
    conforming(found)
    assert len(found.corners) == 2


def test_materials_are_listed_once():
    steel, titanium = MATERIALS["steel"], MATERIALS["titanium"]
    found = subdivide(
        body(
            section("a", 0.0, 1.0, 0.0, 0.1, steel),
            section("b", 1.0, 2.0, 0.0, 0.1, titanium),
            section("c", 2.0, 3.0, 0.0, 0.1, steel),
        )
    )
    assert found.materials == (steel, titanium)
    assert [face.material for face in found.faces] == [0, 1, 0]


@pytest.mark.parametrize("slip", [1e-10, -1e-10])
def test_slips_below_the_tolerance_are_bonded(slip):
    """A tenth of the tolerance (1e-9 of the size 1 m), apart or overlapping, along z and r."""
    found = subdivide(
        body(
            section("shaft", 0.0, 0.5, 0.0, 0.1),
            section("more", 0.5 + slip, 1.0, slip if slip > 0.0 else 0.0, 0.1),
            section("disk", 0.2, 0.3, 0.1 + slip, 0.3),
        )
    )
    conforming(found)
    assert len(found.axis) == 2
    assert len(found.corners) == 2


def test_slips_on_a_sloped_edge_are_bonded():
    cone = section("cone", 0.0, 1.0, 0.0, (0.1, 0.4))
    found = subdivide(body(cone, section("ring", 0.2, 0.6, (0.16 + 3e-10, 0.28 - 3e-10), 0.5)))
    conforming(found)
    assert len(found.corners) == 2


def test_collinear_pieces_are_no_corners():
    """A cone drawn in thirds whose radii do not have exact binary fractions."""
    whole = section("cone", 0.0, 0.3, 0.0, (0.1, 0.2))
    cuts = (0.0, 0.1, 0.2, 0.3)
    found = subdivide(
        body(
            *(
                section(f"c{k}", a, b, 0.0, (whole.radii_at(a)[1], whole.radii_at(b)[1]))
                for k, (a, b) in enumerate(pairwise(cuts))
            )
        )
    )
    assert found.corners == ()
