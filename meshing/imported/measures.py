"""What is measured on a tetrahedral mesh: mass, inertia, roundness, areas of interfaces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache

import numpy as np
import scipy

from solidwhirl.meshing.imported.groups import in_box, points_in_box
from solidwhirl.meshing.imported.records import MassIntegrals, MeshInterface, Roundness
from solidwhirl.meshing.imported.turning import turned
from solidwhirl.meshing.own.quality import EDGES
from solidwhirl.meshing.records import FloatArray, IntArray, Mesh

# Gauss points in each direction: exact for degree 7, which inertia on curved elements has, 5 (of
# the moments of roundness on straight ones) and 3, which volume has.
_OF_INERTIA, _OF_MOMENTS, _OF_VOLUME = 4, 3, 2
# Polynomials along the axis that weight the moments of the mass.
_ALONG = 4
_CHUNK = 4000
# Angles that nothing with a few repetitions around is the same after [rad]; the golden angle's.
_ANGLES = tuple(2.399963229728653 * k for k in range(1, 6))
# Turned nodes that are looked at, at most, and the nearest pieces for each.
_MOST, _NEAREST = 4000, 12
# Nodes nearer to the axis than this part of the largest radius say nothing of its roundness.
_NEAR_AXIS = 0.02
# Places in a second-order face: corners of the 16 pieces that it is divided into, by fourths.
_FOURTHS = 4


@lru_cache(maxsize=4)
def _rule(count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Weights, shape functions (q, 10) and gradients (q, 10, 3): conical product of Gauss rules."""
    nodes, weights = zip(*(scipy.special.roots_jacobi(count, k, 0) for k in range(3)), strict=True)
    unit = [0.5 * (n + 1.0) for n in nodes]
    scaled = [w / 2.0 ** (k + 1) for k, w in enumerate(weights)]
    a, b, c = np.meshgrid(unit[0], unit[1], unit[2], indexing="ij")
    x = np.stack([(a * (1.0 - b) * (1.0 - c)), b * (1.0 - c), c], axis=-1).reshape(-1, 3)
    weight = np.einsum("i,j,k->ijk", *scaled).ravel()
    bary = np.column_stack([1.0 - x.sum(axis=1), x])
    of_bary = np.vstack([-np.ones(3), np.eye(3)])
    shape = [bary[:, k] * (2.0 * bary[:, k] - 1.0) for k in range(4)]
    slope = [(4.0 * bary[:, k] - 1.0)[:, None] * of_bary[k] for k in range(4)]
    for i, j in EDGES[3]:
        shape.append(4.0 * bary[:, i] * bary[:, j])
        slope.append(4.0 * (bary[:, [i]] * of_bary[j] + bary[:, [j]] * of_bary[i]))
    return weight, np.array(shape).T, np.array(slope).transpose(1, 0, 2)


def volume_m3(mesh: Mesh) -> float:
    """Volume of the curved elements, of all sectors.

    `mesh`: second-order tetrahedra.
    """
    ones = tuple(replace(m, density_kg_per_m3=1.0) for m in mesh.materials)
    volumes = _masses(replace(mesh, materials=ones), _OF_VOLUME)
    return _copies(mesh) * float(sum(v.sum() for _, v in volumes))


def _copies(mesh: Mesh) -> int:
    return 1 if mesh.sector is None else mesh.sector.copies


def evenly_turned(first: FloatArray, second: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Means over three or more equal turns about z of a vector (3,) and a matrix (3, 3)."""
    across = 0.5 * (second[0, 0] + second[1, 1])
    return np.array([0.0, 0.0, first[2]]), np.diag([across, across, second[2, 2]])


def _masses(mesh: Mesh, count: int) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Places (m, 3) and masses (m,) of the points of the quadrature, and point masses."""
    weight, shape, slope = _rule(count)
    density = np.array([m.density_kg_per_m3 for m in mesh.materials])[mesh.cell_material]
    for start in range(0, len(mesh.cells), _CHUNK):
        own = mesh.points[mesh.cells[start : start + _CHUNK]]
        jacobian = np.einsum("cnd,qne->cqde", own, slope)
        volume = np.linalg.det(jacobian) * weight
        mass = density[start : start + _CHUNK, None] * volume
        yield np.einsum("cnd,qn->cqd", own, shape).reshape(-1, 3), mass.ravel()
    yield mesh.points[mesh.mass_nodes], mesh.node_masses_kg


def mass_integrals(mesh: Mesh) -> MassIntegrals:
    """Integrate mass, centre of gravity and inertia over the curved elements of all sectors.

    `mesh`: second-order tetrahedra.
    """
    total, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for x, mass in _masses(mesh, _OF_INERTIA):
        total += float(mass.sum())
        first += mass @ x
        second += x.T @ (mass[:, None] * x)
    if mesh.sector is not None:
        total *= mesh.sector.copies
        first, second = evenly_turned(mesh.sector.copies * first, mesh.sector.copies * second)
    centre = first / total
    second -= total * np.outer(centre, centre)
    inertia = np.trace(second) * np.eye(3) - second
    return MassIntegrals(
        mass_kg=total,
        center_of_gravity_m=tuple(float(v) for v in centre),  # type: ignore[arg-type]
        inertia_kg_m2=tuple((float(a), float(b), float(c)) for a, b, c in inertia),
    )


def roundness(mesh: Mesh, surface: IntArray) -> Roundness:
    """Measure how far a mesh is from a body of revolution about z.

    `surface`: (f, 6) faces that must be of revolution: the surface, and faces between materials.

    Gyroscopic and inertia forces of motions of circumferential order 1 depend on the mass through
    its circumferential orders 0 and 2, unbalance on order 1: ∫ρ (x+iy)^m P_k(z) dV, m = 1, 2, is
    looked at for the first Legendre polynomials along the body, against ∫ρ r^m dV. What has
    other orders is seen by the surface alone.
    """
    low, high = mesh.points[:, 2].min(), mesh.points[:, 2].max()
    uneven = np.zeros((2, _ALONG), dtype=complex)
    even, total = np.zeros(2), 0.0
    for x, mass in _masses(mesh, _OF_MOMENTS):
        around = x[:, 0] + 1j * x[:, 1]
        along = (2.0 * x[:, 2] - low - high) / (high - low)
        weights = np.array([scipy.special.eval_legendre(k, along) for k in range(_ALONG)])
        for m in (1, 2):
            uneven[m - 1] += weights @ (mass * around**m)
            even[m - 1] += float(mass @ np.abs(around) ** m)
        total += float(mass.sum())
    gyration = np.sqrt(even[1] / total)
    return Roundness(
        static_unbalance=float(abs(uneven[0, 0]) / total / gyration),
        uneven_mass=float((np.abs(uneven) / even[:, None]).max()),
        surface=surface_deviation(mesh.points, surface),
    )


def surface_deviation(points: FloatArray, faces: IntArray) -> float:
    """Return how far turned corners of faces (f, 6) lie from them, over the radius; the most."""
    triangles = flat_pieces(points, faces)
    corner = np.unique(faces[:, :3])
    x = points[corner]
    radius = np.hypot(x[:, 0], x[:, 1])
    x = x[radius > _NEAR_AXIS * radius.max()]
    x = x[:: max(1, -(-len(x) // _MOST))]
    centre = triangles.mean(axis=1)
    tree, count = scipy.spatial.cKDTree(centre), min(_NEAREST, len(centre))
    worst = 0.0
    for angle in _ANGLES:
        cos, sin = np.cos(angle), np.sin(angle)
        turned = np.column_stack([cos * x[:, 0] - sin * x[:, 1], sin * x[:, 0] + cos * x[:, 1]])
        turned = np.column_stack([turned, x[:, 2]])
        _, near = tree.query(turned, k=count)
        near = near.reshape(len(turned), count)
        gap = np.full(len(turned), np.inf)
        for k in range(count):
            np.minimum(gap, _distance(turned, triangles[near[:, k]]), out=gap)
        worst = max(worst, float((gap / np.hypot(turned[:, 0], turned[:, 1])).max()))
    return worst


def flat_pieces(points: FloatArray, faces: IntArray) -> FloatArray:
    """Flat triangles (m, 3, 3) that follow curved faces (f, 6), 16 of each."""
    n = _FOURTHS
    lattice = ((i, j) for i in range(n + 1) for j in range(n + 1 - i))
    index = {place: k for k, place in enumerate(lattice)}
    bary = np.array([[n - i - j, i, j] for i, j in index], dtype=float) / n
    a, b, c = bary.T
    corners = [v * (2.0 * v - 1.0) for v in (a, b, c)]
    shape = np.column_stack([*corners, 4.0 * a * b, 4.0 * b * c, 4.0 * c * a])
    x = np.einsum("pn,fnd->fpd", shape, points[faces])
    cut = []
    for i, j in index:
        if i + j < n:
            cut.append([index[i, j], index[i + 1, j], index[i, j + 1]])
        if i + j < n - 1:
            cut.append([index[i + 1, j], index[i + 1, j + 1], index[i, j + 1]])
    return np.asarray(x[:, np.array(cut)].reshape(-1, 3, 3))


def _distance(x: FloatArray, triangles: FloatArray) -> FloatArray:
    """Distance of points (m, 3) from triangles (m, 3, 3), one each."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1)
    size[size == 0.0] = 1.0
    normal = normal / size[:, None]
    above = np.einsum("ij,ij->i", x - a, normal)
    inside = np.ones(len(x), dtype=bool)
    nearest = np.full(len(x), np.inf)
    for p, q in ((a, b), (b, c), (c, a)):
        side = np.einsum("ij,ij->i", np.cross(q - p, x - p), normal)
        inside &= side >= 0.0
        length = np.maximum(np.einsum("ij,ij->i", q - p, q - p), 1e-300)
        along = np.clip(np.einsum("ij,ij->i", x - p, q - p) / length, 0.0, 1.0)
        np.minimum(nearest, np.linalg.norm(x - p - along[:, None] * (q - p), axis=1), out=nearest)
    return np.where(inside, np.abs(above), nearest)


def measured(interface: MeshInterface, mesh: Mesh, outside: IntArray) -> MeshInterface:
    """Return an interface with its area and centre, and with what its box cuts, in all sectors.

    `outside`: (f, 6) facets of the whole surface.
    """
    sectors = None if mesh.sector is None else mesh.sector.count
    total, mean = area_and_centre(mesh, interface.name)
    mean[np.abs(mean) < 1e-9 * float(np.abs(mesh.points).max())] = 0.0
    told = replace(interface, area_m2=total, mean_m=tuple(mean.tolist()))
    if interface.box_m is None:
        return told
    left = outside[~in_box(mesh.points, outside, interface, sectors)]
    if not len(left):
        return told
    area, centre = facet_areas(mesh.points, left)
    size = float(np.abs(mesh.points).max())
    inside = np.zeros(len(centre), dtype=bool)
    for k in range(sectors or 1):
        inside |= points_in_box(turned(centre, 2.0 * np.pi * k / (sectors or 1)), interface, size)
    return replace(
        told,
        cut_facets=int(inside.reshape(len(left), -1).any(axis=1).sum()) * _copies(mesh),
        cut_area_m2=float(area[inside].sum()) * _copies(mesh),
    )


def area_and_centre(mesh: Mesh, name: str) -> tuple[float, FloatArray]:
    """Area [m²] and centre of area (3,) [m] of an interface of a solid, in all sectors."""
    area, middle = facet_areas(mesh.points, mesh.interfaces[name])
    centre = np.asarray(area @ middle / area.sum())
    if mesh.sector is not None:
        centre[:2] = 0.0
    return _copies(mesh) * float(area.sum()), centre


def facet_areas(points: FloatArray, facets: IntArray) -> tuple[FloatArray, FloatArray]:
    """Areas (16 f,) and middles (16 f, 3) of the pieces of curved facets (f, 6), 16 of each [m]."""
    corner = flat_pieces(points, facets)
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    return 0.5 * np.linalg.norm(normal, axis=1), corner.mean(axis=1)
