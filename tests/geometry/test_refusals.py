"""Sections that do not fit together are refused with their names and the place."""

from __future__ import annotations

import pytest
from shapes import body, interface, section

from solidwhirl.geometry import GeometryError, subdivide


def refused(message):
    return pytest.raises(GeometryError, match=message)


@pytest.mark.parametrize(
    ("message", "sections"),
    [
        # rectangles that share 0.1 m x 0.05 m; the depth is 0.05 m all along
        (
            r"'rotor': sections 'a' and 'b' overlap by 0.005 m\^2 of the meridian, deepest at "
            r"z = 0.4 m, r = 0.075 m",
            [("a", 0.0, 0.5, 0.0, 0.1), ("b", 0.4, 0.6, 0.05, 0.2)],
        ),
        # two triangles, 1 m long, crossing in a third one of base 1 m and height 0.25 m
        (
            r"overlap by 0.125 m\^2 .* z = 0.5 m, r = 0.125 m",
            [("a", 0.0, 1.0, 0.0, (0.0, 0.5)), ("b", 0.0, 1.0, 0.0, (0.5, 0.0))],
        ),
        # a ring whose bore dips 1 mm into a cone over a small part of its length
        (
            "'cone' and 'ring' overlap",
            [("cone", 0.0, 1.0, 0.0, (0.1, 0.2)), ("ring", 0.2, 0.4, 0.139, 0.3)],
        ),
        ("'a' and 'b' overlap", [("a", 0.0, 1.0, 0.0, 0.1), ("b", 0.0, 1.0, 0.0, 0.1)]),
        (
            r"is in 2 pieces: \('a', 'c'\) and \('b'\); gap between 'a' and 'b' at z = 0.5 m, "
            r"r = .* m \(0.0001 m wide\)",
            [("a", 0.0, 0.5, 0.0, 0.1), ("b", 0.5001, 1.0, 0.0, 0.1), ("c", 0.1, 0.2, 0.1, 0.3)],
        ),
        (
            r"gap between 'shaft' and 'disk' at z = .* m, r = 0.1 m \(0.002 m wide\)",
            [("shaft", 0.0, 1.0, 0.0, 0.1), ("disk", 0.2, 0.3, 0.102, 0.3)],
        ),
        (
            r"in 3 pieces: \('a'\) and \('b'\) and \('c'\); gap between 'b' and 'c'",
            [("a", 0.0, 0.1, 0.0, 0.1), ("b", 0.3, 0.4, 0.0, 0.1), ("c", 0.5, 0.6, 0.0, 0.1)],
        ),
        (
            r"'a', 'b' touch only in a point at z = 0.5 m, r = 0.1 m",
            [("a", 0.0, 0.5, 0.0, 0.1), ("b", 0.5, 1.0, 0.1, 0.2)],
        ),
        # a drum's end touches the corner of a disk; both also stand on one shaft
        (
            r"'one', 'drum' touch only in a point at z = 0.3 m, r = 0.4 m",
            [
                ("shaft", 0.0, 1.0, 0.0, 0.1),
                ("one", 0.2, 0.3, 0.1, 0.4),
                ("drum", 0.3, 0.6, 0.4, 0.5),
                ("two", 0.6, 0.7, 0.1, 0.5),
            ],
        ),
        # tips that meet on the axis, and a bore that closes in the end plane
        (
            r"'a', 'b' touch only in a point at z = 0.5 m, r = 0 m",
            [("a", 0.0, 0.5, 0.0, (0.1, 0.0)), ("b", 0.5, 1.0, 0.0, (0.0, 0.1))],
        ),
        (
            r"'a' touch the axis only in a point at z = 1 m, r = 0 m",
            [("a", 0.0, 1.0, (0.1, 0.0), 0.2)],
        ),
        # thinner than the tolerance
        (
            "section 'film': no thickness",
            [("a", 0.0, 1.0, 0.0, 0.1), ("film", 0.0, 1.0, 0.1, 0.1 + 1e-10)],
        ),
        (
            "section 'foil': negative width",
            [("a", 0.0, 1.0, 0.0, 0.1), ("foil", 1.0, 1.0 + 1e-10, 0.0, 0.1)],
        ),
        # a joint 2 tolerances from the tip lies on both edges of a wedge that rises by 1 in 30
        (
            r"section 'left' and 'wedge': two edges fall into one at z = 0.2",
            [
                ("left", 0.0, 0.2 + 2e-9, 0.0, 0.1),
                ("right", 0.2 + 2e-9, 1.0, 0.0, 0.1),
                ("wedge", 0.2, 0.5, 0.1, (0.1, 0.11)),
            ],
        ),
        # a crack beside a bond: 5 to 100 tolerances wide in a body of 1 m
        *(
            (
                rf"gap or edge of only {gap:.3g} m at z = .* \(sections .*'disk'.*\)",
                [
                    ("shaft", 0.0, 0.5, 0.0, 0.1),
                    ("step", 0.5, 1.0, 0.0, 0.1 - gap),
                    ("disk", 0.4, 0.6, 0.1, 0.3),
                ],
            )
            for gap in (5e-9, 1e-7)
        ),
    ],
)
def test_sections_that_do_not_fit_are_refused(message, sections):
    with refused(message):
        subdivide(body(*(section(*values) for values in sections)))


def test_plane_through_a_vanishing_tip():
    """Half a tolerance thick there is nothing to find; five tolerances are no sound edge."""
    tip = section("tip", 0.0, 1.0, 0.0, (0.0, 0.1))
    with refused("'plane' of kind 'section' at z = 5e-09 m lies outside"):
        subdivide(body(tip, interfaces=[interface("plane", "section", 5e-9)]))
    with refused("gap or edge of only 5e-09 m"):
        subdivide(body(tip, interfaces=[interface("plane", "section", 5e-8)]))
