"""Meridian meshes: what they cover, how they are graded, what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shapes import body as body_of
from shapes import interface, section
from simplex import mesh_mass_kg

from solidwhirl.geometry import mass_properties
from solidwhirl.meshing import MeshingError, MeshSize, mesh_meridian, scaled_jacobians, straighten


def test_mass_of_the_mesh_is_that_of_the_profile(reference_rotor):
    mesh = mesh_meridian(reference_rotor, MeshSize(size_m=0.02, corner_size_m=0.004))
    # straight edges are held exactly, and r · Jacobian is linear on straight triangles
    assert mesh_mass_kg(mesh) == pytest.approx(mass_properties(reference_rotor).mass_kg, rel=1e-13)


def test_curved_edges_follow_a_fillet(reference_rotor):
    body = body_of(*reference_rotor.sections, fillet=0.008)
    exact = mass_properties(body).mass_kg
    mesh = mesh_meridian(body, MeshSize(size_m=0.02, corner_size_m=0.004))
    fillet_mass = exact - mass_properties(reference_rotor).mass_kg
    # four parabolic arcs of α = 22.5°: each segment's area is off by about α⁵ R²/480, against
    # the fillet's (1 - π/4) R², together 4e-4
    assert abs(mesh_mass_kg(mesh) - exact) < 4e-4 * fillet_mass
    assert mesh.quality.minimum_scaled_jacobian > 0.05


def test_elements_shrink_towards_reentrant_corners(reference_rotor):
    mesh = mesh_meridian(reference_rotor, MeshSize(size_m=0.02, corner_size_m=5e-4))
    x = mesh.points[mesh.cells[:, :3]]
    edges = np.linalg.norm(x - np.roll(x, 1, axis=1), axis=2).max(axis=1)
    centre = x.mean(axis=1)
    near = np.hypot(centre[:, 0] - 0.145, centre[:, 1] - 0.02) < 1e-3
    assert near.any()
    assert edges[near].max() < 1.5e-3
    assert edges.max() > 8e-3


def test_interfaces_are_where_they_were_asked(twin_inner):
    mesh = mesh_meridian(twin_inner, MeshSize(size_m=0.02, corner_size_m=0.004))
    for name, z in (("A", 0.0), ("C", 0.8 / 3.0), ("B", 0.4)):
        x = mesh.points[np.unique(mesh.interfaces[name])]
        np.testing.assert_allclose(x[:, 0], z, atol=1e-15)
        assert x[:, 1].min() == 0.0
        assert x[:, 1].max() == pytest.approx(0.02, abs=1e-15)


def test_a_rigid_slab_holds_all_material_between_its_planes():
    slab = interface("hub", "slab", 0.04, 0.06, coupling="rigid")
    body = body_of(section("shaft", 0.0, 0.1, 0.0, 0.01), interfaces=(slab,))
    mesh = mesh_meridian(body, MeshSize(size_m=0.01, corner_size_m=0.002))
    x = mesh.points[np.unique(mesh.interfaces["hub"])]
    assert x[:, 0].min() == pytest.approx(0.04)
    assert x[:, 0].max() == pytest.approx(0.06)
    assert np.any(x[:, 1] == 0.0)
    assert np.all(np.isclose(x[:, 1], 0.01) | np.isclose(x[:, 0], 0.04) | np.isclose(x[:, 0], 0.06))


def test_scaled_jacobian_of_known_elements():
    # the equilateral triangle scores 1, the right isosceles one sin 45° · 2/sqrt 3 · cos 45°
    corners = np.array([[0, 0], [1, 0], [0.5, math.sqrt(0.75)]], dtype=float)
    right = np.array([[0, 0], [1, 0], [0, 1]], dtype=float)
    for x, expected in ((corners, 1.0), (right, 1.0 / math.sqrt(3.0))):
        nodes = np.vstack([x, (x[0] + x[1]) / 2, (x[1] + x[2]) / 2, (x[2] + x[0]) / 2])
        found = scaled_jacobians(nodes, np.arange(6)[None])
        assert found[0] == pytest.approx(expected, rel=1e-13)


def test_a_folded_element_is_found_and_straightened():
    x = np.array([[0, 0], [1, 0], [0, 1], [0.5, 0.6], [0.5, 0.5], [0, 0.5]], dtype=float)
    cells = np.arange(6)[None]
    assert scaled_jacobians(x, cells)[0] < 0.0
    moved, count = straighten(x, cells, 0.02)
    assert count == 1
    np.testing.assert_allclose(moved[3], [0.5, 0.0])
    assert scaled_jacobians(moved, cells)[0] > 0.5


@pytest.mark.parametrize(
    ("size", "message"),
    [
        ({"size_m": 0.0, "corner_size_m": 0.1}, "size_m is 0.0"),
        ({"size_m": 0.01, "corner_size_m": float("nan")}, "corner_size_m is nan"),
        ({"size_m": 0.01, "corner_size_m": 0.02}, "larger than size_m"),
        ({"size_m": 0.01, "corner_size_m": 0.01, "growth": -1.0}, "growth is -1.0"),
    ],
)
def test_sizes_that_no_mesh_has_are_refused(size, message):
    with pytest.raises(MeshingError, match=message):
        MeshSize(**size)
