"""Sizes of a sector's tetrahedra from the errors of the elements of the last mesh."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial import Delaunay
from shapes import bladed_disk, section
from simplex import mesh_mass_kg

from solidwhirl.geometry import MATERIALS, Body, Hole
from solidwhirl.meshing import LocalSize, MeshingError, MeshSize, refined_sector
from solidwhirl.meshing.own.drawing import with_skin
from solidwhirl.meshing.own.features.sector import mesh_sector
from solidwhirl.meshing.own.prediction import predict_refined

STEEL = MATERIALS["steel"]
SIZE = MeshSize(size_m=0.02, corner_size_m=0.008, growth=0.6, through_thickness=1.2)


@pytest.fixture(scope="module")
def body():
    """Disk 0.03 to 0.1 m with twelve staggered plates."""
    return bladed_disk()


@pytest.fixture(scope="module")
def mesh(body):
    return mesh_sector(body, SIZE)


def parts(mesh):
    """Vertices, cells, and which vertices are on a blade's root."""
    points, cells = mesh.points, mesh.cells[:, :4]
    blade = mesh.cell_section == mesh.section_names.index("blades")
    root = np.zeros(len(points), dtype=bool)
    root[np.intersect1d(cells[blade], cells[~blade])] = True
    return points, cells, root, blade


def volumes(mesh):
    corners = mesh.points[mesh.cells[:, :4]]
    return np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6.0


@pytest.mark.parametrize("size_m", [0.03, 0.012])
def test_coarse_elements_keep_to_curved_surfaces(size_m):
    """Drilled disk on a shaft: edges made straight took 1.2e-3 of its mass.

    The tolerance is three times what arcs of second order leave at 24 around, 6e-6.
    """
    holes = Hole(name="holes", within="disk", count=8, pitch_radius_m=0.09, diameter_m=0.04)
    sections = section("shaft", 0.0, 0.4, 0.0, 0.025), section("disk", 0.18, 0.21, 0.025, 0.15)
    body = Body(name="drilled", sections=sections, features=(holes,))
    disk = 0.03 * (0.15**2 - 0.025**2 - 8 * 0.02**2)
    exact = STEEL.density_kg_per_m3 * np.pi * (0.4 * 0.025**2 + disk)
    coarse = MeshSize(size_m=size_m, corner_size_m=0.002)
    assert 16 * mesh_mass_kg(mesh_sector(body, coarse)) == pytest.approx(exact, rel=2e-5)


def test_a_mesh_that_is_right_stays_as_it_is(body, mesh):
    """Equal errors per element, at the target already: about as many elements again.

    The first mesh comes from corners and thicknesses, with flatter elements; where one element
    fills the thickness, the surfaces decide more than the sizes.
    """
    counts = []
    for _ in range(3):
        points, cells, root, _ = parts(mesh)
        errors = np.full(len(cells), 1.0 / len(cells))
        nowhere = np.zeros_like(root)
        local = refined_sector(SIZE, points, cells, errors, nowhere, degree=2, target=1.0)
        mesh = mesh_sector(body, SIZE, local)
        counts.append(len(mesh.cells))
    assert 1 / 1.3 < counts[2] / counts[1] < 1.3


@pytest.mark.parametrize("target", [0.5, 0.1])
def test_cells_are_predicted(body, mesh, target):
    points, cells, root, _ = parts(mesh)
    at_root = root[cells].any(axis=1)
    errors = np.where(at_root, 1.0, 0.05) * np.cbrt(volumes(mesh))
    local = refined_sector(
        SIZE, points, cells, errors / errors.sum(), root, degree=2, target=target
    )
    made, predicted = mesh_sector(body, SIZE, local), predict_refined(local)
    assert 1 / 1.5 < predicted.cells / len(made.cells) < 1.5
    # of complex fields: two parts, one cut face follows the other
    cut = np.count_nonzero(made.points[:, 1] == 0.0)
    unknowns = 6 * (len(made.points) - cut)
    assert 1 / 1.5 < predicted.unknowns(2) / unknowns < 1.5
    # fine along the roots, growing from there as asked
    edges = np.sort(np.concatenate([cells[:, [a, b]] for a in range(4) for b in range(a)]))
    a, b = np.unique(edges, axis=0).T
    rise = np.abs(local.size_m[a] - local.size_m[b])
    length = np.linalg.norm(points[a] - points[b], axis=1)
    assert (rise <= SIZE.growth * length * (1.0 + 1e-12)).all()


def test_sizes_go_on_beyond_flat_facets():
    """On arcs between 24 edges the size is that of the chord, not that of the nearest vertex."""
    around = 2.0 * np.pi / 24 * np.arange(24)
    ring = np.column_stack([np.cos(around), np.sin(around), np.zeros(24)])
    disk = np.vstack([ring, np.zeros((1, 3))])
    points = np.vstack([disk, disk + np.array([0.0, 0.0, 1.0])])
    size = np.ones(len(points))
    size[3] = 0.01  # on the circle at z = 0
    cells = Delaunay(points).simplices
    local = with_skin(LocalSize(points=points, cells=cells, size_m=size))
    middle = around[2] + 0.5 * (around[1] - around[0])
    share = 0.25
    place = np.array([np.cos(middle), np.sin(middle), share])  # 0.0086 beyond the facets
    corners = local.points[local.cells]
    sides = np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)
    there = np.abs(np.linalg.det(sides)) > 1e-12
    inner = np.linalg.solve(sides[there], (place - corners[there, 0])[..., None])[..., 0]
    weights = np.column_stack([1.0 - inner.sum(axis=1), inner])
    holding = (weights >= -1e-9).all(axis=1)
    assert holding.any()
    found = (weights[holding] * local.size_m[local.cells[there][holding]]).sum(axis=1)
    # of the two triangles that a square can be cut into, one sees the fine vertex by 0.25, one by
    # 0.5: linear between 0.01 and 1; the layer's normals turn by 7.5 degrees
    assert ((found > 0.45) & (found < 0.8)).all()


def test_blades_are_refined_on_their_own(body, mesh):
    """Errors in the blades alone: their elements get small, those of the disk's bore do not."""
    points, cells, root, blade = parts(mesh)
    errors = np.where(blade, volumes(mesh), 1e-9 * volumes(mesh))
    local = refined_sector(
        SIZE, points, cells, errors / errors.sum(), np.zeros_like(root), degree=2, target=0.02
    )
    made = mesh_sector(body, SIZE, local)
    blades = made.cell_section == made.section_names.index("blades")
    # errors fall as h⁴: 50 times smaller with edges 2.7 times shorter, 19 times the elements
    wanted = blade.sum() * 50.0 ** (3.0 / 4.0)
    assert 1 / 2.0 < blades.sum() / wanted < 2.0
    at_bore = np.hypot(*made.points[made.cells[:, :4], :2].mean(axis=1).T) < 0.05
    was = np.hypot(*points[cells, :2].mean(axis=1).T) < 0.05
    assert at_bore.sum() <= 1.2 * was.sum()


@pytest.mark.parametrize("target", [0.0, -1.0, math.nan])
def test_a_target_that_no_mesh_meets(mesh, target):
    points, cells, root, _ = parts(mesh)
    with pytest.raises(MeshingError, match="a positive number is needed"):
        refined_sector(SIZE, points, cells, np.ones(len(cells)), root, degree=2, target=target)
