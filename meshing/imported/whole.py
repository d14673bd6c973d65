"""One sector of a whole whose mesh is the same after each turn by 2π/N: element by element."""

from __future__ import annotations

import heapq
from dataclasses import dataclass, replace

import numpy as np
import scipy

from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.imported.records import ElementBlock, FileMesh, PointMass
from solidwhirl.meshing.imported.split import CORNERS, FACES, KINDS, Tetrahedra
from solidwhirl.meshing.imported.surface import faces_of
from solidwhirl.meshing.imported.turning import (
    BoolArray,
    angles_taken,
    cylinder_text,
    partners,
    turned,
)
from solidwhirl.meshing.records import FloatArray, IntArray

_MOST_CORNERS = 8
# Numbers of sectors that are tried to tell how many a whole has, and how many are named.
_TRIED, _NAMED = 400, 6
_WHAT_TO_DO = "give a mesh of one sector, or leave sectors out"


@dataclass(frozen=True, kw_only=True, eq=False)
class _Orbits:
    """What the turns by 2π/N make of nodes or elements."""

    table: IntArray  #: (m, N) members of every orbit, each the last one turned; on the axis all one
    row: IntArray  #: (n,) orbit of each, -1: none
    turns: IntArray  #: (n,) turns from the first member


def sector_of_whole(
    found: FileMesh,
    tetrahedra: Tetrahedra,
    count: int,
    tolerance: float,
    materials: tuple[str, ...],
) -> FileMesh:
    """Take one connected sector of elements, one of each set that turns into each other.

    `found`, `tetrahedra`: the whole, about z in metres, and its elements cut. `materials`: groups
    of elements that must be the same in all sectors. Groups of faces and nodes are those of all
    sectors, turned onto the one. Raises MeshingError: the mesh is not the same after a turn.
    """
    corners = _corners(found)
    partner = _all_partners(found, tetrahedra, count, tolerance)
    nodes = _orbits(partner, count)
    elements = _orbits(_turned_elements(found, corners, partner, count), count)
    _refuse_around_axis(found, corners, elements, count)
    for name in materials:
        _refuse_uneven(name, _members(found, name), elements, count)
    graph = _beside(found, tetrahedra, len(corners))
    middle = np.nanmean(np.where(corners[:, :, None] < 0, np.nan, found.points[corners]), axis=1)
    kept = _grown(graph, middle, elements)
    return _restricted(found, corners, kept, nodes, count)


def _corners(found: FileMesh) -> IntArray:
    """Corners (e, 8) of all volume elements in the order of the file, -1 where there are fewer."""
    rows = []
    for block in _volume(found):
        own = np.full((len(block.nodes), _MOST_CORNERS), -1, dtype=np.int64)
        count = CORNERS[KINDS[block.kind][0]]
        own[:, :count] = block.nodes[:, :count]
        rows.append(own)
    return np.vstack(rows)


def _volume(found: FileMesh) -> list[ElementBlock]:
    return [block for block in found.blocks if block.kind in KINDS]


def _first_elements(found: FileMesh) -> IntArray:
    """Number of the first element of every block, counted over all that have a volume."""
    counts = [len(b.nodes) if b.kind in KINDS else 0 for b in found.blocks]
    return np.append(0, np.cumsum(counts))


def _all_partners(
    found: FileMesh, tetrahedra: Tetrahedra, count: int, tolerance: float
) -> IntArray:
    """Node that each node of the elements is turned onto; -1: no node of an element."""
    used = np.unique(np.concatenate([b.nodes.ravel() for b in _volume(found)]))
    partner = partners(found.points, used, 2.0 * np.pi / count, tolerance)
    if (partner[used] >= 0).all() and len(np.unique(partner[used])) == len(used):
        return partner
    lost = used[partner[used] < 0]
    tree = scipy.spatial.cKDTree(found.points[used])
    gaps = tree.query(turned(found.points[lost], 2.0 * np.pi / count))[0]
    worst = found.points[lost[gaps.argmax()]]
    raise MeshingError(
        f"sectors = {count}: the file holds the whole (it takes "
        f"{np.degrees(angles_taken(found.points[used])):.4g}° around), but {len(lost)} of "
        f"{len(used)} nodes, turned by {360.0 / count:.6g}°, lie on no other, the worst at "
        f"{cylinder_text(worst)}: {gaps.max():.3g} m from the nearest. "
        f"{_volumes_text(tetrahedra, count)}{_counts_text(found.points[used], tolerance)}; else "
        f"{_WHAT_TO_DO}"
    )


def _volumes_text(tetrahedra: Tetrahedra, count: int) -> str:
    """How much the volumes of the sectors differ, by the middles of the elements."""
    corner = tetrahedra.points[tetrahedra.cells[:, :4]]
    volume = np.abs(np.linalg.det(corner[:, 1:] - corner[:, :1])) / 6.0
    middle = corner.mean(axis=1)
    angle = np.arctan2(middle[:, 1], middle[:, 0]) / (2.0 * np.pi)
    order = np.floor(count * (angle % 1.0)).astype(np.int64) % count
    found = np.bincount(order, weights=volume, minlength=count)
    return f"The {count} sectors have volumes of {found.min():.6g} to {found.max():.6g} m³"


def _counts_text(points: FloatArray, tolerance: float) -> str:
    """Numbers of sectors for which all nodes have partners."""
    nodes, some = np.arange(len(points)), points[:: -(-len(points) // 50)]
    tree = scipy.spatial.cKDTree(points)
    fitting = []
    for n in range(3, _TRIED):
        gap, _ = tree.query(turned(some, 2.0 * np.pi / n), distance_upper_bound=tolerance)
        if (
            np.isfinite(gap).all()
            and (partners(points, nodes, 2.0 * np.pi / n, tolerance) >= 0).all()
        ):
            fitting.append(n)
    if not fitting:
        return ""
    shown = ", ".join(str(n) for n in fitting[-_NAMED:])
    return f"; the mesh is the same after a turn for sectors = {shown}"


def _orbits(partner: IntArray, count: int) -> _Orbits:
    """Orbits of a permutation that is the identity after `count` times, but for -1."""
    own = np.flatnonzero(partner >= 0)
    first = here = own
    for _ in range(count - 1):
        here = partner[here]
        first = np.minimum(first, here)
    if not np.array_equal(partner[here], own):
        raise MeshingError(f"sectors = {count}: nodes do not come back to their places; check axis")
    table = np.empty((len(np.unique(first)), count), dtype=np.int64)
    table[:, 0] = np.unique(first)
    for k in range(1, count):
        table[:, k] = partner[table[:, k - 1]]
    row, turns = np.full((2, len(partner)), -1, dtype=np.int64)
    for k in range(count)[::-1]:
        row[table[:, k]], turns[table[:, k]] = np.arange(len(table)), k
    return _Orbits(table=table, row=row, turns=turns)


def _turned_elements(found: FileMesh, corners: IntArray, partner: IntArray, count: int) -> IntArray:
    """Element that every element is turned onto."""
    images = np.where(corners < 0, -1, partner[corners])
    other = _rows_in(corners, images)
    if (other < 0).any():
        lost = corners[np.flatnonzero(other < 0)[0]]
        raise MeshingError(
            f"sectors = {count}: the nodes of the whole lie on each other when turned by "
            f"{360.0 / count:.6g}°, but {int((other < 0).sum())} of {len(corners)} elements do "
            f"not, the first at {cylinder_text(found.points[lost[lost >= 0]].mean(axis=0))}; "
            f"{_WHAT_TO_DO}"
        )
    return other


def _rows_in(table: IntArray, wanted: IntArray) -> IntArray:
    """Row of the table (t, k) with the same numbers in any order as each of (m, k); -1: none."""
    rows = np.sort(np.vstack([table, wanted]), axis=1)
    stride, label = int(rows.max()) + 2, rows[:, 0] + 1
    for column in rows.T[1:]:
        _, label = np.unique(label * stride + column + 1, return_inverse=True)
    number = np.full(int(label.max()) + 1, -1, dtype=np.int64)
    number[label[: len(table)]] = np.arange(len(table))
    return np.asarray(number[label[len(table) :]])


def _refuse_around_axis(found: FileMesh, corners: IntArray, elements: _Orbits, count: int) -> None:
    """Refuse elements that the axis goes through: they are their own copies."""
    alone = np.flatnonzero((elements.table[:, 1:] == elements.table[:, :1]).any(axis=1))
    if len(alone):
        first = corners[elements.table[alone[0], 0]]
        raise MeshingError(
            f"sectors = {count}: the axis goes through {len(alone)} elements, the first at "
            f"{cylinder_text(found.points[first[first >= 0]].mean(axis=0))}, which can not be cut "
            f"into sectors; give the mesh nodes on the axis, {_WHAT_TO_DO}"
        )


def _members(found: FileMesh, name: str) -> IntArray:
    """Volume elements of a group, counted over all."""
    start = _first_elements(found)
    own = [
        start[k] + np.asarray(rows)
        for k, rows in found.element_groups.get(name, {}).items()
        if found.blocks[k].kind in KINDS
    ]
    return np.concatenate(own) if own else np.empty(0, dtype=np.int64)


def _refuse_uneven(name: str, members: IntArray, elements: _Orbits, count: int) -> None:
    inside = np.zeros(len(elements.row), dtype=bool)
    inside[members] = True
    own = inside[elements.table]
    uneven = own.any(axis=1) & ~own.all(axis=1)
    if uneven.any():
        raise MeshingError(
            f"sectors = {count}: materials: group {name!r} is not the same in all sectors; "
            f"{int(uneven.sum())} of its elements have copies that are not in it; {_WHAT_TO_DO}"
        )


def _beside(found: FileMesh, tetrahedra: Tetrahedra, count: int) -> scipy.sparse.coo_matrix:
    """Graph of elements that share a face, as rows of neighbours."""
    faces = faces_of(tetrahedra.cells)
    number = _first_elements(found)[tetrahedra.block] + tetrahedra.row
    a, b = number[faces.cells[~faces.outside]].T
    return scipy.sparse.coo_matrix(
        (np.ones(2 * len(a)), (np.append(a, b), np.append(b, a))), (count,) * 2
    )


def _grown(graph: scipy.sparse.coo_matrix, middle: FloatArray, elements: _Orbits) -> IntArray:
    """One element of each orbit, each beside one taken before, those nearest to a plane first.

    The plane goes through the outermost element, as a blade has it.
    """
    rows = graph.tocsr()
    angle = np.arctan2(middle[:, 1], middle[:, 0])
    seed = int(np.hypot(middle[:, 0], middle[:, 1]).argmax())
    away = np.abs((angle - angle[seed] + np.pi) % (2.0 * np.pi) - np.pi)
    taken = np.full(len(elements.table), -1, dtype=np.int64)
    waiting = [(0.0, seed)]
    while waiting:
        _, here = heapq.heappop(waiting)
        if taken[elements.row[here]] >= 0:
            continue
        taken[elements.row[here]] = here
        for there in rows.indices[rows.indptr[here] : rows.indptr[here + 1]]:
            if taken[elements.row[there]] < 0:
                heapq.heappush(waiting, (float(away[there]), int(there)))
    lost = int((taken < 0).sum())
    if lost:
        raise MeshingError(
            f"the mesh has parts that share no face: {lost} elements of a sector are not joined to "
            "the others; a body is in one piece, each other part is a body of its own"
        )
    return np.sort(taken)


def _restricted(
    found: FileMesh, corners: IntArray, kept: IntArray, nodes: _Orbits, count: int
) -> FileMesh:
    """What a file holds, on the elements kept; surfaces and groups of nodes by all their copies."""
    chosen = np.zeros(len(corners), dtype=bool)
    chosen[kept] = True
    here = np.zeros(len(found.points), dtype=bool)
    here[corners[kept][corners[kept] >= 0]] = True
    faces = _faces(found, chosen)
    start = _first_elements(found)
    blocks: list[ElementBlock] = []
    origin: list[IntArray] = []
    for k, block in enumerate(found.blocks):
        if block.kind in KINDS:
            rows = np.flatnonzero(chosen[start[k] : start[k + 1]])
            blocks.append(replace(block, nodes=block.nodes[rows]))
        elif (kind := block.kind.rstrip("6789")) in ("triangle", "quad"):
            own = block.nodes[:, : 3 if kind == "triangle" else 4]
            images, rows = _images(own, nodes, here, faces, count)
            blocks.append(ElementBlock(kind=kind, nodes=images))
        else:
            rows = np.empty(0, dtype=np.int64)
            blocks.append(replace(block, nodes=block.nodes[rows]))
        origin.append(rows)
    return replace(
        found,
        blocks=tuple(blocks),
        element_groups={
            name: {k: np.flatnonzero(np.isin(origin[k], own)) for k, own in rows.items()}
            for name, rows in found.element_groups.items()
        },
        node_groups={name: _copies(own, nodes, here) for name, own in found.node_groups.items()},
        face_groups={
            name: tuple(_images(own, nodes, here, faces, count)[0] for own in groups)
            for name, groups in found.face_groups.items()
        },
        masses=_one_of_each(found, nodes, here, count),
    )


def _one_of_each(
    found: FileMesh, nodes: _Orbits, here: BoolArray, count: int
) -> tuple[PointMass, ...]:
    """Point masses of the sector; those on nodes of the whole have to be the same in all."""
    kept = [mass for mass in found.masses if nodes.row[mass.node] < 0]
    on = [mass for mass in found.masses if nodes.row[mass.node] >= 0]
    total = np.zeros(len(found.points))
    for mass in on:
        total[mass.node] += mass.mass
    for row in np.unique([nodes.row[mass.node] for mass in on]).astype(int):
        members = nodes.table[row]
        own = total[members]
        if np.ptp(own) > 1e-6 * np.abs(own).max():
            first = next(mass for mass in on if nodes.row[mass.node] == row)
            raise MeshingError(
                f"sectors = {count}: {first.label} has no copy of the same mass in each of the "
                f"other sectors; {_WHAT_TO_DO}"
            )
        alone = len(np.unique(members)) == 1  # on the axis, where all sectors meet
        first = next(mass for mass in on if mass.node in members)
        at = int(members[here[members]][0])
        kept.append(replace(first, node=at, mass=float(own[0]) / (count if alone else 1)))
    return tuple(kept)


def _faces(found: FileMesh, chosen: BoolArray) -> IntArray:
    """Corners (f, 4) of the faces of chosen elements, -1 in the place of a fourth."""
    start, out = _first_elements(found), []
    for k, block in enumerate(found.blocks):
        if block.kind not in KINDS:
            continue
        own = block.nodes[chosen[start[k] : start[k + 1]]]
        for face in FACES[KINDS[block.kind][0]]:
            fourth = own[:, face[3]] if len(face) == 4 else np.full(len(own), -1)
            out.append(np.column_stack([own[:, face[:3]], fourth]))
    return np.vstack(out)


def _images(
    corners: IntArray, nodes: _Orbits, here: BoolArray, faces: IntArray, count: int
) -> tuple[IntArray, IntArray]:
    """Copies of surface elements (m, 3 or 4) that are faces of the sector, and their originals.

    What has none is given back as it is.
    """
    known = (nodes.row[corners] >= 0).all(axis=1)
    images, rows = [corners[:0]], [np.empty(0, dtype=np.int64)]
    own = np.flatnonzero(known)
    for k in range(count):
        turn = (nodes.turns[corners[own]] + k) % count
        image = nodes.table[nodes.row[corners[own]], turn]
        on = here[image].all(axis=1)
        images.append(image[on])
        rows.append(own[on])
    image, row = np.vstack(images), np.concatenate(rows)
    padded = np.column_stack([image, np.full((len(image), 4 - image.shape[1]), -1)])
    # on the sector's cuts nodes of one element may lie on both sides
    real = _rows_in(faces, padded) >= 0 if len(padded) else np.empty(0, dtype=bool)
    image, row = image[real], row[real]
    lost = np.setdiff1d(np.arange(len(corners)), row)
    return np.vstack([image, corners[lost]]), np.append(row, lost)


def _copies(own: IntArray, nodes: _Orbits, here: BoolArray) -> IntArray:
    """Nodes of the sector that copies of nodes lie on."""
    rows = nodes.row[own]
    found = np.unique(nodes.table[rows[rows >= 0]])
    return np.asarray(found[here[found]])
