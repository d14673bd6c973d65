"""Solid meshes: symmetry, interfaces, volume, files."""

from __future__ import annotations

import meshio
import numpy as np
import pytest
from scipy.spatial import cKDTree
from shapes import body as body_of
from shapes import section
from simplex import mesh_mass_kg

from solidwhirl.files.vtk_files import mesh_grid, write_vtu
from solidwhirl.geometry import mass_properties
from solidwhirl.meshing import MeshSize, mesh_meridian, mesh_solid, write_gmsh


def straight_volume(mesh):
    x = mesh.points[mesh.cells[:, :4]]
    return np.linalg.det(x[:, 1:] - x[:, :1]) / 6.0


SIZE = MeshSize(size_m=0.05, corner_size_m=0.01, growth=0.8)


@pytest.fixture(scope="module")
def mesh(twin_inner):
    return mesh_solid(twin_inner, SIZE)


def test_mesh_is_unchanged_by_a_quarter_turn(mesh):
    x, y, z = mesh.points.T
    gap, partner = cKDTree(mesh.points).query(np.column_stack([-y, x, z]))
    assert gap.max() == 0.0
    turned = {frozenset(c) for c in partner[mesh.cells].tolist()}
    assert turned == {frozenset(c) for c in mesh.cells.tolist()}


def test_volume_converges_with_the_circumference(reference_rotor):
    exact = mass_properties(reference_rotor).mass_kg
    errors = []
    for around in (8, 16):
        size = MeshSize(size_m=0.05, corner_size_m=0.02, growth=1.0, around=around)
        mesh = mesh_solid(reference_rotor, size)
        assert straight_volume(mesh).min() > 0.0
        errors.append(abs(mesh_mass_kg(mesh) / exact - 1.0))
    # parabolic edges: the volume error falls with the fourth power of the angle, here from 8 to
    # 16 elements by up to 16; the shaft and the disk do not halve exactly, so 6 is asked
    assert errors[0] < 2e-3
    assert errors[1] < errors[0] / 6.0


def test_quality_is_positive_and_reported(reference_rotor):
    # 8 elements around make curved elements that gmsh folds at some sizes; all are mended
    size = MeshSize(size_m=0.1, corner_size_m=0.004, growth=0.6, around=8)
    mesh = mesh_solid(reference_rotor, size)
    assert mesh.quality.minimum_scaled_jacobian > 0.0
    assert mesh.quality.mean_scaled_jacobian > 0.25


def test_interface_facets_cover_the_cross_section(mesh):
    for name, z in (("A", 0.0), ("C", 0.8 / 3.0), ("B", 0.4)):
        facets = mesh.interfaces[name]
        x = mesh.points[facets[:, :3]]
        np.testing.assert_allclose(x[:, :, 2], z, atol=1e-12)
        area = 0.5 * np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1).sum()
        # straight facets inscribed in the circle lose at most 1 - sin(2 pi/12)/(2 pi/12)
        assert 0.95 * np.pi * 0.02**2 < area <= np.pi * 0.02**2


@pytest.mark.parametrize("level", ["meridian", "solid"])
def test_files_read_back(level, mesh, twin_inner, tmp_path):
    mesh = mesh if level == "solid" else mesh_meridian(twin_inner, SIZE)
    write_vtu(mesh_grid(mesh), tmp_path / "m.vtu")
    write_gmsh(mesh, tmp_path / "m.msh")
    vtu, msh = meshio.read(tmp_path / "m.vtu"), meshio.read(tmp_path / "m.msh")
    kind = {2: "triangle6", 3: "tetra10"}[mesh.dimension]
    assert len(vtu.cells_dict[kind]) == len(mesh.cells)
    assert sum(len(b.data) for b in msh.cells if b.type == kind) == len(mesh.cells)
    assert set(msh.field_data) == {"shaft", "disk", "interface_A", "interface_B", "interface_C"}
    # node order: the middle of every edge lies between its ends, in VTK's numbering
    if mesh.dimension == 3:
        x = vtu.points[vtu.cells_dict[kind]]
        for node, (i, j) in zip(
            range(4, 10), ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)), strict=True
        ):
            middle = 0.5 * (x[:, i] + x[:, j])
            length = np.linalg.norm(x[:, i] - x[:, j], axis=1)
            assert np.all(np.linalg.norm(x[:, node] - middle, axis=1) < 0.2 * length)


def test_a_drum_on_a_web_is_meshed_in_one_piece(reference_rotor):
    from solidwhirl.geometry import MATERIALS, TABLE_7, Web, stage_group_sections

    stages = stage_group_sections(
        TABLE_7["hp_turbine"],
        start_m=0.1,
        direction=1,
        material=MATERIALS["nickel_alloy"],
        spacer_thickness_m=0.01,
        web=(Web(stage=1, thickness_m=0.01, inner_radius_m=0.033),),
        prefix="hpt",
    )
    body = body_of(section("shaft", 0.0, 0.3, 0.0, 0.033), *stages)
    mesh = mesh_solid(body, SIZE)
    density = np.array([m.density_kg_per_m3 for m in mesh.materials])[mesh.cell_material]
    mass = float(np.sum(straight_volume(mesh) * density))
    # straight tetrahedra inscribed in the circles lose up to 5 % with 12 around
    assert 0.95 * mass_properties(body).mass_kg < mass < 1.001 * mass_properties(body).mass_kg
