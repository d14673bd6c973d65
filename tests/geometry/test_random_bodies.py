"""Random valid bodies keep every promise of a subdivision.

Shafts of several cylindrical or conical steps, solid or bored, carry disks with conical sides; all
dimensions are multiples of 1 mm, so nothing is near a tolerance by accident.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
import shapes
from hypothesis import given, reject, settings
from hypothesis import strategies as st
from outlines import area_of, chords_of, conforming

from solidwhirl.geometry import (
    MATERIALS,
    GeometryError,
    Section,
    mass_properties,
    merge_fillets,
    subdivide,
)

MM = 1e-3
MATERIAL = st.sampled_from([MATERIALS["steel"], MATERIALS["titanium"]])


@st.composite
def bodies(draw):
    bore = draw(st.sampled_from([0, 0, 5]))
    z = draw(st.integers(-300, 300))
    sections: list[Section] = []
    cuts = []
    for number in range(draw(st.integers(1, 4))):
        length = draw(st.integers(20, 90))
        first = draw(st.integers(15, 60))
        last = draw(st.one_of(st.just(first), st.integers(15, 60)))
        ends, outer = (z * MM, (z + length) * MM), (first * MM, last * MM)
        shaft = shapes.section(f"shaft {number}", *ends, bore * MM, outer, draw(MATERIAL))
        sections.append(shaft)
        sections += draw(disks(shaft, z, length, number))
        cuts.append(z + draw(st.integers(0, length)))
        z += length
    planes = tuple(
        shapes.interface(
            f"plane {k}",
            "section",
            cut * MM,
            radius=draw(st.sampled_from([None, (0.0, 10 * MM)])),
            coupling="rigid",
        )
        for k, cut in enumerate(draw(st.lists(st.sampled_from(cuts), max_size=3)))
    )
    start, end = sections[0].start_m, z * MM
    last = end - draw(st.integers(2, 15)) * MM
    seat = shapes.interface("seat", "outer", start + 2 * MM, last)
    return shapes.body(*draw(st.permutations(sections)), interfaces=(*planes, seat))


@st.composite
def disks(draw, shaft, z, length, number):
    """Disks side by side or apart on one step of the shaft, as high as they like."""
    found = []
    marks = sorted(draw(st.sets(st.integers(z, z + length), max_size=5)))
    for k, (start, end) in enumerate(pairwise(marks)):
        if draw(st.booleans()):
            ends = (max(start * MM, shaft.start_m), min(end * MM, shaft.end_m))
            feet = tuple(shaft.radii_at(place)[1] for place in ends)
            heights = draw(st.tuples(st.integers(70, 200), st.integers(70, 200)))
            rims = (heights[0] * MM, heights[1] * MM)
            found.append(shapes.section(f"disk {number}.{k}", *ends, feet, rims, draw(MATERIAL)))
    return found


def section_area(section):
    gaps = np.subtract(section.outer_radius_m, section.inner_radius_m)
    return float(gaps.mean()) * (section.end_m - section.start_m)


# Fixed examples keep the run reproducible.
@settings(max_examples=80, deadline=None, derandomize=True, database=None)
@given(body=bodies())
def test_random_bodies(body):
    found = subdivide(body)
    conforming(found)
    for number, section in enumerate(body.sections):
        total = sum(area_of(found, face.loop) for face in found.faces if face.section == number)
        # Products of coordinates up to 0.7 m, areas down to 1e-5 m^2.
        assert total == pytest.approx(section_area(section), rel=1e-9)
    # Mass by Green's theorem on the faces: integral of r is minus the contour integral r^2/2 dz.
    mass = 0.0
    for face in found.faces:
        z, r = chords_of(found, face.loop).T
        dz, dr = np.roll(z, -1) - z, np.roll(r, -1) - r
        first_moment = -np.sum(dz * (r**2 + r * dr + dr**2 / 3.0)) / 2.0
        mass += 2.0 * math.pi * found.materials[face.material].density_kg_per_m3 * first_moment
    assert mass_properties(body).mass_kg == pytest.approx(mass, rel=1e-11)
    for plane in body.interfaces[:-1]:
        curves = [found.curves[n] for n in found.interfaces[plane.name]]
        assert all(found.points[c.start, 0] == found.points[c.end, 0] for c in curves)
    ends = [c.interior_angle_rad for c in found.corners]
    assert all(math.pi < angle < 2.0 * math.pi for angle in ends)


@settings(max_examples=50, deadline=None, derandomize=True, database=None)
@given(body=bodies())
def test_random_fillets(body):
    """A radius of 0.1 mm on edges of 1 mm and more: two of them fit if 0.1/tan(w/2) <= 0.5.

    So none is refused for its length unless a wedge is sharper than 2 atan(0.2), 22.6 degrees. And
    a kink of a few degrees beside a tip of a few degrees brings a tangent point nearer to another
    edge than any mesh resolves; that is refused too.
    """
    radius = 0.1 * MM
    shape = shapes.body(*body.sections, fillet=radius)
    try:
        found = subdivide(shape)
    except GeometryError as error:
        sharp = subdivide(shapes.body(*body.sections)).corners
        wedges = [2.0 * math.pi - c.interior_angle_rad for c in sharp]
        if "does not fit: it needs" in str(error):
            assert min(wedges) < 2.0 * math.atan(0.2)
        else:
            assert "a gap or edge of only" in str(error)
            assert max(wedges) > math.radians(170.0)
        reject()
    conforming(found)
    added = sum(area_of(found, face.loop) for face in found.faces) - sum(
        section_area(section) for section in body.sections
    )
    wedges = [2.0 * math.pi - c.interior_angle_rad for c in found.corners if c.filleted]
    expected = sum(radius**2 * (1.0 / math.tan(w / 2.0) - (math.pi - w) / 2.0) for w in wedges)
    # 1e-8 m^2 of fillets on 1e-1 m^2 of sections cancel to 1e-16 / 1e-8.
    assert added == pytest.approx(expected, rel=1e-6, abs=1e-15)
    merged = merge_fillets(found)
    conforming(merged)
    assert sum(area_of(merged, face.loop) for face in merged.faces) == pytest.approx(
        sum(area_of(found, face.loop) for face in found.faces), rel=1e-12
    )
