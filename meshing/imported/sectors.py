"""One of N equal sectors of a body as its mesh: found in a file, checked, joined to its copies.

A file holds one sector, or the whole, of which one is taken (see `whole`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy

from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.imported.masses import used_nodes
from solidwhirl.meshing.imported.records import FileMesh
from solidwhirl.meshing.imported.split import as_tetrahedra
from solidwhirl.meshing.imported.surface import Faces, faces_of
from solidwhirl.meshing.imported.turning import (
    Cut,
    angles_taken,
    chains,
    cylinder_text,
    inside,
    matched_cut,
    partners,
    size_m,
    tolerance_m,
    turned,
)
from solidwhirl.meshing.imported.whole import sector_of_whole
from solidwhirl.meshing.own.meridian import checked_quality
from solidwhirl.meshing.records import FloatArray, IntArray, MeshQuality

# Points this far before a face of the surface, over its longest edge, are inside a neighbour if
# the face lies on it.
_BEFORE = 1e-3
# Places at which copies are looked for in each other, at most.
_MOST = 2000
# Numbers of sectors that are tried to tell which one a mesh is of.
_TRIED = 400
# Rounds of straightening elements at one cut and their partners, and coordinates that are the same.
_ROUNDS, _ROUNDING = 5, 1e-12
_WHAT_TO_DO = (
    "mesh one sector with nodes of the one cut that are those of the other turned (periodic "
    "faces), or leave sectors out"
)


def one_sector(found: FileMesh, count: int, materials: tuple[str, ...]) -> FileMesh:
    """Take one of `count` sectors from what a file holds, points about z in metres.

    `materials`: groups of elements that have a material of their own. Raises MeshingError: a whole
    that does not consist of equal sectors.
    """
    tetrahedra = as_tetrahedra(found)
    angle = 2.0 * np.pi / count
    middles = tetrahedra.points[tetrahedra.cells[:, :4]].mean(axis=1)
    tolerance = tolerance_m(tetrahedra.points, tetrahedra.cells)
    # a sector takes its angle, more with blades that hang over; the whole all
    if angles_taken(middles) > 0.5 * (angle + 2.0 * np.pi):
        return sector_of_whole(found, tetrahedra, count, tolerance, materials)
    _refuse_masses_on_cuts(found, count, tolerance)
    return found


def _refuse_masses_on_cuts(found: FileMesh, count: int, tolerance: float) -> None:
    """Refuse point masses where sectors meet: a file of one does not say whose they are."""
    nodes = used_nodes(found)
    onto = partners(found.points, nodes, 2.0 * np.pi / count, tolerance)
    shared = {*np.flatnonzero(onto >= 0).tolist(), *onto[onto >= 0].tolist()}
    for mass in found.masses:
        if mass.node in shared:
            raise MeshingError(
                f"sectors = {count}: {mass.label} lies on the cut, where it belongs to two "
                "sectors; move it into the sector, or give a mesh of the whole"
            )


def joined_sector(
    points: FloatArray, cells: IntArray, faces: Faces, count: int, where: str
) -> tuple[FloatArray, Faces, MeshQuality]:
    """Check that copies of a sector make a closed body; put partners at exactly turned places.

    `points`, `cells`, `faces`: its second-order tetrahedra. Result: the points, the faces, of which
    those on the cuts are not outside, and the quality. Raises MeshingError: faces of the cut
    without partner, copies that overlap, or folded elements; `where` names the body.
    """
    tolerance = tolerance_m(points, cells)
    cut = matched_cut(points, faces, count, tolerance)
    if not len(cut.first):
        _refuse_other_count(points, cells, faces, count)
    _refuse_overlaps(points, cells, count)
    _refuse_touching(points, cells, faces, cut, count)
    if not len(cut.first):
        raise MeshingError(_far_apart(points, cells, faces, count))
    _refuse_other_middles(points, cut, count, tolerance)
    points = points.copy()
    points[np.hypot(points[:, 0], points[:, 1]) <= tolerance, :2] = 0.0
    points = _with_partners(points, cut, count)
    straightened = 0
    for _ in range(_ROUNDS):
        better, quality = checked_quality(points, cells, where)
        straightened += quality.straightened_elements
        before, points = points, _straightened_alike(points, better, cut, count)
        if np.abs(points - before).max() <= _ROUNDING * size_m(points):
            break
    return points, outer(faces, cut), replace(quality, straightened_elements=straightened)


def _with_partners(points: FloatArray, cut: Cut, count: int) -> FloatArray:
    """Points with those of the second cut where those of the first are when turned."""
    root, turns = chains(cut.onto)
    out = points.copy()
    for k in range(1, int(turns.max()) + 1):
        out[turns == k] = turned(points[root[turns == k]], 2.0 * np.pi * k / count)
    return out


def _straightened_alike(before: FloatArray, points: FloatArray, cut: Cut, count: int) -> FloatArray:
    """Points in which middles of edges on one cut were moved, moved on the other cut as well."""
    points = points.copy()
    moved = (points != before).any(axis=1)
    first = np.flatnonzero((cut.onto >= 0) & ~moved)
    first = first[moved[cut.onto[first]]]
    points[first] = turned(points[cut.onto[first]], -2.0 * np.pi / count)
    return _with_partners(points, cut, count)


def outer(faces: Faces, cut: Cut) -> Faces:
    """The faces of a sector, of which those on its cuts are not on the surface of the body."""
    outside = faces.outside.copy()
    outside[cut.first] = outside[cut.second] = False
    return replace(faces, outside=outside)


def outer_facets(points: FloatArray, cells: IntArray, count: int | None) -> IntArray:
    """Facets (f, 6) of the surface of a body, on its mesh.

    `count`: sectors of the body, whose mesh is one of them; None: the mesh is the whole.
    """
    faces = faces_of(cells)
    if count is not None:
        faces = outer(faces, matched_cut(points, faces, count, tolerance_m(points, cells)))
    return np.asarray(faces.nodes[faces.outside])


def _refuse_touching(
    points: FloatArray, cells: IntArray, faces: Faces, cut: Cut, count: int
) -> None:
    """Refuse faces without partner that have the next sector right before them."""
    rows = np.flatnonzero(outer(faces, cut).outside)
    corner = points[faces.nodes[rows][:, :3]]
    edges = corner - np.roll(corner, 1, axis=1)
    longest = np.linalg.norm(edges, axis=2).max(axis=1)
    normal = np.cross(edges[:, 1], edges[:, 2])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    before = corner.mean(axis=1) + _BEFORE * longest[:, None] * normal
    lost = np.zeros(len(rows), dtype=bool)
    for angle in (2.0 * np.pi / count, -2.0 * np.pi / count):
        lost |= inside(points, cells, turned(before, angle))
    if not lost.any():
        return
    own = np.unique(faces.nodes[rows[lost]][:, :3])
    gaps = _gaps(points, own, np.unique(faces.nodes[faces.outside][:, :3]), count)
    worst = points[own[gaps.argmax()]]
    if gaps.max() <= tolerance_m(points, cells):
        place = cylinder_text(points[faces.nodes[rows[lost][0], :3]].mean(axis=0))
        raise MeshingError(
            f"sectors = {count}: the nodes of the cuts match, but {int(lost.sum())} of their faces "
            "are other triangles on the two sides, with middles of edges that the other side has "
            f"not, the first about {place}. Mesh the cuts as periodic faces, or with hexahedra or "
            "wedges, which are cut alike here"
        )
    raise MeshingError(
        f"sectors = {count}: {int(lost.sum())} faces of the cut have no partner among those of the "
        f"next sector ({len(cut.first)} have one). Turned by {360.0 / count:.6g}° one way or the "
        f"other, the node at {cylinder_text(worst)} lies {gaps.max():.3g} m from the nearest of "
        f"the surface (allowed {tolerance_m(points, cells):.2g} m); {_WHAT_TO_DO}"
    )


def _refuse_overlaps(points: FloatArray, cells: IntArray, count: int) -> None:
    middles = points[cells[:, :4]].mean(axis=1)
    some = middles[:: -(-len(middles) // _MOST)]
    for k in range(1, min(count - 1, 3) + 1):
        over = inside(points, cells, turned(some, 2.0 * np.pi * k / count))
        if over.any():
            raise MeshingError(
                f"sectors = {count}: copies turned by {360.0 * k / count:.6g}° overlap, the first "
                f"at {cylinder_text(some[over][0])}, {100.0 * over.mean():.2g} % of the elements: "
                "the cut faces match the wrong way round, the file holds more than one sector, or "
                "blades run through each other"
            )


def _refuse_other_middles(points: FloatArray, cut: Cut, count: int, tolerance: float) -> None:
    first = np.flatnonzero(cut.onto >= 0)
    gap = np.linalg.norm(
        turned(points[first], 2.0 * np.pi / count) - points[cut.onto[first]], axis=1
    )
    far, worst = int((gap > tolerance).sum()), int(gap.argmax())
    if far:
        raise MeshingError(
            f"sectors = {count}: the corners of the cut faces match, but {far} "
            f"middle nodes do not, the worst at {cylinder_text(points[first[worst]])} by "
            f"{gap[worst]:.3g} m; {_WHAT_TO_DO}"
        )


def _refuse_other_count(points: FloatArray, cells: IntArray, faces: Faces, count: int) -> None:
    """Refuse a mesh whose faces match when turned by another angle."""
    tolerance = tolerance_m(points, cells)
    for other in sorted(range(3, _TRIED), key=lambda n: abs(n - count)):
        matched = len(matched_cut(points, faces, other, tolerance).first)
        if matched:
            raise MeshingError(
                f"{_no_match(points, cells, count)}. Turned by {360.0 / other:.6g}°, {matched} "
                f"faces do: is sectors = {other} meant, or is the file half a sector or several?"
            )


def _far_apart(points: FloatArray, cells: IntArray, faces: Faces, count: int) -> str:
    nodes = np.unique(faces.nodes[faces.outside][:, :3])
    nodes = nodes[np.hypot(points[nodes, 0], points[nodes, 1]) > tolerance_m(points, cells)]
    gaps = _gaps(points, nodes, nodes, count)
    nearest = points[nodes[gaps.argmin()]]
    return (
        f"{_no_match(points, cells, count)}. The node that comes nearest to another, at "
        f"{cylinder_text(nearest)}, stays {gaps.min():.3g} m away; check axis and unit, "
        f"{_WHAT_TO_DO}"
    )


def _no_match(points: FloatArray, cells: IntArray, count: int) -> str:
    taken = np.degrees(angles_taken(points[cells[:, :4]].mean(axis=1)))
    return (
        f"sectors = {count}: no face of the surface, turned by {360.0 / count:.6g}° about the "
        f"axis, lies on another; the mesh takes about {taken:.3g}° around"
    )


def _gaps(points: FloatArray, nodes: IntArray, others: IntArray, count: int) -> FloatArray:
    """Distance of nodes, turned one way or the other, from the nearest of others, (n,)."""
    tree, angle = scipy.spatial.cKDTree(points[others]), 2.0 * np.pi / count
    found = [tree.query(turned(points[nodes], a))[0] for a in (angle, -angle)]
    return np.asarray(np.min(found, axis=0))
