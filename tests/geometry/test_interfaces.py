"""Which curves an interface finds, where it cuts, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest
from outlines import conforming
from shapes import body, interface, section

from solidwhirl.geometry import GeometryError, subdivide


def spans(found, name):
    """Return the sorted end points (z, r) of an interface's curves, rounded to 1e-12 m."""
    return sorted(
        tuple(sorted(tuple(map(float, np.round(found.points[p], 12))) for p in (c.start, c.end)))
        for c in (found.curves[number] for number in found.interfaces[name])
    )


def stepped(*interfaces):
    """Hollow shaft with a disk; bore 0.01, shaft 0.02, disk 0.1 m from z = 0.1 to 0.2 m."""
    shaft, disk = section("shaft", 0.0, 0.4, 0.01, 0.02), section("disk", 0.1, 0.2, 0.02, 0.1)
    return body(shaft, disk, interfaces=interfaces)


FOUND = {
    "a plane cuts every section": (
        ("section", 0.15),
        [((0.15, 0.01), (0.15, 0.02)), ((0.15, 0.02), (0.15, 0.1))],
    ),
    "limited in radius": (("section", 0.15, None, (0.0, 0.02)), [((0.15, 0.01), (0.15, 0.02))]),
    "limits inside a section": (
        ("section", 0.15, None, (0.04, 0.07)),
        [((0.15, 0.04), (0.15, 0.07))],
    ),
    # in the plane of a step the interface is the union of both sides
    "step": (("section", 0.1), [((0.1, 0.01), (0.1, 0.02)), ((0.1, 0.02), (0.1, 0.1))]),
    "step below": (("section", 0.1, None, (0.0, 0.02)), [((0.1, 0.01), (0.1, 0.02))]),
    "a face is the outline": (("face", 0.1), [((0.1, 0.02), (0.1, 0.1))]),
    "part of a face": (("face", 0.2, None, (0.05, 0.08)), [((0.2, 0.05), (0.2, 0.08))]),
    "a seat splits the surface": (("outer", 0.25, 0.3), [((0.25, 0.02), (0.3, 0.02))]),
    "bore": (("inner", 0.05, 0.15), [((0.05, 0.01), (0.15, 0.01))]),
    # radial faces do not belong to an outer surface, whatever lies between its ends does
    "over a disk": (
        ("outer", 0.05, 0.25),
        [((0.05, 0.02), (0.1, 0.02)), ((0.1, 0.1), (0.2, 0.1)), ((0.2, 0.02), (0.25, 0.02))],
    ),
    # within the tolerance a bound snaps to the step
    "beside a vertex": (("outer", 0.2 + 1e-11, 0.3), [((0.2, 0.02), (0.3, 0.02))]),
}


@pytest.mark.parametrize("case", FOUND)
def test_curves_of_an_interface(case):
    arguments, expected = FOUND[case]
    found = subdivide(stepped(interface("it", *arguments)))
    conforming(found)
    assert spans(found, "it") == expected


@pytest.mark.parametrize(
    ("radius", "sections"),
    [(None, [0, 0, 1, 1]), ((0.0, 0.02), [0, 0, 1]), ((0.04, 0.07), [0, 1, 1])],
)
def test_planes_cut_what_they_reach(radius, sections):
    found = subdivide(stepped(interface("mid", "section", 0.15, radius=radius)))
    assert [face.section for face in found.faces] == sections
    assert not set(found.interfaces["mid"]) & set(found.boundary)


def test_section_plane_at_the_end_is_the_end_face():
    found = subdivide(stepped(interface("end", "section", 0.4), interface("face", "face", 0.4)))
    assert spans(found, "end") == [((0.4, 0.01), (0.4, 0.02))]
    assert found.interfaces["end"] == found.interfaces["face"]
    assert set(found.interfaces["end"]) <= set(found.boundary)


def test_radius_picks_one_of_several_surfaces():
    shapes = (
        section("shaft", 0.0, 1.0, 0.0, 0.1),
        section("web", 0.4, 0.5, 0.1, 0.3),
        section("drum", 0.4, 0.9, 0.3, 0.35),
    )
    found = subdivide(
        body(
            *shapes,
            interfaces=[
                interface("all", "outer", 0.6, 0.7),
                interface("drum", "outer", 0.6, 0.7, (0.3, 0.4)),
                interface("under", "inner", 0.6, 0.7),
            ],
        )
    )
    assert spans(found, "all") == [((0.6, 0.1), (0.7, 0.1)), ((0.6, 0.35), (0.7, 0.35))]
    assert spans(found, "drum") == [((0.6, 0.35), (0.7, 0.35))]
    # The axis is no surface.
    assert spans(found, "under") == [((0.6, 0.3), (0.7, 0.3))]


def test_sloped_surface_is_cut_in_z_and_r():
    cone = section("cone", 0.0, 1.0, 0.0, (0.1, 0.5))
    found = subdivide(body(cone, interfaces=[interface("seat", "outer", 0.25, 0.5)]))
    conforming(found)
    assert spans(found, "seat") == [((0.25, 0.2), (0.5, 0.3))]
    wide = interface("seat", "outer", 0.25, 0.5, (0.2, 0.25))
    with pytest.raises(GeometryError, match=r"only z = 0.25 m to 0.375 m is covered"):
        subdivide(body(cone, interfaces=[wide]))


def test_interfaces_may_share_bounds_and_overlap():
    found = subdivide(
        stepped(
            interface("a", "outer", 0.22, 0.30),
            interface("b", "outer", 0.26, 0.34),
            interface("plane", "section", 0.26),
        )
    )
    conforming(found)
    assert len(set(found.interfaces["a"]) & set(found.interfaces["b"])) == 1
    assert len(found.interfaces["a"]) == len(found.interfaces["b"]) == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("i", "section", 0.5),
            r"interface 'i' of kind 'section' at z = 0.5 m lies outside the body 'rotor': no curve "
            r"found there; the body reaches from z = 0 m to 0.4 m and from r = 0.01 m to 0.1 m",
        ),
        (("i", "section", 0.15, None, (0.2, 0.3)), "r = 0.2 m to 0.3 m lies outside the body"),
        (("i", "face", 0.15), "'i' of kind 'face' at z = 0.15 m lies outside"),
        (("i", "outer", 0.5, 0.6), "z = 0.5 m to 0.6 m lies outside"),
        (("i", "inner", 0.1, 0.2, (0.05, 0.2)), "'i' of kind 'inner' at .* lies outside"),
        (
            ("i", "outer", 0.35, 0.45),
            "'i' of kind 'outer' at z = 0.35 m to 0.45 m is partially outside the body: only "
            "z = 0.35 m to 0.4 m is covered",
        ),
        (("i", "outer", -0.1, 0.05), "only z = 0 m to 0.05 m is covered"),
        # a little more than the tolerance beside a vertex is refused as a slip
        (("i", "outer", 0.2 + 1e-8, 0.3), "gap or edge of only 1e-08 m at z = 0.2"),
        (
            ("i", "outer", 0.05, 0.3, (0.0, 0.05)),
            "only z = 0.05 m to 0.1 m and z = 0.2 m to 0.3 m is covered",
        ),
    ],
)
def test_refused_places(arguments, message):
    with pytest.raises(GeometryError, match=message):
        subdivide(stepped(interface(*arguments)))


def test_solid_shaft_has_no_inner_surface():
    bore = interface("bore", "inner", 0.1, 0.2)
    with pytest.raises(GeometryError, match=r"'bore' of kind 'inner' .* lies outside"):
        subdivide(body(section("shaft", 0.0, 1.0, 0.0, 0.1), interfaces=[bore]))
