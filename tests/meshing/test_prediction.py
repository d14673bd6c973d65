"""The prediction of a mesh's numbers against the mesh that is made."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from shapes import STEEL, interface, section
from shapes import body as body_of

from solidwhirl.geometry import Joint
from solidwhirl.meshing import MeshSize, mesh_meridian, mesh_revolved
from solidwhirl.meshing.own.prediction import PredictedMesh, counted, predict_mesh


def tube(inner, outer, length=0.3, **options):
    return body_of(section("tube", 0.0, length, inner, outer), **options)


def rigid_seat():
    seat = interface("seat", "outer", 0.1, 0.13, (0.0, 0.2), "rigid")
    return tube(0.02, 0.03, interfaces=(seat,))


@pytest.mark.parametrize("mesh_of", [mesh_meridian, mesh_revolved])
def test_numbers_of_a_mesh_that_was_made(mesh_of):
    """Edges and facets one by one, against the nodes and Euler's formula."""
    mesh = mesh_of(tube(0.05, 0.1), MeshSize(size_m=0.05, corner_size_m=0.03, around=8))
    d, found = mesh.dimension, counted(mesh)
    corners = np.sort(mesh.cells[:, : d + 1], axis=1)

    def simplices(size):
        parts = [corners[:, list(c)] for c in combinations(range(d + 1), size)]
        return len(np.unique(np.vstack(parts), axis=0))

    assert (found.cells, found.vertices, found.edges) == (len(corners), *map(simplices, (1, 2)))
    assert found.facets == (simplices(3) if d == 3 else 0)


@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5])
@pytest.mark.parametrize(("dimension", "edges", "facets"), [(2, 3, 0), (3, 6, 4)])
def test_nodes_of_one_element(degree, dimension, edges, facets):
    one = PredictedMesh(
        dimension=dimension,
        cells=1,
        vertices=dimension + 1,
        edges=edges,
        facets=facets,
        graded_places=0,
    )
    # polynomials of degree p in d variables
    assert one.unknowns(degree) == 3 * math.comb(degree + dimension, dimension)


@pytest.mark.parametrize(
    ("name", "sizes"),
    [
        ("rotor", {"corner_size_m": 5e-3, "growth": 0.6}),
        ("rotor", {"corner_size_m": 1e-4, "growth": 0.6}),
        ("rotor", {"corner_size_m": 2e-5, "growth": 0.3}),
        ("rotor", {"corner_size_m": 2e-3, "size_m": 2e-3}),
        ("fillets", {"corner_size_m": 4e-3, "growth": 0.8}),
        ("thin", {"corner_size_m": 5e-3, "growth": 0.7}),
        ("thin", {"corner_size_m": 5e-3, "through_thickness": 3.0}),
        ("cone", {"corner_size_m": 5e-3, "through_thickness": 2.0}),
        ("seat", {"corner_size_m": 2e-4, "growth": 0.7}),
    ],
)
def test_meridian_within_a_factor_of_one_and_a_half(reference_rotor, name, sizes):
    body = {
        "rotor": lambda: reference_rotor,
        "fillets": lambda: replace(reference_rotor, fillet_radius_m=0.004),
        "thin": lambda: tube(0.098, 0.1),
        "cone": lambda: tube((0.01, 0.08), (0.03, 0.11)),
        "seat": rigid_seat,
    }[name]()
    size = MeshSize(**{"size_m": 0.1, **sizes})
    mesh = mesh_meridian(body, size)
    made = counted(mesh)
    assert made.unknowns(2) == 3 * len(mesh.points)  # the count itself
    for degree in (2, 3, 4):
        ratio = predict_mesh(body, size, "harmonic").unknowns(degree) / made.unknowns(degree)
        assert 1.0 / 1.5 < ratio < 1.5, degree


@pytest.mark.parametrize("size_m", [0.02, 4e-3])
def test_edges_of_pressed_faces(size_m):
    """Those of the joints that may lift, and no others."""
    parts = (
        section("shaft", 0.0, 0.4, 0.0, 0.03),
        section("hub", 0.1, 0.2, 0.03, 0.06),
        section("ring", 0.25, 0.3, 0.03, 0.05),
    )
    joints = (
        Joint(between=("shaft", "hub"), interference_m=4e-5),
        Joint(between=("shaft", "ring"), stiffness_n_per_m3=(1e12, 1e12)),
    )
    body = replace(body_of(*parts), joints=joints)
    size = MeshSize(size_m=size_m, corner_size_m=0.5 * size_m)
    made = len(mesh_meridian(body, size).seats[0])
    assert 1.0 / 1.5 < predict_mesh(body, size, "harmonic").pressed_edges / made < 1.5


@pytest.mark.parametrize(
    ("name", "sizes"),
    [
        ("rotor", {"corner_size_m": 8e-3, "growth": 0.8}),
        ("rotor", {"corner_size_m": 3e-3}),
        pytest.param("rotor", {"corner_size_m": 1.5e-3}, marks=pytest.mark.verify),
        ("shaft", {"corner_size_m": 8e-3}),
        ("thin", {"corner_size_m": 8e-3, "through_thickness": 0.7}),
        ("thin", {"corner_size_m": 8e-3, "through_thickness": 1.2}),
        ("wall", {"corner_size_m": 8e-3, "through_thickness": 2.0}),
    ],
)
def test_solid_within_a_factor_of_two(reference_rotor, name, sizes):
    body = {
        "rotor": lambda: reference_rotor,
        "shaft": lambda: tube(0.0, 0.02),
        "thin": lambda: tube(0.095, 0.1, length=0.1),
        "wall": lambda: tube(0.04, 0.05, length=0.1),
    }[name]()
    given = {"size_m": 0.1, "growth": 0.6, "through_thickness": 1.2, "around": 12, **sizes}
    size = MeshSize(**given)
    made = 3 * len(mesh_revolved(body, size).points)
    assert 0.5 < predict_mesh(body, size, "revolved").unknowns(2) / made < 2.0


@pytest.mark.parametrize("dimension", [2, 3])
def test_uniform_meshes_grow_with_the_power_of_their_dimension(reference_rotor, dimension):
    """Halving all sizes makes 2^d times as many elements, once the rim is a small part."""
    counts = [
        predict_mesh(
            reference_rotor,
            MeshSize(size_m=h, corner_size_m=h, around=1),
            {2: "harmonic", 3: "solid"}[dimension],
        ).cells
        for h in (4e-4, 2e-4)
    ]
    # the skin, which grows by one power less, is some 5 % of these meshes
    assert counts[1] / counts[0] == pytest.approx(2.0**dimension, rel=0.05)


def test_graded_meridian_grows_with_the_logarithm_of_the_corner(reference_rotor):
    """Each tenfold finer corner adds the same rings of elements."""
    cells = [
        predict_mesh(
            reference_rotor, MeshSize(size_m=0.1, corner_size_m=h, growth=0.5), "harmonic"
        ).cells
        for h in (1e-5, 1e-6, 1e-7)
    ]
    first, second = np.diff(cells)
    assert first > 50
    # the innermost rings are cut into triangles of a size that follows the corner's only roughly
    assert second == pytest.approx(first, rel=0.1)


@pytest.mark.parametrize("kind", ["harmonic", "revolved", "solid"])
def test_finer_sizes_never_make_fewer_elements(reference_rotor, kind):
    cells = [
        predict_mesh(reference_rotor, MeshSize(size_m=0.02, corner_size_m=h), kind).cells
        for h in np.geomspace(0.02, 2e-4, 12)
    ]
    assert cells == sorted(cells)
    assert cells[-1] > 2 * cells[0]


@pytest.mark.parametrize("corner_m", [0.01, 0.005])
def test_sector_of_blades_and_holes_within_a_factor_of_one_and_a_half(corner_m):
    """Mirrored and not; nodes with those of the cut face, which the unknowns leave out."""
    from solidwhirl.geometry import Blade, Hole
    from solidwhirl.meshing.own.features.sector import mesh_sector

    disk = body_of(section("disk", -0.01, 0.01, 0.03, 0.12))
    holes = Hole(name="holes", within="disk", count=8, pitch_radius_m=0.08, diameter_m=0.02)
    ends = {"length_m": 0.05, "chord_m": (0.018, 0.018), "thickness_m": (0.004, 0.003)}
    ends |= {"stagger_deg": (30.0, 45.0), "material": STEEL}
    blades = Blade(name="blades", on="disk", count=24, **ends)
    size = MeshSize(size_m=0.04, corner_size_m=corner_m, growth=0.6)
    for features in ((holes,), (blades,), (holes, blades)):
        body = replace(disk, features=features)
        mesh, found = mesh_sector(body, size), predict_mesh(body, size, "solid")
        assert 1 / 1.5 < found.cells / len(mesh.cells) < 1.5, features
        assert 1 / 1.5 < found.unknowns(1) / 6 / (counted(mesh).vertices - cut_vertices(mesh)) < 1.5


def cut_vertices(mesh):
    """Vertices in the plane θ = 0, where the sector begins."""
    corners = mesh.points[np.unique(mesh.cells[:, :4])]
    return int((np.abs(corners[:, 1]) < 1e-9).sum())
