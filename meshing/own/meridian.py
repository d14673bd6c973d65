"""Second-order triangles on the meridian of a body of revolution."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import gmsh
import numpy as np

from solidwhirl.geometry import Body, Subdivision, merge_fillets, subdivide
from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.own import drawing as drawn
from solidwhirl.meshing.own.parting import parted
from solidwhirl.meshing.own.quality import doubled_areas, scaled_jacobians, straighten
from solidwhirl.meshing.records import FloatArray, IntArray, LocalSize, Mesh, MeshQuality, MeshSize

#: Elements below this scaled Jacobian are straightened; what stays below is refused.
MINIMUM_SCALED_JACOBIAN = 0.02
# gmsh's numbers of the second-order elements, and their nodes
LINE3, TRIANGLE6, TETRAHEDRON10 = 8, 9, 11
_NODES = {LINE3: 3, TRIANGLE6: 6, TETRAHEDRON10: 10}


def mesh_meridian(body: Body, size: MeshSize, local: LocalSize | None = None) -> Mesh:
    """Mesh the meridian of a body with second-order triangles.

    `body`: the body; its sections become cell sections, its interfaces sets of facets. `local`:
    element sizes over the meridian, in place of those that corners and thicknesses ask for.
    Result: points (z, r) [m]. Raises GeometryError: an invalid body. Raises MeshingError:
    gmsh failed, or elements stay folded.
    """
    subdivision = merge_fillets(subdivide(body))
    unit_m = drawn.drawing_unit_m(subdivision)
    with drawn.gmsh_session():
        drawing = drawn.draw(subdivision, unit_m)
        if local is None:
            drawn.size_fields(body, subdivision, size, list(drawing.faces), unit_m)
        else:
            drawn.local_size_field(local, size, unit_m)
        gmsh.option.setNumber("Mesh.Algorithm", 6)
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(2)
        numbering, points = node_table(unit_m)
        cells, owner = element_blocks(drawing.faces, TRIANGLE6, numbering)
        curves = [element_blocks([tag], LINE3, numbering)[0] for tag in drawing.curves]
    cells, points, used = compact(points[:, [2, 0]], cells)
    points[np.abs(points[:, 1]) < 1e-12 * np.abs(points).max(), 1] = 0.0
    cells = counterclockwise(points, cells)
    points, quality = checked_quality(points, cells, "meridian")
    mesh = Mesh(
        points=points,
        cells=cells,
        cell_section=np.array([subdivision.faces[k].section for k in owner]),
        cell_material=np.array([subdivision.faces[k].material for k in owner]),
        materials=subdivision.materials,
        section_names=subdivision.section_names,
        interfaces={
            name: used[np.vstack([curves[c] for c in indices])]
            for name, indices in subdivision.interfaces.items()
        },
        outline=_outline(subdivision, curves, used),
        size=size,
        quality=quality,
    )
    curves = [used[facets] for facets in curves]
    seats = [
        Seat(
            sections=face.sections,
            facets=np.vstack([curves[c] for c in face.curves]),
            carrying=np.vstack([curves[c] for c in face.seat]),
        )
        for face in subdivision.joints
    ]
    return parted_mesh(mesh, seats)


class Seat(NamedTuple):
    """The common face of two sections that a joint parts, as facets of the mesh."""

    sections: tuple[int, int]
    facets: IntArray  #: (f, 3) all of it
    carrying: IntArray  #: (g, 3) what carries


def parted_mesh(mesh: Mesh, joints: Sequence[Seat]) -> Mesh:
    """Double the nodes of a meridian on the faces of joints."""
    if not joints:
        return mesh
    found = parted(mesh.cells, np.vstack([joint.facets for joint in joints]), len(mesh.points))
    seats = []
    for joint in joints:
        sides = [found.facets(joint.carrying, mesh.cell_section, s) for s in joint.sections]
        seats.append(np.stack(sides, axis=1))
    return replace(
        mesh,
        points=mesh.points[found.node_of],
        cells=found.cells,
        interfaces={name: found.facets(facets) for name, facets in mesh.interfaces.items()},
        outline=found.copies(mesh.outline),
        seats=tuple(seats),
    )


def node_table(unit_m: float) -> tuple[IntArray, FloatArray]:
    """Map from gmsh node tags to rows, and the (n, 3) coordinates [m] of all nodes."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    numbering = np.full(int(tags.max()) + 1, -1, dtype=np.int64)
    numbering[tags.astype(np.int64)] = np.arange(len(tags))
    return numbering, unit_m * coordinates.reshape(-1, 3)


def compact(points: FloatArray, cells: IntArray) -> tuple[IntArray, FloatArray, IntArray]:
    """Drop nodes that no cell uses; returns cells, points and the map from old to new nodes."""
    kept = np.unique(cells)
    used = np.full(len(points), -1, dtype=np.int64)
    used[kept] = np.arange(len(kept))
    return used[cells], points[kept].copy(), used


def checked_quality(
    points: FloatArray, cells: IntArray, where: str
) -> tuple[FloatArray, MeshQuality]:
    """Repair badly curved elements, measure, and refuse what stays folded.

    Raises MeshingError with the place of the worst element.
    """
    points, count = straighten(points, cells, MINIMUM_SCALED_JACOBIAN)
    jacobians = scaled_jacobians(points, cells)
    worst = int(jacobians.argmin())
    if jacobians[worst] <= 0.0:
        place = ", ".join(f"{v:.6g}" for v in points[cells[worst]].mean(axis=0))
        raise MeshingError(
            f"{where} mesh: element at ({place}) m is folded (scaled Jacobian "
            f"{jacobians[worst]:.3g}); choose another element size there"
        )
    return points, MeshQuality(
        minimum_scaled_jacobian=float(jacobians[worst]),
        mean_scaled_jacobian=float(jacobians.mean()),
        straightened_elements=count,
    )


def element_blocks(
    tags: Iterable[int], element: int, numbering: IntArray
) -> tuple[IntArray, IntArray]:
    """Connectivity of one element type on entities, and which entity each row is from.

    Raises MeshingError: an entity has no such elements.
    """
    rows, owner = [], []
    for k, tag in enumerate(tags):
        _, nodes = gmsh.model.mesh.getElementsByType(element, tag)
        if not len(nodes):
            raise MeshingError(f"gmsh made no elements of type {element} on entity {tag}")
        rows.append(numbering[nodes.astype(np.int64)].reshape(-1, _NODES[element]))
        owner.append(np.full(len(rows[-1]), k))
    return np.vstack(rows), np.concatenate(owner)


def counterclockwise(points: FloatArray, cells: IntArray) -> IntArray:
    """Turn the triangles so that (z, r) is positively oriented."""
    signed = doubled_areas(points[cells[:, :3]])
    flipped = cells.copy()
    flipped[signed < 0] = cells[signed < 0][:, [0, 2, 1, 5, 4, 3]]
    return flipped


def _outline(subdivision: Subdivision, curves: list[IntArray], used: IntArray) -> IntArray:
    """Nodes on the boundary of the meridian that do not lie on the axis only."""
    nodes = used[np.unique(np.vstack([curves[c] for c in subdivision.boundary]))]
    return np.asarray(nodes, dtype=np.int64)
