"""Common faces of joints: where they are, how they part a mesh, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapes import body, plane, section

from solidwhirl.geometry import Body, GeometryError, Joint, subdivide
from solidwhirl.meshing import MeshSize, mesh_meridian

HELD = Joint(between=("shaft", "hub"), stiffness_n_per_m3=(1e12, 1e12))


def wheel(*joints: Joint) -> Body:
    """A hub on a shaft, with a disk that is one piece with the hub."""
    made = body(
        section("shaft", 0.0, 0.3, 0.0, 0.02),
        section("hub", 0.1, 0.2, 0.02, 0.04),
        section("disk", 0.14, 0.16, 0.04, 0.1),
        interfaces=(plane("middle", 0.15), plane("left", 0.02)),
        name="wheel",
    )
    return replace(made, joints=joints)


def test_the_seat_ends_where_the_joint_says() -> None:
    found = subdivide(wheel(replace(HELD, over_m=(0.11, 0.13))))
    (face,) = found.joints
    ends = {
        name: found.points[[p for c in own for p in (found.curves[c].start, found.curves[c].end)]]
        for name, own in (("face", face.curves), ("seat", face.seat))
    }
    assert (ends["face"][:, 0].min(), ends["face"][:, 0].max()) == (0.1, 0.2)
    assert ends["seat"][:, 0].min() == pytest.approx(0.11, rel=1e-12)
    assert ends["seat"][:, 0].max() == pytest.approx(0.13, rel=1e-12)
    assert (ends["face"][:, 1] == 0.02).all()


def test_a_mesh_is_parted_along_the_face() -> None:
    size = MeshSize(size_m=0.02, corner_size_m=0.01)
    whole, mesh = (mesh_meridian(made, size) for made in (wheel(), wheel(HELD)))
    (seat,) = mesh.seats
    assert len(mesh.cells) == len(whole.cells)
    # corners and middles of the facets of one chain are doubled, and nothing else
    assert len(mesh.points) == len(whole.points) + 2 * len(seat) + 1
    assert (mesh.points[seat[:, 0]] == mesh.points[seat[:, 1]]).all()
    assert not np.intersect1d(seat[:, 0], seat[:, 1]).size
    shaft, others = (
        np.unique(mesh.cells[np.isin(mesh.cell_section, own)]) for own in ([0], [1, 2])
    )
    assert not np.intersect1d(shaft, others).size
    # a cross-section that goes through both keeps all its facets
    assert len(mesh.interfaces["middle"]) == len(whole.interfaces["middle"])
    assert np.isin(mesh.interfaces["middle"], shaft).any()


def test_the_end_of_a_slit_stays_one_node() -> None:
    """Two sections that meet a third, bonded one: its corner hangs together around the slit."""
    made = body(
        section("left", 0.0, 0.1, 0.01, 0.03),
        section("right", 0.1, 0.2, 0.01, 0.03),
        section("sleeve", 0.0, 0.2, 0.03, 0.04),
        name="slit",
    )
    joint = Joint(between=("left", "right"), stiffness_n_per_m3=(1e12, 1e12))
    mesh = mesh_meridian(replace(made, joints=(joint,)), MeshSize(size_m=0.02, corner_size_m=0.01))
    (seat,) = mesh.seats
    same = np.unique(seat[:, 0][seat[:, 0] == seat[:, 1]])
    assert mesh.points[same] == pytest.approx(np.array([[0.1, 0.03]]), abs=1e-12)


@pytest.mark.parametrize(
    ("joint", "message"),
    [
        (replace(HELD, between=("shaft", "disk")), "'disk': the two sections do not touch"),
        (replace(HELD, between=("shaft", "rim")), "no section 'rim'; known: shaft, hub, disk"),
        (Joint(between=("shaft", "hub")), "'hub': nothing says how it joins"),
        (replace(HELD, over_m=(0.25, 0.28)), r"common face reaches from 0.1 to 0.2 m"),
    ],
)
def test_refused_joints(joint: Joint, message: str) -> None:
    with pytest.raises(GeometryError, match=message):
        subdivide(wheel(joint))


def test_a_fillet_does_not_fill_the_corner_of_a_joint() -> None:
    with pytest.raises(GeometryError, match=r"would fill the corner .* leave it out"):
        subdivide(replace(wheel(HELD), fillet_radius_m=0.002))


def test_two_joints_of_one_face_are_refused() -> None:
    with pytest.raises(GeometryError, match="two joints are of this face"):
        subdivide(wheel(HELD, replace(HELD, between=("hub", "shaft"))))


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"between": ("hub", "hub"), "pressure_pa": 1e6}, "found one twice"),
        ({"between": ("a", "b"), "pressure_pa": 1e6, "interference_m": 1e-5}, "keep one of them"),
        ({"between": ("a", "b"), "pressure_pa": 1e6, "over_m": (0.2, 0.1)}, "beyond the start"),
    ],
)
def test_impossible_joints(keys: dict, message: str) -> None:
    with pytest.raises(GeometryError, match=message):
        Joint(**keys)
