"""What sections, interfaces, rigid disks and bodies refuse by themselves."""

from __future__ import annotations

import math

import pytest
from shapes import interface, section

from solidwhirl.geometry import Body, GeometryError, Interface, RigidDisk

NAN = math.nan


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ((0.2, 0.1, 0.0, 0.1), "'a': negative width, it starts at z = 0.2 m and ends at z = 0.1"),
        ((0.1, 0.1, 0.0, 0.1), "'a': negative width"),
        ((0.0, 1.0, (0.0, -0.01), 0.1), "'a': negative radius -0.01 m at z = 1 m"),
        ((0.0, 1.0, (0.0, 0.2), 0.1), "'a': crossing radii at z = 1 m, the inner radius 0.2 m"),
        ((0.0, 1.0, 0.2, 0.1), "'a': crossing radii at z = 0 m"),
        ((0.0, 1.0, (0.1, 0.2), (0.1, 0.15)), "'a': crossing radii at z = 1 m"),
        ((0.0, 1.0, (0.1, 0.2), (0.1, 0.2)), "'a': no thickness from z = 0 m to 1 m"),
        ((0.0, NAN, 0.0, 0.1), "'a': found nan, every value must be finite"),
        ((0.0, 1.0, 0.0, (0.1, math.inf)), "'a': found inf"),
        ((0.0, 1.0, 0.0, (0.1, 0.1, 0.1)), "'a': outer radius has 3 values"),
    ],
)
def test_refused_sections(values, message):
    with pytest.raises(GeometryError, match=message):
        section("a", *values)


def test_triangles_are_allowed():
    assert section("tip", 0.0, 1.0, 0.0, (0.1, 0.0)).radii_at(1.0) == (0.0, 0.0)
    assert section("tip", 0.0, 1.0, (0.1, 0.0), 0.1).radii_at(0.5) == (0.05, 0.1)


def test_radii_are_exact_at_the_ends_and_refused_outside():
    cone = section("cone", 0.1, 0.7, (0.011, 0.0233), (0.1, 0.3))
    assert cone.radii_at(0.1) == (0.011, 0.1)
    assert cone.radii_at(0.7) == (0.0233, 0.3)
    with pytest.raises(GeometryError, match=r"'cone' reaches from z = 0.1 to 0.7 m; z = 0.8 m"):
        cone.radii_at(0.8)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("i", "section", 0.1, 0.2), "'i': z = 0.1 m to 0.2 m given for the kind 'section'"),
        (("i", "face", 0.1, 0.2), "kind 'face', which lies in one plane"),
        (("i", "outer", 0.1, 0.1), "kind 'outer'; the end must lie beyond the start"),
        (("i", "inner", 0.2, 0.1), "kind 'inner'; the end must lie beyond the start"),
        (("i", "rim", 0.1, 0.1), "kind is 'rim', allowed: section, outer, inner, face"),
        (("i", "face", 0.1, 0.1, (0.2, 0.1)), "radial range 0.2 m to 0.1 m"),
        (("i", "face", 0.1, 0.1, (-0.1, 0.1)), "radial range -0.1 m to 0.1 m"),
        (("i", "face", 0.1, 0.1, (0.1,)), "radial range has 1 values"),
        (("i", "face", NAN, NAN), "found nan"),
        (("", "face", 0.1, 0.1), "an? interface needs a name"),
    ],
)
def test_refused_interfaces(arguments, message):
    with pytest.raises(GeometryError, match=message):
        interface(*arguments)


def test_unknown_coupling():
    with pytest.raises(GeometryError, match="coupling is 'glued', allowed: distributing, rigid"):
        Interface(name="i", kind="face", coupling="glued", start_m=0.0, end_m=0.0)


def test_master_node_lies_on_the_axis():
    assert interface("seat", "outer", 0.1, 0.2).position_m == pytest.approx((0.0, 0.0, 0.15))
    assert interface("plane", "section", 0.3).position_m == (0.0, 0.0, 0.3)


@pytest.mark.parametrize(
    ("inertia", "message"),
    [
        ((-1.0, 0.1, 0.1), "'d': mass -1.0 kg"),
        ((1.0, 0.3, 0.1), "'d': polar inertia 0.3 kg m.2 exceeds twice the diametral inertia 0.1"),
        ((1.0, NAN, 0.1), "'d': found nan"),
    ],
)
def test_refused_rigid_disks(inertia, message):
    mass, polar, diametral = inertia
    with pytest.raises(GeometryError, match=message):
        RigidDisk(
            name="d",
            interface="i",
            mass_kg=mass,
            polar_inertia_kg_m2=polar,
            diametral_inertia_kg_m2=diametral,
        )


ONE = section("a", 0.0, 1.0, 0.0, 0.1)
SEAT = interface("seat", "face", 0.0)
FAN = RigidDisk(
    name="fan", interface="sea", mass_kg=1.0, polar_inertia_kg_m2=0, diametral_inertia_kg_m2=0
)


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"sections": ()}, "body 'b' has no section"),
        ({"sections": (ONE, ONE)}, "'b': two sections are called 'a'"),
        ({"interfaces": (SEAT, SEAT)}, "'b': two interfaces are called 'seat'"),
        (
            {"interfaces": (SEAT,), "rigid_disks": (FAN,)},
            r"'fan' sits on the interface 'sea'.*known: seat",
        ),
        ({"fillet_radius_m": -0.001}, r"'b': fillet radius is .* m, must be finite"),
        ({"fillet_radius_m": NAN}, r"'b': fillet radius is .* m, must be finite"),
    ],
)
def test_refused_bodies(parts, message):
    with pytest.raises(GeometryError, match=message):
        Body(**{"name": "b", "sections": (ONE,), **parts})
