"""Sections that do not fit together are refused with their names and the place."""

from __future__ import annotations

import pytest

from solidwhirl.geometry import GeometryError, subdivide


def refused(message):
    return pytest.raises(GeometryError, match=message)


def test_overlap_names_sections_area_and_place(section, body):
    """Rectangles that share 0.1 m x 0.05 m; the depth is 0.05 m all along."""
    with refused(
        r"'rotor': sections 'a' and 'b' overlap by 0.005 m\^2 of the meridian, deepest at "
        r"z = 0.4 m, r = 0.075 m"
    ):
        subdivide(body(section("a", 0.0, 0.5, 0.0, 0.1), section("b", 0.4, 0.6, 0.05, 0.2)))


def test_overlap_area_of_crossing_tapers(section, body):
    """Two triangles, 1 m long, crossing in a third one of base 1 m and height 0.25 m."""
    with refused(r"overlap by 0.125 m\^2 .* z = 0.5 m, r = 0.125 m"):
        subdivide(
            body(section("a", 0.0, 1.0, 0.0, (0.0, 0.5)), section("b", 0.0, 1.0, 0.0, (0.5, 0.0)))
        )


def test_overlap_in_a_corner_only(section, body):
    """A ring whose bore dips 1 mm into a cone over a small part of its length."""
    with refused("'cone' and 'ring' overlap"):
        subdivide(
            body(section("cone", 0.0, 1.0, 0.0, (0.1, 0.2)), section("ring", 0.2, 0.4, 0.139, 0.3))
        )


def test_identical_sections_overlap(section, body):
    with refused("'a' and 'b' overlap"):
        subdivide(body(section("a", 0.0, 1.0, 0.0, 0.1), section("b", 0.0, 1.0, 0.0, 0.1)))


def test_axial_gap(section, body):
    with refused(
        r"is in 2 pieces: \('a', 'c'\) and \('b'\); gap between 'a' and 'b' at z = 0.5 m, "
        r"r = .* m \(0.0001 m wide\)"
    ):
        subdivide(
            body(
                section("a", 0.0, 0.5, 0.0, 0.1),
                section("b", 0.5001, 1.0, 0.0, 0.1),
                section("c", 0.1, 0.2, 0.1, 0.3),
            )
        )


def test_radial_gap(section, body):
    with refused(r"gap between 'shaft' and 'disk' at z = .* m, r = 0.1 m \(0.002 m wide\)"):
        subdivide(body(section("shaft", 0.0, 1.0, 0.0, 0.1), section("disk", 0.2, 0.3, 0.102, 0.3)))


def test_three_pieces(section, body):
    with refused(r"in 3 pieces: \('a'\) and \('b'\) and \('c'\); gap between 'b' and 'c'"):
        subdivide(
            body(
                section("a", 0.0, 0.1, 0.0, 0.1),
                section("b", 0.3, 0.4, 0.0, 0.1),
                section("c", 0.5, 0.6, 0.0, 0.1),
            )
        )


def test_touching_in_a_point(section, body):
    with refused(r"'a', 'b' touch only in a point at z = 0.5 m, r = 0.1 m"):
        subdivide(body(section("a", 0.0, 0.5, 0.0, 0.1), section("b", 0.5, 1.0, 0.1, 0.2)))


def test_pinched_although_connected_elsewhere(section, body):
    """A drum's end touches the corner of a disk; both also stand on one shaft."""
    with refused(r"'one', 'drum' touch only in a point at z = 0.3 m, r = 0.4 m"):
        subdivide(
            body(
                section("shaft", 0.0, 1.0, 0.0, 0.1),
                section("one", 0.2, 0.3, 0.1, 0.4),
                section("drum", 0.3, 0.6, 0.4, 0.5),
                section("two", 0.6, 0.7, 0.1, 0.5),
            )
        )


def test_tips_meeting_on_the_axis(section, body):
    with refused(r"'a', 'b' touch only in a point at z = 0.5 m, r = 0 m"):
        subdivide(
            body(section("a", 0.0, 0.5, 0.0, (0.1, 0.0)), section("b", 0.5, 1.0, 0.0, (0.0, 0.1)))
        )


def test_bore_that_closes_in_the_end_plane(section, body):
    with refused(r"'a' touch the axis only in a point at z = 1 m, r = 0 m"):
        subdivide(body(section("a", 0.0, 1.0, (0.1, 0.0), 0.2)))


@pytest.mark.parametrize("gap", [5e-9, 1e-8, 1e-7])
def test_gap_between_tolerance_and_smallest_detail(section, body, gap):
    """A crack beside a bond: 5 to 100 tolerances wide in a body of 1 m."""
    with refused(rf"gap or edge of only {gap:.3g} m at z = .* \(sections .*'disk'.*\)"):
        subdivide(
            body(
                section("shaft", 0.0, 0.5, 0.0, 0.1),
                section("step", 0.5, 1.0, 0.0, 0.1 - gap),
                section("disk", 0.4, 0.6, 0.1, 0.3),
            )
        )


def test_section_thinner_than_the_tolerance(section, body):
    with refused("section 'film': no thickness"):
        subdivide(
            body(section("a", 0.0, 1.0, 0.0, 0.1), section("film", 0.0, 1.0, 0.1, 0.1 + 1e-10))
        )
    with refused("section 'foil': negative width"):
        subdivide(
            body(section("a", 0.0, 1.0, 0.0, 0.1), section("foil", 1.0, 1.0 + 1e-10, 0.0, 0.1))
        )


def test_plane_through_a_vanishing_tip(section, body, interface):
    """Half a tolerance thick there is nothing to find; five tolerances are no sound edge."""
    tip = section("tip", 0.0, 1.0, 0.0, (0.0, 0.1))
    with refused("'plane' of kind 'section' at z = 5e-09 m lies outside"):
        subdivide(body(tip, interfaces=[interface("plane", "section", 5e-9)]))
    with refused("gap or edge of only 5e-09 m"):
        subdivide(body(tip, interfaces=[interface("plane", "section", 5e-8)]))


def test_vertex_in_the_tip_of_a_thin_wedge(section, body):
    """A joint 2 tolerances from the tip lies on both edges of a wedge that rises by 1 in 30."""
    with refused(r"section 'left' and 'wedge': two edges fall into one at z = 0.2"):
        subdivide(
            body(
                section("left", 0.0, 0.2 + 2e-9, 0.0, 0.1),
                section("right", 0.2 + 2e-9, 1.0, 0.0, 0.1),
                section("wedge", 0.2, 0.5, 0.1, (0.1, 0.11)),
            )
        )
