"""The outer surface of a meshed body with its displacement per coordinate of the superelement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from mpi4py import MPI
from scipy.spatial import cKDTree

from solidwhirl.meshing import Mesh
from solidwhirl.meshing.imported.records import AnyBody
from solidwhirl.reduction.basis.craig_bampton import Basis
from solidwhirl.reduction.basis.reduced_block import ReducedBlock, joined_rows
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators.matrices import BodyOperators
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray
from solidwhirl.rotordyn.superelement.surface import Surface, family_factors

# Edges this near to the axis, in parts of the largest radius, lie on it and are no surface.
_ON_AXIS = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class SurfaceMesh:
    """Corners of the elements on the boundary, and the facets between them."""

    points_m: FloatArray  #: (p, 2) z, r of a meridian without its axis, (p, 3) x, y, z of a solid
    cells: IntArray  #: (c, 2) edges or (c, 3) triangles, outward normals to the right of an edge


def surface_mesh(mesh: Mesh) -> SurfaceMesh:
    """Return the boundary of a mesh, facets of elements that have no neighbour there."""
    d = mesh.dimension
    corners = mesh.cells[:, : d + 1]
    facets = _facets(mesh.points, corners)
    key = np.sort(facets, axis=1)
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    outer = facets[np.sort(first[count == 1])]
    if d == 2:
        radius = mesh.points[:, 1]
        outer = outer[(radius[outer] > _ON_AXIS * radius.max()).any(axis=1)]
    used, cells = np.unique(outer, return_inverse=True)
    points = mesh.points[used].copy()
    if d == 2:
        points[:, 1] = np.where(points[:, 1] > _ON_AXIS * points[:, 1].max(), points[:, 1], 0.0)
    return SurfaceMesh(points_m=points, cells=np.asarray(cells).reshape(-1, d))


def _facets(points: FloatArray, corners: IntArray) -> IntArray:
    """Facets of all cells; normals of triangles, and right hands of edges, show outward."""
    d = points.shape[1]
    outward = 1.0 if d == 3 else -1.0
    found = []
    for kept in combinations(range(d + 1), d):
        (opposite,) = set(range(d + 1)) - set(kept)
        facet = corners[:, kept]
        edges = points[facet[:, 1:]] - points[facet[:, :1]]
        inward = points[corners[:, opposite]] - points[facet[:, 0]]
        turned = np.linalg.det(np.concatenate([edges, inward[:, None]], axis=1)) * outward > 0.0
        facet[turned] = facet[turned][:, [*range(d - 2), d - 1, d - 2]]
        found.append(facet)
    return np.concatenate(found)


def joined_surface(
    body: AnyBody,
    outline: SurfaceMesh,
    harmonics: tuple[int, ...],
    blocks: Sequence[ReducedBlock],
    amplitudes: Sequence[FloatArray],
) -> Surface:
    """Join the surfaces of all orders in the coordinates of the superelement."""
    rows = joined_rows(body, blocks)
    moved, order_of, family_of = [], [], []
    for k, (block, values) in enumerate(zip(blocks, amplitudes, strict=True)):
        columns, count = values.shape[2], len(block.coordinates)
        own = block.order  # column of the stacked families that each coordinate is
        if count:
            moved.append(values[:, :, own % columns] * block.signs[own])
        order_of.append(np.full(count, harmonics[k] if harmonics else 0))
        family_of.append(own // max(columns, 1))
    return Surface(
        points_m=outline.points_m,
        cells=outline.cells,
        amplitudes=np.concatenate(moved, axis=2),
        coordinate=np.concatenate(rows),
        order=np.concatenate(order_of),
        family=np.concatenate(family_of),
        size=sum(len(own) for own in rows),
    )


# Points are nodes of the mesh, or turned into each other, up to this part of its size.
_NEAR = 1e-9


def recovery_modes(operators: BodyOperators, basis: Basis, points_m: FloatArray) -> FloatArray:
    """Displacement of points at θ = 0 and 90° per coordinate, (m, 3, families n)."""
    if operators.harmonic is None:
        return nodal_amplitudes(operators, basis, points_m)
    radius = np.hypot(points_m[:, 0], points_m[:, 1])
    places = np.column_stack([points_m[:, 2], radius])
    amplitudes = nodal_amplitudes(operators, basis, places)
    return _on_the_round(operators.harmonic, amplitudes, points_m)


def nodal_amplitudes(operators: BodyOperators, basis: Basis, places: FloatArray) -> FloatArray:
    """Return the values of the basis at nodes of the mesh.

    `places`: (m, 2) z, r on a meridian, (m, 3) x, y, z on a solid, all of it, also where half of it
    is worked on. Result: (m, 3, n): amplitudes of one family, or displacements, per column of the
    basis; the same on every rank. Raises ReductionError: a place is no node.
    """
    n, comm = basis.vectors.shape[1], operators.comm
    full = operators.coupling.displacement(basis.vectors)
    owned = len(full) // 3
    x = operators.space.tabulate_dof_coordinates()[:owned]
    kin, size = operators.ingredients.kinematics, float(np.abs(places).max(initial=1e-30))
    wanted, away = places, np.zeros(len(places), dtype=bool)
    if kin.copies == 2:
        away = places[:, 1] < -_NEAR * size
        wanted = np.where(away[:, None], places * [-1.0, -1.0, 1.0], places)
    mine, node = _own_places(x[:, : places.shape[1]], wanted, _NEAR * size, comm)
    values = np.zeros((len(places), 3, n))
    values[mine] = full.reshape(owned, 3, n)[node]
    if comm.size > 1:
        comm.Allreduce(MPI.IN_PLACE, values)
    if away.any():
        values[away] = np.einsum("ij,mjn->min", kin.symmetry.power(1), values[away])
    return values


def _own_places(
    nodes: FloatArray, wanted: FloatArray, near: float, comm: Any
) -> tuple[IntArray, IntArray]:
    """Which places are nodes of this rank, each of one rank only, and which nodes they are."""
    gap = np.full(len(wanted), np.inf)
    nearest = np.zeros(len(wanted), dtype=np.int64)
    if len(nodes) and len(wanted):
        gap, nearest = cKDTree(nodes).query(wanted)
    least = np.empty_like(gap)
    comm.Allreduce(gap, least, op=MPI.MIN)
    if len(least) and least.max() > near:
        raise ReductionError(f"recovery points are {least.max():.3g} m off the mesh")
    first = np.empty(len(wanted), dtype=np.int64)
    claim = np.where(gap <= least, comm.rank, comm.size).astype(np.int64)
    comm.Allreduce(claim, first, op=MPI.MIN)
    mine = np.flatnonzero(first == comm.rank)
    return mine, nearest[mine]


def _on_the_round(order: int, amplitudes: FloatArray, points_m: FloatArray) -> FloatArray:
    """Cartesian displacement at the points from amplitudes (a, b, c) of the cos and sin family."""
    theta = np.arctan2(points_m[:, 1], points_m[:, 0])
    a, b, c = (amplitudes[:, k] for k in range(3))
    cos, sin = np.cos(theta)[:, None], np.sin(theta)[:, None]
    out = []
    for family in range(2 if order else 1):
        along, across = (f[:, None] for f in family_factors(order, family, theta))
        u_r, u_t, u_z = a * along, b * across, c * along
        out.append(np.stack([u_r * cos - u_t * sin, u_r * sin + u_t * cos, u_z], axis=1))
    return np.concatenate(out, axis=2)
