"""The whole circle from the mesh of a sector: turned and mirrored copies, merged."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy

from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.records import FloatArray, IntArray, Mesh
from solidwhirl.rotordyn.core.arrays import BoolArray

# Nodes of the cut faces that are nearer to each other, as a part of the size, are the same.
_SAME = 1e-9
# Order of the nodes of a cell or facet after mirroring it, so that it is oriented as before.
_MIRRORED = {10: [0, 2, 1, 3, 6, 5, 4, 7, 9, 8], 6: [0, 2, 1, 5, 4, 3]}


@dataclass(frozen=True, kw_only=True, eq=False)
class Origin:
    """Where the nodes of the whole are from: of several sectors that share a node the first."""

    node: IntArray  #: (n,) Node of the sector
    copy: IntArray  #: (n,) By how many sectors it is turned
    mirrored: BoolArray  #: (n,) Whether it is mirrored in the plane θ = 0 before


def whole_mesh(mesh: Mesh) -> tuple[Mesh, Origin]:
    """Turn a sector around the axis, to the mesh of the whole solid.

    Returned: the whole, whose outline is that of the first sector, and where its nodes are from.
    Cells and facets follow in the order of the copies, of each the sector and then its mirror
    image. Raises MeshingError: the mesh is no sector, or its cut faces do not match.
    """
    if mesh.sector is None:
        raise MeshingError("the mesh is the whole solid; a sector is needed")
    sector, points = mesh.sector, mesh.points
    halves = range(2 if sector.mirrored else 1)
    number, origin = _numbers(mesh)
    places = np.where(origin.mirrored[:, None], [1.0, -1.0, 1.0], 1.0) * points[origin.node]
    angle = 2.0 * np.pi * origin.copy / sector.count

    def copies(nodes: IntArray) -> IntArray:
        sides = (nodes, nodes[:, _MIRRORED[nodes.shape[1]]])
        return np.vstack([number[k, h][sides[h]] for k in range(sector.count) for h in halves])

    several = sector.count * len(halves)
    whole = replace(
        mesh,
        points=turned(places, angle),
        cells=copies(mesh.cells),
        cell_section=np.tile(mesh.cell_section, several),
        cell_material=np.tile(mesh.cell_material, several),
        interfaces={name: copies(facets) for name, facets in mesh.interfaces.items()},
        outline=number[0, 0][mesh.outline],
        sector=None,
        seats=tuple(np.stack([copies(s[:, k]) for k in range(2)], axis=1) for s in mesh.seats),
    )
    return whole, origin


def turned(points: FloatArray, angle: FloatArray | float) -> FloatArray:
    """Points (n, 3) turned about z by an angle [rad], or by one each."""
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = points.T
    return np.column_stack([c * x - s * y, s * x + c * y, z])


def cut_partners(
    points: FloatArray, count: int, within: float = _SAME
) -> tuple[IntArray, IntArray]:
    """Nodes of the first cut face of a sector, and those of the last that they are turned to.

    `points`: (n, 3) nodes of a sector of 2π/count. `within`: largest distance, as a part of the
    size, of a node from the turned one. Nodes on the axis are on neither list. Of a turn in the
    other sense the faces change places. Half a turn takes each to the other: the first is where
    x > 0.
    """
    scale = float(np.abs(points).max())
    off_axis = np.flatnonzero(np.hypot(points[:, 0], points[:, 1]) > within * scale)
    gap, partner = scipy.spatial.cKDTree(points[off_axis]).query(
        turned(points[off_axis], 2.0 * np.pi / count), distance_upper_bound=within * scale
    )
    first = np.flatnonzero(np.isfinite(gap))
    if count == 2:
        first = first[points[off_axis[first], 0] > 0.0]
    return off_axis[first], off_axis[partner[first]]


def _numbers(mesh: Mesh) -> tuple[IntArray, Origin]:
    """Nodes of the whole by (copy, mirrored, node of the sector), and where they are from."""
    assert mesh.sector is not None
    count, n = mesh.sector.count, len(mesh.points)
    halves = 2 if mesh.sector.mirrored else 1
    every = np.arange(count * halves * n).reshape(count, halves, n)
    x, y = mesh.points[:, 0], mesh.points[:, 1]
    near = _SAME * float(np.abs(mesh.points).max())
    same = every.copy()  # the first of equal nodes
    if mesh.sector.mirrored:
        angle = np.pi / count
        off, along = y * np.cos(angle) - x * np.sin(angle), x * np.cos(angle) + y * np.sin(angle)
        first = (np.abs(y) < near) & (x > -near)
        last = (np.abs(off) < near) & (along > -near)
        same[:, 1, first] = every[:, 0, first]
        same[:, 1, last] = np.roll(every[:, 0, last], 1, axis=0)
    else:
        source, target = cut_partners(mesh.points, count)
        if not len(source):
            raise MeshingError(f"no nodes match when turned by 1/{count} of the circle")
        same[:, 0, target] = np.roll(every[:, 0, source], -1, axis=0)
    same[:, :, np.hypot(x, y) < near] = every[0, 0, np.hypot(x, y) < near]
    kept, number = np.unique(same, return_inverse=True)
    origin = Origin(node=kept % n, copy=kept // (n * halves), mirrored=(kept // n) % halves == 1)
    return number.reshape(same.shape), origin
