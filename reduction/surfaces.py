"""The outer surface of a meshed body with its displacement per coordinate of the superelement."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from solidwhirl.meshing import Mesh
from solidwhirl.meshing.user_mesh_records import AnyBody
from solidwhirl.reduction.craig_bampton import Basis
from solidwhirl.reduction.operators import BodyOperators
from solidwhirl.reduction.recovery import nodal_amplitudes
from solidwhirl.reduction.superelements import ReducedBlock, joined_order
from solidwhirl.rotordyn.surface import Surface

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
# Edges this near to the axis, in parts of the largest radius, lie on it and are no surface.
_ON_AXIS = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class SurfaceMesh:
    """Corners of the elements on the boundary, and the facets between them.

    Attributes
    ----------
    points_m
        (p, 2) z, r of a meridian without its axis, (p, 3) x, y, z of a solid.
    cells
        (c, 2) edges or (c, 3) triangles, outward normals to the right of an edge.
    """

    points_m: FloatArray
    cells: IntArray


def surface_mesh(mesh: Mesh) -> SurfaceMesh:
    """Return the boundary of a mesh, facets of elements that have no neighbour there.

    Parameters
    ----------
    mesh
        Meridian or solid.
    """
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


def surface_amplitudes(operators: BodyOperators, basis: Basis, outline: SurfaceMesh) -> FloatArray:
    """Return the amplitudes (p, 3, n) of the surface's points per column of one order's basis.

    Parameters
    ----------
    operators, basis
        Of one body and order.
    outline
        Its surface.
    """
    return nodal_amplitudes(operators, basis, outline.points_m)


def joined_surface(
    body: AnyBody,
    outline: SurfaceMesh,
    harmonics: tuple[int, ...],
    blocks: tuple[ReducedBlock, ...],
    amplitudes: tuple[FloatArray, ...],
) -> Surface:
    """Join the surfaces of all orders in the coordinates of the superelement.

    Parameters
    ----------
    body
        For the order of its interfaces.
    outline
        The body's surface.
    harmonics
        Circumferential orders; empty for a solid.
    blocks, amplitudes
        Of every order, see `surface_amplitudes`.
    """
    place = np.argsort(joined_order(body, [c for b in blocks for c in b.coordinates]))
    moved, coordinate, order_of, family_of, start = [], [], [], [], 0
    for k, (block, values) in enumerate(zip(blocks, amplitudes, strict=True)):
        columns, count = values.shape[2], len(block.coordinates)
        own = block.order  # column of the stacked families that each coordinate is
        if count:
            moved.append(values[:, :, own % columns] * block.signs[own])
        coordinate.append(place[start : start + count])
        order_of.append(np.full(count, harmonics[k] if harmonics else 0))
        family_of.append(own // max(columns, 1))
        start += count
    return Surface(
        points_m=outline.points_m,
        cells=outline.cells,
        amplitudes=np.concatenate(moved, axis=2),
        coordinate=np.concatenate(coordinate),
        order=np.concatenate(order_of),
        family=np.concatenate(family_of),
        size=start,
    )
