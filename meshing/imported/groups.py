"""Groups of a file on its tetrahedra: materials of cells, facets of interfaces."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from solidwhirl.geometry import Material
from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.imported.records import FileMesh, MeshInterface, MeshRequest
from solidwhirl.meshing.imported.split import Tetrahedra
from solidwhirl.meshing.imported.surface import Faces
from solidwhirl.meshing.imported.turning import turned
from solidwhirl.meshing.records import FloatArray, IntArray

BoolArray = np.ndarray[tuple[int], np.dtype[np.bool_]]
# Corners of the surface elements of a file.
_SURFACE = {"triangle": 3, "triangle6": 3, "triangle7": 3, "quad": 4, "quad8": 4, "quad9": 4}
_MOST_NAMED = 20


def volume_groups(mesh: FileMesh, tetrahedra: Tetrahedra) -> dict[str, IntArray]:
    """Cells of every group that has volume elements.

    `mesh`, `tetrahedra`: a file and what became of its elements.
    """
    volume = {int(k) for k in np.unique(tetrahedra.block)}
    out = {}
    for name, blocks in mesh.element_groups.items():
        chosen = np.zeros(len(tetrahedra.cells), dtype=bool)
        for k, rows in blocks.items():
            if k in volume and len(rows):
                inside = np.zeros(len(mesh.blocks[k].nodes), dtype=bool)
                inside[rows] = True
                own = tetrahedra.block == k
                chosen[own] = inside[tetrahedra.row[own]]
        if chosen.any():
            out[name] = np.flatnonzero(chosen)
    return out


def cell_materials(
    request: MeshRequest, groups: Mapping[str, IntArray], count: int
) -> tuple[IntArray, tuple[Material, ...]]:
    """Material number of every cell, and the materials.

    Raises MeshingError: a group that the file has not, cells with two materials or none.
    """
    materials: list[Material] = []
    out = np.full(count, -1, dtype=np.int64)
    for asked, material in request.materials:
        group = as_written(asked, groups)
        if group not in groups:
            raise MeshingError(
                f"materials: the file has no group {group!r} of volume elements; it has "
                f"{names_text(groups)}"
            )
        if material not in materials:
            materials.append(material)
        number, cells = materials.index(material), groups[group]
        other = out[cells][(out[cells] >= 0) & (out[cells] != number)]
        if len(other):
            raise MeshingError(
                f"materials: group {group!r} is {material.name!r}, but {len(other)} of its "
                f"elements are {materials[other[0]].name!r} by another group"
            )
        out[cells] = number
    if (out < 0).any():
        if request.material is None:
            raise MeshingError(
                f"materials: {int(np.sum(out < 0))} of {count} elements are in none of the groups "
                "given; give material for the rest"
            )
        if request.material not in materials:
            materials.append(request.material)
        out[out < 0] = materials.index(request.material)
    return out, tuple(materials)


def sections_of(groups: dict[str, IntArray], count: int) -> tuple[IntArray, tuple[str, ...]]:
    """Return the first group of every cell, as the sections of a mesh."""
    section = np.full(count, -1, dtype=np.int64)
    names: list[str] = []
    for name, cells in groups.items():
        own = cells[section[cells] < 0]
        if len(own):
            section[own] = len(names)
            names.append(name)
    if (section < 0).any():
        section[section < 0] = len(names)
        names.append("other" if names else "body")
    return section, tuple(names)


def interface_facets(
    mesh: FileMesh,
    tetrahedra: Tetrahedra,
    points: FloatArray,
    faces: Faces,
    interface: MeshInterface,
    sectors: int | None = None,
) -> IntArray:
    """Find the facets (f, 6) of an interface by its group or box; points on their axis [m].

    `sectors`: of how many sectors the mesh is one; a facet belongs to a box if a copy does. Raises
    MeshingError: the file has no such group, or nothing of the mesh belongs to it, or facets where
    the next sector joins.
    """
    where = f"interface {interface.name!r}"
    if interface.box_m is not None:
        rows = np.flatnonzero(faces.outside)
        rows = rows[in_box(points, faces.nodes[rows], interface, sectors)]
        if not len(rows):
            low, high = points.min(axis=0), points.max(axis=0)
            raise MeshingError(
                f"{where}: no facet of the surface lies in the box; on its axis the mesh reaches "
                f"from {_numbers(low)} to {_numbers(high)} m"
            )
    else:
        assert interface.group is not None
        known = [*mesh.element_groups, *mesh.face_groups, *mesh.node_groups]
        rows = _of_group(mesh, tetrahedra, faces, as_written(interface.group, known), where)
        between = ~faces.outside[rows] & (faces.cells[rows, 1] < 0)
        if between.any():
            raise MeshingError(
                f"{where}: {int(between.sum())} of {len(rows)} facets of group "
                f"{interface.group!r} lie on the cut faces, where the next sector joins"
            )
    return np.asarray(faces.nodes[rows])


def in_box(
    points: FloatArray, facets: IntArray, interface: MeshInterface, sectors: int | None = None
) -> BoolArray:
    """Whether facets (f, 6) or (f, 3), or copies, are in a box with all corners, (f,)."""
    corner, size = points[facets[:, :3]], float(np.abs(points).max())
    out = np.zeros(len(facets), dtype=bool)
    for k in range(sectors or 1):
        copy = turned(corner.reshape(-1, 3), 2.0 * np.pi * k / (sectors or 1))
        out |= points_in_box(copy, interface, size).reshape(-1, 3).all(axis=1)
    return out


def points_in_box(points: FloatArray, interface: MeshInterface, size_m: float) -> BoolArray:
    """Whether points (n, 3) lie in the box of an interface, (n,)."""
    assert interface.box_m is not None
    low, high = (np.array(corner) for corner in interface.box_m)
    margin = interface.margin * size_m
    return np.asarray(((points >= low - margin) & (points <= high + margin)).all(axis=1))


def _of_group(
    mesh: FileMesh, tetrahedra: Tetrahedra, faces: Faces, group: str, where: str
) -> IntArray:
    corners: list[IntArray] = []
    for k, chosen in mesh.element_groups.get(group, {}).items():
        kind = mesh.blocks[k].kind
        if kind in _SURFACE:
            corners.append(mesh.blocks[k].nodes[chosen][:, : _SURFACE[kind]])
    corners += mesh.face_groups.get(group, ())
    if corners:
        found = [_rows(tetrahedra, faces, own, where, group) for own in corners]
        return np.unique(np.concatenate(found))
    if group in mesh.node_groups:
        chosen = np.zeros(len(tetrahedra.corner_row), dtype=bool)
        chosen[mesh.node_groups[group]] = True
        around, middle = tetrahedra.of_faces[:, :4], tetrahedra.of_faces[:, 4]
        chosen[middle[chosen[around].all(axis=1)]] = True
        rows = tetrahedra.corner_row[chosen]
        belongs = np.zeros(len(tetrahedra.points), dtype=bool)
        belongs[rows[rows >= 0]] = True
        on = np.flatnonzero(faces.outside & belongs[faces.nodes[:, :3]].all(axis=1))
        if not len(on):
            raise MeshingError(
                f"{where}: no facet of the surface has all its corners in the node group {group!r}"
            )
        return on
    raise MeshingError(f"{where}: {_no_group(mesh, group)}")


def _rows(
    tetrahedra: Tetrahedra, faces: Faces, corners: IntArray, where: str, group: str
) -> IntArray:
    """Faces of the mesh that make up the elements of a surface: triangles, halves, quarters."""
    given, corners = corners, tetrahedra.corner_row[corners]
    if corners.shape[1] == 3:
        rows = faces.rows_of(corners)
        lost = rows < 0
        if not lost.any():
            return rows
    else:
        cuts = [faces.rows_of(corners[:, c]) for c in ([0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3])]
        first = (cuts[0] >= 0) & (cuts[1] >= 0)
        second = (cuts[2] >= 0) & (cuts[3] >= 0)
        one, two = np.where(first, cuts[0], cuts[2]), np.where(first, cuts[1], cuts[3])
        halves, lost = first | second, ~first & ~second
        middles = {tuple(own[:4]): own[4] for own in tetrahedra.of_faces.tolist()}
        quarters = []
        for k in np.flatnonzero(lost):
            middle = middles.get(tuple(sorted(given[k].tolist())))
            if middle is not None:
                place = tetrahedra.corner_row[middle]
                own = [[corners[k, i], corners[k, (i + 1) % 4], place] for i in range(4)]
                quarters += faces.rows_of(np.array(own)).tolist()
                lost[k] = False
        if not lost.any() and -1 not in quarters:
            return np.concatenate([one[halves], two[halves], np.array(quarters, dtype=np.int64)])
    raise MeshingError(
        f"{where}: {int(lost.sum())} of {len(lost)} surface elements of group {group!r} are no "
        "faces of volume elements"
    )


def _no_group(mesh: FileMesh, group: str) -> str:
    known = [
        name
        for name, blocks in mesh.element_groups.items()
        if any(mesh.blocks[k].kind in _SURFACE for k in blocks)
    ]
    if group in mesh.element_groups:
        return (
            f"group {group!r} has no surface elements, only others; groups of surface elements, "
            f"faces or nodes are {names_text([*known, *mesh.face_groups, *mesh.node_groups])}"
        )
    return (
        f"the file has no group {group!r} of surface elements, faces or nodes; it has "
        f"{names_text([*known, *mesh.face_groups, *mesh.node_groups])}"
    )


def as_written(group: str, known: Iterable[str]) -> str:
    """Return the name that a file has for a group, whose capitals alone may differ."""
    names = list(known)
    alike = {name for name in names if name.casefold() == group.casefold()}
    return alike.pop() if group not in names and len(alike) == 1 else group


def names_text(names: Mapping[str, object] | list[str]) -> str:
    """Names for a message, no more than a few lines of them."""
    shown = [ascii(name)[:80] for name in sorted(names)]
    more = len(shown) - _MOST_NAMED
    text = ", ".join(shown[:_MOST_NAMED])
    return (text + (f" and {more} more" if more > 0 else "")) or "none"


def _numbers(values: FloatArray) -> str:
    return "[" + ", ".join(f"{v:.6g}" for v in values) + "]"
