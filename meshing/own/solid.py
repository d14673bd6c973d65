"""Second-order tetrahedra of the whole solid, symmetric under quarter turns.

One quarter is meshed with matching cut faces, turned four times and merged. The mesh is then
unchanged by a quarter turn, so the double modes of a body of revolution stay double to solver
precision; an unstructured mesh of the whole body would split them.
"""

from __future__ import annotations

from dataclasses import dataclass

import gmsh
import numpy as np
import scipy

from solidwhirl.geometry import Body, Subdivision, merge_fillets, subdivide
from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.own import meridian as plane_mesh
from solidwhirl.meshing.own.drawing import Drawing, draw, drawing_unit_m, gmsh_session, size_fields
from solidwhirl.meshing.records import FloatArray, IntArray, Mesh, MeshSize

# A quarter turn about z: (x, y) -> (-y, x), exact in floating point.
_QUARTER_TURN = (0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Quarter:
    """Mesh of 0 <= θ <= 90° and what lies where."""

    points: FloatArray
    cells: IntArray
    owner: IntArray
    interfaces: dict[str, IntArray]


def mesh_solid(body: Body, size: MeshSize) -> Mesh:
    """Mesh a body of revolution with second-order tetrahedra.

    `body`: the body; its sections become cell sections, its interfaces sets of facets. Returned:
    with points (x, y, z) [m]; unchanged by a quarter turn about z. Raises GeometryError: an invalid
    body. Raises MeshingError: gmsh failed, the cut faces do not match, or elements stay folded.
    """
    subdivision = merge_fillets(subdivide(body))
    with gmsh_session():
        quarter = _mesh_quarter(body, subdivision, size)
    points, cells, turned = _turn_four_times(quarter.points, quarter.cells)
    points, quality = plane_mesh.checked_quality(points, cells, "solid")
    owner = np.tile(quarter.owner, 4)
    return Mesh(
        points=points,
        cells=cells,
        cell_section=np.array([subdivision.faces[k].section for k in owner]),
        cell_material=np.array([subdivision.faces[k].material for k in owner]),
        materials=subdivision.materials,
        section_names=subdivision.section_names,
        interfaces={
            name: np.vstack([turned[q][facets] for q in range(4)])
            for name, facets in quarter.interfaces.items()
        },
        outline=_outline(subdivision, points),
        size=size,
        quality=quality,
    )


def _mesh_quarter(body: Body, subdivision: Subdivision, size: MeshSize) -> _Quarter:
    """Sweep the meridian by 90° and mesh it with matching cut faces."""
    unit_m = drawing_unit_m(subdivision)
    drawing = draw(subdivision, unit_m)
    swept = gmsh.model.occ.revolve(
        [(2, tag) for tag in drawing.faces], 0, 0, 0, 0, 0, 1, np.pi / 2.0
    )
    gmsh.model.occ.synchronize()
    volumes = [tag for dim, tag in swept if dim == 3]
    if len(volumes) != len(drawing.faces):
        raise MeshingError(f"{len(drawing.faces)} faces swept to {len(volumes)} volumes")
    _match_cut_faces(drawing)
    size_fields(body, subdivision, size, volumes, unit_m)
    gmsh.option.setNumber("Mesh.Algorithm", 6)
    gmsh.option.setNumber("Mesh.Algorithm3D", 1)
    gmsh.option.setNumber("Mesh.Optimize", 1)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.optimize("Netgen")
    gmsh.model.mesh.setOrder(2)
    numbering, points = plane_mesh.node_table(unit_m)
    tetrahedra, owner = plane_mesh.element_blocks(volumes, plane_mesh.TETRAHEDRON10, numbering)
    facets = _facets_of_curves(subdivision, numbering, points)
    cells, points, used = plane_mesh.compact(points, tetrahedra)
    interfaces = {
        name: used[np.vstack([facets[c] for c in indices])]
        for name, indices in subdivision.interfaces.items()
    }
    return _Quarter(points=points, cells=cells, owner=owner, interfaces=interfaces)


def _match_cut_faces(drawing: Drawing) -> None:
    """Tell gmsh that the cut at θ = 90° is a quarter turn of the cut at θ = 0."""
    centre = {tag: np.array(gmsh.model.occ.getCenterOfMass(2, tag)) for tag in drawing.faces}
    area = {tag: gmsh.model.occ.getMass(2, tag) for tag in drawing.faces}
    scale = max(float(np.abs(c).max()) for c in centre.values())
    others = {}
    for _, tag in gmsh.model.getEntities(2):
        c = np.array(gmsh.model.occ.getCenterOfMass(2, tag))
        if tag not in centre and abs(c[0]) < 1e-8 * scale:
            others[tag] = (c, gmsh.model.occ.getMass(2, tag))
    targets, sources = [], []
    for source in drawing.faces:
        x, y, z = centre[source]
        turned = np.array([-y, x, z])
        found = [
            t
            for t, (c, a) in others.items()
            if np.linalg.norm(c - turned) < 1e-7 * scale and abs(a - area[source]) < 1e-7 * a
        ]
        if len(found) != 1:
            raise MeshingError(f"cut face at z = {z:.6g} m has {len(found)} counterparts")
        sources.append(source)
        targets.append(found[0])
    gmsh.model.mesh.setPeriodic(2, targets, sources, list(_QUARTER_TURN))


def _facets_of_curves(
    subdivision: Subdivision, numbering: IntArray, points: FloatArray
) -> dict[int, IntArray]:
    """Triangles on the surface swept by every curve that an interface needs."""
    wanted = sorted({c for curves in subdivision.interfaces.values() for c in curves})
    scale = float(np.abs(subdivision.points).max())
    found: dict[int, list[IntArray]] = {c: [] for c in wanted}
    for _, tag in gmsh.model.getEntities(2):
        triangles, _ = plane_mesh.element_blocks([tag], plane_mesh.TRIANGLE6, numbering)
        x = points[np.unique(triangles[:, :3])]
        if np.abs(x[:, 0]).max() < 1e-9 * scale or np.abs(x[:, 1]).max() < 1e-9 * scale:
            continue  # a cut face
        meridian = np.column_stack([x[:, 2], np.hypot(x[:, 0], x[:, 1])])
        for c in wanted:
            if distance_to_curve(subdivision, c, meridian) < 1e-7 * scale:
                found[c].append(triangles)
    for c, blocks in found.items():
        if not blocks:
            z, r = subdivision.points[subdivision.curves[c].start]
            raise MeshingError(f"no facets on the interface at z = {z:.6g}, r = {r:.6g} m")
    return {c: np.vstack(blocks) for c, blocks in found.items()}


def distance_to_curve(subdivision: Subdivision, index: int, points: FloatArray) -> float:
    """Largest distance of meridian points from a curve."""
    curve = subdivision.curves[index]
    a, b = subdivision.points[curve.start], subdivision.points[curve.end]
    if curve.centre is not None:
        centre = subdivision.points[curve.centre]
        radius = np.linalg.norm(a - centre)
        return float(np.abs(np.linalg.norm(points - centre, axis=1) - radius).max())
    t = np.clip((points - a) @ (b - a) / np.dot(b - a, b - a), 0.0, 1.0)
    return float(np.linalg.norm(points - (a + t[:, None] * (b - a)), axis=1).max())


def _turn_four_times(
    points: FloatArray, cells: IntArray
) -> tuple[FloatArray, IntArray, list[IntArray]]:
    """Turn the quarter four times and merge the nodes of the cut faces.

    Returns the points, the cells, and for every quarter the map from its nodes to the merged.
    """
    scale = float(np.abs(points).max())
    tolerance = 1e-9 * scale
    points = np.where(np.abs(points) < tolerance, 0.0, points)
    axis = np.flatnonzero((points[:, 0] == 0) & (points[:, 1] == 0))
    first = np.flatnonzero((points[:, 1] == 0) & (points[:, 0] > 0))
    last = np.flatnonzero((points[:, 0] == 0) & (points[:, 1] > 0))
    partner = _partners(points[first][:, [0, 2]], points[last][:, [1, 2]], scale)
    n, m = len(points), len(points) - len(last) - len(axis)
    own = np.setdiff1d(np.arange(n), np.concatenate([axis, last]))
    maps = []
    for q in range(4):
        new = np.full(n, -1, dtype=np.int64)
        new[own] = q * m + np.arange(m)
        new[axis] = 4 * m + np.arange(len(axis))
        maps.append(new)
    for q in range(4):
        maps[q][last] = maps[(q + 1) % 4][first[partner]]
    merged = np.empty((4 * m + len(axis), 3))
    merged[4 * m :] = points[axis]
    x, y, z = points[own].T
    for q, (cx, cy) in enumerate(((x, y), (-y, x), (-x, -y), (y, -x))):
        merged[q * m : (q + 1) * m] = np.column_stack([cx, cy, z])
    return merged, np.vstack([maps[q][cells] for q in range(4)]), maps


def _partners(first: FloatArray, last: FloatArray, scale: float) -> IntArray:
    """For every node of the last cut the node of the first cut that it is a turn of."""
    if len(first) != len(last):
        raise MeshingError(f"cut faces do not match: {len(first)} and {len(last)} nodes")
    gap, partner = (
        scipy.spatial.cKDTree(first).query(last) if len(last) else (np.zeros(1), np.array([], int))
    )
    if gap.max() > 1e-7 * scale or len(np.unique(partner)) != len(last):
        raise MeshingError(f"cut faces do not match: nodes are {gap.max():.3g} m apart")
    return np.asarray(partner, dtype=np.int64)


def _outline(subdivision: Subdivision, points: FloatArray) -> IntArray:
    """Nodes of the cut at θ = 0 that lie on the boundary of the meridian."""
    scale = float(np.abs(points).max())
    cut = np.flatnonzero((points[:, 1] == 0) & (points[:, 0] >= 0))
    meridian = np.column_stack([points[cut, 2], points[cut, 0]])
    on = np.zeros(len(cut), dtype=bool)
    for c in subdivision.boundary:
        for k in np.flatnonzero(~on):
            on[k] = distance_to_curve(subdivision, c, meridian[k : k + 1]) < 1e-7 * scale
    return np.asarray(cut[on])
