"""Modes on the surface: the record, its group in the file, VTU and VTKHDF with foreign readers."""

from __future__ import annotations

import dataclasses

import h5py
import meshio
import numpy as np
import pytest
from scipy.spatial import cKDTree
from shapes import body, plane, section

from solidwhirl.files.surface_files import write_surface_vtkhdf, write_surface_vtu
from solidwhirl.rotordyn import SuperelementError
from solidwhirl.rotordyn.superelement.surface import Copies, Surface, beam_surface

NODES = np.array([0.0, 0.1, 0.2, 0.4])
OUTER, INNER = np.array([0.02, 0.03, 0.015]), np.array([0.0, 0.01, 0.01])


def rigid_planes():
    """Deflection and slope of a shaft that moves by ux, uy, uz, rx, ry, rz."""
    planes = np.zeros((2, 2 * len(NODES), 6))
    planes[0, 0::2, 0] = planes[1, 0::2, 1] = 1.0
    planes[0, 0::2, 4], planes[0, 1::2, 4] = NODES, 1.0  # ry
    planes[1, 0::2, 3], planes[1, 1::2, 3] = -NODES, -1.0  # rx: (w, θ) = (uy, −rx)
    axial, torsion = np.zeros((2, len(NODES), 6))
    axial[:, 2] = torsion[:, 5] = 1.0
    return (planes[0], planes[1]), axial, torsion


@pytest.fixture(scope="module")
def shaft():
    return beam_surface(NODES, OUTER, INNER, *rigid_planes())


def volume(faces):
    """Volume inside a surface whose normals show outward (divergence theorem)."""
    quads = faces.quadrangles
    triangles = np.vstack([faces.triangles, quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    a, b, c = (faces.points_m[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def assert_rigid(surface, motions, sectors):
    """Every rigid motion t + θ × x at every point of the surface."""
    points = surface.faces(sectors).points_m
    for k, motion in motions.items():
        unit = np.eye(3)[k % 3]
        exact = np.broadcast_to(unit, points.shape) if k < 3 else np.cross(unit, points)
        moved = surface.displacement(motion, sectors)
        # a solid's surface is kept in single precision
        tolerance = 1e-12 if surface.kind == "meridian" else 1e-6
        assert np.abs(moved - exact).max() < tolerance * np.abs(exact).max()


@pytest.mark.parametrize("sectors", [3, 7, 64])
def test_a_shaft_moves_rigidly_and_its_surface_is_closed(shaft, sectors):
    assert_rigid(shaft, dict(enumerate(np.eye(6))), sectors)
    around = 0.5 * sectors * np.sin(2.0 * np.pi / sectors)  # area of a polygon in a unit circle
    exact = around * ((OUTER**2 - INNER**2) * np.diff(NODES)).sum()
    assert volume(shaft.faces(sectors)) == pytest.approx(exact, rel=1e-12)
    whirl = np.array([1.0, -1.0j, 0.0, 0.0, 0.0, 0.0])
    moved = shaft.displacement(whirl, sectors)
    assert moved == pytest.approx(np.broadcast_to([1.0, -1.0j, 0.0], moved.shape), abs=1e-12)


def test_orders_are_what_their_formula_says():
    """Order 3, both families, at angles that are no multiples of anything."""
    ring = Surface(
        points_m=np.array([[0.1, 0.5]]),
        cells=np.empty((0, 2)),
        amplitudes=np.array([[[1.0, 1.0], [2.0, 2.0], [3.0, 3.0]]]),
        coordinate=np.array([0, 1]),
        order=np.array([3, 3]),
        family=np.array([0, 1]),
        size=2,
    )
    theta = 2.0 * np.pi * np.arange(11) / 11
    cos, sin = np.cos(theta), np.sin(theta)
    for k, (along, across) in enumerate(
        [(np.cos(3 * theta), np.sin(3 * theta)), (np.sin(3 * theta), -np.cos(3 * theta))]
    ):
        exact = [along * cos - 2 * across * sin, along * sin + 2 * across * cos, 3 * along]
        assert ring.displacement(np.eye(2)[k], 11) == pytest.approx(np.array(exact).T)


def test_a_body_that_keeps_some_coordinates_moves_as_before(shaft):
    kept = [4, -1, 0]
    fewer = shaft.of_coordinates(kept)
    moved = fewer.displacement([2.0, 5.0, 3.0], 9)
    assert moved == pytest.approx(shaft.displacement([3.0, 0.0, 0.0, 0.0, 2.0, 0.0], 9))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"points_m": np.zeros((2, 4))}, "4 columns"),
        ({"points_m": np.array([[0.0, -1.0]])}, "negative radius"),
        ({"cells": np.array([[0, 99]])}, "cells"),
        ({"coordinate": np.array([0, 6])}, "coordinate"),
        ({"order": np.array([0.5])}, "order"),
        ({"family": np.array([2])}, "family"),
        ({"amplitudes": np.zeros((1, 3, 1))}, "amplitudes"),
    ],
)
def test_surfaces_that_are_none_are_refused(shaft, change, words):
    with pytest.raises(SuperelementError, match=words):
        dataclasses.replace(shaft, **change)


@pytest.fixture(scope="module")
def element(lateral_shaft):
    """A shaft with a surface, whatever it had before."""
    nodes = lateral_shaft.recovery_points_m[:, 2]
    size, n = lateral_shaft.size, len(nodes)
    planes = np.zeros((2, 2 * n, size))
    for axis in (0, 1):
        planes[axis, 0::2] = lateral_shaft.recovery_modes[:, axis]
        planes[axis, 1::2] = np.gradient(planes[axis, 0::2], nodes, axis=0)
    surface = beam_surface(nodes, np.full(n - 1, 0.02), np.zeros(n - 1), tuple(planes))
    return dataclasses.replace(lateral_shaft, surface=surface)


def test_a_surface_of_another_body_is_refused(element, shaft):
    with pytest.raises(SuperelementError, match="surface is of 6 coordinates"):
        dataclasses.replace(element, surface=shaft)
    with pytest.raises(SuperelementError, match="surface is a str"):
        dataclasses.replace(element, surface="round")


def test_modes_read_by_meshio_are_those_of_the_body(element, tmp_path):
    found = write_surface_vtu(element, tmp_path / "modes.vtu", shapes=("free", "fixed_interface"))
    assert found.files == (tmp_path / "modes.vtu",)
    mesh = meshio.read(tmp_path / "modes.vtu")
    frequencies = np.ravel(mesh.field_data["frequency_hz"])
    free = element.free_frequencies_hz
    assert frequencies[:10] == pytest.approx(free, rel=1e-9)
    fixed = np.sort(element.fixed_interface_frequencies_hz)[:12]
    assert frequencies[12:] == pytest.approx(fixed, rel=1e-6)
    assert len(mesh.point_data) == len(frequencies) == 24
    for name, f in zip(mesh.point_data, frequencies, strict=True):
        assert name.endswith(f"{f:.6g} Hz")
        assert np.linalg.norm(mesh.point_data[name], axis=1).max() == pytest.approx(1.0, rel=1e-6)
    # the mean over the ring around an interface that is held is at rest
    for name in list(mesh.point_data)[12:]:
        for z in (0.1, 0.4):
            ring = np.abs(mesh.points[:, 2] - z) < 1e-12
            assert ring.sum() == 48
            assert np.abs(mesh.point_data[name][ring].mean(axis=0)).max() < 1e-6


def test_vtkhdf_has_the_layout_of_its_format(element, tmp_path):
    """VTKHDF 2.0, UnstructuredGrid, as its description has it, read with h5py alone."""
    write_surface_vtu(element, tmp_path / "modes.vtu", sectors=16)
    write_surface_vtkhdf(element, tmp_path / "modes.vtkhdf", sectors=16)
    other = meshio.read(tmp_path / "modes.vtu")
    with h5py.File(tmp_path / "modes.vtkhdf") as file:
        root = file["VTKHDF"]
        kind = root.attrs.get_id("Type")
        # a text of fixed length in ASCII, else ParaView does not open the file
        assert kind.dtype.kind == "S" and root.attrs["Type"] == b"UnstructuredGrid"
        assert root.attrs["Version"].tolist() == [2, 0]
        names = ("NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds")
        points, cells, numbers = (root[name][()] for name in names)
        assert points.shape == cells.shape == numbers.shape == (1,)
        assert root["Points"].shape == (points[0], 3)
        assert root["Offsets"].shape == (cells[0] + 1,) and root["Types"].shape == (cells[0],)
        assert root["Types"].dtype == np.uint8
        assert root["Offsets"][0] == 0 and root["Offsets"][-1] == numbers[0]
        assert (np.diff(root["Offsets"]) == np.where(root["Types"][()] == 9, 4, 3)).all()
        assert root["Connectivity"].shape == (numbers[0],)
        assert root["Connectivity"][()].max() < points[0]
        assert np.array_equal(root["Points"], other.points)
        assert list(root["PointData"]) == list(other.point_data)
        for name, field in other.point_data.items():
            assert np.array_equal(root["PointData"][name], field)
        assert len(root["FieldData/frequency_hz"]) == len(other.point_data)


def test_a_shaft_is_drawn_by_its_radii(lateral_shaft, tmp_path):
    found = write_surface_vtu(lateral_shaft, tmp_path / "tube.vtu", modes=2, sectors=24)
    assert "square to its bent centre line" in found.left_out[0]
    mesh = meshio.read(tmp_path / "tube.vtu")
    radius = np.hypot(*mesh.points[:, :2].T)
    provenance = lateral_shaft.provenance
    radii = {*provenance["outer_radius_m"], *provenance["inner_radius_m"]}
    assert sorted(set(radius.round(9))) == pytest.approx(sorted(radii))
    # a ring moves with the centre line: Fourier's zeroth order of its points
    shapes = lateral_shaft.recovery_modes
    k = int(np.argmax(lateral_shaft.recovery_points_m[:, 2] >= 0.3))
    z = lateral_shaft.recovery_points_m[k, 2]
    ring = (np.abs(mesh.points[:, 2] - z) < 1e-12) & (radius < 0.0101)
    (name, field), *_ = mesh.point_data.items()
    assert name.startswith("free 01") and ring.sum() == 24
    centre = field[ring].mean(axis=0)
    assert np.linalg.norm(centre) > 0.01 and shapes.shape[1] == 3
    assert np.abs(field[ring] - centre)[:, :2].max() < 1e-6


def test_a_body_without_surface_is_a_line_and_says_so(disk_shaft, tmp_path):
    bare = dataclasses.replace(disk_shaft, surface=None, provenance={})
    found = write_surface_vtu(bare, tmp_path / "line.vtu", modes=2)
    assert "centre line" in found.left_out[0]
    mesh = meshio.read(tmp_path / "line.vtu")
    assert len(mesh.points) == len(bare.recovery_points_m)
    (lines,) = mesh.cells
    along = mesh.points[lines.data, 2]
    assert lines.type == "line" and (np.diff(along, axis=1) > 0.0).all()


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"shapes": ("loud",)}, "shapes are"),
        ({"shapes": ()}, "shapes are"),
        ({"modes": 0}, "modes is 0"),
        ({"sectors": 2}, "sectors"),
    ],
)
def test_meaningless_arguments_are_refused(element, tmp_path, asked, words):
    with pytest.raises(SuperelementError, match=words):
        write_surface_vtu(element, tmp_path / "modes.vtu", **asked)
    assert not list(tmp_path.iterdir())


@pytest.mark.solver
def test_a_reduced_rotor_brings_the_surface_of_its_outline(harmonic_rotor, tmp_path):
    surface = harmonic_rotor.surface
    assert surface is not None and surface.kind == "meridian"
    assert_rigid(surface, dict(enumerate(harmonic_rotor.rigid_body_modes.T)), 12)
    around = 0.5 * 64 * np.sin(2.0 * np.pi / 64)
    exact = around * (0.02**2 * 0.4 + (0.12**2 - 0.02**2) * 0.03)
    assert volume(surface.faces(64)) == pytest.approx(exact, rel=1e-9)
    # the outline at θ = 0 and 90° is that of the points for pictures
    q = np.random.default_rng(2).normal(size=harmonic_rotor.size)
    moved, faces = surface.displacement(q, 4), surface.faces(4)
    shown = harmonic_rotor.recovery_modes @ q
    for point, exact in zip(harmonic_rotor.recovery_points_m, shown, strict=True):
        gap = np.linalg.norm(faces.points_m - point, axis=1)
        if gap.min() < 1e-12:  # points on the axis are no surface but at the ends
            assert moved[gap.argmin()] == pytest.approx(exact, abs=1e-12 * np.abs(shown).max())


@pytest.mark.solver
def test_a_reduced_solid_brings_its_triangles():
    from mpi4py import MPI

    from solidwhirl.meshing import MeshSize, mesh_revolved
    from solidwhirl.reduction import ReductionRequest, reduce_body

    ends = (plane("front", 0.0), plane("rear", 0.1))
    tube = body(section("tube", 0.0, 0.1, 0.02, 0.04), interfaces=ends, name="tube")
    request = ReductionRequest(
        level="solid",
        orders=(1, 0),
        components=("ux", "uy", "uz", "rz"),
        degree=2,
        modes=1,
        maximum_speed_rad_s=0.0,
        gyroscopic=False,
        centrifugal=False,
    )
    mesh = mesh_revolved(tube, MeshSize(size_m=0.04, corner_size_m=0.04, around=8))
    element, _ = reduce_body(tube, mesh, MPI.COMM_SELF, request, {})
    surface = element.surface
    assert surface is not None and surface.kind == "sector"
    there = np.flatnonzero(element.rigid_body_present)
    assert_rigid(surface, {k: element.rigid_body_modes[:, k] for k in there}, 1)
    # triangles between the corners of curved elements: inside the tube, measured 10 % less
    exact = np.pi * (0.04**2 - 0.02**2) * 0.1
    assert 0.8 * exact < volume(surface.faces(1)) < exact


def _tube(count, mirrored, steps=4):
    """Outside, inside and ends of the sector of a round tube, (z, r) and θ of its points."""
    angle = 2.0 * np.pi / count * (0.5 if mirrored else 1.0)
    corners = np.array([[0.1, 0.02], [0.1, 0.03], [0.4, 0.03], [0.4, 0.02]])
    theta = angle * np.arange(steps + 1) / steps
    z, r = (np.tile(corners[:, k], steps + 1) for k in (0, 1))
    around = np.repeat(theta, 4)
    points = np.column_stack([r * np.cos(around), r * np.sin(around), z])
    cells = []
    for k in range(steps):
        for c in range(4):
            a, b, d, e = 4 * k + c, 4 * k + (c + 1) % 4, 4 * k + 4 + c, 4 * k + 4 + (c + 1) % 4
            cells += [[a, d, b], [b, d, e]]
    return points, np.array(cells), z, r, around


def _sector_of_tube(count, mirrored):
    """Rigid motions ux, uy, uz, rx, ry, rz as fields of the index 1 and 0 on a sector."""
    points, cells, *_ = _tube(count, mirrored)
    x, y, z = points.T
    one, zero = np.ones_like(x), np.zeros_like(x)
    bending = np.stack([one, 1j * one, zero], axis=1)
    tilting = np.stack([z, 1j * z, -(x + 1j * y)], axis=1)
    torsion = np.stack([-y, x, zero], axis=1) * (1j if mirrored else 1.0)
    axial = np.stack([zero, zero, one], axis=1).astype(complex)
    fields = [bending, bending, axial, -tilting, tilting, torsion]  # c = ry + i rx
    return Surface(
        points_m=points,
        cells=cells,
        amplitudes=np.stack(fields, axis=2),
        coordinate=np.arange(6),
        order=np.array([1, 1, 0, 1, 1, 0]),
        family=np.array([0, 1, 0, 1, 0, 0]),
        size=6,
        copies=Copies(count=count, mirrored=mirrored),
    )


@pytest.mark.parametrize(("count", "mirrored"), [(3, False), (7, False), (5, True), (12, True)])
def test_a_sector_moves_rigidly_with_all_its_copies(count, mirrored):
    sector = _sector_of_tube(count, mirrored)
    assert_rigid(sector, dict(enumerate(np.eye(6))), 0)
    steps = count * (8 if mirrored else 4)
    exact = 0.5 * steps * np.sin(2.0 * np.pi / steps) * (0.03**2 - 0.02**2) * 0.3
    assert volume(sector.faces(0)) == pytest.approx(exact, rel=1e-12)
    whirl = sector.displacement([1.0, -1.0j, 0.0, 0.0, 0.0, 0.0], 0)
    assert whirl == pytest.approx(np.broadcast_to([1.0, -1.0j, 0.0], whirl.shape), abs=1e-6)
    faces = sector.faces(0)
    whole = sector.as_solid(np.arange(len(faces.points_m)), faces.triangles)
    assert_rigid(whole, dict(enumerate(np.eye(6))), 0)
    few = sector.of_coordinates([2, 4])
    np.testing.assert_array_equal(
        few.displacement([2.0, 3.0], 0), sector.displacement([0, 0, 2, 0, 3, 0], 0)
    )


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_sector_moves_as_the_meridian_of_the_same_body(mirrored):
    """Bending of a ring: Φ = e^{iθ} (a, −ib, c) along r, θ, z is its order 1."""
    count = 8
    points, cells, z, r, theta = _tube(count, mirrored, 1)
    rng = np.random.default_rng(5)
    ring = rng.standard_normal((4, 3))
    a, b, c = np.tile(ring, (2, 1)).T
    phase = np.exp(1j * theta)
    radial = np.stack([np.cos(theta), np.sin(theta), 0.0 * theta], axis=1)
    around = np.stack([-np.sin(theta), np.cos(theta), 0.0 * theta], axis=1)
    field = (phase * a)[:, None] * radial - 1j * (phase * b)[:, None] * around
    field[:, 2] = phase * c
    both = {"coordinate": [0, 1], "order": [1, 1], "family": [0, 1], "size": 2}
    sector = Surface(
        points_m=points,
        cells=cells,
        amplitudes=np.stack([field, field], axis=2),
        copies=Copies(count=count, mirrored=mirrored),
        **both,
    )
    meridian = Surface(
        points_m=np.column_stack([z[:4], r[:4]]),
        cells=np.empty((0, 2)),
        amplitudes=np.stack([ring, ring], axis=2),
        **both,
    )
    angles = count * (2 if mirrored else 1)
    place, exact = meridian.faces(angles).points_m, meridian.displacement([0.3, -1.1j], angles)
    gap, nearest = cKDTree(place).query(sector.faces(0).points_m)
    assert gap.max() < 1e-12
    moved = sector.displacement([0.3, -1.1j], 0)
    assert np.abs(moved - exact[nearest]).max() < 1e-6


def test_sectors_that_are_none_are_refused():
    sector = _sector_of_tube(4, True)
    for change, words in (
        ({"copies": Copies(count=0, mirrored=True)}, "copies are 0"),
        ({"copies": None}, "complex"),
        ({"points_m": sector.points_m[:, :2], "cells": np.empty((0, 2))}, r"3 \(sector\)"),
        ({"amplitudes": sector.amplitudes * np.nan}, "finite"),
    ):
        with pytest.raises(SuperelementError, match=words):
            dataclasses.replace(sector, **change)
