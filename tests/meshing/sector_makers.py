"""Meshes of sectors for tests: bladed disks by gmsh, rings of hexahedra, and their copies."""

from __future__ import annotations

import gmsh
import meshio
import numpy as np
from mesh_makers import file_mesh
from scipy.spatial import cKDTree

from solidwhirl.meshing.imported.records import ElementBlock, FileMesh

# meshio numbers the last two edges of a tetrahedron as VTK does
TO_VTK = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]


def turn(points, angle):
    """Points (n, 3) turned about z."""
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def bladed(path, count=12, sectors=1, stagger_deg=30.0, periodic=True, inner_m=0.03):
    """Write a .msh of sectors of a disk 0.03 <= r <= 0.1, |z| <= 0.006, with blades to x = 0.15.

    Without `periodic` one of the cut faces is meshed finer.
    """
    angle = 2.0 * np.pi / count
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        occ = gmsh.model.occ
        face = occ.addRectangle(inner_m, -0.006, 0.0, 0.1 - inner_m, 0.012)
        occ.rotate([(2, face)], 0, 0, 0, 1, 0, 0, 0.5 * np.pi)
        occ.rotate([(2, face)], 0, 0, 0, 0, 0, 1, -0.5 * angle)
        disk = [e for e in occ.revolve([(2, face)], 0, 0, 0, 0, 0, 1, sectors * angle) if e[0] == 3]
        blades = []
        for k in range(sectors):
            blade = (3, occ.addBox(0.095, -0.002, -0.01, 0.055, 0.004, 0.02))
            occ.rotate([blade], 0, 0, 0, 1, 0, 0, -np.radians(stagger_deg))
            occ.rotate([blade], 0, 0, 0, 0, 0, 1, k * angle)
            blades.append(blade)
        occ.fuse(disk, blades)
        occ.synchronize()
        _mesh_cut(-0.5 * angle, sectors * angle, periodic)
        gmsh.model.mesh.setOrder(2)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


def paddles(path, count=12, sectors=1, width_mm=20.0, turned=0.0, axis=((0, 0, 0), (0, 0, 0))):
    """Write a .step of sectors of a disk, inner radius 30, outer 100 and 12 mm thick, with paddles.

    Every sector has a bolt hole, and a stem that carries a plate across at 120 <= r <= 150 mm.
    `axis`: a translation [mm] and a turn (a vector [rad]) of all. Returns the volume of all
    sectors [m³].
    """
    angle = 2.0 * np.pi / count
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        occ = gmsh.model.occ
        face = occ.addRectangle(30.0, -6.0, 0.0, 70.0, 12.0)
        occ.rotate([(2, face)], 0, 0, 0, 1, 0, 0, 0.5 * np.pi)
        occ.rotate([(2, face)], 0, 0, 0, 0, 0, 1, -0.5 * angle)
        disk = [e for e in occ.revolve([(2, face)], 0, 0, 0, 0, 0, 1, sectors * angle) if e[0] == 3]
        blades, holes = [], []
        for k in range(sectors):
            stem = (3, occ.addBox(95.0, -3.0, -4.0, 30.0, 6.0, 8.0))
            plate = (3, occ.addBox(120.0, -0.5 * width_mm, -2.0, 30.0, width_mm, 4.0))
            hole = (3, occ.addCylinder(60.0, 2.0, -10.0, 0.0, 0.0, 20.0, 5.0))
            occ.rotate([stem, plate, hole], 0, 0, 0, 0, 0, 1, k * angle)
            blades += [stem, plate]
            holes.append(hole)
        solids, _ = occ.cut(occ.fuse(disk, blades)[0], holes)
        volume = sum(occ.getMass(*s) for s in solids)
        occ.rotate(solids, 0, 0, 0, 0, 0, 1, turned)
        if any(axis[1]):
            occ.rotate(solids, 0, 0, 0, *axis[1], float(np.linalg.norm(axis[1])))
        occ.translate(solids, *axis[0])
        occ.synchronize()
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    return 1e-9 * volume * count / sectors


def _mesh_cut(start, angle, periodic):
    middles = {t: np.array(gmsh.model.occ.getCenterOfMass(2, t))
               for _, t in gmsh.model.getEntities(2)}  # fmt: skip
    flat = {t: x for t, x in middles.items() if abs(x[2]) < 1e-7 and 0.04 < np.hypot(*x[:2]) < 0.09}
    first = next(t for t, x in flat.items() if abs(np.arctan2(x[1], x[0]) - start) < 1e-6)
    second = next(t for t, x in flat.items() if np.allclose(turn(middles[first], angle), x))
    c, s = np.cos(angle), np.sin(angle)
    if periodic:
        affine = [c, -s, 0, 0, s, c, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
        gmsh.model.mesh.setPeriodic(2, [second], [first], affine)
    else:
        field = gmsh.model.mesh.field
        field.add("Constant", 1)
        field.setNumber(1, "VIn", 0.005)
        field.setNumber(1, "VOut", 0.012)
        field.setNumbers(1, "SurfacesList", [second])
        field.setAsBackgroundMesh(1)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.012)
    gmsh.model.mesh.generate(3)


def of_msh(path):
    """What a .msh of `bladed` holds, without groups."""
    mesh = meshio.gmsh.read(str(path))
    return file_mesh(mesh.points, tetra10=mesh.cells_dict["tetra10"])


def ring(count, layers, around, radii=(0.4, 1.0), sectors=1, twist=0.0):
    """Hexahedra of sectors of a ring; the cuts lean by `twist` per length and radius."""
    n = around * sectors + (sectors < count)
    angle = 2.0 * np.pi / count * np.arange(n) / around
    r, z = np.linspace(*radii, layers + 1), np.linspace(0.0, 0.5, layers + 1)
    t, r, z = np.meshgrid(angle, r, z, indexing="ij")
    t = t + twist * (z + r**2)
    points = np.column_stack([(r * np.cos(t)).ravel(), (r * np.sin(t)).ravel(), z.ravel()])
    i = np.arange(len(points)).reshape(r.shape)
    i = i if sectors < count else np.concatenate([i, i[:1]])
    a, b = slice(None, -1), slice(1, None)
    corners = [i[a, a, a], i[b, a, a], i[b, b, a], i[a, b, a]]
    corners += [i[a, a, b], i[b, a, b], i[b, b, b], i[a, b, b]]
    return points, np.column_stack([c.ravel() for c in corners])


def shuffled(found, seed=1):
    """The same with nodes and elements in another order."""
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(found.points))
    rank = np.argsort(order)
    assert not found.face_groups
    return FileMesh(
        points=found.points[order],
        blocks=tuple(
            ElementBlock(kind=b.kind, nodes=rng.permutation(rank[b.nodes])) for b in found.blocks
        ),
        element_groups={},
        node_groups={name: rank[own] for name, own in found.node_groups.items()},
    )


def copied(points, cells, count):
    """Points and cells of all copies, those at one place as one, and how many were joined."""
    n = len(points)
    all_points = np.vstack([turn(points, 2.0 * np.pi * k / count) for k in range(count)])
    all_cells = np.vstack([cells + n * k for k in range(count)])
    size = np.abs(points).max()
    tree = cKDTree(all_points)
    first = np.array([min(near) for near in tree.query_ball_point(all_points, 2e-12 * size)])
    kept, number = np.unique(first, return_inverse=True)
    return all_points[kept], number.ravel()[all_cells]
