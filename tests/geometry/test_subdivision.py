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
    angles = [corner.interior_angle_rad for corner in found.corners]
    assert angles == pytest.approx([RIGHT_ANGLE_RAD] * 2)
    assert not any(corner.filleted for corner in found.corners)
    assert corner_places(found) == [(0.145, 0.02), (0.175, 0.02)]


SHAFT = section("shaft", 0.0, 1.0, 0.0, 0.1)
CONE = section("cone", 0.0, 1.0, 0.0, (0.1, 0.4))
SLIP_M = 1e-10  # a tenth of the tolerance, 1e-9 of the size 1 m


def slipped(slip):
    """Shaft in two pieces with a disk, apart or overlapping along z and r."""
    return (
        section("shaft", 0.0, 0.5, 0.0, 0.1),
        section("more", 0.5 + slip, 1.0, max(slip, 0.0), 0.1),
        section("disk", 0.2, 0.3, 0.1 + slip, 0.3),
    )


def thirds():
    """A cone drawn in thirds whose radii do not have exact binary fractions."""
    whole = section("cone", 0.0, 0.3, 0.0, (0.1, 0.2))
    for a, b in pairwise((0.0, 0.1, 0.2, 0.3)):
        yield section(f"from {a}", a, b, 0.0, (whole.radii_at(a)[1], whole.radii_at(b)[1]))


# Sections, how many curves lie on the axis, and places of the corners.
SHAPES = {
    "bore": ((section("tube", 0.0, 1.0, 0.1, 0.2),), 0, []),
    "flush disk": ((SHAFT, section("disk", 0.9, 1.0, 0.1, 0.15)), 1, [(0.9, 0.1)]),
    "sleeve of full length": ((SHAFT, section("sleeve", 0.0, 1.0, 0.1, 0.15)), 1, []),
    # a solid tip and a conical blind hole both end in a vertex on the axis
    "triangles on the axis": (
        (
            section("tip", 0.0, 0.1, 0.0, (0.0, 0.2)),
            section("solid", 0.1, 0.4, 0.0, 0.2),
            section("drilled", 0.4, 0.5, (0.0, 0.1), 0.2),
        ),
        2,
        [],
    ),
    "edge of a triangle on its neighbour": (
        (SHAFT, section("wedge", 0.2, 0.5, 0.1, (0.1, 0.3))),
        1,
        [(0.2, 0.1), (0.5, 0.1)],
    ),
    "gap below the tolerance": (slipped(SLIP_M), 2, [(0.2, 0.1), (0.3, 0.1)]),
    "overlap below the tolerance": (slipped(-SLIP_M), 2, [(0.2, 0.1), (0.3, 0.1)]),
    "slips on a sloped edge": (
        (CONE, section("ring", 0.2, 0.6, (0.16 + 3e-10, 0.28 - 3e-10), 0.5)),
        1,
        [(0.2, 0.16), (0.6, 0.28)],
    ),
    "collinear pieces": (tuple(thirds()), 3, []),
}


@pytest.mark.parametrize("case", SHAPES)
def test_axis_and_corners(case):
    sections, axis, corners = SHAPES[case]
    found = subdivide(body(*sections))
    conforming(found)
    assert len(found.axis) == axis
    places = np.array(corner_places(found)).reshape(-1, 2)
    # slips below the tolerance move a place by as much
    np.testing.assert_allclose(places, np.reshape(corners, (-1, 2)), rtol=0.0, atol=1e-9)


def test_corner_angle_of_a_taper():
    """A cone that rises by 1 in 1 on a cylinder: 180 + 45 degrees of material."""
    cone = section("cone", 0.2, 0.3, 0.0, (0.1, 0.2))
    found = subdivide(body(section("shaft", 0.0, 0.2, 0.0, 0.1), cone))
    assert [c.interior_angle_rad for c in found.corners] == pytest.approx([1.25 * math.pi])


def test_read_only():
    found = subdivide(shaft_and_disk(interfaces=[interface("end", "face", 0.0)]))
    with pytest.raises(ValueError, match="read-only"):
        found.points[0, 0] = 1.0
    with pytest.raises(TypeError):
        found.interfaces["end"] = ()


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
