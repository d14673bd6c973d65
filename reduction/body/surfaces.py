"""The outer surface of a meshed body with its displacement per coordinate of the superelement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
from mpi4py import MPI
from scipy.spatial import cKDTree

from solidwhirl.meshing import Mesh, Sector
from solidwhirl.meshing.imported.records import AnyBody
from solidwhirl.meshing.own.joined import own_parts
from solidwhirl.reduction.basis.craig_bampton import Basis
from solidwhirl.reduction.basis.reduced_block import ReducedBlock, joined_rows
from solidwhirl.reduction.errors import ReductionError
from solidwhirl.reduction.operators.cyclic import CyclicIndex
from solidwhirl.reduction.operators.matrices import BodyOperators
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray, IntArray, Matrix
from solidwhirl.rotordyn.superelement.surface import Copies, Surface, family_factors, turns

# Edges this near to the axis, in parts of the largest radius, lie on it and are no surface.
_ON_AXIS = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class SurfaceMesh:
    """Corners of the elements on the boundary, and the facets between them."""

    points_m: FloatArray  #: (p, 2) z, r of a meridian without its axis, (p, 3) x, y, z of a solid
    cells: IntArray  #: (c, 2) edges or (c, 3) triangles, outward normals to the right of an edge
    copies: Copies | None = None  #: Of a sector, which has no facets on its cut faces


def surface_meshes(mesh: Mesh) -> tuple[SurfaceMesh, ...]:
    """Return the boundary of a mesh, or of every part of one whose sectors differ."""
    return tuple(surface_mesh(part) for part in own_parts(mesh))


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
    copies = None
    if mesh.sector is not None:
        own = mesh.sector
        copies = Copies(count=own.count, mirrored=own.mirrored, angle_rad=own.angle_rad)
        outer = outer[~_cut(mesh.points, outer, copies)]
    used, cells = np.unique(outer, return_inverse=True)
    points = mesh.points[used].copy()
    if d == 2:
        points[:, 1] = np.where(points[:, 1] > _ON_AXIS * points[:, 1].max(), points[:, 1], 0.0)
    return SurfaceMesh(points_m=points, cells=np.asarray(cells).reshape(-1, d), copies=copies)


def _cut(points: FloatArray, facets: IntArray, copies: Copies) -> BoolArray:
    """Which facets (f, 3) of a sector's boundary lie on its cut faces, (f,)."""
    near = _NEAR * float(np.abs(points).max())
    x, y, _ = points.T
    if copies.mirrored:
        half = np.pi / copies.count
        beyond = y * np.cos(half) - x * np.sin(half)
        return np.asarray(sum((np.abs(d) <= near)[facets].all(axis=1) for d in (y, beyond)) > 0)
    used = np.unique(facets)
    turn = turns(np.array([2.0 * np.pi / copies.count]))[0]
    gap, partner = cKDTree(points[used]).query(points[used] @ turn.T, distance_upper_bound=near)
    there = np.full(len(points), -1)
    there[used[np.isfinite(gap)]] = used[partner[np.isfinite(gap)]]
    _, number = np.unique(
        np.sort(np.concatenate([facets, there[facets]]), axis=1), axis=0, return_inverse=True
    )
    first, last = np.reshape(number, (2, -1))
    return np.isin(first, last) | np.isin(last, first)


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
    outlines: Sequence[SurfaceMesh],
    harmonics: tuple[int, ...],
    blocks: Sequence[ReducedBlock],
    amplitudes: Sequence[Matrix],
) -> Surface:
    """Join the surfaces of all orders in the coordinates of the superelement.

    `amplitudes`: by order, of the points of all outlines. Parts whose sectors differ become the
    surface of the whole.
    """
    rows = joined_rows(body, blocks)
    moved, order_of, family_of = [], [], []
    for k, (block, values) in enumerate(zip(blocks, amplitudes, strict=True)):
        columns, count = values.shape[2], len(block.coordinates)
        own = block.order  # column of the stacked families that each coordinate is
        if count:
            moved.append(values[:, :, own % columns] * block.signs[own])
        order_of.append(np.full(count, harmonics[k] if harmonics else 0))
        family_of.append(own // max(columns, 1))
    every = np.concatenate(moved, axis=2)
    ends = np.cumsum([len(outline.points_m) for outline in outlines])
    found = [
        Surface(
            points_m=outline.points_m,
            cells=outline.cells,
            amplitudes=own,
            coordinate=np.concatenate(rows),
            order=np.concatenate(order_of),
            family=np.concatenate(family_of),
            size=sum(len(own) for own in rows),
            copies=outline.copies,
        )
        for outline, own in zip(outlines, np.split(every, ends[:-1]), strict=True)
    ]
    return found[0] if len(found) == 1 else _one_solid(found)


def _one_solid(parts: Sequence[Surface]) -> Surface:
    """Join sectors of one solid, each with all its copies."""
    wholes = []
    for part in parts:
        faces = part.faces(0)
        wholes.append(part.as_solid(np.arange(len(faces.points_m)), faces.triangles))
    starts = np.cumsum([0, *(len(whole.points_m) for whole in wholes[:-1])])
    return replace(
        wholes[0],
        points_m=np.concatenate([whole.points_m for whole in wholes]),
        cells=np.concatenate([w.cells + start for w, start in zip(wholes, starts, strict=True)]),
        amplitudes=np.concatenate([whole.amplitudes for whole in wholes]),
    )


# Points are nodes of the mesh, or turned into each other, up to this part of its size.
_NEAR = 1e-9


def recovery_modes(operators: BodyOperators, basis: Basis, points_m: FloatArray) -> FloatArray:
    """Displacement of points at θ = 0 and 90° per coordinate, (m, 3, families n)."""
    cyclic = operators.ingredients.kinematics.cyclic
    if cyclic is not None:
        home = len(points_m) // 2
        fields = nodal_amplitudes(operators, basis, points_m[:home])
        copies = (0, quarter_copy(cyclic.sector))
        return np.concatenate([in_copy(fields, cyclic, k) for k in copies])
    if operators.harmonic is None:
        return nodal_amplitudes(operators, basis, points_m)
    radius = np.hypot(points_m[:, 0], points_m[:, 1])
    places = np.column_stack([points_m[:, 2], radius])
    amplitudes = nodal_amplitudes(operators, basis, places)
    return _on_the_round(operators.harmonic, amplitudes, points_m)


def quarter_copy(sector: Sector) -> int:
    """Return the copy of a sector that is nearest to a quarter turn."""
    return round(sector.count / 4)


def in_copy(fields: Matrix, cyclic: CyclicIndex, copy: int) -> FloatArray:
    """Displacement of points in a copy of a sector per real amplitude, (m, 3, families n).

    `fields`: Φ of the points of the first copy, (m, 3, n), Φ1 + iΦ2 also where the field is real.
    """
    angle = 2.0 * np.pi * copy / cyclic.sector.count
    turn = turns(np.array([angle]))[0]
    moved = np.exp(1j * cyclic.index * angle) * fields
    if cyclic.is_real:
        moved = np.cos(cyclic.index * angle) * (fields.real + fields.imag)
        found = moved
    else:  # u = Re[(q1 - i q2) Φ]
        found = np.concatenate([moved.real, moved.imag], axis=2)
    return np.asarray(np.einsum("ij,mjn->min", turn, found))


def nodal_amplitudes(operators: BodyOperators, basis: Basis, places: FloatArray) -> Matrix:
    """Return the values of the basis at nodes of the mesh.

    `places`: (m, 2) z, r on a meridian, (m, 3) x, y, z on a solid or a sector. Result: (m, 3, n):
    amplitudes of one family, displacements, or Φ of a sector, per column of the basis; the same on
    every rank. Raises ReductionError: a place is no node.
    """
    n, comm = basis.vectors.shape[1], operators.comm
    full = operators.coupling.unknowns.displacement(basis.vectors)
    owned = len(full) // 3
    x = operators.space.tabulate_dof_coordinates()[:owned].copy()
    joined = operators.ingredients.kinematics.joined
    if joined is not None:  # copies of a drum lie where it does
        x[joined.copied(operators.space)] = np.finfo(np.float32).max
    size = float(np.abs(places).max(initial=1e-30))
    mine, node = _own_places(x[:, : places.shape[1]], places, _NEAR * size, comm)
    values = np.zeros((len(places), 3, n), dtype=full.dtype)
    values[mine] = full.reshape(owned, 3, n)[node]
    if comm.size > 1:
        comm.Allreduce(MPI.IN_PLACE, values)
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
