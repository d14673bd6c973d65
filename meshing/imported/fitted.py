"""A geometry of revolution whose solids are joined: its meridian, parted there, and revolved."""

from __future__ import annotations

import numpy as np
import scipy

from solidwhirl.geometry import Joint
from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.imported.groups import as_written, cell_materials, names_text, sections_of
from solidwhirl.meshing.imported.records import FileMesh, MeshInterface, MeshRequest
from solidwhirl.meshing.own.meridian import (
    Seat,
    checked_quality,
    compact,
    counterclockwise,
    parted_mesh,
)
from solidwhirl.meshing.own.revolved import revolved
from solidwhirl.meshing.records import FloatArray, IntArray, Mesh, MeshSize

# Edges of a triangle with six nodes, and coordinates that are the same, over the body's size.
_EDGES = np.array([[0, 1, 3], [1, 2, 4], [2, 0, 5]])
_SAME = 1e-9


def fitted_mesh(found: FileMesh, request: MeshRequest, name: str) -> Mesh:
    """Mesh half of a sector of a body of revolution with joints between its solids.

    `found`: second-order triangles on a half-plane through the axis, and its edges, on the axis
    [m]. Raises MeshingError: solids that do not hang together, no common face of a joint, or an
    interface without surface.
    """
    assert request.step is not None
    points = np.column_stack([found.points[:, 2], np.hypot(*found.points[:, :2].T)])
    cells, points, used = compact(points, found.blocks[0].nodes)
    tiny = _SAME * float(np.abs(points).max())
    points[points[:, 1] < tiny, 1] = 0.0
    cells = counterclockwise(points, cells)
    points, quality = checked_quality(points, cells, f"body {name!r}: meridian")
    groups = {group: own[0] for group, own in found.element_groups.items() if 0 in own}
    material, materials = cell_materials(request, groups, len(cells))
    section, names = sections_of(groups, len(cells))
    _refuse_apart(cells, section, names)
    edges, beside = _edges_of(cells)
    outside = edges[(beside[:, 1] < 0) & points[edges[:, :2], 1].any(axis=1)]
    corner = np.linalg.norm(np.diff(points[edges[:, :2]], axis=1), axis=2)
    mesh = Mesh(
        points=points,
        cells=cells,
        cell_section=section,
        cell_material=material,
        materials=materials,
        section_names=names,
        interfaces={i.name: _surface(found, used, points, outside, i) for i in request.interfaces},
        outline=np.unique(outside),
        size=MeshSize(
            size_m=float(corner.max()),
            corner_size_m=float(corner.min()),
            around=request.step.around,
        ),
        quality=quality,
    )
    pairs = [tuple(names.index(as_written(n, names)) for n in j.between) for j in request.joints]
    sides = np.where(beside < 0, -1, section[beside])
    return revolved(
        parted_mesh(
            mesh,
            [
                _seat(joint, edges[(np.sort(sides) == sorted(pair)).all(axis=1)], pair, points)
                for joint, pair in zip(request.joints, pairs, strict=True)
            ],
        )
    )


def _seat(joint: Joint, facets: IntArray, pair: tuple[int, ...], points: FloatArray) -> Seat:
    """The common face of two solids; an interference is carried by its cylinders alone."""
    if not len(facets):
        raise MeshingError(f"{joint.where}: the two solids do not touch")
    carrying, r = facets, points[facets[:, :2], 1]
    if joint.interference_m is not None:
        carrying = facets[np.ptp(r, axis=1) <= _SAME * float(np.abs(points).max())]
    if not len(carrying):
        raise MeshingError(
            f"{joint.where}: interference_m presses cylinders, and no part of their common face, "
            f"r from {r.min():.6g} to {r.max():.6g} m, is one"
        )
    return Seat(sections=(pair[0], pair[1]), facets=facets, carrying=carrying)


def _edges_of(cells: IntArray) -> tuple[IntArray, IntArray]:
    """All edges (e, 3) of second-order triangles, and the cells beside each (e, 2), -1: none."""
    every, cell = cells[:, _EDGES].reshape(-1, 3), np.repeat(np.arange(len(cells)), 3)
    _, first, count = np.unique(every[:, 2], return_index=True, return_counts=True)
    _, last = np.unique(every[::-1, 2], return_index=True)
    other = np.where(count > 1, cell[len(every) - 1 - last], -1)
    return every[first], np.column_stack([cell[first], other])


def _surface(
    found: FileMesh, used: IntArray, points: FloatArray, outside: IntArray, asked: MeshInterface
) -> IntArray:
    """Edges (f, 3) of an interface: of a label, or those whose whole ring lies in a box."""
    where = f"interface {asked.name!r}"
    if asked.box_m is not None:
        (x, y, z), (to_x, to_y, to_z) = asked.box_m
        more = asked.margin * float(np.abs(points).max())
        inside = (points[:, 0] >= z - more) & (points[:, 0] <= to_z + more)
        inside &= points[:, 1] <= min(-x, to_x, -y, to_y) + more
        rows = outside[inside[outside[:, :2]].all(axis=1)]
        if not len(rows):
            (low, _), (high, reach) = points.min(axis=0), points.max(axis=0)
            raise MeshingError(
                f"{where}: no ring of the surface lies in the box, whole; the body reaches from z "
                f"= {low:.6g} to {high:.6g} m, to r = {reach:.6g} m"
            )
        return np.asarray(rows)
    assert asked.group is not None
    known = {group: own[1] for group, own in found.element_groups.items() if 1 in own}
    group = as_written(asked.group, known)
    if group not in known:
        raise MeshingError(
            f"{where}: the file has no group {group!r} of faces; it has {names_text(known)}"
        )
    middles = used[found.blocks[1].nodes[known[group]][:, 2]]
    rows = outside[np.isin(outside[:, 2], middles)]
    if len(rows) < len(middles):
        raise MeshingError(f"{where}: faces of group {group!r} lie inside the body, on a joint")
    return np.asarray(rows)


def _refuse_apart(cells: IntArray, section: IntArray, names: tuple[str, ...]) -> None:
    """Refuse solids that do not hang together by what they touch."""
    ends = cells[:, _EDGES[:, :2]].reshape(-1, 2)
    graph = scipy.sparse.coo_matrix((np.ones(len(ends)), ends.T), shape=(cells.max() + 1,) * 2)
    _, part = scipy.sparse.csgraph.connected_components(graph, directed=False)
    apart = np.flatnonzero(part[cells[:, 0]] != part[cells[0, 0]])
    if len(apart):
        first, other = names[section[0]], names[section[apart[0]]]
        raise MeshingError(f"solids {first!r} and {other!r} do not hang together")
